"""Which support, or which held coordinate of a joint, an input moves, and whether all supports can move together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.fields.definition import some_of
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.signals import BASE, MotionInput

__all__ = ["Moved", "check_ground", "moved_by", "refused_input"]


class Moved(NamedTuple):
    """What an input moves: a support of the model or a coordinate of its joints, None for the other."""

    support: int | None
    coordinate: int | None


def refused_input(number: int, signal: MotionInput, why: str, instead: str) -> InputError:
    """Return the error that refuses the input of this number."""
    return InputError(Fault(f"inputs[{number}]", repr(signal.label), why, instead))


def check_ground(problem: Problem, supports: SupportState, signal: MotionInput, number: int) -> None:
    """Check that the ground can move with all its supports.

    Raises:
        InputError: a support holds velocities along axes of a section, or a joint stays behind on the ground.
    """
    if supports.set.in_body.any():
        raise refused_input(
            number, signal, "a support holds velocities along axes of the section", "use another support"
        )
    if problem.joints.count and (problem.joints.arrays.nodes < 0).any():
        raise refused_input(
            number,
            signal,
            "a joint or spring connects the model to the ground, which does not move with the supports",
            "attach it to a body, and support that",
        )


def moved_by(
    problem: Problem, supports: SupportState, constraints: Constraints, signal: MotionInput, number: int
) -> Moved:
    """Return what the input of this number moves; its place is a support or a joint.

    Raises:
        InputError: nothing of this name can be moved, or it does not hold the motion.
    """
    names, word = supports.set.names, MOTIONS[signal.component]
    for m, name in enumerate(names):
        if signal.place in name.split(" + "):
            if supports.set.in_body[m]:
                raise refused_input(
                    number,
                    signal,
                    "this support holds velocities along axes of the section",
                    "use another support, or give a force",
                )
            if not supports.set.fixed[m, signal.component]:
                raise refused_input(
                    number,
                    signal,
                    f"this support does not hold {word}",
                    "give a motion that it holds, or a force",
                )
            return Moved(m, None)
    joints = problem.joints
    if signal.place in joints.names:
        mine = np.flatnonzero(
            (joints.joint == joints.names.index(signal.place))
            & constraints.is_held
            & (np.array(joints.words) == word)
        )
        if not len(mine) or np.isin(mine, constraints.ball_motors.coordinates).any():
            raise refused_input(
                number,
                signal,
                f"{word} of this joint is {'a motor about several axes' if len(mine) else 'not held'}",
                "give a motion that the joint holds or drives, or a moment",
            )
        return Moved(None, int(mine[0]))
    places = [place for name in names for place in name.split(" + ")]
    raise refused_input(
        number,
        signal,
        "only supports and joints can be moved, and none has this name",
        f"give one of {some_of([BASE, *places, *joints.names])}, or a force",
    )

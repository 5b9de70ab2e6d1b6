"""Where motions start, and small motions about that."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.analyses.start_state import StartState
from viscorod.analyses.start_velocities import blow_at_start
from viscorod.errors import InputError, warn
from viscorod.mechanics.compilation.compiled import announce_formulation
from viscorod.mechanics.elements import intrinsic_element as intrinsic
from viscorod.mechanics.elements.branch_memory import begin_branches
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.relaxing import Relaxing, vibrating
from viscorod.solve.problem.initial_shape import strain_rods
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.settings.motion import SimulateSettings

__all__ = ["MotionStart", "held_part", "initial_state"]

REACHED = 1e-6
"""Distance over the size of the model, or angle, by which a start may miss what supports and joints prescribe."""

_MOVED_BEFORE = (
    "initial: before the given velocities act, the model came to rest under its loads, away from the reference shape; "
    "initial = 'reference' gives them to the shape that was described, as of a top or a pendulum that is let go"
)


def initial_state(discrete: DiscreteModel, settings: SimulateSettings) -> tuple[State, str]:
    """Return the state that a motion starts from, and what it is in words."""
    state, text, settled = State.reference(discrete.problem), "the reference shape", False
    if settings.start is not None:
        found = StartState(discrete, settings.start)
        state, text = found.state, found.label
        _note(discrete, found.notes)
        _require_reached(discrete, state)
    elif discrete.problem.initial_strain:
        discrete.system.given_strain = strain_rods(discrete.system, state)
        text = "the initial strains"
    elif settings.initial == "equilibrium":
        search = find_initial_equilibrium(discrete, state)
        text = "the equilibrium" if search is None else f"the equilibrium, found by {search.found_by}"
        settled = search is not None and search.settled
    else:
        _require_closed(discrete)
        _require_held(discrete, state)
    given = discrete.problem.initial_twist(state.r, state.q)
    if settings.start is None:
        state.twist[:] = given
        if given.any():
            doubts = [_MOVED_BEFORE] if settled else []
            doubts += blow_at_start(discrete.system, discrete.supports, state)
            _note(discrete, doubts, show=True)
    elif given.any():
        raise InputError(
            "velocities: the motion starts with the velocities of an earlier result; leave the initial velocities out, "
            "or start"
        )
    if settings.formulation == "intrinsic":
        announce_formulation(intrinsic.forces_at)
    if discrete.problem.relaxing and settings.dynamics == "nonlinear":
        announce_formulation(begin_branches)
    return state, text


def _note(discrete: DiscreteModel, doubts: Sequence[str], *, show: bool = False) -> None:
    """Keep doubts about a start for the result, and ``show`` them: once, also if a finer mesh begins anew."""
    told = json.loads(discrete.attributes.get("doubts", "[]"))
    new = [doubt for doubt in doubts if doubt not in told]
    for doubt in new if show else ():
        warn(doubt)
    discrete.attributes["doubts"] = json.dumps([*told, *new])


def _require_reached(discrete: DiscreteModel, state: State) -> None:
    """Refuse a start in which supports or motors are not where their motions begin."""
    constraints = discrete.system.constraints
    constraints.update(0.0)
    apart = _supports_apart(discrete, state)
    value, _, _ = constraints.measure(state)
    for c in np.flatnonzero(constraints.is_held):
        apart[constraints.joints.label(int(c))] = float(
            abs(value[c] - constraints.target[c]) / constraints.joints.unit[c]
        )
    wrong = [name for name, gap in apart.items() if gap > REACHED]
    if wrong:
        raise InputError(
            f"start: {', '.join(wrong[:6])} {'is' if len(wrong) == 1 else 'are'} elsewhere in the earlier result than "
            "this model prescribes at t = 0; let its motions begin at what they are there, or find the equilibrium "
            "from there first (equilibrium with start)"
        )


def _supports_apart(discrete: DiscreteModel, state: State) -> dict[str, float]:
    """Return by how much a start misses what each support prescribes: over the length of the model, or in rad."""
    supports = discrete.supports
    supports.update(0.0)
    gaps = np.abs(supports.set.fixed * (supports.measured(state) - supports.target))
    gaps[supports.set.in_body] = 0.0
    return {
        name: float(max(gap[:3].max() / discrete.problem.length, gap[3:].max()))
        for name, gap in zip(supports.set.names, gaps, strict=True)
    }


def _require_held(discrete: DiscreteModel, state: State) -> None:
    """Refuse to start from a reference shape that supports would tear: their motions begin elsewhere."""
    wrong = [name for name, gap in _supports_apart(discrete, state).items() if gap > REACHED]
    if wrong:
        raise InputError(
            f"initial = 'reference': the motion of {', '.join(wrong[:6])} begins elsewhere than in the reference "
            "shape, and would tear the rods there at t = 0. Let it begin at 0 (an offset, or another phase), start "
            "from the equilibrium (initial = 'equilibrium'), or place the parts where they begin"
        )


def _require_closed(discrete: DiscreteModel) -> None:
    """Refuse to start from a reference shape in which joints are open."""
    constraints = discrete.system.constraints
    constraints.update(0.0)
    gaps = constraints.open_joints(driven=constraints.driven)
    if gaps:
        raise InputError(
            f"initial = 'reference': joints are open in the reference shape: {', '.join(gaps)}. "
            "Start from the equilibrium (initial = 'equilibrium'), which closes them, move the parts so that they "
            "meet, or let motors begin at 0"
        )


class MotionStart:
    """Where a motion starts, and small motions about that, which are computed when they are first asked for.

    Args:
        discrete: model; settings: of the motion; state: that the motion starts from, and that goes on with it.

    Attributes:
        begin: the state at t = 0, which stays.
        small_motions: returns small motions about it.
        vibrations: returns the same, as stiff as the slowest vibration sees them.
        modes: returns the slowest vibrations.
    """

    def __init__(self, discrete: DiscreteModel, settings: SimulateSettings, state: State) -> None:
        self.state, self.begin = state, state.copy()
        static, begin, scale = discrete.static, self.begin, held_part(settings)
        self.small_motions = small = cache(lambda: linearise(static, begin, scale=scale))
        relaxing = cache(lambda: Relaxing.of(static.system, begin, small()))
        self.vibrations = cache(lambda: vibrating(small(), relaxing()))
        self.modes = cache(lambda: StartModes.of(small(), relaxing()))


def held_part(settings: SimulateSettings) -> float:
    """Return which part of the loads just before t = 0 the start is in balance with."""
    return 1.0 if settings.initial == "equilibrium" or settings.start is not None else 0.0

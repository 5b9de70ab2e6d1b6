"""A converged step as its linearisation needs it, and derivatives of a scalar by what it ends and starts with."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.sensitivity.stage_branches import BranchGradient
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.typing import Floats

__all__ = ["LookedBack", "StageRecord", "Weights"]


class StageRecord(NamedTuple):
    """A converged step, before it is accepted.

    Attributes:
        t, h: its start and length [s]; times: of its stages ``(s,)`` [s].
        before: whether loads at its end are limits from the left.
        state: at its start; X, r, q, twist, acceleration: of the nodes at the stages ``(s, n, ...)``.
        strain, strain_rate, section_force: at the Gauss points ``(s, e, points, 6)``; reaction: of the supports.
        multiplier: at the stages ``(s, m)``; near: angles of joints that others are next to.
        dashpot: strains of Maxwell branches at the start ``(n, e, points, 6)``.
    """

    t: float
    h: float
    times: Floats
    before: bool
    state: State
    X: Floats
    r: Floats
    q: Floats
    twist: Floats
    acceleration: Floats
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    reaction: Floats
    multiplier: Floats
    near: Floats
    dashpot: Floats

    @classmethod
    def of(cls, integrator: Collocation, end: float, *, before: bool) -> StageRecord:
        """Copy the stages of the step to ``end`` [s] that an integrator has attempted."""
        stages, links, t = integrator.stages, integrator.stage_constraints, integrator.t
        none = np.zeros((len(stages.X), 0))
        times = t + integrator.tableau.nodes * (end - t)
        times[-1] = end
        return cls(
            t,
            end - t,
            times,
            before,
            integrator.state.copy(),
            stages.X.copy(),
            stages.r.copy(),
            stages.q.copy(),
            stages.twist.copy(),
            stages.acceleration.copy(),
            stages.strain.copy(),
            stages.strain_rate.copy(),
            stages.section_force.copy(),
            stages.reaction.copy(),
            none if links is None else links.arrays.states.multiplier.copy(),
            integrator.system.constraints.near.copy(),
            np.zeros(0) if integrator.dashpots is None else integrator.dashpots.step.start.copy(),
        )

    @property
    def size(self) -> int:
        """Bytes that it takes."""
        return sum(value.nbytes for value in self if isinstance(value, np.ndarray))


class Weights(NamedTuple):
    """Derivatives of a scalar by what a step ends with.

    Attributes:
        pose: by body increments of the poses at the end ``(n, 6)``; twists: by the twists of all stages ``(s, n, 6)``.
        dashpot: by the strains of the dashpots at the end ``(n, e, points, 6)``; None: zero.
    """

    pose: Floats
    twists: Floats
    dashpot: Floats | None = None


class LookedBack(NamedTuple):
    """Derivatives of a scalar by what a step starts with, and by what it depends on.

    Attributes:
        pose, twist: by the start ``(n, 6)``; forces: by the balances ``(s, N, 6)``, rows of supports projected.
        branches: by Maxwell branches, the dashpots at the start among them; None if there are none.
    """

    pose: Floats
    twist: Floats
    forces: Floats
    branches: BranchGradient | None

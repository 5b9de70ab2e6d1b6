"""What the transient analysis asks of a time integrator."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from viscorod.solve.energy_account import StepShare
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot, Snapshots
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators import iteration_verdict
from viscorod.typing import Floats

OUTCOME = {
    iteration_verdict.CONVERGED: Outcome.CONVERGED,
    iteration_verdict.SLOW: Outcome.SLOW,
    iteration_verdict.DIVERGED: Outcome.DIVERGED,
    iteration_verdict.NOT_FINITE: Outcome.NOT_FINITE,
}
"""What the verdicts on iterations are called."""


class StepReport(NamedTuple):
    """The outcome of an attempted step.

    Attributes:
        outcome: CONVERGED or the reason of failure.
        iterations: number of linear solutions.
        change: size of the last increment (displacement over model length, or rotation in rad, whichever is larger).
        residual: largest nodal force imbalance [N] of a failed step (moments divided by the model length).
        node: where the imbalance was, or where the last increment was largest.
        error: estimated error of the step over the tolerated one (0 without an estimate).
        rate: convergence rate of the iteration.
        component: of ``node``, 0 to 5, body axes.
    """

    outcome: Outcome
    iterations: int
    change: float
    residual: float
    node: int
    error: float = 0.0
    rate: float = 0.0
    component: int = 0

    @property
    def motion(self) -> str:
        """The component of the node's motion that ``change`` or ``error`` is about."""
        return ("displacement" if self.component < 3 else "rotation") + f" along d{self.component % 3 + 1}"

    @property
    def converged(self) -> bool:
        """Whether the equations of the step are solved."""
        return self.outcome is Outcome.CONVERGED

    def after(self, iterations: int) -> StepReport:
        """Return this report with the iterations of an earlier attempt added."""
        return self._replace(iterations=self.iterations + iterations)


class Inside(NamedTuple):
    """States at ``k`` parts of a step, and what happened from its start up to there."""

    states: Snapshots
    share: StepShare


class Integrator(Protocol):
    """A method that advances a :class:`~viscorod.solve.formulations.system.System` in time.

    1. ``start(t, state)`` begins at a state, with the velocities of supports just after ``t``; it is called at
       the beginning and after every instant at which a load or a prescribed motion jumps.
    2. ``attempt(end)`` tries one step from ``t`` to ``end`` and leaves ``t`` and ``state`` unchanged.
    3. ``accept()`` takes the last attempt, which converged: ``t`` and ``state`` are those at the end of the step.
       ``work`` is the work of loads and supports during the step, ``loss`` the energy that viscosity dissipated,
       ``kinetic`` and ``elastic`` are the energies at ``t``, all in J.
    4. ``snapshot()`` returns all fields at ``t``; ``between(parts)`` returns them at parts of the last step, with what
       happened up to there.

    ``outside`` is the energy that loads dissipated outside of the model during the step, not a part of ``loss``, and
    ``work`` does not count it as taken from the model; ``actuator`` is the work of what changed rest strains, no part
    of ``work``; ``branch_loss (n,)`` is the energy that each Maxwell branch dissipated, a part of ``loss``.

    ``resume()`` computes what is not saved, after everything that is saved has been restored (see ``saved_state``).

    ``drift`` is the largest error of joints and held strains so far, in positions (over the length of the model, in
    rad, or as a strain) and in velocities (over the largest one); zeros without any.
    ``estimate_order`` is the order of the error estimate, if there is one: the estimate grows as the power
    ``estimate_order + 1`` of the step. ``records`` is the number of states per step that draw the motion smoothly.

    ``begin_half`` precedes both halves of a step that is computed again to see its error, of which their difference
    is the part ``seen_by_halving``.
    """

    t: float
    state: State
    kinetic: float
    elastic: float
    work: float
    loss: float
    outside: float
    actuator: float
    evaluations: int
    factorisations: int
    jacobians: int

    @property
    def estimate_order(self) -> int:
        """Order of the error estimate."""

    @property
    def records(self) -> int:
        """States to record in the last step."""

    @property
    def branch_loss(self) -> Floats:
        """Energy that each Maxwell branch dissipated during the last step ``(n,)`` [J]."""

    @property
    def drift(self) -> tuple[float, float]:
        """Largest error of joints and held strains so far, in positions and in velocities."""

    @property
    def strain(self) -> float:
        """Largest shear or stretch at ``t``."""

    def unbalanced(self) -> Floats:
        """Return what accelerates the nodes at ``t``, where it has just started ``(n, 6)``, body axes."""

    def first_step(self, duration: float) -> float:
        """Return a step [s] to begin with at ``t`` when steps follow the error."""

    @property
    def looks_within(self) -> bool:
        """Whether it sees what loads do within its steps, so that the rows of records are no corners."""

    def watch(self, duration: float) -> None:
        """Look from now on at what loads and motions do within steps, in a run of ``duration`` [s]; once started."""

    def start(self, t: float, state: State) -> None:
        """Begin at time ``t`` [s] from ``state``."""

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """Try one step to the time ``end`` [s]; ``before`` takes loads there as limits from the left."""

    def accept(self) -> None:
        """Take the attempted step."""

    def snapshot(self) -> Snapshot:
        """Return all fields at ``t``."""

    @property
    def section_force(self) -> Floats:
        """Section forces at ``t (m, 6)``, as in snapshots."""

    def between(self, parts: Floats) -> Inside:
        """Return all fields at ``parts (k,)`` (0 to 1) of the last step, and what happened up to there."""

    def resume(self) -> None:
        """Compute what is not saved."""

    @property
    def seen_by_halving(self) -> float:
        """Part of the error of a step by which it differs from two halves."""

    def stability(self, z: np.ndarray) -> np.ndarray:
        """Return the stability function ``R(z) (k,)``: what a step makes of vibrations with eigenvalues ``z / h``."""

    def begin_half(self, whole: Integrator, place: float) -> None:
        """Leave behind what is carried over from steps of another length, and iterate further than in a run.

        Args:
            whole: has taken the step that the next one is a half of; place: in it where this half begins, 0 or 0.5.
        """

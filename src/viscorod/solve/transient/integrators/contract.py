"""What the transient analysis asks of a time integrator."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.statics.newton import Outcome
from viscorod.typing import Floats


class StepReport(NamedTuple):
    """What an attempted step did.

    Attributes:
        outcome: CONVERGED or the reason of failure.
        iterations: number of linear solutions.
        change: size of the last increment (displacement over model length, or rotation in rad, whichever is larger).
        residual: largest nodal force imbalance [N] of a failed step (moments divided by the model length).
        node: where it was, or where the last increment was largest.
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


class Integrator(Protocol):
    """Advances a :class:`~viscorod.solve.formulations.system.System` in time.

    1. ``start(t, state)`` takes over a state, with the velocities of supports just after ``t``; it is called at
       the beginning and after every instant at which a load or a prescribed motion jumps.
    2. ``attempt(end)`` tries one step from ``t`` to ``end``; ``t`` and ``state`` stay.
    3. ``accept()`` takes the last attempt, which converged: ``t`` and ``state`` have moved; ``work`` and ``loss`` are
       what loads and supports put in and what viscosity took during the step [J], ``kinetic`` and ``elastic`` the
       energies [J] at ``t``.
    4. ``snapshot()`` is everything at ``t``, ``between(parts)`` everything at parts of the last step, with the work and
       the loss up to there.

    ``branch_loss (n,)`` is what each Maxwell branch took during the step, part of ``loss``; ``branch_losses(parts)``,
    ``(k, n)``, is the same up to parts of it.

    ``resume()`` is called after everything else was put back as it was saved (see ``saved_state``).

    ``drift`` is how far joints and held strains were from what they hold: the largest gap of positions over the length
    of the model (or in rad, or strain) and of velocities over the fastest one, so far; zeros without any.
    ``estimate_order`` is that of the error estimate, if there is one: it grows as the power ``estimate_order + 1`` of
    the step. ``records`` is the number of states per step that draw the motion smoothly.
    """

    t: float
    state: State
    kinetic: float
    elastic: float
    work: float
    loss: float
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
        """What each Maxwell branch took during the last step ``(n,)`` [J]."""

    @property
    def drift(self) -> tuple[float, float]:
        """Largest gap of positions and of velocities so far."""

    @property
    def strain(self) -> float:
        """Largest shear or stretch at ``t``."""

    def first_step(self, duration: float) -> float:
        """Return a step [s] to begin with at ``t`` when steps follow the error."""

    def start(self, t: float, state: State) -> None:
        """Begin at time ``t`` [s] from ``state``."""

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """Try one step to the time ``end`` [s]; ``before`` takes loads there as limits from the left."""

    def accept(self) -> None:
        """Take the attempted step."""

    def snapshot(self) -> Snapshot:
        """Return everything at ``t``."""

    def between(self, parts: Floats) -> list[tuple[Snapshot, float, float]]:
        """Return everything at ``parts (k,)`` (0 to 1) of the last step, and work and loss [J] from its start."""

    def resume(self) -> None:
        """Make again what is not saved."""

    def branch_losses(self, parts: Floats) -> Floats:
        """Return what each Maxwell branch took ``(k, n)`` [J] from the start of the last step to ``parts (k,)``."""

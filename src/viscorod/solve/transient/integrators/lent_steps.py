"""What a collocation method and the compiled loop of steps hand to each other."""

from __future__ import annotations

from typing import NamedTuple

from viscorod.mechanics.compilation.shared import Shared
from viscorod.solve.formulations.system import State
from viscorod.solve.transient.integrators.record_kernels import Kept, Reading, StepEnd
from viscorod.solve.transient.integrators.step_task import StepTask
from viscorod.typing import Floats

__all__ = ["Course", "Lent", "StepTaken"]


class Lent(NamedTuple):
    """Arrays that both work on.

    Attributes:
        task: one step, whose start is the present state; kept, reading: as for its end.
        start_rate: of the twists at the start of the last step ``(n, 6)``; ad: of the twists ``(n, 6, 6)``.
    """

    task: Shared[StepTask]
    kept: Kept
    reading: Reading
    start_rate: Floats
    ad: Floats


class Course(NamedTuple):
    """How an integration stands: time and step of the factors [s], convergence rate, what there is of a Jacobian.

    ``evaluations``, ``factorisations`` and ``jacobians`` are those since it was lent.
    """

    t: float
    factor_step: float
    rate: float
    have_jacobian: bool
    fresh_jacobian: int
    evaluations: int
    factorisations: int
    jacobians: int


class StepTaken(NamedTuple):
    """The last step that was taken.

    Attributes:
        h: its length [s]; start: state, fields and reactions at its start; end: at its end.
        energies: kinetic, elastic, then work, viscous loss, and what loads dissipate outside, of the step [J].
        strain: largest shear or stretch at its end.
    """

    h: float
    start: tuple[State, Floats, Floats]
    end: StepEnd
    energies: tuple[float, float, float, float, float]
    strain: float

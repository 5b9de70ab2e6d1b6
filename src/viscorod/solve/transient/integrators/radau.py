"""Radau IIA, steps that follow an error estimate."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.collocation_step import largest_turn
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.integrators.tableau import radau
from viscorod.solve.transient.motion_scale import GivenTolerance, Tolerance

LEAST_CHANGE = 1e-13
"""Change of a pose (over the length, or in rad) below which rounding decides."""

TURN_OF_RECORD = 0.25
"""Rotation [rad] from record to record, if that takes more states than one above the stages."""


class Radau(Collocation):
    """Radau IIA: order 2 s - 1 with s stages, L-stable, stiffly accurate, with an error estimate.

    Args:
        system, supports: the model.
        tolerance: wanted accuracy of the motion: displacement over model length, rotation in rad; a number, or one that
            follows the motion.
        stages: their odd number.

    Attributes:
        estimate_order: of the embedded method that steps are compared with: the number of stages.
    """

    step_factor = 2.0
    """Error that a step may have by its estimate, over the tolerance. The estimate is that of a lower order."""

    newton_factor, newton_power = 3e-3, 1.25
    """Error left by the iteration is ``factor tolerance^power``: it changes velocities, which free motion adds up."""

    newton_factor_of_joints = 1.5e-3
    """The same where there are multipliers, which the changes of poses that end an iteration do not show."""

    half_iteration = 0.1
    """Tolerance of the iteration in steps that are computed again, over that of the run."""

    largest_turn = 2.0
    """Rotation [rad] that a node may make in one step: coordinates of rotations are good to half a turn."""

    def __init__(
        self, system: System, supports: SupportState, *, tolerance: float | Tolerance, stages: int = 3
    ) -> None:
        self.tolerance = GivenTolerance(tolerance) if isinstance(tolerance, float) else tolerance
        self.estimate_order = stages
        if system.problem.constrained:
            self.newton_factor = self.newton_factor_of_joints
        super().__init__(system, supports, radau(stages), self._newton_tolerance())
        self._turn = 0.0
        self.turned = KnownTypes(largest_turn)

    def _newton_tolerance(self) -> float:
        return self._newton_at(self.tolerance.value)

    def _newton_at(self, tolerance: float) -> float:
        return max(self.newton_factor * float(tolerance**self.newton_power), LEAST_CHANGE)

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        super().start(t, state)
        self.tolerance.begin(t, self.state, self._force)
        self.newton_tolerance = self._newton_tolerance()

    def accept(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        super().accept()
        self.tolerance.accept(self.t, self.state)
        self.newton_tolerance = self._newton_tolerance()

    def begin_half(self, whole: Integrator, place: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        super().begin_half(whole, place)
        self.newton_tolerance = self.half_tolerance(self.tolerance.value)

    def half_tolerance(self, tolerance: float) -> float:
        """Return what the iteration may leave in a half of a step, under a tolerance."""
        return max(self.half_iteration * self._newton_at(tolerance), LEAST_CHANGE)

    def _judge(self, error: float, unknown: int) -> tuple[float, int]:
        self._turn, node = self.turned.call(self.stages.X[self._last])
        if self.actions.content is not None:
            unseen, where = self.unseen()
            if unseen > error:
                error, unknown = unseen, where
        error /= self.step_factor * self.tolerance.at(self._end, self._reached)
        too_far = (self._turn / self.largest_turn) ** (self.estimate_order + 1)
        return (too_far, 6 * node + 3) if too_far > error else (error, unknown)

    @property
    def records(self) -> int:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        least = self._last + 2
        return min(max(least, int(np.ceil(self._turn / TURN_OF_RECORD))), 4 * least)

"""Radau IIA with three stages, steps that follow an error estimate."""

from __future__ import annotations

import numpy as np

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import System
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.collocation_step import largest_turn
from viscorod.solve.transient.integrators.tableau import RADAU

LEAST_CHANGE = 1e-13
"""Change of a pose (over the length, or in rad) below which rounding decides."""

RECORDS = 4
"""States recorded per step, so that what is drawn between them is smooth."""

TURN_OF_RECORD = 0.25
"""Rotation [rad] from record to record, if that takes more."""


class Radau(Collocation):
    """Radau IIA with three stages: order 5, L-stable, stiffly accurate, with an error estimate.

    Args:
        system, supports: the model.
        tolerance: wanted accuracy of the motion: displacement over model length, rotation in rad.
    """

    step_factor = 2.0
    """Error that a step may have by its estimate, over the tolerance. The estimate is that of a lower order."""

    newton_factor, newton_power = 3e-3, 1.25
    """Error left by the iteration is ``factor tolerance^power``: it changes velocities, which free motion adds up."""

    estimate_order = 3
    """Of the estimate; the method itself is of order 5."""

    largest_turn = 2.0
    """Rotation [rad] that a node may make in one step: coordinates of rotations are good to half a turn."""

    def __init__(self, system: System, supports: SupportState, *, tolerance: float) -> None:
        super().__init__(
            system, supports, RADAU, max(self.newton_factor * tolerance**self.newton_power, LEAST_CHANGE)
        )
        self.step_tolerance = self.step_factor * tolerance
        self._turn = 0.0

    def _judge(self, error: float, unknown: int) -> tuple[float, int]:
        self._turn, node = largest_turn(self.stages.X[self._last])
        error /= self.step_tolerance
        too_far = (self._turn / self.largest_turn) ** (self.estimate_order + 1)
        return (too_far, 6 * node + 3) if too_far > error else (error, unknown)

    @property
    def records(self) -> int:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return min(max(RECORDS, int(np.ceil(self._turn / TURN_OF_RECORD))), 4 * RECORDS)

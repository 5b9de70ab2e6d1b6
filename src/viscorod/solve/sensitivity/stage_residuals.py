"""What the balances of a step become with other numbers of the model, at the same motion: nothing is solved.

The compiled step evaluates them, with no iteration allowed: once for the section forces of this model, and once with
them as the stresses, so that nothing is left of the frozen operators, which are zero.
"""

from __future__ import annotations

import numpy as np

from viscorod.solve.sensitivity.stage_records import StageRecord
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.typing import Floats

__all__ = ["stage_residual"]


def stage_residual(integrator: Collocation, step: StageRecord, scale: Floats) -> Floats:
    """Return the balances ``(s, N, 6)`` of all stages of a step, as an integrator has them, which does nothing else.

    Args:
        integrator: of a model with other numbers; step: of the model itself.
        scale: of its multipliers at the stages ``(s, places)``.
    """
    integrator.iterations = 0
    integrator.t, integrator.state = step.t, step.state
    integrator.system.constraints.near[:] = step.near
    integrator.prepare_step(float(step.times[-1]), step.before)
    stages, links = integrator.stages, integrator.stage_constraints
    stages.X[:], stages.stress[:] = step.X, step.section_force
    if links is not None:
        links.constraints.scale.fill(1.0)
        links.arrays.scale.fill(1.0)
        links.arrays.states.multiplier[:] = step.multiplier
    arguments = integrator.step_arguments(step.h)
    for _ in range(2):
        integrator.trying.call(*arguments)
        stages.stress[:] = stages.section_force
        if links is not None:
            links.arrays.states.carried[:] = links.arrays.states.force
    found = np.array(stages.residual)
    if links is not None:
        found[:, len(step.state.r) :] *= scale.reshape(len(scale), -1, 6)
    return found

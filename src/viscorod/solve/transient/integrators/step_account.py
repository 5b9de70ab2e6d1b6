"""What a converged collocation step amounts to: its estimated error, its powers and energies.

Parts that a model may lack are None, see ``collocation_step``.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import lane_kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.internal_force import energies
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays, add_branch_error, branch_energies
from viscorod.mechanics.elements.rest_strains import actuator_powers
from viscorod.mechanics.nodes.support_rows import in_body, support_directions
from viscorod.solve.linear.substitution import solve
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays, add_motors
from viscorod.solve.transient.integrators.stage_data import StepTask
from viscorod.solve.transient.integrators.stage_kernels import clear
from viscorod.solve.transient.integrators.step_error import (
    estimate_error,
    largest_error,
    project_free,
    scale_free,
)
from viscorod.typing import Floats

__all__ = ["estimate", "take_account"]


@lane_kernel
def estimate(step: StepTask, branches: MaxwellArrays | None) -> tuple[float, int]:
    """Estimate the error of the step by the embedded method; return its size and the unknown where it is largest."""
    if step.stages.X.shape[0] == 1:
        return 0.0, 0
    body, factors, work = step.body, step.factors, step.work
    error, right, supports = step.account.error, work.real, whole_of(body.supports)
    estimate_error(step, error)
    if branches is not None:
        method, matrices, internal = step.method, step.matrices, step.stages.internal
        clear(internal)
        relaxing, operator, mu = whole_of(branches), matrices.operators.strain, method.real / step.h
        strain, weights = step.stages.strain, method.error
        add_branch_error(
            whole_of(body.elements), relaxing, strain, operator, weights, mu, step.h, internal[0]
        )
        project_free(supports, matrices.directions.Z, work.change, internal[0])
        for k in range(error.shape[0]):
            for i in range(6):
                error[k, i] += internal[0, k, i]
    scale_free(supports.nodes, supports.fixed, factors.real_rows, error, right)
    solve(whole_of(factors.real), right)
    return largest_error(factors.scales, right, body.length, error)


@lane_kernel
def take_account(step: StepTask, links: ConstraintArrays | None, branches: MaxwellArrays | None) -> None:
    """Write the powers of loads, supports, motors, viscosity and rest strains, and the elastic energy, at all stages.

    What loads dissipate outside is a loss of its own, not work that they take from the model.
    """
    elements, stages = whole_of(step.body.elements), step.stages
    powers, elastic, dissipated = step.account.powers, step.account.elastic, stages.dissipated
    add_powers(step, powers[0])
    for i in range(elastic.shape[0]):
        powers[2, i] = dissipated[i]
        powers[0, i] += powers[2, i]
    energies(elements, stages.strain, stages.strain_rate, elastic, powers[1])
    actuator_powers(elements, stages.rest_rate, stages.stress, powers[3])
    if branches is not None:
        branch_energies(elements, whole_of(branches), elastic, powers[1])
    if links is not None:
        add_motors(whole_of(links), powers[0])
        energy, power = links.states.energy, links.states.power
        for i in range(elastic.shape[0]):
            elastic[i] += energy[i]
            powers[1, i] += power[i]


@lane_kernel
def add_powers(step: StepTask, power: Floats) -> None:
    """Write the powers ``(s,)`` [W] of loads and of supports at all stages.

    Supports: those of completely held nodes are known; of the others, reactions times rates of displacements. How fast
    their rotations change follows from the twists.
    """
    body, motion, stages = step.body, step.motion, step.stages
    supports, directions, complete = whole_of(body.supports), whole_of(step.work.directions), body.complete
    nodes, fixed, axes, G = supports.nodes, supports.fixed, supports.axes, directions.G
    twist, external, reaction, r, q = stages.twist, stages.external, stages.reaction, stages.r, stages.q
    target, rate, held_power = motion.target, motion.rate, stages.held_power
    for i in range(twist.shape[0]):
        power[i] = held_power[i]
        for k in range(twist.shape[1]):
            for a in range(6):
                power[i] += external[i, k, a] * twist[i, k, a]
        for m in range(nodes.shape[0]):
            if complete[m] == 0.0:
                k = nodes[m]
                support_directions(supports, m, target[i], r[i], q[i], m, directions)
                for a in range(6):
                    speed = rate[i, m, a]
                    if a >= 3 and not in_body(axes[m]):
                        speed = 0.0
                        for b in range(3, 6):
                            speed += G[m, a, b] * twist[i, k, b]
                    power[i] += fixed[m, a] * reaction[i, m, a] * speed

"""What a converged collocation step amounts to: its estimated error, its powers and energies.

Kernels that only some models need, or that others call as well, are called through their addresses (see
``step_task``).
"""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import far, sharing
from viscorod.mechanics.compilation.compiled import kernel, lane_kernel
from viscorod.mechanics.compilation.references import whole_of
from viscorod.mechanics.elements.internal_force import energies
from viscorod.mechanics.elements.rest_strains import actuator_powers
from viscorod.mechanics.nodes.support_rows import in_body, support_directions
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.stage_solution import solve_real
from viscorod.solve.transient.integrators.step_branches import account_branches, end_branches
from viscorod.solve.transient.integrators.step_error import estimate_error, largest_error, scale_free
from viscorod.solve.transient.integrators.step_links import account_links
from viscorod.solve.transient.integrators.step_task import StepTask

__all__ = ["estimate", "support_powers", "take_account"]

_energies = far(energies, NOTHING)
_end_branches, _account_branches = sharing(end_branches, NOTHING), sharing(account_branches, NOTHING)
_account_links = sharing(account_links, NOTHING)


@lane_kernel
def estimate(step: StepTask) -> tuple[float, int]:
    """Estimate the error of the step by the embedded method; return its size and the unknown where it is largest."""
    calls = step.calls
    if calls.end_branches != 0:
        _end_branches(calls.end_branches, (step,))
    if step.stages.X.shape[0] == 1:
        return 0.0, 0
    body, factors, work, internal = step.body, step.factors, step.work, step.stages.internal
    error, right, supports = step.account.error, work.real, body.supports
    estimate_error(step, error)
    if calls.end_branches != 0:
        for k in range(error.shape[0]):
            for i in range(6):
                error[k, i] += internal[0, k, i]
    scale_free(supports.nodes, supports.fixed, factors.real_rows, error, right)
    solve_real(step, right)
    return largest_error(factors.scales, right, body.length, error)


@lane_kernel
def take_account(step: StepTask) -> None:
    """Write the powers of loads, supports, motors, viscosity and rest strains, and the elastic energy, at all stages.

    What loads dissipate outside is a loss of its own, not work that they take from the model.
    """
    elements, stages, calls = step.body.elements, step.stages, step.calls
    powers, elastic, dissipated = step.account.powers, step.account.elastic, stages.dissipated
    load_powers(step)
    if calls.support_powers != 0:
        _support_powers(calls.support_powers, (step,))
    for i in range(elastic.shape[0]):
        powers[2, i] = dissipated[i]
        powers[0, i] += powers[2, i]
    _energies(calls.energies, (elements, stages.strain, stages.strain_rate, elastic, powers[1]))
    actuator_powers(whole_of(elements), stages.rest_rate, stages.stress, powers[3])
    if calls.account_branches != 0:
        _account_branches(calls.account_branches, (step,))
    if calls.account_links != 0:
        _account_links(calls.account_links, (step,))


@lane_kernel
def load_powers(step: StepTask) -> None:
    """Write the powers [W] of loads, and of supports that hold nodes completely, at all stages."""
    stages, powers = step.stages, step.account.powers
    twist, external, held = stages.twist, stages.external, stages.held_power
    for i in range(twist.shape[0]):
        power = held[i]
        for k in range(twist.shape[1]):
            for a in range(6):
                power += external[i, k, a] * twist[i, k, a]
        powers[0, i] = power


@kernel
def support_powers(step: StepTask) -> None:
    """Add the powers [W] of supports that leave motions free: reactions times rates of displacements.

    How fast rotations change follows from the twists.
    """
    body, motion, stages, powers = step.body, step.motion, step.stages, step.account.powers
    supports, directions, complete = whole_of(body.supports), whole_of(step.work.directions), body.complete
    nodes, fixed, axes, G = supports.nodes, supports.fixed, supports.axes, directions.G
    twist, reaction, r, q, target, rate = (
        stages.twist,
        stages.reaction,
        stages.r,
        stages.q,
        motion.target,
        motion.rate,
    )
    for i in range(twist.shape[0]):
        for m in range(nodes.shape[0]):
            if complete[m] == 0.0:
                support_directions(supports, m, target[i], r[i], q[i], m, directions)
                for a in range(6):
                    speed = rate[i, m, a]
                    if a >= 3 and not in_body(axes[m]):
                        speed = 0.0
                        for b in range(3, 6):
                            speed += G[m, a, b] * twist[i, nodes[m], b]
                    powers[0, i] += fixed[m, a] * reaction[i, m, a] * speed


_support_powers = sharing(support_powers, NOTHING)

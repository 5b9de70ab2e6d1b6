"""A steady rotation that was found: its fields, energies and stability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.formulations.system import State
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady.rigid_rotation import spatial_momenta
from viscorod.solve.steady.stability import Stability, stability
from viscorod.solve.steady.steady_equations import SteadyEquations
from viscorod.typing import Floats

ROUND_OFF = 1e-13
"""Part of mass times acceleration below which the reaction of a support is none."""


@dataclass(frozen=True)
class SteadyRotation:
    """A steady rotation and its small motions.

    Attributes:
        state: poses and twists; strain, section_force: at all Gauss points in the order of results ``(m, 6)``.
        reaction: global wrenches of the supports ``(supports, 6)``.
        spin: angular velocity [rad/s]; centre: a point on its axis [m]; momentum: angular momentum about it [N m s];
            global axes. body_spin: the angular velocity in the axes of the node at the joint, or of the first node.
        kinetic, elastic: energies [J]; joints: coordinates of joints and springs, None without.
        gap: largest imbalance, as a part of the forces that balance; iterations: of Newton's method.
    """

    state: State
    strain: Floats
    section_force: Floats
    reaction: Floats
    spin: Floats
    body_spin: Floats
    centre: Floats
    momentum: Floats
    kinetic: float
    elastic: float
    gap: float
    iterations: int
    stability: Stability
    joints: JointState | None = None


def describe_rotation(
    solver: StaticSolver,
    equations: SteadyEquations,
    iterations: int,
    motions: int,
) -> SteadyRotation:
    """Return fields, energies, stability and ``motions`` slow motions of what ``equations`` have converged to."""
    problem, supports, line = solver.system.problem, solver.supports, equations.line
    state, (strain, force) = equations.state(), equations.fields()
    balance, gap = equations.residual()
    joint = int(supports.set.nodes[0]) if len(supports.set.nodes) else 0
    body_spin = state.twist[joint, 3:].copy()
    rate = float(np.linalg.norm(body_spin))
    turn = matrices(state.q[supports.set.nodes])
    reaction = balance[supports.set.nodes].reshape(-1, 2, 3)
    reaction = np.einsum("nij,npj->npi", turn, reaction).reshape(-1, 6)
    whole = float(problem.mass[:, 0, 0].sum()) * problem.length * rate**2
    reaction[np.abs(reaction) < ROUND_OFF * whole * np.array([1.0] * 3 + [problem.length] * 3)] = 0.0
    _, momentum = spatial_momenta(problem.mass, state.r, state.q, state.twist, line.centre)
    places = solver.system.gauss_indices()
    return SteadyRotation(
        state=state.copy(),
        strain=strain.reshape(-1, 6)[places],
        section_force=force.reshape(-1, 6)[places],
        reaction=reaction,
        spin=rate * line.direction,
        body_spin=body_spin,
        centre=line.centre,
        momentum=momentum,
        kinetic=kinetic_energy(problem.mass, state.twist),
        elastic=equations.elastic_energy(),
        gap=gap,
        iterations=iterations,
        stability=stability(equations.small_motions(), rate, motions),
        joints=solver.system.constraints.state() if problem.joints.count else None,
    )

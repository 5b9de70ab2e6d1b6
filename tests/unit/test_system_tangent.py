"""The assembled system: residual and tangent with inertia, every kind of load and every kind of support (case E4)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.discrete_model import DiscreteModel
from helpers.finite_differences import slope_of
from viscorod.mechanics.nodes import support_rows as kernels
from viscorod.solve.linear.matrix import Matrix


def loaded_frame():
    """Two attached rods of different order, full matrices, off-centre mass, a law, all kinds of loads and supports."""
    stiffness = np.diag([80.0, 70.0, 200.0, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 3.0
    inertia = np.diag([1.0, 1.0, 1.0, 1e-1, 2e-1, 3e-1])
    inertia[0, 5] = inertia[5, 0] = -0.2
    inertia[1, 5] = inertia[5, 1] = 0.1
    section = vr.StiffnessSection(stiffness, inertia, 0.05 * stiffness)
    model = vr.Model()
    model.add(
        "a", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.0, section=section, elements=2, order=2)
    )
    corner = np.array([np.sin(1.0), 1 - np.cos(1.0), 0.0])
    model.add(
        "b",
        vr.Rod.straight(
            corner,
            np.add(corner, (0, 1, 0.5)),
            section=section,
            elements=2,
            order=3,
            d1=(1, 0, 0.2),
            law=vr.CubicBending(2.0, 0.03),
        ),
    )
    model.attach("a.end", "b.start")
    model.support("a.start", ("ux", "uy", "uz", "ry"), motion={"rz": vr.Sine(0.5, amplitude=0.4)})
    model.support("b.end", ("rx",), axes=((1, 2, 0), (-2, 1, 1)), motion={"uy": vr.Sine(0.3, amplitude=0.1)})
    model.gravity((1.0, 2.0, -9.0))
    model.force("b.start", (1.0, 2.0, 3.0), following=True)
    model.moment("b.start", (0.3, 0.2, 0.1))
    model.moment("b.end", (0.3, 0.2, 0.1), following=True)
    model.distributed_force("a", (1.0, 0.5, 0.2), following=True)
    model.distributed_moment("b", (0.1, 0.2, 0.3))
    model.moving_force("b", (0.4, -0.3, 0.2), speed=1.0)
    model.force("a@0.33", (0.2, 0.1, -0.4))
    wind = {"density": 1.5, "width": 0.8, "velocity": (1.0, -2.0, 0.7)}
    model.drag("a", coefficient_across=1.2, coefficient_along=0.3, linear_about=0.4, to_s=0.8, **wind)
    model.drag("b", linear_across=2.0, linear_along=0.7, coefficient_along=0.5, **wind)
    return model


def test_residual_and_tangent_with_inertia_and_all_loads():
    """The derivative along increments of the pose; the map from increments to body changes is T^-1."""
    work = DiscreteModel(loaded_frame())
    work.residual(work.increment)
    work.system.reset_stress()
    work.residual(work.increment, tangent=True)
    K = work.system.matrix.sparse().toarray()
    reference = slope_of(lambda x: work.residual(work.moved(x))[1].ravel(), 6 * work.n, h=2e-4)
    assert K == pytest.approx(reference, abs=3e-7 * np.abs(reference).max())


def test_damping_matrix_comes_with_the_tangent():
    """It is what the rate map multiplies: the difference of the tangents for T + I and T."""
    work = DiscreteModel(loaded_frame())
    new, _ = work.residual(work.increment)
    system, rate_map = work.system, work.integrator._map
    apart = Matrix(work.problem.pattern)
    tangents = []
    for maps in (rate_map, rate_map + np.eye(6)):
        system.assemble(new, work.loads, maps, tangent=True, moving=True, rate_matrix=apart)
        tangents.append(system.matrix.sparse().toarray())
    difference = tangents[1] - tangents[0]
    assert apart.sparse().toarray() == pytest.approx(difference, abs=1e-12 * np.abs(tangents[0]).max())
    system.assemble(new, work.loads, rate_map, tangent=True, moving=True)
    assert np.array_equal(system.matrix.sparse().toarray(), tangents[0])


def test_supports_replace_rows_consistently():
    """Free rows are the derivative of Z^T (residual - G^T reaction), Z and reaction frozen; fixed rows are G."""
    work = DiscreteModel(loaded_frame())
    work.residual(work.increment)
    work.system.reset_stress()
    new, residual = work.residual(work.increment, tangent=True)
    held = residual.copy()
    work.supports.impose(new, held, work.system.matrix, tangent=True)
    K = work.system.matrix.sparse().toarray()
    s = work.supports
    reaction = s.reaction.copy()

    def directions(state, k):
        found = kernels.Directions.of(1)
        kernels.support_directions(s.nodes, k, s.target, state.r, state.q, 0, found)
        return found.value[0], found.G[0], found.Z[0]

    frozen = [directions(new, k)[2] for k in range(len(s.set.nodes))]
    for k, Z in enumerate(frozen):
        assert directions(new, k)[1] @ Z == pytest.approx(np.eye(6), abs=1e-12)

    def rows(x):
        state, balance = work.residual(work.moved(x))
        for k, node in enumerate(s.set.nodes):
            value, G, _ = directions(state, k)
            fixed = s.set.fixed[k] > 0
            projected = frozen[k].T @ (balance[node] - G.T @ reaction[k])
            balance[node] = np.where(fixed, value - s.target[k], projected)
        return balance.ravel()

    reference = slope_of(rows, 6 * work.n, h=2e-4)
    # rows of fixed components carry a weight
    weights = np.ones((work.n, 6))
    for k, node in enumerate(s.set.nodes):
        G = directions(new, k)[1]
        for i in np.flatnonzero(s.set.fixed[k]):
            row = 6 * node + i
            weights[node, i] = np.linalg.norm(K[row]) / np.linalg.norm(G[i])
            reference[row] *= weights[node, i]
    assert weights.ravel() * rows(np.zeros(6 * work.n)) == pytest.approx(held.ravel(), abs=1e-8)
    assert K == pytest.approx(reference, abs=3e-7 * np.abs(reference).max())


def test_work_of_all_forces_matches_the_change_of_energy():
    """d(elastic)/dt + dissipation = internal power, and the power of gravity is that of the moving centres of mass."""
    work = DiscreteModel(loaded_frame())
    new, _ = work.residual(work.increment)
    power = np.sum(work.system.internal * new.twist)
    points = work.system.gauss_points()
    lengths = work.system.gauss_positions().length
    stored = np.einsum("gi,gi,g->", points.section_force, points.strain_rate, lengths)
    assert power == pytest.approx(stored, rel=1e-12)


def test_coefficients_of_the_method():
    """Trapezoidal rule for a spectral radius of 1; second-order condition of Jansen et al. (2000) for all."""
    from viscorod.solve.transient.integrators.momentum_model import Coefficients

    c = Coefficients.of(1.0)
    assert (c.mass, c.force, c.gamma) == (0.5, 0.5, 0.5)
    for rho in (0.0, 0.3, 0.8, 1.0):
        c = Coefficients.of(rho)
        assert c.gamma == pytest.approx(0.5 + c.force - c.mass)  # second order

"""Kernels of the collocation integrators against the assembled system, finite differences and dense algebra."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.finite_differences import slope_of
from helpers.kernel_parts import from_python
from helpers.small_frame import Moved, adjoint, closed, dense, frame, law_response
from viscorod.mechanics.elements.internal_force import (
    ElementWork,
    GaussStates,
    conserve_energy,
    energies,
    internal_forces,
)
from viscorod.mechanics.elements.linearised import Operators, add_frozen_forces, carry_stress
from viscorod.mechanics.elements.section_laws import add_lacking_work
from viscorod.mechanics.nodes import inertia
from viscorod.mechanics.nodes import support_rows as support_kernels
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.plan import Plan
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.transient.integrators import jacobian

LAW = vr.CubicBending(2.0, 0.03)
FRAMES = {
    "orders 2 and 3": lambda: Moved(frame()),
    "orders 1 and 4": lambda: Moved(frame((1, 4))),
    "high orders": lambda: Moved(frame((5, 5))),
    "undamped": lambda: Moved(frame(damping=0.0)),
    "no offset": lambda: Moved(frame((3, 2)), offset=0.0),
    "closed": lambda: Moved(closed()),
    "law": lambda: Moved(frame(law=LAW)),
    "law, undamped": lambda: Moved(frame((3, 3), damping=0.0, law=LAW)),
}


def forces(at, r, q, twist, stress=None):
    """Internal forces ``(n, 6)`` and the Gauss points ``(e, points, 6)``; with ``stress`` of that iterate."""
    points = GaussStates.of(at.elements, 1)
    if stress is not None:
        points = points._replace(stress=stress[None].copy())
    work = ElementWork.of(at.elements.nodes.shape[1] - 1)
    out = np.full((1, at.n, 6), np.nan)
    internal_forces(at.elements, r[None], q[None], twist[None], points, work, out)
    return out[0], GaussStates(*(field[0] for field in points))


@pytest.mark.parametrize("name", FRAMES)
def test_internal_forces_are_those_of_the_assembly(name):
    """Independent formulation: ``GeometricSystem.assemble``, forces, Gauss points and energies."""
    at = FRAMES[name]()
    out, points = forces(at, at.state.r, at.state.q, at.state.twist)
    loads = ExternalLoads(at.problem).at(0.0)
    at.system.assemble(at.state, loads, None, tangent=False, moving=True)
    at.system.reset_stress()  # forces are those of the stress iterate
    at.system.assemble(at.state, loads, None, tangent=False, moving=True)
    assert out == pytest.approx(at.system.internal, abs=1e-12 * np.abs(out).max())
    expected, places = at.system.gauss_points(), at.system.gauss_indices()
    damped = at.elements.damped  # the assembly knows no strain rates without damping
    for field in ("strain", "section_force", *(("strain_rate",) if damped else ())):
        found = getattr(points, field).reshape(-1, 6)[places]
        value = getattr(expected, field)
        assert found == pytest.approx(value, abs=1e-12 * np.abs(value).max())
    elastic, power = np.full((2, 1), np.nan)
    energies(at.elements, points.strain[None], points.strain_rate[None], elastic, power)
    assert elastic[0] == pytest.approx(at.system.elastic_energy(), rel=1e-12)
    rate, length = expected.strain_rate, at.system.gauss_positions().length
    loss = np.einsum("g,gi,gij,gj->", length, rate, at.system.gauss_positions().damping, rate)
    if at.elements.laws.present:
        _, _, lost = law_response(at, points.strain, points.strain_rate, LAW)
        own = length @ lost.ravel()[places]
        assert own > 0.01 * (loss or own)
        loss += own
    assert power[0] == pytest.approx(loss, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("name", FRAMES)
def test_strain_rates(name):
    """Finite differences in time of the strains along the body twists."""
    at = FRAMES[name]()
    _, points = forces(at, at.state.r, at.state.q, at.state.twist)
    h = 1e-3
    eps = {k: forces(at, *at.moved(k * h * at.state.twist), at.state.twist)[1].strain for k in (-2, -1, 1, 2)}
    slope = (8 * (eps[1] - eps[-1]) - (eps[2] - eps[-2])) / (12 * h)
    assert points.strain_rate == pytest.approx(slope, abs=1e-8 * np.abs(slope).max())


def test_forces_of_a_stress_iterate_are_linear_in_it():
    """Structure: the force is B^T sigma whatever the strain; with sigma = S it is the plain one."""
    at = Moved(frame())
    out, points = forces(at, at.state.r, at.state.q, at.state.twist)
    S = points.section_force
    sigma = np.random.default_rng(2).normal(size=S.shape)
    mixed = [forces(at, at.state.r, at.state.q, at.state.twist, stress=s)[0] for s in (S, S + sigma, sigma)]
    assert mixed[0] == pytest.approx(out, abs=1e-13 * np.abs(out).max())
    assert mixed[0] + mixed[2] == pytest.approx(mixed[1], abs=1e-12 * np.abs(out).max())


@pytest.mark.parametrize("law", [None, LAW])
def test_conserved_energy(law):
    """Conservation law: the corrected section forces of the middle work exactly the change of elastic energy."""
    at = Moved(frame(law=law))
    h = 0.02
    X = h * at.state.twist
    start = forces(at, at.state.r, at.state.q, at.state.twist)[1].strain
    end = forces(at, *at.moved(X), at.state.twist)[1].strain
    _, middle = forces(at, *at.moved(0.5 * X), at.state.twist)
    elements = at.elements
    stiff = elements.stiffness[elements.section]
    damping = elements.damping[elements.section]
    rate = middle.strain_rate
    before, S = middle.section_force.copy(), middle.section_force
    given = (field[None] for field in (middle.strain, rate, start, end))
    defect = np.zeros(S.shape[:2])
    if law is not None:
        points = middle.strain[None], rate[None]
        from_python(add_lacking_work)(
            elements.laws, elements.order, elements.section, points, start[None], end[None], h, defect
        )
    from_python(conserve_energy)(elements, *given, h, defect, S[None])
    energy = 0.5 * (
        np.einsum("egi,egij,egj->eg", end, stiff, end) - np.einsum("egi,egij,egj->eg", start, stiff, start)
    )
    viscous = h * np.einsum("egi,egij,egj->eg", rate, damping, rate)
    if law is not None:
        energy += law_response(at, end, rate, law)[1] - law_response(at, start, rate, law)[1]
        viscous += h * law_response(at, middle.strain, rate, law)[2]
    work = h * np.einsum("egi,egi->eg", S, rate) - viscous
    used = np.arange(start.shape[1])[None, :] < elements.order[:, None]
    assert work[used] == pytest.approx(energy[used], abs=1e-13 * np.abs(energy).max())
    change = np.abs(S - before).max() / np.abs(before).max()
    assert 0.0 < change < 0.01  # of second order in the step


def jacobian_of(at):
    """Blocks, operators and section forces of the system's ``linearise`` at the state."""
    state = at.state
    K, C = np.zeros((2, len(at.problem.pattern.rows), 6, 6))
    turning = np.array([adjoint(x) for x in state.twist])
    operators = Operators.of(at.elements)
    S = forces(at, state.r, state.q, state.twist)[1].section_force
    at.system.linearise(state, turning, S, operators, K, C)
    return K, C, operators, S, turning


@pytest.mark.parametrize("name", FRAMES)
def test_linearised_elements(name):
    """Finite differences of the internal forces: along poses with turning twists (K), and along twists (C)."""
    at = FRAMES[name]()
    K, C, _, _, turning = jacobian_of(at)
    state, pattern, n = at.state, at.problem.pattern, at.n

    def along_poses(x):
        d = x.reshape(n, 6)
        return forces(at, *at.moved(d), state.twist + np.einsum("nij,nj->ni", turning, d))[0].ravel()

    def along_twists(x):
        return forces(at, state.r, state.q, state.twist + x.reshape(n, 6))[0].ravel()

    reference = slope_of(along_poses, 6 * n)
    assert dense(pattern, K) == pytest.approx(reference, abs=3e-8 * np.abs(reference).max())
    reference = slope_of(along_twists, 6 * n)
    assert dense(pattern, C) == pytest.approx(reference, abs=1e-9 * max(np.abs(reference).max(), 1.0))


def test_carried_stress_and_frozen_forces():
    """Finite differences of the section forces; and B^T (S - sigma) against the forces of iterates at the state."""
    at = Moved(frame())
    _, _, operators, S, turning = jacobian_of(at)
    state, n = at.state, at.n
    rng = np.random.default_rng(3)
    d, rate = rng.normal(size=(2, n, 6))

    def section_forces(step):
        twist = state.twist + step[0] * (rate + np.einsum("nij,nj->ni", turning, d))
        return forces(at, *at.moved(step[0] * d), twist)[1].section_force.ravel()

    slope = slope_of(section_forces, 1, h=1e-4).reshape(S.shape)
    sigma = np.empty_like(S)
    from_python(carry_stress)(
        at.elements, operators.force, operators.viscous, d[None], rate[None], S[None], sigma[None]
    )
    used = (np.arange(S.shape[1])[None, :] < at.elements.order[:, None])[..., None]
    assert (sigma - S) * used == pytest.approx(slope * used, abs=1e-7 * np.abs(slope).max())
    stress = S + rng.normal(size=S.shape)
    total = forces(at, state.r, state.q, state.twist, stress=stress)[0]
    from_python(add_frozen_forces)(at.elements, operators.strain, S[None], stress[None], total[None])
    plain = forces(at, state.r, state.q, state.twist)[0]
    assert total == pytest.approx(plain, abs=1e-12 * np.abs(plain).max())


def test_inertia_of_the_jacobian():
    """Finite differences of the gyroscopic forces L1(x) M x, and the bracket of se(3)."""
    at = Moved(frame())
    n, twist, mass = at.n, at.state.twist, at.problem.mass
    turning = np.empty((n, 6, 6))
    jacobian.adjoint(twist, turning)
    assert turning == pytest.approx(np.array([adjoint(x) for x in twist]), abs=0)
    pattern = at.problem.pattern
    K, C = np.zeros((2, len(pattern.rows), 6, 6))
    mass_turning = np.empty((n, 6, 6))
    jacobian.add_inertia(mass, twist, turning, K, C, pattern.diagonal, mass_turning, np.empty((6, 6)))

    def gyroscopic(x):
        out = np.zeros((n, 6))
        inertia.add_coriolis(mass, twist + x.reshape(n, 6), out)
        return out.ravel()

    N = slope_of(gyroscopic, 6 * n)
    ad, M = np.zeros((2, 6 * n, 6 * n))
    for k in range(n):
        block = slice(6 * k, 6 * k + 6)
        ad[block, block], M[block, block] = turning[k], mass[k]
        assert mass_turning[k] == pytest.approx(mass[k] @ turning[k], abs=1e-14)
    assert dense(pattern, C) == pytest.approx(N + M @ ad, abs=1e-9)
    assert dense(pattern, K) == pytest.approx(N @ ad, abs=1e-8)
    # L1(x) M x itself is -ad(x)^T M x
    expected = np.array([-adjoint(x).T @ m @ x for x, m in zip(twist, mass, strict=True)])
    assert gyroscopic(np.zeros(6 * n)).reshape(n, 6) == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("mu", [30.0, 20.0 + 25.0j])
def test_supported_systems_are_solved(mu):
    """Independent code: numpy.linalg.solve on the dense matrix with supported rows projected or replaced."""
    model = frame()
    model.support("a.start", ("ux", "uy", "uz", "ry"), motion={"rz": vr.Sine(0.5, amplitude=0.4)})
    model.support("b@0.6", ("rx",), axes=((1, 2, 0), (-2, 1, 1)), motion={"uy": vr.Sine(0.3, amplitude=0.1)})
    model.clamp("b.end")
    at = Moved(model)
    rng = np.random.default_rng(8)
    s, n, pattern = at.supports, at.n, at.problem.pattern
    s.update(0.3)
    K, C, _, _, turning = jacobian_of(at)
    mass = at.problem.mass.copy()
    product, scratch = np.empty((n, 6, 6)), np.empty((6, 6))
    jacobian.add_inertia(mass, at.state.twist, turning, K, C, pattern.diagonal, product, scratch)
    whole_K, whole_C = dense(pattern, K), dense(pattern, C)
    m = len(s.set.nodes)
    found = support_kernels.Directions.of(m)
    poses = at.state.r, at.state.q
    jacobian.project(s.nodes, s.target, np.zeros((m, 6)), *poses, pattern, K, C, mass, found, scratch[0])

    A = (mu * whole_C + whole_K).astype(complex)
    for k in range(n):
        A[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] += mu * mu * at.problem.mass[k]
    own = support_kernels.Directions.of(1)
    for k, node in enumerate(s.set.nodes):
        support_kernels.support_directions(s.nodes, k, s.target, *poses, 0, own)
        directions, dual = own.G[0], own.Z[0]
        rows = slice(6 * node, 6 * node + 6)
        fixed = s.set.fixed[k] > 0
        projected = dual.T @ A[rows]
        constraint = np.zeros_like(projected)
        constraint[:, rows] = np.eye(6) if fixed.all() else directions
        A[rows] = np.where(fixed[:, None], constraint, projected)
    kind = type(mu)
    b = rng.normal(size=6 * n).astype(kind)
    scales = np.tile([0.25, 0.25, 0.25, 1.0, 1.0, 1.0], n)
    row_scales, out = np.empty(6 * n), np.zeros(K.shape, dtype=kind)
    jacobian.combine(K, C, mass, mu, s.nodes, found, pattern, scales, row_scales, out)
    x = row_scales * b
    solver = DirectSolver(Plan.of(pattern), kind)
    solver.factorise(out)
    solver.solve(x)
    expected = np.linalg.solve(A, b)
    assert scales * x == pytest.approx(
        expected if kind is complex else expected.real, abs=1e-10 * np.abs(expected).max()
    )

"""Kernels of the intrinsic element: power identities, the geometric element, finite differences, closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import viscorod as vr
from helpers.finite_differences import slope_of
from helpers.kernel_parts import from_python
from helpers.small_frame import Moved, adjoint, closed, dense, frame, law_response
from viscorod.mechanics.elements.internal_force import ElementWork, GaussStates, internal_forces
from viscorod.mechanics.elements.intrinsic_element import StrainMotion, advance_strains, forces_at
from viscorod.mechanics.elements.intrinsic_linearised import linearise_intrinsic
from viscorod.mechanics.elements.linearised import Operators
from viscorod.solve.transient.integrators.tableau import MIDPOINT, radau

LAW = vr.CubicBending(2.0, 0.03)
FRAMES = {
    "orders 2 and 3": lambda: Moved(frame()),
    "orders 1 and 4": lambda: Moved(frame((1, 4))),
    "high orders": lambda: Moved(frame((5, 5))),
    "undamped": lambda: Moved(frame(damping=0.0)),
    "no offset": lambda: Moved(frame((3, 2)), offset=0.0),
    "closed": lambda: Moved(closed()),
    "law": lambda: Moved(frame(law=LAW)),
}
KINDS = [
    (name, linearised)
    for name in FRAMES
    for linearised in (False, True)
    if not (name == "law" and linearised)
]


def some_strain(elements, seed=1):
    return 0.1 * np.random.default_rng(seed).normal(size=elements.reference.shape)


def evaluate(at, strain, twist, linearised):
    """Internal forces ``(n, 6)``, section forces, what damping acts on, and twists, each ``(e, points, 6)``."""
    rate = np.zeros((1, *strain.shape))
    motion = StrainMotion.of(at.elements, 1, linearised=linearised)
    S, force = np.zeros_like(rate), np.full((1, at.n, 6), np.nan)
    forces_at(
        at.elements, motion, twist[None].copy(), strain[None].copy(), rate, np.zeros_like(strain), S, force
    )
    return force[0], S[0], rate[0], motion.twist[0]


def quadrature(elements):
    """Weights (e, points) [m], zero beyond an element's order."""
    return np.array(
        [elements.weights[p] * h for p, h in zip(elements.order, elements.half_lengths, strict=True)]
    )


@pytest.mark.parametrize(("name", "linearised"), KINDS)
def test_power(name, linearised):
    """Conservation law (AWP 19, 32): nodal forces work the rate of elastic energy and the dissipated power, exactly."""
    at = FRAMES[name]()
    e, strain, twist = at.elements, some_strain(at.elements), at.state.twist
    force, _, viscous, _ = evaluate(at, strain, twist, linearised)
    rate = evaluate(at, strain, twist, False)[2]
    C, D, w = e.stiffness[e.section], e.damping[e.section], quadrature(e)
    stored = np.einsum("eg,egi,egij,egj->", w, rate, C, strain)
    lost = np.einsum("eg,egi,egij,egj->", w, viscous, D, viscous)
    if e.laws.present:
        own, _, power = law_response(at, strain, rate, LAW)
        lost += np.vdot(w, power)
        stored += np.einsum("eg,egi,egi->", w, own, rate) - np.vdot(w, power)
    assert np.vdot(force, twist) == pytest.approx(stored + lost, rel=1e-12)
    assert (lost > 0.0) == e.damped
    if linearised:
        assert viscous != pytest.approx(rate, abs=1e-3)


def test_straight_unstrained_rods_are_those_of_the_geometric_element():
    """Independent formulation: both elements have the same strain rates and forces there."""
    at = FRAMES["no offset"]()
    e, twist = at.elements, at.state.twist
    points, expected = GaussStates.of(e, 1), np.zeros((1, at.n, 6))
    pose = at.problem.positions[None], at.problem.quaternions[None]
    internal_forces(e, *pose, twist[None], points, ElementWork.of(e.nodes.shape[1] - 1), expected)
    force, S, rate, _ = evaluate(at, np.zeros_like(e.reference), twist, False)
    assert rate == pytest.approx(points.strain_rate[0], abs=1e-12 * np.abs(rate).max())
    assert S == pytest.approx(points.section_force[0], abs=1e-12 * np.abs(S).max())
    assert force == pytest.approx(expected[0], abs=1e-11 * np.abs(force).max())


def matrices(at, strain, linearised):
    pattern = at.problem.pattern
    K, C = np.zeros((2, len(pattern.rows), 6, 6))
    turning = np.array([adjoint(x) for x in at.state.twist])
    operators = Operators.of(at.elements)
    _, S, viscous, twist = evaluate(at, strain, at.state.twist, linearised)
    linearise_intrinsic(at.elements, linearised, strain, twist, viscous, turning, S, operators, K, C)
    return dense(pattern, K), dense(pattern, C), operators, turning


def nodal_strain(elements, B, d):
    """``B d (e, points, 6)`` for nodal increments ``d (n, 6)``."""
    e, g, _ = elements.reference.shape
    return np.einsum("eab,eb->ea", B, d[elements.nodes].reshape(e, -1)).reshape(e, g, 6)


@pytest.mark.parametrize(("name", "linearised"), KINDS)
def test_linearised_elements(name, linearised):
    """The strain operator is that of the rates; K and C against finite differences along it."""
    at = FRAMES[name]()
    strain, twist, n = some_strain(at.elements), at.state.twist, at.n
    K, C, operators, turning = matrices(at, strain, linearised)
    rate = evaluate(at, strain, twist, False)[2]
    assert nodal_strain(at.elements, operators.strain, twist) == pytest.approx(
        rate, abs=1e-12 * np.abs(rate).max()
    )

    def moved(x):
        d = x.reshape(n, 6)
        return strain + nodal_strain(at.elements, operators.strain, d), twist + np.einsum(
            "nij,nj->ni", turning, d
        )

    reference = slope_of(lambda x: evaluate(at, *moved(x), linearised)[0].ravel(), 6 * n)
    assert K == pytest.approx(reference, abs=3e-8 * np.abs(reference).max())
    reference = slope_of(
        lambda x: evaluate(at, strain, twist + x.reshape(n, 6), linearised)[0].ravel(), 6 * n
    )
    assert C == pytest.approx(reference, abs=1e-9 * max(np.abs(reference).max(), 1.0))
    # section forces follow A d + P d'
    d, d_rate = np.random.default_rng(3).normal(size=(2, n, 6))

    def section_forces(x):
        eps, turned = moved(x[0] * d.ravel())
        return evaluate(at, eps, turned + x[0] * d_rate, linearised)[1].ravel()

    slope = slope_of(section_forces, 1, h=1e-4).reshape(strain.shape)
    used = (np.arange(strain.shape[1])[None, :] < at.elements.order[:, None])[..., None]
    carried = nodal_strain(at.elements, operators.force, d) + nodal_strain(
        at.elements, operators.viscous, d_rate
    )
    assert carried * used == pytest.approx(slope * used, abs=1e-7 * np.abs(slope).max())


@pytest.mark.parametrize(("tableau", "order"), [(radau(3), 5), (MIDPOINT, 2)])
def test_strains_over_a_step(tableau, order):
    """Closed form: constant twists turn strains as ``exp(L h)`` does; the error of a step falls as order + 1."""
    at = Moved(frame((5, 5)))
    e = at.elements
    rng = np.random.default_rng(4)
    x, b = rng.normal(size=(2, *e.reference.shape))
    start = some_strain(e)
    errors = []
    for h in (0.2, 0.1):
        s = len(tableau.nodes)
        at_stages, linear = np.repeat(x[None], s, axis=0), np.repeat(b[None], s, axis=0)
        strain = np.zeros_like(at_stages)
        scratch = np.zeros((3 * s, 3 * s)), np.zeros(3 * s)
        from_python(advance_strains)(e, tableau.derivative, h, start, at_stages, linear, *scratch, strain)
        end = 2 * strain[0] - start if s == 1 else strain[-1]
        worst = 0.0
        for k in range(len(e.order)):
            for g in range(e.order[k]):
                whole = np.zeros((7, 7))
                whole[:6, :6], whole[:6, 6] = -adjoint(x[k, g]), b[k, g]
                exact = (expm(h * whole) @ np.append(start[k, g], 1.0))[:6]
                worst = max(worst, np.abs(end[k, g] - exact).max())
        errors.append(worst)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order + 1, abs=0.25)

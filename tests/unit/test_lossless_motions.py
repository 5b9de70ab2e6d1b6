"""Small motions that nothing damps: their frequencies, the proof that none is missing, and when there is no proof."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.steady import stability as both
from viscorod.solve.steady.lossless_motions import LosslessMotions
from viscorod.solve.steady.rotation_search import Search

SIZE = 40


def matrices(size=SIZE, seed=0):
    """Mass, gyroscopic matrix and stiffness of some chain, full, with frequencies over three decades."""
    random = np.random.default_rng(seed)
    root = random.standard_normal((size, size)) / np.sqrt(size) + 2.0 * np.eye(size)
    mass = root @ root.T
    turned, _ = np.linalg.qr(random.standard_normal((size, size)))
    stiffness = turned * np.geomspace(1.0, 1e6, size) @ turned.T
    skew = random.standard_normal((size, size))
    return mass, skew - skew.T, 0.5 * (stiffness + stiffness.T)


def motions(mass, damping, stiffness):
    basis = sparse.csc_array(sparse.eye_array(len(mass)))
    return LosslessMotions.of(*(sparse.csr_array(m) for m in (mass, damping, stiffness)), basis)


def all_frequencies(mass, damping, stiffness):
    """Those of the full first-order system, an independent way: eigenvalues come in pairs of signs."""
    one, none = np.eye(len(mass)), np.zeros_like(mass)
    system = np.block([[none, one], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    s = np.linalg.eigvals(system)
    assert np.abs(s.real).max() < 1e-9 * np.abs(s).max()
    return np.sort(s.imag[s.imag > 0.0])


@pytest.mark.parametrize("count", [1, 5, 20, SIZE, 2 * SIZE])
def test_frequencies_are_those_of_the_full_system(count):
    parts = matrices()
    exact = all_frequencies(*parts)
    found = motions(*parts).slowest(count)
    assert found.complete
    np.testing.assert_allclose(found.frequencies, exact[:count], rtol=1e-9)
    s = 1j * found.frequencies
    assert motions(*parts).residuals(s, found.motions).max() < 1e-9
    for w, y in zip(found.frequencies, found.motions.T, strict=True):
        mass, damping, stiffness = parts
        terms = [stiffness @ y, 1j * w * damping @ y, -(w**2) * mass @ y]
        assert np.abs(sum(terms)).max() < 1e-8 * max(np.abs(term).max() for term in terms)


@pytest.mark.parametrize("copies", [2, 4, 9])
def test_frequencies_that_coincide_are_all_found(copies):
    """A structure of equal parts has each frequency as often: what one start vector tells of them is one motion."""
    parts = matrices(12, seed=3)
    exact = all_frequencies(*parts)
    several = [np.kron(np.eye(copies), part) for part in parts]
    found = motions(*several).slowest(3 * copies)
    assert found.complete
    np.testing.assert_allclose(found.frequencies, np.repeat(exact[:3], copies), rtol=1e-9)
    assert np.linalg.matrix_rank(found.motions) == 3 * copies


def test_motions_below_a_frequency_are_counted():
    parts = matrices(seed=5)
    exact, system = all_frequencies(*parts), motions(*parts)
    for k in (0, 1, 7, SIZE - 1):
        between = exact[k] * 0.999 if k == 0 else 0.5 * (exact[k - 1] + exact[k])
        assert system.below(float(between)) == k


def test_what_is_not_surely_bounded_is_left_to_others():
    mass, skew, stiffness = matrices(10)
    assert motions(mass, skew, stiffness) is not None
    slack = stiffness - 2.0 * np.linalg.eigvalsh(stiffness)[0] * np.eye(10)
    assert motions(mass, skew, slack) is None  # gyroscopic forces may hold it, or not
    neutral = stiffness - np.linalg.eigvalsh(stiffness)[0] * np.eye(10)
    assert motions(mass, skew, neutral) is None
    assert motions(mass, skew + 1e-6 * np.eye(10), stiffness) is None  # damped
    circulatory = stiffness.copy()
    circulatory[0, 1] += 1e-3 * np.abs(stiffness).max()
    assert motions(mass, skew, circulatory) is None


def blade(section, spin=20.0):
    """A swept blade on a hub, at its steady rotation: the equations."""
    model = vr.Model()
    model.add("inner", vr.Rod.straight((0.1, 0, 0), (1, 0, 0), section=section, elements=2, order=4))
    model.add("outer", vr.Rod.straight((1, 0, 0), (1.3, -0.3, 0.1), section=section, elements=1, order=4))
    model.attach("inner.end", "outer.start")
    model.clamp("inner.start")
    settings = SteadySettings(spin=(0.0, 0.0, spin))
    return Search(DiscreteModel.of(model, settings).static, settings, None).equations()


SECTION = vr.StiffnessSection([900.0, 900.0, 4000.0, 3.0, 8.0, 2.0], [1.0, 1.0, 1.0, 0.002, 0.004, 0.006])


def test_a_blade_has_the_same_motions_both_ways():
    """All eigenvalues of the full matrix of first order, which knows of no symmetry, beside the slowest ones."""
    equations = blade(SECTION)
    rate = equations.rate
    quick = both.stability(equations.small_motions(), rate, 8)
    full = both.stability(both.first_order(*equations.motions_of_second_order(), rate), rate, 8)
    assert isinstance(quick.system, LosslessMotions)
    assert isinstance(full.system, both.FirstOrder)
    assert (quick.unstable, quick.neutral, quick.growth) == (full.unstable, full.neutral, full.growth)
    np.testing.assert_allclose(quick.eigenvalues, full.eigenvalues[:8], rtol=1e-10, atol=1e-9)
    one, other = quick.increments(8), full.increments(8)
    likeness = np.abs(np.einsum("ik,ik->k", one.conj(), other))
    np.testing.assert_allclose(
        likeness, np.linalg.norm(one, axis=0) * np.linalg.norm(other, axis=0), rtol=1e-9
    )


def test_a_damped_blade_is_not_among_them():
    damped = vr.StiffnessSection(SECTION.stiffness, SECTION.inertia, times=[0.001] * 6)
    equations = blade(damped)
    assert isinstance(equations.small_motions(), both.FirstOrder)


def test_one_iteration_is_the_change_that_the_equations_ask_for():
    """With the factors of statics as by least squares, of the same linearisation."""
    equations = blade(SECTION)
    equations.set_spin(1.02 * equations.rate)
    quick = equations.change_at_spin()
    balance = equations.balance()
    slow = np.linalg.lstsq(balance.matrix[:, :-1], -balance.residual, rcond=None)[0]
    np.testing.assert_allclose(quick[:-1], slow, rtol=1e-8, atol=1e-9 * np.abs(slow).max())
    assert quick[-1] == 0.0


def test_where_something_moves_freely_there_is_no_such_change():
    model = vr.Model()
    model.add("arm", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=SECTION, elements=2, order=3))
    model.pin("arm.start")
    settings = SteadySettings(spin=(0.0, 0.0, 3.0))
    equations = Search(DiscreteModel.of(model, settings).static, settings, None).equations()
    assert equations.change_at_spin() is None

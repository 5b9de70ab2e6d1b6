"""Small motions about rotations of large models: sparse matrices against full ones, and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from reference.cases import stiff
from viscorod.solve.steady import geometric_steady, stability


def shaft(elements, damping=0.01, order=5):
    """A thin shaft between bearings, ``EI = L = mu = 1``."""
    section = stiff(1e6, 1e6, 1.0, 1.0, rotary=(1e-8, 1e-8, 2e-8), damping=damping)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=order)
    model.add("shaft", rod)
    model.pin("shaft.start")
    model.support("shaft.end", ["uy", "uz"])
    return model


def boomerang(damping):
    """Two free rods at an angle, which turn about their axis of largest inertia."""
    section = vr.StiffnessSection([1e4] * 3 + [1.0] * 3, [1.0] * 3 + [1e-3, 1e-3, 2e-3], [damping] * 6)
    model = vr.Model()
    model.add("a", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=4))
    model.add("b", vr.Rod.straight((0, 0, 0), (0, 1, 0), section=section, elements=2, order=4))
    model.attach("a.start", "b.start")
    return model


def pendulum():
    """A rod on a ball joint that whirls about the vertical."""
    section = vr.StiffnessSection([1e5] * 3 + [30.0] * 3, [1.0] * 3 + [1e-4] * 3, [1e-3] * 6)
    model = vr.Model()
    model.add("bob", vr.Rod.straight((0, 0, 0), (0.6, 0, -0.8), section=section, elements=2, order=4))
    model.pin("bob.start")
    model.gravity((0, 0, -10.0))
    return model


CASES = {
    "slow shaft": (lambda: shaft(3), {"spin": (8.0, 0, 0)}),
    "fast shaft": (lambda: shaft(3), {"spin": (50.0, 0, 0)}),
    "undamped shaft": (lambda: shaft(3, 0.0), {"spin": (50.0, 0, 0)}),
    "boomerang": (lambda: boomerang(1e-3), {"momentum": 0.5, "axis": (0, 0, 1)}),
    "pendulum": (pendulum, {"spin": (0, 0, 5.0)}),
}


@pytest.mark.parametrize("case", CASES)
def test_sparse_matrices_give_what_full_ones_do(case, monkeypatch):
    """Two solvers against each other: eigenvalues, stability and the rotation itself."""
    make, kind = CASES[case]
    full = make().steady(**kind, modes=6)
    for module in (geometric_steady, stability):
        monkeypatch.setattr(module, "FULL", 0)
    sparse = make().steady(**kind, modes=6)
    assert not any("grow were sought" in text for text in sparse.warnings)
    assert len(full.warnings) == (full.data.attrs["unstable"] > 0)  # which is told
    assert sparse.data["position"].values == pytest.approx(full.data["position"].values, abs=1e-7)
    size = np.linalg.norm(full.spin)
    assert np.abs(sparse.eigenvalues - full.eigenvalues).max() < 1e-6 * max(
        size, np.abs(full.eigenvalues).max()
    )
    for name in ("unstable", "neutral"):
        assert sparse.data.attrs[name] == full.data.attrs[name]
    assert sparse.growth_rate == pytest.approx(full.growth_rate, rel=1e-6, abs=1e-9 * size)
    assert sparse.modes.residuals.max() < 1e-9


@pytest.mark.parametrize(("elements", "damping"), [(60, 0.001), (15, 0.01)])
def test_a_long_shaft_beyond_three_critical_speeds(elements, damping):
    """Closed form: whirls ``(s + i W)^2 + t w^2 s + w^2 = 0``, of which those with ``w = (k pi)^2 < W`` grow.

    With the larger damping, overdamped motions crowd nearer to zero than some of those that grow."""
    W = 120.0
    found = shaft(elements, damping).steady(spin=(W, 0, 0), modes=12)
    w = (np.arange(1, 6) * np.pi) ** 2
    assert found.data.attrs["unstable"] == 2 * np.count_nonzero(w < W) == 6
    slow = np.array([s for k in w for s in np.roots([1.0, 2j * W + damping * k**2, k**2 - W**2])])
    growing = slow[slow.real > 1e-9]
    assert found.growth_rate == pytest.approx(growing.real.max(), rel=1e-4)
    for root in growing[: None if damping < 0.01 else 0]:
        assert np.abs(found.eigenvalues - (root if root.imag > 0 else root.conj())).min() < 1e-4 * W
    assert not any("grow were sought" in text for text in found.warnings)


@pytest.mark.parametrize("rotary", [1e-12, 1e-9, 1e-6])
def test_a_conical_pendulum_without_damping_is_neutral(rotary):
    """Closed form: all of its motions swing, none grows, however small the inertia of its sections against turning.

    What round-off makes of the fast ones depends on the first guess."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6] * 3 + [1e4] * 3, [1.0] * 3 + [rotary] * 3)
    model.add("bob", vr.Rod.straight((0, 0, 0), (0.6, 0, -0.8), section=section, elements=1, order=4))
    model.pin("bob.start")
    model.gravity((0, 0, -10.0))
    for duration in (1e-6, 1e-4, 1e-2):
        found = model.steady(spin=(0, 0, 5.0), start=model.simulate(duration, initial="reference"))
        assert found.stable
        # 5 nodes, one pinned, in poses and velocities, less turning about the axis
        assert found.neutral == 2 * (5 * 6 - 3) - 1

"""The estimated error of the mesh, beside the error that closed forms and refinement tell."""

from __future__ import annotations

import importlib.util
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from numpy.polynomial import legendre

import viscorod as vr
from viscorod.results.mesh_error import mesh_errors
from viscorod.results.result_warnings import warnings_of

from .cases import slope
from .test_examples import ROOT

_spec = importlib.util.spec_from_file_location("choose_mesh", ROOT / "docs" / "figures" / "choose_mesh.py")
assert _spec is not None
assert _spec.loader is not None
choose_mesh = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(choose_mesh)


def strained(strain, order, elements, length=1.0):
    """What is read of an equilibrium of one rod whose strains are ``strain(s)`` (6, points) at its Gauss points."""
    x, w = legendre.leggauss(order)
    ends = np.linspace(0.0, length, elements + 1)
    half = 0.5 * length / elements
    s = (ends[:-1, None] + half * (1.0 + x)).ravel()
    stations = elements * order + 1
    data = xr.Dataset(
        {
            "strain": (("load_factor", "point", "component"), np.array(strain(s)).T[None]),
            "point_rod": ("point", np.full(s.size, "rod")),
            "point_weight": ("point", np.tile(half * w, elements)),
            "station_rod": ("station", np.full(stations, "rod")),
            "station_order": ("station", np.full(stations, order)),
        },
        coords={"load_factor": [1.0]},
    )
    return SimpleNamespace(data=data, dimension="load_factor")


@pytest.mark.parametrize("order", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("size", [1e-6, 0.1])
def test_one_term_has_the_estimate_of_the_formula(order, size):
    """Closed form: the last Legendre term alone, a curvature that integrates to nothing over the element."""
    term = np.eye(order)[-1]

    def strain(s):
        zero = np.zeros_like(s)
        return [zero, zero, zero, zero, size * legendre.legval(2.0 * s - 1.0, term), zero]

    whole = size / np.sqrt(2 * order - 1)
    turned = size if order == 1 else 0.0
    collocation = {1: 1 / 12, 2: 4 / 2880, 3: 36 / 3628800}.get(order, 0.0) * turned ** (2 * order + 1)
    found = mesh_errors(strained(strain, order, 1))["rod"]
    assert found == pytest.approx((size / (2 * order)) ** 2 / whole + collocation, rel=1e-12)


def test_stretch_counts_over_the_length():
    """Similarity: the same strains of a rod a thousand times as long, curvatures a thousand times smaller."""

    def strain(s, length):
        u = s / length
        return [u**2, 0 * u, 0.1 * u**3, u**4 / length, u**2 / length, 0 * u]

    one, long = (mesh_errors(strained(lambda s, L=L: strain(s, L), 3, 2, L))["rod"] for L in (1.0, 1000.0))
    assert one == pytest.approx(long, rel=1e-12)


@pytest.fixture
def seen(monkeypatch):
    """The last equilibrium that was computed."""
    results = []
    compute = vr.Model.equilibrium

    def kept(self, **given):
        results.append(compute(self, **given))
        return results[-1]

    monkeypatch.setattr(vr.Model, "equilibrium", kept)
    return results


@pytest.mark.parametrize(
    ("order", "elements"), [(1, (4, 8, 16)), (2, (2, 4, 8)), (3, (2, 4, 8)), (5, (2, 4))]
)
def test_estimate_beside_eulers_elastica(seen, order, elements):
    """Closed form: a strip bent by ten times EI/L^2; the estimate is of the same size and falls with the same order."""
    errors = [choose_mesh.bent(n, order) for n in elements]
    estimates = [result.mesh_errors["strip"] for result in seen]
    ratio = np.array(estimates) / errors
    assert np.all((ratio > 1 / 15) & (ratio < 15))
    assert slope(elements, estimates) == pytest.approx(slope(elements, errors), abs=1.0)


@pytest.mark.parametrize(("order", "elements"), [(2, (8, 16)), (3, (4, 8)), (5, (4,))])
def test_estimate_beside_a_wound_wire(seen, order, elements):
    """Closed form: a helix of constant curvature, whose strains have no other term: the error of turning alone."""
    errors = [choose_mesh.coil(n, order) for n in elements]
    estimates = [result.mesh_errors["wire"] for result in seen]
    ratio = np.array(estimates) / errors
    assert np.all((ratio > 0.5) & (ratio < 10))


@pytest.mark.parametrize(("elements", "order"), [(4, 1), (2, 2), (4, 2), (2, 3), (4, 3)])
def test_estimate_beside_a_refined_swing(elements, order):
    """Refinement: the tutorial's swing for a second, beside 4 elements of order 8."""

    def run(elements, order):
        material = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
        model = vr.Model()
        rod = vr.Rod.straight(
            (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=material,
            elements=elements, order=order,
        )  # fmt: skip
        model.add("beam", rod)
        model.clamp("beam.start")
        model.force("beam.end", (0, 0.035, 0), until=0.0)
        return model.simulate(1.0, tolerance=1e-6, output_interval=0.02)

    found, fine = run(elements, order), run(4, 8)
    error = np.abs(found.history("beam.end").values - fine.history("beam.end").values).max() / 0.3
    assert 0.1 < found.mesh_errors["beam"] / error < 10.0
    assert 1e-7 > fine.mesh_errors["beam"]


def test_a_coarse_mesh_is_warned_of():
    """Refinement: a cable of 20 m falls and swings; two elements of order 5 are off by 0.8 % of it, six by nothing."""

    def cable(elements):
        material = vr.Material(100e9, 0.3, 7800.0, damping=vr.KelvinVoigt(1e-4, 1e-4))
        model = vr.Model()
        rod = vr.Rod.straight(
            (0, 0, 0), (20.0, 0, 0), section=vr.Circle(0.005), material=material, elements=elements, order=5
        )
        model.add("cable", rod)
        model.support("cable.start", ("ux", "uy", "uz", "rx"))
        model.gravity()
        return model.simulate(4.0, initial="reference", output_interval=0.02)

    coarse, fine = cable(2), cable(6)
    error = np.abs(coarse.history("cable.end").values - fine.history("cable.end").values).max() / 20.0
    assert 0.002 < error < 0.02
    (warning,) = warnings_of(coarse)
    assert "length of rod 'cable', whose mesh is coarse" in warning
    assert 0.3 * error < coarse.mesh_errors["cable"] < 10.0 * error
    assert "Mesh: positions are off by about" in coarse.report()
    assert not warnings_of(fine)

"""Damped modes of larger models, by iteration: those of full matrices, and of a coarser mesh."""

import copy

import numpy as np
import pytest

import viscorod as vr
from helpers.damaged_cases import CASES
from viscorod.analyses.case_run import as_model
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import case_from_dict
from viscorod.solve.modes import linearisation, undamped


def finer(name, times):
    content = copy.deepcopy(CASES[name])
    for rod in content["rods"].values():
        rod["elements"] = times * rod.get("elements", 2)
    return case_from_dict(content).description


def vibrations(description):
    report = check(DiscreteModel.of(description))
    kept = report.damping_ratios < 0.999
    return report.frequencies[kept], report.damping_ratios[kept]


@pytest.mark.parametrize(
    ("name", "times"), [("soft_arm", 2), ("four_bar", 2), ("cantilever_swing", 4), ("bend_45", 4)]
)
def test_iteration_finds_what_full_matrices_have(name, times, monkeypatch):
    """Creeping motions crowd beside the vibrations in all but the last; double frequencies are both found."""
    model = as_model(finer(name, times))
    found = []
    for dense in (10**6, 0):
        for module in (linearisation, undamped):
            monkeypatch.setattr(module, "DENSE", dense)
        found.append(model.modes(8, about="reference"))
    full, iterated = found
    assert len(full.frequencies) == 8
    assert iterated.certified
    assert iterated.names == full.names
    np.testing.assert_allclose(iterated.frequencies, full.frequencies, rtol=1e-7)
    np.testing.assert_allclose(iterated.damping_ratios, full.damping_ratios, atol=1e-8)


def test_vibrations_of_a_fine_mesh_beside_creep():
    """Heavily damped, with so many creeping motions that not one of them can be told from the others."""
    coarse, fine = vibrations(finer("soft_arm", 1)), vibrations(finer("soft_arm", 4))
    np.testing.assert_allclose(fine[0], coarse[0], rtol=1e-6)
    np.testing.assert_allclose(fine[1], coarse[1], rtol=1e-6)


def test_no_mode_is_made_up():
    """Damping in proportion to stiffness: half the angular frequency times the retardation time, in every mode."""
    times = vr.KelvinVoigt(extensional_time=1e-5, shear_time=1e-5)
    material = vr.Material(2e11, poissons_ratio=0.3, density=7800.0, damping=times)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.01, 0.03), material=material, elements=12, order=5
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    found = model.modes(8, about="reference")
    expected = 0.5 * 2.0 * np.pi * found.frequencies * 1e-5
    np.testing.assert_allclose(found.damping_ratios, expected, rtol=1e-6)


def test_iteration_ends_where_stiffnesses_differ_by_many_digits():
    """For films as high as a metre the library reports failure with all eigenvalues found (found by make fuzz)."""
    content = copy.deepcopy(CASES["comb_resonator"])
    content["sections"]["flexure"]["height"] = 1.0
    for rod in content["rods"].values():
        rod["order"] = 2
        rod.pop("elements")
    report = check(DiscreteModel.of(case_from_dict(content).description))
    assert np.isfinite(report.frequencies).all()

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
from viscorod.solve.modes import damped, linearisation, undamped


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


def test_what_nobody_asks_for_is_not_judged(monkeypatch):
    """To judge all modes of full matrices took twice as long as to find them; those that are asked for are."""
    judged, residuals = [], damped._Reduction.residuals

    def counted(self, roots, vectors, strained):
        judged.append(len(roots))
        return residuals(self, roots, vectors, strained)

    monkeypatch.setattr(damped._Reduction, "residuals", counted)
    found = as_model(finer("cantilever_swing", 1)).modes(3, about="reference")
    assert judged
    assert max(judged) == 3
    assert len(found.residuals) == 3
    assert found.residuals.max() < 1e-8


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


@pytest.mark.parametrize("elements", [None, 3, 9, 15])
def test_relaxation_does_not_pass_for_modes(elements: int | None) -> None:
    """s^2 + w^2 (1 + g s tau/(1 + s tau)) = 0 for every undamped w: the third root of each crowds at -1/tau.

    The rod is stiff beside 1/tau, and a following moment makes its stiffness unsymmetric: round-off gives the crowd
    imaginary parts.
    """
    g, tau = 0.15, 0.35

    def modes(damping: vr.Prony | None) -> np.ndarray:
        steel = vr.Material(2e11, 0.3, 7850.0, damping=damping)
        model = vr.Model()
        start, end = (8.0, 0, 0), (0, 8.0, 0)
        arc = {"section": vr.Circle(0.05), "material": steel, "elements": elements}
        arc |= {} if elements is None else {"order": 6}
        model.add("arc", vr.Rod.arc(start, end, (-8.0, 0, 0), 8.0, np.pi / 3, **arc))
        model.clamp("arc.start")
        model.moment("arc.end", (0, 0, 5.0), following=True)
        return model.modes(8).eigenvalues

    undamped = np.abs(modes(None))
    found = modes(vr.Prony(shear_ratios=(g,), shear_times=(tau,), constant="poissons_ratio"))
    for s, w in zip(found, undamped, strict=True):
        roots = np.roots([tau, 1.0, w**2 * tau * (1.0 + g), w**2])
        exact = roots[np.argmax(roots.imag)]
        assert s == pytest.approx(exact, rel=2e-4 if elements == 3 else 2e-5)


@pytest.mark.parametrize("elements", [4, 8])
def test_overdamped_crowd_does_not_pass_for_slow_modes(elements: int) -> None:
    """s^2 + tau w^2 s + w^2 = 0: of the crowd at -1/tau each root belongs to a fast mode and is listed as one."""
    tau = 1e-3

    def modes(damping: vr.KelvinVoigt | None) -> np.ndarray:
        steel = vr.Material(2e11, 0.3, 7850.0, damping=damping)
        model = vr.Model()
        section = vr.Annulus(0.012, 0.01)
        helix = {"section": section, "material": steel, "elements": elements, "order": 5}
        model.add("tube", vr.Rod.helix(0.03, 0.04, 1.2, **helix))
        model.clamp("tube.start")
        model.moment("tube.end", (0, 0, 0.5), following=True)
        return model.modes(9).eigenvalues

    exact: list[complex] = []
    for w in np.abs(modes(None)):
        half = 0.5 * tau * w**2
        fast = -half - np.sqrt(complex(half**2 - w**2))
        exact += [w**2 / fast, fast] if half > w else [fast.conjugate()]
    for s in modes(vr.KelvinVoigt(tau, tau)):
        nearest = exact.pop(int(np.argmin(np.abs(np.array(exact) - s))))
        assert abs(s - nearest) < 1e-4 * abs(nearest)  # the small load's own stiffness is not damped

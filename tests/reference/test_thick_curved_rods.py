"""Curved rods that are thick: with `curvature_correction`, against elasticity in two and three dimensions."""

from math import log, pi

import numpy as np
import pytest

import viscorod as vr
from viscorod.model.sections.curved_section import curved_matrices

RADIUS = 0.1


def quarter(thickness, corrected, **loads):
    """A quarter of a ring, clamped at one end, with a small load at its other; no lateral contraction."""
    material = vr.Material(1e6, 0.0, 1000.0)
    model = vr.Model()
    ring = vr.Rod.arc(
        *((0, 0, 0), (1, 0, 0), (0, 1, 0), RADIUS, pi / 2),
        section=vr.Rectangle(thickness * RADIUS, 0.01),
        material=material,
        d1=(0, 1, 0),
        elements=2,
        order=6,
        curvature_correction=corrected,
    )
    model.add("ring", ring)
    model.clamp("ring.start")
    for kind, value in loads.items():
        getattr(model, kind)("ring.end", value)
    return model.equilibrium()


def golovin(thickness):
    """Rotation per angle of a ring in pure bending over that of a slender one (Timoshenko and Goodier, article 29)."""
    h, a, b = thickness, 1 - thickness / 2, 1 + thickness / 2
    return 8 * (b**2 - a**2) / ((b**2 - a**2) ** 2 - 4 * a**2 * b**2 * log(b / a) ** 2) * h**3 / 12


def end_force(thickness):
    """Deflection of a quarter of a ring by a radial force at its end, times E b/P (the same, article 33)."""
    a, b = 1 - thickness / 2, 1 + thickness / 2
    return pi * (a**2 + b**2) / (a**2 - b**2 + (a**2 + b**2) * log(b / a))


@pytest.mark.parametrize("thickness", [0.1, 0.4, 0.8])
@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_stiffness_of_a_ring_in_pure_bending_is_golovins(thickness, nu):
    """To round-off without lateral contraction, where plane stress is exact; with it for a narrow ring."""
    material = vr.Material(1e6, nu, 1000.0)
    section = vr.Rectangle(thickness, 0.02 * thickness)
    straight = section.matrices(material)
    C = curved_matrices(straight, section, material, np.array([0.0, 1.0]))[0]
    bending = np.linalg.inv(C[2:5, 2:5])[2, 2] * straight[0][4, 4]
    assert bending == pytest.approx(golovin(thickness), rel=1e-8 if nu == 0.0 else 1e-5)
    assert C[2, 4] != 0.0
    assert np.linalg.eigvalsh(C).min() > 0.0


def test_a_thick_quarter_of_a_ring_has_the_deflection_of_elasticity():
    """The error is of second order in thickness over radius without the correction, and of fourth order with it."""
    force = 1e-7
    thickness = np.array([0.2, 0.4])
    scale = 1e6 * 0.01 / force
    errors = {
        corrected: np.array(
            [
                abs(
                    quarter(t, corrected, force=(force, 0, 0)).displacement("ring.end")[0]
                    * scale
                    / end_force(t)
                    - 1
                )
                for t in thickness
            ]
        )
        for corrected in (False, True)
    }
    orders = {corrected: np.log2(error[1] / error[0]) for corrected, error in errors.items()}
    assert errors[False] == pytest.approx(0.1338 * thickness**2, rel=0.02)
    assert orders[False] == pytest.approx(2.0, abs=0.05)
    assert orders[True] == pytest.approx(4.0, abs=0.05)
    assert errors[True][0] < 6e-5
    moment = 1e-9
    turned = quarter(0.4, True, moment=(0, 0, moment)).rotation("ring.end")[2]
    slender = moment * RADIUS * pi / 2 / (1e6 * 0.01 * (0.4 * RADIUS) ** 3 / 12)
    assert turned / slender == pytest.approx(golovin(0.4), rel=1e-5)


@pytest.mark.parametrize(("ratio", "flexibility"), [(1.0, 1.692), (0.5, 3.293)])
def test_a_bent_tube_becomes_oval(ratio, flexibility):
    """Th. von Karman 1911: flexibility of a pipe bend over a straight pipe, (105 + 4136 l^2 + 4800 l^4)/(3 + 536 l^2 +
    4800 l^4) with l = t R/(r^2 sqrt(1 - nu^2))."""
    r, R, nu = 0.1, 2.0, 0.3
    t = ratio * r**2 / R * np.sqrt(1 - nu**2)
    tube, material = vr.Annulus(r + t / 2, r - t / 2), vr.Material(1e9, nu, 1000.0)
    C = curved_matrices(tube.matrices(material), tube, material, np.array([1 / R, 0.0]))[0]
    found = np.linalg.inv(C[2:5, 2:5])[1, 1] * 1e9 * tube.second_moment_1
    assert found == pytest.approx(flexibility, rel=0.006)


def test_damping_inertia_and_branches_follow():
    """D in proportion of the viscosity, branches of their moduli, the mass centre where J0 puts it (I/A over R)."""
    section, bent = vr.Circle(0.02), np.array([0.0, 5.0])
    viscous = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.01, 0.02))
    relaxing = vr.Material(
        1e6, 0.3, 1000.0, damping=vr.Prony(shear_ratios=[0.5], shear_times=[0.1], constant="poissons_ratio")
    )
    rods = [
        vr.Rod.arc(
            *((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.2, 1.0),
            section=section,
            material=material,
            d1=(0, 1, 0),
            curvature_correction=True,
        )
        for material in (viscous, relaxing)
    ]
    C, D, M = rods[0].matrices_at(0.1)
    assert rods[0].curvature_at(0.1) == pytest.approx(bent, abs=1e-12)
    assert D[2:5, 2:5] == pytest.approx(viscous.extensional_time * C[2:5, 2:5], rel=1e-9, abs=1e-12)
    assert [M[1, 5] / M[0, 0], -M[0, 5] / M[0, 0]] == pytest.approx([-5.0 * 0.02**2 / 4, 0.0], abs=1e-9)
    assert M[0, 0] == pytest.approx(1000.0 * section.area, rel=1e-12)
    C, _, _ = rods[1].matrices_at(0.1)
    times, branches = rods[1].branches_at(0.1)
    (branch,) = relaxing.branches
    assert times == pytest.approx([0.1])
    assert branches[0, 2:5, 2:5] == pytest.approx(
        branch.youngs_modulus / 1e6 * C[2:5, 2:5], rel=1e-9, abs=1e-12
    )


def test_sections_that_cannot_are_refused():
    steel = vr.Material(2e11, 0.3, 7850.0)
    arc = (0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, 1.0
    with pytest.raises(vr.InputError, match=r"curvature_correction: .*its points are not known"):
        vr.Rod.arc(
            *arc,
            section=vr.SectionProperties(1e-4, 1e-9, 1e-9, 1e-9),
            material=steel,
            curvature_correction=True,
        )
    with pytest.raises(vr.InputError, match="reaches to the centre of curvature"):
        vr.Rod.arc(*arc, section=vr.Circle(0.11), material=steel, curvature_correction=True)


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_the_loss_of_a_corrected_rod_is_that_of_its_sections():
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.002, 0.004))
    model = vr.Model()
    arc = (0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, 1.0
    section = vr.Rectangle(0.03, 0.02)
    model.add(
        "arc",
        vr.Rod.arc(*arc, section=section, material=rubber, elements=1, order=3, curvature_correction=True),
    )
    model.clamp("arc.start")
    model.force("arc.end", (0.05, 0.05, 0.02), until=0.0)
    run = model.simulate(0.01, time_step=0.005, integrator="generalized_alpha")
    largest = run.data.dissipation.values.max()
    for k, s in enumerate(run.data.point_s.values.tolist()):
        found = run.stress(f"arc@{s!r}")
        own = found.loss_density.values @ (found.area.values * found.volume_factor.values)
        assert own == pytest.approx(run.data.dissipation.values[:, k], abs=1e-9 * largest)

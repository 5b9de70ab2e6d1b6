"""Statics in three dimensions (cases A6, B1, B2, B11)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import stiff


def helix_error(slenderness, elements=6, order=4):
    """A6: a straight rod bent and twisted into a helix by a body-fixed end couple; the exact shape is known."""
    radius, height, coils = 10.0, 50.0, 2.0
    a = 2 * np.pi * coils
    c = height / (radius * a)
    length = np.sqrt(1 + c**2) * radius * a
    width = length / slenderness
    area, second = np.pi * width**2 / 4, np.pi * width**4 / 64
    E, G = 1.0, 0.5

    def exact(s):
        x = s / length
        return radius * np.array([np.sin(a * x), -np.cos(a * x), c * a * x]).T

    start = exact(np.zeros(1))[0]
    tangent = np.array([1.0, 0.0, c]) / np.hypot(1, c)
    normal = np.array([0.0, 1.0, 0.0])  # towards the axis
    rod = vr.Rod.straight(
        start,
        start + length * tangent,
        section=vr.StiffnessSection(
            [G * area, G * area, E * area, E * second, E * second, 2 * G * second],
            [1, 1, 1, 1e-3, 1e-3, 2e-3],
        ),
        elements=elements,
        order=order,
        d1=normal,
    )
    model = vr.Model()
    model.add("rod", rod)
    model.clamp("rod.start")
    # R0 a^2/L^2 (c GJ e_axis + EI e_binormal); here d3 is the axis, d1 the normal, so the binormal is d3 x d1 = d2
    moment = radius * a**2 / length**2 * np.array([0.0, E * second, c * 2 * G * second])
    model.moment("rod.end", tuple(moment), following=True)
    found = model.equilibrium()
    stations = found.data["station_s"].values
    return np.abs(found.data["position"].values[-1] - exact(stations)).max() / length


def test_helix_does_not_lock():
    """A6: the error of a given mesh does not grow from slenderness 1e1 to 1e4."""
    errors = [helix_error(10.0**k) for k in (1, 2, 3, 4)]
    assert max(errors) < 2e-4
    assert max(errors) < 1.01 * errors[0]


def test_helix_converges_to_round_off_at_slenderness_1e4():
    assert helix_error(1e4, elements=8, order=8) < 1e-8


def bend(elements, order, slenderness=None):
    """B1: Bathe and Bolourchi's 45-degree bend, J = Ip; the load is out of plane."""
    radius = 100.0
    width, load = 1.0, 600.0
    if slenderness is not None:
        width = radius / slenderness
        load = 600.0 * width**4
    area, second = width**2, width**4 / 12
    section = vr.StiffnessSection(
        [5e6 * area, 5e6 * area, 1e7 * area, 1e7 * second, 1e7 * second, 5e6 * 2 * second],
        [1, 1, 1, 1e-3, 1e-3, 2e-3],
    )
    model = vr.Model()
    rod = vr.Rod.arc(
        (0, 0, 0), (0, 1, 0), (1, 0, 0), radius, np.pi / 4, section=section, elements=elements, order=order
    )
    model.add("arc", rod)
    model.clamp("arc.start")
    model.force("arc.end", (0, 0, load))
    return model.equilibrium()


def test_45_degree_bend_in_one_step():
    """B1, six digits (converged independently), one load step, at most 12 iterations (mixed Newton)."""
    found = bend(3, 6)
    assert found.position("arc.end") == pytest.approx([15.68480, 47.15044, 53.47486], abs=1e-5)
    assert found.data.sizes["load_factor"] == 1
    assert found.data.attrs["rejected"] == 0
    assert found.data.attrs["iterations"] <= 12


@pytest.mark.parametrize("slenderness", [1e1, 1e2, 1e3, 1e4])
def test_bend_does_not_lock(slenderness):
    """B1 slenderness family: the same mesh stays converged; loads scale so that EI w''/F does not change."""
    coarse, fine = bend(2, 5, slenderness), bend(4, 8, slenderness)
    error = np.abs(coarse.position("arc.end") - fine.position("arc.end")).max()
    assert error < 2e-5 * 100.0


def frame(torsion, force, elements=3, order=6):
    """B2: Argyris' right-angle frame in newtons and millimetres; x along leg 1, y along leg 2."""
    E, nu, height, thickness, leg = 71240.0, 0.31, 30.0, 0.6, 240.0
    G = E / (2 * (1 + nu))
    area = height * thickness
    strong, weak = thickness * height**3 / 12, height * thickness**3 / 12
    # in-plane bending is strong: d1 in the plane, d2 = z; bend_2 (about d2) strong
    section = vr.StiffnessSection(
        [5 / 6 * G * area, 5 / 6 * G * area, E * area, E * weak, E * strong, G * torsion],
        [1, 1, 1, 1, 1, 2],
    )
    model = vr.Model()
    given = {"section": section, "elements": elements, "order": order}
    model.add("leg1", vr.Rod.straight((0, 0, 0), (leg, 0, 0), d1=(0, 1, 0), **given))
    model.add("leg2", vr.Rod.straight((leg, 0, 0), (leg, leg, 0), d1=(1, 0, 0), **given))
    model.attach("leg1.end", "leg2.start")
    model.clamp("leg1.start")
    model.force("leg2.end", (force, 0, 0))
    return model.equilibrium(load_steps=2, search=False)


EXACT_TORSION = 30 * 0.6**3 / 3 * (1 - 0.630250 * 0.6 / 30)
"""Of the rectangle 30 x 0.6 (Timoshenko and Goodier's series; the next term is below 1e-9)."""


@pytest.mark.parametrize(
    ("torsion", "critical"),
    [(30 * 0.6**3 / 3, 1.087518), (EXACT_TORSION, 1.084089), (30 * 0.6**3 / 3, -0.680427)],
)
def test_right_angle_frame_buckles_sideways(torsion, critical):
    """B2: zero of the exact out-of-plane determinant; the count of negative eigenvalues changes within 0.01 %."""
    below = frame(torsion, critical * (1 - 1e-4)).negative_eigenvalues
    above = frame(torsion, critical * (1 + 1e-4)).negative_eigenvalues
    assert (below, above) == (0, 1)


def test_initially_curved_rod_stays_as_built():
    """No load, no motion: a coarse mesh of a twisted helix is free of stress as built."""
    model = vr.Model()
    rod = vr.Rod.helix(1.0, 0.5, 2.0, section=stiff(1e3, 1e3, 1.0, 1.0), elements=6, order=2, twist=3.0)
    model.add("spring", rod)
    model.clamp("spring.start")
    model.force("spring.end", (0, 0, 0))
    found = model.equilibrium()
    assert np.abs(found.data["section_force"].values).max() < 1e-9
    assert np.abs(found.displacement("spring.end")).max() < 1e-12


def l_frame():
    model = vr.Model()
    section = vr.StiffnessSection([2e3, 2e3, 5e3, 2.0, 3.0, 1.5], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model.add("a", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=4))
    model.add("b", vr.Rod.straight((1, 0, 0), (1, 1, 0.3), section=section, elements=2, order=4))
    model.attach("a.end", "b.start")
    return model


def test_path_independence():
    """B11 (ii): F1 then F2, F2 then F1, and both at once end in the same state."""
    ends = []
    for steps in (1, 2, 7):
        model = l_frame()
        model.clamp("a.start")
        model.force("b.end", (0, 0, 2.0))
        model.moment("b.end", (0, 1.0, 0))
        ends.append(model.equilibrium(load_steps=steps).position("b.end"))
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    assert ends[0] == pytest.approx(ends[2], abs=1e-9)


def test_clamp_turned_ten_times_returns_the_energy():
    """B11 (iii): a following load on a frame whose clamp is turned; the energy does not see the rotation."""
    energies = []
    for angle in (0.0, 1.0, 20 * np.pi):
        model = l_frame()
        model.clamp("a.start", motion={"rz": vr.Constant(angle)})
        model.force("b.end", (0.3, 0, 1.0), following=True)
        energies.append(model.equilibrium(load_steps=40).elastic_energy)
    assert energies[1] == pytest.approx(energies[0], rel=1e-10)
    assert energies[2] == pytest.approx(energies[0], rel=1e-10)

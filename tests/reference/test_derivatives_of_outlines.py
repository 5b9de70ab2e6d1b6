"""Derivatives by numbers of sections that are meshed: their meshes are moved, not made anew."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

WEDGE = [(0.0, 0.0), (0.05, 0.0), (0.05, 0.01), (0.0, 0.02)]


def shaft(section, **material):
    """A clamped rod under a small torque, which turns its end by T L/(G J)."""
    model = vr.Model()
    given = {"poissons_ratio": 0.3, "density": 7850.0} | material
    model.materials["steel"] = vr.Material(2.1e11, **given)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=section, material=model.materials["steel"], elements=1, order=1
    )
    model.add("shaft", rod)
    model.clamp("shaft.start")
    model.moment("shaft.end", (1e-3, 0, 0))
    return model


def points(corners):
    """Keys of the coordinates of an outline, and these."""
    return {
        f"rods.shaft.section.points[{i}][{j}]": corners[i][j] for i in range(len(corners)) for j in range(2)
    }


def twist(found):
    """Angle of twist at the end, rad per length."""
    return found.probe("shaft@0.5")["strain"].values[-1, 0, 5]


def test_a_twist_falls_with_the_fourth_power_of_its_outline():
    """Euler's theorem: J is homogeneous of degree 4 in all coordinates, and tau(x) per torque of -3 with x as well.

    Meshes made anew left noise as large as the derivatives: of an angle profile d(ln J)/d(ln h) was 0.5 to 2.2 at
    distances of 2.5e-5 to 1e-3, with 0.2 % between two meshes.
    """
    keys = points(WEDGE)
    found = shaft(vr.PolygonSection(WEDGE, mesh_size=0.003)).equilibrium(derivatives=list(keys))
    total = sum(value * found.derivatives[key].of(twist) for key, value in keys.items())
    assert total / twist(found) == pytest.approx(-4.0, abs=1e-6)

    def stress(result, scale=1.0):
        place = (-0.0123 * scale, 0.0031 * scale)
        return result.stress("shaft@0.5", points=place).stress.values[-1, 0, :2]

    total = sum(value * found.derivatives[key].of(stress) for key, value in keys.items())
    outwards = (stress(found, 1.0 + 1e-4) - stress(found, 1.0 - 1e-4)) / 2e-4  # linear within a triangle
    wanted = -3.0 * stress(found) - outwards
    np.testing.assert_allclose(total, wanted, atol=1e-5 * np.abs(wanted).max())


def test_a_rectangle_that_is_drawn_changes_as_its_closed_form():
    """Independent: Saint-Venant's series of the shape ``rectangle``; the mesh leaves 0.2 %."""
    width, height = 0.02, 0.008
    drawn = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    keys = points(drawn)
    found = shaft(vr.PolygonSection(drawn, mesh_size=0.001)).equilibrium(derivatives=list(keys))
    by = {key: found.derivatives[key].of(twist) for key in keys}
    names = ["rods.shaft.section.width", "rods.shaft.section.height"]
    known = shaft(vr.Rectangle(width, height)).equilibrium(derivatives=names)
    for axis, name in enumerate(names):
        far = [key for k, key in enumerate(keys) if k % 2 == axis and keys[key] > 0.0]
        assert len(far) == 2
        wanted = known.derivatives[name].of(twist)
        assert sum(by[key] for key in far) == pytest.approx(wanted, rel=4e-3)


def composite():
    steel = vr.Material(2.1e11, 0.3, 7850.0)
    rubber = vr.Material(5e6, 0.45, 1100.0, damping=vr.KelvinVoigt(0.01, 0.01))
    lower = [(0.0, 0.0), (0.02, 0.0), (0.02, 0.002), (0.0, 0.002)]
    upper = [(0.0, 0.002), (0.02, 0.002), (0.02, 0.005), (0.0, 0.005)]
    return vr.Composite([vr.CompositeRegion(steel, points=lower), vr.CompositeRegion(rubber, points=upper)])


def test_corners_that_meet_stay_together():
    """A layer that alone becomes wider would have another mesh: refused by name; a free side may move."""
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=composite(), elements=1, order=2))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, -1e-3))
    with pytest.raises(vr.InputError, match="lie on each other would part"):
        model.equilibrium(derivatives=["rods.beam.section.regions[0].points[2][0]"])
    keys = [f"rods.beam.section.regions[1].points[{i}][1]" for i in (2, 3)]
    modes = model.modes(1, derivatives=keys)
    assert all(np.isfinite(modes.derivatives[key].damping_ratios).all() for key in keys)


def test_a_mesh_size_is_no_number_of_a_model():
    with pytest.raises(vr.InputError, match="meshes stay while numbers vary"):
        shaft(vr.PolygonSection(WEDGE, mesh_size=0.002)).equilibrium(
            derivatives=["rods.shaft.section.mesh_size"]
        )

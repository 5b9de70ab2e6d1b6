"""Paths of symmetric structures: they stay symmetric on every mesh, and list what they pass."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

SECTION = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1.0] * 6)
OPENING = 2.0 * np.arctan(0.75)


def arch(elements, order, opening=OPENING):
    """A shallow clamped arch under a load in its middle."""
    model = vr.Model()
    mesh = {"elements": elements, "order": order}
    rod = vr.Rod.arc((0, 0, 0), (0.8, 0, 0.6), (0.6, 0, -0.8), 1.0, opening, section=SECTION, **mesh)
    model.add("arch", rod)
    model.clamp("arch.start")
    model.clamp("arch.end")
    model.force(f"arch@{0.5 * rod.length!r}", (0, 0, -40.0))
    return model


def half(elements, order):
    """Its left half, whose right end stays in the plane of symmetry, under half of the load."""
    model = vr.Model()
    mesh = {"elements": elements, "order": order}
    rod = vr.Rod.arc((0, 0, 0), (0.8, 0, 0.6), (0.6, 0, -0.8), 1.0, 0.5 * OPENING, section=SECTION, **mesh)
    model.add("arch", rod)
    model.clamp("arch.start")
    model.support("arch.end", ("ux", "uy", "rx", "ry", "rz"))
    model.force("arch.end", (0, 0, -20.0))
    return model


def pressed(model, place, depth=0.2, **settings):
    return model.path(place=place, axis="z", displacement=-depth, **settings)


def middle(model):
    return f"arch@{0.5 * model.rods['arch'].length!r}"


@pytest.mark.parametrize(("elements", "order"), [(12, 6), (2, 5), (4, 3)])
def test_a_symmetric_arch_stays_symmetric(elements, order):
    """Independent formulation: half of the arch with symmetric supports knows no other states.

    Among those listed are the bifurcations at which the whole arch would lean to one side."""
    model = arch(elements, order)
    path = pressed(model, middle(model))
    other = pressed(half(elements // 2, order), "arch.end")
    assert path.load_factor[-1] == pytest.approx(other.load_factor[-1], rel=1e-7)
    assert path.limit_points == pytest.approx(other.limit_points, rel=1e-7)
    assert abs(path.displacement(middle(model))[0]) < 1e-9
    assert len(path.bifurcations) > len(other.bifurcations)
    assert not path.stable


def test_bifurcations_that_undo_each_other_within_a_step_are_listed():
    """Short steps: the number of negative eigenvalues is the same before the two at 0.424 and 0.372 and after them."""
    model = arch(2, 5)
    short, long = (pressed(model, middle(model), arc_length=step) for step in (0.03, None))
    assert len(long.load_factor) < 20
    assert len(short.bifurcations) == 4
    assert long.bifurcations == pytest.approx(short.bifurcations, rel=1e-5)


def test_an_arch_that_is_not_quite_symmetric_leans_on_every_mesh():
    """Continuity: it cannot cross the broken bifurcation at 0.48 of the loads, whatever the steps and the mesh."""
    paths = []
    for elements, order, step in ((8, 4, None), (4, 6, None), (4, 6, 0.04)):
        model = arch(elements, order, 1.287)
        paths.append(pressed(model, middle(model), arc_length=step))
        assert abs(paths[-1].rotation(middle(model))[1]) > 0.01
        assert "near 0.48" in flat(paths[-1].report())
        assert len(paths[-1].bifurcations) == 2
    ends = [path.load_factor[-1] for path in paths]
    assert ends[1] == pytest.approx(ends[2], rel=1e-8)
    assert ends[0] == pytest.approx(ends[1], rel=2e-4)
    assert np.isclose(paths[0].load_factor[-1], 0.2924, atol=2e-4)


def test_a_very_small_imperfection_is_no_rounding():
    """An opening that is wrong by 2e-8 rad parts the paths by 1e-4, as rounding may: the force that does it tells."""
    model = arch(8, 4, OPENING - 2e-8)
    path = pressed(model, middle(model))
    assert "near 0.48" in flat(path.report())
    assert len(path.bifurcations) == 2


def test_a_limit_point_parts_no_path():
    """An arch of two hinges whose symmetric path ends at its limit load, with the sway bifurcation on the way.

    Independent formulation: half of the arch. No point is found nearer to the limit load than 2e-8 of it, and the path
    turns there: it was told to turn off beside another one."""
    steel, strip = vr.Material(2e11, 0.3, 7850.0), vr.Rectangle(0.1, 0.01)
    loads = []
    for angle in (2.0, 1.0):
        model = vr.Model()
        s, c = np.sin(1.0), np.cos(1.0)
        given = {"section": strip, "material": steel, "d1": (0, 0, 1), "elements": int(8 * angle), "order": 5}
        model.add("arch", vr.Rod.arc((-s, c, 0), (c, s, 0), (s, -c, 0), 1.0, angle, **given))
        hinge = ("ux", "uy", "uz", "rx", "ry")
        model.support("arch.start", hinge)
        model.support("arch.end", hinge if angle == 2.0 else ("ux", "uz", "rx", "ry", "rz"))
        model.force("arch@1.0", (0, -angle * 1e4, 0))
        path = model.path(limit_point=1)
        assert "which it does not meet" not in flat(path.report())
        loads.append(path.limit_points[0])
    assert loads[0] == pytest.approx(loads[1], rel=1e-7)

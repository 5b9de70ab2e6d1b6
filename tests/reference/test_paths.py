"""Paths of equilibria by arc length: buckling, post-buckling and snap-through, constrained and shearable."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

import viscorod as vr
from helpers.pictures import written
from helpers.plain_text import flat

from .cases import cantilever, stiff

EULER = np.pi**2 / 4
INERTIA = [1, 1, 1, 1e-3, 1e-3, 2e-3]
KINDS = pytest.mark.parametrize("kind", ["kirchhoff", "stiff"])


def section(kind, sideways=1.0):
    """Bending stiffness 1 in the plane; a stiff section errs by 1e-6 where a Kirchhoff rod is exact."""
    large = 1.0 if kind == "kirchhoff" else 1e7
    return vr.StiffnessSection([large, large, large, sideways, 1.0, 1.0], INERTIA)


def held(kind):
    return {"constraints": "kirchhoff"} if kind == "kirchhoff" else {}


def column(kind, ends, sideways=5.0, elements=4, order=5):
    """A column of length 1 along x that bends about d2, that is in xz, more easily."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0),
        (1, 0, 0),
        section=section(kind, sideways),
        d1=(0, 0, 1),
        elements=elements,
        order=order,
        **held(kind),
    )
    model.add("column", rod)
    if ends == "pinned":
        model.support("column.start", ("ux", "uy", "uz", "rx"))
        model.support("column.end", ("uy", "uz"))
    else:
        model.clamp("column.start")
    if ends == "clamped":
        model.guide("column.end", along=(1, 0, 0))
    return model


@KINDS
@pytest.mark.parametrize(("ends", "factor"), [("clamped-free", 0.25), ("pinned", 1.0), ("clamped", 4.0)])
def test_euler_loads_are_bifurcations(ends, factor, kind):
    """A7: the path along the straight column finds the load to 1e-5 (mesh: 2e-6 for the clamped one) and goes on."""
    model = column(kind, ends)
    model.force("column.end", (-factor * np.pi**2, 0, 0))
    path = model.path(load_factor=1.3)
    assert path.bifurcations == pytest.approx([1.0], abs=1e-5)
    assert path.limit_points.size == 0
    negative = path.data["negative_eigenvalues"].values
    assert negative.tolist() == sorted(negative.tolist())
    assert (negative[0], path.negative_eigenvalues, path.load_factor[-1]) == (0, 1, 1.3)
    assert np.abs(path.displacement("column@0.5")[1:]).max() < 1e-6


@KINDS
def test_self_weight(kind):
    """A8 (Greenhill): a standing column buckles at 7.8373474 EI/L^2 per length, root of J_-1/3."""
    model = column(kind, "clamped-free")
    model.distributed_force("column", (-7.8373474, 0, 0))
    assert model.path(load_factor=1.2).bifurcations == pytest.approx([1.0], abs=1e-5)


@KINDS
def test_post_buckling(kind):
    """A7, all points of the path from the unloaded shape to 9.1 times the buckling load against elliptic integrals.

    A force of 1e-5 of the buckling load across the column chooses the side; it changes the rotation at the buckling
    load by its third root, so the comparison starts at 20 degrees, where 2e-4 remain.
    """
    model = column(kind, "clamped-free", elements=4, order=6)
    model.force("column.end", (-EULER, 0, 0))
    model.force("column.end", (0, 0, 1e-5 * EULER))
    path = model.path(load_factor=9.11622)
    assert path.limit_points.size == path.bifurcations.size == 0
    assert (path.data["negative_eigenvalues"].values == 0).all()  # the bent branch is stable
    place = path.sites.at("column.end")
    tip = place.of(path.field("position"))
    rotation = path.data["rotation"].values[:, place.stations[np.argmax(place.weights)]]
    start = path.data["reference_rotation"].values[place.stations[np.argmax(place.weights)]]
    angle = 2 * np.arccos(np.clip(np.abs(rotation @ start), 0, 1))  # about one axis, below pi
    bent = angle > np.radians(20)
    assert bent.sum() > 20
    modulus = np.sin(0.5 * angle[bent]) ** 2
    K, E = ellipk(modulus), ellipe(modulus)
    assert path.load_factor[bent] == pytest.approx((2 * K / np.pi) ** 2, rel=3e-4)
    assert tip[bent, 0] == pytest.approx(2 * E / K - 1, abs=2e-4)
    assert tip[bent, 2] == pytest.approx(2 * np.sqrt(modulus) / K, abs=2e-4)
    # the last row of the table, whose load is the end of the path
    assert np.degrees(angle[-1]) == pytest.approx(176.0, abs=1e-3)
    assert tip[-1, [0, 2]] == pytest.approx([-0.57721, 0.42144], abs=2e-5)


DEEP = np.radians(215.0)
LIMIT, SAG = (
    8.973090,
    1.137316,
)  # tests.reference.independent.arch, inextensible; DaDeppo and Schmidt 1975: 8.97


def deep_arch(kind, elements=8, order=5):
    """The clamped-hinged arch of 215 degrees, radius 1, that bends in its plane only as far as the path tells."""
    half = 0.5 * DEEP
    rod = vr.Rod.arc(
        (-np.sin(half), np.cos(half), 0),
        (np.cos(half), np.sin(half), 0),
        (np.sin(half), -np.cos(half), 0),
        1.0,
        DEEP,
        section=section(kind),
        elements=elements,
        order=order,
        **held(kind),
    )
    model = vr.Model()
    model.add("arch", rod)
    model.support("arch.start", ("ux", "uy", "uz", "rx", "ry"))
    model.clamp("arch.end")
    model.force(f"arch@{half}", (0, -10.0, 0))
    return model, f"arch@{half}"


@KINDS
def test_deep_arch(kind):
    """The limit load and the sag there, to 2e-5 against shooting, and the path down to negative loads beyond.

    1e-5 is what this mesh leaves, and for the stiff rod what 1e7 in shear and stretch leaves. The whole path is
    followed on a coarser mesh, whose limit load errs by 0.3 %.
    """
    model, crown = deep_arch(kind)
    top = model.path(limit_point=1)
    assert 10 * top.load_factor[-1] == pytest.approx(LIMIT, rel=2e-5)
    assert -top.displacement(crown)[1] == pytest.approx(SAG, rel=1e-4)
    model, crown = deep_arch(kind, 8, 3)
    whole = model.path(place=crown, axis="y", displacement=-1.9)
    assert whole.outcome == "completed"
    assert whole.displacement(crown)[1] == pytest.approx(-1.9, abs=1e-9)
    assert 10 * whole.limit_points[0] == pytest.approx(LIMIT, rel=4e-3)
    assert len(whole.limit_points) == 2
    assert whole.limit_points[1] == whole.load_factor.min() < 0.0
    # out of its plane it buckles much earlier; nothing there leads it off, and the path goes on
    assert len(whole.bifurcations) == 1
    assert np.abs(whole.field("position")[..., 2]).max() < 1e-6
    assert "limit point at" in flat(whole.report())
    assert "bifurcation at" in flat(whole.report())


@pytest.mark.parametrize("held", [(), ("unshearable",), ("shear_1", "shear_2", "bend_1", "bend_2", "twist")])
def test_snap_through_of_a_bar(held):
    """Half of a two-bar truss (von Mises), which stretches only: all points against the closed form, to round-off.

    With h the height of the apex: load = EA (1 - L/L0) h/L. Stretch is linear in the length, so any element is exact.
    """
    half, height, EA = 1.0, 0.3, 100.0
    L0 = np.hypot(half, height)
    model = vr.Model()
    truss = vr.StiffnessSection([100.0, 100.0, EA, 50.0, 50.0, 50.0], INERTIA)
    rod = vr.Rod.straight((0, 0, 0), (half, 0, height), section=truss, elements=2, order=2, constraints=held)
    model.add("bar", rod)
    model.support("bar.start", ("ux", "uy", "uz", "rx", "rz"))
    model.support("bar.end", ("ux",) if "twist" in held else ("ux", "uy", "rx", "rz"))
    model.force("bar.end", (0, 0, -1.0))
    # the way down ends where the load, having grown, shrunk and grown again, is 1
    path = model.path(load_factor=1.0, arc_length=0.05)
    h = height + path.sites.at("bar.end").of(path.field("displacement"))[:, 2]
    L = np.hypot(half, h)
    assert path.load_factor == pytest.approx(EA * (1 / L - 1 / L0) * h, abs=1e-9)
    assert path.load_factor[-1] == 1.0
    assert h[-1] < -height
    top = half * np.sqrt((L0 / half) ** (2 / 3) - 1)  # where d(load)/dh = 0
    assert path.limit_points[0] == pytest.approx(EA * (1 / np.hypot(half, top) - 1 / L0) * top, rel=1e-7)
    assert path.limit_points[1] == pytest.approx(-path.limit_points[0], rel=1e-6)
    negative = path.data["negative_eigenvalues"].values
    between = np.arange(negative.size)
    first, second = path.special_points("limit_points")
    assert (negative[between < first] == 0).all()
    assert (negative[(between > first) & (between < second)] == 1).all()
    assert (negative[between > second] == 0).all()


def test_no_load_no_path():
    with pytest.raises(vr.InputError, match="no path to follow"):
        cantilever(stiff(1e4, 1e5, 1.0, 0.7)).path()


def test_points_and_arc_length():
    """A path has no more points than asked for, says so, and no two of them are farther apart than asked for."""
    model, _ = deep_arch("kirchhoff", 4, 5)
    path = model.path(points=12, arc_length=0.05)
    assert path.outcome == "points"
    assert "give more points" in flat(path.report())
    assert len(path.load_factor) == 12
    assert np.abs(np.diff(path.load_factor)).max() <= 0.05
    assert path.load_factor[0] == 0.0
    assert path.data.sizes["load_factor"] == 12


def test_path_and_equilibrium_agree():
    """The state at a load factor does not depend on the way: forces, shape, reactions, energy."""

    def bent(kind):
        model = cantilever(stiff(1e4, 1e5, 1.0, 0.7), elements=3, order=4)
        model.force("beam.end", (-1.0, 2.0, 1.0))
        model.moment("beam.end", (0.5, 0, 0.3), following=True)
        return getattr(model, kind)(load_factor=1.5)

    direct, path = bent("equilibrium"), bent("path")
    assert path.load_factor[-1] == direct.load_factor[-1] == 1.5
    assert path.position("beam.end") == pytest.approx(direct.position("beam.end"), abs=1e-9)
    assert path.elastic_energy == pytest.approx(direct.elastic_energy, rel=1e-9)
    assert path.reactions.values == pytest.approx(direct.reactions.values, abs=1e-7)


def test_saved_path_says_the_same(tmp_path):
    model, _ = deep_arch("kirchhoff", 4, 4)
    path = model.path(limit_point=1)
    loaded = vr.load(path.save(tmp_path / "path.nc"))
    assert loaded.limit_points == pytest.approx(path.limit_points)
    assert loaded.report() == path.report()
    assert written(loaded.plot, tmp_path / "path.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"place": "beam.end"}, "belong together"),
        ({"place": "beam.end", "axis": "w", "displacement": 1.0}, "axis"),
        ({"place": "bean.end", "axis": "y", "displacement": 1.0}, "bean"),
        ({"points": 1}, "points"),
        ({"arc_length": 0.0}, "arc_length"),
        ({"limit_point": 0}, "limit_point"),
    ],
)
def test_wrong_settings(wrong, text):
    model = cantilever(stiff(1e4, 1e5, 1.0, 0.7))
    model.force("beam.end", (0, 1.0, 0))
    with pytest.raises(vr.InputError, match=text):
        model.path(**wrong)

"""Critical loads: linear and exact, with prestress."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import airy

import viscorod as vr
from helpers.plain_text import flat

INERTIA = [1, 1, 1, 1e-3, 1e-3, 2e-3]


def column(stiff=1e7):
    """A clamped column of length 1 with bending stiffness 1 in xz, 5 across."""
    section = vr.StiffnessSection([stiff, stiff, stiff, 5.0, 1.0, 1.0], INERTIA)
    model = vr.Model()
    model.add(
        "column", vr.Rod.straight((0, 0, 0), (1, 0, 0), d1=(0, 0, 1), section=section, elements=4, order=5)
    )
    return model


def hinged_column(**kinds):
    section = vr.StiffnessSection([1.0, 1.0, 1.0, 5.0, 1.0, 1.0], INERTIA)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), d1=(0, 0, 1), section=section, elements=4, order=5, **kinds)
    model.add("column", rod)
    model.support("column.start", ("ux", "uy", "uz", "rx"))
    model.support("column.end", ("uy", "uz"))
    model.force("column.end", (-(np.pi**2), 0, 0))
    return model


def test_euler_loads_in_both_planes():
    """A7: a Kirchhoff column between hinges buckles at 1, 4, 9 and, stiffer across, at 5 times pi^2 EI/L^2."""
    found = hinged_column(constraints="kirchhoff").buckling(count=4)
    assert found.load_factors == pytest.approx([1.0, 4.0, 5.0, 9.0], rel=2e-6)
    assert found.linear == pytest.approx([1.0, 4.0, 5.0, 9.0], rel=1e-5)
    assert not found.limit.any()
    assert found.complete
    assert not found.warnings
    assert found.errors.max() < 1e-5
    s = found.positions[0][:, 0]
    first, across = found.shapes[0], found.shapes[2]
    assert first[:, 2] == pytest.approx(np.sin(np.pi * s) * first[len(s) // 2, 2], abs=1e-5)
    assert np.abs(first[:, 1]).max() < 1e-6
    assert across[:, 1] == pytest.approx(np.sin(np.pi * s) * across[len(s) // 2, 1], abs=1e-5)


@pytest.mark.parametrize(("push", "right"), [(0.1, [1.0]), (20.0, [])])
def test_a_column_that_is_pushed_sideways_gives_way_without_a_critical_load(push, right):
    """A7: near pi^2 EI/L^2; one that is pushed so hard that it hardly feels the force along it does not."""
    model = column(stiff=1e5)
    model.support("column.start", ("ux", "uy", "uz", "rx"))
    model.support("column.end", ("uy", "uz"))
    model.force("column.end", (-(np.pi**2), 0, 0))
    model.force("column@0.5", (0.0, 0.0, push), name="push")
    found = model.buckling(1, constant=["push"])
    told = re.findall(r"near the load factor ([\d.]+) the model gives way", " ".join(found.warnings))
    assert [float(value) for value in told] == pytest.approx(right, rel=0.03)


@pytest.mark.parametrize("exact", [True, False])
def test_a_column_as_stiff_both_ways_loses_both_stiffnesses_at_once(exact):
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 1.0, 1.0, 1.0], INERTIA)
    model = vr.Model()
    model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=3, order=5))
    model.clamp("column.start")
    model.force("column.end", (-1.0, 0, 0))
    found = model.buckling(count=2, exact=exact)
    assert found.load_factors == pytest.approx([np.pi**2 / 4] * 2, rel=2e-6)
    across = found.shapes[:, -1, 1:]
    assert abs(np.linalg.det(across)) > 0.1


def test_weight_as_prestress():
    """EI theta'' + (P + q (L - s)) theta = 0 with theta(0) = 0 and theta'(L) = 0: Airy functions; q = 0 is Euler's."""
    weight = 3.0

    def open_end(load, weight=weight):
        # with z = -(P + q (1 - s))/q^(2/3) the equation is theta'' = z theta
        root = weight ** (1.0 / 3.0)
        foot, top = -(load + weight) / root**2, -load / root**2
        ai, _, bi, _ = airy(foot)
        _, dai, _, dbi = airy(top)
        return ai * dbi - bi * dai

    model = column()
    model.clamp("column.start")
    model.distributed_force("column", (-weight, 0, 0), name="weight")
    model.force("column.end", (-1.0, 0, 0))
    expected = brentq(open_end, 1.0, 2.0, xtol=1e-12)
    found = model.buckling(count=1, constant=["weight"])
    assert found.load_factors == pytest.approx([expected], rel=2e-6)
    assert found.linear == pytest.approx([expected], rel=2e-6)
    alone = model.buckling(count=1, constant=["force"])
    assert expected < np.pi**2 / 4
    heaviest = brentq(lambda heavy: open_end(1.0, heavy), 4.0, 7.8, xtol=1e-12)
    assert alone.load_factors == pytest.approx([heaviest / weight], rel=2e-6)


@pytest.mark.parametrize(("force", "expected"), [(1.0, 1.084089), (-1.0, 0.678929)])
def test_lateral_buckling_of_a_right_angle_frame(force, expected):
    """B2 (Argyris 1979), exact prebuckling state and torsion constant: zero of its 2 x 2 Jacobian out of the plane."""
    model = angle_frame((0.24, 0, 0), (0.24, -0.24, 0))
    model.clamp("first.start")
    model.force("second.end", (force, 0, 0))
    found = model.buckling(count=1)
    assert found.load_factors == pytest.approx([expected], rel=2e-6)
    assert 1e-4 < abs(found.linear[0] / expected - 1.0) < 1e-3  # the frame bends a little before it buckles
    assert np.abs(found.shapes[0][:, 2]).max() == 1.0


@pytest.mark.parametrize("couple", [1.0, -1.0])
def test_hinged_right_angle_frame_under_end_couples(couple):
    """Argyris 1979: 622.21 N mm with the torsion constant h t^3/3; critical couples of both signs are equal.

    The couple goes with the root of the torsional stiffness, of which a strip of these sides has 1 - 0.63 t/h.
    """
    half = 0.24 * np.sqrt(0.5)
    model = angle_frame((half, half, 0), (2 * half, 0, 0))
    model.support("first.start", ("ux", "uy", "uz", "rx", "ry"))
    model.support("second.end", ("uy", "uz", "rx", "ry"))
    model.moment("first.start", (0, 0, couple))
    model.moment("second.end", (0, 0, -couple))
    found = model.buckling(count=1)
    expected = 0.62221 * np.sqrt(1.0 - 0.63025 * 0.0006 / 0.030)
    assert found.load_factors == pytest.approx([expected], rel=1e-4)


def angle_frame(corner, end):
    material = vr.Material(71240e6, 0.31, 2700.0)
    section = vr.Rectangle(0.0006, 0.030)
    model = vr.Model()
    for name, ends in (("first", ((0, 0, 0), corner)), ("second", (corner, end))):
        rod = vr.Rod.straight(*ends, d1=(0, 0, 1), section=section, material=material, elements=4)
        model.add(name, rod)
    model.attach("second.start", "first.end")
    return model


def test_an_arch_snaps_after_it_has_branched_off():
    """DaDeppo and Schmidt 1975: the limit load of the clamped and hinged arch is 8.97 EI/R^2."""
    angle = np.radians(215.0)
    half = angle / 2
    ends = (
        (-np.sin(half), np.cos(half), 0),
        (np.cos(half), np.sin(half), 0),
        (np.sin(half), -np.cos(half), 0),
    )
    section = vr.StiffnessSection([1.0] * 6, [1.0] * 6)
    rod = vr.Rod.arc(*ends, 1.0, angle, section=section, elements=6, order=5, constraints="kirchhoff")
    model = vr.Model()
    model.add("arch", rod)
    model.support("arch.start", ("ux", "uy", "uz", "rx", "ry"))
    model.clamp("arch.end")
    model.force(f"arch@{half}", (0, -1.0, 0))
    found = model.buckling(count=2)
    assert found.limit.tolist() == [False, True]
    assert found.load_factors[1] == pytest.approx(8.97, abs=0.005)


@pytest.mark.parametrize("constraints", [(), "kirchhoff"])
def test_a_twisted_shaft_between_clamps_buckles(constraints):
    """Greenhill 1883: EI w_ssss = i M w_sss, w = w_s = 0 at both ends, so tan(M L/2EI) = M L/2EI: 8.98682 EI/L."""
    section = vr.StiffnessSection([1e8, 1e8, 1e8, 1.0, 1.0, 0.8], INERTIA)
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, constraints=constraints)
    model = vr.Model()
    model.add("shaft", rod)
    model.clamp("shaft.start")
    model.support("shaft.end", ("uy", "uz", "ry", "rz"), motion={"rx": 1.0})
    found = model.buckling(count=1)
    torque = 2.0 * brentq(lambda x: np.sin(x) - x * np.cos(x), 4.0, 4.6, xtol=1e-12)
    assert 0.8 * found.load_factors == pytest.approx([torque] * 2, rel=2e-4)
    assert 0.8 * found.linear == pytest.approx([torque], rel=5e-4)


def test_a_strip_that_bends_before_it_buckles_sideways():
    """Prandtl 1899: P L^2 = 4.0126 sqrt(EI GJ) if it is stiff the other way, here a hundred times as stiff."""
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 100.0, 1.0, 1.0], INERTIA)
    model = vr.Model()
    model.add("strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), d1=(0, 1, 0), section=section))
    model.clamp("strip.start")
    model.force("strip.end", (0, 0, -1.0))
    found = model.buckling(count=1)
    assert found.linear == pytest.approx([4.0125993], rel=1e-5)
    assert found.load_factors == pytest.approx([4.0125993], rel=0.02)


def test_a_strip_that_bends_much_before_it_buckles_beyond_twice_the_linear_load():
    """Nearly as stiff both ways, it sags before it leaves its plane; an inertia count says where stiffness is lost."""

    def strip():
        section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.6, 1.0], INERTIA)
        model = vr.Model()
        model.add("strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), d1=(0, 0, 1), section=section))
        model.clamp("strip.start")
        model.support("strip.end", ("uy", "uz", "rx", "rz"))
        model.force("strip@0.5", (0, 0, -1.0))
        return model

    found = strip().buckling(count=1)
    (critical,) = found.load_factors
    assert critical > 2.0 * found.linear[0]
    assert np.abs(found.shapes[0, :, 1]).max() == 1.0
    for part, count in ((0.999, 0), (1.001, 1)):
        near = strip().equilibrium(load_factor=part * critical, search=False)
        assert near.negative_eigenvalues == count


def test_springs_under_load_count():
    """A stiff bar on a ball, on two springs k at 45 degrees: k = P (k/2 + EA/L)/(k + EA/L)."""
    k, axial = 1000.0, 1e4
    section = vr.StiffnessSection([1e8, 1e8, axial, 1e7, 1e7, 1e7], INERTIA)
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section))
    model.support("bar.start", ("ux", "uy", "uz", "rz"))
    for anchor in ((1, 0, 0), (-1, 0, 0)):
        model.line_spring("bar.end", anchor, stiffness=k)
    model.spring("bar.end", stiffness={"uy": 1e6})
    model.force("bar.end", (0, 0, -1.0))
    found = model.buckling(count=1, exact=False)
    assert found.linear == pytest.approx([k * (axial + k) / (0.5 * k + axial)], rel=1e-4)


def test_fewer_than_asked_for_are_told():
    """Beck's column has no other equilibrium (Beck 1952)."""
    model = column()
    model.clamp("column.start")
    model.force("column.end", (0, 0, -1.0), following=True)
    found = model.buckling(count=2)
    assert found.load_factors.size == found.linear.size == 0
    assert not found.complete
    text = flat(found.report())
    assert "followed to the load factor 2 and keep their stiffness up to there" in text
    assert "oscillations may grow" in text
    assert "model.stability" in text


def test_flutter_before_any_loss_of_stiffness_is_told():
    """Beck's column (1952) flutters at 20.051 EI/L^2; here loads grow to 2 x 12 EI/L^2."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 5.0, 1.0], [1, 1, 1, 1e-7, 1e-7, 2e-7])
    model.add("column", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section))
    model.clamp("column.start")
    model.force("column.end", (0, 0, -12.0), following=True)
    (told,) = model.buckling(count=1).warnings
    factor = re.search(r"oscillations grow from the load factor ([\d.]+) on", told)
    assert 12.0 * float(factor[1]) == pytest.approx(20.051, rel=1e-3)


def test_refusals():
    model = column()
    model.clamp("column.start")
    with pytest.raises(vr.InputError, match="no load or prescribed motion grows"):
        model.buckling()
    model.force("column.end", (-1.0, 0, 0), name="thrust")
    with pytest.raises(vr.InputError, match=r"constant\[0\].*'thrsut'.*did you mean 'thrust'"):
        model.buckling(constant=["thrsut"])
    with pytest.raises(vr.InputError, match="no load or prescribed motion grows"):
        model.buckling(constant=["thrust"])
    loose = column()
    loose.force("column.end", (-1.0, 0, 0))
    with pytest.raises(vr.InputError, match="nothing holds the model"):
        loose.buckling()


def test_critical_loads_are_kept_drawn_and_told(tmp_path):
    """As they were found, from the file; a case file with a table and the command give the same."""
    from typer.testing import CliRunner

    from viscorod.casefile.shipped import shipped_case
    from viscorod.cli.app import app

    done = CliRunner().invoke(
        app, ["buckling", str(shipped_case("tall_rod")), "-o", str(tmp_path), "--count", "2"]
    )
    assert done.exit_code == 0, done.output
    found = vr.load(tmp_path / "buckling.nc")
    assert isinstance(found, vr.Buckling)
    assert found.report() in done.output
    assert found.load_factors == pytest.approx([1.017725] * 2, rel=3e-6)
    assert found.complete
    assert found.exact
    assert found.errors.max() < 1e-6
    assert found.positions.shape == found.shapes.shape == found.rotations.shape
    assert found.history("rod.end")[0, 2] == pytest.approx(5.0, rel=1e-6)
    assert (tmp_path / "buckling.png").stat().st_size > 10_000
    model = column()
    model.clamp("column.start")
    model.force("column.end", (0, 0, -1.0), following=True)
    none = vr.load(model.buckling(count=1).save(tmp_path / "none.nc"))
    with pytest.raises(vr.InputError, match="no critical loads were found"):
        vr.view(none, tmp_path / "page.html")
    assert "none were found" in flat(none.report())
    none.plot(tmp_path / "none.png")


def test_a_heated_bar_between_clamps():
    """Closed form: 4 pi^2 (EI/EA)/L^2 of free growth, since the bar stays straight and as long as it is."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 30.0, 1.0], [1.0, 1.0, 1.0, 1e-6, 1e-6, 2e-6])
    model = vr.Model()
    bar = vr.Rod.straight(
        (0, 0, 0), (0, 0, 1), section=section, elements=4, order=6, constraints="unshearable"
    )
    model.add("bar", bar)
    model.clamp("bar.start")
    model.clamp("bar.end")
    model.rest_strain("bar", (0, 0, 1e-6, 0, 0, 0))
    found = model.buckling(count=1)
    assert found.linear[0] == pytest.approx(4.0 * np.pi**2, rel=1e-6)
    assert found.load_factors[0] == pytest.approx(4.0 * np.pi**2, rel=1e-6)
    # the motions of the bar tell the same, also where a pivot is exactly zero on the way to the limit
    (limit,) = model.stability(band=(30.0, 45.0), count=3, modes=1).limits
    assert (limit.kind, limit.at) == ("divergence", pytest.approx(4.0 * np.pi**2, rel=1e-6))


def test_critical_loads_at_strains_of_no_material_are_told():
    """A pulled bar loses stiffness where N (1/kGA - 1/EA) = 1, in shear: the limit of a short half wave (Haringx)."""
    model, section = vr.Model(), vr.StiffnessSection([1.0, 1.0, 2.0, 1e-6, 1e-6, 1e-6])
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    model.clamp("bar.start")
    model.force("bar.end", (1.0, 0, 0))
    found = model.buckling(1)
    assert found.load_factors[0] == pytest.approx(2.0, rel=5e-3)
    assert "stretch is 1" in found.warnings[0]


def bent_strip():
    """A strip on edge under moments about fixed axes at both ends, without anything that holds its twist."""
    steel = vr.Material(2.1e11, 0.3, 7850.0)
    model = vr.Model()
    section = vr.Rectangle(0.001, 0.02)
    ends = ((0, 0, 0), (1, 0, 0))
    rod = vr.Rod.straight(*ends, d1=(0, 1, 0), section=section, material=steel, elements=2, order=5)
    model.add("strip", rod)
    model.moment("strip.start", (0, 1.0, 0))
    model.moment("strip.end", (0, -1.0, 0))
    return model, 0.35, 140.0, steel.shear_modulus * section.torsion()


def left_open(moment, sideways, on_edge, twist, share):
    """Return what small motions about a bent strip leave open at its end; they are possible where it is zero.

    Independent of rods of finite elements: the frame turns by phi = M s/EI about y, and of the small rotation w,
    GJ (w'.d3) d3 + EI (w'.d2) d2 + w x M e_y is the moment that the ends and their lateral reactions make; u' = w x d3.
    Each end holds its deflection u and the rotation about an axis that is turned by a ``share`` of phi: 0 for one that
    stands still, 1 for the strip's own.
    """
    ends = 0.5 * moment / on_edge * np.array([-1.0, 1.0])
    held = np.column_stack([np.cos(share * ends), -np.sin(share * ends)])
    # columns: a rotation that is free at the start, the moment and the lateral force that it is held by
    reaction = np.outer(held[0], [0.0, 1.0, 0.0])
    force = np.array([0.0, 0.0, 1.0])

    def slope(s, y):
        wx, wz, _, x, z = y.reshape(5, 3)
        phi = moment / on_edge * (s - 0.5)
        d3, d2 = np.array([np.cos(phi), -np.sin(phi)]), np.array([np.sin(phi), np.cos(phi)])
        m = reaction + force * np.array([-z, x]) - moment * np.array([-wz, wx])
        turning = np.outer(d3, d3 @ m) / twist + np.outer(d2, d2 @ m) / sideways
        return np.vstack([turning, wz * d3[0] - wx * d3[1], np.outer(d3, np.ones(3))]).ravel()

    start = np.zeros((5, 3))
    start[:2, 0] = -held[0, 1], held[0, 0]
    way = solve_ivp(slope, (0, 1), start.ravel(), "DOP853", rtol=1e-10, atol=1e-12).y[:, -1].reshape(5, 3)
    m = reaction + force * np.array([-way[4], way[3]])
    return np.linalg.det([held[1] @ way[:2], way[2], m[0] * held[1, 1] - m[1] * held[1, 0]])


def test_what_holds_the_twist_of_a_bent_strip_matters():
    """Prandtl 1899, with what bending before takes off: two ways to hold the ends, beside the small motions solved.

    A fork goes with the strip: the moment is Prandtl's over sqrt((1 - EI1/EI2)(1 - GJ/EI2)). A rotation that is held as
    ``rx`` is a component of the rotation vector, about an axis half way between the fixed one and the strip.
    """
    model, *numbers = bent_strip()
    model.support("strip.start", ("ux", "uy", "uz", "rx"))
    model.support("strip.end", ("uy", "uz", "rx"))
    found = model.buckling(count=1, about=1.3).load_factors[0]
    assert (
        left_open(found * (1.0 - 1e-6), *numbers, 0.5) * left_open(found * (1.0 + 1e-6), *numbers, 0.5) < 0.0
    )
    model, *numbers = bent_strip()
    axes = ((0, 0, 1), (0, 1, 0))
    model.add("block", vr.Body.sphere((1, 0, 0), 0.02, mass=1.0))
    model.universal("strip.start", "ground", axes)
    model.universal("strip.end", "block", axes)
    model.prismatic("block", "ground", axis=(1, 0, 0))
    found = model.buckling(count=1, about=1.3).load_factors[0]
    assert (
        left_open(found * (1.0 - 1e-6), *numbers, 1.0) * left_open(found * (1.0 + 1e-6), *numbers, 1.0) < 0.0
    )
    sideways, on_edge, twist = numbers
    prandtl = np.pi * np.sqrt(sideways * twist)
    fork = prandtl / np.sqrt((1.0 - sideways / on_edge) * (1.0 - twist / on_edge))
    assert found == pytest.approx(fork, rel=1e-6)


def test_a_clamped_arch_under_pressure_from_outside():
    """Closed form: (k^2 - 1) EI/R^3 with k tan a = tan k a (Timoshenko and Gere, 7.6)."""
    half = np.radians(60.0)
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 1.0, 400.0, 1.5], INERTIA)
    tangent, normal = (np.cos(half), 0, np.sin(half)), (np.sin(half), 0, -np.cos(half))
    model = vr.Model()
    rod = vr.Rod.arc(
        (-np.sin(half), 0, 0),
        tangent,
        normal,
        1.0,
        2.0 * half,
        d1=(0, 1, 0),
        section=section,
        elements=6,
        order=5,
    )
    model.add("arch", rod)
    model.clamp("arch.start")
    model.clamp("arch.end")
    model.distributed_force("arch", (0, -1.0, 0), following=True)  # d2 = d3 x d1 points outwards
    found = model.buckling(count=1)
    k = brentq(lambda k: k * np.tan(half) - np.tan(k * half), 4.3, 4.45)
    assert found.load_factors == pytest.approx([k**2 - 1.0], rel=2e-5)


def test_critical_loads_that_are_passed_as_the_load_falls_are_told_to_be():
    """They are in the order of the way of the equilibria, in which a load that grows comes to the first one first."""
    linear = hinged_column(constraints="kirchhoff").buckling(count=3, exact=False)
    found = type(linear)(linear.data.assign_attrs(buckling_exact=1))
    assert "the load falls" not in flat(found.report())
    fallen = type(found)(found.data.assign(critical_load=("critical", [3.2, 3.3, 2.7])))
    assert "number 3 is passed there, at a smaller load" in flat(fallen.report())


def test_turns_of_a_spring_that_would_touch_are_told():
    """The told gap is that of positions 1/200 of a turn apart, looked at all around the next turn."""
    steel = vr.Material(2.06e11, 0.3, 7850.0)
    helix = vr.Rod.helix(0.01, 0.012, 8.0, section=vr.Circle(0.001), material=steel, elements=16, order=4)
    for pressed, told in ((-0.05, False), (-0.09, True)):
        model = vr.Model()
        model.add("spring", helix)
        model.clamp("spring.start")
        model.clamp("spring.end", motion={"uz": pressed})
        found = model.equilibrium(search=False)
        texts = [text for text in found.warnings if "its turns come as near as" in text]
        assert len(texts) == told
        places = found.probe("spring", s=np.linspace(0.0, helix.length, 1601))["position"].values[-1]
        gap = min(np.linalg.norm(places[k + 150 : k + 251] - places[k], axis=1).min() for k in range(1401))
        assert (gap < 0.99 * 0.002) == told
        for text in texts:
            assert float(re.search("as near as ([0-9.e-]+) m", text)[1]) == pytest.approx(gap, abs=2e-5)


def test_turns_that_touch_in_a_motion_are_told(tmp_path):
    """A spring that is held pressed, and let go at once, has touching turns at its start alone."""
    steel = vr.Material(2.06e11, 0.3, 7850.0)
    model = vr.Model()
    section = vr.Circle(0.001)
    model.add("spring", vr.Rod.helix(0.01, 0.012, 3.0, section=section, material=steel, elements=6, order=4))
    model.clamp("spring.start")
    model.support("spring.end", ("ux", "uy", "rx", "ry", "rz"))
    model.force("spring.end", (0, 0, -220.0), until=0.0)
    for folder in (None, tmp_path / "run"):
        with pytest.warns(vr.AccuracyWarning, match="its turns come as near as"):
            run = model.simulate(2e-4, folder=folder)
        assert [text.partition(" its turns")[0] for text in run.warnings if "come as near" in text] == [
            "rod spring: at 0 s"
        ]

"""Assemblies that cannot be solved end in one message each; open joints are closed by the static solution."""

from __future__ import annotations

import pytest

import viscorod as vr

SECTION = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 1e3], [1, 1, 1, 1e-3, 1e-3, 2e-3])
ALL_STRAINS = ["shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"]


def four_bar(constraints):
    """Three bars and the ground on four parallel hinges."""
    model = vr.Model()
    corners = [(0, 0, 0), (0, 1, 0), (2, 1, 0), (2, 0, 0)]
    for name, start, end in zip("abc", corners[:-1], corners[1:], strict=True):
        rod = vr.Rod.straight(start, end, section=SECTION, elements=1, order=2, constraints=constraints)
        model.add(name, rod)
    ends = ["ground", "a.start", "a.end", "b.start", "b.end", "c.start", "c.end", "ground"]
    for name, first, second in zip("ABCD", ends[::2], ends[1::2], strict=True):
        model.revolute(first, second, (0, 0, 1), name=name)
    return model


def hinged(gap, **given):
    """Two rods, each clamped at its far end, with a ball joint between their near ends, which are ``gap`` apart."""
    model = vr.Model()
    model.add("a", vr.Rod.straight((0, 0, 0), (0, 1, 0), section=SECTION, elements=1, order=3, **given))
    model.add("b", vr.Rod.straight((0, 1 + gap, 0), (2, 1 + gap, 0), section=SECTION, elements=1, order=3))
    model.clamp("a.start")
    model.clamp("b.end")
    model.ball("b.start", "a.end", name="hinge")
    return model


def test_parallel_hinges_of_rigid_bars_are_redundant():
    """A rigid four-bar moves in its plane: the last hinge holds three motions that the others hold already."""
    with pytest.raises(
        vr.InputError, match=r"joint D, uz: .*held already by .*joint A; joint B; joint C"
    ) as refused:
        four_bar(ALL_STRAINS).simulate(0.1, initial="reference")
    assert "kind 'general'" in str(refused.value)


def test_straight_rod_that_does_not_stretch_between_two_pins():
    model = vr.Model()
    model.add("r", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=SECTION, constraints="inextensible"))
    model.pin("r.start")
    model.pin("r.end")
    with pytest.raises(vr.InputError, match=r"rod r, which holds its stretch: .*the support of r.start"):
        model.equilibrium()


def test_open_joint_needs_the_equilibrium():
    with pytest.raises(vr.InputError, match=r"joints are open in the reference shape: hinge, uy by 0\.05 m"):
        hinged(0.05).simulate(0.1, initial="reference")


def test_static_solution_closes_joints():
    """The ends meet; the energy is that of two springs in series, to first order in the gap."""
    found = hinged(0.01).equilibrium()
    assert found.position("a.end") == pytest.approx(found.position("b.start"), abs=1e-12)
    bending, shear, stretch = 2.0**3 / (3 * 1e3), 2.0 / 1e6, 1.0 / 1e6
    assert found.elastic_energy == pytest.approx(0.5 * 0.01**2 / (bending + shear + stretch), rel=1e-3)


def test_start_that_nothing_can_close():
    """Both sides are held completely: by how much the joint is open is said."""
    model = hinged(0.05, constraints=ALL_STRAINS)
    model.clamp("b.start")
    with pytest.raises(
        vr.InputError, match=r"joint hinge, ux: .*held already by .*; the joint is open there, uy by 0\.05 m"
    ):
        model.equilibrium()

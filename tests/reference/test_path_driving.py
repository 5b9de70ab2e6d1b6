"""Paths driven by prescribed motions, by motors, and by reference loads of any size; branches at bifurcations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import viscorod as vr
from helpers.plain_text import flat

STEEL = vr.Material(2e11, 0.3, 7850.0)


def strip(**load):
    """A steel strip between clamps that are pushed together by 5 % of its length."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), d1=(0, 1, 0), section=vr.Rectangle(0.001, 0.02), material=STEEL, elements=4
    )
    model.add("strip", rod)
    model.clamp("strip.start")
    model.clamp("strip.end", motion={"ux": -0.05})
    for place, value in load.items():
        model.force(f"strip@{place}", value)
    return model


def clamped_elastica(shortening):
    """Rise and force of a clamped inextensible strip: 2 E/K - 1 = 1 - shortening, rise k L/K, P = (4 K/L)^2 EI."""
    m = brentq(lambda m: 2.0 * ellipe(m) / ellipk(m) - 1.0 - (1.0 - shortening), 1e-9, 0.9)
    return np.sqrt(m) / ellipk(m), (4.0 * ellipk(m)) ** 2 * 2e11 * 0.02 * 0.001**3 / 12.0


def test_progress_of_a_path_is_that_of_what_ends_it(capsys):
    """A load of 1 N at the apex of a shallow truss rises, falls and rises again, its displacement goes one way."""
    model = vr.Model()
    bar = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 1e3])
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0.1, 0), section=bar, elements=1, order=3))
    model.support("bar.start", fixed=["ux", "uy", "uz", "rx", "ry"])
    model.support("bar.end", fixed=["ux", "uz", "rx", "ry"])
    model.force("bar.end", (0, -1.0, 0))
    seen = []
    given = {"place": "bar.end", "axis": "y", "displacement": -0.05}
    path = model.path(**given, progress=lambda reached, step: seen.append((reached, step)))
    reached, steps = np.array(seen).T
    assert reached == pytest.approx(path.history("bar.end", "displacement").values[:, 1], abs=1e-15)
    assert np.cumsum(steps) == pytest.approx(reached, abs=1e-15)
    model.path(**given, progress=True)
    assert capsys.readouterr().err.startswith("displacement = -0.05 of -0.05 m, step -")


@pytest.mark.parametrize("branch", [1, -1])
def test_buckling_by_end_shortening_onto_the_branch(branch):
    """The strip shortens by P/EA too, 3e-6: 0.14011 m and 13.50 N."""
    rise, force = clamped_elastica(0.05)
    assert (rise, force) == pytest.approx((0.14011, 13.50), rel=1e-3)
    path = strip().path(branch=branch)
    assert path.bifurcations[0] * 0.05 == pytest.approx(np.pi**2 * 0.001**2 / 3.0, rel=1e-4)
    assert abs(path.displacement("strip@0.5")[1]) == pytest.approx(rise, rel=1e-4)
    assert path.reactions.values[-1, 0] == pytest.approx(-force, rel=2e-4)
    assert path.stable


def test_buckling_by_end_shortening_with_a_side_load():
    """A thousandth of a newton across it is enough to bow out; it changes the rise by 2e-6 of itself."""
    model = strip()
    model.force("strip@0.5", (0, 1e-3, 0))
    path = model.path(points=400)
    assert path.displacement("strip@0.5")[1] == pytest.approx(clamped_elastica(0.05)[0], rel=1e-4)
    assert path.bifurcations.size == 0
    assert path.stable
    assert "which it does not meet" in flat(path.report())
    assert "mesh_lost" not in path.data.attrs  # near the buckling load the finer mesh is singular elsewhere
    assert 1e-7 < path.data.attrs["mesh_motion_error"] < 1e-3


@pytest.mark.parametrize("radius", [0.005, 0.0002])
def test_path_by_twist(radius):
    """Steel rods; EA is up to 1e14 times the stiffness against bending over one part in 1e8 of the length."""
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(radius), material=STEEL))
    model.clamp("rod.start")
    model.clamp("rod.end", motion={"rx": 1.0})
    path = model.path(load_factors=[0.25, 0.5, 1.0])
    torsion = 2e11 / 2.6 * np.pi * radius**4 / 2.0
    assert path.load_factor[-1] == 1.0
    assert {0.25, 0.5} <= set(path.load_factor)
    assert path.elastic_energy == pytest.approx(0.5 * torsion, rel=1e-8)
    assert path.reactions.values[-1, 3] == pytest.approx(torsion, rel=1e-8)


def truss(load):
    """Half of a shallow two-bar truss, its apex guided."""
    section = vr.StiffnessSection([1e6] * 3 + [1e3] * 3, [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0.1, 0), section=section, elements=1, order=3))
    model.support("bar.start", ("ux", "uy", "uz", "rx", "ry"))
    model.support("bar.end", ("ux", "uz", "rx", "ry"))
    model.force("bar.end", (0, -load, 0))
    return model


@pytest.mark.parametrize("load", [1.0, 200.0, 1e6])
def test_snap_through_does_not_depend_on_the_reference_load(load):
    """P = EA (L0 - L)/L0 (h - v)/L: limit loads of 190.544 N at v = 0.04236 and back, with as many points."""
    path = truss(load).path(place="bar.end", axis="y", displacement=-0.23)
    assert load * path.limit_points == pytest.approx([190.544, -190.544], abs=1e-3)
    assert 25 <= path.load_factor.size <= 40
    v = -path.history("bar.end", "displacement").values[:, 1]
    length, present = np.sqrt(1.01), np.sqrt(1.0 + (0.1 - v) ** 2)
    force = 1e6 * (length - present) / length * (0.1 - v) / present
    assert load * path.load_factor == pytest.approx(force, abs=1e-6)


def test_path_of_a_clamp_that_turns_a_free_rod():
    """A rigid motion: no energy, and the end where the turn takes it."""
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=STEEL))
    model.clamp("rod.start", motion={"rz": 1.0})
    path = model.path()
    assert path.position("rod.end") == pytest.approx([np.cos(1.0), np.sin(1.0), 0.0], abs=1e-9)
    assert path.elastic_energy < 1e-9


@pytest.mark.parametrize("turns", [0.4, 3.0])
@pytest.mark.parametrize("analysis", ["equilibrium", "path"])
def test_a_motor_alone_drives_a_rod(turns, analysis):
    """The motor of a hinge along the rod's axis twists it: torque GJ phi/L."""
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=STEEL))
    model.clamp("rod.start")
    phi = 2.0 * np.pi * turns
    model.revolute("rod.end", "ground", (1, 0, 0), motion={"rz": phi})
    found = getattr(model, analysis)()
    torsion = 2e11 / 2.6 * np.pi * 0.005**4 / 2.0
    assert found.elastic_energy == pytest.approx(0.5 * torsion * phi**2, rel=1e-8)
    assert abs(found.reactions.values[0, 3]) == pytest.approx(torsion * phi, rel=1e-8)


def test_two_bifurcations_within_a_step():
    """Closed form: pi^2 EI/4 (1, 1.1) of a column that is stiffer one way, far below the first step's end."""
    section = vr.StiffnessSection([1e7] * 3 + [1.0, 1.1, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4))
    model.clamp("column.start")
    model.force("column.end", (-(np.pi**2) / 4.0, 0, 0))
    path = model.path(load_factor=4.0, arc_length=20.0)
    assert path.bifurcations == pytest.approx([1.0, 1.1], abs=1e-5)
    assert path.multiplicity.tolist() == [1, 1]
    assert path.negative_eigenvalues == 2


def test_a_double_bifurcation_is_told():
    """A column as stiff both ways buckles in every direction at once."""
    section = vr.StiffnessSection([1e7] * 3 + [1.0, 1.0, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4))
    model.clamp("column.start")
    model.force("column.end", (-(np.pi**2) / 4.0, 0, 0))
    path = model.path(load_factor=1.3)
    assert path.bifurcations == pytest.approx([1.0], abs=1e-5)
    assert path.multiplicity.tolist() == [2]
    assert "2-fold bifurcation" in flat(path.report())


def test_equilibria_at_wanted_load_factors():
    """Exactly these are stored, and each is the equilibrium of its load alone."""
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=STEEL))
    model.clamp("rod.start")
    model.force("rod.end", (0, 50.0, 0))
    steps = model.equilibrium(load_steps=10)
    assert steps.load_factor.tolist() == [k / 10 for k in range(1, 10)] + [1.0]
    factors = [0.25, 1.0, -0.5]
    found = model.equilibrium(load_factors=factors)
    assert found.load_factor.tolist() == factors
    for k, factor in enumerate(factors):
        alone = model.equilibrium(load_factor=factor)
        there = found.history("rod.end", "position").values[k]
        assert there == pytest.approx(alone.position("rod.end"), abs=1e-8)
    with pytest.raises(vr.InputError, match="load_steps"):
        model.equilibrium(load_factors=factors, load_steps=3)


def pressed(force):
    """A bar of EA = 100 N that is pressed along its axis."""
    section = vr.StiffnessSection([100.0, 100.0, 100.0, 1e4, 1e4, 1e4], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    model.clamp("bar.start")
    model.guide("bar.end")
    model.force("bar.end", (-force, 0, 0))
    return model


def test_a_section_pressed_inside_out_is_refused():
    """Under 150 N a linear material would be shorter than nothing."""
    with pytest.raises(vr.SolveError, match=r"pressed through each other.*rod 'bar', element \d, s ="):
        pressed(150.0).equilibrium()
    assert pressed(90.0).equilibrium().position("bar.end")[0] == pytest.approx(0.1, abs=1e-9)


def test_a_failed_equilibrium_keeps_its_last_load_step():
    """Closed form: shortened by P L/EA, up to two thirds of 150 N; the last step before is kept beside the half."""
    shown = []
    with pytest.raises(vr.SolveError) as failed:
        pressed(150.0).equilibrium(load_steps=2, progress=lambda reached, step: shown.append(reached))
    part = failed.value.run
    first, last = part.load_factor
    assert first == 0.5
    assert 0.66 < last < 2.0 / 3.0
    assert shown[-1] == last
    moved = part.history("bar.end", "displacement").values[:, 0]
    assert moved == pytest.approx(-1.5 * part.load_factor, rel=1e-9)

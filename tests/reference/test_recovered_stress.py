"""Stress, strain and loss at the points of a section, of results of all kinds (LLT 2.2 to 2.6)."""

import re

import numpy as np
import pytest

import viscorod as vr
from helpers.paraview_files import states_of
from helpers.pictures import written
from helpers.plain_text import flat
from viscorod.pictures.plots.plot_stress import draw_stress
from viscorod.pictures.viewer import view
from viscorod.results.largest_stress import peak_stresses
from viscorod.results.stress import section_patch

from .independent.solid_bar import bar_stress

pytestmark = pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # steps are few and long

VISCOUS = vr.Material(2e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.001, 0.004))
RELAXING = vr.Material(
    2e6,
    0.3,
    1000.0,
    damping=vr.Prony(shear_ratios=[0.2, 0.5], shear_times=[0.02, 0.2], bulk_ratios=[0.1], bulk_times=[0.05]),
)
SOFT = vr.Material(2e5, 0.45, 1100.0, damping=vr.KelvinVoigt(0.01, 0.04))
LAYERED = vr.Composite(
    [
        vr.CompositeRegion(VISCOUS, vr.Rectangle(0.02, 0.006)),
        vr.CompositeRegion(SOFT, vr.Rectangle(0.02, 0.004), at=(0.0, 0.005)),
    ],
    origin="given",
    mesh_size=0.0015,
)
RECTANGLE = vr.Rectangle(0.01, 0.02)


def swing(section, material=None, integrator="generalized_alpha", rod=None, **more):
    """A cantilever pulled askew, twisted and released."""
    given = {"section": section, "elements": 1, "order": 3, **more}
    if material is not None:
        given["material"] = material
    model = vr.Model()
    model.add("beam", rod(**given) if rod else vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given))
    model.clamp("beam.start")
    model.force("beam.end", (0.002, 0.02, 0.01), until=0.0)
    model.moment("beam.end", (3e-4, 0, 0), until=0.0)
    return model.simulate(0.02, time_step=0.004, integrator=integrator)


def resultants(found):
    """Forces and moments of stresses at the points of the quadrature."""
    area, x, y = (found[name].values for name in ("area", "x1", "x2"))
    s33, s23, s13 = (found.stress.sel(stress_component=name).values for name in ("33", "23", "13"))
    rows = [
        s13 @ area,
        s23 @ area,
        s33 @ area,
        s33 @ (area * y),
        -s33 @ (area * x),
        s23 @ (area * x) - s13 @ (area * y),
    ]
    return np.stack(rows, axis=-1)


@pytest.mark.parametrize(
    ("run", "loss"),
    [
        (lambda: swing(RECTANGLE, VISCOUS), 1e-11),
        (lambda: swing(RECTANGLE, RELAXING), 1e-11),
        (lambda: swing(RECTANGLE, RELAXING, "radau"), 1e-11),  # the springs of the branches are kept
        (lambda: swing(RECTANGLE, VISCOUS, "radau"), 1e-5),  # viscous forces to the tolerance of its steps
        (lambda: swing(LAYERED), 1e-6),  # their smaller part of what carries the load
        (lambda: swing(RECTANGLE, VISCOUS, constraints="kirchhoff"), 1e-11),
        (lambda: swing(vr.Ellipse(0.01, 0.005), VISCOUS, constraints=["twist", "bend_1"]), 1e-11),
        (lambda: swing(RECTANGLE, VISCOUS, rod=bent), 1e-11),
    ],
    ids=["Kelvin-Voigt", "Maxwell", "Maxwell radau", "radau", "layers", "Kirchhoff", "held", "curved"],
)
def test_stresses_have_the_section_forces_and_the_loss_is_that_of_the_run(run, loss):
    """Resultants of the stress, and the loss over section and arc length, at every Gauss point and instant."""
    run = run()
    data = run.data
    power = np.zeros(len(run.time))
    force = data.section_force.values
    size = np.abs(force).max(axis=(0, 1))
    for k, s in enumerate(data.point_s.values.tolist()):
        found = run.stress(f"beam@{s!r}")
        assert resultants(found) / size == pytest.approx(force[:, k] / size, abs=1e-10)
        own = found.loss_density.values @ (found.area.values * found.volume_factor.values)
        assert own == pytest.approx(data.dissipation.values[:, k], abs=loss * data.dissipation.values.max())
        power += own * float(data.point_weight.values[k])
    assert power == pytest.approx(data.dissipation.values @ data.point_weight.values, abs=loss * power.max())
    assert (found.loss_density.values >= 0.0).all()


def bent(**given):
    """A quarter of a circle whose section is a fifth of its radius."""
    return vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, np.pi / 2, **given)


def test_a_cantilever_by_hand():
    """Axial stress, lateral contraction, von Mises stress and elastic strain of bending, extension and shear."""
    steel = vr.Material(2e11, 0.3, 7850.0)
    b, h, length, F = 0.02, 0.01, 0.5, 10.0
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (length, 0, 0), section=vr.Rectangle(b, h), material=steel))
    model.clamp("beam.start")
    model.force("beam.end", (1000.0, 0, F))  # d2 is z
    held = model.equilibrium()
    points = [(0.0, h / 2), (0.3 * b, -h / 4), (0.0, 0.0)]
    found = held.stress("beam@0.1", points).isel(load_factor=-1)
    N, M = held.probe("beam@0.1").section_force.values[-1, 0, 2:4]
    s33 = N / (b * h) + M * np.array(points)[:, 1] / (b * h**3 / 12)
    assert found.stress.sel(stress_component="33").values == pytest.approx(s33, rel=1e-9)
    assert found.strain.sel(stress_component="33").values == pytest.approx(s33 / 2e11, rel=1e-9)
    assert found.strain.sel(stress_component="11").values == pytest.approx(-0.3 * s33 / 2e11, rel=1e-9)
    shear = found.stress.sel(stress_component=["23", "13"]).values
    assert found.von_mises.values == pytest.approx(np.sqrt(s33**2 + 3 * (shear**2).sum(axis=1)), rel=1e-12)
    assert found.viscous_stress.values == pytest.approx(0.0, abs=1e-9 * np.abs(s33).max())
    told = re.search(r"von Mises stress (\S+) MPa, beam.start, at \((\S+), (\S+)\) mm", held.report())
    value, x, y = float(told[1]) * 1e6, float(told[2]) / 1e3, float(told[3]) / 1e3
    assert held.stress("beam.start", (x, y)).von_mises.values[-1, 0] == pytest.approx(value, rel=1e-5)
    assert held.stress("beam.start").von_mises.values.max() <= value * (1 + 1e-5)


@pytest.mark.parametrize(
    ("ratio", "inner", "outer"), [(1.3, 72.98, -61.27), (2.0, 7.725, -4.863), (3.0, 2.285, -1.095)]
)
def test_pure_bending_of_a_thick_ring_is_winklers(ratio, inner, outer):
    """Timoshenko and Goodier, article 29: stresses over M/a^2 by the hyperbolic distribution (3 % off, or less)."""
    a, b, M = 0.02, 0.02 * ratio, 1e-3
    rubber = vr.Material(1e6, 0.3, 1000.0)
    model = vr.Model()
    section = vr.Rectangle(b - a, 0.01)
    radius = (a + b) / 2
    rod = vr.Rod.arc(
        (0, 0, 0), (1, 0, 0), (0, 1, 0), radius, 1.0, section=section, material=rubber, d1=(0, 1, 0)
    )
    model.add("ring", rod)
    model.clamp("ring.start")
    model.moment("ring.end", (0, 0, -M))  # opens it: the inside is in tension
    half = (b - a) / 2
    found = model.equilibrium().stress("ring@0.01", [(half, 0.0), (-half, 0.0)])
    stress = found.stress.sel(stress_component="33").values[-1] / (M / 0.01 / a**2)
    assert stress == pytest.approx([inner, outer], abs=0.006)


def test_a_solid_of_finite_elements_has_these_stresses():
    """A thick bar, bent, sheared, stretched and twisted: an independent solution in three dimensions, mid-way."""
    (a, b, length), young, nu = (0.02, 0.03, 0.16), 2e6, 0.3
    force, torque = np.array([0.01, 0.005, 0.02]), 2e-4
    points, solid = bar_stress((a, b, length), (4, 4, 8), young, nu, force, torque)
    model = vr.Model()
    section, material = vr.Rectangle(a, b), vr.Material(young, nu, 1000.0)
    rod = vr.Rod.straight((0, 0, 0), (0, 0, length), section=section, material=material, d1=(1, 0, 0))
    model.add("bar", rod)
    model.clamp("bar.start")
    scale = 1e-4  # as small as linear elasticity means it
    model.force("bar.end", scale * force)
    model.moment("bar.end", (0, 0, scale * torque))
    held = model.equilibrium()
    for z in np.unique(points[:, 2].round(9)):
        here = np.abs(points[:, 2] - z) < 1e-8
        found = held.stress(f"bar@{z:.9g}", points[here, :2]).stress.values[-1] / scale
        size = np.abs(solid[here]).max(axis=0)
        assert np.abs(found - solid[here])[:, 2].max() < 0.01 * size[2]
        assert np.abs(found - solid[here])[:, 3:5].max() < 0.015 * size[3:5].max()
        assert size[[0, 1, 5]].max() < 0.01 * size[2]  # what a rod leaves out


def test_times_between_states_and_a_file(tmp_path):
    run = swing(RECTANGLE, RELAXING, "radau")
    some = run.stress("beam@0.1", (0.002, 0.01), times=[0.0, 0.0123])
    force = run.probe("beam@0.1", [0.0123]).section_force.values
    whole = run.stress("beam@0.1", times=0.0123)
    assert resultants(whole) == pytest.approx(force[:, 0], abs=1e-10 * np.abs(force).max())
    again = vr.load(run.save(tmp_path / "run.nc")).stress("beam@0.1", (0.002, 0.01), times=[0.0, 0.0123])
    assert again.stress.values == pytest.approx(some.stress.values, rel=1e-9, abs=1e-9)
    assert again.loss_density.values == pytest.approx(some.loss_density.values, rel=1e-9)
    assert run.data.branch_strain.dims == ("time", "point", "branch", "component")


def test_sections_along_a_rod():
    """A taper, pieces, and a function of the arc length, which is kept at the Gauss points."""
    profiles = {
        "taper": vr.Taper(vr.Circle(0.004), vr.Circle(0.002)),
        "pieces": vr.Piecewise([(0.1, vr.Circle(0.004)), (0.2, vr.Circle(0.002))]),
        "function": lambda s: vr.Circle(0.004 - 0.01 * s),
    }
    model = vr.Model()
    for number, (name, section) in enumerate(profiles.items()):
        y = 0.1 * number
        model.add(name, vr.Rod.straight((0, y, 0), (0.2, y, 0), section=section, material=VISCOUS))
        model.clamp(f"{name}.start")
        model.force(f"{name}.end", (1e-3, 0, 0))
    held = model.equilibrium()
    for name, radius in (("taper", 0.003), ("pieces", 0.002), ("function", 0.003)):
        s = 0.15 if name == "pieces" else 0.1
        found = held.stress(f"{name}@{s}", (0, 0)).stress.values[-1, 0, 2]
        # the function is that of the nearest Gauss point
        assert found == pytest.approx(1e-3 / (np.pi * radius**2), rel=0.1 if name == "function" else 1e-9)
    assert "pieces" in held.report()


def test_what_has_no_stress_is_refused_by_name():
    C, _, M = RECTANGLE.matrices(VISCOUS)
    model = vr.Model()
    line = {"elements": 1, "order": 2}
    model.add("plain", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.StiffnessSection(C, M), **line))
    law = vr.Rod.straight(
        (0, 1, 0), (0.3, 1, 0), section=RECTANGLE, material=VISCOUS, law=vr.CubicBending(1e-4), **line
    )
    model.add("law", law)
    model.clamp("plain.start")
    model.clamp("law.start")
    model.gravity()
    held = model.equilibrium()
    with pytest.raises(vr.InputError, match=r"plain.section: .*has no points.*describe it by its shape"):
        held.stress("plain@0.1")
    with pytest.raises(vr.InputError, match="have a law"):
        held.stress("law@0.1")
    with pytest.raises(vr.InputError, match="no rod is called"):
        held.stress("rod.end")
    assert "von Mises" not in flat(held.report())


@pytest.mark.parametrize("points", [[1.0, 2.0, 3.0], [[0.0]], [], "middle", [[np.nan, 0.0]]], ids=str)
def test_points_that_are_none_are_refused(points):
    model = vr.Model()
    line = {"elements": 1, "order": 2, "section": RECTANGLE, "material": VISCOUS}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **line))
    model.clamp("beam.start")
    with pytest.raises(vr.InputError, match="points: give"):
        model.equilibrium().stress("beam.end", points)


def test_a_spinning_rod_is_stretched():
    """A steady rotation: s33 = rho w^2 (L^2 - s^2)/2 in a stiff rod that turns about its end."""
    steel = vr.Material(2e11, 0.3, 7850.0)
    length, rate = 0.5, 100.0
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (length, 0, 0), section=vr.Circle(0.01), material=steel, elements=2, order=4
    )
    model.add("rod", rod)
    model.clamp("rod.start")
    found = model.steady(spin=(0, 0, rate), centre=(0, 0, 0))
    for s in (0.0, 0.2):
        stress = found.stress(f"rod@{s}", (0.003, 0.004)).stress.sel(stress_component="33").values
        assert stress[0, 0] == pytest.approx(7850 * rate**2 * (length**2 - s**2) / 2, rel=1e-3)
    assert "Largest von Mises stress" in flat(found.report())
    assert "Validity of the rod model" in flat(found.report())


def test_the_picture_of_a_section(tmp_path):
    """Three panels; of a run at its worst stored state, or at a time; flat sections on top of each other."""
    run = swing(RECTANGLE, VISCOUS)
    figure = draw_stress(run, "beam.start")
    titles = [title for axes in figure.axes if (title := axes.get_title(loc="left"))]
    assert titles[0].startswith("axial stress s33 [")
    assert [title.split(" [")[0] for title in titles[1:3]] == [
        "shear stress |(s13, s23)|",
        "von Mises stress",
    ]
    whole = run.stress("beam.start", section_patch(run, "beam.start").points).von_mises
    worst = whole.max("point")
    (text,) = (one.get_text() for one in figure.texts if "largest von Mises" in one.get_text())
    assert f"at {float(worst.time[int(worst.values.argmax())]):.4g} s" in text
    assert f"{float(worst.max()) / 1e3:.4g} kPa" in text
    assert written(run.plot_stress, tmp_path / "section.png", "beam@0.1", 0.01).stat().st_size > 10_000
    model = vr.Model()
    line = {"section": vr.Rectangle(0.02, 0.002), "material": VISCOUS, "elements": 1, "order": 2}
    model.add("strip", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **line))
    model.clamp("strip.start")
    model.gravity()
    held = model.equilibrium()
    assert written(held.plot_stress, tmp_path / "strip.png", "strip.start").stat().st_size > 10_000
    with pytest.raises(vr.InputError, match="only a run has times"):
        held.plot_stress(tmp_path / "no.png", "strip.end", 0.1)


def test_surfaces_for_paraview_have_the_true_section_and_its_stress(tmp_path):
    """Points of the outlines where frames put them, with the stresses of `stress`; holes too."""
    model = vr.Model()
    line = {"material": VISCOUS, "elements": 1, "order": 2}
    model.add("tube", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Annulus(0.02, 0.01), **line))
    model.add("bar", vr.Rod.straight((0, 0.1, 0), (0.3, 0.1, 0), section=RECTANGLE, **line))
    C, _, M = RECTANGLE.matrices(VISCOUS)
    model.add(
        "plain", vr.Rod.straight((0, 0.2, 0), (0.3, 0.2, 0), section=vr.StiffnessSection(C, M), elements=1)
    )
    for name in ("tube", "bar", "plain"):
        model.clamp(f"{name}.start")
        model.force(f"{name}.end", (0, 0.02, 0.01))
    held = model.equilibrium()
    times, state = states_of(held.save_paraview(tmp_path / "held.vtkhdf", sections=True))
    surface = state(times.index(1.0))["sections"]
    places, ring = 2 * 2 + 1, 48
    assert surface.n_points == places * (2 * ring + 32)
    assert surface.n_cells == (places - 1) * (2 * ring + 32)
    largest = held.stress("bar.start", [(0.005, 0.01), (-0.005, 0.01), (0.005, -0.01), (-0.005, -0.01)])
    corner = surface.point_data["von_mises"][surface.point_data["rod"] == 1]
    assert corner.max() >= largest.von_mises.values[-1].max() * (1 - 1e-9)
    start = surface.points[:ring]
    assert np.hypot(start[:, 1], start[:, 2]) == pytest.approx(0.02, rel=1e-5)


def test_the_page_shows_the_largest_stress_of_every_section(tmp_path):
    """To a percent of the largest at the points of the section, at all Gauss points and instants."""
    run = swing(RECTANGLE, RELAXING)
    data = run.data
    found = peak_stresses(run, data.strain.values, data.section_force.values, data.branch_strain.values)
    points = section_patch(run, "beam.start").points
    for k, s in enumerate(data.point_s.values.tolist()):
        exact = run.stress(f"beam@{s!r}", points).von_mises.values.max(axis=1)
        assert found[:, k] == pytest.approx(exact, rel=0.01)
    page = view(run, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "von Mises stress, largest in the section" in page

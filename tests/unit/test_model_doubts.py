"""What a model is hardly meant to have is told with every result: equal loads, loose ends, sections past a centre.

Right values are closed forms: small deflections of cantilevers.
"""

import re

import numpy as np
import pytest
import scipy.optimize

import viscorod as vr

STEEL = vr.Material(2.1e11, 0.3, 7850.0)
WIRE = vr.Circle(0.005)


def straight(start, end, **more):
    return vr.Rod.straight(start, end, section=WIRE, material=STEEL, **more)


def bar():
    model = vr.Model()
    model.add("bar", straight((0, 0, 0), (0.5, 0, 0)))
    model.clamp("bar.start")
    return model


def sag(weight):
    """Return w L^4/8 EI of the bar."""
    return weight * 7850.0 * np.pi * 0.005**2 * 0.5**4 / (8.0 * 2.1e11 * np.pi / 4.0 * 0.005**4)


def test_equal_loads_add_up_and_are_told():
    model = bar()
    model.gravity()
    model.gravity()
    found = model.equilibrium()
    assert found.displacement("bar.end")[2] == pytest.approx(-sag(2.0 * 9.81), rel=1e-3)
    told = "loads[0], loads[1] are the same gravity: they add up to 2 times one of them"
    for result in (found, model.modes(1), model.simulate(1e-3), model.check()):
        assert sum(told in text for text in result.warnings) == 1


def test_loads_that_differ_are_not_doubted():
    model = bar()
    model.gravity()
    model.gravity((0, -9.81, 0))
    for name in ("wind", "push"):  # who names two forces means two
        model.force("bar.end", (0, 1.0, 0), name=name)
    model.force("bar@0.25", (0, 1.0, 0))
    assert model.equilibrium().warnings == []


@pytest.mark.parametrize(
    ("acceleration", "told"),
    [
        ((0, 0, -9810.0), "9810 mm/s2 are 9.81 m/s2"),
        ((0, 981.0, 0), "981 cm/s2 are 9.81 m/s2"),
        ((0, 0, -1e4), ""),
    ],
)
def test_weights_in_another_unit_are_told(acceleration, told):
    """A centrifuge of a thousand g and more is none of them."""
    model = bar()
    model.gravity(acceleration)
    found = [text for text in model.check().warnings if "acceleration" in text]
    assert len(found) == bool(told)
    assert all(told in text for text in found)


def coil(radius, wire, pitch=0.05):
    model = vr.Model()
    helix = vr.Rod.helix(radius, pitch, 2.0, section=wire, material=STEEL)
    model.add("coil", helix)
    model.clamp("coil.start")
    return model


@pytest.mark.parametrize(
    ("model", "told"),
    [
        (coil(0.01, vr.Circle(0.02)), True),
        (coil(0.03, vr.Circle(0.02)), False),
        # the centre of curvature is R + (p/2 pi)^2/R = 0.01633 m away, not R
        (coil(0.01, vr.Circle(0.0163)), False),
        (coil(0.01, vr.Circle(0.0164)), True),
    ],
)
def test_wire_thicker_than_its_radius_of_curvature(model, told):
    model.gravity()
    for warnings in (model.check().warnings, model.equilibrium().warnings):
        assert any("past the centre of curvature" in text for text in warnings) == told
    assert any("0.01633 m away" in text for text in warnings) == told


@pytest.mark.parametrize(("pitch", "told"), [(0.0, True), (0.0018, True), (0.002, False), (0.01, False)])
def test_turns_that_lie_within_each_other_are_told(pitch, told):
    """Two turns of a wire of 2 mm: those of a close-coiled spring, 2 mm apart, touch."""
    model = coil(0.02, vr.Circle(0.001), pitch)
    assert any("lie within each other, and no contact" in text for text in model.check().warnings) == told


@pytest.mark.parametrize(("torsion", "told"), [(5e-9, True), (3e-9, False), (1e-9, False)])
def test_torsion_constants_that_no_section_has_are_told(torsion, told):
    """Saint-Venant's torsion constant is at most I1 + I2: warping only makes a section softer."""
    section = vr.SectionProperties(
        area=1e-4, second_moment_1=1e-9, second_moment_2=2e-9, torsion_constant=torsion
    )
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=STEEL))
    model.clamp("bar.start")
    model.gravity()
    for warnings in (model.check().warnings, model.equilibrium().warnings):
        assert any("no section of one material has that" in text for text in warnings) == told


def test_band_bent_over_its_flat_side_is_not_doubted():
    """Its half width, 12.5 mm, is more than the radius, its half thickness is not."""
    for d1, told in (((0, 0, 1), False), ((0, 1, 0), True)):
        band = vr.Rectangle(0.025, 0.001)
        model = vr.Model()
        arc = vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.01, 1.0, section=band, material=STEEL, d1=d1)
        model.add("band", arc)
        model.clamp("band.start")
        assert any("past the centre of curvature" in text for text in model.check().warnings) == told


def frame():
    """Return two bars that meet at right angles, each held at its far end."""
    model = vr.Model()
    model.add("beam", straight((0, 0, 0), (0.5, 0, 0)))
    model.add("post", straight((0.5, 0, 0), (0.5, 0.5, 0)))
    model.clamp("beam.start")
    model.gravity()
    return model


LOOSE = "beam.end and post.start are at the same place, and nothing joins them there"


def test_ends_that_meet_and_are_not_joined_are_told():
    model = frame()
    with pytest.raises(vr.InputError, match=LOOSE):
        model.equilibrium()
    model.clamp("post.end")
    found = model.equilibrium()
    assert any(LOOSE in text for text in found.warnings)
    assert any(LOOSE in text for text in model.check().warnings)
    for end in ("beam.end", "post.start"):
        assert found.displacement(end)[2] == pytest.approx(-sag(9.81), rel=1e-3)


def by_a_body(model):
    model.add("pin", vr.Sphere(0.01, density=1000.0, centre=(0.5, 0, 0)))
    model.rigid("beam.end", "pin")
    model.ball("pin", "post.start")


@pytest.mark.parametrize(
    "join",
    [
        lambda model: model.rigid("beam.end", "post.start"),
        lambda model: model.ball("beam.end", "post.start"),
        lambda model: model.spring("beam.end", "post.start", stiffness={"uz": 10.0}),
        lambda model: [model.clamp(end) for end in ("beam.end", "post.start")],
        by_a_body,
    ],
)
def test_ends_that_are_joined_or_held_are_not_doubted(join):
    model = frame()
    model.clamp("post.end")
    join(model)
    assert not any("nothing joins" in text for text in model.check().warnings)


def test_a_disc_is_no_rod():
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(10.0), material=STEEL))
    model.clamp("bar.start")
    for warnings in (model.check().warnings, model.equilibrium().warnings):
        assert sum("half width, 10 m, is more than its length, 1 m" in text for text in warnings) == 1


@pytest.mark.parametrize(
    ("times", "end", "told"),
    [
        ((0.0, 1e-3), 0.5, "ends at 0.001 s, and its last value, 0.5, is kept"),
        ((1e-4, 2e-3), 0.5, "begins at 0.0001 s, and its first value, 1, is taken from the beginning on"),
        ((0.0, 1e-3), 0.0, ""),
    ],
)
def test_records_that_do_not_cover_the_motion_are_told(times, end, told):
    model = bar()
    record = vr.TimeTable(np.linspace(*times, 40).tolist(), np.linspace(1.0, end, 40).tolist())
    model.force("bar.end", (0, 0, 0.1), time=record)
    found = [text for text in model.simulate(2e-3).warnings if "loads[0].time" in text]
    assert len(found) == bool(told)
    assert all(told in text for text in found)


def test_ramps_stay_where_they_end():
    model = bar()
    model.force("bar.end", (0, 0, 0.1), time=vr.TimeTable([0.0, 1e-3], [0.0, 1.0]))
    assert not any("loads[0].time" in text for text in model.simulate(2e-3).warnings)


def test_springs_that_push_are_told():
    """Those of magnets do; most have a sign that was not meant."""
    model = bar()
    model.spring("bar.end", stiffness={"uz": -5.0, "uy": 5.0})
    model.line_spring("bar.end", (0, 0, 1), stiffness=3.0)
    told = [text for text in model.check().warnings if "pushes away" in text]
    assert told == [
        "bushing bar.end - ground: a stiffness of -5 along uz pushes away from rest what leaves it; springs that pull "
        "back have positive numbers"
    ]


def brace(height=0.0):
    """Return two diagonals of a rectangle, 0.8 by 0.6 m, and a post that ends in the middle of the first."""
    model = vr.Model()
    model.add("up", straight((0, 0, 0), (0.8, 0.6, 0)))
    model.add("down", straight((0, 0.6, height), (0.8, 0.0, height)))
    arc = vr.Rod.arc((0.2, 0.0, 0), (0, 1, 0), (1, 0, 0), 2.0, 0.3, section=WIRE, material=STEEL)
    model.add("bow", arc)
    for name in ("up", "down", "bow"):
        model.clamp(f"{name}.start")
        model.clamp(f"{name}.end")
    return model


def crossings(model):
    return [text for text in model.check().warnings if "pass through each other" in text]


def test_rods_that_cross_without_a_joint_are_told():
    """The diagonals cross in their middles; the bow, x = 2.2 - 2 cos a and y = 2 sin a, the first where y = 0.75 x."""
    (text,) = crossings(brace())
    assert "up@0.5 and down@0.5 (at (0.4, 0.3, 0) m)" in text
    a = scipy.optimize.brentq(lambda a: 2.0 * np.sin(a) - 0.75 * (2.2 - 2.0 * np.cos(a)), 0.0, 0.3)
    place = re.search(r"up@([\d.]+) and bow@([\d.]+)", text)
    assert float(place[1]) == pytest.approx(2.0 * np.sin(a) / 0.6, abs=1e-5)
    assert float(place[2]) == pytest.approx(2.0 * a, abs=1e-5)
    assert any("up@0.5 and down@0.5" in warning for warning in brace().equilibrium().warnings)


def test_rods_that_are_joined_where_they_cross_or_pass_beside_each_other_are_not_doubted():
    model = brace()
    model.revolute("up@0.5", "down@0.5", axis=(0, 0, 1))
    (text,) = crossings(model)
    assert "down@0.5" not in text
    assert "up@0.5 and down@0.5" not in "".join(crossings(brace(height=0.01)))


def test_a_rod_that_ends_on_another_one_is_told():
    model = vr.Model()
    model.add("beam", straight((0, 0, 0), (0.5, 0, 0)))
    model.add("post", straight((0.2, 0, 0), (0.2, 0.5, 0)))
    model.clamp("beam.start")
    model.gravity()
    with pytest.raises(vr.InputError, match=r"beam@0.2 and post.start \(at \(0.2, 0, 0\) m\) cross"):
        model.equilibrium()
    model.rigid("post.start", "beam@0.2")
    assert not crossings(model)


def test_rods_that_lie_along_each_other_are_not_doubted():
    """A core in a tube, which supports hold there."""
    model = vr.Model()
    for name, start in (("tube", 0.0), ("core", 0.1)):
        model.add(name, straight((start, 0, 0), (start + 0.5, 0, 0)))
        model.clamp(f"{name}.start")
    assert not crossings(model)


@pytest.mark.parametrize(("d1", "angle"), [((0.0, 0.0, 1.0), None), ((0.05, 0, 1), None), ((1, 0, 1), 45)])
def test_section_axes_far_from_the_plane_across_are_told(d1, angle):
    """The first axis of the sections is the part of d1 across the rod; the angle is 45 degrees for (1, 0, 1)."""
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0.5, 0, 0), d1=d1, section=WIRE, material=STEEL)
    model.add("beam", rod)
    model.clamp("beam.start")
    told = [text for text in model.check().warnings if "d1" in text]
    assert bool(told) == (angle is not None)
    if angle:
        assert f"is {angle} degrees off" in told[0]
        assert "(0, 0, 1)" in told[0]


def test_loads_that_supports_take_over_are_told():
    """A clamp holds all that a force and a moment push, a roller a force along its normal only."""
    model = bar()
    model.force("bar.start", (0, 1.0, 0))
    model.moment("bar@0", (0, 0, 1.0))
    model.roller("bar.end", (0, 0, 1.0))
    model.force("bar.end", (0, 0, 5.0))
    model.force("bar.end", (0, 1e-3, 5.0))
    found = model.equilibrium()
    told = [re.match(r"loads\[(\d)\]: .* acts where supports\[(\d)\], the", text) for text in found.warnings]
    assert [one.groups() for one in told] == [("0", "0"), ("1", "0"), ("2", "1")]
    bend = 0.5**3 / (3.0 * 2.1e11 * np.pi / 4.0 * 0.005**4)  # shear adds 2e-4 of it
    assert found.displacement("bar.end")[1] == pytest.approx(1e-3 * bend, rel=5e-4)


@pytest.mark.parametrize(
    ("damping", "told"),
    [
        ({"shear_time": 0.1, "bulk_time": 0.3}, True),
        ({"shear_time": 0.1, "bulk_time": 0.1}, False),
        ({"shear_time": 0.1, "bulk_time": 0.0}, False),
        ({"shear_time": 0.1, "extensional_time": 0.1}, False),
        ({"shear_viscosity": 1e4, "bulk_viscosity": 1e4}, True),
    ],
)
def test_a_volume_that_does_not_change_is_not_damped(damping, told):
    """LLT (4): eta_E = 3 eta for a Poisson's ratio of 0.5, whatever the bulk viscosity is."""
    rubber = vr.Material(3e6, 0.5, 1000.0, damping=vr.KelvinVoigt(**damping))
    assert [text for text in rubber.doubts if "has no effect: with a Poisson's ratio of 0.5" in text] == list(
        rubber.doubts
    )
    assert bool(rubber.doubts) == told
    assert rubber.extensional_time == pytest.approx(rubber.shear_time, rel=1e-12)


@pytest.mark.parametrize(("temperature", "told"), [(293.15, True), (20.0, False), (250.0, False)])
def test_temperatures_in_kelvin_are_told(temperature, told):
    model = vr.Model()
    shift = vr.Arrhenius(activation_energy=1e4, reference=20.0)
    damping = vr.KelvinVoigt(shear_time=0.01, bulk_time=0.01)
    material = vr.Material(1e9, 0.4, 1000.0, damping=damping, temperature=temperature, shift=shift)
    model.add("bar", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), section=WIRE, material=material))
    model.clamp("bar.start")
    found = [text for text in model.check().warnings if "degrees C" in text]
    assert found == (
        ["rod bar: temperature = 293.15 is read in degrees C; if it is 293.15 K, give 20 degrees C"]
        if told
        else []
    )


def test_a_damping_ratio_beside_kelvin_voigt_points_to_the_modal_kind():
    with pytest.raises(vr.InputError, match=r"damping\.ratio: 0\.02: no such key; .* kind 'modal'"):
        vr.Material(1e9, 0.4, 1000.0, damping={"kind": "kelvin_voigt", "ratio": 0.02})

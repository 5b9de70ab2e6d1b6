"""How far reference shapes turn, closed forms: whole turns count, and meshes must be able to tell them."""

import math

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import InputError
from viscorod.solve.problem.discretise import discretise

STEEL = vr.Material(2.1e11, poissons_ratio=0.3, density=7850.0)
THIN = vr.Circle(0.002)
RADIUS, PITCH = 0.05, 0.1
TURN = 2.0 * math.pi


def straight(twist, **given):
    return vr.Rod.straight((0, 0, 0), (1, 0, 0), section=THIN, material=STEEL, twist=twist, **given)


def arc(angle, **given):
    return vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, angle, section=THIN, material=STEEL, **given)


def helix(turns, **given):
    return vr.Rod.helix(RADIUS, PITCH, turns, section=THIN, material=STEEL, **given)


def wound(turns, **given):
    """A helix with its section's axes wound about it by as much as it bends."""
    return helix(turns, twist=bent(turns), **given)


def bent(turns):
    """Curvature times length of a helix."""
    return turns * TURN * RADIUS / math.hypot(RADIUS, PITCH / TURN)


TURNS = pytest.mark.parametrize("turns", [0.3, 1.0, 64.0, 64.3, 512.0, 3000.0])
"""64 and 512 whole turns look like none to samples at as many places."""


@TURNS
@pytest.mark.parametrize(
    ("build", "expected"),
    [
        (lambda n: straight(n * TURN), lambda n: n * TURN),
        (lambda n: straight(-n * TURN), lambda n: n * TURN),
        (lambda n: straight(lambda s: n * TURN * s), lambda n: n * TURN),
        (lambda n: arc(n * TURN), lambda n: n * TURN),
        (helix, bent),
        (wound, lambda n: math.sqrt(2.0) * bent(n)),
    ],
    ids=["twisted", "the other way", "function", "arc", "helix", "wound helix"],
)
def test_turning_is_curvature_and_twist_times_length(build, expected, turns):
    rod = build(turns)
    s = np.linspace(0.0, rod.length, 8)
    # steps of frames see a little less than what lies along them
    np.testing.assert_allclose(rod.turned(s), expected(turns) * s / rod.length, rtol=1e-6, atol=1e-12)


def test_a_twist_to_and_fro_adds_up():
    rod = straight(lambda s: 2.0 * math.sin(TURN * s))
    assert rod.turned([1.0])[0] == pytest.approx(8.0, rel=1e-3)


def test_a_curve_without_closed_form():
    """A parabola's tangent turns by atan(2)."""
    rod = vr.Rod.curve(lambda u: (u, u * u, 0.0), section=THIN, material=STEEL)
    assert rod.turned([rod.length])[0] == pytest.approx(math.atan(2.0), rel=1e-4)


@TURNS
@pytest.mark.parametrize("order", [2, 5, 8])
def test_chosen_meshes_turn_by_a_fifteenth_of_a_circle_from_node_to_node(turns, order):
    for rod in (straight(turns * TURN, order=order), arc(turns * TURN, order=order)):
        elements = rod.chosen_elements(0.0, rod.length)
        assert elements >= 10 // order
        if turns >= 1.0:
            assert elements * order == pytest.approx(15 * turns, abs=order)


@pytest.mark.parametrize(
    "build",
    [lambda **given: straight(20 * TURN, **given), lambda **given: helix(20, **given)],
    ids=["twist", "helix"],
)
def test_meshes_that_cannot_tell_turns_are_refused(build):
    """What the message advises is enough, and so is leaving the number out."""

    def model_of(**given):
        model = vr.Model()
        model.add("wire", build(**given))
        return model

    with pytest.raises(InputError, match=r"rods\.wire\.elements: 10: too few.*beyond half a turn") as error:
        discretise(model_of(elements=10))
    (problem,) = error.value.problems
    needed = int(problem.instead.split("at least ")[1].split(",")[0])
    assert needed < 60  # of which the program takes no less
    assert "leave it out" in problem.instead
    for given in ({"elements": needed}, {}):
        part = discretise(model_of(**given)).sets[0]
        assert len(part.start) * part.order >= 2 * 20  # half a turn from node to node at most


def test_the_thickness_of_a_close_coil_is_seen():
    """Curvature times half width of a coil is radius over radius of the wire, however many turns."""
    model = vr.Model()
    model.add("coil", vr.Rod.helix(0.01, 0.005, 200, section=THIN, material=STEEL))
    model.clamp("coil.start")
    (text,) = check(DiscreteModel.of(model)).warnings
    assert "half width times curvature of the reference shape is 0.2;" in text


def test_the_twist_of_a_thick_rod_is_seen():
    """Twist per length times half width: 2 pi 0.01 m / 0.2 m."""
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0.2, 0, 0), section=vr.Circle(0.01), material=STEEL, twist=2.0 * np.pi)
    model.add("drill", rod)
    model.clamp("drill.start")
    texts = check(DiscreteModel.of(model)).warnings
    assert any("half width times twist of the reference shape is 0.31;" in text for text in texts)

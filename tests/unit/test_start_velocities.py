"""Initial velocities that supports or joints hold are told: the motion begins with a blow there."""

import pytest

import viscorod as vr

MATERIAL = vr.Material(youngs_modulus=1e7, poissons_ratio=0.3, density=1000.0)


def rod_along_x(begin=0.0):
    section = vr.Rectangle(0.01, 0.01)
    return vr.Rod.straight((begin, 0, 0), (begin + 0.3, 0, 0), section=section, material=MATERIAL, elements=1)


def told(model):
    """The warnings about the start of a motion of one step or so."""
    run = model.simulate(1e-5)
    return [text for text in run.warnings if "given velocities move" in text]


@pytest.mark.parametrize("given", [{"linear": (0, 1, 0)}, {"angular": (0, 0, 3.0)}])
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_a_clamp_that_holds_what_moves_is_named(given):
    model = vr.Model()
    model.add("beam", rod_along_x())
    model.clamp("beam.start")
    model.velocity("beam", **given)
    (text,) = told(model)
    assert text.startswith("velocities: beam.start holds what the given velocities move")


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_velocities_that_supports_allow_are_not():
    """A turn about a pin, and a field whose velocity and turning vanish at a clamp."""
    pinned = vr.Model()
    pinned.add("beam", rod_along_x())
    pinned.pin("beam.start")
    pinned.velocity("beam", angular=(0, 0, 3.0))
    assert told(pinned) == []
    clamped = vr.Model()
    clamped.add("beam", rod_along_x())
    clamped.clamp("beam.start")
    clamped.velocity("beam", field=lambda s: ((0, s**2, 0), (0, 0, 2.0 * s)))
    assert told(clamped) == []


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_a_joint_that_holds_what_moves_is_named():
    """Two rods on one ball joint: both along is allowed, one of them alone is not."""
    found = []
    for speeds in ((1.0, 1.0), (1.0, 0.0)):
        model = vr.Model()
        for name, begin, speed in zip(("left", "right"), (0.0, 0.3), speeds, strict=True):
            model.add(name, rod_along_x(begin))
            model.velocity(name, (0, speed, 0))
        model.ball("left.end", "right.start")
        found.append(told(model))
    assert found[0] == []
    assert len(found[1]) == 1
    assert ", uy hold" in found[1][0]

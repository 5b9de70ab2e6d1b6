"""Motions that begin with a blow, and supports whose motions begin elsewhere than the model, are told or refused."""

import numpy as np
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


def shaken(**given):
    """A steel bar that is shaken along itself at its start."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=3
    )
    model.add("bar", rod)
    model.clamp("bar.start", motion={"ux": vr.Sine(20.0, amplitude=1e-3, **given)})
    return model


def test_a_reference_shape_that_a_support_would_tear_is_refused():
    """The bar was stretched by the amplitude within its first node spacing, and took 1e5 steps, without a word."""
    model = shaken(phase=np.pi / 2)
    with pytest.raises(vr.InputError, match=r"the motion of bar\.start begins elsewhere"):
        model.simulate(0.01, initial="reference")
    run = model.simulate(0.01)  # from the equilibrium there
    np.testing.assert_allclose(
        run.data["position"].values[0, :, 0] - run.data["reference_position"][:, 0], 1e-3
    )


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
@pytest.mark.parametrize(("given", "count"), [({}, 1), ({"phase": -np.pi / 2, "offset": 0.01}, 0)])
def test_a_motion_that_begins_with_a_velocity_is_told(given, count):
    """An inverted pendulum on a shaker: a wave of the force rho c v A goes up the bar, which long steps lose."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.02, 0, 0.2), section=vr.Circle(0.004), material=material, elements=2, order=3
    )
    model.add("bar", rod)
    motion = {"uz": vr.Sine(60.0, amplitude=0.01, **given)}
    model.support("bar.start", fixed=["ux", "uy", "rx", "rz"], motion=motion)
    run = model.simulate(0.1, initial="reference")
    told = [text for text in run.warnings if "bar.start begins with a velocity at t = 0" in text]
    assert len(told) == count
    wave = np.sqrt(2e11 * 7850.0) * 2.0 * np.pi * 60.0 * 0.01 * np.pi * 0.004**2  # 7500 N
    assert (run.step_errors["section_force"] > wave / 3.0) == bool(count)

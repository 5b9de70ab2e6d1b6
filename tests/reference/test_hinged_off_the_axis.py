"""A blade on a ball joint that a hub carries round: what its pin means, and what is neutral."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

OFFSET, LENGTH = 0.2, 1.8


def _blade() -> vr.Model:
    """A stiff uniform blade on a pin 0.2 m off the axis."""
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 1e5, 1e5, 1e5], [1.0, 1.0, 1.0, 1e-6, 1e-6, 2e-6])
    model = vr.Model()
    rod = vr.Rod.straight((OFFSET, 0, 0), (OFFSET + LENGTH, 0, 0), section=section, elements=2, order=4)
    model.add("blade", rod)
    model.pin("blade.start")
    return model


def test_flap_and_lag_about_a_ball_joint_on_a_hub() -> None:
    """Rigid blade: flap ``W sqrt(1 + 3e/2l)``, lag ``W sqrt(3e/2l)`` (Johnson, Helicopter Theory)."""
    turning = _blade().steady(spin=(0, 0, 10.0), centre=(0, 0, 0))
    found = np.unique(np.round(turning.frequencies * 2.0 * np.pi / 10.0, 3))
    lag = np.sqrt(1.5 * OFFSET / LENGTH)
    for expected in (lag, np.hypot(1.0, lag)):
        assert np.abs(found - expected).min() < 2e-3
    assert not any("pin" in told for told in turning.warnings)


def test_a_pin_beside_the_axis_is_told() -> None:
    """Without a centre the pin rests: there is no hub, and the tension at the root is ``m W^2 l^2/2``, not more."""
    turning = _blade().steady(spin=(0, 0, 10.0))
    assert any("turns about the pin at (0.2, 0, 0) m" in told for told in turning.warnings)
    assert float(turning.reactions[0, 0]) == pytest.approx(-100.0 * LENGTH**2 / 2.0, rel=1e-4)


def test_neutral_motions_that_a_diagram_follows_are_told() -> None:
    """The spin of a round blade about itself has the root zero at every speed, and no limits of stability.

    Where it is held, flap and lag are those of a rigid blade, to the percent by which one that is as soft differs.
    """
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 1e-3, 1e-3, 1e-3], [1.0, 1.0, 1.0, 1e-6, 1e-6, 2e-6])
    end = (OFFSET + LENGTH, 0, 0)
    rod = vr.Rod.straight((OFFSET, 0, 0), end, section=section, elements=3, order=4)
    told = []
    for fixed in (("ux", "uy", "uz"), ("ux", "uy", "uz", "rx")):
        model = vr.Model()
        model.add("blade", rod)
        model.support("blade.start", fixed)
        diagram = model.campbell(axis=(0, 0, 1), speeds=[2.0, 6.0, 10.0], modes=3, centre=(0, 0, 0))
        told.append(any("neither swing nor grow" in one for one in diagram.warnings))
    assert told == [True, False]
    lag = np.sqrt(1.5 * OFFSET / LENGTH)
    found = np.sort(diagram.frequencies[-1] * 2.0 * np.pi / 10.0)[:2]
    assert found == pytest.approx([lag, np.hypot(1.0, lag)], rel=1e-2)

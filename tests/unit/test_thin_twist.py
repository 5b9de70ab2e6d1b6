"""What thin sections resist twist with beside GJ is told where it is not small, as it is not computed."""

from __future__ import annotations

import re

import numpy as np
import pytest

import viscorod as vr

STEEL = vr.Material(2e11, 0.3, 7850.0)
B, T = 0.02, 0.0002


def told(result):
    texts = [text for text in result.warnings if "its fibres" in text]
    assert len(texts) < 2
    return [float(re.search(r"by about ([\d.e+]+) % of GJ", text)[1]) / 100.0 for text in texts]


def tape(section=None, **motion):
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section or vr.Rectangle(B, T), material=STEEL)
    model.add("tape", rod)
    model.clamp("tape.start")
    model.clamp("tape.end", motion=motion)
    return model


def test_a_tape_that_is_twisted_much():
    """Buckley 1914: M = GJ tau + E b^5 t tau^3/360, where its ends may move together."""
    model = tape(rx=1.5)
    model.supports.pop()
    model.support("tape.end", ("uy", "uz", "ry", "rz"), motion={"rx": 1.5})
    expected = B**5 * T * 1.5**2 / 360.0 / (B * T**3 / 3.0 / 2.6)
    assert told(model.equilibrium()) == pytest.approx([expected], rel=0.05)
    assert not told(tape(rx=0.5).equilibrium())


def test_a_tape_that_is_pulled():
    """N b^2/12 beside GJ; without twist there is nothing to tell, nor of a wire."""
    strain = 1e-4
    expected = 2e11 * strain * B**3 * T / 12.0 / (2e11 / 2.6 * B * T**3 / 3.0)
    assert told(tape(ux=strain, rx=0.1).equilibrium()) == pytest.approx([expected], rel=0.05)
    assert not told(tape(ux=strain).equilibrium())
    assert not told(tape(vr.Circle(0.002), ux=strain, rx=0.1).equilibrium())


def test_a_blade_that_turns():
    """Centrifugal tension of a pretwisted strip, which it untwists."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0.1, 0, 0), (0.6, 0, 0), section=vr.Rectangle(0.05, 0.001), material=STEEL, twist=0.5
    )
    model.add("blade", rod)
    model.clamp("blade.start")
    (part,) = told(model.steady(spin=(0, 0, 200.0)))
    stretch = 7850.0 * 200.0**2 * (0.6**2 - 0.1**2) / 2.0 / 2e11
    assert part == pytest.approx(2.6 / 4.0 * 50.0**2 * stretch, rel=0.1)
    assert np.isfinite(part)

"""Free vibrations that start near rest: the tolerance that nobody gave must not swallow them."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import cantilever


@pytest.mark.parametrize("force", [1e-7, 1e-5, 1e-3])
def test_damping_ratio_of_a_small_swing(force):
    """Closed form: in the last cycles the first mode's ratio, whatever the amplitude; numerical loss below 2 %."""
    material = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = cantilever(vr.Rectangle(0.01, 0.01), 0.3, material=material)
    model.force("beam.end", (0, force, 0), until=0.0)
    run = model.simulate(10.0)
    s = model.modes(1, about="reference").eigenvalues[0]
    assert run.energy.numerical_fraction < 0.02
    assert run.decrement("beam.end", "y").small_amplitude_ratio == pytest.approx(-s.real / abs(s), rel=0.005)


def loaded(*, until):
    """A sagging cantilever that is also pulled aside."""
    material = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = cantilever(vr.Rectangle(0.01, 0.01), 0.3, elements=2, order=5, material=material)
    model.gravity((0, 0, -3.0))
    if until is not None:
        model.force("beam.end", (0, 0.02, 0), until=until)
    return model


def test_modes_about_the_released_shape():
    """Independent formulation: the model without the load that ends at t = 0."""
    found = loaded(until=0.0).modes(4, about="released")
    without = loaded(until=None).modes(4)
    held = loaded(until=0.0).modes(4)
    assert found.eigenvalues == pytest.approx(without.eigenvalues, rel=1e-9)
    assert np.abs(held.eigenvalues[0] / found.eigenvalues[0] - 1.0) > 0.01
    assert held.eigenvalues == pytest.approx(
        loaded(until=1.0).modes(4, about="released").eigenvalues, rel=1e-12
    )
    for modes, until in ((found, None), (held, 0.0)):
        shape = loaded(until=until).equilibrium().field("position", states=-1)
        assert modes.positions == pytest.approx(shape, abs=1e-12)


def test_a_released_motion_swings_as_its_modes():
    """Two ways to the same number: the decay of a small release about the sagging shape, and the modes there."""
    model = loaded(until=None)
    model.force("beam.end", (0, 2e-5, 0), until=0.0)
    found = model.simulate(6.0, tolerance=1e-8).decrement("beam.end", "y")
    modes = model.modes(2, about="released")
    swing = modes.shapes[:, -1, 1]
    root = modes.eigenvalues[int(np.argmax(np.abs(swing)))]
    assert found.small_amplitude_ratio == pytest.approx(-root.real / abs(root), rel=2e-3)
    assert 2 * np.pi / found.period[-1] == pytest.approx(root.imag, rel=1e-3)

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


def test_other_motions_keep_the_usual_tolerance():
    """Loads that act later say nothing of how far it will move."""
    material = vr.Material(1e6, 0.3, 1000.0)
    tolerances = []
    for later in (False, True):
        model = cantilever(vr.Rectangle(0.01, 0.01), 0.3, material=material)
        model.force("beam.end", (0, 1e-6, 0), until=0.0)
        if later:
            model.force("beam.end", (0, 0.01, 0), time=vr.Ramp(0.01, 0.02))
        tolerances.append(model.simulate(0.05).data.attrs["tolerance"])
    assert tolerances[1] == 1e-4
    assert 1e-10 <= tolerances[0] < 1e-6
    assert np.isfinite(tolerances).all()

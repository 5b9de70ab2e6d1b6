"""A cantilever strip with a free damping layer: its first mode against Euler, Bernoulli and Oberst."""

import math

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel


@pytest.mark.parametrize("origin", ["centroid", "given"])
def test_first_mode_of_a_strip_with_a_free_layer(origin):
    """omega = 1.8751^2 sqrt(EI/m)/L^2 with the laminate's EI; damping ratio omega tau/2 with Oberst's share of tau_E.

    The centre line in the interface couples extension and bending in stiffness, damping and inertia; the mode is
    the same. Slender, so that shear and rotary inertia matter by some (h/L)^2 = 1e-5 only.
    """
    b, h1, h2, length = 0.02, 0.001, 0.002, 0.8
    E1, E2, nu, tau = 7e10, 2e9, 0.4, 2e-4
    layer = vr.Material(E2, nu, 1200.0, damping=vr.KelvinVoigt(shear_time=tau, bulk_time=tau))
    section = vr.Composite(
        [
            vr.CompositeRegion(vr.Material(E1, 0.33, 2700.0), vr.Rectangle(b, h1), at=(0, -h1 / 2)),
            vr.CompositeRegion(layer, vr.Rectangle(b, h2), at=(0, h2 / 2)),
        ],
        origin=origin,
    )
    model = vr.Model()
    model.add("strip", vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, d1=(0, 0, 1)))
    model.clamp("strip.start")
    report = check(DiscreteModel.of(model))
    A, B = b * (E1 * h1 + E2 * h2), b * (E2 * h2**2 - E1 * h1**2) / 2
    stiffness = b * (E1 * h1**3 + E2 * h2**3) / 3 - B**2 / A
    mass = b * (2700.0 * h1 + 1200.0 * h2)
    omega = 1.8751040687119611**2 * math.sqrt(stiffness / mass) / length**2
    e, h = E2 / E1, h2 / h1
    share = e * h * (3 + 6 * h + 4 * h**2 + 2 * e * h**3 + e**2 * h**4)
    share /= (1 + e * h) * (1 + 4 * e * h + 6 * e * h**2 + 4 * e * h**3 + e**2 * h**4)
    assert report.frequencies[0] == pytest.approx(omega / (2 * math.pi), rel=2e-4)
    assert report.damping_ratios[0] == pytest.approx(omega * share * tau / 2, rel=5e-4)
    assert np.all(report.damping_ratios >= 0.0)

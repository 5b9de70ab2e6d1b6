"""Parametric excitation: a column under a pulsating load against the multipliers of Mathieu's equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import viscorod as vr


def test_an_inextensible_column_under_a_pulsating_load_is_unstable_within_mathieus_tongue() -> None:
    """It stays straight and at rest: x'' + tau w1^2 x' + (0.8 - 0.3 cos W t) w1^2 x = 0 is its slowest disturbance."""
    time = 0.002
    section = vr.StiffnessSection([1.0, 1, 1, 1, 5, 1], [1.0, 1, 1, 1e-9, 1e-9, 2e-9], times=[time] * 6)
    column = vr.Rod.straight(
        (0, 0, 0), (0, 0, 1), section=section, elements=2, order=4, constraints="kirchhoff"
    )
    model = vr.Model()
    model.add("column", column)
    model.support("column.start", ("ux", "uy", "uz", "rz"))
    model.support("column.end", ("ux", "uy"))
    euler = np.pi**2
    model.force("column.end", (0, 0, -0.2 * euler))
    twice = 2.0 * np.pi**2 * np.sqrt(0.8)

    found = model.periodic(
        inputs="column.end fz",
        amplitudes=[0.3 * euler],
        outputs=["column.end uz", "column.start reaction fz"],
        frequencies=[0.85 * twice / (2 * np.pi), 1.15 * twice / (2 * np.pi)],
        harmonics=3,
        step=0.3,
    )

    def growth(speed: float) -> float:
        def rates(t: float, y: np.ndarray) -> list[float]:
            stiffness = euler**2 * (0.8 - 0.3 * np.cos(speed * t))
            return [y[1], -time * euler**2 * y[1] - stiffness * y[0]]

        period = (0.0, 2 * np.pi / speed)
        ends = [solve_ivp(rates, period, y, rtol=1e-9, atol=1e-12).y[:, -1] for y in ([1, 0], [0, 1])]
        return float(np.abs(np.linalg.eigvals(np.array(ends))).max() - 1.0)

    tongue = [brentq(growth, low * twice, high * twice) for low, high in ((0.88, 0.97), (1.03, 1.15))]
    places = [place for place, kind in found.bifurcations if kind == "period doubling"]
    assert len(places) == len(found.bifurcations) == 2
    assert 2 * np.pi * found.frequencies[places] == pytest.approx(tongue, rel=2e-5)
    assert found.amplitude("column.end uz").max() == 0.0
    assert found.amplitude("column.start reaction fz") == pytest.approx(0.3 * euler, rel=1e-9)

"""The right-angle frame D4 over 30 s against another program's extrapolated motion."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .independent.mechanism_data import table


def test_right_angle_frame_trajectory():
    """D4 (Simo and Vu-Quoc 1988): places of elbow and tip to t = 30; the table is good to 1e-4."""
    rows = table("right_angle")
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 1e3], [1, 1, 1, 10, 10, 20])
    given = {"section": section, "elements": 3, "order": 5}
    model.add("leg1", vr.Rod.straight((0, 0, 0), (10, 0, 0), **given))
    model.add("leg2", vr.Rod.straight((10, 0, 0), (10, 10, 0), **given))
    model.attach("leg1.end", "leg2.start")
    model.clamp("leg1.start")
    model.force("leg1.end", (0, 0, 50), time=vr.TimeTable([0, 1, 2], [0, 1, 0]), until=2.0)
    run = model.simulate(30.0, initial="reference", tolerance=1e-6, output_interval=0.5)
    index = [int(np.argmin(np.abs(run.time - t))) for t in rows["t"]]
    for place, name in (("leg1.end", "elbow"), ("leg2.end", "tip")):
        expected = np.column_stack([rows[f"{name}_{k}"] for k in "xyz"])
        assert run.history(place).values[index] == pytest.approx(expected, abs=5e-4)

"""Radau IIA with five and seven stages on all that a step may contain, beside three stages with a small tolerance."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr


def rod(**given):
    C, _, M = vr.Rectangle(0.01, 0.012).matrices(vr.Material(1e5, poissons_ratio=0.3, density=1000.0))
    section = vr.StiffnessSection(C, M, **{key: part(C) for key, part in given.items()})
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=1, order=3))
    return model


def relaxing():
    model = rod(branches=lambda C: [vr.MaxwellBranch(time=0.05, stiffness=0.5 * C)])
    model.clamp("rod.start")
    model.gravity((0, 0, -0.5))
    return model


def hinged():
    model = rod(damping=lambda C: 0.05 * C)
    model.revolute("rod.start", "ground", axis=(0, 1, 0), name="hinge")
    model.gravity((0, 0, -0.5))
    return model


def shaken():
    model = rod(damping=lambda C: 0.05 * C)
    model.clamp("rod.start", motion={"uz": vr.SpinUp(0.05, 0.5)})
    model.support("rod.end", ("uy",))
    return model


def blown():
    model = rod(damping=lambda C: 0.05 * C)
    model.clamp("rod.start")
    model.force("rod.end", (0, 0, 0.001), time=vr.FunctionOfTime(lambda t: np.sin(9.0 * t) * np.exp(-t)))
    return model


@pytest.mark.parametrize("stages", [5, 7])
@pytest.mark.parametrize(
    ("make", "given"),
    [
        (relaxing, {}),
        (hinged, {}),
        (shaken, {}),
        (blown, {}),
        (blown, {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}),
    ],
)
def test_more_stages_lead_to_the_same_motion(make, given, stages):
    """Between steps too; the energy balance closes, and what steps are said to err by is not less than they do."""
    given = {"initial": "reference", "output_interval": 0.04} | given
    fine = make().simulate(0.4, tolerance=1e-8, errors=False, **given)
    run = make().simulate(0.4, tolerance=1e-5, stages=stages, **given)
    assert run.data.attrs["stages"] == stages
    moved = np.abs(fine.data["position"].values - fine.data["position"].values[0]).max()
    assert moved > 0.005
    error = np.abs(run.data["position"].values - fine.data["position"].values).max()
    assert error < 3e-5 * 0.3
    assert run.energy.numerical_fraction < 1e-3
    assert error < 3.0 * run.step_errors["position"] + 1e-6 * 0.3

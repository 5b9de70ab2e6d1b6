"""Meshes that the program chooses beside the tolerance of the steps."""

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.solve.settings.motion import SimulateSettings


def released(mesh=None, **settings):
    """A strip of rubber is let go that a couple has bent into a circle; if its mesh is given, a force aside."""
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = vr.Model()
    square = vr.Rectangle(0.01, 0.01)
    rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=square, material=rubber, **mesh or {})
    model.add("strip", rod)
    model.clamp("strip.start")
    if mesh is None:
        model.moment("strip.end", (0, 0, 2.0 * np.pi * 1e6 * 1e-8 / 12.0 / 0.3), following=True, until=0.0)
    else:  # a couple bends it evenly, which any mesh has exactly
        model.force("strip.end", (0, 0.035, 0), until=0.0)
    return model.simulate(0.1, output_interval=0.02, **settings)


@pytest.mark.parametrize(
    ("given", "accuracy"),
    [
        ({}, 1e-4),
        ({"tolerance": 1e-2}, 1e-2),
        ({"tolerance": 1e-6}, 1e-4),
        ({"tolerance": 1e-2, "accuracy": 1e-3}, 1e-3),
        ({"tolerance": 1e-2, "accuracy": 1e-4}, 1e-4),
    ],
)
def test_what_is_wanted_of_a_mesh(given, accuracy):
    assert SimulateSettings(duration=1.0, **given).mesh_accuracy == accuracy


def test_a_large_tolerance_has_a_coarser_mesh_that_keeps_it():
    """Against a run that is refined in both: the tolerance is kept, with fewer nodes than 1e-4 takes."""
    exact = released(tolerance=1e-6, accuracy=1e-6).history("strip.end").values
    coarse, fine = released(tolerance=1e-2), released(tolerance=1e-2, accuracy=1e-4)
    assert coarse.data.sizes["station"] < fine.data.sizes["station"]
    assert np.abs(coarse.history("strip.end").values - exact).max() < 1e-2 * 0.3


def test_a_tolerance_that_the_mesh_makes_worthless_is_told():
    told = "steps as small gain nothing"
    assert told in flat(released({"elements": 2, "order": 3}, tolerance=1e-6).report())
    assert told not in flat(released({"elements": 8, "order": 5}, tolerance=1e-6).report())

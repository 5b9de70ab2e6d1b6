"""Told errors of positions, rotations and section forces are within a factor of three of the true ones.

Refinement: the same mesh with a tolerance of 1e-8 and at least 6000 steps, so that the vibrations that carry section
forces are followed, compared at 400 equal times from the start on.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.mechanics.rotations.quaternion import conjugate, product

from .independent.slider_crank import SliderCrank
from .test_mechanisms import slider_crank
from .test_step_errors import double_pendulum, soft, steel, suddenly_loaded, tumbling

TIMES, FINE = 400, 6000


def swinging():
    """A soft cantilever, bent far and let go, undamped."""
    return soft(duration=0.5)


def relaxing():
    """The same with a Maxwell branch."""
    branch = vr.Prony(shear_ratios=[0.3], shear_times=[0.02], constant="poissons_ratio")
    return soft(branch, duration=0.5)


def pulled():
    """A bar that is suddenly pulled and bent: axial vibrations last."""
    model = steel()
    model.force("bar.end", (100.0, 0, 1.0))
    return model, {"duration": 0.1, "initial": "reference"}


def falling():
    """A steel bar that falls on a ball joint."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=3
    )
    model.add("bar", rod)
    model.ball("bar.start", "ground")
    model.gravity((0, 0, -9.81))
    return model, {"duration": 1.0, "initial": "reference"}


def halves():
    """The same bar in two halves."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    given = {"section": vr.Circle(0.01), "material": material, "elements": 1, "order": 4}
    model.add("one", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), **given))
    model.add("two", vr.Rod.straight((0.5, 0, 0), (1, 0, 0), **given))
    model.attach("one.end", "two.start")
    model.ball("one.start", "ground")
    model.gravity((0, 0, -9.81))
    return model, {"duration": 1.0, "initial": "reference"}


def crank_turn(damping=0.0):
    """One turn of a slider-crank whose coupler is a rod."""
    case = SliderCrank(damping=damping)
    return slider_crank(case), {"duration": 2 * np.pi / case.speed, "initial": "reference"}


def damped_crank_turn():
    return crank_turn(5e-5)


def compared(run, fine):
    """Largest differences of positions, rotations, section forces and moments."""
    moved = np.linalg.norm(run.data["position"].values - fine.data["position"].values, axis=2).max()
    q, exact = (one.data["rotation"].values.reshape(-1, 4) for one in (run, fine))
    turned = 2.0 * np.arcsin(np.linalg.norm(product(conjugate(exact), q)[:, 1:], axis=1).max())
    away = run.data["section_force"].values - fine.data["section_force"].values
    return moved, turned, *np.linalg.norm(away.reshape(-1, 2, 3), axis=2).max(axis=0)


MOTIONS = (
    swinging, relaxing, suddenly_loaded, pulled, tumbling, falling, halves, double_pendulum, crank_turn,
    damped_crank_turn,
)  # fmt: skip


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.__name__)
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of the forces that vibrations carry
def test_told_errors_are_within_a_factor_of_three(motion):
    """See the module's text."""
    model, given = motion()
    given |= {"output_interval": given["duration"] / TIMES}
    run = model.simulate(**given)
    fine = model.simulate(**given, tolerance=1e-8, time_step=given["duration"] / FINE)
    for kind, error in zip(run.step_errors, compared(run, fine), strict=True):
        assert 1.0 / 3.0 < run.step_errors[kind] / error < 3.0, (kind, run.step_errors[kind], error)

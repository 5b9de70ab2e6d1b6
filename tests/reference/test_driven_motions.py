"""Motions that grow by what feeds energy in, and stop growing: dampers with a law that drives."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import viscorod as vr


def _law(rate: float) -> float:
    """Rayleigh's: it drives slow motions and brakes fast ones, N."""
    return -(rate - rate**3 / 3.0)


def _rayleigh() -> vr.Model:
    """A mass of 1 kg on a spring of 1 N/m beside a damper by `_law`, thrown with 0.5 m/s."""
    model = vr.Model()
    model.add("mass", vr.Body(1.0, (1.0, 1.0, 1.0)))
    model.prismatic("mass", "ground", (0, 0, 1))
    model.spring("mass", stiffness={"uz": 1.0}, damping={"uz": _law})
    model.velocity("mass", linear=(0, 0, 0.5))
    return model


def _exact(times: np.ndarray) -> np.ndarray:
    """Return displacement, velocity and loss of it by another method, ``(3, n)``."""
    found = solve_ivp(
        lambda _, y: [y[1], -_law(y[1]) - y[0], _law(y[1]) * y[1]],
        (0.0, float(times[-1])),
        [0.0, 0.5, 0.0],
        rtol=1e-10,
        atol=1e-12,
        dense_output=True,
    )
    return np.asarray(found.sol(times))


@pytest.mark.filterwarnings("error::viscorod.AccuracyWarning")
@pytest.mark.parametrize("interval", [None, 0.005], ids=["few", "many"])
def test_an_oscillator_comes_to_its_limit_cycle(interval: float | None) -> None:
    """Rayleigh 1883, by the explicit method of Dormand and Prince: position, loss at every stored time, told error.

    Its damper gives and takes 0.9 J in every cycle; the error of steps is that of a cycle that is stable, not e^10 of
    it, by which motions about the start grow in these 20 s.
    """
    run = _rayleigh().simulate(20.0, initial="reference", output_interval=interval)
    z, _, loss = _exact(run.time)
    off = np.abs(run.history("mass").values[:, 2] - z).max()
    assert off < 1e-4
    assert off < run.step_errors["position"] < 10.0 * off
    assert_allclose(run.energy.viscous, loss, atol=1e-3)
    assert np.diff(run.energy.viscous).min() < 0.0  # it drives
    assert np.abs(run.energy.numerical).max() < 1e-4


def test_generalised_alpha_moves_bodies_alone() -> None:
    """The same motion to the tolerance of a method of order two."""
    run = _rayleigh().simulate(8.0, initial="reference", integrator="generalized_alpha")
    z, _, loss = _exact(run.time)
    assert_allclose(run.history("mass").values[:, 2], z, atol=1e-2)
    ends = slice(None) if run.step_ends is None else run.step_ends
    assert_allclose(run.energy.viscous[ends], loss[ends], atol=1e-2)

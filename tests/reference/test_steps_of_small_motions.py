"""Default steps follow the motion that there is, whatever its size: errors below 1 % of its amplitude in 20 periods."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.linalg

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import linearise

STEEL = vr.Material(2e11, 0.3, 7850.0)
SIZE = 0.02
PERIODS = 20


def bar(**support):
    """A steel bar of 1 m, clamped at its start."""
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Rectangle(SIZE, SIZE), material=STEEL))
    model.clamp("bar.start", **support)
    return model


def linear_modes(model):
    """Return angular frequencies, shapes of unit modal mass (6 n, modes), mass (6 n, 6 n) and the end node."""
    discrete = DiscreteModel.of(model)
    linear = linearise(discrete.static, State.reference(discrete.problem), scale=0.0)
    squares, shapes = scipy.linalg.eigh(linear.stiffness.toarray(), linear.mass.toarray())
    mass = scipy.linalg.block_diag(*discrete.problem.mass)
    end = int(discrete.problem.stations.nodes[-1])
    return np.sqrt(squares), linear.basis @ shapes, mass, end


def tip(run, times, axis=1):
    """Return a displacement of the end [m]."""
    u = run.probe(["bar.end"], times)["position"].values.reshape(len(times), 3)[:, axis]
    return u - u[0]


def test_sudden_force():
    """Modal superposition in closed form, sum of (1 - cos w t)/w^2: small beside the bar, not beside itself."""
    model = bar()
    w, shapes, _, end = linear_modes(model)
    model.force("bar.end", (0, 8.0, 0))
    shares = 8.0 * shapes[6 * end] ** 2 / w**2
    times = np.linspace(0.0, PERIODS * 2.0 * math.pi / w[0], 4001)
    exact = (1.0 - np.cos(np.outer(times, w))) @ shares
    run = model.simulate(times[-1], initial="reference")
    assert np.ptp(exact) / 2.0 == pytest.approx(1e-3, rel=0.01)
    assert np.abs(tip(run, times) - exact).max() < 0.01 * np.ptp(exact) / 2.0
    assert run.energy.numerical_fraction < 0.01


@pytest.mark.parametrize("amplitude", [1e-6, 1e-3])
def test_base_motion(amplitude):
    """Closed form of a base that begins to swing, a (1 - cos W t)/2: a Duhamel integral for each mode."""
    W = 2.0 * math.pi * 11.0
    model = bar(motion={"uy": vr.Sine(11.0, -amplitude / 2.0, phase=math.pi / 2.0, offset=amplitude / 2.0)})
    w, shapes, mass, end = linear_modes(model)
    carried = np.tile([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], len(mass) // 6)
    parts = shapes[6 * end] * (shapes.T @ mass @ carried)
    times = np.linspace(0.0, PERIODS * 2.0 * math.pi / w[0], 4001)
    phase = np.cos(np.outer(times, w)) - np.cos(W * times)[:, None]
    base = amplitude / 2.0 * (1.0 - np.cos(W * times))
    relative = -(amplitude / 2.0 * W**2 * phase / (W**2 - w**2)) @ parts
    run = model.simulate(times[-1])
    assert np.abs(tip(run, times) - base - relative).max() < 0.01 * np.ptp(relative) / 2.0


def test_resonance_of_a_microbeam():
    """Closed form of one mode driven at its frequency, amplitude F t/(2 m w), nanometres on 200 micrometres."""
    model = vr.Model()
    section = vr.Rectangle(4e-6, 2e-6)
    beam = vr.Rod.straight(
        (0, 0, 0), (2e-4, 0, 0), section=section, material=vr.Material(160e9, 0.22, 2330.0)
    )
    model.add("beam", beam)
    model.clamp("beam.start")
    w, shapes, _, end = linear_modes(model)
    gains = 2e-11 * shapes[6 * end] ** 2
    driven = int(np.argmax(gains / w**2))
    W, rest = w[driven], np.arange(len(w)) != driven
    model.force("beam.end", (0, 2e-11, 0), time=vr.Sine(W / (2.0 * math.pi)))
    times = np.linspace(0.0, PERIODS * 2.0 * math.pi / W, 2001)
    exact = gains[driven] / (2.0 * W**2) * (np.sin(W * times) - W * times * np.cos(W * times))
    others = np.sin(W * times)[:, None] - W / w[rest] * np.sin(np.outer(times, w[rest]))
    exact += (others / (w[rest] ** 2 - W**2)) @ gains[rest]
    run = model.simulate(times[-1])
    got = run.probe(["beam.end"], times)["position"].values.reshape(len(times), 3)[:, 1]
    assert 1e-10 < np.ptp(exact) < 1e-4 * 2e-4
    assert np.abs(got - exact).max() < 0.01 * np.ptp(exact) / 2.0


def test_deep_beam_of_nafems():
    """NAFEMS 5T (R0016): 1 MN/m suddenly on a simply supported deep beam, 2 % damping: 1.043 mm at 11.7 ms.

    The static deflection there is 0.537 mm; the second peak follows from the decay, 0.537 (1 + exp(-3 pi 0.02)) mm.
    """
    damping = vr.MeasuredDamping(ratio=0.02, mode=1)
    model = vr.Model()
    steel = vr.Material(2e11, 0.3, 8000.0, damping=damping)
    model.add("bar", vr.Rod.straight((0, 0, 0), (10, 0, 0), section=vr.Rectangle(2.0, 2.0), material=steel))
    model.support("bar.start", ["ux", "uy", "uz", "rx"])
    model.support("bar.end", ["uy", "uz", "rx"])
    model.distributed_force("bar", (0, 0, -1e6))
    run = model.simulate(0.04, initial="reference")
    times = np.linspace(0.0, 0.04, 4001)
    u = run.probe(["bar@5.0"], times)["position"].values.reshape(len(times), 3)[:, 2]
    peak = int(np.argmin(u[:2000]))
    assert -u[peak] == pytest.approx(1.043e-3, rel=0.01)
    assert times[peak] == pytest.approx(11.7e-3, abs=0.1e-3)
    assert -u[2000:].min() == pytest.approx(0.537e-3 * (1.0 + math.exp(-3.0 * math.pi * 0.02)), rel=0.01)


def test_vibrations_after_a_large_slow_load():
    """Modal superposition: a ramp of half a second bends the bar, what swings on is the thousandth part of that."""
    model = bar()
    w, shapes, _, end = linear_modes(model)
    model.force("bar.end", (0, 8.0, 0), time=vr.Ramp(0.0, 0.5))
    shares = 8.0 * shapes[6 * end] ** 2 / w**2
    times = np.linspace(0.5, 0.5 + PERIODS * 2.0 * math.pi / w[0], 4001)
    swings = np.sin(np.outer(times, w)) - np.sin(np.outer(times - 0.5, w))
    exact = shares.sum() - (swings / (0.5 * w)) @ shares
    run = model.simulate(times[-1])
    u = run.probe(["bar.end"], times)["position"].values.reshape(len(times), 3)[:, 1]
    assert np.ptp(exact) / 2.0 < 0.03 * shares.sum()
    assert np.abs(u - exact).max() < 0.02 * np.ptp(exact) / 2.0


def test_blade_that_turns_with_its_support():
    """The same bar at rest (independent run): slow turning carries it along and swallows none of its vibrations."""
    turning, still = bar(motion={"rz": vr.SpinUp(speed=1.0, duration=1.0)}), bar()
    for model in (turning, still):
        model.force("bar.end", (0, 0, 0.8))
    times = np.linspace(0.0, 1.2, 2001)
    exact = tip(still.simulate(1.2, initial="reference", tolerance=1e-7), times, axis=2)
    run = turning.simulate(1.2, initial="reference")
    assert np.ptp(exact) / 2.0 == pytest.approx(1e-4, rel=0.01)
    assert np.abs(tip(run, times, axis=2) - exact).max() < 0.015 * np.ptp(exact) / 2.0

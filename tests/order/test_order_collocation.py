"""Orders in time of the integrators and their dense output by regression; error against the tolerance."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import viscorod as vr
from helpers.measured_orders import March, check_order_of_accuracy, curved, orders_against, slope, swung
from viscorod.solve.transient.integrators import INTEGRATORS


def whirled():
    """Prescribed motion of a clamp and a partly supported, moving far end."""
    model = curved(0.01)
    model.clamp("rod.start", motion={"uy": vr.Sine(1.0, amplitude=0.1), "rz": vr.Sine(0.5, amplitude=0.8)})
    model.support("rod.end", ("ux",), motion={"uz": vr.Sine(0.8, amplitude=0.15)})
    return model


def steered():
    """Likewise, from rest: no velocity jumps at the start."""
    model = curved(0.01)
    model.clamp("rod.start", motion={"uy": vr.SpinUp(0.2, 1.0), "rz": vr.SpinUp(0.8, 1.0)})
    model.support("rod.end", ("ux",), motion={"uz": vr.SpinUp(0.3, 1.0)})
    return model


def released():
    """Loads that jump at t = 0 and at t = 0.25."""
    model = curved(0.02)
    model.clamp("rod.start")
    model.force("rod.end", (0, 0, 1.0), until=0.0)
    model.force("rod.end", (0.5, 0, 0), time=vr.TimeTable([0.0, 0.25, 0.25], [0.0, 0.0, 1.0]))
    return model


def orders(make, duration, steps, fine, settle=False):
    """Orders of radau against its own fine run."""
    exact = March(make(), duration, fine, settle=settle)
    return orders_against(exact, make, duration, steps, settle=settle)


@pytest.mark.parametrize(
    ("integrator", "formulation"),
    [(name, formulation) for name, method in INTEGRATORS.items() for formulation in method.formulations],
)
def test_order_of_accuracy(integrator, formulation):
    """Every integrator has the order that it states, in positions and velocities under smooth loads (theory)."""
    check_order_of_accuracy(integrator, formulation)


def test_accuracy_of_radau():
    """Order five of positions and velocities, and the size of the error, against a fine run on the same mesh."""
    (positions, velocities), errors = orders(swung, 0.8, (0.08, 0.04, 0.02), 0.005)
    assert positions == pytest.approx(5.0, abs=0.35)
    assert velocities == pytest.approx(5.0, abs=0.5)
    assert errors[-1, 0] < 5e-8


def supple():
    """Slow in all its modes, so that steps are short beside all periods."""
    section = vr.StiffnessSection(
        [20.0, 20.0, 20.0, 1.0, 1.4, 0.8], [1, 1, 1, 0.2, 0.2, 0.3], [0.2, 0.2, 0.2, 0.01, 0.014, 0.008]
    )
    model = vr.Model()
    given = {"section": section, "elements": 1, "order": 1, "twist": 0.8}
    model.add("rod", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2, **given))
    model.clamp("rod.start")
    model.force("rod.end", (0.4, 0.8, 1.5), time=vr.Sine(1.0))
    model.moment("rod.end", (0.1, 0.0, -0.2), following=True, time=vr.Sine(0.7))
    return model


@pytest.mark.parametrize(
    ("stages", "steps", "least", "most"),
    [
        (3, (0.16, 0.08, 0.04), 4.8, 5.3),
        (5, (0.4, 0.2, 0.16), 8.5, 10.0),
        (7, (0.8, 0.4, 0.8 / 3.0), 11.0, 14.0),
    ],
)
def test_order_of_radau_with_more_stages(stages, steps, least, most):
    """Theory: order 2 s - 1 of positions and velocities, against fine runs with other stages; 13 is near rounding."""
    given = {"tolerance": 1e-10}
    exact = March(supple(), 0.8, 0.04, stages=7 if stages == 5 else 5, **given)
    found, errors = orders_against(exact, supple, 0.8, steps, stages=stages, **given)
    assert least < min(found)
    assert max(found) < most
    assert errors[-1].max() < {3: 2e-7, 5: 2e-8, 7: 2e-9}[stages]


def test_order_of_radau_with_prescribed_motion_and_partial_support():
    """Theory of index-3 constraints: order five of positions and three of velocities."""
    (positions, velocities), _ = orders(steered, 0.8, (0.08, 0.04, 0.02), 0.005)
    assert positions == pytest.approx(5.0, abs=0.5)
    assert velocities > 3.0


def test_order_of_radau_after_supports_start_with_a_jolt():
    """Order by regression: velocities that jump at the start excite modes far beyond what the steps resolve."""
    found, errors = orders(whirled, 0.8, (0.01, 0.005, 0.0025), 0.000625)
    assert min(found) > 1.8
    assert errors[-1, 0] < 5e-7


def test_order_of_radau_with_jumps():
    """Order by regression, steps far too long for what the jumps start in the highest modes: no step lags behind."""
    (positions, velocities), errors = orders(released, 0.7, (0.05, 0.025, 0.0125), 0.003125, settle=True)
    assert positions > 2.5
    assert velocities > 2.5
    assert errors[-1, 0] < 1e-7


@pytest.mark.parametrize("tau", [0.1, 1.0, 10.0])
def test_order_of_radau_with_heavily_damped_modes(tau):
    """Order by regression where tau omega of the highest modes is 1e2 to 1e5: at least the stage order, three."""
    omega = np.abs(swung(1e-6).modes(200).eigenvalues).max()
    assert 1e2 < tau * omega < 1e5
    steps = (0.16, 0.08, 0.04, 0.02)
    found, errors = orders(lambda: swung(tau), 0.8, steps, 0.0025)
    assert min(found) > 3.0
    clear = errors[:, 0] > 1e-8  # above what Newton's method leaves
    local = np.diff(np.log(errors[:, 0])) / np.diff(np.log(steps))
    assert local[clear[1:]].min() > 3.0


def between_steps(integrator, steps, make=swung, fine=0.0025, **given):
    """Orders of positions, velocities, orientations and strains at 77 equal times, most of them between steps."""
    exact = March(make(), 0.8, fine, interval=0.8 / 77)
    errors = []
    for h in steps:
        run = March(make(), 0.8, h, integrator, interval=0.8 / 77, **given)
        assert run.t == pytest.approx(exact.t, abs=1e-12)
        strain = [
            np.abs(a.strain - b.strain).max()
            for a, b in zip(run.result.history.snapshots, exact.result.history.snapshots, strict=True)
        ]
        errors.append([*(np.abs(getattr(run, n) - getattr(exact, n)).max() for n in "rvq"), max(strain)])
    return [slope(steps, e) for e in np.transpose(errors)]


def test_order_between_the_steps_of_radau():
    """Order by regression of the dense output against a fine run."""
    positions, velocities, rotations, strains = between_steps("radau", (0.08, 0.04, 0.02))
    assert positions > 4.0
    assert rotations > 3.0
    assert velocities > 2.0
    assert strains > 2.0


def test_order_between_the_steps_of_five_stages():
    """Order by regression of the dense output against a fine run: s + 1 at the stages and between them."""
    found = between_steps("radau", (0.4, 0.2, 0.1), supple, 0.01, stages=5)
    assert min(found) > 5.0


@pytest.mark.parametrize("integrator", [name for name, method in INTEGRATORS.items() if method.order == 2])
def test_order_between_the_steps_of_second_order(integrator):
    """Order by regression of the dense output against a fine run: that of the methods."""
    positions, velocities, rotations, strains = between_steps(integrator, (0.02, 0.01, 0.005))
    assert [positions, velocities, rotations] == pytest.approx([2.0] * 3, abs=0.15)
    assert strains > 0.7


@functools.cache
def followed_exactly(make):
    run = make().simulate(1.5, tolerance=1e-9, output_interval=0.01, initial="reference", errors=False)
    return run.data["position"].values


def error(model, reference, **given):
    run = model.simulate(1.5, output_interval=0.01, initial="reference", errors=False, **given)
    distance = np.linalg.norm(run.data["position"].values - reference, axis=2)
    return float(distance.max() / run.data.attrs["scale_length"])


@pytest.mark.parametrize(
    ("integrator", "tolerances", "least", "most"),
    [
        ("radau", (1e-3, 1e-5, 1e-7), 0.003, 10.0),  # jolts are followed more exactly than asked
        ("generalized_alpha", (1e-2, 1e-3, 1e-4), 0.01, 30.0),
    ],
)
@pytest.mark.parametrize("make", [swung, whirled])
def test_error_follows_the_tolerance(make, integrator, tolerances, least, most):
    """Largest displacement error at 150 equal times over the tolerance, against a run at 1e-9."""
    reference = followed_exactly(make)
    found = np.array([error(make(), reference, integrator=integrator, tolerance=t) for t in tolerances])
    assert np.all(found < most * np.array(tolerances))
    assert np.all(found > least * np.array(tolerances))
    assert np.all(np.diff(found) < 0)

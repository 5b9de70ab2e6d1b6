"""Where the frozen Jacobian of a collocation step is made, and what its halves are predicted by."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.transient.integrators.predictor import Predictor
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.integrators.stage_constraints import StageConstraints
from viscorod.solve.transient.integrators.stage_model import StageModel
from viscorod.solve.transient.saved_state import hand_over


def swinging():
    """A soft rod that is let go level."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    model.add(
        "one",
        vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=material, elements=1, order=3),
    )
    model.gravity((0, 0, -9.81))
    return model, section, material


def clamped():
    """Held at its start."""
    model, _, _ = swinging()
    model.clamp("one.start")
    return model


def turned():
    """Its clamp turns."""
    model, _, _ = swinging()
    model.clamp("one.start", motion={"ry": vr.SpinUp(3.0, 0.3)})
    return model


def hinged():
    """Two of them on hinges, whose forces are unknowns."""
    model, section, material = swinging()
    rod = vr.Rod.straight((0.3, 0, 0), (0.5, 0, 0), section=section, material=material, elements=1, order=3)
    model.add("two", rod)
    model.revolute("one.start", "ground", (0, 1, 0))
    model.revolute("one.end", "two.start", (0, 1, 0))
    return model


def radau(model):
    """The method, without a control of its steps."""
    problem = discretise(model)
    return Radau(GeometricSystem(problem), SupportState(problem), tolerance=1e-5), State.reference(problem)


MODELS = (clamped, turned, hinged)


def march(model, h, steps):
    """Equal steps, each with a Jacobian of its own: rates of convergence, iterations, and where they come to."""
    integrator, state = radau(model)
    integrator.start(0.0, state)
    rates, iterations = [], 0
    for k in range(steps):
        integrator.forget_jacobian()
        report = integrator.attempt((k + 1) * h, before=False)
        assert report.converged
        rates.append(report.rate)
        iterations += report.iterations
        integrator.accept()
    return np.array(rates), iterations, integrator.state


@pytest.mark.parametrize("make", MODELS)
def test_a_jacobian_of_the_middle_converges_faster(make, monkeypatch):
    """The rate of a simplified Newton iteration goes with the distance from where it was linearised.

    The middle of a step is half as far from its ends as they are from each other; the solution is the same to what the
    iteration leaves (Hairer and Wanner 1996, IV.8).
    """
    middle = march(make(), 0.01, 15)
    monkeypatch.setattr(StageModel, "_predicted", lambda self, *_, **__: (self.state, self._stress))
    start = march(make(), 0.01, 15)
    assert np.median(middle[0][3:]) < 0.75 * np.median(start[0][3:])
    assert middle[1] < start[1]
    np.testing.assert_allclose(middle[2].r, start[2].r, rtol=0, atol=1e-7)
    np.testing.assert_allclose(middle[2].q, start[2].q, rtol=0, atol=2e-7)


def test_factors_of_another_step_come_with_a_new_jacobian():
    """A Jacobian that converges at less than a tenth stays for equal steps; for others only below three hundredths."""
    integrator, state = radau(clamped())
    integrator.start(0.0, state)
    counts = {}
    for name, rate, h in (
        ("first", 0.0, 1e-3),
        ("aged", 0.05, 1e-3),
        ("aged, longer", 0.05, 2e-3),
        ("young, longer", 0.02, 3e-3),
        ("stale", 0.2, 3e-3),
    ):
        before = integrator.jacobians
        if name != "first":
            integrator._rate = rate
            integrator._have_jacobian = integrator._have_jacobian and rate <= integrator.stale
        assert integrator.attempt(integrator.t + h, before=False).converged
        integrator.accept()
        counts[name] = integrator.jacobians - before
    assert counts == {"first": 1, "aged": 0, "aged, longer": 1, "young, longer": 0, "stale": 1}


def halves(make):
    """What the prediction of the halves of a step lacks, where they come to, and the step itself."""
    (integrator, state), (twin, _) = radau(make()), radau(make())
    integrator.start(0.0, state)
    twin.start(0.0, state.copy())
    h = 0.02
    for k in range(6):
        if k == 5:
            hand_over(integrator, twin)
        assert integrator.attempt((k + 1) * h, before=False).converged
        integrator.accept()
    twin.resume()
    predict, predicted, lacks = twin.predictor.predict, [], []

    def noted(*given):
        predict(*given)
        predicted[:] = [twin.stages.X.copy()]

    twin.predictor.predict = noted
    for place, end in ((0.0, 5.5 * h), (0.5, 6 * h)):
        twin.begin_half(integrator, place)
        assert twin.attempt(end, before=False).converged
        lacks.append(np.abs(twin.stages.X - predicted[0]).max())
        twin.accept()
    return lacks, twin.state, integrator.state


@pytest.mark.parametrize("make", MODELS)
def test_halves_are_predicted_by_the_step(make, monkeypatch):
    """A polynomial is nearer between its nodes than beyond them; the halves come to the same."""
    near, better, whole = halves(make)
    for kind in (Predictor, StageConstraints):
        monkeypatch.setattr(kind, "follow", lambda *_: None)
    far, same, _ = halves(make)
    assert near[0] < 0.5 * far[0]
    apart = np.abs(better.r - whole.r).max()
    assert np.abs(better.r - same.r).max() < 0.02 * apart

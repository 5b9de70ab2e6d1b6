"""States within steps that compiled code closes are those that ``projection.close_gaps`` closes by themselves."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.solve.constraints.projection import close_gaps
from viscorod.solve.formulations.system import State
from viscorod.solve.transient.integrators.stage_constraints import StageConstraints
from viscorod.solve.transient.many_steps import ManySteps


def hanging(**more):
    """A soft rod that falls from a clamp, and a second one whose start is where the first one ends."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    given = {"section": vr.Rectangle(0.01, 0.01), "material": material, "elements": 1, "order": 4}
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given, **more))
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.5, 0, 0), **given))
    model.clamp("rod.start")
    model.gravity((0, 0, -9.81))
    return model


def motor():
    """A hinge about an oblique axis that turns to and fro."""
    model = hanging()
    model.revolute("arm.start", "rod.end", (0, 1, 0.3), motion={"rz": vr.Sine(2.0, amplitude=0.7)})
    return model


def held():
    """A rod that neither shears nor stretches, and a hinge with a spring."""
    model = hanging(constraints=("unshearable", "inextensible"))
    model.revolute("arm.start", "rod.end", (0, 1, 0), stiffness={"rz": 1e-3}, damping={"rz": 1e-5})
    return model


def ball():
    """A ball joint whose motors turn far."""
    model = hanging()
    turns = {"rx": vr.Ramp(0.0, 0.3, 2.5), "ry": vr.Sine(1.0), "rz": vr.Ramp(0.1, 0.3, 1.0)}
    model.ball("arm.start", "rod.end", motion=turns)
    return model


@pytest.mark.parametrize("make", [motor, held, ball])
def test_states_are_closed_as_one_by_one(make, monkeypatch):
    """To rounding: poses, velocities, coordinates of joints, and the largest gap that is left."""
    seen, between = [], StageConstraints.between

    def both(self, states, parts, times, systems):
        given, constraints = [field.copy() for field in states], self.constraints
        found = between(self, states, parts, times, systems)
        moved = max(np.abs(new - old).max() for new, old in zip(states, given, strict=True))
        for k, t in enumerate(times):
            constraints.between_steps = True
            constraints.update(t)
            state = State(*(field[k] for field in given), np.zeros(0))
            left = close_gaps(constraints, state, systems.solve_real)
            value, rate, _ = constraints.measure(state)
            alone = constraints.state_of(value, rate, np.zeros_like(value))
            constraints.between_steps = False
            for new, old in zip(states, (state.r, state.q, state.twist), strict=True):
                np.testing.assert_allclose(new[k], old, rtol=0, atol=1e-11 * max(1.0, np.abs(old).max()))
            np.testing.assert_allclose(found.value[k], alone.value, rtol=0, atol=1e-11)
            np.testing.assert_allclose(found.rate[k], alone.rate, rtol=0, atol=1e-9)
            seen.append((moved, left))
        return found

    monkeypatch.setattr(StageConstraints, "between", both)
    monkeypatch.setattr(ManySteps, "of", lambda *_, **__: None)  # the loop closes its own
    run = make().simulate(0.3, initial="reference", tolerance=1e-3, output_interval=0.01)
    assert len(seen) > 20
    assert max(moved for moved, _ in seen) > 1e-9  # they were open
    assert max(left for _, left in seen) <= 1e-11
    assert run.data.attrs["drift_position"] <= 1e-6

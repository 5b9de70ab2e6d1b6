"""Motions whose steps are taken many at once, and the same taken one by one."""

from __future__ import annotations

import json

import numpy as np
import pytest

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.many_steps import ManySteps
from viscorod.solve.transient.step_control import ErrorControl
from viscorod.solve.transient.transient_solver import Transient

__all__ = ["count_taken", "require_same_rest", "require_same_steps", "transient"]


def count_taken(monkeypatch):
    """Return a list of how many steps are taken at once, call by call, of runs that no second one tells errors of."""
    monkeypatch.setattr("viscorod.analyses.motion_errors.is_needed", lambda *_: False)
    counts, take = [], ManySteps.take

    def counted(self, *given):
        found = take(self, *given)
        counts.append(len(found.ends))
        return found

    monkeypatch.setattr(ManySteps, "take", counted)
    return counts


def require_same_steps(make, duration, taken, **given):
    """Compare all data, and all that a result says of its steps and of their errors, bit for bit.

    Args:
        make: makes the model, which rests at first; taken: see :func:`count_taken`; given: to ``simulate``.
    """
    at_once = make().simulate(duration, initial="reference", **given)
    assert sum(taken) == at_once.data.attrs["steps"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ManySteps, "of", lambda *_, **__: None)
        one_by_one = make().simulate(duration, initial="reference", **given)
    assert at_once.data.identical(one_by_one.data.assign_attrs(at_once.data.attrs))
    apart = {key for key, value in one_by_one.data.attrs.items() if at_once.data.attrs.get(key) != value}
    assert {key for key in apart if "time" not in key} == set()
    assert json.loads(at_once.data.attrs["warnings"]) == json.loads(one_by_one.data.attrs["warnings"])


def transient(model, duration):
    """A motion of radau."""
    problem = discretise(model)
    system = GeometricSystem(problem)
    integrator = Radau(system, SupportState(problem), tolerance=1e-4)
    control = ErrorControl(integrator.estimate_order, duration / 10, duration)
    return Transient(problem, integrator, control), State.reference(problem)


def require_same_rest(make, duration):
    """Compare the end of a motion with that of one that goes on from a checkpoint; return the account of the first."""
    whole, state = transient(make(), duration)
    end = whole.run(state, duration).history.snapshots[-1]
    first, state = transient(make(), duration)
    half = first.run(
        state, duration, after_step=lambda: "enough" if first.integrator.t > duration / 2 else ""
    )
    assert half.outcome is Outcome.INTERRUPTED
    assert half.between_steps
    second, state = transient(make(), duration)
    rest = second.run(state, duration, checkpoint=first.saved()).history.snapshots[-1]
    for one, other in zip(end[1:4], rest[1:4], strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(end.state.r, rest.state.r)
    np.testing.assert_array_equal(end.state.multiplier, rest.state.multiplier)
    for joints, others in zip(end.joints or (), rest.joints or (), strict=True):
        np.testing.assert_array_equal(joints, others)
    assert second.account.recorded == whole.account.recorded
    np.testing.assert_array_equal(second.account.branches, whole.account.branches)
    if end.branch_strain is not None:
        np.testing.assert_array_equal(end.branch_strain, rest.branch_strain)
    return whole.account

"""Step control without an integrator: made-up reports, so that every rule can be seen."""

from __future__ import annotations

import numpy as np
import pytest

from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators.contract import StepReport
from viscorod.solve.transient.step_control import HALVINGS, PATIENCE, ErrorControl, FixedSteps


def report(error=1.0, outcome=Outcome.CONVERGED, iterations=3):
    return StepReport(outcome, iterations, 0.0, 0.0, 0, error)


def march(control, corner, judge, t=0.0, first=None, limit=2000):
    """Ends of the accepted steps up to a corner, and the steps that were rejected."""
    control.begin(t, corner, first=first)
    ends, rejected = [], []
    for _ in range(limit):
        end = control.next_end(t)
        assert t < end <= corner
        if control.accepts(judge(t, end - t), end - t):
            t = end
            ends.append(end)
            if t == corner:
                return np.array(ends), rejected
        else:
            rejected.append(end - t)
            if control.exhausted:
                return np.array(ends), rejected
        if control.exhausted:
            return np.array(ends), rejected
    raise AssertionError("the corner was not reached")


@pytest.mark.parametrize("corner", [0.1 + 0.2, 1 / 3, 1.0, 0.07])
def test_fixed_steps_are_equal_and_end_at_the_corner(corner):
    """Closed form: the fewest equal steps not longer than the given one."""
    control = FixedSteps(0.01)
    ends, rejected = march(control, corner, lambda t, h: report())
    assert ends[-1] == corner
    assert not rejected
    count = int(np.ceil(corner / 0.01 - 1e-9))
    assert np.diff(ends, prepend=0.0) == pytest.approx(np.full(count, corner / count), rel=1e-9)
    assert control.limit == "the given step"


def test_fixed_steps_are_halved_and_recover():
    """A step that fails is tried at half its size until it succeeds; full steps come back, on their grid."""

    def judge(t, h):
        hard = 0.3 <= t < 0.5 and h > 0.03
        return report(outcome=Outcome.DIVERGED if hard else Outcome.CONVERGED)

    ends, rejected = march(FixedSteps(0.1), 3.0, judge)
    assert rejected[:2] == pytest.approx([0.1, 0.05])
    steps = np.diff(ends, prepend=0.0)
    assert steps.min() == pytest.approx(0.025)
    assert steps[-5:] == pytest.approx([0.1] * 5)
    assert ends[-1] == 3.0
    grid = np.arange(1, 31) / 10
    assert np.abs(ends[:, None] - grid).min(axis=0).max() < 1e-12


def test_fixed_steps_give_up():
    """After twelve halvings."""
    control = FixedSteps(0.1)
    ends, rejected = march(control, 1.0, lambda t, h: report(outcome=Outcome.SLOW))
    assert control.exhausted
    assert len(ends) == 0
    assert rejected == pytest.approx(0.1 * 0.5 ** np.arange(HALVINGS + 1))
    assert control.limit == "convergence of Newton's method"


def control_of(**given):
    return ErrorControl(**({"order": 3, "largest": 0.5, "duration": 10.0} | given))


@pytest.mark.parametrize("corner", [0.1 + 0.2, 1 / 3, 1.0, 7.7])
def test_corners_are_hit_exactly_without_a_tiny_step(corner):
    """The last two steps share what is left."""
    ends, _ = march(control_of(), corner, lambda t, h: report(error=(h / 0.13) ** 4), first=0.1)
    assert ends[-1] == corner
    steps = np.diff(ends, prepend=0.0)
    assert steps[-1] > 0.2 * steps.max()


def test_steps_follow_the_error():
    """Closed form: where the error is (h/h0)^4 with a varying h0, steps come near h0 and never err too much."""

    def ideal(t):
        return 0.05 * (1.0 + 0.9 * np.sin(t))

    ends, rejected = march(control_of(), 10.0, lambda t, h: report(error=(h / ideal(t)) ** 4), first=1e-4)
    steps = np.diff(ends, prepend=0.0)
    begin = ends - steps
    assert np.all(steps <= ideal(begin) * (1 + 1e-12))  # accepted errors are at most one
    settled = begin > 0.1
    assert np.median((steps / ideal(begin))[settled]) > 0.6
    assert len(rejected) < 0.2 * len(ends)


def test_first_step_and_growth_are_limited():
    """A first step after a jump, then growth by at most five up to the largest step."""
    control = control_of()
    ends, _ = march(control, 10.0, lambda t, h: report(error=0.0), first=1e-3)
    steps = np.diff(ends, prepend=0.0)
    assert steps[0] == 1e-3
    assert np.max(steps[1:] / steps[:-1]) <= 5.0 + 1e-9
    assert steps.max() == pytest.approx(0.5)
    assert control.limit in ("the largest allowed step", "the next corner of loads or motions")


def test_first_step_is_named():
    """What limits the first step is the beginning, or the jump before it."""
    for t, name in ((0.0, "the beginning of the run"), (1.0, "the jump at its start")):
        control = control_of()
        control.begin(t, 10.0, first=1e-3)
        assert control.accepts(report(), control.next_end(t) - t)
        assert control.limit == name


@pytest.mark.parametrize(
    ("bad", "name"),
    [
        (report(error=20.0), "the error"),
        (report(error=1.01), "the error"),
        (report(outcome=Outcome.DIVERGED), "convergence of Newton's method"),
    ],
)
def test_rejected_steps_shrink(bad, name):
    """A step that errs too much or does not converge is tried again, shorter; the reason is kept."""
    control = control_of()
    control.begin(0.0, 10.0, first=0.4)
    before = control.next_end(0.0)
    assert not control.accepts(bad, before)
    after = control.next_end(0.0)
    assert 0.1 * before <= after <= 0.9 * before * (1 + 1e-12)
    assert control.accepts(report(error=0.5), after)
    assert control.limit == name
    assert control.next_end(after) - after <= after * (1 + 1e-9)  # no growth right after a failure
    assert not control.notes_failures


def test_steps_stay_equal_where_growth_is_small():
    """Steps that could grow by less than a fifth stay, so that factors are used again."""
    ends, _ = march(control_of(largest=0.1), 5.0, lambda t, h: report(error=(h / 0.1) ** 4 * 0.5), first=0.09)
    steps = np.diff(ends, prepend=0.0)
    assert len(set(np.round(steps[:-2], 12))) <= 2


def test_a_step_cut_at_a_corner_does_not_shorten_the_next():
    """The planned step is taken up again behind a corner."""
    control = control_of()
    march(control, 1.03, lambda t, h: report(error=(h / 0.13) ** 4), first=0.1)
    control.begin(1.03, 10.0, first=None)
    assert control.next_end(1.03) - 1.03 > 0.08


def test_crawling_is_noticed():
    """Steps that never reach the end: shrinking ones, and tiny ones that all succeed."""
    control = control_of()
    march(control, 10.0, lambda t, h: report(error=1e9), first=0.1)
    assert control.exhausted
    control = control_of()
    ends, _ = march(control, 10.0, lambda t, h: report(error=(h / 1e-10) ** 4), first=1e-10)
    assert control.exhausted
    assert len(ends) == PATIENCE
    assert ends[-1] < 1e-5

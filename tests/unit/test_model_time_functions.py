"""Functions of time: values, derivatives against differences, limits from the left, breakpoints."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from viscorod.errors import AccuracyWarning, InputError
from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.time_function import Constant, Ramp, Sine, SmoothRamp, SpinUp, Until
from viscorod.model.actions.time_function_kinds import time_function
from viscorod.model.actions.time_table import TimeTable

WAVY = ([0.0, 0.5, 1.2, 2.0, 3.0], [1.0, -1.0, 2.0, 0.5, 0.0])
SMOOTH = (np.linspace(0.0, 3.0, 13), np.sin(2.0 * np.linspace(0.0, 3.0, 13)))
FUNCTIONS = [
    Constant(3.0),
    Until(1.0),
    Ramp(0.5, 2.0, 4.0),
    SmoothRamp(0.5, 2.0, 4.0),
    Sine(0.7, 2.0, 0.3, 1.0),
    SpinUp(6.0, 2.5),
    TimeTable(*WAVY),
    TimeTable(*SMOOTH, "cubic"),
    TimeTable(*WAVY, "monotone"),
    TimeTable([0.0, 1.0, 1.0, 2.0], [1.0, 2.0, -1.0, 0.0]),
    TimeTable([0.0, 0.5, 1.0, 1.0, 1.5, 2.0, 2.5], [1.0, 1.5, 1.8, 0.0, 1.0, 2.0, 2.5], "cubic"),
    FunctionOfTime(lambda t: t**3, lambda t: 3 * t**2, lambda t: 6 * t),
]


@pytest.mark.parametrize("f", FUNCTIONS, ids=lambda f: f.kind)
def test_derivatives(f):
    h = 1e-5
    for t in np.linspace(-0.6, 3.7, 44):
        if any(abs(t - b) < 2 * h for b in f.breakpoints):
            continue
        assert f.rate(t) == pytest.approx((f.value(t + h) - f.value(t - h)) / (2 * h), abs=1e-6)
        assert f.acceleration(t) == pytest.approx((f.rate(t + h) - f.rate(t - h)) / (2 * h), abs=1e-3)


@pytest.mark.parametrize("f", FUNCTIONS, ids=lambda f: f.kind)
def test_limits_from_the_left(f):
    for t in [*f.breakpoints, 0.3]:
        near = math.nextafter(t, -1.0)
        assert f.value(t, before=True) == pytest.approx(f.value(near), abs=1e-12)
        assert f.rate(t, before=True) == pytest.approx(f.rate(near), abs=1e-12)
        assert f.acceleration(t, before=True) == pytest.approx(f.acceleration(near), abs=1e-12)
        if t not in f.jumps:
            assert f.value(t, before=True) == pytest.approx(f.value(t), abs=1e-12)
    assert set(f.jumps) <= set(f.breakpoints)
    assert list(f.breakpoints) == sorted(f.breakpoints)


def test_a_smooth_ramp_starts_and_stops_without_a_blow():
    """Half of the way at half of the time, its largest speed twice the mean, no speed and acceleration at the ends."""
    f = SmoothRamp(1.0, 3.0, 0.5)
    assert (f.value(1.0), f.value(2.0), f.value(3.0), f.value(9.0)) == pytest.approx(
        (0.0, 0.25, 0.5, 0.5), abs=1e-15
    )
    assert f.rate(2.0) == pytest.approx(2.0 * 0.5 / 2.0)
    for t in (0.5, 1.0, 3.0, 4.0):
        assert (f.rate(t), f.acceleration(t)) == pytest.approx((0.0, 0.0), abs=1e-14)
    assert not f.jumps
    with pytest.raises(InputError, match="after its start"):
        SmoothRamp(1.0, 1.0)


def test_until():
    f = Until(0.0, 2.0)
    assert (f.value(-1.0), f.value(0.0, before=True), f.value(0.0), f.value(1.0)) == (2.0, 2.0, 0.0, 0.0)
    assert f.jumps == f.breakpoints == (0.0,)


def test_ramp():
    f = Ramp(1.0, 3.0)
    assert [f.value(t) for t in (0.0, 1.0, 1.5, 3.0, 9.0)] == [0.0, 0.0, 0.25, 1.0, 1.0]
    assert f.breakpoints == (1.0, 3.0)
    assert f.jumps == ()


def test_spin_up_is_the_manoeuvre_of_the_literature():
    """psi = 6/15 [t^2/2 + (15/2pi)^2 (cos(2 pi t/15) - 1)] until 15 s, 6 t - 45 after (Simo and Vu-Quoc 1986)."""
    f = SpinUp(6.0, 15.0)
    for t in (0.0, 1.0, 4.0, 11.3, 15.0):
        angle = 6 / 15 * (t**2 / 2 + (15 / (2 * math.pi)) ** 2 * (math.cos(2 * math.pi * t / 15) - 1))
        assert f.value(t) == pytest.approx(angle, abs=1e-13)
    assert f.value(20.0) == pytest.approx(75.0, rel=1e-15)
    assert f.rate(20.0) == pytest.approx(6.0, rel=1e-15)
    assert f.acceleration(7.5) == pytest.approx(0.8, rel=1e-14)


def test_linear_table():
    f = TimeTable([0.0, 1.0, 1.0, 3.0], [0.0, 2.0, 5.0, 7.0])
    assert [f.value(t) for t in (-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0)] == [0.0, 0.0, 1.0, 5.0, 6.0, 7.0, 7.0]
    assert f.value(1.0, before=True) == 2.0
    assert (f.rate(1.0, before=True), f.rate(1.0), f.rate(3.0, before=True), f.rate(3.0)) == (
        2.0,
        1.0,
        1.0,
        0.0,
    )
    assert f.breakpoints == (0.0, 1.0, 3.0)
    assert f.jumps == (1.0,)


def test_cubic_table_is_the_spline():
    f, spline = TimeTable(*SMOOTH, "cubic"), CubicSpline(*SMOOTH)
    for t in np.linspace(0.0, 2.99, 30):
        assert f.value(t) == pytest.approx(spline(t), abs=1e-13)
        assert f.acceleration(t) == pytest.approx(spline(t, 2), abs=1e-12)
    assert f.breakpoints == (0.0, 3.0)


def test_a_spline_that_overshoots_is_monotone():
    """A shock of 1 ms between zeros 5 s away, whose spline would go to -9e5; a doubt says so. Fritsch-Butland: none."""
    t = np.linspace(5.0, 5.001, 51)
    points = [0.0, *t, 10.0], [0.0, *np.sin(np.pi * (t - 5.0) / 1e-3), 0.0]
    with pytest.warns(
        AccuracyWarning, match="cubic spline through the table would reach -9.11e\\+05 at t = 1.6688 s"
    ):
        shock = TimeTable(*points, "cubic")
    values = [shock.value(x) for x in np.linspace(0.0, 10.0, 2001)] + [shock.value(x) for x in t]
    assert (min(values), max(values)) == (min(points[1]), max(points[1]))
    monotone = TimeTable(*points, "monotone")
    assert [shock.rate(x) for x in t] == [monotone.rate(x) for x in t]
    assert monotone.breakpoints == tuple(points[0])


@pytest.mark.parametrize("interpolation", ["linear", "cubic"])
def test_tables_are_equal_if_they_were_given_the_same(interpolation):
    """What a table has worked out, an array, does not count."""
    times = [0.0, 1.0, 3.0]
    table = TimeTable(times, [1.0, 2.0, 0.0], interpolation)
    assert table == TimeTable(np.array(times), (1, 2, 0), interpolation)
    assert hash(table) == hash(TimeTable(times, [1.0, 2.0, 0.0], interpolation))
    assert table != TimeTable(times, [1.0, 2.0, 0.1], interpolation)
    assert table != Constant(1.0)


def test_repeated_time_with_one_value_is_a_corner_not_a_jump():
    f = TimeTable([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0], "cubic")
    assert f.jumps == ()
    assert f.breakpoints == (0.0, 1.0, 2.0)


def test_python_functions():
    f = time_function(lambda t: 2.0 * t)
    assert isinstance(f, FunctionOfTime)
    assert f.value(3.0) == 6.0
    with pytest.raises(InputError, match="needs its velocity and acceleration"):
        f.rate(1.0)
    with pytest.raises(InputError, match=r"at t = 1 s: the number must be finite"):
        FunctionOfTime(lambda t: math.nan).value(1.0)
    step = FunctionOfTime(lambda t: float(t >= 1.0), breakpoints=[1.0, 0.5])
    assert step.breakpoints == (0.5, 1.0)
    assert step.jumps == (1.0,)


def test_a_function_may_return_an_array_of_no_dimension():
    spline = CubicSpline([0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
    assert isinstance(spline(1.0), np.ndarray)
    assert FunctionOfTime(spline).value(1.0) == pytest.approx(1.0)


def test_numbers_and_tables_are_functions_of_time():
    assert time_function(2) == Constant(2.0)
    assert time_function({"kind": "ramp", "start": 0, "end": 1}) == Ramp(0.0, 1.0)


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Ramp(1.0, 1.0), "Ramp.end", "after its start"),
        (lambda: Sine(0.0), "Sine.frequency", "> 0"),
        (lambda: Sine(-1.0), "Sine.frequency", "> 0"),
        (lambda: SpinUp(6.0, 0.0), "SpinUp.duration", "> 0"),
        (lambda: Until(math.nan), "Until.time", "finite"),
        (lambda: TimeTable([0.0, 1.0], [1.0]), "TimeTable.values", "2"),
        (lambda: TimeTable([0.0, 1.0], [1.0, 2.0, 3.0]), "TimeTable.values", "as many"),
        (lambda: TimeTable([0.0], [1.0]), "TimeTable.times", "at least 2"),
        (lambda: TimeTable([0.0, -1.0], [1.0, 1.0]), "TimeTable.times[1]", "not decrease"),
        (lambda: TimeTable([0, 1, 1, 1], [1, 2, 3, 4]), "TimeTable.times[3]", "three times"),
        (lambda: TimeTable([0, "x"], [1, 2]), "TimeTable.times[1]", "number"),
        (lambda: TimeTable([0, 1], [1, 2], "quadratic"), "TimeTable.interpolation", "'linear', 'cubic'"),
        (lambda: TimeTable([0, 1e-280], [1e59, -1e59]), "TimeTable", "change the units"),
        (lambda: time_function("ramp"), "", "function of time"),
        (lambda: time_function(True), "", "function of time"),
        (lambda: time_function({"kind": "rmap"}), "kind", "did you mean 'ramp'"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=text) as caught:
        build()
    assert caught.value.problems[0].where == path

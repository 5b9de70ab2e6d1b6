"""Loads that compiled code knows as functions of time are those of Python."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

import viscorod as vr
from helpers.loaded_rods import ROWS, loaded_rod
from viscorod.mechanics.nodes.load_courses import LoadSums, course_at, sum_loads
from viscorod.model.actions.time_function import TimeFunction
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.problem.load_courses import course_loads

FUNCTIONS = [
    None,
    vr.Constant(0.7),
    vr.Until(0.2, 1.3),
    vr.Ramp(0.05, 0.21, 1.7),
    vr.SmoothRamp(0.05, 0.21, 1.7),
    vr.Sine(3.1, amplitude=0.8, phase=0.3, offset=0.1),
    vr.SpinUp(2.0, 0.17),
    vr.TimeTable(*ROWS),
    vr.TimeTable(*ROWS, interpolation="monotone"),
    vr.TimeTable([0.0, 0.1, 0.2, 0.3], [0.0, 0.1, 0.15, 0.12], interpolation="cubic"),
]


@njit(error_model="numpy")
def values(formula, numbers, first, times, before, out):
    """Evaluate a function of time at many times."""
    for k in range(times.shape[0]):
        out[k] = course_at(formula, numbers, first, times[k], before)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda one: type(one).__name__)
def test_functions_of_time_are_the_same_bit_for_bit(function):
    """At 500 times, at corners from both sides, and before and after a table."""
    model = loaded_rod(vr.Model(), [function])
    given = course_loads(ExternalLoads(discretise(model)))
    times = np.concatenate([np.linspace(-0.1, 0.5, 500), [0.05, 0.1, 0.17, 0.2, 0.21, 0.25, 0.3]])
    out = np.empty(len(times))
    for before in (False, True):
        values(given.formulas[0], given.numbers, given.begins[0], times, before, out)
        expected = [1.0 if function is None else function.value(float(t), before) for t in times]
        np.testing.assert_array_equal(out, expected)


@njit(error_model="numpy")
def sums_at(given, t, before, sums):
    """Sum loads at one instant."""
    sum_loads(given, t, before, 0, sums)


@pytest.mark.parametrize("t", [0.0, 0.04, 0.1, 0.13, 0.2, 0.28, 0.4])
@pytest.mark.parametrize("before", [False, True])
def test_sums_are_the_same_bit_for_bit(t, before):
    """All kinds together, with gravity, and forces at an arm, whose levers turn with the section."""
    model = loaded_rod(vr.Model(), FUNCTIONS, until=0.28)
    model.gravity((0, 0, -9.81))
    model.add("box", vr.Body.box((0.35, 0, 0), (0.1, 0.1, 0.1), 10.0, points={"corner": (0.4, 0.05, 0.05)}))
    model.attach("rod.end", "box")
    model.force("box.corner", (1.0, 2.0, 3.0), time=FUNCTIONS[3])
    for function in FUNCTIONS[:3]:
        model.drag("rod", linear_across=0.1, time=function, until=0.28)
    problem = discretise(model)
    loads = ExternalLoads(problem)
    count, places = len(problem.nodal_loads) + len(problem.motion_loads), len(loads.motion.nodes)
    sums = LoadSums.of(1, count, problem.size, places=places, offset=loads.offset)
    expected = loads.at(t, before)
    assert loads.offset
    for _ in range(2):  # nothing is done again where factors stay
        sums_at(course_loads(loads), t, before, sums)
        np.testing.assert_array_equal(sums.dead[0], expected.dead)
        np.testing.assert_array_equal(sums.following[0], expected.following)
        np.testing.assert_array_equal(sums.gravity[0], expected.gravity)
        np.testing.assert_array_equal(sums.levers[0], expected.levers)
        np.testing.assert_array_equal(sums.moving[0], expected.factors)
        assert sums.acting[0] == float(len(expected.nodes) > 0)


class OwnFunction(TimeFunction):
    """A function of time that nobody knows."""

    def value(self, t, before=False):
        return t

    def rate(self, t, before=False):
        return 1.0

    def acceleration(self, t, before=False):
        return 0.0


def test_other_functions_and_loads_are_left_to_python():
    known = loaded_rod(vr.Model(), FUNCTIONS)
    assert course_loads(ExternalLoads(discretise(known))) is not None
    model = loaded_rod(vr.Model(), [vr.FunctionOfTime(math.sin)])
    assert course_loads(ExternalLoads(discretise(model))) is None
    model = loaded_rod(vr.Model(), [OwnFunction()])
    assert course_loads(ExternalLoads(discretise(model))) is None
    known.moving_force("rod", (0, 0, 1.0), speed=1.0)
    assert course_loads(ExternalLoads(discretise(known))) is None

"""Where functions of the arc length bend or jump, and the elements that end there."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.model.sections.section_kinks import kinks
from viscorod.solve.problem.chosen_divisions import chosen_divisions
from viscorod.solve.problem.discretise import discretise


def stations(seed, count):
    rng = np.random.default_rng(seed)
    places = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, count - 1))])
    return places / places[-1], rng.uniform(0.5, 2.0, count)


@pytest.mark.parametrize("count", [3, 21, 61])
def test_stations_of_a_table_are_found(count):
    """Closed form: a table that is linear in between has its kinks at its stations."""
    places, values = stations(count, count)
    found = kinks(lambda s: np.array([np.interp(s / 30.0, places, values), 1.0]), 30.0)
    np.testing.assert_allclose(found, 30.0 * places[1:-1], atol=30.0 * 1e-9)


def test_a_jump_and_a_kink_on_a_slope_are_found():
    found = kinks(lambda s: np.array([np.exp(-3.0 * s) + (s > 0.3337), 0.1 * abs(s - 0.7123)]), 1.0)
    np.testing.assert_allclose(found, [0.3337, 0.7123], atol=1e-9)


@pytest.mark.parametrize(
    "smooth",
    [lambda s: 1.0 + s**3, lambda s: np.exp(-50.0 * s), np.sqrt, lambda s: np.sin(20.0 * s), lambda _: 2.0],
)
def test_a_smooth_function_has_none(smooth):
    assert kinks(lambda s: np.array([smooth(s)]), 1.0) == []


def tapering(**mesh):
    places, values = stations(5, 9)

    def section(s):
        return vr.StiffnessSection([1e6, 1e6, 1e6, *[100.0 * np.interp(s, places, values)] * 3], [1.0] * 6)

    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, **mesh))
    return model, places


def test_elements_end_at_kinks():
    model, places = tapering()
    division = chosen_divisions(model)["rod"]
    for s in places:
        assert np.abs(division.ends - s).min() < 1e-9
    assert 2 <= division.order <= 5


def test_given_elements_stay():
    model, _ = tapering(elements=3, order=4)
    division = chosen_divisions(model)["rod"]
    assert division.order == 4
    np.testing.assert_allclose(division.ends, [0.0, 1 / 3, 2 / 3, 1.0])
    assert discretise(model).size == 13


def test_a_function_may_name_its_stations():
    class Table:
        stations = np.array([0.0, 0.123, 1.0])

        def __call__(self, s):
            return vr.StiffnessSection([1e6] * 3 + [1.0 + s] * 3, [1.0] * 6)

    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=Table())
    assert rod.kinks == (0.123,)

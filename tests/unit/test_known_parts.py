"""Cases that are read with the parts of the ones before: each is what it is when it is read alone."""

import copy
import tomllib
from pathlib import Path

import numpy as np
import pytest

import viscorod as vr
from helpers.strip import content
from viscorod.analyses.case_run import discretised_case
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.case_keys import put
from viscorod.casefile.known_parts import KnownParts, same
from viscorod.model.centrelines.centreline import MOST_KNOWN

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))


def numbers(value, path=()):
    """The places of all numbers of a content."""
    if isinstance(value, dict):
        return [one for key, item in value.items() for one in numbers(item, (*path, key))]
    if isinstance(value, list):
        return [one for k, item in enumerate(value) for one in numbers(item, (*path, k))]
    return [path] if isinstance(value, int | float) and not isinstance(value, bool) else []


def with_number(data, path, factor):
    changed = copy.deepcopy(data)
    place = changed
    for part in path[:-1]:
        place = place[part]
    place[path[-1]] *= factor
    return changed


def read(data, source, known=None):
    """What a case is, or why it is refused."""
    try:
        return case_from_dict(data, source, known=known).to_dict()
    except vr.InputError as error:
        return str(error)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_number_of_the_shipped_cases(path):
    """Each number is changed by itself, one after the other: right values, wrong ones, and back."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    places = numbers(data)
    chosen = np.unique(np.linspace(0, len(places) - 1, 12, dtype=int))
    known = KnownParts()
    for place in (places[k] for k in chosen):
        for factor in (1.01, -1.0, 1):
            changed = with_number(data, place, factor)
            assert read(changed, path, known) == read(changed, path), place


def arrays(case):
    problem = discretised_case(case).problem
    part = problem.sets[0]
    return [problem.positions, problem.quaternions, problem.mass, part.stiffness, part.damping]


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("materials.rubber.youngs_modulus", [1e6, 2e6, "3 MPa", 1e6]),
        (
            "materials.rubber.damping",
            [{"shear_time": 0.01, "bulk_time": 0.02}, {"shear_time": 0.03, "bulk_time": 0.03}],
        ),
        ("sections.thin.width", [0.01, 0.02, "12 mm"]),
        ("rods.beam.end", [[0.3, 0.0, 0.0], [0.2, 0.1, 0.0], [0.3, -0.0, 0.0]]),
        ("rods.beam.twist", [0.0, 0.1, -0.0, 0.2]),
        ("rods.beam.d1", [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]),
        ("rods.beam.elements", [1, 2, 3, 1]),
    ],
)
def test_the_arrays_are_the_same_bits(key, values):
    known = KnownParts()
    for value in values:
        data = content("equilibrium")
        put(data, key, value)
        alone, beside = arrays(case_from_dict(data)), arrays(case_from_dict(data, known=known))
        assert all(a.tobytes() == b.tobytes() for a, b in zip(alone, beside, strict=True))


def test_what_did_not_change_is_not_read_again():
    known, data = KnownParts(), content("equilibrium")
    before = case_from_dict(data, known=known).description
    data = copy.deepcopy(data)
    data["loads"][0]["value"] = [0.0, 2e-3, 0.0]
    after = case_from_dict(data, known=known).description
    assert after.rods["beam"] is before.rods["beam"]
    assert after.loads[0] is not before.loads[0]
    data["materials"]["rubber"]["density"] = 1100.0
    last = case_from_dict(data, known=known).description
    assert last.rods["beam"] is not before.rods["beam"]
    assert last.rods["beam"].centreline is before.rods["beam"].centreline


@pytest.mark.parametrize(
    ("one", "other", "equal"),
    [
        (1, 1.0, False),
        (1, True, False),
        (0.0, -0.0, False),
        (float("nan"), float("nan"), False),
        (0.1, 0.1 + 0.0, True),
        ("a", "a", True),
        ([1, 2], [1, 2], True),
        ([1, 2], [1], False),
        ((1,), [1], False),
        ({"a": 1, "b": 2}, {"a": 1, "b": 2}, True),
        ({"a": 1, "b": 2}, {"b": 2, "a": 1}, False),
        ({"a": {"b": [0.0]}}, {"a": {"b": [-0.0]}}, False),
        (object(), object(), False),
    ],
)
def test_what_is_the_same(one, other, equal):
    assert same(one, other) is equal


def test_frames_that_are_known_stay_what_they_are():
    """They are handed out as copies, and their number is bounded."""
    line = case_from_dict(content("equilibrium")).description.rods["beam"].centreline
    position, frames = line.frames([0.0, 0.1])
    position[:], frames[:] = 7.0, 7.0
    again = line.frames([0.0, 0.1])
    assert np.allclose(again[0], [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    assert np.allclose(again[1] @ again[1].transpose(0, 2, 1), np.eye(3))
    for k in range(3 * MOST_KNOWN):
        line.frames([0.001 * k])
    assert len(line._known_frames) <= MOST_KNOWN

"""Every wrong case file ends in one readable message: random damage to the shipped cases and to one of everything.

Whatever is done to a case, it must load into finite numbers or raise an `InputError` that names what is wrong, why, and
what to give instead; any other exception fails the test.
"""

import copy
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from viscorod.cases.case import case_from_dict, load_case
from viscorod.cases.shipped import shipped_cases
from viscorod.errors import InputError

FILES = {**shipped_cases(), "everything": Path(__file__).with_name("everything.toml")}
TEXTS = {name: path.read_text(encoding="utf-8") for name, path in FILES.items()}
CASES = {name: tomllib.loads(text) for name, text in TEXTS.items()}

NESTED: object = 1.0
for _ in range(60):
    NESTED = [{"a": NESTED}]

VALUES = st.sampled_from(
    [
        -1.0,
        0.0,
        -0.0,
        1,
        0.7,
        1e300,
        1e-300,
        -1e300,
        1e59,
        1e-59,
        -1e59,
        1e20,
        1e-20,
        math.nan,
        math.inf,
        -math.inf,
        10**400,
        True,
        False,
        "",
        "x",
        "beam.start",
        "rod.end",
        "straight",
        "\u0000\u2603'\"",
        "y" * 5000,
        [],
        {},
        [0.0, 0.0, 0.0],
        [1.0, 0.0],
        [1.0, 2.0, 3.0, 4.0],
        [math.nan] * 3,
        [1e200] * 6,
        [-1.0] * 6,
        [[1.0] * 6] * 6,
        ["ux", "ux"],
        [{}],
        {"kind": "ramp"},
        {"kind": "table", "times": [0.0, 0.0, 0.0], "values": [1.0, 2.0, 3.0]},
        {"shape": "circle", "radius": -1.0},
        NESTED,
    ]
)


def spots(node, path=()):
    """All places in nested dicts and lists, as paths."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in items:
        yield (*path, key)
        yield from spots(child, (*path, key))


def typo(key, data):
    """`key` with one character dropped, doubled, swapped or replaced (an empty key gets one)."""
    if not key:
        return "q"
    at = data.draw(st.integers(0, len(key) - 1))
    kind = data.draw(st.sampled_from(["drop", "double", "swap", "replace", "case"]))
    if kind == "drop":
        return key[:at] + key[at + 1 :]
    if kind == "double":
        return key[:at] + key[at] + key[at:]
    if kind == "swap":
        return key[:at] + key[at : at + 2][::-1] + key[at + 2 :]
    return key[:at] + (key[at].upper() if kind == "case" else "q") + key[at + 1 :]


def damage(case, data):
    """Change one place of the case in one of several ways."""
    path = data.draw(st.sampled_from(list(spots(case))))
    parent = case
    for key in path[:-1]:
        parent = parent[key]
    key, value = path[-1], parent[path[-1]]
    kind = data.draw(st.sampled_from(["delete", "rename", "replace", "negate", "length", "nest", "add"]))
    if kind == "delete":
        del parent[key]
    elif kind == "rename" and isinstance(parent, dict):
        parent[typo(key, data)] = parent.pop(key)
    elif kind == "negate" and isinstance(value, int | float) and not isinstance(value, bool):
        parent[key] = -value
    elif kind == "length" and isinstance(value, list) and value:
        parent[key] = data.draw(st.sampled_from([value[:-1], [*value, value[-1]]]))
    elif kind == "nest":
        parent[key] = data.draw(st.sampled_from([[value], {"a": value}, {"kind": value}]))
    elif kind == "add" and isinstance(parent, dict):
        parent[typo(key, data)] = copy.deepcopy(value)
    else:
        parent[key] = copy.deepcopy(data.draw(VALUES))


def toml(value):
    """A value as TOML text, all tables in line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return "nan" if math.isnan(value) else repr(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return '"' + "".join(c if c.isalnum() and c.isascii() else f"\\u{ord(c):04x}" for c in value) + '"'
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return "{" + ", ".join(f"{toml(key)} = {toml(item)}" for key, item in value.items()) + "}"


def loads_or_tells(path):
    """Load the file; check the model or the message."""
    told = None
    try:
        case = load_case(path)
    except InputError as error:
        told = error
    if told is not None:
        assert told.problems
        assert str(path) in str(told)
        for problem in told.problems:
            assert problem.where, str(told)
            assert problem.why, str(told)
            assert problem.instead, str(told)
            assert len(str(problem)) < 1500
        return
    assert case.to_dict()
    for rod in case.description.rods.values():
        positions, frames = rod.frames(np.linspace(0.0, rod.length, 3))
        assert np.isfinite(positions).all()
        assert np.isfinite(frames).all()
        if rod.material is not None and rod.material.pending:
            continue
        for matrix in rod.matrices_at(0.0):
            assert np.isfinite(matrix).all()
        for array in rod.branches_at(0.0):
            assert np.isfinite(array).all()
            assert (array >= 0.0).all() or array.ndim == 3


RELAXED = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]


def test_undamaged_cases_load_and_come_back():
    for name, path in FILES.items():
        case = load_case(path)
        again = case_from_dict(case.to_dict())
        assert again.to_dict() == case.to_dict(), name


@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
@settings(max_examples=120, deadline=None, suppress_health_check=RELAXED)
def test_damaged_content(name, data, tmp_path):
    case = copy.deepcopy(CASES[name])
    for _ in range(data.draw(st.integers(1, 3))):
        if case:
            damage(case, data)
    path = tmp_path / "case.toml"
    path.write_text(
        "\n".join(f"{toml(key)} = {toml(value)}" for key, value in case.items()), encoding="utf-8"
    )
    loads_or_tells(path)


@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=RELAXED)
def test_damaged_text(name, data, tmp_path):
    text = TEXTS[name]
    for _ in range(data.draw(st.integers(1, 3))):
        at, size = data.draw(st.integers(0, len(text))), data.draw(st.integers(0, 20))
        text = (
            text[:at]
            + data.draw(st.sampled_from(["", "=", "[", "]", '"', "\n", "#", "-", "\x00", "é", ","]))
            + text[at + size :]
        )
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    loads_or_tells(path)


@given(content=st.binary(max_size=300))
@settings(max_examples=100, deadline=None, suppress_health_check=RELAXED)
def test_any_bytes(content, tmp_path):
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    loads_or_tells(path)

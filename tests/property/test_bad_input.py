"""Every wrong case file ends in one readable message: random damage to the shipped cases and to one of everything.

Whatever is done to a case, it must load into finite numbers or raise an `InputError` that names what is wrong, why, and
what to give instead; any other exception fails the test.
"""

import copy

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers.damaged_cases import CASES, FILES, TEXTS, damage, toml
from viscorod.casefile.case import case_from_dict, load_case
from viscorod.errors import InputError


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
@settings(max_examples=48, suppress_health_check=RELAXED)
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
@settings(max_examples=24, suppress_health_check=RELAXED)
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
@settings(max_examples=100, suppress_health_check=RELAXED)
def test_any_bytes(content, tmp_path):
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    loads_or_tells(path)

"""Damaged cases that load are checked and computed for a few steps: a message or finite numbers, in bounded time.

Every shipped case, and one of everything, is made coarse and short, then damaged at random. ``make fuzz`` runs 10 000
examples of each; here are a few, the same each time.
"""

import copy
import signal
import time
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers.damaged_cases import CASES, VALUES, damage, spots
from viscorod.analyses.case_run import run_case
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import case_from_dict
from viscorod.errors import InputError, SolveError

EXAMPLES = settings.default.max_examples if settings.default.max_examples > 1000 else 1
LIMIT = 300
"""Seconds of processor time for one example, which takes a twentieth unless kernels are compiled for it."""
ANALYSES = {"equilibrium": {}, "path": {"points": 6}, "steady": {"spin": [0.0, 0.0, 4.0]}}
STEPS = 6
KINDS = st.sampled_from(["own", *ANALYSES])
RELAXED = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]


@contextmanager
def time_limit(seconds):
    def stop(number, frame):
        raise TimeoutError(f"no message and no result within {seconds} s of processor time")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def short(case, analysis="own"):
    """The case with few elements and a short analysis: its own, or another one of the same model."""
    case = copy.deepcopy(case)
    if analysis != "own":
        for word in ("simulate", *ANALYSES):
            case.pop(word, None)
        case[analysis] = copy.deepcopy(ANALYSES[analysis])
    for rod in case["rods"].values():
        rod.pop("elements", None)
        rod["order"] = 2
        if "turns" in rod:
            rod["turns"] = min(rod["turns"], 1.0)
    if "simulate" in case:
        part = case["simulate"]
        part["duration"] = part["duration"] / 200.0
        if "time_step" in part:
            part["time_step"] = min(part["time_step"], part["duration"])
        part.pop("output_interval", None)
    for table, few in (
        ("path", "points"),
        ("periodic", "points"),
        ("campbell", "count"),
        ("stability", "count"),
    ):
        if table in case:
            case[table][few] = 6
    return case


def told(error):
    """Whether a message has all its parts."""
    for problem in error.problems:
        assert problem.why, str(error)
        assert len(str(problem)) < 1500


def finite(data):
    for name, variable in data.variables.items():
        if variable.dtype.kind == "f":
            assert np.isfinite(variable.values).all(), name


def computed_or_told(content):
    """Load, check and compute a case; what it came to, for counting."""
    count, ends = 0, time.process_time() + 0.1 * LIMIT

    def progress(*_reached):
        nonlocal count
        count += 1

    def stop():
        return "enough" if count >= STEPS or time.process_time() > ends else ""

    with time_limit(LIMIT):
        try:
            case = case_from_dict(content)
        except InputError as error:
            told(error)
            return "refused"
        try:
            report = check(DiscreteModel.of(case.description), case.settings)
            assert np.isfinite(report.frequencies).all()
            assert np.isfinite(report.damping_ratios).all()
            finite(run_case(case, progress=progress, stop=stop).data)
        except InputError as error:
            told(error)
            return "told"
        except SolveError as error:
            if error.run is not None:
                finite(error.run.data)
            return "stopped"
    return "computed"


@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
@settings(max_examples=EXAMPLES, suppress_health_check=RELAXED)
def test_damaged_cases_are_computed_or_told(name, data):
    content = short(CASES[name], data.draw(KINDS))
    for _ in range(data.draw(st.integers(1, 2))):
        if content:
            damage(content, data)
    computed_or_told(content)


@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
@settings(max_examples=EXAMPLES, suppress_health_check=RELAXED)
def test_changed_numbers_are_computed_or_told(name, data):
    """Only the numbers change, so that most cases are computed."""
    content = short(CASES[name], data.draw(KINDS))
    numbers = [path for path in spots(content) if _is_number(_at(content, path))]
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(numbers))
        parent, value = _at(content, path[:-1]), _at(content, path)
        factor = data.draw(st.sampled_from([-1.0, 0.0, 1e-12, 1e-6, 1e-3, 0.5, 1.5, 10.0, 1e3, 1e6, 1e12]))
        parent[path[-1]] = value * factor if isinstance(value, float) else int(value * factor)
    computed_or_told(content)


@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
@settings(max_examples=5 * EXAMPLES, suppress_health_check=RELAXED)
def test_no_key_is_ignored(name, data):
    """A key that nothing reads is refused wherever it stands, except where keys are names of the user."""
    content = copy.deepcopy(CASES[name])
    tables = [path for path in [(), *spots(content)] if isinstance(_at(content, path), dict)]
    path = data.draw(st.sampled_from(tables))
    value = data.draw(VALUES)
    names = len(path) == 1 and path[0] in {"materials", "sections", "rods", "bodies"}
    names = names or (len(path) > 1 and path[0] == "bodies" and path[-1] == "points")
    if not names:
        _at(content, path)["nothing_reads_this"] = value
        with pytest.raises(InputError, match="nothing_reads_this"):
            case_from_dict(content)


def _is_number(value):
    return isinstance(value, int | float) and not isinstance(value, bool)


def _at(content, path):
    for key in path:
        content = content[key]
    return content

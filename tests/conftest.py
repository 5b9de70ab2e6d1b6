"""One outcome for one version of the code: the same random examples each time, and nothing skipped where CI runs."""

import functools
import gc
import os

import pytest
import typer.testing
from hypothesis import HealthCheck, settings

# tests run side by side: threads of the linear algebra would only wait for each other
os.environ.setdefault("OMP_NUM_THREADS", "1")

pytest.register_assert_rewrite("helpers.measured_orders")

# the commands are the same at every call, as they are in a process of their own, which makes them once
if hasattr(typer.testing, "_get_command"):  # not public: a version without it takes longer
    typer.testing._get_command = functools.cache(typer.testing._get_command)

# how long an example takes says something about the machine, not about the code
ANY_SPEED = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("same", derandomize=True, **ANY_SPEED)
settings.register_profile("search", print_blob=True, **ANY_SPEED)
settings.register_profile("fuzz", print_blob=True, max_examples=10_000, **ANY_SPEED)
settings.load_profile("same")


def pytest_collection_finish():
    """Let the search for garbage leave out what was imported and collected: it is large, and it stays."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Let a test that was skipped fail if VISCOROD_NO_SKIPS is set: everything that tests need is to be there."""
    report = yield
    if report.skipped and not hasattr(report, "wasxfail") and os.environ.get("VISCOROD_NO_SKIPS"):
        report.outcome, report.longrepr = "failed", f"not to be skipped: {report.longrepr[2]}"
    return report

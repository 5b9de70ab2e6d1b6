"""Contract: Ctrl-C that meets compiled code of a library, a SystemError to Python, is Ctrl-C to the user."""

from pathlib import Path

import pytest

import viscorod as vr
from helpers.stopped_runs import swing
from viscorod.errors import came_of_interrupt, reading
from viscorod.results.quantities import evaluated, quantities_of


def as_compiled_code_tells(*_):
    """Raise what Python raises where a signal was handled within an ``__exit__`` of Cython."""
    try:
        raise KeyboardInterrupt
    except KeyboardInterrupt as interrupt:
        raise SystemError("__exit__ returned a result with an exception set") from interrupt


def test_a_file_that_was_being_read_is_not_called_damaged():
    with pytest.raises(KeyboardInterrupt), reading(Path("run.nc")):
        as_compiled_code_tells()
    with pytest.raises(vr.InputError, match="damaged"), reading(Path("run.nc")):
        raise SystemError("of another kind")


def test_a_run_ends_as_by_ctrl_c():
    with pytest.raises(KeyboardInterrupt):
        swing().simulate(0.1, progress=as_compiled_code_tells)


def test_a_quantity_does_not_fail_of_it():
    quantities = quantities_of({"tip": as_compiled_code_tells}, "simulate")
    with pytest.raises(KeyboardInterrupt):
        evaluated(quantities, object())


def test_other_errors_are_no_interrupts():
    assert not came_of_interrupt(SystemError())
    assert not came_of_interrupt(ValueError("a" * 10))


def test_a_function_of_time_does_not_fail_of_it():
    model = swing()
    model.force("beam.end", (0, 0, 1e-3), time=as_compiled_code_tells)
    with pytest.raises(KeyboardInterrupt):
        model.simulate(0.1)

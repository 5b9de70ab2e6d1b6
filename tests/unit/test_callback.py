"""Python functions called from compiled code."""

from __future__ import annotations

import numpy as np
import pytest

from viscorod.mechanics.compilation.callback import Callback, call
from viscorod.mechanics.compilation.compiled import kernel


@kernel
def call_both(first, second, values):
    call(first, values.ctypes, values.shape[0])
    call(second, values[1:].ctypes, 1)


def test_compiled_code_calls_python_functions():
    def square(numbers):
        numbers[:] = numbers**2

    seen = []
    squared, noted = Callback(square), Callback(lambda numbers: seen.append(numbers.copy()))
    numbers = np.array([2.0, 3.0, 4.0])
    call_both(squared.address, noted.address, numbers)
    np.testing.assert_array_equal(numbers, [4.0, 9.0, 16.0])
    np.testing.assert_array_equal(seen, [[9.0]])
    call_both(noted.address, squared.address, numbers)
    np.testing.assert_array_equal(numbers, [4.0, 81.0, 16.0])


def test_errors_of_python_functions_are_raised_afterwards():
    def fail(numbers):
        raise KeyError(int(numbers[0]))

    failing = Callback(fail)
    numbers = np.array([2.0, 3.0])
    call_both(failing.address, failing.address, numbers)
    assert np.isnan(numbers).all()
    with pytest.raises(KeyError, match="2"):
        failing.check()
    failing.check()  # once is enough

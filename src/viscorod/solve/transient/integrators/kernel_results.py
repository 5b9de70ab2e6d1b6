"""What the kernels return that steps and the compiled loop of steps call through their addresses."""

from __future__ import annotations

from typing import Any

from numba import types

__all__ = ["ATTEMPTED", "ENDED", "EXTENT", "NOTHING", "NUMBER", "REAL", "TURNED"]

_tuple: Any = types.Tuple
NOTHING, NUMBER, REAL = types.none, types.int64, types.float64
TURNED = _tuple((types.float64, types.int64))
ATTEMPTED = _tuple((types.int64,) * 2 + (types.float64,) * 2 + (types.int64, types.float64, types.int64))
ENDED, EXTENT = _tuple((types.float64,) * 5), _tuple((types.float64,) * 2)

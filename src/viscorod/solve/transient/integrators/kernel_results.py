"""What the kernels return that the compiled loop of steps calls through their addresses."""

from __future__ import annotations

from typing import Any

from numba import types

__all__ = ["ATTEMPTED", "ENDED", "EXTENT", "NOTHING", "NUMBER", "TURNED"]

_tuple: Any = types.Tuple
NOTHING, NUMBER, TURNED = types.none, types.int64, _tuple((types.float64, types.int64))
ATTEMPTED = _tuple((types.int64,) * 2 + (types.float64,) * 2 + (types.int64, types.float64, types.int64))
ENDED, EXTENT = _tuple((types.float64,) * 5), _tuple((types.float64,) * 2)

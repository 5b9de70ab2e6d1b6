"""Arrays as text in a page: 16 bits a value, differences in time, deflated, base64.

Neighbouring states differ little, so that differences of their integers deflate well; low and high bytes are stored
apart for the same reason. Reading goes backwards through the same steps (``static/data.js``).
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

from viscorod.typing import Floats

__all__ = ["LEVELS", "Pack"]

LEVELS = 65535
"""Steps between the smallest and the largest value of a quantised array: its error is half a step at most."""
_LEVEL = 6  # of the deflation: 9 takes three times as long for 2 % less


class Pack:
    """Named arrays, to be put into a page."""

    def __init__(self) -> None:
        self._blocks: list[bytes] = []
        self._index: dict[str, dict[str, Any]] = {}
        self._offset = 0

    def quantised(self, name: str, values: Floats, components: int = 1) -> None:
        """Add an array whose first axis is time.

        Args:
            name: of the array.
            values: ``(states, ...)``; its last axis has a range of its own per component if there are several.
            components: of the last axis, 1 for one range of all.
        """
        flat = np.ascontiguousarray(values, dtype=float).reshape(len(values), -1, components)
        low = flat.min(axis=(0, 1), initial=np.inf) if flat.size else np.zeros(components)
        high = flat.max(axis=(0, 1), initial=-np.inf) if flat.size else np.zeros(components)
        step = (high - low) / LEVELS
        safe = np.where(step > 0.0, step, 1.0)
        whole = np.rint((flat - low) / safe).astype(np.uint16).reshape(len(values), -1)
        change = np.diff(whole, axis=0, prepend=np.zeros((1, whole.shape[1]), dtype=np.uint16))
        halves = change.astype("<u2").reshape(-1).view(np.uint8).reshape(-1, 2)
        self._add(
            name, halves.T.tobytes(), values.shape, kind="quantised", low=low.tolist(), step=step.tolist()
        )

    def plain(self, name: str, values: Floats) -> None:
        """Add an array in single precision."""
        self._add(name, np.ascontiguousarray(values, dtype="<f4").tobytes(), np.shape(values), kind="float32")

    def whole(self, name: str, values: Any) -> None:
        """Add an array of integers that are not negative."""
        self._add(name, np.ascontiguousarray(values, dtype="<u4").tobytes(), np.shape(values), kind="uint32")

    def _add(self, name: str, data: bytes, shape: tuple[int, ...], **more: Any) -> None:
        self._index[name] = {"offset": self._offset, "bytes": len(data), "shape": list(shape), **more}
        padding = -len(data) % 4  # typed arrays start at multiples of four bytes
        self._blocks.append(data + bytes(padding))
        self._offset += len(data) + padding

    @property
    def index(self) -> dict[str, dict[str, Any]]:
        """Where each array is in the inflated bytes, and how to read it."""
        return self._index

    def text(self) -> str:
        """Return all arrays: base64 of the zlib stream (RFC 1950) of the blocks."""
        deflate = zlib.compressobj(_LEVEL)
        pieces = [deflate.compress(block) for block in self._blocks]
        return base64.b64encode(b"".join((*pieces, deflate.flush()))).decode("ascii")

"""Colour maps that readers with any kind of colour vision tell apart."""

from __future__ import annotations

import numpy as np

__all__ = ["colour_tables"]

_SHADES = 64
_SIGNED, _ONE_SIGN = "coolwarm", "viridis"


def colour_tables() -> dict[str, list[list[int]]]:
    """Return the colours (sRGB, 0 to 255) of fields of one sign ("plain") and of both ("signed")."""
    from matplotlib import colormaps

    at = np.linspace(0.0, 1.0, _SHADES)
    return {
        key: np.rint(255.0 * colormaps[name](at)[:, :3]).astype(int).tolist()
        for key, name in (("plain", _ONE_SIGN), ("signed", _SIGNED))
    }

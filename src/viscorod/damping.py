"""The former name of :mod:`viscorod.programs`."""

from __future__ import annotations

import warnings

from viscorod import programs


def __getattr__(name: str) -> object:
    value = getattr(programs, name)
    warnings.warn(
        f"viscorod.damping.{name} is now viscorod.programs.{name}", DeprecationWarning, stacklevel=2
    )
    return value

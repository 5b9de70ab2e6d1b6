"""Which steps are tried again in halves: numbers for ``halved_steps`` and for the compiled loop of steps."""

from __future__ import annotations

__all__ = ["FARTHEST", "FIRST", "LONGER", "PART", "SETTLED"]

FIRST = 1
"""The first step that is tried again, counted from 0."""
FARTHEST, PART = 32, 4
"""Most steps to the next one early in a run, and later the part of those done."""
SETTLED, LONGER = 8, 2.0
"""After so many steps one that is so much longer than those tried again is one of them."""

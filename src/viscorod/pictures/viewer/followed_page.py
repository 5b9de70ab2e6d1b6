"""The page of modes that are followed along a speed or a load: Campbell diagrams, stability."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.pictures.viewer.curve_parts import CurveParts, places
from viscorod.results.campbell import Campbell
from viscorod.results.followed_modes import FollowedModes
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats

__all__ = ["followed_page"]

OVERDAMPED = 0.9
"""Damping ratio from which on a mode may leave the picture."""


def followed_page(result: FollowedModes, most: int) -> CurveParts:
    """Return the page of modes along a speed or a load."""
    page = _FollowedPage(result, most)
    page.add_frequencies()
    page.add_damping_ratios()
    page.add_chosen_place()
    page.add_critical_speeds()
    page.add_limits()
    page.add_meetings()
    return page.parts


class _FollowedPage:
    """The parts of the page, added one by one.

    Attributes:
        scale, hz: of frequencies as shown, and their unit; along: what the modes are followed along.
        dashed, hertz, ratio, rate: rows of the modes, where they grow [1], of frequencies, damping ratios [%] and
            rates of growth [1/s].
    """

    def __init__(self, result: FollowedModes, most: int) -> None:
        self.result = result
        self.turning = result if isinstance(result, Campbell) else None
        self.scale, self.hz = scaled("Hz", result.frequencies)
        word, unit = ("load factor", "") if self.turning is None else ("angular speed", "rad/s")
        self.along = f"{word} [{unit}]" if unit else word
        heading = f"{result.what[:1].upper()}{result.what[1:]}"
        if self.turning is not None:
            seen = "on the model that turns" if self.turning.frame == "turning" else "from space"
            heading += f", frequencies as seen {seen}"
        chosen = places(len(result.values), most)
        self.parts = parts = CurveParts(heading, (word, unit), result.values, chosen)
        grows = (result.eigenvalues.real > 1e-7 * np.abs(result.eigenvalues))[chosen]
        self.dashed = parts.rows(grows.T)
        self.hertz = parts.rows(self.scale * result.frequencies[chosen].T)
        self.ratio = parts.rows(100.0 * result.damping_ratios[chosen].T)
        self.rate = parts.rows(result.eigenvalues.real[chosen].T)

    def add_frequencies(self) -> None:
        """Add the diagram: frequencies, critical speeds or limits of stability on them, and engine orders."""
        self.parts.chart(
            "Frequencies",
            self.along,
            f"frequency [{self.hz}]",
            self._curves(self.hertz),
            marks=self._critical_marks() + self._limit_marks(),
            guides=self._engine_orders(),
            range=[0.0, 1.06 * self.scale * float(self.result.frequencies.max()) or 1.0],
            follows=True,
        )

    def add_damping_ratios(self) -> None:
        """Add the diagram of damping ratios."""
        self.parts.chart(
            "Damping ratios; dashed where a mode grows", self.along, "damping ratio [%]", self._curves(self.ratio),
            range=_range(100.0 * self.result.damping_ratios), follows=True,
        )  # fmt: skip

    def add_chosen_place(self) -> None:
        """Add the table of all modes at the chosen place."""
        head = ["mode", f"frequency [{self.hz}]", "damping ratio [%]", "growth [1/s]"]
        cells: list[list[Any]] = [
            [name, (self.hertz, k), (self.ratio, k), (self.rate, k)]
            for k, name in enumerate(self.result.modes)
        ]
        if self.turning is not None:
            whirl = self.parts.rows(self.turning.whirl[self.parts.chosen].T)
            head, cells = [*head, "whirl"], [[*row, (whirl, k)] for k, row in enumerate(cells)]
        self.parts.live(head, cells)

    def add_critical_speeds(self) -> None:
        """Add the table of speeds at which an engine order meets a mode."""
        if self.turning is None:
            return
        self.parts.table(
            "Critical speeds",
            ["mode", "order", "[rad/s]", "[rpm]", f"[{self.hz}]"],
            [
                [one.mode, one.order, one.speed, one.speed * 30.0 / np.pi, self.scale * one.frequency]
                for one in self.turning.critical_speeds
            ],
        )

    def add_limits(self) -> None:
        """Add the table of places at which a mode begins or ceases to grow."""
        self.parts.table(
            "Limits of stability",
            ["mode", self.along, "what", f"[{self.hz}]"],
            [
                [
                    one.mode,
                    one.at,
                    f"{'begins' if one.unstable else 'ends'}: {one.kind}",
                    self.scale * one.frequency,
                ]
                for one in self.result.limits
            ],
        )

    def add_meetings(self) -> None:
        """Add the table of frequencies that cross or veer."""
        self.parts.table(
            "Frequencies that meet, as seen on the model",
            ["modes", "they", f"near {self.along}", f"[{self.hz}]"],
            [
                [
                    ", ".join(one.modes),
                    "cross" if one.crosses else "veer",
                    one.at,
                    self.scale * one.frequency,
                ]
                for one in self.result.meetings
            ],
        )

    def _curves(self, rows: str) -> list[dict[str, Any]]:
        """Return a curve of every mode over the places, in a colour of its own."""
        x = self.parts.meta["slider"]["places"]
        return [
            self.parts.curve(name, (x, 0), (rows, k), dashed=(self.dashed, k), colour=k)
            for k, name in enumerate(self.result.modes)
        ]

    def _limit_marks(self) -> list[dict[str, Any]]:
        return [
            self._mark(
                one.at,
                one.frequency,
                f"{one.mode} {'begins' if one.unstable else 'ceases'} to grow: {one.kind}",
                "limit of stability",
            )
            for one in self.result.limits
        ]

    def _critical_marks(self) -> list[dict[str, Any]]:
        found = () if self.turning is None else self.turning.critical_speeds
        return [
            self._mark(
                one.speed,
                one.frequency,
                f"critical speed of {one.mode}, order {one.order:g}",
                "critical speed",
            )
            for one in found
        ]

    def _engine_orders(self) -> list[dict[str, Any]]:
        """Return lines of frequencies that are multiples of the speed."""
        if self.turning is None:
            return []
        end = float(self.result.values[-1])
        return [
            {"x": [0.0, end], "y": [0.0, self.scale * order * end / (2.0 * np.pi)], "text": f"{order:g}x"}
            for order in self.turning.engine_orders
        ]

    def _mark(self, at: float, frequency: float, text: str, kind: str) -> dict[str, Any]:
        return {"x": at, "y": self.scale * frequency, "text": text, "kind": kind}


def _range(shown: Floats) -> list[float]:
    """Return the ends of an axis of damping ratios [%] on which zero and what is not overdamped is seen."""
    mild = shown[np.abs(shown) < 100.0 * OVERDAMPED]
    low, high = min(float(mild.min(initial=0.0)), 0.0), max(float(mild.max(initial=0.0)), 0.0)
    margin = 0.08 * (high - low) or 1.0
    return [low - margin, high + margin]

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
    chosen = places(len(result.values), most)
    whirls = isinstance(result, Campbell)
    scale, hz = scaled("Hz", result.frequencies)
    word, unit = ("angular speed", "rad/s") if whirls else ("load factor", "")
    along = f"{word} [{unit}]" if unit else word
    seen = ""
    if isinstance(result, Campbell):
        seen = f", frequencies as seen {'on the model that turns' if result.frame == 'turning' else 'from space'}"
    parts = CurveParts(
        f"{result.what[:1].upper()}{result.what[1:]}{seen}", (word, unit), result.values, chosen
    )
    grows = (result.eigenvalues.real > 1e-7 * np.abs(result.eigenvalues))[chosen]
    x, dashed = parts.meta["slider"]["places"], parts.rows(grows.T)
    hertz, ratio = (
        parts.rows(scale * result.frequencies[chosen].T),
        parts.rows(100.0 * result.damping_ratios[chosen].T),
    )
    rate = parts.rows(result.eigenvalues.real[chosen].T)
    modes = range(len(result.modes))

    def curves(y: str) -> list[dict[str, Any]]:
        return [
            parts.curve(name, (x, 0), (y, k), dashed=(dashed, k), colour=k)
            for k, name in zip(modes, result.modes, strict=True)
        ]

    def mark(at: float, frequency: float, text: str, kind: str) -> dict[str, Any]:
        return {"x": at, "y": scale * frequency, "text": text, "kind": kind}

    limits = [
        mark(
            one.at,
            one.frequency,
            f"{one.mode} {'begins' if one.unstable else 'ceases'} to grow: {one.kind}",
            "limit of stability",
        )
        for one in result.limits
    ]
    marks, guides = limits, []
    if isinstance(result, Campbell):
        marks = [
            mark(
                one.speed,
                one.frequency,
                f"critical speed of {one.mode}, order {one.order:g}",
                "critical speed",
            )
            for one in result.critical_speeds
        ] + limits
        end = float(result.values[-1])
        guides = [
            {"x": [0.0, end], "y": [0.0, scale * order * end / (2.0 * np.pi)], "text": f"{order:g}x"}
            for order in result.engine_orders
        ]
    top = 1.06 * scale * float(result.frequencies.max()) or 1.0
    parts.chart(
        "Frequencies",
        along,
        f"frequency [{hz}]",
        curves(hertz),
        marks=marks,
        guides=guides,
        range=[0.0, top],
        follows=True,
    )
    parts.chart(
        "Damping ratios; dashed where a mode grows", along, "damping ratio [%]", curves(ratio),
        range=_range(100.0 * result.damping_ratios), follows=True,
    )  # fmt: skip
    head = ["mode", f"frequency [{hz}]", "damping ratio [%]", "growth [1/s]"]
    cells: list[list[Any]] = [
        [name, (hertz, k), (ratio, k), (rate, k)] for k, name in enumerate(result.modes)
    ]
    if isinstance(result, Campbell):
        whirl = parts.rows(result.whirl[chosen].T)
        head, cells = [*head, "whirl"], [[*row, (whirl, k)] for k, row in enumerate(cells)]
        parts.table(
            "Critical speeds",
            ["mode", "order", "[rad/s]", "[rpm]", f"[{hz}]"],
            [
                [one.mode, one.order, one.speed, one.speed * 30.0 / np.pi, scale * one.frequency]
                for one in result.critical_speeds
            ],
        )
    parts.live(head, cells)
    parts.table(
        "Limits of stability",
        ["mode", along, "what", f"[{hz}]"],
        [
            [one.mode, one.at, f"{'begins' if one.unstable else 'ends'}: {one.kind}", scale * one.frequency]
            for one in result.limits
        ],
    )
    parts.table(
        "Frequencies that meet, as seen on the model",
        ["modes", "they", f"near {along}", f"[{hz}]"],
        [
            [", ".join(one.modes), "cross" if one.crosses else "veer", one.at, scale * one.frequency]
            for one in result.meetings
        ],
    )
    return parts


def _range(shown: Floats) -> list[float]:
    """Return the ends of an axis of damping ratios [%] on which zero and what is not overdamped is seen."""
    mild = shown[np.abs(shown) < 100.0 * OVERDAMPED]
    low, high = min(float(mild.min(initial=0.0)), 0.0), max(float(mild.max(initial=0.0)), 0.0)
    margin = 0.08 * (high - low) or 1.0
    return [low - margin, high + margin]

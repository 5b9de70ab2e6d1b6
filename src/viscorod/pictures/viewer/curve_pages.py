"""Pages of curves: Campbell diagrams, stability along a load, periodic motions, frequency responses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.viewer.curve_parts import CurveParts
from viscorod.pictures.viewer.page import curve_page, heading_of
from viscorod.results.campbell import Campbell
from viscorod.results.followed_modes import FollowedModes
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.results.periodic import Periodic
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats
from viscorod.wording import with_article

if TYPE_CHECKING:
    from viscorod.results.stateless_result import StatelessResult

__all__ = ["curves_of"]

OVERDAMPED = 0.9
"""Damping ratio from which on a mode may leave the picture."""
INSTANTS = 96
"""Of a cycle."""
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 181)


def curves_of(result: StatelessResult, most: int) -> str:
    """Return the text of the page of a result, with ``most`` places along its curves at most.

    Raises:
        InputError: results of this kind have no such page.
    """
    if isinstance(result, FollowedModes):
        parts = _followed(result, most)
    elif isinstance(result, Periodic):
        parts = _periodic(result, most)
    elif isinstance(result, FrequencyResponse):
        parts = _response(result, most)
    else:
        raise InputError(
            f"{with_article(result.what)} has no page in the browser; draw it with its method plot"
        )
    shown = len(parts.chosen)
    notes = [] if shown == parts.total else [f"{shown} of {parts.total} places along the curves are shown"]
    meta = {
        **parts.meta,
        "title": result.title,
        "heading": heading_of(result),
        "version": str(result.data.attrs.get("version", "")),
        "outcome": result.outcome,
        "warnings": result.warnings,
        "notes": notes,
    }
    return curve_page(result.title, meta, parts.pack)


def _chosen(count: int, most: int, kept: list[int] | None = None) -> np.ndarray:
    """Return numbers of ``count`` places, ``most`` of them evenly and those to be kept."""
    return np.unique([*np.linspace(0, count - 1, min(count, most)).round().astype(int), *(kept or [])])


def _followed(result: FollowedModes, most: int) -> CurveParts:
    """Return the page of modes along a speed or a load."""
    chosen = _chosen(len(result.values), most)
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

    limits = [
        {
            "x": one.at,
            "y": scale * one.frequency,
            "text": f"{one.mode} {'begins' if one.unstable else 'ceases'} to grow: {one.kind}",
            "kind": "limit of stability",
        }
        for one in result.limits
    ]
    marks, guides = limits, []
    if isinstance(result, Campbell):
        marks = [
            {
                "x": one.speed,
                "y": scale * one.frequency,
                "text": f"critical speed of {one.mode}, order {one.order:g}",
                "kind": "critical speed",
            }
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


def _periodic(result: Periodic, most: int) -> CurveParts:
    """Return the page of periodic motions: the curve, and the cycle of the motion that is chosen on it."""
    chosen = _chosen(len(result.frequencies), most, [k for k, _ in result.bifurcations])
    free = not result.inputs
    over = str(result.data.attrs.get("over", "frequency"))
    scale, hz = scaled("Hz", result.frequencies)
    kind = "free vibrations of a mode" if free else "forced motions"
    parts = CurveParts(
        f"Periodic motions, {kind}, {int(result.data.attrs['harmonics'])} harmonics",
        ("motion on the curve", hz),
        scale * result.frequencies,
        chosen,
    )
    known = bool((np.asarray(result.data["unstable"].values) >= 0).all())
    unstable = parts.rows((~result.stable[chosen])[None]) if known else None
    hertz, level = (
        parts.rows(scale * result.frequencies[chosen][None]),
        parts.rows(result.levels[chosen][None]),
    )
    x, along = (level, "factor of the amplitudes") if over == "level" else (hertz, f"frequency [{hz}]")
    dashed = None if unstable is None else (unstable, 0)
    units = [str(unit) for unit in result.data["output_unit"].values]
    output = parts.choice("Output", result.outputs)
    phase = parts.rows(np.linspace(0.0, 1.0, INSTANTS + 1)[None])
    rows: list[list[Any]] = [[f"frequency [{hz}]", (hertz, 0)], ["factor of the amplitudes", (level, 0)]]
    for k, (name, unit) in enumerate(zip(result.outputs, units, strict=True)):
        factor, name_of_unit = scaled(unit, result.amplitude(k))
        size = factor * result.amplitude(k)
        y, word = parts.rows(size[chosen][None]), f"amplitude [{name_of_unit}]"
        marks = [
            {
                "x": float((result.levels if over == "level" else scale * result.frequencies)[at]),
                "y": float(size[at]),
                "text": what,
                "kind": "fold or other bifurcation",
            }
            for at, what in result.bifurcations
        ]
        title = f"Amplitude of {name}" + (
            "; dashed where it is unstable" if known and not result.stable.all() else ""
        )
        parts.chart(
            title,
            along,
            word,
            [parts.curve(name, (x, 0), (y, 0), dashed=dashed)],
            marks=marks,
            when={output: k},
            follows=True,
        )
        cycles = np.array([result.course(int(p), k, INSTANTS)[1] for p in chosen])
        factor, cycle_unit = scaled(unit, cycles)
        course = parts.rows(factor * _closed(cycles))
        parts.chart(
            f"A cycle of {name}", "part of the period", f"[{cycle_unit}]",
            [parts.curve(name, (phase, 0), (course, -1), colour=1)], when={output: k}, side=True,
        )  # fmt: skip
        rows.append([f"amplitude of {name} [{name_of_unit}]", (y, 0)])
        if free:
            ratio = parts.rows(100.0 * result.damping_ratios[chosen][None])
            parts.chart(
                "Damping ratio over the amplitude", word, "damping ratio [%]",
                [parts.curve("damping ratio", (y, 0), (ratio, 0), colour=2)], when={output: k}, follows=True,
            )  # fmt: skip
    _energies(result, parts, (x, along), dashed)
    _loops(result, parts)
    _multipliers(result, parts)
    for words, values in (("work", result.work), ("loss", result.loss)):
        factor, joule = scaled("J", values)
        rows.append([f"{words} of a cycle [{joule}]", (parts.rows(factor * values[chosen][None]), 0)])
    rows.append(
        ["damping ratio, loss over 8 pi kinetic [1]", (parts.rows(result.damping_ratios[chosen][None]), 0)]
    )
    if known:
        counts = np.asarray(result.data["unstable"].values, dtype=float)[chosen][None]
        rows.append(["multipliers beyond 1 in size", (parts.rows(counts), 0)])
    parts.live(["of the chosen motion", ""], rows)
    parts.table(
        "Bifurcations",
        ["kind", "motion", f"[{hz}]", "level"],
        [
            [word, at + 1, scale * float(result.frequencies[at]), float(result.levels[at])]
            for at, word in result.bifurcations
        ],
    )
    return parts


def _closed(values: Floats) -> Floats:
    """Return courses ``(n, instants + 1)`` that end where they begin."""
    return np.concatenate([values, values[:, :1]], axis=1)


def _energies(
    result: Periodic, parts: CurveParts, x: tuple[str, str], dashed: tuple[str, int] | None
) -> None:
    if result.inputs:
        factor, unit = scaled("J", result.loss)
        loss = parts.rows(factor * result.loss[parts.chosen][None])
        parts.chart(
            "Energy lost in a cycle", x[1], f"loss [{unit}]",
            [parts.curve("loss", (x[0], 0), (loss, 0), dashed=dashed, colour=2)], follows=True,
        )  # fmt: skip


def _loops(result: Periodic, parts: CurveParts) -> None:
    """Add the hysteresis loop of every input that is a load."""
    conjugate = np.asarray(result.data["conjugate"].values)
    loads = [k for k in range(len(result.inputs)) if conjugate[:, k].any()]
    if not loads:
        return
    choice = parts.choice("Loop of", tuple(result.inputs[k] for k in loads))
    for number, k in enumerate(loads):
        found = np.array([result.loop(int(p), k, INSTANTS) for p in parts.chosen])
        unit = str(result.data["input_unit"].values[k])
        length, moves = scaled("rad" if unit == "N m" else "m", found[:, 0])
        size, loads_in = scaled(unit, found[:, 1])
        moved, force = parts.rows(length * _closed(found[:, 0])), parts.rows(size * _closed(found[:, 1]))
        parts.chart(
            f"Loop of {result.inputs[k]}: its area is the work of a cycle",
            f"{'rotation' if unit == 'N m' else 'displacement'} [{moves}]",
            f"[{loads_in}]",
            [parts.curve(result.inputs[k], (moved, -1), (force, -1), colour=2)],
            when={choice: number},
            side=True,
        )


def _multipliers(result: Periodic, parts: CurveParts) -> None:
    """Add the Floquet multipliers in the complex plane, with the unit circle."""
    found = result.multipliers[parts.chosen]
    if not found.shape[1]:
        return
    reach = 1.1 * max(1.0, min(float(np.abs(found).max()), 3.0))
    circle = {"x": np.cos(CIRCLE).tolist(), "y": np.sin(CIRCLE).tolist(), "text": ""}
    real, imaginary = parts.rows(found.real), parts.rows(found.imag)
    parts.chart(
        "Floquet multipliers: beyond the circle disturbances grow", "real", "imaginary",
        [parts.curve("multiplier", (real, -1), (imaginary, -1), colour=3, points=True)],
        guides=[circle], range=[-reach, reach], equal=True, side=True,
    )  # fmt: skip


def _response(result: FrequencyResponse, most: int) -> CurveParts:
    """Return the page of frequency responses: size and phase over frequency, and the complex plane."""
    peaks = [
        int(p)
        for k in range(len(result.outputs))
        for j in range(len(result.inputs))
        for p in _summits(np.abs(result.values[:, k, j]))
    ]
    chosen = _chosen(len(result.frequencies), most, peaks)
    scale, hz = scaled("Hz", result.frequencies)
    parts = CurveParts(
        f"Frequency response about {result.data.attrs.get('about', 'a state')}",
        ("frequency", hz),
        scale * result.frequencies,
        chosen,
    )
    output, source = parts.choice("Output", result.outputs), parts.choice("Input", result.inputs)
    x, rows = parts.meta["slider"]["places"], []
    for k, name in enumerate(result.outputs):
        for j, given in enumerate(result.inputs):
            value, when = result.values[chosen, k, j], {output: k, source: j}
            size, phase = (
                parts.rows(np.abs(value)[None]),
                parts.rows(np.degrees(np.unwrap(np.angle(value)))[None]),
            )
            real, imaginary = parts.rows(value.real[None]), parts.rows(value.imag[None])
            words, unit = f"{name} over {given}", result.unit(k, j)
            marks = [
                {
                    "x": scale * one.frequency,
                    "y": one.amplitude,
                    "text": f"peak {one.name or ''} at {scale * one.frequency:.6g} {hz}".replace("  ", " "),
                    "kind": "peak",
                }
                for one in result.resonances(k, j)
            ]
            log = ["y"] if np.abs(value).min() > 0.0 else []
            parts.chart(
                words,
                f"frequency [{hz}]",
                f"size [{unit}]",
                [parts.curve(words, (x, 0), (size, 0))],
                marks=marks,
                when=when,
                log=log,
                follows=True,
            )
            parts.chart(
                "Phase",
                f"frequency [{hz}]",
                "phase [degrees]",
                [parts.curve("phase", (x, 0), (phase, 0), colour=1)],
                when=when,
                follows=True,
            )
            parts.chart(
                "In the complex plane", f"real [{unit}]", f"imaginary [{unit}]",
                [parts.curve(words, (real, 0), (imaginary, 0), colour=2)],
                when=when, equal=True, side=True, follows=True,
            )  # fmt: skip
            rows.append([f"{words} [{unit}]", (size, 0), (phase, 0)])
            parts.table(
                f"Peaks of {words}, and damping ratios by three ways",
                ["peak of", f"at [{hz}]", f"size [{unit}]", "half power", "circle", "pole"],
                [
                    [
                        one.name or "-",
                        scale * one.frequency,
                        one.amplitude if one.resolved else f"> {one.amplitude:.5g}",
                        *("-" if d is None else d for d in (one.half_power, one.circle, one.pole)),
                    ]
                    for one in result.resonances(k, j)
                ],
            )
    parts.live(["response", "size", "phase [degrees]"], rows)
    return parts


def _summits(size: Floats) -> np.ndarray:
    """Return the numbers of values that are larger than their neighbours."""
    return 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))

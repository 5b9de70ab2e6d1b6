"""The page of periodic motions: curves over frequency or level, cycles, loops and multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.pictures.viewer.curve_parts import CurveParts, places
from viscorod.results.periodic import Periodic
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats

__all__ = ["periodic_page"]

INSTANTS = 96
"""Of a cycle."""
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 181)


def periodic_page(result: Periodic, most: int) -> CurveParts:
    """Return the page of periodic motions: the curve, and the cycle of the motion that is chosen on it."""
    chosen = places(len(result.frequencies), most, [k for k, _ in result.bifurcations])
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

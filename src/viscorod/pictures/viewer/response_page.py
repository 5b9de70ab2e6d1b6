"""The page of frequency responses: size, phase, the complex plane and the peaks."""

from __future__ import annotations

import numpy as np

from viscorod.pictures.viewer.curve_parts import CurveParts, places
from viscorod.results.frequency_response import FrequencyResponse, phases
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats

__all__ = ["response_page"]


def response_page(result: FrequencyResponse, most: int) -> CurveParts:
    """Return the page of frequency responses: size and phase over frequency, and the complex plane."""
    peaks = [
        int(p)
        for k in range(len(result.outputs))
        for j in range(len(result.inputs))
        for p in _summits(np.abs(result.values[:, k, j]))
    ]
    chosen = places(len(result.frequencies), most, peaks)
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
                parts.rows(phases(value)[None]),
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
                range=[-190.0, 190.0],
                turn=360.0,
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

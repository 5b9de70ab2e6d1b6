"""The page of frequency responses: size, phase, the complex plane and the peaks."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.pictures.viewer.curve_parts import CurveParts, places
from viscorod.results.frequency_response import FrequencyResponse, phases
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats

__all__ = ["response_page"]


def response_page(result: FrequencyResponse, most: int) -> CurveParts:
    """Return the page of frequency responses: size and phase over frequency, and the complex plane."""
    pairs = [(k, j) for k in range(len(result.outputs)) for j in range(len(result.inputs))]
    page = _ResponsePage(result, most, pairs)
    for k, j in pairs:
        page.add_response(k, j)
    page.parts.live(["response", "size", "phase [degrees]"], page.rows)
    return page.parts


class _ResponsePage:
    """The parts of the page.

    Attributes:
        scale, hz: of frequencies as shown, and their unit; x: their row.
        output, source: numbers of the choices; rows: of the table of the chosen frequency.
    """

    def __init__(self, result: FrequencyResponse, most: int, pairs: list[tuple[int, int]]) -> None:
        self.result = result
        self.scale, self.hz = scaled("Hz", result.frequencies)
        peaks = [int(p) for k, j in pairs for p in _summits(np.abs(result.values[:, k, j]))]
        self.parts = CurveParts(
            f"Frequency response about {result.data.attrs.get('about', 'a state')}",
            ("frequency", self.hz),
            self.scale * result.frequencies,
            places(len(result.frequencies), most, peaks),
        )
        self.output = self.parts.choice("Output", result.outputs)
        self.source = self.parts.choice("Input", result.inputs)
        self.x = self.parts.meta["slider"]["places"]
        self.rows: list[list[Any]] = []

    def add_response(self, k: int, j: int) -> None:
        """Add charts and peaks of output ``k`` over input ``j``."""
        result, parts = self.result, self.parts
        value = result.values[parts.chosen, k, j]
        words, unit = f"{result.outputs[k]} over {result.inputs[j]}", result.unit(k, j)
        shown: dict[str, Any] = {"when": {self.output: k, self.source: j}, "follows": True}
        along = f"frequency [{self.hz}]"
        size, phase = parts.rows(np.abs(value)[None]), parts.rows(phases(value)[None])
        real, imaginary = parts.rows(value.real[None]), parts.rows(value.imag[None])
        parts.chart(
            words, along, f"size [{unit}]", [parts.curve(words, (self.x, 0), (size, 0))],
            marks=self._peak_marks(k, j), log=["y"] if np.abs(value).min() > 0.0 else [], **shown,
        )  # fmt: skip
        parts.chart(
            "Phase", along, "phase [degrees]", [parts.curve("phase", (self.x, 0), (phase, 0), colour=1)],
            range=[-190.0, 190.0], turn=360.0, **shown,
        )  # fmt: skip
        parts.chart(
            "In the complex plane", f"real [{unit}]", f"imaginary [{unit}]",
            [parts.curve(words, (real, 0), (imaginary, 0), colour=2)], equal=True, side=True, **shown,
        )  # fmt: skip
        self.rows.append([f"{words} [{unit}]", (size, 0), (phase, 0)])
        self._add_peaks(k, j, words, unit)

    def _add_peaks(self, k: int, j: int, words: str, unit: str) -> None:
        """Add the table of the peaks of a response."""
        self.parts.table(
            f"Peaks of {words}, and damping ratios by three ways",
            ["peak of", f"at [{self.hz}]", f"size [{unit}]", "half power", "circle", "pole"],
            [
                [
                    one.name or "-",
                    self.scale * one.frequency,
                    one.amplitude if one.resolved else f"> {one.amplitude:.5g}",
                    *("-" if d is None else d for d in (one.half_power, one.circle, one.pole)),
                ]
                for one in self.result.resonances(k, j)
            ],
        )

    def _peak_marks(self, k: int, j: int) -> list[dict[str, Any]]:
        found = []
        for one in self.result.resonances(k, j):
            at = self.scale * one.frequency
            text = f"peak {one.name or ''} at {at:.6g} {self.hz}".replace("  ", " ")
            found.append({"x": at, "y": one.amplitude, "text": text, "kind": "peak"})
        return found


def _summits(size: Floats) -> np.ndarray:
    """Return the numbers of values that are larger than their neighbours."""
    return 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))

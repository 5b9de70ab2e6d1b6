"""The result of a frequency response: complex responses over frequency, their peaks, the poles."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.resonances import Resonance, resonances_of
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.results.summits import Summit, summit_of_response
from viscorod.results.text_numbers import number, per_cent, quantity
from viscorod.results.text_table import listed, numbers, page, tabulated, words
from viscorod.shown import counted, span
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["FrequencyResponse", "phases"]

VARIABLES: Variables = {
    "frequency": (("frequency",), "Hz", "frequency of the harmonic motion"),
    "input": (("input",), "", "what drives the model"),
    "output": (("output",), "", "what is read"),
    "part": (("part",), "", "real and imaginary"),
    "input_unit": (("input",), "", "unit of the input"),
    "output_unit": (("output",), "", "unit of the output"),
    "response": (("frequency", "output", "input", "part"), "", "output over input, exp(i omega t)"),
    "pole": (("mode", "part"), "1/s", "s of the free motion exp(s t)"),
    "residue": (
        ("mode", "output", "input", "part"),
        "",
        "of the part residue/(i omega - pole) of the response, 1/s times its unit",
    ),
    "pole_name": (
        ("mode",),
        "",
        "what most of the strain energy of the motion is in, and its number among these",
    ),
}
"""Name -> dimensions, unit and long name of every variable; all are always there."""


def phases(values: np.ndarray) -> Floats:
    """Return the phases of complex responses [degrees], from -180 to 180; that of an output that lags is negative.

    They are not continued beyond half a turn: between two frequencies far apart nobody knows how many turns there were.
    """
    found: Floats = np.degrees(np.angle(values))
    return found


class FrequencyResponse(StatelessResult):
    """Responses of a model to harmonic inputs about a state: output over input at every frequency.

    ``data`` is an ``xarray.Dataset`` with the real and imaginary parts of ``response`` by ``frequency`` [Hz],
    ``output`` and ``input``, in the units of output over input (SI), and the poles.
    """

    kind: ClassVar[str] = "response"
    picture: ClassVar[str] = "bode"
    what: ClassVar[str] = "frequency response"

    @classmethod
    def variables(cls) -> Variables:
        """See :class:`StatelessResult`."""
        return VARIABLES

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.outputs), "output")
        yield counted(len(self.inputs), "input")
        yield span(float(self.frequencies[0]), float(self.frequencies[-1]), "Hz")
        yield counted(len(self.poles), "pole")
        yield from super()._facts()

    def _curves(self) -> tuple[Floats, Floats]:
        size = np.abs(self.values[:, :1, 0])
        return self.frequencies, np.log10(np.maximum(size, np.finfo(float).tiny))

    @property
    def frequencies(self) -> Floats:
        """Frequencies [Hz], shape (n,)."""
        return np.asarray(self.data["frequency"].values, dtype=float)

    @property
    def inputs(self) -> tuple[str, ...]:
        """The inputs, in words."""
        return tuple(str(name) for name in self.data["input"].values)

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs, in words."""
        return tuple(str(name) for name in self.data["output"].values)

    @cached_property
    def values(self) -> np.ndarray:
        """All responses ``(frequencies, outputs, inputs)``, complex, SI units of output over input."""
        parts = np.asarray(self.data["response"].values, dtype=float)
        found: np.ndarray = parts[..., 0] + 1j * parts[..., 1]
        return found

    @property
    def poles(self) -> np.ndarray:
        """Poles ``s`` [1/s] of the free motions ``exp(s t)`` within the band and the next one, Im > 0.

        They are those of the whole model. Where moduli come from a table they are taken at the frequency of each pole.
        """
        real, imaginary = np.asarray(self.data["pole"].values, dtype=float).reshape(-1, 2).T
        found: np.ndarray = real + 1j * imaginary
        return found

    @property
    def residues(self) -> np.ndarray:
        """What each pole has in the responses, ``residue/(i omega - pole)``: ``(poles, outputs, inputs)``, complex."""
        parts = np.asarray(self.data["residue"].values, dtype=float)
        found: np.ndarray = parts[..., 0] + 1j * parts[..., 1]
        return found

    @property
    def moduli(self) -> list[str]:
        """Which complex moduli are not those of the law that motions are computed with, in sentences."""
        return [str(text) for text in json.loads(self.data.attrs.get("moduli_from", "[]"))]

    @checked
    def response(self, output: str | int = 0, source: str | int = 0) -> np.ndarray:
        """Return one response ``(frequencies,)``, complex.

        Args:
            output, source: the words of the output and of the input, or their numbers from 0.

        Raises:
            InputError: there is no such output or input.
        """
        k, j = self._number("output", output, self.outputs), self._number("source", source, self.inputs)
        found: np.ndarray = self.values[:, k, j]
        return found

    def unit(self, output: str | int = 0, source: str | int = 0) -> str:
        """Return the unit of a response: "m/N", "1" of a transmissibility.

        Args:
            output, source: names or numbers of an output and an input.

        Raises:
            InputError: there is no such output or input.
        """
        k, j = self._number("output", output, self.outputs), self._number("source", source, self.inputs)
        over, under = (
            str(self.data[name].values[at]) for name, at in (("output_unit", k), ("input_unit", j))
        )
        if over == under:
            return "1"
        if under == "1":
            return over
        left, right = (f"({text})" if any(c in text for c in " /") else text for text in (over, under))
        return f"{left}/{right}"

    @checked
    def amplification(self, output: str | int = 0, source: str | int = 0) -> Floats:
        """Return the size of a response ``(frequencies,)``, in its :meth:`unit`.

        Args:
            output, source: names or numbers of an output and an input.

        Raises:
            InputError: there is no such output or input.
        """
        return np.asarray(np.abs(self.response(output, source)))

    @checked
    def summit(self, output: str | int = 0, source: str | int = 0) -> Summit:
        """Return the top of the size of a response: number of the frequency next to it, frequency [Hz], size.

        It lies between the computed frequencies, as the poles and residues of the model tell the course between them.

        Args:
            output, source: names or numbers of an output and an input.

        Raises:
            InputError: there is no such output or input.
        """
        k, j = self._number("output", output, self.outputs), self._number("source", source, self.inputs)
        return summit_of_response(self.frequencies, self.values[:, k, j], self.poles, self.residues[:, k, j])

    def resonances(self, output: str | int = 0, source: str | int = 0) -> list[Resonance]:
        """Return the peaks of a response, with the damping ratios that are read off them beside those of the poles.

        Args:
            output, source: names or numbers of an output and an input.

        Raises:
            InputError: there is no such output or input.
        """
        k, j = self._number("output", output, self.outputs), self._number("source", source, self.inputs)
        return resonances_of(
            self.frequencies,
            self.values[:, k, j],
            (self.poles, self.residues[:, k, j]),
            [str(name) for name in self.data["pole_name"].values],
        )

    def report(self) -> str:
        """Return a report: band, peaks of every response with their damping, poles, warnings."""
        hertz = self.frequencies
        heading = f"{self.title + chr(10) if self.title else ''}Frequency response, {len(hertz)} frequencies"
        heading += f" from {quantity(hertz[0], 'Hz')} to {quantity(hertz[-1], 'Hz')}, "
        heading += f"about {self.data.attrs.get('about', 'a state')}"
        if "line_error" in self.data.attrs:
            heading += (
                f"\nLines between them follow every response to {per_cent(100.0 * self.data.attrs['line_error'])} "
                "(estimated)"
            )
        if "modal_error" in self.data.attrs:
            heading += (
                f"\nSolved in {int(self.data.attrs['modal_modes'])} modes with static correction: the direct solution "
                f"differs by {self.data.attrs['modal_error']:.2g} of the largest response where it was compared"
            )
        blocks = [
            heading,
            *([listed("Moduli", self.moduli)] if self.moduli else []),
        ]
        for j, source in enumerate(self.inputs):
            for k, target in enumerate(self.outputs):
                blocks.append(self._peaks(k, j, f"{target} over {source}, {self.unit(k, j)}"))
        if len(self.poles):
            ratios = (-self.poles.real / np.abs(self.poles)).tolist()
            blocks.append(
                tabulated(
                    "Poles",
                    words("mode", map(str, self.data["pole_name"].values)),
                    numbers(("frequency",), "Hz", np.abs(self.poles) / (2.0 * np.pi)),
                    words("damping ratio", [number(ratio, 5) for ratio in ratios]),
                )
            )
        if self.warnings:
            blocks.append(listed("Warnings", self.warnings))
        return page(blocks)

    def _peaks(self, k: int, j: int, title: str) -> str:
        found = self.resonances(k, j)
        if not found:
            size = self.amplification(k, j)
            if not size.any():
                return f"{title}: no response"
            return f"{title}: no peak; from {size.min():.5g} to {size.max():.5g}"
        by = {
            way: ["-" if ratio is None else number(ratio, 4) for ratio in ratios]
            for way, ratios in (
                ("half power", [one.half_power for one in found]),
                ("circle", [one.circle for one in found]),
                ("pole", [one.pole for one in found]),
            )
        }
        text = tabulated(
            f"{title}: peaks, and damping ratios by three ways",
            words("peak of", [one.name or "-" for one in found]),
            numbers(("at",), "Hz", [one.frequency for one in found]),
            words("size", [f"{'' if one.resolved else '> '}{one.amplitude:.5g}" for one in found]),
            *(words(way, cells) for way, cells in by.items()),
        )
        if all(one.resolved for one in found):
            return text
        return (
            f"{text}\n  >: the frequencies there are too far apart to see how high the peak is; give a band"
        )

    @checked
    def plot(self, path: str | Path | None = None, kind: str = "bode", *, ax: Axes | None = None) -> Figure:
        """Draw the responses.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            kind: "bode" (size and phase over frequency), "nyquist" (in the complex plane) or "space" (both over
                frequency, in three dimensions).
            ax: axes of yours to draw into: the sizes of the responses of the first unit, or the first response in the
                complex plane or in space.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such kind, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_response import draw_response

        return delivered(draw_response(self, kind, ax), path)

    @staticmethod
    def _number(what: str, given: str | int, known: tuple[str, ...]) -> int:
        if isinstance(given, str) and given in known:
            return known.index(given)
        if isinstance(given, int | np.integer) and -len(known) <= given < len(known):
            return int(given) % len(known)
        raise InputError(f"{what} = {given!r}: this response has {', '.join(map(repr, known))}")

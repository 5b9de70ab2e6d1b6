"""Results of modes that were followed along a parameter: roots over a speed or a load, limits, crossings."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.checks import checked
from viscorod.results.frequency_words import frequency_note
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.results.text_numbers import above_rounding, scaled
from viscorod.results.text_table import listed, page, table
from viscorod.shown import counted, span
from viscorod.typing import Floats

__all__ = ["FollowedModes", "Limit", "Meeting", "error_text"]


@known_arguments
@dataclass(frozen=True)
class Limit:
    """A value of the parameter at which a mode begins to grow, or ceases to.

    Attributes:
        at: speed [rad/s] or load factor; mode: its name; number: from 1.
        kind: "flutter", it oscillates, or "divergence"; unstable: whether it grows beyond.
        frequency: of the oscillation [Hz]; mesh_error: estimated error by the mesh, as a part of the value.
    """

    at: float
    mode: str
    number: int
    kind: str
    unstable: bool
    frequency: float
    mesh_error: float


@known_arguments
@dataclass(frozen=True)
class Meeting:
    """Two modes whose frequencies meet.

    Attributes:
        at: about where, speed [rad/s] or load factor; modes: names; crosses: they cross, or else veer.
        frequency: there [Hz]; gap: the least distance of both that was seen [Hz].
    """

    at: float
    modes: tuple[str, str]
    crosses: bool
    frequency: float
    gap: float


class FollowedModes(StatelessResult):
    """Modes followed along a parameter; ``data`` is an ``xarray.Dataset``."""

    along: ClassVar[str]
    """The dimension of the parameter."""
    unit: ClassVar[str]
    more: ClassVar[Variables] = {}
    """Variables beside those of all."""

    @classmethod
    def variables(cls) -> Variables:
        """Return the dimensions, units and long names of all variables."""
        p = cls.along
        return {
            p: ((p,), cls.unit, "parameter along which modes are followed"),
            "mode": (("mode",), "", "what most of the strain energy is in, and its number among these"),
            "part": (("part",), "", "real and imaginary"),
            "eigenvalue": ((p, "mode", "part"), "1/s", "s of the motion exp(s t), as seen on the model"),
            "frequency": (
                (p, "mode"),
                "Hz",
                "of the oscillation, |Im s| over 2 pi, in the frame of the diagram; natural ones are |s| over 2 pi",
            ),
            "damping_ratio": ((p, "mode"), "1", "-Re s over |s|, in the frame of the diagram"),
            "likeness": ((p, "mode"), "1", "MAC of the shape with the one next to it on the way"),
            "mesh_error": (("mode",), "1", "estimated error of the frequency by the mesh, in parts of it"),
            f"limit_{p}": (("limit",), cls.unit, "where a mode begins to grow or ceases to"),
            "limit_mode": (("limit",), "", "number of the mode from 0"),
            "limit_kind": (("limit",), "", "flutter or divergence"),
            "limit_unstable": (("limit",), "", "1 where it grows beyond, 0 where it ceases to"),
            "limit_frequency": (("limit",), "Hz", "of the oscillation"),
            "limit_error": (("limit",), "1", "estimated error by the mesh, in parts of the value"),
            f"meeting_{p}": (("meeting",), cls.unit, "about where two frequencies meet"),
            "meeting_modes": (("meeting", "pair"), "", "numbers of the modes from 0"),
            "meeting_crosses": (("meeting",), "", "1 where they cross, 0 where they veer"),
            "meeting_frequency": (("meeting",), "Hz", "there"),
            "meeting_gap": (("meeting",), "Hz", "least distance that was seen"),
        } | cls.more

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.modes), "mode")
        word = self.along.replace("_", " ")
        yield f"{word} {span(float(self.values[0]), float(self.values[-1]), '' if self.unit == '1' else self.unit)}"
        yield counted(len(self.limits), "limit of stability", "limits of stability")
        yield from super()._facts()

    def _curves(self) -> tuple[Floats, Floats]:
        return self.values, self.frequencies

    @property
    def values(self) -> Floats:
        """Values of the parameter ``(n,)``."""
        return np.asarray(self.data[self.along].values, dtype=float)

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the modes, by their strains where they begin to be followed."""
        return tuple(str(name) for name in self.data["mode"].values)

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Roots ``s`` [1/s] of the motions ``exp(s t)`` as they are seen on the model ``(n, modes)``, complex."""
        parts = np.asarray(self.data["eigenvalue"].values, dtype=float)
        found: np.ndarray = parts[..., 0] + 1j * parts[..., 1]
        return found

    @property
    def frequencies(self) -> Floats:
        """Frequencies of the oscillations, ``|Im s|/2 pi`` [Hz] ``(n, modes)``; those of ``Modes`` are ``|s|/2 pi``."""
        return np.asarray(self.data["frequency"].values, dtype=float)

    @property
    def damping_ratios(self) -> Floats:
        """``-Re s/|s|`` ``(n, modes)``; less than 0 where a mode grows."""
        return np.asarray(self.data["damping_ratio"].values, dtype=float)

    @property
    def mesh_errors(self) -> Floats:
        """Estimated errors of the frequencies by the mesh, in parts of them ``(modes,)``."""
        return np.asarray(self.data["mesh_error"].values, dtype=float)

    @property
    def limits(self) -> list[Limit]:
        """Where modes begin to grow and cease to, in order."""
        data, names = self.data, self.modes
        return [
            Limit(
                float(data[f"limit_{self.along}"].values[k]),
                names[int(data["limit_mode"].values[k])],
                int(data["limit_mode"].values[k]) + 1,
                str(data["limit_kind"].values[k]),
                bool(data["limit_unstable"].values[k]),
                float(data["limit_frequency"].values[k]),
                float(data["limit_error"].values[k]),
            )
            for k in range(data.sizes["limit"])
        ]

    @property
    def meetings(self) -> list[Meeting]:
        """Where frequencies cross and veer, in order."""
        data, names = self.data, self.modes
        return [
            Meeting(
                float(data[f"meeting_{self.along}"].values[k]),
                (names[int(pair[0])], names[int(pair[1])]),
                bool(data["meeting_crosses"].values[k]),
                float(data["meeting_frequency"].values[k]),
                float(data["meeting_gap"].values[k]),
            )
            for k, pair in enumerate(np.asarray(data["meeting_modes"].values).reshape(-1, 2))
        ]

    def report(self) -> str:
        """Return a report: modes at both ends, limits, crossings and veerings, warnings."""
        return page([*self._blocks(), self._meetings(), self._warnings()])

    def _blocks(self) -> list[str]:
        note = frequency_note(self.damping_ratios[[0, -1]], natural=False)
        return [self._heading(), self._modes(), *note, self._limits()]

    @abstractmethod
    def _heading(self) -> str:
        """Return the first line, after the title."""

    def _modes(self) -> str:
        f, d = self.frequencies, above_rounding(self.damping_ratios)
        first, last = (f"{value:.5g}" for value in self.values[[0, -1]])
        factor, hertz = scaled("Hz", f[[0, -1]])
        rows = [
            [
                name,
                f"{factor * f[0, k]:.6g}",
                f"{d[0, k]:.4g}",
                f"{factor * f[-1, k]:.6g}",
                f"{d[-1, k]:.4g}",
                error_text(error),
            ]
            for k, (name, error) in enumerate(zip(self.modes, self.mesh_errors, strict=True))
        ]
        header = [
            "mode",
            f"[{hertz}] at {first}",
            "damping ratio",
            f"[{hertz}] at {last}",
            "damping ratio",
            "mesh error",
        ]
        return table("Modes at both ends", header, rows)

    def _limits(self) -> str:
        limits, grows = self.limits, self.eigenvalues.real > 1e-7 * np.abs(self.eigenvalues)
        growing, later = int(grows[0].sum()), int((grows.any(axis=0) & ~grows[0]).sum())
        start = f"{growing} of the modes grow from the beginning on. " if growing else ""
        if not limits and later:
            return start + f"{later} of the modes begin to grow; where was not sought to the end"
        if not limits:
            return start + (
                "No other mode that was followed begins to grow"
                if growing
                else "No mode that was followed grows"
            )
        factor, hertz = scaled("Hz", [one.frequency for one in limits])
        rows = [
            [
                one.mode,
                f"{one.at:.10g}",
                ("begins: " if one.unstable else "ends: ") + one.kind,
                f"{factor * one.frequency:.6g}",
                error_text(one.mesh_error),
            ]
            for one in limits
        ]
        header = ["mode", self._axis_words, "what", f"[{hertz}]", "mesh error"]
        return start + table("Limits of stability", header, rows)

    @property
    def _axis_words(self) -> str:
        return f"{self.along.replace('_', ' ')}{f' [{self.unit}]' if self.unit else ''}"

    def _meetings(self) -> str:
        if not self.meetings:
            return ""
        factor, hertz = scaled("Hz", [one.frequency for one in self.meetings])
        rows = [
            [
                f"{one.modes[0]}, {one.modes[1]}",
                "cross" if one.crosses else "veer",
                f"{one.at:.5g}",
                f"{factor * one.frequency:.5g}",
                "-" if one.crosses else f"{factor * one.gap:.3g}",
            ]
            for one in self.meetings
        ]
        header = ["modes", "they", f"near {self._axis_words}", f"[{hertz}]", f"least distance [{hertz}]"]
        return table("Frequencies that meet, as seen on the model", header, rows)

    def _warnings(self) -> str:
        return listed("Warnings", self.warnings) if self.warnings else ""

    @checked
    def save_csv(self, path: str | Path) -> Path:
        """Write frequencies and damping ratios of all modes over the parameter as a table; returns the path."""
        from viscorod.results.files.csv_text import write

        return write(self.columns(), path)

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of the table by their headings with units."""
        found = {self._axis_words: self.values}
        for k, name in enumerate(self.modes):
            found[f"{name}: frequency [Hz]"] = self.frequencies[:, k]
            found[f"{name}: damping ratio"] = self.damping_ratios[:, k]
            found[f"{name}: growth [1/s]"] = self.eigenvalues[:, k].real
        return found


def error_text(part: float) -> str:
    """Return an estimated error as text; 0 stands for none estimated."""
    return f"{part:.1g}" if part > 0.0 else "-"

"""The result of periodic motions: amplitudes and stability along a curve, loops and losses of cycles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.results.summits import Summit, largest_in_cycle, summit_of
from viscorod.shown import counted, span
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["LOSSLESS", "NO_INPUT", "Periodic"]

LOSSLESS = 1e-10
"""Damping ratio below which work and loss of a free vibration are round-off."""

NO_INPUT = "none"
"""The input of free vibrations in the data set."""

VARIABLES: Variables = {
    "frequency": (("point",), "Hz", "frequency of the motion"),
    "level": (("point",), "1", "factor of all amplitudes of the inputs"),
    "input": (("input",), "", "what drives the model"),
    "output": (("output",), "", "what is read"),
    "harmonic": (("harmonic",), "", "multiple of the frequency"),
    "part": (("part",), "", "real and imaginary"),
    "input_unit": (("input",), "", "unit of the input"),
    "output_unit": (("output",), "", "unit of the output"),
    "coefficient": (
        ("point", "output", "harmonic", "part"),
        "",
        "c_k of the output, the real part of sum c_k exp(2 pi i k f t)",
    ),
    "drive": (
        ("point", "input", "part"),
        "",
        "force, or displacement of what is moved, the real part of d exp(2 pi i f t)",
    ),
    "conjugate": (
        ("point", "input", "harmonic", "part"),
        "",
        "displacement on which the unit force of the input does work, as coefficients, without its mean",
    ),
    "work": (("point",), "J", "work of loads, supports and motors in a cycle"),
    "loss": (("point",), "J", "energy lost to viscosity, dampers and outside in a cycle"),
    "damping_ratio": (("point",), "1", "loss of a cycle over 8 pi times the mean kinetic energy"),
    "multiplier": (
        ("point", "multiplier_number", "part"),
        "1",
        "Floquet multipliers, by which small disturbances grow in a cycle, the largest first",
    ),
    "unstable": (("point",), "", "number of multipliers beyond 1 in size, -1 where they are not known"),
    "bifurcation": (
        ("point",),
        "",
        "fold, period doubling, torus (Neimark-Sacker) or branch point where there is one",
    ),
    "tail": (("point",), "1", "size of the highest two harmonics over that of all"),
}
"""Name -> dimensions, unit and long name of every variable; all are always there."""
FINE = 400
"""Instants of a cycle at which the extremes of an output are sought."""


class Periodic(StatelessResult):
    """Periodic motions along a curve over frequency or level.

    ``data`` is an ``xarray.Dataset`` by ``point`` of the curve, ``output`` and ``input`` (SI units).
    """

    kind: ClassVar[str] = "periodic"
    picture: ClassVar[str] = "amplitude"
    what: ClassVar[str] = "curve of periodic motions"
    orbits: Sequence[Any] = ()
    """Of a result that has just been computed: what its motions were found as."""

    @classmethod
    def variables(cls) -> Variables:
        """See :class:`StatelessResult`."""
        return VARIABLES

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.frequencies), "motion")
        yield span(float(self.frequencies.min()), float(self.frequencies.max()), "Hz")
        if self.bifurcations:
            yield counted(len(self.bifurcations), "bifurcation")
        yield from super()._facts()

    def _curves(self) -> tuple[Floats, Floats]:
        over = str(self.data.attrs.get("over"))
        if over == "amplitude":
            return self.amplitude(0), self.frequencies[:, None]
        return self.levels if over == "level" else self.frequencies, self.amplitude(0)[:, None]

    @property
    def outcome(self) -> str:
        """How it ended: "completed", "points" where the curve is longer than was asked for, "stopped"."""
        return str(self.data.attrs["outcome"])

    @property
    def frequencies(self) -> Floats:
        """Frequencies of all motions [Hz] ``(points,)``, in their order on the curve."""
        return np.asarray(self.data["frequency"].values, dtype=float)

    @property
    def levels(self) -> Floats:
        """Factors of the amplitudes of the inputs ``(points,)``."""
        return np.asarray(self.data["level"].values, dtype=float)

    @property
    def inputs(self) -> tuple[str, ...]:
        """The inputs, in words; none of free vibrations."""
        if self.data.attrs.get("over") == "amplitude":
            return ()
        return tuple(str(name) for name in self.data["input"].values)

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs, in words."""
        return tuple(str(name) for name in self.data["output"].values)

    @property
    def work(self) -> Floats:
        """Work of loads, supports and motors in a cycle [J] ``(points,)``."""
        return np.asarray(self.data["work"].values, dtype=float)

    @property
    def loss(self) -> Floats:
        """Energy lost in a cycle [J] ``(points,)``."""
        return np.asarray(self.data["loss"].values, dtype=float)

    @property
    def damping_ratios(self) -> Floats:
        """Loss of a cycle over 8 pi times the mean kinetic energy ``(points,)``.

        Of free vibrations it is their damping ratio: at this amplitude they decay by the factor exp(-2 pi zeta) in a
        cycle, to first order.
        """
        return np.asarray(self.data["damping_ratio"].values, dtype=float)

    @property
    def multipliers(self) -> np.ndarray:
        """The largest Floquet multipliers ``(points, k)``, complex; k is 0 if they were not wanted."""
        return self._complex("multiplier")

    @property
    def stable(self) -> np.ndarray:
        """Whether each motion is stable ``(points,)``.

        Raises:
            InputError: multipliers were not wanted.
        """
        unstable = np.asarray(self.data["unstable"].values)
        if (unstable < 0).any():
            raise InputError(
                "whether these motions are stable is not known: they are free vibrations, or were computed with "
                "stability = False"
            )
        found: np.ndarray = unstable == 0
        return found

    @property
    def has_loops(self) -> bool:
        """Whether any input is a force or a moment, which has a hysteresis loop."""
        return bool(self.data["conjugate"].values.any())

    @property
    def bifurcations(self) -> list[tuple[int, str]]:
        """Points at which the curve folds, or motions change their stability otherwise, and what happens there.

        "fold": a real multiplier passes 1 and the curve turns back; "branch point": it passes 1 and another curve
        crosses; "period doubling": one passes -1; "torus": a pair leaves the circle (Neimark and Sacker).
        """
        kinds = [str(word) for word in self.data["bifurcation"].values]
        return [(k, word) for k, word in enumerate(kinds) if word]

    @checked
    def harmonics(self, output: str | int = 0) -> np.ndarray:
        """Return ``c_k (points, harmonics + 1)`` of an output, the real part of ``sum c_k exp(2 pi i k f t)``.

        Args:
            output: its words, or its number from 0.

        Raises:
            InputError: there is no such output.
        """
        found: np.ndarray = self._complex("coefficient")[:, self._number("output", output, self.outputs)]
        return found

    @checked
    def amplitude(self, output: str | int = 0) -> Floats:
        """Return half of the way from the smallest to the largest value of an output in a cycle ``(points,)``."""
        values = self._course(self.harmonics(output), FINE)
        return np.asarray(0.5 * (largest_in_cycle(values) + largest_in_cycle(-values)))

    @checked
    def summit(self, output: str | int = 0) -> Summit:
        """Return the largest amplitude of an output between the motions of the curve, and its frequency [Hz].

        Args:
            output: its words, or its number from 0.

        Raises:
            InputError: there is no such output.
        """
        return summit_of(self.frequencies, self.amplitude(output))

    @checked
    def decrement_ratios(self, output: str | int = 0) -> Floats:
        """Return the damping ratio that a decay of an output shows at each amplitude ``(points,)``, of free vibrations.

        A slow decay passes through free vibrations of ever smaller amplitude ``a``. Its action ``J = 2 <T>/omega``
        falls by ``2 zeta omega J`` per time, the amplitude by ``a dlnJ/dt / (dlnJ/dlna)``: a decrement shows
        ``2 zeta/(dlnJ/dlna)``, which is zeta where J grows as the square of the amplitude.

        Args:
            output: its words or number.

        Raises:
            InputError: these are forced motions, there are fewer than three, or there is no such output.
        """
        if self.data.attrs.get("over") != "amplitude" or len(self.frequencies) < 3:
            raise InputError(
                "decrements are those of three free vibrations of a mode or more; give mode and largest"
            )
        from scipy.interpolate import CubicSpline

        action = self.loss / (8.0 * np.pi**2 * self.damping_ratios * self.frequencies)
        size = self.amplitude(output)
        slope = CubicSpline(np.log(size), np.log(action))(np.log(size), 1)
        return np.asarray(2.0 * self.damping_ratios / slope)

    @checked
    def course(self, point: int, output: str | int = 0, instants: int = FINE) -> tuple[Floats, Floats]:
        """Return times [s] and values of an output in one cycle ``(instants,)``; the inputs begin at their phase.

        Args:
            point: number of the motion; output: its words or number; instants: how many, equally spaced.

        Raises:
            InputError: there is no such point or output.
        """
        point = self._point(point)
        values = self._course(self.harmonics(output)[point][None], int(instants))[0]
        return np.arange(int(instants)) / int(instants) / self.frequencies[point], values

    @checked
    def loop(self, point: int, source: str | int = 0, instants: int = FINE) -> tuple[Floats, Floats]:
        """Return the hysteresis loop of a force: the displacement on which it does work, and the force ``(instants,)``.

        Its area is the work of the force in a cycle.

        Args:
            point: number of the motion; source: words or number of the input, a load; instants: how many.

        Raises:
            InputError: there is no such point or input, or the input is a motion.
        """
        point, k = self._point(point), self._number("source", source, self.inputs)
        conjugate = self._complex("conjugate")[point, k]
        if not conjugate.any():
            raise InputError(
                f"source = {self.inputs[k]!r} is a motion: its force is the reaction; give that as an output"
            )
        drive = np.array([0.0, self._complex("drive")[point, k]])
        count = int(instants)
        return self._course(conjugate[None], count)[0], self._course(drive[None], count)[0]

    def report(self) -> str:
        """Return a report: curve, largest amplitudes, bifurcations, energy of cycles, warnings."""
        from viscorod.results.reports.periodic_report import periodic_report

        return periodic_report(self)

    @checked
    def save_csv(self, path: str | Path) -> Path:
        """Write frequencies, levels, amplitudes, energies and stability as a table, a row for each motion.

        Returns:
            The path.
        """
        from viscorod.results.files.csv_text import write

        columns: dict[str, np.ndarray] = {
            "frequency [Hz]": self.frequencies,
            "level": self.levels,
        }
        for k, name in enumerate(self.outputs):
            columns[f"{name} amplitude [{self.data['output_unit'].values[k]}]"] = self.amplitude(k)
        columns |= {"work [J]": self.work, "loss [J]": self.loss, "damping ratio": self.damping_ratios}
        columns["unstable multipliers"] = np.asarray(self.data["unstable"].values)
        columns["bifurcation"] = np.asarray(self.data["bifurcation"].values, dtype=str)
        return write(columns, path)

    @checked
    def plot(
        self, path: str | Path | None = None, kind: str = "amplitude", *, ax: Axes | None = None
    ) -> Figure:
        """Draw the curve.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            kind: "amplitude" (of all outputs over frequency or level, unstable motions dashed), "multipliers" (in the
                complex plane), "loops" (hysteresis of the first input that is a force, of some motions).
            ax: axes of yours to draw into: the amplitudes of the first unit, the frequency of free vibrations, or the
                other kinds.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such kind, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_periodic import draw_periodic

        return delivered(draw_periodic(self, kind, ax), path)

    @cached_property
    def _known(self) -> dict[str, np.ndarray]:
        return {}

    def _complex(self, name: str) -> np.ndarray:
        if name not in self._known:
            parts = np.asarray(self.data[name].values, dtype=float)
            self._known[name] = parts[..., 0] + 1j * parts[..., 1]
        return self._known[name]

    @staticmethod
    def _course(coefficients: np.ndarray, instants: int) -> Floats:
        """Return values in a cycle ``(points, instants)`` from coefficients ``(points, harmonics + 1)``."""
        phases = 2.0 * np.pi * np.outer(np.arange(coefficients.shape[1]), np.arange(instants) / instants)
        return np.asarray((coefficients @ np.exp(1j * phases)).real)

    def _point(self, point: int) -> int:
        count = len(self.frequencies)
        if not isinstance(point, int | np.integer) or not -count <= point < count:
            raise InputError(f"point = {point!r}: there are {count} motions, 0 to {count - 1}")
        return int(point) % count

    @staticmethod
    def _number(what: str, given: str | int, known: tuple[str, ...]) -> int:
        if isinstance(given, str) and given in known:
            return known.index(given)
        if isinstance(given, int | np.integer) and -len(known) <= given < len(known):
            return int(given) % len(known)
        raise InputError(f"{what} = {given!r}: these motions have {', '.join(map(repr, known))}")

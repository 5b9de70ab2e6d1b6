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
    page = _PeriodicPage(result, most)
    page.add_outputs()
    page.add_energies()
    page.add_loops()
    page.add_multipliers()
    page.add_chosen_motion()
    page.add_bifurcations()
    return page.parts


class _PeriodicPage:
    """The parts of the page, added one by one.

    Attributes:
        free: of vibrations without a load; known: whether all motions have been looked at for their stability.
        scale, hz: of frequencies as shown, and their unit; dashed: where motions are unstable, if it is known.
        x, along: row of what the curve goes along, and its label; rows: of the table of the chosen motion.
    """

    def __init__(self, result: Periodic, most: int) -> None:
        self.result = result
        self.free = not result.inputs
        self.over_level = str(result.data.attrs.get("over", "frequency")) == "level"
        self.scale, self.hz = scaled("Hz", result.frequencies)
        kind = "free vibrations of a mode" if self.free else "forced motions"
        chosen = places(len(result.frequencies), most, [k for k, _ in result.bifurcations])
        self.parts = parts = CurveParts(
            f"Periodic motions, {kind}, {int(result.data.attrs['harmonics'])} harmonics",
            ("motion on the curve", self.hz),
            self.scale * result.frequencies,
            chosen,
        )
        self.unstable = np.asarray(result.data["unstable"].values)
        self.known = bool((self.unstable >= 0).all())
        self.dashed = (parts.rows((~result.stable[chosen])[None]), 0) if self.known else None
        hertz = parts.rows(self.scale * self._of_chosen(result.frequencies))
        level = parts.rows(self._of_chosen(result.levels))
        self.x, self.along = (
            (level, "factor of the amplitudes") if self.over_level else (hertz, f"frequency [{self.hz}]")
        )
        self.rows: list[list[Any]] = [
            [f"frequency [{self.hz}]", (hertz, 0)],
            ["factor of the amplitudes", (level, 0)],
        ]

    def add_outputs(self) -> None:
        """Add charts of every output, one of which is chosen: its amplitude along the curve, and its cycle."""
        result, parts = self.result, self.parts
        output = parts.choice("Output", result.outputs)
        phase = parts.rows(np.linspace(0.0, 1.0, INSTANTS + 1)[None])
        units = [str(unit) for unit in result.data["output_unit"].values]
        for k, (name, unit) in enumerate(zip(result.outputs, units, strict=True)):
            factor, shown_unit = scaled(unit, result.amplitude(k))
            size = factor * result.amplitude(k)
            label, when = f"amplitude [{shown_unit}]", {output: k}
            y = self._add_amplitude(name, label, size, when)
            self._add_cycle(k, phase, when)
            self.rows.append([f"amplitude of {name} [{shown_unit}]", (y, 0)])
            if self.free:
                ratio = parts.rows(100.0 * self._of_chosen(result.damping_ratios))
                parts.chart(
                    "Damping ratio over the amplitude", label, "damping ratio [%]",
                    [parts.curve("damping ratio", (y, 0), (ratio, 0), colour=2)], when=when, follows=True,
                )  # fmt: skip

    def _add_amplitude(self, name: str, label: str, size: Floats, when: dict[int, int]) -> str:
        """Add the amplitudes of one output along the curve; return their row."""
        result, parts = self.result, self.parts
        y = parts.rows(self._of_chosen(size))
        over = result.levels if self.over_level else self.scale * result.frequencies
        marks = [
            {"x": float(over[at]), "y": float(size[at]), "text": what, "kind": "fold or other bifurcation"}
            for at, what in result.bifurcations
        ]
        dashes = self.known and not result.stable.all()
        parts.chart(
            f"Amplitude of {name}" + ("; dashed where it is unstable" if dashes else ""),
            self.along,
            label,
            [parts.curve(name, (self.x, 0), (y, 0), dashed=self.dashed)],
            marks=marks,
            when=when,
            follows=True,
        )
        return y

    def _add_cycle(self, output: int, phase: str, when: dict[int, int]) -> None:
        """Add the cycle of one output in the chosen motion."""
        parts, name = self.parts, self.result.outputs[output]
        cycles = np.array([self.result.course(int(p), output, INSTANTS)[1] for p in parts.chosen])
        factor, unit = scaled(str(self.result.data["output_unit"].values[output]), cycles)
        course = parts.rows(factor * _closed(cycles))
        parts.chart(
            f"A cycle of {name}", "part of the period", f"[{unit}]",
            [parts.curve(name, (phase, 0), (course, -1), colour=1)], when=when, side=True,
        )  # fmt: skip

    def add_energies(self) -> None:
        """Add what is lost in a cycle of a forced motion."""
        if self.free:
            return
        factor, unit = scaled("J", self.result.loss)
        loss = self.parts.rows(factor * self._of_chosen(self.result.loss))
        self.parts.chart(
            "Energy lost in a cycle", self.along, f"loss [{unit}]",
            [self.parts.curve("loss", (self.x, 0), (loss, 0), dashed=self.dashed, colour=2)], follows=True,
        )  # fmt: skip

    def add_loops(self) -> None:
        """Add the hysteresis loop of every input that is a load."""
        result, parts = self.result, self.parts
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

    def add_multipliers(self) -> None:
        """Add the Floquet multipliers in the complex plane, with the unit circle."""
        parts = self.parts
        found = self.result.multipliers[parts.chosen]
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

    def add_chosen_motion(self) -> None:
        """Add the table of the chosen motion."""
        result, parts, rows = self.result, self.parts, self.rows
        for words, values in (("work", result.work), ("loss", result.loss)):
            factor, joule = scaled("J", values)
            rows.append([f"{words} of a cycle [{joule}]", (parts.rows(factor * self._of_chosen(values)), 0)])
        ratio = parts.rows(self._of_chosen(result.damping_ratios))
        rows.append(["damping ratio, loss over 8 pi kinetic [1]", (ratio, 0)])
        if self.known:
            counts = parts.rows(self._of_chosen(self.unstable.astype(float)))
            rows.append(["multipliers beyond 1 in size", (counts, 0)])
        parts.live(["of the chosen motion", ""], rows)

    def add_bifurcations(self) -> None:
        """Add the table of bifurcations."""
        result = self.result
        self.parts.table(
            "Bifurcations",
            ["kind", "motion", f"[{self.hz}]", "level"],
            [
                [word, at + 1, self.scale * float(result.frequencies[at]), float(result.levels[at])]
                for at, word in result.bifurcations
            ],
        )

    def _of_chosen(self, values: Floats) -> Floats:
        """Return values ``(1, n)`` of the motions that are shown."""
        found: Floats = values[self.parts.chosen][None]
        return found


def _closed(values: Floats) -> Floats:
    """Return courses ``(n, instants + 1)`` that end where they begin."""
    return np.concatenate([values, values[:, :1]], axis=1)

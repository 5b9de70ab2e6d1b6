"""The energy account of a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from viscorod.alike import Alike
from viscorod.argument_names import known_arguments
from viscorod.results.text_numbers import number, percent, quantity, scaled
from viscorod.results.text_table import wrapped
from viscorod.shown import Shown, span
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.state_arrays import Stored

_ROUND_OFF = 1e-12  # what moved less than this part of the energy that is there did not move
_SQUARED_ROUND_OFF = 1e-24
_LITTLE = 0.01  # part of all energy that is there, below which what moved is no scale by itself


@known_arguments
@dataclass(frozen=True, repr=False, eq=False)
class Energy(Shown, Alike):
    """Energies over time [J], arrays of the length of ``time`` [s].

    At every time ``kinetic + elastic + viscous + outside - external - actuator - numerical`` is what ``kinetic +
    elastic`` was at the start.

    Attributes:
        time: times of the account [s].
        kinetic: energy of motion.
        elastic: energy stored in the strains and in springs, those of joints too.
        viscous: energy lost to viscosity and in dampers so far.
        external: work of loads (gravity among them), moving supports and motors so far. Of drag it has what the moving
            medium would do to sections at rest.
        outside: energy lost outside of the rods so far: what drag takes beyond that because they move; zero without.
        actuator: work of what changes rest strains so far; zero without.
        numerical: remainder that the integration made or lost, positive where it made energy.
        scale: elastic energy at a strain of one: round-off of the shape is its 1e-24th part.
        branches: energy that each Maxwell branch lost so far, parts of ``viscous`` ``(times, branches)``;
            relaxation_times: of the branches [s].
    """

    time: Floats
    kinetic: Floats
    elastic: Floats
    viscous: Floats
    external: Floats
    numerical: Floats
    scale: float = 0.0
    branches: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    relaxation_times: Floats = field(default_factory=lambda: np.zeros(0))
    outside: Floats = field(default_factory=lambda: np.zeros(1))
    actuator: Floats = field(default_factory=lambda: np.zeros(1))

    def _facts(self) -> Iterator[str]:
        yield span(float(self.time[0]), float(self.time[-1]), "s")
        yield f"{quantity(self.moved, 'J', 4)} moved"
        yield f"{quantity(float(self.viscous[-1]), 'J', 4)} lost to viscosity"
        yield f"numerical remainder {percent(self.numerical_fraction)} of what moved"

    def _drawing(self) -> str:
        """Return energy of motion and strain, and with it what viscosity took."""
        drawing = Drawing(equal=False)
        drawing.line(np.stack([self.time, self.total + self.viscous], axis=-1), faint=True)
        drawing.line(np.stack([self.time, self.total], axis=-1))
        return drawing.svg()

    @classmethod
    def of(cls, data: Stored) -> Energy:
        """Read the account from what is stored of a run."""
        names = ("time", "kinetic", "elastic", "viscous", "external", "numerical")
        known = data.variables
        columns = {name: np.asarray(known[name].values, dtype=float) for name in names}
        for name in ("outside", "actuator"):
            found = known[name].values if name in known else np.zeros_like(columns["time"])
            columns[name] = np.asarray(found, dtype=float)
        if "branch_loss" in known:
            columns["branches"] = np.asarray(known["branch_loss"].values, dtype=float)
            columns["relaxation_times"] = np.asarray(known["relaxation_time"].values, dtype=float)
        return cls(**columns, scale=float(data.attrs.get("energy_scale", 0.0)))

    @property
    def total(self) -> Floats:
        """Kinetic and elastic energy together ``(time,)`` [J]."""
        return self.kinetic + self.elastic

    @property
    def supplied(self) -> Floats:
        """Energy at the start and all work since ``(time,)`` [J]: of loads, supports and what changes rest strains."""
        return np.asarray(self.total[0] + self.external + self.actuator)

    @property
    def moved(self) -> float:
        """Exchanged energy [J], the scale of the account.

        The largest of: range of the kinetic energy, range of the elastic energy, viscous loss, loss to
        drag, and largest amount of work done by or against the loads and supports, and by what changes rest strains.
        Zero if all of it is round-off.
        """
        moved = max(
            float(np.ptp(self.kinetic)),
            float(np.ptp(self.elastic)),
            float(np.max(self.viscous)),
            float(np.max(np.abs(self.outside))),
            float(np.max(np.abs(self.external))),
            float(np.max(np.abs(self.actuator))),
        )
        floor = max(_ROUND_OFF * float(np.max(self.total)), _SQUARED_ROUND_OFF * self.scale)
        return moved if moved > floor else 0.0

    @property
    def lost(self) -> float:
        """Energy that damping took until the end [J]: of the material, of dampers and of drag."""
        return float(self.viscous[-1] + self.outside[-1])

    @property
    def driven(self) -> float:
        """Largest amount of work done by or against loads, supports, motors and what changes rest strains [J]."""
        return float(np.max(np.abs(self.external + self.actuator)))

    @property
    def numerical_fraction(self) -> float:
        """Largest amount of the numerical remainder as a fraction of ``moved`` (0 where nothing moved)."""
        moved = self.moved
        return float(np.max(np.abs(self.numerical))) / moved if moved > 0.0 else 0.0

    def __str__(self) -> str:
        moved = self.moved
        values = {"kinetic": self.kinetic[-1], "elastic": self.elastic[-1]}
        values["lost to viscosity"] = self.viscous[-1]
        for time, loss in zip(self.relaxation_times, self.branches.T, strict=True):
            values[f"  in branches of {quantity(float(time), 's', 3)}"] = loss[-1]
        if self.outside.any():
            values["lost to drag, outside"] = self.outside[-1]
        values["work of loads and supports"] = self.external[-1]
        if self.actuator.any():
            values["work of rest strains"] = self.actuator[-1]
        values["numerical remainder"] = self.numerical[-1]
        there = np.array([*values.values(), self.total[0]])
        scale, unit = scaled("J", np.append(there, moved))
        size = scale * max(moved, float(np.max(np.abs(there))))
        start = f"{number(scale * self.total[0], size=1e-2 * size)} {unit}"
        lines = [
            wrapped(
                f"Energy at {quantity(float(self.time[-1]), 's')} (kinetic and elastic at the start: {start}; "
                f"moved: {number(scale * moved)} {unit})"
            )
        ]
        amounts = [number(scale * float(value), size=1e-2 * size) for value in values.values()]
        parts = [percent(value / moved) if moved > 0.0 else "" for value in values.values()]
        wide, narrow = max(14, *map(len, amounts)), max(12, *(len(part) + 1 for part in parts))
        for name, amount, part in zip(values, amounts, parts, strict=True):
            told = f"{part:>{narrow}s} of what moved" if part else ""
            lines.append(f"  {name:<28s}{amount:>{wide}s} {unit}{told}")
        most = f"{number(100.0 * self.numerical_fraction, 3)} % of what moved"
        if 0.0 < moved < _LITTLE * float(np.max(self.total)):
            of_all = float(np.max(np.abs(self.numerical)) / np.max(self.total))
            most += f", {number(100.0 * of_all, 3)} % of all that is there"
        lines.append(wrapped(f"  largest numerical remainder: {most}"))
        return "\n".join(lines)

"""Self-heating: how much the energy that a motion loses would warm its rods if nothing were conducted away.

Linn, Lang and Tuganov (2013) assume isothermal motion. The loss per length, over the heat capacity per length, bounds
the mean temperature of every section from above: conduction along the rod and to its surroundings only lowers the
hottest one. The rise is that of the mean over the section. In bending the loss density grows with the square of the
distance from the neutral axis, so that the outer fibres of a rectangle get 3 times the mean, those of a circle 4 times.

The loss field is integrated over the stored states by the trapezoidal rule. Where nothing but rods loses energy to
viscosity, its total is known from the energy account, and the field is scaled to it.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.results.array_pieces import blocks
from viscorod.results.extremes import maxima
from viscorod.results.text_numbers import quantity
from viscorod.results.text_table import page
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.run import Run

__all__ = ["RodHeating", "SelfHeating", "self_heating"]


@dataclass(frozen=True)
class RodHeating:
    """Adiabatic rise of temperature of one rod, means over the section.

    Attributes:
        rod: which.
        s: arc length where it is largest, m.
        largest: rise over the run there, K.
        mean: rise over the run of the whole rod, its loss over its heat capacity, K.
        per_cycle: largest rise during one cycle of the motion there, K; NaN where the motion has no two maxima.
        cycle: mean duration of the cycles, s; NaN likewise.
    """

    rod: str
    s: float
    largest: float
    mean: float
    per_cycle: float
    cycle: float

    def __str__(self) -> str:
        cycle = (
            ""
            if math.isnan(self.per_cycle)
            else f", at most {quantity(self.per_cycle, 'K', 3)} in one cycle of about {quantity(self.cycle, 's', 3)}"
        )
        return (
            f"rod {self.rod}: at most {quantity(self.largest, 'K', 3)} over the run (at {quantity(self.s, 'm', 4)}; "
            f"{quantity(self.mean, 'K', 3)} in the mean of the rod){cycle}"
        )


@dataclass(frozen=True)
class SelfHeating:
    """Adiabatic rise of temperature by the loss of a motion.

    Attributes:
        rods: those whose specific heat is known.
    """

    rods: tuple[RodHeating, ...]

    def __str__(self) -> str:
        head = (
            "Self-heating if no heat leaves its section, mean over the section (outer fibres of a bent rectangle get 3 "
            "times as much, of a circle 4 times):"
        )
        return page(["\n".join([head, *(f"  {rod}" for rod in self.rods)])])


def self_heating(run: Run) -> SelfHeating:
    """Return how much a motion warms its rods at most; see ``Run.self_heating``."""
    capacities = json.loads(run.data.attrs.get("heat_capacities", "{}"))
    if not capacities or "dissipation" not in run.data:
        raise InputError(
            Fault(
                "specific_heat",
                "",
                "no rod of this result has a material with a specific heat",
                "give the material specific_heat, J/(kg K), and compute it again",
            )
        )
    loss = _loss(run)
    account = float(run.energy.viscous[-1] - run.energy.viscous[0])
    weight = np.asarray(run.data["point_weight"].values, dtype=float)
    total = float(weight @ loss)
    scale = account / total if total > 0.0 and account > 0.0 and "joint_value" not in run.data else 1.0
    cycles = _cycles(run)
    rods = np.asarray(run.data["point_rod"].values)
    s = np.asarray(run.data["point_s"].values, dtype=float)
    found = []
    for rod, known in capacities.items():
        mine = np.flatnonzero(rods == rod)
        capacity = np.interp(s[mine], known["s"], known["capacity"])
        rise = scale * loss[mine] / capacity
        hottest = int(np.argmax(rise))
        mean = scale * float(weight[mine] @ loss[mine]) / float(weight[mine] @ capacity)
        point = int(mine[hottest])
        per_cycle, cycle = _per_cycle(run, point, scale / float(capacity[hottest]), cycles)
        found.append(RodHeating(rod, float(s[point]), float(rise[hottest]), mean, per_cycle, cycle))
    return SelfHeating(tuple(found))


def _loss(run: Run) -> Floats:
    """Return the energy lost per length at every point over the run ``(points,)``, J/m."""
    time = run.time
    weight = np.zeros(time.size)
    steps = np.diff(time)
    weight[:-1] += 0.5 * steps
    weight[1:] += 0.5 * steps
    total = np.zeros(run.data.sizes["point"])
    first = 0
    for block in blocks(run, "dissipation"):
        total += weight[first : first + len(block)] @ block
        first += len(block)
    return total


def _cycles(run: Run) -> Floats:
    """Return the times of the maxima of the motion with the largest range, s; (0,) where there are none."""
    site, axis = run.main_motion
    displacement, velocity = (
        np.asarray(run.history(site.label, quantity).sel(axis=axis).values, dtype=float)
        for quantity in ("displacement", "velocity")
    )
    return maxima(run.time, displacement, velocity)[0]


def _per_cycle(run: Run, point: int, factor: float, cycles: Floats) -> tuple[float, float]:
    """Return the largest rise between two successive maxima at a point, K, and their mean distance, s."""
    if cycles.size < 2:
        return math.nan, math.nan
    power = factor * np.asarray(run.data["dissipation"].isel(point=point).values, dtype=float)
    rise = np.append(0.0, np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(run.time)))
    at = np.interp(cycles, run.time, rise)
    return float(np.diff(at).max()), float(np.diff(cycles).mean())

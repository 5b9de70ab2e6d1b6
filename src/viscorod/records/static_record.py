"""What static loads moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.limits import SMALLEST_NUMBER
from viscorod.records.any_record import AnyRecord, deviations, finite
from viscorod.records.arguments import described
from viscorod.records.read_off import (
    BODY_AXES,
    QUANTITIES,
    Direction,
    direction_text,
    strain_along,
    turned_from_reference,
)
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats

__all__ = ["BACK", "SLACK", "StaticRecord"]

SLACK = 1e-3
"""Part of the largest load by which a record may go beyond the equilibria: weighed and converted loads are rounded."""
BACK = 0.05
"""Part of their range by which loads may go back, and below none: the noise of a load cell is no unloading."""

AT_REST = ("position", "displacement", "rotation", "strain", "force", "moment")
_OF_SECTION = {"force": slice(3), "moment": slice(3, 6)}


class StaticRecord(AnyRecord):
    """Static loads with what they moved: one number at a place for each load.

    Args:
        loads: N or N m (n,). Those of a load cell that go back a little are sorted; loading and unloading are two
            records.
        values: SI (n,).
        full_load: the load of the case at load factor 1, in the same unit; left out, `loads` are load factors.
        place, quantity, direction: as of a `Record`, without velocities and accelerations; a rotation is the component
            of the rotation vector from the reference shape, half a turn at most.
        noise: standard deviation, SI, one number or (n,); None where it is not known.
        unknown: "offset", "gain".
        name: of the record; by default its place.

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "static"
    analysis: ClassVar[str] = "equilibrium"

    @described
    def __init__(
        self,
        loads: Any,
        values: Any,
        *,
        place: str,
        direction: Direction,
        quantity: str = "displacement",
        full_load: float = 1.0,
        noise: Any = None,
        unknown: Sequence[str | Unknown] = (),
        name: str | None = None,
    ) -> None:
        where = f"record {name or place}"
        given = finite(f"{where}: loads", loads)
        values = finite(f"{where}: values", values)
        if len(values) != len(given):
            raise InputError(
                Fault(where, f"{len(values)} values", f"there are {len(given)} loads", "give as many")
            )
        order = _order(f"{where}: loads", given)
        self.loads, self.values = given[order], values[order]
        self.observed = self.values
        if not abs(full_load) > SMALLEST_NUMBER:
            raise InputError(
                Fault(f"{where}: full_load", f"{full_load:g}", "no load", "give the load at factor 1")
            )
        self.full_load = float(full_load)
        self.load_factors = self.loads / self.full_load
        if quantity not in AT_REST:
            raise InputError(
                Fault(f"{where}: quantity", repr(quantity), "nothing at rest has it",
                      f"use one of {', '.join(AT_REST)}")
            )  # fmt: skip
        self.place, self.quantity = place, quantity
        self.direction = QUANTITIES[quantity].direction(f"{where}: direction", direction)
        told = deviations(f"{where}: noise", noise, self.values.shape)
        self.noise = None if told is None else told[order]
        reach = float(np.abs(self.values).max()) or 1.0
        self._named(
            name or place, unknown, {"offset": (0.0, -1e3 * reach, 1e3 * reach), "gain": (1.0, 0.1, 10.0)}
        )

    @property
    def axes(self) -> tuple[tuple[str, str], ...]:
        """See `AnyRecord`."""
        unit = QUANTITIES[self.quantity].unit(self.direction)
        return ((f"{self.quantity} {direction_text(self.direction)} of {self.place}", unit),)

    def _over(self) -> str:
        return (
            f" under loads from {self.loads[0]:.6g} to {self.loads[-1]:.6g}, {self.full_load:.6g} at factor 1"
        )

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what an `Equilibrium` says at the loads (n,), straight lines between its states; see `AnyRecord`."""
        self._needs(result, "equilibrium")
        known = np.asarray(result.load_factor, dtype=float)
        low, high = float(self.load_factors.min()), float(self.load_factors.max())
        slack = SLACK * max(abs(known.min()), abs(known.max()))
        below = BACK * high if known.min() == 0.0 else slack  # the noise of no load
        if low < known.min() - below or high > known.max() + slack:
            raise InputError(
                f"record {self.name}: its loads are {low:.6g} to {high:.6g} of full_load = {self.full_load:.6g}, and "
                f"the equilibria go from {known.min():.6g} to {known.max():.6g}; full_load is the load of the case in "
                "the unit of `loads` (N, N m), and load_factors of the case say how far the equilibria go"
            )
        found = result.probe(self.place).isel(place=0)
        model = self._of_states(result, found)
        order = np.argsort(known, kind="stable")
        values = self.values_of(nuisances)
        shown = _along(self.load_factors, known[order], np.asarray(model)[order])
        return self.nuisance("gain", values, 1.0) * shown + self.nuisance("offset", values)

    def _of_states(self, result: Any, found: Any) -> Floats:
        """Return what was measured of the states of an equilibrium along the direction (n,)."""
        if self.quantity == "strain":
            return strain_along(found, self.direction, np.zeros(3))
        if self.quantity == "rotation":
            vectors = turned_from_reference(result, self.place, np.asarray(found["frame"].values))
        elif self.quantity in _OF_SECTION:
            of_section = np.asarray(found["section_force"].values[:, _OF_SECTION[self.quantity]])
            if isinstance(self.direction, str):
                return of_section[:, BODY_AXES.index(self.direction)]
            vectors = np.einsum("tij,tj->ti", found["frame"].values, of_section)
        else:
            vectors = np.asarray(found[self.quantity].values[:, :3])
        along: Floats = vectors @ np.asarray(self.direction)
        return along


def _order(where: str, loads: Floats) -> np.ndarray:
    """Return the rows by increasing loads.

    Raises:
        InputError: the loads go there and back by more than noise does.
    """
    back = [float((np.maximum.accumulate(way) - way).max()) for way in (loads, -loads)]
    if min(back) > BACK * float(np.ptp(loads)):
        turn = int(np.argmax(np.abs(loads - loads[0])))
        raise InputError(
            Fault(
                where,
                f"{loads[turn]:g}",
                f"they go there and back: row {turn + 1} is the farthest from the first",
                "loading and unloading are two records (of a file, branch = 'loading' or 'unloading')",
            )
        )
    return np.argsort(loads, kind="stable")


def _along(wanted: Floats, known: Floats, states: Floats) -> Floats:
    """Return straight lines between states at known loads; below the first one, its line goes on."""
    found: Floats = np.interp(wanted, known, states)
    below = wanted < known[0]
    if len(known) > 1 and known[1] > known[0]:
        found[below] += (wanted[below] - known[0]) * (states[1] - states[0]) / (known[1] - known[0])
    return found

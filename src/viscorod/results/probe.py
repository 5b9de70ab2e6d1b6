"""All fields at any place and, of a motion, any time; see ``Result.probe``."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.given_as import Amount, Amounts
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.results.array_pieces import in_states
from viscorod.results.between_records import Instants
from viscorod.results.data_schema import AXES, VARIABLES
from viscorod.results.element_points import Poses, Stencil
from viscorod.results.result_places import ResultPlace
from viscorod.results.state_arrays import StateArrays
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.result import Quantity, Result
    from viscorod.results.run import Run

Places = str | int | Sequence[str | int]

DIRECTORS = ("d1", "d2", "d3")
FIELDS = ("strain", "section_force", "dissipation")
"""Fields of rods that bodies do not have."""


def probed(
    result: Result,
    places: Places,
    s: Amount | Amounts | None = None,
    instants: Instants | None = None,
) -> xr.Dataset:
    """Return the fields of a result at places, in stored states or at instants; see ``Result`` and ``Run.probe``."""
    import xarray as xr

    chosen = _sites(result, places, s)
    bodies = [site.label for site in chosen if site.rod in result.sites.bodies]
    if bodies and len(bodies) < len(chosen):
        raise InputError(
            f"{bodies[0]!r} is a place on a body and has no strains; probe places on bodies and on rods separately"
        )
    along = result.dimension
    level = np.asarray(result.data[along].values, dtype=float) if instants is None else instants.time
    values = fields_at(result, chosen, instants)
    dims: dict[str, tuple[str, ...]] = {
        "angular_velocity": ("director",),
        "rotation": ("quaternion",),
        "frame": ("axis", "director"),
        "strain": ("component",),
        "section_force": ("component",),
        "dissipation": (),
    }
    labels = {
        "axis": list(AXES),
        "quaternion": list("wxyz"),
        "director": list(DIRECTORS),
        "component": result.data["component"].values.tolist() if "component" in result.data.coords else [],
    }
    variables = {
        name: ((along, "place", *dims.get(name, ("axis",))), field, _about(name))
        for name, field in values.items()
    }
    used = {dimension for spec in variables.values() for dimension in spec[0]}
    return xr.Dataset(
        variables,
        {
            along: (along, level, dict(result.data[along].attrs)),
            "place": [site.label for site in chosen],
            "rod": ("place", [site.rod for site in chosen]),
            "s": ("place", [site.s for site in chosen], _about("station_s")),
            **{name: words for name, words in labels.items() if name in used},
        },
        {"title": result.title},
    )


def of_quantity(found: xr.Dataset, quantity: str | None) -> xr.Dataset:
    """Return the fields at places, or one of them alone.

    Raises:
        InputError: it is not there.
    """
    if quantity is None:
        return found
    if quantity not in found:
        near = difflib.get_close_matches(quantity, list(map(str, found)), n=1)
        hint = f"did you mean {near[0]!r}? It" if near else "it"
        at = str(found["place"].values[0])
        raise InputError(
            f"quantity = {quantity!r} is not there at {at}; {hint} can be {', '.join(map(str, found))}"
        )
    return found[[quantity]]


def history_of(
    result: Result,
    places: Places,
    quantity: Quantity,
    s: Any = None,
    instants: Instants | None = None,
) -> xr.DataArray:
    """Return one field at a place, or at several, over the states of a result or at instants."""
    import xarray as xr

    data, along = result.stored, result.dimension
    stored = quantity in ("position", "displacement") or (quantity == "velocity" and quantity in data)
    if isinstance(places, str | int) and s is None and instants is None and stored:
        site = result.sites.at(places)
        name = "velocity" if quantity == "velocity" else "position"
        over: Any
        if isinstance(data, StateArrays):  # which has the units of all data sets
            over, unit = data.along(_about(along), "axis"), _about(name)["units"]
        else:
            over, unit = {along: data[along], "axis": data["axis"]}, data[name].attrs["units"]
        return xr.DataArray(
            result.vector(site, quantity),
            dims=(along, "axis"),
            coords=over,
            name=quantity,
            attrs={"units": unit, "long_name": f"{quantity} of {site.label}"},
        )
    found = of_quantity(probed(result, places, s, instants), quantity)[quantity]
    label = ", ".join(map(str, found["place"].values[:3]))
    if isinstance(places, str | int) and (s is None or np.ndim(s) == 0):
        found = found.isel(place=0).drop_vars(["place", "rod", "s"], errors="ignore")
    return found.assign_attrs(long_name=f"{quantity.replace('_', ' ')} of {label}")


def instants_of(run: Run, times: Any) -> Instants:
    """Return times [s] located among the states of a run.

    Raises:
        InputError: a time lies outside the run.
    """
    return Instants.of(run.time, times, run.step_ends)


def fields_at(
    result: Result,
    sites: Sequence[ResultPlace],
    instants: Instants | None = None,
    of_rods: Sequence[str] = FIELDS,
    *,
    turning: bool = True,
) -> dict[str, Floats]:
    """Return all fields of sites, either all on rods or all on bodies, ``(states or times, sites, ...)`` each.

    Args:
        result: that has them; sites: where; instants: when, left out in all stored states.
        of_rods: which of the fields that bodies do not have.
        turning: whether rotations and velocities are wanted; positions and displacements alone take a quarter as long.
    """
    if sites[0].rod in result.sites.bodies:
        return _OfBodies(result, sites, instants).fields()
    rods = _OfRods(result, sites, instants, of_rods)
    return rods.fields() if turning else rods.places()


def poses_at(run: Result, stations: Integers, instants: Instants) -> Poses:
    """Return the poses of stations at times of a run, reading no other states."""
    moving = PartsRead(run, instants).moving(stations)
    assert moving is not None
    return moving[0]


def _about(name: str) -> dict[str, str]:
    known = VARIABLES | {
        "displacement": ("m", "displacement from the reference shape, global axes"),
        "frame": ("1", "directors d1, d2, d3 as columns, global axes"),
        "station_s": ("m", "arc length in the reference shape, 0 on bodies"),
    }
    unit, text = known[name]
    return {"units": unit, "long_name": text}


def _sites(result: Result, places: Places, s: Amount | Amounts | None) -> list[ResultPlace]:
    if s is not None:
        if not isinstance(places, str) or places not in result.sites.rods:
            raise InputError(
                f"s: arc lengths go with one rod, found {places!r}; give one of {', '.join(result.sites.rods)}"
            )
        arc = np.atleast_1d(np.asarray(s, dtype=float))
        if arc.ndim != 1 or arc.size == 0:
            raise InputError("s: give one arc length in m, or a list of them")
        return [result.sites.along(places, float(value)) for value in arc]
    several: list[str | int] = [places] if isinstance(places, (str, int, np.integer)) else list(places)
    if not several:
        raise InputError("places: give at least one place, such as 'beam.end'")
    return [result.sites.at(place) for place in several]


class PartsRead:
    """Reads the needed parts of the data set only."""

    def __init__(self, result: Result, instants: Instants | None) -> None:
        self.data, self.along, self.instants = result.stored, result.dimension, instants

    def has(self, name: str) -> bool:
        """Return whether the result holds a variable."""
        return name in self.data

    def at(self, name: str, dimension: str, numbers: Integers) -> Floats:
        """Return a variable at some places of a dimension, in the states that are needed."""
        whole: Any = self.data.variables[name]
        variable = whole.isel({dimension: numbers})  # a part of a DataArray takes longer
        if self.instants is not None and self.along in variable.dims:
            return in_states(variable, self.along, self.instants.states)
        return np.asarray(variable.values, dtype=float)

    def moving(self, stations: Integers) -> tuple[Poses, Floats, Floats] | None:
        """Return poses, velocities and spins at the times; None where the result has no velocities."""
        if not self.has("velocity"):
            return None
        names = ("position", "rotation", "velocity", "angular_velocity")
        r, q, v, w = (self.at(name, "station", stations) for name in names)
        if self.instants is not None:
            r, q = self.instants.positions(r, v), self.instants.rotations(q, w)
            v, w = self.instants.fields(v), self.instants.fields(w)
        return Poses(r, q), v, w

    def positions(self, stations: Integers) -> Floats:
        """Return positions at the times, without those of rotations that :meth:`moving` reads beside them."""
        r = self.at("position", "station", stations)
        if self.instants is None or not self.has("velocity"):
            return r
        return self.instants.positions(r, self.at("velocity", "station", stations))

    def poses(self, stations: Integers) -> Poses:
        """Return poses of the stored states that are needed."""
        return Poses(self.at("position", "station", stations), self.at("rotation", "station", stations))


class _OfBodies:
    """Fields at the mass centres and named points of bodies."""

    def __init__(self, result: Result, chosen: Sequence[ResultPlace], instants: Instants | None) -> None:
        self._read = PartsRead(result, instants)
        self._stations = np.array([site.stations[0] for site in chosen])

    def fields(self) -> dict[str, Floats]:
        moving = self._read.moving(self._stations)
        poses = self._read.poses(self._stations) if moving is None else moving[0]
        values = _placed(poses, self._read.at("reference_position", "station", self._stations))
        if moving is not None:
            values |= {"velocity": moving[1], "angular_velocity": moving[2]}
        return values


class _OfRods:
    """Fields at places of rods."""

    def __init__(
        self,
        result: Result,
        chosen: Sequence[ResultPlace],
        instants: Instants | None,
        of_rods: Sequence[str] = FIELDS,
    ) -> None:
        self._read, self._names = PartsRead(result, instants), of_rods
        self._count = len(chosen)
        self._stencil = Stencil.of(result.stored, result.sites, chosen)

    def fields(self) -> dict[str, Floats]:
        read, stencil = self._read, self._stencil
        stations, points = stencil.stations, stencil.points
        moving = read.moving(stations)
        poses = read.poses(stations) if moving is None else moving[0]
        reference = Poses(
            read.at("reference_position", "station", stations),
            read.at("reference_rotation", "station", stations),
        )
        at_points = {
            name: read.at(name, "point", points) for name in self._names if read.has(name) and points.size
        }
        parts: list[dict[str, Floats]] = []
        for group in stencil.groups:
            values = _placed(group.poses(poses), group.poses(reference).position)
            if moving is not None:
                values["velocity"], values["angular_velocity"] = group.rates(*moving)
            for name, field in at_points.items():
                inside = field[:, group.gauss] if field.ndim == 3 else field[:, group.gauss, None]
                found = group.through_gauss_points(inside)
                if read.instants is not None:
                    found = read.instants.fields(found)
                # between Gauss points or states a polynomial through small powers may fall below zero
                values[name] = np.maximum(found[..., 0], 0.0) if name == "dissipation" else found
            parts.append(values)
        return self._together(parts)

    def places(self) -> dict[str, Floats]:
        """Return positions and displacements alone."""
        read, stencil = self._read, self._stencil
        moved = read.positions(stencil.stations)
        reference = read.at("reference_position", "station", stencil.stations)
        parts = []
        for group in stencil.groups:
            position = group.positions(moved)
            parts.append({"position": position, "displacement": position - group.positions(reference)})
        return self._together(parts)

    def _together(self, parts: list[dict[str, Floats]]) -> dict[str, Floats]:
        """Return the fields of all places in the order in which they were asked for."""
        together = {}
        for name in parts[0]:
            first = parts[0][name]
            together[name] = np.empty((len(first), self._count, *first.shape[2:]))
            for group, values in zip(self._stencil.groups, parts, strict=True):
                together[name][:, group.places] = values[name]
        return together


def _placed(poses: Poses, reference: Floats) -> dict[str, Floats]:
    """Return positions, displacements, rotations and frames of places."""
    q = poses.rotation.copy()
    if len(q) > 1:  # both signs mean one rotation: each nearest to the one before it in time
        flips = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
        q[1:][np.cumsum(flips, axis=0) % 2 == 1] *= -1.0
    frame = matrices(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3, 3)
    return {
        "position": poses.position,
        "displacement": poses.position - reference,
        "rotation": q,
        "frame": frame,
    }

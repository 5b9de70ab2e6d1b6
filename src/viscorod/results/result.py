"""Common part of runs and equilibria: places, histories, the file."""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np

from viscorod.alike import Alike
from viscorod.attributes import WellNamed
from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.given_as import Amount, Amounts
from viscorod.results.array_pieces import extremes
from viscorod.results.data_schema import AXES, DIMENSION, annotated
from viscorod.results.mesh_error import mesh_errors
from viscorod.results.result_places import ResultPlace, ResultPlaces
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing, on_paper
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.derivative import Derivative
    from viscorod.results.probe import Places
    from viscorod.results.validity import Validity
    from viscorod.solve.stress.recorded_rods import RecordedRods

Quantity: TypeAlias = Literal[
    "position",
    "displacement",
    "rotation",
    "frame",
    "velocity",
    "angular_velocity",
    "strain",
    "section_force",
    "dissipation",
]
"""What ``probe`` and ``history`` have, and a table of histories."""


class Result(WellNamed, Shown, Alike, ABC):
    """A data set with the methods that all kinds of result have."""

    kind: ClassVar[str]
    picture: ClassVar[str] = "shape"
    """Name of the picture of it all."""
    derivatives: Mapping[str, Derivative[Self]] = MappingProxyType({})
    """By the keys of the numbers that were asked for; see ``Derivative``."""
    _build: Callable[[], xr.Dataset]

    def __init__(self, data: xr.Dataset) -> None:
        if not hasattr(data, "data_vars"):
            raise InputError(
                f"data: {type(data).__name__}: a result is made of an xarray.Dataset; "
                "viscorod.load reads one from a file"
            )
        self.data = annotated(data, self.kind)

    @classmethod
    def owning(cls, data: xr.Dataset) -> Self:
        """Return a result of a data set that nobody else has; it is not copied."""
        result = cls.__new__(cls)
        result.data = annotated(data, cls.kind, own=True)
        return result

    @classmethod
    def later(cls, build: Callable[[], xr.Dataset]) -> Self:
        """Return a result whose data set is built on first use; ``build`` must not depend on when."""
        result = cls.__new__(cls)
        result._build = build
        return result

    @cached_property
    def data(self) -> xr.Dataset:
        """The ``xarray.Dataset`` behind everything; names and units are in ``viscorod.results.data_schema``."""
        data = annotated(self._build(), self.kind, own=True)
        del self._build
        return data

    @cached_property
    def sites(self) -> ResultPlaces:
        """The stations, by rod and arc length."""
        return ResultPlaces(self.data)

    def _content(self) -> Any:
        return self.data

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.data,)

    @property
    def dimension(self) -> str:
        """Name of the dimension along which states are stored: "time" or "load_factor"."""
        return DIMENSION[self.kind]

    @property
    def title(self) -> str:
        """Title of the case, empty if it has none."""
        return str(self.data.attrs.get("title", ""))

    @property
    def outcome(self) -> str:
        """The word "completed", or what stopped the solution."""
        return str(self.data.attrs.get("outcome", "completed"))

    @checked
    def at(self, level: float) -> tuple[Self, float]:
        """Return the state at a time [s] of a motion, or at a load factor, for the ``start`` of another analysis."""
        return self, float(level)

    @property
    def warnings(self) -> list[str]:
        """What the result says against itself, in sentences; they stand in its report, its file and its page too."""
        from viscorod.results.result_warnings import warnings_of

        return warnings_of(self)

    @checked
    def history(
        self,
        places: Places,
        quantity: Quantity = "position",
        *,
        s: Amount | Amounts | None = None,
    ) -> xr.DataArray:
        """Return how a quantity at a place, or at several, changes; see ``probe``, which returns all of them.

        Args:
            places: "beam.end", "beam@0.15" (arc length in m), "plate" (mass centre of a body), "plate.corner" (its
                named point), the number of a station, or a list of these; with ``s`` the name of a rod.
            quantity: "position" [m], "displacement" from the reference shape [m], "velocity" [m/s] and whatever else
                ``probe`` has.
            s: arc lengths on that rod [m].

        Returns:
            Array ``(time, axis)``, or ``(load_factor, axis)`` for an equilibrium; of several places ``(time, place,
            axis)``.

        Raises:
            InputError: no such place or quantity.
        """
        from viscorod.results.probe import history_of

        return history_of(self, places, quantity, s)

    @checked
    def joint(self, name: str) -> xr.Dataset:
        """Return the coordinates of a joint or spring: what each is, how fast it changes, what acts along it.

        Coordinates are the motions of the joint's a relative to its b, from the reference shape; of a spring along a
        line its length. Held ones are there with their reactions. Free rotations of a ball joint are there if something
        acts on them.

        Args:
            name: of the joint or spring, by default its kind and places, such as "revolute arm.end - leg.start".

        Returns:
            ``value`` [m or rad], ``rate`` and ``force`` [N or N m] ``(time, motion)``, or ``(load_factor, motion)``;
            motion is the motion word, ``held`` marks those that the joint or a motor holds. A force is what acts on a
            from the joint. Held values are what they have to be to 1e-10 of the size.

        Raises:
            InputError: no such joint or spring.
        """
        import xarray as xr

        known = list(dict.fromkeys(self.data["joint"].values.tolist())) if "joint" in self.data else []
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1) or known
            hint = f"did you mean {near[0]!r}?" if near else "this result has no joints or springs"
            raise InputError(f"no joint or spring is called {name!r}; {hint}")
        mine = np.flatnonzero(self.data["joint"].values == name)
        words = self.data["joint_motion"].values[mine]
        units = {
            "value": ["m" if word.startswith("u") else "rad" for word in words],
            "rate": ["m/s" if word.startswith("u") else "rad/s" for word in words],
            "force": ["N" if word.startswith("u") else "N m" for word in words],
        }
        return xr.Dataset(
            {
                key: (
                    (self.dimension, "motion"),
                    self.data[f"joint_{key}"].values[:, mine],
                    {"units": ", ".join(dict.fromkeys(unit)), "long_name": f"{key} of {name}"},
                )
                for key, unit in units.items()
            },
            {
                self.dimension: self.data[self.dimension],
                "motion": words,
                "held": ("motion", self.data["joint_held"].values[mine].astype(bool)),
            },
        )

    def vector(self, site: ResultPlace, quantity: Quantity) -> Floats:
        """Return a vector at a site, ``(time or load_factor, axis)``, global axes, SI; other stations are not read."""
        return site.mixed(self.field(quantity, stations=site.stations))

    @checked
    def field(
        self, quantity: Quantity, *, states: int | slice = slice(None), stations: Integers | None = None
    ) -> Floats:
        """Return a vector at all stations in all states, or in some; what is left out is not read.

        Args:
            quantity: as of ``history``.
            states: which of the stored states; one number leaves their dimension out.
            stations: numbers of the stations ``(k,)``.

        Returns:
            Array ``(time or load_factor, station, axis)``, global axes, SI.

        Raises:
            InputError: no such quantity.
        """
        known = ("position", "displacement") + (("velocity",) if "velocity" in self.data else ())
        if quantity not in known:
            raise InputError(f"quantity = {quantity!r} is not stored; it can be {', '.join(known)}")
        name = "velocity" if quantity == "velocity" else "position"
        found, reference = self.data.variables[name], self.data.variables["reference_position"]
        try:
            found = found.isel({self.dimension: states})
            if stations is not None:
                found, reference = found.isel(station=stations), reference.isel(station=stations)
        except (IndexError, KeyError, TypeError, ValueError) as error:
            sizes = f"{self.data.sizes[self.dimension]} states and {self.data.sizes['station']} stations"
            raise InputError(
                f"states, stations: {states!r}, {stations!r}: these are no numbers of states or stations ({error}); "
                f"there are {sizes}, numbered from 0"
            ) from None
        values = np.asarray(found.values, dtype=float)
        return values - reference.values if quantity == "displacement" else values

    @checked
    def probe(
        self,
        places: Places,
        *,
        s: Amount | Amounts | None = None,
        quantity: Quantity | None = None,
    ) -> xr.Dataset:
        """Return everything at any places, by the element's own interpolation, in all stored states.

        Positions and frames are those of the element between its nodes. Strains, section forces and dissipation are
        the polynomial through the Gauss points of the element, of degree p - 1 with order p: with it the element
        stores energy (derivatives of the positions agree with it at the Gauss points only, and are less accurate
        between). Where two elements meet they are those of the element that begins there. Dissipation is not
        negative.

        Args:
            places: "beam.end", "beam@0.15", "plate", "plate.corner", the number of a station, or a list of these; with
                ``s`` the name of a rod.
            s: arc lengths on that rod [m].
            quantity: the only one that is wanted.

        Returns:
            A data set over ``time`` (or ``load_factor``, ``spin``) and ``place`` with ``position``, ``displacement``
            [m], ``rotation`` (quaternion), ``frame`` (d1, d2, d3 as columns of a matrix), ``velocity`` [m/s] and
            ``angular_velocity`` [rad/s, body axes], ``strain``, ``section_force`` (body axes) and ``dissipation``
            [W/m], as far as this kind of result has them; see the reference of the data set for components, units and
            axes. On bodies only the motion.

        Raises:
            InputError: no such place or quantity, or places on rods and on bodies in one call.
        """
        from viscorod.results.probe import of_quantity, probed

        return of_quantity(probed(self, places, s), quantity)

    @checked
    def stress(self, place: str | int, points: Any = None) -> xr.Dataset:
        """Return stress, strain and loss at points of the section at a place, in all stored states.

        The axial stress is linear over the section (of a curved rod over J0, Linn, Lang and Tuganov 2013, equations 10
        to 17, in balance with the section forces), shear stresses are those of Saint-Venant's torsion and flexure. All
        follow from strains and section forces at the place, see ``probe``.

        Args:
            place: "beam.end", "beam@0.15" or the number of a station.
            points: of the section about the centre line ``(n, 2)`` or ``(2,)``, along d1 and d2 [m]; without them those
                of a quadrature, with their ``area``.

        Returns:
            A data set over ``time`` (or ``load_factor``, ``spin``) and ``point``: ``stress``, its ``viscous_stress``
            and the elastic ``strain`` (components 11, 22, 33, 23, 13, 12 along d1, d2, d3), ``von_mises`` [Pa], and of
            a motion ``loss_density`` [W/m^3]; ``x1``, ``x2`` and ``region`` of the points.

        Raises:
            InputError: no such place, a point outside the section, or a section without a known shape.
        """
        from viscorod.results.stress import stress_at

        return stress_at(self, place, points)

    def validity(self) -> Validity:
        """Return the conditions under which a rod model is right, each with its number and its limit.

        Curvature, twist and slenderness of the reference shape, strains, and how quick the motion is beside the
        material's relaxation (Linn, Lang and Tuganov 2013, sections 2.2 and 2.6); ``print`` shows a table.
        """
        from viscorod.results.validity import validity_of

        return validity_of(self)

    @checked
    def plot_stress(
        self,
        path: str | Path | None = None,
        place: str | int | None = None,
        time: float | None = None,
        *,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw axial stress, shear stress and von Mises stress over the section at a place.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            place: on a rod, see ``stress``; by default that of the largest von Mises stress.
            time: of a run [s]; by default the stored one with the largest von Mises stress there. Equilibria and steady
                rotations show their last state.
            ax: axes of yours to draw into: the von Mises stress alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: as of ``stress``, or a time outside the run, or of what is no run.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_stress import draw_stress

        return delivered(draw_stress(self, self._most_stressed() if place is None else place, time, ax), path)

    def _most_stressed(self) -> str:
        """Return the place with the largest von Mises stress of all states."""
        from viscorod.results.largest_stress import largest_stress

        found = largest_stress(self)
        if found is None:
            raise InputError(
                "place: the sections of this result have no known points; name a place for the reason"
            )
        return f"{found.rod}@{found.s!r}"

    @checked
    def plot_strain(
        self,
        path: str | Path | None = None,
        component: str | None = None,
        rod: str | None = None,
        *,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the strains: the largest of every component over time or load, and one of them along a rod.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            component: "shear_1", "shear_2", "stretch", "bend_1", "bend_2" or "twist"; by default what changes most.
            rod: by default the one where it changes most.
            ax: axes of yours to draw into: the profiles along the rod alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such component or rod, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_strain import draw_strain

        return delivered(draw_strain(self, component, rod, ax), path)

    @cached_property
    def recorded_rods(self) -> RecordedRods:
        """The sections of the rods, from what is kept of the model."""
        from viscorod.solve.stress.recorded_rods import RecordedRods

        lengths = {rod: float(self.sites.ends(rod)[1].s) for rod in self.sites.rods}
        return RecordedRods(self.data.attrs, lengths)

    @cached_property
    def displacement_range(self) -> tuple[Floats, Floats]:
        """The least and the largest displacement of every station over all states [m], ``(station, axis)`` each."""
        reference = np.asarray(self.data["reference_position"].values, dtype=float)
        low, high = extremes(self, "position")
        return low - reference, high - reference

    @cached_property
    def mesh_errors(self) -> dict[str, float]:
        """Estimated error of positions by the mesh, as a part of the length of each rod; see ``results.mesh_error``.

        The largest over the states that were compared with a mesh of elements half as long.
        """
        return mesh_errors(self)

    @cached_property
    def main_motion(self) -> tuple[ResultPlace, str]:
        """The station and the global axis whose displacement has the largest range."""
        low, high = self.displacement_range
        # one state alone has no range
        spread = high - low if self.data.sizes[self.dimension] > 1 else np.abs(high)
        station, axis = np.unravel_index(int(np.argmax(spread)), spread.shape)
        return self.sites.at(int(station)), AXES[int(axis)]

    @checked
    def save(self, path: str | Path) -> Path:
        """Write everything to a netCDF4 file, for ``viscorod.load`` and any HDF5 tool; returns the path."""
        from viscorod.results.files.storage import write
        from viscorod.results.files.stored_derivatives import groups_of, with_derivatives

        return write(with_derivatives(self), path, groups_of(self.derivatives))

    @checked
    def save_paraview(self, path: str | Path, *, sections: bool = False) -> Path:
        """Write polylines of all stored states for ParaView, one file in the format VTKHDF.

        Args:
            path: of the file, which ends with .vtkhdf.
            sections: also write the surfaces of rods with their true sections, with axial and von Mises stress.

        Returns:
            The path.

        Raises:
            InputError: another suffix, or the file cannot be written.
        """
        from viscorod.results.files.paraview import write_paraview

        return write_paraview(self, path, sections=sections)

    @abstractmethod
    def report(self) -> str:
        """Return a short report in words and numbers."""

    def __str__(self) -> str:
        return self.report()

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.sites.rods), "rod")
        bodies = {place.partition(".")[0] for place in self.sites.bodies}
        if bodies:
            yield counted(len(bodies), "body", "bodies")
        yield counted(int(self.data.sizes["station"]), "station")
        if self.outcome != "completed":
            yield self.outcome

    def _drawing(self) -> str:
        """Return the reference shape, dashed, and the shape in the last state."""
        reference = np.asarray(self.data["reference_position"].values, dtype=float)
        return self._shapes(reference, self.field("position", states=-1))

    def _shapes(self, faint: Floats, main: Floats) -> str:
        """Return a small drawing of two shapes, positions of the stations ``(station, 3)`` each."""
        parts = [self.sites.stations(rod) for rod in self.sites.rods]
        bodies = np.array([int(self.sites.stations(body)[0]) for body in self.sites.bodies], dtype=int)
        seen = on_paper([*(faint[k] for k in parts), *(main[k] for k in parts), main[bodies]])
        drawing = Drawing()
        for number, line in enumerate(seen[:-1]):
            drawing.line(line, faint=number < len(parts))
        drawing.dots(seen[-1])
        return drawing.svg()

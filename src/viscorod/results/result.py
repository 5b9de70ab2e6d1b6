"""Common part of runs, equilibria and steady rotations: what can be asked of places, the pictures, the file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.given_as import Amount, Amounts
from viscorod.results.recorded_states import Quantity, RecordedStates
from viscorod.shown import counted

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.derivative import Derivative
    from viscorod.results.probe import Places
    from viscorod.results.validity import Validity

__all__ = ["Quantity", "Result"]

READ_AT_ONCE = 2_000_000
"""Strains that are looked at for a line about a result at most."""


class Result(RecordedStates, ABC):
    """A data set with the methods that all kinds of result have."""

    picture: ClassVar[str] = "shape"
    """Name of the picture of it all."""
    derivatives: Mapping[str, Derivative[Self]] = MappingProxyType({})
    """By the keys of the numbers that were asked for; see ``Derivative``."""

    def _facts(self) -> Iterator[str]:
        from viscorod.results.result_warnings import stored_warnings

        yield from super()._facts()
        quick = "strain" not in self.stored or self.stored["strain"].size <= READ_AT_ONCE
        if found := self.warnings if quick else stored_warnings(self.stored):
            yield counted(len(found), "warning")

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
        from viscorod.results.joint_histories import coordinates_of

        return coordinates_of(self, name)

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

    @checked
    def save(self, path: str | Path) -> Path:
        """Write everything to a netCDF4 file, for ``viscorod.load`` and any HDF5 tool; returns the path."""
        from viscorod.results.files.storage import write
        from viscorod.results.files.stored_derivatives import groups_of, with_derivatives

        content = with_derivatives(self) if self.derivatives else self.stored
        return write(content, path, groups_of(self.derivatives))

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

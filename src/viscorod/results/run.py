"""The result of a motion over time."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from viscorod.checks import checked, checked_with, numbers
from viscorod.errors import Fault, InputError
from viscorod.given_as import Amount, Amounts
from viscorod.results.between_records import step_ends
from viscorod.results.data_schema import AXES
from viscorod.results.decrement import Decrement, decrement
from viscorod.results.energy import Energy
from viscorod.results.extremes import resting_value
from viscorod.results.result import Quantity
from viscorod.results.result_places import ResultPlace
from viscorod.results.run_pictures import RunPictures
from viscorod.results.step_error import step_errors
from viscorod.shown import counted, span
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.damping_validity import DampingValidity
    from viscorod.results.element_points import Poses
    from viscorod.results.probe import Places
    from viscorod.results.self_heating import SelfHeating

_STARTS_BELOW = 0.5  # a start this far below rest, as a part of the largest departure, makes minima count


def _times(name: str, value: Any) -> Any:
    """Return times; a word that stands there is taken for the quantity, which ``history`` takes second."""
    if isinstance(value, str) and value.isidentifier():
        raise InputError(
            Fault(name, repr(value), "what probe takes second are times", f"write quantity={value!r}")
        )
    return numbers(name, value)


class Run(RunPictures):
    """A motion over time; ``data`` holds it whole, with ``time`` index 0 the initial state."""

    kind: ClassVar[str] = "simulate"
    ends_of_steps: Floats = np.zeros(0)
    """Times [s] at which its steps ended, known where derivatives were wanted."""

    @property
    def _motion(self) -> Run:
        return self

    def _facts(self) -> Iterator[str]:
        yield span(float(self.time[0]), float(self.time[-1]), "s")
        yield counted(len(self.time), "state")
        yield from super()._facts()

    @property
    def time(self) -> Floats:
        """Stored times [s] ``(time,)``."""
        return np.asarray(self.stored.variables["time"].values, dtype=float)

    @cached_property
    def step_ends(self) -> Integers | None:
        """Numbers ``(k,)`` of stored states that end a step, 0 too; None where some steps end between stored states."""
        if "step_size" not in self.stored:
            return None
        return step_ends(self.time, np.asarray(self.stored["step_size"].values, dtype=float))

    @cached_property
    def energy(self) -> Energy:
        """The energy account."""
        return Energy.of(self.stored)

    @property
    def step_errors(self) -> dict[str, float]:
        """Estimated errors by the steps, the largest at any node and time; see ``results.step_error``.

        "position" [m], "rotation" [rad], "section_force" [N] and "section_moment" [N m]; empty where no step was tried
        again.
        """
        return step_errors(self.stored.attrs)

    @checked
    def decrement(
        self, place: str | int, axis: str, rest: float | None = None, *, below: bool = False
    ) -> Decrement:
        """Return period, amplitude and damping ratio of every cycle of a displacement.

        Args:
            place: "beam.end", "beam@0.15", "plate", "plate.corner" or the number of a station.
            axis: global axis "x", "y" or "z".
            rest: displacement about which it swings [m]; left out, it is taken from the extremes of the motion, also
                where it creeps, as the report does.
            below: minima bound the cycles instead of maxima.

        Raises:
            InputError: no such place or axis, or fewer than two maxima.
        """
        site = self.sites.at(place)
        value, rate = self._component(site, axis)
        return decrement(self.time, value, rate, rest=rest, below=below, place=site.label, axis=axis)

    @checked
    def free_decay(self, place: str | int, axis: str) -> Decrement | None:
        """Return the decrement about the position of rest, or None where the motion is not a regular decay.

        Maxima whose periods agree within 30 % and that do not grow are one; the report and the picture show
        cycles only there. Where the motion starts far below its position of rest, minima count.

        Args:
            place: name of a place, or number of a station; axis: global axis "x", "y" or "z" of the displacement.

        Raises:
            InputError: no such place or axis.
        """
        swing = self._swing(place, axis)
        try:
            found = decrement(self.time, *swing[1:3], rest=None, below=swing[3], place=swing[0], axis=axis)
        except InputError:
            return None
        return found if found.regular else None

    def decay(self, place: str | int, axis: str) -> Decrement:
        """Return the decrement about the position of rest, by minima where the motion starts far below it.

        Args:
            place: name of a place, or number of a station; axis: global axis "x", "y" or "z" of the displacement.

        Raises:
            InputError: no such place or axis, or fewer than two maxima.
        """
        label, value, rate, below = self._swing(place, axis)
        return decrement(self.time, value, rate, rest=None, below=below, place=label, axis=axis)

    def _swing(self, place: str | int, axis: str) -> tuple[str, Floats, Floats, bool]:
        """Return a place in words, its displacement [m] and rate [m/s], and whether it starts far below its rest."""
        site = self.sites.at(place)
        value, rate = self._component(site, axis)
        rest = resting_value(self.time, value, rate)
        below = bool(value[0] - rest < -_STARTS_BELOW * np.max(np.abs(value - rest)))
        return site.label, value, rate, below

    def _component(self, site: ResultPlace, axis: str) -> tuple[Floats, Floats]:
        """Return the displacement [m] of a site along a global axis and its rate [m/s]."""
        if axis not in AXES:
            raise InputError(f"axis = {axis!r} is not a global axis; it can be x, y or z")
        column = AXES.index(axis)
        return self.vector(site, "displacement")[:, column], self.vector(site, "velocity")[:, column]

    @checked
    def snapshot(self, time: float) -> dict[str, Floats]:
        """Return where every rod and body is at a time.

        Args:
            time: any time of the run [s]; between stored times positions follow their velocities (cubic
                Hermite interpolation).

        Returns:
            Rod name -> positions of its stations by increasing arc length [m], shape (n, 3), global axes; name of a
            body, or "body.point" -> its position, shape (1, 3).

        Raises:
            InputError: the time lies outside the run.
        """
        positions = self.positions_at(time)
        return {part: positions[self.sites.stations(part)] for part in (*self.sites.rods, *self.sites.bodies)}

    @checked
    def positions_at(self, time: float) -> Floats:
        """Return the positions of all stations at a time [m], shape (stations, 3), global axes; see ``snapshot``.

        Raises:
            InputError: the time lies outside the run.
        """
        position: Floats = self._poses_at(time).position[0]
        return position

    @checked
    def rotations_at(self, time: float) -> Floats:
        """Return the orientations of all stations at a time, unit quaternions (stations, 4); see ``probe``.

        Raises:
            InputError: the time lies outside the run.
        """
        rotation: Floats = self._poses_at(time).rotation[0]
        return rotation

    def _poses_at(self, time: float) -> Poses:
        from viscorod.results.probe import instants_of, poses_at

        return poses_at(self, np.arange(self.data.sizes["station"]), instants_of(self, time))

    @checked_with(times=_times)
    def probe(
        self,
        places: Places,
        times: Amount | Amounts | None = None,
        *,
        s: Amount | Amounts | None = None,
        quantity: Quantity | None = None,
    ) -> xr.Dataset:
        """Return everything at any places and any times; see ``Result.probe`` for what is between stations.

        Between stored states positions and rotations are cubics through the stored ones and their rates; velocities,
        strains, section forces and dissipation are the polynomial through the stored states of the step, or the cubic
        through the four nearest ones (errors of order 4 in the time between states). Without ``output_interval`` the
        collocation methods store their own polynomial at three instants within every step: strains and section forces
        between are that polynomial again, positions and rotations follow it far below the tolerance. An
        ``output_interval`` should resolve the motion.

        Args:
            places: "beam.end", "beam@0.15", "plate", "plate.corner", the number of a station, or a list of these; with
                ``s`` the name of a rod.
            times: times of the run [s]; without them all stored ones.
            s: arc lengths on that rod [m].
            quantity: the only one that is wanted.

        Returns:
            A data set over ``time`` and ``place``, see ``Result.probe``.

        Raises:
            InputError: no such place or quantity, a time outside the run, or places on rods and on bodies in one call.
        """
        from viscorod.results.probe import instants_of, of_quantity, probed

        found = probed(self, places, s, None if times is None else instants_of(self, times))
        return of_quantity(found, quantity)

    @checked
    def history(
        self,
        places: Places,
        quantity: Quantity = "position",
        times: Amount | Amounts | None = None,
        *,
        s: Amount | Amounts | None = None,
    ) -> xr.DataArray:
        """Return how a quantity at a place, or at several, changes; see ``Result.history``.

        Args:
            places, quantity, s: see there.
            times: times of the run [s]; without them all stored ones. What is between is said in ``probe``.

        Raises:
            InputError: no such place or quantity, or a time outside the run.
        """
        from viscorod.results.probe import history_of, instants_of

        return history_of(self, places, quantity, s, None if times is None else instants_of(self, times))

    @checked
    def stress(
        self, place: str | int, points: Any = None, times: Amount | Amounts | None = None
    ) -> xr.Dataset:
        """Return stress, strain and loss at points of the section at a place; see ``Result.stress``.

        Args:
            place: "beam.end", "beam@0.15" or the number of a station.
            points: of the section about the centre line ``(n, 2)``, along d1 and d2 [m]; see ``Result.stress``.
            times: times of the run [s]; without them all stored ones. What is between stored states is said in
                ``probe``.

        Raises:
            InputError: as of ``Result.stress``, or a time outside the run.
        """
        from viscorod.results.probe import instants_of
        from viscorod.results.stress import stress_at

        return stress_at(self, place, points, None if times is None else instants_of(self, times))

    @checked
    def damping_validity(self, tolerance: float = 0.1) -> DampingValidity:
        """Tell whether Kelvin-Voigt damping was right for this motion, from the spectrum of its strains.

        Where the material is known by a Prony series, the error of the stress is bounded (Linn, Lang and Tuganov
        2013, end of section 2.6); otherwise the frequencies at which energy was lost are compared with the retardation
        times. See ``viscorod.results.damping_validity`` for how the spectrum is taken.

        Args:
            tolerance: accepted error of the stress, as a part of the largest.

        Returns:
            A verdict with numbers for every strain that took part; ``print`` shows it in sentences.

        Raises:
            InputError: the run is too short, or from a version that did not keep its damping laws.
        """
        from viscorod.results.damping_validity import damping_validity

        return damping_validity(self, tolerance)

    def self_heating(self) -> SelfHeating:
        """Tell how much the energy that the motion lost warms its rods at most: over the run, and in one cycle.

        It is the adiabatic bound, loss over heat capacity, as a mean over each section; see
        ``viscorod.results.self_heating``.

        Returns:
            The rise of temperature [K] of every rod whose material has a specific heat; ``print`` shows sentences.

        Raises:
            InputError: no material has a specific heat.
        """
        from viscorod.results.self_heating import self_heating

        return self_heating(self)

    def report(self) -> str:
        """Return a report: the start, every cycle of the decay, the energy account, the effort, warnings."""
        from viscorod.results.reports.motion_report import run_report

        return run_report(self)

"""Records over time: position, displacement, velocity, strain, force, rotation at a place of a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.records.any_record import AnyRecord, deviations, finite, increasing
from viscorod.records.arguments import described
from viscorod.records.clock_times import from_the_first, turned_on
from viscorod.records.history_unknowns import unknowns_of_a_history
from viscorod.records.other_files import columns_of
from viscorod.records.read_off import (
    QUANTITIES,
    WITHOUT_LEVER,
    Direction,
    direction_text,
    motion_along,
)
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats

if TYPE_CHECKING:
    from typing import Self

__all__ = ["Record"]

EVEN = 1e-3
"""Part of the interval by which samples of one rate may be off their place."""
MOST_WEIGHED = 14.0
"""Time constants of a window after which it is down to a millionth, and what it left is no signal."""
UNSORTED = "sort the samples, each once; of stamps that were rounded give even times, in read by rate"
ROUNDED = tuple(10.0**-k for k in range(10))
"""Parts of a second to which stamps may be rounded; first and last one are off too, so that all may be by one part."""


class Record(AnyRecord):
    """A history that was measured: one number at a place of a model, over time.

    Times are those of the measurement; with the unknown "release_time" the motion of the model begins at that time of
    the record, otherwise both have the same zero. Before the release the model is what it is at its start.

    Args:
        times: increasing, s (n,).
        values: SI (n,): m, m/s, m/s^2, 1, N, rad, rad/s or N m.
        place: of the model, "beam.end", "beam@0.15", "plate.corner".
        quantity: "position", "displacement" (from the reference shape), "velocity", "acceleration", "strain", "force"
            or "moment" (of the section, what the part beyond exerts on the part before), "rotation" (rotation vector
            from the reference shape, less than half a turn) or "angular_velocity".
        direction: "x", "y", "z" or a vector in global axes; of velocities, accelerations and forces also "d1", "d2",
            "d3", which turn with the section; of a strain a component such as "bend_2", or "axial" at the `lever`.
        noise: standard deviation of the noise of a sample, SI, one number or (n,); None where it is not known.
        lever: where the marker or gauge sits, from the place along d1, d2, d3, m.
        unknown: words, or `Unknown` with what is believed beforehand: "release_time" (s), "offset", "drift" (of the
            rest, per s), "gain", "orientation_x", "orientation_y", "orientation_z" (rotation vector of the measuring
            frame, rad), "marker_1", "marker_2", "marker_3" (to be added to the lever, m); others with the key of a
            number of the case.
        name: of the record; by default its place.

    Attributes:
        place, quantity, direction, lever: as given; times, values: (n,).

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "motion"
    analysis: ClassVar[str] = "simulate"

    @described
    def __init__(
        self,
        times: Any,
        values: Any,
        *,
        place: str,
        quantity: str,
        direction: Direction,
        noise: Any = None,
        lever: Sequence[float] = (0.0, 0.0, 0.0),
        unknown: Sequence[str | Unknown] = (),
        name: str | None = None,
    ) -> None:
        if not isinstance(place, str) or not place:
            raise InputError(
                Fault("place", repr(place), "no place of a model", "give one such as 'beam.end'")
            )
        where = f"record {name or place}"
        self.times = increasing(f"{where}: times", times, UNSORTED)
        self.values = finite(f"{where}: values", values)
        if len(self.values) != len(self.times):
            raise InputError(
                Fault(
                    where, f"{len(self.values)} values", f"there are {len(self.times)} times", "give as many"
                )
            )
        if len(self.times) < 2:
            raise InputError(Fault(where, "1 sample", "a history has several", "give two or more"))
        if quantity not in QUANTITIES:
            raise InputError(
                Fault(
                    f"{where}: quantity",
                    repr(quantity),
                    "it is not known",
                    f"use one of {', '.join(QUANTITIES)}",
                )
            )
        self.place, self.quantity = place, quantity
        self.lever = finite(f"{where}: lever", lever)
        if self.lever.shape != (3,):
            raise InputError(
                Fault(f"{where}: lever", "", "three numbers are needed", "give (0.0, 0.0, 0.01)")
            )
        if quantity in WITHOUT_LEVER and self.lever.any():
            why = f"a {quantity.replace('_', ' ')} is that of the whole section"
            raise InputError(Fault(f"{where}: lever", "", why, "leave it out"))
        self.direction = QUANTITIES[quantity].direction(f"{where}: direction", direction)
        self.observed = self.values
        self.noise = deviations(f"{where}: noise", noise, self.values.shape)
        known = unknowns_of_a_history(self.times, self.values, self.quantity, self.direction)
        self._named(name or place, unknown, known)

    @classmethod
    @described
    def read(
        cls,
        source: Any,
        value: str | int,
        *,
        quantity: str,
        time: str | int = 1,
        unit: str | None = None,
        time_unit: str | None = None,
        rate: float | None = None,
        gaps: str = "refuse",
        **more: Any,
    ) -> Record:
        """Return a record from a column of a file, or of an object of xarray or pandas.

        Text files are read as tables of moduli are: names with units ("t [s]", "x (mm)", "tip_x_m", or units in the
        line below), any encoding, tabs, semicolons, commas or blanks, decimal commas. The extra ``viscorod[records]``
        reads UFF (functions named by node and direction, "3:+z") and C3D ("marker x"). Fields of structures of MATLAB
        are named "data.tip". Times of day, dates and seconds since 1970 count from the first sample; angles that begin
        again after a whole turn are counted on.

        Args:
            source: path, ``DataArray``, ``Dataset``, ``DataFrame`` or ``Series``.
            value, time: columns by name, without unit, or number from 1.
            quantity: see `Record`; with it the unit of the values is checked.
            unit, time_unit: where the source does not say.
            rate: samples per second, where there is no column of times; the first sample is at 0.
            gaps: of samples without a number: "refuse", or "leave out". Samples around a gap are not evenly spaced,
                and their noise counts as white.
            more: all else that a `Record` has: place, direction, noise (SI), unknown, ...

        Raises:
            InputError: it cannot be read, a column is missing, a unit is missing or of another kind.
        """
        columns = columns_of(source, value)
        if rate is not None:
            if rate <= 0.0:
                raise InputError(Fault("rate", f"{rate:g}", "it is not positive", "give samples per second"))
            columns, time = columns.timed(1.0 / rate, "time"), "time"
        elif columns.number("time", time) == columns.number("value", value):
            raise InputError(
                Fault(
                    f"{columns.source}: time", repr(time), "this column has the values, and none has times",
                    "give rate, samples per second, or the column of the times",
                )
            )  # fmt: skip
        columns = columns.kept(gaps, [("time", time), ("value", value)])
        if quantity not in QUANTITIES:
            raise InputError(
                Fault("quantity", repr(quantity), "it is not known", f"use one of {', '.join(QUANTITIES)}")
            )
        chosen, si = QUANTITIES[quantity], QUANTITIES[quantity].units[0]
        if "direction" in more:
            si = chosen.unit(chosen.direction("direction", more["direction"]))
        return cls(
            from_the_first(columns.si("time", time, "s", time_unit)),
            turned_on(quantity, columns.si("value", value, si, unit)),
            quantity=quantity,
            **more,
        )

    @property
    def unit(self) -> str:
        """SI unit of the values."""
        return QUANTITIES[self.quantity].unit(self.direction)

    @property
    def axes(self) -> tuple[tuple[str, str], ...]:
        """See `AnyRecord`."""
        return ((f"{self.quantity} {direction_text(self.direction)} of {self.place}", self.unit),)

    @property
    def interval(self) -> float | None:
        """Time between samples, s; None where they are not evenly spaced, beyond what stamps were rounded to."""
        mean = float(np.mean(np.diff(self.times)))
        even = self.times[0] + mean * np.arange(len(self.times))
        off = float(np.abs(self.times - even).max())
        rounded = next((one for one in ROUNDED if _are_multiples(self.times, one)), 0.0)
        return mean if off <= max(EVEN * mean, min(rounded, 0.5 * mean)) else None

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what a run says that should have been measured at the samples (n,); see `AnyRecord`.

        gain (direction . quantity(t - release_time)) + offset + drift (t - first time), with the direction turned by
        the orientation, and the place moved by lever and marker.
        """
        self._needs(result, "simulate")
        values = self.values_of(nuisances)
        raw = self.read_off(result, values)
        return self.measured(raw, values)

    @described
    def read_off(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return the model's quantity along the direction at the samples (n,), before gain and offset."""
        values = self.values_of(nuisances)
        times = self.times - self.nuisance("release_time", values)
        turn = np.array([self.nuisance(f"orientation_{axis}", values) for axis in "xyz"])
        marker = np.array([self.nuisance(f"marker_{k}", values) for k in (1, 2, 3)])
        return motion_along(result, self, times, self.lever + marker, turn)

    @described
    def measured(
        self, raw: Floats, nuisances: Mapping[str, float] | None = None, *, change: bool = False
    ) -> Floats:
        """Return what an instrument shows of the model's quantity (..., n): gain, offset and drift.

        Args:
            raw: of `read_off`, or its derivative by a number of the case.
            nuisances: values of the unknowns.
            change: whether `raw` is a derivative, to which offset and drift do not belong.
        """
        values = self.values_of(nuisances)
        given = np.asarray(raw) if hasattr(raw, "dtype") else finite("raw", raw)
        if (
            given.dtype.kind not in "fiu"
            or given.shape[-1:] != self.times.shape
            or not np.isfinite(given).all()
        ):
            raise InputError(
                f"record {self.name}: raw: {len(self.times)} finite numbers are needed, as of read_off"
            )
        shown = self.nuisance("gain", values, 1.0) * given
        if change:
            return shown
        found: Floats = (
            shown
            + self.nuisance("offset", values)
            + self.nuisance("drift", values) * (self.times - self.times[0])
        )
        return found

    @described
    def window(self, start: float, end: float) -> Self:
        """Return the samples between two times, s.

        Raises:
            InputError: fewer than two samples are there.
        """
        inside = (self.times >= start) & (self.times <= end)
        if np.count_nonzero(inside) < 2:
            raise InputError(
                Fault(
                    f"record {self.name}: window",
                    f"{start:g} to {end:g} s",
                    "fewer than two samples are there",
                    f"the record goes from {self.times[0]:g} to {self.times[-1]:g} s",
                )
            )
        return self.with_samples(
            self.times[inside], self.values[inside], None if self.noise is None else self.noise[inside]
        )

    def decimated(self, factor: int) -> Self:
        """Return every k-th sample, after a filter against aliasing without phase.

        It is that of ``scipy.signal.decimate``, of finite length, a Hamming window of order 20 k: half the size is left
        at the new half rate. The noise of the record becomes smaller accordingly.

        Raises:
            InputError: the samples are not evenly spaced, or too few for the factor.
        """
        if not isinstance(factor, int) or isinstance(factor, bool) or factor < 1:
            raise InputError(
                Fault(f"record {self.name}: factor", repr(factor), "no factor", "give 2, 3, ...")
            )
        if factor == 1:
            return self
        if self.interval is None:
            raise InputError(
                f"record {self.name}: its samples are not evenly spaced; they cannot be decimated"
            )
        if len(self.values) < 20 * factor:
            raise InputError(
                Fault(
                    f"record {self.name}: factor",
                    str(factor),
                    f"{len(self.values)} samples are too few",
                    f"give {max(len(self.values) // 20, 1)} at most",
                )
            )
        from scipy.signal import decimate, firwin

        values = decimate(self.values, factor, ftype="fir", zero_phase=True)
        noise = self.noise
        if noise is not None:
            taps = firwin(20 * factor + 1, 1.0 / factor, window="hamming")
            noise = noise[::factor] * float(np.sqrt(np.sum(taps**2)))
        return self.with_samples(self.times[::factor], values, noise)

    @described
    def without_exponential(self, window_time: float, start: float | None = None) -> Self:
        """Return the record without an exponential window that an analyser multiplied it by.

        Its noise is that of the measurement again; a `noise` that was given stays as it is.

        Args:
            window_time: time constant of the window, s: at the end of a record of length T where it is down to the part
                p this is -T/ln p.
            start: where the window begins to fall, s; by default at the first sample.

        Raises:
            InputError: the time constant is not positive, or so short that the end has no numbers.
        """
        begin = float(self.times[0]) if start is None else float(start)
        last = float(self.times[-1]) - begin
        if not window_time > 0.0 or last > MOST_WEIGHED * window_time:
            raise InputError(
                Fault(
                    f"record {self.name}: window_time", f"{window_time:g}",
                    "a time constant is positive" if not window_time > 0.0
                    else f"the window would be down to {np.exp(-last / window_time):.1g} at the end",
                    "give that of the analyser, s, or cut the end off by window",
                )
            )  # fmt: skip
        growth = np.exp(np.maximum(self.times - begin, 0.0) / window_time)
        return self.with_samples(self.times, self.values * growth, self.noise)

    @described
    def with_noise_of(self, start: float, end: float) -> Self:
        """Return the record with the noise that a stretch at rest has, s: the deviation from a straight line there."""
        still = self.window(start, end)
        if len(still.values) < 10:
            raise InputError(
                Fault(
                    f"record {self.name}: noise",
                    f"{len(still.values)} samples",
                    "too few",
                    "give 10 or more at rest",
                )
            )
        line = np.polyfit(still.times - still.times[0], still.values, 1)
        rest = still.values - np.polyval(line, still.times - still.times[0])
        size = float(np.sqrt(np.sum(rest**2) / (len(rest) - 2)))
        if size == 0.0:
            raise InputError(
                f"record {self.name}: nothing moves between {start:g} and {end:g} s, not even noise"
            )
        return self.with_samples(self.times, self.values, np.full(len(self.values), size))

    def with_samples(self, times: Floats, values: Floats, noise: Floats | None = None) -> Self:
        """Return a record of other samples that are described alike.

        Args:
            times: s (n,); values, noise: SI (n,).
        """
        return type(self)(
            times,
            values,
            place=self.place,
            quantity=self.quantity,
            direction=self.direction,
            noise=noise,
            lever=self.lever.tolist(),
            unknown=list(self.nuisances.values()),
            name=self.name,
        )

    def __str__(self) -> str:
        rate = self.interval
        sampled = "unevenly" if rate is None else f"at {1.0 / rate:.6g} Hz"
        noise = "not known" if self.noise is None else f"{float(np.median(self.noise)):.3g} {self.unit}"
        unknown = ", ".join(one.name for one in self.nuisances.values()) or "nothing"
        return (
            f"Record {self.name}: {self.quantity} {direction_text(self.direction)} of {self.place} [{self.unit}], "
            f"{len(self.times)} samples {sampled} from {self.times[0]:.6g} to {self.times[-1]:.6g} s; "
            f"noise {noise}; unknown: {unknown}"
        )


def _are_multiples(times: Floats, unit: float) -> bool:
    return bool(np.abs(times / unit - np.round(times / unit)).max() < 1e-6)

"""Frequency responses that were measured."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from scipy.ndimage import uniform_filter1d

from viscorod.errors import Fault, InputError
from viscorod.records.any_record import AnyRecord, deviations, finite, increasing
from viscorod.records.arguments import described
from viscorod.records.column_units import si_size_and_kind
from viscorod.records.columns import Columns
from viscorod.records.one_sided import mirrored_from, one_sided
from viscorod.records.other_files import columns_of
from viscorod.records.response_unit import require_same_unit, si_unit_of_kind, unit_of_response
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats

__all__ = ["ResponseRecord"]

LEAST_INCOHERENT = 1e-8
"""What a coherence that is written as 1 may lack."""
SCATTER = 40.0
"""Degrees of freedom of a noise by coherences at least: with few averages, of several neighbouring lines together."""
WINDOWS = ("exponential", "hann")
EXCITATIONS = ("blow", "noise")
DEGREE = float(np.pi / 180.0)
_DECIBEL = re.compile(
    r"\s*dB\s*(?:\(\s*(?:re[fl]?\b\.?:?)?\s*(.+?)\s*\)|re[fl]?\b\.?:?\s*(.+?))?\s*", re.IGNORECASE
)
_PHASE = re.compile(r"phase|angle|winkel|^arg\b|^phi\b|φ", re.IGNORECASE)
_MAGNITUDE = re.compile(r"^mag|magnitude|betrag|^ampl|^abs\b|^\|", re.IGNORECASE)
"""Names of columns of magnitudes and phases, in English and German."""


def _angle(unit: str | None) -> float | None:
    """Return the size of a unit of angles, rad; None of others."""
    return {"deg": DEGREE, "degree": DEGREE, "degrees": DEGREE, "°": DEGREE, "rad": 1.0, "radians": 1.0}.get(
        (unit or "").strip().casefold()
    )


def _phase_unit(
    columns: Columns, places: Sequence[int], written: str | None, given: str | None
) -> str | None:
    """Return the unit of the second of two columns: that of an angle, or of imaginary parts.

    Raises:
        InputError: their names are those of a magnitude and a phase, of which no unit is told; or it is no angle.
    """
    name = columns.names[places[1]]
    if given is not None:
        if _angle(given) is None:
            raise InputError(Fault("phase_unit", repr(given), "it is no unit of an angle", "give deg or rad"))
        if written is not None and _angle(written) != _angle(given):
            why = f"the source says {written!r} of column {name}"
            raise InputError(Fault(f"{columns.source}: phase_unit", repr(given), why, "leave it out"))
        return given
    if written is None and (_PHASE.search(name) or _MAGNITUDE.search(columns.names[places[0]])):
        raise InputError(
            Fault(
                f"{columns.source}: value", repr(name), "of a phase its unit is needed",
                "write it beside the name, or give phase_unit = 'deg' or 'rad'",
            )
        )  # fmt: skip
    return written


def _plain(columns: Columns, column: str | int) -> str | None:
    """Return the unit of a plain number, unless the source gives one."""
    return "1" if columns.units[columns.number("coherence", column)] is None else None


def _complex(where: str, values: Any) -> np.ndarray:
    """Return complex numbers in one row."""
    try:
        given = np.asarray(values)
    except ValueError:
        given = np.empty(0, dtype=object)
    if given.dtype.kind not in "fiuc" or given.ndim != 1:
        raise InputError(Fault(where, "", "these are no complex numbers in one row", "give a list of them"))
    return given


def _noise_of(where: str, size: Floats, coherence: Any, averages: int | None) -> Floats:
    """Return the noise of a mean of responses of these sizes (n,)."""
    if coherence is None or averages is None:
        key = "averages" if averages is None else "coherence"
        raise InputError(
            Fault(f"{where}: {key}", "", "the noise needs coherence and averages", "give both, or neither")
        )
    if isinstance(averages, bool) or not isinstance(averages, int) or averages < 2:
        why = "a coherence is that of two records or more"
        raise InputError(Fault(f"{where}: averages", repr(averages), why, "give a whole number such as 8"))
    told = finite(f"{where}: coherence", coherence)
    if told.shape != size.shape or not ((told > 0.0) & (told <= 1.0)).all():
        why = f"{len(size)} numbers above 0, 1 at most, are needed"
        raise InputError(Fault(f"{where}: coherence", "", why, "take lines without coherence out"))
    told = np.minimum(told, 1.0 - LEAST_INCOHERENT)
    relative = np.log((1.0 - told) / (2.0 * averages * told))
    aside = min(int(np.ceil(SCATTER / (4 * (averages - 1)))) - 1, len(size) // 8)
    smooth = uniform_filter1d(relative, 2 * aside + 1, mode="nearest")
    return np.asarray(size * np.exp(0.5 * smooth))


def _require_window(
    where: str, window: str | None, window_time: float | None, excitation: str | None
) -> None:
    """Raise `InputError` unless window, time constant and excitation go together."""
    faults = []
    if window not in (None, *WINDOWS):
        faults.append(
            Fault(
                f"{where}: window",
                repr(window),
                "it is not known",
                f"give {' or '.join(WINDOWS)}, or leave it out",
            )
        )
    if excitation not in (None, *EXCITATIONS):
        faults.append(
            Fault(
                f"{where}: excitation",
                repr(excitation),
                "it is not known",
                f"give {' or '.join(EXCITATIONS)}, or leave it out",
            )
        )
    elif window == "exponential" and excitation == "noise":
        faults.append(
            Fault(f"{where}: excitation", "noise", "an exponential window is one of a blow", "give blow")
        )
    if (window == "exponential") != (window_time is not None):
        why = "an exponential window has a time constant" + ("" if window_time is None else ", and no other")
        told = "" if window_time is None else f"{window_time:g}"
        faults.append(Fault(f"{where}: window_time", told, why, "give window='exponential' and its time, s"))
    elif window_time is not None and not window_time > 0.0:
        faults.append(
            Fault(f"{where}: window_time", f"{window_time:g}", "a time constant is positive", "give it in s")
        )
    if faults:
        raise InputError(faults)


class ResponseRecord(AnyRecord):
    """A frequency response that was measured: output over input, complex, exp(i omega t).

    Args:
        frequencies: increasing, Hz (n,).
        values: complex, SI units of output over input (n,).
        output, source: words or numbers of the output and the input of the model's response.
        unit: SI unit of the values, such as "m/s^2/N", which that of the model's response must be; None where it is not
            known.
        noise: standard deviation of real and imaginary part, one number or (n,); None where it is not known.
        coherence: from 0 to 1 (n,), and averages: of how many records the response is the mean; together they tell the
            noise, ``|H| sqrt((1 - coherence)/(2 averages coherence))`` (J. S. Bendat and A. G. Piersol, Random Data,
            section 9.2.4). Of few averages it is the mean of neighbouring lines.
        window: of the analyser, "exponential" or "hann"; None where there was none.
        window_time: time constant of an exponential window, s: at the end of a record of length T where it is down to
            the part p this is -T/ln p.
        excitation: "blow", also of periodic signals and sines, after which the spectrum of the record is exact, or
            "noise", of which lines are averages (H1).
        unknown: "gain", "delay" (s, by which the output comes late).
        name: of the record.

    Attributes:
        observed: real parts, then imaginary parts (2 n,).

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "response"
    analysis: ClassVar[str] = "response"

    @described
    def __init__(
        self,
        frequencies: Any,
        values: Any,
        *,
        output: str | int = 0,
        source: str | int = 0,
        unit: str | None = None,
        noise: Any = None,
        coherence: Any = None,
        averages: int | None = None,
        window: str | None = None,
        window_time: float | None = None,
        excitation: str | None = None,
        unknown: Sequence[str | Unknown] = (),
        name: str = "response",
    ) -> None:
        where = f"record {name}"
        self.frequencies = increasing(f"{where}: frequencies", frequencies)
        given = _complex(f"{where}: values", values)
        self.observed = finite(f"{where}: values", np.concatenate([np.real(given), np.imag(given)], axis=0))
        if len(self.observed) != 2 * len(self.frequencies):
            raise InputError(
                Fault(
                    where,
                    f"{len(self.observed) // 2} values",
                    f"there are {len(self.frequencies)} frequencies",
                    "",
                )
            )
        if self.frequencies[0] < 0.0:
            raise InputError(
                Fault(f"{where}: frequencies", "", "a frequency is negative", "give the positive ones")
            )
        mirrored = mirrored_from(self.frequencies, given)
        if mirrored is not None:
            raise InputError(
                Fault(
                    f"{where}: frequencies", f"{self.frequencies[mirrored]:g}",
                    "the lines from there on are the mirror of those below: it is a spectrum with two sides",
                    f"give the first {mirrored} lines",
                )
            )  # fmt: skip
        self.output, self.source, self.unit = output, source, unit_of_response(where, unit)
        self.window, self.window_time, self.excitation = window, window_time, excitation
        _require_window(where, window, window_time, excitation)
        if coherence is not None or averages is not None:
            if noise is not None:
                raise InputError(
                    Fault(f"{where}: noise", "", "the coherence tells the noise", "give one of them")
                )
            noise = _noise_of(where, np.abs(given), coherence, averages)
        one = deviations(f"{where}: noise", noise, self.frequencies.shape)
        self.noise = None if one is None else np.concatenate([one, one])
        step = float(np.min(np.diff(self.frequencies))) if len(self.frequencies) > 1 else 1.0
        self._named(name, unknown, {"gain": (1.0, 1e-3, 1e3), "delay": (0.0, -0.25 / step, 0.25 / step)})

    @classmethod
    @described
    def read(
        cls,
        source: Any,
        /,
        value: str | int | Sequence[str | int],
        *,
        frequency: str | int = 1,
        step: float | None = None,
        unit: str | None = None,
        frequency_unit: str | None = None,
        phase_unit: str | None = None,
        coherence: str | int | None = None,
        gaps: str = "refuse",
        **more: Any,
    ) -> ResponseRecord:
        """Return a response from columns of a file, or of an object of xarray or pandas; see `Record.read`.

        Args:
            source: path or object; the name ``source`` is that of the input of the model's response, as of the record.
            value: a complex column, in texts of "1.2+3.4j", "(1.2, 3.4)" or "1.2@45deg"; or two: real and imaginary
                part, or magnitude and phase where the second one is an angle (deg, rad). A magnitude in dB needs the
                unit that it is over.
            frequency: column of the frequencies, by name or number from 1.
            step: between lines, Hz, where there is no column of frequencies; the first line is at 0.
            unit: of output over input, such as "m/s^2/N" or "g/N", where the source does not say; of decibels what 0 dB
                are, or "dB re 1 g/N".
            frequency_unit, phase_unit: where the source does not say; of a phase "deg" or "rad".
            coherence: column of the coherence; it needs `averages`.
            gaps: of lines without a number: "refuse", or "leave out".
            more: all else that a `ResponseRecord` has.

        Of a spectrum with two sides the lines from 0 Hz on are read; a line at 0 Hz without a number is left out.

        Raises:
            InputError: it cannot be read, a column or a unit is missing.
        """
        parts = [value] if isinstance(value, str | int) else list(value)
        columns = columns_of(source, parts[0])
        if step is not None:
            if step <= 0.0:
                raise InputError(
                    Fault("step", f"{step:g}", "it is not positive", "give that of the lines, Hz")
                )
            columns, frequency = columns.timed(step, "frequency", "Hz"), "frequency"
        places = [columns.number("value", part) for part in parts]
        if len(places) > 2:
            raise InputError(
                Fault("value", repr(value), "too many columns", "give one complex, or two real ones")
            )
        for k in places:
            columns.require_numbers(k)
        if len(places) == 1 and not columns.values[:, places[0]].imag.any():
            raise InputError(
                Fault(
                    f"{columns.source}: value",
                    repr(value),
                    "its numbers are real, and a response has a phase",
                    "give two columns: real and imaginary part, or magnitude and phase",
                )
            )
        wanted: list[tuple[str, str | int]] = [("frequency", frequency), *(("value", one) for one in parts)]
        columns = columns.kept(gaps, wanted + ([] if coherence is None else [("coherence", coherence)]))
        told = [columns.units[k] for k in places]
        numbers = [columns.values[:, k] for k in places]
        if len(places) > 1:
            told[1] = _phase_unit(columns, places, told[1], phase_unit)
        turn = _angle(told[1]) if len(places) > 1 else None
        if turn is not None and unit is not None and _DECIBEL.fullmatch(unit):
            told[0], unit = unit, None
        decibel = _DECIBEL.fullmatch(str(told[0])) if turn is not None else None
        if decibel is not None:
            told[0] = decibel[1] or decibel[2]
        written = [unit] if unit is not None else told[:1] if turn is not None else told
        if None in written or len(set(written)) > 1:
            why = "it is not said what 0 dB are" if decibel else "its unit is not known"
            if len(set(written)) > 1:
                why = " and ".join(
                    f"{part} is in {one or 'no unit'}" for part, one in zip(parts, told, strict=True)
                )
            raise InputError(
                Fault(f"{columns.source}: value", repr(value), why, "give unit, such as 'm/s^2/N'")
            )
        size, kind = si_size_and_kind(columns.source, "value", str(written[0]))
        if turn is not None:
            magnitude = 10.0 ** (numbers[0].real / 20.0) if decibel else numbers[0].real
            values = magnitude * np.exp(1j * turn * numbers[1].real)
        else:
            values = numbers[0] + (1j * numbers[1] if len(places) > 1 else 0.0)
        hertz = columns.si("frequency", frequency, "Hz", frequency_unit)
        kept = np.isfinite(values) | (hertz != 0.0)
        columns.require_no_gaps(places[0], np.where(kept, values, 0.0))
        kept[kept] = one_sided(columns.source, hertz[kept], values[kept])
        if coherence is not None:
            columns = replace(columns, values=columns.values[kept])
            more["coherence"] = columns.si("coherence", coherence, "1", _plain(columns, coherence))
        return cls(hertz[kept], size * values[kept], unit=si_unit_of_kind(kind), **more)

    @property
    def axes(self) -> tuple[tuple[str, str], ...]:
        """See `AnyRecord`."""
        return (("real part", self.unit or ""), ("imaginary part", self.unit or ""))

    @property
    def values(self) -> np.ndarray:
        """The complex responses (n,)."""
        count = len(self.frequencies)
        found: np.ndarray = self.observed[:count] + 1j * self.observed[count:]
        return found

    def conjugate(self) -> ResponseRecord:
        """Return the same response where it was given with exp(-i omega t)."""
        return ResponseRecord(
            self.frequencies,
            self.values.conj(),
            output=self.output,
            source=self.source,
            unit=self.unit,
            noise=None if self.noise is None else self.noise[: len(self.frequencies)],
            window=self.window,
            window_time=self.window_time,
            excitation=self.excitation,
            unknown=list(self.nuisances.values()),
            name=self.name,
        )

    def _over(self) -> str:
        return f" from {self.frequencies[0]:.6g} to {self.frequencies[-1]:.6g} Hz"

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what a `FrequencyResponse` says (2 n,), straight lines between its frequencies; see `AnyRecord`."""
        self._needs(result, "response")
        if self.window is not None:
            raise InputError(
                Fault(
                    f"record {self.name}: window",
                    self.window,
                    "the response of a model has none, and its peaks are not as wide",
                    "take its modes by viscorod.modal_fit, and fit viscorod.ModesRecord.of(them)",
                )
            )
        hertz = np.asarray(result.frequencies, dtype=float)
        mine = self.frequencies
        slack = 1e-9 * hertz[-1]
        if mine[0] < hertz[0] - slack or mine[-1] > hertz[-1] + slack:
            raise InputError(
                f"record {self.name}: it goes from {mine[0]:.6g} to {mine[-1]:.6g} Hz, and the response from "
                f"{hertz[0]:.6g} to {hertz[-1]:.6g} Hz; compute it over the band of the record"
            )
        response = np.asarray(result.response(self.output, self.source))
        if self.unit is not None:
            gain = any(one.name == "gain" for one in self.nuisances.values())
            modelled = str(result.unit(self.output, self.source))
            require_same_unit(f"record {self.name}", self.unit, modelled, gain=gain)
        values = self.values_of(nuisances)
        model = np.interp(mine, hertz, response.real) + 1j * np.interp(mine, hertz, response.imag)
        shown = self.nuisance("gain", values, 1.0) * model
        shown = shown * np.exp(-2j * np.pi * mine * self.nuisance("delay", values))
        return np.concatenate([shown.real, shown.imag])

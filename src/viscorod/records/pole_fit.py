"""Poles of measured frequency responses: frequencies and damping ratios of modes, also far narrower than the bins.

About each peak the response is residue/(i omega - s), the same of neighbouring modes, whose poles are those of a first
fit, and a polynomial of the second degree for all other modes. Where
a record of the length T is transformed without a window, the response at the multiples of 1/T has this form exactly
however long the mode rings, since exp(i omega T) is 1 there: the pole is in the complex values of neighbouring bins,
the half-power width is not.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.stats import t as student

from viscorod.argument_names import telling
from viscorod.errors import Fault, InputError
from viscorod.one_thread import one_blas_thread
from viscorod.records.arguments import described
from viscorod.records.decay_doubts import BINS, half_power_width
from viscorod.records.line_shapes import LineShape, line_shape
from viscorod.records.peak_noise import CONFIDENCE, Pole, poles_of
from viscorod.records.pole_about_peak import LEAST, Peak, peak_fits, rough_pole, spacing
from viscorod.records.response_doubts import (
    by_excitation,
    excitation_doubts,
    turns_backwards,
    window_doubts,
)
from viscorod.records.response_record import ResponseRecord
from viscorod.records.response_unit import is_load_over_motion
from viscorod.results.modal_fit_result import ModalFit
from viscorod.results.resonances import MEASURED, resonances_of
from viscorod.results.text_numbers import per_cent
from viscorod.solve.estimation.noise import MEDIAN_TO_DEVIATION
from viscorod.typing import Floats

__all__ = ["modal_fit"]

STANDS_OUT = 4.0
"""Size of a peak over the median about it."""
ABOUT = 0.15
"""Part of all frequencies, on each side, of which that median is."""
ABOUT_LINES = 1000
"""Lines on each side of which it is the median at most: of more, every second or third is as good."""
USUAL = 8
"""Bins on each side that take part where the peak is narrow."""
VALLEY, VALLEY_NOISE = 1.2, 4.0
"""Size of the lower of two peaks over the valley between at least, and standard deviations of noise beyond that."""
WIDTHS = 3.0
"""Half-power widths on each side that take part where the peak is wide."""
HIGH = 0.6
"""Part of a peak above which its lines are counted; 0.7 is half the power, and noise is on it."""
NO_MODE = 0.25
"""Part of a peak that one mode leaves over from which on it has not the shape of a mode."""
NO_NOISE, STRUCTURED = 3.5, 1e-3
"""Deviations from which on lines are alike, and the part of the peak from which on that is told."""
HALF_POWER_WITHIN = 20.0
"""Half-power widths on each side of a mode in which its peak is looked at."""
NEARLY_ALL = 0.99
"""Part of a ratio that its interval reaches on each side because nobody told the excitation at most."""
DIFFER = 1.5
"""Birge's ratio from which on records are said to differ."""


@described
@one_blas_thread()
@telling
def modal_fit(
    records: ResponseRecord | Sequence[ResponseRecord],
    *,
    band: tuple[float, float] | None = None,
    title: str = "",
) -> ModalFit:
    """Return the modes that measured frequency responses show, with 95 % intervals.

    Each response is fitted by itself about each peak; several are one weighted mean, whose interval is widened by
    Birge's ratio where they differ by more than their own intervals. The noise may have a constant part and one in
    proportion to the response, both as large as the lines show; of records that tell their noise, it is in proportion
    to that. Windows that records tell are in the fit; of others there are doubts. A response whose circles turn as
    those of exp(-i omega t) do is taken as its conjugate. Half-power widths of less than two bins are refused.

    Args:
        records: responses of one structure over the same frequencies.
        band: frequencies in which peaks are looked for, Hz; left out, all.
        title: of the result.

    Raises:
        InputError: the frequencies differ, are not evenly spaced (which those of a blow without a window, and of sines
            one by one, need not be), or no peak stands out.
    """
    listed = [records] if isinstance(records, ResponseRecord) else list(records)
    if not listed or not all(isinstance(one, ResponseRecord) for one in listed):
        raise InputError(
            Fault("records", "", "these are no responses", "give ResponseRecord, or a list of them")
        )
    hertz = listed[0].frequencies
    steps = np.diff(hertz)
    for one in listed:
        _require_even(one, np.diff(one.frequencies))
    for one in listed[1:]:
        if len(one.frequencies) != len(hertz) or not np.allclose(one.frequencies, hertz):
            raise InputError(
                f"record {one.name} has other frequencies than {listed[0].name}: fit it by itself"
            )
    step = float(steps.mean())
    peaks = _peaks(hertz, listed, band)
    for one in listed if peaks else ():
        if not one.values.imag.any():
            raise InputError(
                f"record {one.name}: its values are real, and poles are in the phase: give complex values, or "
                "magnitude and phase; a magnitude alone, or decibels, tell no pole"
            )
    lines = [line_shape(one.window, one.window_time, one.excitation, step) for one in listed]
    turned = [turns_backwards(one, _seen(one, peaks), line) for one, line in zip(listed, lines, strict=True)]
    listed = [one.conjugate() if turn else one for one, turn in zip(listed, turned, strict=True)]
    other = [by_excitation(one, _seen(one, peaks)) for one in listed]
    modes = _modes(hertz, listed, lines, peaks, [apart for apart, _ in other])
    if not peaks:
        raise InputError("no peak stands out of the response: give a band, or a response with finer bins")
    if not any(modes):
        places = ", ".join(f"{hertz[k]:.5g}" for k, _ in peaks)
        raise InputError(
            f"peaks stand at {places} Hz, and none has the shape of a mode whose ratio is told from zero: give the "
            "window that was used, or a response with finer bins"
        )
    doubts = [
        f"the circles of {one.name} turn the other way, as those of exp(-i omega t): its conjugate is taken"
        for one, turn in zip(listed, turned, strict=True)
        if turn
    ] + [
        f"a peak stands at {hertz[k]:.5g} Hz that has not the shape of a mode whose ratio is told from zero: it is "
        "left out"
        for (k, _), found in zip(peaks, modes, strict=True)
        if not found
    ]
    doubts += [
        text
        for one, (apart, known) in zip(listed, other, strict=True)
        for text in excitation_doubts(one.name, apart, known=known)
    ]
    doubts += [
        f"{one.name} is in {one.unit}, a load over a motion: its peaks are modes of what is left free when the driven "
        "place is held; of the structure itself give the motion over the load, 1/H"
        for one in listed
        if is_load_over_motion(one.unit)
    ]
    return _result(hertz, listed, [found for found in modes if found], doubts, step, title)


def _require_even(record: ResponseRecord, steps: Floats) -> None:
    """Raise `InputError` unless lines are enough, and evenly spaced where what they are depends on it."""
    where, hertz = f"record {record.name}: frequencies", record.frequencies
    if len(hertz) < 4 * LEAST:
        raise InputError(
            Fault(
                where, f"{len(hertz)} lines", f"a fit needs {4 * LEAST}", "give a wider band, or finer bins"
            )
        )
    exact = record.excitation == "blow" and record.window is None
    if np.ptp(steps) > 1e-3 * float(steps.mean()) and not exact:
        usual = float(np.median(steps))
        k = int(np.argmax(np.abs(steps - usual)))
        raise InputError(
            Fault(
                where, f"{hertz[k]:.6g}, {hertz[k + 1]:.6g}",
                f"the lines must be evenly spaced, and most are {usual:.3g} Hz apart",
                "of sines one by one, or a blow without a window, say excitation='blow', and lines may stand anywhere; "
                "else give those on one side of a gap alone, or those of the analyser before they were thinned out",
            )
        )  # fmt: skip


def _peaks(
    hertz: Floats, records: list[ResponseRecord], band: tuple[float, float] | None
) -> list[tuple[int, int]]:
    """Return the places of peaks, and the lines to the middle between each and the nearest other."""
    scaled = [np.abs(one.values) / float(np.median(np.abs(one.values)) or 1.0) for one in records]
    size = np.sqrt(np.mean(np.square(scaled), axis=0))
    reach = max(int(ABOUT * len(size)), 3 * LEAST)
    low, high = (hertz[0], hertz[-1]) if band is None else band
    found: list[int] = []
    every = max(reach // ABOUT_LINES, 1)
    highest = maximum_filter1d(size, 2 * LEAST + 1)[LEAST:-LEAST]
    for k in LEAST + np.flatnonzero(size[LEAST:-LEAST] == highest):
        if low <= hertz[k] <= high:
            about = size[max(k - reach, 0) : k + reach + 1 : every]
            if size[k] > STANDS_OUT * float(np.median(about)):
                found = _apart(size, found, int(k))
    ends = [0, *found, len(size) - 1]
    return [(k, max(min(k - ends[j], ends[j + 2] - k) // 2, LEAST)) for j, k in enumerate(found)]


def _apart(size: Floats, found: list[int], k: int) -> list[int]:
    """Return the peaks with one more; of two without a valley between that noise does not make, only the higher one."""
    while found:
        between = np.log(np.maximum(size[found[-1] : k + 1], np.finfo(float).tiny))
        noise = (
            0.0
            if len(between) < 3
            else float(np.median(np.abs(np.diff(between, 2)))) * MEDIAN_TO_DEVIATION / np.sqrt(6.0)
        )
        if min(between[0], between[-1]) - between.min() > np.log(VALLEY) + VALLEY_NOISE * noise:
            break
        if size[found[-1]] >= size[k]:
            return found
        found = found[:-1]
    return [*found, k]


def _modes(
    hertz: Floats,
    records: list[ResponseRecord],
    lines: list[LineShape],
    peaks: list[tuple[int, int]],
    apart: Sequence[Floats],
) -> list[list[Pole]]:
    """Return for every peak the poles of the responses that show it.

    Args:
        hertz: lines; records, lines: the responses and their line shapes; peaks: see `_peaks`.
        apart: of every response by which part ratios are other if it is a mean over noise, by which intervals reach
            farther.
    """
    fits: list[tuple[int, float, Peak]] = []
    for one, line, other_part in zip(records, lines, apart, strict=True):
        noise = None if one.noise is None else one.noise[: len(hertz)]
        rough: dict[int, tuple[float, float]] = {}
        for place, (k, reach) in enumerate(_seen(one, peaks)):
            pole = rough_pole(hertz, one.values, k, reach, line)
            if pole is not None:
                rough[place] = pole
        for place, pole in rough.items():
            k, gap = peaks[place]
            wide = int(WIDTHS * (half_power_width(*pole) / (hertz[1] - hertz[0]) + 2.0 * line.widening))
            others = [other for at, other in rough.items() if at != place]
            fit = peak_fits(hertz, one.values, k, min(max(wide, USUAL), gap), line, noise, others)
            if fit is not None:
                fits.append((place, float(other_part[place]), fit))
    poles = poles_of([fit for _, _, fit in fits])
    found: list[list[Pole]] = [[] for _ in peaks]
    for (place, part, _), told in zip(fits, poles, strict=True):
        if told is not None and told.misfit < NO_MODE:
            farther = min(told.ratio_width + part * told.ratio, NEARLY_ALL * told.ratio)
            found[place].append(replace(told, ratio_width=max(told.ratio_width, farther)))
    return found


def _seen(record: ResponseRecord, peaks: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the places of peaks, and the lines on each side that a first fit of a response takes."""
    size = np.abs(record.values)
    return [(k, min(max(int(WIDTHS * _lines_above(size, k)), USUAL), gap)) for k, gap in peaks]


def _lines_above(size: Floats, k: int) -> int:
    """Return the number of lines about a peak that are above `HIGH` of it."""
    low = np.flatnonzero(size < HIGH * size[k])
    place = int(np.searchsorted(low, k))
    return int((low[place] if place < len(low) else len(size)) - (low[place - 1] if place else -1)) - 1


def _together(values: Floats, widths: Floats) -> tuple[float, float, float]:
    """Return the weighted mean, half the width of its interval, and Birge's ratio."""
    weight = 1.0 / np.maximum(widths, 1e-300) ** 2
    mean = float(np.sum(weight * values) / np.sum(weight))
    half = float(1.0 / np.sqrt(np.sum(weight)))
    if len(values) == 1:
        return mean, half, 0.0
    quantile = float(student.ppf(0.5 + 0.5 * CONFIDENCE, 1e6))
    birge = float(np.sqrt(np.sum(weight * (values - mean) ** 2) / (len(values) - 1))) * quantile
    return mean, half * max(birge, 1.0), birge


def _result(
    hertz: Floats,
    records: list[ResponseRecord],
    modes: list[list[Pole]],
    doubts: list[str],
    step: float,
    title: str,
) -> ModalFit:
    import xarray as xr

    half_power, rows = [], []
    windowed = all(one.window is not None for one in records)
    told = all(one.window is not None or one.excitation is not None for one in records)
    for found in modes:
        ratios = np.array([one.ratio for one in found])
        frequency, frequency_width, _ = _together(
            np.array([one.frequency for one in found]),
            np.array([one.frequency_width for one in found]),
        )
        ratio, ratio_width, birge = _together(ratios, np.array([one.ratio_width for one in found]))
        if ratio_width >= ratio:
            doubts.append(
                f"a peak stands at {frequency:.5g} Hz, whose ratio of {ratio:.3g} ± {ratio_width:.2g} is not told from "
                "zero: it is left out"
            )
            continue
        rows.append((frequency, frequency_width, ratio, ratio_width))
        if birge > DIFFER:
            doubts.append(
                f"the ratios at {frequency:.5g} Hz are {', '.join(f'{one:.3g}' for one in ratios)} in the records, "
                "further apart than their intervals: the interval is widened accordingly"
            )
        width = half_power_width(frequency, ratio)
        refused = windowed or width < BINS * spacing(hertz, frequency)
        half_power.append(None if refused else _half_power(hertz, records, frequency, width))
        structured = max((one.misfit for one in found if one.alike > NO_NOISE), default=0.0)
        if STRUCTURED < structured <= 0.1:
            doubts.append(
                f"about {frequency:.5g} Hz what one mode leaves over, {per_cent(100.0 * structured)} of the peak, is "
                "no noise: neighbouring lines are alike; where another mode stands nearby, or lines were smoothed or "
                "windowed, the intervals do not hold"
            )
        if structured > 0.1:
            left = per_cent(100.0 * structured)
            doubts.append(
                f"about {frequency:.5g} Hz one mode leaves {left} of the peak over: there are others"
            )
    narrow = [row[0] for row in rows if half_power_width(row[0], row[2]) < BINS * spacing(hertz, row[0])]
    if windowed:
        doubts.append("half-power: refused; the window makes peaks wider than the modes are")
    elif narrow:
        doubts.append(
            f"half-power: refused at {', '.join(f'{one:.4g}' for one in narrow)} Hz, where the width has less than "
            f"{BINS:g} bins of {step:.3g} Hz and would be that of the bins"
            + (
                ""
                if told
                else "; the ratios hold of a blow without a window, else give window and excitation"
            )
        )
    columns = np.array(rows).reshape(-1, 4).T
    doubts += window_doubts(records, columns[0], columns[2])
    responses = np.array([one.values for one in records])
    return ModalFit(
        xr.Dataset(
            {
                "response": (("record", "line", "part"), np.stack([responses.real, responses.imag], axis=-1)),
                "line_frequency": ("line", hertz),
                "record_name": ("record", [one.name for one in records]),
                "frequency": ("mode", columns[0]),
                "frequency_width": ("mode", columns[1]),
                "damping_ratio": ("mode", columns[2]),
                "damping_ratio_width": ("mode", columns[3]),
            },
            attrs={
                "kind": "modal_fit",
                "title": title,
                "half_power": json.dumps(half_power),
                "warnings": json.dumps(doubts),
            },
        )
    )


def _half_power(hertz: Floats, records: list[ResponseRecord], frequency: float, width: float) -> float | None:
    """Return the ratio read off the half-power width, of the first record that shows it."""
    nothing = np.empty(0, dtype=complex)
    near = np.abs(hertz - frequency) < HALF_POWER_WITHIN * width
    for one in (one for one in records if one.window is None):
        for peak in resonances_of(hertz[near], one.values[near], (nothing, nothing), (), MEASURED):
            if abs(peak.frequency - frequency) < width and peak.half_power is not None:
                return peak.half_power
    return None

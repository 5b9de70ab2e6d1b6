"""Poles of measured frequency responses: frequencies and damping ratios of modes, also far narrower than the bins.

About each peak the response is residue/(i omega - s) and a polynomial of the second degree for all other modes. Where
a record of the length T is transformed without a window, the response at the multiples of 1/T has this form exactly
however long the mode rings, since exp(i omega T) is 1 there: the pole is in the complex values of neighbouring bins,
the half-power width is not.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from viscorod.errors import Fault, InputError
from viscorod.records.arguments import described
from viscorod.records.decay_doubts import BINS, half_power_width
from viscorod.records.response_record import ResponseRecord
from viscorod.results.modal_fit_result import ModalFit
from viscorod.results.resonances import resonances_of
from viscorod.typing import Floats

__all__ = ["modal_fit"]

STANDS_OUT = 4.0
"""Size of a peak over the median about it."""
ABOUT = 0.15
"""Part of all frequencies, on each side, of which that median is."""
LEAST, USUAL = 4, 8
"""Bins on each side that take part at least, and where the peak is narrow."""
WIDTHS = 3.0
"""Half-power widths on each side that take part where the peak is wide."""
DEGREE = 2
SURE = 3.0
"""Standard deviations by which a ratio must differ from zero."""
CONFIDENCE = 0.95
DIFFER = 1.5
"""Birge's ratio from which on records are said to differ."""


@dataclass(frozen=True)
class _Pole:
    """One pole found in one response: natural frequency [Hz], ratio, their deviations, and the misfit over the peak."""

    frequency: float
    ratio: float
    frequency_deviation: float
    ratio_deviation: float
    misfit: float
    freedom: int


@described
def modal_fit(
    records: ResponseRecord | Sequence[ResponseRecord],
    *,
    band: tuple[float, float] | None = None,
    title: str = "",
) -> ModalFit:
    """Return the modes that measured frequency responses show, with 95 % intervals.

    Each response is fitted by itself about each peak; several are one weighted mean, whose interval is widened by
    Birge's ratio where they differ by more than their own intervals. Half-power widths of less than two bins are
    refused.

    Args:
        records: responses of one structure over the same frequencies.
        band: frequencies in which peaks are looked for, Hz; left out, all.
        title: of the result.

    Raises:
        InputError: the frequencies differ, are not evenly spaced, or no peak stands out.
    """
    listed = [records] if isinstance(records, ResponseRecord) else list(records)
    if not listed or not all(isinstance(one, ResponseRecord) for one in listed):
        raise InputError(
            Fault("records", "", "these are no responses", "give ResponseRecord, or a list of them")
        )
    hertz = listed[0].frequencies
    steps = np.diff(hertz)
    if len(hertz) < 4 * LEAST or np.ptp(steps) > 1e-3 * float(steps.mean()):
        raise InputError("the frequencies of a response must be evenly spaced, 16 at least")
    for one in listed[1:]:
        if len(one.frequencies) != len(hertz) or not np.allclose(one.frequencies, hertz):
            raise InputError(
                f"record {one.name} has other frequencies than {listed[0].name}: fit it by itself"
            )
    step = float(steps.mean())
    peaks = _peaks(hertz, listed, band)
    modes = [found for k, gap in peaks if (found := _mode(hertz, listed, k, gap)) is not None]
    if not modes:
        raise InputError("no peak stands out of the response: give a band, or a response with finer bins")
    return _result(hertz, listed, modes, step, title)


def _peaks(
    hertz: Floats, records: list[ResponseRecord], band: tuple[float, float] | None
) -> list[tuple[int, int]]:
    """Return the places of peaks, and the bins to the middle between each and the nearest other."""
    scaled = [np.abs(one.values) / float(np.median(np.abs(one.values)) or 1.0) for one in records]
    size = np.sqrt(np.mean(np.square(scaled), axis=0))
    reach = max(int(ABOUT * len(size)), 3 * LEAST)
    low, high = (hertz[0], hertz[-1]) if band is None else band
    found = []
    for k in range(LEAST, len(size) - LEAST):
        near = size[max(k - LEAST, 0) : k + LEAST + 1]
        about = size[max(k - reach, 0) : k + reach + 1]
        if (
            low <= hertz[k] <= high
            and size[k] == near.max()
            and size[k] > STANDS_OUT * float(np.median(about))
        ):
            found.append(k)
    ends = [0, *found, len(size) - 1]
    return [(k, max(min(k - ends[j], ends[j + 2] - k) // 2, LEAST)) for j, k in enumerate(found)]


def _mode(hertz: Floats, records: list[ResponseRecord], k: int, gap: int) -> list[_Pole] | None:
    """Return a mode in all responses that show it; None if none does."""
    found = []
    for one in records:
        pole = _pole(hertz, one.values, k, min(USUAL, gap))
        if pole is not None:
            wide = int(WIDTHS * half_power_width(pole.frequency, pole.ratio) / (hertz[1] - hertz[0]))
            if wide > USUAL:
                pole = _pole(hertz, one.values, k, min(wide, gap))
        if pole is not None:
            found.append(pole)
    return found or None


def _pole(hertz: Floats, response: np.ndarray, k: int, reach: int) -> _Pole | None:
    """Return the pole about a peak from the bins within reach; None where there is none."""
    inside = np.arange(max(k - reach, 0), min(k + reach + 1, len(hertz)))
    if len(inside) < 2 * LEAST:
        return None
    step = float(hertz[1] - hertz[0])
    x = (hertz[inside] - hertz[k]) / step
    y = response[inside]
    scale = float(np.abs(y).max())
    powers = (x / reach)[:, None] ** np.arange(DEGREE + 1)

    def basis(theta: Floats) -> np.ndarray:
        return np.column_stack([1.0 / (1j * (x - theta[1]) + np.exp(theta[0])), powers])

    def misfit(theta: Floats) -> Floats:
        columns = basis(theta)
        off = columns @ np.linalg.lstsq(columns, y, rcond=None)[0] - y
        return np.concatenate([off.real, off.imag]) / scale

    best = None
    width = max(step, 1e-3 * reach * step) / step
    for start in (0.05 * width, 0.2 * reach):
        for shift in (-0.3, 0.3):
            fit = least_squares(misfit, [np.log(start), shift], x_scale=[0.3, 0.1], max_nfev=200)
            if best is None or fit.cost < best.cost:
                best = fit
    assert best is not None
    decay, centre = float(np.exp(best.x[0])) * step, float(hertz[k] + best.x[1] * step)
    freedom = 2 * len(inside) - 2 - 2 * (DEGREE + 2)
    if abs(best.x[1]) > 1.5 or decay <= 0.0 or freedom < 1:
        return None
    noise = float(np.sqrt(2.0 * best.cost / freedom))
    spread = np.linalg.pinv(best.jac.T @ best.jac) * noise**2
    frequency = float(np.hypot(centre, decay))
    ratio = decay / frequency
    deviations = np.sqrt(np.maximum(np.diag(spread), 0.0))
    if ratio < SURE * ratio * deviations[0]:
        return None
    return _Pole(frequency, ratio, float(deviations[1]) * step, ratio * float(deviations[0]), noise, freedom)


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
    hertz: Floats, records: list[ResponseRecord], modes: list[list[_Pole]], step: float, title: str
) -> ModalFit:
    import xarray as xr

    doubts, half_power, rows = [], [], []
    for found in modes:
        quantile = [float(student.ppf(0.5 + 0.5 * CONFIDENCE, one.freedom)) for one in found]
        ratios = np.array([one.ratio for one in found])
        frequency, frequency_width, _ = _together(
            np.array([one.frequency for one in found]),
            np.array([q * one.frequency_deviation for q, one in zip(quantile, found, strict=True)]),
        )
        ratio, ratio_width, birge = _together(
            ratios, np.array([q * one.ratio_deviation for q, one in zip(quantile, found, strict=True)])
        )
        rows.append((frequency, frequency_width, ratio, ratio_width))
        if birge > DIFFER:
            doubts.append(
                f"the ratios at {frequency:.5g} Hz are {', '.join(f'{one:.3g}' for one in ratios)} in the records, "
                "further apart than their intervals: the interval is widened accordingly"
            )
        width = half_power_width(frequency, ratio)
        half_power.append(None if width < BINS * step else _half_power(hertz, records, frequency, width))
        worst = max(one.misfit for one in found)
        if worst > 0.1:
            doubts.append(
                f"about {frequency:.5g} Hz one mode leaves {100.0 * worst:.2g} % of the peak over: there are others"
            )
    narrow = [row[0] for row in rows if half_power_width(row[0], row[2]) < BINS * step]
    if narrow:
        doubts.append(
            f"half-power: refused at {', '.join(f'{one:.4g}' for one in narrow)} Hz, where the width has less than "
            f"{BINS:g} bins of {step:.3g} Hz and would be that of the bins"
        )
    columns = np.array(rows).T
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
    for one in records:
        for peak in resonances_of(hertz, one.values, (nothing, nothing), ()):
            if abs(peak.frequency - frequency) < width and peak.half_power is not None:
                return peak.half_power
    return None

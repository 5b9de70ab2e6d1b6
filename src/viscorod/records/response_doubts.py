"""What a measured response shows of how it was made: windows that nobody told, and the sense of its circles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.records.line_shapes import LineShape, line_shape
from viscorod.records.pole_about_peak import rough_misfit, rough_pole
from viscorod.records.response_record import EXCITATIONS, ResponseRecord
from viscorod.typing import Floats

__all__ = ["by_excitation", "excitation_doubts", "turns_backwards", "window_doubts"]

SAME_RATE, OCTAVES = 1.5, 1.0
"""Ratio of decay rates below which they are called nearly the same, and octaves that their modes are apart at least."""
WITHIN = 1.0
"""Decay of the slowest mode over the record, as a logarithm, from which on it may be that of a window."""
BLOCK, FEWEST = 32, 3
"""Lines of a stretch whose noise is looked at, and how many such."""
AWAY, AWAY_WIDTHS = 15, 10.0
"""Lines and half-power widths from a mode beyond which noise is looked at."""
WHITE, SCATTER = -0.8, 0.275
"""Correlation of neighbouring fourth differences of white noise, and its deviation for one line."""
GROWTH = 7.0
"""Mean square of sixth over that of fourth differences: of white noise 13.2, of what is smooth far less."""
SURE = 4.0
"""Deviations from which on noise is called alike."""
FEW = 20
"""Lines on each side of a peak that its sense is taken from, evenly."""
ROUND = 0.15
"""Mean area that peaks go round, over the square of their diameter; pi/4 of a whole circle."""
LIKELIER = 20.0
"""Logarithm of how much likelier the conjugate, or another excitation, is, from which on that is called certain."""
MATTERS = 0.05
"""Part by which damping ratios depend on what shook the structure, from which on that is said."""


def window_doubts(records: Sequence[ResponseRecord], frequencies: Floats, ratios: Floats) -> list[str]:
    """Return sentences on windows that may have been used and are not told.

    Args:
        records: over the same, evenly spaced lines.
        frequencies: of the modes that were found, Hz (k,); ratios: damping ratios (k,).
    """
    plain = [one for one in records if one.window is None and one.excitation != "noise"]
    if not plain:
        return []
    hertz = plain[0].frequencies
    step = float(hertz[1] - hertz[0])
    found = []
    rates = 2.0 * np.pi * frequencies * ratios
    apart = len(rates) > 1 and float(np.log2(frequencies.max() / frequencies.min())) > OCTAVES
    if apart and rates.max() < SAME_RATE * rates.min() and rates.min() > WITHIN * step:
        found.append(
            f"all modes die out at nearly the same rate, {rates.min():.3g} to {rates.max():.3g} 1/s, as an exponential "
            f"window with a time constant of {1.0 / rates.min():.3g} s or a little more makes them: if the response "
            "was weighed by one, give window='exponential' and its window_time, else something outside damps"
        )
    alike = [one.name for one in plain if _noise_is_alike(one, frequencies, ratios)]
    if alike:
        found.append(
            f"the noise of neighbouring lines is alike in {', '.join(alike)}, as a window, smoothing or zeros behind "
            "the record make it: ratios are wrong by what that does to peaks; give window, and excitation='noise' of a "
            "mean over noise (H1)"
        )
    return found


def _noise_is_alike(record: ResponseRecord, frequencies: Floats, ratios: Floats) -> bool:
    """Return whether lines away from modes have noise that neighbours share.

    Fourth differences take away what is smooth; the correlation of neighbours among them is known for white noise.
    """
    hertz, values = record.frequencies, record.values
    step = float(hertz[1] - hertz[0])
    away = np.ones(len(hertz), dtype=bool)
    for f, ratio in zip(frequencies, ratios, strict=True):
        away &= np.abs(hertz - f) > max(AWAY * step, AWAY_WIDTHS * 2.0 * ratio * f)
    found = []
    for k in range(0, len(hertz) - BLOCK + 1, BLOCK):
        if away[k : k + BLOCK].all():
            fourth = np.diff(values[k : k + BLOCK], 4)
            square = float(np.mean(np.abs(fourth) ** 2))
            if square > 0.0 and float(np.mean(np.abs(np.diff(fourth, 2)) ** 2)) > GROWTH * square:
                found.append(float(np.mean((fourth[1:] * fourth[:-1].conj()).real)) / square)
    if len(found) < FEWEST:
        return False
    deviation = 1.25 * SCATTER / np.sqrt(len(found) * (BLOCK - 4))  # of a median
    return bool(abs(float(np.median(found)) - WHITE) > SURE * deviation + 1.0 / (BLOCK - 4) ** 2)


def turns_backwards(record: ResponseRecord, peaks: Sequence[tuple[int, int]], line: LineShape) -> bool:
    """Return whether the circles of a response go round as those of exp(-i omega t) do, counterclockwise.

    Args:
        record: the response; line: shape of a pole.
        peaks: lines of peaks, and how many lines on each side show them.
    """
    values = record.values
    areas = []
    for k, reach in peaks:
        about = values[max(k - reach, 0) : k + reach + 1 : max(reach // FEW, 1)]
        about = about - about.mean()
        closed = np.append(about, about[0])
        area = 0.5 * float(np.sum(np.imag(np.conj(closed[:-1]) * closed[1:])))
        areas.append(area / float(np.abs(np.subtract.outer(about, about)).max() or 1.0) ** 2)
    if not areas or float(np.mean(areas)) < -ROUND:
        return False
    likelier = 0.0
    for k, reach in peaks:
        one, other = (
            rough_misfit(record.frequencies, response, k, reach, line) for response in (values, values.conj())
        )
        if one is not None and other is not None:
            likelier += one[1] * (np.log(one[0]) - np.log(other[0]))
    return bool(likelier > LIKELIER)


def by_excitation(record: ResponseRecord, peaks: Sequence[tuple[int, int]]) -> tuple[Floats, bool]:
    """Return by which part ratios differ (k,) if a response of which nobody told it is a mean over noise (H1).

    Peaks a line wide look nearly alike after a blow and in a mean over noise, and their ratios differ; wider ones are
    alike in both. The parts are zero where the lines say that it was a blow.

    Args:
        record: the response.
        peaks: lines of peaks, and how many lines on each side show them (k).

    Returns:
        the parts, and whether the lines say that it is a mean over noise.
    """
    apart = np.zeros(len(peaks))
    if record.window is not None or record.excitation is not None:
        return apart, False
    hertz, values = record.frequencies, record.values
    step = float(hertz[1] - hertz[0])
    blow, noise = (line_shape(None, None, excitation, step) for excitation in EXCITATIONS)
    likelier = 0.0
    for k, reach in sorted(peaks, key=lambda peak: -abs(values[peak[0]])):
        one, other = (rough_misfit(hertz, values, k, reach, line) for line in (blow, noise))
        if one is not None and other is not None:
            likelier += one[1] * (np.log(one[0]) - np.log(other[0]))
        if likelier < -LIKELIER:
            return apart, False
    for place, (k, reach) in enumerate(peaks):
        poles = [rough_pole(hertz, values, k, reach, line) for line in (blow, noise)]
        if poles[0] is not None and poles[1] is not None and poles[0][1] > 0.0:
            apart[place] = abs(poles[1][1] / poles[0][1] - 1.0)
    return apart, likelier > LIKELIER


def excitation_doubts(name: str, apart: Floats, *, known: bool) -> list[str]:
    """Return a sentence where a response that is read as that to a blow may as well be a mean over noise (H1).

    Args:
        name: of the response; apart, known: of `by_excitation`.
    """
    most = float(apart.max(initial=0.0))
    if most < MATTERS:
        return []
    say = "say that" if known else "do not tell whether"
    return [
        f"the lines of {name} {say} they are a mean over noise (H1), of which damping ratios are up to "
        f"{100.0 * most:.0f} % other than after a blow, and intervals reach as far: if they are, give "
        "excitation='noise', and else 'blow'"
    ]

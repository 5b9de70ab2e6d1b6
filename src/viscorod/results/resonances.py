"""Damping ratios read off the peaks of a frequency response, as one does with measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # its parts are imported when they are asked for

from viscorod.argument_names import known_arguments
from viscorod.typing import Floats

__all__ = ["MEASURED", "Resonance", "resonances_of"]

PROMINENT = 1.002
"""Size of a computed peak over that of the valleys beside it at least: more than round-off, less than the two peaks of
a damper that is tuned."""
MEASURED = 1.2
"""The same of a measured one, which noise makes uneven."""
LOPSIDED = 3.0
"""Distance of one half-power frequency from the peak over that of the other; of one mode alone it is below 1.6."""
HIGHER = 1.05
"""Height of the peak of a pole over that of the frequencies beside it, from which on they do not show it."""
ON_CIRCLE = 4
"""Frequencies within the half-power band from which a circle is fitted."""


@known_arguments
@dataclass(frozen=True)
class Resonance:
    """A peak of a response.

    Attributes:
        frequency: of the peak [Hz]; amplitude: its size.
        half_power: damping ratio by the frequencies at which the size is that of the peak over root 2; None where the
            response does not fall so far on both sides, or much later on one of them: another mode is there.
        circle: damping ratio by the circle through the responses within that band, in the complex plane (Kennedy and
            Pancu 1947, in the form of Ewins, Modal Testing, section 4.3); None where there are too few.
        pole: damping ratio of the pole that has most of the response there, and name: of its motion; None and empty
            where it is not near by.
        resolved: frequencies are close enough to see the peak; if not, frequency and amplitude are the largest of those
            that there are, and the peak of the pole is higher.
    """

    frequency: float
    amplitude: float
    half_power: float | None
    circle: float | None
    pole: float | None
    name: str
    resolved: bool = True


def resonances_of(
    hertz: Floats,
    response: np.ndarray,
    roots: tuple[np.ndarray, np.ndarray],
    names: Sequence[str],
    prominent: float = PROMINENT,
) -> list[Resonance]:
    """Return the peaks of a response.

    Args:
        hertz: increasing frequencies ``(n,)``; response: there ``(n,)``.
        roots: poles ``s`` [1/s] and their residues; names: of their motions.
        prominent: size of a peak over that of the valleys beside it at least.
    """
    poles, residues = roots
    size = np.abs(response)
    found = []
    for k in _peaks(size, prominent):
        f, top = _summit(hertz[k - 1 : k + 2], size[k - 1 : k + 2])
        unseen = _unseen(hertz[k - 1 : k + 2], top, poles, residues)
        if unseen is not None:
            ratio, name = -poles[unseen].real / abs(poles[unseen]) + 0.0, str(names[unseen])
            found.append(Resonance(float(hertz[k]), float(size[k]), None, None, float(ratio), name, False))
            continue
        low, high = _crossing(hertz, size, k, top, -1), _crossing(hertz, size, k, top, 1)
        half = circle = None
        if (
            low is not None
            and high is not None
            and max(high - f, f - low) < LOPSIDED * min(high - f, f - low)
        ):
            half = (high**2 - low**2) / (4.0 * f**2)
            inside = np.flatnonzero((hertz >= low) & (hertz <= high))
            if len(inside) >= ON_CIRCLE:
                circle = _circle(hertz[inside], response[inside])
        mine = _pole_of(f, poles, residues)
        found.append(
            Resonance(
                f,
                top,
                half,
                circle,
                None if mine is None else float(-poles[mine].real / abs(poles[mine]) + 0.0),
                "" if mine is None else str(names[mine]),
            )
        )
    return found


def _pole_of(hertz: float, poles: np.ndarray, residues: np.ndarray) -> int | None:
    """Return the pole near a peak that has most of the response there; None if there is none near by."""
    width = np.maximum(np.abs(poles.real), 1e-2 * np.abs(poles)) / np.pi
    near = np.flatnonzero(np.abs(poles.imag / (2.0 * np.pi) - hertz) <= 2.0 * width)
    if not len(near):
        return None
    return int(near[np.argmax(np.abs(residues[near] / (2j * np.pi * hertz - poles[near])))])


def _unseen(hertz: Floats, top: float, poles: np.ndarray, residues: np.ndarray) -> int | None:
    """Return the pole between three frequencies whose peak is higher than what they show, too narrow for them."""
    centres, widths = poles.imag / (2.0 * np.pi), np.abs(poles.real) / np.pi
    inside = (centres > hertz[0]) & (centres < hertz[-1]) & (widths < np.diff(hertz).max())
    heights = np.abs(residues) / np.maximum(np.abs(poles.real), 1e-30 * np.abs(poles))
    hidden = np.flatnonzero(inside & (heights > HIGHER * top))
    return int(hidden[np.argmax(heights[hidden])]) if len(hidden) else None


def _peaks(size: Floats, prominent: float) -> np.ndarray:
    """Return the places of maxima that stand out from the valleys on both sides."""
    height = np.log(np.maximum(size, np.finfo(float).tiny))
    _, found = scipy.signal.find_peaks(height, plateau_size=1, prominence=np.log(prominent))
    return np.asarray(found["left_edges"])


def _summit(hertz: Floats, size: Floats) -> tuple[float, float]:
    """Return the top of the parabola through 1/size^2 of three frequencies, which is exact for one mode alone."""
    x = hertz - hertz[1]
    y = 1.0 / size**2
    a, b, c = np.polyfit(x, y, 2)
    if a <= 0.0:
        return float(hertz[1]), float(size[1])
    at = float(np.clip(-0.5 * b / a, x[0], x[2]))
    low = a * at**2 + b * at + c
    return float(hertz[1] + at), float(1.0 / np.sqrt(low)) if low > 0.0 else float(size[1])


def _crossing(hertz: Floats, size: Floats, k: int, top: float, step: int) -> float | None:
    """Return the frequency beside a peak at which the size is that of the top over root 2; None if there is none."""
    wanted = top / np.sqrt(2.0)
    last = k
    while 0 <= last + step < len(size):
        here = last + step
        if size[here] <= wanted:
            x, y = hertz[[last, here]], 1.0 / size[[last, here]] ** 2
            part = (1.0 / wanted**2 - y[0]) / (y[1] - y[0])
            return float(x[0] + part * (x[1] - x[0]))
        if size[here] > top:
            return None
        last = here
    return None


def _circle(hertz: Floats, response: np.ndarray) -> float | None:
    """Return the damping ratio by the angles that the response sweeps on its circle."""
    x, y = response.real, response.imag
    scale = float(np.abs(response).max())
    matrix = np.column_stack([x, y, np.full(len(x), scale)]) / scale
    (a, b, _), *_ = np.linalg.lstsq(matrix, (x * x + y * y) / scale, rcond=None)
    centre = 0.5 * complex(a, b)
    angle = np.unwrap(np.angle(response - centre))
    squared = hertz**2

    def line(middle: float) -> tuple[Floats, float]:
        """Return slope, start and misfit of tan(theta/2), which is linear in omega^2 where one mode is alone."""
        half = np.tan(0.5 * (angle - middle))
        found, misfit, *_ = np.polyfit(squared / squared[0] - 1.0, half, 1, full=True)
        return found, float(misfit[0]) if len(misfit) else 0.0

    centre_angle = 0.5 * (angle[0] + angle[-1])
    reach = 0.4 * abs(angle[-1] - angle[0])
    best = scipy.optimize.minimize_scalar(
        lambda m: line(m)[1], bounds=(centre_angle - reach, centre_angle + reach), method="bounded"
    )
    slope, start = line(float(best.x))[0]
    if slope == 0.0:
        return None
    # tan(theta/2) = (omega_r^2 - omega^2)/(eta omega_r^2)
    resonance = 1.0 - start / slope
    ratio = float(0.5 / (abs(slope) * resonance))
    return ratio if np.isfinite(ratio) and ratio > 0.0 else None

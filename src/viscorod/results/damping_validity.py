"""Validity of Kelvin-Voigt damping for a motion: the strains of a run compared with the data of the material.

Kelvin-Voigt damping is meant for motions that are slow beside the material's relaxation (Linn, Lang and Tuganov 2013,
called LLT, end of section 2.6). Where it approximates a Prony series, LLT bound the error of the stress by

    (1/2 pi) int |eps^(w)| sum_j M_j (tau_j w)^2/sqrt(1 + (tau_j w)^2) dw.

For moduli that were fitted over a band, the weight is the difference of the two complex moduli less its value at rest,
which counts by itself, times the largest strain. Where only times are known, the angular frequency below which 95 % of
the energy was lost is compared with them: their product should stay below a half.

The spectrum is that of the strain rate. It vanishes before the start, which is from rest; at the end the last tenth of
the record is faded out by a cosine, so that what the record leaves out makes no false frequencies. Strains are taken
from their records by cubic splines at equal distances, and the record is padded with as many zeros.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.array_pieces import blocks
from viscorod.results.text_numbers import per_cent, quantity
from viscorod.results.text_table import page
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.run import Run

__all__ = ["DampingValidity", "StrainValidity", "damping_validity"]

COMPONENTS = ("shear 1", "shear 2", "stretch", "bend 1", "bend 2", "twist")
KIND = ("shear", "shear", "extension", "extension", "extension", "shear")
QUICK = 0.5
"""Angular frequency times retardation time above which Kelvin-Voigt is doubtful."""
LITTLE = 1e-3
"""Strains with less than this part of the work in their rod are left out."""
MOST_SAMPLES = 2**16
FADE = 0.1
MARGIN = 0.5
"""Part of the highest frequency that the records can hold beyond which they are too far apart."""


@dataclass(frozen=True)
class StrainValidity:
    """One strain of a rod.

    Attributes:
        rod, strain: which.
        time: retardation time, s.
        mean_frequency: of the motion, Hz, weighted with the energy lost.
        high_frequency: below which 95 % of the energy was lost, Hz.
        bound: LLT's bound of the stress error over the largest elastic stress; NaN where only times are known.
        limit: frequency up to which the damping would be right, Hz.
        valid: it was right for this motion.
    """

    rod: str
    strain: str
    time: float
    mean_frequency: float
    high_frequency: float
    bound: float
    limit: float
    valid: bool

    @property
    def product(self) -> float:
        """Angular frequency below which 95 % of the energy was lost, times the retardation time."""
        return 2.0 * math.pi * self.high_frequency * self.time

    def __str__(self) -> str:
        spectrum = f"95 % of the energy was lost below {quantity(self.high_frequency, 'Hz', 3)}"
        measure = (
            f"angular frequency times retardation time is {self.product:.2g} there"
            if math.isnan(self.bound)
            else f"the stress is wrong by {per_cent(100.0 * self.bound)} of its largest value at most"
        )
        verdict = "right" if self.valid else "not to be trusted"
        return (
            f"rod {self.rod}, {self.strain}: Kelvin-Voigt damping is {verdict} for this motion; {spectrum}, "
            f"{measure}; it is right up to about {quantity(self.limit, 'Hz', 3)}"
        )


@dataclass(frozen=True)
class DampingValidity:
    """Validity of Kelvin-Voigt damping for a run.

    Attributes:
        strains: those that took part in the motion of damped rods.
        tolerance: accepted error of the stress.
        notes: further remarks.
    """

    strains: tuple[StrainValidity, ...]
    tolerance: float
    notes: tuple[str, ...] = ()

    @property
    def valid(self) -> bool:
        """True if it was right for every strain."""
        return all(strain.valid for strain in self.strains)

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        if not self.strains:
            return "No rod with Kelvin-Voigt damping was strained."
        if self.valid:
            return "Kelvin-Voigt damping was right for this motion."
        limit = min(strain.limit for strain in self.strains if not strain.valid)
        head = "Kelvin-Voigt damping was not right for this motion; "
        return head + f"it would be for frequencies up to {quantity(limit, 'Hz', 3)}."

    def __str__(self) -> str:
        lines = [self.sentence, *(f"  {text}" for text in (*self.strains, *self.notes))]
        return page(["\n".join(lines)])


def damping_validity(run: Run, tolerance: float = 0.1) -> DampingValidity:
    """Compare the spectrum of the strains with the materials; see ``Run.damping_validity``."""
    if not 0.0 < tolerance < 1.0:
        raise InputError(
            f"tolerance = {tolerance!r}: give an accepted error of the stress above 0 and below 1"
        )
    data = run.stored
    if "damping_laws" not in data.attrs or "strain" not in data:
        raise InputError(
            "this result does not hold its damping laws; compute it again with this version of viscorod"
        )
    laws: dict[str, dict[str, Any]] = json.loads(data.attrs["damping_laws"])
    if run.time.size < 8:
        raise InputError(
            f"a spectrum needs a record of 8 states at least, and this run holds {run.time.size}"
        )
    rods = data["point_rod"].values
    notes = [
        f"rod {rod}: its Maxwell branches are solved as they are, at every frequency"
        for rod, law in laws.items()
        if law["maxwell"]
    ]
    damped = [rod for rod, law in laws.items() if not law["maxwell"] and any(law["times"]) and rod in rods]
    following = [rod for rod, law in laws.items() if law.get("loss_band") and rod in rods]
    found: list[StrainValidity] = []
    if damped or following:
        largest, work = _sizes(run)
        notes += [note for rod in following if (note := _loss_note(run, rod, laws[rod], largest, work))]
        for rod in damped:
            found += _rod(run, rod, laws[rod], largest, work, tolerance)
    resolved = 0.5 / float(np.max(np.diff(run.time)))
    if any(strain.high_frequency > MARGIN * resolved for strain in found):
        notes.append(
            f"the records are too far apart to resolve frequencies above {quantity(MARGIN * resolved, 'Hz', 3)}; "
            "give a smaller output_interval"
        )
    return DampingValidity(tuple(found), tolerance, tuple(notes))


def _sizes(run: Run) -> tuple[Floats, Floats]:
    """Return the largest size over time of strains, and of their work with section forces, ``(points, 6)`` each."""
    largest, work = np.zeros((2, run.stored.sizes["point"], 6))
    for strain, force in zip(blocks(run, "strain"), blocks(run, "section_force"), strict=True):
        largest = np.maximum(largest, np.abs(strain).max(axis=0))
        work = np.maximum(work, np.abs(force * strain).max(axis=0))
    weight: Floats = np.asarray(run.stored["point_weight"].values, dtype=float)
    return largest, weight[:, None] * work


def _rod(
    run: Run, rod: str, law: dict[str, Any], largest: Floats, work: Floats, tolerance: float
) -> list[StrainValidity]:
    mine = np.flatnonzero(run.stored["point_rod"].values == rod)
    work = work[mine].sum(axis=0)
    found = []
    for k in np.flatnonzero(work > LITTLE * work.sum()).tolist():
        time = law["times"][k]
        # the point of the rod where the strain is largest represents all
        point = int(mine[np.argmax(largest[mine, k])])
        history = run.stored["strain"].isel(point=point, component=k).values
        omega, rate = _spectrum(run.time, np.asarray(history, dtype=float))
        if not time or not rate.any():
            continue
        mean, high = _frequencies(omega, rate)
        series = law.get(KIND[k])
        if series is None:
            bound, limit = math.nan, QUICK / (2.0 * math.pi * time)
            valid = 2.0 * math.pi * high * time <= QUICK
        else:
            bound = _bound(omega, rate, float(largest[point, k]), series)
            limit = _limit(series, tolerance)
            valid = bound <= tolerance
        found.append(StrainValidity(rod, COMPONENTS[k], time, mean, high, bound, limit, valid))
    return found


def _loss_note(run: Run, rod: str, law: dict[str, Any], largest: Floats, work: Floats) -> str:
    """Say whether the motion lies in the band of a loss factor; empty where the rod was not strained."""
    mine = np.flatnonzero(run.stored["point_rod"].values == rod)
    k = int(np.argmax(work[mine].sum(axis=0)))
    point = int(mine[np.argmax(largest[mine, k])])
    history = run.stored["strain"].isel(point=point, component=k).values
    omega, rate = _spectrum(run.time, np.asarray(history, dtype=float))
    if not rate.any():
        return ""
    mean, _ = _frequencies(omega, rate)
    low, high = law["loss_band"]
    place = "within it" if low <= mean <= high else "outside of it, where the loss factor falls off"
    return (
        f"rod {rod}: its loss factor holds from {quantity(low, 'Hz', 4)} to {quantity(high, 'Hz', 4)}; the mean "
        f"frequency of its {COMPONENTS[k]} is {quantity(mean, 'Hz', 3)}, {place}"
    )


def _spectrum(time: Floats, strain: Floats) -> tuple[Floats, Floats]:
    """Return angular frequencies (n,) and the size of the transform of the rate of a strain, (n,)."""
    from scipy.interpolate import CubicSpline

    known, first = np.unique(time, return_index=True)
    duration = float(known[-1] - known[0])
    wanted = min(duration / float(np.min(np.diff(known))), float(MOST_SAMPLES))
    count = min(MOST_SAMPLES, 2 ** max(6, math.ceil(math.log2(wanted)) + 1))
    rate = CubicSpline(known, strain[first])(np.linspace(known[0], known[-1], count), 1)
    last = max(2, round(FADE * count))
    rate[-last:] *= 0.5 + 0.5 * np.cos(np.pi * np.arange(1, last + 1) / last)
    step = duration / (count - 1)
    omega = 2.0 * np.pi * np.fft.rfftfreq(2 * count, step)
    return omega, step * np.abs(np.fft.rfft(rate, 2 * count))


def _frequencies(omega: Floats, rate: Floats) -> tuple[float, float]:
    """Return the mean frequency and that below which 95 % of the dissipation lies, Hz: weights |eps_t^|^2."""
    power = rate**2
    total = np.cumsum(power) - 0.5 * power  # up to the frequency itself, by the trapezoidal rule
    mean = float(np.sum(omega * power) / total[-1])
    high = float(np.interp(0.95 * total[-1], total, omega))
    return mean / (2.0 * math.pi), high / (2.0 * math.pi)


def _weight(omega: Floats, series: dict[str, Any]) -> Floats:
    """Return a bound of the error of the complex modulus less its value at rest, Pa."""
    moduli, times = np.array(series["moduli"]), np.array(series["times"])
    product = omega[:, None] * times
    slow = math.isclose(series["viscosity"], float(moduli @ times), rel_tol=1e-9)
    if slow:
        weight: Floats = np.sum(moduli * product**2 / np.sqrt(1.0 + product**2), axis=1)
        return weight
    exact = np.sum(moduli * product * (product + 1j) / (1.0 + product**2), axis=1)
    return np.asarray(np.abs(exact - 1j * omega * series["viscosity"]))


def _bound(omega: Floats, rate: Floats, largest: float, series: dict[str, Any]) -> float:
    """Return a bound of the stress error over the largest elastic stress."""
    inside = omega > 0.0
    integrand = rate[inside] / omega[inside] * _weight(omega[inside], series)
    moving = float(np.sum(integrand)) * float(omega[1] - omega[0]) / math.pi  # both signs of the frequency
    resting = abs(series["equilibrium"] - series["modulus"]) * largest
    return float((moving + resting) / (series["modulus"] * largest))


def _limit(series: dict[str, Any], tolerance: float) -> float:
    """Return the frequency up to which the error of a harmonic stress stays within the tolerance, Hz."""
    times = series["times"]
    omega = np.geomspace(1e-4 / times[-1], 1e4 / times[0], 4000)
    error = _weight(omega, series) + abs(series["equilibrium"] - series["modulus"])
    size = np.abs(series["modulus"] + 1j * omega * series["viscosity"])
    wrong = np.flatnonzero(error > tolerance * size)
    if not wrong.size:
        return math.inf
    return float(omega[wrong[0]]) / (2.0 * math.pi) if wrong[0] > 0 else 0.0

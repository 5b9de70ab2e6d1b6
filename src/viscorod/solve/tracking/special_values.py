"""Values of a parameter at which something happens to a mode that is followed, found as roots of smooth functions.

A mode with damping begins to grow where Re s vanishes. Without damping it does so where two frequencies meet: there
``(s1 - s2)^2`` changes its sign, which is smooth although the roots are not. It diverges where an eigenvalue of the
stiffness passes zero (Seyranian and Mailybaev, Multiparameter Stability Theory, 2003, chapters 2 and 5).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy  # its parts are imported when they are asked for

from viscorod.errors import SolveError
from viscorod.solve.tracking.mode_tracking import STILL, Sample, Tracker, alike

__all__ = ["Limit", "ModeBetween", "growing", "grows", "limits", "resting", "solved"]

GROWS = 1e-7
"""Growth of a motion, as a part of its root, from which on it counts: round-off of undamped ones is less."""
PRECISION = 1e-11
"""Part of the parameter to which roots are found."""
COINCIDENT = 1e-6
"""Distance of two roots, as a part of them, within which they are one."""
BESIDE = 1e-4
"""Part of the way between two values within which a limit is at one of them, if two roots are one there."""
ROUNDS = 100
NARROWED, LIKE = 10, 0.3
"""Halvings before two roots that meet are looked at, and likeness of their motions then."""


@dataclass(frozen=True)
class Limit:
    """A value of the parameter at which a mode begins to grow, or ceases to.

    Attributes:
        parameter: its value; mode: number; root: of the mode there [1/s].
        kind: "flutter" or "divergence"; unstable: whether it grows beyond.
        function: of the parameter, whose root it is; slope: its derivative there, 0 where the function only touches
            zero.
    """

    parameter: float
    mode: int
    root: complex
    kind: str
    unstable: bool
    function: str
    slope: float


def grows(s: complex) -> bool:
    """Return whether a motion grows."""
    return bool(s.real > GROWS * abs(s) and s.real > 0.0)


def resting(samples: Sequence[Sample]) -> np.ndarray:
    """Return where modes are at rest ``(samples, modes)``: their roots are round-off beside those elsewhere."""
    sizes = np.abs([sample.roots for sample in samples])
    return np.asarray(sizes <= STILL * sizes.max(axis=0))


def growing(samples: Sequence[Sample]) -> np.ndarray:
    """Return where modes grow ``(samples, modes)``."""
    found = np.array([[grows(complex(s)) for s in sample.roots] for sample in samples])
    return np.asarray(found & ~resting(samples))


class ModeBetween:
    """One mode between two samples, as a function of the parameter.

    Args:
        tracker: that followed it; mode: its number; ends: the samples before and after.
    """

    def __init__(self, tracker: Tracker, mode: int, ends: tuple[Sample, Sample]) -> None:
        self.tracker, self.mode, self.ends = tracker, mode, ends
        self._known = {end.parameter: (complex(end.roots[mode]), end.shapes[:, mode]) for end in ends}

    def at(self, parameter: float) -> tuple[complex, np.ndarray]:
        """Return the root [1/s] and its shape ``(6 n,)`` with unit inertia.

        Raises:
            SolveError: it was not found there.
        """
        if parameter not in self._known:
            self._known[parameter] = self._found(parameter)
        return self._known[parameter]

    def root(self, parameter: float) -> complex:
        """Return the root [1/s]."""
        return self.at(parameter)[0]

    def _found(self, parameter: float) -> tuple[complex, np.ndarray]:
        near = sorted(self._known, key=lambda known: abs(known - parameter))[:2]
        (s, shape), (other, _) = self._known[near[0]], self._known[near[1]]
        guess = s + (other - s) * (parameter - near[0]) / (near[1] - near[0])
        first, last = (complex(end.roots[self.mode]) for end in self.ends)
        far = abs(first - last) + 0.05 * max(abs(first), abs(last))
        mass = self.tracker.family.mass
        self.tracker.check_interrupt()
        found = self.tracker.family.pencil(parameter).refined(guess, shape, far)
        if found is not None:
            root, shape_there = found
            shape_there = shape_there / np.sqrt(np.vdot(shape_there, mass @ shape_there).real)
            if abs(np.vdot(shape, mass @ shape_there)) ** 2 > 0.25:
                return root, shape_there
        spectrum = self.tracker.spectrum(parameter, 1.3 * max(abs(first), abs(last)))
        roots = np.concatenate([spectrum.roots, spectrum.roots.conj()])
        shapes = np.hstack([spectrum.shapes, spectrum.shapes.conj()])
        like = alike(np.array([s]), shape[:, None], roots, shapes, mass)[0]
        k = int(np.argmin(1.0 - like + np.minimum(np.abs(roots - guess) / far, 1.0)))
        return complex(roots[k]), shapes[:, k]


def solved(function: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Return the root of a function that changes its sign between two values, and its slope there."""
    known: dict[float, float] = {}

    def seen(x: float) -> float:
        if x not in known:
            known[x] = function(x)
        return known[x]

    size = max(abs(low), abs(high))
    found = float(
        scipy.optimize.brentq(
            seen, low, high, xtol=PRECISION * size, rtol=4.0 * np.finfo(float).eps, maxiter=ROUNDS
        )
    )
    others = sorted(known, key=lambda x: abs(abs(x - found) - 1e-4 * size))
    beside = next(x for x in others if x != found)
    return found, (known[beside] - seen(found)) / (beside - found)


def limits(tracker: Tracker) -> list[Limit]:
    """Return where the modes that were followed begin to grow and cease to, in order of the parameter."""
    found, unstable = [], growing(tracker.samples)
    for mode in range(len(tracker.samples[0].roots)):
        for k, ends in enumerate(pairwise(tracker.samples)):
            first, last = unstable[k : k + 2, mode]
            if first != last:
                found.append(_limit(tracker, mode, ends, bool(last)))
    return sorted(found, key=lambda one: one.parameter)


def _limit(tracker: Tracker, mode: int, ends: tuple[Sample, Sample], unstable: bool) -> Limit:
    low, high = (end.parameter for end in ends)
    growing, calm = ends[::-1] if unstable else ends
    s, rest = complex(growing.roots[mode]), complex(calm.roots[mode])
    shape = growing.shapes[:, mode]
    if s.imag == 0.0:

        def stiffness(p: float) -> float:
            return tracker.family.pencil(p).stiffness_near_zero(shape)

        found = _tried(stiffness, low, high)
        if found is not None:
            return Limit(found[0], mode, 0j, "divergence", unstable, "stiffness", found[1])
    if rest.real >= -GROWS * abs(rest):
        pair = _Pair.of(tracker, (growing.parameter, s, shape), (calm.parameter, rest))
        low, high = sorted((pair.growing, pair.calm))
        found = _tried(pair.distance, low, high)
        near = found is None or abs(found[0] - calm.parameter) < BESIDE * abs(
            growing.parameter - calm.parameter
        )
        if near and abs(pair.distance(calm.parameter)) <= (COINCIDENT * abs(rest)) ** 2:
            # two that are one are driven apart by any load, as in Nikolai's shaft: the distance only touches zero
            return Limit(calm.parameter, mode, 1j * abs(rest.imag), "flutter", unstable, "pair", 0.0)
        if found is not None:
            return Limit(found[0], mode, 1j * pair.frequency(found[0]), "flutter", unstable, "pair", found[1])
        low, high = (end.parameter for end in ends)
    branch = ModeBetween(tracker, mode, ends)
    found = _tried(lambda p: branch.root(p).real, low, high)
    if found is None:
        raise SolveError(
            f"Mode {mode + 1} changes its stability between {low:.8g} and {high:.8g}, and the limit was not found. "
            "What to try: more values in between"
        )
    root = branch.root(found[0])
    kind = "flutter" if abs(root.imag) > GROWS * max(abs(s), abs(rest)) else "divergence"
    return Limit(found[0], mode, 1j * root.imag, kind, unstable, "growth", found[1])


@dataclass
class _Pair:
    """Two roots without damping that meet between a value of the parameter where one grows and one where none does.

    Attributes:
        tracker: finds roots; growing, calm: these values; root: that grows [1/s]; shape: of it ``(6 n,)``.
        reach: up to which roots are looked at [1/s].
    """

    tracker: Tracker
    growing: float
    calm: float
    root: complex
    shape: np.ndarray
    reach: float

    @classmethod
    def of(
        cls, tracker: Tracker, growing: tuple[float, complex, np.ndarray], calm: tuple[float, complex]
    ) -> _Pair:
        """Return the pair between two values so close that no other root is as near to both."""
        reach = 2.0 * max(abs(growing[1]), abs(calm[1]))
        pair = cls(tracker, growing[0], calm[0], growing[1], growing[2], reach)
        for _ in range(NARROWED):
            middle = 0.5 * (pair.growing + pair.calm)
            roots, shapes = pair.alike(middle)
            # what diverges all the while, as a rigid motion may, is another one
            own = np.where(np.abs(roots.imag) >= 0.5 * abs(pair.root.imag), roots.real, -np.inf)
            k = int(np.argmax(own)) if len(roots) else -1
            if k >= 0 and np.isfinite(own[k]) and grows(complex(roots[k])):
                pair.growing, pair.root, pair.shape = middle, complex(roots[k]), shapes[:, k]
            else:
                pair.calm = middle
        return pair

    def alike(self, parameter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the roots whose motions are like the one that grows, and these."""
        found = self.tracker.spectrum(parameter, self.reach)
        both = [
            alike(np.array([self.root]), self.shape[:, None], found.roots, shapes, self.tracker.family.mass)[
                0
            ]
            for shapes in (found.shapes, found.shapes.conj())
        ]
        kept = np.maximum(*both) > LIKE
        return found.roots[kept], found.shapes[:, kept]

    def distance(self, parameter: float) -> float:
        """Return ``(s1 - s2)^2`` of both [1/s^2]."""
        one, other = self._roots(parameter)
        return float(((one - other) ** 2).real)

    def frequency(self, parameter: float) -> float:
        """Return the mean of both frequencies [rad/s]."""
        return float(self._roots(parameter).imag.mean())

    def _roots(self, parameter: float) -> np.ndarray:
        roots, _ = self.alike(parameter)
        if len(roots) < 2:
            raise SolveError("Two motions that meet were not found: follow more modes")
        order = np.argsort(np.abs(roots.imag - self.root.imag), kind="stable")
        return np.asarray(roots[order[:2]])


def _tried(function: Callable[[float], float], low: float, high: float) -> tuple[float, float] | None:
    """Return the root of a function and its slope; None if it does not change its sign."""
    if function(low) * function(high) > 0.0:
        return None
    return solved(function, low, high)

"""Modes followed along a parameter through crossings and veerings, by their shapes (MAC) and the course of their roots.

Between two values of the parameter every mode is matched with the motion whose shape is most like its own, the modal
assurance criterion (Allemang and Brown, Proc. 1st IMAC, 1982), and whose root lies where its course leads. Where a
shape has no counterpart the step is halved: modes that veer exchange their shapes within a small change of the
parameter, and keep their order. What stays open is told.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import scipy  # its parts are imported when they are asked for
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.statics.newton import interruption
from viscorod.solve.tracking.moving_pencil import MovingPencil, Spectrum
from viscorod.typing import Floats

__all__ = ["SWINGS", "Family", "Sample", "Tracker", "alike"]

SURE = 0.8
"""Likeness of two shapes from which on they are those of one mode."""
BESIDE = 1e-4
"""Part of the parameter beside which a slope is taken."""
HALVINGS = 7
"""How often a step is halved at most to tell modes apart."""
EQUAL = 1e-6
"""Distance of roots, as a part of them, within which any combination of their shapes is a mode."""
COURSE = 0.3
"""Weight of the distance of a root from the course of a mode beside the likeness of shapes."""
OWN = 0.1
"""Weight of the likeness with a shape itself where roots are equal."""
BEND = 0.05
"""Distance from the course, as a part of the root, that counts as far."""
REACH = 1.3
"""How far beyond the largest root of a mode others are sought."""
STILL = 1e-6
"""Part of the median of the slowest roots below which one is that of a motion at rest."""
NOISE = 1e2 * float(np.sqrt(np.finfo(float).eps))
"""Part of the shift from which roots are sought below which one may be the rounding of zero."""
PARTNER = 1e-6
"""Distance of two roots from being mirror images, as a part of them."""
SWINGS = 0.04
"""Imaginary part, as a part of a root, from which on a mode is followed: damping ratios below 0.999."""
CROWD = 0.5
"""Part of the rate at which overdamped motions crowd, below which one is a mode of its own."""
SHIFTS, FIRST, MOST_FIRST = 30, 4, 64
"""Shifts that are tried at most, and roots by which one is judged."""
SHIFT = 0.37
"""Real shift about which roots are sought, as a part of the slowest one."""


class Family(Protocol):
    """Small motions that depend on a parameter."""

    mass: sparse.csr_array
    """Inertia of body increments of the nodes, sparse ``(6 n, 6 n)``."""

    def pencil(self, parameter: float) -> MovingPencil:
        """Return the small motions at a value of the parameter."""

    def idle(self, parameter: float, roots: np.ndarray) -> np.ndarray:
        """Return which roots are those of motions that are none, however they look."""

    def principal(self, parameter: float, shapes: np.ndarray) -> np.ndarray:
        """Return combinations ``(6 n, m)`` of shapes with one root, each of which is a motion of one kind."""


@dataclass
class Sample:
    """The modes that are followed, at one value of the parameter.

    Attributes:
        parameter: its value; roots: of the modes [1/s], Im < 0 where one has passed zero; shapes: body increments
            ``(6 n, modes)``, unit inertia; likeness: of each shape with the one before ``(modes,)``.
        spectrum: all motions that were found there.
    """

    parameter: float
    roots: np.ndarray
    shapes: np.ndarray
    likeness: Floats
    spectrum: Spectrum


@dataclass
class Tracker:
    """Follows the slowest modes of a family.

    Attributes:
        family: whose modes they are; count: how many.
        samples: at all values of the parameter so far, those between the ones asked for too, in order.
        doubts: stretches of the parameter in which modes could not be told apart, with their numbers.
        check_interrupt: raises where the search is to stop; told: is told each value that is reached, and the step.
        stopped: why the modes were not followed to the last value, empty if they were.
    """

    family: Family
    count: int
    check_interrupt: Callable[[], None] = lambda: None
    told: Callable[[float, float], None] | None = None
    stopped: str = ""
    samples: list[Sample] = field(default_factory=list)
    doubts: list[tuple[float, float, tuple[int, ...]]] = field(default_factory=list)
    _shift: float = 0.0
    _space: int = 0
    _slopes: np.ndarray | None = None

    def follow(self, parameters: Sequence[float], first: int = 0) -> None:
        """Follow the modes over increasing values of the parameter, from the one numbered ``first`` to both ends.

        Where that ends early, between two values or more, the samples up to there are kept, and the reason.

        Raises:
            SolveError: the small motions were not found near the first value.
        """
        start = self._begin(float(parameters[first]))
        self._slopes = self._slopes_at(start)
        upwards, downwards = [start], [start]
        try:
            for values, way in ((parameters[:first][::-1], downwards), (parameters[first + 1 :], upwards)):
                for value in map(float, values):
                    step = value - way[-1].parameter
                    self._step(way, value, 0)
                    if self.told is not None and way is upwards:
                        self.told(value, step)
        except (SolveError, KeyboardInterrupt) as error:
            self.samples = downwards[:0:-1] + upwards
            if len(self.reached(parameters)) < 2:
                raise
            self.stop(interruption(error) if isinstance(error, KeyboardInterrupt) else str(error))
        self.samples = downwards[:0:-1] + upwards

    def stop(self, reason: str) -> None:
        """Keep the reason why something was not done to its end; what is there is evaluated without asking again."""
        self.stopped = reason
        self.check_interrupt = lambda: None

    def reached(self, parameters: Sequence[float]) -> list[float]:
        """Return the values, of those that were asked for, at which there are samples."""
        known = {sample.parameter for sample in self.samples}
        return [float(value) for value in parameters if float(value) in known]

    def at(self, parameters: Sequence[float]) -> list[Sample]:
        """Return the samples at values that were asked for."""
        known = {sample.parameter: sample for sample in self.samples}
        return [known[float(value)] for value in parameters]

    def spectrum(self, parameter: float, reach: float, count: int | None = None) -> Spectrum:
        """Return all motions up to ``reach`` [1/s], and at least ``count``, with unit inertia."""
        self.check_interrupt()
        pencil = self.family.pencil(parameter)
        wanted = min(self.count + 2 if count is None else count, pencil.size // 2)
        if self._shift == 0.0:
            self._shift = _first_shift(pencil)
        found = pencil.slowest(wanted, reach, self._shift, self._space)
        if count is None:
            self._space = found.space
        shapes = found.shapes
        for same in _clusters(found.roots):
            shapes[:, same] = self.family.principal(parameter, shapes[:, same])
        size = np.sqrt(np.einsum("ik,ik->k", shapes.conj(), self.family.mass @ shapes).real)
        return Spectrum(found.roots, shapes / size, found.complete, found.space)

    def _begin(self, parameter: float) -> Sample:
        found = self.spectrum(parameter, 0.0)
        while True:
            s = found.roots
            still = np.abs(s) <= _still(np.abs(s), self._shift)
            chosen = np.flatnonzero(~still & self._worth(s, parameter))[: self.count]
            if len(chosen) >= self.count or len(s) >= 4 * self.count + 40:
                break
            more = self.spectrum(parameter, 0.0, 2 * len(s))
            if len(more.roots) <= len(s):
                break
            found = more
        if not len(chosen):
            raise SolveError("No small motion oscillates where modes begin to be followed")
        return Sample(parameter, s[chosen], found.shapes[:, chosen], np.ones(len(chosen)), found)

    def _slopes_at(self, start: Sample) -> np.ndarray:
        """Return the changes of the roots by the parameter where modes begin to be followed; 0 if not known.

        From rest on the two whirls of a round shaft have the same shapes, and which is which their courses alone tell.
        """
        slopes = np.zeros(len(start.roots), dtype=complex)
        step = BESIDE * start.parameter
        if step > 0.0:
            pencil = self.family.pencil(start.parameter + step)
            for k, (s, shape) in enumerate(zip(start.roots, start.shapes.T, strict=True)):
                found = pencil.refined(complex(s), shape, max(BEND * abs(s), 10.0 * step))
                slopes[k] = 0.0 if found is None else (found[0] - s) / step
        return slopes

    def _worth(self, s: np.ndarray, parameter: float) -> np.ndarray:
        """Return which roots begin modes: those that swing or grow, and creeping ones slower than all of these.

        Of the material's own damping very many motions creep about as fast as it relaxes; none of these is taken.
        """
        swings = (s.imag > SWINGS * np.abs(s)) | (s.real > 1e-6 * np.abs(s))
        first = float(np.abs(s[swings]).min(initial=np.inf))
        crowd = CROWD * self.family.pencil(parameter).quadratic.creep
        chosen = swings | (np.abs(s) < min(first, crowd))
        return np.asarray(chosen & ~self.family.idle(parameter, s))

    def _step(self, way: list[Sample], parameter: float, depth: int) -> None:
        """Add the sample at the next value, with others before it where modes could not be told apart."""
        last = way[-1]
        reach = REACH * float(np.abs(last.roots).max())
        found = self.spectrum(parameter, reach)
        sample = self._matched(way, found, parameter)
        poor = np.flatnonzero(sample.likeness < SURE)
        if len(poor) and depth < HALVINGS:
            self._step(way, 0.5 * (last.parameter + parameter), depth + 1)
            self._step(way, parameter, depth + 1)
            return
        if len(poor):
            ends = sorted((last.parameter, parameter))
            self.doubts.append((ends[0], ends[1], tuple(int(k) for k in poor)))
        way.append(sample)

    def _matched(self, way: list[Sample], found: Spectrum, parameter: float) -> Sample:
        """Return the motions that continue the modes of the last sample."""
        last = way[-1]
        expected, mass = _course(way, parameter, self._slopes), self.family.mass
        likeness = alike(last.roots, last.shapes, found.roots, found.shapes, mass)
        mirrored = alike(last.roots, last.shapes, found.roots, found.shapes.conj(), mass)
        momenta = (mass @ last.shapes).conj().T
        products = [np.abs(momenta @ shapes) ** 2 for shapes in (found.shapes, found.shapes.conj())]
        far = [
            np.abs(roots[None, :] - expected[:, None])
            / (BEND * np.maximum(np.abs(expected), 0.1 * np.abs(expected).min())[:, None])
            for roots in (found.roots, found.roots.conj())
        ]
        cost = np.array(
            [
                1.0 - mac - OWN * own + COURSE * np.minimum(d, 1.0) + 1e-3 * np.minimum(d, 100.0)
                for mac, own, d in zip((likeness, mirrored), products, far, strict=True)
            ]
        )
        resting = np.abs(found.roots) <= STILL * np.abs(last.roots).max()
        cost += resting | self.family.idle(parameter, found.roots)  # whatever their shapes are like
        conjugate = cost[1] < cost[0]
        rows, columns = scipy.optimize.linear_sum_assignment(cost.min(axis=0))
        chosen = columns[np.argsort(rows)]
        chosen = self._growing(found, chosen, likeness)
        turned = conjugate[np.arange(len(chosen)), chosen] & (found.roots[chosen].imag != 0.0)
        roots, shapes = found.roots[chosen], found.shapes[:, chosen]
        roots = np.where(turned, roots.conj(), roots)
        shapes = np.where(turned, shapes.conj(), shapes)
        macs = np.where(
            turned, mirrored[np.arange(len(chosen)), chosen], likeness[np.arange(len(chosen)), chosen]
        )
        return Sample(parameter, roots, shapes, np.asarray(macs), found)

    def _growing(self, found: Spectrum, chosen: np.ndarray, likeness: Floats) -> np.ndarray:
        """Return the choice with the growing one of two roots where an oscillation, or two, have ended in both.

        These are two real roots, or without damping two with the same frequency, of which one grows as the other fades.
        """
        s, taken, better = found.roots, set(chosen.tolist()), chosen.copy()
        for k, place in enumerate(chosen):
            partners = np.flatnonzero(
                (np.abs(s.imag - s[place].imag) <= PARTNER * np.abs(s[place])) & (s.real > s[place].real)
            )
            for other in partners:
                mirrored = s[place].imag == 0.0 or abs(s[other] + s[place].conj()) <= PARTNER * abs(s[place])
                grows = s[other].real > s[better[k]].real
                if (
                    mirrored
                    and grows
                    and int(other) not in taken
                    and likeness[k, other] > 0.5 * likeness[k, place]
                ):
                    taken.add(int(other))
                    better[k] = other
        return better


def _first_shift(pencil: MovingPencil) -> float:
    """Return a real shift [1/s] that is somewhat less than the slowest root.

    Raises:
        SolveError: nothing moves.
    """
    M, K = pencil.quadratic.M.diagonal(), np.abs(pencil.quadratic.K.diagonal())
    shift, count = 1e-4 * float(np.sqrt(K.sum() / M.sum())), min(FIRST, pencil.size // 2)
    for _ in range(SHIFTS):
        found = np.abs(pencil.slowest(count, 0.0, shift).roots)
        moving = found[found > _still(found, shift)] if len(found) else found
        if not len(moving):
            if 2 * count <= min(MOST_FIRST, pencil.size // 2):
                count *= 2
                continue
            raise SolveError("The model has no small motions that could be followed")
        slowest = float(moving.min())
        near = 0.05 * slowest < shift < 0.7 * slowest
        shift = SHIFT * slowest
        if near:
            break
    return shift


def _still(sizes: Floats, shift: float) -> float:
    """Return the size [1/s] up to which roots are those of motions at rest, of all that were found from a shift.

    A double root at zero, as what nothing resists has, is found with the root of the precision of the shift.
    """
    return max(STILL * float(np.median(sizes)), NOISE * shift)


def alike(
    roots: np.ndarray, shapes: np.ndarray, others: np.ndarray, theirs: np.ndarray, mass: sparse.csr_array
) -> Floats:
    """Return the likeness (MAC) of shapes of unit inertia ``(m, k)``; of equal roots of the nearest combination."""
    products = np.abs(shapes.conj().T @ (mass @ theirs)) ** 2
    mine, other = _equal(roots), _equal(others)
    within = np.maximum(mine @ products, products @ other.T)
    return np.asarray(np.minimum(within, 1.0))


def _equal(roots: np.ndarray) -> Floats:
    """Return a matrix of ones where two roots are equal but for round-off."""
    return np.asarray(
        np.abs(roots[:, None] - roots[None, :]) <= EQUAL * np.maximum(np.abs(roots[:, None]), np.abs(roots)),
        dtype=float,
    )


def _clusters(roots: np.ndarray) -> list[np.ndarray]:
    """Return the places of roots that are equal, where there are several."""
    near = _equal(roots) > 0.0
    groups = {tuple(np.flatnonzero(row).tolist()) for row in near}
    return [
        np.array(group) for group in sorted(groups) if len(group) > 1 and near[np.ix_(group, group)].all()
    ]


def _course(way: list[Sample], parameter: float, slopes: np.ndarray | None) -> np.ndarray:
    """Return where the roots of the modes lead at a value of the parameter, at first with their slopes."""
    last = way[-1]
    if len(way) < 2:
        return np.asarray(last.roots + (0.0 if slopes is None else slopes) * (parameter - last.parameter))
    before = way[-2]
    part = (parameter - last.parameter) / (last.parameter - before.parameter)
    ahead = last.roots + part * (last.roots - before.roots)
    turned = (last.roots.imag == 0.0) != (before.roots.imag == 0.0)
    return np.where(turned, last.roots, ahead)

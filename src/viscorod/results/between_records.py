"""States between stored ones: polynomials in time of poses and of fields.

Positions and rotations are cubics through two stored states and their rates. Everything else, velocities too (the rate
of that cubic would divide the round-off and the drift corrections of positions by a small step), is a polynomial
through stored states alone: where both ends of a step and two or more states between are stored, as they are by default
for the collocation methods, the one through these. Section forces then are the integrator's own polynomial of the step,
which is a cubic through its start and three stages. Elsewhere it is the cubic through the four nearest states. Errors
are of order 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.results.extremes import hermite
from viscorod.typing import Floats, Integers

_NEAREST = 4  # stored states of a polynomial across steps
_INSIDE = 5  # of one within a step, at most
_SMALL = 1e-4  # rotation [rad] below which series replace quotients


@dataclass(frozen=True)
class Instants:
    """Requested times, among stored ones.

    Attributes:
        time: requested times ``(n,)`` [s].
        states: numbers of the stored states that are needed, increasing ``(m,)``.
        interval: the stored state before each time, as a place in ``states``, after which comes that behind it.
        part: of the interval, 0 to 1; length: of the interval [s].
        window: stored states of the polynomials, as places in ``states`` ``(n, k)``; weights: theirs ``(n, k)``.
    """

    time: Floats
    states: Integers
    interval: Integers
    part: Floats
    length: Floats
    window: Integers
    weights: Floats

    @classmethod
    def of(cls, known: Floats, times: Floats, ends: Integers | None = None) -> Instants:
        """Locate times [s] among the stored ones, which increase.

        Args:
            known: stored times; times: requested ones.
            ends: which stored states end a step, the first one too; see :func:`step_ends`.

        Raises:
            InputError: a time is not finite or lies outside the run.
        """
        times = np.atleast_1d(np.asarray(times, dtype=float))
        if times.ndim != 1 or times.size == 0:
            raise InputError("times: give one time in s, or a list of times")
        slack = 1e-9 * max(abs(known[-1]), abs(known[0]))
        outside = ~((times >= known[0] - slack) & (times <= known[-1] + slack))
        if outside.any():
            raise InputError(
                f"time = {times[outside][0]:g} s lies outside the run, which covers {known[0]:g} to {known[-1]:g} s"
            )
        times = np.clip(times, known[0], known[-1])
        last = known.size - 1
        k = np.clip(np.searchsorted(known, times, side="right") - 1, 0, max(last - 1, 0))
        after = np.minimum(k + 1, last)
        length = np.where(after > k, known[after] - known[k], 1.0)
        window, weights = _windows(known, times, k, ends)
        states = np.unique(np.concatenate([k, after, window.ravel()]))
        interval, window = np.searchsorted(states, k), np.searchsorted(states, window)
        return cls(times, states, interval, (times - known[k]) / length, length, window, weights)

    def fields(self, field: Floats) -> Floats:
        """Return a field ``(m, ...)`` of ``states`` at the times, the polynomial through stored states."""
        result: Floats = np.einsum("tk,tk...->t...", self.weights, field[self.window])
        return result

    def positions(self, position: Floats, velocity: Floats) -> Floats:
        """Return positions at the times, from those and velocities in ``states`` ``(m, ..., 3)``."""
        k, after = self._ends(position)
        u, h = (self._spread(x, position) for x in (self.part, self.length))
        return _hermite(u, h, position[k], position[after], velocity[k], velocity[after])

    def rotations(self, rotation: Floats, spin: Floats) -> Floats:
        """Return unit quaternions at the times.

        The rotation vector from the stored state before is the cubic; it turns by less than pi in an interval.

        Args:
            rotation: in ``states`` ``(m, ..., 4)``; spin: angular velocity, body axes ``(m, ..., 3)``.
        """
        k, after = self._ends(rotation)
        u, h = (self._spread(x, rotation) for x in (self.part, self.length))
        turn = _vector(product(conjugate(rotation[k]), rotation[after]))
        theta = _hermite(u, h, np.zeros_like(turn), turn, spin[k], _vector_rate(turn, spin[after]))
        return product(rotation[k], _quaternion(theta))

    def _ends(self, field: Floats) -> tuple[Integers, Integers]:
        return self.interval, np.minimum(self.interval + 1, len(field) - 1)

    @staticmethod
    def _spread(x: Floats, field: Floats) -> Floats:
        return x.reshape(-1, *(1,) * (field.ndim - 1))


def step_ends(known: Floats, step_size: Floats) -> Integers | None:
    """Return which stored states end a step, the initial one too; None where the ends of some steps are not stored.

    Args:
        known: stored times ``(n,)`` [s]; step_size: of the step in which each lies ``(n,)`` [s].
    """
    ends, last = [0], known.size - 1
    while ends[-1] < last:
        start = ends[-1]
        goal = known[start] + step_size[start + 1]
        k = start + 1
        slack = 1e-6 * step_size[start + 1]
        while k < last and known[k] < goal - slack:
            k += 1
        if abs(known[k] - goal) > slack:
            return None
        ends.append(k)
    return np.array(ends)


def _windows(known: Floats, times: Floats, k: Integers, ends: Integers | None) -> tuple[Integers, Floats]:
    """Return stored states of the polynomials of times in the intervals ``k``, and their weights, padded with zeros."""
    size = min(_NEAREST, known.size)
    low = np.clip(k - 1, 0, known.size - size)
    count = np.full(times.size, size)
    if ends is not None and ends.size > 1:
        step = np.clip(np.searchsorted(ends, k, side="right") - 1, 0, ends.size - 2)
        a, b = ends[step], ends[step + 1]
        inside = b - a + 1 >= _NEAREST
        within = np.minimum(b - a + 1, _INSIDE)
        low = np.where(inside, np.clip(k - 1, a, b + 1 - within), low)
        count = np.where(inside, within, count)
    most = int(count.max())
    used = np.arange(most) < count[:, None]
    window = low[:, None] + np.where(used, np.arange(most), 0)
    nodes = known[window]
    weights = np.where(used, 1.0, 0.0)
    for i in range(most):
        for j in range(most):
            if i != j:
                both = used[:, i] & used[:, j]
                gap = np.where(both, nodes[:, i] - nodes[:, j], 1.0)
                weights[:, i] *= np.where(both, (times - nodes[:, j]) / gap, 1.0)
    return window, weights


def _hermite(u: Floats, h: Floats, y0: Floats, y1: Floats, v0: Floats, v1: Floats) -> Floats:
    """Return the cubic with values ``y`` and rates ``v`` at both ends of an interval ``h``."""
    return hermite(u, y0, y1, h * v0, h * v1)


def _quaternion(theta: Floats) -> Floats:
    """Return the unit quaternions of rotation vectors ``(..., 3)``."""
    half = 0.5 * np.linalg.norm(theta, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * theta], axis=-1)


def _vector(q: Floats) -> Floats:
    """Return the rotation vectors of unit quaternions ``(..., 4)``, at most pi long."""
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    factor = 2.0 * np.arctan2(sine, q[..., :1]) / np.where(sine > 0.0, sine, 1.0)
    result: Floats = np.where(sine > 0.0, factor, 2.0) * q[..., 1:]
    return result


def _vector_rate(theta: Floats, spin: Floats) -> Floats:
    """Return the rate of a rotation vector from the body angular velocity, by the inverse right tangent.

    ``rate = w + theta x w/2 + (1 - phi/2 cot(phi/2))/phi^2 theta x (theta x w)``.
    """
    phi = np.linalg.norm(theta, axis=-1, keepdims=True)
    safe = np.where(phi > _SMALL, phi, 1.0)
    c = np.where(phi > _SMALL, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2, 1.0 / 12.0 + phi**2 / 720.0)
    once = np.cross(theta, spin)
    result: Floats = spin + 0.5 * once + c * np.cross(theta, once)
    return result

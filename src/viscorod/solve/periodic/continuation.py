"""Periodic motions over frequency or level of what drives them, by pseudo-arclength continuation through folds.

A curve of orbits is followed along its tangent; corrections are across it (Keller 1977; Nayfeh and Balachandran 1995,
chapter 6). Lengths are relative: changes of the orbit over its own size, and of the parameter over a part of its range,
so that resonances of any height and width are followed with the steps that they need. The Jacobian of a point, which
its tangent and its multipliers need, serves the corrections of the next one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from viscorod.errors import SolveError
from viscorod.solve.periodic.floquet import multipliers
from viscorod.solve.periodic.orbit import Motion, Orbit, Setting
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_matrix import OrbitMatrix
from viscorod.solve.periodic.orbit_solver import OrbitSolver, Solved, orbit_size
from viscorod.typing import Floats

__all__ = ["UNSTABLE", "Continuation", "OrbitPoint", "Parameter"]

PART = 0.2
"""Of the range of the parameter that counts as much as the orbit changing by its own size."""
ANGLE = 0.35
"""Largest angle [rad] between the tangents of two points."""
UNSTABLE = 1.0 + 1e-6
"""Size of a multiplier from which on a motion counts as unstable."""
LOCATED = 1e-4
"""Part of a step, or of what changes sign, to which bifurcations are located."""
TRIES = 8
"""To locate one."""


@dataclass(frozen=True)
class Parameter:
    """What changes along a curve.

    Attributes:
        of: "omega" or "level" of the setting; start, end: its range.
    """

    of: str
    start: float
    end: float

    @property
    def unit(self) -> float:
        """The change that counts as much as the orbit changing by its own size."""
        return PART * abs(self.end - self.start)


@dataclass
class OrbitPoint:
    """A converged orbit on the curve.

    Attributes:
        orbit, motion: of it; value: of the parameter.
        tangent: changes of all motions ``(N, N_b, 6)``, axes of supports, and of the parameter, per length.
        multipliers: the largest first; none where they are not wanted.
        size: of the orbit; bifurcation: what the curve does here, empty if nothing; iterations: it took.
        bend: half of the second derivatives of body increments ``(N, N_b, 6)`` and parameter along the curve.
    """

    orbit: Orbit
    motion: Motion
    value: float
    tangent: tuple[Floats, float]
    multipliers: np.ndarray
    size: float
    bifurcation: str = ""
    iterations: int = 0
    bend: tuple[Floats, float] | None = None

    @property
    def setting(self) -> Setting:
        """Its setting."""
        return self.motion.setting

    @property
    def unstable(self) -> int:
        """How many multipliers are outside of the unit circle."""
        return int((np.abs(self.multipliers) > UNSTABLE).sum())


class Continuation:
    """Follows orbits.

    Args:
        balance: of the model; parameter: what changes; stability: whether multipliers are wanted.
        stop: returns a reason to stop, empty to go on.
    """

    def __init__(
        self,
        balance: OrbitBalance,
        parameter: Parameter,
        *,
        stability: bool = True,
        stop: Callable[[], str] | None = None,
    ) -> None:
        self.balance, self.parameter, self.stability, self.stop = balance, parameter, stability, stop
        self.solver = OrbitSolver(balance, [parameter.of])
        none = np.zeros((balance.fourier.count, balance.problem.pattern.size, 6))
        self._fixed = none[None], np.ones((1, 1))
        self._last_row = self._fixed

    def first(self, orbit: Orbit, setting: Setting) -> OrbitPoint:
        """Return the orbit at the start of the range, found from one near it, with more and more of the drive.

        Raises:
            SolveError: there is none that the iteration reaches.
        """
        done, step = 0.0, 1.0
        while True:
            part = min(1.0, done + step)
            found = self.solver.solve(
                orbit, setting._replace(level=part * setting.level), self._fixed, fresh=True
            )
            if found is not None and part == 1.0:
                return self._point(found, None)
            if found is None:
                step *= 0.5
                if step < 1e-3:
                    raise SolveError(
                        f"no periodic motion was found at {_told(setting)}: the iteration converges up to {done:.3g} "
                        "of the amplitudes; start farther from the resonance, or give more harmonics"
                    )
            else:
                orbit, done, step = found.orbit, part, 2.0 * step

    def follow(self, first: OrbitPoint, step: float, most: int) -> Iterator[OrbitPoint]:
        """Yield points from the first to the end of the range, bifurcations among them, ``most`` of them at most.

        Args:
            step: largest relative change of the motion between points.

        Raises:
            SolveError: the curve cannot be followed further.
        """
        parameter, point = self.parameter, first
        forward = np.sign(parameter.end - parameter.start)
        if point.tangent[1] * forward < 0.0:
            point.tangent = -point.tangent[0], -point.tangent[1]
        low, high = sorted((parameter.start, parameter.end))
        length, count = 0.25 * step, 1
        yield first
        while count < most:
            self._ask(point)
            new = self._step(point, length)
            angle = 0.0 if new is None else self._angle(point, new)
            while new is None or angle > ANGLE:
                length *= 0.5
                if length < 1e-3 * step:
                    raise SolveError(
                        f"the curve of periodic motions cannot be followed beyond {_told(point.setting)}: the "
                        "iteration does not converge however small the step; give more harmonics"
                    )
                new = self._step(point, length)
                angle = 0.0 if new is None else self._angle(point, new)
            if not low <= new.value <= high:
                end = self._at_end(point, new, high if new.value > high else low)
                if end is not None:
                    yield from self._specials(point, end)
                    yield end
                return
            for special in self._specials(point, new):
                count += 1
                yield special
            count += 1
            yield new
            self._bend(point, new, length)
            point = new
            if new.iterations <= 7 and angle < 0.5 * ANGLE:
                length = min(1.4 * length, step)
            elif new.iterations > 10:
                length *= 0.6

    def _bend(self, point: OrbitPoint, new: OrbitPoint, length: float) -> None:
        """Take from the point before how the curve bends at a new one, for the prediction of the next."""
        jacobian = self.solver.jacobian
        assert jacobian is not None
        back = self.balance.between(new.motion, point.motion)
        along = jacobian.matrix.increments(length * new.tangent[0])
        value = point.value - new.value + length * new.tangent[1]
        new.bend = (back + along) / length**2, value / length**2

    def _ask(self, point: OrbitPoint) -> None:
        reason = self.stop() if self.stop is not None else ""
        if reason:
            raise SolveError(f"stopped at {_told(point.setting)}: {reason}")

    def _step(self, point: OrbitPoint, length: float) -> OrbitPoint | None:
        """Return the orbit at a length along the curve; None if the iteration does not find it."""
        found = self._solved(point, length)
        return None if found is None else self._point(found, point)

    def _solved(self, point: OrbitPoint, length: float) -> Solved | None:
        jacobian = self.solver.jacobian
        assert jacobian is not None
        change = jacobian.matrix.increments(length * point.tangent[0])
        value = length * point.tangent[1]
        if point.bend is not None:
            change, value = change + length**2 * point.bend[0], value + length**2 * point.bend[1]
        orbit = self.balance.added(point.orbit, change)
        setting = point.setting._replace(**{self.parameter.of: point.value + value})
        if not setting.omega > 0.0:
            return None
        stress = self.balance.sections.carried(
            point.motion.points.section_force, jacobian.linear, change, point.setting.omega
        )
        found = self.solver.solve(orbit, setting, self._last_row, stress=stress)
        if found is None:
            self.solver.jacobian, self.solver.rows = jacobian, self._last_row
        return found

    def _point(self, found: Solved, before: OrbitPoint | None) -> OrbitPoint:
        """Return a solved orbit with its tangent and multipliers."""
        rows = self._fixed if before is None else self._row(before)
        jacobian = self.solver.linearise(found.orbit, found.motion, rows)
        self._last_row = rows
        size = orbit_size(self.balance, found.orbit)
        tangent = self._tangent(jacobian.matrix, size)
        setting = found.motion.setting
        values = np.zeros(0, dtype=complex)
        if self.stability:
            values = multipliers(self.balance, setting.omega, jacobian.linear, jacobian.groups)
        value = float(getattr(setting, self.parameter.of))
        return OrbitPoint(
            found.orbit, found.motion, value, tangent, values, size, iterations=found.iterations
        )

    def _tangent(self, matrix: OrbitMatrix, size: float) -> tuple[Floats, float]:
        """Return the tangent at the orbit of the Jacobian, of length 1, along that of its border."""
        right = np.zeros(matrix.size + 1)
        right[-1] = 1.0
        found = matrix.solve(right)
        own, slope = found[:-1], float(found[-1])
        length = float(np.sqrt(matrix.weights @ own**2 / size**2 + (slope / self.parameter.unit) ** 2))
        return matrix.whole(own) / length, slope / length

    def _row(self, point: OrbitPoint) -> tuple[Floats, Floats]:
        """Return the condition that changes are across the tangent of a point."""
        return point.tangent[0][None] / point.size**2, np.array([[point.tangent[1] / self.parameter.unit**2]])

    def _angle(self, one: OrbitPoint, other: OrbitPoint) -> float:
        jacobian = self.solver.jacobian
        assert jacobian is not None
        matrix = jacobian.matrix
        sizes = one.size * other.size
        own = matrix.weights @ (matrix.reduced(one.tangent[0]) * matrix.reduced(other.tangent[0])) / sizes
        along = own + one.tangent[1] * other.tangent[1] / self.parameter.unit**2
        return float(np.arccos(np.clip(along, -1.0, 1.0)))

    def _at_end(self, point: OrbitPoint, beyond: OrbitPoint, value: float) -> OrbitPoint | None:
        """Return the orbit at an end of the range, between two points."""
        part = (value - point.value) / (beyond.value - point.value)
        orbit = Orbit(
            point.orbit.X + part * (beyond.orbit.X - point.orbit.X),
            point.orbit.multiplier + part * (beyond.orbit.multiplier - point.orbit.multiplier),
        )
        setting = point.setting._replace(**{self.parameter.of: value})
        found = self.solver.solve(orbit, setting, self._fixed, fresh=True)
        return None if found is None else self._point(found, point)

    def _specials(self, point: OrbitPoint, new: OrbitPoint) -> list[OrbitPoint]:
        """Return the bifurcations between two points, in order; the solver stands at ``new`` afterwards."""
        kinds: list[tuple[str, Callable[[OrbitPoint], float]]] = []
        if point.tangent[1] * new.tangent[1] < 0.0:
            kinds.append(("fold", lambda p: p.tangent[1]))
        if self.stability:
            kinds += self._crossings(point, new, folded=bool(kinds))
        found = []
        for kind, test in kinds:
            special = self._located(point, new, test)
            if special is not None:
                special.bifurcation = kind
                found.append(special)
        if found:
            self.solver.linearise(new.orbit, new.motion, self._row(point))
            self._last_row = self.solver.rows
        return found

    def _crossings(
        self, point: OrbitPoint, new: OrbitPoint, *, folded: bool
    ) -> list[tuple[str, Callable[[OrbitPoint], float]]]:
        """Return what crosses the unit circle between two points, but the multiplier of a fold."""
        gained = new.unstable - point.unstable
        if gained == 0:
            return []
        more, less = (new, point) if gained > 0 else (point, new)
        crossed = more.multipliers[less.unstable : more.unstable]
        found: list[tuple[str, Callable[[OrbitPoint], float]]] = []
        real = [m for m in crossed if abs(m.imag) < 1e-6 * abs(m)]
        if any(m.real > 0.0 for m in real) and not folded:
            found.append(("branch point", _beyond(less.unstable)))
        if any(m.real < 0.0 for m in real):
            found.append(("period doubling", _beyond(less.unstable)))
        if len(crossed) - len(real) >= 2:
            found.append(("torus", _beyond(less.unstable)))
        return found

    def _located(
        self, point: OrbitPoint, new: OrbitPoint, test: Callable[[OrbitPoint], float]
    ) -> OrbitPoint | None:
        """Return the point between two where a function is zero, by secants that keep it between."""
        low, high = (0.0, test(point)), (1.0, test(new))
        best = None
        for _ in range(TRIES):
            part = low[0] - low[1] * (high[0] - low[0]) / (high[1] - low[1])
            found = self._between(point, new, part)
            if found is None:
                return best
            best, value = found, test(found)
            if abs(value) <= LOCATED * max(abs(test(point)), abs(test(new))):
                return best
            if value * high[1] < 0.0:
                low, high = high, (part, value)
            else:
                low, high = (low[0], 0.5 * low[1]), (part, value)
        return best

    def _between(self, point: OrbitPoint, new: OrbitPoint, part: float) -> OrbitPoint | None:
        """Return the point of the curve at a part of the way from one to another."""
        X = point.orbit.X + part * (new.orbit.X - point.orbit.X)
        multiplier = point.orbit.multiplier + part * (new.orbit.multiplier - point.orbit.multiplier)
        value = point.value + part * (new.value - point.value)
        setting = point.setting._replace(**{self.parameter.of: value})
        found = self.solver.solve(Orbit(X, multiplier), setting, self._row(point), fresh=True)
        return None if found is None else self._point(found, point)


def _beyond(number: int) -> Callable[[OrbitPoint], float]:
    """Return the size of a multiplier less one."""
    return lambda point: float(np.abs(point.multipliers[number]) - 1.0)


def _told(setting: Setting) -> str:
    return f"{setting.omega / (2.0 * np.pi):.6g} Hz, {setting.level:.4g} of the amplitudes"

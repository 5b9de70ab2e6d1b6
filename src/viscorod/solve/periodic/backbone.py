"""Free vibrations of any size: frequency and damping ratio over amplitude.

A free vibration loses energy. A damping that is taken away, proportional to the mass, keeps it going: ``M x' + ... -
2 zeta w M x = 0`` has periodic motions, a family over their amplitude for each mode, along which frequency and damping
ratio follow (Krack, Nonlinear modal analysis of nonconservative systems: extension of the periodic motion concept,
Computers and Structures 154, 2015, 59-71). A slow decay passes through them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from viscorod.errors import SolveError
from viscorod.solve.periodic.orbit import Motion, Orbit, Setting
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_matrix import coupled_motions
from viscorod.solve.periodic.orbit_solver import OrbitSolver, Solved
from viscorod.typing import Floats

__all__ = ["Backbone"]

LEAST = 1e-3
"""Part of the wanted growth from one vibration to the next below which it is given up."""


class Backbone:
    """Follows the free vibrations of a mode.

    Args:
        balance: of the model, without a drive; shape: of the mode, body increments ``(n, 6)``; omega: its undamped
            angular frequency [rad/s].
        amplitude: of a motion, by which the family goes; stop: returns a reason to stop, empty to go on.
    """

    def __init__(
        self,
        balance: OrbitBalance,
        shape: Floats,
        omega: float,
        amplitude: Callable[[Motion], float],
        stop: Callable[[], str] | None = None,
    ) -> None:
        self.balance, self.amplitude, self.stop = balance, amplitude, stop
        self.solver = OrbitSolver(balance, ["omega", "lack"])
        self.setting = Setting(omega, 0.0, 0.0)
        self._resting_stress: Floats
        self.shape = self._in_one_group(shape)
        rows = np.zeros((2, balance.fourier.count, balance.problem.pattern.size, 6))
        for row, wave in zip(rows, (np.cos, np.sin), strict=True):
            row[:, : balance.problem.size] = wave(balance.phases)[:, None, None] * self.shape
        self._rows = rows, np.zeros((2, 2))

    def follow(self, smallest: float, largest: float, step: float, most: int) -> Iterator[Solved]:
        """Yield vibrations from the smallest amplitude to the largest, ``most`` of them at most.

        Raises:
            SolveError: the family cannot be followed, or the amplitude is not that of the mode.
        """
        solved = self._first(smallest)
        yield solved
        before: tuple[Solved, float] | None = None
        growth = 1.0 + step
        for _ in range(most - 1):
            size = self.amplitude(solved.motion)
            if size >= 0.999 * largest:
                return
            reason = self.stop() if self.stop is not None else ""
            if reason:
                raise SolveError(f"stopped at the amplitude {size:.4g}: {reason}")
            found = None
            while found is None:
                factor = min(growth, largest / size)
                found = self._next(solved, before, factor)
                if found is None:
                    growth = 1.0 + 0.5 * (growth - 1.0)
                    if growth - 1.0 < LEAST * step:
                        raise SolveError(
                            f"free vibrations cannot be followed beyond the amplitude {size:.4g}: the iteration does "
                            "not converge however small the step; give more harmonics"
                        )
            if found.iterations <= 7:
                growth = min(1.0 + 1.4 * (growth - 1.0), 1.0 + step)
            before, solved = (solved, factor), found
            yield solved

    def _first(self, smallest: float) -> Solved:
        """Return the vibration of the smallest amplitude, from the linear mode."""
        tiny = 1e-6 * self.balance.problem.length
        unit = self.amplitude(self.balance.moved(self._swing(tiny), self.setting)) / tiny
        if not unit > 0.0:
            raise SolveError(
                "the first output does not move in this mode, and its amplitude cannot tell how far to go; give "
                "another output or mode"
            )
        orbit, setting = self._swing(smallest / unit), self.setting
        found = self.solver.solve(orbit, setting, self._rows, fresh=True)
        if found is None:
            raise SolveError(
                f"no free vibration was found near the linear mode at {self.setting.omega / (2.0 * np.pi):.6g} Hz: "
                "give a smaller amplitude or more harmonics"
            )
        return found

    def _swing(self, size: float) -> Orbit:
        """Return the mode with an amplitude of its shape."""
        balance = self.balance
        change = np.zeros((balance.fourier.count, balance.problem.pattern.size, 6))
        waves = np.cos(balance.phases)[:, None, None]
        change[:, : balance.problem.size] = size * waves * self.shape
        return balance.added(balance.resting(), change)

    def _next(self, solved: Solved, before: tuple[Solved, float] | None, factor: float) -> Solved | None:
        """Return a vibration that is larger by a factor; ``before``: the one before, by what this one is larger."""
        orbit, motion = solved.orbit, solved.motion
        setting, stress = motion.setting, motion.points.stress
        slope = Orbit(orbit.X, orbit.multiplier - self.balance.base.multiplier)  # over the relative amplitude
        strained, omega, lack = stress - self._resting_stress, 0.0, 0.0
        if before is not None:
            earlier, last = before
            part = 1.0 / (1.0 - 1.0 / last)
            slope = Orbit(
                part * (orbit.X - earlier.orbit.X), part * (orbit.multiplier - earlier.orbit.multiplier)
            )
            strained = part * (stress - earlier.motion.points.stress)
            share = (factor**2 - 1.0) / (1.0 - last**-2)  # these grow with the square of the amplitude
            omega = share * (setting.omega - earlier.motion.setting.omega)
            lack = share * (setting.lack - earlier.motion.setting.lack)
        gain = factor - 1.0
        predicted = Orbit(orbit.X + gain * slope.X, orbit.multiplier + gain * slope.multiplier)
        setting = setting._replace(omega=setting.omega + omega, lack=setting.lack + lack)
        jacobian, rows = self.solver.jacobian, self.solver.rows
        found = self.solver.solve(predicted, setting, self._rows, stress=stress + gain * strained, fresh=True)
        if found is None:
            self.solver.jacobian, self.solver.rows = jacobian, rows
        return found

    def _in_one_group(self, shape: Floats) -> Floats:
        """Return the part of a shape in the motions that couple with most of it, largest entry 1.

        Modes of one frequency, as of a square section, may be mixed.
        """
        balance = self.balance
        motion = balance.moved(balance.resting(), self.setting)
        self._resting_stress = motion.points.stress
        linear = balance.linearised(motion)
        groups = coupled_motions(balance, self.setting.omega, linear)
        unit = np.array([balance.problem.length] * 3 + [1.0] * 3)
        flat = np.concatenate([(shape / unit).ravel(), np.zeros(6 * balance.problem.multipliers)])
        most = max(groups, key=lambda group: float((flat[group] ** 2).sum()))
        found = np.zeros_like(flat)
        found[most] = flat[most]
        nodal = found[: shape.size].reshape(shape.shape)
        return np.asarray(nodal / np.abs(nodal).max() * unit)

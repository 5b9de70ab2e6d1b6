"""Newton's iteration for one orbit, with a Jacobian that serves several of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from viscorod.solve.periodic.orbit import Frozen, Linearised, Motion, Orbit, Setting
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_matrix import OrbitMatrix, coupled_motions
from viscorod.typing import Floats, Integers

__all__ = ["Jacobian", "OrbitSolver", "Solved", "orbit_size"]

CONVERGED = 1e-7
"""Size of the last change over that of the orbit."""
BALANCED = 1e-7
"""Largest force that is left unbalanced, over the largest internal or inertial one."""
ROUND_OFF = 1e-11
"""Size of a change over that of the orbit that no further correction would make smaller."""
STALLED = 1e-8
"""Size of a change over that of the orbit below which corrections that no longer become smaller are round-off: small
swings of slender rods leave the round-off of their stretch unbalanced."""
SMALLEST = 1e-14
"""Size of a change (over the length, or rad) that is round-off."""
STILL = 1e-12
"""Size of an orbit (over the length, or rad) that is none."""
ITERATIONS = 24
"""Corrections, with renewed Jacobians where they converge slowly."""
SLOW = 0.4
"""Rate of convergence from which on the Jacobian is renewed."""
TURNED = 2.6
"""Rotation [rad] from the shape at rest up to which orbits are computed."""
DRIVEN = 1e-9
"""Part of the largest force from which on motions are driven."""


class Jacobian(NamedTuple):
    """The factorised Jacobian of an orbit with its border.

    Attributes:
        matrix: of the driven motions; groups: of all motions that do not couple; linear: derivatives at the orbit.
    """

    matrix: OrbitMatrix
    groups: list[Integers]
    linear: Linearised


class Solved(NamedTuple):
    """A converged orbit, its motion, and how many corrections it took."""

    orbit: Orbit
    motion: Motion
    iterations: int


def orbit_size(balance: OrbitBalance, orbit: Orbit) -> float:
    """Return the root mean square over the phases of all displacements over the length, and rotations [rad].

    It has a floor: where nothing moves, as an inextensible column under a pulsating load, changes are measured by it.
    """
    scaled = orbit.X.copy()
    scaled[..., :3] /= balance.problem.length
    return max(float(np.sqrt((scaled**2).sum(axis=(1, 2)).mean())), STILL)


class OrbitSolver:
    """Finds orbits with parameters of their setting as further unknowns.

    Args:
        balance: of the model; unknown: the parameters of the setting that are unknowns.

    Attributes:
        jacobian: in use; None before the first.
    """

    def __init__(self, balance: OrbitBalance, unknown: Sequence[str]) -> None:
        self.balance, self.unknown = balance, tuple(unknown)
        self.jacobian: Jacobian | None = None
        self.rows: tuple[Floats, Floats]

    def solve(
        self,
        orbit: Orbit,
        setting: Setting,
        rows: tuple[Floats, Floats],
        *,
        stress: Floats | None = None,
        fresh: bool = False,
    ) -> Solved | None:
        """Return the orbit near another one; None if the iteration does not converge.

        Args:
            orbit, setting: to begin from.
            rows: conditions on changes: of all motions ``(k, N, N_b, 6)`` and of the unknown parameters ``(k, k)``.
            stress: section forces ``(N, e, points, 6)`` to begin from; those of the strains by default.
            fresh: linearise anew.
        """
        balance = self.balance
        if fresh or self.jacobian is None or not _same(rows, self.rows):
            known = None if stress is None or self.jacobian is None else Frozen(stress, self.jacobian.linear)
            self.linearise(orbit, balance.moved(orbit, setting, known), rows)
        renewed, last, least, floor = fresh, 0.0, np.inf, orbit_size(balance, orbit)
        for iteration in range(1, ITERATIONS + 1):
            assert self.jacobian is not None
            matrix, linear = self.jacobian.matrix, self.jacobian.linear
            motion = balance.moved(orbit, setting, None if stress is None else Frozen(stress, linear))
            right = np.concatenate([-matrix.right(motion.residual), np.zeros(len(self.unknown))])
            solution = matrix.solve(right)
            if not np.isfinite(solution).all():
                return None
            own, parameters = solution[: matrix.size], solution[matrix.size :]
            size = float(np.sqrt(matrix.weights @ own**2))
            if size > max(5.0 * floor, 1.0):
                return None
            change = matrix.increments(matrix.whole(own), motion.residual)
            orbit = balance.added(orbit, change)
            stress = balance.sections.carried(motion.points.section_force, linear, change, setting.omega)
            setting = moved_setting(setting, self.unknown, parameters)
            if not setting.omega > 0.0 or np.abs(orbit.X[..., 3:]).max() > TURNED:
                return None
            whole = orbit_size(balance, orbit)
            scales = [abs(getattr(setting, u)) + 1e-3 * setting.omega * (u == "lack") for u in self.unknown]
            small = np.abs(parameters) <= 1e-8 * np.array(scales)
            if size <= CONVERGED * whole + SMALLEST and small.all():
                motion = balance.moved(orbit, setting)
                beside, among = matrix.others(motion.residual)
                if beside > BALANCED * motion.size and not renewed:  # motions that were not driven before
                    self.linearise(orbit, motion, rows)
                    renewed = True
                elif (
                    among <= BALANCED * motion.size
                    or size <= ROUND_OFF * whole + SMALLEST
                    or SLOW * least < size <= STALLED * whole
                ):
                    return Solved(orbit, motion, iteration)
            if last > 0.0 and size > SLOW * last and iteration > 2:
                self.linearise(orbit, balance.moved(orbit, setting, Frozen(stress, linear)), rows)
                size = 0.0
            else:
                least = min(least, size)
            last = size
        return None

    def linearise(self, orbit: Orbit, motion: Motion, rows: tuple[Floats, Floats]) -> Jacobian:
        """Make and factorise the Jacobian at an orbit, with conditions as its last rows."""
        balance, setting = self.balance, motion.setting
        linear = balance.linearised(motion)
        groups = coupled_motions(balance, setting.omega, linear)
        columns = [self._slope(orbit, motion, name) for name in self.unknown]
        more = setting._replace(level=setting.level + 1.0)  # in a step without round-off
        forces = self.balance.moved(orbit, more, motion.frozen).residual - motion.residual
        driven = driven_motions(balance, groups, forces, orbit)
        matrix = OrbitMatrix(balance, setting.omega, linear, driven)
        wide = np.column_stack([matrix.right(column) for column in columns]) if columns else None
        self.rows = rows
        conditions = np.array([matrix.reduced(row) * matrix.weights for row in rows[0]])
        k = len(self.unknown)
        matrix.factorise(
            np.zeros((matrix.size, 0)) if wide is None else wide, conditions.reshape(k, matrix.size), rows[1]
        )
        self.jacobian = Jacobian(matrix, groups, linear)
        return self.jacobian

    def _slope(self, orbit: Orbit, motion: Motion, name: str) -> Floats:
        """Return the derivative of the balance by a parameter, by differences."""
        setting = motion.setting
        value = getattr(setting, name)
        step = (
            setting.omega if name == "lack" else 1e-6 * abs(value)
        )  # the balance is linear in what is lacking
        other = self.balance.moved(orbit, setting._replace(**{name: value + step}), motion.frozen)
        return np.asarray((other.residual - motion.residual) / step)


def driven_motions(
    balance: OrbitBalance, groups: Sequence[Integers], forces: Floats, orbit: Orbit
) -> Integers:
    """Return the motions of all groups on which forces act or which move."""
    largest = np.abs(forces).max(axis=0)
    unit = np.ones_like(largest)
    unit[: balance.problem.size, :3] = balance.problem.length
    acting = (largest * unit).ravel()
    moving = np.zeros_like(largest)
    moving[: balance.problem.size] = np.abs(orbit.X).max(axis=0) / unit[: balance.problem.size]
    swing = moving.ravel()
    least = DRIVEN * max(float(acting[group].max()) for group in groups)
    found = [
        group
        for group in groups
        if acting[group].max() > least or swing[group].max() > DRIVEN * max(swing.max(), 1e-300)
    ]
    return np.sort(np.concatenate(found or list(groups)))


def moved_setting(setting: Setting, unknown: Sequence[str], change: Floats) -> Setting:
    """Return a setting after changes of some of its parameters."""
    return setting._replace(
        **{n: getattr(setting, n) + float(c) for n, c in zip(unknown, change, strict=True)}
    )


def _same(one: tuple[Floats, Floats], other: tuple[Floats, Floats]) -> bool:
    return one[0] is other[0] and one[1] is other[1]

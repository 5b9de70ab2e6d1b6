"""What wrong frequencies make of a motion in time: vibrations on a coarse mesh run ahead of those on a finer one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.refinement.correction import Balance, corrected
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape
from viscorod.solve.refinement.inertial_forces import CoarseMotion
from viscorod.solve.refinement.start_modes import COUNT as FOLLOWED
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["AtRest", "PhaseDrift"]

COUNT = 12
"""Slowest vibrations that are compared before a motion."""
LEADING = 4
"""Of these, those that a mesh has to resolve before anything is known of the motion."""
ALIKE = 0.5
"""Part of a vibration, by its mass, that one on the finer mesh must hold to be the same."""
TWINS = 1e-3
"""Relative difference of frequencies below which shapes mix: of equal stiffness in two planes, or of two equal rods."""
UNLIKE = 0.2
"""Relative error of the frequency of a vibration that there is no other of on the finer mesh."""


@dataclass(frozen=True)
class AtRest:
    """A state at rest as the finer mesh has it, and the vibrations about it.

    Attributes:
        shape: the state on the coarse mesh; scale: multiple of the loads at t = 0 that act there.
        count: vibrations that were sought.
        state, modes: on the finer mesh; None if there is no such state.
        turns: unit quaternions of the finer stations where the coarse mesh has them ``(1, stations, 4)``.
    """

    shape: Shape
    scale: float
    count: int
    state: State | None
    modes: StartModes | None
    turns: Floats | None = None

    @classmethod
    def of(cls, finer: FinerMesh, shape: Shape, scale: float, count: int) -> AtRest:
        """Find the state and its vibrations."""
        own = replace(shape, state=shape.state.copy())
        if not count:
            return cls(own, scale, count, None, None)
        finer.system.prestress = np.zeros((0, 1, 6))
        carried = finer.carried([shape])
        state = corrected(Balance(finer, factor=scale), finer.take_over(carried))
        modes = None if state is None else StartModes.about(finer.static, state, scale, count)
        return cls(own, scale, count, state, modes, carried.q)

    def is_of(self, shape: Shape, scale: float, count: int) -> bool:
        """Return whether it is that of exactly this state."""

        def arrays(one: Shape) -> tuple[Floats, ...]:
            return one.state.r, one.state.q, one.state.multiplier, one.section_force, one.near

        pairs = zip(arrays(self.shape), arrays(shape), strict=True)
        return (self.scale, self.count) == (scale, count) and all(np.array_equal(a, b) for a, b in pairs)


class PhaseDrift:
    """Undamped vibrations about a state at rest, on a mesh and on the one twice as fine.

    Args:
        motion: motions as the finer mesh has them; static: solver of the coarse one; shape: the state on it; scale:
            multiple of the loads at t = 0 that act there; modes: of the coarse one about this state, if they are known.
        known: a state at rest on the finer mesh, which is taken if it is this one.

    Attributes:
        modes: on the coarse mesh; finer: state and modes on the finer one.
    """

    def __init__(
        self,
        motion: CoarseMotion,
        static: StaticSolver,
        shape: Shape,
        scale: float,
        modes: StartModes | None = None,
        known: AtRest | None = None,
    ) -> None:
        self.problem, self.state, self._motion = motion.problem, shape.state, motion
        self.modes = modes or StartModes.about(static, shape.state, scale, COUNT)
        count = min(len(self.modes.omega), FOLLOWED)
        if known is None or not known.is_of(shape, scale, count):
            known = AtRest.of(motion.finer, shape, scale, count)
        self.finer = known

    @property
    def leading(self) -> float:
        """The largest relative error of the slowest frequencies."""
        return float(self.errors[:LEADING].max(initial=0.0))

    @cached_property
    def errors(self) -> Floats:
        """How much faster vibrations are on the coarse mesh than on the finer one, in parts ``(k,)``.

        The same vibration is that whose shape is most alike; where none is, the error is taken as large.
        """
        modes, better = self.modes, self.finer.modes
        if better is None or not len(better.omega):
            return np.zeros(len(modes.omega))
        shapes = modes.shapes.T.reshape(len(modes.omega), -1, 6)
        momenta = self._motion.inertia(self.state.r, self.state.q, shapes, self.finer.turns)
        momenta = momenta.reshape(len(modes.omega), -1)
        alike = np.square(momenta @ better.shapes)
        best = better.omega[alike.argmax(axis=1)]
        alike[np.abs(better.omega / best[:, None] - 1.0) > TWINS] = 0.0
        whole = alike.sum(axis=1)
        apart = np.abs(modes.omega / (alike @ better.omega / np.maximum(whole, np.finfo(float).tiny)) - 1.0)
        return np.asarray(np.where(whole > ALIKE, apart, np.maximum(apart, UNLIKE)))

    def gaps(
        self, times: Sequence[float], rates: Floats, kicks: Sequence[Floats | float] = (0.0,)
    ) -> list[dict[str, float]]:
        """Return how far each rod has drifted from where it is on the finer mesh at most [m].

        The amplitude of a vibration is that of its acceleration over the square of its frequency: a fast one that only
        follows slower ones, without a phase of its own, has little of it. What a jump of the loads or a velocity has
        set off at the start lasts until it has faded, though steps that are large for it may hide it.

        Args:
            times: of some states of the motion [s]; rates: of the twists of all nodes there ``(times, n, 6)``.
            kicks: amplitudes of the vibrations that the start sets off ``(k,)``, see :meth:`kicked`; each is another
                question.

        Returns:
            the gaps of all rods, for each of ``kicks``.
        """
        omega, decay, shapes = self.modes.omega, self.modes.decay, self.modes.shapes
        names, stations = self.problem.rods, self.problem.stations
        if not len(omega):
            return [dict.fromkeys(names, 0.0)] * len(kicks)
        lengths = np.linalg.norm(shapes.reshape(self.problem.size, 6, -1)[:, :3], axis=1)
        reach = np.maximum.reduceat(lengths[stations.nodes], self._motion.finer.halves.rod_stations, axis=0)
        t = np.array(times)[:, None]
        amplitudes = np.abs(rates.reshape(len(rates), -1) @ self._momenta.T) / omega**2
        for before, amplitude in pairwise(amplitudes):
            # where acceleration passes zero, the amplitude of neighbours in time counts
            np.maximum(0.5 * before, amplitude, out=amplitude)
        # what has faded has left no phase, and overdamped vibrations creep alike, whatever their frequency
        lasted = t / np.maximum(decay * t, 1.0) / np.maximum(decay / omega, 1.0)
        ahead = reach * np.minimum(self.errors * omega * lasted, 2.0)[:, None]
        found = []
        for kick in kicks:
            gaps = np.linalg.norm(np.maximum(amplitudes, kick)[:, None] * ahead, axis=2).max(axis=0)
            found.append(dict(zip(names, gaps.tolist(), strict=True)))
        return found

    def kicked(self, twist: Floats, rate: Floats) -> Floats:
        """Return the amplitudes of the vibrations ``(k,)`` that nodes with these twists and rates ``(n, 6)`` begin."""
        omega = self.modes.omega
        return np.hypot(self._momenta @ twist.ravel() / omega, self._momenta @ rate.ravel() / omega**2)

    @cached_property
    def _momenta(self) -> Floats:
        shapes, mass = self.modes.shapes.reshape(self.problem.size, 6, -1), self.problem.mass
        return np.asarray((np.swapaxes(mass, 1, 2) @ shapes).reshape(len(self.modes.shapes), -1).T)

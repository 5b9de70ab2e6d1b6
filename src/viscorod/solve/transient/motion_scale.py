"""What a step may err by: a given tolerance, or a part of the motion that there is.

A vibration of angular frequency ``w`` that Radau IIA follows with steps ``h`` loses ``(w h)^6/7200`` of its amplitude
per step, that is 1 % in 20 periods at 7 steps per period, where the estimated error of a step is 0.0028 of the
amplitude. Modes that take a smaller part in the motion last longer in their own periods, so that less is allowed:
``amplitude.PART_OF_MOTION`` keeps the motion of an undamped bar under a sudden force, with all its modes, to 0.7 %
over 20 periods of the first.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from viscorod.errors import SolveError
from viscorod.mechanics.nodes.carried_motion import Carrier, carry_along
from viscorod.mechanics.rotations.rotation import motion_extent
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.undamped import resolved_modes
from viscorod.solve.modes.vibrations import Linearisation, natural_frequencies
from viscorod.solve.transient import amplitude
from viscorod.typing import Floats

PER_RUN = 2.0
"""Angular frequency over one by the duration, below which a motion is one from here to there, and no vibration."""


class Tolerance(Protocol):
    """What a step may err by: displacement over the size of the model, or rotation in rad."""

    @property
    def value(self) -> float:
        """What is allowed at present, before a step is tried."""

    def begin(self, t: float, state: State, force: Floats) -> None:
        """Start at ``t`` [s] from a state in which ``force (n, 6)`` accelerates the nodes, body components."""

    def at(self, t: float, state: State) -> float:
        """Return what is allowed of a step that was tried and ends at ``t`` [s] in ``state``."""

    def accept(self, t: float, state: State) -> None:
        """Take the state at ``t`` [s] as one of the motion."""


class GivenTolerance:
    """The same for all steps."""

    def __init__(self, value: float) -> None:
        self.value = value

    def begin(self, t: float, state: State, force: Floats) -> None:
        """See :class:`Tolerance`."""

    def at(self, t: float, state: State) -> float:
        """See :class:`Tolerance`."""
        del t, state
        return self.value

    def accept(self, t: float, state: State) -> None:
        """See :class:`Tolerance`."""


class PartOfMotion:
    """A part of the amplitude of the motion so far.

    The amplitude is half of the largest displacement (or rotation) from the start, relative to a support that moves,
    or, if that is less, the largest velocity over the slowest natural frequency: what a slow load has bent does not
    vibrate. It is not known when a motion begins: until the motion has had the time to unfold, it is what a linear
    vibration would have that starts so, with these forces out of balance and with these velocities.

    Args:
        supports: those that move carry the rest along.
        linear: small motions about the start, if there are any.
        duration: of the run [s].

    Attributes:
        numbers: see ``amplitude``; start: where the motion began, once it has.
        carrier: the support that moves, or turns, and so carries the model along; the first of them if there are
            several, None if there is none.
    """

    def __init__(self, supports: SupportState, linear: Linearisation | None, duration: float) -> None:
        self.numbers = np.zeros(amplitude.COUNT)
        self.numbers[amplitude.LENGTH] = supports.problem.length
        self.start: State | None = None
        self.carrier = _carrier_of(supports)
        self._respond = None
        if linear is not None:
            self._respond, self.numbers[amplitude.SLOWEST] = _response(supports, linear, PER_RUN / duration)

    @property
    def value(self) -> float:
        """See :class:`Tolerance`."""
        return float(amplitude.allowed_now(self.numbers))

    def begin(self, t: float, state: State, force: Floats) -> None:
        """See :class:`Tolerance`."""
        if self.start is None:
            self.start = state.copy()
        numbers = self.numbers
        numbers[amplitude.EXPECTED] = 0.0
        if self._respond is not None:
            _, _, twist = self._relative(state)
            numbers[amplitude.EXPECTED], time = self._respond(force, twist)
            numbers[amplitude.UNTIL] = t + time

    def at(self, t: float, state: State) -> float:
        """See :class:`Tolerance`."""
        if amplitude.is_usual(self.numbers, float(t)):
            return amplitude.USUAL
        return float(amplitude.allowed_after(self.numbers, float(t), *self._extent(state)))

    def accept(self, t: float, state: State) -> None:
        """See :class:`Tolerance`."""
        moved, speed = self._extent(state) if amplitude.still_grows(self.numbers) else (0.0, 0.0)
        amplitude.take_extent(self.numbers, float(t), moved, speed)

    def _extent(self, state: State) -> tuple[float, float]:
        """Return how far ``state`` is from the start, and how fast it is."""
        r, q, twist = self._relative(state)
        return motion_extent(r, q, state.r, state.q, twist, float(self.numbers[amplitude.LENGTH]))

    def _relative(self, state: State) -> tuple[Floats, Floats, Floats]:
        """Return poses that count as no motion at the time of ``state``, and its body twists beside theirs."""
        start = self.start
        assert start is not None
        if self.carrier is None:
            return start.r, start.q, state.twist
        found = np.empty_like(start.r), np.empty_like(start.q), np.empty_like(start.twist)
        carry_along(self.carrier, start.r, start.q, state.r, state.q, state.twist, *found)
        return found


def _carrier_of(supports: SupportState) -> Carrier | None:
    """Return the node of the first support that moves; of those that hold it completely, if there are any."""
    moving: dict[int, list[int]] = {}
    for k, component, _ in supports.set.motions:
        moving.setdefault(k, []).append(component)
    for k in supports.complete:
        if int(k) in moving:
            return Carrier(int(supports.set.nodes[k]), 1, np.eye(3))
    for k, components in moving.items():
        axes = supports.set.axes[k][[c for c in components if c < 3]]
        if len(axes) and axes.any():
            return Carrier(int(supports.set.nodes[k]), 0, axes.T @ axes)
    return None


def _size(increments: Floats, length: float) -> float:
    """Return the largest of increments ``(n, 6)``: displacement over length, rotation."""
    squares = np.square(increments)
    return float(np.sqrt(max(squares[:, :3].sum(axis=1).max() / length**2, squares[:, 3:].sum(axis=1).max())))


def _response(
    supports: SupportState, linear: Linearisation, least: float
) -> tuple[Callable[[Floats, Floats], tuple[float, float]] | None, float]:
    """Return what estimates the vibration that begins, and the slowest natural frequency [rad/s], 0 of free motions.

    The former returns, for forces out of balance and twists ``(n, 6)``, the amplitude of the linear vibration and the
    time [s] that it takes to unfold, half a period. ``least`` [rad/s] is added as a frequency, so that free motions
    have a response too.
    """
    M, basis, length = linear.mass, linear.basis, supports.problem.length
    try:
        solve = _solver(linear, least)
        slowest = float(natural_frequencies(linear, 1)[0]) if M.shape[0] else 0.0
    except SolveError:
        return None, 0.0

    mass = supports.problem.mass

    def expected(force: Floats, twist: Floats) -> tuple[float, float]:
        size, time = 0.0, 0.0
        pushed = np.asarray(basis.T @ force.ravel())
        if pushed.any():
            y = solve(pushed)
            size = _size((basis @ y).reshape(-1, 6), length)
            time = math.pi * math.sqrt(abs(float(y @ (M @ y)) / float(pushed @ y)))
        speed = _size(twist, length)
        if speed > 0.0:
            momentum = np.einsum("nij,nj->ni", mass, twist)
            reach = _size((basis @ solve(np.asarray(basis.T @ momentum.ravel()))).reshape(-1, 6), length)
            size = math.hypot(size, math.sqrt(speed * reach))
            time = max(time, math.pi * math.sqrt(reach / speed))
        return (size, time) if math.isfinite(size + time) else (0.0, 0.0)

    return expected, slowest


def _solver(linear: Linearisation, least: float) -> Callable[[Floats], Floats]:
    """Return what solves ``(K + least^2 M) y = b``: by all modes where full matrices tell them, else by factors.

    Raises:
        SolveError: it is singular.
    """
    modes = resolved_modes(linear)
    if modes is None:
        return linear.solver(linear.stiffness + least**2 * linear.mass)
    inverse_squares, shapes = modes
    shares = 1.0 / (1.0 + least**2 * inverse_squares)
    return lambda b: np.asarray(shapes @ (shares * (b @ shapes)))

"""What the transient analysis asks of a time integrator."""

from __future__ import annotations

from typing import Protocol

from viscorod.solve.newton import NewtonReport
from viscorod.solve.system import State


class Integrator(Protocol):
    """Advances a :class:`~viscorod.solve.system.System` in time.

    1. ``start(t, state)`` takes over a state, with the velocities of supports just after ``t``; it is called at
    the beginning
       and after every instant at which a load or a prescribed motion jumps.
    2. ``step(end)`` tries one step from ``t`` to ``end``. When it converges, ``t`` and ``state`` have moved and
    system and
       supports hold the forces and reactions there; otherwise nothing has changed.
    3. ``kinetic`` is the kinetic energy [J] at ``t``.
    """

    t: float
    state: State
    kinetic: float

    def start(self, t: float, state: State) -> None:
        """Begin at time ``t`` [s] from ``state``."""

    def step(self, end: float, *, before: bool) -> NewtonReport:
        """Try one step to the time ``end`` [s]; ``before`` takes loads there as limits from the left."""

"""The energy account of a motion: at the ends of its steps, and within them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from viscorod.typing import Floats

NO_LOSS: Floats = np.zeros(0)
"""What no Maxwell branches dissipate [J]."""


class Progressing(Protocol):
    """Energies of an integrator after a step, for the energy account."""

    kinetic: float
    elastic: float
    work: float
    loss: float
    outside: float
    actuator: float

    @property
    def branch_loss(self) -> Floats:
        """Energy dissipated by each Maxwell branch ``(n,)`` [J], part of ``loss``."""


class StepShare(NamedTuple):
    """What happened up to ``k`` parts of a step ``(k,)`` [J].

    Work, viscous loss, loss of loads outside, work of rest strains; what each Maxwell branch lost ``(k, n)``.
    """

    work: Floats
    loss: Floats
    outside: Floats
    actuator: Floats
    branches: Floats


@dataclass
class EnergyAccount:
    """Energies so far [J].

    ``outside`` is what loads dissipated; ``actuator`` the work of what changes rest strains; ``numerical`` closes the
    balance;
    ``branches`` are dissipated by each Maxwell branch, parts of ``viscous``.
    """

    kinetic: float = 0.0
    elastic: float = 0.0
    viscous: float = 0.0
    external: float = 0.0
    start: float = 0.0
    outside: float = 0.0
    actuator: float = 0.0
    branches: Floats = field(default_factory=lambda: NO_LOSS)

    @property
    def numerical(self) -> float:
        """T + W + D - P - (T + W)_0: energy that the time integration produced (negative: lost)."""
        given = self.external + self.actuator + self.start
        return self.kinetic + self.elastic + self.viscous + self.outside - given

    def copy(self) -> EnergyAccount:
        """Return an independent copy."""
        copied = EnergyAccount.__new__(EnergyAccount)
        vars(copied).update(vars(self))
        return copied

    def add(self, step: Progressing) -> None:
        """Add a step."""
        self.kinetic, self.elastic = step.kinetic, step.elastic
        self.external += step.work
        self.viscous += step.loss
        self.outside += step.outside
        self.actuator += step.actuator
        if len(self.branches):
            self.branches = self.branches + step.branch_loss

    @property
    def recorded(self) -> tuple[float, ...]:
        """Everything but the branches, as histories keep it."""
        return (
            self.kinetic,
            self.elastic,
            self.viscous,
            self.external,
            self.numerical,
            self.outside,
            self.actuator,
        )


class EnergiesWithin(NamedTuple):
    """What the energies at ``k`` places of a step are made of.

    Attributes:
        before, end: the account at both ends of the step.
        parts: places ``(k,)``, 0 to 1; kinetic: energies there ``(k,)`` [J].
        step: what happened up to there.
    """

    before: EnergyAccount
    end: EnergyAccount
    parts: Floats
    kinetic: Floats
    step: StepShare

    @staticmethod
    def rows(steps: Sequence[EnergiesWithin]) -> Floats:
        """Return the energies ``(k, 7)`` in all of some steps, in the order of :attr:`EnergyAccount.recorded`.

        The remainder is known at the ends of steps only, and linear between; the elastic energy is what the balance
        leaves.
        """
        counts = [len(step.parts) for step in steps]
        before = np.repeat(
            np.array([(*step.before.recorded, step.before.start) for step in steps]), counts, 0
        )
        last = np.repeat([step.end.numerical for step in steps], counts)
        parts, kinetic = (np.concatenate([step[k] for step in steps]) for k in (2, 3))
        shares = tuple(np.concatenate([step.step[k] for step in steps]) for k in range(4))
        return energies_within(before, last, parts, kinetic, shares)


def energies_within(
    before: Floats, last: Floats, parts: Floats, kinetic: Floats, shares: tuple[Floats, ...]
) -> Floats:
    """Return the energies ``(k, 7)`` at ``parts (k,)`` of steps, see :meth:`EnergiesWithin.rows`.

    Args:
        before: what is recorded at the start of each step, and the energy at the start of the motion ``(k, 8)`` [J].
        last: remainder at its end ``(k,)``; kinetic: energies; shares: as in :class:`StepShare`, without branches.
    """
    _, _, lost, work, first, out, moved, start = before.T
    external, viscous, outside, actuator = (
        sum_ + share for sum_, share in zip((work, lost, out, moved), shares, strict=True)
    )
    remainder = (1.0 - parts) * first + parts * last
    given = external + actuator + start
    elastic = np.maximum(remainder - (kinetic + viscous + outside - given), 0.0)
    numerical = kinetic + elastic + viscous + outside - given
    return np.array([kinetic, elastic, viscous, external, numerical, outside, actuator]).T


class EnergiesKnown(NamedTuple):
    """Energies at ``k`` instants: rows ``(k, 7)`` as in :attr:`EnergyAccount.recorded`, and of branches ``(k, n)``."""

    rows: Floats
    branches: Floats

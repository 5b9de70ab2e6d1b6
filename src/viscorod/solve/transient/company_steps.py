"""Models that take the same steps side by side: each step of each in one compiled call, where they need none of Python.

What their predictions lack goes from one to the next as in single steps (see ``integrators.company``), and so do the
numbers, bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators import loop_data
from viscorod.solve.transient.integrators.company import LEFT, Company, predicted_rows
from viscorod.solve.transient.integrators.loop_company import Guided, take_guided
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.many_steps import ManySteps
from viscorod.solve.transient.step_choice import CORNER
from viscorod.solve.transient.step_control import ErrorControl
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.solve.transient.given_steps import Retraced

__all__ = ["CompanySteps", "compile_guided"]

WORTH = 200
"""Steps of all models of a process from which on machine code is loaded from disk."""
AT_ONCE = 64
"""Steps whose records are taken from the arrays of the loops at once."""


class CompanySteps:
    """The compiled steps of models of one company.

    Args:
        company: of all; motions: the leader's first; duration: of them [s].
        ends: of their steps [s]; times: that are recorded [s], all in ascending order.
    """

    _count: ClassVar[int] = 0  # of steps of all models so far

    def __init__(
        self, company: Company, motions: Sequence[Retraced], duration: float, ends: Floats, times: Floats
    ) -> None:
        self._company, self._motions, self._ends, self._times = company, motions, ends, times
        self._due = due_records(ends, times)
        company.lend()
        self._members = [_Member(one, duration, leads=one is motions[0]) for one in motions]

    @classmethod
    def of(
        cls, company: Company, motions: Sequence[Retraced], duration: float, ends: Floats, times: Floats
    ) -> CompanySteps | None:
        """Return what takes compiled steps; None if anything needs Python, or machine code is not at hand."""
        kernel = KnownTypes(take_guided)
        cls._count += len(ends) * len(motions)
        if PURE_PYTHON or not (kernel.loaded or (cls._count >= WORTH and kernel.kept)):
            return None
        if not all(type(one.integrator) is Radau and ManySteps.serves(one.integrator) for one in motions):
            return None
        found = cls(company, motions, duration, ends, times)
        most = int(np.diff(found._due, axis=0).max(initial=0))
        return found if most <= found._members[0].rows else None

    @property
    def ready(self) -> bool:
        """Whether steps can be taken: not with factors of another plan."""
        return all(one.many.ready for one in self._members)

    def go(self, corner: float) -> Sequence[Retraced]:
        """Take steps up to a ``corner`` [s], or until one is Python's.

        Returns:
            motions that take the next step by themselves, some of one or all; none if the corner is reached. One that
            does not go on at all has that as its outcome.
        """
        ends, members = self._ends, self._members
        at = int(np.searchsorted(ends, members[0].motion.integrator.t, side="right"))
        last = int(np.searchsorted(ends, corner, side="right"))
        for one in members:
            one.begin(corner, up_to_date=self._company.up_to_date(one.integrator))
        stuck: int | None = None
        while at < last and stuck is None:
            until = self._until(at, last)
            instants = self._times[self._due[0, at] : self._due[1, until - 1]]
            for one in members:
                one.instants[: len(instants)] = instants
            while at < until and stuck is None:
                stuck = self._take(at)
                at += 1
            for one in members:
                one.record()
        renewed = members[0].renewed
        up_to_date = [one.integrator for one in members if one.seen == renewed]
        for one in members:
            one.many.hand_back()
        self._company.take_back(up_to_date)
        return () if stuck is None else self._motions[stuck:]

    def _until(self, first: int, last: int) -> int:
        """Return up to which step records fit into the arrays of the loops."""
        fit = int(np.searchsorted(self._due[1], self._due[0, first] + self._members[0].rows, side="right"))
        return min(last, first + AT_ONCE, fit)

    def _take(self, k: int) -> int | None:
        """Take a step with all members; return the place of one that cannot, None if all could."""
        company, leader = self._company, self._members[0]
        end, records = float(self._ends[k]), int(self._due[1, k] - self._due[0, k])
        company.forget()
        for place, one in enumerate(self._members):
            if one is leader:
                one.have_jacobian(one.have and not one.linked)
            else:
                company.expect(one.integrator, one.guided.lack)
                one.have_jacobian(company.shares or one.seen == leader.renewed)
            if not one.take(end, records):
                return place
            one.seen = leader.renewed
            company.learn(one.integrator, one.guided.lacked.copy())
        return None


def due_records(ends: Floats, times: Floats) -> Integers:
    """Return where among some ``times`` those begin and end that are within each step ``(2, steps)``."""
    starts = np.append(0.0, ends[:-1])
    slack = 1e-9 * (ends - starts)
    return np.searchsorted(times, [starts + slack, ends + slack], side="right")


def compile_guided(many: ManySteps) -> None:
    """Compile the steps of a company for models like that of a loop."""
    guided = Guided.of(predicted_rows(many.integrator))
    KnownTypes(take_guided).compiled((Shared(many.loop).argument, Shared(guided).argument, 0.0, 0))


class _Member:
    """One of the models.

    Attributes:
        many: its loop; guided: what its steps are told; instants: of records [s], of which there are most ``rows``.
        linked: it has joints or held strains; seen: how many Jacobians the leader had when this one had its own.
    """

    def __init__(self, motion: Retraced, duration: float, *, leads: bool) -> None:
        integrator = motion.integrator
        assert isinstance(integrator, Radau)
        self.motion, self.integrator, self._leads = motion, integrator, leads
        self.linked = integrator.stage_constraints is not None
        control = ErrorControl(integrator.estimate_order, duration, duration)
        self.many = ManySteps(integrator, control, duration, None)
        self._numbers, self.instants = self.many.loop.numbers, self.many.loop.batch.instants
        self.rows, self.seen = len(self.instants), -1
        self.guided = Guided.of(predicted_rows(integrator))
        self._told, self._kernel = Shared(self.guided), KnownTypes(take_guided)
        self._arguments: tuple[Any, ...] = ()

    def begin(self, corner: float, *, up_to_date: bool) -> None:
        """Hand the present state over, for steps up to a ``corner`` [s]; whether its Jacobian is the leader's age."""
        self.integrator.newton_tolerance = LEFT
        self.many.hand_over(self.motion.account)
        self._arguments = self.many.addressed().argument, self._told.argument
        self.many.control.numbers[CORNER] = corner
        self._numbers[loop_data.LENT] = not self._leads
        self.seen = self.renewed if up_to_date else -1

    @property
    def renewed(self) -> int:
        """How many Jacobians it had since :meth:`begin`."""
        return int(self._numbers[loop_data.RENEWED])

    @property
    def have(self) -> bool:
        """Whether it has a Jacobian."""
        return bool(self._numbers[loop_data.HAVE])

    def have_jacobian(self, have: bool) -> None:
        """Set whether it has a Jacobian that serves."""
        self._numbers[loop_data.HAVE] = have

    def take(self, end: float, records: int) -> bool:
        """Take a step to ``end`` [s] with so many records; return whether it did."""
        why = self._kernel.call(*self._arguments, end, records)
        self.many.check()
        if why == loop_data.BROKEN:
            self.motion.result.outcome = Outcome.BROKEN
        return bool(why == loop_data.GOES_ON)

    def record(self) -> None:
        """Record what was due of the steps taken, and make room for others."""
        motion, numbers, batch = self.motion, self._numbers, self.many.loop.batch
        steps, account = int(numbers[loop_data.STEPS]), motion.account.copy()
        if not steps:
            return
        records = self.many.records(motion.account)
        self.many.bring(account)
        motion.account = account
        if records is not None:
            motion.result.history.extend(*records)
        batch.accounts[0], batch.lost[0] = batch.accounts[steps], batch.lost[steps]
        numbers[loop_data.STEPS] = numbers[loop_data.ROWS] = numbers[loop_data.ITERATED] = 0

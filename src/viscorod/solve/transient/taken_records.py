"""What comes of many steps in one compiled call: their records, states at marks, steps that were tried again."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.energy_account import EnergiesKnown, EnergyAccount, energies_within
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Records, Snapshot, Snapshots
from viscorod.solve.transient.integrators import loop_data
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.tried_steps import Reached, TriedStep
from viscorod.typing import Floats

__all__ = ["Taken", "TakenRecords"]


class Taken(NamedTuple):
    """Steps that were taken.

    Attributes:
        broken: strains are out of bounds after one more.
        starts, ends, lengths: of the steps [s]; iterations, limits, unknowns: of each.
        iterated, rejected: iterations of all attempts, and attempts that were rejected.
    """

    broken: bool
    starts: list[float]
    ends: list[float]
    lengths: list[float]
    iterations: list[int]
    limits: list[int]
    unknowns: list[int]
    iterated: int
    rejected: int


class TakenRecords:
    """What the compiled loop of one motion leaves in its arrays.

    Args:
        integrator: that the loop goes on for; loop: its arrays.
    """

    def __init__(self, integrator: Radau, loop: loop_data.StepLoop) -> None:
        self.integrator, self.loop = integrator, loop

    def marked(self, taken: Taken, marks: list[int]) -> list[tuple[int, Callable[[], Snapshot]]]:
        """Return the marks among the steps taken, with what returns the state there."""
        rows = len(self.loop.batch.states.r) - loop_data.EXTRA_ROWS

        def state(k: int) -> Snapshot:
            return self._states(slice(rows + k, rows + k + 1)).at(0)

        return [(mark, partial(state, k)) for k, mark in enumerate(marks) if mark <= len(taken.ends)]

    def tried(self) -> dict[int, TriedStep]:
        """Return the steps that were tried again, and whose halves came to their ends, by their numbers from 0."""
        batch, found = self.loop.batch, {}
        first = len(batch.states.r) - loop_data.EXTRA_ROWS + loop_data.MARKS
        for number, end, h, complete in batch.trials[: self.loop.numbers[loop_data.TRIED]].tolist():
            if complete:
                start, *others = self._reached(slice(first, first + loop_data.TRIAL_ROWS))
                found[int(number)] = TriedStep(end, h, start.state.twist, *others)
            first += loop_data.TRIAL_ROWS
        return found

    def _reached(self, rows: slice) -> list[Reached]:
        """Return the states in some rows, and their section forces, in arrays of their own."""
        found = self.loop.batch.states
        fields = found.r, found.q, found.twist, found.fields.points[2]
        copies = zip(*(field[rows].copy() for field in fields), self._multipliers(rows), strict=True)
        return [Reached(State(r, q, twist, multiplier), force) for r, q, twist, force, multiplier in copies]

    def _multipliers(self, rows: slice) -> list[Floats]:
        """Return the multipliers of the states in some rows, which may share an array where there are none."""
        if self.integrator.stage_constraints is None:
            return [self.integrator.state.multiplier] * len(self.loop.batch.states.r[rows])
        return list(self.loop.links.rows.multiplier[rows].copy())

    def _joints(self, rows: slice) -> JointState | None:
        """Return the joints in the states in some rows."""
        if self.integrator.stage_constraints is None:
            return None
        kept = self.loop.links.rows
        return JointState(kept.value[rows].copy(), kept.rate[rows].copy(), kept.force[rows].copy())

    def bring(self, account: EnergyAccount) -> None:
        """Bring the energy account to the end of the steps taken."""
        steps = int(self.loop.numbers[loop_data.STEPS])
        found = self.loop.batch.accounts[steps].tolist()
        account.kinetic, account.elastic, account.viscous, account.external, account.outside = found
        account.branches = self.loop.batch.lost[steps].copy()

    def records(self, account: EnergyAccount) -> tuple[list[float], Records, list[float], list[int]] | None:
        """Return instants, records, lengths of their steps [s] and iterations of the steps taken, if there are any.

        Args:
            account: before the first of them.
        """
        batch, rows = self.loop.batch, int(self.loop.numbers[loop_data.ROWS])
        if not rows:
            return None
        of_step, places = batch.of_step[:rows], batch.places[:rows]
        states = self._states(slice(rows))
        kinetic, work, loss, outside, _ = batch.states.energies[:, :rows]
        steps = int(self.loop.numbers[loop_data.STEPS])
        accounts = np.zeros((steps + 1, 8))
        accounts[:, :4], accounts[:, 5] = batch.accounts[: steps + 1, :4], batch.accounts[: steps + 1, 4]
        accounts[:, 6:] = account.actuator, account.start
        moving, bent, lost, given, _, out, moved, start = accounts.T
        accounts[:, 4] = moving + bent + lost + out - (given + moved + start)
        nothing = np.zeros(rows)
        last = accounts[of_step + 1, 4]
        energies = energies_within(accounts[of_step], last, places, kinetic, (work, loss, outside, nothing))
        ended = places == 1.0
        energies[ended] = accounts[of_step[ended] + 1, :7]
        branches = batch.lost[of_step] + batch.branches.loss[:rows]
        branches[ended] = batch.lost[of_step[ended] + 1]
        return (
            batch.instants[:rows].tolist(),
            Records(states, EnergiesKnown(energies, branches)),
            batch.lengths[of_step].tolist(),
            batch.notes[0, of_step].tolist(),
        )

    def _states(self, rows: slice) -> Snapshots:
        """Return the states in some rows, in arrays of their own."""
        found = self.loop.batch.states
        strain, rate, force = found.fields.points[:, rows].copy()
        kinetic, *_, elastic = found.energies[:, rows].copy()
        branches, power, spring = self.loop.batch.branches, None, None
        if self.integrator.dashpots is not None:
            power, spring = branches.power[rows].copy(), branches.strain[rows].copy()
        return Snapshots(
            found.r[rows].copy(),
            found.q[rows].copy(),
            found.twist[rows].copy(),
            self._multipliers(rows),
            strain,
            rate,
            force,
            found.fields.reactions[rows].copy(),
            kinetic,
            elastic,
            self._joints(rows),
            power,
            spring,
        )

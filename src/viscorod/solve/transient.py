"""Transient analysis: steps an integrator through time, halves steps that fail, keeps the energy account."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from viscorod.errors import InputError
from viscorod.solve.history import EnergyAccount, History, StationReader
from viscorod.solve.integrators import Integrator
from viscorod.solve.newton import NewtonReport, Outcome
from viscorod.solve.problem import Problem
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System

HALVINGS = 12
RECOVERY = 8


@dataclass
class TransientResult:
    """History of a transient run and how it ended.

    Attributes:
        outcome: COMPLETED or the reason of the last failed step, which happened at ``failed_at`` [s].
        notes: one line per instant at which the step had to be halved.
        reason: why an INTERRUPTED run stopped.
    """

    history: History = field(default_factory=History)
    outcome: Outcome = Outcome.COMPLETED
    failed_at: float = 0.0
    report: NewtonReport | None = None
    steps: int = 0
    rejected: int = 0
    iterations: int = 0
    notes: list[str] = field(default_factory=list)
    reason: str = ""


class Transient:
    """Runs an integrator over a time span.

    Steps are equal between the instants at which loads or prescribed motions are not smooth; those are always hit, and
    after a jump the integrator starts anew, so that no load is ever averaged over a jump.
    """

    def __init__(
        self, problem: Problem, system: System, supports: SupportState, integrator: Integrator
    ) -> None:
        self.problem = problem
        self.system = system
        self.supports = supports
        self.integrator = integrator
        self.account = EnergyAccount()
        self._power = 0.0

    def run(
        self,
        state: State,
        duration: float,
        time_step: float,
        *,
        output_interval: float | None = None,
        progress: Callable[[float, float], None] | None = None,
    ) -> TransientResult:
        """Integrate from ``state`` at t = 0 to ``duration`` [s].

        Args:
            state: initial poses and twists (overwritten).
            time_step: largest step [s].
            output_interval: time between records [s], whose multiples steps hit; None records every step.
            progress: called with (time, step) after every step.
        """
        result = TransientResult()
        try:
            self._march(result, state, duration, time_step, output_interval, progress)
        except KeyboardInterrupt:
            result.outcome, result.reason = Outcome.INTERRUPTED, "interrupted from the keyboard"
        except InputError as error:
            if not result.history.instant:
                raise
            result.outcome, result.reason = Outcome.INTERRUPTED, str(error)
        return result

    def _march(
        self,
        result: TransientResult,
        state: State,
        duration: float,
        time_step: float,
        output_interval: float | None,
        progress: Callable[[float, float], None] | None,
    ) -> None:
        reader = StationReader(self.problem)
        integrator, account = self.integrator, self.account
        self._begin(0.0, state)
        account.kinetic = integrator.kinetic
        account.elastic = self.system.elastic_energy()
        self.system.viscous_loss(0.0)
        account.start = account.kinetic + account.elastic

        def record(h: float, iterations: int) -> None:
            result.history.record(
                integrator.t, reader, integrator.state, self.system, self.supports, account, h, iterations
            )

        record(0.0, 0)
        corners, jumps = self._corners(duration, output_interval)
        next_output = output_interval or 0.0
        begin = 0.0
        for corner in corners:
            count = max(1, int(np.ceil((corner - begin) / time_step * (1.0 - 1e-9))))
            full = (corner - begin) / count
            level, easy = 0, 0
            done, whole = 0, 0  # completed full steps, and parts of 2^-HALVINGS of the present one
            parts = 2**HALVINGS
            while done < count:
                size = parts >> level
                h = full * size / parts
                last = done + 1 == count and whole + size == parts
                target = corner if last else begin + full * (done + (whole + size) / parts)
                report = integrator.step(target, before=last)
                result.iterations += report.iterations
                result.report = report
                if not report.converged:
                    result.rejected += 1
                    if level == HALVINGS or (report.outcome is Outcome.NOT_FINITE and level > 4):
                        result.outcome, result.failed_at = report.outcome, target
                        return
                    if level == 0:
                        result.notes.append(f"t = {integrator.t:.6g} s: step of {h:.3g} s halved")
                    level, easy = level + 1, 0
                    continue
                result.steps += 1
                self._account(h)
                whole += size
                if whole == parts:
                    done, whole = done + 1, 0
                easy += 1
                if level and easy >= RECOVERY and whole % (2 * size) == 0:
                    level, easy = level - 1, 0
                if progress is not None:
                    progress(integrator.t, h)
                if output_interval is None or integrator.t >= next_output - 1e-9 * time_step or last:
                    record(h, report.iterations)
                    if output_interval is not None:
                        next_output = output_interval * (np.floor(integrator.t / output_interval + 1e-9) + 1)
            begin = corner
            if corner in jumps:
                self._begin(corner, integrator.state)

    def _corners(self, duration: float, output_interval: float | None) -> tuple[list[float], set[float]]:
        """Instants that steps must hit, and those among them after which the integrator starts anew.

        Instants that only rounding keeps apart are one; the later stands for both.
        """
        corners: list[float] = []
        jumps: set[float] = set()
        instants = {t for t in self.problem.breakpoints if 0.0 < t < duration}
        if output_interval is not None:
            instants.update(output_interval * k for k in range(1, int(duration / output_interval) + 1))
        for t in [*sorted(t for t in instants if t < duration), duration]:
            jumped = t in self.problem.jumps and t < duration
            if corners and t - corners[-1] < 1e-12 * duration:
                jumped = jumped or corners[-1] in jumps
                corners.pop()
            corners.append(t)
            if jumped:
                jumps.add(t)
        return corners, jumps

    def _begin(self, t: float, state: State) -> None:
        """Start or restart the integrator; the impulse of a support whose velocity jumps counts as external work."""
        before = self.integrator.kinetic
        self.integrator.start(t, state)
        if t > 0.0:
            self.account.external += self.integrator.kinetic - before
            self.account.kinetic = self.integrator.kinetic
        self._power = self._work_rate()

    def _work_rate(self) -> float:
        """Present power of loads and moving supports [W]."""
        return float(np.sum(self.system.external * self.integrator.state.twist)) + self.supports.power()

    def _account(self, h: float) -> None:
        """Add one step to the energy account, to the integrator's order (trapezoidal work, loss at the mean rate)."""
        power = self._work_rate()
        account = self.account
        account.external += 0.5 * h * (self._power + power)
        account.viscous += self.system.viscous_loss(h)
        account.kinetic = self.integrator.kinetic
        account.elastic = self.system.elastic_energy()
        self._power = power

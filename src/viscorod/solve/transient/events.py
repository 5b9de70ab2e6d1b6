"""Events of a run, located between the ends of steps too."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
import scipy  # its parts are imported when they are asked for

from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.history import Snapshot
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.typing import Floats

PARTS = (0.25, 0.5, 0.75)
"""Places within a step where a quantity is evaluated, so that it does not cross a value and return unseen."""

ACCURACY = 1e-12
"""Of the time of a crossing, as a part of the step."""


class Event(NamedTuple):
    """An event: time [s], label, and whether the run ends there."""

    time: float
    label: str
    stop: bool


class Monitor(Protocol):
    """Waits for one kind of event."""

    def begin(self, t: float, snapshot: Snapshot) -> None:
        """Take over the state at the start."""

    def check_step(self, integrator: Integrator, start: float) -> list[Event]:
        """Return the events of the step that was accepted last and began at ``start`` [s]."""


class CrossingMonitor:
    """Waits for a quantity to cross a value.

    Args:
        label, stop: of the events; quantity: less the value that is crossed; rising, falling: what counts.
    """

    def __init__(
        self, label: str, stop: bool, quantity: Callable[[Snapshot], float], *, rising: bool, falling: bool
    ) -> None:
        self.label, self.stop, self.quantity = label, stop, quantity
        self.rising, self.falling = rising, falling
        self._last = 0.0

    def begin(self, t: float, snapshot: Snapshot) -> None:
        """See :class:`Monitor`."""
        del t
        self._last = self.quantity(snapshot)

    def check_step(self, integrator: Integrator, start: float) -> list[Event]:
        """See :class:`Monitor`."""
        inner = [self.quantity(one) for one in integrator.between(np.array(PARTS)).states.each()]
        values = [self._last, *inner, self.quantity(integrator.snapshot())]
        places = [0.0, *PARTS, 1.0]
        self._last = values[-1]
        found = []
        for k in range(len(values) - 1):
            a, b = values[k], values[k + 1]
            if (a < 0.0 <= b and self.rising) or (a > 0.0 >= b and self.falling):
                part = self._part(integrator, places[k], places[k + 1], a, b)
                found.append(Event(start + part * (integrator.t - start), self.label, self.stop))
        return found

    def _part(self, integrator: Integrator, left: float, right: float, a: float, b: float) -> float:
        """Return where in the step the value is crossed, between ``left`` and ``right`` with the values ``a, b``."""

        def value(part: float) -> float:
            if part == left:
                return a
            if part == right:
                return b
            return self.quantity(integrator.between(np.array([part])).states.at(0))

        return right if b == 0.0 else float(scipy.optimize.brentq(value, left, right, xtol=ACCURACY))


class LastingMonitor:
    """Waits until a condition has held for a while; happens once.

    Args:
        label, stop: of the event; so: the condition; during: how long it has to hold [s].
    """

    def __init__(self, label: str, stop: bool, so: Callable[[Snapshot], bool], during: float) -> None:
        self.label, self.stop, self.so, self.during = label, stop, so, during
        self._since: float | None = None
        self._done = False

    def begin(self, t: float, snapshot: Snapshot) -> None:
        """See :class:`Monitor`."""
        self._since = t if self.so(snapshot) else None

    def check_step(self, integrator: Integrator, start: float) -> list[Event]:
        """See :class:`Monitor`."""
        del start
        inside = integrator.between(np.array(PARTS)).states.each()
        quiet = [self.so(snapshot) for snapshot in [*inside, integrator.snapshot()]]
        if not all(quiet):
            self._since = None
            return []
        if self._since is None:
            self._since = integrator.t
        if self._done or integrator.t - self._since < self.during:
            return []
        self._done = True
        return [Event(integrator.t, self.label, self.stop)]


class FadedMotion:
    """Condition that the kinetic energy is below a ``part`` of the largest so far."""

    def __init__(self, part: float) -> None:
        self.part = part
        self._largest = 0.0

    def __call__(self, snapshot: Snapshot) -> bool:
        """Evaluate the condition in a snapshot."""
        self._largest = max(self._largest, snapshot.kinetic)
        return self._largest > 0.0 and snapshot.kinetic < self.part * self._largest


class StillStrains:
    """Condition that strains change by less than ``rate`` [1/s] of the largest so far, in the energy norm."""

    def __init__(self, gauss: GaussPositions, rate: float) -> None:
        self.gauss, self.rate = gauss, rate
        self._largest = 0.0

    def __call__(self, snapshot: Snapshot) -> bool:
        """Evaluate the condition in a snapshot."""
        self._largest = max(self._largest, self._norm(snapshot.strain))
        return self._norm(snapshot.strain_rate) <= self.rate * self._largest

    def _norm(self, field: Floats) -> float:
        gauss = self.gauss
        return float(np.sqrt(np.einsum("g,gi,gij,gj", gauss.length, field, gauss.stiffness, field)))


class EventWatch:
    """The monitors of a run, and the events so far.

    Args:
        monitors: they check every step.
    """

    def __init__(self, monitors: list[Monitor]) -> None:
        self.monitors = monitors
        self.times: list[float] = []
        self.labels: list[str] = []
        self.ended_by = ""

    def begin(self, t: float, snapshot: Snapshot) -> None:
        """Pass the state at the start of the run to all monitors."""
        for monitor in self.monitors:
            monitor.begin(t, snapshot)

    def check_step(self, integrator: Integrator, start: float) -> float | None:
        """Record the events of the accepted step from ``start`` [s]; return when the run is to end, if it is."""
        found = [event for monitor in self.monitors for event in monitor.check_step(integrator, start)]
        end = None
        for event in sorted(found, key=lambda event: event.time):
            self.times.append(event.time)
            self.labels.append(event.label)
            if event.stop:
                end, self.ended_by = event.time, event.label
                break
        return end

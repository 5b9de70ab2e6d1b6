"""What a run is watched for, as the solver sees it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import InputError
from viscorod.model.actions.event import Crossing, Decayed
from viscorod.results.data_schema import AXES
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot, StationReader
from viscorod.solve.modes import vibrations as small_motion
from viscorod.solve.settings import SimulateSettings
from viscorod.solve.transient.events import (
    CrossingMonitor,
    FadedMotion,
    LastingMonitor,
    Monitor,
    StillStrains,
)

__all__ = ["monitors"]


def monitors(work: DiscreteModel, settings: SimulateSettings, state: State) -> list[Monitor]:
    """What the run is watched for."""
    found: list[Monitor] = []
    for event in settings.events:
        if isinstance(event, Crossing):
            found.append(
                CrossingMonitor(
                    event.label,
                    event.stop,
                    _quantity(work, event),
                    rising=event.direction != "falling",
                    falling=event.direction != "rising",
                )
            )
            continue
        during = event.during or _slowest_period(work, settings, state)
        so: Callable[[Snapshot], bool]
        if isinstance(event, Decayed):
            so = FadedMotion(event.amplitude**2)
        else:
            so = StillStrains(work.system.gauss_positions(), event.change / during)
        found.append(LastingMonitor(event.label, event.stop, so, during))
    return found


def _quantity(work: DiscreteModel, event: Crossing) -> Callable[[Snapshot], float]:
    """The quantity of a crossing, less the value that is crossed."""
    reader, site = StationReader(work.problem), work.site(event.at)
    start = reader.read(work.problem.positions, work.problem.quaternions, np.zeros((work.problem.size, 6)))[0]
    component = AXES.index(event.quantity[-1])
    kind = event.quantity[:-1]

    def quantity(snapshot: Snapshot) -> float:
        state = snapshot.state
        position, _, velocity, _ = reader.read(state.r, state.q, state.twist)
        field = velocity if kind == "v" else position - start if kind == "u" else position
        return float(site.of(field)[component]) - event.value

    return quantity


def _slowest_period(work: DiscreteModel, settings: SimulateSettings, state: State) -> float:
    """Period of the slowest undamped vibration about the state that a motion starts from [s]."""
    linear = small_motion.linearise(
        work.static, state, scale=1.0 if settings.initial == "equilibrium" else 0.0
    )
    frequencies = small_motion.natural_frequencies(linear, 16)
    vibrating = frequencies[frequencies > 0.0]
    if not len(vibrating):
        raise InputError("events: nothing vibrates, so that there is no period to wait for; give during (s)")
    return float(2.0 * np.pi / vibrating.min())

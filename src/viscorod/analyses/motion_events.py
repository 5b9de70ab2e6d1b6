"""Events of a motion: the monitors that watch for crossings, decay and rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import InputError
from viscorod.model.actions.event import AnyEvent, Crossing, Decayed
from viscorod.results.data_schema import AXES
from viscorod.solve.history import Snapshot, StationReader
from viscorod.solve.modes.linearisation import Linearisation
from viscorod.solve.modes.vibrations import natural_frequencies
from viscorod.solve.transient.events import (
    CrossingMonitor,
    FadedMotion,
    LastingMonitor,
    Monitor,
    StillStrains,
)

__all__ = ["monitors"]

SEEN = 16
"""Slowest motions among which the slowest vibration is sought."""


def monitors(
    discrete: DiscreteModel, events: Sequence[AnyEvent], linear: Callable[[], Linearisation]
) -> list[Monitor]:
    """Return the monitors of the events that a run is watched for; ``linear`` returns small motions about its start."""
    found: list[Monitor] = []
    for event in events:
        if isinstance(event, Crossing):
            found.append(
                CrossingMonitor(
                    event.label,
                    event.stop,
                    _quantity(discrete, event),
                    rising=event.direction != "falling",
                    falling=event.direction != "rising",
                )
            )
            continue
        during = event.during or _slowest_period(linear())
        so: Callable[[Snapshot], bool]
        if isinstance(event, Decayed):
            so = FadedMotion(event.amplitude**2)
        else:
            so = StillStrains(discrete.system.gauss_positions(), event.change / during)
        found.append(LastingMonitor(event.label, event.stop, so, during))
    return found


def _quantity(discrete: DiscreteModel, event: Crossing) -> Callable[[Snapshot], float]:
    """Return the quantity of a crossing, less the value that is crossed."""
    reader, place = StationReader(discrete.problem), discrete.place(event.at)
    start = reader.read(
        discrete.problem.positions, discrete.problem.quaternions, np.zeros((discrete.problem.size, 6))
    )[0]
    component = AXES.index(event.quantity[-1])
    kind = event.quantity[:-1]

    def quantity(snapshot: Snapshot) -> float:
        state = snapshot.state
        position, _, velocity, _ = reader.read(state.r, state.q, state.twist)
        field = velocity if kind == "v" else position - start if kind == "u" else position
        return float(place.of(field)[component]) - event.value

    return quantity


def _slowest_period(linear: Linearisation) -> float:
    """Return the period [s] of the slowest undamped vibration about the state that a motion starts from."""
    frequencies = natural_frequencies(linear, SEEN)
    vibrating = frequencies[frequencies > 0.0]
    if not len(vibrating):
        raise InputError("events: nothing vibrates, so that there is no period to wait for; give during (s)")
    return float(2.0 * np.pi / vibrating.min())

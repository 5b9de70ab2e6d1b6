"""Campbell diagrams: modes over the speed of a rotation, followed, with critical speeds and limits of stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import require_no_initial_strain
from viscorod.analyses.followed import (
    Errors,
    common_attributes,
    common_variables,
    doubts,
    errors_of,
    followed,
    found_in,
    limits_of,
    names_of,
    on_fine_mesh,
    whole,
)
from viscorod.errors import Fault, InputError, SolveError
from viscorod.results.campbell import Campbell
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.statics.newton import interruption
from viscorod.solve.steady.driven_rotations import DrivenRotations
from viscorod.solve.steady.steady_checks import (
    SupportKind,
    beside_the_axis,
    require_steady,
    support_kind,
)
from viscorod.solve.steady.whirl import Rounds
from viscorod.solve.tracking.engine_orders import Critical, critical_speeds
from viscorod.solve.tracking.meetings import meetings
from viscorod.solve.tracking.mode_tracking import Sample, Tracker
from viscorod.typing import Floats

__all__ = ["campbell", "rotations"]

_SEEN_ON_MODEL = (
    "the model is alike all around its axis, as a shaft is, and these frequencies are as seen on it: its unbalance "
    "excites it where a frequency seen from outside is that of the speed, which the critical speeds here are not; "
    "frame = 'space' has them"
)

NEUTRAL = 2e-3
"""Part of the speed below which a root may be the rounding of one that is zero."""


def _neutral(samples: Sequence[Sample], names: Sequence[str]) -> list[str]:
    """Return a doubt of modes that are hardly more than rounding at most of the speeds."""
    still = np.array([np.abs(one.roots) <= NEUTRAL * one.parameter for one in samples])
    found = np.flatnonzero(still.mean(axis=0) >= 0.5)
    if not len(found):
        return []
    listed = ", ".join(dict.fromkeys(str(names[int(k)]) for k in found))
    return [
        f"modes that neither swing nor grow are among those that were followed ({listed}): nothing resists them, as "
        "the spin of a round rod about itself on a ball joint; their roots and limits of stability are rounding. Hold "
        "that motion, such as rx of a support in place of a pin"
    ]


def rotations(discrete: DiscreteModel, settings: CampbellSettings) -> DrivenRotations:
    """Return the steady rotations of a model about the axis of the settings.

    Raises:
        InputError: the model cannot turn steadily.
    """
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    require_no_initial_strain(discrete)
    steady = settings.steady()
    require_steady(discrete.model, discrete.problem, steady)
    if settings.values[0] == 0.0 and support_kind(discrete.problem) is not SupportKind.HELD:
        raise InputError(
            Fault(
                "speeds" if settings.band is None else "band",
                "0 rad/s",
                "supports leave the model free to turn as a whole, and at rest it has no modes in place of those that "
                "wobble",
                "begin above 0, or add supports",
            )
        )
    return DrivenRotations(discrete.static, steady)


def campbell(discrete: DiscreteModel, settings: CampbellSettings) -> Campbell:
    """Follow the modes over the speeds on a mesh that is fine enough; see ``Model.campbell``."""
    try:
        meshes = on_fine_mesh(
            discrete,
            lambda one: rotations(one, settings),
            settings.values[-1],
            settings.modes,
            settings.accuracy,
        )
        return _followed(*meshes, settings)
    except KeyboardInterrupt as asked:
        raise SolveError(f"Stopped: {interruption(asked)}") from None


def _followed(discrete: DiscreteModel, finer: DiscreteModel | None, settings: CampbellSettings) -> Campbell:
    """Follow the modes; ``finer`` is the same model with elements halved, for the error of the mesh."""
    family, speeds = rotations(discrete, settings), settings.values
    tracker, speeds = followed(discrete, family, settings.modes, speeds, first=1 if speeds[0] == 0.0 else 0)
    diagram = _Diagram(family, settings.frame, tracker)
    waves = diagram.waves()
    nothing: list[Critical] = []
    orders = settings.engine_orders
    critical = found_in(
        discrete, tracker, "critical speeds", lambda: critical_speeds(tracker, orders, waves), nothing
    )
    found = limits_of(discrete, tracker)
    met, samples = meetings(tracker.samples, family.mass), tracker.at(speeds)
    better = None if finer is None else partial(rotations, finer, settings)
    errors = errors_of(discrete, better, tracker, samples, found, critical, waves)
    start = samples[1 if speeds[0] == 0.0 else 0]
    names = names_of(discrete, family.state(start.parameter), start)
    shifts = np.array(speeds)[:, None] * np.array(waves)
    variables, coordinates = common_variables("speed", samples, names, found, met, errors, shifts)
    whirls = [diagram.rounds(sample).whirl(sample.roots, sample.parameter) for sample in samples]
    at_limits = [abs(one.root.imag + waves[one.mode] * one.parameter) / (2.0 * np.pi) for one in found]
    variables |= {
        "whirl": (("speed", "mode"), np.array(whirls)),
        "limit_frequency": ("limit", np.array(at_limits, dtype=float)),
        **_critical_variables(critical, errors),
    }
    coordinates |= {"speed": np.array(speeds), "engine_order": np.array(settings.engine_orders, dtype=float)}
    notes = [
        *beside_the_axis(discrete.problem, settings.steady()),
        *_neutral(samples, names),
        *doubts("speed", samples, names, errors, tracker),
    ]
    if "frame" not in settings.model_fields_set and diagram.whirls:
        notes.insert(0, _SEEN_ON_MODEL)
    attrs = common_attributes(
        discrete, Campbell.kind, tracker, family.iterations, notes, frame=settings.frame
    )
    import xarray as xr

    return whole(Campbell(xr.Dataset(variables, coordinates, attrs)), tracker)


def _critical_variables(critical: Sequence[Critical], errors: Errors) -> dict[str, Any]:
    """Return the variables of critical speeds."""
    ratios = [-one.root.real / np.hypot(one.root.real, one.order * one.speed) for one in critical]
    frequencies = [one.order * one.speed / (2.0 * np.pi) for one in critical]
    return {
        "critical_speed": ("critical", np.array([one.speed for one in critical], dtype=float)),
        "critical_mode": ("critical", np.array([one.mode for one in critical], dtype=np.int64)),
        "critical_order": ("critical", np.array([one.order for one in critical], dtype=float)),
        "critical_frequency": ("critical", np.array(frequencies, dtype=float)),
        "critical_damping_ratio": ("critical", np.array(ratios, dtype=float)),
        "critical_error": ("critical", errors.critical),
    }


@dataclass
class _Diagram:
    """What the modes are in the frame of the diagram."""

    family: DrivenRotations
    frame: str
    tracker: Tracker

    def rounds(self, sample: Sample) -> Rounds:
        """Return how the modes go round the axis at one speed."""
        return self.family.rounds(sample.parameter, sample.shapes)

    @property
    def whirls(self) -> bool:
        """Whether modes go round the axis, all of them one way alone: those of a model that is alike all around it."""
        samples = self.tracker.samples
        found: Floats = self.rounds(samples[len(samples) // 2]).waves()
        return bool((found != 2).all() and (np.abs(found) == 1).any())

    def waves(self) -> Sequence[int]:
        """Return by how many speeds the frequencies in the frame of the diagram are more than on the model.

        Raises:
            InputError: a mode goes round neither way alone, so that it has no frequency in space.
        """
        count = len(self.tracker.samples[0].roots)
        if self.frame == "turning":
            return [0] * count
        middle = self.tracker.samples[len(self.tracker.samples) // 2]
        found: Floats = self.rounds(middle).waves()
        if (found == 2).any():
            number = int(np.argmax(found == 2)) + 1
            raise InputError(
                Fault(
                    "frame",
                    "'space'",
                    f"at {middle.parameter:.6g} rad/s mode {number} goes round the axis both ways: the model is not "
                    "alike all around it, so that from outside its motions have several frequencies",
                    "take frame = 'turning'",
                )
            )
        return [int(wave) for wave in found]

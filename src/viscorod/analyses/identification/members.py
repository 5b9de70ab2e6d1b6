"""One case of an identification: its records, its mesh, and the analysis that they are compared with."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from viscorod.analyses.call_options import CallOptions
from viscorod.analyses.case_run import discretised_case, run_case
from viscorod.analyses.derivatives.differentiate import equilibrium_derivatives, on_mesh_of
from viscorod.analyses.derivatives.eigenvalues import modes_derivatives
from viscorod.analyses.derivatives.motions import motion_derivatives
from viscorod.analyses.derivatives.responses import response_derivatives
from viscorod.analyses.derivatives.rotations import steady_derivatives
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium
from viscorod.analyses.frequency_response import frequency_response, with_inputs
from viscorod.analyses.identification.case_numbers import case_with, number_at
from viscorod.analyses.modes import modes
from viscorod.analyses.motion import motion
from viscorod.analyses.path import equilibrium_path
from viscorod.analyses.steady import steady_rotation
from viscorod.casefile.case import Case
from viscorod.casefile.known_parts import KnownParts
from viscorod.errors import Fault, InputError, SolveError, last_warnings
from viscorod.one_thread import one_blas_thread
from viscorod.records.any_record import STEP
from viscorod.records.response_record import ResponseRecord
from viscorod.records.static_record import BACK, SLACK, StaticRecord
from viscorod.results.derivative import Derivative
from viscorod.results.run import Run
from viscorod.solve.problem.division import Division, Divisions
from viscorod.solve.refinement.mesh_watch import MeshWatch
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["Member", "earliest_release", "members_of"]

ON_MESH: dict[type, Callable[[DiscreteModel, Any], AnyResult]] = {
    SimulateSettings: motion,
    EquilibriumSettings: equilibrium,
    PathSettings: equilibrium_path,
    SteadySettings: steady_rotation,
    ModesSettings: modes,
    ResponseSettings: frequency_response,
}
"""The analyses that records are compared with, on a mesh that stays as it is."""
BY_NUMBERS: dict[type, Callable[..., dict[str, Derivative[Any]]]] = {
    SimulateSettings: motion_derivatives,
    EquilibriumSettings: equilibrium_derivatives,
    SteadySettings: steady_derivatives,
    ModesSettings: modes_derivatives,
    ResponseSettings: response_derivatives,
}
"""What gives their results derivatives by numbers of the model."""
STEPS = 1e-4
"""What steps of motions may err by over the size of the model, unless the case says; differences need it."""
LINES = 1000
"""Frequencies of records up to which responses are computed at these, not on straight lines between others."""
MOST_STATES = 50
"""The same of loads and equilibria."""
BEFORE = 0.1
"""Part of a record by which its release may be sought before where it starts."""


class _Computed(NamedTuple):
    """What was computed last: numbers by key, the case and the discretised model with them, and its result."""

    key: tuple[tuple[str, float], ...]
    case: Case
    discrete: DiscreteModel
    result: AnyResult


class Unwatched(MeshWatch):
    """Estimates nothing: meshes stay as they are, and estimating takes as long as a motion."""

    @property
    def feasible(self) -> bool:
        """No."""
        return False


@dataclass
class Member:
    """One case with the records that it has to predict.

    Attributes:
        case: at the start; records: that are compared with its result.
        divisions: of the rods; found once, with the first result, and kept.
        step_ends: times [s] at which steps of its motion end, see :meth:`hold`; none where steps are chosen.
        doubts: about its model and the state that it starts from, with the last numbers.
    """

    case: Case
    records: list[Any]
    divisions: Divisions | None = None
    step_ends: tuple[float, ...] = ()
    doubts: tuple[str, ...] = ()
    _last: _Computed | None = field(default=None, repr=False)
    _known: KnownParts = field(default_factory=KnownParts, repr=False, compare=False)

    def __post_init__(self) -> None:
        if type(self.case.settings) not in ON_MESH:
            words = "simulate, equilibrium, path, steady, modes or response"
            raise InputError(
                Fault("case", self.case.kind, "records are not compared with this", f"use {words}")
            )
        self.case = replace(self.case, settings=self._settled())

    @cached_property
    def own(self) -> dict[str, str]:
        """Unknowns of the records that are numbers of this case alone, by full name: their keys."""
        return {
            full: one.key
            for record in self.records
            for full, one in record.nuisances.items()
            if one.key is not None
        }

    def key_of(self, name: str) -> str | None:
        """Return the key (or several that are equal) of an unknown in this case; None if it is none of its numbers."""
        key = self.own.get(name, name)
        return key if number_at(self.case, key) is not None else None

    def numbers(self, named: Mapping[str, float]) -> dict[str, float]:
        """Return by key those of several unknowns that are numbers of this case."""
        return {key: value for name, value in named.items() if (key := self.key_of(name)) is not None}

    def result(self, values: Mapping[str, float]) -> AnyResult:
        """Return the result of the case with these numbers; the last one is kept.

        Raises:
            InputError: the case refuses a number. SolveError: it cannot be solved.
        """
        return self._with(values).result

    def derivatives(self, values: Mapping[str, float]) -> dict[str, Derivative[Any]]:
        """Return the derivatives of the result with these numbers by those of them that it has any by, by key.

        Those of a motion go through its own steps.

        Raises:
            InputError, SolveError: as of :meth:`result`.
        """
        compute = BY_NUMBERS.get(type(self.case.settings))
        if compute is None:
            return {}
        computed = self._with(values)
        model, settings, result = computed.case.description, self.case.settings, computed.result
        if isinstance(settings, ResponseSettings):
            model = with_inputs(model, settings)
        found: dict[str, Derivative[Any]] = {}
        with last_warnings() as kept, one_blas_thread():
            discrete = on_mesh_of(computed.discrete, result)
            try:
                found = compute(model, discrete, settings, result, list(values))
            except (InputError, SolveError):  # one of them has none: the others may have
                for key in values:
                    with suppress(InputError, SolveError):
                        found |= compute(model, discrete, settings, result, [key])
            kept.clear()
        return found

    def _with(self, values: Mapping[str, float]) -> _Computed:
        key = tuple(values.items())
        if self._last is None or self._last.key != key:
            case = replace(case_with(self.case, values, self._known), settings=self.case.settings)
            self._last = _Computed(key, case, *self._compute(case))
        return self._last

    def predicted(self, record: Any, named: Mapping[str, float]) -> Floats:
        """Return what the case says of a record, with unknowns by name."""
        found: Floats = record.predicted(self.compared(record, named), named)
        return found

    def compared(self, record: Any, named: Mapping[str, float]) -> Any:
        """Return what a record is compared with: the result of the case, or its material.

        Raises:
            InputError: the case has several materials.
        """
        if record.analysis != "material":
            return self.result(self.numbers(named))
        case = case_with(self.case, self.numbers(named), self._known)
        materials = {id(rod.material): rod.material for rod in case.description.rods.values()}
        if len(materials) != 1:
            why = "moduli are those of one material"
            raise InputError(Fault("case", f"{len(materials)} materials", why, "give a case with one"))
        return next(iter(materials.values()))

    def hold(self, values: Mapping[str, float]) -> None:
        """Let motions go through the steps from now on that are chosen with these numbers.

        Steps that follow their errors change with the numbers, and what they err by jumps. With steps that stay where
        they are, results are smooth functions of the numbers.
        """
        if not isinstance(self.case.settings, SimulateSettings):
            return
        before, self.step_ends, self._last = self.step_ends, (), None
        try:
            run = self.result(values)
        except (SolveError, InputError):
            self.step_ends = before
            raise
        self._last = None
        if isinstance(run, Run) and not run.data.attrs.get(
            "ended_by"
        ):  # an event, at a time that changes too
            self.step_ends = tuple(run.ends_of_steps.tolist())

    def _compute(self, case: Case) -> tuple[DiscreteModel, AnyResult]:
        options = CallOptions(step_ends=self.step_ends, note_steps=not self.step_ends)
        with last_warnings() as kept:
            if self.divisions is None:
                self.divisions = self._chosen(case)
            discrete = discretised_case(case, options)
            if self.divisions:
                discrete = discrete.on_mesh(self.divisions)
            watch = Unwatched(discrete.model, discrete.problem, discrete.system)
            with one_blas_thread():
                result = ON_MESH[type(case.settings)](replace(discrete, watch=watch), case.settings)
            kept.clear()  # a fit passes through many, and tells those of the last
        self.doubts = tuple(json.loads(str(discrete.attributes["doubts"])))
        if self.step_ends and isinstance(result, Run):
            result.ends_of_steps = np.array(self.step_ends)
        return discrete, result

    def _chosen(self, case: Case) -> Divisions:
        """Return the mesh that the program chooses for the case; none where all rods have their elements given."""
        if all(rod.elements is not None for rod in case.description.rods.values()):
            return {}
        stored = json.loads(str(run_case(case).data.attrs.get("divisions", "{}")))
        return {name: Division(order, np.array(ends)) for name, (order, ends) in stored.items()}

    def _settled(self) -> Any:
        """Return the settings with steps that are fine enough for differences, long enough for all records.

        Equilibria are those at the measured loads, as far as those of the case go, or `MOST_STATES` between them.
        """
        settings = self.case.settings
        if isinstance(settings, EquilibriumSettings) and not settings.stages and settings.start is None:
            loads = [np.asarray(one.load_factors) for one in self.records if isinstance(one, StaticRecord)]
            wanted = np.unique(np.concatenate(loads)) if loads else np.zeros(0)
            reach = (1.0 + SLACK) * max(settings.stops)
            if len(wanted) and -BACK * wanted[-1] <= wanted[0] and wanted[-1] <= reach:
                wanted = np.unique(np.maximum(wanted, 0.0))
                if len(wanted) > MOST_STATES:
                    wanted = np.linspace(wanted[0], wanted[-1], MOST_STATES)
                return settings.model_copy(
                    update={"load_factors": tuple(wanted.tolist()), "load_steps": None, "load_factor": 1.0}
                )
            return settings
        if isinstance(settings, ResponseSettings):
            return self._at_lines(settings)
        if not isinstance(settings, SimulateSettings):
            return settings
        changes: dict[str, Any] = {}
        if settings.tolerance is None and settings.integrator == "radau":
            changes["tolerance"] = STEPS
        needed = max((_last_time(record) for record in self.records), default=0.0)
        if needed > settings.duration:
            changes["duration"] = needed
        return settings.model_copy(update=changes) if changes else settings

    def _at_lines(self, settings: ResponseSettings) -> ResponseSettings:
        """Return the settings with the frequencies of the records, unless these are very many."""
        lines = [one.frequencies for one in self.records if isinstance(one, ResponseRecord)]
        wanted = np.unique(np.concatenate(lines)) if lines else np.zeros(0)
        if not 0 < len(wanted) <= LINES:
            return settings
        return settings.model_copy(update={"frequencies": tuple(wanted.tolist()), "band": None})


def _last_time(record: Any) -> float:
    """Return the time of the motion at which the last sample may be, also of differences by the time of release."""
    times = getattr(record, "times", None)
    if times is None:
        return 0.0
    last, span = float(times[-1]), float(times[-1] - times[0])
    release = [one for one in record.nuisances.values() if one.name == "release_time"]
    if not release:
        return last
    return last - earliest_release(release[0], span) + STEP * float(record.usual_size(release[0]))


def earliest_release(release: Any, span: float) -> float:
    """Return the earliest time at which a motion may have been released."""
    return float(max(release.low, release.start - BEFORE * span))


def members_of(pairs: Sequence[tuple[Case, Any]]) -> list[Member]:
    """Return the cases with their records; records share the result of a case unless they have numbers of their own."""
    found: list[tuple[Case, frozenset[tuple[str, str]], list[Any]]] = []
    for case, given in pairs:
        for record in given if isinstance(given, list | tuple) else [given]:
            own = _own_numbers(record)
            known = next((records for one, its, records in found if one is case and its == own), None)
            if known is None:
                found.append((case, own, [record]))
            else:
                known.append(record)
    return [Member(case, records) for case, _, records in found]


def _own_numbers(record: Any) -> frozenset[tuple[str, str]]:
    """Return the unknowns of a record that are numbers of its case, by full name, with their keys."""
    return frozenset((full, one.key) for full, one in record.nuisances.items() if one.key is not None)

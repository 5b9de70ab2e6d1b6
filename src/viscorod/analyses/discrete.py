"""A discretised model with the objects that solve it: what every analysis works on."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.call_options import CallOptions
from viscorod.analyses.modal_damping import with_known_times
from viscorod.analyses.model_doubts import model_doubts
from viscorod.analyses.provenance import provenance, section_record
from viscorod.analyses.thin_twist import thin_twist
from viscorod.analyses.touching_coils import touching_in
from viscorod.analyses.unjoined_rods import unjoined_rods
from viscorod.errors import Fault, InputError
from viscorod.mechanics.compilation.compiled import announce_compilation, announce_formulation
from viscorod.mechanics.elements import geometric_element as geometric
from viscorod.mechanics.elements.held_strains import add_held_strains
from viscorod.mechanics.joints.joint_forces import joint_forces
from viscorod.model.actions.rest_strain import RestStrain
from viscorod.model.description.consistency import require_inertia
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.dataset import dataset, state_arrays
from viscorod.results.late_attributes import LateAttributes
from viscorod.results.result_places import ResultPlace, ResultPlaces
from viscorod.results.state_arrays import StateArrays
from viscorod.solve.constraints.free_motion import FreeMotion
from viscorod.solve.constraints.parts import many_parts
from viscorod.solve.constraints.redundancy import require_independent
from viscorod.solve.constraints.rigid_motions import free_motions
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.constraints.undetermined_motions import undetermined, undetermined_of_many
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import History
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.division import Divisions
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.node_names import describe_node
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.mesh_watch import MeshWatch
from viscorod.solve.settings.analysis import AnySettings
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.checks import require_fit
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.statics.newton import NewtonReport
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.contract import StepReport

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.result import Result

__all__ = ["DiscreteModel", "named", "unheld"]

IMPOSED = (
    "the initial strains (strain, [[strains]]) are imposed as rest strains, at which rods are free of stress; write "
    "rest_strain, [[rest_strains]], for what stays in motions and modes too"
)


LARGE = 5000
"""Nodes from which on modes take more than a second or two."""
MOST_NAMED = 6
"""Free motions that a message names."""


def named(motions: list[FreeMotion]) -> str:
    """Name the first of some free motions, and count the others."""
    more = len(motions) - MOST_NAMED
    text = "; ".join(motion.text for motion in motions[:MOST_NAMED])
    return f"{text} and {more} more motions" if more > 0 else text


def unheld(motions: list[FreeMotion], why: str = "", *, thrust: bool = False) -> InputError:
    """Return the refusal of a static solution that leaves motions free; ``thrust``: following loads act."""
    rocket = (
        ". What its own thrust accelerates rests beside its inertia: give that as a distributed force against the "
        "thrust, and soft springs"
        if thrust
        else ""
    )
    return InputError(
        f"no static equilibrium: nothing holds the model against {named(motions)}{f' ({why})' if why else ''}. "
        "Add supports, or take the reference shape (initial = 'reference' of a simulation, "
        f"about = 'reference' of modes){rocket}"
    )


def with_strains_at_rest(model: ModelDescription) -> ModelDescription:
    """Return the model with its initial strains as rest strains: nothing else could keep them in statics.

    Raises:
        InputError: a rod has both.
    """
    taken = {strain.rod for strain in model.rest_strains}
    faults = [
        Fault(
            f"strains[{index}].rod",
            repr(strain.rod),
            "in statics an initial strain is imposed as a rest strain, and the rod has one already",
            "leave one of them out",
        )
        for index, strain in enumerate(model.strains)
        if strain.rod in taken
    ]
    if faults:
        raise InputError(faults)
    rest = [*model.rest_strains, *(RestStrain(strain.rod, value=strain.value) for strain in model.strains)]
    parts: dict[str, Any] = model.parts() | {"strains": [], "rest_strains": rest}
    return type(model).of(**parts)


@cache
def _announce_assembly() -> None:
    """Say once if the assembly has to be compiled: to ask Numba takes a hundredth of a small equilibrium."""
    announce_compilation(geometric.assemble)


@dataclass(frozen=True)
class DiscreteModel:
    """One discretised model with the objects that solve it.

    Attributes:
        model: that was discretised, with the times of all its materials known.
        problem: its frozen arrays.
        formulation: its words in ``FORMULATIONS``, with those of its damping.
        system, supports: the formulation and the supports that solvers work on.
        static: finds equilibria.
        attributes: of every result: where it comes from and what its materials are.
        options: of the present call.
        watch: estimates what the mesh makes wrong.
        began: when the computation did, on the clock of ``time.perf_counter``.
        coarser: what the same analysis found on a coarser mesh, where there was one.
    """

    model: ModelDescription
    problem: Problem
    formulation: tuple[str, str]
    system: System
    supports: SupportState
    static: StaticSolver
    attributes: LateAttributes
    options: CallOptions
    watch: MeshWatch
    began: float
    coarser: Result | None = None

    @classmethod
    def of(
        cls,
        model: ModelDescription,
        settings: AnySettings | None = None,
        options: CallOptions | None = None,
        *,
        formulation: tuple[str, str] | None = None,
        validated: bool = False,
    ) -> DiscreteModel:
        """Discretise a model for an analysis.

        Args:
            model: what is computed.
            settings: of the analysis.
            options: of the call.
            formulation: and damping, by their words in ``FORMULATIONS``; by default those of the settings of a motion,
                else the geometric formulation with full damping.
            validated: whether ``model.validate()`` has passed already.

        Raises:
            InputError: the model is inconsistent, or cannot be computed with these settings.
        """
        options = options or CallOptions()
        if isinstance(settings, SimulateSettings):
            require_fit(model, settings)
            formulation = formulation or (settings.formulation, settings.damping)
        if settings is not None and not isinstance(
            settings, EquilibriumSettings | PathSettings | BucklingSettings
        ):
            require_inertia(model)
        notes: dict[str, str] = {}
        if isinstance(settings, EquilibriumSettings | PathSettings) and model.strains:
            model = with_strains_at_rest(model)
            notes["warnings"] = json.dumps([IMPOSED])
        model = ModelDescription.of(**model.parts())  # which may change before all is read of a result
        known = with_known_times(model)
        attributes = provenance(model, known, options.title, options.attributes) | notes
        problem = discretise(known, validated=validated)
        duration = settings.duration if isinstance(settings, SimulateSettings) else 0.0
        attributes["doubts"] = json.dumps(model_doubts(known, problem, duration))
        _announce_assembly()
        if problem.constrained:
            announce_formulation(joint_forces if problem.joints.count else add_held_strains)
        return cls._begun(known, problem, formulation or ("geometric", "full"), attributes, options)

    @classmethod
    def _begun(
        cls,
        model: ModelDescription,
        problem: Problem,
        formulation: tuple[str, str],
        attributes: LateAttributes,
        options: CallOptions,
    ) -> DiscreteModel:
        system, supports = FORMULATIONS[formulation].make(problem), SupportState(problem)
        attributes = attributes | section_record(model, system.gauss_positions())
        static, watch = (
            StaticSolver(system, supports),
            MeshWatch(model, problem, system, wanted=options.errors),
        )
        began = time.perf_counter()
        return cls(model, problem, formulation, system, supports, static, attributes, options, watch, began)

    @property
    def inertia_known(self) -> bool:
        """Whether the inertia of all rods is known."""
        return all(rod.has_inertia for rod in self.model.rods.values())

    def renewed(self, options: CallOptions, attributes: dict[str, str]) -> DiscreteModel:
        """Return the same problem with solvers that have not been used: they keep stresses from one use to the next.

        Args:
            options: of the next call.
            attributes: of its result, beside those that are there.
        """
        return self._begun(self.model, self.problem, self.formulation, self.attributes | attributes, options)

    def on_mesh(self, divisions: Divisions, coarser: Result | None = None) -> DiscreteModel:
        """Return the same model with its rods divided otherwise; ``coarser`` is what was found on the present mesh."""
        problem = discretise(self.model, validated=True, divisions=divisions)
        stored = {name: (division.order, division.ends.tolist()) for name, division in divisions.items()}
        attributes = self.attributes | {"divisions": json.dumps(stored)}
        made = self._begun(self.model, problem, self.formulation, attributes, self.options)
        return replace(made, coarser=coarser)

    def of_problem(self, model: ModelDescription, problem: Problem) -> DiscreteModel:
        """Return what solves another problem, of a model with other numbers, in the same formulation."""
        return self._begun(model, problem, self.formulation, self.attributes, self.options)

    def announce_modes(self) -> None:
        """Say that modes are being found, where that takes more than a few seconds: it shows no progress."""
        if self.problem.size > LARGE:
            logging.getLogger("viscorod").warning(
                "viscorod: finding vibrations of %d nodes, some seconds for every 10 000", self.problem.size
            )

    def require_independent(self) -> None:
        """Refuse conditions that others imply already: joints, held strains and supports that hold the same.

        Raises:
            InputError: there are such conditions, by name.
        """
        require_independent(self.system, self.supports)

    def require_held(self, loads: Callable[[], LoadState], *, searching: bool = False) -> list[FreeMotion]:
        """Refuse a static solution if supports and loads leave a rigid motion undetermined.

        Args:
            loads: returns those that act, which are looked at only where supports leave a motion.
            searching: let rotations and mechanisms pass that loads may hold in another position.

        Returns:
            These motions.

        Raises:
            InputError: they do; it names the motion.
        """
        many = bool(many_parts(self.problem))
        motions = [] if many else free_motions(self.problem)
        if not (many or motions):
            return []
        self.system.assemble(State.reference(self.problem), loads(), None, tangent=True, moving=False)
        size = 6 * self.problem.size
        stiffness = self.system.matrix.sparse()[:size, :size]
        found = undetermined_of_many(self.problem, self.system.external, stiffness) if many else None
        if found is None:
            motions = motions or free_motions(self.problem)
            found = undetermined(self.problem, self.system.external, stiffness, motions)
        loose = found
        acting = self.system.external.any() or self.supports.moving or bool(self.problem.joints.motions)
        # a line that is not taut yet holds nothing across it, and does once it bears a load
        roped = any(spring.kind == "line" for spring in self.model.resolved_springs())
        if searching and acting and (roped or not any(motion.translation for motion in loose)):
            return loose
        if loose:
            thrust = any(getattr(load, "following", False) for load in self.model.loads)
            raise unheld(loose, "; ".join(unjoined_rods(self.model, self.problem)), thrust=thrust)
        return []

    def place(self, name: str) -> ResultPlace:
        """Return a place by its name, before there is a data set.

        Raises:
            InputError: there is no such place.
        """
        problem = self.problem
        stations = problem.stations
        names, still = list(problem.bodies.names), np.zeros(len(problem.bodies.names))
        return ResultPlaces.of(
            np.array([*np.array(problem.rods)[stations.rod], *names]),
            np.append(stations.s, still),
            np.append(problem.rod_orders[stations.rod], still.astype(np.int64)),
        ).at(name)

    def where(self, report: NewtonReport | StepReport) -> str:
        """Say in a sentence where a solution failed."""
        return (
            f" Largest imbalance {report.residual:.3g} N at {describe_node(self.problem, report.node)}, "
            f"after {report.iterations} iterations."
        )

    def data_set(self, kind: str, history: History, attrs: dict[str, Any]) -> Callable[[], xr.Dataset]:
        """Return what builds the data set of a history."""
        complete = self.complete(attrs)
        return partial(dataset, kind, self.problem, self.system.gauss_positions(), history, complete)

    def arrays(
        self,
        kind: str,
        history: History,
        attrs: dict[str, Any],
        late: Callable[[], dict[str, Any]] | None = None,
    ) -> Callable[[], StateArrays]:
        """Return what makes the arrays of a history; as a data set they take half as long as a small equilibrium.

        ``late`` makes attributes that are not known yet.
        """
        complete, points = self.complete(attrs), self.system.gauss_positions()
        if history.instant:
            told = thin_twist(self.problem, self.model.rods, points, history.snapshots[-1].strain)
            words = "in this state" if history.count == 1 else "at the load factor {:.4g}"
            touching = touching_in(self.model.rods, self.problem, history, words)
            complete["doubts"] = json.dumps([*json.loads(complete.get("doubts", "[]")), *told, *touching])
        return partial(state_arrays, kind, self.problem, points, history, complete, late)

    @property
    def _energy_scale(self) -> float:
        """Elastic energy [J] at a strain of one; if all strains are held, that whose round-off loads on them make."""
        problem = self.problem
        elastic = problem.length * max(float(s.stiffness.max(initial=0.0)) for s in problem.sets)
        if elastic > 0.0:
            return elastic
        loads = self.static.loads.at(0.0)
        weight = float(np.abs(loads.gravity).max()) * float(problem.mass[:, 0, 0].sum())
        return (
            1e12 * problem.length * (weight + float(np.abs(loads.dead).sum() + np.abs(loads.following).sum()))
        )

    def complete(self, attrs: Mapping[str, Any]) -> LateAttributes:
        """Return the attributes of a data set, with those that all have."""
        return (
            {
                "message": "",
                "scale_length": self.problem.length,
                "energy_scale": self._energy_scale,
                "wall_time_s": time.perf_counter() - self.began,
            }
            | self.attributes
            | attrs
        )

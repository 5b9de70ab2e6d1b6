"""The discretised model with a number of the case a little larger and smaller, on the same mesh.

What enters a problem through its arrays is smooth in the number. Central differences with two steps, extrapolated
(Richardson), have an error of the fourth order in the step of 1e-3 of the number, which leaves about 1e-12 of it and of
rounding together; where one side is refused (a ratio at its bound, a time of zero), five points of the other side do
the same. Nothing is solved for these.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from viscorod.analyses.derivatives.case_numbers import CaseNumber
from viscorod.analyses.derivatives.section_meshes import section_meshes
from viscorod.analyses.discrete import DiscreteModel, with_strains_at_rest
from viscorod.analyses.modal_damping import with_known_times
from viscorod.analyses.provenance import material_record, section_record
from viscorod.errors import Fault, InputError
from viscorod.mechanics.joints.joint_coordinates import AT_Q_A, AT_U1
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.model.connections.resolved_places import required_breaks
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.sections.kept_meshes import KeptMesh, kept_meshes
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import System
from viscorod.solve.problem.discretise import discretise, discretise_beside
from viscorod.solve.problem.division import Division, Divisions, divisions_of
from viscorod.solve.problem.element_arrays import gauss_positions
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.static_solver import StaticSolver

__all__ = ["CLOSE", "MANY", "STEP", "Neighbour", "Neighbours", "Scheme"]

STEP = 1e-3
"""Change of a number, as a part of it."""
CLOSE = 5e-5
"""The same where few neighbours are to do."""
TURN = 2e-3
"""Most rotation [rad] of nodes: what strains have of fourth order in it, section forces show."""
ROUNDING = 1e-9
"""Part of the length of a rod by which places that are one may differ."""

JUMP = 0.3
"""Components of unit vectors by which axes of joints and supports differ whose choice jumped."""


class Scheme(NamedTuple):
    """Where a function is evaluated, in steps, and the weights of a derivative over the step, and of a rougher one."""

    places: tuple[float, ...]
    weights: tuple[float, ...]
    rough: tuple[float, ...]


def _to_one_side(
    places: tuple[float, ...], weights: tuple[float, ...], rough: tuple[float, ...]
) -> tuple[Scheme, Scheme]:
    """Return a difference to larger numbers, and its reflection."""
    below = Scheme(*(tuple(-x for x in values) for values in (places, weights, rough)))
    return Scheme(places, weights, rough), below


MANY = (
    Scheme((1.0, -1.0, 0.5, -0.5), (-1.0 / 6.0, 1.0 / 6.0, 4.0 / 3.0, -4.0 / 3.0), (0.5, -0.5, 0.0, 0.0)),
    *_to_one_side(
        (0.0, 1.0, 2.0, 3.0, 4.0), (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -0.25), (-1.5, 2.0, -0.5, 0.0, 0.0)
    ),
)
"""Two central differences, extrapolated; five points to one side."""
FEW = (
    Scheme((1.0, -1.0), (0.5, -0.5), (0.5, -0.5)),
    *_to_one_side((0.0, 1.0, 2.0), (-1.5, 2.0, -0.5), (-1.0, 1.0, 0.0)),
)
"""A central difference; three points to one side."""


@dataclass(frozen=True)
class Neighbour:
    """The model at one place of a scheme: its problem, and solvers of its own.

    Attributes:
        change: of the number; weight: of what is computed with it, in the derivative.
        model, problem: with the other number, discretised on the mesh of ``base``.
        meshes: of sections of ``base``, which its own ones are moved from.
    """

    change: float
    weight: float
    model: ModelDescription
    problem: Problem
    base: DiscreteModel
    meshes: tuple[KeptMesh, ...] = ()

    @cached_property
    def discrete(self) -> DiscreteModel:
        """What solves it."""
        return self.base.of_problem(self.model, self.problem)

    @property
    def keeps_shape(self) -> bool:
        """Whether nodes, supports, joints and rest strains are those of the model itself."""
        mine, its = self.problem, self.base.problem
        rest = (tuple(strain for _, strain in problem.rest_strains) for problem in (mine, its))
        one, other = rest
        return mine.of_layout is its.of_layout and all(a is b for a, b in zip(one, other, strict=True))

    @cached_property
    def resting(self) -> StaticSolver:
        """What evaluates states at rest: that of the model itself with other numbers, where these keep the shape.

        To make one of its own takes five times as long. Between two evaluations nothing of it lasts.
        """
        return self.base.static.beside(self.problem) if self.keeps_shape else self.static

    @property
    def system(self) -> System:
        """Its formulation."""
        return self.discrete.system

    @property
    def supports(self) -> SupportState:
        """Its supports."""
        return self.discrete.supports

    @property
    def static(self) -> StaticSolver:
        """What finds its equilibria."""
        return self.discrete.static

    def attributes(self, result: Any) -> dict[str, Any]:
        """Return the attributes of a result for this one: its materials and sections are its own."""
        model = self.model
        kept = {name: value for name, value in result.data.attrs.items() if name != "kind"}
        rods = zip(self.base.model.rods.values(), model.rods.values(), strict=True)
        if not all(a is b for a, b in rods):
            with kept_meshes(self.meshes):
                kept |= material_record(model) | section_record(model, gauss_positions(self.problem))
            if self.meshes:
                kept["section_meshes"] = json.dumps([mesh.to_list() for mesh in self.meshes])
        return kept | {"case": json.dumps(model.to_dict())}


class Neighbours(NamedTuple):
    """All that a derivative by one number is made of.

    Attributes:
        rough: weights of a derivative of lower order by the same neighbours, which tells what that by theirs lacks.
    """

    number: CaseNumber
    each: tuple[Neighbour, ...]
    rough: tuple[float, ...]

    @classmethod
    def of(
        cls,
        model: ModelDescription,
        key: str,
        discrete: DiscreteModel,
        few: float | None = None,
        *,
        many: float = STEP,
    ) -> Neighbours:
        """Make them beside a discretised model.

        Args:
            model: as its user made it; key: of the number; discrete: the same on its mesh.
            few: change of the number, as a part of it, of few neighbours; by default there are many.
            many: the same of many.

        Raises:
            InputError: there is no such number, or it changes the mesh, what is connected, or when loads jump.
        """
        number = CaseNumber.of(model, key)
        size = number.size or natural_size(number.unit, discrete.problem)
        meshes = section_meshes(discrete)
        refused: list[str] = []
        central, above, below = MANY if few is None else FEW
        for scheme, part in ((central, 1.0), (central, 0.01), (above, 1.0), (below, 1.0)):
            step = part * (few or many) * size
            try:
                found = [_made(discrete, number, step * place, meshes) for place in scheme.places]
                turn = max(_turned(discrete.problem, problem) for _, problem in found)
                if turn > TURN:
                    step *= TURN / turn
                    found = [_made(discrete, number, step * place, meshes) for place in scheme.places]
            except InputError as error:
                refused += [text for text in [str(error)] if text not in refused]
                continue
            each = [
                Neighbour(step * place, weight / step, *made, discrete, meshes)
                for place, weight, made in zip(scheme.places, scheme.weights, found, strict=True)
            ]
            return cls(number, tuple(each), tuple(weight / step for weight in scheme.rough))
        told = refused[:1] if len(refused) < 2 else [refused[0], refused[-1]]
        raise InputError(
            Fault(
                "derivatives",
                repr(key),
                f"the model cannot be made with a slightly larger or smaller number: {'; and '.join(told)}",
                "name a number that may vary a little while mesh and connections stay",
            )
        )

    def derivative(self, function: Callable[[Neighbour], np.ndarray]) -> np.ndarray:
        """Return the derivative of the arrays that a function returns."""
        total: np.ndarray = sum((one.weight * function(one) for one in self.each), np.zeros(()))
        return total


def _turned(problem: Problem, other: Problem) -> float:
    """Return by how much [rad] the node that turns most is turned in the reference shape of another problem."""
    if other.quaternions is problem.quaternions:
        return 0.0
    turn = product(conjugate(problem.quaternions), other.quaternions)
    return float(2.0 * np.linalg.norm(turn[:, 1:], axis=1).max())


def natural_size(unit: str, problem: Problem) -> float:
    """Return what is of moderate size for a model, in a unit: of numbers that are zero."""
    bending = min((float(b) for e in problem.sets for b in e.stiffness[:, 3, 3] if b > 0.0), default=1.0)
    length, mass = problem.length, float(problem.mass[:, 0, 0].sum()) or 1.0
    time = float(np.sqrt(mass * length**3 / bending))
    return {
        "N": bending / length**2,
        "N/m": bending / length**3,
        "N m": bending / length,
        "m": length,
        "1/m": 1.0 / length,
        "kg": mass,
        "s": time,
        "m/s": length / time,
        "rad/s": 1.0 / time,
        "m/s^2": length / time**2,
    }.get(unit, 1.0)


def _made(
    discrete: DiscreteModel, number: CaseNumber, change: float, meshes: Sequence[KeptMesh]
) -> tuple[ModelDescription, Problem]:
    """Return the model of a neighbour, and its arrays; its sections keep the meshes that are there."""
    with kept_meshes(meshes):
        return _made_alike(discrete, number, change)


def _made_alike(
    discrete: DiscreteModel, number: CaseNumber, change: float
) -> tuple[ModelDescription, Problem]:
    model = number.at(number.value + change)
    if discrete.model.rest_strains and not discrete.model.strains and model.strains:
        model = with_strains_at_rest(model)
    known = with_known_times(model)
    problem = discretise_beside(discrete.problem, discrete.model, known)
    if problem is None:
        divisions = _moved(discrete.model, known, divisions_of(discrete.problem))
        problem = discretise(known, validated=True, divisions=divisions)
    difference = _difference(discrete.problem, problem)
    if difference:
        raise InputError(Fault(number.key, f"{number.value:.6g}", f"it changes {difference}", ""))
    return known, problem


def _moved(model: ModelDescription, other: ModelDescription, divisions: Divisions) -> dict[str, Division]:
    """Return the divisions of another model: elements keep their parts of the lengths between fixed places."""
    found = {}
    for name, division in divisions.items():
        here, there = (_corners(one, name) for one in (model, other))
        if len(here) != len(there):
            raise InputError(Fault(f"rods.{name}", "", "the places where elements must end differ", ""))
        ends = division.ends
        fixed = np.abs(here[:, None] - ends).min(axis=1) <= ROUNDING * ends[-1]
        here, there = here[fixed], there[fixed]
        order = np.argsort(here)
        ends = np.interp(ends, here[order], there[order])
        found[name] = Division(division.order, ends)
    return found


def _corners(model: ModelDescription, name: str) -> np.ndarray:
    """Return the arc lengths of a rod at which elements may have to end, in the order in which they are given."""
    rod = model.rods[name]
    places = [*required_breaks(model), *(place for load in model.loads for place in load.breaks(model))]
    return np.array([0.0, rod.length, *rod.section_breaks, *(p.s for p in places if p.rod == name)])


def _instants(times: Sequence[float]) -> list[float]:
    """Return whether times are before, at or after t = 0: -1, 0 or 1."""
    return [float(sign) for sign in np.sign(times)]


def _difference(problem: Problem, other: Problem) -> str:
    """Say in what two problems differ beside their numbers; empty if in nothing."""
    mine, its = problem.joints.arrays, other.joints.arrays
    checks: dict[str, list[tuple[Any, Any]]] = {
        "the mesh": [
            (problem.positions.shape, other.positions.shape),
            (len(problem.sets), len(other.sets)),
            *((a.nodes, b.nodes) for a, b in zip(problem.sets, other.sets, strict=False)),
            (problem.multipliers, other.multipliers),
        ],
        "what is connected or held": [
            (problem.supports.nodes, other.supports.nodes),
            (problem.supports.fixed, other.supports.fixed),
            (mine.nodes, its.nodes),
            (mine.kind, its.kind),
            (mine.place, its.place),
            (problem.held.place, other.held.place),
        ],
        "how many different relaxation times there are (materials.NAME... is the number of all rods of a material)": [
            (len(problem.relaxation_times), len(other.relaxation_times)),
        ],
        "when rows of records are": [(problem.rows, other.rows)],
        "which jumps or corners of loads and motions are at one time, or at t = 0": [
            (_instants(one), _instants(two))
            for one, two in ((problem.breakpoints, other.breakpoints), (problem.jumps, other.jumps))
        ],
    }
    for text, pairs in checks.items():
        if not all(a is b or np.array_equal(a, b) for a, b in pairs):
            return text
    axes = [(mine.geometry[:, AT_U1:AT_Q_A], its.geometry[:, AT_U1:AT_Q_A])]
    axes.append((problem.supports.axes, other.supports.axes))
    if any(np.abs(a - b).max(initial=0.0) > JUMP for a, b in axes):
        return "which axes of a joint or support are taken across its direction, all at once"
    return ""

"""Watches the solutions of one problem for what a finer mesh would make of them, and says where to refine."""

from __future__ import annotations

import json
from functools import cached_property
from typing import Any

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import DEFAULT_ORDER
from viscorod.solve.formulations.system import State, System
from viscorod.solve.problem.division import Division, Divisions, divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape
from viscorod.solve.refinement.mesh_estimate import MeshEstimate, difference

__all__ = ["MeshWatch"]

MOST_NODES = 20_000
"""Nodes of a problem beyond which no finer mesh is made."""
MOST_CHOSEN_NODES = 4_000
"""Nodes beyond which the program refines no mesh that it chose."""
SHARE = 0.5
"""Part of its share of the accuracy beyond which an element is too large."""


class MeshWatch:
    """Estimates the errors that the mesh of one problem leaves in its equilibria.

    Args:
        model: that was discretised; problem: what came of it; system: that solves it.

    Attributes:
        estimate: the largest errors of all solutions seen, None before the first.
        lost: how many solutions had no counterpart on a finer mesh.
    """

    def __init__(self, model: ModelDescription, problem: Problem, system: System) -> None:
        self.model, self.problem, self.system = model, problem, system
        self.estimate: MeshEstimate | None = None
        self.lost = 0

    @cached_property
    def finer(self) -> FinerMesh:
        """The problem on elements half as long."""
        return FinerMesh(self.model, self.problem)

    @property
    def feasible(self) -> bool:
        """Whether the problem is small enough for a finer one beside it."""
        return self.problem.size <= MOST_NODES

    def see(self, state: State, t: float = 0.0, *, before: bool = True, scale: float = 1.0) -> None:
        """Estimate the errors of an equilibrium, which the system evaluated last.

        Args:
            state: of it; t, before, scale: time [s] of the loads, whether from the left, their multiple.
        """
        if not self.feasible:
            return
        force, near = self.system.gauss_points().section_force, self.system.constraints.near
        shape = Shape(state, force, near.copy())
        finer = self.finer
        other = finer.take_over(shape)
        report = finer.static.newton(other, t, before=before, scale=scale)
        if not report.converged:
            self.lost += 1
            return
        found = Shape(other, finer.system.gauss_points().section_force, shape.near)
        self.estimate = difference(finer, shape, found).joined(self.estimate)

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its mesh."""
        found: dict[str, Any] = {}
        if self.estimate is not None:
            found["mesh_errors"] = json.dumps(self.estimate.rods)
            found["mesh_motion_error"], found["mesh_force_error"] = self.estimate.motion, self.estimate.force
        if self.lost:
            found["mesh_lost"] = self.lost
        return found

    def too_coarse(self, accuracy: float) -> bool:
        """Whether an error is larger than wanted, or could not be estimated."""
        return self.lost > 0 or (self.estimate is not None and self.estimate.largest > accuracy)

    def refined(self, accuracy: float) -> Divisions | None:
        """Return finer divisions of the rods whose mesh the program may choose, where elements are too large.

        Returns:
            None if there is nothing to refine, or the mesh would become very large.
        """
        divisions = divisions_of(self.problem)
        free = [name for name, rod in self.model.rods.items() if rod.elements is None]
        if not free or not self.too_coarse(accuracy):
            return None
        marked = {name: self._marked(name, divisions[name], accuracy) for name in free}
        if not any(mask.any() for mask in marked.values()):
            marked = {name: np.ones(divisions[name].count, dtype=bool) for name in free}
        refined = {name: self._finer(name, divisions[name], mask) for name, mask in marked.items()}
        found = divisions | refined
        if sum(division.order * division.count for division in found.values()) > MOST_CHOSEN_NODES:
            return None
        return found

    def _marked(self, name: str, division: Division, accuracy: float) -> np.ndarray:
        """Return which elements are too large: all, where no solution on a finer mesh was found."""
        if self.estimate is None or self.lost:
            return np.ones(division.count, dtype=bool)
        errors = self.estimate.elements[name]
        too_large = np.zeros(division.count, dtype=bool)
        if self.estimate.motion > accuracy:
            too_large |= errors[:, 0] * division.count > SHARE * accuracy
        if self.estimate.force > accuracy:
            too_large |= errors[:, 1] > SHARE * accuracy
        return too_large

    def _finer(self, name: str, division: Division, marked: np.ndarray) -> Division:
        """Return a division whose marked elements are halved; many small ones of low order get a higher one instead."""
        rod = self.model.rods[name]
        if rod.order is None and division.order < DEFAULT_ORDER and marked.mean() > SHARE:
            return Division(division.order + 1, division.ends)
        return division.halved(marked)

"""Which elements to halve, or to raise in order, for an error that a mesh leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import DEFAULT_ORDER
from viscorod.solve.problem.division import Division, Divisions, divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.mesh_estimate import MeshEstimate

__all__ = ["MOST_CHOSEN_NODES", "FinerDivisions", "free_rods"]

MOST_CHOSEN_NODES = 4_000
"""Nodes beyond which the program refines no mesh that it chose."""
SHARE = 0.5
"""Part of the accuracy beyond which an element is too large."""


def free_rods(model: ModelDescription) -> list[str]:
    """Return the names of the rods whose mesh the program may choose."""
    return [name for name, rod in model.rods.items() if rod.elements is None]


@dataclass(frozen=True)
class FinerDivisions:
    """Refines the rods whose mesh the program may choose, where their elements are too large.

    Attributes:
        model: that was discretised; problem: what came of it.
        accuracy: largest error of positions over the displacements; forces: of section forces over the largest.
    """

    model: ModelDescription
    problem: Problem
    accuracy: float
    forces: float

    def of(self, estimate: MeshEstimate | None, most: int) -> Divisions | None:
        """Return finer divisions for an estimate of the errors; where there is None, all elements are too large.

        Returns:
            None if there is nothing to refine, or there would be more than ``most`` nodes.
        """
        divisions, free = divisions_of(self.problem), free_rods(self.model)
        if not free or not (estimate is None or self._too_coarse(estimate)):
            return None
        marked = {name: self._marked(name, divisions[name], estimate) for name in free}
        if not any(mask.any() for mask in marked.values()):
            marked = {name: np.ones(divisions[name].count, dtype=bool) for name in free}
        found = divisions | {name: self._finer(name, divisions[name], mask) for name, mask in marked.items()}
        if sum(division.order * division.count for division in found.values()) > most:
            return None
        return found

    def _too_coarse(self, estimate: MeshEstimate) -> bool:
        return estimate.mendable > self.accuracy or estimate.force > self.forces

    def _marked(self, name: str, division: Division, estimate: MeshEstimate | None) -> np.ndarray:
        """Return which elements of a rod are too large."""
        if estimate is None:
            return np.ones(division.count, dtype=bool)
        errors = estimate.of_elements(name)
        too_large = np.zeros(division.count, dtype=bool)
        if estimate.mendable > self.accuracy:
            too_large |= errors[:, 0] > SHARE * self.accuracy
        if estimate.force > self.forces:
            too_large |= errors[:, 1] > SHARE * self.forces
        return too_large

    def _finer(self, name: str, division: Division, marked: np.ndarray) -> Division:
        """Return a division whose marked elements are halved; many small ones of low order get a higher one instead."""
        rod = self.model.rods[name]
        if rod.order is None and division.order < DEFAULT_ORDER and marked.mean() > SHARE:
            return Division(division.order + 1, division.ends)
        return division.halved(marked)

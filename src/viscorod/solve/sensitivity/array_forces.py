"""How the balances of all stages of a step change with the arrays of the problem, and the transpose of that.

The balance is ``R = M x' + L1(x) M x + f_int - f_ext`` with ``f_int = sum_g w_g B^T S`` and ``S = C eps + D eps'``: it
is linear in the arrays, so that its derivatives by them are those formulas once more, with other stresses and masses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.elements.section_laws import BY_RATE, BY_STRAIN
from viscorod.mechanics.nodes.inertia import add_coriolis
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.external_loads import load_count
from viscorod.solve.problem.law_responses import law_responses
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.array_gradients import add_of_elements, add_of_inertia
from viscorod.solve.sensitivity.stage_terms import fall
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.sensitivity.stage_records import StageRecord

__all__ = ["ArrayForces"]


class ArrayForces:
    """Changes of the balances of all stages.

    Args:
        actions: loads of the model, on a system that nothing else works with; stages: of the method.

    Attributes:
        operators: of all elements at the stages, written by whoever linearises; B: of the strains, the same arrays.
        weights: of the Gauss points ``(e, points)`` [m]; scale: of the multipliers at the stages ``(s, places)``.
    """

    def __init__(self, actions: StepActions, stages: int) -> None:
        self.actions, self.problem = actions, actions.system.problem
        self._elements = elements = actions.system.elements()
        count, points, _ = elements.reference.shape
        shape = (stages, count, 6 * points, 6 * (points + 1))
        self.B, force, viscous = np.zeros((3, *shape))
        self.operators = [Operators(*arrays) for arrays in zip(self.B, force, viscous, strict=True)]
        self.weights = elements.half_lengths[:, None] * elements.weights[elements.order]
        self._times: list[tuple[float, bool]] = [(0.0, False)] * stages
        self._gravity, self._fall = np.zeros((stages, 3)), np.zeros((stages, self.problem.size, 6))
        self.scale = np.zeros((stages, len(actions.system.constraints.scale)))
        self._virtual: Floats = np.zeros((stages, count, points, 6))
        self._of_elements, self._of_inertia = KnownTypes(add_of_elements), KnownTypes(add_of_inertia)
        self._falling = KnownTypes(fall)
        self._step: StageRecord

    def take(self, i: int, t: float, before: bool, scale: Floats) -> None:
        """Take the loads of stage ``i`` at ``t`` [s]; ``scale``: of the multipliers."""
        self._times[i] = t, before
        self.scale[i] = scale
        self._gravity[i] = self.actions.loads.at(t, before).gravity

    def begin(self, step: StageRecord) -> None:
        """Take a step, whose stages have been taken and whose operators are written."""
        self._step = step
        # gravity is an acceleration of the whole model the other way
        self._falling.call(step.q, step.acceleration, self._gravity, self._fall)

    def force(self, changes: ArrayChanges) -> Floats:
        """Return the changes ``(s, N, 6)`` of the balances with the arrays, at constant motion and multipliers."""
        step, elements, held = self._step, self._elements, self.problem.held
        section, n = elements.section, self.problem.size
        stress = np.einsum("egij,segj->segi", changes.stiffness[section], step.strain)
        stress += np.einsum("egij,segj->segi", changes.damping[section], step.strain_rate)
        stress -= np.einsum("segij,egj->segi", self._tangents(), changes.reference)
        stress *= self.weights[:, :, None]
        nodal = np.einsum("sera,ser->sea", self.B, stress.reshape(*self.B.shape[:3]))
        found = np.zeros((len(stress), n + self.problem.multipliers, 6))
        for i, out in enumerate(found):
            np.add.at(out, elements.nodes, nodal[i].reshape(*elements.nodes.shape, 6))
            out[:n] += np.einsum("nij,nj->ni", changes.mass, self._fall[i])
            add_coriolis(changes.mass, step.twist[i], out[:n])
            for load in np.flatnonzero(changes.factors):
                out[:n] -= changes.factors[load] * self.unit_load(i, int(load))
            gaps = np.zeros_like(self.scale[i])
            gaps[held.place] = -changes.reference[held.element, held.point, held.component]
            out[n:] = (self.scale[i] * gaps).reshape(-1, 6)
        return found

    def gradient(self, weights: Floats, *, loads: bool = True) -> ArrayChanges:
        """Return the derivatives of the sum of ``weights (s, N, 6)`` times the balances by the arrays.

        Those by the factors of the ``loads`` only if they are wanted.
        """
        found = ArrayChanges.none(self.problem, self._elements)
        self.add_gradient(weights, found, loads=loads)
        return found

    def add_gradient(self, weights: Floats, found: ArrayChanges, *, loads: bool = True) -> None:
        """Add what :meth:`gradient` returns."""
        step, elements, problem, held = self._step, self._elements, self.problem, self.problem.held
        n = problem.size
        nodal = np.ascontiguousarray(weights[:, :n])
        places = elements.nodes, elements.section
        by = found.stiffness, found.damping
        self._of_elements.call(
            self.B, self.weights, *places, step.strain, step.strain_rate, nodal, self._virtual, *by
        )
        np.subtract(
            found.reference,
            np.einsum("segji,segj->egi", self._tangents(), self._virtual)
            if elements.laws.present
            else (self._virtual.sum(axis=0)[..., None, :] @ elements.stiffness[elements.section])[..., 0, :],
            out=found.reference,
        )
        self._of_inertia.call(nodal, step.twist, self._fall, found.mass)
        for i in range(len(nodal)):
            if len(held.place):
                gaps = self.scale[i] * weights[i, n:].ravel()
                found.reference[held.element, held.point, held.component] -= gaps[held.place]
            for load in range(len(found.factors) if loads else 0):
                found.factors[load] -= float(np.vdot(nodal[i], self.unit_load(i, load)))

    def unit_load(self, i: int, load: int) -> Floats:
        """Return the forces ``(n, 6)`` of one load with the factor 1 at stage ``i``."""
        step, (t, before) = self._step, self._times[i]
        given = dict.fromkeys(range(load_count(self.problem)), 0.0) | {load: 1.0}
        found: Floats = np.zeros((self.problem.size, 6))
        state = State(step.r[i], step.q[i], step.twist[i])
        self.actions.add_loads(t, state, found, before=before, given=given)
        return found

    def _tangents(self) -> Floats:
        """Return the derivatives of section forces by strains ``(s, e, points, 6, 6)``, at constant rates."""
        elements, step = self._elements, self._step
        found = np.broadcast_to(elements.stiffness[elements.section], (*step.strain.shape, 6))
        if elements.laws.present:
            laws = [
                law_responses(elements.laws, elements.section, *points)[..., BY_STRAIN:BY_RATE]
                for points in zip(step.strain, step.strain_rate, strict=True)
            ]
            found = found + np.array(laws).reshape(found.shape)
        return np.asarray(found)

"""Strains and section forces of all elements at all phases of an orbit.

Maxwell branches are linear in the strains: at all phases their springs are stretched by ``w tau D (1 + w tau D)^-1
eps``, which is their complex modulus at every harmonic.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import ElementWork, GaussStates, internal_forces
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.periodic.fourier import Fourier
from viscorod.solve.periodic.orbit import Frozen, Linearised
from viscorod.typing import Floats

__all__ = ["OrbitSections"]


class OrbitSections:
    """Section forces of an orbit, and the nodal forces that balance them.

    Args:
        system: of the model; supports: of it; fourier: the phases.

    Attributes:
        points: strains, their rates and section forces at the Gauss points, as last computed.
        memory: Maxwell branches of the sections; None without any.
    """

    def __init__(self, system: GeometricSystem, supports: SupportState, fourier: Fourier) -> None:
        self.problem, self.supports, self.fourier = system.problem, supports, fourier
        self.elements, self.memory = system.elements(), system.relaxation
        self.points = GaussStates.of(self.elements, fourier.count, carried=True)
        self._work = ElementWork.of(self.elements.nodes.shape[1] - 1)

    def internal(
        self,
        r: Floats,
        q: Floats,
        twist: Floats,
        multiplier: Floats,
        omega: float,
        frozen: Frozen | None,
    ) -> tuple[Floats, Floats]:
        """Return internal forces of the nodes ``(N, n, 6)`` and strains of the springs of branches; write ``points``.

        Args:
            r, q, twist: of all nodes at all phases ``(N, n, 3)``, ...; multiplier: of held strains ``(N, places)``.
            omega: angular frequency [rad/s]; frozen: stresses of their own, if they are.
        """
        points, elements, held = self.points, self.elements, self.problem.held
        force = np.zeros_like(twist)
        memory, spring = self.memory, np.zeros((0, *points.strain.shape))
        simple = memory is None and not len(held.place)
        if frozen is not None:
            points.stress[:] = frozen.stress
        own = points._replace(stress=points.section_force) if simple and frozen is None else points
        internal_forces(elements, r, q, twist, own, self._work, force)
        if simple:
            if frozen is None:
                points.stress[:] = points.section_force
            return force, spring
        forces = points.section_force.copy()
        if memory is not None:
            spring = np.tensordot(self.responses(omega), points.strain, axes=1)
            for j in range(len(memory.times)):
                modulus = memory.branches[elements.section, j]
                forces += np.einsum("egij,pegj->pegi", modulus, spring[j])
        at = held.element, held.point, held.component
        forces[:, *at] = multiplier[:, held.place] / held.weight
        points.stress[:] = forces if frozen is None else frozen.stress
        points.stress[:, *at] = forces[:, *at]
        internal_forces(elements, r, q, twist, points, self._work, force)
        points.section_force[:] = forces
        return force, spring

    def carried(self, stress: Floats, linear: Linearised, change: Floats, omega: float) -> Floats:
        """Return section forces ``(N, e, points, 6)`` after body increments ``(N, N_b, 6)``, to first order."""
        elements, n = self.elements, self.problem.size
        poses = np.ascontiguousarray(change[:, :n])
        twists = np.einsum("kpqij,qkj->pki", linear.V, poses)
        width = 6 * elements.nodes.shape[1]
        at = [
            part[:, elements.nodes].reshape(len(part), len(elements.nodes), width) for part in (poses, twists)
        ]
        own = (linear.force @ at[0][..., None] + linear.viscous @ at[1][..., None])[..., 0]
        found = stress + own.reshape(stress.shape)
        memory = self.memory
        if memory is not None:
            strain = (linear.strain @ at[0][..., None])[..., 0].reshape(stress.shape)
            for j, response in enumerate(self.responses(omega)):
                modulus = memory.branches[elements.section, j]
                found += np.einsum("egij,pegj->pegi", modulus, np.tensordot(response, strain, axes=1))
        return np.asarray(found)

    def through(self, frozen: Frozen) -> Floats:
        """Return the forces ``(N, n, 6)`` of what stresses lack, through frozen operators."""
        elements, points, supports = self.elements, self.points, self.supports
        lacking = (points.section_force - frozen.stress) * self.weights()[..., None]
        lacking[:, self.problem.held.element, self.problem.held.point, self.problem.held.component] = 0.0
        flat = lacking.reshape(*lacking.shape[:2], 6 * lacking.shape[2], 1)
        nodal = (np.swapaxes(frozen.linear.strain, -1, -2) @ flat)[..., 0]
        nodal = nodal.reshape(*nodal.shape[:2], elements.nodes.shape[1], 6)
        found = np.zeros((len(nodal), self.problem.size, 6))
        for e, nodes in enumerate(elements.nodes):
            for k in range(int(elements.order[e]) + 1):
                found[:, nodes[k]] += nodal[:, e, k]
        for number, k in enumerate(supports.partial):
            node = int(supports.set.nodes[k])
            along = np.einsum("pij,pi->pj", frozen.linear.Z[:, number], found[:, node])
            found[:, node] = np.where(supports.set.fixed[k] != 0.0, 0.0, along)
        return found

    def responses(self, omega: float) -> Floats:
        """Return by what the strains at all phases give those of the springs of all branches ``(branches, N, N)``."""
        times, D = self.problem.relaxation_times, omega * self.fourier.derivative()
        unit = np.eye(len(D))
        return np.array([np.linalg.solve(unit + tau * D, tau * D) for tau in times]).reshape(-1, *D.shape)

    def weights(self) -> Floats:
        """Return lengths that the Gauss points stand for ``(e, points)`` [m]."""
        elements = self.elements
        return np.asarray(elements.half_lengths[:, None] * elements.weights[elements.order])

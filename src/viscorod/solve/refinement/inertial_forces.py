"""Inertial forces of a state of motion, as the finer mesh has them: from what does not balance on the coarse one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.history import station_reader
from viscorod.solve.problem.external_loads import NO_LOADS, ExternalLoads
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape
from viscorod.solve.refinement.half_elements import read
from viscorod.typing import Floats

__all__ = ["CoarseMotion"]


class CoarseMotion:
    """Evaluates what does not balance in a motion on the coarse mesh.

    Args:
        finer: the mesh that takes over.
    """

    def __init__(self, finer: FinerMesh) -> None:
        self.finer, self.problem = finer, finer.coarse
        self.system = GeometricSystem(self.problem)
        self.system.relaxation = None
        self.supports = SupportState(self.problem)
        self.loads = ExternalLoads(self.problem)
        self._reader = station_reader(self.problem)
        # supported nodes follow apart: the mass of a point mass whose rotations are held has no inverse
        loose = np.ones(self.problem.size, dtype=bool)
        loose[self.supports.set.nodes] = False
        self._loose = np.flatnonzero(loose)

    def other_stress(self, state: State, section_force: Floats, t: float, *, before: bool) -> Floats:
        """Return the section forces that the strains of the poses do not explain ``(m, 6)``.

        These are viscous ones and those of branches, and what strains that are known by themselves have in addition, in
        the intrinsic formulation and between two steps. Strains that multipliers hold have none. Rest strains are those
        at the time ``t`` [s], from the left if ``before``.
        """
        self.system.prestress = np.zeros((0, 1, 6))
        self.system.impose_rest(Imposed(1.0, t, before))
        self.system.assemble(state, NO_LOADS, None, tangent=False, moving=False)
        held = np.einsum("mii->mi", self.system.gauss_positions().stiffness) == 0.0
        return np.where(held, 0.0, section_force - self.system.gauss_points().section_force)

    def rates(
        self, shapes: Sequence[Shape], stresses: Sequence[Floats], times: Sequence[float], *, before: bool
    ) -> Floats:
        """Return the rates of the twists of the coarse nodes ``(k, n, 6)``, with what turning axes make of velocities.

        Args:
            shapes: some states of the coarse mesh; stresses: section forces beside the elastic ones ``(m, 6)``, and
                times [s] of loads and supports, of each; before: whether from the left.
        """
        problem, system, loose = self.problem, self.system, self._loose
        forces, found = np.zeros((2, len(shapes), problem.size, 6))
        for k, (shape, stress, t) in enumerate(zip(shapes, stresses, times, strict=True)):
            self.supports.update(t, before)
            if len(shape.near):
                system.constraints.near[:] = shape.near
            system.constraints.update(t, before)
            system.prestress = self.finer.arranged(stress, system)
            system.assemble(shape.state, self.loads.at(t, before), None, tangent=False, moving=False)
            np.subtract(system.external, system.internal, out=forces[k])
            self._obey_supports(shape.state, forces[k], found[k])
        found[:, loose] = np.linalg.solve(problem.mass[loose], forces[:, loose, :, None])[..., 0]
        return found

    def _obey_supports(self, state: State, force: Floats, rate: Floats) -> None:
        """Set rates of twists that supports prescribe, whose reactions are not among the forces."""
        supports, mass = self.supports, self.problem.mass
        nodes = supports.set.nodes
        if len(supports.complete):
            rate[nodes[supports.complete]] = supports.complete_motion()[3] if supports.moving else 0.0
        for k in supports.partial:
            free = supports.set.fixed[k] == 0.0
            directions = supports.free_directions(int(k), state)
            N, P = directions[:, free], directions[:, ~free]
            given = P @ supports.acceleration[k][~free]
            node = nodes[k]
            own = N.T @ mass[node] @ N
            rate[node] = given
            if free.any():
                rate[node] += (
                    N @ np.linalg.lstsq(own, N.T @ (force[node] - mass[node] @ given), rcond=None)[0]
                )

    def inertia(self, r: Floats, q: Floats, rates: Floats, fine_q: Floats | None = None) -> Floats:
        """Return minus mass times rates ``(k, n, 6)`` on the finer nodes ``(k, n', 6)``: see :meth:`fields`."""
        return np.asarray(
            -np.einsum("nij,knj->kni", self.finer.problem.mass, self.fields(r, q, rates, fine_q))
        )

    def fields(self, r: Floats, q: Floats, rates: Floats, fine_q: Floats | None = None) -> Floats:
        """Return twists, or rates of them, ``(k, n, 6)`` on the finer nodes ``(k, n', 6)``, body axes.

        Rates of displacement are mixed in global axes. They act beside the loads.

        Args:
            r, q: poses of the coarse nodes, in one state ``(n, 3)``, ``(n, 4)`` or in as many ``(k, n, ...)``.
            rates: ``(k, n, 6)``; fine_q: unit quaternions of the finer stations, if they are known.
        """
        finer, fine, number = self.finer, self.finer.problem, len(rates)
        count, bodies = len(self.problem.stations.nodes), finer.bodies
        if fine_q is None:
            fine_q = finer.interpolated(r, q)[1]
        r, q = (np.broadcast_to(x, (number, *x.shape[-2:])) for x in (r, q))
        _, _, linear, angular = self._reader.read(r, q, rates)
        field = read(finer.halves.stations, np.concatenate([linear, angular], axis=2)[:, :count])
        own = fine.stations.links < 0
        nodes = fine.stations.nodes[own]
        found = np.zeros((number, fine.size, 6))
        found[:, :bodies] = rates[:, :bodies]
        axes = matrices(fine_q[..., own, :].reshape(-1, 4)).reshape(-1, len(nodes), 3, 3)
        found[:, nodes, :3] = np.einsum(
            "knji,knj->kni", np.broadcast_to(axes, (number, *axes.shape[1:])), field[:, own, :3]
        )
        found[:, nodes, 3:] = field[:, own, 3:]
        return found

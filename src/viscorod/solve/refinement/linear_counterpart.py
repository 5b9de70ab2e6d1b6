"""A linear motion on a finer mesh: what its states become there, with the linear model of that mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse.linalg as spla
from scipy import sparse

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product, rotation_vectors
from viscorod.solve.history import Snapshot
from viscorod.solve.refinement.finer_mesh import Shape
from viscorod.solve.refinement.inertial_forces import CoarseMotion
from viscorod.solve.transient.integrators.linear_model import LinearModel
from viscorod.typing import Floats

__all__ = ["LinearCounterpart"]

NO_JOINTS = np.zeros(0)


class LinearState(NamedTuple):
    """Displacements, velocities and accelerations of the nodes, body axes of the start, each ``(6 n,)``."""

    displacement: Floats
    velocity: Floats
    acceleration: Floats


class LinearCounterpart:
    """Estimates what the linear motion of a mesh is on the one twice as fine.

    Args:
        coarse: the linear model of the mesh; finer: that of the finer mesh, about the same state there.
        moving: carries fields over from one to the other.
    """

    def __init__(self, coarse: LinearModel, finer: LinearModel, moving: CoarseMotion) -> None:
        self.coarse, self.finer, self.moving = coarse, finer, moving

    def state(self, snapshot: Snapshot, t: float, *, before: bool) -> LinearState:
        """Return a state of the motion on the coarse mesh under the loads at a time [s]."""
        base, state = self.coarse.base, snapshot.state
        moved = np.empty((len(state.r), 6))
        moved[:, :3] = np.einsum("nji,nj->ni", matrices(base.q), state.r - base.r)
        moved[:, 3:] = rotation_vectors(product(conjugate(base.q), state.q))
        xi, x, reduced = moved.ravel(), state.twist.ravel(), self.coarse.reduced
        force = self.coarse.loads(t, before) - self.coarse.internal(xi, x)
        rate = spla.spsolve(sparse.csc_array(reduced.mass), reduced.basis.T @ force)
        return LinearState(xi, x, reduced.basis @ rate)

    def better(self, now: LinearState, t: float, *, before: bool, anchor: float) -> Shape:
        """Return what a state becomes on the finer mesh: what does not balance there moves it.

        Args:
            now: the state; t: time of the loads [s]; before: whether from the left.
            anchor: stiffness over mass [1/s^2] by which inertia resists (see ``Balance``).
        """
        finer, reduced = self.finer, self.finer.reduced
        base = self.coarse.base
        xi, x, a = self.moving.fields(base.r, base.q, np.array(now).reshape(3, -1, 6)).reshape(3, -1)
        force = finer.loads(t, before) - finer.internal(xi, x) - finer.mass @ a
        stiffness = sparse.csc_array(reduced.stiffness + anchor * reduced.mass)
        xi = xi + reduced.basis @ spla.spsolve(stiffness, reduced.basis.T @ force)
        found = finer.snapshot(xi, x, a, finer.loads(t, before))
        return Shape(found.state, found.section_force, NO_JOINTS)

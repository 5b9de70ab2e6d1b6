"""A discretised model at a random state, its balance as generalised-alpha has it, for the tests of tangents."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.rotations.rotation import inverse_motion_tangent, retract
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.transient.integrators.generalized_alpha import GeneralizedAlpha
from viscorod.solve.transient.integrators.momentum_model import Relation

TIME = 0.3


class DiscreteModel:
    def __init__(self, model, seed=3):
        rng = np.random.default_rng(seed)
        self.problem = discretise(model)
        self.system = GeometricSystem(self.problem)
        self.supports = SupportState(self.problem)
        self.loads = ExternalLoads(self.problem).at(TIME)
        self.supports.update(TIME)
        n = self.problem.size
        self.n = n
        self.old = State.reference(self.problem)
        retract(self.old.r, self.old.q, 0.2 * rng.normal(size=(n, 6)), self.old.r, self.old.q)
        self.increment = 0.3 * rng.normal(size=(n, 6))
        self.relation = Relation(7.0, rng.normal(size=(n, 6)), rng.normal(size=(n, 6)))
        self.integrator = GeneralizedAlpha(self.system, self.supports, spectral_radius=0.8)
        self.integrator.state = self.old

    def residual(self, increment, tangent=False):
        """Balance of all nodes before supports; assembled matrix with ``tangent``."""
        new = self.old.copy()
        self.integrator._update_state(new, increment, self.relation)
        inverse_motion_tangent(increment, self.relation.slope, self.integrator._map)
        self.system.assemble(new, self.loads, self.integrator._map, tangent=tangent, moving=True)
        return new, self.integrator._residual(new, self.relation, tangent=tangent)

    def moved(self, x):
        """Increment after the body change ``x`` of the pose that ``self.increment`` reaches."""
        T = np.empty((self.n, 6, 6))
        # the derivative of the increment is T^-1; a finite x needs the exact composition
        inverse_motion_tangent(self.increment, 1.0, T)
        return self.increment + np.einsum("nij,nj->ni", T, x.reshape(self.n, 6))

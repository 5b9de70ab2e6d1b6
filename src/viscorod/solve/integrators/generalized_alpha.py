"""Generalised-alpha on the Lie group, in poses and spatial momenta.

The equations of motion are first order in the poses ``H`` (with ``H_t = H x1``) and the spatial momenta ``pi`` (with ``pi_t``
= resultant wrench about the origin). Both are advanced by the generalised-alpha method for first-order systems (Jansen,
Whiting and Hulbert 2000), the poses on SE(3) by the exponential (as Bruels and Cardona 2010 do for the second-order
method):

    D/h  = (1-g) xi_n + g xi_n+1      (1-am) xi_n+1 + am xi_n = (1-af) x1_n+1 + af x1_n       H_n+1 = H_n exp(D)

and the same for ``pi`` with the wrenches in place of the twists. It is of second order, dissipates only high frequencies,
``rho`` being the spectral radius at infinity, and keeps linear and angular momentum of a free body to round-off, because
internal forces have no spatial resultant and the scheme is linear in the momenta.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics import inertia
from viscorod.mechanics.rotation import inverse_motion_tangent, retract
from viscorod.solve.loads import ExternalLoads
from viscorod.solve.newton import Convergence, NewtonReport, Outcome, SingularMatrixError, worst_node
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System
from viscorod.typing import Floats


@dataclass(frozen=True)
class Coefficients:
    """The three numbers of the method for a spectral radius ``rho`` at infinite frequency in [0, 1]."""

    mass: float
    force: float
    gamma: float

    @classmethod
    def of(cls, rho: float) -> Coefficients:
        """Second order and optimal dissipation (Jansen, Whiting and Hulbert 2000, in the convention of Bruels and Cardona)."""
        return cls(mass=(3.0 * rho - 1.0) / (2.0 * (1.0 + rho)), force=rho / (1.0 + rho), gamma=1.0 / (1.0 + rho))


class GeneralizedAlpha:
    """Implicit one-step integrator of second order (see the module's text).

    Args:
        system, supports: what is integrated.
        spectral_radius: 1 damps nothing numerically, 0 annihilates the highest frequencies in one step.
        tolerance: size of the last Newton increment (displacement over model length, rotation in rad).
        iterations: allowed Newton iterations per step.
    """

    def __init__(
        self,
        system: System,
        supports: SupportState,
        *,
        spectral_radius: float = 0.8,
        tolerance: float = 1e-9,
        iterations: int = 12,
    ) -> None:
        self.system = system
        self.supports = supports
        self.loads = ExternalLoads(system.problem)
        self.coefficients = Coefficients.of(spectral_radius)
        self.tolerance = tolerance
        self.iterations = iterations
        n = system.problem.size
        self.t = 0.0
        self.state = State(system.problem.positions.copy(), system.problem.quaternions.copy(), np.zeros((n, 6)))
        self.kinetic = 0.0
        self._twist_mean: Floats = np.zeros((n, 6))  # xi
        self._momentum: Floats = np.zeros((n, 6))
        self._wrench: Floats = np.zeros((n, 6))
        self._wrench_mean: Floats = np.zeros((n, 6))  # b
        self._rate: Floats = np.zeros((n, 6))  # twist rate, for predicting
        self._map = np.zeros((n, 6, 6))
        self._held = supports.set.nodes[supports.complete]

    def start(self, t: float, state: State, h: float) -> None:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        system, supports, c = self.system, self.supports, self.coefficients
        mass = system.problem.mass
        supports.update(t, False)
        supports.prescribe(state)
        supports.project_twists(state)
        system.assemble(state, self.loads.at(t), None, tangent=False, moving=True)
        system.reset_stress()
        gyroscopic = np.zeros_like(system.internal)
        inertia.add_coriolis(mass, state.twist, gyroscopic)
        self._rate = supports.accelerations(state, system.external - system.internal - gyroscopic)
        inertial = np.einsum("nij,nj->ni", mass, self._rate) + gyroscopic
        residual = inertial + system.internal - system.external
        supports.impose(state, residual, system.band, tangent=False)
        inertia.spatial_wrenches(state.r, state.q, inertial, self._wrench)
        self._wrench_mean = self._wrench.copy()
        self._twist_mean = state.twist + (c.mass - c.force) * h * self._rate
        self.kinetic = inertia.momenta(mass, state.r, state.q, state.twist, self._momentum)
        self.t = t
        self.state = state

    def step(self, h: float, *, before: bool) -> NewtonReport:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        system, supports, old = self.system, self.supports, self.state
        mass, c = system.problem.mass, self.coefficients
        supports.update(self.t + h, before)
        loads = self.loads.at(self.t + h, before)
        # twist = slope * increment + constant; wrench = slope * momentum + history
        slope = (1.0 - c.mass) / ((1.0 - c.force) * c.gamma * h)
        lag = c.mass / (1.0 - c.force) - (1.0 - c.gamma) * slope * h
        keep = c.force / (1.0 - c.force)
        constant = lag * self._twist_mean - keep * old.twist
        history = lag * self._wrench_mean - keep * self._wrench - slope * self._momentum

        increment = h * old.twist + 0.5 * h * h * self._rate
        increment[self._held] = 0.0
        new = old.copy()
        convergence = Convergence(system.problem.length, self.tolerance, self.iterations)
        count, imbalance, node = 0, 0.0, 0
        while True:
            retract(old.r, old.q, increment, new.r, new.q)
            np.multiply(increment, slope, out=new.twist)
            new.twist += constant
            supports.prescribe(new)
            inverse_motion_tangent(increment, slope, self._map)
            self._map[self._held] = 0.0
            system.assemble(new, loads, self._map, tangent=True, moving=True)
            residual = self._residual(new, slope, history, tangent=True)
            supports.impose(new, residual, system.band, tangent=True)
            try:
                system.band.factorise()
            except SingularMatrixError as error:
                return self._failed(NewtonReport(Outcome.SINGULAR, count, 0.0, imbalance, error.row // 6))
            change = system.band.solve(-residual)
            count += 1
            verdict, size = convergence.judge(change, count)
            if verdict not in (None, Outcome.CONVERGED):
                imbalance, node = worst_node(residual, system.problem.length)
                return self._failed(NewtonReport(verdict, count, size, imbalance, node))
            increment += np.einsum("nij,nj->ni", self._map, change) / slope
            system.carry_stress(change)
            if verdict is Outcome.CONVERGED:
                break
        retract(old.r, old.q, increment, new.r, new.q)
        np.multiply(increment, slope, out=new.twist)
        new.twist += constant
        supports.prescribe(new)
        self._accept(new, h, increment, slope, history)
        return NewtonReport(Outcome.CONVERGED, count, size, imbalance, node)

    def _residual(self, new: State, slope: float, history: Floats, *, tangent: bool) -> Floats:
        system = self.system
        residual: Floats = system.internal - system.external
        inertia.add_momentum_rate(
            system.problem.mass,
            new.r,
            new.q,
            new.twist,
            slope,
            history,
            self._map,
            tangent,
            residual,
            system.band.data,
            system.band.diagonal,
        )
        return residual

    def _accept(self, new: State, h: float, increment: Floats, slope: float, history: Floats) -> None:
        system, supports, old, c = self.system, self.supports, self.state, self.coefficients
        mass = system.problem.mass
        self.t += h
        system.assemble(new, self.loads.last, None, tangent=False, moving=True)
        system.reset_stress()
        residual = self._residual(new, slope, history, tangent=False)
        supports.impose(new, residual, system.band, tangent=False)
        momentum = np.empty_like(self._momentum)
        self.kinetic = inertia.momenta(mass, new.r, new.q, new.twist, momentum)
        self._wrench_mean = ((momentum - self._momentum) / h - (1.0 - c.gamma) * self._wrench_mean) / c.gamma
        self._wrench = slope * momentum + history
        self._twist_mean = (increment / h - (1.0 - c.gamma) * self._twist_mean) / c.gamma
        if len(supports.partial):
            supports.project_twists(new)
            self.kinetic = inertia.momenta(mass, new.r, new.q, new.twist, momentum)
        self._momentum = momentum
        self._rate = (new.twist - old.twist) / h
        self.state = new

    def _failed(self, report: NewtonReport) -> NewtonReport:
        """Put system and supports back to the last accepted state."""
        self.supports.update(self.t, False)
        self.system.assemble(self.state, self.loads.at(self.t), None, tangent=False, moving=True)
        self.system.reset_stress()
        return report

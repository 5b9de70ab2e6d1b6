"""The velocities and strains in which a motion is sought: modes, and what they make of each other.

Vibration modes alone converge slowly. Bending makes a rod shorter in its own axes and puts it under tension where it
turns, which are products of two modes, and shared among axial modes far above those that are kept. So each product of
the intrinsic equations gets its quasi-static answer as a velocity of its own, as modal derivatives are in equations of
displacements (Idelsohn and Cardona 1985; Weeger, Wever and Simeon 2016): that to the strain rates that two modes
make, that to their inertial forces, and that to their elastic ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from viscorod.solve.modes.undamped import Undamped
from viscorod.solve.problem.problem import Problem
from viscorod.solve.reduced.point_operators import PointOperators, curved, momentum_flux, products
from viscorod.typing import Floats

__all__ = ["MotionBasis", "motion_basis"]

FACTORS = 24
"""Slowest modes whose products are answered."""
INDEPENDENT = 1e-6
"""Part of a vector that must be left beside the others for it to count."""


@dataclass(frozen=True)
class MotionBasis:
    """Velocities and strains of a reduced motion.

    Attributes:
        velocity: body twists of the nodes ``(6 n, k)``, orthonormal by the mass; the rigid motions first.
        omega: angular frequency of each within these velocities [rad/s], 0 of rigid motions.
        strain: strains at the Gauss points ``(l, m, 6)``, orthonormal by the stiffness: ``B phi/w`` of each velocity
            that is not rigid, in the same order, and self-stresses.
        rigid: number of rigid motions; modes: of vibration modes; answers: of quasi-static answers to their products.
    """

    velocity: Floats
    omega: Floats
    strain: Floats
    rigid: int
    modes: int
    answers: int


def motion_basis(
    problem: Problem,
    operators: PointOperators,
    undamped: Undamped,
    count: int,
    exact: Floats,
    static: Floats,
) -> MotionBasis:
    """Return a basis of some modes.

    Args:
        operators: of the problem; undamped: its modes about the unstressed shape.
        count: vibration modes, and as many answers to their products at most.
        exact: motions that are to be in the basis ``(6 n, k)``, and strains that are, by :func:`shape_of_strain`.
        static: forces whose static shapes join the answers ``(6 n, k)``.
    """
    basis = undamped.linear.basis
    rigid, modes = np.asarray(basis @ undamped.rigid), np.asarray(basis @ undamped.shapes[:, :count])
    omega = np.sqrt(np.maximum(undamped.squares[:count], 0.0))
    answers = _answers(problem, operators, undamped, rigid, modes, omega, static)
    mass = _Mass(problem)
    velocity = mass.joined(rigid, np.hstack([modes, exact, answers[:, :count]]))
    k = rigid.shape[1]
    # the modes and frequencies within these velocities
    rates = operators.rates(velocity[:, k:])
    form = products(rates, operators.stresses(rates))
    squares, turn = np.linalg.eigh(0.5 * (form + form.T))
    velocity[:, k:] = velocity[:, k:] @ turn
    frequency = np.sqrt(np.maximum(squares, 0.0))
    strain = operators.rates(velocity[:, k:]) / frequency[:, None, None]
    strain = np.concatenate([strain, _self_stresses(operators, undamped, strain)])
    found = velocity.shape[1] - k - modes.shape[1] - exact.shape[1]
    return MotionBasis(velocity, np.append(np.zeros(k), frequency), strain, k, modes.shape[1], max(found, 0))


def shape_of_strain(operators: PointOperators, undamped: Undamped, strain: Floats) -> Floats:
    """Return the small motions ``(6 n, k)`` that come nearest to strains ``(k, m, 6)``."""
    return static_shape(undamped, operators.forces(operators.stresses(strain)))


def static_shape(undamped: Undamped, forces: Floats) -> Floats:
    """Return the displacements ``(6 n, k)`` under nodal forces, without rigid motions."""
    basis = undamped.linear.basis
    return np.asarray(basis @ undamped.flexibility(np.asarray(basis.T @ forces)))


def _answers(
    problem: Problem,
    operators: PointOperators,
    undamped: Undamped,
    rigid: Floats,
    modes: Floats,
    omega: Floats,
    static: Floats,
) -> Floats:
    """Return answers to the products of modes ``(6 n, k)``, the most important first.

    Of unit elastic energy each, products of two modes count by one over both their frequencies, rigid ones by one over
    the first of the others; what modes have of them already does not count.
    """
    used = modes[:, :FACTORS]
    shapes = np.hstack([rigid, used])
    frequency = np.append(np.full(rigid.shape[1], omega[0]), omega[:FACTORS])
    weight = omega[0] / frequency
    strains = operators.rates(used) / omega[:FACTORS, None, None]
    twists = operators.twists(shapes)
    slow = weight[rigid.shape[1] :]
    pairs, both = np.triu_indices(len(weight)), np.triu_indices(len(slow))
    # strain rates of two modes
    rates = curved(twists[:, None], strains[None]).reshape(-1, *strains.shape[1:])
    kinematic = -operators.forces(operators.stresses(rates))
    # inertial forces
    nodal = shapes.T.reshape(-1, problem.size, 6)
    momenta = np.einsum("nij,knj->kni", problem.mass, nodal)
    flux = momentum_flux(nodal[pairs[0]], momenta[pairs[1]]) + momentum_flux(
        nodal[pairs[1]], momenta[pairs[0]]
    )
    inertial = flux.reshape(len(flux), -1).T
    # forces of stresses in the strained shape
    stresses = operators.stresses(strains)
    bent = stress_forces(stresses[both[0]], strains[both[1]]) + stress_forces(
        stresses[both[1]], strains[both[0]]
    )
    elastic = np.asarray(operators.twist.T @ bent.reshape(len(bent), -1).T)
    forces = np.hstack([static, kinematic, inertial, elastic])
    parts = [np.ones(static.shape[1]), np.outer(weight, slow).ravel()]
    parts += [weight[pairs[0]] * weight[pairs[1]], slow[both[0]] * slow[both[1]]]
    found = static_shape(undamped, forces)
    rate = operators.rates(found)
    energies = np.einsum("kgi,kgi->k", rate, operators.stresses(rate))
    kept = energies > 1e-18 * energies.max(initial=0.0)
    scale = np.concatenate(parts)[kept] / np.sqrt(energies[kept])
    found, rate = found[:, kept] * scale, rate[kept] * scale[:, None, None]
    within = products(strains, operators.stresses(rate))
    rate = rate - np.tensordot(within.T, strains, 1)
    gram = products(rate, operators.stresses(rate))
    values, vectors = np.linalg.eigh(gram)
    order = np.argsort(values)[::-1]
    return np.asarray(found @ vectors[:, order[values[order] > INDEPENDENT**2 * values.max(initial=0.0)]])


def stress_forces(stress: Floats, strain: Floats) -> Floats:
    """Return ``L2(S) eps = (N x kappa, N x gamma + M x kappa)`` of AWP (7), ``(..., 6)``."""
    N, M, gamma, kappa = stress[..., :3], stress[..., 3:], strain[..., :3], strain[..., 3:]
    return np.concatenate([np.cross(N, kappa), np.cross(N, gamma) + np.cross(M, kappa)], axis=-1)


def _self_stresses(operators: PointOperators, undamped: Undamped, strains: Floats) -> Floats:
    """Return strains of states of stress without loads ``(k, m, 6)``, orthonormal beside others.

    A rod that is held more than it needs has some, six for each closed loop. No vibration has any part of them, but
    two modes together stretch a rod between its ends.
    """
    motions = undamped.linear.basis.shape[1] - undamped.rigid.shape[1]
    count = 6 * operators.points - motions
    if count <= 0:
        return np.zeros((0, *strains.shape[1:]))
    tried = np.tile(np.eye(6)[:, None, :], (1, operators.points, 1))
    places = np.linspace(-1.0, 1.0, operators.points)[:, None]
    tried = np.concatenate([tried * places**k for k in range(-(-count // 6) + 1)])
    tried = tried - operators.rates(shape_of_strain(operators, undamped, tried))
    for _ in range(2):
        tried = tried - np.tensordot(products(operators.stresses(tried), strains), strains, 1)
    gram = products(tried, operators.stresses(tried))
    scale = 1.0 / np.sqrt(np.diag(gram))
    values, vectors = scipy.linalg.eigh(gram * np.outer(scale, scale))
    chosen = np.argsort(values)[::-1][:count]
    chosen = chosen[values[chosen] > INDEPENDENT * values.max()]
    return np.asarray(
        np.tensordot((scale[:, None] * vectors[:, chosen] / np.sqrt(values[chosen])).T, tried, 1)
    )


class _Mass:
    """The inertia of all nodes."""

    def __init__(self, problem: Problem) -> None:
        self.mass = problem.mass

    def times(self, x: Floats) -> Floats:
        """Return momenta ``(6 n, k)``."""
        nodal = x.reshape(len(self.mass), 6, -1)
        return np.asarray(np.einsum("nij,njk->nik", self.mass, nodal).reshape(x.shape))

    def joined(self, first: Floats, others: Floats) -> Floats:
        """Return orthonormal vectors and what others have beside them, orthonormal as well."""
        found = first
        for other in others.T:
            size = np.sqrt(max(float(other @ self.times(other[:, None])[:, 0]), 0.0))
            if size == 0.0:
                continue
            x = other / size
            for _ in range(2):
                x = x - found @ (self.times(found).T @ x)
            left = np.sqrt(max(float(x @ self.times(x[:, None])[:, 0]), 0.0))
            if left > INDEPENDENT:
                found = np.column_stack([found, x / left])
        return found

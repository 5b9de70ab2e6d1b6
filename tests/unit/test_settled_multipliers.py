"""Multipliers of joints after a step, against a dense solution of Gauss's principle."""

from __future__ import annotations

import numba
import numpy as np

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.mechanics.joints import settled_multipliers
from viscorod.mechanics.joints.joint_forces import gradient_of
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays

settle_multipliers = settled_multipliers.settle_multipliers


@numba.njit
def settle(joints, states, work, length, r, q, residual):
    settle_multipliers(joints, states, work, length, r, q, residual)


@numba.njit
def gradients(joints, r, q, out):
    for c in range(out.shape[0]):
        gradient_of(c, joints, r, q, 0.0, out[c])


def linkage():
    """Two bars, a hinge to the ground, a universal joint between them."""
    steel = vr.Material(210e9, 0.3, 7850.0)
    model = vr.Model()
    for name, ends in {"a": ((0, 0, 0), (0.5, 0, 0.1)), "b": ((0.5, 0, 0.1), (1.0, 0.2, 0.0))}.items():
        model.add(name, vr.Rod.straight(*ends, section=vr.Circle(0.01), material=steel, elements=1, order=2))
    model.revolute("a.start", "ground", (0, 1, 0))
    model.universal("a.end", "b.start", ((0, 1, 0), (0, 0, 1)))
    return DiscreteModel.of(model)


def test_what_is_left_is_the_least_that_gradients_allow():
    """Independent: least squares by NumPy, weighted with the inverse masses."""
    discrete = linkage()
    problem, constraints = discrete.problem, discrete.system.constraints
    arrays = ConstraintArrays.of(constraints, 1)
    rng = np.random.default_rng(3)
    left = rng.normal(size=(1, problem.size, 6))
    before = rng.normal(size=arrays.states.multiplier.shape)
    arrays.states.multiplier[:] = before
    place, nodes = arrays.joints.place, arrays.joints.nodes
    r, q = problem.positions[None].copy(), problem.quaternions[None].copy()
    all_gradients = np.zeros((len(place), 12))
    gradients(arrays.joints, r[0], q[0], all_gradients)
    G = np.zeros((before.shape[1], problem.size, 6))
    for c in np.flatnonzero(place >= 0):
        for side in range(2):
            if nodes[c, side] >= 0:
                G[place[c], nodes[c, side]] += all_gradients[c, 6 * side : 6 * side + 6]
    weight = np.sqrt(arrays.settling.inverse).ravel()
    rows = G.reshape(len(G), -1)
    change = np.linalg.lstsq((rows * weight).T, -weight * left.ravel(), rcond=None)[0]
    expected = left.ravel() + rows.T @ change
    settle(arrays.joints, arrays.states, arrays.settling, problem.length, r, q, left)
    np.testing.assert_allclose(left.ravel() * weight, expected * weight, atol=1e-5 * np.abs(weight).max())
    held = place >= 0
    found = (arrays.states.multiplier - before)[0]
    np.testing.assert_allclose(found, change, atol=1e-5 * np.abs(change).max())
    assert (arrays.states.force[0, held] == arrays.states.multiplier[0, place[held]]).all()


def test_what_is_nearly_right_stays():
    """Multipliers that are wrong by less than a ten-thousandth of the largest are as right as the poses."""
    discrete = linkage()
    arrays = ConstraintArrays.of(discrete.system.constraints, 1)
    problem = discrete.problem
    arrays.states.multiplier[:] = 1.0
    left = np.full((1, problem.size, 6), 1e-9)
    r, q = problem.positions[None].copy(), problem.quaternions[None].copy()
    settle(arrays.joints, arrays.states, arrays.settling, problem.length, r, q, left)
    assert (arrays.states.multiplier == 1.0).all()
    assert (left == 1e-9).all()

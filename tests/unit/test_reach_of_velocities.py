"""How far velocities go in the vibrations of a shape: beside closed forms and the root of a full matrix."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.mechanics.rotations.quaternion import product
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.transient.reach_of_velocities import ReachOfVelocities


@pytest.fixture(scope="module")
def cantilever():
    """A problem, its reference shape, and all small motions about it."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    section = vr.Rectangle(0.02, 0.01)
    model.add(
        "bar",
        vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=material, elements=1, order=4),
    )
    model.clamp("bar.start")
    discrete = DiscreteModel.of(model)
    reference = State.reference(discrete.problem)
    return discrete, reference, StartModes.about(discrete.static, reference, 0.0)


def bent(reference, curvature):
    """The same bar as an arc of a circle in the plane of its first two axes."""
    s = reference.r[:, 0]
    r = np.stack([np.sin(curvature * s), 1.0 - np.cos(curvature * s), 0.0 * s], axis=1) / curvature
    half = 0.5 * curvature * s
    turn = np.stack([np.cos(half), 0.0 * s, 0.0 * s, np.sin(half)], axis=1)
    return State(r, product(turn, reference.q), np.zeros_like(reference.twist), reference.multiplier)


def test_a_vibration_goes_as_far_as_its_velocity_over_its_frequency(cantilever):
    """Closed form: about the start ``v = a w phi`` is an amplitude ``a`` in its own shape, and none in others."""
    discrete, reference, modes = cantilever
    reach = ReachOfVelocities(discrete.problem, modes)
    for k in (0, 3, 7):
        twist = (0.01 * modes.omega[k] * modes.shapes[:, k]).reshape(-1, 6)
        expected = np.zeros(len(modes.omega))
        expected[k] = 0.01
        np.testing.assert_allclose(reach.along(modes.shapes, reference, 0.0, twist), expected, atol=1e-8)


def test_velocities_of_a_bent_shape_go_as_far_as_its_own_vibrations(cantilever):
    """Independent: all vibrations of the bent shape by full matrices; velocities in a slow one and in a fast one.

    The fast one, a stretching wave, has a part of bending; about the straight bar that is taken for a slow velocity.
    """
    discrete, reference, modes = cantilever
    shape = bent(reference, 2.0)
    tangent = discrete.static.tangent(shape, 0.0)
    basis, stiffness = tangent.basis.toarray(), tangent.stiffness.toarray()
    mass = block_diagonal(discrete.problem.mass).toarray()
    squares, vectors = scipy.linalg.eigh(0.5 * (stiffness + stiffness.T), basis.T @ mass @ basis)
    vibrations, rates = basis @ vectors, np.sqrt(np.maximum(squares, 0.0))
    parts = np.zeros(len(rates))
    parts[[2, 12, -3]] = 1e-3, 1e-4, 1e-5
    twist = (vibrations @ (parts * rates)).reshape(-1, 6)
    seen = modes.shapes.T @ mass @ vibrations
    expected = (seen * (rates / np.maximum(rates, modes.omega[:, None]))) @ parts
    found = ReachOfVelocities(discrete.problem, modes).along(modes.shapes, shape, 0.0, twist)
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())
    as_of_start = modes.shapes.T @ mass @ twist.ravel() / modes.omega
    assert abs(as_of_start[1]) > 100.0 * abs(expected[1])

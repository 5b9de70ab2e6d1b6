"""The slowest frequency by itself is that of all modes, to the last digit; where it is uncertain all are looked at.

What a motion begins with is told by the same modes, where sparse factors would tell it too. Stiffness and damping come
from one assembly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from helpers.strip import content
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.casefile.case import case_from_dict
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.undamped import resolved_modes, undamped_modes
from viscorod.solve.modes.vibrations import natural_frequencies
from viscorod.solve.problem.external_loads import NO_LOADS
from viscorod.solve.transient.motion_scale import _solver


def small_motions(**changes):
    """Return small motions of the strip about its reference shape, with other parts."""
    given = content("modes", about="reference") | {"loads": []} | changes
    discrete = DiscreteModel.of(case_from_dict(given).description)
    return linearise(discrete.static, State.reference(discrete.problem), scale=0.0)


@pytest.fixture
def clamped():
    """Return small motions of the strip as it is, clamped."""
    return small_motions()


def test_it_is_that_of_all_modes(clamped):
    alone = 1.0 / resolved_modes(clamped)[0][-1]
    assert natural_frequencies(clamped, 1)[0] == np.sqrt(alone)
    other = replace(clamped)  # which keeps nothing of what was found
    assert undamped_modes(other, 1).squares[0] == alone


def test_all_modes_are_looked_at_where_some_are_rigid():
    hinged = [{"kind": "support", "at": "beam.start", "fixed": ["ux", "uy", "uz", "rx", "ry"]}]
    linear = small_motions(supports=hinged)
    assert linear.rigid == 1
    assert resolved_modes(linear) is None
    assert natural_frequencies(linear, 1).tolist() == [0.0]


def test_all_modes_are_looked_at_where_the_stiffness_is_not_positive(clamped):
    softer = replace(
        clamped, stiffness=clamped.stiffness - 2.0 / resolved_modes(clamped)[0][-1] * clamped.mass
    )
    assert resolved_modes(softer) is None
    assert natural_frequencies(softer, 1).tolist() == [0.0]


def test_all_modes_are_looked_at_where_rounding_spoils_one(clamped):
    """A spring that resists one direction alone and is 1e12 times as stiff leaves slow shapes the rounding of it."""
    along = np.ones((clamped.mass.shape[0], 1))
    spring = 1e12 * abs(clamped.stiffness).max() * sparse.csr_array(along @ along.T)
    spoiled = replace(clamped, stiffness=sparse.csr_array(clamped.stiffness + spring))
    assert resolved_modes(spoiled) is None


def test_what_begins_is_told_by_modes_as_by_factors(clamped):
    """With modes ``x.K x = 1`` the flexibility is a sum; factors of ``K + w^2 M`` know nothing of modes."""
    least, force = 0.3 * natural_frequencies(clamped, 1)[0], np.cos(np.arange(clamped.mass.shape[0]))
    by_modes = _solver(clamped, least)(force)
    by_factors = clamped.solver(clamped.stiffness + least**2 * clamped.mass)(force)
    np.testing.assert_allclose(by_modes, by_factors, rtol=1e-9, atol=1e-9 * np.abs(by_factors).max())
    assert by_modes @ (clamped.stiffness @ by_modes) < by_modes @ force  # as inertia resists too


def test_damping_is_that_of_an_assembly_of_its_own():
    """A force bends the strip; the damping of its small motions is what the strain rates of moving nodes give."""
    case = case_from_dict(content("modes"))
    discrete = DiscreteModel.of(case.description)
    state = State.reference(discrete.problem)
    find_initial_equilibrium(discrete, state)
    linear = linearise(discrete.static, state)
    system, twist = discrete.system, np.zeros((discrete.problem.size, 6))
    speed = np.sin(np.arange(linear.mass.shape[0]))
    twist.ravel()[:] = linear.basis @ speed
    forces = []
    for sign in (1.0, -1.0):
        moving = State(state.r, state.q, sign * 1e-6 * twist, state.multiplier)
        system.assemble(moving, NO_LOADS, None, tangent=False, moving=True)
        forces.append(system.internal.copy())
    found = linear.basis.T @ (forces[0] - forces[1]).ravel() / 2e-6
    np.testing.assert_allclose(linear.damping @ speed, found, rtol=1e-6, atol=1e-6 * np.abs(found).max())

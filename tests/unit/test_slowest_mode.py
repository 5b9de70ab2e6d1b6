"""The slowest frequency by itself is that of all modes, to the last digit; where it is uncertain all are looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from helpers.strip import content
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import case_from_dict
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.undamped import slowest_square, undamped_modes
from viscorod.solve.modes.vibrations import natural_frequencies


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
    alone = slowest_square(clamped)
    assert alone is not None
    assert natural_frequencies(clamped, 1)[0] == np.sqrt(alone)
    other = replace(clamped)  # which keeps nothing of what was found
    assert undamped_modes(other, 1).squares[0] == alone


def test_all_modes_are_looked_at_where_some_are_rigid():
    hinged = [{"kind": "support", "at": "beam.start", "fixed": ["ux", "uy", "uz", "rx", "ry"]}]
    linear = small_motions(supports=hinged)
    assert linear.rigid == 1
    assert slowest_square(linear) is None
    assert natural_frequencies(linear, 1).tolist() == [0.0]


def test_all_modes_are_looked_at_where_the_stiffness_is_not_positive(clamped):
    softer = replace(clamped, stiffness=clamped.stiffness - 2.0 * slowest_square(clamped) * clamped.mass)
    assert slowest_square(softer) is None
    assert natural_frequencies(softer, 1).tolist() == [0.0]


def test_all_modes_are_looked_at_where_rounding_spoils_one(clamped):
    """A spring that resists one direction alone and is 1e12 times as stiff leaves slow shapes the rounding of it."""
    along = np.ones((clamped.mass.shape[0], 1))
    spring = 1e12 * abs(clamped.stiffness).max() * sparse.csr_array(along @ along.T)
    spoiled = replace(clamped, stiffness=sparse.csr_array(clamped.stiffness + spring))
    assert slowest_square(spoiled) is None

"""Histories of several states at once: energies within steps, states that are forgotten."""

from __future__ import annotations

import numpy as np
import pytest

from viscorod.solve.energy_account import EnergiesWithin, EnergyAccount, StepShare
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Records, Snapshot, Snapshots

NUMBERS = np.random.default_rng(7)
NODES, POINTS, BRANCHES = 3, 2, 2


def account():
    """An account with some energy everywhere."""
    found = EnergyAccount(*(1.0 + NUMBERS.random(7)))
    found.branches = NUMBERS.random(BRANCHES)
    return found


def snapshot():
    """A state of random numbers."""
    shapes = ((NODES, 3), (NODES, 4), (NODES, 6), (0,))
    state = State(*(NUMBERS.random(shape) for shape in shapes))
    points = (NUMBERS.random((POINTS, 6)) for _ in range(3))
    return Snapshot(state, *points, NUMBERS.random((1, 6)), *NUMBERS.random(2).tolist())


def step(parts):
    """What is known within a step: nothing has happened at its start, and all of it at its end."""
    before, end = account(), account()
    whole = (end.external - before.external, end.viscous - before.viscous)
    whole += (end.outside - before.outside, end.actuator - before.actuator)
    end.start = before.start
    sums = (parts * one for one in whole)
    share = StepShare(*sums, np.multiply.outer(parts, end.branches - before.branches))
    kinetic = (1.0 - parts) * before.kinetic + parts * end.kinetic
    return EnergiesWithin(before, end, parts, kinetic, share)


def filled():
    """A history of a start, five states within two steps, and the end; and its states one by one."""
    history, states = History(), [snapshot() for _ in range(7)]
    history.record(0.0, states[0], account(), 0.0, 0)
    for first, parts in ((1, np.array([0.0, 0.3, 1.0])), (4, np.array([0.25, 0.5]))):
        inside = Snapshots.joined([Snapshots.of(one) for one in states[first : first + len(parts)]])
        instants = [float(first + k) for k in range(len(parts))]
        history.extend(instants, Records(inside, step(parts)), 1.0, 3)
    history.record(6.0, states[6], account(), 1.0, 3)
    return history, states


def test_energies_within_a_step_are_those_at_its_ends():
    """At its parts 0 and 1, and the balance between: the remainder there is linear."""
    within = step(np.array([0.0, 0.4, 1.0]))
    first, middle, last = EnergiesWithin.rows([within])
    np.testing.assert_allclose(first, within.before.recorded, atol=1e-13)
    np.testing.assert_allclose(last, within.end.recorded, atol=1e-13)
    kinetic, elastic, viscous, external, numerical, outside, actuator = middle
    assert numerical == pytest.approx(0.6 * first[4] + 0.4 * last[4], abs=1e-13)
    given = external + actuator + within.before.start
    assert kinetic + elastic + viscous + outside - given == pytest.approx(numerical, abs=1e-13)


def test_states_of_several_pieces_are_those_of_each():
    """In order, bit for bit, and those of steps beside each other as those of each alone."""
    history, states = filled()
    for found, given in zip(history.snapshots, states, strict=True):
        np.testing.assert_array_equal(found.state.r, given.state.r)
        np.testing.assert_array_equal(found.section_force, given.section_force)
        assert found.kinetic == given.kinetic
    energy, branches = history.energies()
    assert energy.shape == (7, 7)
    assert branches.shape == (7, BRANCHES)
    for begin, end, piece in ((1, 4, 1), (4, 6, 2)):
        np.testing.assert_array_equal(energy[begin:end], EnergiesWithin.rows([history.records[piece].energy]))


@pytest.mark.parametrize("count", range(8))
def test_what_is_forgotten_leaves_the_rest(count):
    """Also in the middle of a piece: a co-simulation goes back to where it was."""
    history, _ = filled()
    states, (energy, branches) = history.states(), history.energies()
    history.truncate(count)
    assert history.count == len(history.step_size) == len(history.iterations) == count
    if not count:
        assert history.records == []
        return
    np.testing.assert_array_equal(history.states().q, states.q[:count])
    left = history.energies()
    np.testing.assert_array_equal(left[0], energy[:count])
    np.testing.assert_array_equal(left[1], branches[:count])

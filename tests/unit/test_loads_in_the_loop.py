"""Loads that the compiled loop of steps knows move things as those that it asks Python for, and as they should."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.loaded_rods import ROWS, loaded_rod
from viscorod.analyses.warmup import compile_loop
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.solve.transient.many_steps import ManySteps

pytestmark = pytest.mark.skipif(PURE_PYTHON, reason="nothing is compiled")


class OwnTable(vr.TimeTable):
    """A table that Python is asked for, since it might be another function."""


@pytest.fixture
def asked(monkeypatch):
    """How many functions the loop has of Python."""
    compile_loop()
    calls, called = [], ManySteps._called

    def counted(self, function):
        calls.append(function)
        return called(self, function)

    monkeypatch.setattr(ManySteps, "_called", counted)
    return calls


def test_a_table_moves_a_rod_as_the_same_table_in_python(asked):
    """Bit for bit, with corners, a jump, and an end."""
    runs = []
    for kind in (vr.TimeTable, OwnTable):
        model = loaded_rod(vr.Model(), [kind(*ROWS)], until=0.28)
        model.clamp("rod.start")
        runs.append(model.simulate(0.5, tolerance=1e-4, initial="reference", output_interval=0.01))
        assert len(asked) == (0 if kind is vr.TimeTable else 2)
    one, other = runs
    assert one.data.attrs["steps"] == other.data.attrs["steps"]
    assert one.data.attrs["iterations"] == other.data.attrs["iterations"]
    for name in ("position", "section_force", "external"):
        np.testing.assert_array_equal(one.data[name], other.data[name])


def test_a_force_in_pieces_gives_its_impulse(asked):
    """A free rod under an even force: its velocity is the integral of the table over the mass, its way that of it."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    model.add("rod", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=material))
    table = vr.TimeTable([0.0, 0.1, 0.3, 0.3, 0.5], [0.0, 1.0, 2.0, -1.0, 0.0])
    model.distributed_force("rod", (0, 0, 0.2), time=table, until=0.4)
    run = model.simulate(0.6, tolerance=1e-5, initial="reference")
    assert not asked
    # pieces of 0 to 1, 1 to 2, -1 to -0.5; then nothing
    impulse = 0.5 * 0.1 * 1.0 + 0.2 * 1.5 + 0.1 * -0.75
    way = 0.1**2 / 6.0
    way += 0.05 * 0.2 + 0.2**2 * (1.0 / 2.0 + 1.0 / 6.0)
    way += 0.35 * 0.1 + 0.1**2 * (-1.0 / 2.0 + 0.5 / 6.0)
    way += impulse * 0.2
    acceleration = 0.2 / (1000.0 * 1e-4)
    moved = run.history("rod.end", "position").values[-1]
    np.testing.assert_allclose(moved, [0.3, 0.0, acceleration * way], rtol=1e-9, atol=1e-12)
    velocity = run.history("rod.start", "velocity").values[-1]
    np.testing.assert_allclose(velocity, [0.0, 0.0, acceleration * impulse], rtol=1e-9, atol=1e-12)

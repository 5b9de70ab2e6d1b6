"""How far prescribed tables go from what stages of a step show of them, beside SciPy's polynomials through these."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import KroghInterpolator

import viscorod as vr
from viscorod.mechanics.nodes.table_motions import TableMotions, furthest_motion
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.motion_courses import table_motions
from viscorod.solve.transient.integrators.tableau import radau

ROWS = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5], [0.0, 0.2, 0.25, 0.0, -0.2, -0.1]
LENGTH = 0.3
STEPS = [(0.0, 0.5), (0.02, 0.31), (0.1, 0.2), (0.11, 0.14), (0.38, 0.9), (0.6, 0.7)]


def tables(**motion):
    """Tables that move a clamp, as compiled code knows them."""
    model = vr.Model()
    section, material = vr.Rectangle(0.01, 0.01), vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    model.add("rod", vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, material=material))
    model.clamp("rod.start", motion=motion)
    return table_motions(discretise(model).supports, LENGTH, radau(3).nodes)


def shown(table, start, end):
    """The polynomial through values and rates at the start and at the stages."""
    instants = start + (end - start) * np.array([0.0, *radau(3).nodes])
    sides = [(float(t), k == len(instants) - 1) for k, t in enumerate(instants)]
    pairs = [(table.value(*side), table.rate(*side)) for side in sides]
    return KroghInterpolator(np.repeat(instants, 2), np.ravel(pairs))


def furthest(table, start, end):
    """The largest distance at rows within the step, and in the middle between rows."""
    rows = np.array(ROWS[0])
    samples = np.concatenate([rows, 0.5 * (rows[1:] + rows[:-1])])
    among = samples[(samples > start) & (samples <= end)]
    polynomial = shown(table, start, end)
    return max((abs(float(polynomial(t)) - table.value(float(t))) for t in among), default=0.0)


@pytest.mark.parametrize(("start", "end"), STEPS)
@pytest.mark.parametrize("interpolation", ["linear", "monotone", "cubic"])
def test_the_distance_is_that_from_the_polynomial_through_the_stages(interpolation, start, end):
    """Of steps over many rows, from row to row, between rows, beyond the last one, and after it."""
    table = vr.TimeTable(*ROWS, interpolation)
    found = furthest_motion(tables(rz=table), start, end)
    assert found == pytest.approx(furthest(table, start, end), rel=1e-10, abs=1e-14)
    if end == 0.31:
        assert found > 1e-3


def test_displacements_are_measured_in_the_length_and_the_furthest_counts():
    large, small = vr.TimeTable(*ROWS, "cubic"), vr.TimeTable(ROWS[0], 0.1 * np.array(ROWS[1]), "cubic")
    alone = [furthest_motion(tables(**{name: large}), 0.02, 0.31) for name in ("rz", "ux")]
    assert alone[1] == pytest.approx(alone[0] / LENGTH, rel=1e-13)
    together = tables(rz=large, ux=small)
    assert isinstance(together, TableMotions)
    assert furthest_motion(together, 0.02, 0.31) == max(alone[0], 0.1 * alone[1])


def test_what_is_no_table_is_left_to_python():
    class Own(vr.TimeTable):
        """Another function, perhaps."""

    assert tables(rz=Own(*ROWS), ux=vr.Sine(2.0)) is None

"""Sums of nodal loads at one instant."""

from __future__ import annotations

import numpy as np

import viscorod as vr
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.external_loads import ExternalLoads


def _frame() -> vr.Model:
    """Build two rods at a corner, loaded along both, so that the corner carries parts of several loads."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    model = vr.Model()
    for name, start, end in (("post", (0, 0, 0), (0, 0, 1)), ("beam", (0, 0, 1), (1, 0, 1))):
        rod = vr.Rod.straight(
            start, end, section=vr.Rectangle(0.1, 0.1), material=material, elements=2, order=3
        )
        model.add(name, rod)
    model.attach("post.end", "beam.start")
    model.clamp("post.start")
    model.distributed_force("post", (1, 0, 0), time=vr.Ramp(0, 2))
    model.distributed_force("beam", (0, 0, -3), following=True)
    model.force("beam.end", (0, 2, 0), time=vr.Sine(0.25), until=3.0)
    model.force("beam.end", (0, 5, 0), until=1.5)
    model.gravity(time=vr.Ramp(2, 4))
    return model


def test_loads_add_up_at_every_node():
    """Load by load and row by row, at times when different ones act."""
    problem = discretise(_frame())
    loads = ExternalLoads(problem)
    for t in (0.0, 0.7, 1.0, 2.5, 3.5):
        dead, following, gravity = np.zeros((problem.size, 6)), np.zeros((problem.size, 6)), np.zeros(3)
        for load in problem.nodal_loads:
            factor = load.factor(t, False)
            for k, node in enumerate(load.nodes):
                dead[node] += factor * load.dead[k]
                following[node] += factor * load.following[k]
            gravity += factor * load.gravity
        state = loads.at(t)
        np.testing.assert_allclose(state.dead, dead, rtol=1e-15, atol=1e-300)
        np.testing.assert_allclose(state.following, following, rtol=1e-15, atol=1e-300)
        np.testing.assert_allclose(state.gravity, gravity, rtol=1e-15)
        loaded = np.flatnonzero(dead.any(axis=1) | following.any(axis=1) | bool(gravity.any()))
        np.testing.assert_array_equal(state.nodes, loaded)

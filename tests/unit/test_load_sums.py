"""Sums of nodal loads at one instant."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from pydantic import Field

import viscorod as vr
from viscorod.model.actions.load_base import AlongRod
from viscorod.model.actions.load_effects import Arrows
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Number
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


class Patch(AlongRod):
    """A force per length along y that grows from 0 at its start, at which no element begins."""

    kind: Literal["patch"] = Field(default="patch", kw_only=True, repr=False)
    growth: Number = Key("of the force per length with the length", "N/m^2")

    def breaks(self, model):
        return []

    def arrows(self, model, t):
        return Arrows(f"patch on {self.rod}", "N/m", (model.place(self.rod + ".start"),), np.zeros((1, 3)))

    def place(self, model, placing):
        def density(s):
            return np.array([0.0, self.growth * (s - self.from_s), 0.0, 0.0, 0.0, 0.0])

        placing.along(self.rod, density, self.factor, start=self.from_s, end=self.to_s)


@pytest.mark.parametrize("elements", [1, 3])
def test_a_load_on_a_part_of_an_element_has_its_force_and_moment(elements):
    """Closed form of a triangle: q l/2 at 2/3 of its length; shape functions of order 2 sum to both exactly."""
    section = vr.StiffnessSection([1.0] * 6, [1, 1, 1, 1, 1, 2])
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=2)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.loads.append(Patch("beam", growth=5.0, from_s=0.1, to_s=0.85))
    problem = discretise(model)
    assert len(problem.sets[0].start) == elements
    force = ExternalLoads(problem).at(0.0).dead[:, 1]
    length = 0.75
    assert force.sum() == pytest.approx(5.0 * length**2 / 2.0, rel=1e-13)
    moment = force @ problem.positions[:, 0]
    assert moment == pytest.approx(5.0 * length**2 / 2.0 * (0.1 + 2.0 / 3.0 * length), rel=1e-13)

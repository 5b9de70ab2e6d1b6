"""Joints, springs, dampers, held strains and loads at arms: residual and tangent of the assembled system (case E4)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.discrete_model import DiscreteModel
from helpers.finite_differences import slope_of


def assembly():
    """A pre-curved rod that neither shears nor stretches, a plate, a coupled rod; every kind of joint and spring."""
    stiffness = np.diag([80.0, 70.0, 200.0, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 3.0
    section = vr.StiffnessSection(stiffness, np.diag([1.0, 1.0, 1.0, 0.1, 0.2, 0.3]), 0.05 * stiffness)
    model = vr.Model()
    held = vr.Rod.arc(
        (0, 0, 0),
        (1, 0, 0),
        (0, 1, 0),
        1.0,
        1.0,
        section=section,
        elements=2,
        order=2,
        constraints="kirchhoff",
    )
    model.add("a", held)
    corner = np.array([np.sin(1.0), 1 - np.cos(1.0), 0.0])
    end = np.add(corner, (0, 1, 0.5))
    twisted = vr.Rod.straight(
        corner, end, section=section, elements=2, order=3, constraints=["twist", "shear_1"]
    )
    model.add("b", twisted)
    plate = vr.Body(
        2.0,
        (0.3, 0.4, 0.5),
        centre=np.add(end, (0.3, 0.1, 0.2)),
        points={"rim": np.add(end, (0.5, 0.3, 0.1))},
    )
    model.add("plate", plate)
    model.add("lid", vr.Body.box(np.add(end, (0.3, 0.1, 0.6)), (0.2, 0.3, 0.1), 100.0))
    model.attach("b.end", "plate")
    model.revolute(
        "b.start", "a.end", (0.2, 0.5, 1.0), stiffness={"rz": 0.7}, damping={"rz": 0.3}, rest={"rz": 0.2}
    )
    model.universal("lid", "plate.rim", ((1, 0, 0), (0, 1, 1)), stiffness={"rx": 2.0}, damping={"ry": 0.5})
    model.joint(
        "general",
        "a.start",
        "ground",
        free=["ux", "ry", "rz"],
        stiffness={"ux": 3.0},
        motion={"ry": vr.Ramp(0, 1, 2)},
    )
    model.joint("ball", "b@0.9", "plate.rim", stiffness={"rx": 0.4, "ry": 0.3}, damping={"rz": 0.2})
    model.planar("lid", "b.start", (0, 1, 0), damping={"ux": 0.1})
    model.spring(
        "plate",
        stiffness={"ux": 3.0, "rz": 0.6, "ry": 0.2},
        damping={"uy": 0.4, "rx": 0.2},
        axes=((1, 1, 0), (-1, 1, 0.5)),
    )
    model.line_spring("lid", "a.start", 5.0, 0.7, length=0.4)
    model.line_spring("plate.rim", (1.0, 2.0, 3.0), lambda x: 2.0 * x + x**3, lambda v: 0.3 * v + v**3)
    model.gravity((1.0, 2.0, -9.0))
    model.force("plate.rim", (1.0, 2.0, 3.0))
    model.force("plate.rim", (0.5, -1.0, 0.3), following=True)
    model.moment("plate.rim", (0.5, -1.0, 0.3))
    model.force("b.end", (0.3, 0.1, 0.4))
    model.distributed_force("b", (0.3, 0.2, -0.1))
    model.distributed_force("b", (0.3, 0.2, -0.1), following=True)
    return model


class Assembly(DiscreteModel):
    """With multipliers: unknowns are increments of the nodes, then multipliers in the scale of the matrix."""

    def __init__(self, model):
        super().__init__(model)
        self.multiplier = np.random.default_rng(5).normal(size=6 * self.problem.multipliers)
        self.multiplier[self.system.constraints.idle] = 0.0
        self.old.multiplier = self.multiplier.copy()
        self.system.constraints.update(0.3)

    def at(self, x):
        size = 6 * self.n
        self.old.multiplier = self.multiplier + self.system.constraints.scale * x[size:]
        return self.residual(self.moved(x[:size]))[1].ravel()


def test_tangent_of_an_assembly():
    """Central differences at a random state; multipliers are linear, their rows the derivatives of the gaps."""
    work = Assembly(assembly())
    work.residual(work.increment)
    work.system.reset_stress()
    work.residual(work.increment, tangent=True)
    K = work.system.matrix.sparse().toarray()
    idle = 6 * work.n + work.system.constraints.idle
    assert np.array_equal(K[np.ix_(idle, idle)], np.eye(len(idle)))
    K[idle, idle] = 0.0
    reference = slope_of(work.at, len(K), h=2e-4)
    assert K == pytest.approx(reference, abs=1e-6 * np.abs(reference).max())


def test_gradients_of_all_conditions():
    """What the null space of small motions is made of: derivatives of the gaps by body increments."""
    work = Assembly(assembly())
    work.residual(work.increment, tangent=True)
    K = work.system.matrix.sparse().toarray()
    new, _ = work.residual(work.increment)
    constraints = work.system.constraints
    scale = constraints.scale[constraints.used].copy()
    found = work.system.constraint_gradients(new).toarray()
    rows = K[6 * work.n + constraints.used][:, : 6 * work.n] / scale[:, None]
    assert found == pytest.approx(rows, abs=1e-12 * np.abs(rows).max())


def test_power_of_joints_is_stored_and_lost():
    """Internal power = rate of elastic energy + losses + multipliers times the rates of their gaps."""
    work = Assembly(assembly())
    new, _ = work.residual(work.increment)
    system = work.system
    power = np.sum(system.internal * new.twist)
    points, lengths = system.gauss_points(), system.gauss_positions().length
    sections = np.einsum("gi,gi,g->", points.section_force, points.strain_rate, lengths)
    joints = np.sum(system.constraints.force * system.constraints.rate)
    assert power == pytest.approx(sections + joints, rel=1e-12)

"""A small frame with everything that kernels must treat: mixed orders, couplings, an offset attachment, supports."""

from __future__ import annotations

import numpy as np

import viscorod as vr
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise


def section(damping=0.05):
    """Full stiffness, off-centre mass, damping that is not proportional."""
    stiffness = np.diag([80.0, 70.0, 200.0, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 3.0
    stiffness[3, 5] = stiffness[5, 3] = 0.2
    inertia = np.diag([1.0, 1.0, 1.0, 1e-1, 2e-1, 3e-1])
    inertia[0, 5] = inertia[5, 0] = -0.2
    inertia[1, 5] = inertia[5, 1] = 0.1
    viscosity = damping * (stiffness + np.diag([5.0, 0.0, 9.0, 0.1, 0.0, 0.3]))
    return vr.StiffnessSection(stiffness, inertia, viscosity if damping else None)


def frame(orders=(2, 3), damping=0.05, law=None):
    """Two rods of different order, joined at a right angle; the second may have a law of its section."""
    model = vr.Model()
    for name, a, b, order in zip("ab", ((0, 0, 0), (1, 0, 0)), ((1, 0, 0), (1, 1, 0.5)), orders, strict=True):
        rod = vr.Rod.straight(
            a,
            b,
            section=section(damping),
            elements=2,
            order=order,
            d1=(0, 0.3, 1),
            law=law if name == "b" else None,
        )
        model.add(name, rod)
    model.attach("a.end", "b.start")
    return model


def closed(damping=0.05):
    """One element along a circle, its ends attached to each other: two of its nodes share one."""
    model = vr.Model()
    circle = vr.Rod.arc(
        (0, 0, 0), (1, 0, 0), (0, 0, 1), 0.5, 2.0 * np.pi, section=section(damping), elements=1, order=5
    )
    model.add("a", circle)
    model.attach("a.start", "a.end")
    return model


class Moved:
    """A discretised model in a random state: deformed, moving, and with its attachments moved off their nodes."""

    def __init__(self, model, seed=5, offset=0.2, size=0.2):
        rng = np.random.default_rng(seed)
        self.problem = discretise(model)
        self.problem.link_positions[:] = offset * rng.normal(size=self.problem.link_positions.shape)
        self.system = GeometricSystem(self.problem)
        self.supports = SupportState(self.problem)
        self.elements = self.system.elements()
        self.n = n = self.problem.size
        self.state = State(
            self.problem.positions.copy(), self.problem.quaternions.copy(), rng.normal(size=(n, 6))
        )
        retract(self.state.r, self.state.q, size * rng.normal(size=(n, 6)), self.state.r, self.state.q)

    def moved(self, increment):
        """Poses after body increments ``(n, 6)``."""
        r, q = np.empty((self.n, 3)), np.empty((self.n, 4))
        retract(self.state.r, self.state.q, increment, r, q)
        return r, q


def law_response(at, strain, rate, law):
    """Forces ``(e, points, 6)``, energies and powers ``(e, points)`` of the law of rod b, by its Python function."""
    e = at.elements
    force, energy, power = np.zeros_like(strain), np.zeros(strain.shape[:2]), np.zeros(strain.shape[:2])
    own = {int(section) for section in np.flatnonzero(e.laws.address)}
    for a, order in enumerate(e.order):
        for g in range(order):
            if int(e.section[a, g]) in own:
                numbers = law.parameters(e.stiffness[e.section[a, g]])
                tangents = np.zeros((2, 6, 6))
                energy[a, g], power[a, g] = law.respond(
                    numbers, strain[a, g], rate[a, g], force[a, g], *tangents
                )
    return force, energy, power


def adjoint(x):
    """``ad(x)`` of a body twist, from the bracket of se(3)."""

    def skew(a):
        return np.cross(np.eye(3), np.asarray(a))

    return np.block([[skew(x[3:]), skew(x[:3])], [np.zeros((3, 3)), skew(x[3:])]])


def dense(pattern, blocks):
    """The matrix of blocks whose entry (i, j) stands at ``[s, j, i]``."""
    out = np.zeros((6 * pattern.size, 6 * pattern.size), dtype=blocks.dtype)
    for row, column, block in zip(pattern.rows, pattern.columns, blocks, strict=True):
        out[6 * row : 6 * row + 6, 6 * column : 6 * column + 6] = block.T
    return out

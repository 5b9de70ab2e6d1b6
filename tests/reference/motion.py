"""Run models with joints and look at joints, bodies, drift and energy in one way."""

from __future__ import annotations

import numpy as np

import viscorod as vr
from viscorod.analysis import Workplace
from viscorod.mechanics.quaternion import matrices
from viscorod.model.settings import SimulateSettings


class Motion:
    """A run, and what it keeps of joints and bodies."""

    def __init__(self, model, duration, **settings):
        self.work = work = Workplace.of(model)
        stepping = work._stepping

        def remembering(*given):
            self.integrator, *others = stepping(*given)
            return (self.integrator, *others)

        work._stepping = remembering
        self.run = work.simulate(SimulateSettings(duration=duration, **settings), None, {})
        self.time, self.energy = self.run.time, self.run.energy
        self._snapshots = work.history.snapshots

    def joint(self, name, word):
        """Value, rate and force of a joint's coordinate over time."""
        joints = self.work.problem.joints
        (c,) = (c for c, w in enumerate(joints.words) if w == word and joints.names[joints.joint[c]] == name)
        return np.array([[x[c] for x in s.joints] for s in self._snapshots]).T

    def _node(self, body):
        bodies = self.work.problem.bodies
        k = bodies.names.index(body)
        return bodies.nodes[k], bodies.arms[k]

    def body(self, name):
        """Positions of a body's centre or of one of its points, "plate.corner"."""
        node, arm = self._node(name)
        r = np.array([s.state.r[node] for s in self._snapshots])
        return r + self.rotation(name) @ arm

    def rotation(self, name):
        """Rotation matrices of a body's node, from the body's axes to global ones."""
        node, _ = self._node(name)
        return matrices(np.array([s.state.q[node] for s in self._snapshots]))

    def twist(self, name):
        """Linear and angular velocity of a body's node, body axes."""
        node, _ = self._node(name)
        return np.array([s.state.twist[node] for s in self._snapshots])

    @property
    def drift(self):
        """Largest gap of a joint or held strain: of positions, over the size, and of recorded velocities."""
        linked = getattr(self.integrator, "linked", None)
        if linked is not None:
            return max(linked.drift)
        constraints = self.work.system.constraints
        held, worst = constraints.is_held, 0.0
        for t, s in zip(self.time, self._snapshots, strict=True):
            constraints.update(t, before=bool(t > 0.0))
            gap, speed = s.joints.value - constraints.target, s.joints.rate - constraints.target_rate
            gap, speed = gap / constraints.joints.unit, speed / constraints.joints.unit
            worst = max(worst, *np.abs(gap[held]), *np.abs(speed[held] / constraints.speed(s.state)))
        return worst

    def imbalance(self):
        """Largest numerical remainder of the energy account over the largest energy that was there or came in."""
        e = self.energy
        most = max(np.abs(x).max() for x in (e.kinetic, e.elastic, e.external))
        return float(np.abs(e.numerical).max() / most)


def rigid_parts(*names_and_bodies):
    """A model with these bodies, and a short clamped rod that has nothing to do with them."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6] * 3 + [1e2] * 3, [1.0, 1.0, 1.0, 1e-3, 1e-3, 2e-3])
    model.add("stub", vr.Rod.straight((0, 0, -1), (0, 0, -0.9), section=section, elements=1, order=1))
    model.clamp("stub.start")
    for name, body in names_and_bodies:
        model.add(name, body)
    return model

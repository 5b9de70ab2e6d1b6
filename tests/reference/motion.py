"""Run models with joints and look at joints, bodies, drift and energy in one way."""

from __future__ import annotations

import numpy as np

import viscorod as vr
from viscorod.mechanics.rotations.quaternion import matrices


class Motion:
    """A run, and what it keeps of joints and bodies."""

    def __init__(self, model, duration, **settings):
        self.run = model.simulate(duration, **settings)
        self.time, self.energy = self.run.time, self.run.energy

    def joint(self, name, word):
        """Value, rate and force of a joint's coordinate over time."""
        coordinate = self.run.joint(name).sel(motion=word)
        return np.array([coordinate[key].values for key in ("value", "rate", "force")])

    def body(self, name):
        """Positions of a body's centre or of one of its points, "plate.corner"."""
        return self.run.history(name).values

    def rotation(self, name):
        """Rotation matrices of a body, from the body's axes to global ones."""
        return matrices(np.ascontiguousarray(self._station("rotation", name)))

    def twist(self, name):
        """Linear and angular velocity of a body's centre, body axes."""
        linear = np.einsum("tji,tj->ti", self.rotation(name), self._station("velocity", name))
        return np.concatenate([linear, self._station("angular_velocity", name)], axis=1)

    def _station(self, variable, name):
        (station,) = self.run.sites.at(name).stations
        return self.run.data[variable].values[:, station]

    @property
    def drift(self):
        """Largest gap of a joint or held strain: of positions, over the size, and of recorded velocities."""
        attrs = self.run.data.attrs
        return max(attrs["drift_position"], attrs["drift_velocity"])

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

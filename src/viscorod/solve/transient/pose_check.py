"""Distance of poses integrated in time from those that follow from strains along rods (intrinsic formulation)."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.poses_from_strains import along_rod
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.solve.formulations.system import System
from viscorod.solve.history import History, StationReader
from viscorod.typing import Floats

MOST = 100
"""Instants that are looked at, evenly chosen."""


def pose_gap(system: System, history: History) -> tuple[float, float]:
    """Return the largest distance [m] and angle [rad] between both at any station and recorded instant.

    Integration along a rod begins at its start.
    """
    problem, gauss = system.problem, system.gauss_positions()
    sampled = history.sample(MOST)
    snapshots = [snapshot for _, snapshot in sampled]
    r = np.array([snapshot.state.r for snapshot in snapshots])
    q = np.array([snapshot.state.q for snapshot in snapshots])
    position, rotation, _, _ = StationReader(problem).read(r, q, np.zeros((*r.shape[:2], 6)))
    reference = system.elements().reference.reshape(-1, 6)[system.gauss_indices()]
    strain = reference + np.array([snapshot.strain for snapshot in snapshots])
    if system.imposed.changes:
        places = system.gauss_indices()
        strain += [system.imposed.driven(t, t > 0.0).reshape(-1, 6)[places] for t, _ in sampled]
    distance = angle = 0.0
    for rod, order in enumerate(problem.rod_orders):
        at, points = np.flatnonzero(problem.stations.rod == rod), gauss.rod == rod
        half_length = half_lengths(system, rod)
        inside = strain[:, points].reshape(len(snapshots), len(half_length), order, 6)
        there, turned = position[:, at], rotation[:, at]
        found, turn = along_rod(int(order), half_length, inside, there[:, 0], turned[:, 0])
        distance = max(distance, float(np.linalg.norm(found - there, axis=-1).max()))
        sine = np.linalg.norm(product(conjugate(turn), turned)[..., 1:], axis=-1)
        angle = max(angle, float(2.0 * np.arcsin(np.minimum(sine, 1.0)).max()))
    return distance, angle


def half_lengths(system: System, rod: int) -> Floats:
    """Return the half lengths of a rod's elements in order of arc length [m]."""
    sets = system.problem.sets
    start = np.concatenate([e.start[e.rod == rod] for e in sets])
    half = np.concatenate([e.half_lengths[e.rod == rod] for e in sets])
    return np.asarray(half[np.argsort(start)])

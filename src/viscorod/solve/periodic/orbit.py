"""Periodic motions as data: an orbit, the motion that follows from it, and the derivatives of its balance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.solve.formulations.system import State
from viscorod.typing import Floats

__all__ = ["Frozen", "Linearised", "Motion", "Orbit", "Setting"]


class Setting(NamedTuple):
    """Angular frequency [rad/s], level of the drive, and a damping [1/s] that is taken away, times the mass."""

    omega: float
    level: float
    lack: float = 0.0


@dataclass
class Orbit:
    """Coordinates ``(N, n, 6)`` and multipliers ``(N, places)`` at all phases."""

    X: Floats
    multiplier: Floats


@dataclass
class Motion:
    """What follows from an orbit: states, Gauss points and forces at all phases (first index).

    Attributes:
        X, rates: coordinates of the nodes and their rates ``(N, n, 6)``.
        residual: unbalanced forces and scaled gaps ``(N, N_b, 6)``, in the directions that supports leave free; what
            supports hold has gaps there. force: the unbalanced forces of all nodes ``(N, n, 6)``, body axes.
        targets: of supports ``(N, m, 6)``; reaction: along their axes ``(N, m, 6)``.
        spring: strains of the springs of Maxwell branches ``(branches, N, e, points, 6)``.
        gaps: targets and rates of joints ``(N, c)``; powers: of motors, lost by dampers, lost outside ``(3, N)`` [W].
        drive: power of all loads ``(N,)`` [W]; size: of the largest internal or inertial force, times the length [N m].
        frozen: stresses of their own that it was computed with.
    """

    setting: Setting
    X: Floats
    rates: Floats
    states: list[State]
    twist: Floats
    acceleration: Floats
    points: GaussStates
    residual: Floats
    force: Floats
    targets: Floats
    reaction: Floats
    spring: Floats
    powers: Floats
    drive: Floats
    size: float
    frozen: Frozen | None


class Frozen(NamedTuple):
    """Stresses ``(N, e, points, 6)`` as iterates of their own, with the derivatives by which they are carried."""

    stress: Floats
    linear: Linearised


class Linearised(NamedTuple):
    """Derivatives of the balance by body increments (K), twists (C) and their rates (M), at all phases.

    Attributes:
        K, C: blocks of the pattern as matrices ``(N, b, 6, 6)``; M: ``(N, n, 6, 6)``; rows projected on what supports
            leave free. ad: of the twists ``(N, n, 6, 6)``.
        V: changes of the twists at all phases by body increments at all others ``(n, N, N, 6, 6)``, of the
            trigonometric polynomials of the coordinates.
        Z: body increments of the nodes of partial supports ``(N, partial, 6, 6)``.
        strain, force, viscous: operators of all elements ``(N, e, 6 points, 6 nodes)``: changes of the strains, and of
            section forces, by body increments at constant twists and by twists.
    """

    K: Floats
    C: Floats
    M: Floats
    ad: Floats
    V: Floats
    Z: Floats
    strain: Floats
    force: Floats
    viscous: Floats

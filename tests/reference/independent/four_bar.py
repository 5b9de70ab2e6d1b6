"""Four-bar mechanism with an inclined hinge, quasi-static: three rods by shooting, without any mesh.

Bars AB and CD of 0.12 m, BC of 0.24 m, in the plane at the start: A (0, 0), B (0, 0.12), C (0.24, 0.12), D (0.24, 0).
Revolute joints at A (driven), B and D about z; the axis at C is (sin a, 0, cos a), a = 5 degrees: were the bars
rigid, nothing could move. The problem is that of Bauchau, Betsch, Cardona, Gerstmayr, Jonker, Masarati, Sonneville,
"Validation of flexible multibody dynamics beam formulations using benchmark problems", Multibody System Dynamics
37 (2016). Geometry, tilt, the direction of the drive and the rounded section constants below are those on which two
public programs agree (the four-bar examples of smdogroup/TACS and of vspsonn/mb_sef_py); the paper itself was not at
hand. They fit squares of 16 and 8 mm, E = 207 GPa, nu = 0.3, rho = 7800 kg/m3 (GA with k = 0.828, GJ as printed).

The drive is slow (0.6 rad/s against hundreds), so inertia is left out here; `exudyn_rods.four_bar` has it. The joint
force is then the same everywhere, and each bar is an initial value problem. Eight unknowns (force, moment at A, two
joint angles) meet eight equations: no moment about the axes of B, C, D, and at D the place and the axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from .galerkin import Array, Values

TILT = np.radians(5.0)
THICK = {"EA": 52.99e6, "GA": 16.88e6, "GJ": 733.5, "EI": 1131.0, "mass": 1.997, "rotary": 42.60e-6}
THIN = {"EA": 13.25e6, "GA": 4.22e6, "GJ": 45.84, "EI": 70.66, "mass": 0.4992, "rotary": 2.662e-6}
POINTS = {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.12, 0.0), "C": (0.24, 0.12, 0.0), "D": (0.24, 0.0, 0.0)}
SPEED, RISE = -0.6, 1.0
_UNITS = np.array([100.0, 100, 100, 10, 10, 10, 1, 1])
_EZ = np.array([0.0, 0.0, 1.0])


def crank_angle(t: float, speed: float = SPEED, rise: float = RISE) -> float:
    """Angle of the crank: from rest to ``speed`` within ``rise``, with a rate of acceleration 1 - cos."""
    if t >= rise:
        return speed * (t - rise / 2)
    return speed / rise * (t * t / 2 + (rise / (2 * np.pi)) ** 2 * (np.cos(2 * np.pi * t / rise) - 1))


@dataclass(frozen=True)
class Pose:
    """Equilibrium at a crank angle: places of B and C, force and moment in the crank at A, angles of the joints.

    The force and the moment are those that the outer part exerts on the inner one: the motor's torque on the crank is
    minus the moment about z. `angles` are relative rotations at B, C and the absolute one at D; `axis` is the tilt
    of bar CD's z axis at D, which the joint there keeps zero.
    """

    crank: float
    B: Array
    C: Array
    force: Array
    moment: Array
    angles: Array
    residual: float

    @property
    def motor(self) -> float:
        """Torque of the motor on the crank about z."""
        return -float(self.moment[2])


def equilibrium(
    crank: float, guess: Array | None = None, *, tilt: float = TILT, steps: int = 6
) -> tuple[Pose, Array]:
    """Solve at one crank angle from a guess of the unknowns; also give the unknowns."""
    x = np.zeros(8) if guess is None else guess.copy()

    def residual_and_slope(x: Array) -> tuple[Array, Array]:
        h = 1e-30
        values, _ = _shoot(np.vstack([x + 0j, x + 1j * h * np.eye(8)]), crank, tilt, steps)
        return values[0].real, values[1:].imag.T / h

    found = root(residual_and_slope, x, jac=True, method="hybr", tol=1e-14)
    x = found.x
    if np.abs(found.fun).max() > 1e-10:
        raise ArithmeticError(f"no equilibrium at {crank}: residual {np.abs(found.fun).max():.1e}")
    values, seen = _shoot(x[None], crank, tilt, steps)
    n, m, angles, rB, rC = (s[0].real for s in seen)
    return Pose(crank, rB, rC, n, m, angles, float(np.abs(values).max())), x


def path(
    cranks: Array, *, tilt: float = TILT, steps: int = 6, fine: int = 16, stride: float = 0.02
) -> list[Pose]:
    """Follow the equilibria from the unstressed mechanism through the crank angles, in steps of at most ``stride``.

    Bars are integrated in ``steps`` intervals on the way and in ``fine`` ones at the angles asked for.
    """
    x, rate, last, poses = np.zeros(8), np.zeros(8), 0.0, []
    for crank in cranks:
        while True:
            ahead = float(np.clip(crank - last, -stride, stride))
            _, new = equilibrium(last + ahead, x + ahead * rate, tilt=tilt, steps=steps)
            if ahead:
                rate = (new - x) / ahead
            x, last = new, last + ahead
            if abs(crank - last) < 1e-13:
                break
        poses.append(equilibrium(crank, x, tilt=tilt, steps=fine)[0])
    return poses


def _shoot(x: Values, crank: float, tilt: float, steps: int) -> tuple[Values, list[Values]]:
    """Residuals for a batch of unknowns, one row each; and what there is to see."""
    x = x * _UNITS
    n, m = x[:, :3], x[:, 3:6]
    hinge = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    start = np.zeros_like(n)
    AB, BC, CD = (_frame(np.subtract(POINTS[q], POINTS[p])) for p, q in (("A", "B"), ("B", "C"), ("C", "D")))
    one = np.ones(len(x), dtype=x.dtype)

    RA = _turn(_EZ, crank * one) @ AB
    rB, RB, mB = _bar(start, RA, n, m, 0.12, THICK, steps)
    T = RB @ AB.T
    RB2 = T @ _turn(_EZ, x[:, 6]) @ BC
    rC, RC, mC = _bar(rB, RB2, n, mB, 0.24, THICK, steps)
    U = RC @ BC.T
    RC2 = U @ _turn(hinge, x[:, 7]) @ CD
    rD, RD, mD = _bar(rC, RC2, n, mC, 0.12, THIN, steps)
    V = RD @ CD.T
    residual = np.column_stack(
        [
            np.einsum("bi,bi->b", mB, T @ _EZ) / 10,
            np.einsum("bi,bi->b", mC, U @ hinge) / 10,
            (rD - np.array(POINTS["D"])) / 0.01,
            (V @ _EZ)[:, :2] * 10,
            mD[:, 2] / 10,
        ]
    )
    at_D = np.arctan2(V[:, 1, 0].real, V[:, 0, 0].real)
    return residual, [n, m, np.column_stack([x[:, 6], x[:, 7], at_D]), rB, rC]


def _bar(
    r: Values, R: Values, n: Values, m: Values, length: float, section: dict[str, float], steps: int
) -> tuple[Values, Values, Values]:
    """Integrate r' = R (e1 + C n), R' = R (kappa)^, m' = -r' x n by Runge-Kutta-Munthe-Kaas of order 4."""
    soft = 1 / np.array([section["EA"], section["GA"], section["GA"]])
    bend = 1 / np.array([section["GJ"], section["EI"], section["EI"]])
    e1 = np.array([1.0, 0.0, 0.0])
    h = length / steps

    def slopes(R: Values, m: Values) -> tuple[Values, Values, Values]:
        slope = _times(R, e1 + soft * _back(R, n))
        return slope, bend * _back(R, m), -np.cross(slope, n)

    def pulled(u: Values, w: Values) -> Values:
        c = np.cross(u, w)
        return w + c / 2 + np.cross(u, c) / 12

    for _ in range(steps):
        r1, k1, m1 = slopes(R, m)
        u = h / 2 * k1
        r2, k2, m2 = slopes(R @ _exponential(u), m + h / 2 * m1)
        k2 = pulled(u, k2)
        u = h / 2 * k2
        r3, k3, m3 = slopes(R @ _exponential(u), m + h / 2 * m2)
        k3 = pulled(u, k3)
        u = h * k3
        r4, k4, m4 = slopes(R @ _exponential(u), m + h * m3)
        k4 = pulled(u, k4)
        R = R @ _exponential(h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
        r = r + h / 6 * (r1 + 2 * r2 + 2 * r3 + r4)
        m = m + h / 6 * (m1 + 2 * m2 + 2 * m3 + m4)
    return r, R, m


def _times(R: Values, v: Values) -> Values:
    return np.einsum("bij,bj->bi", R, np.broadcast_to(v, (len(R), 3)))


def _back(R: Values, v: Values) -> Values:
    return np.einsum("bji,bj->bi", R, v)


def _exponential(v: Values) -> Values:
    """Rotations of rotation vectors, holomorphic."""
    square = np.einsum("bi,bi->b", v, v)
    small = np.abs(square) < 1e-8
    root = np.sqrt(np.where(small, 1.0, square))
    first = np.where(small, 1 - square / 6 + square**2 / 120, np.sin(root) / root)
    second = np.where(small, 0.5 - square / 24 + square**2 / 720, (1 - np.cos(root)) / root**2)
    K = _hat(v)
    return np.eye(3) + first[:, None, None] * K + second[:, None, None] * (K @ K)


def _turn(axis: Array, angles: Values) -> Values:
    K = _hat(axis[None])
    return np.eye(3) + np.sin(angles)[:, None, None] * K + (1 - np.cos(angles))[:, None, None] * (K @ K)


def _hat(v: Values) -> Values:
    zero = np.zeros_like(v[:, 0])
    return np.stack(
        [[zero, -v[:, 2], v[:, 1]], [v[:, 2], zero, -v[:, 0]], [-v[:, 1], v[:, 0], zero]]
    ).transpose(2, 0, 1)


def _frame(direction: Array) -> Array:
    """Columns: along the bar, across in the plane, z."""
    x = np.asarray(direction) / np.linalg.norm(direction)
    return np.column_stack([x, np.cross(_EZ, x), _EZ])

"""Gyroscopes: whirl of an overhung disc on a flexible shaft, and steady precession of a heavy top.

The disc (mass m, polar inertia Ip about the shaft, diametral Id) sits on the end of a shaft of length L whose other end
is held in a frame that spins at rate W about the shaft. A round shaft looks the same from every side, so that in the
frame at rest its stiffness is that of the shaft at rest. With deflection u = x + i y and slope p = x' + i y'
at the end,

    m u''            + k11 u - k12 p = 0,        k11, k12, k22: inverse of the compliances below
    Id p'' - i Ip W p' - k12 u + k22 p = 0

and u = U e^(i w t) gives a quartic with four real roots w, forward whirl positive:

    (k11 - m w^2)(k22 - Id w^2 + Ip W w) - k12^2 = 0.

Compliances of a cantilever under end force F and moment M: u = F (L^3/3EI + L/GA) + M L^2/2EI, p = F L^2/2EI + M L/EI.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from .galerkin import Array


@dataclass(frozen=True)
class Overhung:
    """Disc on a shaft; SI units. ``GA`` infinite: no shear. ``line_mass``: of the shaft, kg/m."""

    length: float = 0.5
    EI: float = 100.0
    GA: float = np.inf
    line_mass: float = 0.0
    mass: float = 2.0
    polar: float = 0.02
    diametral: float = 0.0101
    offset: float = 0.0  # of the disc's centre beyond the end of the shaft

    def stiffness(self) -> Array:
        """Stiffness for force and moment at the end of the massless shaft, against deflection and slope."""
        L, EI = self.length, self.EI
        compliance = np.array([[L**3 / (3 * EI) + L / self.GA, L**2 / (2 * EI)], [L**2 / (2 * EI), L / EI]])
        return np.linalg.inv(compliance)

    def dynamic_stiffness(self, w: float) -> Array:
        """Stiffness at frequency w of the shaft with its mass, exact for Euler-Bernoulli, without rotary inertia."""
        if np.isfinite(self.GA):
            raise ValueError("the exact dynamic stiffness is that of a shaft without shear")
        if self.line_mass == 0 or w == 0:
            return self.stiffness()
        k = (self.line_mass * w * w / self.EI) ** 0.25
        z = k * self.length
        if z < 0.05:  # the exact expressions cancel; the consistent mass matrix is exact to z^8
            return self.stiffness() - w * w * self.consistent_mass()
        c, s, C, S = np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)
        d = 1 - c * C
        EI = self.EI
        return np.array(
            [
                [EI * k**3 * (c * S + s * C) / d, -EI * k**2 * s * S / d],
                [-EI * k**2 * s * S / d, EI * k * (s * C - c * S) / d],
            ]
        )

    def consistent_mass(self) -> Array:
        """Mass of the shaft seen at its end, with the static shapes."""
        L = self.length
        return self.line_mass * L / 420 * np.array([[156.0, -22 * L], [-22 * L, 4 * L * L]])

    def inertia(self) -> Array:
        """Mass and diametral inertia of the disc, referred to the end of the shaft."""
        e, m = self.offset, self.mass
        return np.array([[m, m * e], [m * e, self.diametral + m * e * e]])

    def whirl(self, spin: float) -> Array:
        """The four whirl frequencies, rad/s, ascending (backward negative), of the shaft without or with its mass."""
        K, M = self.stiffness(), self.inertia() + self.consistent_mass()
        G = np.array([[0.0, 0.0], [0.0, self.polar * spin]])
        # K + G w - M w^2 = 0 as a linear problem in (q, w q)
        lower = np.hstack([np.linalg.solve(M, K), np.linalg.solve(M, G)])
        companion = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), lower])
        roots = np.sort(np.linalg.eigvals(companion).real)
        if self.line_mass == 0 or np.isfinite(self.GA):
            return roots
        return np.array([self._refined(w, spin) for w in roots])

    def _refined(self, guess: float, spin: float) -> float:
        def determinant(w: float) -> float:
            A = self.dynamic_stiffness(abs(w)) - w * w * self.inertia()
            A[1, 1] += self.polar * spin * w
            return float(np.linalg.det(A)) / float(np.linalg.det(self.stiffness()))

        for width in (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1):
            a, b = guess * (1 - width), guess * (1 + width)
            if determinant(a) * determinant(b) < 0:
                return float(brentq(determinant, a, b, xtol=1e-13 * abs(guess), rtol=1e-13))
        raise ArithmeticError(f"no root near {guess}")


def quartic(rotor: Overhung, spin: float) -> Array:
    """The same frequencies of the massless shaft from the quartic of the module's text (no offset)."""
    (k11, k12), (_, k22) = rotor.stiffness()
    first = np.array([-rotor.mass, 0.0, k11])
    second = np.array([-rotor.diametral, rotor.polar * spin, k22])
    return np.sort(np.roots(np.polysub(np.polymul(first, second), [k12**2])).real)


@dataclass(frozen=True)
class Top:
    """Symmetric heavy top on a fixed point: inertias about that point, distance of the centre of mass."""

    mass: float
    axial: float
    transverse: float
    distance: float
    gravity: float = 9.81

    def precession(self, tilt: float, spin: float) -> Array:
        """Rates of steady precession, slow and fast, at a tilt from the vertical; ``spin``: w3 along the axis.

        Roots of A cos(tilt) W^2 - C w3 W + m g l = 0.
        """
        weight = self.mass * self.gravity * self.distance
        a, b = self.transverse * np.cos(tilt), self.axial * spin
        square = b * b - 4 * a * weight
        if square < 0:
            raise ValueError("too slow a spin for steady precession at this tilt")
        q = (b + np.copysign(np.sqrt(square), b)) / 2
        return np.array([weight / q, q / a])

    def angular_velocity(self, tilt: float, spin: float, rate: float) -> Array:
        """Angular velocity in space of the top with its axis at (sin tilt, 0, cos tilt), precessing at ``rate``."""
        axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
        return rate * np.array([0.0, 0.0, 1.0]) + (spin - rate * np.cos(tilt)) * axis

    def nutation(self, tilt: float, spin: float, rate: float) -> float:
        """Angular frequency of small nutation about a steady precession.

        From the effective potential V(q) = (p - C w3 cos q)^2/(2 A sin^2 q) + m g l cos q, p the vertical momentum:
        A w^2 = V''.
        """
        A, b = self.transverse, self.axial * spin
        weight = self.mass * self.gravity * self.distance
        c, s = np.cos(tilt), np.sin(tilt)
        f, f1 = A * rate * s * s, b * s  # p - b cos q and its derivative
        # V' = f f1/(A s^2) - f^2 c/(A s^3) - weight s
        second = (
            (f1 * f1 + f * b * c) / (A * s**2)
            - 4 * f * f1 * c / (A * s**3)
            + f * f * (1 / (A * s**2) + 3 * c * c / (A * s**4))
            - weight * c
        )
        return float(np.sqrt(second / A))

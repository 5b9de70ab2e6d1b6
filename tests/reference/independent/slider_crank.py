"""Slider-crank with a flexible coupler: a planar shear-deformable rod in polynomials of the whole length.

The crank (radius a) turns at the constant rate W and carries the coupler's start; the coupler's end is pinned to a
slider (mass) on the x axis. Unknowns are place (x, y) and angle of the coupler's sections, their rates, and the forces
of the crank pin and of the guide, which hold the velocities of the ends: an index-2 system.

With t = (cos th, sin th), n = (-sin th, cos th): e = r'.t - 1, g = r'.n, k = th'; N = EA (e + T e_t),
Q = GA (g + T g_t), M = EI (k + T k_t), T being the Kelvin-Voigt time. In these unknowns the mass matrix is constant.
At t = 0 the coupler is straight, with the velocities of a rigid one. Slider at (a + L, 0) at the start.

The numbers are those of a coupler of 6 mm diameter that is often computed (a 0.15 m, L 0.3 m, E 0.2 TPa, 7870 kg/m3,
150 rad/s, slider of half the coupler's mass; from memory, after Jonker 1989), with a shear stiffness added.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from .galerkin import Array, Field, Form, System, Values, blocks, gauss, polynomials, radau


@dataclass(frozen=True)
class SliderCrank:
    """SI units; ``damping``: Kelvin-Voigt time of all three strains."""

    crank: float = 0.15
    length: float = 0.3
    speed: float = 150.0
    young: float = 0.2e12
    shear: float = 0.0692e12  # shear modulus times the shear coefficient
    density: float = 7870.0
    diameter: float = 0.006
    slider: float = 0.033
    damping: float = 0.0

    @property
    def area(self) -> float:
        return np.pi * self.diameter**2 / 4

    @property
    def inertia(self) -> float:
        return np.pi * self.diameter**4 / 64

    @property
    def stiffness(self) -> tuple[float, float, float]:
        """EA, GA, EI."""
        return self.young * self.area, self.shear * self.area, self.young * self.inertia

    def rigid_slider(self, times: Array) -> Array:
        """Slider's place with a rigid coupler."""
        angle = self.speed * np.asarray(times)
        return self.crank * np.cos(angle) + np.sqrt(self.length**2 - (self.crank * np.sin(angle)) ** 2)


@dataclass(frozen=True)
class Solution:
    """Slider's place, deflection of the middle left of the chord from pin to slider, motor torque; energy balance."""

    times: Array
    slider: Array
    deflection: Array
    torque: Array
    energy: Array
    work: Array
    dissipated: Array

    @property
    def imbalance(self) -> float:
        """Largest |energy + dissipated - work| over the largest change of energy."""
        gap = self.energy + self.dissipated - self.work
        return float(np.abs(gap - gap[0]).max() / np.ptp(self.energy))


def solve(case: SliderCrank, times: Array, *, degree: int = 10, steps: int = 20) -> Solution:
    """Integrate, with polynomials of the given degree and ``steps`` between two of the times, the first being zero."""
    L, a, W, T, m = case.length, case.crank, case.speed, case.damping, degree + 1
    points, weights = gauss(np.array([0, L]), 2 * m)
    EA, GA, EI = case.stiffness
    mu, J = case.density * case.area, case.density * case.inertia

    P, dP = polynomials(points, L, m), _slopes(points, L, m)
    first, last = polynomials(np.array([0.0]), L, m), polynomials(np.array([L]), L, m)
    x, y, q, u, v, o, (Fx, Fy, guide, work, lost), n = blocks(m, m, m, m, m, m, scalars=5)

    mass, linear = np.eye(n), np.zeros((n, n))
    gram = P.T @ (weights[:, None] * P)
    mass[u, u] = mu * gram + case.slider * last.T @ last
    mass[v, v], mass[o, o] = mu * gram, J * gram
    for place, rate in ((x, u), (y, v), (q, o)):
        linear[place, rate] = np.eye(m)
    for held in (Fx, Fy, guide):
        mass[held, held] = 0.0

    def internal(f: Values) -> list[Values]:
        xs, ys, angle, k, us, vs, spin, k_t = f
        c, s = np.cos(angle), np.sin(angle)
        e, g = xs * c + ys * s - 1, ys * c - xs * s
        e_t = us * c + vs * s + spin * g
        g_t = vs * c - us * s - spin * (1 + e)
        N, Q, M = EA * (e + T * e_t), GA * (g + T * g_t), EI * (k + T * k_t)
        return [
            -(N * c - Q * s),
            -(N * s + Q * c),
            Q * (1 + e) - N * g,
            -M,
            T * (EA * e_t**2 + GA * g_t**2 + EI * k_t**2),
        ]

    seen = [Field(x, dP), Field(y, dP), Field(q, P), Field(q, dP)]
    seen += [Field(u, dP), Field(v, dP), Field(o, P), Field(o, dP)]
    tests = [Field(u, dP), Field(v, dP), Field(o, P), Field(o, dP)]
    body = Form(seen, [*tests, Field(lost, np.ones((points.size, 1)))], internal, weights)
    one, unit = np.ones((1, 1)), np.ones(1)
    end, normal = Field(v, last), Field(guide, one)
    support = Form([end, normal], [end, normal], lambda f: [f[1], f[0]], unit)

    def pin(t: float) -> Form:
        place = [Field(u, first), Field(v, first)]
        force = [Field(Fx, one), Field(Fy, one)]
        vx, vy = -a * W * np.sin(W * t), a * W * np.cos(W * t)
        return Form(
            [*place, *force],
            [*place, *force, Field(work, one)],
            lambda f: [f[2], f[3], f[0] - vx, f[1] - vy, f[2] * f[0] + f[3] * f[1]],
            unit,
        )

    start = np.zeros(n)
    start[x] = np.linalg.lstsq(P, a + points, rcond=None)[0]
    start[v] = np.linalg.lstsq(P, a * W * (1 - points / L), rcond=None)[0]
    start[o.start] = -a * W / L
    scale = np.ones(n)
    scale[u] = scale[v] = scale[o] = 100.0
    scale[Fx] = scale[Fy] = scale[guide] = 1e4
    states = radau(System(mass, linear, [body, support], pin, start, scale), times, steps, tolerance=1e-10)

    def energy(state: Array) -> float:
        xs, ys, angle, k, *_ = body.values(state)
        c, s = np.cos(angle), np.sin(angle)
        e, g = xs * c + ys * s - 1, ys * c - xs * s
        kinetic = mu * ((P @ state[u]) ** 2 + (P @ state[v]) ** 2) + J * (P @ state[o]) ** 2
        elastic = EA * e**2 + GA * g**2 + EI * k**2
        return float(weights @ (kinetic + elastic) / 2 + case.slider * (last[0] @ state[u]) ** 2 / 2)

    centre = polynomials(np.array([L / 2]), L, m)[0]
    ends = [np.column_stack([states[:, x] @ row, states[:, y] @ row]) for row in (first[0], centre, last[0])]
    chord, arm = ends[2] - ends[0], ends[1] - ends[0]
    across = (chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / np.linalg.norm(chord, axis=1)
    angle = W * np.asarray(times)
    Rx, Ry = states[:, Fx][:, 0], states[:, Fy][:, 0]
    return Solution(
        times,
        ends[2][:, 0],
        across,
        a * (Ry * np.cos(angle) - Rx * np.sin(angle)),
        np.array([energy(state) for state in states]),
        states[:, work][:, 0],
        states[:, lost][:, 0],
    )


def _slopes(points: Array, length: float, count: int) -> Array:
    """Derivatives of the Legendre polynomials."""
    z = 2 * np.asarray(points) / length - 1
    columns = [legendre.legval(z, legendre.legder(np.eye(count)[i])) for i in range(count)]
    return 2 / length * np.column_stack(columns)

"""Von Karman planar beam (AWP 37): moderate rotations, the model that AWP V.A compare with.

Axial strain e = u' + w'^2/2, curvature w''; virtual work, for all (du, dw) that vanish with the supports:

    int mu (u_tt du + w_tt dw) = - int [N (du' + w' dw') + M dw''] + P dw(s_P) - Q du(L),   M = EI (w'' + eta w_t'')

The axial viscous force admits two readings, which differ a lot here:

* full:        N = EA (e + eta e_t), the same force in both equations; dissipation eta (EA e_t^2 + EI w_t''^2);
* linearised:  eta EA u_t' in the axial equation alone, so N w' keeps its elastic part; dissipation
  eta (EA u_t'^2 + EI w_t''^2). This is the one that comes near NL-L, as AWP say of their reference.
"""

from __future__ import annotations

import numpy as np

from .galerkin import (
    Array,
    Damping,
    Field,
    Form,
    System,
    Values,
    blocks,
    gauss,
    integrals,
    polynomials,
    radau,
)
from .problem import Bridge, Motion


def solve_von_karman(
    bridge: Bridge,
    damping: Damping,
    times: Array,
    *,
    modes: int = 100,
    steps: int = 100,
) -> Motion:
    """Galerkin with ``modes`` sines in w and as many polynomials in u, axial inertia kept; P is a dead load."""
    L = bridge.length
    points, weights = gauss(np.linspace(0, L, modes + 1), 6)
    k = np.pi * np.arange(1, modes + 1) / L
    sine, cosine = np.sin(points[:, None] * k), np.cos(points[:, None] * k)
    u, w, ut, wt, (work, lost), n = blocks(modes, modes, modes, modes, scalars=2)
    along, stretch = integrals(points, L, modes), polynomials(points, L, modes)

    mass, linear = np.eye(n), np.zeros((n, n))
    mass[ut, ut] = bridge.mass * along.T @ (weights[:, None] * along)
    mass[wt, wt] *= bridge.mass * L / 2
    linear[u, ut] = linear[w, wt] = np.eye(modes)
    EA, EI, eta = bridge.EA, bridge.EI, bridge.eta

    def internal(f: Values) -> list[Values]:
        u_s, slope, bend, ut_s, slope_t, bend_t = f
        elastic = EA * (u_s + slope * slope / 2)
        rate = ut_s + (slope * slope_t if damping == "full" else 0.0)
        N = elastic + eta * EA * rate
        turned = N if damping == "full" else elastic
        return [
            -N,
            -turned * slope,
            -EI * (bend + eta * bend_t),
            eta * (EA * rate * rate + EI * bend_t * bend_t),
        ]

    shapes = [(u, ut, stretch), (w, wt, k * cosine), (w, wt, -(k**2) * sine)]
    seen = [Field(block, rows) for block, _, rows in shapes] + [
        Field(block, rows) for _, block, rows in shapes
    ]
    tests = [*seen[3:], Field(lost, np.ones((points.size, 1)))]
    body = Form(seen, tests, internal, weights)

    unit, to_work = np.ones(1), Field(work, np.ones((1, 1)))
    end = Field(ut, integrals(np.array([L]), L, modes))
    compression = Form([end], [end, to_work], lambda f: [-bridge.Q + 0 * f[0], -bridge.Q * f[0]], unit)

    def load(t: float) -> Form:
        spot, P = Field(wt, np.sin(k * bridge.station(t))[None]), bridge.load(t)
        return Form([spot], [spot, to_work], lambda f: [P + 0 * f[0], P * f[0]], unit)

    start = np.zeros(n)
    start[u.start] = -bridge.Q / EA
    scale = np.ones(n)
    scale[-2:] = 1e6
    states = radau(System(mass, linear, [body, compression], load, start, scale), times, steps)

    def energy(y: Array) -> float:
        u_s, slope, bend, *_ = body.values(y)
        density = bridge.mass * ((along @ y[ut]) ** 2 + (sine @ y[wt]) ** 2)
        density += EA * (u_s + slope**2 / 2) ** 2 + EI * bend**2
        return float(weights @ density / 2)

    energies = np.array([energy(y) for y in states])
    deflection = states[:, w] @ np.sin(k * L / 2)
    return Motion(times, deflection, energies - energies[0], states[:, n - 2], states[:, n - 1])

"""Geometrically exact planar beam of AWP V.A, twice: in positions, and in strains and body velocities.

Both share only the numbers of the problem and the time integrator. Tangent t = (cos a, sin a), normal
n = (-sin a, cos a), r' = (1 + eps) t + gam n, kap = a'; N, T, M are axial force, shear force and moment.
The two dampings differ in the axial viscous force alone (moment: eta EI kap_t in both; none on shear):

* full (AWP 13-14):        N = EA eps + eta EA eps_t, in every term;
* linearised (AWP 22-23):  eta EA vt', vt = r_t . t, in N' only, so the force on the centre line is
  (EA eps t + T n)' + (eta EA vt')' t, and the dissipation is eta EA vt'^2 + eta EI kap_t^2.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

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


def solve_in_positions(
    bridge: Bridge,
    damping: Damping,
    times: Array,
    *,
    spans: int = 80,
    steps: int = 100,
    degree: int = 5,
) -> Motion:
    """Solve for the position r(s, t) of the shear-rigid beam without rotary inertia: the Euler-Bernoulli limit itself.

    eps = |r'| - 1, kap = (r' x r'')/|r'|^2. Virtual work, for all dr that vanish with the supports:

        int mu r_tt . dr = - int [N d(eps) + M d(kap)] + P dz(s_P) - Q dx(L),   N = EA (eps + eta eps_t)

    and with linearised damping N d(eps) becomes EA eps d(eps) + eta EA vt' (dr . t)'.
    B-splines of the given degree on equal spans, consistent mass; ``steps`` is the number between two of the times.
    """
    space = _Splines(bridge.length, spans, degree)
    points, weights = gauss(np.linspace(0, bridge.length, spans + 1), degree + 3)
    B = [space.at(points, d) for d in range(3)]
    full = space.size
    nx, nz = full - 1, full - 2  # x held at 0; z held at both ends
    cut_x, cut_z = slice(1, None), slice(1, -1)
    x, z, vx, vz, (work, lost), n = blocks(nx, nz, nx, nz, scalars=2)

    gram = B[0].T @ (weights[:, None] * B[0])
    mass, linear = np.eye(n), np.zeros((n, n))
    mass[vx, vx] = bridge.mass * gram[cut_x, cut_x]
    mass[vz, vz] = bridge.mass * gram[cut_z, cut_z]
    linear[x, vx], linear[z, vz] = np.eye(nx), np.eye(nz)

    def fields(rows: Array, pair: tuple[slice, slice]) -> list[Field]:
        return [Field(pair[0], rows[:, cut_x]), Field(pair[1], rows[:, cut_z])]

    EA, EI, eta = bridge.EA, bridge.EI, bridge.eta

    def internal(f: Values) -> list[Values]:
        ux, uz, bx, bz, wx, wz, cx, cz, velocity_x, velocity_z = f
        ax, az = 1 + ux, uz
        square = ax * ax + az * az
        norm = np.sqrt(square)
        tx, tz = ax / norm, az / norm
        kap = (ax * bz - az * bx) / square
        kap_t = (wx * bz + ax * cz - wz * bx - az * cx - 2 * kap * norm * (tx * wx + tz * wz)) / square
        M = EI * (kap + eta * kap_t)
        if damping == "full":
            rate = tx * wx + tz * wz
            N, viscous = EA * (norm - 1 + eta * rate), 0.0
        else:  # the rate is vt' = r_t' . t + kap r_t . n
            rate = tx * wx + tz * wz + kap * (tx * velocity_z - tz * velocity_x)
            N, viscous = EA * (norm - 1 + eta * rate), eta * EA * rate
        # d(kap) = [dr' x r'' + r' x dr'' - 2 kap r' . dr']/|r'|^2
        return [
            -(N * tx + M * (bz - 2 * kap * ax) / square),
            -(N * tz + M * (-bx - 2 * kap * az) / square),
            M * az / square,
            -M * ax / square,
            viscous * kap * tz,
            -viscous * kap * tx,
            eta * (EA * rate * rate + EI * kap_t * kap_t),
        ]

    ones = Field(lost, np.ones((points.size, 1)))
    tests = [*fields(B[1], (vx, vz)), *fields(B[2], (vx, vz)), *fields(B[0], (vx, vz)), ones]
    seen = [f for pair in ((x, z), (vx, vz)) for rows in B[1:] for f in fields(rows, pair)]
    body = Form([*seen, *fields(B[0], (vx, vz))], tests, internal, weights)

    end = Field(vx, space.at(np.array([bridge.length]))[:, cut_x])
    to_work, unit = Field(work, np.ones((1, 1))), np.ones(1)
    compression = Form([end], [end, to_work], lambda f: [-bridge.Q + 0 * f[0], -bridge.Q * f[0]], unit)

    def load(t: float) -> Form:
        spot, P = Field(vz, space.at(np.array([bridge.station(t)]))[:, cut_z]), bridge.load(t)
        return Form([spot], [spot, to_work], lambda f: [P + 0 * f[0], P * f[0]], unit)

    start = np.zeros(n)
    start[x] = -bridge.Q / EA * space.abscissae[cut_x]
    scale = np.ones(n)
    scale[-2:] = 1e6
    states = radau(System(mass, linear, [body, compression], load, start, scale), times, steps)

    def energy(y: Array) -> float:
        ux, uz, bx, bz, *_, velocity_x, velocity_z = body.values(y)
        norm = np.hypot(1 + ux, uz)
        kap = ((1 + ux) * bz - uz * bx) / norm**2
        density = bridge.mass * (velocity_x**2 + velocity_z**2) + EA * (norm - 1) ** 2 + EI * kap**2
        return float(weights @ density / 2)

    middle = space.at(np.array([bridge.length / 2]))[0, cut_z]
    energies = np.array([energy(y) for y in states])
    return Motion(times, states[:, z] @ middle, energies - energies[0], states[:, n - 2], states[:, n - 1])


def solve_in_strains(
    bridge: Bridge,
    damping: Damping,
    times: Array,
    *,
    degree: int = 64,
    steps: int = 100,
    rotary: float = 1e-5,
    shear: float = 1e5,
) -> Motion:
    """Solve the intrinsic equations (AWP 34) for body velocities vt, vn, om and strains eps, gam, kap.

        mu (vt_t - om vn) = N' - kap T + P sin a         eps_t = vt' - kap vn + om gam
        mu (vn_t + om vt) = T' + kap N* + P cos a        gam_t = vn' + kap vt - om (1 + eps)
        J om_t            = M' + (1 + eps) T - gam N*    kap_t = om'

    N* is N with full damping, its elastic part alone with linearised damping. Rotary inertia J = ``rotary`` mu I/A
    and shear stiffness ``shear`` EA are those of AWP. The dead loads need the angle: a = a0(t) + int kap with
    a0_t = om(0). The support at s = L is the constraint vt sin a + vn cos a = 0 with its reaction; the deflection
    integrates vt sin a + vn cos a at mid-span.

    One polynomial on the whole beam: velocities of the given degree, strains and shear force one degree less, all
    products integrated exactly, consistent mass. The strain equations hold in projection, which keeps the energy
    balance of the continuous problem.
    """
    L = bridge.length
    points, weights = gauss(np.array([0, L]), (3 * degree) // 2 + 2)
    EA, EI, eta, mu = bridge.EA, bridge.EI, bridge.eta, bridge.mass
    J, GA = rotary * mu * bridge.inertia / bridge.area, shear * EA
    m = degree
    vt, vn, om, eps, kap, T, (a0, reaction, mid, work, lost), n = blocks(m, m, m + 1, m, m, m, scalars=5)

    phi, psi = integrals(points, L, m), polynomials(points, L, m)
    one = np.ones((points.size, 1))
    phi_om = np.hstack([one, phi])
    psi_om = np.hstack([0 * one, psi])

    mass, linear = np.zeros((n, n)), np.zeros((n, n))
    for block, basis, factor in (
        (vt, phi, mu),
        (vn, phi, mu),
        (om, phi_om, J),
        (eps, psi, 1.0),
        (T, psi, 1 / GA),
    ):
        mass[block, block] = factor * basis.T @ (weights[:, None] * basis)
    mass[kap, kap] = np.eye(m)
    linear[kap, om] = np.eye(m, m + 1, 1)  # the strains of om are its coefficients but the first
    for scalar in (a0, mid, work, lost):
        mass[scalar, scalar] = 1.0
    linear[a0, om.start] = 1.0

    def internal(f: Values) -> list[Values]:
        vt, vn, om, vt_s, vn_s, om_s, eps, kap, T = f
        gam = T / GA
        full_rate = vt_s - kap * vn + om * gam
        rate = full_rate if damping == "full" else vt_s
        N = EA * (eps + eta * rate)
        turned = N if damping == "full" else EA * eps
        M = EI * (kap + eta * om_s)
        return [
            mu * om * vn - kap * T,
            -N,
            -mu * om * vt + kap * turned,
            -T,
            (1 + eps) * T - gam * turned,
            -M,
            full_rate,
            vn_s + kap * vt - om * (1 + eps),
            eta * (EA * rate * rate + EI * om_s * om_s),
        ]

    values = [Field(vt, phi), Field(vn, phi), Field(om, phi_om)]
    slopes = [Field(vt, psi), Field(vn, psi), Field(om, psi_om)]
    seen = [*values, *slopes, Field(eps, psi), Field(kap, psi), Field(T, psi)]
    tests = [f for pair in zip(values, slopes, strict=True) for f in pair]
    tests += [Field(eps, psi), Field(T, psi), Field(lost, one)]
    body = Form(seen, tests, internal, weights)

    unit, single = np.ones(1), np.ones((1, 1))

    def spot(station: float) -> list[Field]:
        """Body velocities and angle at a station."""
        row = integrals(np.array([station]), L, m)
        return [Field(vt, row), Field(vn, row), Field(a0, single), Field(kap, row)]

    def support(f: Values) -> list[Values]:
        vt, vn, a0, turn, R = f
        sine, cosine = np.sin(a0 + turn), np.cos(a0 + turn)
        R = R * force
        slip = vt * cosine - vn * sine
        return [
            -bridge.Q * cosine + R * sine,
            bridge.Q * sine + R * cosine,
            vt * sine + vn * cosine,
            -bridge.Q * slip,
        ]

    force = 1e6  # unit of the reaction, for a well-scaled matrix
    at_end = spot(L)
    end = Form(
        [*at_end, Field(reaction, single)],
        [*at_end[:2], Field(reaction, single), Field(work, single)],
        support,
        unit,
    )

    def across(f: Values) -> Values:
        vt, vn, a0, turn = f
        return vt * np.sin(a0 + turn) + vn * np.cos(a0 + turn)

    middle = Form(spot(L / 2), [Field(mid, single)], lambda f: [across(f)], unit)

    def load(t: float) -> Form:
        P, place = bridge.load(t), spot(bridge.station(t))

        def flux(f: Values) -> list[Values]:
            angle = f[2] + f[3]
            return [P * np.sin(angle), P * np.cos(angle), P * across(f)]

        return Form(place, [*place[:2], Field(work, single)], flux, unit)

    start = np.zeros(n)
    start[eps.start] = -bridge.Q / EA
    scale = np.ones(n)
    scale[T] = scale[work] = scale[lost] = 1e6
    states = radau(System(mass, linear, [body, end, middle], load, start, scale), times, steps)

    def energy(y: Array) -> float:
        vt, vn, om, *_, eps, kap, T = body.values(y)
        density = mu * (vt**2 + vn**2) + J * om**2 + EA * eps**2 + EI * kap**2 + T**2 / GA
        return float(weights @ density / 2)

    energies = np.array([energy(y) for y in states])
    return Motion(
        times, states[:, mid.start], energies - energies[0], states[:, work.start], states[:, lost.start]
    )


class _Splines:
    """B-splines on equal spans of [0, length], open knots."""

    def __init__(self, length: float, spans: int, degree: int) -> None:
        inner = np.linspace(0, length, spans + 1)
        knots = np.concatenate([[0.0] * degree, inner, [length] * degree])
        self.size = spans + degree
        self.abscissae = np.array([knots[i + 1 : i + degree + 1].mean() for i in range(self.size)])
        self._spline = BSpline(knots, np.eye(self.size), degree)

    def at(self, points: Array, derivative: int = 0) -> Array:
        """Values or derivatives of all splines, one row a point."""
        return self._spline(np.asarray(points, dtype=float), derivative)

"""A planar bar in the absolute nodal coordinate formulation (ANCF) whose law is that of three-dimensional strains.

The position of a material point (x, y, z) of a bar of square section is polynomial over the section, with vectors of
the line as coefficients; the motion is symmetric about the plane z = 0:

    in the plane   r0 + y r_y                      + y^2/2 r_yy + z^2/2 r_zz
    across         z (c                            + y d)

The first column is the element of lowest order, with position and section vectors at its nodes; with both columns,
``enriched``, the section can bulge as Saint-Venant's bent bar does. All coefficients are Lagrange polynomials through
Gauss-Lobatto points along x. Energy and dissipation are those of the solid (Abdel-Nasser and Shabana; LLT 2.6):

    2 W = lambda tr(E)^2 + 2 mu E:E        2 Psi = lambda_v tr(E_t)^2 + 2 mu_v E_t:E_t       (E Green-Lagrange strain)

No lateral contraction is prescribed and no stress condition is used: the section finds its own.

``python -m tests.reference.independent.ancf``, from the repository root, prints rows of
docs/explanation/llt_cantilever.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp
from scipy.interpolate import lagrange

from .galerkin import Array, gauss

UNIT = np.eye(3)


@dataclass(frozen=True)
class Bar:
    """The cantilever of LLT section 3, SI units; times of shear and of volume change."""

    shear_time: float = 0.02
    bulk_time: float = 0.02
    enriched: bool = True
    young: float = 1e6
    poisson: float = 0.3
    density: float = 1000.0
    length: float = 0.3
    side: float = 0.01
    elements: int = 3
    order: int = 5

    @property
    def mu(self) -> float:
        """Shear modulus."""
        return self.young / 2 / (1 + self.poisson)

    @property
    def lam(self) -> float:
        """First Lame modulus."""
        return self.young * self.poisson / (1 + self.poisson) / (1 - 2 * self.poisson)

    @property
    def mu_v(self) -> float:
        """Shear viscosity, gamma_v2 = tau_S."""
        return self.mu * self.shear_time

    @property
    def lam_v(self) -> float:
        """K tau_B - 2/3 G tau_S, gamma_v1 = tau_B."""
        return (self.lam + 2 / 3 * self.mu) * self.bulk_time - 2 / 3 * self.mu * self.shear_time


@dataclass(frozen=True)
class Motion:
    """Places of the free end's centre (n, 2), m, at the times, and the energies, J."""

    times: Array
    tip: Array
    energy: Array


class Ancf:
    """Semi-discrete equations ``mass q_tt = load - forces(q, q_t)`` of the free coordinates."""

    def __init__(self, bar: Bar, held: bool = True) -> None:
        self.bar = bar
        nodes = bar.elements * bar.order + 1
        edges = np.linspace(0, bar.length, bar.elements + 1)
        x, wx = gauss(edges, bar.order + 1)
        self.values, self.slopes = _lagrange(edges, bar.order, x)
        half = bar.side / 2
        y, wy = gauss(np.array([-half, half]), 4)
        z, wz = gauss(np.array([0, half]), 2)
        grid = np.meshgrid(np.arange(x.size), y, z, indexing="ij")
        at = grid[0].ravel()
        y, z = grid[1].ravel(), grid[2].ravel()
        self.weights = 2 * np.einsum("i,j,k->ijk", wx, wy, wz).ravel()
        plane = [np.ones_like(y), y] + ([y**2 / 2, z**2 / 2] if bar.enriched else [])
        plane_y = [0 * y, np.ones_like(y)] + ([y, 0 * y] if bar.enriched else [])
        plane_z = [0 * y, 0 * y] + ([0 * y, z] if bar.enriched else [])
        across = [z, y * z] if bar.enriched else [z]
        across_y = [0 * y, z] if bar.enriched else [0 * y]
        across_z = [np.ones_like(y), y] if bar.enriched else [np.ones_like(y)]
        N, dN = self.values[at], self.slopes[at]
        k, m = len(plane), len(across)
        size = (2 * k + m) * nodes
        # rows of F: components 1 and 2 in the plane, 3 across; columns: x, y, z
        F = np.zeros((3, 3, y.size, size))
        self.shape = np.zeros((3, y.size, size))
        for c in (0, 1):
            for j in range(k):
                cols = slice((2 * j + c) * nodes, (2 * j + c + 1) * nodes)
                F[c, 0][:, cols] = plane[j][:, None] * dN
                F[c, 1][:, cols] = plane_y[j][:, None] * N
                F[c, 2][:, cols] = plane_z[j][:, None] * N
                self.shape[c][:, cols] = plane[j][:, None] * N
        for j in range(m):
            cols = slice((2 * k + j) * nodes, (2 * k + j + 1) * nodes)
            F[2, 0][:, cols] = across[j][:, None] * dN
            F[2, 1][:, cols] = across_y[j][:, None] * N
            F[2, 2][:, cols] = across_z[j][:, None] * N
            self.shape[2][:, cols] = across[j][:, None] * N
        self.gradient = F
        # a clamp that lets the section contract: it holds the centre and keeps the section plane
        fixed = [0, nodes] + [2 * j * nodes for j in range(1, k)] if held else []
        self.free = np.setdiff1d(np.arange(size), fixed)
        self.nodes = nodes
        start = np.zeros(size)
        start[:nodes] = _points(edges, bar.order)
        start[3 * nodes : 4 * nodes] = 1.0  # r_y = e2
        start[2 * k * nodes : (2 * k + 1) * nodes] = 1.0  # c
        self.start = start

    @cached_property
    def mass(self) -> Array:
        """Constant consistent mass of the free coordinates."""
        S = self.shape[:, :, self.free]
        return np.asarray(self.bar.density * np.einsum("cpi,p,cpj->ij", S, self.weights, S, optimize=True))

    @cached_property
    def _rows(self) -> Array:
        """Deformation gradient of the free coordinates, (9 points, free)."""
        return self.gradient[..., self.free].reshape(-1, self.free.size)

    def _at_points(self, q: Array) -> Array:
        return (self.gradient.reshape(-1, q.size) @ q).reshape(3, 3, -1)

    def whole(self, free: Array, base: Array | None = None) -> Array:
        """Return all coordinates of the free ones."""
        out = (self.start if base is None else base).copy()
        out[self.free] = free
        return out

    def _stresses(self, q: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Return deformation gradient, its rate, and the second Piola-Kirchhoff stress at the points."""
        bar = self.bar
        F, Ft = self._at_points(q), self._at_points(rate)
        E = (np.einsum("kip,kjp->ijp", F, F) - UNIT[..., None]) / 2
        A = np.einsum("kip,kjp->ijp", Ft, F)
        Et = (A + A.transpose(1, 0, 2)) / 2
        pressure = bar.lam * np.einsum("iip->p", E) + bar.lam_v * np.einsum("iip->p", Et)
        return F, Ft, pressure * UNIT[..., None] + 2 * bar.mu * E + 2 * bar.mu_v * Et

    def forces(self, q: Array, rate: Array) -> Array:
        """Return the internal forces on the free coordinates."""
        F, _, S = self._stresses(q, rate)
        return np.asarray(self._rows.T @ (self.weights * np.einsum("kip,ijp->kjp", F, S)).ravel())

    def tangents(self, q: Array, rate: Array) -> tuple[Array, Array]:
        """Return the derivatives of the internal forces by positions and by velocities."""
        bar = self.bar
        F, Ft, S = self._stresses(q, rate)

        def moduli(lam: float, mu: float, G: Array) -> Array:
            """F_ai (lam d_ij G_bm + mu (G_bi d_jm + G_bj d_im)), by the components bm of F or of its rate."""
            unlike = np.einsum("amp,bjp->ajbmp", F, G) + np.einsum("aip,bip,jm->ajbmp", F, G, UNIT)
            return np.asarray(lam * np.einsum("ajp,bmp->ajbmp", F, G) + mu * unlike)

        elastic = moduli(bar.lam, bar.mu, F) + moduli(bar.lam_v, bar.mu_v, Ft)
        viscous = moduli(bar.lam_v, bar.mu_v, F)
        elastic += np.einsum("ab,mjp->ajbmp", UNIT, S)
        R = self._rows.reshape(9, self.weights.size, -1)
        both = []
        for parts in (elastic, viscous):
            acted = np.einsum("abp,bpj->apj", (self.weights * parts).reshape(9, 9, -1), R, optimize=True)
            both.append(self._rows.T @ acted.reshape(self._rows.shape))
        return both[0], both[1]

    def energy(self, q: Array, rate: Array) -> float:
        """Return kinetic and elastic energy together, J."""
        F = self._at_points(q)
        E = (np.einsum("kip,kjp->ijp", F, F) - np.eye(3)[..., None]) / 2
        density = self.bar.lam * np.einsum("iip->p", E) ** 2 / 2 + self.bar.mu * np.einsum("ijp,ijp->p", E, E)
        v = rate[self.free]
        return float(self.weights @ density + v @ self.mass @ v / 2)

    def end_load(self, force: Array) -> Array:
        """Return a dead force (2,), spread evenly over the end section."""
        load = np.zeros(self.start.size)
        moment = self.bar.side**2 / 24  # mean of y^2/2 and of z^2/2
        for j, mean in enumerate((1.0, 0.0, moment, moment) if self.bar.enriched else (1.0, 0.0)):
            for c in (0, 1):
                load[(2 * j + c + 1) * self.nodes - 1] = mean * force[c]
        return load[self.free]

    def equilibrium(self, load: Array, steps: int = 10) -> Array:
        """Return all coordinates under a dead load, by Newton's method in load steps."""
        q, still = self.start.copy(), np.zeros(self.start.size)
        for k in range(steps):
            for _ in range(30):
                residual = (k + 1) / steps * load - self.forces(q, still)
                change = np.linalg.solve(self.tangents(q, still)[0], residual)
                q[self.free] += change
                if np.abs(change).max() < 1e-11:
                    break
            else:
                raise ArithmeticError("no equilibrium")
        return q

    def eigenvalues(self) -> Array:
        """Return the eigenvalues of small motions about the straight bar, by size."""
        K, D = self.tangents(self.start, np.zeros_like(self.start))
        n = K.shape[0]
        A = np.zeros((2 * n, 2 * n))
        A[:n, n:] = np.eye(n)
        A[n:, :n], A[n:, n:] = -np.linalg.solve(self.mass, K), -np.linalg.solve(self.mass, D)
        found = np.linalg.eigvals(A)
        return np.asarray(found[np.argsort(np.abs(found))])

    def release(self, q: Array, times: Array, tolerance: float = 1e-6) -> Motion:
        """Return the free motion from rest at the coordinates q (Radau IIA of SciPy)."""
        n = self.free.size
        still = np.zeros(self.start.size)
        inverse = np.linalg.inv(self.mass)

        def slope(_t: float, y: Array) -> Array:
            force = self.forces(self.whole(y[:n]), self.whole(y[n:], still))
            return np.concatenate([y[n:], -inverse @ force])

        def jacobian(_t: float, y: Array) -> Array:
            K, D = self.tangents(self.whole(y[:n]), self.whole(y[n:], still))
            return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ D]])

        begin = np.concatenate([q[self.free], np.zeros(n)])
        found = solve_ivp(
            slope,
            (times[0], times[-1]),
            begin,
            "Radau",
            times,
            jac=jacobian,
            rtol=tolerance,
            atol=tolerance * 1e-2,
        )
        if not found.success:
            raise ArithmeticError(found.message)
        whole = [(self.whole(y[:n]), self.whole(y[n:], still)) for y in found.y.T]
        tip = np.array([[q[self.nodes - 1], q[2 * self.nodes - 1]] for q, _ in whole])
        return Motion(times, tip, np.array([self.energy(*pair) for pair in whole]))


def uniaxial_modulus(bar: Bar, s: complex) -> complex:
    """Return E*(s) of a bar free to contract: 1/E* = 1/(9 K*) + 1/(3 G*), K* = K (1 + s tau_B), G* likewise."""
    bulk = (bar.lam + 2 / 3 * bar.mu) * (1 + s * bar.bulk_time)
    shear = bar.mu * (1 + s * bar.shear_time)
    return 9 * bulk * shear / (3 * bulk + shear)


def _points(edges: Array, order: int) -> Array:
    """Gauss-Lobatto points of all elements."""
    inner = legendre.Legendre.basis(order).deriv().roots()
    x = np.concatenate([[-1.0], np.real(inner), [1.0]])
    parts = [a + (b - a) * (x[:-1] + 1) / 2 for a, b in pairwise(edges)]
    return np.append(np.concatenate(parts), edges[-1])


def _lagrange(edges: Array, order: int, points: Array) -> tuple[Array, Array]:
    """Values and slopes of the shape functions along x, one row a point."""
    nodes = _points(edges, order)
    values, slopes = np.zeros((points.size, nodes.size)), np.zeros((points.size, nodes.size))
    each = points.size // (edges.size - 1)
    for e in range(edges.size - 1):
        mine, rows = slice(e * order, e * order + order + 1), slice(e * each, (e + 1) * each)
        for j, one in enumerate(np.eye(order + 1)):
            shape = lagrange(nodes[mine] - edges[e], one)
            values[rows, e * order + j] = shape(points[rows] - edges[e])
            slopes[rows, e * order + j] = shape.deriv()(points[rows] - edges[e])
    return values, slopes


def _print_rows() -> None:
    """Print the tip of LLT's swing under its load and at its first two maxima, for both elements."""
    for enriched, elements, order in ((True, 2, 5), (False, 2, 5)):
        beam = Ancf(Bar(enriched=enriched, elements=elements, order=order))
        bent = beam.equilibrium(beam.end_load(np.array([0.0, 0.035])))
        times = np.linspace(0, 4.2, 841)
        motion = beam.release(bent, times, 1e-5)
        y = motion.tip[:, 1] / beam.bar.length
        print(f"enriched {enriched}: tip {motion.tip[0] / beam.bar.length}")
        for k in range(1, y.size - 1):
            if y[k] > max(y[k - 1], y[k + 1]) and y[k] > 0:
                a, b, c = y[k - 1 : k + 2]
                shift = (a - c) / (a - 2 * b + c) / 2
                print(f"  maximum {b - (a - c) * shift / 4:.5f} at {times[k] + shift * 0.005:.5f} s")


if __name__ == "__main__":
    _print_rows()

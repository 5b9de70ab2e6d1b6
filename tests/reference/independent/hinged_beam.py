"""The hinged beam of Artola, Wynn and Palacios (AWP) section V.B as the paper computed it.

The intrinsic equations (13), (14) and (22), (23) on quadratic elements of *equal order*: velocities x1 and elastic
section forces x2 are both continuous and quadratic, tested by the same functions (Galerkin), consistent mass; implicit
midpoint rule, 40 elements and 1 ms as printed. Integration by parts makes the total section forces at the ends natural
conditions. Order of components, as in the paper: (axial, across 2, across 3 | twist, bend 2, bend 3).

``python -m tests.reference.independent.hinged_beam``, from the repository root, writes
``tests/reference/data/awp_hinged.csv``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs

from .galerkin import Array, Damping, gauss

INERTIA = np.array([1.0, 1.0, 1.0, 4e-4, 2e-4, 2e-4])
NEXT, AFTER = [1, 2, 0], [2, 0, 1]
BAND = 35  # quadratic elements, twelve unknowns a node


@dataclass(frozen=True)
class Hinged:
    """Data of section V.B; ``axial`` is the axial stiffness, printed as 1e5."""

    eta: float = 1e-3
    axial: float = 1e4
    damping: Damping = "linearised"
    elements: int = 40
    step: float = 1e-3

    @property
    def stiffness(self) -> Array:
        """Six stiffnesses in the paper's order."""
        return np.array([self.axial, 5e3, 5e3, 1.0, 1.0, 2.0])

    def torque(self, t: float) -> float:
        """Torque about both bending axes, following the free end."""
        return 0.5 * float(np.sin(4 * np.pi * t)) if 0 <= t <= 0.5 else 0.0


@dataclass(frozen=True)
class History:
    """What was recorded: total and kinetic energy, J; angular velocity of the joint's section (n, 3), rad/s."""

    times: Array
    energy: Array
    spin: Array
    kinetic: Array


def cross(a: Array, b: Array) -> Array:
    """Cross products of the columns of two arrays (3, ...)."""
    return np.asarray(a[NEXT] * b[AFTER] - a[AFTER] * b[NEXT])


def skew(a: Array) -> Array:
    """Matrices (n, 3, 3) of a x . for the columns of a (3, n)."""
    out = np.zeros((a.shape[1], 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, k, j], out[:, j, k] = a[i], -a[i]
    return out


@dataclass
class Quadratic:
    """The semi-discrete equations ``mass y_t = F(y) + load``; y (nodes, 12) holds x1 and x2 of the nodes."""

    given: Hinged
    values: Array = field(init=False)
    slopes: Array = field(init=False)
    weights: Array = field(init=False)

    def __post_init__(self) -> None:
        edges = np.linspace(0.0, 1.0, self.given.elements + 1)
        points, self.weights = gauss(edges, 3)
        nodes = 2 * self.given.elements + 1
        self.values, self.slopes = np.zeros((points.size, nodes)), np.zeros((points.size, nodes))
        size = edges[1]
        for k, s in enumerate(points):
            e = k // 3
            x = (s - edges[e]) / size
            mine = slice(2 * e, 2 * e + 3)
            self.values[k, mine] = [(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)]
            self.slopes[k, mine] = np.array([4 * x - 3, 4 - 8 * x, 4 * x - 1]) / size

    @cached_property
    def both(self) -> Array:
        """Values above slopes, at the points."""
        return np.vstack([self.values, self.slopes])

    def fluxes(self, y: Array) -> tuple[Array, Array, Array, Array]:
        """Give what is tested by values and by slopes, momentum and strain equations: four arrays (6, points)."""
        at = (self.both @ y).T
        count = self.weights.size
        x1, x2, x1_s = at[:6, :count], at[6:, :count], at[:6, count:]
        strain = x2 / self.given.stiffness[:, None]
        momentum = x1 * INERTIA[:, None]
        v, w, f, m, gamma, kappa = x1[:3], x1[3:], x2[:3], x2[3:], strain[:3], strain[3:]
        rate = x1_s.copy()  # x1' - E^T x1, with E^T x1 = (w x e1, 0)
        rate[1] -= w[2]
        rate[2] += w[1]
        turned = np.concatenate([cross(gamma, w) + cross(kappa, v), cross(kappa, w)])
        viscous_rate = rate + turned if self.given.damping == "full" else rate
        viscous = (self.given.eta * self.given.stiffness)[:, None] * viscous_rate
        total = x2 + viscous
        if self.given.damping == "full":
            f, m = total[:3], total[3:]
        balance = np.concatenate(
            [
                cross(kappa, f) - cross(w, momentum[:3]),
                cross(gamma, f) + cross(kappa, m) - cross(v, momentum[:3]) - cross(w, momentum[3:]),
            ]
        )
        balance[4] -= total[2]  # E S: e1 x f
        balance[5] += total[1]
        return balance, -total, rate + turned, viscous_rate

    def force(self, y: Array) -> Array:
        """Evaluate F(y), (nodes, 12)."""
        balance, total, strain, _ = self.fluxes(y)
        tested = np.concatenate(
            [np.concatenate([balance, strain]), np.concatenate([total, np.zeros_like(total)])], axis=1
        )
        return np.asarray(self.both.T @ (np.tile(self.weights, 2) * tested).T)

    def banded(self, y: Array) -> Array:
        """Give the derivative of F, as LAPACK stores bands: complex steps of the fluxes at the points."""
        nodes, count = y.shape[0], self.weights.size
        at = self.both @ y
        mine = [slice(2 * (k // 3), 2 * (k // 3) + 3) for k in range(count)]
        N = np.stack([self.values[k, mine[k]] for k in range(count)])
        B = np.stack([self.slopes[k, mine[k]] for k in range(count)])
        tangent = self.point_tangent(at[:count].T, at[count:].T)  # (n, tested 18, seen 18)
        parts = np.zeros((count, 3, 12, 3, 12))
        for rows, test in ((slice(0, 12), N), (slice(12, 18), B)):
            for columns, seen in ((slice(0, 12), N), (slice(12, 18), B)):
                block = np.einsum("k,ki,kj,kab->kiajb", self.weights, test, seen, tangent[:, rows, columns])
                parts[:, :, : block.shape[2], :, : block.shape[4]] += block
        return self.assembled(parts.reshape(self.given.elements, 3, 36, 36).sum(axis=1), nodes)

    def assembled(self, blocks: Array, nodes: int) -> Array:
        """Add element matrices (elements, 36, 36) in band storage, with room for pivots."""
        band = np.zeros((3 * BAND + 1, 12 * nodes))
        i, j = np.meshgrid(np.arange(36), np.arange(36), indexing="ij")
        for e, block in enumerate(blocks):
            band[2 * BAND + i - j, 24 * e + j] += block
        return band

    def point_tangent(self, at: Array, slope: Array) -> Array:
        """Derivatives of (balance, strain equation, -total) with respect to (x1, x2, x1'), (n, 18, 18)."""
        c, eta = self.given.stiffness, self.given.eta
        n = at.shape[1]
        x1, x2 = at[:6], at[6:]
        strain = x2 / c[:, None]
        v, w, gamma, kappa = skew(x1[:3]), skew(x1[3:]), skew(strain[:3]), skew(strain[3:])
        zero = np.zeros((n, 3, 3))

        def four(a: Array, b: Array, d: Array, e: Array) -> Array:
            return np.concatenate([np.concatenate([a, b], axis=2), np.concatenate([d, e], axis=2)], axis=1)

        e1 = skew(np.tile([[1.0], [0.0], [0.0]], n))
        frame = four(zero, zero, e1, zero)
        on_x1 = four(kappa, e1 + gamma, zero, kappa)  # strain rate = x1' + on_x1 x1
        on_strain = -four(w, v, zero, w)
        full = self.given.damping == "full"
        rate_x1 = on_x1 if full else four(zero, e1, zero, zero)
        rate_x2 = on_strain / c if full else 0 * on_strain
        unit, damped = np.tile(np.eye(6), (n, 1, 1)), np.diag(eta * c)
        total = [damped @ rate_x1, unit + damped @ rate_x2, np.tile(damped, (n, 1, 1))]
        rate = slope[:6] + np.einsum("kij,jk->ik", rate_x1, x1)
        S = x2 + (eta * c)[:, None] * rate if full else x2
        f, m = skew(S[:3]), skew(S[3:])
        turning = four(kappa, zero, gamma, kappa)
        momentum = x1 * INERTIA[:, None]
        p, h = skew(momentum[:3]), skew(momentum[3:])
        gyration = four(zero, p, p, h) - four(w, zero, v, w) * INERTIA
        balance = [
            (frame @ total[0]) + (turning @ total[0] if full else 0.0) + gyration,
            frame @ total[1] + (turning @ total[1] if full else turning) - four(zero, f, f, m) / c,
            frame @ total[2] + (turning @ total[2] if full else 0.0),
        ]
        kinematic = [on_x1, on_strain / c, unit]
        rows = [balance, kinematic, [-t for t in total]]
        return np.concatenate([np.concatenate(row, axis=2) for row in rows], axis=1)

    @cached_property
    def mass(self) -> Array:
        """Consistent mass of shape functions, (nodes, nodes)."""
        return np.asarray(self.values.T @ (self.weights[:, None] * self.values))

    @cached_property
    def densities(self) -> Array:
        """Inertia of x1, then compliance of x2, (12,)."""
        return np.concatenate([INERTIA, 1.0 / self.given.stiffness])

    def energies(self, y: Array) -> tuple[float, float]:
        """Kinetic and elastic energy, J."""
        at = self.values @ y
        squares = self.weights @ at**2 * self.densities / 2
        return float(squares[:6].sum()), float(squares[6:].sum())

    def linear_mass(self, nodes: int) -> Array:
        """The mass of all unknowns in band storage."""
        blocks = np.zeros((self.given.elements, 3, 12, 3, 12))
        for e in range(self.given.elements):
            mine = slice(3 * e, 3 * e + 3)
            N = self.values[mine, 2 * e : 2 * e + 3]
            gram = N.T @ (self.weights[mine, None] * N)
            blocks[e] = np.einsum("ij,ab->iajb", gram, np.diag(self.densities))
        return self.assembled(blocks.reshape(-1, 36, 36), nodes)


def solve(given: Hinged, duration: float, every: int = 100, tolerance: float = 1e-9) -> History:
    """Integrate from rest by the implicit midpoint rule; record each ``every`` steps.

    Newton with a tangent that is kept while it converges fast. The ball joint holds the velocities at s = 0.
    """
    beam = Quadratic(given)
    nodes = 2 * given.elements + 1
    h, steps = given.step, round(duration / given.step)
    y, last, before_last = np.zeros((3, nodes, 12))
    mass = beam.linear_mass(nodes)
    held = np.arange(3)
    scale = 1.0 / np.sqrt(beam.densities)
    factors: tuple[Array, Array] | None = None
    records = []

    def factorise(middle: Array) -> tuple[Array, Array]:
        band = 2.0 / h * mass - beam.banded(middle)
        for i in held:  # rows and columns of the held velocities
            for j in range(i + BAND + 1):
                band[2 * BAND + i - j, j] = band[2 * BAND + j - i, i] = 0.0
            band[2 * BAND, i] = 1.0
        factor, pivots, info = dgbtrf(band, BAND, BAND)
        if info:
            raise ArithmeticError(f"singular tangent, column {info}")
        return factor, pivots

    for k in range(steps + 1):
        if k % every == 0:
            kinetic, elastic = beam.energies(y)
            records.append([k * h, kinetic + elastic, kinetic, *y[0, 3:6]])
        if k == steps:
            break
        load = given.torque((k + 0.5) * h)
        middle = 2 * y - (3 * last - before_last) / 2  # half way to the extrapolation of three states
        before = np.inf
        for attempt in range(30):
            residual = beam.force(middle) - (2.0 / h) * (beam.mass @ (middle - y)) * beam.densities
            residual[-1, 4:6] += load
            residual[0, :3] = 0.0
            if factors is None:
                factors = factorise(middle)
            change, _ = dgbtrs(*factors[:1], BAND, BAND, residual.reshape(-1), factors[1])
            change = change.reshape(nodes, 12)
            middle = middle + change
            size = float(np.abs(change / scale).max())
            if size < tolerance:
                break
            if attempt and size > 0.1 * before:
                factors = None
            before = size
        else:
            raise ArithmeticError(f"no convergence at {k * h:.3f} s: {size:.1e}")
        before_last, last, y = last, y, 2 * middle - y
    table = np.array(records)
    return History(table[:, 0], table[:, 1], table[:, 3:], table[:, 2])


HEADER = """\
# Hinged beam of AWP section V.B, linearised damping, eta = 0.001 s: time, s; kinetic plus elastic energy and kinetic
# energy, J; angular velocity of the section at the joint in its own axes (axis of the rod first), rad/s.
# The paper's discretisation: velocities and forces continuous and quadratic, 40 elements, midpoint rule, 1 ms.
# Written by: python -m tests.reference.independent.hinged_beam
"""


def write_table(path: Path = Path("tests/reference/data/awp_hinged.csv")) -> None:
    """Follow both axial stiffnesses for 50 s; write every 0.1 s up to 2 s, then every 2 s."""
    rows = ["axial,time,energy,kinetic,spin_1,spin_2,spin_3"]
    for axial in (1e4, 1e5):
        found = solve(Hinged(axial=axial), 50.0)
        for k, t in enumerate(found.times):
            if k <= 20 or k % 20 == 0:
                values = [found.energy[k], found.kinetic[k], *found.spin[k]]
                rows.append(f"{axial:g},{t:.1f}," + ",".join(f"{value:.9g}" for value in values))
        print(rows[-1], flush=True)
    path.write_text(HEADER + "\n".join(rows) + "\n")


if __name__ == "__main__":
    write_table()

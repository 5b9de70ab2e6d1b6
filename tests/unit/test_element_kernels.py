"""Element kernels against an independent complex-step / finite-difference formulation at random states."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.finite_differences import slope_of
from helpers.small_frame import dense
from viscorod.mechanics.elements import geometric_element as geometric
from viscorod.mechanics.elements.basis import gauss, lagrange
from viscorod.mechanics.elements.gauss_batch import ElementGroup, PointFields
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.lanes import LANES
from viscorod.mechanics.elements.section_laws import SectionLaws
from viscorod.mechanics.nodes import applied_loads as loading
from viscorod.mechanics.nodes.attached_poses import ElementNodes, PointWrench
from viscorod.mechanics.rotations.rotation import inverse_motion_tangent, retract
from viscorod.solve.linear.pattern import Pattern

rng = np.random.default_rng(7)


def quaternion_product(p, q):
    return np.array(
        [
            p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
            p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
            p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
        ]
    )


def matrix(q):
    q = q / np.sqrt((q * q).sum())
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def first_order_move(r, q, dx):
    """Poses after the body increments dx, correct to first order: enough for a complex step."""
    rr = np.array([r[k] + matrix(q[k]) @ dx[k, :3] for k in range(len(r))])
    qq = np.array([q[k] + quaternion_product(q[k], np.array([0, *dx[k, 3:]]) / 2) for k in range(len(q))])
    return rr, qq


def plain_strains(shapes, slopes, r, q):
    """V and U straight from model.md section 4, in plain (complex-capable) NumPy."""
    out = []
    for shape, slope in zip(shapes, slopes, strict=True):
        f, g = shape @ q, slope @ q
        conj = f * np.array([1, -1, -1, -1])
        out.append(np.concatenate([matrix(f).T @ (slope @ r), 2 * quaternion_product(conj, g)[1:] / (f @ f)]))
    return np.array(out)


class Element:
    """One random, strongly deformed and moving element with full 6x6 matrices, optionally with attached end nodes."""

    def __init__(self, order, links=False):
        m = order + 1
        self.m = m
        self.half = 0.4
        points, self.weights = gauss(order)
        self.shapes, self.slopes = lagrange(order, points)
        self.nodes = np.arange(m)[None, :].copy()
        self.pattern = Pattern.of(m, [self.nodes])
        self.links = -np.ones((1, m), dtype=np.int64)
        self.link_r = rng.normal(size=(2, 3)) * 0.2
        self.link_q = rng.normal(size=(2, 4))
        self.link_q /= np.linalg.norm(self.link_q, axis=1)[:, None]
        if links:
            self.links[0, 0], self.links[0, -1] = 0, 1
        self.r = np.array([[0.3 * k, 0, 0] for k in range(m)]) + 0.1 * rng.normal(size=(m, 3))
        self.q = np.array([1, 0, 0, 0]) + 0.3 * rng.normal(size=(m, 4))
        self.q /= np.linalg.norm(self.q, axis=1)[:, None]
        self.twist = rng.normal(size=(m, 6))
        a = rng.normal(size=(2, 6, 6))
        self.C = a @ a.transpose(0, 2, 1)
        a = rng.normal(size=(2, 6, 6))
        self.D = a @ a.transpose(0, 2, 1)
        self.section = rng.integers(0, 2, size=(1, order))
        self.coupled = True
        self.reference = 0.2 * rng.normal(size=(1, order, 6))
        self.rate_map = rng.normal(size=(m, 6, 6))
        self.prestress = 0.3 * rng.normal(size=(1, order, 6))
        self.laws = SectionLaws.none(2)

    def assemble(self, r, q, twist, stress=None, moving=True):
        m, g = self.m, self.m - 1
        force = np.zeros((m, 6))
        blocks = np.zeros((m * m, 6, 6))
        strain, rate, S = np.zeros((3, 1, g, 6))
        operator = np.full((-(-g // LANES), m, 6, 6, LANES), np.nan)
        self.strain_operator = np.full_like(operator, np.nan)
        self.rate_blocks = np.zeros_like(blocks)
        if stress is None:
            stress = np.zeros((1, g, 6))
        fields = PointFields(stress, self.prestress, strain, rate, S, operator, self.strain_operator)
        out = geometric.Assembled(force, blocks, self.rate_blocks)
        geometric.assemble(self.arrays, self.group, fields, r, q, twist, moving, self.rate_map, True, out)
        K = dense(self.pattern, blocks)
        return force.ravel(), K, strain, rate, S, self.section_columns(S, operator)

    @property
    def arrays(self):
        p = self.m - 1

        def by_order(table):  # only the highest order is used
            return np.concatenate([np.zeros((p, *table.shape)), table[None]])

        return Elements(
            np.full(len(self.nodes), p), self.nodes, self.links, self.link_r, self.link_q, by_order(self.shapes),
            by_order(self.slopes), by_order(self.weights), np.array([self.half]), self.section, self.C, self.D, True,
            self.reference, self.pattern.slots(self.nodes), self.laws,
        )  # fmt: skip

    @property
    def group(self):
        return ElementGroup(0, len(self.nodes), self.m - 1, self.coupled, True, False)

    def section_columns(self, S, operator):
        """The change of the section forces per unit increment, as Newton's method carries them."""
        columns = np.empty((6 * self.m, *S.shape))
        for column, u in zip(columns, np.eye(6 * self.m), strict=True):
            fields = PointFields(S, S, S, S, S, operator, operator)
            geometric.update_stress(self.arrays, self.group, fields, u.reshape(self.m, 6), column)
        return np.moveaxis(columns - S, 0, -1)

    def attached(self, r, q):
        r, q = r.copy(), q.copy()
        for k in range(self.m):
            link = self.links[0, k]
            if link >= 0:
                r[k] = r[k] + matrix(q[k]) @ self.link_r[link]
                q[k] = quaternion_product(q[k], self.link_q[link])
            if k > 0 and (q[k].real @ q[k - 1].real) < 0:
                q[k] = -q[k]
        return r, q


@pytest.mark.parametrize("links", [False, True])
@pytest.mark.parametrize("order", [1, 2, 3, 5, 8])
def test_strains_rates_and_forces_match_complex_step(order, links):
    e = Element(order, links)
    slopes = e.slopes / e.half
    force, _, strain, rate, S, _ = e.assemble(e.r, e.q, e.twist)
    assert strain[0] + e.reference[0] == pytest.approx(
        plain_strains(e.shapes, slopes, *e.attached(e.r, e.q)).real, abs=1e-12
    )

    def by_complex_step(dx):
        moved = first_order_move(e.r.astype(complex), e.q.astype(complex), 1e-40j * dx)
        return plain_strains(e.shapes, slopes, *e.attached(*moved)).imag / 1e-40

    assert rate[0] == pytest.approx(by_complex_step(e.twist), rel=1e-10, abs=1e-10)
    B = np.array([by_complex_step(u.reshape(e.m, 6)) for u in np.eye(6 * e.m)])  # (unknown, point, 6)
    total = [e.C[s] @ a + e.D[s] @ b for s, a, b in zip(e.section[0], strain[0], rate[0], strict=True)]
    assert S[0] - e.prestress[0] == pytest.approx(np.array(total), rel=1e-12, abs=1e-12)
    expected = np.einsum("ugi,gi,g->u", B, S[0], e.weights * e.half)
    assert force == pytest.approx(expected, rel=1e-10, abs=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("links", [False, True])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_tangent_and_stress_operator_match_finite_differences(order, links):
    """Elastic, viscous and geometric parts together, with the twist following the pose through the rate map."""
    e = Element(order, links)
    _, _, _, _, S, _ = e.assemble(e.r, e.q, e.twist)
    _, K, _, _, _, operator = e.assemble(e.r, e.q, e.twist, stress=S)
    strain_columns = e.section_columns(np.zeros_like(S), e.strain_operator)

    def moved(x):
        dx = x.reshape(e.m, 6)
        r, q = np.empty_like(e.r), np.empty_like(e.q)
        retract(e.r, e.q, dx, r, q)
        return e.assemble(r, q, e.twist + np.einsum("nij,nj->ni", e.rate_map, dx))

    reference = slope_of(lambda x: moved(x)[0], 6 * e.m)
    assert K == pytest.approx(reference, abs=2e-8 * np.abs(reference).max())
    reference = slope_of(lambda x: moved(x)[4].ravel(), 6 * e.m).reshape(1, order, 6, -1)
    assert operator == pytest.approx(reference, abs=2e-8 * np.abs(reference).max())
    reference = slope_of(lambda x: moved(x)[2].ravel(), 6 * e.m).reshape(1, order, 6, -1)
    assert strain_columns == pytest.approx(reference, abs=2e-8 * np.abs(reference).max())


@pytest.mark.parametrize("links", [False, True])
@pytest.mark.parametrize("order", [1, 3, 8])
def test_damping_matrix_is_what_the_rate_map_multiplies(order, links):
    """It is the difference of the tangents for the rate maps T + I and T, and symmetric."""
    e = Element(order, links)
    _, with_map, *_ = e.assemble(e.r, e.q, e.twist)
    e.rate_map += np.eye(6)
    _, with_more, *_ = e.assemble(e.r, e.q, e.twist)
    damping = dense(e.pattern, e.rate_blocks)
    assert damping == pytest.approx(with_more - with_map, abs=1e-12 * np.abs(with_more).max())
    assert damping == pytest.approx(damping.T, abs=1e-12 * np.abs(damping).max())


def test_uncoupled_sections_may_skip_the_off_diagonals():
    e = Element(3)
    e.C, e.D = (np.array([np.diag(np.diag(a)) for a in matrices]) for matrices in (e.C, e.D))
    full = e.assemble(e.r, e.q, e.twist)
    e.coupled = False
    for a, b in zip(full, e.assemble(e.r, e.q, e.twist), strict=True):
        assert b == pytest.approx(a, abs=1e-12 * np.abs(a).max())


@pytest.mark.parametrize("count", [LANES - 1, LANES, LANES + 1, 2 * LANES])
def test_every_element_of_a_batch_is_assembled(count):
    """Copies of one element, side by side, each with its own nodes: all get the same forces and blocks."""
    e = Element(1)
    force, K, strain, _, S, _ = e.assemble(e.r, e.q, e.twist)
    n = 2 * count
    r, q, twist, rate_map = (np.concatenate([a] * count) for a in (e.r, e.q, e.twist, e.rate_map))
    nodes = np.arange(n).reshape(count, 2)
    repeat = [np.repeat(a, count, axis=0) for a in (e.links, e.section, e.reference, e.prestress)]
    pattern = Pattern.of(n, [nodes])
    total, blocks = np.zeros((n, 6)), np.zeros((4 * count, 6, 6))
    points = np.zeros((3, count, 1, 6))
    elements = e.arrays._replace(
        nodes=nodes, links=repeat[0], slots=pattern.slots(nodes), half_lengths=np.full(count, e.half),
        section=repeat[1], reference=repeat[2], order=np.ones(count, dtype=np.int64),
    )  # fmt: skip
    operator = np.zeros((-(-count // LANES), 2, 6, 6, LANES))
    fields = PointFields(np.zeros((count, 1, 6)), repeat[3], *points, operator, operator[:0])
    out = geometric.Assembled(total, blocks, np.zeros((0, 6, 6)))
    group = ElementGroup(0, count, 1, True, True, False)
    geometric.assemble(elements, group, fields, r, q, twist, True, rate_map, True, out)
    assert total.reshape(count, -1) == pytest.approx(np.tile(force, (count, 1)), rel=1e-12)
    assert points[0] == pytest.approx(np.repeat(strain, count, axis=0), rel=1e-12)
    assert points[2] == pytest.approx(np.repeat(S, count, axis=0), rel=1e-12)
    whole = dense(pattern, blocks)
    for first in range(0, 6 * n, 12):
        block = whole[first : first + 12, first : first + 12]
        assert block == pytest.approx(K, abs=1e-12 * np.abs(K).max())


def test_tangent_of_static_equilibrium_is_symmetric():
    """A conservative system has a symmetric tangent where the nodal forces vanish; here S = 0."""
    e = Element(3)
    _, K, *_ = e.assemble(e.r, e.q, 0 * e.twist, moving=False)
    assert K == pytest.approx(K.T, abs=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("order", [1, 3, 6])
def test_objectivity(order):
    """Superposed rigid rotations and translations change neither strains nor body forces (structure test E1)."""
    e = Element(order)
    turn = rng.normal(size=4)
    turn /= np.linalg.norm(turn)
    r = e.r @ matrix(turn).T + 50 * rng.normal(size=3)
    q = np.array([quaternion_product(turn, k) for k in e.q])
    a, b = e.assemble(e.r, e.q, e.twist), e.assemble(r, q, e.twist)
    assert a[2] == pytest.approx(b[2], abs=1e-12)
    assert a[0] == pytest.approx(b[0], abs=1e-11 * np.abs(a[0]).max())


@pytest.mark.parametrize("order", [1, 2, 5])
def test_rigid_motion_is_neither_strained_nor_damped(order):
    """E1: the strain rate of any rigid twist vanishes, so viscosity never acts on it."""
    e = Element(order)
    v, w = rng.normal(size=(2, 3))
    twist = np.array(
        [
            np.concatenate([matrix(q).T @ (v + np.cross(w, x)), matrix(q).T @ w])
            for x, q in zip(e.r, e.q, strict=True)
        ]
    )
    rate = e.assemble(e.r, e.q, twist)[3]
    assert np.abs(rate).max() < 1e-12


@pytest.mark.parametrize("links", [False, True])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_station_load_is_work_conjugate_and_its_tangent_right(order, links):
    e = Element(order, links)
    shape, _ = lagrange(order, np.array([0.3]))
    dead, following = rng.normal(size=(2, 6))
    slots = e.pattern.slots(e.nodes)[0]

    def load(x, tangent=False):
        r, q = np.empty_like(e.r), np.empty_like(e.q)
        retract(e.r, e.q, x.reshape(e.m, 6), r, q)
        external = np.zeros((e.m, 6))
        blocks = np.zeros((e.m * e.m, 6, 6))
        own = ElementNodes(e.nodes[0], e.links[0], e.link_r, e.link_q)
        wrench = PointWrench(shape[0], dead, following)
        work = loading.StationWork.of(e.m)
        loading.add_station_load(own, wrench, r, q, tangent, external, blocks, slots, work)
        return external.ravel(), blocks

    force, blocks = load(np.zeros(6 * e.m), True)
    K = dense(e.pattern, blocks)
    reference = -slope_of(lambda x: load(x)[0], 6 * e.m)
    assert K == pytest.approx(reference, abs=1e-8 * np.abs(reference).max())
    frame = matrix(shape[0] @ e.attached(e.r, e.q)[1])
    power = []
    for u in np.eye(6 * e.m):
        r, q = first_order_move(e.r.astype(complex), e.q.astype(complex), 1e-40j * u.reshape(e.m, 6))
        r, q = e.attached(r, q)
        velocity = (shape[0] @ r).imag / 1e-40
        spin = matrix(shape[0] @ q).imag / 1e-40 @ frame.T  # skew matrix of the global angular velocity
        spin = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        power.append(
            (dead[:3] + frame @ following[:3]) @ velocity + (dead[3:] + frame @ following[3:]) @ spin
        )
    assert force == pytest.approx(np.array(power), abs=1e-11)


@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.25, 1.0, 3.0, 5.5])
def test_motion_exponential_and_its_inverse_tangent(size):
    """The twist of t -> H0 exp(X + t dX) is T(X) dX: finite differences of the exponential itself."""
    X = rng.normal(size=6)
    X *= size / np.linalg.norm(X[3:])
    dX = rng.normal(size=6)
    r0, q0 = np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]])

    def pose(x):
        r, q = np.empty((1, 3)), np.empty((1, 4))
        retract(r0, q0, x[None, :], r, q)
        return r[0], matrix(q[0])

    h = 1e-3
    values = {s: pose(X + s * h * dX) for s in (-2, -1, 1, 2)}
    dr = (8 * (values[1][0] - values[-1][0]) - (values[2][0] - values[-2][0])) / (12 * h)
    dR = (8 * (values[1][1] - values[-1][1]) - (values[2][1] - values[-2][1])) / (12 * h)
    R = pose(X)[1]
    spin = R.T @ dR
    twist = np.concatenate([R.T @ dr, [spin[2, 1], spin[0, 2], spin[1, 0]]])
    inverse = np.empty((1, 6, 6))
    inverse_motion_tangent(X[None, :], 1.0, inverse)
    assert inverse[0] @ twist == pytest.approx(dX, abs=1e-8)

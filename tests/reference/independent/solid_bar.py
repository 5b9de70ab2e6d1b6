"""A bar as a solid in three dimensions: linear elasticity, elements of 27 nodes, nothing of viscorod in it."""

from itertools import product

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

POINTS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
WEIGHTS = np.array([5.0, 8.0, 5.0]) / 9.0


def line(x):
    """Quadratic shape functions of nodes -1, 0, 1 and their slopes (3,) each."""
    return np.array([x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2]), np.array([x - 0.5, -2 * x, x + 0.5])


def strain_matrix(point, size):
    """B (6, 81) at a point of an element; strains 11, 22, 33, 23, 13, 12 (engineering shear)."""
    (N, dN) = zip(*(line(x) for x in point), strict=True)
    B = np.zeros((6, 81))
    for k, (a, b, c) in enumerate(product(range(3), repeat=3)):
        x, y, z = (
            dN[0][a] * N[1][b] * N[2][c] * 2 / size[0],
            N[0][a] * dN[1][b] * N[2][c] * 2 / size[1],
            N[0][a] * N[1][b] * dN[2][c] * 2 / size[2],
        )
        B[:, 3 * k : 3 * k + 3] = [[x, 0, 0], [0, y, 0], [0, 0, z], [0, z, y], [z, 0, x], [y, x, 0]]
    return B


def bar_stress(lengths, counts, young, nu, force, torque):
    """Stress in the middle of a bar that is clamped at z = 0 and loaded at its other end.

    Args:
        lengths: along x, y, z, the bar about the z axis [m]; counts: elements along these, an even number along z.
        young, nu: constants of the material.
        force: spread evenly over the end (3,) [N]; torque: about z, as (-y, x) is [N m].

    Returns:
        points (n, 3) [m] and stresses (n, 6) [Pa] at points of the layer of elements that begins there.
    """
    size = np.array(lengths) / counts
    lame, shear = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    rule = [
        (np.array(p), np.prod(w))
        for p, w in zip(product(POINTS, repeat=3), product(WEIGHTS, repeat=3), strict=True)
    ]
    matrices = [strain_matrix(p, size) for p, _ in rule]
    own = sum(w * B.T @ law @ B for (_, w), B in zip(rule, matrices, strict=True)) * np.prod(size) / 8
    nodes = [2 * n + 1 for n in counts]
    number = np.arange(np.prod(nodes)).reshape(nodes)
    places = np.stack(
        np.meshgrid(*(np.linspace(0, a, n) for a, n in zip(lengths, nodes, strict=True)), indexing="ij"), -1
    )
    places[..., :2] -= np.array(lengths[:2]) / 2
    elements = np.array(
        [
            number[2 * i : 2 * i + 3, 2 * j : 2 * j + 3, 2 * k : 2 * k + 3].ravel()
            for i, j, k in product(*map(range, counts))
        ]
    )
    unknowns = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 81)
    rows, columns = np.repeat(unknowns, 81, axis=1).ravel(), np.tile(unknowns, (1, 81)).ravel()
    K = coo_matrix((np.tile(own.ravel(), len(elements)), (rows, columns))).tocsc()
    load = np.zeros((number.size, 3))
    area, polar = lengths[0] * lengths[1], lengths[0] * lengths[1] * (lengths[0] ** 2 + lengths[1] ** 2) / 12
    for i, j in product(range(counts[0]), range(counts[1])):
        for (p, w), (q, v) in product(zip(POINTS, WEIGHTS, strict=True), repeat=2):
            x = (i + (1 + p) / 2) * size[0] - lengths[0] / 2
            y = (j + (1 + q) / 2) * size[1] - lengths[1] / 2
            traction = np.array(force) / area + torque / polar * np.array([-y, x, 0])
            shape = np.outer(line(p)[0], line(q)[0]).ravel() * w * v * size[0] * size[1] / 4
            load[number[2 * i : 2 * i + 3, 2 * j : 2 * j + 3, -1].ravel()] += shape[:, None] * traction
    free = np.flatnonzero(np.repeat(places[..., 2].ravel() > 0.0, 3))
    moved = np.zeros(load.size)
    moved[free] = splu(K[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(
        load.ravel()[free]
    )
    # strains are most accurate at the points of the next lower rule (J. Barlow 1976)
    best = [np.array(p) for p in product((-np.sqrt(1 / 3), np.sqrt(1 / 3)), repeat=3)]
    stiff = [law @ strain_matrix(p, size) for p in best]
    points, stresses = [], []
    for element, (i, j, k) in zip(unknowns, product(*map(range, counts)), strict=True):
        if k == counts[2] // 2:
            for p, B in zip(best, stiff, strict=True):
                points.append(
                    (np.array([i, j, k]) + (1 + p) / 2) * size - [lengths[0] / 2, lengths[1] / 2, 0]
                )
                stresses.append(B @ moved[element])
    return np.array(points), np.array(stresses)

"""Straight beams by classical finite elements, written independently of the package.

Two-node elements with linear displacements and rotations, one point for bending and shear (Hughes, Taylor and
Kanoknukulchai, Int. J. Numer. Meth. Eng. 11 (1977)), and lumped masses: errors fall with the square of their number.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla


def cantilever_frequencies(length, stiffness, inertia, count, elements=4000):
    """Return the lowest frequencies of a clamped beam in bending in both planes, torsion and extension together [Hz].

    Args:
        length: of the beam [m]; stiffness, inertia: functions of the arc length, diagonals (6,) in the order of the
            package: shear 1 and 2, stretch, bending about 1 and 2, twist; masses along and inertia about the same.
        count: of frequencies.
    """
    h = length / elements
    C = np.array([stiffness((e + 0.5) * h) for e in range(elements)])
    M = np.array([inertia((e + 0.5) * h) for e in range(elements)])
    # displacement along 1 is sheared with the rotation about 2 and bent about 2, and the other way round
    found = [*_plane(C[:, 0], C[:, 4], M[:, 0], M[:, 4], h, count)]
    found += [*_plane(C[:, 1], C[:, 3], M[:, 1], M[:, 3], h, count)]
    found += [*_line(C[:, 2], M[:, 2], h, count), *_line(C[:, 5], M[:, 5], h, count)]
    return np.sort(found)[:count]


def _lumped(density, h):
    mass = np.zeros(len(density) + 1)
    mass[:-1] += 0.5 * h * density
    mass[1:] += 0.5 * h * density
    return mass


def _lowest(B, D, mass, count):
    """Return the lowest frequencies of ``B' D B`` and a diagonal mass, with the first node held."""
    K = sp.csc_array(B.T @ sp.diags_array(D) @ B)
    values = spla.eigsh(K, count, sp.diags_array(mass, format="csc"), sigma=0.0, return_eigenvectors=False)
    return np.sqrt(np.sort(values)) / (2.0 * np.pi)


def _line(stiffness, density, h, count):
    n = len(stiffness)
    slope = sp.diags_array([-np.ones(n) / h, np.ones(n) / h], offsets=[0, 1], shape=(n, n + 1))
    return _lowest(sp.csr_array(slope)[:, 1:], h * stiffness, _lumped(density, h)[1:], count)


def _plane(shear, bending, density, rotary, h, count):
    n = len(shear)
    slope = sp.diags_array([-np.ones(n) / h, np.ones(n) / h], offsets=[0, 1], shape=(n, n + 1))
    mean = sp.diags_array([np.full(n, 0.5), np.full(n, 0.5)], offsets=[0, 1], shape=(n, n + 1))
    slope, mean = sp.csr_array(slope)[:, 1:], sp.csr_array(mean)[:, 1:]
    B = sp.block_array([[slope, -mean], [None, slope]])
    mass = np.concatenate([_lumped(density, h)[1:], _lumped(rotary, h)[1:]])
    return _lowest(B, np.concatenate([h * shear, h * bending]), mass, count)

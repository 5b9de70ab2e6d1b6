"""How the nodal forces of constant section forces turn with the element: the geometric stiffness.

Coordinates and maps are those of ``strain``; the quadratic forms are second derivatives of the strains in (c, y, b).
"""

from __future__ import annotations

from typing import TypeAlias

from viscorod.mechanics.compiled import part
from viscorod.mechanics.rotation import add_skew
from viscorod.typing import Floats

StiffnessWork: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats]
"""Scratch arrays of :func:`add_geometric_stiffness`, allocated once per assembly."""


@part
def add_geometric_stiffness(
    weight: float,
    shape: Floats,
    slope: Floats,
    V: Floats,
    U: Floats,
    z0: float,
    p: Floats,
    Q: Floats,
    L: Floats,
    S: Floats,
    work: StiffnessWork,
    KT: Floats,
) -> None:
    """Add ``weight`` times the derivative of ``B^T S`` at constant ``S`` to ``KT`` (transposed, 6 m x 6 m)."""
    m = p.shape[0]
    N = S[0:3]
    M = S[3:6]
    MU = M[0] * U[0] + M[1] * U[1] + M[2] * U[2]
    NV = N[0] * V[0] + N[1] * V[1] + N[2] * V[2]
    Hyy, Hby, F, Gy, Gb, Gc, f, g = work
    Hby[:, :] = 0.0
    Hyy[0, 0] = 2.0 * MU
    F[0] = -MU
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        Hyy[0, 1 + i] = (
            2.0 * (V[i1] * N[i2] - V[i2] * N[i1]) + 4.0 * z0 * M[i] + 2.0 * (U[i1] * M[i2] - U[i2] * M[i1])
        )
        Hyy[1 + i, 0] = Hyy[0, 1 + i]
        for j in range(3):
            Hyy[1 + i, 1 + j] = 2.0 * (N[i] * V[j] + V[i] * N[j])
        Hyy[1 + i, 1 + i] -= 4.0 * NV + 2.0 * MU
        Hby[1 + i, 0] = -2.0 * M[i]
        Hby[0, 1 + i] = -2.0 * M[i]
        F[1 + i] = 2.0 * (N[i1] * V[i2] - N[i2] * V[i1]) - 2.0 * z0 * M[i] + M[i1] * U[i2] - M[i2] * U[i1]
    add_skew(M, -2.0, Hby[1:4, 1:4])
    for j in range(m):
        sj, nj = slope[j] * weight, shape[j] * weight
        for a in range(4):
            for i in range(3):
                by = yy = yb = 0.0
                for c in range(4):
                    yy += Hyy[a, c] * L[j, c, i]
                    by += Hby[a, c] * L[j, c, i]
                    yb += Hby[c, a] * L[j, c, i]
                Gy[a, i] = nj * yy + sj * yb
                Gb[a, i] = nj * by
        for i in range(3):
            l1, l2, l3 = -2.0 * nj * L[j, 1, i], -2.0 * nj * L[j, 2, i], -2.0 * nj * L[j, 3, i]
            Gc[0, i] = N[1] * l3 - N[2] * l2
            Gc[1, i] = N[2] * l1 - N[0] * l3
            Gc[2, i] = N[0] * l2 - N[1] * l1
        for k in range(m):
            sk, nk = slope[k], shape[k]
            for i in range(3):
                for c in range(3):
                    turn = 0.0
                    for a in range(4):
                        turn += L[k, a, c] * (nk * Gy[a, i] + sk * Gb[a, i])
                    KT[6 * j + 3 + i, 6 * k + 3 + c] += turn
                    push = sk * (Q[k, 0, c] * Gc[0, i] + Q[k, 1, c] * Gc[1, i] + Q[k, 2, c] * Gc[2, i])
                    KT[6 * j + 3 + i, 6 * k + c] += push
                    KT[6 * k + c, 6 * j + 3 + i] += push
    for k in range(m):
        # the nodal frame in which the force is measured turns with the node
        s, n = slope[k] * weight, shape[k] * weight
        for i in range(3):
            f[i] = s * (Q[k, 0, i] * N[0] + Q[k, 1, i] * N[1] + Q[k, 2, i] * N[2])
        add_skew(f, -1.0, KT[6 * k + 3 : 6 * k + 6, 6 * k : 6 * k + 3])
        g[0] = n * F[0]
        for i in range(3):
            g[1 + i] = n * F[1 + i] + 2.0 * s * M[i]
        trace = 0.25 * (g[0] * p[k, 0] + g[1] * p[k, 1] + g[2] * p[k, 2] + g[3] * p[k, 3])
        for i in range(3):
            f[i] = g[0] * L[k, 0, i] + g[1] * L[k, 1, i] + g[2] * L[k, 2, i] + g[3] * L[k, 3, i]
            KT[6 * k + 3 + i, 6 * k + 3 + i] -= trace
        add_skew(f, -0.5, KT[6 * k + 3 : 6 * k + 6, 6 * k + 3 : 6 * k + 6])

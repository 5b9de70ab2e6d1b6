"""What a scalar owes to section matrices, strains at rest and inertia through the balances of a step, compiled."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.typing import Floats, Integers

__all__ = ["add_of_elements", "add_of_inertia"]


@kernel
def add_of_elements(
    B: Floats,
    weights: Floats,
    nodes: Integers,
    section: Integers,
    strain: Floats,
    strain_rate: Floats,
    y: Floats,
    virtual: Floats,
    stiffness: Floats,
    damping: Floats,
) -> None:
    """Add the derivatives by section matrices ``(sections, 6, 6)`` of ``y (s, n, 6)`` times the balances.

    Args:
        B: of the strains ``(s, e, 6 points, 6 nodes)``; weights: of the Gauss points ``(e, points)`` [m].
        nodes: ``(e, nodes)``; section: ``(e, points)``; strain, strain_rate: at the stages ``(s, e, points, 6)``.
        virtual: output, the strains of ``y`` times the weights ``(s, e, points, 6)``.
    """
    for s in range(B.shape[0]):
        for e in range(B.shape[1]):
            for g in range(weights.shape[1]):
                at = section[e, g]
                for a in range(6):
                    row, total = 6 * g + a, 0.0
                    for k in range(nodes.shape[1]):
                        node = nodes[e, k]
                        for i in range(6):
                            total += B[s, e, row, 6 * k + i] * y[s, node, i]
                    total *= weights[e, g]
                    virtual[s, e, g, a] = total
                    for i in range(6):
                        stiffness[at, a, i] += total * strain[s, e, g, i]
                        damping[at, a, i] += total * strain_rate[s, e, g, i]


@kernel
def add_of_inertia(y: Floats, twist: Floats, fall: Floats, mass: Floats) -> None:
    """Add the derivatives by the nodal inertia ``(n, 6, 6)`` of ``y (s, n, 6)`` times ``M a + L1(x) M x``.

    Args:
        twist, fall: twists and accelerations against gravity at the stages ``(s, n, 6)``.
    """
    for s in range(twist.shape[0]):
        for n in range(twist.shape[1]):
            v, w = twist[s, n, :3], twist[s, n, 3:]
            f, m = y[s, n, :3], y[s, n, 3:]
            for a in range(3):
                b, c = (a + 1) % 3, (a + 2) % 3
                force = w[b] * f[c] - w[c] * f[b] + v[b] * m[c] - v[c] * m[b]
                moment = w[b] * m[c] - w[c] * m[b]
                for i in range(6):
                    mass[n, a, i] += y[s, n, a] * fall[s, n, i] - force * twist[s, n, i]
                    mass[n, 3 + a, i] += y[s, n, 3 + a] * fall[s, n, i] - moment * twist[s, n, i]

"""Drag of a medium on a section: linear and quadratic in the velocity past it, apart along and across the axis.

With the velocity of the section past the medium in body axes, ``u = v - R^T U``, per length of the rod,

    F_across = -(c_n + k_n |u_across|) u_across    F_along = -(c_t + k_t |u_along|) u_along    M_along = -c_r w_along

The linear part is the resistance of a slender body in creeping flow (Tirado and Garcia de la Torre 1979, J. Chem. Phys.
71). The other is Morison's for a member that feels the flow across and along it independently (Morison et al. 1950,
Petroleum Trans. AIME 189; Taylor 1952, Proc. R. Soc. A 214), ``k_n = rho C_n d/2`` and ``k_t = rho C_t pi d/2``.
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import lane_kernel, part
from viscorod.mechanics.rotations.vectors import Quaternion, Vector, difference, dot, rotated_back
from viscorod.typing import Floats


@lane_kernel
def resistance(law: Floats, k: int, u: Vector) -> Vector:
    """Return the force per length [N/m] on a section that moves with ``u`` [m/s] past the medium, body axes."""
    across = law[k, 1] + law[k, 4] * math.sqrt(u[0] * u[0] + u[1] * u[1])
    along = law[k, 2] + law[k, 5] * abs(u[2])
    return -across * u[0], -across * u[1], -along * u[2]


@part
def drag(law: Floats, k: int, q: Quaternion, twist: Floats, force: Floats, K: Floats, C: Floats) -> float:
    """Write the wrench of the medium and its derivatives; return the power [W/m] that motion takes from the section.

    That is what the force resists the motion with beyond the one of the same medium on a section at rest, whose power
    is work from outside.

    Args:
        law: row ``k`` has c_n, c_t [Pa s], c_r [N s], k_n, k_t [kg/m^2], U [m/s], from column 1 on.
        q: orientation of the section; twist: of the section, body axes ``(6,)``.
        force: ``(6,)`` [N/m, N]; K, C: by increments of the pose and by the twist ``(6, 6)``, zero before.
    """
    medium = rotated_back(q, (law[k, 6], law[k, 7], law[k, 8]))
    v = twist[0], twist[1], twist[2]
    u = difference(v, medium)
    f = resistance(law, k, u)
    still = resistance(law, k, difference((0.0, 0.0, 0.0), medium))
    for a in range(3):
        force[a], force[3 + a] = f[a], 0.0
    force[5] = -law[k, 3] * twist[5]
    speed = math.sqrt(u[0] * u[0] + u[1] * u[1])
    slope = law[k, 4] / speed if speed > 0.0 else 0.0
    for a in range(2):
        for b in range(2):
            C[a, b] = -slope * u[a] * u[b]
        C[a, a] -= law[k, 1] + law[k, 4] * speed
    C[2, 2] = -(law[k, 2] + 2.0 * law[k, 5] * abs(u[2]))
    C[5, 5] = -law[k, 3]
    for a in range(3):  # du = theta x medium
        for j in range(3):
            b, c = (j + 1) % 3, (j + 2) % 3
            K[a, 3 + j] = C[a, c] * medium[b] - C[a, b] * medium[c]
    power: float = dot(difference(still, f), v) - force[5] * twist[5]
    return power

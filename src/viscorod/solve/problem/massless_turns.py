"""Refuse rigid nodes that can turn without inertia, such as a point mass on a joint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.bodies.body_base import AnyBody
from viscorod.solve.problem.mesh import Mesh
from viscorod.solve.problem.problem import SupportSet
from viscorod.typing import Floats

__all__ = ["refuse_massless_turns"]

_NONE = 1e-15
"""Part of the largest principal inertia of a node, or of its mass and the model's size, that counts as none."""


def refuse_massless_turns(
    bodies: Mapping[str, AnyBody], mesh: Mesh, mass: Floats, supports: SupportSet
) -> None:
    """Refuse nodes of bodies that have no inertia about some axis through their mass centre which no support holds.

    Args:
        bodies: by name, in the order of the mesh.
        mesh: of the model.
        mass: nodal masses (n, 6, 6) with all that is attached, along the node's axes; kg, kg m, kg m^2.
        supports: what holds nodes.

    Raises:
        InputError: there are such nodes; the message names the bodies and the axis.
    """
    faults = []
    names = list(bodies)
    for node in dict.fromkeys(mesh.body_nodes.tolist()):
        own, R = mass[node], matrices(mesh.quaternions[node][None])[0]
        free = np.eye(3)
        if node in supports.nodes:
            k = int(np.argmax(supports.nodes == node))
            free = supports.axes[k][:, supports.fixed[k, 3:] == 0.0]
        if not free.size:
            continue
        inertia = own[3:, 3:] - own[3:, :3] @ np.linalg.solve(own[:3, :3], own[:3, 3:])
        turned = free.T @ R @ (inertia + inertia.T) @ R.T @ free / 2.0
        values, axes = np.linalg.eigh(turned)
        if values[0] > _NONE * max(float(values[-1]), float(np.abs(own[3:, 3:]).max())):
            continue
        joined = [name for name, at in zip(names, mesh.body_nodes.tolist(), strict=True) if at == node]
        axis = free @ axes[:, 0]
        about = "" if values[-1] <= 0.0 else f" about ({', '.join(f'{x:.3g}' for x in axis + 0.0)})"
        faults.append(
            Fault(
                f"bodies.{joined[0]}.inertia",
                " and ".join(joined) + (" together" if len(joined) > 1 else ""),
                f"nothing gives turning{about} an inertia: a joint or a spring does not",
                "attach the body to a rod, hold its rotations by a support, or give it an inertia, such as that of a "
                "small ball, 2/5 m r^2",
            )
        )
    if faults:
        raise InputError(faults)

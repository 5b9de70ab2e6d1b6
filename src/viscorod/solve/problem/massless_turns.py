"""Refuse rigid nodes that can turn without inertia, such as a point mass on a joint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.bodies.body_base import AnyBody
from viscorod.solve.problem.mesh import Mesh
from viscorod.typing import Floats

__all__ = ["refuse_massless_turns"]

_NONE = 1e-15
"""Part of the largest principal inertia of a node, or of its mass and the model's size, that counts as none."""


def refuse_massless_turns(bodies: Mapping[str, AnyBody], mesh: Mesh, mass: Floats) -> None:
    """Refuse nodes of bodies that have no inertia about some axis through their mass centre.

    Args:
        bodies: by name, in the order of the mesh.
        mesh: of the model.
        mass: nodal masses (n, 6, 6) with all that is attached, along the node's axes; kg, kg m, kg m^2.

    Raises:
        InputError: there are such nodes; the message names the bodies and the axis.
    """
    faults = []
    names = list(bodies)
    for node in dict.fromkeys(mesh.body_nodes.tolist()):
        own = mass[node]
        inertia = own[3:, 3:] - own[3:, :3] @ np.linalg.solve(own[:3, :3], own[:3, 3:])
        values, axes = np.linalg.eigh((inertia + inertia.T) / 2.0)
        if values[0] > _NONE * max(float(values[2]), float(np.abs(own[3:, 3:]).max())):
            continue
        joined = [name for name, at in zip(names, mesh.body_nodes.tolist(), strict=True) if at == node]
        axis = matrices(mesh.quaternions[node][None])[0] @ axes[:, 0]
        about = "" if values[2] <= 0.0 else f" about ({', '.join(f'{x:.3g}' for x in axis + 0.0)})"
        faults.append(
            Fault(
                f"bodies.{joined[0]}.inertia",
                " and ".join(joined) + (" together" if len(joined) > 1 else ""),
                f"nothing gives turning{about} an inertia: a joint, a spring or a support does not",
                "attach the body to a rod, or give it an inertia, such as that of a small ball, 2/5 m r^2",
            )
        )
    if faults:
        raise InputError(faults)

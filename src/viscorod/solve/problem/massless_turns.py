"""Refuse rigid nodes that can turn without inertia, such as a point mass on a joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.bodies.body_base import AnyBody
from viscorod.solve.problem.joint_set import JointSet
from viscorod.solve.problem.mesh import Mesh
from viscorod.solve.problem.problem import SupportSet
from viscorod.typing import Floats, Integers

__all__ = ["refuse_massless_turns"]

_NONE = 1e-15
"""Part of the largest principal inertia of a node, or of its mass and the model's size, that counts as none."""

_UNHELD = 1e-8
"""Part of a turn by which joints may move, at most, where they do not hold it."""


class _Turns(NamedTuple):
    """Turns of a node without inertia: axes ``(3, k)``, global, and body increments ``(6, k)`` of the node.

    ``all_axes`` says that it may turn about any axis.
    """

    node: int
    axes: Floats
    increments: Floats
    all_axes: bool


def refuse_massless_turns(
    bodies: Mapping[str, AnyBody], mesh: Mesh, mass: Floats, supports: SupportSet, joints: JointSet
) -> None:
    """Refuse nodes of bodies that have no inertia about some axis through their mass centre which nothing holds.

    A support holds a turn of its node, joints hold combinations of turns: a thin bar on a hinge cannot turn about its
    own axis. What is held needs no inertia, since then masses and conditions together leave no acceleration open.

    Args:
        bodies: by name, in the order of the mesh.
        mesh: of the model.
        mass: nodal masses (n, 6, 6) with all that is attached, along the node's axes; kg, kg m, kg m^2.
        supports, joints: what holds nodes.

    Raises:
        InputError: there are such nodes; the message names the bodies and the axis.
    """
    found = [
        turns
        for node in dict.fromkeys(mesh.body_nodes.tolist())
        if (turns := _massless(node, mesh, mass, supports)) is not None
    ]
    if not found:
        return
    names = list(bodies)
    faults = []
    for turns, weights in zip(found, _unheld(found, mesh, joints), strict=True):
        if not weights.any():
            continue
        joined = [name for name, at in zip(names, mesh.body_nodes.tolist(), strict=True) if at == turns.node]
        axis = turns.axes @ weights
        about = "" if turns.all_axes else f" about ({', '.join(f'{x:.3g}' for x in axis + 0.0)})"
        faults.append(
            Fault(
                f"bodies.{joined[0]}.inertia",
                " and ".join(joined) + (" together" if len(joined) > 1 else ""),
                f"nothing gives turning{about} an inertia, and no support or joint holds it",
                "attach the body to a rod, hold its rotations by a support, or give it an inertia, such as that of a "
                "small ball, 2/5 m r^2",
            )
        )
    if faults:
        raise InputError(faults)


def _massless(node: int, mesh: Mesh, mass: Floats, supports: SupportSet) -> _Turns | None:
    """Return the turns of a node about its mass centre that have no inertia and that its support leaves free."""
    own, R = mass[node], matrices(mesh.quaternions[node][None])[0]
    free = np.eye(3)
    if node in supports.nodes:
        k = int(np.argmax(supports.nodes == node))
        free = supports.axes[k][:, supports.fixed[k, 3:] == 0.0]
    if not free.size:
        return None
    carried = -np.linalg.solve(own[:3, :3], own[:3, 3:])  # keeps the mass centre where it is
    inertia = own[3:, 3:] + own[3:, :3] @ carried
    turned = free.T @ R @ (inertia + inertia.T) @ R.T @ free / 2.0
    values, axes = np.linalg.eigh(turned)
    none = values <= _NONE * max(float(values[-1]), float(np.abs(own[3:, 3:]).max()))
    if not none.any():
        return None
    about = free @ axes[:, none]
    return _Turns(node, about, np.vstack([carried @ R.T @ about, R.T @ about]), bool(values[-1] <= 0.0))


def _unheld(found: list[_Turns], mesh: Mesh, joints: JointSet) -> list[Floats]:
    """Return the weights ``(k,)`` of one combination of the turns of every node that joints leave free; 0 for none."""
    columns = np.split(
        np.arange(sum(t.axes.shape[1] for t in found)), np.cumsum([t.axes.shape[1] for t in found])
    )
    held = np.flatnonzero(joints.arrays.place >= 0)
    gradients = joints.measure(mesh.positions, mesh.quaternions, np.zeros((len(mesh.positions), 6)))[2]
    moved = np.zeros((len(held), columns[-2][-1] + 1))
    for turns, mine in zip(found, columns, strict=False):
        moved[:, mine] = _moved(joints.arrays.nodes[held], gradients[held] / joints.unit[held, None], turns)
    ways = _null_space(moved)
    weights = []
    for mine in columns[: len(found)]:
        part = ways[mine]
        most = part[:, int(np.argmax(np.linalg.norm(part, axis=0)))] if part.size else np.zeros(len(mine))
        size = float(np.linalg.norm(most))
        weights.append(most / size if size > _UNHELD else np.zeros(len(mine)))
    return weights


def _moved(nodes: Integers, gradients: Floats, turns: _Turns) -> Floats:
    """Return what the turns of one node do to coordinates ``(c, k)``."""
    ends = [(nodes[:, side] == turns.node)[:, None] * gradients[:, 6 * side :][:, :6] for side in (0, 1)]
    found: Floats = (ends[0] + ends[1]) @ turns.increments
    return found


def _null_space(rows: Floats) -> Floats:
    """Return an orthonormal basis ``(n, k)`` of what ``rows`` ``(m, n)`` take to nothing."""
    _, sizes, ways = np.linalg.svd(rows)
    held = int(np.sum(sizes > _UNHELD))
    found: Floats = ways[held:].T
    return found

"""One rigid motion that nothing holds, in words: "rotation about x of the leg, with 2 more parts moving along"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.solve.constraints.parts import Parts
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["FreeMotion", "described"]

_NAMES = (
    "translation along x",
    "translation along y",
    "translation along z",
    "rotation about x",
    "rotation about y",
    "rotation about z",
)


@dataclass(frozen=True)
class FreeMotion:
    """One rigid motion of an assembly that nothing holds; ``increments (n, 6)`` are the nodal body increments."""

    text: str
    translation: bool
    increments: Floats

    @property
    def size(self) -> float:
        """Largest nodal displacement of the motion [m]; 1 for a rotation about the rod's own axis."""
        return float(np.abs(self.increments[:, :3]).max()) or 1.0


def described(parts: Parts, group: list[int], motion: Floats) -> FreeMotion:
    """Describe one motion of a group of parts and give its nodal increments."""
    problem, centres, labels = parts.problem, parts.centres, parts.labels
    moves = motion.reshape(-1, 6)
    every = np.zeros((1, parts.count, 6))
    every[0, group] = moves
    increments = parts.increments(every)[0]
    size = np.linalg.norm(moves, axis=1)
    moving = [k for k in np.argsort(-size, kind="stable") if size[k] > 1e-6 * size.max()]
    first = moving[0]
    text = f"{_describe(moves[first] / size[first], centres[group[first]], problem.length)}"
    text += _name(problem, np.flatnonzero(labels == group[first]))
    if len(moving) > 1:
        others = len(moving) - 1
        text += f", with {others} more part{'s' if others > 1 else ''} moving along"
    still = float(np.abs(moves[:, 3:]).max()) < 1e-6 * float(np.abs(moves).max())
    return FreeMotion(text, still, increments)


def _name(problem: Problem, nodes: Integers) -> str:
    if len(problem.rods) == 1 and not problem.bodies.names:
        return ""
    inside = np.isin(problem.stations.nodes, nodes)
    names = [problem.rods[i] for i in sorted(set(problem.stations.rod[inside].tolist()))]
    bodies = zip(problem.bodies.names, problem.bodies.nodes, strict=True)
    names += [name for name, node in bodies if node in nodes and "." not in name]
    return f" of {', '.join(names[:3])}{', ...' if len(names) > 3 else ''}"


def _describe(motion: Floats, centre: Floats, length: float) -> str:
    main = int(np.argmax(np.abs(motion)))
    if abs(abs(motion[main]) - 1.0) < 1e-6 and main < 3:
        return _NAMES[main]
    t, w = motion[:3], motion[3:] / length
    if np.linalg.norm(w) * length < 1e-6:
        return f"translation along ({', '.join(f'{x:.3g}' for x in t / np.linalg.norm(t))})"
    point = centre + np.cross(w, t) / (w @ w)
    through = ", ".join(f"{x:.4g}" for x in np.where(np.abs(point) < 1e-9 * length, 0.0, point))
    direction = w / np.linalg.norm(w)
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) > 1.0 - 1e-6:
        return f"{_NAMES[3 + axis]} through ({through})"
    return f"rotation about ({', '.join(f'{x:.3g}' for x in direction)}) through ({through})"

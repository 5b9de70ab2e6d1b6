"""Which small motions about a start have a part in a motion: equal steps are chosen by these.

A bar that falls on a joint moves by its length, and its bending vibrates by a ten thousandth of that. Steps that
follow the vibration for its own sake are a thousand times shorter than those that the fall needs.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.typing import Floats

__all__ = ["Participation", "participation", "periods_set_off"]

PART = 1e-3
"""Amplitude of a vibration, as a part of the motion, below which it does not matter how the steps follow it."""
LOOKS, MOST_LOOKS = 64, 1024
"""Instants at which loads are looked at, and most of those at which they have corners."""
TINY = 1e-9
"""Amplitude over the length of the model, or in rad, below which a vibration is none."""
FADED = 1e-3
"""Part of its amplitude at which a vibration is over."""
FARTHEST = 1.0
"""Motion of a part in lengths of the model, or in rad, from which on it is another one: forces, too, turn with it."""


class Participation(NamedTuple):
    """Angular frequencies of the vibrations that have a part in a motion ``(k,)``, and of its rigid motions [rad/s]."""

    vibrations: Floats
    rigid: float


def participation(
    problem: Problem, modes: StartModes, state: State, duration: float, held: float
) -> Participation:
    """Return which vibrations matter in a motion, and how fast its rigid motions change.

    A rigid motion that begins with the acceleration ``a`` and the velocity ``v`` (over the length, or in rad) changes
    at about ``sqrt(a)`` or ``v``, as a pendulum that is let go level does. A vibration is as large as its static
    response to the largest loads, and to what turns the nodes at the start, and as its initial velocity makes it.
    Without rigid motions all vibrations count.

    Args:
        modes: about the start; state: the start.
        duration: of the motion [s]; held: part of the loads just before t = 0 that the start is in balance with.
    """
    if not modes.rigid.shape[1]:
        return Participation(modes.omega, 0.0)
    length = problem.length
    forces = _unbalanced(problem, state, duration, held).reshape(-1, 6 * problem.size).T
    momenta = np.einsum("nij,nj->ni", problem.mass, state.twist).ravel()
    faster, begun = _begun(problem, modes, forces, momenta)
    moved = min(0.5 * faster * duration**2 + begun * duration, FARTHEST)
    response = np.abs(modes.shapes.T @ forces).max(axis=1) / modes.omega**2
    response += np.abs(modes.shapes.T @ momenta) / modes.omega
    amplitudes = _sizes(modes.shapes, length) * response
    return Participation(modes.omega[amplitudes > PART * moved], max(math.sqrt(faster), begun))


def periods_set_off(
    problem: Problem, modes: StartModes, state: State, duration: float, held: float
) -> tuple[float, float]:
    """Return frequency [Hz] and number of periods of the largest vibration that the start sets off, until it fades.

    It is the largest by what acts on the start and is not in balance; 0 periods if all is, or if the rigid motions are
    so large beside it that the steps need not follow it.

    Args:
        modes: about the start; state: the start.
        duration: of the motion [s]; held: part of the loads just before t = 0 that the start is in balance with.
    """
    if not len(modes.omega):
        return 0.0, 0.0
    forces = _unbalanced(problem, state, 0.0, held)[0].ravel()
    momenta = np.einsum("nij,nj->ni", problem.mass, state.twist).ravel()
    faster, begun = _begun(problem, modes, forces[:, None], momenta)
    moved = min(0.5 * faster * duration**2 + begun * duration, FARTHEST)
    amplitudes = _sizes(modes.shapes, problem.length) * np.abs(modes.shapes.T @ forces) / modes.omega**2
    largest = int(np.argmax(amplitudes))
    if not amplitudes[largest] > max(TINY, PART * moved):
        return 0.0, 0.0
    frequency, decay = float(modes.omega[largest]) / (2.0 * math.pi), float(modes.decay[largest])
    lasts = min(duration, math.log(1.0 / FADED) / decay) if decay > 0.0 else duration
    return frequency, frequency * lasts


def _begun(problem: Problem, modes: StartModes, forces: Floats, momenta: Floats) -> tuple[float, float]:
    """Return acceleration and velocity [1/s] of rigid motions over the length, or in rad, by forces ``(6 n, j)``."""
    if not modes.rigid.shape[1]:
        return 0.0, 0.0
    pushed = modes.rigid.T @ forces
    pushed = pushed[:, np.square(pushed).sum(axis=0).argmax()]
    given = modes.rigid @ (modes.rigid.T @ momenta)
    faster, begun = _sizes(np.column_stack([modes.rigid @ pushed, given]), problem.length).tolist()
    return faster, begun


def _unbalanced(problem: Problem, state: State, duration: float, held: float) -> Floats:
    """Return what accelerates the nodes of the start at some instants ``(j, n, 6)``, body axes."""
    loads, pose = ExternalLoads(problem), (state.r, state.q)
    times = np.linspace(0.0, duration, LOOKS + 1) if duration else np.zeros(1)
    corners = np.array([t for t in (*problem.breakpoints, *problem.rows) if 0.0 < t < duration])
    times = np.append(times, corners[:: max(1, len(corners) // MOST_LOOKS)])
    found = np.zeros((len(times), problem.size, 6))
    balanced = np.zeros((problem.size, 6))
    if held:
        loads.at(0.0, True, held).add(problem, pose, None, balanced)
    v, w = state.twist[:, :3], state.twist[:, 3:]
    p, s = np.split(np.einsum("nij,nj->ni", problem.mass, state.twist), 2, axis=1)
    for out, t in zip(found, times, strict=True):
        loads.at(float(t), False).add(problem, pose, state.twist, out)
    turning = np.hstack([np.cross(w, p), np.cross(w, s) + np.cross(v, p)])
    found -= balanced + turning
    return found


def _sizes(increments: Floats, length: float) -> Floats:
    """Return the largest of each of some increments ``(6 n, k)``: displacement over length, or rotation ``(k,)``."""
    squares = np.square(increments.reshape(-1, 2, 3, increments.shape[1])).sum(axis=2).max(axis=0)
    return np.asarray(np.sqrt(np.maximum(squares[0] / length**2, squares[1])))

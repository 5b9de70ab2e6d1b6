"""How motions go round the axis of a rotation: with the spin or against it, as seen on the model and from outside.

Across the axis a motion ``Re(x exp(s t))`` is ``P exp(i w t) + Q exp(-i w t)`` in the complex plane: P goes round with
the spin, Q against it, with the frequency w on the model and w + W, W - w in space (Genta, Dynamics of Rotating
Systems, 2005, 2.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.typing import Floats

__all__ = ["Rounds", "pure", "rounds"]

PURE = 0.99
"""Part of the energy from which on a motion is one of a kind."""


@dataclass(frozen=True)
class Rounds:
    """Parts of the kinetic energy of motions ``(m,)``.

    Attributes:
        forwards: of what goes round with exp(+i w t), by the right-hand rule about the axis; backwards: the other way
            round; along: of what is along the axis and about it.
    """

    forwards: Floats
    backwards: Floats
    along: Floats

    def waves(self) -> np.ndarray:
        """Return 1 or -1 of motions that only go round one way, 0 of those along the axis, 2 of others."""
        found = np.full(len(self.along), 2)
        found[self.along > PURE] = 0
        across = self.forwards + self.backwards
        found[self.forwards > PURE * np.maximum(across, 1e-300)] = 1
        found[self.backwards > PURE * np.maximum(across, 1e-300)] = -1
        found[self.along > PURE] = 0
        return found

    def whirl(self, roots: np.ndarray, speed: float) -> Floats:
        """Return the part of the motion across the axis that goes with the spin in space, less that against it.

        Args:
            roots: of the motions on the model [1/s]; speed: angular speed [rad/s].
        """
        if speed <= 0.0:
            return np.zeros(len(roots))
        across = np.maximum(self.forwards + self.backwards, 1e-300)
        with_spin = np.sign(roots.imag + speed) * self.forwards + np.sign(speed - roots.imag) * self.backwards
        return np.where(self.along > PURE, 0.0, with_spin / across)


def rounds(motions: np.ndarray, mass: Floats, frames: Floats, axis: Floats) -> Rounds:
    """Return how motions go round an axis.

    Args:
        motions: translations and rotations of nodes, global axes ``(n, 6, m)``.
        mass: of the nodes, body axes ``(n, 6, 6)``; frames: body to global ``(n, 3, 3)``; axis: unit vector.
    """
    energies = [
        np.einsum("nim,nij,njm->m", part.conj(), mass, part).real for part in _parts(motions, frames, axis)
    ]
    total = np.maximum(sum(energies), 1e-300)
    return Rounds(*(np.asarray(energy / total) for energy in energies))


def pure(motions: np.ndarray, mass: Floats, frames: Floats, axis: Floats) -> np.ndarray:
    """Return weights ``(m, m)`` of combinations of motions that go round one way as far as they can; see above."""
    forwards, backwards, along = (
        np.einsum("nim,nij,njk->mk", part.conj(), mass, part) for part in _parts(motions, frames, axis)
    )
    whole = forwards + backwards + along
    size = 1.0 / np.sqrt(np.maximum(np.diag(whole).real, 1e-300))
    scaled = np.outer(size, size)
    value, turn = np.linalg.eigh(whole * scaled)
    kept = turn / np.sqrt(np.maximum(value, 1e-12 * value[-1]))
    _, rest = np.linalg.eigh(kept.conj().T @ ((forwards - backwards) * scaled) @ kept)
    return np.asarray(size[:, None] * (kept @ rest))


def _parts(motions: np.ndarray, frames: Floats, axis: Floats) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what goes round with the right-hand rule, the other way, and along the axis, body axes ``(n, 6, m)``."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    both = motions.reshape(len(motions), 2, 3, -1)

    def part(way: np.ndarray, weight: float) -> np.ndarray:
        found = np.einsum("nbim,i->nbm", both, way.conj())[:, :, None, :] * (weight * way)[:, None]
        return np.asarray(np.einsum("nji,nbjm->nbim", frames, found).reshape(len(motions), 6, -1))

    # x exp(i w t) goes round where its components are (1, -i): the real part turns from the first to the second
    return part(first - 1j * second, 0.5), part(first + 1j * second, 0.5), part(axis + 0j, 1.0)

"""What a section carries where: points of a section with the shear stress of unit forces, and their quadrature.

A section force is (N1, N2, T) in shear and twist and (N3, M1, M2) in stretch and bending. Saint-Venant's flexure and
torsion give the shear stress (s31, s32) of unit forces about the centre line, the ``flow``: it balances the change of
the axial stress along the rod and leaves the outline free of traction. The axial stress needs no field of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from viscorod.model.materials.material import Material
from viscorod.typing import Floats, Integers

__all__ = ["SectionPatch", "SectionSamples", "StressField", "resultants"]


@dataclass(frozen=True)
class SectionSamples:
    """Points of a section.

    Attributes:
        points: about the centre line, along d1 and d2 ``(n, 2)`` [m].
        region: number of the material of each ``(n,)``.
        flow: shear stresses s31, s32 of unit forces along d1, d2 and a unit torque about d3 at the centre line
            ``(n, 2, 3)`` [1/m^2, 1/m^2, 1/m^3].
    """

    points: Floats
    region: Integers
    flow: Floats

    @property
    def axial(self) -> Floats:
        """The axial strain per stretch, bend 1 and bend 2 ``(n, 3)`` [1, m, m]: 1, y and -x (LLT 10)."""
        x, y = self.points.T
        return np.stack([np.ones_like(x), y, -x], axis=-1)

    def curved(self, curvature: Floats) -> Floats:
        """Return J0 = 1 + y U01 - x U02 ``(n,)`` of a reference curvature ``(2,)`` [1/m] (LLT 2.2)."""
        return np.asarray(1.0 + self.axial[:, 1:] @ curvature)


@dataclass(frozen=True)
class SectionPatch:
    """A section in triangles, for pictures and for largest values; regions do not share points.

    Attributes:
        samples: the corners; triangles: their numbers ``(m, 3)``.
    """

    samples: SectionSamples
    triangles: Integers


@dataclass(frozen=True)
class StressField:
    """How a section carries its forces.

    Attributes:
        materials: of the regions.
        rule: points of a quadrature; weight: their areas ``(q,)`` [m^2].
        patch: the section in triangles, its outline included.
        at: gives samples at points ``(n, 2)`` [m]; raises an InputError where one lies outside.
    """

    materials: tuple[Material, ...]
    rule: SectionSamples
    weight: Floats
    patch: SectionPatch
    at: Callable[[Floats], SectionSamples]


def resultants(points: Floats, weight: Floats, shear: Floats) -> Floats:
    """Return force along d1, along d2 and torque about the centre line ``(3, k)`` of shear stresses ``(n, 2, k)``."""
    x, y = points.T[..., None]
    parts = np.stack([shear[:, 0], shear[:, 1], x * shear[:, 1] - y * shear[:, 0]])
    return np.asarray(np.einsum("q,iqk->ik", weight, parts))

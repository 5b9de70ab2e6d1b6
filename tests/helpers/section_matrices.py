"""What tests of cross sections share: a material by its times, and matrices without units."""

from __future__ import annotations

import numpy as np

from viscorod.model.materials.material import KelvinVoigt, Material


def material(E, nu=0.0, shear=0.0, bulk=0.0, density=1.0):
    """A material of Young's modulus `E` with the retardation times `shear` and `bulk`."""
    damping = KelvinVoigt(shear_time=shear, bulk_time=bulk)
    return Material(youngs_modulus=E, poissons_ratio=nu, density=density, damping=damping)


def scaled(matrix, by=None):
    """`matrix` over sqrt(d_i d_j), with d the diagonal of `by` or its own."""
    size = np.sqrt(np.diag(matrix if by is None else by))
    return matrix / np.outer(size, size)

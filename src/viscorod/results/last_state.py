"""What is asked of one state: the last one of an equilibrium, the one of a steady rotation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.mechanics.rotations.quaternion import conjugate, product, rotation_vector
from viscorod.results.result import Result
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LastState"]


class LastState(Result):
    """A result of which one state is meant, the last one that is stored."""

    @checked
    def position(self, place: str | int) -> Floats:
        """Return the position of a place [m], shape (3,), global axes.

        Raises:
            InputError: no such place.
        """
        return self.sites.at(place).of(self.field("position", states=-1))

    @checked
    def displacement(self, place: str | int) -> Floats:
        """Return the displacement of a place from the reference shape [m], shape (3,), global axes.

        Raises:
            InputError: no such place.
        """
        return self.sites.at(place).of(self.field("displacement", states=-1))

    @checked
    def rotation(self, place: str | int) -> Floats:
        """Return the rotation of a place from its reference orientation.

        Returns:
            Rotation vector [rad], shape (3,), global axes, of length pi at most.

        Raises:
            InputError: no such place.
        """
        site = self.sites.at(place)
        return rotation_vector(
            product(site.rotation(self._final("rotation")), conjugate(site.rotation(self._reference)))
        )

    @property
    def elastic_energy(self) -> float:
        """Energy stored in the strains [J]."""
        return float(self._final("elastic"))

    @property
    def reactions(self) -> xr.DataArray:
        """Force [N] and moment [N m] of every support on its rod, ``(support, motion)``, global axes."""
        if "reaction" not in self.data:
            raise InputError("this result holds no reactions: the case has no supports")
        return self.data["reaction"].isel({self.dimension: -1})

    @property
    def _reference(self) -> Floats:
        return np.asarray(self.data["reference_rotation"].values, dtype=float)

    def _final(self, name: str) -> Floats:
        final: Floats = np.asarray(self.data[name].values, dtype=float)[-1]
        return final

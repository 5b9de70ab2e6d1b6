"""Base class of the laws of sections: section forces beside those of stiffness, damping and Maxwell branches."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from viscorod.model.fields.definition import Definition
from viscorod.typing import Floats

__all__ = ["AnySectionLaw"]


class AnySectionLaw(Definition):
    """A law of the section forces of a rod beside C eps + D eps_t and its Maxwell branches.

    Strains, their rates and forces are in the order (shear_1, shear_2, stretch, bend_1, bend_2, twist), relative to the
    strains at which the rod is free of stress. The stress and its tangents must vanish for vanishing strains and rates:
    what is linear there belongs into the section's matrices, by which meshes, steps and scales are chosen.
    """

    tag: ClassVar[str | None] = "kind"

    @abstractmethod
    def parameters(self, stiffness: Floats) -> Floats:
        """Return the numbers that :meth:`respond` gets, for a section with the stiffness C (6, 6)."""

    @staticmethod
    @abstractmethod
    def respond(
        parameters: Floats, strain: Floats, rate: Floats, force: Floats, by_strain: Floats, by_rate: Floats
    ) -> tuple[float, float]:
        """Evaluate the law at one point; Numba compiles this function, which may use numbers and arrays only.

        Args:
            parameters: from :meth:`parameters`.
            strain, rate: eps (-, 1/m) and eps_t, (6,) each.
            force: the section force s(eps, eps_t), N and N m, to be filled, (6,); it is zero on entry, as all outputs.
            by_strain, by_rate: its derivatives by strain and by rate, to be filled, (6, 6).

        Returns:
            the stored energy W(eps) per length, J/m, and the power that is dissipated per length,
            ``s . eps_t - dW/dt >= 0``, W/m.
        """

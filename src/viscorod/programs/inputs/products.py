"""Programs that multiply the section stiffness by six times: what they have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.programs.energy_creation import check_product
from viscorod.programs.inputs.program_inputs import ProgramInputs, SectionData, checked_options, listed
from viscorod.typing import Floats

__all__ = ["ProductInputs"]


@dataclass(frozen=True)
class ProductInputs(ProgramInputs):
    """Six times in the program's order.

    Attributes:
        mu: six times, s.
    """

    mu: tuple[float, ...]

    words: ClassVar[tuple[str, ...]] = ("mu1", "mu2", "mu3", "mu4", "mu5", "mu6")

    @staticmethod
    def reordered(times: Floats) -> Floats:
        """Six times in viscorod's order, in the program's."""
        return times

    @property
    def times(self) -> Floats:
        """The six mu in viscorod's order, s, (6,)."""
        return np.array(self.mu)

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """mu_i = D_ii/C_ii, in the program's order."""
        checked_options(cls, options)
        return cls(tuple(cls.reordered(data.times).tolist()))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """Six numbers."""
        del data
        checked_options(cls, options)
        return cls(listed(cls, numbers))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The six mu."""
        return self.mu

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Whether the product creates energy, and from which coupling on."""
        check = check_product(data.stiffness, self.times)
        return (check.text(),) if np.isfinite(check.factor) else ()

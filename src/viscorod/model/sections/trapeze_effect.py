"""Fibres of thin sections that become longer as these twist: the trapeze effect, also called Wagner's."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Positive
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.typing import Floats

__all__ = ["TrapezeEffect"]


class TrapezeEffect(AnySectionLaw):
    """The torsional stiffness that tension gives a section, and the tension that twist does.

    A fibre at the distance r from the line is stretched by r^2 tau^2/2 beside the stretch e, and resists with its
    modulus (H. Buckley, Philosophical Magazine 28 (1914) 778; H. Wagner 1929). Beside the energy of the section's
    stiffness it stores, for sections that are symmetric about d1 and d2,

        W = P e tau^2/2 + Q tau^4/8,    P = E <r^2> = EI_1 + EI_2,    Q = E <r^4> = fourth P^2/EA

    so that under a tension N the torsional stiffness is GJ + N P/EA, and the torque of a strip that is free to become
    shorter has the part (Q - P^2/EA) tau^3/2. It is elastic: what viscosity adds to it is left out. Twist is counted
    from that of the section without stress: a blade that is built twisted does not untwist by its tension through it.
    """

    kind: Literal["trapeze_effect"] = Field(default="trapeze_effect", kw_only=True, repr=False)
    fourth: Positive = Key(
        "<r^4> A/<r^2>^2 of the section: 9/5 of a thin strip, 4/3 of a round bar, 1 of a thin tube",
        default=1.8,
    )

    def parameters(self, stiffness: Floats) -> Floats:
        """Return P (N m^2) and Q (N m^4)."""
        second = float(stiffness[3, 3] + stiffness[4, 4])
        return np.array([second, self.fourth * second**2 / float(stiffness[2, 2])])

    @staticmethod
    def respond(
        parameters: Floats, strain: Floats, _rate: Floats, force: Floats, by_strain: Floats, _by_rate: Floats
    ) -> tuple[float, float]:
        """Evaluate force, torque, tangent and energy; see `AnySectionLaw.respond`."""
        second, fourth = parameters[0], parameters[1]
        stretch, twist = strain[2], strain[5]
        force[2] = 0.5 * second * twist**2
        force[5] = second * stretch * twist + 0.5 * fourth * twist**3
        by_strain[2, 5] = by_strain[5, 2] = second * twist
        by_strain[5, 5] = second * stretch + 1.5 * fourth * twist**2
        return 0.5 * second * stretch * twist**2 + 0.125 * fourth * twist**4, 0.0

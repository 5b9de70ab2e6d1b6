"""Doubts about the torsion of thin sections, whose fibres resist twist by their stretch, which no linear law knows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["thin_twist"]

THIN = 10.0
"""(EI1 + EI2)/GJ beyond which a section is thin; a circle has 2.6."""
OWN = 2.0 / 15.0
"""What (half width times twist)^2 counts beside the stretch: E/2 (<r^4> - <r^2>^2/A) of a strip."""
TOLD = 0.1
"""Part of GJ beyond which it is told."""
TWISTED = 1e-3
"""Part of the elastic energy at a point that twist has at least."""


def thin_twist(problem: Problem, points: GaussPositions, strain: Floats) -> Iterator[str]:
    """Yield which rods have a torsional stiffness that stretch and twist itself would change.

    Fibres at the distance r from the line are longer by (r twist)^2/2, and the tension N turns them against twist: a
    strip has N (I1 + I2)/A more than GJ (trapeze effect), and its own twist makes E twist^2/2 (<r^4> - <r^2>^2/A) of it
    (H. Buckley, Philosophical Magazine 28 (1914) 778; S. Timoshenko, Strength of materials II, on thin strips).

    Args:
        problem: of the result; points: where the strains are; strain: in one state ``(m, 6)``.
    """
    stiffness = np.einsum("mkk->mk", points.stiffness)
    energy = stiffness * strain**2
    torsion, bending = stiffness[:, 5], stiffness[:, 3] + stiffness[:, 4]
    twisted = (torsion > 0.0) & (bending > THIN * torsion) & (energy[:, 5] > TWISTED * energy.sum(axis=1))
    if not twisted.any():
        return
    wide = points.half_width * strain[:, 5]
    part = np.zeros(len(strain))
    np.divide(bending * np.abs(strain[:, 2] + OWN * wide**2), torsion, out=part, where=twisted)
    for number, name in enumerate(problem.rods):
        mine = np.flatnonzero(points.rod == number)
        worst = mine[np.argmax(part[mine])]
        if part[worst] > TOLD:
            yield (
                f"rod {name}: its section is thin, and where it is twisted its fibres, stretched by tension and twist, "
                f"change the torsional stiffness by about {100.0 * part[worst]:.2g} % of GJ at "
                f"{name}@{points.s[worst]:.4g}; the law of the section is linear and leaves this out"
            )

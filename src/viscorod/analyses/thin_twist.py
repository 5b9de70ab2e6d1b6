"""Doubts about the torsion of thin sections, whose fibres resist twist by their stretch, which no linear law knows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from viscorod.model.rod import Rod
from viscorod.model.sections.trapeze_effect import TrapezeEffect
from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["thin_twist", "thin_twist_of_modes"]

THIN = 10.0
"""(EI1 + EI2)/GJ beyond which a section is thin; a circle has 2.6."""
OWN = 2.0 / 15.0
"""What (half width times twist)^2 counts beside the stretch: E/2 (<r^4> - <r^2>^2/A) of a strip."""
TOLD = 0.1
"""Part of GJ beyond which it is told."""
TWISTED = 1e-3
"""Part of the elastic energy at a point that twist has at least."""
HOW = "and law = vr.TrapezeEffect() (of a rod; in a case file { kind = 'trapeze_effect' }) has it"
"""What to do."""


def thin_twist(
    problem: Problem, rods: Mapping[str, Rod], points: GaussPositions, strain: Floats
) -> Iterator[str]:
    """Yield which rods have a torsional stiffness that stretch and twist itself would change.

    Fibres at the distance r from the line are longer by (r twist)^2/2, and the tension N turns them against twist: a
    strip has N (I1 + I2)/A more than GJ (trapeze effect), and its own twist makes E twist^2/2 (<r^4> - <r^2>^2/A) of it
    (H. Buckley, Philosophical Magazine 28 (1914) 778; S. Timoshenko, Strength of materials II, on thin strips).

    Args:
        problem: of the result; rods: of the model; points: where the strains are; strain: in one state ``(m, 6)``.
    """
    energy = np.einsum("mkk->mk", points.stiffness) * strain**2
    twisted = energy[:, 5] > TWISTED * energy.sum(axis=1)
    wide = points.half_width * strain[:, 5]
    for place, part in _changed(problem, rods, points, twisted, strain[:, 2] + OWN * wide**2):
        yield (
            f"{place[0]}: its section is thin, and where it is twisted its fibres, stretched by tension and twist, "
            f"change the torsional stiffness by about {100.0 * part:.2g} % of GJ at {place[1]}; the linear law of the "
            f"section leaves this out, {HOW}"
        )


def thin_twist_of_modes(
    problem: Problem, rods: Mapping[str, Rod], points: GaussPositions, strain: Floats
) -> Iterator[str]:
    """Yield which rods would twist with another stiffness in modes that twist them, about a state that stretches them.

    Args:
        problem: of the result; rods: of the model; points: where the strains are; strain: in one state ``(m, 6)``.
    """
    for place, part in _changed(problem, rods, points, np.ones(len(strain), dtype=bool), strain[:, 2]):
        yield (
            f"{place[0]}: its section is thin, and the stretch of its fibres changes the torsional stiffness by about "
            f"{100.0 * part:.2g} % of GJ at {place[1]}, and frequencies of twist with it; the linear law of the "
            f"section leaves this out, {HOW}"
        )


def _changed(
    problem: Problem, rods: Mapping[str, Rod], points: GaussPositions, where: np.ndarray, fibres: Floats
) -> Iterator[tuple[tuple[str, str], float]]:
    """Yield rods of thin sections, the place, and the part of GJ by which fibres that are stretched change it."""
    stiffness = np.einsum("mkk->mk", points.stiffness)
    torsion, bending = stiffness[:, 5], stiffness[:, 3] + stiffness[:, 4]
    where = where & (torsion > 0.0) & (bending > THIN * torsion)
    part = np.zeros(len(fibres))
    np.divide(bending * np.abs(fibres), torsion, out=part, where=where)
    for number, name in enumerate(problem.rods):
        if isinstance(rods[name].law, TrapezeEffect):
            continue
        mine = np.flatnonzero(points.rod == number)
        worst = mine[np.argmax(part[mine])]
        if part[worst] > TOLD:
            yield (f"rod {name}", f"{name}@{points.s[worst]:.4g}"), float(part[worst])

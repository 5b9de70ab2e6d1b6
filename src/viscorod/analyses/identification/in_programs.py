"""The fitted damping in the numbers of other programs, with intervals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from scipy import stats

from viscorod.analyses.identification.case_numbers import case_with, number_at
from viscorod.analyses.identification.named_combinations import Combination, complex_modulus
from viscorod.casefile.case import Case
from viscorod.casefile.known_parts import KnownParts
from viscorod.errors import InputError
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.programs.inputs import PROGRAMS, SectionData
from viscorod.solve.estimation.intervals import Covariance
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["in_programs"]

STEP = 1e-4
"""Step of differences by the coordinates of unknowns."""
ROUND_OFF = 1e-9
"""Part of an input by which it must change with a logarithm for its change to be more than round-off."""
SEGMENTS = 20
"""Rigid segments into which a rod is divided for programs that have such."""


def in_programs(
    case: Case, unknowns: Unknowns, z: Floats, known: Covariance, frequencies: Sequence[float], level: float
) -> tuple[list[Combination], list[str]]:
    """Return the damping inputs of other programs for the first rod of a case, and sentences on what was done for them.

    Maxwell branches, which other programs do not have, are replaced by the one time that has the same loss factor
    at the frequency of the record.
    """
    mine = [k for k, one in enumerate(unknowns) if number_at(case, one.name) is not None]
    notes: list[str] = []
    parts = KnownParts()

    units: dict[str, str] = {}

    def numbers(at: Floats) -> dict[str, float]:
        values = unknowns.values(at)
        changed = case_with(case, {unknowns[k].name: float(values[k]) for k in mine}, parts)
        return _numbers(changed, frequencies, notes, units)

    centre = numbers(z)
    told_in = list(dict.fromkeys(notes))
    slopes = {name: np.zeros(len(z)) for name in centre}
    for k in mine:
        step = STEP * np.eye(len(z))[k]
        above, below = numbers(z + step), numbers(z - step)
        for name in centre:
            slopes[name][k] = (above[name] - below[name]) / (2.0 * STEP)
    out, unknown = [], []
    for name, value in centre.items():
        gradient = slopes[name]
        if np.linalg.norm(gradient) <= ROUND_OFF * abs(value):  # nothing sought acts on it
            out.append(Combination(name, units[name], value, value, value, tuple(np.zeros(len(z)).tolist())))
            continue
        if not known.told(gradient):
            unknown.append(name)
            continue
        reach = float(stats.t.ppf(0.5 + level / 2.0, known.freedom_of(gradient))) * known.deviation(gradient)
        low, high = value - reach, value + reach
        if value > 0.0:  # as the numbers that it follows from, by its logarithm: damping is none below zero
            low, high = value * np.exp(-reach / value), value * np.exp(reach / value)
        out.append(Combination(name, units[name], value, float(low), float(high), tuple(gradient.tolist())))
    if unknown:
        told_in.append(
            f"The data do not tell these inputs of other programs: {_by_program(unknown, centre)}."
        )
    return out, told_in


def _by_program(names: Sequence[str], everything: Mapping[str, float]) -> str:
    """Return inputs "program: input" by program, those of a program in brackets unless they are all that it has."""
    inputs: dict[str, list[str]] = {}
    for name in names:
        program, _, own = name.partition(": ")
        inputs.setdefault(program, []).append(own)
    whole = Counter(name.partition(": ")[0] for name in everything)
    return ", ".join(
        program if len(own) == whole[program] else f"{program} ({', '.join(own)})"
        for program, own in inputs.items()
    )


def _numbers(
    case: Case, frequencies: Sequence[float], notes: list[str], units: dict[str, str]
) -> dict[str, float]:
    """Return the inputs by program and word; what was done for them goes to the notes, their units to the units."""
    name, rod = next(iter(case.description.rods.items()))
    hertz = frequencies[0] if frequencies else None
    if isinstance(rod.material, Material) and rod.material.branches:
        if hertz is None:
            return {}
        modulus = complex_modulus(rod.material, hertz)
        tau = modulus.imag / modulus.real / (2.0 * np.pi * hertz)
        rod = rod.model_copy(
            update={
                "material": Material(
                    modulus.real,
                    rod.material.poissons_ratio,
                    rod.material.density,
                    damping=KelvinVoigt(tau, tau),
                )
            }
        )
        notes.append(
            f"Other programs have no Maxwell branches: their numbers have the loss factor of {name} at {hertz:.4g} Hz, "
            "and are wrong elsewhere."
        )
    try:
        data = SectionData.of(rod)
    except InputError:
        return {}
    if not np.any(data.damping):
        return {}
    found = {}
    options = {"segment_length": rod.length / SEGMENTS, "frequency": hertz}
    for program in PROGRAMS.values():
        given = {key: value for key, value in options.items() if key in program.options and value is not None}
        try:
            inputs = program.from_section(data, **given)
        except InputError:
            continue
        about = f" ({SEGMENTS} segments)" if "segment_length" in given else ""
        for word, unit, value in inputs.named_numbers:
            found[f"{program.title}{about}: {word}"] = float(value)
            units[f"{program.title}{about}: {word}"] = unit
    return found

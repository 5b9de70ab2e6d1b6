"""Fields and energies at the end of a step and between its stages, read from the stages."""

from __future__ import annotations

from typing import NamedTuple

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers


@kernel
def read_end(
    strain: Floats, rate: Floats, force: Floats, places: Integers, mass: Floats, twist: Floats, out: Floats
) -> tuple[float, float]:
    """Bring strains, strain rates and section forces of the last stage into the order of results.

    Args:
        strain, rate, force: at the stages ``(s, e, points, 6)``.
        places: where the points of the results are in ``(e, points)`` flattened.
        mass, twist: inertia and twists of the nodes ``(n, 6, 6)``, ``(n, 6)``.
        out: ``(3, m, 6)``.

    Returns:
        kinetic energy [J]; largest shear or stretch, infinite if any is undefined.
    """
    last, top = strain.shape[0] - 1, strain.shape[2]
    largest = 0.0
    for g in range(places.shape[0]):
        e, point = places[g] // top, places[g] % top
        for a in range(6):
            out[0, g, a] = strain[last, e, point, a]
            out[1, g, a] = rate[last, e, point, a]
            out[2, g, a] = force[last, e, point, a]
        for a in range(3):
            size = abs(strain[last, e, point, a])
            largest = max(largest, size if size <= 1e300 else 1e300)
    return kinetic_energy(mass, twist), largest


class StageFields(NamedTuple):
    """Fields at the stages of a step ``(s, ...)``.

    Attributes:
        strain, rate, force: at the Gauss points ``(s, e, points, 6)``; reactions: of the supports ``(s, m, 6)``.
        powers: of loads, viscosity, and what loads dissipate ``(3, s)`` [W].
    """

    strain: Floats
    rate: Floats
    force: Floats
    reactions: Floats
    powers: Floats


class ResultFields(NamedTuple):
    """Strains, their rates and section forces ``(3, ..., m, 6)`` in the order of results; reactions ``(..., m, 6)``."""

    points: Floats
    reactions: Floats


@kernel
def read_between(
    parts: Floats,
    h: float,
    method: Tableau,
    begin: ResultFields,
    stage_fields: StageFields,
    places: Integers,
    whole_loss: float,
    mass: Floats,
    twist: Floats,
    found: ResultFields,
    energies: Floats,
) -> None:
    """Interpolate between the stages of a step by their polynomials.

    Args:
        parts: places in the step ``(k,)``, 0 to 1, ascending; h: step [s].
        begin: at the start of the step; places: as in :func:`read_end`; whole_loss: viscous loss of the step [J].
        mass: ``(n, 6, 6)``; twist: of the nodes at the parts ``(k, n, 6)``.
        found: output at the parts, ``(3, k, m, 6)``, ``(k, m, 6)``.
        energies: output ``(3, k)`` [J]: kinetic; work and viscous loss since the start of the step.
    """
    values, integrals = method.values, method.integrals
    start, start_reaction = begin
    strain, rate, force, reactions, powers = stage_fields
    out, reaction = found
    top, stages = strain.shape[2], strain.shape[0]
    loss = 0.0
    for k in range(parts.shape[0]):
        work = lost = 0.0
        for g in range(places.shape[0]):
            for a in range(6):
                for field in range(3):
                    out[field, k, g, a] = start[field, g, a]
        for m in range(reaction.shape[1]):
            for a in range(6):
                reaction[k, m, a] = start_reaction[m, a]
        for i in range(stages):
            power, c, integral = parts[k], 0.0, 0.0
            for p in range(stages):
                c += values[i, p] * power
                integral += integrals[i, p] * power
                power *= parts[k]
            work += h * powers[0, i] * integral
            lost += h * powers[1, i] * integral
            for g in range(places.shape[0]):
                e, point = places[g] // top, places[g] % top
                for a in range(6):
                    out[0, k, g, a] += c * (strain[i, e, point, a] - start[0, g, a])
                    out[1, k, g, a] += c * (rate[i, e, point, a] - start[1, g, a])
                    out[2, k, g, a] += c * (force[i, e, point, a] - start[2, g, a])
            for m in range(reaction.shape[1]):
                for a in range(6):
                    reaction[k, m, a] += c * (reactions[i, m, a] - start_reaction[m, a])
        loss = max(loss, min(lost, whole_loss))  # interpolation must not give energy back
        energies[0, k], energies[1, k], energies[2, k] = kinetic_energy(mass, twist[k]), work, loss

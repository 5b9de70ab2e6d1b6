"""Rest strains that change with time, deducted from the strains of moving elements.

The strain of the material is what the shape has less the rest strain, ``e = eps - eps_r(t)``, and springs and dashpots
of a section see it both: ``S = C e + D e_t``. With ``S . eps_t = S . e_t + S . eps_r'`` the balance of energy is
``d/dt (T + W) = P - int e_t.D e_t - int S . eps_r'``: what changes the rest strain does the work of the last term.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.internal_force import Elements, GaussStates
from viscorod.mechanics.elements.section_laws import add_law_force
from viscorod.typing import Floats


@part
def shift(sign: float, rest: Floats, strain: Floats) -> None:
    """Add ``sign`` times ``rest`` to ``strain``, both ``(s, e, points, 6)``."""
    for s in range(rest.shape[0]):
        for e in range(rest.shape[1]):
            for g in range(rest.shape[2]):
                for i in range(6):
                    strain[s, e, g, i] += sign * rest[s, e, g, i]


@part
def section_forces(elements: Elements, strain: Floats, strain_rate: Floats, S: Floats) -> None:
    """Write ``C eps + D eps_t`` (or ``D b``) and the forces of laws at all Gauss points ``(s, e, points, 6)``."""
    laws = elements.laws
    orders, section, C, D, damped = elements[0], elements[9], elements[10], elements[11], elements[12]
    for s in range(S.shape[0]):
        for e in range(orders.shape[0]):
            for g in range(orders[e]):
                of = section[e, g]
                for i in range(6):
                    total = 0.0
                    for j in range(6):
                        total += C[of, i, j] * strain[s, e, g, j]
                    if damped:
                        for j in range(6):
                            total += D[of, i, j] * strain_rate[s, e, g, j]
                    S[s, e, g, i] = total
                if laws.present:
                    add_law_force(laws, of, strain[s, e, g], strain_rate[s, e, g], S[s, e, g])


@kernel
def deduct_rest(elements: Elements, rest: Floats, rate: Floats, points: GaussStates) -> None:
    """Deduct rest strains and their rates ``(s, e, points, 6)`` at all Gauss points, and write the section forces."""
    shift(-1.0, rest, points.strain)
    shift(-1.0, rate, points.strain_rate)
    section_forces(elements, points.strain, points.strain_rate, points.section_force)


@part
def actuator_powers(elements: Elements, rate: Floats, stress: Floats, powers: Floats) -> None:
    """Write the power ``-int S . eps_r'`` [W] of what changes the rest strains, at all stages ``(s,)``."""
    orders, weights, half_lengths = elements.order, elements.weights, elements.half_lengths
    for s in range(rate.shape[0]):
        power = 0.0
        for e in range(orders.shape[0]):
            for g in range(orders[e]):
                weight = weights[orders[e], g] * half_lengths[e]
                for i in range(6):
                    power -= weight * stress[s, e, g, i] * rate[s, e, g, i]
        powers[s] = power

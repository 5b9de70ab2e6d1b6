"""Maxwell branches from step to step of a collocation method: what a step begins with, what its end leaves, records.

See ``maxwell_branches`` for the equations. Steps that are taken one by one and the compiled loop of steps call the same
kernels, so that their numbers are the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays
from viscorod.typing import Floats, Integers

__all__ = ["BranchMemory", "BranchRows", "begin_branches", "keep_branches", "read_branches", "read_within"]


class BranchMemory(NamedTuple):
    """What branches remember.

    Attributes:
        dashpot, strain: strains of the dashpots ``(n, e, points, 6)``, and of the sections ``(e, points, 6)``, at the
            last accepted instant.
        earlier: strains of the springs at the start of the last step, like ``dashpot``.
        loss: energy that each branch dissipated in the last step ``(n,)`` [J].
        length: of the step that the factors of the branches are for ``(1,)`` [s]; scratch: ``(s, 2 s)``.
    """

    dashpot: Floats
    strain: Floats
    earlier: Floats
    loss: Floats
    length: Floats
    scratch: Floats

    @classmethod
    def of(cls, dashpot: Floats, strain: Floats, stages: int) -> BranchMemory:
        """Allocate beside strains that others remember."""
        n, s = len(dashpot), stages
        return cls(dashpot, strain, np.zeros_like(dashpot), np.zeros(n), np.zeros(1), np.zeros((s, 2 * s)))

    @classmethod
    def none(cls) -> BranchMemory:
        """Return that of a model without branches."""
        return cls.of(np.zeros((0, 0, 0, 6)), np.zeros((0, 0, 6)), 0)


class BranchRows(NamedTuple):
    """Branches in ``k`` states at the ``m`` Gauss points in the order of results.

    Attributes:
        strain: of the springs ``(k, m, n, 6)``; power: that all branches lose per length ``(k, m)`` [W/m].
        loss: energy that each branch dissipated since the start of the step ``(k, n)`` [J].
    """

    strain: Floats
    power: Floats
    loss: Floats

    @classmethod
    def of(cls, count: int, points: int, branches: int) -> BranchRows:
        """Allocate."""
        k, m, n = count, points, branches
        return cls(np.empty((k, m, n, 6)), np.empty((k, m)), np.empty((k, n)))


@part
def write_factor(j: int, ratio: float, A: Floats, system: Floats, factor: Floats) -> None:
    """Write ``F_j = (1 + ratio A)^-1`` by Gauss and Jordan's elimination; ``system (s, 2 s)`` is scratch."""
    s = A.shape[0]
    for i in range(s):
        for k in range(s):
            system[i, k] = ratio * A[i, k]
            system[i, s + k] = 0.0
        system[i, i] += 1.0
        system[i, s + i] = 1.0
    for c in range(s):
        pivot = c
        for i in range(c + 1, s):
            if abs(system[i, c]) > abs(system[pivot, c]):
                pivot = i
        scale = 1.0 / system[pivot, c]
        for k in range(2 * s):
            value = system[pivot, k] * scale
            system[pivot, k] = system[c, k]
            system[c, k] = value
        for i in range(s):
            weight = system[i, c]
            if i != c:
                for k in range(2 * s):
                    system[i, k] -= weight * system[c, k]
    for i in range(s):
        for k in range(s):
            factor[j, i, k] = system[i, s + k]


@part
def couple(branches: Floats, factor: Floats, coupling: Floats) -> None:
    """Write ``E_ik = sum_j (F_j)_ik C_j`` of all sections."""
    for of in range(coupling.shape[0]):
        for i in range(coupling.shape[1]):
            for k in range(coupling.shape[2]):
                for a in range(6):
                    for b in range(6):
                        total = 0.0
                        for j in range(factor.shape[0]):
                            total += factor[j, i, k] * branches[of, j, a, b]
                        coupling[of, i, k, a, b] = total


@part
def write_past(orders: Integers, section: Integers, arrays: MaxwellArrays) -> None:
    """Write what the past subtracts from the section forces, ``P_i = sum_j C_j sum_k (F_j)_ik alpha_j0``."""
    branches, factor, start, past = arrays.branches, arrays.factor, arrays.start, arrays.past
    stages = past.shape[0]
    for e in range(orders.shape[0]):
        for g in range(orders[e]):
            of = section[e, g]
            for i in range(stages):
                for a in range(6):
                    past[i, e, g, a] = 0.0
            for j in range(start.shape[0]):
                for a in range(6):
                    force = 0.0
                    for b in range(6):
                        force += branches[of, j, a, b] * start[j, e, g, b]
                    for i in range(stages):
                        for k in range(stages):
                            past[i, e, g, a] += factor[j, i, k] * force


@kernel
def begin_branches(
    h: float,
    A: Floats,
    orders: Integers,
    section: Integers,
    arrays: MaxwellArrays,
    memory: BranchMemory,
) -> None:
    """Write what a step of ``h`` [s] from the last accepted instant needs, of a method with the matrix ``A``."""
    times, start, start_strain = arrays.times, arrays.start, arrays.start_strain
    if memory.length[0] != h:
        for j in range(times.shape[0]):
            write_factor(j, h / times[j], A, memory.scratch, arrays.factor)
        couple(arrays.branches, arrays.factor, arrays.coupling)
        memory.length[0] = h
    for e in range(start_strain.shape[0]):
        for g in range(start_strain.shape[1]):
            for a in range(6):
                start_strain[e, g, a] = memory.strain[e, g, a]
                for j in range(start.shape[0]):
                    start[j, e, g, a] = memory.dashpot[j, e, g, a]
    write_past(orders, section, arrays)


@kernel
def keep_branches(weights: Floats, strain: Floats, arrays: MaxwellArrays, memory: BranchMemory) -> None:
    """Take the end of the step, where the last stage has led.

    With one stage the dashpots are extrapolated from it, and the strains at the end are known later.

    Args:
        weights: of the method's quadrature; strain: of the sections at the stages ``(s, e, points, 6)``.
    """
    last, spring, power, h = strain.shape[0] - 1, arrays.spring, arrays.power, memory.length[0]
    dashpot, sections = memory.dashpot, memory.strain
    for e in range(sections.shape[0]):
        for g in range(sections.shape[1]):
            for a in range(6):
                for j in range(dashpot.shape[0]):
                    memory.earlier[j, e, g, a] = sections[e, g, a] - dashpot[j, e, g, a]
                    found = strain[last, e, g, a] - spring[last, j, e, g, a]
                    dashpot[j, e, g, a] = found if last > 0 else 2.0 * found - arrays.start[j, e, g, a]
                if last > 0:
                    sections[e, g, a] = strain[last, e, g, a]
    for j in range(power.shape[1]):
        total = 0.0
        for i in range(last + 1):
            total += weights[i] * power[i, j]
        memory.loss[j] = h * total


@part
def write_power(
    row: int, arrays: MaxwellArrays, section: Integers, places: Integers, rows: BranchRows
) -> None:
    """Write the power that springs lose at the strains in a row, ``sum_j beta_j.C_j beta_j/tau_j``."""
    top, times, branches, strain = section.shape[1], arrays.times, arrays.branches, rows.strain
    for g in range(places.shape[0]):
        of, total = section[places[g] // top, places[g] % top], 0.0
        for j in range(times.shape[0]):
            product = 0.0
            for a in range(6):
                for b in range(6):
                    product += branches[of, j, a, b] * strain[row, g, j, a] * strain[row, g, j, b]
            total += product / times[j]
        rows.power[row, g] = total


@kernel
def read_branches(
    row: int,
    arrays: MaxwellArrays,
    memory: BranchMemory,
    section: Integers,
    places: Integers,
    rows: BranchRows,
) -> None:
    """Write the branches at the last accepted instant into a row; ``places``: of the points, see ``Reading``."""
    top, dashpot, strain = section.shape[1], memory.dashpot, memory.strain
    for j in range(dashpot.shape[0]):
        rows.loss[row, j] = memory.loss[j]
        for g in range(places.shape[0]):
            e, point = places[g] // top, places[g] % top
            for a in range(6):
                rows.strain[row, g, j, a] = strain[e, point, a] - dashpot[j, e, point, a]
    write_power(row, arrays, section, places, rows)


@kernel
def read_within(
    parts: Floats,
    row: int,
    values: Floats,
    integrals: Floats,
    arrays: MaxwellArrays,
    memory: BranchMemory,
    section: Integers,
    places: Integers,
    rows: BranchRows,
) -> None:
    """Write the branches at places of the last step into rows, from ``row`` on.

    Strains of springs follow the polynomials through their start and the stages, losses the quadrature of the stages.

    Args:
        parts: places in the step ``(k,)``, 0 to 1; values, integrals: coefficients of the method, see ``Tableau``.
    """
    top, spring, earlier, power, h = (
        section.shape[1],
        arrays.spring,
        memory.earlier,
        arrays.power,
        memory.length[0],
    )
    for k in range(parts.shape[0]):
        at, place = row + k, parts[k]
        for j in range(earlier.shape[0]):
            rows.loss[at, j] = 0.0
            for g in range(places.shape[0]):
                e, point = places[g] // top, places[g] % top
                for a in range(6):
                    rows.strain[at, g, j, a] = earlier[j, e, point, a]
        for i in range(spring.shape[0]):
            step, c, integral = place, 0.0, 0.0
            for p in range(spring.shape[0]):
                c += values[i, p] * step
                integral += integrals[i, p] * step
                step *= place
            for j in range(earlier.shape[0]):
                rows.loss[at, j] += h * integral * power[i, j]
                for g in range(places.shape[0]):
                    e, point = places[g] // top, places[g] % top
                    for a in range(6):
                        gained = spring[i, j, e, point, a] - earlier[j, e, point, a]
                        rows.strain[at, g, j, a] += c * gained
        write_power(at, arrays, section, places, rows)

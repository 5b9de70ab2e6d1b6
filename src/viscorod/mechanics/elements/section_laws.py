"""Laws of a section beside its matrices: section forces that are evaluated point by point, behind an address.

The section forces of a Gauss point are

    S = C eps + D eps_t + sum_j C_j beta_j + s(eps, eps_t)

with the matrices C and D of the section, its Maxwell branches (see ``maxwell_branches``), and ``s``, the law. C, D and
C_j are used as they are; the law is compiled by itself and called through its address (see ``callback``), so that no
other kernel is compiled again for a new one. Its stress beside the elastic part takes the power ``s.eps_t - W'``.

One evaluation gives the forces, their derivatives by strains and by strain rates, the stored energy per length and the
dissipated power per length; they are exchanged in the array ``values``, of which a law sees slices.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numba
import numpy as np

from viscorod.mechanics.compilation.callback import Callback, call
from viscorod.mechanics.compilation.compiled import PURE_PYTHON, kernel, lane_kernel, part
from viscorod.mechanics.elements.lanes import AT_FORCE, AT_RATE, AT_STRAIN
from viscorod.typing import Floats, Integers

LawFunction: TypeAlias = Callable[[Floats, Floats, Floats, Floats, Floats, Floats], tuple[float, float]]
"""``law(parameters, strain, rate, force, by_strain, by_rate) -> (energy, power)``, which fills arrays of zeros."""

STRAIN, RATE, FORCE, BY_STRAIN, BY_RATE, ENERGY, POWER, PARAMETERS = 0, 6, 12, 18, 54, 90, 91, 92
"""First entries of ``values``; the two derivatives are row by row."""

_NUMBA: Any = numba


class SectionLaws(NamedTuple):
    """Laws of the sections that have any.

    Attributes:
        present: any section has one.
        address: of the compiled law ``(sections,)``, 0: none; parameters: ``(sections, most)``.
        free: 0 where a multiplier holds the strain and gives its force ``(sections, 6)``.
        values: scratch of one evaluation.
    """

    present: bool
    address: Integers
    parameters: Floats
    free: Floats
    values: Floats

    @classmethod
    def of(cls, laws: list[tuple[int, Floats]], held: Floats) -> SectionLaws:
        """Collect address and parameters of every section, whose held strains are marked ``(sections, 6)``."""
        most = max((len(numbers) for _, numbers in laws), default=0)
        parameters = np.zeros((len(laws), most))
        for row, (_, numbers) in zip(parameters, laws, strict=True):
            row[: len(numbers)] = numbers
        address = np.array([where for where, _ in laws], dtype=np.int64)
        return cls(bool(address.any()), address, parameters, 1.0 - held, np.zeros(PARAMETERS + most))

    @classmethod
    def none(cls, sections: int) -> SectionLaws:
        """Return those of sections without a law."""
        return cls.of([(0, np.zeros(0))] * sections, np.zeros((sections, 6)))

    @classmethod
    def joined(cls, parts: list[SectionLaws]) -> SectionLaws:
        """Return the laws of all sections of several sets; those of one are the same."""
        if len(parts) == 1:
            return parts[0]
        laws = [(int(a), p) for own in parts for a, p in zip(own.address, own.parameters, strict=True)]
        return cls.of(laws, 1.0 - np.concatenate([own.free for own in parts]))


@functools.cache
def _compiled(function: LawFunction) -> Any:
    """Return an object that lives as long as the address of a law; compiled once."""
    inside: Any = function if PURE_PYTHON else _NUMBA.njit(error_model="numpy")(function)

    def evaluate(values: Floats) -> None:
        for i in range(FORCE, PARAMETERS):
            values[i] = 0.0
        values[ENERGY], values[POWER] = inside(
            values[PARAMETERS:],
            values[STRAIN:RATE],
            values[RATE:FORCE],
            values[FORCE:BY_STRAIN],
            values[BY_STRAIN:BY_RATE].reshape(6, 6),
            values[BY_RATE:ENERGY].reshape(6, 6),
        )

    if PURE_PYTHON:
        return Callback(evaluate)
    compiled: Any = _NUMBA.njit(error_model="numpy")(evaluate)

    def entry(pointer: Any, count: int) -> None:
        compiled(_NUMBA.carray(pointer, (count,)))

    kinds = _NUMBA.types
    return _NUMBA.cfunc(kinds.void(kinds.CPointer(kinds.float64), kinds.int64))(entry)


def law_address(function: LawFunction) -> int:
    """Return the address of a law for :class:`SectionLaws`."""
    return int(_compiled(function).address)


@part
def respond(laws: SectionLaws, of: int, strain: Floats, rate: Floats) -> bool:
    """Evaluate the law of the section ``of`` into ``laws.values``; return False if it has none.

    Args:
        strain, rate: of one Gauss point ``(6,)``.
    """
    if laws.address[of] == 0:
        return False
    values = laws.values
    for i in range(6):
        values[STRAIN + i], values[RATE + i] = strain[i], rate[i]
    for k in range(laws.parameters.shape[1]):
        values[PARAMETERS + k] = laws.parameters[of, k]
    call(laws.address[of], values.ctypes, values.shape[0])
    for i in range(6):
        values[FORCE + i] *= laws.free[of, i]
        for j in range(6):
            free = laws.free[of, i] * laws.free[of, j]
            values[BY_STRAIN + 6 * i + j] *= free
            values[BY_RATE + 6 * i + j] *= free
    return True


@part
def add_law_force(laws: SectionLaws, of: int, strain: Floats, rate: Floats, S: Floats) -> None:
    """Add the law of the section ``of`` to the section force ``(6,)`` of one Gauss point."""
    if respond(laws, of, strain, rate):
        for i in range(6):
            S[i] += laws.values[FORCE + i]


@part
def add_law_tangents(laws: SectionLaws, of: int, strain: Floats, rate: Floats, C: Floats, D: Floats) -> None:
    """Add the derivatives of the law by strains and by their rates to ``C`` and ``D`` ``(6, 6)`` of one Gauss point."""
    if respond(laws, of, strain, rate):
        for i in range(6):
            for j in range(6):
                C[i, j] += laws.values[BY_STRAIN + 6 * i + j]
                D[i, j] += laws.values[BY_RATE + 6 * i + j]


@part
def stored_and_lost(laws: SectionLaws, of: int, strain: Floats, rate: Floats) -> tuple[float, float]:
    """Return the energy [J/m] that the law stores and the power [W/m] that it dissipates at one Gauss point."""
    if respond(laws, of, strain, rate):
        return laws.values[ENERGY], laws.values[POWER]
    return 0.0, 0.0


@part
def add_lacking_work(
    laws: SectionLaws,
    orders: Integers,
    section: Integers,
    points: tuple[Floats, Floats],
    start: Floats,
    end: Floats,
    h: float,
    lacking: Floats,
) -> None:
    """Add the energy defect of the laws in a step of the midpoint rule: energy stored and lost less work done.

    Args:
        points: strains and their rates in the middle ``(1, e, points, 6)``; start, end: strains at the ends, likewise.
        h: step [s]; lacking: of every Gauss point ``(e, points)`` [J/m].
    """
    strain, rate = points
    for e in range(orders.shape[0]):
        for g in range(orders[e]):
            of = section[e, g]
            if laws.address[of] == 0:
                continue
            before, _ = stored_and_lost(laws, of, start[0, e, g], rate[0, e, g])
            after, _ = stored_and_lost(laws, of, end[0, e, g], rate[0, e, g])
            _, lost = stored_and_lost(laws, of, strain[0, e, g], rate[0, e, g])
            work = 0.0
            for i in range(6):
                work += laws.values[FORCE + i] * rate[0, e, g, i]
            lacking[e, g] += after - before + h * (lost - work)


@lane_kernel
def add_lane_laws(
    count: int,
    element: Integers,
    place: Integers,
    section: Integers,
    laws: SectionLaws,
    point: Floats,
    C: Floats,
    D: Floats,
    strain: Floats,
    rate: Floats,
) -> None:
    """Add the laws to the section forces of all lanes, and their derivatives to ``C`` and ``D`` (see ``lanes``).

    ``strain`` and ``rate`` are scratch ``(6,)``.
    """
    for lane in range(count):
        for i in range(6):
            strain[i], rate[i] = point[0, AT_STRAIN + i, lane], point[0, AT_RATE + i, lane]
        if respond(laws, section[element[lane], place[lane]], strain, rate):
            for i in range(6):
                point[0, AT_FORCE + i, lane] += laws.values[FORCE + i]
                for j in range(6):
                    C[i, j, lane] += laws.values[BY_STRAIN + 6 * i + j]
                    D[i, j, lane] += laws.values[BY_RATE + 6 * i + j]


@kernel
def law_values(laws: SectionLaws, section: Integers, strain: Floats, rate: Floats, out: Floats) -> None:
    """Write what the laws of some Gauss points give, as in ``values``, into ``out (m, PARAMETERS)``; zero without one.

    Args:
        section: of every point ``(m,)``; strain, rate: ``(m, 6)``.
    """
    for g in range(section.shape[0]):
        found = respond(laws, section[g], strain[g], rate[g])
        for i in range(PARAMETERS):
            out[g, i] = laws.values[i] if found else 0.0

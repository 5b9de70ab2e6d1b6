"""Sections given by their stiffness, inertia and damping per length, with couplings and off-centre mass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import NOT_NEGATIVE, blocks, listed, of_kind, quantity
from viscorod.model.fields.metadata import TABLES, Accepts, Key, accepts
from viscorod.model.fields.symmetry import skew_entry
from viscorod.model.fields.values import Positive, amount, each, items, numbers, sequence
from viscorod.model.materials.material import Material
from viscorod.model.sections.named_numbers import (
    INERTIA_FORM,
    INERTIA_NAMES,
    STIFFNESS_FORM,
    STIFFNESS_NAMES,
    TIMES_FORM,
    diagonal_by_name,
    inertia_by_name,
)
from viscorod.model.sections.section_base import AnySection, Branches, Matrices
from viscorod.typing import Floats

__all__ = ["STRAINS", "TWISTS", "Matrix", "MaxwellBranch", "StiffnessSection", "strain_times"]

Matrix: TypeAlias = tuple[tuple[float, ...], ...]
Given: TypeAlias = Sequence[float] | Sequence[Sequence[float]] | Floats | Mapping[str, float]

STRAINS = ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")
"""The six strain components, in the order used everywhere."""
TWISTS = ("v1", "v2", "v3", "w1", "w2", "w3")
"""Velocity and angular velocity along d1, d2, d3."""

PLAIN_WORDS = {
    "shear_1": "shear along d1",
    "shear_2": "shear along d2",
    "stretch": "extension",
    "bend_1": "bending about d1",
    "bend_2": "bending about d2",
    "twist": "twist",
}
"""The strains for a sentence."""

_MATRIX = "6 numbers (a diagonal), 6 rows of 6 or a table of GA1, GA2, EA, EI1, EI2, GJ"
_INERTIA = "6 numbers (a diagonal), 6 rows of 6 or a table of mass, J1, J2, J3"

ROUND_OFF = 1e-12
"""Relative size below which an eigenvalue of a matrix scaled to a unit diagonal cannot be distinguished from zero."""


def symmetric(value: Any, words: tuple[str, ...], *, all_needed: bool = False) -> Matrix:
    """Return `value`, six numbers (a diagonal), six rows of six or named numbers, as a symmetric matrix."""
    if isinstance(value, Mapping):
        named = inertia_by_name(value) if words is TWISTS else diagonal_by_name(value, all_needed=all_needed)
        return tuple(map(tuple, np.diag(named).tolist()))
    rows = sequence(value)
    if len(rows) != 6:
        raise RefusedError(
            f"a 6x6 matrix or its diagonal is needed here, {len(rows)} items were given",
            f"give six numbers or six rows of six, in the order {', '.join(words)}",
        )
    if not any(isinstance(row, list | tuple | np.ndarray) for row in rows):
        return tuple(map(tuple, np.diag(each(numbers(rows, count=6), amount)).tolist()))
    full = each(rows, lambda row: each(numbers(row, count=6), amount))
    matrix = np.array(full)
    if (skew := skew_entry(matrix)) is not None:
        i, j = skew
        raise RefusedError(
            "the matrix must be symmetric",
            f"give the same number twice for {words[i]} and {words[j]}, in row {i + 1}, column {j + 1} "
            f"and in row {j + 1}, column {i + 1}",
            found=f"{show(full[i][j])} against {show(full[j][i])}",
        )
    return tuple(map(tuple, (matrix / 2.0 + matrix.T / 2.0).tolist()))


def refuse_indefinite(
    matrix: Matrix, words: tuple[str, ...], *, zero_allowed: bool, meaning: str, otherwise: str = ""
) -> None:
    """Refuse a matrix with a negative (or, unless allowed, zero) eigenvalue, and name its direction.

    Decided on the matrix scaled to a unit diagonal, S A S with S = diag(A_ii^(-1/2)): a congruence keeps
    the signs of the eigenvalues (Sylvester) and makes forces and moments, whatever their units, comparable.

    Args:
        matrix: symmetric.
        words: names of its rows.
        zero_allowed: whether a semi-definite matrix is accepted.
        meaning: the requirement on the matrix, as the beginning of a sentence.
        otherwise: the effect of the motions of the eigenvector, such as "would create energy".
    """
    array = np.array(matrix)
    diagonal = np.diag(array)
    used = np.flatnonzero(np.abs(array).sum(axis=1) > 0.0)
    if not zero_allowed:
        used = np.arange(6)
    for index in used:
        if diagonal[index] <= 0.0:
            number = f"{diagonal[index]:.6g}"
            alone = (
                f"{_plain([words[index]])} {otherwise}"
                if otherwise and diagonal[index] < 0.0
                else f"for {words[index]} alone it is {number}"
            )
            raise RefusedError(
                f"{meaning}; {alone}",
                f"give a diagonal entry > 0 for {words[index]}"
                + (" or a row and column of zeros" if zero_allowed else ""),
                found=f"the diagonal entry {number} for {words[index]}",
            )
    if not used.size:
        return
    scale = np.sqrt(diagonal[used])
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = array[np.ix_(used, used)] / scale[:, None] / scale[None, :]
    if not np.isfinite(scaled).all():
        raise RefusedError(
            meaning, "give couplings no larger than the diagonal allows", found="entries out of range"
        )
    values, vectors = np.linalg.eigh(scaled)
    if values[0] < (-ROUND_OFF if zero_allowed else ROUND_OFF):
        direction, names = vectors[:, 0] / np.abs(vectors[:, 0]).max(), [words[i] for i in used]
        text = _in_words(direction, names)
        large = [name for x, name in zip(direction, names, strict=True) if abs(x) > 0.05]
        together = f"{_plain(large)} {otherwise}: " if otherwise else "it is not for "
        raise RefusedError(
            f"{meaning}; {together}the combined motion {text}",
            "make the couplings smaller or the diagonal larger",
            found=f"an eigenvalue of {values[0]:.3g} (of the matrix scaled to a unit diagonal)",
        )


def _in_words(direction: Floats, words: Sequence[str]) -> str:
    parts = [
        f"{'-' if x < 0 else '+'} {abs(x):.2g} {word}"
        for x, word in zip(direction, words, strict=True)
        if abs(x) > 1e-3
    ]
    return " ".join(parts).removeprefix("+ ")


def _plain(words: Sequence[str]) -> str:
    """Return the motions as the subject of a sentence: "extension and twist together"."""
    names = [PLAIN_WORDS.get(word, word) for word in words]
    if len(names) == 1:
        return f"{names[0]} alone"
    return f"{', '.join(names[:-1])} and {names[-1]} together"


@accepts(blocks(STIFFNESS_FORM), _MATRIX)
def _stiffness(value: Any) -> Matrix:
    matrix = symmetric(value, STRAINS, all_needed=True)
    if not np.array(matrix)[3:].any():  # a cable
        refuse_indefinite(_with_moments(matrix), STRAINS, zero_allowed=False, meaning=_COSTS)
    else:
        refuse_indefinite(matrix, STRAINS, zero_allowed=False, meaning=_COSTS)
    return matrix


_COSTS = "every strain must cost energy, unless bending and twist cost none at all (three zeros: a cable)"


def _with_moments(matrix: Matrix) -> Matrix:
    """Return the matrix with moments of 1 for bending and twist."""
    return tuple(map(tuple, (np.array(matrix) + np.diag([0, 0, 0, 1, 1, 1])).tolist()))


@accepts(blocks(INERTIA_FORM), _INERTIA)
def _inertia(value: Any) -> Matrix | None:
    if value is None:
        return None
    matrix = symmetric(value, TWISTS)
    refuse_indefinite(matrix, TWISTS, zero_allowed=False, meaning="every motion must have kinetic energy")
    return matrix


@accepts(blocks(STIFFNESS_FORM), _MATRIX)
def _damping(value: Any) -> Matrix | None:
    if value is None:
        return None
    matrix = symmetric(value, STRAINS)
    refuse_indefinite(
        matrix,
        STRAINS,
        zero_allowed=True,
        meaning="damping must never create energy",
        otherwise="would create energy",
    )
    return matrix


@accepts(
    {"anyOf": [listed(quantity(bounds=NOT_NEGATIVE), 6, 6), TIMES_FORM]},
    "6 numbers >= 0, or a table of GA1, GA2, EA, EI1, EI2, GJ",
)
def strain_times(value: Any) -> tuple[float, ...] | None:
    """Check six numbers >= 0."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        value = diagonal_by_name(value, all_needed=False)
    times = each(numbers(value, count=6), amount)
    for index, time in enumerate(times):
        if time < 0.0:
            raise RefusedError(
                f"a retardation time cannot be negative ({STRAINS[index]})",
                "give a number >= 0",
                found=show(time),
                at=(index,),
            )
    return times


@accepts(blocks(STIFFNESS_FORM), _MATRIX)
def _branch_stiffness(value: Any) -> Matrix:
    matrix = symmetric(value, STRAINS)
    refuse_indefinite(matrix, STRAINS, zero_allowed=True, meaning="a branch must never give energy away")
    return matrix


def _stand_in(stiffness: Floats) -> Floats:
    """Return an inertia for statics, which do not depend on it: 1 kg/m, the radius of gyration of the stiffness."""
    bending = float(np.diag(stiffness)[3:5].mean())
    turning = bending / float(stiffness[2, 2]) if bending > 0.0 else 0.0
    return np.diag([1.0, 1.0, 1.0, turning, turning, 2.0 * turning])


class MaxwellBranch(Definition):
    """A Maxwell branch of a section: a spring and a dashpot in series, beside the stiffness.

    It adds `stiffness` to strains much faster than `time`, and nothing to much slower ones.
    """

    time: Positive = Key("relaxation time", "s")
    stiffness: Annotated[Given, _branch_stiffness] = Key(
        "symmetric, positive semi-definite; {}, {}, {}", "N", "N m", "N m^2"
    )


class StiffnessSection(AnySection):
    """A section given by symmetric 6x6 matrices per length, or by their six diagonal numbers.

    Such a section takes no material. Strains are in the order (shear_1, shear_2, stretch, bend_1, bend_2,
    twist), velocities in the order (v1, v2, v3, w1, w2, w3), all along d1, d2, d3.

    A diagonal may be given by names, in any order: GA1 and GA2 against shear along d1 and d2, EA, EI1 and EI2 against
    bending about d1 and d2, GJ; of the inertia the mass per length, J1, J2 and J3 = J1 + J2 about d1, d2 and d3.
    Without inertia there are equilibria, paths and critical loads, and nothing that moves.

    Six retardation times tau give the damping D = T C T with T = diag(sqrt(tau)): symmetric, positive
    semi-definite whatever the couplings of C are, and D_ii/C_ii = tau_i. (The products diag(tau) C and
    C diag(tau) are not symmetric where C couples strains of different times, and can create energy.)
    """

    hints: ClassVar[dict[str, str]] = dict.fromkeys(
        STIFFNESS_NAMES, "give the stiffnesses as one table: stiffness = { EA = ..., EI1 = ..., ... }"
    ) | dict.fromkeys(
        INERTIA_NAMES, "give the inertia as one table: inertia = { mass = ..., J1 = ..., J2 = ... }"
    )
    no_material: ClassVar[str | None] = "a section given by its stiffness takes no material"
    shape: Literal["stiffness"] = Field(default="stiffness", kw_only=True, repr=False)
    stiffness: Annotated[Given, _stiffness] = Key("C, positive definite; {}, {}, {}", "N", "N m", "N m^2")
    inertia: Annotated[Given | None, _inertia] = Key(
        "M, positive definite; {}, {}, {}; may be left out where nothing moves",
        "kg/m",
        "kg",
        "kg m",
        default=None,
    )
    damping: Annotated[Given | None, _damping] = Key(
        "D of S = C eps + D eps_t, positive semi-definite; {}, {}, {}",
        "N s",
        "N m s",
        "N m^2 s",
        default=None,
    )
    branches: Annotated[
        Sequence[MaxwellBranch],
        BeforeValidator(items),
        Accepts(listed(of_kind("sections.branch")), TABLES),
    ] = Key("Maxwell branches, each with its relaxation `time` and its `stiffness`", default=())
    times: Annotated[Sequence[float] | None, strain_times] = Key(
        "retardation times of the six strains instead of `damping`; {}", "s", default=None
    )

    @model_validator(mode="after")
    def _one_damping(self) -> Self:
        if self.damping is not None and self.times is not None:
            raise RefusedError(
                "the damping is given twice, by the matrix damping and by times",
                "give damping (6x6) or times (six numbers), not both",
                found=show(self.times),
                at=("times",),
            )
        return self

    def matrices(self, material: Material | None = None) -> Matrices:
        """Return stiffness C, damping D and inertia M per length, (6, 6) each, in the orders of the class.

        Raises:
            InputError: there is a material.
        """
        self.refuse_material(material)
        stiffness = np.array(self.stiffness)
        if self.times is not None:
            root = np.sqrt(np.array(self.times))
            damping = stiffness * np.outer(root, root)
        else:
            damping = np.zeros((6, 6)) if self.damping is None else np.array(self.damping)
        return stiffness, damping, _stand_in(stiffness) if self.inertia is None else np.array(self.inertia)

    @property
    def has_inertia(self) -> bool:
        """Whether its inertia is known."""
        return self.inertia is not None

    def branch_matrices(self, material: Material | None = None) -> Branches:
        """Return Maxwell branches: relaxation times (n,), s, and their stiffnesses (n, 6, 6)."""
        del material
        times = np.array([branch.time for branch in self.branches])
        return times, np.array([branch.stiffness for branch in self.branches]).reshape(-1, 6, 6)

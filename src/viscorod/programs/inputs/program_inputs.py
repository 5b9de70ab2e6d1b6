"""The inputs of a program: its numbers, its damping law, a text to paste, and what is lost."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.argument_names import KnownArguments, known_arguments
from viscorod.errors import Fault, InputError
from viscorod.model.materials.material import Material
from viscorod.model.rod import Rod
from viscorod.model.sections.isotropic_section import MaterialSection
from viscorod.model.sections.stiffness_section import STRAINS
from viscorod.programs.energy_creation import creates_energy, least_power
from viscorod.programs.matrices import by_sizes, symmetric_part
from viscorod.programs.own_laws import refuse_own_laws
from viscorod.programs.times import MaterialFit, component_times, fit_material, symmetric_damping
from viscorod.typing import Floats

__all__ = [
    "ProgramInputs",
    "Recovered",
    "SectionData",
    "listed",
    "matrix_of",
    "number_text",
]

UNITS = {"segment_length": "m", "frequency": "Hz"}
"""Units of the options of programs."""


@known_arguments
@dataclass(frozen=True, eq=False)
class SectionData:
    """One section of a rod, for translation.

    Attributes:
        stiffness: C (6, 6); N, N m, N m^2; strains in viscorod's order.
        damping: D (6, 6), the units of the stiffness times s.
        inertia: M per length (6, 6); kg/m, kg, kg m.
        material: for a section given by its shape.
        section: the section given by its shape, if it is.
    """

    stiffness: Floats
    damping: Floats
    inertia: Floats
    material: Material | None = None
    section: MaterialSection | None = None

    @classmethod
    def of(cls, rod: Rod, s: float = 0.0) -> Self:
        """Return the section of a rod at the arc length `s`, m.

        Raises:
            InputError: the section has Maxwell branches, which the Kelvin-Voigt laws of other programs do not have.
        """
        refuse_own_laws(rod, [s])
        section = rod.section_at(s)
        shaped = section if isinstance(section, MaterialSection) else None
        return cls(*rod.matrices_at(s), material=rod.material if shaped else None, section=shaped)

    @property
    def times(self) -> Floats:
        """Six times D_ii/C_ii (6,), s."""
        return component_times(self.stiffness, self.damping)


@known_arguments
@dataclass(frozen=True, eq=False)
class Recovered:
    """A program's inputs as viscorod's damping.

    Attributes:
        damping: D (6, 6), symmetric and positive semi-definite, for a `StiffnessSection`.
        times: six times of the program's law, s, (6,).
        material: the two times of an isotropic material closest to them; None without Poisson's ratio.
        difference: largest difference of D from the program's law, in parts of the law's largest entry, both
            scaled by sqrt(C_ii C_jj); 0 where the law is symmetric.
        warnings: sentences for the user.
    """

    damping: Floats
    times: Floats
    material: MaterialFit | None
    difference: float
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class ProgramInputs(KnownArguments, ABC):
    """The inputs of one program that describe a beam's damping.

    A subclass states in class attributes what the program is, and in four methods how a section becomes its numbers,
    what else it keeps besides them, its law, and the text to paste.
    """

    program: ClassVar[str]
    """Word for the command line."""
    title: ClassVar[str]
    """Name of the program."""
    sources: ClassVar[tuple[str, ...]]
    """Where its meaning was read: repository and file, or package and version."""
    meaning: ClassVar[str]
    """Its damping law in a sentence."""
    words: ClassVar[tuple[str, ...]]
    """What its numbers are, in their order."""
    units: ClassVar[tuple[str, ...]] = ()
    """Of these numbers."""
    options: ClassVar[tuple[str, ...]] = ()
    """Further keywords of `from_section` and `from_numbers`."""
    missing: ClassVar[tuple[int, ...]] = ()
    """Places of strains that the program does not have: it holds them."""
    always_lost: ClassVar[tuple[str, ...]] = ()
    """Sentences on what is lost, whatever the section."""
    notes: ClassVar[tuple[str, ...]] = ()
    """Sentences on what the user must know, whatever the section."""

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """Return the inputs for a section.

        Raises:
            InputError: an option of the program is missing, wrong or of another program, or the program cannot have
                such a section.
        """
        chosen = _checked_options(cls, options)
        return cls._of(cls._numbers(data, chosen), data, chosen)

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """Return the inputs from the program's numbers (see `words`), with what it takes from the section.

        Raises:
            InputError: as for `from_section`, or the numbers are too few, too many, negative or not finite.
        """
        chosen = _checked_options(cls, options)
        return cls._of(cls._checked(numbers), data, chosen)

    @classmethod
    @abstractmethod
    def _numbers(cls, data: SectionData, options: Sequence[float], /) -> Sequence[float]:
        """Translate a section into the program's numbers."""

    @classmethod
    def _checked(cls, numbers: Sequence[float]) -> Sequence[float]:
        """Refuse numbers that the program cannot have."""
        return listed(cls, numbers)

    @classmethod
    def _of(cls, numbers: Sequence[float], _data: SectionData, options: Sequence[float], /) -> Self:
        """Make the inputs of the program's numbers, the options, and what else is taken from the section."""
        return cls(*numbers, *options)

    @property
    def numbers(self) -> tuple[float, ...]:
        """The program's numbers, in the order of `words`: the first field, or one field each."""
        first, *others = astuple(self)
        return first if isinstance(first, tuple) else (first, *others)[: len(self.words)]

    @property
    def named_numbers(self) -> tuple[tuple[str, str, float], ...]:
        """The program's numbers with their words and units."""
        units = self.units or ("",) * len(self.words)
        return tuple(zip(self.words, units, self.numbers, strict=True))

    @abstractmethod
    def law(self, stiffness: Floats) -> Floats:
        """Return the matrix P (6, 6) of the program's viscous section force P eps_t, in viscorod's order.

        It need not be symmetric. Strains the program does not have are rows and columns of zeros.
        """

    @abstractmethod
    def text(self) -> str:
        """Return the inputs as the user pastes them."""

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Return what is lost when the section's damping becomes these inputs, in sentences with numbers."""
        law = self.law(data.stiffness)
        out: list[str] = []
        given, taken = data.times, component_times(data.stiffness, law)
        if self.missing:
            out.append(f"{self.title} has no {', '.join(STRAINS[k] for k in self.missing)}: these are rigid")
        for place, (word, before, after) in enumerate(zip(STRAINS, given, taken, strict=True)):
            if place in self.missing:
                continue
            if before > 0.0 and after == 0.0:
                out.append(f"{word} is not damped")
            elif abs(after - before) > 1e-9 * max(abs(before), abs(after)):
                change = f", {after / before - 1.0:+.1%}" if before > 0.0 else ""
                out.append(f"{word} has the time {after:.6g} s instead of {before:.6g} s{change}")
        coupling = _coupling_difference(law, data)
        if coupling > 1e-9:
            out.append(
                f"the viscous couplings differ by {coupling:.3g} of sqrt(D_ii D_jj) from the symmetric law of "
                "viscorod"
            )
        return (*out, *self.always_lost)

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Return what the user must know before running the program with these inputs."""
        law = self.law(data.stiffness)
        if creates_energy(law, data.stiffness):
            power = least_power(law, data.stiffness)
            return (f"this law creates energy in some motions (least scaled power {power:.3g})", *self.notes)
        return self.notes

    def recovered(self, data: SectionData, poissons_ratio: float | None = None) -> Recovered:
        """Return the inputs as viscorod's damping of a section with this stiffness.

        A law that is symmetric and never creates energy is taken as it is. For any other the symmetric
        D = T C T with the same six times is taken, and the difference is reported.
        """
        law = self.law(data.stiffness)
        times = component_times(data.stiffness, law)
        scaled = by_sizes(law, np.diag(data.stiffness))
        largest = float(np.abs(scaled).max())
        skew = float(np.abs(scaled - scaled.T).max())
        warnings: list[str] = []
        if skew <= 1e-9 * largest and not creates_energy(law, data.stiffness):
            damping, difference = symmetric_part(law), 0.0
        else:
            damping = symmetric_damping(data.stiffness, times)
            taken = by_sizes(damping, np.diag(data.stiffness))
            difference = float(np.abs(taken - scaled).max()) / largest
            warnings.append(
                f"the program's law is not symmetric; D = T C T with its six times is taken, which differs by "
                f"{difference:.3g} of the law's largest entry"
            )
        nu = poissons_ratio
        if nu is None and data.material is not None:
            nu = data.material.poissons_ratio
        fit = None if nu is None else fit_material(times, nu, left_out=self.missing)
        if fit is not None and fit.largest_deviation > 1e-9:
            warnings.append(
                "no two times of an isotropic material give these six; the closest two, "
                f"shear {fit.shear_time:.6g} s and bulk {fit.bulk_time:.6g} s, deviate by up to "
                f"{fit.largest_deviation:.3g}"
            )
        return Recovered(damping, times, fit, difference, (*self.warnings(data), *warnings))


def _coupling_difference(law: Floats, data: SectionData) -> float:
    """Return the largest off-diagonal difference between a law and D, scaled by sqrt(D_ii D_jj)."""
    diagonal = np.diag(data.damping)
    difference = by_sizes(law - data.damping, np.where(diagonal > 0.0, diagonal, np.inf))
    np.fill_diagonal(difference, 0.0)
    return float(np.abs(difference).max())


def listed(program: type[ProgramInputs], numbers: Sequence[float]) -> tuple[float, ...]:
    """Return finite, non-negative numbers of a program, one for each of its words.

    Raises:
        InputError: there are more or fewer, or one is negative or not finite.
    """
    values = tuple(float(value) for value in numbers)
    if len(values) != len(program.words):
        raise InputError(
            Fault(
                program.program,
                f"{len(values)} numbers",
                f"{program.title} has {len(program.words)} here",
                f"give {', '.join(program.words)}",
            )
        )
    for word, value in zip(program.words, values, strict=True):
        if not (math.isfinite(value) and value >= 0.0):
            where = f"{program.program}.{word}"
            raise InputError(Fault(where, f"{value:g}", "outside what is allowed", "give a number >= 0"))
    return values


def matrix_of(program: type[ProgramInputs], numbers: Sequence[float]) -> Floats:
    """Return a 6x6 matrix from 6 numbers (a diagonal), 21 (the upper triangle, row by row) or 36 (row by row).

    Raises:
        InputError: there is another count, or a number is not finite.
    """
    values = np.array([float(value) for value in numbers])
    if values.size not in (6, 21, 36) or not np.isfinite(values).all():
        raise InputError(
            Fault(
                program.program,
                f"{values.size} numbers",
                f"{program.title} has a 6x6 matrix here",
                "give 6 numbers (its diagonal), 21 (its upper triangle, row by row) or 36, in the program's order",
            )
        )
    if values.size == 6:
        return np.diag(values)
    if values.size == 36:
        return values.reshape(6, 6)
    matrix = np.zeros((6, 6))
    matrix[np.triu_indices(6)] = values
    return np.asarray(matrix + np.triu(matrix, 1).T)


def _checked_options(program: type[ProgramInputs], options: Mapping[str, float]) -> tuple[float, ...]:
    """Return the options of a program in their order, all of them required and positive.

    Raises:
        InputError: one is missing or not positive, or the program does not take it.
    """
    for name in options:
        if name not in program.options:
            raise InputError(
                Fault(name, f"{options[name]:g}", f"{program.title} has no use for it", "leave it out")
            )
    for name in program.options:
        if name not in options:
            raise InputError(Fault(name, "", "this program needs it", f"give {name} ({UNITS[name]})"))
        if not (math.isfinite(options[name]) and options[name] > 0.0):
            raise InputError(
                Fault(
                    name,
                    f"{options[name]:g}",
                    "outside what is allowed",
                    f"give a number > 0 ({UNITS[name]})",
                )
            )
    return tuple(options[name] for name in program.options)


def number_text(value: float) -> str:
    """Return a number as text to paste: ten digits, always with a point or an exponent, for Fortran and C++."""
    text = f"{value:.10g}"
    return text if any(mark in text for mark in ".en") else f"{text}.0"

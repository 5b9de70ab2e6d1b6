"""The common result of all descriptions of damping: moduli at rest, Kelvin-Voigt times, Maxwell branches."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import NamedTuple

from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.materials.relaxation_modulus import RelaxationModulus

__all__ = [
    "Behaviour",
    "Branch",
    "Damping",
    "Elastic",
    "bulk_time_of",
    "maxwell_behaviour",
    "maxwell_branches",
]


class Branch(NamedTuple):
    """A Maxwell branch of an isotropic material: spring and dashpot in series, beside the equilibrium moduli.

    Attributes:
        time: relaxation time, s.
        youngs_modulus: its contribution to Young's modulus in fast extension, Pa.
        shear_modulus: its contribution to the shear modulus in fast shear, Pa.
    """

    time: float
    youngs_modulus: float
    shear_modulus: float

    def __repr__(self) -> str:
        """Return the numbers with six digits, so that several branches can be read beside each other."""
        told = ", ".join(f"{name}={value:.6g}" for name, value in self._asdict().items())
        return f"Branch({told})"


class Elastic(NamedTuple):
    """The elastic constants that were given with a material; NaN for those that were not.

    Attributes:
        youngs_modulus: E, Pa.
        poissons_ratio: nu.
    """

    youngs_modulus: float
    poissons_ratio: float

    @property
    def shear_modulus(self) -> float:
        """G = E/2(1+nu), Pa."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))

    @property
    def bulk_modulus(self) -> float:
        """K = E/3(1-2nu), Pa; infinite for nu = 0.5."""
        compressibility = 1.0 - 2.0 * self.poissons_ratio
        return self.youngs_modulus / (3.0 * compressibility) if compressibility != 0.0 else math.inf


@dataclass(frozen=True)
class Behaviour:
    """The behaviour of a material, which a :class:`Damping` derives from the given elastic constants.

    Attributes:
        youngs_modulus, poissons_ratio: E (Pa) and nu in equilibrium, after a long time.
        shear_time, bulk_time: Kelvin-Voigt times of slow motion, s.
        bulk_viscosity: where it does not follow from the bulk time, Pa s.
        branches: Maxwell branches, by time; with them the times above are only those of slow motion.
        extension, shear: the relaxation moduli, where more is known than the times.
        assumptions: what was assumed, one sentence each.
        doubts: how it differs from what was measured, by so much that every result tells it, one sentence each.
        pending: whether the times are only known once a model has been built.
    """

    youngs_modulus: float
    poissons_ratio: float
    shear_time: float = 0.0
    bulk_time: float = 0.0
    bulk_viscosity: float | None = None
    branches: tuple[Branch, ...] = ()
    extension: RelaxationModulus | None = None
    shear: RelaxationModulus | None = None
    assumptions: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    pending: bool = False

    def shifted(self, factor: float) -> Behaviour:
        """Return the same behaviour at another temperature: all times and viscosities times a positive factor."""
        return replace(
            self,
            shear_time=self.shear_time * factor,
            bulk_time=self.bulk_time * factor,
            bulk_viscosity=None if self.bulk_viscosity is None else self.bulk_viscosity * factor,
            branches=tuple(branch._replace(time=branch.time * factor) for branch in self.branches),
            extension=None if self.extension is None else self.extension.shifted(factor),
            shear=None if self.shear is None else self.shear.shifted(factor),
        )

    def assuming(self, *sentences: str) -> Behaviour:
        """Return the same behaviour with more assumptions."""
        return replace(self, assumptions=self.assumptions + sentences)


class Damping(Definition):
    """Base class of the descriptions of a material's damping."""

    @abstractmethod
    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return the behaviour of a material with these elastic constants.

        Raises:
            InputError: the two do not go together.
        """

    def behaviour_at(self, elastic: Elastic, shift: float) -> Behaviour:
        """Return the behaviour at a temperature where relaxation takes ``shift`` times as long as in the data."""
        return self.behaviour(elastic).shifted(shift)


def bulk_time_of(
    extensional: float, shear: float, nu: float, keys: tuple[str, ...], unit: str = " s"
) -> float:
    """Return the bulk time that goes with times in extension and shear, s (LLT 4 solved for tau_B).

    Loss factors at one frequency go together like times.

    Args:
        extensional: retardation time in extension, s.
        shear: retardation time in shear, s.
        nu: Poisson's ratio.
        keys: key of the extensional time, for the message.
        unit: of the numbers, for the message.

    Raises:
        InputError: the bulk time would be negative, or nu = 0.5 and the two times differ.
    """
    part = 2.0 * (1.0 + nu) / 3.0
    if nu == 0.5:
        if abs(extensional - shear) > 1e-9 * max(extensional, shear):
            raise RefusedError(
                "an incompressible material (nu = 0.5) has the same time in extension and shear, and "
                f"that of shear is {shear:.6g}{unit}",
                f"give {shear:.6g}{unit} for both, or a Poisson's ratio below 0.5",
                found=f"{extensional:.6g}{unit} in extension",
                at=keys,
            )
        return shear
    bulk = (3.0 * extensional - 2.0 * (1.0 + nu) * shear) / (1.0 - 2.0 * nu)
    if bulk < -1e-9 * max(extensional, shear) / (1.0 - 2.0 * nu):
        raise RefusedError(
            f"with {shear:.6g}{unit} in shear and nu = {nu:.6g} it means a negative bulk viscosity",
            f"give at least {part * shear:.6g}{unit} in extension, 2(1+nu)/3 of the time in shear, "
            f"or at most {extensional / part:.6g}{unit} in shear",
            found=f"{extensional:.6g}{unit} in extension",
            at=keys,
        )
    return max(bulk, 0.0)


def maxwell_branches(extension: RelaxationModulus, shear: RelaxationModulus) -> tuple[Branch, ...]:
    """Merge branches of extension and shear: the times of both, each with its contribution to E and to G."""
    young = dict(zip(extension.times, extension.moduli, strict=True))
    shearing = dict(zip(shear.times, shear.moduli, strict=True))
    return tuple(
        Branch(time, young.get(time, 0.0), shearing.get(time, 0.0)) for time in sorted(young | shearing)
    )


def maxwell_behaviour(
    rest: Elastic, extension: RelaxationModulus, shear: RelaxationModulus, assumptions: tuple[str, ...]
) -> Behaviour:
    """Return the behaviour of a material whose moduli of extension and shear relax, each by itself.

    Args:
        rest: the elastic constants at rest.
        extension, shear: the relaxation moduli.
        assumptions: what was assumed.
    """
    young, nu = rest
    times = extension.retardation_time, shear.retardation_time
    bulk_time = times[1]
    if nu != 0.5 and not math.isclose(*times, rel_tol=1e-12):
        bulk_time = max((3.0 * times[0] - 2.0 * (1.0 + nu) * times[1]) / (1.0 - 2.0 * nu), 0.0)
    return Behaviour(
        young,
        nu,
        times[1],
        bulk_time,
        branches=maxwell_branches(extension, shear),
        extension=extension,
        shear=shear,
        assumptions=assumptions,
    )

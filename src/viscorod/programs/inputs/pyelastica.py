"""PyElastica: it does not damp strains; the mass-proportional constant that agrees at one frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.errors import Fault, InputError
from viscorod.programs.inputs.program_inputs import (
    ProgramInputs,
    Recovered,
    SectionData,
    number_text,
)
from viscorod.typing import Floats

__all__ = ["PyElastica"]


@known_arguments
@dataclass(frozen=True)
class PyElastica(ProgramInputs):
    """The uniform damping constant of AnalyticalLinearDamper that agrees at one frequency.

    Attributes:
        constant: 1/s; velocities and angular velocities decay as exp(-constant t).
        frequency: undamped frequency of the mode whose damping ratio agrees, Hz.
    """

    constant: float
    frequency: float

    program = "pyelastica"
    title = "PyElastica"
    meaning = "velocities decay as exp(-constant t), whatever the strains do: damping by the mass"
    words = ("uniform_damping_constant",)
    units = ("1/s",)
    options = ("frequency",)
    sources = (
        "GazzolaLab/PyElastica: elastica/dissipation.py, AnalyticalLinearDamper (package pyelastica 1.0.0)",
    )
    notes = (
        "the older keyword damping_constant reduces angular velocities by exp(-constant m/J t), which depends on "
        "the unit of length: use uniform_damping_constant",
    )

    @classmethod
    def _numbers(cls, data: SectionData, options: Sequence[float], /) -> Sequence[float]:
        """Return tau omega^2 with the time of bending, so that the ratio constant/(2 omega) is tau omega/2."""
        (frequency,) = options
        return [float(data.times[3:5].mean()) * (2.0 * math.pi * frequency) ** 2]

    @property
    def time(self) -> float:
        """The retardation time (s) with the same damping ratio at the frequency."""
        return self.constant / (2.0 * math.pi * self.frequency) ** 2

    def ratio(self, frequency: float) -> float:
        """Return the damping ratio in PyElastica of a mode with this undamped frequency (Hz), constant/(2 omega)."""
        return self.constant / (4.0 * math.pi * frequency)

    def law(self, stiffness: Floats) -> Floats:
        """Return zeros: no force depends on strain rates."""
        del stiffness
        return np.zeros((6, 6))

    def text(self) -> str:
        """Return a Python call."""
        return (
            "simulator.dampen(rod).using(\n"
            "    elastica.AnalyticalLinearDamper,\n"
            f"    uniform_damping_constant={number_text(self.constant)},  # 1/s\n"
            "    time_step=time_step,\n)"
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Return what is lost: everything but one number."""
        del data
        ratio = self.ratio(self.frequency)
        return (
            "there is no equivalent: PyElastica damps velocities, not strain rates, so it also slows rigid "
            "motions, and its ratio falls with the frequency, whereas a material's rises",
            f"the constant agrees at {self.frequency:.6g} Hz (ratio {ratio:.6g}); a mode at ten times that "
            f"frequency has the ratio {ratio / 10.0:.3g} instead of {ratio * 10.0:.3g}",
            "the ratio of bending is used; stretch, shear and twist get the same constant",
        )

    def recovered(self, data: SectionData, poissons_ratio: float | None = None) -> Recovered:
        """Refuse: a mass-proportional constant is not a law of a section.

        Raises:
            InputError: always.
        """
        del data, poissons_ratio
        raise InputError(
            Fault(
                self.program,
                number_text(self.constant),
                "a mass-proportional constant does not damp strains",
                f"a bending mode at {self.frequency:g} Hz has the same ratio with the extensional time "
                f"{self.time:.6g} s; "
                "give that to the material",
            )
        )

"""MuJoCo: the joint damping of a cable made of rigid segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.programs.inputs.program_inputs import (
    ProgramInputs,
    SectionData,
    checked_options,
    listed,
    number_text,
)
from viscorod.typing import Floats

__all__ = ["MuJoCo"]


@dataclass(frozen=True)
class MuJoCo(ProgramInputs):
    """The damping of the ball joints between the segments of a cable.

    Attributes:
        joint_damping: one number for all three axes of the joint, N m s/rad.
        segment_length: of the rigid segments, m.
        bend: Young's modulus for the plugin's key `bend`, Pa; 0 where the section has no material.
        twist: shear modulus for its key `twist`, Pa.
    """

    joint_damping: float
    segment_length: float
    bend: float = 0.0
    twist: float = 0.0

    program: ClassVar[str] = "mujoco"
    title: ClassVar[str] = "MuJoCo cable"
    meaning: ClassVar[str] = (
        "joint torque = -damping times relative angular velocity, the same about all three axes"
    )
    words: ClassVar[tuple[str, ...]] = ("damping",)
    options: ClassVar[tuple[str, ...]] = ("segment_length",)
    missing: ClassVar[tuple[int, ...]] = (0, 1, 2)
    sources: ClassVar[tuple[str, ...]] = (
        "google-deepmind/mujoco: plugin/elasticity/cable.cc (elastic torque: stiffness over the "
        "distance of the bodies)",
        "google-deepmind/mujoco: model/plugin/elasticity/cable.xml (joint kind main, damping); the "
        "package mujoco, run",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """The mean viscous bending stiffness over the segment length."""
        (length,) = checked_options(cls, options)
        return cls(float(np.diag(data.damping)[3:5].mean()) / length, length, *_moduli(data))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """One number."""
        (length,) = checked_options(cls, options)
        (damping,) = listed(cls, numbers)
        return cls(damping, length, *_moduli(data))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The joint damping."""
        return (self.joint_damping,)

    def law(self, stiffness: Floats) -> Floats:
        """A joint turns by the curvature times the segment length, so D = damping times length."""
        del stiffness
        value = self.joint_damping * self.segment_length
        return np.diag([0.0, 0.0, 0.0, value, value, value])

    def text(self) -> str:
        """Lines of the model file."""
        damping = number_text(self.joint_damping)
        plugin = ""
        if self.bend > 0.0:
            plugin = (
                '<plugin plugin="mujoco.elasticity.cable">\n'
                f'  <config key="twist" value="{number_text(self.twist)}"/>\n'
                f'  <config key="bend" value="{number_text(self.bend)}"/>\n</plugin>\n'
            )
        return (
            f"<!-- segments of {number_text(self.segment_length)} m -->\n{plugin}"
            f'<joint kind="main" damping="{damping}"/>  <!-- in composite; '
            f'else <joint type="ball" damping="{damping}"/> -->'
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """One number for three directions."""
        return (
            *super().losses(data),
            "one damping for both bending directions and twist; with other segments it must be scaled by 1/length",
        )

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Versions, and the integrator."""
        return (
            *super().warnings(data),
            "run with mujoco 3.17; mujoco 4.0.0 as installed from the package index knows no composite "
            "and finds no plugin "
            "mujoco.elasticity.cable",
        )


def _moduli(data: SectionData) -> tuple[float, float]:
    material = data.material
    return (0.0, 0.0) if material is None else (material.youngs_modulus, material.shear_modulus)

"""MuJoCo and Newton: damping of the joints between rigid segments, per joint and not per length."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.programs.inputs.program_inputs import ProgramInputs, SectionData, number_text
from viscorod.typing import Floats

__all__ = ["MuJoCo", "Newton"]


@known_arguments
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

    program = "mujoco"
    title = "MuJoCo cable"
    meaning = "joint torque = -damping times relative angular velocity, the same about all three axes"
    words = ("damping",)
    units = ("N m s/rad",)
    options = ("segment_length",)
    missing = (0, 1, 2)
    sources = (
        "google-deepmind/mujoco: plugin/elasticity/cable.cc (elastic torque: stiffness over the distance of the "
        "bodies)",
        "google-deepmind/mujoco: model/plugin/elasticity/cable.xml (joint kind main, damping); the package mujoco, run",
    )
    always_lost = (
        "one damping for both bending directions and twist; with other segments it must be scaled by 1/length",
    )
    notes = (
        "run with mujoco 3.17; mujoco 4.0.0 as installed from the package index has neither composite nor the "
        "plugin mujoco.elasticity.cable",
    )

    @classmethod
    def _numbers(cls, data: SectionData, options: Sequence[float], /) -> Sequence[float]:
        """Return the mean viscous bending stiffness over the segment length."""
        (length,) = options
        return [float(np.diag(data.damping)[3:5].mean()) / length]

    @classmethod
    def _of(cls, numbers: Sequence[float], data: SectionData, options: Sequence[float], /) -> Self:
        material = data.material
        moduli = () if material is None else (material.youngs_modulus, material.shear_modulus)
        return cls(*numbers, *options, *moduli)

    def law(self, stiffness: Floats) -> Floats:
        """Return damping times length: a joint turns by the curvature times the segment length."""
        del stiffness
        value = self.joint_damping * self.segment_length
        return np.diag([0.0, 0.0, 0.0, value, value, value])

    def text(self) -> str:
        """Return lines of the model file."""
        damping = number_text(self.joint_damping)
        plugin = ""
        if self.bend > 0.0:
            plugin = (
                '<!-- in the model: <extension><plugin plugin="mujoco.elasticity.cable"/></extension> -->\n'
                '<plugin plugin="mujoco.elasticity.cable">\n'
                f'  <config key="twist" value="{number_text(self.twist)}"/>\n'
                f'  <config key="bend" value="{number_text(self.bend)}"/>\n</plugin>\n'
            )
        return (
            f"<!-- segments of {number_text(self.segment_length)} m -->\n{plugin}"
            f'<joint kind="main" damping="{damping}"/>  <!-- in composite; '
            f'else <joint type="ball" damping="{damping}"/> -->'
        )


@known_arguments
@dataclass(frozen=True)
class Newton(ProgramInputs):
    """Constants of the joints between the capsules of a rod (ModelBuilder.add_rod); per joint, not per length.

    Attributes:
        damping: stretch (N s/m), shear (N s/m), bend (N m s/rad), twist (N m s/rad).
        stiffness: the same four (N/m, N/m, N m/rad, N m/rad).
        segment_length: rest length of the capsules, m.
    """

    damping: tuple[float, ...]
    stiffness: tuple[float, ...]
    segment_length: float

    program = "newton"
    title = "Newton rod"
    meaning = "joint force = -damping times rate of the joint's displacement or relative rotation"
    words = ("stretch_damping", "shear_damping", "bend_damping", "twist_damping")
    units = ("N s/m", "N s/m", "N m s/rad", "N m s/rad")
    options = ("segment_length",)
    sources = (
        "newton-physics/newton: newton/_src/sim/builder.py, add_rod and add_joint_rod (package newton 1.8.0)",
        "newton-physics/newton: newton/_src/solvers/vbd/rigid_vbd_kernels.py (package newton 1.8.0)",
    )
    always_lost = (
        "one constant for both shears and one for both bendings; with other segments all must be scaled by 1/length",
    )
    notes = (
        "read in newton 1.8.0, where the constants are absolute; the threads 1058 and 1097 of its repository "
        "describe them as factors of the stiffness: with another version, check which it has",
        "its VBD solver takes the rate from implicit Euler, which damps by itself, more with larger steps",
    )

    @classmethod
    def _numbers(cls, data: SectionData, options: Sequence[float], /) -> Sequence[float]:
        return _per_joint(data.damping, *options)

    @classmethod
    def _of(cls, numbers: Sequence[float], data: SectionData, options: Sequence[float], /) -> Self:
        return cls(tuple(numbers), _per_joint(data.stiffness, *options), *options)

    def law(self, stiffness: Floats) -> Floats:
        """Return a diagonal matrix: the constants times the segment length."""
        del stiffness
        stretch, shear, bend, twist = (value * self.segment_length for value in self.damping)
        return np.diag([shear, shear, stretch, bend, bend, twist])

    def text(self) -> str:
        """Return keywords of add_rod."""
        lines = [
            f"# rod with segments of {number_text(self.segment_length)} m",
            "builder.add_rod(",
            "    rod=rod,",
        ]
        for word, stiff, damp in zip(self.words, self.stiffness, self.damping, strict=True):
            mode = word.removesuffix("_damping")
            lines.append(f"    {mode}_stiffness={number_text(stiff)}, {word}={number_text(damp)},")
        return "\n".join([*lines, ")"])


def _per_joint(matrix: Floats, length: float) -> tuple[float, ...]:
    """Return the diagonal over the segment length; both shears and both bendings by their means."""
    shear_1, shear_2, stretch, bend_1, bend_2, twist = (np.diag(matrix) / length).tolist()
    return stretch, (shear_1 + shear_2) / 2.0, (bend_1 + bend_2) / 2.0, twist

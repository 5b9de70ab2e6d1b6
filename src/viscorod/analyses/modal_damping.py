"""From measured damping ratios of modes to the times of the materials: solved on the model as it is supported."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
from scipy import sparse

from viscorod.errors import Fault, InputError
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.description.pending_times import (
    all_pending,
    pending,
    with_materials,
    without_pending_times,
)
from viscorod.model.fields.definition import did_you_mean, some_of
from viscorod.model.materials.kelvin_voigt import KelvinVoigt
from viscorod.model.materials.material import Material
from viscorod.model.materials.measured_damping import MOST_MODES, MeasuredDamping
from viscorod.model.sections.stiffness_section import STRAINS
from viscorod.results.text_numbers import quantity
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.damped import CLOSE
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.modes.mode_names import StrainEnergies
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.problem import problem as discrete
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["with_known_times"]

M = TypeVar("M", bound=ModelDescription)


def with_known_times(model: M) -> M:
    """Return the model with the times of these materials found from its modes about the unloaded reference shape.

    Several such materials are solved for jointly, each with its own mode. Dampers and other materials count as they
    are.

    Raises:
        InputError: there is no such mode, another part damps the mode more, the modes do not distinguish the materials,
            or a material has Maxwell branches.
    """
    materials = pending(model)
    if not materials:
        return model
    where = [_path(model, material) for material in materials]
    _require_no_branches(model, where[0])
    base = without_pending_times(model)
    modes = _Modes(discretise(base))
    chosen = [modes.find(_wish(m), path) for m, path in zip(materials, where, strict=True)]
    # the ratio of a mode is (fixed + sum of what each material with the shear time 1 s adds) phi.D phi/2 omega
    fixed = np.array([mode.ratio(modes.linear.damping) for mode in chosen])
    slopes = np.empty((len(chosen), len(materials)))
    for column, material in enumerate(materials):
        unit = KelvinVoigt(1.0, _wish(material).bulk_to_shear)
        variant = {id(m): m.with_damping(unit if m == material else None) for m in all_pending(model)}
        damping = modes.damping(discretise(with_materials(model, variant)))
        slopes[:, column] = [mode.ratio(damping) for mode in chosen]
    slopes -= fixed[:, None]
    targets = np.array([_wish(material).target for material in materials])
    times = _times(slopes, targets - fixed, where)
    known: dict[int, Material] = {}
    for material in all_pending(model):
        k = materials.index(material)
        known[id(material)] = _known(material, float(times[k]), chosen[k])
    return with_materials(model, known)


def _known(material: Material, time: float, mode: _Mode) -> Material:
    wish = _wish(material)
    return material.with_damping(
        KelvinVoigt(time, wish.bulk_to_shear * time),
        f"the shear time of {quantity(time, 's', 4)} gives mode {mode.number} of the unloaded model "
        f"({quantity(mode.hertz, 'Hz', 4)}, {mode.share:.0%} {mode.strain}) the damping ratio {wish.target:.4g}, to "
        "first order in the ratio; that of others grows with their frequency",
        "the bulk time is taken equal to the shear time"
        if wish.bulk_to_shear == 1.0
        else f"the bulk time is taken as {wish.bulk_to_shear:g} times the shear time",
    )


def _wish(material: Material) -> MeasuredDamping:
    assert isinstance(material.damping, MeasuredDamping)
    return material.damping


def _path(model: ModelDescription, material: Material) -> str:
    name = next(name for name, rod in model.rods.items() if rod.material == material)
    return f"rods.{name}.material.damping"


def _require_no_branches(model: ModelDescription, where: str) -> None:
    for name, rod in model.rods.items():
        stations = (0.0, *rod.section_breaks)
        relaxing = rod.material is not None and rod.material.branches
        if relaxing or (rod.material is None and any(len(rod.branches_at(s)[0]) for s in stations)):
            raise InputError(
                Fault(
                    where,
                    f"rod {name}",
                    "its Maxwell branches make the mode depend on more than these times",
                    "give this material its times, or that rod a Kelvin-Voigt material",
                )
            )


def _times(slopes: Floats, wanted: Floats, where: list[str]) -> Floats:
    """Return the shear times of the materials from the ratios that they have to give."""
    scale = np.abs(slopes).max(axis=0, initial=0.0)
    if not (scale > 0.0).all() or np.linalg.cond(slopes / scale) > 1e8:
        raise InputError(
            Fault(
                where[0],
                "",
                "the chosen modes do not distinguish the damping of these materials",
                "choose a mode that strains each of them: mode = 'bend_1 1', rod = the rod's name",
            )
        )
    times: Floats = np.asarray(np.linalg.solve(slopes, wanted), dtype=float)
    for path, time in zip(where, times, strict=True):
        if not time > 0.0:
            raise InputError(
                Fault(
                    path,
                    "",
                    "the other parts of the model damp this mode more than that already",
                    "give it a higher damping ratio, or choose a mode that strains mostly this material, or damp the "
                    "others less",
                )
            )
    return times


@dataclass(frozen=True)
class _Mode:
    """A vibration: its number, frequency [Hz], shape with phi.M phi = 1, and the strain with most of its energy."""

    number: int
    hertz: float
    shape: Floats
    strain: str = ""
    share: float = 0.0

    def ratio(self, damping: sparse.csr_array) -> float:
        """Return the damping ratio ``phi.D phi/2 omega``."""
        return float(self.shape @ (damping @ self.shape)) / (4.0 * np.pi * self.hertz)


def _linearised(problem: discrete.Problem) -> tuple[StaticSolver, Linearisation]:
    solver = StaticSolver(GeometricSystem(problem), SupportState(problem))
    return solver, linearise(solver, State.reference(problem), scale=0.0)


class _Modes:
    """The slowest undamped vibrations about the unloaded reference shape, rigid motions left out."""

    def __init__(self, problem: discrete.Problem) -> None:
        solver, linear = _linearised(problem)
        found = undamped_modes(linear, 2 * MOST_MODES)
        self.linear = found.linear
        self.energies = StrainEnergies(solver.system, State.reference(problem), self.linear)
        vibrating = np.flatnonzero(found.squares > 0.0)[: 2 * MOST_MODES]
        squares = found.squares[vibrating]
        self.omega = np.sqrt(squares)
        self.shapes = self.energies.principal(found.shapes[:, vibrating], squares)
        self.kinds = self.energies.kinds(self.shapes)

    def damping(self, problem: discrete.Problem) -> sparse.csr_array:
        """Return the damping matrix of another problem that differs in damping alone, in the same motions."""
        linear = _linearised(problem)[1]
        return (linear.unconditional() if self.linear.gradients is None else linear).damping

    def find(self, wish: MeasuredDamping, where: str) -> _Mode:
        """Return the mode that is meant.

        Raises:
            InputError: there is no such rod or mode.
        """
        rods = self.energies.rods
        if wish.rod is not None and wish.rod not in rods:
            hint = did_you_mean(wish.rod, rods)
            raise InputError(
                Fault(
                    f"{where}.rod",
                    repr(wish.rod),
                    "no rod has this name",
                    f"{hint}give one of {some_of(rods)}",
                )
            )
        word, _, count = wish.mode.rpartition(" ") if isinstance(wish.mode, str) else ("", "", str(wish.mode))
        if wish.rod is None:
            every = enumerate(zip(self.kinds, self.omega, self.shapes.T, strict=True), 1)
            found = [_Mode(k, w / (2.0 * np.pi), x) for k, (kind, w, x) in every if not word or kind == word]
        else:
            found = [mode for a, b in self._spaces() for mode in self._mostly(word, wish.rod, a, b)]
        if len(found) >= int(count):
            return self._named(found[int(count) - 1])
        text = f"modes{f' mostly of {word}' if word else ''}{f' in rod {wish.rod}' if wish.rod else ''}"
        raise InputError(
            Fault(
                f"{where}.mode",
                repr(wish.mode),
                f"among the first {len(self.omega)} modes there are {len(found)} {text}",
                "give a lower number, or more elements to the rod",
            )
        )

    def _spaces(self) -> list[tuple[int, int]]:
        """Return the ranges of modes with the same frequency."""
        ends = np.flatnonzero(np.diff(self.omega) > CLOSE * self.omega[1:]) + 1
        edges = [0, *ends.tolist(), len(self.omega)]
        return [(a, b) for a, b in pairwise(edges) if b > a]

    def _mostly(self, word: str, rod: str, first: int, last: int) -> list[_Mode]:
        """Return the modes of one frequency that have more than half of their energy in a strain and in a rod."""
        shapes, omega = self.shapes[:, first:last], self.omega[first:last]
        # within one frequency any combination is a mode: those with the largest share, and across them
        forms = self.energies.forms(shapes, rod)
        wanted = forms[STRAINS.index(word)] if word else forms.sum(axis=0)
        shares, turn = np.linalg.eigh(wanted / (omega[:, None] * omega))
        shapes = (shapes @ turn)[:, ::-1]
        kept = shapes[:, shares[::-1] > 0.5]
        return [_Mode(first + k + 1, float(omega[k]) / (2.0 * np.pi), x) for k, x in enumerate(kept.T)]

    def _named(self, mode: _Mode) -> _Mode:
        """Return the mode with the strain that has most of its elastic energy."""
        forms = self.energies.forms(mode.shape[:, None])[:, 0, 0] / (2.0 * np.pi * mode.hertz) ** 2
        largest = int(np.argmax(forms))
        return replace(mode, strain=STRAINS[largest].replace("_", " "), share=float(forms[largest]))

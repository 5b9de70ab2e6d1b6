"""From measured damping ratios of modes to the times of the materials: solved on the model as it is supported."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np
import scipy.linalg
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
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import DENSE, Linearisation, linearise
from viscorod.solve.problem import problem as discrete
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["with_known_times"]

M = TypeVar("M", bound=ModelDescription)

CLOSE = 1e-6
"""Relative distance of frequencies below which modes are taken as one space, such as bending of a square section."""


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
        damping = _linearised(discretise(with_materials(model, variant))).damping
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
        f"the shear time of {time:.4g} s gives mode {mode.number} of the unloaded model ({mode.hertz:.4g} Hz, "
        f"{mode.share:.0%} {mode.strain}) the damping ratio {wish.target:.4g}, to first order in the ratio; "
        "that of others grows with their frequency",
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


def _linearised(problem: discrete.Problem) -> Linearisation:
    solver = StaticSolver(GeometricSystem(problem), SupportState(problem))
    return linearise(solver, State.reference(problem), scale=0.0).unconditional()


class _Modes:
    """The slowest undamped vibrations about the unloaded reference shape."""

    def __init__(self, problem: discrete.Problem) -> None:
        self.problem = problem
        self.linear = _linearised(problem)
        self.omega, self.shapes = _vibrations(self.linear, 2 * MOST_MODES)

    def find(self, wish: MeasuredDamping, where: str) -> _Mode:
        """Return the mode that is meant.

        Raises:
            InputError: there is no such rod or mode.
        """
        rods = self.problem.rods
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
        found: list[_Mode] = []
        for first, last in self._spaces():
            found += self._mostly(word, wish.rod, first, last)
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

    def _mostly(self, word: str, rod: str | None, first: int, last: int) -> list[_Mode]:
        """Return the modes of one frequency that have more than half of their energy in a strain and in a rod."""
        shapes, hertz = self.shapes[:, first:last], self.omega[first:last] / (2.0 * np.pi)
        if word or rod is not None:
            # within one frequency any combination is a mode: those with the largest share, and across them
            shares, turn = np.linalg.eigh(self._share(shapes, hertz, word, rod))
            shapes = (shapes @ turn)[:, ::-1]
            shapes = shapes[:, shares[::-1] > 0.5]
        return [_Mode(first + k + 1, float(hertz[k]), shape) for k, shape in enumerate(shapes.T)]

    def _share(self, shapes: Floats, hertz: Floats, word: str, rod: str | None) -> Floats:
        """Return the share of the elastic energy in a strain and a rod, as a quadratic form of the given modes."""
        part = self._energy(word, rod)
        form = shapes.T @ (part @ shapes) / (2.0 * np.pi * hertz[:, None]) ** 2
        total: Floats = 0.5 * (form + form.T)
        return total

    def _named(self, mode: _Mode) -> _Mode:
        """Return the mode with the strain that has most of its elastic energy."""
        alone, hertz = mode.shape[:, None], np.array([mode.hertz])
        shares = [float(self._share(alone, hertz, word, None)[0, 0]) for word in STRAINS]
        largest = int(np.argmax(shares))
        return replace(mode, strain=STRAINS[largest].replace("_", " "), share=shares[largest])

    def _energy(self, word: str, rod: str | None) -> sparse.csr_array:
        """Return the stiffness of one strain and one rod alone (all if not named), for twice the elastic energy."""
        kept = np.array([not word or strain == word for strain in STRAINS], dtype=float)
        sets = []
        for e in self.problem.sets:
            part = 0.5 * (kept[:, None] * e.stiffness + e.stiffness * kept)
            inside = np.ones(len(e.rod), dtype=bool) if rod is None else e.rod == self.problem.rods.index(rod)
            # a second copy of every section, without this part, for the elements of the other rods
            sets.append(
                replace(
                    e,
                    section=np.where(inside[:, None], e.section, e.section + len(e.stiffness)),
                    stiffness=np.concatenate([e.stiffness, e.stiffness]),
                    damping=np.concatenate([part, np.zeros_like(part)]),
                    held=np.concatenate([e.held, e.held]),
                    branches=np.concatenate([e.branches, e.branches]),
                )
            )
        # assembled as a damping matrix, beside which joints and springs must have no dampers
        joints = self.problem.joints
        with_dampers = _linearised(replace(self.problem, sets=tuple(sets))).damping
        if not joints.count:
            return with_dampers
        none = tuple(replace(e, damping=np.zeros_like(e.damping)) for e in self.problem.sets)
        return sparse.csr_array(with_dampers - _linearised(replace(self.problem, sets=none)).damping)


def _vibrations(linear: Linearisation, count: int) -> tuple[Floats, Floats]:
    """Return angular frequencies [rad/s] and shapes (size, n) of the slowest undamped vibrations, not rigid ones."""
    import scipy.sparse.linalg as spla

    K, M = 0.5 * (linear.stiffness + linear.stiffness.T), 0.5 * (linear.mass + linear.mass.T)
    size = K.shape[0]
    shift = 1e-10 * float(K.diagonal().sum() / M.diagonal().sum())
    shifted = sparse.csc_array(K + shift * M)
    if size <= 2 * DENSE:
        inverse, shapes = scipy.linalg.eigh(M.toarray(), shifted.toarray())
    else:
        # the largest of M x = mu (K + shift M) x, which is definite, are the slowest
        factor = spla.splu(shifted)
        solve = spla.LinearOperator((size, size), matvec=factor.solve)
        inverse, shapes = spla.eigsh(
            sparse.csc_array(M), min(count + 6, size - 2), shifted, Minv=solve, which="LA"
        )
    values = 1.0 / inverse[inverse > 0.0] - shift
    shapes = shapes[:, inverse > 0.0]
    order = np.argsort(values)[: count + 6]
    values, shapes = values[order], shapes[:, order]
    moving = values > 1e4 * shift
    # a vibration is slower than a rigid motion's round-off only if its frequency is below 1e-3 of the lowest resolved
    values, shapes = values[moving][:count], shapes[:, moving][:, :count]
    norm = np.sqrt(np.einsum("ik,ik->k", shapes, M @ shapes))
    return np.sqrt(values), shapes / norm

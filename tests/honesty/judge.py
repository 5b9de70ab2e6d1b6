"""Solutions by default against refined ones of the same model: how far off they are, and whether they say so."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import viscorod as vr
from honesty.random_models import Mesh, Trial, by_default, random_trial
from viscorod.analyses.call_arguments import SimulateArguments
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.motion import motion
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.one_thread import one_blas_thread
from viscorod.results.result_warnings import warnings_of
from viscorod.solve.problem.division import Division, Divisions

UNTOLD = 0.01
"""True error, as a part of the displacements or of a frequency, that no result may have without a word."""
WITHIN = 10.0
"""Factor within which an estimate is to be right."""
FLOOR = 1e-9
"""True errors below it are round-off, which no estimate of the mesh is about."""
FINER = 3e-3
"""Tolerance of refined motions over that of the default one, but at least ``LEAST_TOLERANCE``."""
LEAST_TOLERANCE = 1e-9
ENOUGH = 0.03
"""Part of a tolerance that a smaller one may be at most to judge what the steps err by."""
MOMENTS = 60
FACTORS = {"simulate": (2, 3), "steady": (1, 2)}
"""Times the elements that two refined solutions have; 3 and 5 of other analyses, which cost less."""


@dataclass(frozen=True)
class Verdict:
    """What a trial showed.

    Attributes:
        seed, analysis, structure: of the trial.
        outcome: "solved", "refused" (before it was computed), "failed" (with a reason), "unjudged" (no refined solution
            that agrees with another), or "crashed", which no trial may.
        error: true error, as a part of the largest displacement, or of the frequency; NaN if unjudged.
        true_mesh, estimate: error of positions by the mesh over the length of the rod (or of a frequency), as it is,
            and as the result says it is.
        told: whether the result warns, or its estimate is as large as a third of the error.
        words: warnings, or the message.
        true_steps, steps: errors of positions of a motion by its steps [m], as they are, and as the result says they
            are; true_turns, turns: of rotations [rad]; true_forces, forces: of section forces [N]; true_moments,
            moments: of the moments of sections [N m]. NaN where tolerances cannot be much smaller.
    """

    seed: int
    analysis: str
    structure: str
    outcome: str
    error: float = math.nan
    true_mesh: float = math.nan
    estimate: float = math.nan
    told: bool = True
    words: str = ""
    true_steps: float = math.nan
    steps: float = math.nan
    true_turns: float = math.nan
    turns: float = math.nan
    true_forces: float = math.nan
    forces: float = math.nan
    true_moments: float = math.nan
    moments: float = math.nan

    @property
    def untold(self) -> bool:
        """Whether a number is wrong without a word."""
        return self.outcome == "crashed" or (
            self.outcome == "solved" and self.error > UNTOLD and not self.told
        )

    @property
    def estimated(self) -> bool:
        """Whether there is an estimate that can be judged."""
        return self.outcome == "solved" and self.true_mesh > FLOOR and self.estimate > 0.0

    @property
    def within(self) -> bool:
        """Whether the estimate is right within the factor."""
        return 1.0 / WITHIN <= self.estimate / self.true_mesh <= WITHIN


def verdict(seed: int) -> Verdict:
    """Judge the trial of a seed."""
    return judge(random_trial(seed))


def judge(trial: Trial) -> Verdict:
    """Solve a trial by default and refined, and compare."""
    known = (trial.seed, trial.analysis, trial.structure)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            found = _Answer.of(trial)
        except vr.InputError as error:
            return Verdict(*known, "refused", words=_short(error))
        except vr.SolveError as error:
            return Verdict(*known, "failed", words=_short(error))
        except Exception as error:  # any other is what no user may see
            return Verdict(*known, "crashed", words=f"{type(error).__name__}: {_short(error)}", told=False)
        try:
            fine, finer = (_Answer.of(trial, **found.refined(k)) for k in (0, 1))
            # of a motion, the error of the mesh alone is what is left with the steps of the finest solution
            meshed = _Answer.of(trial, **found.with_finest_steps) if found.tolerance else found
        except (vr.InputError, vr.SolveError) as error:
            return Verdict(*known, "unjudged", words=f"refined: {_short(error)}")
    error, doubt = found.error(finer), fine.error(finer)
    if doubt > 0.2 * max(error, UNTOLD):
        return Verdict(*known, "unjudged", error, words=f"refined solutions differ by {doubt:.2g}")
    apart = meshed.mesh_error(finer)
    true_mesh = apart if fine.mesh_error(finer) < 0.2 * apart else math.nan
    told = bool(found.warnings) or found.estimate_of_error > error / 3.0
    words = "; ".join(found.warnings)
    return Verdict(
        *known, "solved", error, true_mesh, found.estimate, told, words, *found.errors_of_steps(meshed)
    )


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:300]


@dataclass(frozen=True)
class _Answer:
    """What a user reads of a result.

    Attributes:
        values: what is compared; scale: of it, 0 where each value is its own.
        lengths: of the rods, by name; moved: displacements of places on them ``(states, places, 3)``.
        elements: and order of every rod.
        estimate: of the mesh error; warnings: of the result; tolerance: of a motion, 0 of others.
        factors: how many times the elements refined solutions have.
    """

    values: np.ndarray
    scale: float
    moved: dict[str, np.ndarray]
    lengths: dict[str, float]
    meshes: dict[str, tuple[int, int]]
    estimate: float
    warnings: list[str]
    tolerance: float = 0.0
    factors: tuple[int, int] = (3, 5)
    divisions: Divisions = field(default_factory=dict)
    turned: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    section_force: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 6)))
    steps: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        trial: Trial,
        mesh: Mesh = by_default,
        settings: dict[str, Any] | None = None,
        divisions: Divisions | None = None,
    ) -> _Answer:
        model, settings = trial.build(mesh), settings or {}
        lengths = {name: rod.length for name, rod in model.rods.items()}
        if trial.analysis == "simulate":
            interval = trial.settings["duration"] / MOMENTS
            given = trial.settings | {"output_interval": interval} | settings
            result = model.simulate(**given) if divisions is None else _motion(model, divisions, given)
        else:
            result = getattr(model, trial.analysis)(**trial.settings, **settings)
        if trial.analysis == "modes":
            return cls(
                result.frequencies,
                0.0,
                {},
                lengths,
                _meshes_of_model(model),
                float(np.max(result.frequency_errors, initial=0.0)),
                list(getattr(result, "warnings", [])),
            )
        moved, turned = {}, []
        for name, length in lengths.items():
            probed = result.probe(name, s=np.linspace(0.0, length, 11))
            moved[name] = np.asarray(probed["displacement"].values)
            turned.append(np.asarray(probed["rotation"].values))
        if trial.analysis != "simulate":
            moved = {name: value[-1:] for name, value in moved.items()}
        every = np.concatenate(list(moved.values()), axis=1)
        largest = float(np.linalg.norm(every, axis=2).max())
        return cls(
            every,
            largest,
            moved,
            lengths,
            _meshes_of_data(result.data),
            max(result.mesh_errors.values(), default=0.0),
            warnings_of(result),
            float(result.data.attrs.get("tolerance", 0.0)),
            FACTORS.get(trial.analysis, (3, 5)),
            _divisions(result.data),
            np.concatenate(turned, axis=1),
            np.asarray(result.data["section_force"].values),
            getattr(result, "step_errors", {}),
        )

    def error(self, other: _Answer) -> float:
        """Return the largest deviation from another answer, as a part of the displacements or of each frequency."""
        if self.values.shape != other.values.shape:
            return math.inf
        if self.scale == 0.0:
            least = max(1e-6 * float(np.abs(other.values).max()), np.finfo(float).tiny)  # all may be zero
            size = np.maximum(np.abs(other.values), least)
            return float((np.abs(self.values - other.values) / size).max())
        away = np.linalg.norm(self.values - other.values, axis=2).max()
        return float(away / max(other.scale, 1e-9 * max(self.lengths.values())))

    def mesh_error(self, other: _Answer) -> float:
        """Return the same, as estimates of the mesh state it: over the length of each rod."""
        if self.scale == 0.0:
            return self.error(other)
        return max(
            float(np.linalg.norm(mine - other.moved[name], axis=2).max()) / self.lengths[name]
            for name, mine in self.moved.items()
        )

    @property
    def estimate_of_error(self) -> float:
        """Estimate, as a part of the displacements or of a frequency."""
        if self.scale == 0.0:
            return self.estimate
        return self.estimate * max(self.lengths.values()) / max(self.scale, 1e-300)

    def errors_of_steps(self, other: _Answer) -> tuple[float, ...]:
        """Return errors and their estimates beside finer steps: see ``Verdict``."""
        if not self.steps or LEAST_TOLERANCE > ENOUGH * self.tolerance:
            return ()
        away = float(np.linalg.norm(self.values - other.values, axis=2).max())
        sine = np.linalg.norm(product(conjugate(self.turned), other.turned)[..., 1:], axis=-1)
        turns = float(2.0 * np.arcsin(np.minimum(sine, 1.0)).max())
        apart = (self.section_force - other.section_force).reshape(-1, 2, 3)
        force, moment = np.linalg.norm(apart, axis=2).max(axis=0).tolist()
        said = [self.steps[kind] for kind in ("position", "rotation", "section_force", "section_moment")]
        return tuple(x for pair in zip((away, turns, force, moment), said, strict=True) for x in pair)

    def refined(self, level: int) -> dict[str, Any]:
        """Return arguments of a refined solution: some times the elements, of an order that is higher by one."""
        factor = self.factors[level]
        if self.tolerance:
            divisions = {
                name: Division(min(division.order + 1, 8), _split(division.ends, factor))
                for name, division in self.divisions.items()
            }
            return {"divisions": divisions, "settings": self.settings}
        meshes = self.meshes

        def mesh(rod: str) -> dict[str, int]:
            elements, order = meshes[rod]
            return {"elements": factor * elements, "order": min(order + 1, 8)}

        return {"mesh": mesh}

    @property
    def with_finest_steps(self) -> dict[str, Any]:
        """Return arguments of a motion on the mesh of this answer, with the steps of the finest one."""
        return {"divisions": self.divisions, "settings": self.settings}

    @property
    def settings(self) -> dict[str, Any]:
        """Return settings of refined motions."""
        return {"tolerance": max(FINER * self.tolerance, LEAST_TOLERANCE)}


def _motion(model: vr.Model, divisions: Divisions, settings: dict[str, Any]) -> vr.Run:
    """Compute a motion on elements that need not be equal."""
    call = SimulateArguments(**settings)
    with one_blas_thread():
        return motion(DiscreteModel.of(model, call, call.options).on_mesh(divisions), call)


def _split(ends: np.ndarray, count: int) -> np.ndarray:
    """Return the ends of elements, each divided in ``count``."""
    parts = np.arange(count) / count
    inner = ends[:-1, None] + parts * np.diff(ends)[:, None]
    return np.append(inner.ravel(), ends[-1])


def _divisions(data: Any) -> Divisions:
    """Return how the rods of a data set are divided."""
    found = {}
    rods, orders = np.array(data["station_rod"].values), np.array(data["station_order"].values)
    for name in dict.fromkeys(rods.tolist()):
        mine = rods == name
        order = int(orders[mine][0])
        if order:
            found[str(name)] = Division(order, np.array(data["station_s"].values[mine][::order], dtype=float))
    return found


def _meshes_of_data(data: Any) -> dict[str, tuple[int, int]]:
    """Return the number of elements and the order of every rod of a data set."""
    rods, orders = data["station_rod"].values.tolist(), data["station_order"].values.tolist()
    found: dict[str, tuple[int, int]] = {}
    for name in dict.fromkeys(rods):
        order = int(orders[rods.index(name)])
        if order:
            found[name] = ((rods.count(name) - 1) // order, order)
    return found


def _meshes_of_model(model: vr.Model) -> dict[str, tuple[int, int]]:
    """Return the same for a model that is only discretised."""
    from viscorod.solve.problem.discretise import discretise

    problem = discretise(model)
    counts = np.bincount(problem.stations.rod)
    return {
        str(name): ((int(counts[k]) - 1) // int(order), int(order))
        for k, (name, order) in enumerate(zip(problem.rods, problem.rod_orders, strict=True))
    }

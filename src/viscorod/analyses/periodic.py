"""Periodic motions over frequency or amplitude."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.analyses.linear_about import placed_outputs
from viscorod.errors import Fault, InputError, SolveError
from viscorod.results.periodic import LOSSLESS, NO_INPUT, Periodic
from viscorod.solve.formulations.system import State
from viscorod.solve.linear_systems.measured_moduli import of_law_in_place
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.periodic.backbone import Backbone
from viscorod.solve.periodic.continuation import UNSTABLE, Continuation, OrbitPoint, Parameter
from viscorod.solve.periodic.drive import Drive
from viscorod.solve.periodic.fourier import Fourier
from viscorod.solve.periodic.more_harmonics import multipliers_with_more_harmonics
from viscorod.solve.periodic.orbit import Motion, Orbit, Setting
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_energy import losses, put_in, unit_powers
from viscorod.solve.periodic.orbit_outputs import OrbitOutputs
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.signals import LoadInput
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Record", "data_set", "periodic"]

FINE = 2.0 * np.pi * np.arange(200) / 200
"""Phases [rad] at which the extremes of an output are sought."""
KEPT = 12
"""Floquet multipliers of every motion that a result has, the largest ones."""
MOST_CHECKED, UNSURE = 3, 1e-3
"""Bifurcations, but folds, whose multipliers are found with twice the harmonics too; what is told if they change."""
TAIL = 1e-4
"""Size of the highest two harmonics, over that of all, from which on more of them are advised."""


def periodic(discrete: DiscreteModel, settings: PeriodicSettings) -> Periodic:
    """Follow periodic motions; see ``Model.periodic``."""
    discrete.require_independent()
    before, base = settings.about == "equilibrium", State.reference(discrete.problem)
    find_initial_equilibrium(discrete, base, before=before)
    linear = linearise(discrete.static, base, before=before)
    if linear.rigid:
        raise InputError(
            f"no periodic motion: nothing holds the model against {', '.join(linear.texts)}, so it has no place to "
            "swing about; add supports or springs"
        )
    record = Record.of(discrete, settings, base)
    try:
        follow = _forced if settings.mode is None else _free
        reached = follow(discrete, settings, record)
    except SolveError as error:
        if not record.points:
            raise
        part = Periodic(data_set(discrete, settings, record, "stopped"))
        raise SolveError(f"{error}; {len(record.points)} motions before are in run", part) from None
    found = Periodic(data_set(discrete, settings, record, "completed" if reached else "points"))
    found.orbits = record.orbits
    return found


def _forced(discrete: DiscreteModel, settings: PeriodicSettings, record: Record) -> bool:
    """Follow forced motions; return whether the curve left its range."""
    turn, balance = 2.0 * np.pi, record.balance
    if settings.frequencies is not None:
        parameter = Parameter("omega", turn * settings.frequencies[0], turn * settings.frequencies[1])
        setting = Setting(parameter.start, 1.0)
    else:
        assert settings.levels is not None
        assert settings.frequency is not None
        parameter = Parameter("level", *settings.levels)
        setting = Setting(turn * settings.frequency, parameter.start)
    continuation = Continuation(balance, parameter, stability=settings.stability, stop=discrete.options.stop)
    first = continuation.first(balance.resting(), setting)
    last, progress = first, discrete.options.progress
    changed: list[OrbitPoint] = []
    unit = turn if settings.frequencies is not None else 1.0
    for point in continuation.follow(first, settings.step, settings.points):
        record.add(point.motion, point.orbit, point.multipliers, point.bifurcation)
        if point.bifurcation not in ("", "fold") and len(changed) < MOST_CHECKED:
            changed.append(point)
        if progress is not None:
            progress(point.value / unit, abs(point.value - last.value) / unit)
        last = point
    for point in changed:
        record.check(point)
    return last is not first and last.value in (parameter.start, parameter.end)


def _free(discrete: DiscreteModel, settings: PeriodicSettings, record: Record) -> bool:
    """Follow the free vibrations of a mode; return whether they reached their amplitude.

    Raises:
        InputError: there is no such mode.
    """
    assert settings.mode is not None
    assert settings.largest is not None
    balance = record.balance
    linear = linearise(discrete.static, balance.base, before=settings.about == "equilibrium")
    found = undamped_modes(linear, settings.mode)
    swinging = np.flatnonzero(found.squares > 0.0)
    if len(swinging) < settings.mode:
        raise InputError(
            Fault(
                "mode",
                str(settings.mode),
                f"the model has {len(swinging)} vibrations",
                "give a smaller number",
            )
        )
    at = int(swinging[settings.mode - 1])
    shape = np.asarray(found.linear.basis @ found.shapes[:, at]).reshape(-1, 6)

    def amplitude(motion: Motion) -> float:
        course = record.outputs.read(motion)[:, 0]
        return float(0.5 * np.ptp(balance.fourier.at(FINE) @ course))

    backbone = Backbone(balance, shape, float(np.sqrt(found.squares[at])), amplitude, discrete.options.stop)
    smallest, size = settings.largest / 100.0, 0.0
    for solved in backbone.follow(smallest, settings.largest, settings.step, settings.points):
        record.add(solved.motion, solved.orbit)
        before, size = size, amplitude(solved.motion)
        if discrete.options.progress is not None:
            discrete.options.progress(size, size - before)
    return size >= 0.999 * settings.largest


class Record:
    """What is kept of every motion.

    Attributes:
        points: numbers of the result; orbits: with their settings; notes: what is not sure.
    """

    def __init__(self, balance: OrbitBalance, outputs: OrbitOutputs) -> None:
        self.balance, self.outputs = balance, outputs
        self.points: list[dict[str, Any]] = []
        self.orbits: list[tuple[Orbit, Setting]] = []
        self.notes: list[str] = []

    @classmethod
    def of(cls, discrete: DiscreteModel, settings: PeriodicSettings, base: State) -> Record:
        """Return what records motions of a model about the state ``base``."""
        signals = settings.inputs or ()
        drive = Drive.of(
            discrete.problem,
            discrete.supports,
            discrete.system.constraints,
            signals,
            np.array(settings.amplitudes or ()),
            np.array(settings.phases or np.zeros(len(signals))),
            len(discrete.model.loads) - sum(isinstance(one, LoadInput) for one in signals),
        )
        before, fourier = settings.about == "equilibrium", Fourier(settings.harmonics)
        balance = OrbitBalance(discrete.system, base, drive, fourier, before=before)
        return cls(balance, OrbitOutputs(balance, discrete.static, placed_outputs(discrete, settings)))

    def check(self, point: OrbitPoint) -> None:
        """Compare the multipliers at a bifurcation with those of twice the harmonics; note where they differ."""
        few = self.balance.fourier.harmonics
        better = multipliers_with_more_harmonics(self.balance, point.orbit, point.setting, 2 * few)
        where = f"the {point.bifurcation} at {point.setting.omega / (2.0 * np.pi):.6g} Hz"
        if better is None:
            self.notes.append(f"{where} is not sure: with {2 * few} harmonics no motion was found there")
            return
        critical = point.multipliers[np.argmin(np.abs(np.abs(point.multipliers) - 1.0))]
        nearest = better[np.argmin(np.abs(better - critical))]
        if abs(nearest - critical) > UNSURE:
            self.notes.append(
                f"{where} is not sure: the multiplier of size {abs(critical):.4f} there has {abs(nearest):.4f} with "
                f"{2 * few} harmonics: give more"
            )

    def add(
        self, motion: Motion, orbit: Orbit, multipliers: np.ndarray | None = None, bifurcation: str = ""
    ) -> None:
        """Keep a motion."""
        balance, setting = self.balance, motion.setting
        self.orbits.append((orbit, setting))
        fourier, period = balance.fourier, 2.0 * np.pi / setting.omega
        if multipliers is None:
            multipliers = np.zeros(0, dtype=complex)
        values = np.full(KEPT, np.nan, dtype=complex)
        values[: len(multipliers)] = multipliers[:KEPT]
        rates = fourier.coefficients(unit_powers(balance, motion))
        order = np.arange(fourier.harmonics + 1)[:, None]
        conjugate = np.where(order > 0, rates / np.maximum(1j * setting.omega * order, 1j * 1e-300), 0.0)
        squares = np.abs(fourier.coefficients(orbit.X)) ** 2
        squares[..., :3] /= balance.problem.length**2
        harmonics = squares.sum(axis=(1, 2))[1:]
        loss = period * float(losses(balance, motion).mean())
        kinetic = 0.5 * np.einsum("pki,kij,pkj->p", motion.twist, balance.body.mass, motion.twist).mean()
        self.points.append(
            {
                "frequency": 1.0 / period,
                "level": setting.level,
                "coefficient": fourier.coefficients(self.outputs.read(motion)),
                "drive": balance.drive.phasors(setting.omega, setting.level),
                "conjugate": conjugate,
                "work": period * float(put_in(balance, motion).mean()),
                "loss": loss,
                "damping_ratio": loss / (8.0 * np.pi * max(float(kinetic), 1e-300)),
                "multiplier": values,
                "unstable": int((np.abs(multipliers) > UNSTABLE).sum()) if len(multipliers) else -1,
                "bifurcation": bifurcation,
                "tail": float(np.sqrt(harmonics[-2:].sum() / max(harmonics.sum(), 1e-300)))
                if fourier.harmonics > 2
                else np.nan,
            }
        )

    def all(self, name: str) -> Any:
        """Return one quantity of all points."""
        return np.array([point[name] for point in self.points])


def data_set(discrete: DiscreteModel, settings: PeriodicSettings, record: Record, outcome: str) -> xr.Dataset:
    """Return the data set of periodic motions."""
    import xarray as xr

    hertz = record.all("frequency")
    laws = of_law_in_place(discrete.model, float(hertz.min()), float(hertz.max()))
    notes, signals = [*laws, *_notes(settings, record, outcome)], settings.inputs or ()
    earlier = json.loads(discrete.attributes.get("warnings", "[]"))
    attrs = discrete.complete(
        {
            "kind": Periodic.kind,
            "outcome": outcome,
            "over": "amplitude" if settings.mode else "frequency" if settings.frequencies else "level",
            "harmonics": settings.harmonics,
            "nodes": discrete.problem.size,
            "warnings": json.dumps([*earlier, *notes]),
        }
    )

    def parts(values: np.ndarray) -> Floats:
        return np.stack([values.real, values.imag], axis=-1)

    coefficient = np.swapaxes(record.all("coefficient"), 1, 2)
    conjugate = np.swapaxes(record.all("conjugate"), 1, 2)
    multiplier = record.all("multiplier")
    known = np.isfinite(multiplier).all(axis=0)
    return xr.Dataset(
        {
            "level": ("point", record.all("level")),
            "coefficient": (("point", "output", "harmonic", "part"), parts(coefficient)),
            "drive": (("point", "input", "part"), parts(_filled(record.all("drive")))),
            "conjugate": (("point", "input", "harmonic", "part"), parts(_filled(conjugate))),
            "work": ("point", record.all("work")),
            "loss": ("point", record.all("loss")),
            "damping_ratio": ("point", record.all("damping_ratio")),
            "multiplier": (("point", "multiplier_number", "part"), parts(multiplier[:, known])),
            "unstable": ("point", record.all("unstable").astype(np.int64)),
            "bifurcation": ("point", record.all("bifurcation").astype(str)),
            "tail": ("point", np.nan_to_num(record.all("tail"))),
            "input_unit": ("input", np.array([one.unit for one in signals] or ["1"], dtype=str)),
            "output_unit": ("output", np.array([one.unit for one in settings.outputs], dtype=str)),
            "frequency": ("point", record.all("frequency")),
        },
        {
            "output": [one.label for one in settings.outputs],
            "input": [one.label for one in signals] or [NO_INPUT],
            "harmonic": np.arange(settings.harmonics + 1),
            "part": ["real", "imaginary"],
        },
        attrs,
    )


def _filled(values: np.ndarray) -> np.ndarray:
    """Return values by point and input; zeros where there is no input, since files have no empty arrays."""
    points, inputs, *others = values.shape
    return values if inputs else np.zeros((points, 1, *others), dtype=complex)


def _notes(settings: PeriodicSettings, record: Record, outcome: str) -> list[str]:
    """Return what is uncertain, in sentences."""
    found = list(record.notes)
    tail = float(np.nan_to_num(record.all("tail")).max())
    if tail > TAIL:
        found.append(
            f"the highest two of {settings.harmonics} harmonics make {tail:.2g} of the motion where they make most, "
            "and what tells stability is as uncertain: give more harmonics"
        )
    if outcome == "points":
        found.append(f"the curve does not reach its end with {settings.points} points")
    work, loss = record.all("work"), record.all("loss")
    apart = float((np.abs(work - loss) / np.maximum(np.abs(work), 1e-300)).max())
    # what swings by itself without damping has neither, but for round-off
    if apart > TAIL and (
        settings.mode is None or float(np.abs(record.all("damping_ratio")).max()) > LOSSLESS
    ):
        found.append(f"work and loss of a cycle differ by up to {apart:.2g} of the work: give more harmonics")
    return found

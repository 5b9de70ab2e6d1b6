"""Periodic motions over frequency or amplitude."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.analyses.linear_about import placed_outputs
from viscorod.errors import SolveError
from viscorod.results.periodic import Periodic
from viscorod.solve.formulations.system import State
from viscorod.solve.periodic.continuation import Continuation, OrbitPoint, Parameter
from viscorod.solve.periodic.drive import Drive
from viscorod.solve.periodic.fourier import Fourier
from viscorod.solve.periodic.orbit_balance import OrbitBalance, Setting
from viscorod.solve.periodic.orbit_outputs import OrbitOutputs
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.signals import LoadInput
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["periodic"]

KEPT = 12
"""Floquet multipliers of every motion that a result has, the largest ones."""
TAIL = 1e-4
"""Size of the highest two harmonics, over that of all, from which on more of them are advised."""


def periodic(discrete: DiscreteModel, settings: PeriodicSettings) -> Periodic:
    """Follow periodic motions; see ``Model.periodic``."""
    discrete.require_independent()
    model, problem = discrete.model, discrete.problem
    base = State.reference(problem)
    find_initial_equilibrium(discrete, base, before=True)
    first_load = len(model.loads) - sum(isinstance(one, LoadInput) for one in settings.inputs)
    drive = Drive.of(
        problem,
        discrete.supports,
        discrete.system.constraints,
        settings.inputs,
        np.array(settings.amplitudes),
        np.array(settings.phases or np.zeros(len(settings.inputs))),
        first_load,
    )
    balance = OrbitBalance(discrete.system, base, drive, Fourier(settings.harmonics))
    outputs = OrbitOutputs(balance, discrete.static, placed_outputs(discrete, settings))
    turn = 2.0 * np.pi
    if settings.frequencies is not None:
        parameter = Parameter("omega", turn * settings.frequencies[0], turn * settings.frequencies[1])
        setting = Setting(parameter.start, 1.0)
    else:
        assert settings.levels is not None
        assert settings.frequency is not None
        parameter = Parameter("level", *settings.levels)
        setting = Setting(turn * settings.frequency, parameter.start)
    continuation = Continuation(balance, parameter, stability=settings.stability, stop=discrete.options.stop)
    record = _Record(balance, outputs)
    try:
        first = continuation.first(balance.resting(), setting)
        for point in continuation.follow(first, settings.step, settings.points):
            record.add(point)
    except SolveError as error:
        if not record.points:
            raise
        part = Periodic(_data_set(discrete, settings, record, "stopped"))
        raise SolveError(f"{error}; {len(record.points)} motions before are in run", part) from None
    reached = record.points[-1]["value"] in (parameter.start, parameter.end)
    return Periodic(_data_set(discrete, settings, record, "completed" if reached else "points"))


class _Record:
    """What is kept of every motion."""

    def __init__(self, balance: OrbitBalance, outputs: OrbitOutputs) -> None:
        self.balance, self.outputs = balance, outputs
        self.points: list[dict[str, Any]] = []

    def add(self, point: OrbitPoint) -> None:
        """Keep a point."""
        balance, motion, setting = self.balance, point.motion, point.setting
        fourier, period = balance.fourier, 2.0 * np.pi / setting.omega
        values = np.full(KEPT, np.nan, dtype=complex)
        values[: len(point.multipliers)] = point.multipliers[:KEPT]
        rates = fourier.coefficients(balance.unit_powers(motion))
        order = np.arange(fourier.harmonics + 1)[:, None]
        conjugate = np.where(order > 0, rates / np.maximum(1j * setting.omega * order, 1j * 1e-300), 0.0)
        orbit = np.abs(fourier.coefficients(point.orbit.X)) ** 2
        orbit[..., :3] /= balance.problem.length**2
        harmonics = orbit.sum(axis=(1, 2))[1:]
        self.points.append(
            {
                "value": point.value,
                "frequency": 1.0 / period,
                "level": setting.level,
                "coefficient": fourier.coefficients(self.outputs.read(motion)),
                "drive": balance.drive.phasors(setting.omega, setting.level),
                "conjugate": conjugate,
                "work": period * float(balance.put_in(motion).mean()),
                "loss": period * float(balance.losses(motion).mean()),
                "multiplier": values,
                "unstable": point.unstable if len(point.multipliers) else -1,
                "bifurcation": point.bifurcation,
                "tail": float(np.sqrt(harmonics[-2:].sum() / max(harmonics.sum(), 1e-300)))
                if fourier.harmonics > 2
                else np.nan,
            }
        )

    def all(self, name: str) -> Any:
        """Return one quantity of all points."""
        return np.array([point[name] for point in self.points])


def _data_set(
    discrete: DiscreteModel, settings: PeriodicSettings, record: _Record, outcome: str
) -> xr.Dataset:
    """Return the data set of periodic motions."""
    import xarray as xr

    notes = _notes(settings, record, outcome)
    earlier = json.loads(discrete.attributes.get("warnings", "[]"))
    attrs = discrete.complete(
        {
            "kind": Periodic.kind,
            "outcome": outcome,
            "over": "frequency" if settings.frequencies else "level",
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
            "drive": (("point", "input", "part"), parts(record.all("drive"))),
            "conjugate": (("point", "input", "harmonic", "part"), parts(conjugate)),
            "work": ("point", record.all("work")),
            "loss": ("point", record.all("loss")),
            "multiplier": (("point", "multiplier_number", "part"), parts(multiplier[:, known])),
            "unstable": ("point", record.all("unstable").astype(np.int64)),
            "bifurcation": ("point", record.all("bifurcation").astype(str)),
            "tail": ("point", np.nan_to_num(record.all("tail"))),
            "input_unit": ("input", np.array([one.unit for one in settings.inputs], dtype=str)),
            "output_unit": ("output", np.array([one.unit for one in settings.outputs], dtype=str)),
            "frequency": ("point", record.all("frequency")),
        },
        {
            "output": [one.label for one in settings.outputs],
            "input": [one.label for one in settings.inputs],
            "harmonic": np.arange(settings.harmonics + 1),
            "part": ["real", "imaginary"],
        },
        attrs,
    )


def _notes(settings: PeriodicSettings, record: _Record, outcome: str) -> list[str]:
    """Return what is uncertain, in sentences."""
    found = []
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
    if apart > TAIL:
        found.append(f"work and loss of a cycle differ by up to {apart:.2g} of the work: give more harmonics")
    return found

"""Frequency responses: small harmonic motions about a state, from inputs to outputs."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.linear_about import LinearAbout, linear_about, with_input_loads
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.solve.linear_systems.adaptive_frequencies import (
    MOST,
    Followed,
    StoppedError,
    followed,
    reason_of,
)
from viscorod.solve.linear_systems.harmonic_response import HarmonicResponse
from viscorod.solve.linear_systems.poles import Poles
from viscorod.solve.linear_systems.reductions import modal_basis
from viscorod.solve.linear_systems.second_order import SecondOrder, second_order
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.signals import MotionInput
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["frequency_response", "with_inputs"]

FURTHER = 2.0
"""Frequency up to which modes take part, over the highest of the band."""
GROWS = 1e-9
"""Growth of a motion, as a part of its frequency, beyond round-off."""
LOOKS, BESIDE = 12, 1.001
"""Frequencies at which responses that are none are told from others at most, and how far beside resonances."""
COMPARED = 20
"""Frequencies at which a modal solution is compared with the direct one, beside the resonances."""


def frequency_response(discrete: DiscreteModel, settings: ResponseSettings) -> FrequencyResponse:
    """Compute frequency responses; see ``Model.frequency_response``."""
    discrete.static.stop = discrete.options.stop
    about = linear_about(discrete, settings, measured=settings.moduli == "measured")
    given = np.array(settings.frequencies or settings.band, dtype=float)
    low, high = float(given[0]), float(given[-1])
    _require_response(about, settings, low, high)
    response = HarmonicResponse(about.small, about.inputs, about.readings)
    poles = about.poles(high)
    residues = response.residues(poles.roots)
    silent = response.silent(_looked_at(low, high, poles.roots))
    residues[:, silent] = 0.0
    solve = response.at
    attributes: dict[str, float] = {}
    if settings.method == "modal":
        modal = ModalResponse.of(about, high)
        solve = modal.at
        attributes["modal_modes"] = modal.modes
        attributes["modal_error"] = modal.error(response, low, high, poles.roots)
    notes = [*about.notes, *_beyond(about, low, high), *_doubts(poles, in_band=settings.band is not None)]
    watched, progress = _watched(solve, silent, discrete.options.stop), discrete.options.progress
    if settings.band is None:
        found = _at_given(watched, given, progress)
    else:
        found = followed(watched, (low, high), list(poles.roots), settings.tolerance, progress)
        attributes |= {} if found.stopped else {"line_error": found.error}
        if len(found.hertz) >= MOST:
            notes.append(f"lines between {MOST} frequencies do not follow all responses to the tolerance")
    attributes["systems"] = response.solved
    text = f"The frequency response was stopped at {found.reached:.6g} of {high:.6g} Hz: {found.stopped}"
    if found.stopped:
        if len(found.hertz) < 2:
            raise SolveError(text)
        beyond = ": beyond, lines between frequencies do not follow the responses"
        notes.append(f"it was stopped at {found.reached:.6g} Hz" + ("" if settings.band is None else beyond))
    result = FrequencyResponse(_data_set(about, settings, found, (poles, residues), notes, attributes))
    if found.stopped:
        raise SolveError(text, result)
    return result


def _require_response(about: LinearAbout, settings: ResponseSettings, low: float, high: float) -> None:
    """Refuse frequencies between ``low`` and ``high`` [Hz] at which there is no response."""
    _require_known(about, low, high)
    _require_moving(settings, low)
    if low == 0.0 and about.loose:
        raise SolveError(
            f"There is no response at 0 Hz: nothing holds the model against {', '.join(about.loose)}; add supports, "
            "or give frequencies > 0"
        )


def _doubts(poles: Poles, *, in_band: bool) -> list[str]:
    """Return what the poles say against a response, in sentences.

    Args:
        in_band: lines follow it all over a band.
    """
    notes = []
    if not poles.complete:
        notes.append("not all resonances of this band were sought: narrow peaks may be missing")
    growing = poles.roots[poles.roots.real > GROWS * np.abs(poles.roots)]
    if len(growing):
        notes.append(
            f"a small motion at {abs(growing[0]) / (2.0 * np.pi):.6g} Hz grows by itself (s = {growing[0]:.5g} 1/s): "
            "the response is that of the equations, and no motion settles to it"
        )
    sharp = poles.roots[np.abs(poles.roots.real) <= GROWS * np.abs(poles.roots)]
    if in_band and len(sharp):
        first = np.abs(sharp.imag).min() / (2.0 * np.pi)
        notes.append(
            f"nothing damps the vibration at {first:.6g} Hz: a response has no bound there, and no lines follow it"
        )
    return notes


def _looked_at(low: float, high: float, roots: np.ndarray) -> Floats:
    """Return frequencies [Hz] at which one sees what answers at all: both ends, and beside resonances."""
    resonances = np.sort(np.abs(roots.imag)) / (2.0 * np.pi)
    inside = BESIDE * resonances[(resonances > low) & (resonances < high)]
    chosen = np.unique(np.linspace(0, max(len(inside) - 1, 0), LOOKS).round().astype(int))
    return np.unique([low, *(inside[chosen] if len(inside) else ()), high])


def _watched(
    solve: Callable[[float], np.ndarray], silent: np.ndarray, stop: Callable[[], str] | None
) -> Callable[[float], np.ndarray]:
    """Return ``solve`` that ends where something asks for it before a frequency; ``silent`` responses are 0."""

    def at(hertz: float) -> np.ndarray:
        reason = stop() if stop is not None else ""
        if reason:
            raise StoppedError(reason)
        return np.where(silent, 0.0, solve(hertz))

    return at


def _at_given(
    solve: Callable[[float], np.ndarray], hertz: Floats, told: Callable[[float, float], None] | None
) -> Followed:
    """Return the responses at given frequencies [Hz], as many as there are until something asks to stop."""
    values: list[np.ndarray] = []
    stopped, before = "", 0.0
    try:
        for f in map(float, hertz):
            values.append(solve(f))
            step, before = f - before, f
            if told is not None:
                told(f, step)
    except (StoppedError, KeyboardInterrupt) as asked:
        stopped = reason_of(asked)
    return Followed(hertz[: len(values)], np.array(values), 0.0, before, stopped)


@dataclass(frozen=True)
class ModalResponse:
    """Responses in few modes with static correction.

    Attributes:
        system: in these coordinates; modes: how many are modes.
    """

    system: SecondOrder
    modes: int

    @classmethod
    def of(cls, about: LinearAbout, highest: float) -> ModalResponse:
        """Return it with the modes up to twice the ``highest`` frequency [Hz]."""
        system, _ = second_order(about.small, about.inputs, about.readings)
        count = 8
        while True:
            basis, omega = modal_basis(system, min(count, system.size), len(about.loose))
            if omega[-1] > FURTHER * 2.0 * np.pi * highest or count >= system.size:
                return cls(system.within(basis), len(omega))
            count *= 2

    def at(self, hertz: float) -> np.ndarray:
        """Return the responses ``(outputs, inputs)`` at a frequency [Hz]."""
        return self.system.response(hertz)

    def error(self, exact: HarmonicResponse, low: float, high: float, poles: np.ndarray) -> float:
        """Return the largest difference from the direct responses at some frequencies, as a part of the largest."""
        resonances = poles.imag / (2.0 * np.pi)
        inside = resonances[(resonances > low) & (resonances < high)]
        hertz = np.unique(np.concatenate([np.linspace(low, high, COMPARED), inside]))
        direct = exact.over(hertz)
        found = np.array([self.at(float(f)) for f in hertz])
        sizes = self.system.sizes(direct, np.array([*inside[:COMPARED], high]))
        return float((np.abs(found - direct) / sizes).max())


def with_inputs(model: ModelDescription, settings: object) -> ModelDescription:
    """Return the model with the loads of the inputs, if the settings have some."""
    return (
        with_input_loads(model, settings)
        if isinstance(settings, ResponseSettings | PeriodicSettings)
        else model
    )


def _require_known(about: LinearAbout, low: float, high: float) -> None:
    """Refuse frequencies at which a modulus was not measured."""
    band, slack = about.small.band, 1e-9
    if band is not None and not (band[0] * (1.0 - slack) <= low and high <= band[1] * (1.0 + slack)):
        raise InputError(
            Fault(
                "frequencies",
                f"{low:.6g} to {high:.6g} Hz",
                f"the moduli of the materials were measured from {band[0]:.6g} to {band[1]:.6g} Hz only",
                "stay within, or take the fitted law: moduli = 'law'",
            )
        )


def _require_moving(settings: ResponseSettings, low: float) -> None:
    """Refuse the response to a constant velocity or acceleration."""
    for k, one in enumerate(settings.inputs):
        if low == 0.0 and isinstance(one, MotionInput) and one.derivative:
            raise InputError(
                Fault(
                    f"inputs[{k}]",
                    repr(one.label),
                    "at 0 Hz a velocity or an acceleration moves everything without end",
                    "give a displacement, or frequencies > 0",
                )
            )


def _beyond(about: LinearAbout, low: float, high: float) -> list[str]:
    """Say where a constant loss factor is taken beyond the band over which it was said to hold."""
    slack = 1e-9
    if about.holds is None or (
        about.holds[0] * (1.0 - slack) <= low and high <= about.holds[1] * (1.0 + slack)
    ):
        return []
    return [
        f"a constant loss factor is taken from {low:.6g} to {high:.6g} Hz, and it was said to hold from "
        f"{about.holds[0]:.6g} to {about.holds[1]:.6g} Hz only"
    ]


def _data_set(
    about: LinearAbout,
    settings: ResponseSettings,
    found: Followed,
    roots: tuple[Poles, np.ndarray],
    notes: list[str],
    attributes: dict[str, float],
) -> xr.Dataset:
    """Return the data set of responses at their frequencies; ``roots`` are the poles and their residues."""
    import xarray as xr

    poles, residues = roots
    hertz, values, discrete = found.hertz, found.responses, about.discrete
    earlier = json.loads(discrete.attributes.get("warnings", "[]"))
    attrs = discrete.complete(
        {
            "kind": FrequencyResponse.kind,
            "outcome": "interrupted" if found.stopped else "completed",
            "about": about.text,
            "moduli": settings.moduli,
            "moduli_from": json.dumps(about.moduli),
            "nodes": discrete.problem.size,
            "warnings": json.dumps([*earlier, *notes]),
            **attributes,
        }
    )
    return xr.Dataset(
        {
            "response": (
                ("frequency", "output", "input", "part"),
                np.stack([values.real, values.imag], axis=-1),
            ),
            "input_unit": ("input", np.array([one.unit for one in settings.inputs], dtype=str)),
            "output_unit": ("output", np.array([one.unit for one in settings.outputs], dtype=str)),
            "pole": (("mode", "part"), np.column_stack([poles.roots.real, poles.roots.imag])),
            "residue": (
                ("mode", "output", "input", "part"),
                np.stack([residues.real, residues.imag], axis=-1),
            ),
            "pole_name": ("mode", np.array(poles.names, dtype=str)),
        },
        {
            "frequency": hertz,
            "output": [one.label for one in settings.outputs],
            "input": [one.label for one in settings.inputs],
            "part": ["real", "imaginary"],
        },
        attrs,
    )

"""How frequency responses change with numbers of the case: one more solution at every frequency.

With ``A(s) x = b`` (conditions border it) and ``y = c x``, ``A dx = db - dA x`` and ``dy = dc x + c dx``. What stands
there with a d is the derivative of the matrices along the state, which changes too; ``A`` is factorised once more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from viscorod.analyses.derivatives.eigenvalues import Pencil, groups_of
from viscorod.analyses.derivatives.neighbours import Neighbours
from viscorod.analyses.derivatives.static_changes import Instant, StaticChange
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.linear_about import linear_about, placed_outputs
from viscorod.errors import Fault, InputError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.derivative import Derivative, Part
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.solve.formulations.system import State
from viscorod.solve.linear_systems.harmonic_response import HarmonicResponse
from viscorod.solve.linear_systems.measured_moduli import MeasuredParts, measured_parts
from viscorod.solve.linear_systems.ports import inputs_of
from viscorod.solve.linear_systems.readings import readings_of
from viscorod.solve.linear_systems.small_motions import small_motions
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.signals import LoadInput

__all__ = ["response_derivatives"]


def response_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: ResponseSettings,
    result: FrequencyResponse,
    keys: Sequence[str],
) -> dict[str, Derivative[FrequencyResponse]]:
    """Return the derivatives of responses at all frequencies, and of the poles."""
    if not isinstance(settings.about, str):
        why = "responses about an earlier state have no derivatives here"
        raise InputError(Fault("derivatives", ", ".join(keys), why, "give about as a word"))
    measured = settings.moduli == "measured"
    about = linear_about(discrete, settings, measured=measured)
    at = Instant(before=about.before, scale=about.scale)
    loaded = settings.about != "reference" and not discrete.static.loads.at(0.0, at.before).none
    change = StaticChange(discrete, about.state, at) if loaded else None
    base = _responses(discrete, settings, about.state, at)
    places = [2j * np.pi * float(f) for f in result.frequencies]
    motions = np.array([base.motion(s) for s in places])
    poles = result.poles
    pencil = Pencil(base.small)
    vectors = (
        []
        if base.small.measured
        else [
            (group, *pencil.vectors(complex(poles[group].mean()), len(group))) for group in groups_of(poles)
        ]
    )
    every, lacking, of_poles = [], [], []
    for key in keys:
        neighbours = Neighbours.of(model, key, discrete)
        increment = None if change is None else change.increment(neighbours)
        each = []
        for one in neighbours.each:
            if change is None or increment is None:
                state = State.reference(one.problem)
            else:
                state = change.moved(increment, one.change)
                one.system.constraints.near[:] = discrete.system.constraints.near
            each.append((one.weight, _responses(one.discrete, settings, state, at)))
        every.append(neighbours)
        lacking.append(_Lacking.of(each, places, motions))
        pencils = [(weight, Pencil(response.small)) for weight, response in each] if vectors else []
        slopes = np.full(len(poles), np.nan + 0j)
        for group, s, right, left, slope in vectors:
            changed = sum(weight * other.times(s, right) for weight, other in pencils)
            slopes[group] = -np.trace(np.linalg.solve(slope, left.conj().T @ changed)) / len(group)
        of_poles.append(slopes)
    responses = _rates(base, lacking, places, motions)
    return {
        neighbours.number.key: _derivative(neighbours, result, _Rates(*rates))
        for neighbours, *rates in zip(every, responses, of_poles, strict=True)
    }


class _Rates(NamedTuple):
    """Derivatives of responses ``(frequencies, outputs, inputs)`` and of poles ``(poles,)``, complex."""

    responses: np.ndarray
    poles: np.ndarray


def _responses(
    discrete: DiscreteModel, settings: ResponseSettings, state: State, at: Instant
) -> HarmonicResponse:
    """Return the responses of a model about a state."""
    first = len(discrete.model.loads) - sum(isinstance(one, LoadInput) for one in settings.inputs)
    parts = MeasuredParts()
    if settings.moduli == "measured":
        parts = measured_parts(discrete.model, discrete.problem, discrete.system.gauss_positions())
    small = small_motions(discrete.static, state, parts.parts, before=at.before, scale=at.scale)
    inputs = inputs_of(discrete.static, small, settings.inputs, first)
    readings = readings_of(discrete.static, small, placed_outputs(discrete, settings), inputs)
    return HarmonicResponse(small, inputs, readings)


class _Lacking(NamedTuple):
    """What motions lack, and outputs see of them, per unit of a number that changes the model and not the motions.

    Attributes:
        right, gaps: of the balance and of conditions ``(frequencies, n or m, inputs)``.
        own: change of the outputs ``(frequencies, outputs, inputs)``.
    """

    right: np.ndarray
    gaps: np.ndarray
    own: np.ndarray

    @classmethod
    def of(
        cls,
        each: Sequence[tuple[float, HarmonicResponse]],
        places: Sequence[complex],
        motions: np.ndarray,
    ) -> _Lacking:
        """Return it of responses of neighbours, with their weights."""
        left = [(weight, response.lacking(places, motions)) for weight, response in each]
        right, gaps = (np.asarray(sum(weight * parts[k] for weight, parts in left)) for k in (0, 1))
        own: Any = sum(
            weight * np.array([response.read(s, x) for s, x in zip(places, motions, strict=True)])
            for weight, response in each
        )
        return cls(right, gaps, np.asarray(own))


def _rates(
    base: HarmonicResponse, lacking: Sequence[_Lacking], places: Sequence[complex], motions: np.ndarray
) -> np.ndarray:
    """Return the derivatives of the responses ``(keys, frequencies, outputs, inputs)``.

    The dynamic stiffness is factorised once at a frequency, for all numbers.
    """
    found = np.array([one.own for one in lacking])
    for k, (s, x) in enumerate(zip(places, motions, strict=True)):
        right, gaps = (np.concatenate([one[i][k] for one in lacking], axis=1) for i in (0, 1))
        moved, still = base.solve(s, right, gaps), base.read(s, np.zeros_like(x))
        for rates, change in zip(found, np.split(moved, len(lacking), axis=1), strict=True):
            rates[k] += base.read(s, change) - still
    return found


def _derivative(
    neighbours: Neighbours, result: FrequencyResponse, rates: _Rates
) -> Derivative[FrequencyResponse]:
    """Return the derivative from responses to first order; residues have none here."""
    number, parts = neighbours.number, []
    for one in neighbours.each:
        values = result.values + one.change * rates.responses
        poles = result.poles + one.change * rates.poles
        near = FrequencyResponse.__new__(FrequencyResponse)
        near.data = result.data.assign(
            response=(result.data["response"].dims, np.stack([values.real, values.imag], axis=-1)),
            pole=(("mode", "part"), np.column_stack([poles.real, poles.imag])),
            residue=(result.data["residue"].dims, np.full(result.data["residue"].shape, np.nan)),
        )
        parts.append(Part(one.weight, one.change, near))
    return Derivative(number.key, number.value, number.unit, result, parts)

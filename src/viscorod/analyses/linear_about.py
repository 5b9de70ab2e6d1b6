"""A model made linear about a state, with inputs and outputs: what linear systems and responses start from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium_near, find_initial_equilibrium
from viscorod.analyses.start_state import StartState
from viscorod.errors import Fault, InputError
from viscorod.model.actions.time_function import Constant
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.formulations.system import State
from viscorod.solve.linear_systems.measured_moduli import measured_parts
from viscorod.solve.linear_systems.ports import Inputs, inputs_of
from viscorod.solve.linear_systems.readings import Reading, Readings, readings_of
from viscorod.solve.linear_systems.small_motions import SmallMotions, small_motions
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.settings.response import LinearSettings, ResponseSettings
from viscorod.solve.settings.signals import LoadInput
from viscorod.solve.start import Start

__all__ = ["LinearAbout", "linear_about", "with_input_loads"]


@dataclass(frozen=True)
class LinearAbout:
    """A model made linear about a state.

    Attributes:
        discrete: the model, the loads of the inputs last among its own; state: about which it is.
        small: its motions; inputs, readings: what goes in and comes out.
        before, scale: of the loads, see ``linearise``.
        notes: what is uncertain, in sentences.
    """

    discrete: DiscreteModel
    state: State
    small: SmallMotions
    inputs: Inputs
    readings: Readings
    before: bool
    scale: float
    notes: tuple[str, ...]

    def linearisation(self) -> Linearisation:
        """Return the same motions as modes are found from, with the fitted laws."""
        return linearise(self.discrete.static, self.state, before=self.before, scale=self.scale)


def with_input_loads(
    model: ModelDescription, settings: LinearSettings | ResponseSettings
) -> ModelDescription:
    """Return the model with the loads of the inputs after its own, which do not act by themselves.

    Raises:
        InputError: the model has no such place, by the number of the input.
    """
    inputs = [(k, one) for k, one in enumerate(settings.inputs) if isinstance(one, LoadInput)]
    loads = [one.load.model_copy(update={"time": Constant(0.0), "until": None}) for _, one in inputs]
    faults = [
        Fault(f"inputs[{k}]", repr(one.label), error.why, error.instead)
        for (k, one), load in zip(inputs, loads, strict=True)
        for error in load.misfits(model)
    ]
    if faults:
        raise InputError(faults)
    parts: dict[str, Any] = model.parts() | {"loads": [*model.loads, *loads]}
    return type(model).of(**parts)


def linear_about(
    discrete: DiscreteModel, settings: LinearSettings | ResponseSettings, *, measured: bool
) -> LinearAbout:
    """Return a model made linear about the state that the settings name.

    Args:
        discrete: with the loads of the inputs (:func:`with_input_loads`); settings: of the analysis.
        measured: moduli come from tables where there are any.
    """
    discrete.require_independent()
    problem, model = discrete.problem, discrete.model
    before, scale = True, 1.0
    if isinstance(settings.about, Start):
        if StartState(discrete, settings.about).result.kind == "steady":
            raise InputError(
                Fault(
                    "about",
                    "a steady rotation",
                    "small motions about what turns are not those about an equilibrium",
                    "its modes are in Steady.modes; for responses about it compute the motion with simulate",
                )
            )
        state, _ = equilibrium_near(discrete, settings.about)
    else:
        state = State.reference(problem)
        before, loaded = settings.about != "released", settings.about != "reference"
        scale = float(loaded)
        if loaded:
            find_initial_equilibrium(discrete, state, before=before)
    notes = []
    parts, fitted = (
        measured_parts(model, problem, discrete.system.gauss_positions()) if measured else ([], [])
    )
    if fitted:
        notes.append(
            f"regions of composite sections have the laws that were fitted to their tables: {', '.join(fitted)}"
        )
    small = small_motions(discrete.static, state, parts, before=before, scale=scale)
    first = len(model.loads) - sum(isinstance(one, LoadInput) for one in settings.inputs)
    inputs = inputs_of(discrete.static, small, settings.inputs, first)
    readings = readings_of(discrete.static, small, _placed(discrete, settings), inputs)
    return LinearAbout(discrete, state, small, inputs, readings, before, scale, tuple(notes))


def _placed(discrete: DiscreteModel, settings: LinearSettings | ResponseSettings) -> list[Reading]:
    """Return the outputs with their places in the mesh.

    Raises:
        InputError: there is no such place, by the number of the output.
    """
    found = []
    for k, output in enumerate(settings.outputs):
        try:
            place = discrete.place(output.place)
        except InputError as error:
            raise InputError(Fault(f"outputs[{k}]", repr(output.label), str(error), "give a place")) from None
        rod = discrete.problem.rods.index(place.rod) if place.rod in discrete.problem.rods else -1
        found.append(Reading(output, place.stations, place.weights, rod, place.s))
    return found

"""A model made linear about a state, with inputs and outputs: what linear systems and responses start from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium_near, find_initial_equilibrium
from viscorod.analyses.start_state import StartState, require_still
from viscorod.errors import Fault, InputError
from viscorod.model.actions.time_function import Constant
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.steady_result import Steady
from viscorod.solve.formulations.system import State
from viscorod.solve.linear_systems.measured_moduli import MeasuredParts, measured_parts
from viscorod.solve.linear_systems.poles import Poles, poles_about_rotation, poles_below
from viscorod.solve.linear_systems.ports import Inputs, inputs_of
from viscorod.solve.linear_systems.readings import Reading, Readings, readings_of
from viscorod.solve.linear_systems.small_motions import SmallMotions, motions_about_rotation, small_motions
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import LinearSettings, ResponseSettings
from viscorod.solve.settings.signals import LoadInput
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.start import Start
from viscorod.solve.steady.geometric_steady import GeometricSteady
from viscorod.solve.steady.rotation_search import Search as RotationSearch
from viscorod.solve.steady.steady_checks import SupportKind, require_steady, support_kind

__all__ = ["LinearAbout", "linear_about", "placed_outputs", "with_input_loads"]


@dataclass(frozen=True)
class LinearAbout:
    """A model made linear about a state.

    Attributes:
        discrete: the model, the loads of the inputs last among its own; state: about which it is, in words ``text``.
        small: its motions; inputs, readings: what goes in and comes out.
        before, scale: of the loads, see ``linearise``; rotation: of a state that turns steadily.
        moduli: where moduli come from, in sentences; notes: what is uncertain, in sentences.
        holds: frequencies [Hz] between which constant loss factors were said to hold; None without any.
    """

    discrete: DiscreteModel
    state: State
    text: str
    small: SmallMotions
    inputs: Inputs
    readings: Readings
    before: bool
    scale: float
    rotation: GeometricSteady | None
    moduli: tuple[str, ...]
    notes: tuple[str, ...]
    holds: tuple[float, float] | None

    @cached_property
    def _linearisation(self) -> Linearisation:
        """The same motions as modes are found from, with the fitted laws."""
        return linearise(self.discrete.static, self.state, before=self.before, scale=self.scale)

    @property
    def loose(self) -> tuple[str, ...]:
        """Motions that nothing resists at 0 Hz, in words."""
        if self.rotation is None:
            return self._linearisation.texts if self._linearisation.rigid else ()
        return ("turning about the axis",) if self.rotation.may_be_copied else ()

    def poles(self, hertz: float) -> Poles:
        """Return the poles with natural frequencies up to ``hertz``, and the next one."""
        static = self.discrete.static
        if self.rotation is not None:
            return poles_about_rotation(static, self.rotation, self.small, hertz)
        return poles_below(static, self.state, self._linearisation, self.small, hertz)


def with_input_loads(
    model: ModelDescription, settings: LinearSettings | ResponseSettings | PeriodicSettings
) -> ModelDescription:
    """Return the model with the loads of the inputs after its own, which do not act by themselves.

    Raises:
        InputError: the model has no such place, by the number of the input.
    """
    inputs = [(k, one) for k, one in enumerate(settings.inputs or ()) if isinstance(one, LoadInput)]
    loads = [one.load.model_copy(update={"time": Constant(0.0), "until": None}) for _, one in inputs]
    faults = [
        Fault(f"inputs[{k}]", repr(one.label), error.why, error.instead)
        for (k, one), load in zip(inputs, loads, strict=True)
        for error in load.misfits(model)
    ]
    if faults:
        raise InputError(faults)
    parts: dict[str, Any] = model.parts() | {"loads": [*model.loads, *loads]}
    found = type(model).of(**parts)
    found.materials, found.sections = model.materials, model.sections  # by whose names derivatives are taken
    return found


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
    first = len(model.loads) - sum(isinstance(one, LoadInput) for one in settings.inputs)
    before, scale, rotation = True, 1.0, None
    text = _ABOUT.get(str(settings.about), "the equilibrium near an earlier state")
    if isinstance(settings.about, Start):
        start = StartState(discrete, settings.about)
        if start.result.kind == "steady":
            rotation = _rotation(discrete, start, settings.about, first)
            state = rotation.state().copy()
            text = f"the steady rotation at {rotation.rate:.6g} rad/s, in axes that turn with it"
        else:
            require_still(start)
            state, _, _ = equilibrium_near(discrete, settings.about)
            text = f"the equilibrium under the loads at t = 0- near {start.label}"
    else:
        state = State.reference(problem)
        before, loaded = settings.about != "released", settings.about != "reference"
        scale = float(loaded)
        if loaded:
            find_initial_equilibrium(discrete, state, before=before)
    found = measured_parts(model, problem, discrete.system.gauss_positions()) if measured else MeasuredParts()
    small = (
        small_motions(discrete.static, state, found.parts, before=before, scale=scale)
        if rotation is None
        else motions_about_rotation(discrete.static, rotation, found.parts)
    )
    inputs = inputs_of(discrete.static, small, settings.inputs, first)
    readings = readings_of(discrete.static, small, placed_outputs(discrete, settings), inputs)
    return LinearAbout(
        discrete,
        state,
        text,
        small,
        inputs,
        readings,
        before,
        scale,
        rotation,
        found.told,
        found.notes,
        found.holds,
    )


_ABOUT = {
    "equilibrium": "the equilibrium under the loads at t = 0-",
    "released": "the equilibrium once released, under the loads just after t = 0",
    "reference": "the reference shape, as if free of load",
}


def _rotation(discrete: DiscreteModel, start: StartState, about: Start, loads: int) -> GeometricSteady:
    """Return the steady rotation of the model with the spin of an earlier result, found from its state.

    Args:
        discrete: the model; start: the earlier state; about: how it was given; loads: how many of the model's act.

    Raises:
        InputError: there can be no such rotation. SolveError: none was found.
    """
    result, problem = start.result, discrete.problem
    assert isinstance(result, Steady)
    if result.damping == "linearised":
        raise InputError(
            Fault(
                "about",
                "a steady rotation with linearised damping",
                "linear systems have the full damping of the material",
                "compute it again without damping = 'linearised'",
            )
        )
    driven = support_kind(problem) is SupportKind.HELD or loads > 0
    turning: dict[str, Any] = {"spin": float(np.linalg.norm(result.spin))}
    if driven:
        turning = {"spin": tuple(result.spin.tolist()), "centre": tuple(result.centre.tolist())}
    chosen = SteadySettings(**turning, start=about)
    require_steady(discrete.model, problem, chosen, loads)
    found = RotationSearch(discrete.static, chosen, start.state).equations()
    assert isinstance(found, GeometricSteady)
    return found


def placed_outputs(
    discrete: DiscreteModel, settings: LinearSettings | ResponseSettings | PeriodicSettings
) -> list[Reading]:
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

"""How a steady rotation changes with numbers of the case: found again from it for the model's neighbours.

Newton's method starts a thousandth away and ends at round-off; what the neighbours differ by is extrapolated.
"""

from __future__ import annotations

from collections.abc import Sequence

from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.start_state import StartState
from viscorod.analyses.steady import steady_rotation
from viscorod.errors import InputError, SolveError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.derivative import Derivative, Part
from viscorod.results.steady_result import Steady
from viscorod.solve.formulations.system import State
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.start import Start

__all__ = ["steady_derivatives"]


def steady_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: SteadySettings,
    result: Steady,
    keys: Sequence[str],
) -> dict[str, Derivative[Steady]]:
    """Return the derivatives of a steady rotation and of the eigenvalues of its small motions."""
    state = StartState(discrete, Start(result=result)).state
    found = {}
    for key in keys:
        neighbours = Neighbours.of(model, key, discrete)
        number, parts = neighbours.number, []
        for one in neighbours.each:
            first = _held_as(one, state)
            try:
                near = steady_rotation(one.discrete, settings, first)
            except (InputError, SolveError) as error:
                raise SolveError(
                    f"The steady rotation has no derivative by {key}: it was not found for a slightly different "
                    f"number. {error}"
                ) from None
            parts.append(Part(one.weight, one.change, near))
        found[key] = Derivative(number.key, number.value, number.unit, result, parts)
    return found


def _held_as(one: Neighbour, state: State) -> State:
    """Return a state with the poses that a neighbour has where it is held: twists and strains do not tell them."""
    found, problem = state.copy(), one.problem
    for node, fixed in zip(problem.supports.nodes, problem.supports.fixed, strict=True):
        if fixed[:3].all():
            found.r[node] = problem.positions[node]
        if fixed.all():
            found.q[node] = problem.quaternions[node]
    return found

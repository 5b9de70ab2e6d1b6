"""Time integrators by name, and what each of them can do. A new one adds a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from viscorod.solve.deferred import deferred

if TYPE_CHECKING:
    from viscorod.solve.transient.integrators.contract import Integrator

__all__ = ["INTEGRATORS", "Method", "integrators_that"]


class Method(NamedTuple):
    """What a time integrator can do, for the settings, the analyses and the tests.

    Attributes:
        make: returns the :class:`~viscorod.solve.transient.integrators.contract.Integrator`:
            ``make(system, supports, **given)``, with the parameters and the tolerance, if there is one.
        title: in messages, such as "the midpoint rule".
        order: of accuracy in time, of smooth motions, with its parameters unless given.
        adaptive: it estimates its error, so that steps can follow a tolerance.
        tolerance: unless given; None: steps are equal without one.
        formulations: which ones it integrates.
        velocity_supports: it holds velocities along moving axes.
        parameters: settings that are its own, with their values unless given.
        make_linear: as ``make``, for linear dynamics; None: it has nonlinear dynamics only.
        make_reduced: likewise of a :class:`~viscorod.solve.reduced.reduced_model.ReducedModel`, for motions in modes:
            ``make_reduced(model, **given)``.
    """

    make: Callable[..., Integrator]
    title: str
    order: int
    adaptive: bool = False
    tolerance: float | None = None
    formulations: tuple[str, ...] = ("geometric", "intrinsic")
    velocity_supports: bool = True
    parameters: Mapping[str, float] = MappingProxyType({})
    make_linear: Callable[..., Integrator] | None = None
    make_reduced: Callable[..., Integrator] | None = None

    def order_with(self, parameters: Mapping[str, float]) -> int:
        """Return the order with other values of its parameters."""
        stages = parameters.get("stages")
        return self.order if stages is None else 2 * int(stages) - 1


INTEGRATORS: dict[str, Method] = {
    "radau": Method(
        deferred("transient.integrators.radau:Radau"),
        "Radau IIA",
        order=5,
        adaptive=True,
        tolerance=1e-4,
        parameters={"stages": 3},
        make_linear=deferred("transient.integrators.linear_motion:linear_radau"),
        make_reduced=deferred("reduced.reduced_motion:reduced_radau"),
    ),
    "generalized_alpha": Method(
        deferred("transient.integrators.generalized_alpha:GeneralizedAlpha"),
        "generalised-alpha",
        order=2,
        adaptive=True,
        formulations=("geometric",),
        velocity_supports=False,
        parameters={"spectral_radius": 0.6},
    ),
    "midpoint": Method(
        deferred("transient.integrators.midpoint:Midpoint"),
        "the midpoint rule",
        order=2,
        make_linear=deferred("transient.integrators.linear_motion:linear_midpoint"),
        make_reduced=deferred("reduced.reduced_motion:reduced_midpoint"),
    ),
}


def integrators_that(can: Callable[[Method], object]) -> str:
    """Return the names of the integrators that can do something, for messages: "'radau' or 'midpoint'"."""
    return " or ".join(repr(name) for name, method in INTEGRATORS.items() if can(method))

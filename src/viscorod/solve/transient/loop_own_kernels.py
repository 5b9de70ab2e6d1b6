"""Kernels of the compiled loop of steps that only models with joints, or some moving supports, need."""

from __future__ import annotations

from collections.abc import Callable

from viscorod.mechanics.compilation.by_address import address_of
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
from viscorod.solve.transient.integrators import kernel_results, loop_links, loop_moving_supports
from viscorod.solve.transient.integrators.loop_data import StepLoop
from viscorod.solve.transient.integrators.radau import Radau

__all__ = ["find_own", "own_kernels"]

Kernels = dict[str, tuple[Callable[..., object], tuple[object, ...]]]
"""Kernels by their names among the addresses, with arguments that they have behind the loop."""

LINK_KERNELS: Kernels = {
    "drive_links": (loop_links.drive, (0.0, False, 0)),
    "linearise_links": (loop_links.linearise, (True,)),
    "predict_links": (loop_links.predict, (0.0,)),
    "keep_links": (loop_links.keep, ()),
    "read_links": (loop_links.read, (0,)),
    "close_within": (loop_links.within, (0, 0, 0)),
}
"""Those that models with joints or held strains need."""
MOVING_KERNELS: Kernels = {
    "prescribe_start": (loop_moving_supports.prescribe_start, ()),
    "turn_alone": (loop_moving_supports.turn_alone, ()),
    "correct_within": (loop_moving_supports.correct_within, (0, 0, 0)),
}
"""Those of moving supports that hold nodes in part."""


def own_kernels(integrator: Radau) -> Kernels:
    """Return the kernels of the loop that only some models need, by their names, and arguments behind the loop."""
    supports = integrator.supports
    found = LINK_KERNELS if integrator.stage_constraints is not None else {}
    return found | MOVING_KERNELS if supports.moving and len(supports.partial) else found


def find_own(kernels: Kernels, loop: Shared[StepLoop]) -> dict[str, int]:
    """Return where kernels of the loop are that only some models need."""

    def address(kernel: Callable[..., object], *arguments: object) -> int:
        return address_of(KnownTypes(kernel), kernel_results.NOTHING, lambda: arguments)

    return {name: address(kernel, loop.argument, *rest) for name, (kernel, rest) in kernels.items()}

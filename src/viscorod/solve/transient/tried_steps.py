"""Steps that are computed again in halves: where the step and its halves come to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.typing import Floats

__all__ = ["Reached", "Several", "TriedStep"]


class Reached(NamedTuple):
    """A state, and the section forces ``(m, 6)`` in it."""

    state: State
    section_force: Floats

    @classmethod
    def at(cls, integrator: Integrator) -> Reached:
        """Return where an integrator is, in arrays of its own: the integrator goes on."""
        return cls(integrator.state.copy(), integrator.section_force.copy())


class TriedStep(NamedTuple):
    """A step that was computed again in halves.

    Attributes:
        end, h: when it ends, and its length [s]; before: body twists at its start ``(n, 6)``.
        middle, whole: by the step itself, at its middle and at its end; better_middle, better: by the halves.
    """

    end: float
    h: float
    before: Floats
    middle: Reached
    whole: Reached
    better_middle: Reached
    better: Reached


class Several(NamedTuple):
    """Several states ``(k, n, ...)``, and the section forces in them ``(k, m, 6)``."""

    r: Floats
    q: Floats
    twist: Floats
    section_force: Floats

    @classmethod
    def of(cls, reached: tuple[Reached, ...]) -> Several:
        """Copy states, one after the other, into arrays of all."""
        fields = [(state.r, state.q, state.twist, force) for state, force in reached]
        return cls(*(np.array(rows) for rows in zip(*fields, strict=True)))

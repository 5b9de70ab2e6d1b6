"""Strains and internal forces of a moving body in both formulations, for collocation methods.

The geometric formulation computes strains from poses. The intrinsic one keeps them as states at the Gauss points, which
the twists move; it takes them from the poses once, at the beginning of a run.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements, ElementWork, GaussStates, internal_forces
from viscorod.mechanics.elements.intrinsic_element import StrainMotion, forces_at
from viscorod.mechanics.elements.intrinsic_linearised import linearise_intrinsic
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.elements.rest_strains import deduct_rest
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.formulations.system import State, System
from viscorod.typing import Floats


class ElementForces(Protocol):
    """Internal forces of a moving body."""

    @property
    def motion(self) -> StrainMotion | None:
        """Strains as states of the compiled step; None if they follow from poses."""

    def evaluate(self, state: State, points: GaussStates, internal: Floats) -> None:
        """Write the Gauss points ``(1, e, points, 6)`` and the internal forces ``(n, 6)`` of ``state``."""

    def linearise(
        self, state: State, ad: Floats, stress: Floats, operators: Operators, K: Floats, C: Floats
    ) -> None:
        """Write the operators and add to the blocks ``K`` and ``C`` of the Jacobian at ``state``.

        Args:
            ad: ``ad(x1)`` of every node ``(n, 6, 6)``; stress: section forces ``(e, points, 6)``.
        """

    def set_strains(self, strain: Floats) -> None:
        """Set the strains ``(e, points, 6)`` from which the next step starts."""

    def extrapolate_strains(self, middle: Floats) -> None:
        """Set the strains at the end of a step from those in its middle, by linear extrapolation."""

    def take_rest(self, rest: Floats, rate: Floats) -> None:
        """Take the arrays ``(s, e, points, 6)`` of rest strains that change with time, and of their rates, of stages.

        The strains that are set contain them.
        """


def branch_forces(relaxation: DashpotMemory | None, strain: Floats) -> Floats:
    """Return the forces of Maxwell branches at ``strain (e, points, 6)``, in which a motion begins relaxed."""
    if relaxation is None:
        return np.zeros_like(strain)
    relaxation.begin(strain)
    return relaxation.force(strain)


class GeometricForces:
    """Internal forces of the geometric formulation, whose strains follow from poses."""

    motion = None

    def __init__(self, system: System, elements: Elements) -> None:
        self.system, self.elements = system, elements
        self._work = ElementWork.of(elements.nodes.shape[1] - 1)

    def evaluate(self, state: State, points: GaussStates, internal: Floats) -> None:
        """See :class:`ElementForces`."""
        where = state.r[None], state.q[None], state.twist[None]
        internal_forces(self.elements, *where, points, self._work, internal[None])
        held, relaxation = self.system.problem.held, self.system.relaxation
        driven = self.system.rest if self.system.imposed.changes else None
        if not len(held.place) and relaxation is None and driven is None:
            return
        if driven is not None:
            deduct_rest(self.elements, *driven, points)
        # once more, with the section forces that need the strains, and multipliers for those that no law gives
        points.stress[:] = points.section_force
        points.stress[0] += branch_forces(relaxation, points.strain[0])
        forces = state.multiplier[held.place] / held.weight
        points.stress[0, held.element, held.point, held.component] = forces
        internal_forces(self.elements, *where, points, self._work, internal[None])
        if driven is not None:
            deduct_rest(self.elements, *driven, points)
        points.section_force[:] = points.stress

    def linearise(
        self, state: State, ad: Floats, stress: Floats, operators: Operators, K: Floats, C: Floats
    ) -> None:
        """See :class:`ElementForces`."""
        self.system.linearise(state, ad, stress, operators, K, C)

    def set_strains(self, strain: Floats) -> None:
        """Do nothing: strains follow from poses."""

    def extrapolate_strains(self, middle: Floats) -> None:
        """Do nothing: strains follow from poses."""

    def take_rest(self, rest: Floats, rate: Floats) -> None:
        """Do nothing: a step deducts them from strains that follow from poses."""


class IntrinsicForces:
    """Internal forces of the intrinsic formulation, whose strains are states.

    Args:
        system: whose statics give the first strains; elements: its elements.
        stages: of a step.
        linearised: damping is that of AWP (22), else the full one of AWP (13).
    """

    def __init__(self, system: System, elements: Elements, stages: int, *, linearised: bool) -> None:
        self.system, self.elements = system, elements
        self.motion = StrainMotion.of(elements, stages, linearised=linearised)
        self._now = StrainMotion.of(elements, 1, linearised=linearised)
        self._known = False
        if len(system.problem.held.place):
            system.constraints.strains_as_states = self.strains_at

    def evaluate(self, state: State, points: GaussStates, internal: Floats) -> None:
        """See :class:`ElementForces`."""
        if not self._known:
            self._begin(state, points, internal)
        held = self.system.problem.held
        points.strain[0] = self.motion.start - self._rest()
        prestress = branch_forces(self.system.relaxation, points.strain[0])
        prestress[held.element, held.point, held.component] += state.multiplier[held.place] / held.weight
        now = self._at_rest(self._now)
        forces_at(
            self.elements,
            now,
            state.twist[None],
            points.strain,
            points.strain_rate,
            prestress,
            points.section_force,
            internal[None],
        )
        points.stress[:] = points.section_force

    def _begin(self, state: State, points: GaussStates, internal: Floats) -> None:
        """Take the first strains from the poses, or those that are given; held ones are exactly zero."""
        held = self.system.problem.held
        GeometricForces(self.system, self.elements).evaluate(state, points, internal)
        strain = points.strain[0]
        if self.system.given_strain is not None:
            strain.reshape(-1, 6)[self.system.gauss_indices()] = self.system.given_strain
        strain[held.element, held.point, held.component] = 0.0
        self.set_strains(strain + self._rest())

    def strains_at(self, state: State) -> tuple[Floats, Floats]:
        """Return the present strains and how fast the twists of ``state`` change them ``(1, e, points, 6)``."""
        shape, exact = self.elements.reference.shape, self._at_rest(self._now._replace(linearised=False))
        if not self._known:
            self._begin(state, GaussStates.of(self.elements, 1, carried=True), np.zeros_like(state.twist))
        strain, rate, unused = (self.motion.start - self._rest())[None], *np.zeros((2, 1, *shape))
        none = np.zeros(shape)
        forces_at(
            self.elements,
            exact,
            state.twist[None],
            strain,
            rate,
            none,
            unused,
            np.zeros((1, *state.twist.shape)),
        )
        return strain, rate

    def linearise(
        self, state: State, ad: Floats, stress: Floats, operators: Operators, K: Floats, C: Floats
    ) -> None:
        """See :class:`ElementForces`."""
        now, rate = self._now, np.zeros((1, *stress.shape))
        forces_at(
            self.elements,
            now,
            state.twist[None],
            self.motion.start[None],
            rate,
            np.zeros_like(stress),
            np.zeros_like(rate),
            np.zeros((1, *state.twist.shape)),
        )
        rest = self._rest()
        linearise_intrinsic(
            self.elements._replace(reference=self.elements.reference + rest),
            now.linearised,
            self.motion.start - rest,
            now.twist[0],
            rate[0],
            ad,
            stress,
            operators,
            K,
            C,
        )

    def set_strains(self, strain: Floats) -> None:
        """See :class:`ElementForces`."""
        self.motion.start[:] = strain
        self._known = True

    def extrapolate_strains(self, middle: Floats) -> None:
        """See :class:`ElementForces`."""
        self.set_strains(2.0 * middle - self.motion.start)

    def take_rest(self, rest: Floats, rate: Floats) -> None:
        """See :class:`ElementForces`."""
        self.motion = self.motion._replace(rest=rest, rest_rate=rate)

    def _at_rest(self, motion: StrainMotion) -> StrainMotion:
        """Return scratch for one state with the rest strains of the present time, where these change."""
        if not self.system.imposed.changes:
            return motion
        rest, rate = self.system.rest
        return motion._replace(rest=rest, rest_rate=rate)

    def _rest(self) -> Floats | float:
        """Return the rest strains that change, at the time that the system has."""
        return self.system.rest[0][0] if self.system.imposed.changes else 0.0

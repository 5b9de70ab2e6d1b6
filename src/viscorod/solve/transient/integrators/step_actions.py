"""Loads and prescribed motions during a step, evaluated into the arrays that kernels read."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.problem.external_loads import ExternalLoads, LoadState, load_count
from viscorod.solve.transient.integrators.stage_data import Discretisation, StageLoads, SupportMotion
from viscorod.solve.transient.load_content import StepContent
from viscorod.typing import Floats


class StepActions:
    """Loads and prescribed motions of a run.

    Args:
        system, supports: the model; body: the same for kernels.
        stages: of the method.

    Attributes:
        motion, stage_loads: prescribed motions and loads at the stages of the step that is prepared.
        content: of the steps, where anything has to be looked for.
    """

    def __init__(self, system: System, supports: SupportState, body: Discretisation, stages: int) -> None:
        self.system, self.supports, self.body = system, supports, body
        self.loads = ExternalLoads(system.problem)
        self.motion = SupportMotion.of(stages, body)
        self.stage_loads = StageLoads.of(
            stages,
            body,
            len(system.problem.station_loads),
            self.loads.motion,
            offset=self.loads.offset,
        )
        self.content: StepContent | None = None
        self._count = load_count(system.problem)
        self._rest: ExternalLoads | None = None
        self._written: list[LoadState | None] = [None] * stages

    def look_within(self, start: float, end: float) -> None:
        """Look at what loads and motions do within the step from ``start`` to ``end`` [s]; before :meth:`prepare`."""
        if self.content is not None:
            self.content.look(start, end)

    def means(self, i: int) -> dict[int, float] | None:
        """Return the factors at stage ``i`` of loads that are records, by number; None if nothing is looked at."""
        return None if self.content is None else {k: float(v[i]) for k, v in self.content.courses.items()}

    def unseen(self, t: float, state: State) -> Floats | None:
        """Return what loads do between the stages, as forces ``(n, 6)`` in body components; None: nothing."""
        if self.content is None or not self.content.rest:
            return None
        factors = dict.fromkeys(range(self._count), 0.0) | self.content.rest
        external = np.zeros_like(state.twist)
        if self._rest is None:
            self._rest = ExternalLoads(self.system.problem)
        self._add(self._rest.at(t, given=factors), state, external)
        return external

    def prepare(self, i: int, t: float, *, before: bool) -> None:
        """Evaluate loads and prescribed motions of stage ``i`` at time ``t`` [s]; ``before``: limits from the left."""
        motion, given, supports = self.motion, self.stage_loads, self.supports
        if supports.moving:
            supports.update(t, before)
            motion.target[i], motion.rate[i] = supports.target, supports.rate
            c = supports.complete
            if len(c):
                r, q, twist, rate = supports.complete_motion()
                motion.r[i, c], motion.q[i, c], motion.twist[i, c], motion.twist_rate[i, c] = (
                    r,
                    q,
                    twist,
                    rate,
                )
        loads = self.loads.at(t, before, given=self.means(i))
        if loads is self._written[i]:  # time factors are the same
            return
        self._written[i] = loads
        given.motion_factors[i] = loads.factors
        given.acting[i] = 1.0 if len(loads.nodes) else 0.0
        if len(loads.nodes):
            given.dead[i], given.following[i], given.gravity[i] = loads.dead, loads.following, loads.gravity
            given.levers[i] = loads.levers
        if self.system.problem.station_loads:
            given.element[i] = -1
            for k, load in enumerate(loads.stations):
                given.element[i, k] = load.element
                given.shape[i, k, : len(load.shape)] = load.shape
                given.point_dead[i, k], given.point_following[i, k] = load.dead, load.following

    def reset(self) -> None:
        """Write all loads anew: ``stage_loads`` were changed from outside."""
        self._written = [None] * len(self._written)

    def move_supports(self, t: float, *, before: bool) -> None:
        """Bring moving supports to time ``t`` [s]."""
        if self.supports.moving:
            self.supports.update(t, before)

    def add_loads(
        self,
        t: float,
        state: State,
        external: Floats,
        *,
        before: bool,
        given: Mapping[int, float] | None = None,
    ) -> float:
        """Add the loads at time ``t`` [s] to ``external (n, 6)``, in body components; ``given`` factors come first.

        Returns:
            the power that they dissipate [W].
        """
        return self._add(self.loads.at(t, before, given=given), state, external)

    def add_load_stiffness(
        self, t: float, state: State, ad: Floats, K: Floats, C: Floats, *, before: bool = False
    ) -> None:
        """Subtract the derivatives of the loads at time ``t`` [s] by poses and twists from ``K`` and ``C``.

        Increments turn with the body frames, ``ad (n, 6, 6)`` is ``ad(twist)``.
        """
        loads = self.loads.at(t, before)
        if not loads.none or loads.sees_motion:
            into = MotionTangent(ad, K, C, self.body.pattern.diagonal)
            self._add(loads, state, np.zeros_like(state.twist), into)

    def _add(
        self, loads: LoadState, state: State, external: Floats, tangent: MotionTangent | None = None
    ) -> float:
        return loads.add(self.system.problem, (state.r, state.q), state.twist, external, tangent)

"""What is recorded of the steps of a collocation method: everything at their ends, and between their stages."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics import inertia
from viscorod.mechanics import supports as support_kernels
from viscorod.mechanics.interpolation import interpolate
from viscorod.solve.history import Snapshot
from viscorod.solve.integrators import solved_step
from viscorod.solve.integrators.stage_data import Body, Given, Stages
from viscorod.solve.integrators.tableau import Tableau
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State
from viscorod.typing import Floats, Integers


class Records:
    """Snapshots at the ends of steps and between.

    Args:
        body, given, stages, tableau: of the method; supports: correct what is interpolated where they hold in part.
        places: where the Gauss points of the results are in the arrays of the stages, flattened.

    Attributes:
        snapshot: everything at the present time.
    """

    snapshot: Snapshot

    def __init__(
        self,
        body: Body,
        given: Given,
        stages: Stages,
        tableau: Tableau,
        supports: SupportState,
        places: Integers,
    ) -> None:
        self.body, self.given, self.stages, self.tableau = body, given, stages, tableau
        self.supports = supports
        self._places = places
        self._last = len(tableau.nodes) - 1
        self._start: tuple[State, Snapshot]  # of the last step
        self._reactions = np.zeros(stages.reaction.shape)

    def settle(
        self,
        state: State,
        fields: tuple[Floats, Floats, Floats],
        reaction: Floats,
        kinetic: float,
        elastic: float,
    ) -> None:
        """Take the snapshot of a ``state`` that no stage led to.

        Args:
            state: poses and twists.
            fields: strain, strain rate and section force ``(e, points, 6)``.
            reaction: global wrenches of the supports ``(supports, 6)``; kinetic, elastic: energies [J].
        """
        strain, rate, force = (self._gather(field) for field in fields)
        self.snapshot = Snapshot(state, strain, rate, force, reaction, kinetic, elastic)

    def leave(self, state: State) -> None:
        """Keep what states between need of the ``state`` at the start of an accepted step, and of its stages."""
        self._start = (state, self.snapshot)
        b, stages = self.body, self.stages
        self._reactions = np.empty(stages.reaction.shape)
        support_kernels.reaction_wrenches(
            b.nodes,
            b.fixed,
            b.axes,
            b.r0,
            b.q0,
            self.given.target,
            stages.r,
            stages.q,
            stages.reaction,
            self._reactions,
        )

    def arrive(self, state: State, kinetic: float, elastic: float) -> None:
        """Take the snapshot of a ``state`` that is the last stage's; energies in J."""
        stages, last = self.stages, self._last
        fields = stages.strain[last], stages.strain_rate[last], stages.stress[last]
        self.settle(state, fields, self._reactions[last], kinetic, elastic)

    def between(
        self,
        parts: Floats,
        t: float,
        h: float,
        new: State,
        end_rate: Floats,
        powers: Floats,
        whole_loss: float,
    ) -> list[tuple[Snapshot, float, float]]:
        """Return everything at ``parts (k,)`` (0 to 1) of the last step, and work and loss [J] from its start.

        Poses and twists are polynomials of degree 5 through both ends of the step (with accelerations), Gauss points
        and reactions follow the stages.

        Args:
            parts: in ascending order.
            t, h: end and length of the step [s]; new, end_rate: state there, and the rate of its twists ``(n, 6)``.
            powers: of loads and viscosity at the stages ``(2, s)`` [W]; whole_loss: of the step [J].
        """
        (old, first), stages = self._start, self.stages
        count = len(parts)
        change = (stages.twist - old.twist).reshape(self._last + 1, -1)
        start_rate = np.dot(self.tableau.start_derivative / h, change).reshape(old.twist.shape)
        r, q, twist = (np.empty((count, *shape.shape)) for shape in (new.r, new.q, new.twist))
        interpolate(
            parts,
            h,
            old.r,
            old.q,
            old.twist,
            start_rate,
            new.r,
            new.q,
            new.twist,
            end_rate,
            self.body.split,
            self._last > 0,
            r,
            q,
            twist,
        )
        weights = self.tableau.polynomials(parts)
        points = np.empty((3, count, len(self._places), 6))
        solved_step.follow(
            weights,
            first.strain,
            first.strain_rate,
            first.section_force,
            stages.strain,
            stages.strain_rate,
            stages.stress,
            self._places,
            points,
        )
        change = (self._reactions - first.reaction).reshape(self._last + 1, -1)
        reaction = first.reaction + np.dot(weights, change).reshape(count, *first.reaction.shape)
        work, losses = h * powers @ self.tableau.partial_weights(parts).T
        found = []
        loss = 0.0
        for k, part in enumerate(parts):
            state = State(r[k], q[k], twist[k])
            self.supports.correct(state, t - (1.0 - part) * h)
            kinetic = inertia.kinetic_energy(self.body.mass, twist[k])
            strain, rate, force = points[0, k], points[1, k], points[2, k]
            snapshot = Snapshot(state, strain, rate, force, reaction[k], kinetic, 0.0)
            loss = max(loss, min(float(losses[k]), whole_loss))  # interpolation must not give energy back
            found.append((snapshot, float(work[k]), loss))
        return found

    def _gather(self, field: Floats) -> Floats:
        """Bring a Gauss-point field ``(e, points, 6)`` into the order of results ``(m, 6)``."""
        return field.reshape(-1, 6)[self._places]

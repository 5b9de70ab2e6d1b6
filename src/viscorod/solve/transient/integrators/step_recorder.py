"""Records of the steps of a collocation method: everything at their ends, and between their stages."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, interpolate
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot, Snapshots
from viscorod.solve.loss_within_steps import drives, loss_within
from viscorod.solve.transient.integrators.inner_stages import go_through_stages
from viscorod.solve.transient.integrators.record_kernels import (
    Between,
    Kept,
    Reading,
    ResultFields,
    StageFields,
    StepEnd,
    end_step,
    read_between,
    read_state,
)
from viscorod.solve.transient.integrators.stage_constraints import StageConstraints
from viscorod.solve.transient.integrators.stage_data import Discretisation, Stages, SupportMotion
from viscorod.solve.transient.integrators.stage_systems import StageSystems
from viscorod.solve.transient.integrators.step_task import StepAccount
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers


class StepRecorder:
    """Snapshots at the ends of steps and between.

    Args:
        body, motion, stages, tableau: of the method; supports: correct what is interpolated where they hold in part.
        places: where the Gauss points of the results are in the arrays of the stages, flattened.
        stage_constraints: joints, if there are any; systems: of the last step.

    Attributes:
        snapshot: everything at the present time; strain: largest shear or stretch there.
    """

    snapshot: Snapshot

    unsaved = frozenset({"_held", "_inner", "_reactions", "_start", "start_rate", "systems"})

    def __init__(
        self,
        body: Discretisation,
        motion: SupportMotion,
        stages: Stages,
        tableau: Tableau,
        supports: SupportState,
        places: Integers,
        stage_constraints: StageConstraints | None,
        systems: StageSystems,
    ) -> None:
        self.body, self.motion, self.stages, self.tableau = body, motion, stages, tableau
        self.supports = supports
        self._held = supports.moving and body.partly  # poses within steps are corrected
        self._inner = tableau.exact_inside
        self.reading = Reading.of(places, body.mass, body.split, body.supports)
        self.stage_constraints, self.systems = stage_constraints, systems
        self.strain = 0.0
        self._fields = np.empty((3, len(places), 6))
        self._start: tuple[State, Floats, Floats]  # of the last step: state, fields, reactions
        self.start_rate = np.zeros(stages.twist.shape[1:])
        self._reactions = np.zeros(stages.reaction.shape)
        self.ending, self.reading_between = KnownTypes(end_step), KnownTypes(read_between)
        self.correction = KnownTypes(go_through_stages)

    def record_state(
        self, state: State, points: GaussStates, reaction: Floats, kinetic: float, elastic: float
    ) -> None:
        """Record a ``state`` that is not a stage of a step.

        Args:
            state: poses and twists; points: one stage of Gauss points in that state.
            reaction: global wrenches of the supports ``(supports, 6)``; kinetic, elastic: energies [J].
        """
        places = self.reading.places
        self._fields = np.empty((3, len(places), 6))
        self.strain = read_state(points.strain, points.strain_rate, points.stress, places, self._fields)
        self._take(state, reaction, kinetic, elastic)

    def take_step(
        self, state: State, h: float, account: StepAccount, kept: Kept
    ) -> tuple[StepEnd, float, tuple[float, float, float]]:
        """Keep the ``state`` at the start of an accepted step of ``h`` [s], and read its end from the last stage.

        Returns:
            the end; its kinetic energy [J]; work, viscous loss, and what loads dissipate outside [J].
        """
        self._start = (state, self._fields, self.snapshot.reaction)
        end = StepEnd.of(self.stages, self.reading)
        kinetic, self.strain, work, loss, outside = self.ending.call(
            h, self.tableau, self.stages, account, self.motion.target, self.reading, kept, end
        )
        self._fields, self._reactions = end.points, end.reactions
        return end, kinetic, (work, loss, outside)

    @property
    def present(self) -> tuple[Floats, Floats]:
        """Fields ``(3, m, 6)`` and global reactions ``(supports, 6)`` at the present time."""
        return self._fields, self.snapshot.reaction

    def take_over(self, start: tuple[State, Floats, Floats], end: StepEnd, strain: float) -> None:
        """Take a step that was accepted elsewhere.

        Args:
            start: state, fields and reactions there; end: of the step; strain: largest shear or stretch there.
        """
        self._start, self.strain = start, strain
        self._fields, self._reactions = end.points, end.reactions

    def record_end(self, state: State, kinetic: float, elastic: float) -> None:
        """Record a ``state`` that is the last stage's; kinetic, elastic: energies [J]."""
        self._take(state, self._reactions[-1], kinetic, elastic)

    def _take(self, state: State, reaction: Floats, kinetic: float, elastic: float) -> None:
        strain, rate, force = self._fields
        joints = None if self.stage_constraints is None else self.stage_constraints.state()
        self.snapshot = Snapshot(state, strain, rate, force, reaction, kinetic, elastic, joints)

    def between(
        self,
        parts: Floats,
        t: float,
        h: float,
        new: State,
        end_rate: Floats,
        powers: Floats,
        whole_loss: float,
    ) -> tuple[Snapshots, Floats, Floats, Floats, Floats]:
        """Return everything at ``parts (k,)`` (0 to 1) of the last step, and energies ``(k,)`` [J] up to there.

        These are work, viscous loss, what loads dissipate outside, and nothing.

        Poses and twists are polynomials of degree 5 through both ends of the step (with accelerations), corrected
        towards the stages if they are many; Gauss points and reactions follow the stages.

        Args:
            parts: in ascending order.
            t, h: end and length of the step [s]; new, end_rate: state there, and the rate of its twists ``(n, 6)``.
            powers: of loads, viscosity, and what loads dissipate, at the stages ``(3, s)`` [W].
            whole_loss: viscous, of the step [J].
        """
        (old, start, start_reaction), stages = self._start, self.stages
        count, held, inner = len(parts), self._held, self._inner
        found = Between.of(count + len(inner), len(new.r), start.shape[1], len(start_reaction))
        given = (
            h,
            self.tableau,
            MovingPoses(old.r, old.q, old.twist, self.start_rate),
            MovingPoses(new.r, new.q, new.twist, end_rate),
            ResultFields(start, start_reaction),
            StageFields(
                stages.twist, stages.strain, stages.strain_rate, stages.stress, self._reactions, powers
            ),
            whole_loss,
            self.reading,
        )
        corrected = held or len(inner) > 0
        places = np.append(parts, inner) if len(inner) else parts
        self.reading_between.call(places, *given, True, not corrected, found)
        if len(inner):
            at_stages, states = (stages.r, stages.q, stages.twist), (found.r, found.q, found.twist)
            self.correction.call(parts, self.tableau, at_stages, 0, count, states)
            found = found.first(count)
        if held:
            for r, q, twist, part in zip(found.r, found.q, found.twist, parts, strict=True):
                self.supports.correct(State(r, q, twist, new.multiplier), t - (1.0 - part) * h)
        if corrected:
            self.reading_between.call(parts, *given, False, True, found)
        joints = None
        if self.stage_constraints is not None:
            states, times = (found.r, found.q, found.twist), t - (1.0 - parts) * h
            joints = self.stage_constraints.between(states, parts, times, self.systems)
        (strain, rate, force), (kinetic, *shares, nothing) = found.fields.points, found.energies
        snapshots = Snapshots(
            found.r,
            found.q,
            found.twist,
            [new.multiplier] * count,
            strain,
            rate,
            force,
            found.fields.reactions,
            kinetic,
            nothing,
            joints,
        )
        work, loss, outside = shares
        if drives(powers[1]):
            loss = loss_within(h * self.tableau.partial_weights(parts), powers[1], whole_loss)
        return snapshots, work, loss, outside, nothing


def interpolate_states(
    parts: Floats,
    h: float,
    start: tuple[State, Floats],
    end: tuple[State, Floats],
    split: Floats,
    *,
    with_rates: bool,
) -> tuple[list[State], Floats]:
    """Return the states at ``parts (k,)`` (0 to 1) of a step of ``h`` [s], and their twists as one array ``(k, n, 6)``.

    Args:
        start, end: states, and rates of their twists ``(n, 6)``.
        split: marks nodes that are held in part ``(n,)``.
        with_rates: poses are polynomials of degree 5 that have these rates at both ends; else of degree 3.
    """
    (old, old_rate), (new, new_rate) = start, end
    r, q, twist = (np.empty((len(parts), *field.shape)) for field in (new.r, new.q, new.twist))
    interpolate(
        parts,
        h,
        MovingPoses(old.r, old.q, old.twist, old_rate),
        MovingPoses(new.r, new.q, new.twist, new_rate),
        split,
        with_rates,
        r,
        q,
        twist,
        np.empty((10, 6)),
    )
    return [State(*fields, new.multiplier) for fields in zip(r, q, twist, strict=True)], twist

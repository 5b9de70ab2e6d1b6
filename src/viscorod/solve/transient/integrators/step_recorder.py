"""Records of the steps of a collocation method: everything at their ends, and between their stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.mechanics.nodes import support_rows as support_kernels
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, interpolate
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.transient.integrators.record_kernels import (
    ResultFields,
    StageFields,
    read_between,
    read_end,
)
from viscorod.solve.transient.integrators.stage_constraints import StageConstraints
from viscorod.solve.transient.integrators.stage_data import Discretisation, Stages, SupportMotion
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers


class StepRecorder:
    """Snapshots at the ends of steps and between.

    Args:
        body, motion, stages, tableau: of the method; supports: correct what is interpolated where they hold in part.
        places: where the Gauss points of the results are in the arrays of the stages, flattened.
        stage_constraints: joints, if there are any; solve_real: with the real matrix of the last step.

    Attributes:
        snapshot: everything at the present time; strain: largest shear or stretch there.
    """

    snapshot: Snapshot

    def __init__(
        self,
        body: Discretisation,
        motion: SupportMotion,
        stages: Stages,
        tableau: Tableau,
        supports: SupportState,
        places: Integers,
        stage_constraints: StageConstraints | None,
        solve_real: Callable[[Floats], Floats],
    ) -> None:
        self.body, self.motion, self.stages, self.tableau = body, motion, stages, tableau
        self.supports = supports
        self._places = places
        self.stage_constraints, self.solve_real = stage_constraints, solve_real
        self.strain = 0.0
        self._fields = np.empty((3, len(places), 6))
        self._start: tuple[State, Floats, Floats]  # of the last step: state, fields, reactions
        self._reactions = np.zeros(stages.reaction.shape)
        self._directions = support_kernels.Directions.of(1)
        self._reaction_wrenches = KnownTypes(support_kernels.reaction_wrenches)
        self._read_end, self._read_between = KnownTypes(read_end), KnownTypes(read_between)

    def record_state(
        self, state: State, points: GaussStates, reaction: Floats, kinetic: float, elastic: float
    ) -> None:
        """Record a ``state`` that is not a stage of a step.

        Args:
            state: poses and twists; points: one stage of Gauss points in that state.
            reaction: global wrenches of the supports ``(supports, 6)``; kinetic, elastic: energies [J].
        """
        self._read(state, points.strain, points.strain_rate, points.stress)
        self._take(state, reaction, kinetic, elastic)

    def keep_start(self, state: State) -> None:
        """Keep the ``state`` at the start of an accepted step, and reactions at its stages, for states between."""
        self._start = (state, self._fields, self.snapshot.reaction)
        stages = self.stages
        self._reactions = np.empty(stages.reaction.shape)
        self._reaction_wrenches(
            self.body.supports,
            self.motion.target,
            stages.r,
            stages.q,
            stages.reaction,
            self._directions,
            self._reactions,
        )

    def record_end(self, state: State, elastic: float) -> float:
        """Record a ``state`` that is the last stage's; return its kinetic energy [J]."""
        stages = self.stages
        kinetic = self._read(state, stages.strain, stages.strain_rate, stages.stress)
        self._take(state, self._reactions[-1], kinetic, elastic)
        return kinetic

    def _take(self, state: State, reaction: Floats, kinetic: float, elastic: float) -> None:
        strain, rate, force = self._fields
        joints = None if self.stage_constraints is None else self.stage_constraints.state()
        self.snapshot = Snapshot(state, strain, rate, force, reaction, kinetic, elastic, joints)

    def _read(self, state: State, strain: Floats, rate: Floats, force: Floats) -> float:
        """Bring the last stage of Gauss-point fields into the order of results; return the kinetic energy [J]."""
        self._fields = np.empty((3, len(self._places), 6))
        kinetic, self.strain = self._read_end(
            strain, rate, force, self._places, self.body.mass, state.twist, self._fields
        )
        return float(kinetic)

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

        Poses and twists are polynomials of degree 5 through both ends of the step (with accelerations), corrected
        towards the stages if they are many; Gauss points and reactions follow the stages.

        Args:
            parts: in ascending order.
            t, h: end and length of the step [s]; new, end_rate: state there, and the rate of its twists ``(n, 6)``.
            powers: of loads, viscosity, and what loads dissipate, at the stages ``(3, s)`` [W].
            whole_loss: viscous, of the step [J].
        """
        (old, start, start_reaction), stages, tableau = self._start, self.stages, self.tableau
        count, (n, _) = len(parts), new.r.shape
        change = (stages.twist - old.twist).reshape(len(tableau.nodes), -1)
        start_rate = np.dot(tableau.start_derivative / h, change).reshape(n, 6)
        inner = tableau.exact_inside
        r, q, twist = interpolate_poses(
            np.append(parts, inner),
            h,
            (old, start_rate),
            (new, end_rate),
            self.body.split,
            with_rates=len(tableau.nodes) > 1,
        )
        if len(inner):
            correct_inside(
                tableau.polynomials(parts)[:, :-1], (r, q, twist), (stages.r, stages.q, stages.twist)
            )
        states = [
            State(*fields, new.multiplier) for fields in zip(r[:count], q[:count], twist[:count], strict=True)
        ]
        if self.supports.moving and self.body.partly:
            for state, part in zip(states, parts, strict=True):
                self.supports.correct(state, t - (1.0 - part) * h)
        points = np.empty((3, count, len(self._places), 6))
        reaction, energies = np.empty((count, *start_reaction.shape)), np.empty((3, count))
        self._read_between(
            parts,
            h,
            tableau,
            ResultFields(start, start_reaction),
            StageFields(stages.strain, stages.strain_rate, stages.stress, self._reactions, powers),
            self._places,
            whole_loss,
            self.body.mass,
            twist[:count],
            ResultFields(points, reaction),
            energies,
        )
        kinetic, work, loss = energies.tolist()
        joints: Sequence[JointState | None] = [None] * count
        if self.stage_constraints is not None:
            joints = self.stage_constraints.between(states, parts, t - (1.0 - parts) * h, self.solve_real)
        snapshots = map(Snapshot, states, *points, reaction, kinetic, [0.0] * count, joints)
        return list(zip(snapshots, work, loss, strict=True))


def interpolate_poses(
    parts: Floats,
    h: float,
    start: tuple[State, Floats],
    end: tuple[State, Floats],
    split: Floats,
    *,
    with_rates: bool,
) -> tuple[Floats, Floats, Floats]:
    """Return positions ``(k, n, 3)``, quaternions and twists at ``parts (k,)`` (0 to 1) of a step of ``h`` [s].

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
    return r, q, twist


def correct_inside(weights: Floats, found: tuple[Floats, Floats, Floats], stages: tuple[Floats, ...]) -> None:
    """Correct poses and twists within a step so that they go through its stages.

    Args:
        weights: ``(k, m)`` of polynomials that are one at one stage, zero at the others and at the start.
        found: poses and twists, ``k`` to be corrected and those at the first ``m`` stages, interpolated; overwritten.
        stages: poses and twists there.
    """
    (r, q, twist), (r_stages, q_stages, twist_stages) = found, stages
    k, m = weights.shape
    r[:k] += np.tensordot(weights, r_stages[:m] - r[k:], 1)
    twist[:k] += np.tensordot(weights, twist_stages[:m] - twist[k:], 1)
    turn = product(conjugate(q[k:]), q_stages[:m])
    turn /= turn[..., :1]  # one, and half of a small rotation vector
    whole = np.tensordot(weights, turn, 1)
    whole[..., 0] = 1.0
    q[:k] = product(q[:k], whole / np.linalg.norm(whole, axis=2, keepdims=True))

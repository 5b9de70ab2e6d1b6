"""Data of the collocation kernels: discretisation, inputs at the stages, stages, matrices, scratch.

All arrays are allocated once for a run; the classes are tuples that compiled code takes as they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements, ElementWork
from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.nodes.applied_loads import StationWork
from viscorod.mechanics.nodes.motion_loads import MotionLoads, MotionWork
from viscorod.mechanics.nodes.support_rows import Directions, SupportedNodes
from viscorod.solve.linear.factors import Factors as MatrixFactors
from viscorod.solve.linear.pattern import Pattern
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.solve.constraints.support_state import SupportState
    from viscorod.solve.problem.problem import Problem


class Discretisation(NamedTuple):
    """Elements, inertia and supports, which do not change in a run.

    Attributes:
        mass: ``(n, 6, 6)``; held, split: mark nodes ``(n,)`` whose pose is prescribed / held in part.
        supports: of ``m`` nodes; complete: marks those that hold everything ``(m,)``; partly: any leaves motions free.
        loaded: the nodes that loads act on; length: of the model [m]; pattern: of all matrices.
    """

    elements: Elements
    mass: Floats
    held: Floats
    split: Floats
    supports: SupportedNodes
    complete: Floats
    partly: bool
    loaded: Integers
    length: float
    pattern: Pattern

    @classmethod
    def of(cls, problem: Problem, elements: Elements, supports: SupportState) -> Discretisation:
        """Collect what the kernels need to know of a problem."""
        n = problem.size
        held, split = np.zeros(n), np.zeros(n)
        held[supports.set.nodes[supports.complete]] = 1.0
        split[supports.set.nodes[supports.partial]] = 1.0
        complete = np.zeros(len(supports.set.nodes))
        complete[supports.complete] = 1.0
        loaded = np.zeros(n, dtype=bool)
        for load in problem.nodal_loads:
            loaded[load.nodes] = True
            loaded |= bool(load.gravity.any())
        return cls(
            elements,
            problem.mass,
            held,
            split,
            supports.nodes,
            complete,
            len(supports.partial) > 0,
            np.flatnonzero(loaded).astype(np.int64),
            problem.length,
            problem.pattern,
        )


class SupportMotion(NamedTuple):
    """Prescribed motions of supports at the stages (first index).

    Attributes:
        target, rate: prescribed values and their rates ``(s, m, 6)``.
        r, q, twist, twist_rate: motion of completely held supports ``(s, m, ...)``.
        end_r, end_q: poses of completely held supports at the end of the step, if that is not a stage.
    """

    target: Floats
    rate: Floats
    r: Floats
    q: Floats
    twist: Floats
    twist_rate: Floats
    end_r: Floats
    end_q: Floats

    @classmethod
    def of(cls, stages: int, body: Discretisation) -> SupportMotion:
        """Allocate for a number of stages."""
        s, m, r0, q0 = stages, len(body.complete), body.supports.r0, body.supports.q0
        return cls(
            target=np.zeros((s, m, 6)),
            rate=np.zeros((s, m, 6)),
            r=np.repeat(r0[None], s, axis=0),
            q=np.repeat(q0[None], s, axis=0),
            twist=np.zeros((s, m, 6)),
            twist_rate=np.zeros((s, m, 6)),
            end_r=r0.copy(),
            end_q=q0.copy(),
        )


class StageLoads(NamedTuple):
    """Loads at the stages (first index).

    Attributes:
        acting: 1 where nodal loads act; dead, following ``(s, n, 6)``; gravity ``(s, 3)``; levers: of dead forces at
            arms ``(s, n, 3, 3)``, no nodes if there are none.
        element: elements with concentrated loads ``(s, loads)``, -1 if none; their basis values ``shape`` and wrenches.
        motion: loads that see motion, with their factors ``(s, m)``.
        station_work, motion_work: scratch.
    """

    acting: Floats
    dead: Floats
    following: Floats
    gravity: Floats
    levers: Floats
    element: Integers
    shape: Floats
    point_dead: Floats
    point_following: Floats
    motion: MotionLoads
    motion_factors: Floats
    station_work: StationWork
    motion_work: MotionWork

    @classmethod
    def of(
        cls, stages: int, body: Discretisation, loads: int, motion: MotionLoads, *, offset: bool
    ) -> StageLoads:
        """Allocate for a number of stages and of concentrated loads; ``offset``: any dead force acts at an arm."""
        s, n, m = stages, len(body.mass), body.elements.nodes.shape[1]
        return cls(
            acting=np.zeros(s),
            dead=np.zeros((s, n, 6)),
            following=np.zeros((s, n, 6)),
            gravity=np.zeros((s, 3)),
            levers=np.zeros((s, n if offset else 0, 3, 3)),
            element=np.full((s, loads), -1, dtype=np.int64),
            shape=np.zeros((s, loads, m)),
            point_dead=np.zeros((s, loads, 6)),
            point_following=np.zeros((s, loads, 6)),
            motion=motion,
            motion_factors=np.zeros((s, len(motion.nodes))),
            station_work=StationWork.of(m),
            motion_work=MotionWork.new(),
        )


class StepStart(NamedTuple):
    """Start of a step: poses and twists ``(n, ...)``, and what accelerates the nodes there, ``force (n, 6)``."""

    r: Floats
    q: Floats
    twist: Floats
    force: Floats


class Stages(NamedTuple):
    """State of all stages of a step (first index): unknowns, what follows from them, and the residual.

    ``dissipated (s,)`` is the power that loads turn into heat outside of the model [W]; ``rest, rest_rate`` are rest
    strains that change with time ``(s, e, points, 6)``, and their rates, no stages if there are none.
    """

    X: Floats
    r: Floats
    q: Floats
    twist: Floats
    acceleration: Floats
    internal: Floats
    external: Floats
    force: Floats
    residual: Floats
    reaction: Floats
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    stress: Floats
    held_power: Floats
    dissipated: Floats
    rest: Floats
    rest_rate: Floats

    @classmethod
    def of(cls, stages: int, body: Discretisation, *, driven: bool) -> Stages:
        """Allocate; ``driven``: rest strains change with time."""
        s, n = stages, len(body.mass)
        points = (s, *body.elements.reference.shape)
        return cls(
            X=np.zeros((s, n, 6)),
            r=np.zeros((s, n, 3)),
            q=np.zeros((s, n, 4)),
            twist=np.zeros((s, n, 6)),
            acceleration=np.zeros((s, n, 6)),
            internal=np.zeros((s, n, 6)),
            external=np.zeros((s, n, 6)),
            force=np.zeros((s, n, 6)),
            residual=np.zeros((s, body.pattern.size, 6)),  # of nodes and multipliers
            reaction=np.zeros((s, len(body.complete), 6)),
            strain=np.zeros(points),
            strain_rate=np.zeros(points),
            section_force=np.zeros(points),
            stress=np.zeros(points),
            held_power=np.zeros(s),
            dissipated=np.zeros(s),
            rest=np.zeros(points if driven else (0, *points[1:])),
            rest_rate=np.zeros(points if driven else (0, *points[1:])),
        )


class Matrices(NamedTuple):
    """The frozen Jacobian: blocks ``K`` and ``C (b, 6, 6)``, ``mass (n, 6, 6)``, with supported rows projected.

    ``directions`` are those of the supports; ``adjoint (n, 6, 6)`` is ``M ad(x)``, which ``C`` contains.
    """

    K: Floats
    C: Floats
    mass: Floats
    adjoint: Floats
    directions: Directions
    operators: Operators

    @classmethod
    def of(cls, body: Discretisation) -> Matrices:
        """Allocate."""
        b, n = len(body.pattern.rows), len(body.mass)
        return cls(
            K=np.zeros((b, 6, 6)),
            C=np.zeros((b, 6, 6)),
            mass=np.zeros((n, 6, 6)),
            adjoint=np.zeros((n, 6, 6)),
            directions=Directions.of(len(body.complete)),
            operators=Operators.of(body.elements),
        )


class StageFactors(NamedTuple):
    """Factors of the real matrix, and of the complex ones as a stack; scales of their rows and of the unknowns.

    Scales are ``(6 N,)``, those of the rows of the complex matrices ``(p, 6 N)``.
    """

    real: MatrixFactors
    pairs: MatrixFactors
    real_rows: Floats
    pair_rows: Floats
    scales: Floats


class Work(NamedTuple):
    """Scratch: one element; rates of all stages; nodal vectors ``(n, 6)``; blocks of no matrix.

    ``real (6 N,)`` and ``pairs (p, 6 N)`` are right sides, ``directions`` those of the supports; ``square (6, 6)``.
    """

    element: ElementWork
    real: Floats
    pairs: Floats
    rates: Floats
    rate: Floats
    vector: Floats
    change: Floats
    reaction: Floats
    directions: Directions
    no_blocks: Floats
    square: Floats

    @classmethod
    def of(cls, body: Discretisation, stages: int) -> Work:
        """Allocate."""
        n, m = len(body.mass), len(body.complete)
        return cls(
            element=ElementWork.of(body.elements.nodes.shape[1] - 1),
            real=np.zeros(6 * body.pattern.size),
            pairs=np.zeros((stages // 2, 6 * body.pattern.size), dtype=complex),
            rates=np.zeros((stages, n, 6)),
            rate=np.zeros((n, 6)),
            vector=np.zeros((n, 6)),
            change=np.zeros((n, 6)),
            reaction=np.zeros((m, 6)),
            directions=Directions.of(m),
            no_blocks=np.zeros((0, 6, 6)),
            square=np.zeros((6, 6)),
        )

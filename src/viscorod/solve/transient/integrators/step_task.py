"""A collocation step as compiled code sees it: one bundle of everything that it reads and writes.

It stands in memory for a whole run (see ``mechanics.compilation.shared``), and all parts of the step take a reference
to it. What a model lacks is there and empty, so that the step is compiled once for all models; kernels that only some
need are called through their addresses, which are 0 where there is nothing for them to do.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.mechanics.elements.intrinsic_element import StrainMotion
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays
from viscorod.solve.transient.integrators.stage_data import (
    Discretisation,
    Matrices,
    StageFactors,
    StageLoads,
    Stages,
    StepStart,
    SupportMotion,
    Work,
)
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

H, TOLERANCE, RATE, ITERATIONS, FINAL, NUMBERS = range(6)
"""Places among the numbers of a step: its length [s]; what the iteration may leave of the stage coordinates
(displacement over length, or rotation [rad]); convergence rate of the last step, trusted in the first iteration (1 if
unknown); allowed iterations; whether the present evaluation is the last one."""


class StepAccount(NamedTuple):
    """What a converged step amounts to.

    Attributes:
        powers: of loads, of viscosity, what loads dissipate outside, and of what changes rest strains, at all stages
            ``(4, s)`` [W].
        elastic: energies there ``(s,)`` [J].
        error: estimated, of the poses ``(n, 6)``, body components.
    """

    powers: Floats
    elastic: Floats
    error: Floats

    @classmethod
    def of(cls, nodes: int, stages: int) -> StepAccount:
        """Allocate."""
        return cls(np.zeros((4, stages)), np.zeros(stages), np.zeros((nodes, 6)))


class Ends(NamedTuple):
    """Ends of a step for the method that conserves energy between them; no states for others.

    Poses and twists at the end of the step ``(1, n, ...)``, its Gauss points, the strains at the start, a
    scratch force, the energy defect of the Maxwell branches ``(e, points)``, and rest strains as those of stages.
    """

    r: Floats
    q: Floats
    twist: Floats
    strain: Floats
    strain_rate: Floats
    section_force: Floats
    start_strain: Floats
    force: Floats
    defect: Floats
    rest: Floats

    @classmethod
    def of(cls, body: Discretisation, *, driven: bool) -> Ends:
        """Allocate; ``driven``: rest strains change with time."""
        points = body.elements.reference.shape
        return cls._allocated(1, len(body.mass), points, driven=driven)

    @classmethod
    def none(cls) -> Ends:
        """Return those of a method without."""
        return cls._allocated(0, 0, (0, 0, 6), driven=False)

    @classmethod
    def _allocated(cls, states: int, n: int, shape: tuple[int, ...], *, driven: bool) -> Ends:
        points = (states, *shape)
        return cls(
            r=np.zeros((states, n, 3)),
            q=np.zeros((states, n, 4)),
            twist=np.zeros((states, n, 6)),
            strain=np.zeros(points),
            strain_rate=np.zeros(points),
            section_force=np.zeros(points),
            start_strain=np.zeros(points),
            force=np.zeros((states, n, 6)),
            defect=np.zeros(shape[:2]),
            rest=np.zeros(points if driven else (0, *shape)),
        )


class StepCalls(NamedTuple):
    """Addresses of the kernels that a step calls, 0 where there is nothing for them to do.

    Attributes:
        place_ends, conserve, hold_ends: of methods that conserve energy between the ends of a step, see ``step_ends``.
        internal_forces, deduct_rest, strains: of the elements; the last one where strains are states.
        give_links, hold_links, freeze_links, move_links, account_links: of joints, springs and held strains, see
            ``step_links``.
        add_branches, branch_defect, move_branches, end_branches, account_branches: of Maxwell branches, see
            ``step_branches``.
        nodal_loads, station_load, motion_loads: of loads; impose, support_powers: of supports.
        substitute, substitute_pair: with real and with complex factors; energies: of the elements.
    """

    place_ends: int = 0
    conserve: int = 0
    hold_ends: int = 0
    internal_forces: int = 0
    deduct_rest: int = 0
    strains: int = 0
    give_links: int = 0
    hold_links: int = 0
    freeze_links: int = 0
    move_links: int = 0
    account_links: int = 0
    add_branches: int = 0
    branch_defect: int = 0
    move_branches: int = 0
    end_branches: int = 0
    account_branches: int = 0
    nodal_loads: int = 0
    station_load: int = 0
    motion_loads: int = 0
    impose: int = 0
    support_powers: int = 0
    substitute: int = 0
    substitute_pair: int = 0
    energies: int = 0


class StepTask(NamedTuple):
    """All that a step reads and writes.

    Attributes:
        body, method: the model and the method; start: of the step; numbers: see above.
        motion, loads: of supports and of loads at its stages.
        factors, matrices: of its linear systems, and the frozen Jacobian.
        stages: their state; points: their Gauss points; account: what the step amounts to; work: scratch.
        ends: of the midpoint rule; strains: of the intrinsic formulation; links: joints, springs and held strains;
            branches: Maxwell's.
        calls: kernels that are called by address.
    """

    body: Discretisation
    method: Tableau
    start: StepStart
    numbers: Floats
    motion: SupportMotion
    loads: StageLoads
    factors: StageFactors
    matrices: Matrices
    stages: Stages
    points: GaussStates
    account: StepAccount
    work: Work
    ends: Ends
    strains: StrainMotion
    links: ConstraintArrays
    branches: MaxwellArrays
    calls: StepCalls

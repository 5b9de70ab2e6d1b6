"""Data of the compiled loop of steps: places in its arrays of numbers, what it works on, what comes of it."""

from __future__ import annotations

from typing import Any, NamedTuple

from viscorod.mechanics.elements.branch_memory import BranchMemory, BranchRows
from viscorod.mechanics.elements.gauss_batch import PointFields
from viscorod.mechanics.elements.geometric_element import Assembled
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.nodes.carried_motion import Carrier
from viscorod.mechanics.nodes.load_courses import LoadCourses, LoadSums
from viscorod.mechanics.nodes.motion_courses import MotionCourses
from viscorod.mechanics.nodes.table_motions import TableMotions
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses
from viscorod.solve.transient.integrators.branch_systems import Stiffened
from viscorod.solve.transient.integrators.loop_link_data import LoopLinks
from viscorod.solve.transient.integrators.record_kernels import Between, Kept, Reading, StepEnd
from viscorod.solve.transient.integrators.stage_data import StepStart
from viscorod.typing import Floats, Integers

T, FACTOR_STEP, RATE, LAST_STEP, TURN, KINETIC, ELASTIC, WORK, LOSS, OUTSIDE, STRAIN = range(11)
GAP, HAD, WAS_FRESH, CLOCK = range(11, 15)
"""Places in the clock: time and the step that factors are for [s], convergence rate, the last step [s] (0: there was
none, or a jump since), its rotation [rad]; energies at its end, its work, its loss, and what loads dissipate outside in
it [J], the largest shear or stretch at its end; how far motions go from what its stages show; ``HAVE`` and ``FRESH`` of
a state that is put back."""

(
    HAVE,
    FRESH,
    LOST,
    MOST,
    STEPS,
    ROWS,
    REJECTED,
    ITERATED,
    TRYING,
    TAKEN,
    TRIED,
    EVALUATED,
    FACTORISED,
    RENEWED,
    PASSED,
    LENT,
    NUMBERS,
) = range(17)
"""Places among the numbers: whether there is a Jacobian, and one of the present step (see below), and whether its
factors are lost; most steps; then counts, among them the steps that are tried again, beside whether the present one is,
and what of it is taken, then the corners of the loads that were passed, and last whether the factors are those of
another model, which finds them itself."""

OLD, OF_MIDDLE, OF_START = range(3)
"""What a Jacobian is of: an earlier step, or one that has converged; the middle of the present one, as it is predicted;
its start, where that did not converge, or no step precedes."""

TOLERANCE, NEWTON, FOLLOWS, SAFETY, FACTOR, EXPONENT = range(6)
STALE, AGED, ALLOWED, FARTHEST, POWER, OUTPUT, DURATION, SMALLEST = range(6, 14)
LEAST, LARGEST, HALF, WAS, LIMITS = range(14, 19)
"""Places among the limits: of the error and of Newton's method; the least of the latter if they follow the motion, else
0, and the factors and the power with which they do; convergence rates from which on a Jacobian is stale, and aged;
iterations, rotation [rad], power of the step in the error; time between records (0: within every step), duration and
smallest step [s], least records of a step, largest strain; limit of Newton's method in halves of steps."""

NEXT, SETTLED, LONGER, FIRST, TRIALS = range(5)
"""Places among the trials: number of the next step that is tried again; from which number on one that is longer than
what follows is; number of the first step."""

WHOLE, FIRST_HALF, SECOND_HALF = range(3)
"""What is taken: a step of the motion, or halves of one that is tried again."""

START, MIDDLE, END, BETTER_MIDDLE, BETTER_END, TRIAL_ROWS = range(6)
"""States that are kept of a step that is tried again: its own, then those of its halves."""

REACHED, FULL, ASK, BROKEN, RAISED, GOES_ON, AGAIN, FAILED = range(8)
"""Why a loop ends: at the corner; enough steps, or arrays are full; the next attempt is Python's; strains are out of
bounds; an exception in Python. Or it goes on, or an attempt is to be made again with another Jacobian, or it has failed
with a new one."""


class LoopBranches(NamedTuple):
    """What Maxwell branches remember, and the stiffness with them at real and at complex eigenvalues."""

    memory: BranchMemory
    real: Stiffened
    pair: Stiffened


class HeldInPart(NamedTuple):
    """Supports that hold nodes in part: their rows ``(p,)``, and how their rotations alone turn these ``(p, 6)``.

    Attributes:
        axes, r0, q0, fixed: of these supports, see ``support_rows``.
        target, rate: of all supports in a record ``(m, 6)``; given: of these, and accelerations ``(3, p, 6)``.
        r, q, twist_rate, change: scratch ``(p, 3)``, ``(p, 4)``, ``(p, 6)``, ``(1, 6)``.
    """

    rows: Integers
    turning: Floats
    axes: Floats
    r0: Floats
    q0: Floats
    fixed: Floats
    target: Floats
    rate: Floats
    given: Floats
    r: Floats
    q: Floats
    twist_rate: Floats
    change: Floats


class LoopModel(NamedTuple):
    """One step, whose start is the present state; ``reading`` of its end, and ``gap`` as for the predictor; the rest.

    The step is a shared bundle (see ``mechanics.compilation.shared``), so that compiled code has a reference to it.
    """

    task: Any
    reading: Reading
    gap: Floats
    branches: LoopBranches
    held: HeldInPart


class LoopLoads(NamedTuple):
    """The loads, where they are functions of time that compiled code knows: of the stages, and at the step's start.

    ``motions`` are those of supports, likewise, ``tables`` those of them that are looked at within steps; none if they
    are at rest.
    """

    courses: LoadCourses
    motions: MotionCourses
    tables: TableMotions
    stages: LoadSums
    start: LoadSums


class Renewal(NamedTuple):
    """What a Jacobian is renewed with. Supports that move hold their nodes completely.

    Attributes:
        elements, groups, fields: of the assembly, see ``gauss_batch``; out: internal forces, which nobody reads, and
            the matrices; at_start: ``fields`` with the stresses at the start of the step.
        ad: of the twists ``(n, 6, 6)``; external, square: scratch ``(n, 6)``, ``(6, 6)``.
        target: prescribed values of the supports ``(m, 6)``.
    """

    elements: Elements
    groups: Integers
    fields: PointFields
    at_start: PointFields
    out: Assembled
    ad: Floats
    external: Floats
    square: Floats
    target: Floats


class LoopSystems(NamedTuple):
    """Blocks of the real and of the complex matrices, and ``places``, where they go to (see ``factors.reduce``)."""

    real: Floats
    pairs: Floats
    slots: Integers
    kept: Integers
    targets: Integers


class Follows(NamedTuple):
    """The tolerance that follows a motion.

    Attributes:
        numbers: see ``amplitude``; r, q: the poses where it began; carrier: what carries these along, if anything does.
        carried_r, carried_q, relative_twist: scratch, see ``carry_along``.
    """

    numbers: Floats
    r: Floats
    q: Floats
    carrier: Carrier
    carried_r: Floats
    carried_q: Floats
    relative_twist: Floats


class LoopState(NamedTuple):
    """The present state, and what the next step and its records begin with.

    Attributes:
        now: state at the present time, that of the step's start.
        last: of the start of the last step, with rates that records leave there.
        kept: see ``end_step``; stress, stages_stress: of ``kept.stresses``, and of the stages, in rows.
        end: scratch; fields: at the present time and at the start of the last step, two stages.
        weights: scratch of the predictor; follows: the tolerance.
        whole_coordinates, whole_stress: as ``kept.X`` and ``stress``, of a step that is tried again in halves.
    """

    now: StepStart
    last: MovingPoses
    kept: Kept
    stress: Floats
    stages_stress: Floats
    end: StepEnd
    points: Floats
    reactions: Floats
    weights: Floats
    follows: Follows
    whole_coordinates: Floats
    whole_stress: Floats


MARKS, MOST_TRIALS = 12, 8
"""States at the ends of steps, beside the records, and steps that are tried again, that a loop keeps at most."""

EXTRA_ROWS = MARKS + TRIAL_ROWS * MOST_TRIALS
"""States beside the records."""


class Batch(NamedTuple):
    """What comes of a loop.

    Attributes:
        ends, lengths: of the steps [s]; iterations, limits, unknowns: of each (integers ``(3, steps)``).
        accounts: before the first and after every step: kinetic, elastic, viscous, external, and what loads dissipated
            outside ``(steps + 1, 5)``.
        lost: by each Maxwell branch, likewise ``(steps + 1, n)``; branches: of the states.
        instants, places: of the records [s], 0 to 1 in their steps, and 0.5; of_step: number of the step.
        states: of the records; behind them at the inner stages of a step of many; in the last :data:`EXTRA_ROWS` rows
            first of the ends of some steps: the ``marks``, numbers of steps in ascending order; then of the steps that
            are tried again.
        trials: of these: number of the step in the loop, end and length [s], whether the halves came to their end
            ``(k, 4)``.
    """

    ends: Floats
    lengths: Floats
    notes: Integers
    accounts: Floats
    lost: Floats
    instants: Floats
    places: Floats
    of_step: Integers
    states: Between
    branches: BranchRows
    marks: Integers
    trials: Floats


class Backup(NamedTuple):
    """What steps go on from, as one row of numbers each: the arrays themselves, and what they were in two states."""

    live: tuple[Floats, ...]
    before: Floats
    after: Floats


class Addresses(NamedTuple):
    """Where the kernels are, and Python functions, 0 where there is nothing for them to do.

    Kernels of Maxwell branches, of loads that see motion, of joints and held strains, of steps with many stages, and of
    supports that move, follow tables, carry the rest along, or hold nodes in part, are there where there are any.
    Python renews Jacobians where loads are unknown functions of time, and prepares steps where loads or motions are; it
    says what these do between the stages if anything has to be looked for.
    """

    step: int
    reduce_real: int
    reduce_pair: int
    combine_real: int
    combine_pair: int
    predict: int
    place: int
    turn: int
    extent: int
    carry: int
    end: int
    between: int
    adjoint: int
    assemble: int
    collect: int
    add_loads: int
    add_moving: int
    add_inertia: int
    project: int
    stiffen_real: int
    stiffen_pair: int
    begin_branches: int
    keep_branches: int
    read_branches: int
    read_within: int
    prescribe: int
    furthest: int
    project_twists: int
    kinetic: int
    correct: int
    correct_within: int
    go_through: int
    turn_alone: int
    prescribe_start: int
    joint_forces: int
    joint_tangent: int
    hold_strains: int
    close: int
    drive_links: int
    linearise_links: int
    predict_links: int
    keep_links: int
    read_links: int
    close_within: int
    renew: int
    prepare: int
    unseen: int


class StepLoop(NamedTuple):
    """All that the loop works on.

    Attributes:
        model, systems, state, calls: what steps are made of.
        clock, numbers, limits: see above; control: those of ``step_choice``; trials: steps that are tried again.
        batch: outputs; backup: of what steps go on from; renewal: of Jacobians.
        message: tells Python time and end of the step [s], whether that is a corner, and whether it is a half ``(4,)``.
        loads: that the loop knows; ahead: corners after the next one [s], where steps go on at once, then inf.
        links: joints, springs and held strains.
    """

    model: LoopModel
    systems: LoopSystems
    state: LoopState
    calls: Addresses
    clock: Floats
    numbers: Integers
    limits: Floats
    control: Floats
    trials: Floats
    batch: Batch
    backup: Backup
    renewal: Renewal
    message: Floats
    loads: LoopLoads
    ahead: Floats
    links: LoopLinks

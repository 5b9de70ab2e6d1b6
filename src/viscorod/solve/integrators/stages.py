"""Compiled heart of the collocation integrators: stage residuals, simplified Newton iteration, error estimate.

Unknowns are the coordinates ``X_i`` of all nodes at the stages, seen from the poses at the start of the step (see
``mechanics.motion``). Twists follow exactly, ``x_i = T(X_i) sum_j d_ij X_j / h``, accelerations as
``sum_j d_ij (x_j - x_0)/h``, and each stage has to be in balance,

    R_i = M x_i' + L1(x_i) M x_i + f_int - f_ext = 0.

With body increments ``dx = (increment)' + ad(x) increment``, and ``M, C, K`` from the frozen Jacobian, the linear
system of
all stages decouples in the eigenvectors of ``D``: one real and one complex matrix ``(mu/h)^2 M + (mu/h) C + K`` of the
size of
the model (Hairer and Wanner 1996, IV.8, for the second-order form).
"""

from __future__ import annotations

from viscorod.mechanics import supports
from viscorod.mechanics.compiled import inlined
from viscorod.mechanics.inertia import balance
from viscorod.mechanics.internal_force import Points, conserve_energy, internal_forces
from viscorod.mechanics.linearised import Operators, add_frozen_forces
from viscorod.mechanics.loading import add_nodal_loads, add_station_load
from viscorod.mechanics.motion import place, place_stages
from viscorod.solve.integrators.stage_data import Body, Ends, Given, Stages, Work
from viscorod.solve.integrators.tableau import Tableau
from viscorod.typing import Floats


@inlined
def points_of(stages: Stages, i: int) -> Points:
    """Return the Gauss points of stage ``i``."""
    return Points(stages.strain[i], stages.strain_rate[i], stages.section_force[i], stages.stress[i])


@inlined
def evaluate_loads(body: Body, given: Given, stages: Stages, i: int, work: Work) -> None:
    """External loads at stage ``i`` (body components)."""
    r, q, external = stages.r[i], stages.q[i], stages.external[i]
    external[:, :] = 0.0
    if given.acting[i] != 0.0:
        add_nodal_loads(
            body.loaded,
            q,
            given.dead[i],
            given.following[i],
            given.gravity[i],
            body.mass,
            False,
            external,
            work.band,
            0,
        )
    elements = body.elements
    for load in range(given.element.shape[1]):
        e = given.element[i, load]
        if e >= 0:
            m = elements.order[e] + 1
            add_station_load(
                elements.nodes[e, :m],
                elements.links[e, :m],
                elements.link_positions,
                elements.link_quaternions,
                given.shape[i, load, :m],
                given.point_dead[i, load],
                given.point_following[i, load],
                r,
                q,
                False,
                external,
                work.band,
                0,
            )


@inlined
def impose(body: Body, given: Given, stages: Stages, i: int, work: Work) -> None:
    """Replace the supported rows of the residual of stage ``i``; keeps the reactions."""
    supports.impose(
        body.nodes,
        body.fixed,
        body.axes,
        body.r0,
        body.q0,
        given.target[i],
        stages.r[i],
        stages.q[i],
        False,
        stages.residual[i],
        stages.reaction[i],
        work.band,
        0,
        0,
    )


@inlined
def hold(body: Body, given: Given, stages: Stages, i: int) -> None:
    """Put completely held nodes where their supports are at stage ``i``."""
    for m in range(body.nodes.shape[0]):
        if body.complete[m] != 0.0:
            k = body.nodes[m]
            for a in range(3):
                stages.r[i, k, a] = given.r[i, m, a]
            for a in range(4):
                stages.q[i, k, a] = given.q[i, m, a]
            for a in range(6):
                stages.twist[i, k, a] = given.twist[i, m, a]
                stages.acceleration[i, k, a] = given.twist_rate[i, m, a]


@inlined
def reach_end(
    body: Body,
    given: Given,
    r0: Floats,
    q0: Floats,
    X: Floats,
    ends: Ends,
    work: Work,
) -> None:
    """Poses and strains at the end of a step of the midpoint rule, where the coordinates are ``2 X``."""
    rate = work.rate[0]
    double = work.change[0]
    for k in range(X.shape[0]):
        for a in range(6):
            double[a] = 2.0 * X[k, a]
            rate[a] = 0.0
        if body.held[k] == 0.0:
            place(r0[k], q0[k], double, rate, body.split[k] != 0.0, ends.r[k], ends.q[k], ends.twist[k])
    for m in range(body.nodes.shape[0]):
        if body.complete[m] != 0.0:
            k = body.nodes[m]
            for a in range(3):
                ends.r[k, a] = given.end_r[m, a]
            for a in range(4):
                ends.q[k, a] = given.end_q[m, a]
    points = Points(ends.strain, ends.strain_rate, ends.section_force, ends.stress)
    internal_forces(body.elements, ends.r, ends.q, ends.twist, points, False, work.element, ends.force)


@inlined
def hold_ends(body: Body, given: Given, stages: Stages, ends: Ends, work: Work) -> None:
    """Ask held nodes to be at their targets at the end of the step rather than in its middle."""
    residual = work.vector
    reaction = work.reaction
    residual[:, :] = 0.0
    supports.impose(
        body.nodes,
        body.fixed,
        body.axes,
        body.r0,
        body.q0,
        given.target[0],
        ends.r,
        ends.q,
        False,
        residual,
        reaction,
        work.band,
        0,
        0,
    )
    for m in range(body.nodes.shape[0]):
        for a in range(6):
            if body.fixed[m, a] != 0.0:
                stages.residual[0, body.nodes[m], a] = 0.5 * residual[body.nodes[m], a]


@inlined
def evaluate(
    body: Body,
    given: Given,
    r0: Floats,
    q0: Floats,
    twist0: Floats,
    h: float,
    tableau: Tableau,
    operators: Operators,
    stages: Stages,
    ends: Ends,
    work: Work,
    final: bool,
) -> None:
    """Compute the residual of all stages from their coordinates ``X``; ``r0, q0, twist0`` is the start of the step."""
    X, twist = stages.X, stages.twist
    s, n = X.shape[0], X.shape[1]
    place_stages(
        r0,
        q0,
        twist0,
        X,
        tableau.derivative,
        h,
        body.split,
        body.held,
        stages.r,
        stages.q,
        twist,
        stages.acceleration,
    )
    for i in range(s):
        hold(body, given, stages, i)
        points = points_of(stages, i)
        internal_forces(
            body.elements, stages.r[i], stages.q[i], twist[i], points, True, work.element, stages.internal[i]
        )
        if ends.active:
            reach_end(body, given, r0, q0, X[i], ends, work)
            conserve_energy(
                body.elements,
                stages.strain[i],
                stages.strain_rate[i],
                ends.start_strain,
                ends.strain,
                h,
                stages.section_force[i],
            )
        evaluate_loads(body, given, stages, i, work)
        residual = stages.residual[i]
        balance(
            body.mass,
            twist[i],
            stages.acceleration[i],
            stages.internal[i],
            stages.external[i],
            stages.force[i],
            residual,
        )
        if not final:
            add_frozen_forces(body.elements, operators, stages.section_force[i], stages.stress[i], residual)
        if final:
            power = 0.0
            for m in range(body.nodes.shape[0]):
                if body.complete[m] != 0.0:
                    for a in range(6):
                        power += residual[body.nodes[m], a] * twist[i, body.nodes[m], a]
            stages.held_power[i] = power
        if final or body.partly:
            impose(body, given, stages, i, work)
        for k in range(n):
            if body.held[k] != 0.0:
                for a in range(6):
                    residual[k, a] = 0.0
        if ends.active:
            hold_ends(body, given, stages, ends, work)

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
from viscorod.mechanics.compiled import kernel
from viscorod.mechanics.internal_force import Points, conserve_energy, internal_forces
from viscorod.mechanics.linearised import Operators, add_frozen_forces
from viscorod.mechanics.loading import add_nodal_loads, add_station_load
from viscorod.mechanics.motion import place
from viscorod.solve.integrators.stage_data import Body, Ends, Given, Stages, Work
from viscorod.solve.integrators.tableau import Tableau
from viscorod.typing import Floats


@kernel
def points_of(stages: Stages, i: int) -> Points:
    """Return the Gauss points of stage ``i``."""
    return Points(stages.strain[i], stages.strain_rate[i], stages.section_force[i], stages.stress[i])


@kernel
def evaluate_forces(body: Body, given: Given, stages: Stages, i: int, mixed: bool, work: Work) -> None:
    """Internal and external forces of stage ``i``, and ``force``: what accelerates the nodes (body components).

    With ``mixed`` the internal forces are those of the stress iterate.
    """
    r, q, twist = stages.r[i], stages.q[i], stages.twist[i]
    internal, external, force = stages.internal[i], stages.external[i], stages.force[i]
    internal_forces(body.elements, r, q, twist, points_of(stages, i), mixed, work.element, internal)
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
    for k in range(r.shape[0]):
        v0, v1, v2, w0, w1, w2 = twist[k]
        M = body.mass[k]
        p0 = M[0, 0] * v0 + M[0, 1] * v1 + M[0, 2] * v2 + M[0, 3] * w0 + M[0, 4] * w1 + M[0, 5] * w2
        p1 = M[1, 0] * v0 + M[1, 1] * v1 + M[1, 2] * v2 + M[1, 3] * w0 + M[1, 4] * w1 + M[1, 5] * w2
        p2 = M[2, 0] * v0 + M[2, 1] * v1 + M[2, 2] * v2 + M[2, 3] * w0 + M[2, 4] * w1 + M[2, 5] * w2
        h0 = M[3, 0] * v0 + M[3, 1] * v1 + M[3, 2] * v2 + M[3, 3] * w0 + M[3, 4] * w1 + M[3, 5] * w2
        h1 = M[4, 0] * v0 + M[4, 1] * v1 + M[4, 2] * v2 + M[4, 3] * w0 + M[4, 4] * w1 + M[4, 5] * w2
        h2 = M[5, 0] * v0 + M[5, 1] * v1 + M[5, 2] * v2 + M[5, 3] * w0 + M[5, 4] * w1 + M[5, 5] * w2
        for a in range(6):
            force[k, a] = external[k, a] - internal[k, a]
        force[k, 0] -= w1 * p2 - w2 * p1
        force[k, 1] -= w2 * p0 - w0 * p2
        force[k, 2] -= w0 * p1 - w1 * p0
        force[k, 3] -= v1 * p2 - v2 * p1 + w1 * h2 - w2 * h1
        force[k, 4] -= v2 * p0 - v0 * p2 + w2 * h0 - w0 * h2
        force[k, 5] -= v0 * p1 - v1 * p0 + w0 * h1 - w1 * h0


@kernel
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


@kernel
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


@kernel
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


@kernel
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


@kernel
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
    X, twist, acceleration = stages.X, stages.twist, stages.acceleration
    s, n = X.shape[0], X.shape[1]
    rate = work.rate[0]
    D = tableau.derivative
    for i in range(s):
        for k in range(n):
            if body.held[k] != 0.0:
                continue
            for a in range(6):
                total = 0.0
                for j in range(s):
                    total += D[i, j] * X[j, k, a]
                rate[a] = total / h
            place(
                r0[k],
                q0[k],
                X[i, k],
                rate,
                body.split[k] != 0.0,
                stages.r[i, k],
                stages.q[i, k],
                twist[i, k],
            )
    for i in range(s):
        for k in range(n):
            for a in range(6):
                total = 0.0
                for j in range(s):
                    total += D[i, j] * (twist[j, k, a] - twist0[k, a])
                acceleration[i, k, a] = total / h
        hold(body, given, stages, i)
    for i in range(s):
        evaluate_forces(body, given, stages, i, True, work)
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
        residual = stages.residual[i]
        for k in range(n):
            M = body.mass[k]
            for a in range(6):
                total = -stages.force[i, k, a]
                for b in range(6):
                    total += M[a, b] * acceleration[i, k, b]
                residual[k, a] = total
        if not final:
            add_frozen_forces(body.elements, operators, stages.section_force[i], stages.stress[i], residual)
        power = 0.0
        for m in range(body.nodes.shape[0]):
            if body.complete[m] != 0.0:
                for a in range(6):
                    power += residual[body.nodes[m], a] * twist[i, body.nodes[m], a]
        stages.held_power[i] = power
        impose(body, given, stages, i, work)
        if ends.active:
            hold_ends(body, given, stages, ends, work)

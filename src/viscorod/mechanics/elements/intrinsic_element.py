"""The intrinsic element: strains at the Gauss points are states, advanced by the nodal body twists.

Hodges' equations as Artola, Wynn and Palacios write them (AWP 13-14, full Kelvin-Voigt damping; 22-23, linearised).
Body twists ``x1 = (v, w)`` are interpolated in body components by the basis of order p, strains are given at the p
Gauss points, and compatibility holds there:

    eps_t = x1' - E^T x1 + L1(x1)^T eps = b + (kappa x v + gamma x w, kappa x w)     b = x1' + (U0 x v + V0 x w, U0 x w)

Tested with the same interpolation, the section forces give ``f_k = sum_g w_g [N'_k S + N_k (-U x N, -V x N - U x M)]``,
so ``sum_k f_k . x1_k = sum_g w_g S . eps_t`` holds exactly: the energy balance is exact in space. Linearised damping
applies the viscous force ``D b`` through ``U0, V0`` instead of ``U, V``; it dissipates ``b . D b`` (AWP 32).

The equations contain no pose: rigid rotations are in the twists alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, lane_kernel, part
from viscorod.mechanics.elements.internal_force import Elements, GaussStates, scatter
from viscorod.mechanics.elements.rest_strains import section_forces, shift
from viscorod.mechanics.nodes.attached_poses import attached_twist
from viscorod.mechanics.rotations.vectors import (
    Vector,
    cross,
    difference,
    entries,
    plus,
    put,
    quaternion,
    stage_vector,
    vector,
)
from viscorod.typing import Floats, Integers


class StrainMotion(NamedTuple):
    """Strains as states: their values at the start of a step, and the arrays that the step works with.

    Attributes:
        linearised: viscous forces are those of the linearised damping.
        start: strains at the start of the step ``(e, points, 6)``.
        twist: body twists at the Gauss points of the stages ``(s, e, points, 6)``.
        linear_rate: ``b``, the strain rate of the unstrained rod, likewise.
        nodes, forces: scratch of one element ``(m, 6)``; matrix: ``(3 s, 3 s)``; right: ``(3 s,)``.
        rest, rest_rate: rest strains that change with time, of the stages ``(s, e, points, 6)``; no stages if there
            are none. The strains of the other arrays contain them, those of Gauss points do not.
    """

    linearised: bool
    start: Floats
    twist: Floats
    linear_rate: Floats
    nodes: Floats
    forces: Floats
    matrix: Floats
    right: Floats
    rest: Floats
    rest_rate: Floats

    @classmethod
    def of(cls, elements: Elements, stages: int, *, linearised: bool) -> StrainMotion:
        """Allocate the arrays for a number of stages, without rest strains that change."""
        points, m = elements.reference.shape, elements.nodes.shape[1]
        return cls(
            linearised,
            np.zeros(points),
            np.zeros((stages, *points)),
            np.zeros((stages, *points)),
            np.zeros((m, 6)),
            np.zeros((m, 6)),
            np.zeros((3 * stages, 3 * stages)),
            np.zeros(3 * stages),
            np.zeros((0, *points)),
            np.zeros((0, *points)),
        )

    @classmethod
    def none(cls) -> StrainMotion:
        """Return those of elements whose strains follow from poses."""
        at_start, at_stages, of_element = np.zeros((0, 0, 6)), np.zeros((0, 0, 0, 6)), np.zeros((0, 6))
        matrix, right = np.zeros((0, 0)), np.zeros(0)
        rest = (at_stages, at_stages)
        return cls(False, at_start, at_stages, at_stages, of_element, of_element, matrix, right, *rest)


@part
def interpolate_twists(
    elements: Elements, twist: Floats, T: Floats, at_points: Floats, linear_rate: Floats
) -> None:
    """Write the body twists at all Gauss points, and ``b``, of some states.

    Args:
        twist: of all nodes ``(s, n, 6)``; T: scratch ``(m, 6)``.
        at_points, linear_rate: outputs ``(s, e, points, 6)``.
    """
    orders, nodes, links, link_positions, link_quaternions, shapes, slopes = elements[:7]
    half_lengths, reference = elements[8], elements[13]
    for s in range(twist.shape[0]):
        for e in range(orders.shape[0]):
            order = orders[e]
            gather_twists(s, order + 1, nodes[e], links[e], link_positions, link_quaternions, twist, T)
            for g in range(order):
                v, w, dv, dw = ((0.0, 0.0, 0.0),) * 4
                for k in range(order + 1):
                    n, d = shapes[order, g, k], slopes[order, g, k] / half_lengths[e]
                    v, w = plus(v, n, vector(T, k, 0)), plus(w, n, vector(T, k, 3))
                    dv = plus(dv, d, difference(vector(T, k, 0), vector(T, 0, 0)))
                    dw = plus(dw, d, difference(vector(T, k, 3), vector(T, 0, 3)))
                V0, U0 = entries(reference[e, g], 0), entries(reference[e, g], 3)
                put(linear_rate[s, e], g, 0, plus(plus(dv, 1.0, cross(U0, v)), 1.0, cross(V0, w)))
                put(linear_rate[s, e], g, 3, plus(dw, 1.0, cross(U0, w)))
                put(at_points[s, e], g, 0, v)
                put(at_points[s, e], g, 3, w)


@part
def gather_twists(
    s: int,
    count: int,
    nodes: Integers,
    links: Integers,
    link_positions: Floats,
    link_quaternions: Floats,
    twist: Floats,
    T: Floats,
) -> None:
    """Write the twists of an element's nodes in state ``s``, attachments applied ``(m, 6)``."""
    for k in range(count):
        n, link = nodes[k], links[k]
        v, w = stage_vector(twist, s, n, 0), stage_vector(twist, s, n, 3)
        if link >= 0:
            d, own = vector(link_positions, link, 0), quaternion(link_quaternions, link)
            v, w = attached_twist(d, own, v, w)
        put(T, k, 0, v)
        put(T, k, 3, w)


@part
def viscous_rates(linearised: bool, strain: Floats, twist: Floats, linear_rate: Floats, out: Floats) -> None:
    """Write the strain rates in the law of damping at all Gauss points ``(s, e, points, 6)``.

    They are ``eps_t = b + (kappa x v + gamma x w, kappa x w)``, or ``b`` if linearised.
    """
    for s in range(out.shape[0]):
        for e in range(out.shape[1]):
            for g in range(out.shape[2]):
                if linearised:
                    for i in range(6):
                        out[s, e, g, i] = linear_rate[s, e, g, i]
                    continue
                gamma, kappa = vector(strain[s, e], g, 0), vector(strain[s, e], g, 3)
                v, w = vector(twist[s, e], g, 0), vector(twist[s, e], g, 3)
                V_rate = plus(vector(linear_rate[s, e], g, 0), 1.0, cross(kappa, v))
                put(out[s, e], g, 0, plus(V_rate, 1.0, cross(gamma, w)))
                put(out[s, e], g, 3, plus(vector(linear_rate[s, e], g, 3), 1.0, cross(kappa, w)))


@part
def solve_stages(matrix: Floats, right: Floats, size: int, factorise: bool) -> None:
    """Solve ``matrix x = right`` in place, without pivoting since the matrix is near a constant of the method.

    Without ``factorise`` the matrix already contains its factors.
    """
    if factorise:
        for j in range(size):
            inverse = 1.0 / matrix[j, j]
            for i in range(j + 1, size):
                factor = matrix[i, j] * inverse
                matrix[i, j] = factor
                if factor != 0.0:
                    for k in range(j + 1, size):
                        matrix[i, k] -= factor * matrix[j, k]
    for i in range(size):
        for j in range(i):
            right[i] -= matrix[i, j] * right[j]
    for back in range(size):
        i = size - 1 - back
        for j in range(i + 1, size):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]


@part
def advance_strains(
    elements: Elements,
    D: Floats,
    h: float,
    start: Floats,
    twist: Floats,
    linear_rate: Floats,
    matrix: Floats,
    right: Floats,
    strain: Floats,
) -> None:
    """Integrate compatibility over a step by the collocation method: write the strains at all stages.

    ``sum_j d_ij (eps_j - eps_0)/h = eps_t(eps_i, x1_i)`` is linear in the strains: with ``d = eps - eps_0``

        sum_j d_ij dU_j + h w_i x dU_i = h (b_U + kappa_0 x w)_i
        sum_j d_ij dV_j + h w_i x dV_i = h (b_V + kappa_i x v_i + gamma_0 x w_i)

    Args:
        D: derivatives from stage values ``(s, s)``; h: step [s]; start: strains at its start ``(e, points, 6)``.
        twist, linear_rate: from :func:`interpolate_twists` ``(s, e, points, 6)``; strain: output, likewise.
        matrix, right: scratch ``(3 s, 3 s)``, ``(3 s,)``.
    """
    stages = twist.shape[0]
    size = 3 * stages
    for e in range(elements.order.shape[0]):
        for g in range(elements.order[e]):
            for i in range(stages):
                for a in range(3):
                    for j in range(stages):
                        for b in range(3):
                            matrix[3 * i + a, 3 * j + b] = D[i, j] if a == b else 0.0
                for a in range(3):
                    b, c = (a + 1) % 3, (a + 2) % 3
                    matrix[3 * i + a, 3 * i + b] -= h * twist[i, e, g, 3 + c]
                    matrix[3 * i + a, 3 * i + c] += h * twist[i, e, g, 3 + b]
                    right[3 * i + a] = h * (
                        linear_rate[i, e, g, 3 + a]
                        + start[e, g, 3 + b] * twist[i, e, g, 3 + c]
                        - start[e, g, 3 + c] * twist[i, e, g, 3 + b]
                    )
            solve_stages(matrix, right, size, True)
            for i in range(stages):
                for a in range(3):
                    strain[i, e, g, 3 + a] = start[e, g, 3 + a] + right[3 * i + a]
            for i in range(stages):
                for a in range(3):
                    b, c = (a + 1) % 3, (a + 2) % 3
                    right[3 * i + a] = h * (
                        linear_rate[i, e, g, a]
                        + strain[i, e, g, 3 + b] * twist[i, e, g, c]
                        - strain[i, e, g, 3 + c] * twist[i, e, g, b]
                        + start[e, g, b] * twist[i, e, g, 3 + c]
                        - start[e, g, c] * twist[i, e, g, 3 + b]
                    )
            solve_stages(matrix, right, size, False)
            for i in range(stages):
                for a in range(3):
                    strain[i, e, g, a] = start[e, g, a] + right[3 * i + a]


@part
def nodal_forces(
    elements: Elements,
    linearised: bool,
    strain: Floats,
    strain_rate: Floats,
    sigma: Floats,
    F: Floats,
    force: Floats,
) -> None:
    """Write the internal forces ``(s, n, 6)`` of section forces ``sigma (s, e, points, 6)``, body components.

    With linearised damping, ``sigma - D b`` acts through the strains and ``D b`` through those of the reference shape.
    """
    orders, nodes, links, link_positions, link_quaternions, shapes, slopes, weights = elements[:8]
    half_lengths, section, D, reference = elements[8], elements[9], elements[11], elements[13]
    for s in range(force.shape[0]):
        for n in range(force.shape[1]):
            for i in range(6):
                force[s, n, i] = 0.0
        for e in range(orders.shape[0]):
            order = orders[e]
            for k in range(order + 1):
                for i in range(6):
                    F[k, i] = 0.0
            for g in range(order):
                N, M = vector(sigma[s, e], g, 0), vector(sigma[s, e], g, 3)
                # the parts due to the curvature of the reference shape
                f, m = curved_forces(vector(reference[e], g, 0), vector(reference[e], g, 3), N, M)
                if linearised:
                    of = section[e, g]
                    for j in range(6):
                        rate = strain_rate[s, e, g, j]
                        N = plus(N, -rate, (D[of, 0, j], D[of, 1, j], D[of, 2, j]))
                        M = plus(M, -rate, (D[of, 3, j], D[of, 4, j], D[of, 5, j]))
                df, dm = curved_forces(vector(strain[s, e], g, 0), vector(strain[s, e], g, 3), N, M)
                f, m = plus(f, 1.0, df), plus(m, 1.0, dm)
                weight = weights[order, g] * half_lengths[e]
                N, M = vector(sigma[s, e], g, 0), vector(sigma[s, e], g, 3)
                for k in range(order + 1):
                    n, d = weight * shapes[order, g, k], weights[order, g] * slopes[order, g, k]
                    put(F, k, 0, plus(plus(vector(F, k, 0), d, N), n, f))
                    put(F, k, 3, plus(plus(vector(F, k, 3), d, M), n, m))
            scatter(s, order + 1, nodes[e], links[e], link_positions, link_quaternions, F, force)


@lane_kernel
def curved_forces(V: Vector, U: Vector, N: Vector, M: Vector) -> tuple[Vector, Vector]:
    """Return ``(-U x N, -V x N - U x M)``: forces and moments per length of section forces on a curved rod."""
    return cross(N, U), plus(cross(N, V), 1.0, cross(M, U))


@kernel
def forces_at(
    elements: Elements,
    motion: StrainMotion,
    twist: Floats,
    strain: Floats,
    strain_rate: Floats,
    prestress: Floats,
    section_force: Floats,
    force: Floats,
) -> None:
    """Write strain rates, section forces and internal forces of a state with known strains.

    Args:
        motion: scratch for one state; twist: of all nodes ``(1, n, 6)``; strain: ``(1, e, points, 6)``.
        strain_rate: output, the rate in the law of damping; prestress: section forces besides ``C eps + D eps_t``
            ``(e, points, 6)``.
        section_force: output like the strain; force: output ``(1, n, 6)``.
    """
    linearised, _, at_points, linear_rate, T, F, _, _, rest, rest_rate = motion
    interpolate_twists(elements, twist, T, at_points, linear_rate)
    shift(1.0, rest, strain)
    viscous_rates(linearised, strain, at_points, linear_rate, strain_rate)
    shift(-1.0, rest, strain)
    shift(-1.0, rest_rate, strain_rate)
    section_forces(elements, strain, strain_rate, section_force)
    for e in range(prestress.shape[0]):
        for g in range(prestress.shape[1]):
            for a in range(6):
                section_force[0, e, g, a] += prestress[e, g, a]
    shift(1.0, rest, strain)
    nodal_forces(elements, linearised, strain, strain_rate, section_force, F, force)
    shift(-1.0, rest, strain)


@part
def stage_forces(
    elements: Elements,
    motion: StrainMotion,
    D: Floats,
    h: float,
    twist: Floats,
    points: GaussStates,
    force: Floats,
) -> None:
    """Write strains, the rates of damping, section forces and the forces of the stress at all stages of a step.

    Args:
        D: derivatives from stage values ``(s, s)``; h: step [s]; twist: of all nodes ``(s, n, 6)``.
        points: outputs ``(s, e, points, 6)``, but for the stress; force: output ``(s, n, 6)``.
    """
    linearised, start, at_points, linear_rate, T, F, matrix, right, rest, rest_rate = motion
    strain, strain_rate, section_force, sigma = points
    interpolate_twists(elements, twist, T, at_points, linear_rate)
    advance_strains(elements, D, h, start, at_points, linear_rate, matrix, right, strain)
    viscous_rates(linearised, strain, at_points, linear_rate, strain_rate)
    nodal_forces(elements, linearised, strain, strain_rate, sigma, F, force)
    shift(-1.0, rest, strain)
    shift(-1.0, rest_rate, strain_rate)
    section_forces(elements, strain, strain_rate, section_force)

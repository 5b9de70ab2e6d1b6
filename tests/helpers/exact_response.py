"""Exact responses of damped bars and beams, by which those of the package are judged."""

import numpy as np


def bar_receptance(omega, length, area, density, modulus):
    """Return the end displacement over an axial end force of a clamped bar with a complex modulus.

    ``EA u'' + rho A omega^2 u = 0``: tan(k L)/(E A k) with k^2 = rho omega^2/E.
    """
    k = omega * np.sqrt(density / modulus)
    return np.tan(k * length) / (modulus * area * k)


def timoshenko_fields(omega, length, stiffness, inertia):
    """Return ``(w, psi, M, Q)`` at the end for unit values of each at the start, (4, 4), complex.

    ``w' = psi + Q/kGA, psi' = M/EI, M' = -Q - rho I omega^2 psi, Q' = -rho A omega^2 w`` (Timoshenko 1921), solved by
    the exponential of the matrix.

    Args:
        stiffness: EI and kGA, complex; inertia: rho A and rho I.
    """
    from scipy.linalg import expm

    bending, shear = stiffness
    mass, rotary = inertia
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 1.0 / shear],
            [0.0, 0.0, 1.0 / bending, 0.0],
            [0.0, -rotary * omega**2, 0.0, -1.0],
            [-mass * omega**2, 0.0, 0.0, 0.0],
        ],
        dtype=complex,
    )
    return expm(matrix * length)


def cantilever_receptance(omega, length, stiffness, inertia):
    """Return deflection and rotation of the end over a force at it (2,) of a clamped Timoshenko beam."""
    fields = timoshenko_fields(omega, length, stiffness, inertia)
    start = np.linalg.solve(fields[2:, 2:], [0.0, 1.0])
    return fields[:2, 2:] @ start


def shaken_cantilever(omega, length, stiffness, inertia):
    """Return the deflection of the free end over that of the clamp."""
    fields = timoshenko_fields(omega, length, stiffness, inertia)
    start = np.linalg.solve(fields[2:, 2:], -fields[2:, 0])
    return fields[0, 0] + fields[0, 2:] @ start

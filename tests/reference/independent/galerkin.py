"""What the independent solutions share: Galerkin forms on dense bases, and Radau IIA in time.

A semi-discrete beam is ``M y_t = A y + sum of forms``, M and A constant and M perhaps singular. A form is
``int test . flux(fields) ds``: fields are linear in y, the flux is a function at a point. Derivatives of fluxes
come from complex steps, exact to round-off, so that no tangent has to be derived by hand.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

Array = NDArray[np.floating[Any]]
Values = NDArray[Any]  # real, or complex in a complex step
Flux = Callable[[Values], Sequence[Values]]
Damping = Literal["full", "linearised"]


@dataclass(frozen=True)
class Field:
    """Values ``basis @ y[block]`` at the points of a form; the same object serves as a test function."""

    block: slice
    basis: Array


@dataclass(frozen=True)
class Form:
    """``int test . flux(fields) ds`` by quadrature; a single point of weight one is a point load."""

    fields: Sequence[Field]
    tests: Sequence[Field]
    flux: Flux
    weights: Array

    def values(self, y: Array) -> Array:
        """Give the fields at the points, one row a field."""
        return np.stack([f.basis @ y[f.block] for f in self.fields])

    def add(self, y: Array, out: Array) -> None:
        """Add the form to the right-hand side."""
        for test, flux in zip(self.tests, self.flux(self.values(y)), strict=True):
            out[test.block] += test.basis.T @ (self.weights * flux)

    def add_jacobian(self, y: Array, out: Array) -> None:
        """Add the derivative of the form with respect to y."""
        values, step = self.values(y), 1e-40
        for j, field in enumerate(self.fields):
            shifted = values.astype(complex)
            shifted[j] += 1j * step
            for test, flux in zip(self.tests, self.flux(shifted), strict=True):
                slope = self.weights * np.imag(flux) / step
                if slope.any():
                    out[test.block, field.block] += test.basis.T @ (slope[:, None] * field.basis)


@dataclass(frozen=True)
class System:
    """``mass @ y_t = linear @ y + forms + load(t)`` from the state ``start``; ``scale``: the size of each unknown."""

    mass: Array
    linear: Array
    forms: Sequence[Form]
    load: Callable[[float], Form]
    start: Array
    scale: Array

    def right_hand_side(self, load: Form, y: Array) -> Array:
        """Evaluate the right-hand side under a load."""
        out = self.linear @ y
        for form in (*self.forms, load):
            form.add(y, out)
        return out

    def jacobian(self, load: Form, y: Array) -> Array:
        """Evaluate the derivative of the right-hand side."""
        out = self.linear.copy()
        for form in (*self.forms, load):
            form.add_jacobian(y, out)
        return out


def radau(system: System, times: Array, steps: int, tolerance: float = 1e-11) -> Array:
    """Integrate by the three-stage Radau IIA method, ``steps`` equal steps between two ``times``; states at the times.

    Order five, also for the differential unknowns of an index-2 system (Hairer, Wanner, Solving Ordinary
    Differential Equations II, IV.8 and VII.4). Simplified Newton; the stage system splits into one real and one
    complex system through the eigenvectors of A^-1. No step control: convergence is seen by doubling ``steps``.
    """
    r = np.sqrt(6)
    c = np.array([(4 - r) / 10, (4 + r) / 10, 1])
    # collocation: A integrates the polynomial through the values at c
    powers = np.arange(3)
    inverse = np.linalg.inv((c[:, None] ** (powers + 1) / (powers + 1)) @ np.linalg.inv(c[:, None] ** powers))
    eigenvalues, vectors = np.linalg.eig(inverse)
    order = np.argsort(np.abs(eigenvalues.imag))  # the real one first, then the pair
    eigenvalues, vectors = eigenvalues[order], vectors[:, order]
    back = np.linalg.inv(vectors)
    # values at the next stages of the polynomial through 0 and the three stages
    nodes = np.append(0.0, c)
    extrapolate = ((1 + c)[:, None] ** np.arange(4)) @ np.linalg.inv(nodes[:, None] ** np.arange(4))

    y, z, factors, factored = system.start.copy(), np.zeros((3, system.start.size)), [], 0.0
    states = [y]
    for t0, t1 in pairwise(times):
        h = (t1 - t0) / steps
        for k in range(steps):
            t, last = t0 + k * h, z
            loads = [system.load(t + fraction * h) for fraction in c]
            for attempt in range(2):  # first with the tangent at hand, then with a new one
                if attempt or not np.isclose(h, factored, rtol=1e-9):
                    jacobian = system.jacobian(loads[0], y)
                    factors = [
                        lu_factor((lam.real if i == 0 else lam) * system.mass - h * jacobian)
                        for i, lam in enumerate(eigenvalues[:2])
                    ]
                    factored = h
                # the extrapolation is of values, z counts from the start of the step
                z = extrapolate[:, 1:] @ last - last[-1]
                change, done = np.inf, False
                for _ in range(8 if attempt == 0 else 20):
                    slopes = np.stack([system.right_hand_side(loads[i], y + z[i]) for i in range(3)])
                    residual = h * slopes - inverse @ (z @ system.mass.T)
                    first, second = back[:2] @ residual
                    w0 = lu_solve(factors[0], first.real)
                    w1 = lu_solve(factors[1], second)
                    dz = np.outer(vectors[:, 0].real, w0) + 2 * np.real(np.outer(vectors[:, 1], w1))
                    z = z + dz
                    previous, change = change, np.abs(dz / system.scale).max()
                    if change < tolerance:
                        done = True
                        break
                    if change > 2 * previous:
                        break
                if done:
                    break
            else:
                raise ArithmeticError(
                    f"Newton iteration failed at t = {t:.4f}: change {change:.1e}; use more steps"
                )
            y = y + z[-1]
        states.append(y)
    return np.stack(states)


def gauss(edges: Array, count: int) -> tuple[Array, Array]:
    """Points and weights of Gauss quadrature on each interval between the edges."""
    x, w = legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2
    return ((edges[:-1, None] + half) + half * x).ravel(), (half * w).ravel()


def polynomials(points: Array, length: float, count: int) -> Array:
    """Legendre polynomials of degree below ``count`` on [0, length], one row a point."""
    return legendre.legvander(2 * np.asarray(points) / length - 1, count - 1)


def integrals(points: Array, length: float, count: int) -> Array:
    """Integrals from 0 of the same polynomials: they vanish at 0, their derivatives are ``polynomials``."""
    P, k = polynomials(points, length, count + 1), np.arange(1, count)
    return length / 2 * np.column_stack([P[:, 0] + P[:, 1], (P[:, 2:] - P[:, :-2]) / (2 * k + 1)])


def blocks(*sizes: int, scalars: int) -> list[Any]:
    """Slices of consecutive blocks, then a list of one-number slices, then the total."""
    edges = np.concatenate([[0], np.cumsum(sizes)])
    total = int(edges[-1])
    parts: list[Any] = [slice(int(a), int(b)) for a, b in pairwise(edges)]
    return [*parts, [slice(total + i, total + i + 1) for i in range(scalars)], total + scalars]

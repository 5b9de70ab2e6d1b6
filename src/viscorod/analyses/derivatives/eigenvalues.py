"""How small vibrations change with numbers of the case, by the vectors from both sides.

With ``P(s) x = 0`` and ``y* P(s) = 0``, conditions of joints and held strains bordering ``P``, a simple eigenvalue
changes by ``ds = -y* dP(s) x/(y* P'(s) x)`` (Lancaster 1964). ``dP`` is the derivative of the matrices along the
equilibrium that changes too. Of eigenvalues that fall together only the mean has such a derivative.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse

from viscorod.analyses.derivatives.differentiate import record_static
from viscorod.analyses.derivatives.mode_shapes import SHAPES, MovingVectors, ShapeRate, ShapeRates
from viscorod.analyses.derivatives.neighbours import MANY, STEP, Neighbour, Neighbours
from viscorod.analyses.derivatives.static_changes import Instant, StaticChange
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.start_state import StartState
from viscorod.errors import Fault, InputError, SolveError, warn
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.dataset import dataset_beside
from viscorod.results.derivative import Derivative, Part
from viscorod.results.modes_result import Modes
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.linear_systems.dynamic_stiffness import aligned
from viscorod.solve.linear_systems.small_motions import SmallMotions, small_motions
from viscorod.solve.problem.element_arrays import gauss_positions
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.start import Start
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Pencil", "groups_of", "modes_derivatives"]

TOGETHER = 1e-6
"""Distance of eigenvalues that fall together, as a part of them."""
ROUNDS = 4
"""Inverse iterations from an eigenvalue that is known to round-off."""
OUTSIDE = 1e-9
"""Part of an eigenvalue by which the matrix is taken beside it: it is singular there."""
UNKNOWN = ("mode_share", "mode_residual", "mode_error")
"""What has no derivatives here."""
UNCERTAIN = 1e-8
"""Error in the derivatives, over the largest of them, from which on a number changes more, or less."""
ALIKE = 0.5
"""Logarithm of the ratio of two distances that hardly differ in what they leave."""
FARTHEST = 32.0
"""By how many times at most."""
EPSILON = float(np.finfo(float).eps)


def modes_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: ModesSettings,
    result: Modes,
    keys: Sequence[str],
) -> dict[str, Derivative[Modes]]:
    """Return the derivatives of eigenvalues, and of the state that they are about."""
    if not isinstance(settings.about, str):
        why = "modes about an earlier state have no derivatives here"
        raise InputError(Fault("derivatives", ", ".join(keys), why, "give about as a word"))
    loaded = settings.about != "reference"
    at = Instant(before=settings.about != "released", scale=float(loaded))
    change = _change(discrete, result, at) if loaded else None
    state = State.reference(discrete.problem) if change is None else change.state
    pencil = Pencil.of(discrete.static, state, at)
    groups = groups_of(result.eigenvalues, result.rigid)
    vectors = [pencil.vectors(complex(np.mean(result.eigenvalues[group])), len(group)) for group in groups]
    shapes = ShapeRates(
        {
            group[0]: ShapeRate(pencil, s, right[:, 0])
            for group, (s, right, _, _) in zip(groups, vectors, strict=True)
            if len(group) == 1
        },
        result,
    )
    sizes = [pencil.magnitudes(s, right, left) for s, right, left, _ in vectors]
    first, found = _first_distance(vectors, sizes), {}
    for key in keys:
        rates = _Rates(Neighbours.of(model, key, discrete, many=first), change, at, vectors, sizes)
        better = rates.better(first)
        if rates.rounding + rates.left > UNCERTAIN and abs(np.log(better / first)) > ALIKE:
            others = _Rates(Neighbours.of(model, key, discrete, many=better), change, at, vectors, sizes)
            rates = min(rates, others, key=lambda one: one.rounding + one.left)
        neighbours, number = rates.neighbours, len(result.eigenvalues)
        slopes, alone = np.zeros(number, dtype=complex), {}
        for group, changed, slope in zip(groups, rates.changed, rates.of_groups, strict=True):
            slopes[group] = slope
            if len(group) == 1:
                alone[group[0]] = changed[:, 0], slope
        moving = MovingVectors(shapes.of, alone)
        histories = [History() for _ in neighbours.each]
        for one, state, history in zip(neighbours.each, rates.states, histories, strict=True):
            record_static(one, state, at, history, at.scale, discrete)
        near = [
            cache(partial(shapes.near, pencil, one.change, moving))
            for one, pencil in zip(neighbours.each, rates.pencils, strict=True)
        ]
        found[key] = _derivative(neighbours, result, histories, slopes, groups, near)
    return found


class _Rates:
    """How eigenvalues change with one number, by neighbours of the model at one distance.

    Args:
        neighbours: of the model; change: of the equilibrium, None for the reference shape; at: its loads.
        vectors: of groups of eigenvalues, see :meth:`Pencil.vectors`; sizes: see :meth:`Pencil.magnitudes`.

    Attributes:
        states, pencils: of the neighbours; changed: rates of the matrices times the right vectors, of each group.
        of_groups: rates of the eigenvalues of each group; rounding: part of the largest that rounding may be.
        left: the same of what the scheme leaves.
    """

    def __init__(
        self,
        neighbours: Neighbours,
        change: StaticChange | None,
        at: Instant,
        vectors: Sequence[tuple[complex, np.ndarray, np.ndarray, np.ndarray]],
        sizes: Sequence[np.ndarray],
    ) -> None:
        self.neighbours, each = neighbours, neighbours.each
        increment = None if change is None else change.increment(neighbours)
        self.states = [
            State.reference(one.problem)
            if change is None or increment is None
            else change.moved(increment, one.change)
            for one in each
        ]
        self.pencils = [
            Pencil.of(one.resting, state, at) for one, state in zip(each, self.states, strict=True)
        ]
        self.changed: list[np.ndarray] = []
        self.of_groups: list[complex] = []
        coarse, noise = [], []
        weights = np.array([one.weight for one in each])
        for (s, right, left, slope), terms in zip(vectors, sizes, strict=True):
            products = np.array([pencil.times(s, right) for pencil in self.pencils])
            changed = np.tensordot(weights, products, 1)

            def rate(changed: np.ndarray, left: np.ndarray = left, slope: np.ndarray = slope) -> complex:
                between = np.linalg.solve(slope, left.conj().T @ changed)
                return complex(-np.trace(between) / len(slope))

            self.changed.append(changed)
            self.of_groups.append(rate(changed))
            coarse.append(rate(np.tensordot(neighbours.rough, products, 1)))
            noise.append(EPSILON * np.abs(weights).max() * float(np.abs(np.linalg.solve(slope, terms)).max()))
        size = max(map(abs, self.of_groups), default=0.0) or 1.0
        self.rounding = max(noise, default=0.0) / size
        apart = [abs(one - other) for one, other in zip(self.of_groups, coarse, strict=True)]
        self.left = (max(apart, default=0.0) / size) ** 2

    def better(self, part: float) -> float:
        """Return by which part of the number neighbours differ that have the least error; these differ by ``part``."""
        return float(np.clip(part * _times(self.rounding, self.left), STEP, FARTHEST * STEP))


def _times(rounding: float, left: float) -> float:
    """Return how many times as far neighbours have the least error.

    Rounding falls with the distance, and what the scheme leaves grows by its fourth power.
    """
    return float((rounding / max(4.0 * left, 1e-30)) ** 0.2)


def _first_distance(
    vectors: Sequence[tuple[complex, np.ndarray, np.ndarray, np.ndarray]], sizes: Sequence[np.ndarray]
) -> float:
    """Return by which part of a number to begin, as far as rounding asks for if eigenvalues go as its root.

    The relative error of two neighbours is about the square of the part then, and that of four the square of this.
    """
    largest = max((abs(s) for s, *_ in vectors), default=0.0)
    if largest == 0.0:
        return STEP
    weight, slope = max(map(abs, MANY[0].weights)) / STEP, 0.5 * largest
    each = [np.abs(np.linalg.solve(by, terms)).max() for (*_, by), terms in zip(vectors, sizes, strict=True)]
    rounding = EPSILON * weight * float(max(each)) / slope
    if rounding <= UNCERTAIN:
        return STEP
    return STEP * min(max(_times(rounding, STEP**4), 1.0), FARTHEST)


def _change(discrete: DiscreteModel, result: Modes, at: Instant) -> StaticChange | None:
    """Return the change of the equilibrium; None where nothing acts on a model that nothing holds."""
    state = StartState(discrete, Start(result=result)).state
    state.twist[:] = 0.0
    try:
        return StaticChange(discrete, state, at)
    except SolveError:
        discrete.static.restore(state, at.t, before=at.before, scale=at.scale)
        if discrete.static.loads.at(at.t, at.before).none:
            return None
        raise


def groups_of(s: np.ndarray, first: int = 0) -> list[list[int]]:
    """Return the numbers of the eigenvalues ``s``, from the ``first`` on, that fall together."""
    groups: list[list[int]] = []
    for k in range(first, len(s)):
        same = [g for g in groups if abs(s[g[0]] - s[k]) <= TOGETHER * abs(s[k])]
        if same:
            same[0].append(k)
        else:
            groups.append([k])
    return groups


class Pencil:
    """The matrices of small motions at one state, bordered by conditions, as a function of ``s``."""

    def __init__(self, small: SmallMotions) -> None:
        self.small = small
        self._units = units = np.where(small.free_places % 6 < 3, small.problem.length, 1.0)
        free = sparse.csr_array(small.free @ sparse.diags_array(units))
        scale = sparse.diags_array(units)
        self._parts = [sparse.csr_array(scale @ (rows @ free)) for rows in small.balance]
        self._held = None if small.gradients is None else sparse.csr_array(small.gradients @ free)
        self._weight = float(np.abs(self._parts[0].diagonal()).mean()) or 1.0

    @cached_property
    def _aligned(self) -> tuple[sparse.csr_array, Floats]:
        """A pattern that holds all matrices, and their values in its places."""
        pattern = sparse.csr_array(sum(abs(part) for part in self._parts))
        return pattern, aligned(self._parts, pattern)

    @classmethod
    def of(cls, static: StaticSolver, state: State, at: Instant) -> Pencil:
        """Return that of an equilibrium."""
        return cls(small_motions(static, state, before=at.before, scale=at.scale))

    def at(self, s: complex) -> sparse.csc_array:
        """Return the matrix at ``s`` [1/s]."""
        return self._bordered([c(s) for c in self.small.coefficients], held=True)

    def times(self, s: complex, x: np.ndarray) -> np.ndarray:
        """Return the product of the matrix at ``s`` with vectors ``(n, k)``; the matrix is not made."""
        free, (pattern, values) = len(self._units), self._aligned
        data = np.tensordot(np.asarray(self.small.at(s)), values, 1)
        found = sparse.csr_array((data, pattern.indices, pattern.indptr), shape=pattern.shape) @ x[:free]
        if self._held is None:
            return np.asarray(found)
        rows = self._weight * self._held
        return np.concatenate([found + rows.T @ x[free:], rows @ x[:free]])

    def magnitudes(self, s: complex, right: np.ndarray, left: np.ndarray) -> np.ndarray:
        """Return what the matrix between vectors from both sides is, with the magnitudes of all numbers."""
        return np.asarray(np.abs(left).T @ (abs(self.at(s)) @ np.abs(right)))

    def slope(self, s: complex) -> sparse.csc_array:
        """Return its derivative by ``s``."""
        times = self.small.times
        rates = [0.0, 1.0, 2.0 * s, *(tau / (1.0 + s * tau) ** 2 for tau in times)]
        return self._bordered(rates, held=False)

    def increments(self, x: np.ndarray) -> np.ndarray:
        """Return the body increments of all nodes ``(6 n,)`` of a vector."""
        return np.asarray(self.small.free @ (self._units * x[: len(self._units)]))

    def vectors(self, s: complex, count: int) -> tuple[complex, np.ndarray, np.ndarray, np.ndarray]:
        """Return eigenvalue, right and left vectors ``(n, count)``, and what the slope is between these."""
        factors = SparseLU(sparse.csc_array(self.at(s * (1.0 + OUTSIDE)), dtype=complex))
        rng = np.random.default_rng(0)
        size = self.at(s).shape[0]
        right, left = (rng.normal(size=(size, count)) + 0j for _ in range(2))
        # s by s the conditions have no slope: the inverse times the slope tends to the vectors
        slope = self.slope(s)
        for _ in range(ROUNDS):
            right, _ = np.linalg.qr(factors.solve(slope @ right))
            left, _ = np.linalg.qr(factors.solve((slope.T @ left.conj()), transposed=True).conj())
        between = left.conj().T @ (slope @ right)
        s = s - complex(np.trace(np.linalg.solve(between, left.conj().T @ (self.at(s) @ right)))) / count
        return s, right, left, between

    def _bordered(self, coefficients: Sequence[complex], *, held: bool) -> sparse.csc_array:
        total: Any = sum(c * part for c, part in zip(coefficients, self._parts, strict=False))
        if self._held is None:
            return sparse.csc_array(total)
        rows = self._weight * self._held
        none = sparse.csr_array((rows.shape[0], rows.shape[0]))
        if not held:
            return sparse.csc_array(sparse.block_diag([total, none]))
        return sparse.csc_array(sparse.block_array([[total, rows.T], [rows, none]]))


def _derivative(
    neighbours: Neighbours,
    result: Modes,
    histories: Sequence[History],
    rates: np.ndarray,
    groups: Sequence[Sequence[int]],
    shapes: Sequence[Callable[[], dict[str, np.ndarray]]],
) -> Derivative[Modes]:
    """Return the derivative from modes to first order."""
    number = neighbours.number
    parts = []
    for one, history, shape in zip(neighbours.each, histories, shapes, strict=True):
        near = Modes.later(
            partial(_near, one, history, result, result.eigenvalues + one.change * rates, shape)
        )
        parts.append(Part(one.weight, one.change, near))
    notes = []
    several = [group for group in groups if len(group) > 1]
    if several:
        listed = "; ".join(", ".join(str(k + 1) for k in group) for group in several)
        notes.append(
            f"the modes {listed} have one frequency: a number may part them, and what is given for each is the "
            "derivative of their mean"
        )
    found = Derivative(number.key, number.value, number.unit, result, parts, notes)
    for note in notes:
        warn(f"derivatives by {number.key}: {note}")
    return found


def _near(
    one: Neighbour,
    history: History,
    result: Modes,
    s: np.ndarray,
    shapes: Callable[[], dict[str, np.ndarray]],
) -> xr.Dataset:
    """Return the data of modes with the eigenvalues ``s`` of a neighbour."""
    data = result.data
    more: dict[str, Any] = {
        "mode_name": data["mode_name"].values,
        "eigenvalue": np.stack([s.real, s.imag], axis=1),
    }
    more |= {name: lambda name=name: shapes()[name] for name in SHAPES}
    more |= {name: np.full(data[name].shape, np.nan) for name in UNKNOWN if name in data}
    return dataset_beside(
        data, one.problem, gauss_positions(one.problem), history, one.attributes(result), more
    )

"""First guess of a collocation step: the polynomials of the last step, continued."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.rotations.nodal_motion import extrapolate
from viscorod.solve.transient.integrators.stage_data import Discretisation, Stages
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.formulations.system import State


class Predictor:
    """Predicts coordinates and stresses of the stages of a step.

    Stresses go on with the polynomial through start and stages of the last step, of degree ``s``. Coordinates go on
    with one of degree ``s + 1``, which has the rates of that polynomial at the stages, and at the start the twist
    there: collocation leaves a gap between the two rates, which is also what the error estimate is made of.

    Args:
        body, stages, tableau: of the method; ``stages.X`` and ``stages.stress`` are written.

    Attributes:
        X, stresses: coordinates of the last step's stages ``(s, n, 6)``, and stresses at its start and at its stages
            ``(s + 1, e, points, 6)``; written from outside (see ``record_kernels``).
    """

    unsaved = frozenset({"gap", "_stages_stress", "_stress", "_weights", "_whole"})

    def __init__(self, body: Discretisation, stages: Stages, tableau: Tableau) -> None:
        self.body, self.stages, self.tableau = body, stages, tableau
        s = len(tableau.nodes)
        self._several = s > 1
        self.gap = _gap(tuple(tableau.nodes.tolist()))
        self.X = np.empty(stages.X.shape)
        self.stresses = np.empty((s + 1, *stages.stress.shape[1:]))
        self._stress = self.stresses.reshape(s + 1, -1)
        self._stages_stress = stages.stress.reshape(s, -1)
        self._weights = np.empty((s, s + 1))
        self.extrapolation = KnownTypes(extrapolate_step)
        self._old: State | None = None  # at the start of the last step
        self._step = 0.0
        self._whole: tuple[Predictor, float] | None = None

    def reset(self) -> None:
        """Forget the last step: it does not predict the next one."""
        self._old = None

    def keep(self, state: State, h: float) -> None:
        """Keep a step of ``h`` [s] from ``state``, of which ``X`` and ``stresses`` are."""
        self._whole = None
        if self._several:
            self._old, self._step = state, h

    def follow(self, whole: Predictor, place: float) -> None:
        """Let the next step be predicted by one that has been taken, and that it is a part of.

        Args:
            whole: predictor of what took that step; place: in it where the next one starts (0 to 1).
        """
        self._whole = whole, place

    @property
    def last(self) -> tuple[State, float] | None:
        """Start of the last step, and its length [s], if it is known."""
        return None if self._old is None else (self._old, self._step)

    def predict(self, state: State, stress: Floats, h: float) -> None:
        """Write the stages of a step of ``h`` [s] from ``state``, where the stresses are ``(e, points, 6)``.

        They follow the last step's polynomials, or the present twists and stresses.
        """
        tableau, stages, body = self.tableau, self.stages, self.body
        known, place = (self, 1.0) if self._whole is None else self._whole
        old = known._old
        if old is None:
            np.multiply.outer(tableau.nodes * h, state.twist, out=stages.X)
            stages.X[:, body.held != 0.0] = 0.0
            stages.stress[:] = stress
            return
        self.extrapolation.call(
            tableau,
            self.gap,
            LastStep(known._step, place, old.r, old.q, old.twist, known.X, known._stress),
            h,
            state.r,
            state.q,
            body.split,
            body.held,
            self._weights,
            stages.X,
            self._stages_stress,
        )


@lru_cache
def _gap(nodes: tuple[float, ...]) -> Floats:
    """Return coefficients of the powers 1 to s + 1 of a polynomial with the rate 1 at the start and 0 at ``nodes``."""
    through = np.poly(nodes)
    return np.ascontiguousarray(np.polyint(through / through[-1])[-2::-1], dtype=np.float64)


class LastStep(NamedTuple):
    """The step that goes on.

    Attributes:
        h: step [s]; place: in it where the new one starts, 1 at its end.
        r, q, twist: its start; X: its coordinates ``(s, n, 6)``; stress: at its start and stages ``(s + 1, numbers)``.
    """

    h: float
    place: float
    r: Floats
    q: Floats
    twist: Floats
    X: Floats
    stress: Floats


@kernel
def extrapolate_step(
    method: Tableau,
    gap: Floats,
    last: LastStep,
    h: float,
    r1: Floats,
    q1: Floats,
    split: Floats,
    held: Floats,
    weights: Floats,
    new_X: Floats,
    new_stress: Floats,
) -> None:
    """Continue coordinates and stresses of a step into the next one, or into a part of itself.

    Args:
        gap: coefficients of the powers 1 to s + 1 of the place in the step, of a coordinate whose rate is one at the
            start and zero at the stages.
        h: new step [s]; r1, q1: start of the new step; split, held: as in ``motion.extrapolate``.
        weights: scratch ``(s, s + 1)``.
        new_X, new_stress: outputs ``(s, n, 6)``, ``(s, numbers)``.
    """
    nodes, values, stress, ratio = method.nodes, method.values, last.stress, h / last.h
    s = nodes.shape[0]
    for i in range(s):
        place = last.place + nodes[i] * ratio
        rest = 1.0
        for j in range(s):
            power, weight = place, 0.0
            for k in range(s):
                weight += values[j, k] * power
                power *= place
            weights[i, j] = weight
            rest -= weight
        weights[i, s] = rest
    for i in range(s):
        for m in range(stress.shape[1]):
            total = weights[i, s] * stress[0, m]
            for j in range(s):
                total += weights[i, j] * stress[j + 1, m]
            new_stress[i, m] = total
    for i in range(s):
        place = last.place + nodes[i] * ratio
        power, correction = place, 0.0
        for k in range(s + 1):
            correction += gap[k] * power
            power *= place
        for j in range(s):
            weights[i, j] -= correction * method.start_derivative[j]
        weights[i, s] = correction * last.h
    extrapolate(last.r, last.q, last.twist, last.X, weights, r1, q1, split, held, new_X)

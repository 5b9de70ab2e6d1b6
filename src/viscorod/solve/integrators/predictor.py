"""Where the iteration of a collocation step starts: the polynomials of the last step go on."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.motion import extrapolate
from viscorod.solve.integrators.stage_data import Body, Stages
from viscorod.solve.integrators.tableau import Tableau
from viscorod.solve.system import State
from viscorod.typing import Floats


class Predictor:
    """Predicts coordinates and stresses of the stages of a step.

    Args:
        body, stages, tableau: of the method; ``stages.X`` and ``stages.stress`` are written.
    """

    def __init__(self, body: Body, stages: Stages, tableau: Tableau) -> None:
        self.body, self.stages, self.tableau = body, stages, tableau
        self._earlier: tuple[State, Floats, Floats, float] | None = None

    def forget(self) -> None:
        """Begin anew: the last step says nothing about the next one."""
        self._earlier = None

    def keep(self, state: State, stress: Floats, h: float) -> None:
        """Keep the polynomials of a step of ``h`` [s] from ``state``, where the stresses were ``(e, points, 6)``."""
        stages = self.stages
        self._earlier = (state, stages.X.copy(), np.concatenate([stress[None], stages.stress]), h)

    def predict(self, state: State, stress: Floats, h: float) -> None:
        """Write the stages of a step of ``h`` [s] from ``state``, where the stresses are ``(e, points, 6)``.

        They follow the last step's polynomials, or the present twists and stresses.
        """
        nodes, stages, body = self.tableau.nodes, self.stages, self.body
        if self._earlier is None or len(nodes) == 1:
            np.multiply.outer(nodes * h, state.twist, out=stages.X)
            stages.X[:, body.held != 0.0] = 0.0
            stages.stress[:] = stress
            return
        old, X, stresses, old_step = self._earlier
        weights = self.tableau.polynomials(1.0 + nodes * (h / old_step))
        all_weights = np.concatenate([1.0 - weights.sum(axis=1, keepdims=True), weights], axis=1)
        np.dot(all_weights, stresses.reshape(len(stresses), -1), out=stages.stress.reshape(len(nodes), -1))
        extrapolate(old.r, old.q, X, weights, state.r, state.q, body.split, body.held, stages.X)

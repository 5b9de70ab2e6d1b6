"""How forced periodic motions change with numbers of the case, at their frequencies and levels.

The motions of the model with the number a little larger and smaller are found again from those of the result, and
iterated to round-off. Along a curve they change without bound where it folds: there they have no such derivative.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.analyses.derivatives.neighbours import CLOSE, Neighbour, Neighbours
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.analyses.periodic import Record, data_set
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.derivative import Derivative, Part
from viscorod.results.periodic import Periodic
from viscorod.solve.formulations.system import State
from viscorod.solve.periodic.orbit_solver import OrbitSolver, Solved
from viscorod.solve.settings.periodic import PeriodicSettings

__all__ = ["orbit_derivatives"]

AGAIN = 3
"""Solutions from the one before: each leaves a part of what the last one left."""
SMOOTH = ("coefficient", "drive", "conjugate", "work", "loss", "damping_ratio")
"""What has derivatives."""


def orbit_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: PeriodicSettings,
    result: Periodic,
    keys: Sequence[str],
) -> dict[str, Derivative[Periodic]]:
    """Return the derivatives of forced motions at all points of the curve; at folds they are not numbers.

    Raises:
        InputError: the motions are free vibrations. SolveError: a motion was not found for a number close by.
    """
    if settings.mode is not None:
        why = "free vibrations along a family have no derivatives here"
        raise InputError(
            Fault("derivatives", ", ".join(keys), why, "leave derivatives out, or drive the model")
        )
    base = State.reference(discrete.problem)
    find_initial_equilibrium(discrete, base, before=settings.about == "equilibrium")
    folds = np.flatnonzero(result.data["bifurcation"].values == "fold")
    notes = []
    if len(folds):
        points = ", ".join(str(k + 1) for k in folds)
        notes.append(
            f"at the folds (points {points}) motions at a given frequency or level have no derivative"
        )
    found = {}
    for key in keys:
        neighbours = Neighbours.of(model, key, discrete, CLOSE)
        parts, lost = [], set()
        for one in neighbours.each:
            record, missing = _found_again(one, settings, base.copy(), result, key, folds)
            lost |= set(missing)
            left_out = np.union1d(folds, missing).astype(int)
            parts.append(Part(one.weight, one.change, _near(one, settings, record, result, left_out)))
        number = neighbours.number
        told = [*notes, _lost(result, key, sorted(lost))] if lost else notes
        found[key] = Derivative(key, number.value, number.unit, result, parts, told)
    return found


def _lost(result: Periodic, key: str, lost: Sequence[int]) -> str:
    """Return a note of points without derivatives.

    Raises:
        SolveError: no point has any.
    """
    frequencies = result.data["frequency"].values[list(lost)]
    where = ", ".join(f"{k + 1} ({hertz:.6g} Hz)" for k, hertz in zip(lost, frequencies, strict=True))
    why = (
        f"no motion was found beside that of point {where} for a slightly other {key}: a fold, or another family of "
        "motions, such as one that a superharmonic resonance sets off, lies too close by"
    )
    if len(lost) == len(result.data["frequency"]):
        raise SolveError(
            f"The motions have no derivative by {key}: {why}. Ask for frequencies or levels further off, or for more "
            "harmonics"
        )
    return f"{why}; the derivatives are no numbers there"


def _found_again(
    one: Neighbour, settings: PeriodicSettings, state: State, result: Periodic, key: str, folds: np.ndarray
) -> tuple[Record, list[int]]:
    """Return the motions of a neighbour, which rests next to ``state``, and those that were not found.

    For the latter stands that of the model itself.
    """
    before = settings.about == "equilibrium"
    if not one.static.newton(state, 0.0, before=before, scale=1.0).converged:
        raise SolveError(
            f"The motions have no derivative by {key}: the model rests elsewhere for a number close by"
        )
    record = Record.of(one.discrete, settings, state)
    size, places = record.balance.fourier.count, record.balance.problem.pattern.size
    rows = np.zeros((0, size, places, 6)), np.zeros((0, 0))
    missing: list[int] = []
    for k, (orbit, setting) in enumerate(result.orbits):
        solved = Solved(orbit, record.balance.moved(orbit, setting), 0)
        for _ in range(0 if k in folds else AGAIN):
            better = OrbitSolver(record.balance, ()).solve(solved.orbit, setting, rows, fresh=True)
            if better is None:
                missing.append(k)
                solved = Solved(orbit, record.balance.moved(orbit, setting), 0)
                break
            solved = better
        record.add(solved.motion, solved.orbit)
    return record, missing


def _near(
    one: Neighbour, settings: PeriodicSettings, record: Record, result: Periodic, folds: np.ndarray
) -> Periodic:
    """Return the result for a neighbour, with what has derivatives."""
    own = data_set(one.discrete, settings, record, result.outcome)
    known = {}
    for name, values in result.data.data_vars.items():
        if values.dtype.kind == "f":
            moved = own[name].values.copy() if name in SMOOTH else np.full(values.shape, np.nan)
            if name in SMOOTH:
                moved[folds] = np.nan
            known[name] = values.copy(data=moved)
    for name in ("frequency", "level"):
        known[name] = result.data[name]
    near = Periodic.__new__(Periodic)
    near.data = result.data.assign(known)
    return near

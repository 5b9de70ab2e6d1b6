"""Large assemblies: frames whose members are rigidly attached, in statics and in motion, condensed and not.

    python bench/assemblies.py

A lattice of 3 x 3 x 3 joints with 54 members, and 1000 members between 400 joints at random places, one element of
order 5 each, clamped at some joints, under gravity. Printed are what the model takes until it can be solved; a Newton
iteration of the equilibrium: assembly, factorisation, solution, update; and a step of Radau IIA at a tolerance of 1e-3,
with its Jacobians and factorisations. The second line of each model is the same with a sparse LU of all unknowns, in
turn with the first.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import cKDTree

import viscorod as vr
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.plan import plans
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.typing import Floats, Integers

ROUNDS, STEPS, STEP = 5, 20, 1e-3


def frame(places: Floats, members: Integers, clamped: list[int]) -> vr.Model:
    """Rods between joints at ``places (j, 3)``, one per pair of ``members (m, 2)``, rigidly attached there."""
    material = vr.Material(1e9, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(1e-3, 1e-3))
    section = vr.Circle(0.02)
    model = vr.Model()
    ends: list[list[str]] = [[] for _ in places]
    for number, (a, b) in enumerate(members.tolist()):
        rod = vr.Rod.straight(places[a], places[b], section=section, material=material, elements=1, order=5)
        model.add(f"m{number}", rod)
        ends[a].append(f"m{number}.start")
        ends[b].append(f"m{number}.end")
    for joined in ends:
        for other in joined[1:]:
            model.attach(joined[0], other)
    for joint in clamped:
        model.clamp(ends[joint][0])
    model.gravity()
    return model


def lattice(n: int) -> vr.Model:
    """Cubes of 1 m, clamped at the bottom."""
    places = np.array(list(product(range(n), repeat=3)), dtype=float)
    pairs = cKDTree(places).query_pairs(1.01, output_type="ndarray")
    return frame(places, pairs, [k for k in range(n**3) if places[k, 2] == 0.0])


def random_frame(joints: int, members: int) -> vr.Model:
    """Members between joints that are near each other, all connected, clamped at every tenth joint."""
    rng = np.random.default_rng(1)
    places = 7.0 * rng.random((joints, 3))
    near = cKDTree(places).query(places, k=9)[1][:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(joints), 8), near.ravel()])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    lengths = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    tree = minimum_spanning_tree(coo_array((lengths, tuple(pairs.T)), shape=(joints, joints))).tocoo()
    kept = np.column_stack([tree.row, tree.col])
    numbers = pairs @ [joints, 1]
    rest = pairs[~np.isin(numbers, np.sort(kept, axis=1) @ [joints, 1])]
    chosen = rng.permutation(len(rest))[: members - len(kept)]
    return frame(places, np.concatenate([kept, rest[chosen]]), list(range(0, joints, 10)))


MODELS: dict[str, Callable[[], vr.Model]] = {
    "lattice of 3 x 3 x 3": lambda: lattice(3),
    "frame in space": lambda: random_frame(400, 1000),
}


class Equilibrium:
    """Newton's iterations of the equilibrium under gravity."""

    def __init__(self, problem: Problem) -> None:
        self.solver = StaticSolver(GeometricSystem(problem), SupportState(problem))
        self.state = State.reference(problem)
        begin = time.perf_counter()
        report = self.solver.newton(self.state, 0.0, before=False, scale=1.0)
        self.seconds, self.iterations = time.perf_counter() - begin, report.iterations
        assert report.converged
        self.loads = self.solver.loads.at(0.0, False, 1.0)

    def iterate(self) -> float:
        """Return the time [s] of one more iteration."""
        system, supports, state = self.solver.system, self.solver.supports, self.state
        begin = time.perf_counter()
        system.assemble(state, self.loads, None, tangent=True, moving=False)
        residual = system.residual()
        supports.impose(state, residual, system.matrix, tangent=True)
        system.matrix.factorise()
        increment = system.matrix.solve(-residual)
        retract(state.r, state.q, increment, state.r, state.q)
        system.carry_stress(increment)
        return time.perf_counter() - begin


def step(problem: Problem) -> float:
    """Return the time [s] of a step of Radau IIA, in the mean of some from rest."""
    system = GeometricSystem(problem)
    radau = Radau(system, SupportState(problem), tolerance=1e-3)
    radau.start(0.0, State.reference(problem))
    begin = time.perf_counter()
    for k in range(1, STEPS + 1):
        assert radau.attempt(k * STEP, before=False).converged
        radau.accept()
    return (time.perf_counter() - begin) / STEPS


def measure(model: vr.Model) -> None:
    """Print the lines of a model."""
    begin = time.perf_counter()
    condensed = discretise(model)
    between = time.perf_counter()
    plan = condensed.plan
    print(
        f"  checked and discretised in {between - begin:.2f} s, plan made in "
        f"{time.perf_counter() - between:.3f} s; {6 * condensed.size} unknowns"
    )
    whole = replace(condensed)
    vars(whole)["plan"] = next(other for other in plans(plan.pattern) if not other.banded)
    problems = condensed, whole
    solved = [Equilibrium(problem) for problem in problems]
    iteration, transient = np.full(2, np.inf), np.full(2, np.inf)
    for _ in range(ROUNDS):  # in turn: both see the same noise
        for k, problem in enumerate(problems):
            iteration[k] = min(iteration[k], *(solved[k].iterate() for _ in range(5)))
            transient[k] = min(transient[k], step(problem))
    for k, problem in enumerate(problems):
        each = 1e6 * iteration[k] / len(model.rods)
        print(
            f"  {problem.plan.description:58} {1e3 * iteration[k]:8.2f} ms {each:8.1f} us "
            f"{1e3 * solved[k].seconds:8.1f} ms in {solved[k].iterations} {1e3 * transient[k]:8.2f} ms"
        )


def main() -> None:
    """Print all lines."""
    small = discretise(lattice(2))
    Equilibrium(small)  # what follows is compiled then
    step(small)
    print(f"  {'':58} {'iteration':>11} {'a member':>11} {'equilibrium':>16} {'step':>11}")
    for name, make in MODELS.items():
        begin = time.perf_counter()
        model = make()
        print(
            f"{name}: {len(model.rods)} members, {len(model.supports)} clamps, "
            f"described in {time.perf_counter() - begin:.2f} s"
        )
        measure(model)


if __name__ == "__main__":
    main()

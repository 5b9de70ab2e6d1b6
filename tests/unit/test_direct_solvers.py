"""Direct solvers on random matrices of blocks, against dense solutions."""

from __future__ import annotations

import os
import subprocess
import sys

import numba
import numpy as np
import pytest
from scipy.linalg.lapack import dgbtrf, zgbtrf
from scipy.sparse import csc_array

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.elimination import Elimination
from viscorod.solve.linear.factors import HEAD, REACH
from viscorod.solve.linear.ordering import cuthill_mckee, half_bandwidth
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan, plans
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.linear.stacked_solvers import StackedSolvers
from viscorod.solve.linear.substitution import solve, solve_each

KINDS = [float, complex]


def frame(joints, members, order, multipliers=()):
    """Pattern and interiors of elements between joints; every multiplier row couples with two given rows."""
    members = np.asarray(members)
    inner = joints + np.arange(len(members) * (order - 1)).reshape(len(members), order - 1)
    elements = np.concatenate([members[:, :1], inner, members[:, 1:]], axis=1)
    size = joints + inner.size
    rows = [np.array([[*pair, size + k]]) for k, pair in enumerate(multipliers)]
    pattern = Pattern.of(size + len(rows), [elements, *rows])
    return pattern, ([inner] if order > 1 else []), size


def chain(count, order):
    return frame(count + 1, np.column_stack([np.arange(count), np.arange(1, count + 1)]), order)


def lattice(n, order, multipliers=()):
    grid = np.arange(n**3).reshape(n, n, n)
    ends = [(grid[:-1], grid[1:]), (grid[:, :-1], grid[:, 1:]), (grid[:, :, :-1], grid[:, :, 1:])]
    members = np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in ends])
    return frame(n**3, members, order, multipliers)


MODELS = {
    "chain": chain(4, 3),
    "one element": chain(1, 5),
    "linear elements": chain(9, 1),
    "ring with multipliers": frame(5, [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0)], 3, [(0, 2), (1, 3)]),
    "two parts": frame(4, [(0, 1), (2, 3)], 2),
    "multiplier at an inner node": frame(3, [(0, 1), (1, 2)], 3, [(3, 0)]),
    "lattice": lattice(3, 3, [(0, 26), (2, 20)]),
}


def values(pattern, nodes, kind=float, seed=0):
    """Random blocks; those between multipliers (rows from ``nodes`` on) are zero."""
    rng = np.random.default_rng(seed)
    blocks = rng.normal(size=(len(pattern.rows), 6, 6)).astype(kind)
    if kind is complex:
        blocks += 1j * rng.normal(size=blocks.shape)
    blocks[(pattern.rows >= nodes) & (pattern.columns >= nodes)] = 0.0
    return blocks


def sparse_plan(pattern, interiors):
    elimination = Elimination.of(pattern, interiors)
    order = np.random.default_rng(1).permutation(elimination.remaining.size)
    return Plan(pattern, elimination, order, banded=False, cost=0.0)


def right_side(size, kind, seed=3):
    rng = np.random.default_rng(seed)
    b = rng.normal(size=size).astype(kind)
    return b + 1j * rng.normal(size=size) if kind is complex else b


@kernel
def solve_twice(factors, b, c):
    solve(factors, b)
    solve(factors, c)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", MODELS)
def test_solutions_are_those_of_dense_matrices(model, kind):
    pattern, interiors, nodes = MODELS[model]
    sides = [right_side(6 * pattern.size, kind, seed) for seed in (3, 4, 5)]
    dense = []  # what every way is compared with
    for seed in range(2):
        blocks = values(pattern, nodes, kind, seed)
        matrix = pattern.sparse(blocks).toarray()
        expected = [
            *np.linalg.solve(matrix, np.column_stack(sides[:2])).T,
            np.linalg.solve(matrix.T, sides[2]),
        ]
        dense.append((blocks, expected, 1e-16 * np.linalg.cond(matrix) * 1e3))
    for plan in [*plans(pattern, interiors), sparse_plan(pattern, interiors), sparse_plan(pattern, ())]:
        solver = DirectSolver(plan, kind)
        for blocks, (expected_b, expected_c, expected_d), scale in dense:
            kept = blocks.copy()
            solver.factorise(blocks)
            np.testing.assert_array_equal(blocks, kept)
            b, c, d = (side.copy() for side in sides)
            nodal = b.reshape(-1, 6).copy()
            assert solver.solve(nodal) is nodal
            solve_twice(solver.factors, b, c)
            solver.check()
            turned = solver.solve(d, transposed=True)
            for found, expected in (
                (nodal.ravel(), expected_b),
                (b, expected_b),
                (c, expected_c),
                (turned, expected_d),
            ):
                np.testing.assert_allclose(found, expected, atol=scale * np.abs(expected).max(), rtol=0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", MODELS)
def test_rows_that_do_not_move_are_left_out(model, kind):
    """Solutions are those of the dense matrix of all other rows, also for joints and inner nodes that are left out."""
    pattern, interiors, nodes = MODELS[model]
    blocks, b = values(pattern, nodes, kind), right_side(6 * pattern.size, kind)
    whole = pattern.sparse(blocks).toarray()
    for without in ((0,), (0, nodes - 1), (1, 2)):
        moving = np.repeat(~np.isin(np.arange(pattern.size), without), 6)
        dense = whole[np.ix_(moving, moving)]
        condition = np.linalg.cond(dense)
        if condition > 1e10:  # a multiplier that couples only with what is left out
            continue
        solutions = [np.linalg.solve(matrix, b[moving]) for matrix in (dense, dense.T)]
        for plan in plans(pattern, interiors, without):
            solver = DirectSolver(plan, kind)
            solver.factorise(blocks)
            for transposed, expected in enumerate(solutions):
                found = solver.solve(b.copy(), transposed=bool(transposed))
                scale = 1e-13 * condition * np.abs(expected).max()
                np.testing.assert_allclose(found[moving], expected, atol=scale, rtol=0)
                np.testing.assert_array_equal(found[~moving], b[~moving])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", MODELS)
def test_badly_scaled_rows_keep_their_accuracy(model, kind):
    """The residual of every row is small beside the row itself, whatever its unit."""
    pattern, interiors, nodes = MODELS[model]
    units = 10.0 ** np.random.default_rng(5).integers(-6, 7, size=(pattern.size, 6))
    blocks = values(pattern, nodes, kind) * units[pattern.rows][:, None, :]
    matrix = pattern.sparse(blocks)
    for plan in [*plans(pattern, interiors), sparse_plan(pattern, interiors)]:
        solver = DirectSolver(plan, kind)
        solver.factorise(blocks)
        b = right_side(6 * pattern.size, kind) * units.ravel()
        x = solver.solve(b.copy())
        size = abs(matrix) @ np.abs(x) + np.abs(b)
        assert np.max(np.abs(matrix @ x - b) / size) < 1e-9


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("model", MODELS)
def test_singular_matrices_are_named_at_a_free_unknown(model, kind):
    """An unknown, others in turn, is left without any force: its column is zero."""
    pattern, interiors, nodes = MODELS[model]
    for plan in [*plans(pattern, interiors), sparse_plan(pattern, interiors)]:
        solver = DirectSolver(plan, kind)
        for unknown in range(0, 6 * pattern.size, 37):
            blocks = values(pattern, nodes, kind)
            blocks[pattern.columns == unknown // 6, unknown % 6] = 0.0
            with pytest.raises(SingularMatrixError) as raised:
                solver.factorise(blocks)
            assert raised.value.row == unknown
        blocks = values(pattern, nodes, kind)
        solver.factorise(blocks)  # as good as new
        b = right_side(6 * pattern.size, kind)
        x = solver.solve(b.copy())
        np.testing.assert_allclose(pattern.sparse(blocks) @ x, b, atol=1e-8 * np.abs(x).max())


@pytest.mark.parametrize("model", MODELS)
def test_matrices_that_are_not_finite_give_no_numbers(model):
    pattern, interiors, nodes = MODELS[model]
    for plan in [*plans(pattern, interiors), sparse_plan(pattern, interiors)]:
        solver = DirectSolver(plan)
        blocks = values(pattern, nodes)
        blocks[pattern.diagonal[0]] = np.nan
        solver.factorise(blocks)
        assert np.isnan(solver.solve(np.ones(6 * pattern.size))).any()


@pytest.mark.parametrize("kind", KINDS)
def test_compiled_code_fits_all_ways(kind):
    models = MODELS.values()
    every = [plan for pattern, interiors, _ in models for plan in plans(pattern, interiors)]
    every += [sparse_plan(pattern, interiors) for pattern, interiors, _ in models]
    assert len({numba.typeof(DirectSolver(plan, kind).factors) for plan in every}) == 1


@pytest.mark.parametrize("size", [0.0, 1e-12])
@pytest.mark.parametrize("kind", KINDS)
def test_interiors_without_stiffness_of_their_own_are_not_condensed(kind, size):
    """The whole matrix is regular: the solver goes over to a way that does not need more, and stays with it."""
    pattern, interiors, nodes = MODELS["chain"]
    blocks = values(pattern, nodes, kind)
    inner = interiors[0][2]
    within = np.isin(pattern.rows, inner) & np.isin(pattern.columns, inner)
    for sparse in (False, True):
        ways = [plan for plan in plans(pattern, interiors) if plan.elimination.fronts]
        solver = DirectSolver(sparse_plan(pattern, interiors) if sparse else ways[0], kind)
        assert solver.plan.elimination.fronts
        solver.factorise(blocks)
        assert solver.plan.elimination.fronts
        singular = blocks.copy()
        singular[within, 1:3] *= size  # two columns of each inner node
        solver.factorise(singular)
        assert solver.plan is solver.plan.plain
        b, c = right_side(6 * pattern.size, kind), right_side(6 * pattern.size, kind, 4)
        dense = pattern.sparse(singular).toarray()
        expected = np.linalg.solve(dense, np.column_stack([b, c])).T
        solve_twice(solver.factors, b, c)
        scale = 1e-13 * np.linalg.cond(dense)
        for found, right in zip((b, c), expected, strict=True):
            np.testing.assert_allclose(found, right, atol=scale * np.abs(right).max(), rtol=0)
        solver.factorise(blocks)
        assert not solver.plan.elimination.fronts


@kernel
def solve_stack(factors, b):
    solve_each(factors, b)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_stacked_matrices_are_solved_one_by_one(count):
    """Against dense solutions; where one of them needs another way, all go it."""
    pattern, interiors, nodes = MODELS["chain"]
    inner = interiors[0][2]
    within = np.isin(pattern.rows, inner) & np.isin(pattern.columns, inner)
    ways = [plan for plan in plans(pattern, interiors) if plan.elimination.fronts]
    for plan in (ways[0], sparse_plan(pattern, interiors)):
        solvers = StackedSolvers(plan, count)
        blocks = np.zeros((count, len(pattern.rows), 6, 6), dtype=complex)
        b = np.zeros((count, 6 * pattern.size), dtype=complex)
        for k in range(count):
            blocks[k] = values(pattern, nodes, complex, k)
            b[k] = right_side(6 * pattern.size, complex, k)
        for singular in (False, True):
            if singular and count:
                blocks[-1, within, 1:3] = 0.0
            solvers.factorise(blocks)
            found = b.copy()
            solve_stack(solvers.factors, found)
            solvers.check()
            for own, x, y in zip(blocks, found, b, strict=True):
                dense = pattern.sparse(own).toarray()
                scale = 1e-13 * np.linalg.cond(dense)
                expected = np.linalg.solve(dense, y)
                np.testing.assert_allclose(x, expected, atol=scale * np.abs(expected).max(), rtol=0)


def test_groups_that_touch_others_remain():
    pattern, (inner,), _ = chain(6, 3)
    wrong = [inner[:4], np.array([[0], [inner[5, 0]]])]
    found = Elimination.of(pattern, wrong)
    # the first node touches the first element, and a half element the other half, which is in no group
    assert sorted(k for front in found.fronts for k in front.interior.ravel()) == [
        *inner[1:4].ravel(),
        inner[5, 0],
    ]
    assert inner[5, 1] in found.rows
    plan = Plan.of(pattern, [inner[:1], inner[:1, ::-1]])
    assert plan.description == "band of half width 23", "a group given twice"


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("order", [1, 3])
def test_narrow_bands_have_the_factors_of_lapack(order, kind):
    """Pivots of dgbtrf and zgbtrf, also beyond the block, and their LU; entries of U as far as is said."""
    pattern, _, size = chain(12, order)
    for dominant in (0.0, 20.0):
        blocks = values(pattern, size, kind)
        blocks[pattern.rows == pattern.columns] += dominant * np.eye(6)
        solver = DirectSolver(next(plans(pattern)), kind)
        width, far = solver.plan.width, order
        band = np.zeros((6 * size, 3 * width + 1), dtype=kind)
        place = 6 * np.argsort(solver.plan.rows)
        for block, row, column in zip(blocks, place[pattern.rows], place[pattern.columns], strict=True):
            for b in range(6):  # blocks stand column by column
                first = 2 * width + row - column - b
                band[column + b, first : first + 6] = block[b]
        solver.factorise(blocks)
        lu, pivots, _ = (dgbtrf if kind is float else zgbtrf)(band.T, width, width)
        lu[2 * width] = 1.0 / lu[2 * width]
        ours = solver.factors.values.reshape(6 * size, 3 * width + 1)
        assert (solver.factors.integers[HEAD:] == pivots + 1).all()
        np.testing.assert_allclose(ours, lu.T, rtol=0.0, atol=1e-11 * abs(lu).max())
        columns, entries = np.nonzero(ours[:, : 2 * width])
        above = columns // 6 - (columns + entries - 2 * width) // 6
        assert solver.factors.integers[REACH] == above.max()
        assert (above.max() > far) == (dominant == 0.0), "pivots beyond a block reach farther"


def test_the_cheapest_way_is_taken():
    """Narrow bands as they are, high orders condensed, wide graphs sparse."""
    assert Plan.of(*chain(100, 1)[:2]).description == "band of half width 11"
    assert Plan.of(*chain(1, 5)[:2]).description == "band of half width 35"
    assert Plan.of(*chain(20, 5)[:2]).description == "element interiors condensed, band of half width 11"
    assert Plan.of(*lattice(3, 5)[:2]).description.startswith(
        "element interiors condensed, band of half width"
    )
    arms = np.arange(1, 301).reshape(100, 3)  # from one joint
    members = np.concatenate([[(0, a), (a, b), (b, c)] for a, b, c in arms])
    assert Plan.of(*frame(301, members, 5)[:2]).description == (
        "element interiors condensed, sparse LU of 1806 unknowns"
    )


def test_shuffled_chains_have_the_band_of_ordered_ones():
    shuffle = np.random.default_rng(2).permutation(50)
    ends = np.column_stack([shuffle[:-1], shuffle[1:]])
    pattern = Pattern.of(60, [ends[:20], ends[21:]])  # two chains and ten nodes alone
    order = cuthill_mckee(pattern)
    assert sorted(order) == list(range(60))
    assert half_bandwidth(pattern, order) == 1


SPARSE = """
import numpy as np
from viscorod.solve.linear import factors, substitution
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.elimination import Elimination
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan

padding = [np.zeros(k) for k in range(np.random.default_rng().integers(1000))]  # other addresses than last time
pattern = Pattern.of(3, [np.array([[0, 1, 2]])])
solver = DirectSolver(Plan(pattern, Elimination.of(pattern, [np.array([[1]])]), np.arange(2), False, 0.0))
blocks = np.random.default_rng(0).normal(size=(9, 6, 6))
solver.factorise(blocks)
assert np.allclose(pattern.sparse(blocks) @ solver.solve(np.ones(18)), 1.0)
print(*[sum(k.stats.cache_misses.values()) for k in (factors.reduce, substitution.substitute)])
"""


@pytest.mark.slow
def test_machine_code_on_disk_calls_the_functions_of_this_process(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def output():
        command = [sys.executable, "-c", SPARSE]
        return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout

    assert output().split() == ["1", "1"]
    assert output().split() == ["0", "0"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_sparse_lu_solves_the_transposed_system(kind):
    """Against a dense matrix that is not symmetric, with conditions that have no diagonal; rows in their own units."""
    pattern, _, nodes = MODELS["ring with multipliers"]
    matrix = pattern.sparse(values(pattern, nodes, kind))
    units = np.repeat(10.0 ** np.random.default_rng(6).integers(-3, 4, size=pattern.size), 6)
    matrix = matrix * np.outer(units, units)
    b = np.column_stack([right_side(6 * pattern.size, kind, seed) for seed in (7, 8)])
    x = SparseLU(matrix).solve(b, transposed=True)
    size = abs(matrix).T @ np.abs(x) + np.abs(b)
    assert np.max(np.abs(matrix.T @ x - b) / size) < 1e-12


def test_a_diagonal_of_round_off_does_not_scale_a_matrix() -> None:
    """Rows of conditions have no diagonal; what rounding leaves there is none either."""
    random = np.random.default_rng(3)
    stiffness = np.diag(10.0 ** random.uniform(-3, 3, 40))
    rows = random.standard_normal((12, 40))
    noise = np.diag(10.0 ** random.uniform(-40, -17, 12))
    matrix = np.block([[stiffness, rows.T], [rows, noise]])
    right = random.standard_normal(52)
    found = SparseLU(csc_array(matrix)).solve(right)
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-9)

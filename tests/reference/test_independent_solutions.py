"""The independent solutions of AWP V.A, checked against closed forms, against each other and for their energy."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from .independent import (
    ETAS,
    MODELS,
    RATIOS,
    TIMES,
    Motion,
    bridge,
    deflection,
    frequencies,
    modal_sum,
    solve_in_positions,
    solve_in_strains,
    solve_von_karman,
)
from .independent.galerkin import Field, Form, System, radau

FROM_REST = np.append(0.0, TIMES)
SMALL = 200.0  # newtons: deflections of a millimetre, nonlinear terms of relative size 1e-8
COARSE = {
    solve_in_positions: {"spans": 20, "steps": 25},
    solve_in_strains: {"degree": 20, "steps": 25},
    solve_von_karman: {"modes": 20, "steps": 25},
}


@cache
def coarse(solve: Callable[..., Motion], damping: str) -> Motion:
    """One row of the table on a coarse mesh."""
    return solve(bridge(0.001, 1.25), damping, FROM_REST, **COARSE[solve])


def table() -> dict[tuple[str, float, float], np.ndarray]:
    lines = (Path(__file__).parent / "data" / "awp_bridge.csv").read_text().splitlines()
    rows = csv.reader(line for line in lines if not line.startswith("#"))
    next(rows)
    return {(r[0], float(r[1]), float(r[2])): np.array(r[3:], dtype=float) for r in rows}


def test_integrator_order_with_a_singular_mass():
    """x_t = x cos t + R and y_t = x cos t + 2 x - R under the index-2 constraint x = y: x = e^(t + sin t), R = x."""
    x, y = (Field(slice(i, i + 1), np.ones((1, 1))) for i in (0, 1))

    def load(t: float) -> Form:
        return Form([x], [x, y], lambda f: [np.cos(t) * f[0]] * 2, np.ones(1))

    linear = np.array([[0, 0, 1.0], [2, 0, -1], [1, -1, 0]])
    system = System(np.diag([1.0, 1, 0]), linear, [], load, np.ones(3), np.ones(3))
    ends = [radau(system, np.array([0, 2.0]), n, tolerance=1e-13)[-1, 0] for n in (8, 16)]
    errors = np.abs(np.array(ends) - np.exp(2 + np.sin(2)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(5, abs=0.5)


def test_frequency_that_the_paper_prints():
    """7.83 rad/s is the first frequency under Q, with I = 0.0243."""
    assert frequencies(bridge(0.001, 1.0), 1)[0] == pytest.approx(7.83437, abs=1e-5)
    assert frequencies(bridge(0.001, 1.0), 1, prestrained=False)[0] == pytest.approx(7.83376, abs=1e-5)


@pytest.mark.parametrize("eta", [0.01, 0.0001])
@pytest.mark.parametrize("solve", [solve_in_positions, solve_in_strains, solve_von_karman])
def test_small_loads_give_the_closed_form(solve, eta):
    """Linear limit, for either damping; von Karman does not know the stretch of the compressed state."""
    case = replace(bridge(eta, 0.75), amplitude=SMALL)
    exact = modal_sum(case, TIMES, prestrained=solve is not solve_von_karman)
    for damping in ("full", "linearised"):
        found = solve(case, damping, FROM_REST, **COARSE[solve]).deflection[1:]
        assert found == pytest.approx(exact, abs=5e-5 * np.abs(exact).max())


@pytest.mark.parametrize("damping", ["full", "linearised"])
@pytest.mark.parametrize("solve", [solve_in_positions, solve_in_strains, solve_von_karman])
def test_energy_balance(solve, damping):
    """Energy gained + energy dissipated = work of P and Q, to the order of the integrator."""
    motion = coarse(solve, damping)
    assert motion.imbalance < 1e-6
    assert np.all(np.diff(motion.dissipated) > 0)
    assert motion.dissipated[-1] > 0.02 * np.abs(motion.energy).max()


@pytest.mark.parametrize(
    ("model", "solve", "damping"),
    [
        ("NL-L", solve_in_positions, "linearised"),
        ("NL-L", solve_in_strains, "linearised"),
        ("NL-NL", solve_in_positions, "full"),
        ("NL-NL", solve_in_strains, "full"),
        ("von Karman linearised", solve_von_karman, "linearised"),
        ("von Karman full", solve_von_karman, "full"),
    ],
)
def test_a_coarse_mesh_gives_the_table(model, solve, damping):
    """Positions and strains, two formulations with nothing but the integrator in common, meet in the same row."""
    assert coarse(solve, damping).deflection[1:] == pytest.approx(table()[model, 0.001, 1.25], abs=2e-4)


def test_linear_rows_of_the_table():
    for eta in ETAS:
        for ratio in RATIOS:
            assert deflection("L-L", eta, ratio) == pytest.approx(table()["L-L", eta, ratio], abs=1e-6)


def test_what_the_table_shows():
    """AWP figure 2: 45 curves; linearised damping dissipates more, less so as eta falls; von Karman is near NL-L."""
    rows = table()
    assert len(rows) == len(MODELS) * len(ETAS) * len(RATIOS)
    gaps = [np.abs(rows["NL-L", eta, 1.0] - rows["NL-NL", eta, 1.0]).max() for eta in ETAS]
    assert gaps[0] > gaps[1] > gaps[2]
    for ratio in RATIOS:
        exact = rows["NL-L", 0.001, ratio]
        near, far = (
            np.abs(rows[f"von Karman {d}", 0.001, ratio] - exact).max() for d in ("linearised", "full")
        )
        assert near < far

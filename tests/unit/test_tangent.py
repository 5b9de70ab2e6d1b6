"""Negative eigenvalues and modes beside conditions, by pivots and saddle systems, against full null spaces."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.constraints.null_space import null_space
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import complex_modes, linearise, natural_frequencies
from viscorod.solve.statics.tangent import negative_eigenvalues, with_one_sign


def section(wide=1.0):
    return vr.StiffnessSection(
        [1e4, 1e4, 1e4, 1.0, wide, 0.8], [1, 1, 1, 1e-3, 1e-3, 2e-3], damping=[1e-3] * 6
    )


def column(load, *, elements, order, constraints="kirchhoff"):
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=section(1.3), constraints=constraints, elements=elements, order=order
    )
    model.add("column", rod)
    model.clamp("column.start")
    model.force("column.end", (-load, 0, 0))
    return model


def four_bar(load):
    """Three Kirchhoff rods on hinges in a plane, and a body."""
    model = vr.Model()
    corners = [(0, 0, 0), (0, 1, 0), (2, 1, 0), (2, 0, 0)]
    for name, start, end in zip("abc", corners[:-1], corners[1:], strict=True):
        model.add(
            name,
            vr.Rod.straight(start, end, section=section(), constraints="kirchhoff", elements=2, order=3),
        )
    model.clamp("a.start")
    model.clamp("c.end")
    model.revolute("a.end", "b.start", (0, 0, 1))
    model.ball("b.end", "c.start")
    model.add("weight", vr.Box(sides=(0.1, 0.1, 0.1), mass=0.5, centre=(1, 1, 0)))
    model.attach("b@1.0", "weight")
    model.force("b@1.0", (0, -load, 0))
    return model


def solved(model):
    work = DiscreteModel.of(model)
    state = State.reference(work.problem)
    assert work.static.solve(state).outcome.name == "COMPLETED"
    return work, state


def counted(model):
    """The number of negative eigenvalues: by pivots, and by all eigenvalues in the full null space."""
    work, state = solved(model)
    tangent = work.static.tangent(state)
    Z = null_space(tangent.gradients)
    within = Z.T @ tangent.stiffness.toarray() @ Z
    values = scipy.linalg.eigvalsh(0.5 * (within + within.T))
    return negative_eigenvalues(tangent), int(np.count_nonzero(values < 0.0))


@pytest.mark.parametrize(("elements", "order"), [(20, 1), (8, 2), (5, 3), (3, 5)])
@pytest.mark.parametrize(("load", "expected"), [(2.0, 0), (2.8, 1), (3.5, 2), (25.0, 3), (70.0, 5)])
def test_column_beyond_its_critical_loads(elements, order, load, expected):
    """Closed form: pi^2 EI (2 k - 1)^2/(4 L^2) with EI = 1 and 1.3: 2.47, 3.21, 22.2, 28.9, 61.7, 80.2."""
    assert counted(column(load, elements=elements, order=order)) == (expected, expected)


@pytest.mark.parametrize(
    "constraints", [("stretch",), ("shear_1", "twist"), ("shear_1", "shear_2", "stretch", "bend_2")]
)
def test_any_conditions_leave_the_count_of_the_full_null_space(constraints):
    for load in (2.0, 2.8, 30.0):
        by_pivots, full = counted(column(load, elements=4, order=4, constraints=constraints))
        assert by_pivots == full


@pytest.mark.parametrize("load", [0.0, 5.0, 12.0, -12.0])
def test_joints_and_bodies(load):
    by_pivots, full = counted(four_bar(load))
    assert by_pivots == full


def test_a_long_rod_is_counted_as_a_short_one():
    """400 elements: a full null space would have 12 000 columns."""
    work, state = solved(column(25.0, elements=400, order=5))
    assert negative_eigenvalues(work.static.tangent(state)) == 3


# --- modes


def cantilever(elements, *, clamped=True, constraints="kirchhoff"):
    model = vr.Model()
    inert = vr.StiffnessSection([1e4] * 3 + [1, 1, 1], [1, 1, 1, 1e-12, 1e-12, 2e-3], damping=[1e-3] * 6)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=inert, constraints=constraints, elements=elements, order=5
    )
    model.add("beam", rod)
    if clamped:
        model.clamp("beam.start")
    return model


@pytest.mark.parametrize("elements", [12, 20, 40])
def test_modes_of_a_fine_mesh(elements):
    """Closed form (C1): Euler-Bernoulli, and damping ratios D omega/(2 EI); full matrices up to 16 elements."""
    modes = cantilever(elements).modes(4, about="reference")
    omega = np.repeat([1.875104068711961, 4.694091132974174], 2) ** 2
    assert 2 * np.pi * modes.frequencies == pytest.approx(omega, rel=1e-6)
    assert modes.damping_ratios == pytest.approx(1e-3 * omega / 2, rel=1e-4)
    if elements <= 20:
        again = cantilever(elements).modes(4, about="reference")
        np.testing.assert_array_equal(modes.eigenvalues, again.eigenvalues)


@pytest.mark.parametrize("constraints", [(), "kirchhoff"])
def test_free_modes_of_a_fine_mesh(constraints):
    """Closed form: six rigid motions, then free-free bending, beta L = 4.7300."""
    frequencies = (
        cantilever(40, clamped=False, constraints=constraints).modes(16, about="reference").frequencies
    )
    slow = 2 * np.pi * frequencies
    assert np.count_nonzero(slow == 0.0) == 6
    assert slow[slow > 1.0][:2] == pytest.approx(np.full(2, 4.730040744862704**2), rel=1e-3)


def test_both_ways_to_the_modes_agree():
    """Independent formulation: full matrices in the null space, and saddle systems, of one model."""
    model = cantilever(40)
    work = DiscreteModel.of(model)
    state = State.reference(work.problem)
    beside = linearise(work.static, state)
    assert beside.gradients is not None
    within = beside.unconditional()
    assert natural_frequencies(beside, 6) == pytest.approx(natural_frequencies(within, 6), rel=1e-7)
    modes = [complex_modes(work.static, state, linear, 6) for linear in (beside, within)]
    assert modes[0].eigenvalues == pytest.approx(modes[1].eigenvalues, rel=1e-7)


def test_a_rod_that_is_held_stiff_has_its_rigid_motions_alone():
    """Closed form: 20 elements without any strain on a hinge and a spring: a rigid bar, w^2 = k L^2/(m L^2/3)."""
    model = cantilever(
        20, clamped=False, constraints=("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")
    )
    model.revolute("beam.start", "ground", (0, 0, 1))
    model.spring("beam.end", stiffness={"uy": 3.0})
    modes = model.modes(6, about="reference")
    assert 2 * np.pi * modes.frequencies == pytest.approx([3.0], rel=1e-5)


@pytest.mark.parametrize("rounding", [-1e-9, 0.0, 1e-9])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_side_of_a_branch_is_no_matter_of_round_off(sign, rounding):
    """A half sine of a symmetric rod turns by as much at one end as at the other: the first of both is positive."""
    direction = np.array([[0.3, 1.0, 0.0, -1.0 - rounding, 0.9]]).T
    assert with_one_sign(sign * direction)[:2, 0].tolist() == [0.3, 1.0]
    assert with_one_sign(sign * np.array([[0.2, -0.5, 0.4]]).T)[:, 0].tolist() == [-0.2, 0.5, -0.4]

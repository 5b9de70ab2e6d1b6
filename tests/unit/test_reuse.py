"""What is made once for models alike: numbers stay those of a run by itself, and another topology has its own."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses import refinement
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.solve.linear import known_plans
from viscorod.solve.linear.known_plans import plan_of
from viscorod.solve.linear.plan import Plan
from viscorod.solve.once import once
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.refinement.half_elements import half_elements, read
from viscorod.solve.refinement.mesh_watch import MeshWatch

TIMES = (0.02, 0.02, 0.03, 0.03, 0.05)


def case(elements=2, time=0.02, **more):
    """Return the case of a cantilever that is let go."""
    square = {"shape": "rectangle", "width": 0.01, "height": 0.01}
    rubber = {
        "youngs_modulus": 1e6,
        "poissons_ratio": 0.49,
        "density": 1100.0,
        "damping": {"shear_time": time, "bulk_time": time},
    }
    beam = {"shape": "straight", "start": [0.0, 0.0, 0.0], "end": [0.3, 0.0, 0.0]}
    mesh = {"elements": elements, "order": 3} if elements else {}
    return case_from_dict(
        {
            "materials": {"rubber": rubber},
            "sections": {"square": square},
            "rods": {"beam": beam | mesh | {"section": "square", "material": "rubber"}},
            "supports": [{"kind": "clamp", "at": "beam.start"}],
            "loads": [{"kind": "force", "at": "beam.end", "value": [0.0, 0.02, 0.0], "until": 0.0}],
            "simulate": {"duration": 0.1, "output_interval": 0.02, **more},
        }
    )


def same(one, other):
    """Whether all variables of two results are equal, bit for bit."""
    return set(one.data.variables) == set(other.data.variables) and all(
        np.array_equal(one.data[name].values, other.data[name].values) for name in one.data.variables
    )


def test_members_are_the_runs_that_cases_give_alone_whatever_was_computed_before():
    values = {
        "rods.beam.elements": [2, 3, 2, 1, 3],
        "materials.rubber.damping": [{"shear_time": t, "bulk_time": t} for t in TIMES],
    }
    found = vr.sweep(case(), values, workers=1)
    for k in range(5):
        known_plans._kept.cache_clear()
        alone = run_case(case(values["rods.beam.elements"][k], TIMES[k]))
        assert same(found.members[k].result, alone)


def test_plans_are_shared_by_problems_alike_and_by_no_others():
    plans = [discretise(case(n).description).plan for n in (2, 2, 3)]
    assert plans[0] is plans[1]
    assert plans[0] is not plans[2]
    problem = discretise(case(2).description)
    apart = plan_of(problem.pattern, ())
    assert apart is not plans[0]
    assert not apart.elimination.fronts
    expected = Plan.of(problem.pattern, problem.interiors)
    for name in ("order", "rows", "targets", "kept"):
        assert np.array_equal(getattr(plans[0], name), getattr(expected, name))


def test_plans_of_large_matrices_are_not_kept(monkeypatch):
    monkeypatch.setattr(known_plans, "MOST_BLOCKS", 10)
    problem = discretise(case(2).description)
    assert plan_of(problem.pattern, problem.interiors) is not plan_of(problem.pattern, problem.interiors)


def test_what_is_made_once_belongs_to_one_object():
    class Holder:
        pass

    made = []

    @once
    def number(holder):
        made.append(holder)
        return len(made)

    first, second = Holder(), Holder()
    assert [number(first), number(first), number(second), number(first)] == [1, 1, 2, 1]


def test_elements_read_in_their_halves_are_the_same_polynomials():
    """On every rod of a mesh of several orders, against polynomials by their coefficients."""
    sizes = ((1, 3), (4, 2), (2, 1), (5, 3))
    whole = half_elements(sizes)
    random = np.random.default_rng(0)
    from viscorod.mechanics.elements.basis import gauss, lobatto

    coarse, fine, points, finer_points = [], [], [], []
    for order, count in sizes:
        inner = 0.5 * (lobatto(order)[0] + 1.0)
        last = None
        for _ in range(count):
            curve, forces = (np.polynomial.Polynomial(random.standard_normal(n)) for n in (order + 1, order))
            if last is not None:  # continuous from element to element
                curve = curve - curve(0.0) + last
            last = curve(1.0)
            own = 0.5 * np.concatenate([inner[:-1], 1.0 + inner[:-1]])
            coarse += curve(inner[:-1]).tolist()
            fine += curve(own).tolist()
            x = 0.5 * (gauss(order)[0] + 1.0)
            points += forces(x).tolist()
            finer_points += forces(0.5 * np.concatenate([x, 1.0 + x])).tolist()
        coarse.append(float(last))
        fine.append(float(last))
    columns = np.array(coarse)[:, None]
    assert read(whole.stations, columns)[:, 0] == pytest.approx(np.array(fine), abs=1e-13)
    forces, divided = np.array(points)[:, None], np.array(finer_points)[:, None]
    assert read(whole.points, forces)[:, 0] == pytest.approx(divided[:, 0], abs=1e-12)
    assert read(whole.whole, forces) == pytest.approx(read(whole.divided, divided), abs=1e-12)
    several = np.stack([columns, 2.0 * columns])
    assert read(whole.stations, several)[1] == pytest.approx(2.0 * np.array(fine)[:, None], abs=1e-13)


def test_a_finer_mesh_that_was_there_already_tells_the_same_errors(monkeypatch):
    """Where the program chooses the mesh, the run uses what was made to choose it."""
    found = run_case(case(elements=None))
    shared = []
    monkeypatch.setattr(MeshWatch, "share", lambda self, other: shared.append(other))
    alone = run_case(case(elements=None))
    assert shared
    assert same(found, alone)
    names = [name for name in alone.data.attrs if name.startswith(("mesh_", "step_"))]
    assert {"mesh_errors", "mesh_motion_error", "mesh_force_error"} <= set(names)
    assert [found.data.attrs[name] for name in names] == [alone.data.attrs[name] for name in names]
    assert refinement.MOST_MESHES > 1


def test_copies_with_other_fields_compute_anew_what_follows_from_them():
    """The rotation of the frame, the matrices of the section and the line, after all of them have been asked for."""
    soft, hard = (vr.Material(modulus, 0.3, 1000.0) for modulus in (1e6, 2e6))
    section = vr.Rectangle(0.01, 0.02)
    line = vr.Straight((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    rod = vr.Rod(line, section, soft)
    before = rod.matrices_at(0.0)[0]
    rod.frames([0.0]), rod.turned([1.0])
    assert rod.model_copy(update={"material": hard}).matrices_at(0.0)[0] == pytest.approx(2.0 * before)
    assert rod.matrices_at(0.5)[0] == pytest.approx(before)
    longer = line.model_copy(update={"end": (0.0, 2.0, 0.0)})
    assert longer.frames([2.0])[0][0] == pytest.approx([0.0, 2.0, 0.0])
    arc = vr.Arc((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 1.0, 1.0)
    assert rod.model_copy(update={"centreline": arc}).turned([1.0])[0] == pytest.approx(1.0)


def test_matrices_of_a_uniform_rod_are_the_readers_own():
    rod = vr.Rod(
        vr.Straight((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), vr.Rectangle(0.01, 0.02), vr.Material(1e6, 0.3, 1e3)
    )
    for matrix in rod.matrices_at(0.0):
        matrix[:] = 0.0
    assert rod.matrices_at(0.0)[0].any()

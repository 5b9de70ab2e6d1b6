"""Neighbours of a motion in compiled steps: bit for bit as in steps that are taken one by one."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.derivatives import motions
from viscorod.analyses.warmup import compile_loop
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.solve.transient import company_steps
from viscorod.solve.transient.company_steps import CompanySteps

pytestmark = pytest.mark.skipif(PURE_PYTHON, reason="nothing is compiled")

E, TIME, WIDTH = (
    "materials.rubber.youngs_modulus",
    "materials.rubber.damping.shear_time",
    "rods.beam.section.width",
)


@pytest.fixture(scope="module", autouse=True)
def loop():
    """Compiled steps are taken where they are there, so they are compiled first."""
    compile_loop()


@pytest.fixture
def taken(monkeypatch):
    """Whether compiled steps were taken up to each corner of motions."""
    found = []
    go = CompanySteps.go

    def watched(self, corner):
        left = go(self, corner)
        found.append(not left)
        return left

    monkeypatch.setattr(CompanySteps, "go", watched)
    return found


def beam(damping=None, **more):
    """A rubber cantilever that hangs aside and is let go."""
    model = vr.Model()
    damping = damping or vr.KelvinVoigt(0.02, 0.02)
    rubber = vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0, damping=damping)
    model.materials["rubber"] = rubber
    given = {"section": vr.Rectangle(0.02, 0.01), "material": rubber, "elements": 2, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given, **more))
    model.gravity((0, 0, -9.81))
    model.force("beam.end", (0.0, 0.05, 0.0), until=0.0)
    return model


def swing():
    """It is clamped, and pushed until 0.05 s: a jump."""
    model = beam()
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.02, 0), until=0.05)
    return model, [E, TIME, WIDTH]


def relaxing():
    """It has Maxwell branches, and drag."""
    model = beam(vr.Prony(shear_ratios=[0.2, 0.1], shear_times=[0.002, 0.02], constant="bulk_modulus"))
    model.clamp("beam.start")
    model.drag("beam", linear_across=0.05)
    return model, [E, "materials.rubber.damping.shear_times[1]"]


def jointed():
    """An inextensible arm on a damped hinge."""
    model = beam()
    model.clamp("beam.start")
    given = {"section": vr.Rectangle(0.015, 0.01), "material": model.materials["rubber"], "order": 3}
    arm = vr.Rod.straight((0.3, 0, 0), (0.38, 0.02, 0.01), elements=1, constraints="inextensible", **given)
    model.add("arm", arm)
    hinge = {"stiffness": {"rz": 0.02}, "damping": {"rz": 2e-4}}
    model.revolute("beam.end", "arm.start", axis=(0.1, 1, 0.2), **hinge)
    return model, [E, "joints[0].damping.rz"]


def shaken():
    """A pin that follows a table, and a guide that holds its other end in part."""
    model = beam()
    times = np.linspace(0.0, 0.1, 6)
    model.pin("beam.start", motion={"ux": vr.TimeTable(times, 1e-3 * np.sin(40.0 * times), "cubic")})
    model.support("beam.end", fixed=["uz", "ry"])
    return model, [E, TIME]


def differentiated(made, **more):
    """The derivatives of a motion, all that is stored of them."""
    model, keys = made()
    found = model.simulate(0.1, output_interval=0.004, derivatives=keys, **more).derivatives
    return {key: one.data for key, one in found.items()}


def require_same(found, wanted):
    """Two derivatives are the same, bit for bit."""
    for key, data in wanted.items():
        assert float(np.abs(data["position"]).max()) > 0.0
        for name, values in data.items():
            assert np.array_equal(found[key][name], values, equal_nan=values.dtype.kind == "f"), (key, name)


@pytest.mark.parametrize("made", [swing, relaxing, jointed, shaken])
def test_compiled_steps_are_those_taken_one_by_one(made, taken, monkeypatch):
    """Independent: each step in Python, with the kernels that a single step has."""
    found = differentiated(made)
    assert taken
    assert all(taken)
    monkeypatch.setattr(CompanySteps, "of", lambda *_: None)
    require_same(found, differentiated(made))


@pytest.mark.parametrize("stuck", [0, 1, 3])
def test_a_step_that_is_left_to_python_changes_nothing(stuck, taken, monkeypatch):
    """Each third step is refused by one of the models: it and those after it take it by themselves, and all go on."""
    members, take, count = [], company_steps._Member.take, [0]

    def refusing(self, end, records):
        if self not in members:
            members.append(self)
        if members.index(self) == stuck:
            count[0] += 1
            if count[0] % 3 == 0:
                return False
        return take(self, end, records)

    wanted = differentiated(swing)
    taken.clear()
    monkeypatch.setattr(company_steps._Member, "take", refusing)
    found = differentiated(swing)
    assert not all(taken)
    require_same(found, wanted)


def test_records_that_do_not_fit_at_once_are_taken_in_pieces(taken, monkeypatch):
    """Arrays of the loops are filled again and again; steps with more records than fit are taken one by one."""
    model, keys = swing()
    given = {"output_interval": 0.0002, "derivatives": keys[:1]}
    found = model.simulate(0.1, **given).derivatives[E].data
    assert all(taken)
    assert len(found.time) == 501
    monkeypatch.setattr(CompanySteps, "of", lambda *_: None)
    require_same({E: found}, {E: model.simulate(0.1, **given).derivatives[E].data})


def test_other_methods_have_no_compiled_steps(taken):
    """The midpoint rule is a collocation method, but has no loop."""
    differentiated(swing, integrator="midpoint", time_step=0.01)
    assert not taken


@pytest.mark.parametrize(("made", "own"), [(swing, False), (jointed, True)])
def test_the_frozen_jacobian_of_the_first_serves_all(made, own, monkeypatch):
    """None that follows makes one, but those with joints, whose records are closed with their own."""
    seen, go = [], motions.side_by_side

    def watched(given, *rest):
        seen.extend(given)
        return go(given, *rest)

    monkeypatch.setattr(motions, "side_by_side", watched)
    differentiated(made)
    counts = [one.integrator.jacobians for one in seen]
    assert counts[0] > 2
    assert all((count > 2) is own for count in counts[1:])

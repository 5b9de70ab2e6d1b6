"""Members of a sweep one after the other: none changes the next, and none waits for a search for garbage."""

from __future__ import annotations

import gc
import tomllib

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.solve.modes import vibrations

TEXT = """
[materials.rubber]
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0

[materials.rubber.damping]
shear_time = 0.01
extensional_time = 0.01

[sections.square]
shape = "rectangle"
width = 0.01
height = 0.01

[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.3, 0.0, 0.0]
section = "square"
material = "rubber"
elements = 1
order = 3

[[supports]]
kind = "clamp"
at = "beam.start"

[[loads]]
kind = "force"
at = "beam.end"
value = [0.0, 0.001, 0.0]
until = 0.0
"""
KINDS = {
    "equilibrium": "[equilibrium]\n",
    "motion": "[simulate]\nduration = 0.05\ntolerance = 1e-3\n",
    "modes": "[modes]\ncount = 4\n",
}
MODULUS = "materials.rubber.youngs_modulus"
MODULI = [1.0e6, 3.0e6, 2.0e6, 1.0e5]


def case_with(kind, modulus=1e6):
    """Return the case of an analysis."""
    content = tomllib.loads(TEXT + KINDS[kind])
    content["materials"]["rubber"]["youngs_modulus"] = modulus
    return case_from_dict(content)


def numbers(result):
    """Return all numbers of a result that do not depend on when it was computed, as bytes."""
    return {
        str(name): np.asarray(values).tobytes()
        for name, values in result.data.variables.items()
        if np.asarray(values).dtype.kind in "fiu"
    }


@pytest.mark.parametrize("kind", KINDS)
def test_members_do_not_depend_on_those_before(kind):
    """Independent: each case by itself, and the members in another order."""
    given = {"workers": 1, "errors": 0, "fields": True}
    forward = vr.sweep(case_with(kind), {MODULUS: MODULI}, **given)
    backward = vr.sweep(case_with(kind), {MODULUS: MODULI[::-1]}, **given)
    alone = vr.sweep(case_with(kind), {MODULUS: MODULI[2:3]}, **given)
    results = [numbers(member.result) for member in forward.members]
    assert results == [numbers(member.result) for member in backward.members][::-1]
    assert results[2] == numbers(alone.members[0].result)
    assert results[0] != results[1]


@pytest.mark.parametrize("kind", KINDS)
def test_members_leave_no_garbage(kind):
    """What refers to itself is freed by a search only, which costs time, and memory until then."""

    def compute():
        vr.sweep(case_with(kind), {MODULUS: MODULI}, workers=1, errors=0, quantities={"one": float_of})

    def left():
        gc.collect()
        gc.disable()
        try:
            compute()
            return gc.collect()
        finally:
            gc.enable()

    compute()  # what is made once
    # members leave every time what they leave; what a thread of another test leaves just then comes once
    assert any(left() == 0 for _ in range(3))


def float_of(result):
    """Read a number of a result."""
    return float(result.data["position"].values[-1, -1, 0])


def test_shapes_and_names_are_those_of_the_member_also_if_they_are_read_later():
    first = run_case(case_with("modes"), errors=False)
    run_case(case_with("modes", 9e6), errors=False)
    again = run_case(case_with("modes"), errors=False)
    assert sorted(first.names) == ["bend_1 1", "bend_1 2", "bend_2 1", "bend_2 2"]
    assert first.names == again.names
    assert first.shapes.tobytes() == again.shapes.tobytes()
    assert first.shares.tobytes() == again.shares.tobytes()


def test_shapes_of_members_are_not_made_for_a_frequency(monkeypatch):
    """Names of modes follow from their shapes; a frequency by its number needs neither."""
    case, given = case_with("modes"), {"workers": 1, "errors": 0, "quantities": {"f": ("frequency", 1)}}
    known = vr.sweep(case, {MODULUS: MODULI}, **given).table()["f"].tolist()
    monkeypatch.setattr(vibrations, "_shown", lambda *_: pytest.fail("shapes were made"))
    assert vr.sweep(case, {MODULUS: MODULI}, **given).table()["f"].tolist() == known

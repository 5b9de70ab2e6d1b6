"""What prescribed motions turn against each other: counted by hand, as a person would see it."""

from __future__ import annotations

import pytest

import viscorod as vr
from viscorod.solve.problem.prescribed_turns import prescribed_turn

GIVEN = {"section": vr.Circle(0.005), "material": vr.Material(2e11, 0.3, 7850.0)}
SPIN = vr.SpinUp(300.0, 2.0)


def rod():
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), **GIVEN))
    return model


def shaft_in_bearings():
    model = rod()
    model.support("rod.start", ["ux", "uy", "uz"], motion={"rx": SPIN})
    model.support("rod.end", ["uy", "uz"])
    return model, 0.0


def shaft_on_a_motor():
    model = rod()
    model.revolute("rod.start", "ground", (1, 0, 0), motion={"rz": SPIN})
    model.support("rod.end", ["uy", "uz"])
    return model, 0.0


def blade_on_a_hub():
    model = rod()
    model.clamp("rod.start", motion={"rz": SPIN})
    return model, 0.0


def twisted():
    model = rod()
    model.clamp("rod.start", motion={"rx": vr.Ramp(0.0, 1.0)})
    model.clamp("rod.end")
    return model, 1.0


def twisted_by_a_motor():
    model = rod()
    model.revolute("rod.start", "ground", (1, 0, 0), motion={"rz": vr.Ramp(0.0, 1.0)})
    model.clamp("rod.end")
    return model, 1.0


def turned_at_both_ends():
    """One end turns by 1 rad, the other by 3 rad."""
    model = rod()
    model.clamp("rod.start", motion={"rx": vr.Ramp(0.0, 1.0)})
    model.clamp("rod.end", motion={"rx": vr.TimeTable([0.0, 1.0], [0.0, 3.0])})
    return model, 2.0


def bent_by_its_end():
    model = rod()
    model.pin("rod.start")
    model.support("rod.end", ["uy", "uz"], motion={"ry": vr.Ramp(0.0, 1.0)})
    return model, 1.0


def slider_crank():
    model = vr.Model()
    model.add("crank", vr.Rod.straight((0, 0, 0), (0.1, 0, 0), **GIVEN))
    model.add("coupler", vr.Rod.straight((0.1, 0, 0), (0.4, 0, 0), **GIVEN))
    model.add("slider", vr.Box((0.02, 0.02, 0.02), centre=(0.4, 0, 0), mass=0.1))
    model.revolute("crank.start", "ground", (0, 0, 1), motion={"rz": SPIN})
    model.revolute("coupler.start", "crank.end", (0, 0, 1))
    model.revolute("slider", "coupler.end", (0, 0, 1))
    model.prismatic("slider", "ground", (1, 0, 0))
    return model, 0.0


CASES = (
    shaft_in_bearings, shaft_on_a_motor, blade_on_a_hub, twisted, twisted_by_a_motor, turned_at_both_ends,
    bent_by_its_end, slider_crank,
)  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.__name__)
def test_only_what_rods_must_take_up_counts(case):
    model, turn = case()
    assert prescribed_turn(model) == pytest.approx(turn, abs=1e-7)


def test_a_shaft_that_turns_in_bearings_keeps_its_mesh():
    """It had 144 elements of order 5, one for each turn of the shaft."""
    model, _ = shaft_in_bearings()
    assert model.simulate(1e-3, initial="reference").data.sizes["station"] < 30

"""Conditions of a rod model: their numbers, limits and tables, before a solution and of results."""

import math

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel

RUBBER = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))


def arc(section, material=RUBBER):
    model = vr.Model()
    given = {"section": section, "d1": (0, 1, 0), "twist": 0.8, "elements": 2, "order": 4}
    if material is not None:
        given["material"] = material
    model.add("arc", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 0.1, 2.0, **given))
    model.clamp("arc.start")
    model.force("arc.end", (0, 0, 0.002), until=0.0)
    return model


def numbers(validity):
    return [condition.value for condition in validity.conditions]


def test_an_arc_in_numbers():
    """Half width 0.015 m, radius 0.1 m, length 0.2 m, 0.8 rad of twist; strains of the run itself."""
    model = arc(vr.Circle(0.015))
    run = model.simulate(0.05)
    found = run.validity()
    curved, twisted, slender, shear, bending, rate = found.conditions
    assert [curved.value, twisted.value, slender.value] == pytest.approx([0.15, 0.06, 0.075], rel=1e-3)
    strain = np.abs(run.data.strain.values).max(axis=(0, 1))
    assert shear.value == pytest.approx(strain[:3].max())
    assert bending.value == pytest.approx(0.015 * strain[3:].max())
    assert rate.value == pytest.approx(max(strain.product for strain in run.damping_validity().strains))
    assert [curved.kept, twisted.kept, found.valid] == [False, True, False]
    report = run.report()
    assert "Validity of the rod model" in flat(report)
    line, where = (line.split() for line in report.splitlines() if "|J0 - 1|" in line)
    assert line[-5:] == ["0.15", "0.1", "NO", "LLT", "2.2"]
    assert where[-1] == f"arc@{curved.where.partition('@')[2]}"
    still = model.equilibrium().validity()
    assert numbers(still)[:3] == pytest.approx([0.15, 0.06, 0.075], rel=1e-3)
    assert len(still.conditions) == 5
    before = check(DiscreteModel.of(model)).validity
    assert [condition.name for condition in before.conditions[:5]] == [c.name for c in found.conditions[:5]]
    assert numbers(before)[:3] == pytest.approx([0.15, 0.06, 0.075], rel=1e-3)
    omega = 2 * np.pi * check(DiscreteModel.of(model)).frequencies[0]
    assert before.conditions[-1].value == pytest.approx(0.02 * omega)
    assert before.conditions[-1].limit == rate.limit == 0.5


def test_what_is_not_known_is_said():
    """Sections given by numbers have no width; an elastic rod has no rate; branches hold at every frequency."""
    C, _, M = vr.Circle(0.005).matrices(RUBBER)
    plain = arc(vr.StiffnessSection(C, M), None).equilibrium().validity()
    assert [math.isnan(value) for value in numbers(plain)] == [True, True, True, False, True]
    assert "sections without a known shape" in flat(str(plain))
    assert plain.valid
    elastic = arc(vr.Circle(0.005), vr.Material(1e6, 0.3, 1000.0)).simulate(0.02).validity()
    assert elastic.conditions[-1].where == "no Kelvin-Voigt damping"
    series = vr.Prony(shear_ratios=[0.5], shear_times=[0.1], constant="poissons_ratio")
    relaxing = arc(vr.Circle(0.005), vr.Material(1e6, 0.3, 1000.0, damping=series)).simulate(0.02).validity()
    assert relaxing.conditions[-1].where == "Maxwell branches hold at every frequency"

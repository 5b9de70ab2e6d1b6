"""A material needs a density only where something moves."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod import programs


def cantilever(material) -> vr.Model:
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.01), material=material, elements=2
    )
    model.add("bar", rod)
    model.clamp("bar.start")
    model.force("bar.end", (0.0, 0.0, 3.0))
    return model


def test_statics_are_those_with_any_density():
    light, heavy = (vr.Material(2e11, 0.3, density) for density in (1.0, 1e4))
    expected = cantilever(light).equilibrium()
    for material in (heavy, vr.Material(2e11, 0.3)):
        found = cantilever(material).equilibrium()
        assert np.array_equal(found.data.position, expected.data.position)
    assert cantilever(vr.Material(2e11, 0.3)).rods["bar"].has_inertia is False


@pytest.mark.parametrize(
    "ask",
    [lambda m: m.simulate(1.0), lambda m: m.modes(), lambda m: m.campbell(axis=(0, 0, 1), band=(0.0, 1.0))],
)
def test_what_moves_asks_for_it(ask):
    model = cantilever(vr.Material(2e11, 0.3))
    with pytest.raises(
        vr.InputError, match=r"rods.bar.material.density: it was left out, and something moves here"
    ):
        ask(model)


def test_weight_mass_and_other_programs_ask_for_it():
    model = cantilever(vr.Material(2e11, 0.3))
    with pytest.raises(vr.InputError, match="give the density"):
        _ = model.mass
    with pytest.raises(vr.InputError, match="other programs need its inertia"):
        programs.blade_from_rod(model.rods["bar"])
    assert "not given" in str(model.check())
    with pytest.raises(vr.InputError, match="the weight of bar is not known"):
        model.gravity()


def test_a_composite_section_needs_that_of_every_region():
    pytest.importorskip("sectionproperties")
    steel, core = vr.Material(2e11, 0.3, 7850.0), vr.Material(1e9, 0.3)
    halves = [
        vr.CompositeRegion(material, vr.Rectangle(0.02, 0.01), at=(0.0, y))
        for material, y in ((steel, 0.005), (core, -0.005))
    ]
    assert not vr.Composite(halves, origin="given").has_inertia
    both = [vr.CompositeRegion(steel, region.section, at=region.at) for region in halves]
    assert vr.Composite(both, origin="given").has_inertia


def test_a_case_that_moves_is_refused_when_it_is_checked(tmp_path):
    case = tmp_path / "bar.toml"
    case.write_text(cantilever(vr.Material(2e11, 0.3)).to_toml())
    assert vr.load_case(case).kind == "equilibrium"
    from typer.testing import CliRunner

    from viscorod.cli.app import app

    case.write_text(case.read_text().replace("[equilibrium]", "[simulate]\nduration = 1.0\n"))
    found = CliRunner().invoke(app, ["check", str(case), "-o", str(tmp_path / "out")])
    assert found.exit_code == 2
    assert "bar.material.density" in found.output

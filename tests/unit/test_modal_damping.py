"""Materials whose times follow from a measured damping ratio: the damped modes computed afterwards have it."""

import json
import math

import numpy as np
import pytest

import viscorod as vr
from helpers.pictures import written
from viscorod.analyses.check import check, doubts
from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import InputError
from viscorod.model.materials.measured_damping import MeasuredDamping


def material(**damping) -> vr.Material:
    return vr.Material(1e7, poissons_ratio=0.3, density=1000.0, damping=vr.MeasuredDamping(**damping))


def cantilever(made_of: vr.Material, width: float = 0.01, **rod) -> vr.Model:
    model = vr.Model()
    section = vr.Rectangle(width, 0.012)
    model.add(
        "beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=made_of, elements=3, **rod)
    )
    model.clamp("beam.start")
    return model


@pytest.mark.parametrize("mode", [1, 3, "bend_1 1", "bend_2 2", "twist 1", "stretch 1"])
def test_the_mode_has_the_ratio(mode):
    model = cantilever(material(ratio=0.02, mode=mode))
    known = model.with_known_times().rods["beam"].material
    assert known.shear_time == known.bulk_time == pytest.approx(known.extensional_time, rel=1e-12)
    # of one material with equal times: ratio = omega tau/2 exactly, so one mode has the ratio
    ratios = model.modes(20, about="reference").damping_ratios
    assert np.abs(ratios / 0.02 - 1.0).min() < 1e-8


def test_the_named_mode_is_meant():
    # Euler-Bernoulli: frequencies of a cantilever 3.516 and 22.03 times h/L^2 sqrt(E/12 rho), the first ones of both
    # bendings; bend_1 bends the height of 12 mm. A torsional bar: pi/2L sqrt(GJ/rho Ip)
    times = {}
    for mode in ("bend_1 1", "bend_1 2", "bend_2 1", "twist 1", 1, 2):
        damping = material(ratio=1e-3, mode=mode)
        times[mode] = cantilever(damping).with_known_times().rods["beam"].material.shear_time
    speed = math.sqrt(1e7 / 1000.0 / 12.0) / 0.3**2
    assert times["bend_1 1"] == pytest.approx(2e-3 / (3.516 * 0.012 * speed), rel=0.01)
    assert times["bend_2 1"] == pytest.approx(2e-3 / (3.516 * 0.010 * speed), rel=0.01)
    assert times["bend_1 2"] == pytest.approx(2e-3 / (22.03 * 0.012 * speed), rel=0.03)
    section, known = vr.Rectangle(0.01, 0.012), cantilever(material(ratio=0.1)).with_known_times()
    C, _, M = known.rods["beam"].matrices_at(0.0)
    assert section.torsion() * known.rods["beam"].material.shear_modulus == pytest.approx(C[5, 5])
    assert times["twist 1"] == pytest.approx(2e-3 / (math.pi / 0.6 * math.sqrt(C[5, 5] / M[5, 5])), rel=1e-3)
    assert times[1] == times["bend_2 1"]
    assert times[2] == times["bend_1 1"]


def test_modes_of_equal_frequency():
    # a square section: any direction bends alike, and both words find a mode
    times = [
        cantilever(material(ratio=0.01, mode=mode), width=0.012)
        .with_known_times()
        .rods["beam"]
        .material.shear_time
        for mode in (1, 2, "bend_1 1", "bend_2 1")
    ]
    assert times == pytest.approx([times[0]] * 4, rel=1e-9)


def test_logarithmic_decrement():
    # LLT section 3: delta = 2 pi zeta/sqrt(1 - zeta^2)
    zeta = 0.05
    decrement = 2.0 * math.pi * zeta / math.sqrt(1.0 - zeta**2)
    assert MeasuredDamping(logarithmic_decrement=decrement).target == pytest.approx(zeta, rel=1e-14)
    ratios = cantilever(material(logarithmic_decrement=decrement)).modes(2, about="reference").damping_ratios
    assert ratios[0] == pytest.approx(zeta, rel=1e-8)


@pytest.mark.parametrize("ratio", [1e-2, 1e-3])
def test_unequal_times_are_right_to_first_order(ratio):
    # without bulk viscosity shear and extension differ; the error is of second order in the ratio
    model = cantilever(material(ratio=ratio, bulk_to_shear=0.0))
    known = model.with_known_times().rods["beam"].material
    assert known.bulk_time == 0.0
    assert known.extensional_time == pytest.approx(2.6 / 3.0 * known.shear_time, rel=1e-12)
    found = model.modes(1, about="reference").damping_ratios[0]
    assert found == pytest.approx(ratio, rel=ratio**2)


def test_held_strains_and_free_rods():
    held = cantilever(material(ratio=0.02), constraints="kirchhoff")
    assert held.modes(1, about="reference").damping_ratios[0] == pytest.approx(0.02, rel=1e-8)
    free = vr.Model()
    free.add(
        "beam",
        vr.Rod.straight(
            (0, 0, 0),
            (0.3, 0, 0),
            section=vr.Rectangle(0.01, 0.012),
            material=material(ratio=0.02),
            elements=4,
        ),
    )
    # free-free Euler-Bernoulli: 22.37 in place of 3.516; rigid motions do not count
    tau = free.with_known_times().rods["beam"].material.shear_time
    omega = 22.37 * 0.01 * math.sqrt(1e7 / 1000.0 / 12.0) / 0.3**2
    assert tau == pytest.approx(0.04 / omega, rel=0.01)


def two_rods(first: vr.Material, second: vr.Material) -> vr.Model:
    """A softer rod at the end of a stiffer one."""
    model = vr.Model()
    for name, made_of, start, end, width in (
        ("arm", first, 0.0, 0.2, 0.01),
        ("tip", second, 0.2, 0.4, 0.006),
    ):
        section = vr.Rectangle(width, 0.012)
        model.add(
            name, vr.Rod.straight((start, 0, 0), (end, 0, 0), section=section, material=made_of, elements=2)
        )
    model.clamp("arm.start")
    model.attach("arm.end", "tip.start")
    return model


def test_two_materials_jointly():
    model = two_rods(material(ratio=1e-4, mode="bend_2 1"), material(ratio=5e-4, mode="bend_2 1", rod="tip"))
    known = model.with_known_times()
    assert known.rods["arm"].material.shear_time != known.rods["tip"].material.shear_time
    modes = model.modes(12, about="reference")
    assert modes.damping_ratios[0] == pytest.approx(1e-4, rel=1e-5)
    assert np.abs(modes.damping_ratios / 5e-4 - 1.0).min() < 1e-5


def test_one_material_of_two_rods_has_one_time():
    model = two_rods(material(ratio=1e-3), material(ratio=1e-3))
    times = [rod.material.shear_time for rod in model.with_known_times().rods.values()]
    assert times[0] == times[1]
    assert model.modes(1, about="reference").damping_ratios[0] == pytest.approx(1e-3, rel=1e-8)


def test_other_damping_counts():
    steel = vr.Material(1e7, 0.3, 1000.0, damping=vr.KelvinVoigt(1e-6, 1e-6))
    model = two_rods(steel, material(ratio=1e-4))
    assert model.modes(1, about="reference").damping_ratios[0] == pytest.approx(1e-4, rel=1e-6)
    damper = cantilever(material(ratio=1e-4, mode="bend_2 1"))
    damper.spring("beam.end", stiffness={"uy": 0.01}, damping={"uy": 1e-5})
    alone = cantilever(material(ratio=1e-4, mode="bend_2 1"))
    assert damper.modes(1, about="reference").damping_ratios[0] == pytest.approx(1e-4, rel=1e-6)
    less, more = (m.with_known_times().rods["beam"].material.shear_time for m in (damper, alone))
    assert less < more


def test_every_analysis_builds_it(tmp_path):
    model = cantilever(material(ratio=0.05))
    model.force("beam.end", (0.0, 0.01, 0.0), until=0.0)
    run = model.simulate(4.0, tolerance=1e-4)
    said = json.loads(run.data.attrs["damping_assumptions"])["beam"]
    assert any("gives mode 1 of the unloaded model" in text for text in said)
    again = vr.load(run.save(tmp_path / "run.nc"))
    assert json.loads(again.data.attrs["damping_assumptions"])["beam"] == said
    assert json.loads(run.data.attrs["case"])["rods"]["beam"]["material"]["damping"] == {
        "kind": "modal",
        "ratio": 0.05,
    }
    # read off the maxima of the motion, which higher modes and the amplitude shift a little
    assert run.decrement("beam.end", axis="y").damping_ratio[-1] == pytest.approx(0.05, rel=0.02)
    assert "damping_assumptions" in model.equilibrium().data.attrs
    report = check(DiscreteModel.of(model))
    assert report.damping_ratios[0] == pytest.approx(0.05, rel=1e-8)
    assert report.assumptions[0].startswith("rod beam: the shear time of ")
    assert report.materials[0]["shear time [s]"] == model.with_known_times().rods["beam"].material.shear_time
    assert isinstance(doubts(DiscreteModel.of(model)), list)
    assert written(model.draw, tmp_path / "beam.png").stat().st_size > 0


@pytest.mark.parametrize(
    ("damping", "message"),
    [
        ({"ratio": 0.1, "rod": "bean"}, r"rods.beam.material.damping.rod: 'bean': .*did you mean 'beam'"),
        (
            {"ratio": 0.1, "mode": "stretch 40"},
            r"damping.mode: .* modes mostly of stretch; give a lower number",
        ),
    ],
)
def test_there_must_be_such_a_mode(damping, message):
    with pytest.raises(InputError, match=message):
        cantilever(material(**damping)).modes(1)


def test_what_cannot_be_solved():
    steel = vr.Material(1e7, 0.3, 1000.0, damping=vr.KelvinVoigt(1e-2, 1e-2))
    with pytest.raises(InputError, match=r"rods.tip.material.damping: the other parts of the model damp"):
        two_rods(steel, material(ratio=1e-5)).modes(1)
    with pytest.raises(InputError, match="do not distinguish the damping of these materials"):
        two_rods(material(ratio=1e-3), material(ratio=2e-3)).modes(1)
    relaxing = vr.Material(
        1e7, 0.3, 1000.0, damping=vr.Prony(shear_ratios=[0.1], shear_times=[1.0], constant="poissons_ratio")
    )
    with pytest.raises(InputError, match="rod arm: its Maxwell branches"):
        two_rods(relaxing, material(ratio=1e-3)).modes(1)


def test_a_material_alone_has_no_times():
    alone = material(ratio=0.02)
    for name in ("shear_time", "bulk_time", "extensional_time", "shear_viscosity", "extensional_viscosity"):
        with pytest.raises(
            InputError, match=r"this material stands alone; ask the materials of Model\.with_known"
        ):
            getattr(alone, name)
    assert vr.Material.model_validate(alone.to_dict()) == alone


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "give ratio or logarithmic_decrement"),
        ({"ratio": 0.1, "logarithmic_decrement": 0.1}, "0.1 and 0.1"),
        ({"ratio": 0.0}, "above 0 and below 1"),
        ({"ratio": 1.0}, "above 0 and below 1"),
        ({"logarithmic_decrement": -0.1}, "successive maxima"),
        ({"ratio": 0.1, "mode": 0}, "from 1 to 50"),
        ({"ratio": 0.1, "mode": 1.5}, "from 1 to 50"),
        ({"ratio": 0.1, "mode": "bend 1"}, "did you mean 'bend_"),
        ({"ratio": 0.1, "mode": "bend_1"}, "1 to 50 behind the word: 'bend_1 1'"),
        ({"ratio": 0.1, "mode": "twist 99"}, "1 to 50 behind the word"),
        ({"ratio": 0.1, "rod": "a b"}, "not usable as a name"),
        ({"ratio": 0.1, "bulk_to_shear": -1.0}, "bulk_to_shear: -1.0"),
    ],
)
def test_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        MeasuredDamping(**arguments)

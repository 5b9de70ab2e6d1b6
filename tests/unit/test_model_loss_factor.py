"""Loss factors over a band: Maxwell branches held against the loss factor that they stand for."""

import math

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.analyses.check import check, doubts
from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import InputError

BAND = (1.0, 1000.0)


def loss(material, frequency, strain="extension"):
    modulus = material.relaxation(strain).complex_modulus(2.0 * np.pi * np.asarray(frequency))
    return modulus.imag / modulus.real


def metal(nu=0.3, **damping):
    return vr.Material(2e11, nu, 7850.0, damping=vr.LossFactor(**damping))


@pytest.mark.parametrize("strain", ["extension", "shear"])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_a_flat_loss_factor_is_flat_within_two_per_cent(strain, nu):
    steel = metal(nu, **{strain: 0.01}, band=BAND)
    frequencies = np.geomspace(*BAND, 1000)
    for word in ("extension", "shear"):
        assert np.abs(loss(steel, frequencies, word) / 0.01 - 1.0).max() < 0.02
    # the moduli given are the storage moduli in the geometric middle; those at rest are lower
    middle = steel.relaxation("extension").complex_modulus(2.0 * np.pi * math.sqrt(1000.0))
    assert middle.real == pytest.approx(2e11, rel=1e-12)
    assert steel.youngs_modulus < 2e11
    assert steel.poissons_ratio == nu
    assert all(b.youngs_modulus > 0.0 and b.shear_modulus > 0.0 for b in steel.branches)
    assert any("1.1 % of itself" in text for text in steel.assumptions)


def test_the_storage_modulus_rises_as_causality_demands():
    # Kramers-Kronig for a small constant loss factor: d ln E'/d ln w = 2 eta/pi
    steel = metal(extension=0.01, band=BAND, within=1e-3)
    at = steel.relaxation("extension").complex_modulus(2.0 * np.pi * np.array([10.0, 100.0])).real
    assert math.log(at[1] / at[0]) == pytest.approx(2.0 * 0.01 / math.pi * math.log(10.0), rel=0.01)


def test_more_branches_for_a_smaller_error():
    counts = []
    for within in (0.1, 0.02, 1e-3, 1e-4):
        steel = metal(extension=0.01, band=BAND, within=within)
        assert np.abs(loss(steel, np.geomspace(*BAND, 1000)) / 0.01 - 1.0).max() < 1.02 * within
        counts.append(len(steel.branches))
    assert counts == sorted(set(counts))


@pytest.mark.parametrize("at", [0.0, 1.0, 250.0])
def test_moduli_at_another_frequency(at):
    steel = metal(extension=0.05, band=BAND, moduli_at=at)
    for strain, modulus in (("extension", 2e11), ("shear", 2e11 / 2.6)):
        found = steel.relaxation(strain).complex_modulus(2.0 * np.pi * at).real
        assert found == pytest.approx(modulus, rel=1e-12)


def test_a_table_is_followed():
    frequency = np.geomspace(0.1, 100.0, 7)
    values = 0.1 + 0.05 * np.sin(np.log10(frequency))
    rubber = metal(0.5, frequency=frequency, extension=values)
    assert loss(rubber, frequency) == pytest.approx(values, rel=0.02)
    part = metal(0.5, frequency=frequency, extension=values, band=(1.0, 10.0))
    assert loss(part, [1.0, 10.0]) == pytest.approx(np.interp([1.0, 10.0], frequency, values), rel=0.02)
    assert len(part.branches) < len(rubber.branches)


def test_what_branches_cannot_follow_is_said():
    steep = metal(frequency=[1.0, 10.0, 100.0], extension=[0.01, 0.5, 0.01])
    assert any("2 % were wanted; this is the closest" in text for text in steep.assumptions)


def test_extension_and_shear():
    steel = metal(extension=0.01, shear=0.011, band=BAND)
    frequencies = np.geomspace(*BAND, 300)
    assert np.abs(loss(steel, frequencies) / 0.01 - 1.0).max() < 0.02
    assert np.abs(loss(steel, frequencies, "shear") / 0.011 - 1.0).max() < 0.02
    assert not any("taken equal" in text for text in steel.assumptions)
    # (2(1+nu)/3) of the loss factor in shear is the least in extension, as it is of the times
    with pytest.raises(InputError, match=r"damping.extension: 0\.01 in extension: .*negative bulk viscosity"):
        metal(extension=0.01, shear=0.02, band=BAND)
    with pytest.raises(InputError, match="incompressible"):
        metal(0.5, extension=0.01, shear=0.011, band=BAND)


def test_shear_and_bulk():
    # E* = 9 K* G*/(3 K* + G*) at the frequency where the moduli are those given
    steel = metal(shear=0.02, bulk=0.005, band=(20.0, 60.0), within=1e-4)
    G, K = 2e11 / 2.6 * (1 + 0.02j), 2e11 / 1.2 * (1 + 0.005j)
    young = 9.0 * K * G / (3.0 * K + G)
    assert loss(steel, math.sqrt(1200.0)) == pytest.approx(young.imag / young.real, rel=1e-3)
    assert loss(steel, 30.0, "shear") == pytest.approx(0.02, rel=2e-4)
    # at one frequency the times follow from the two directly
    slow = metal(frequency=2.0, shear=0.02, bulk=0.01)
    assert 2.0 * math.pi * 2.0 * slow.shear_time == pytest.approx(0.02, rel=1e-14)
    assert 2.0 * math.pi * 2.0 * slow.bulk_time == pytest.approx(0.01, rel=1e-14)
    with pytest.raises(InputError, match="no volume change"):
        metal(0.5, shear=0.02, bulk=0.005, band=BAND)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"extension": 0.01}, "frequency: a loss factor holds at a frequency or over a band"),
        ({"frequency": 0.01, "band": BAND}, "there is no loss factor"),
        ({"frequency": 1.0, "extension": 0.1, "band": BAND}, "leave frequency out"),
        ({"frequency": [1.0, 2.0], "extension": 0.1}, "a table has a loss factor for every frequency"),
        ({"frequency": [1.0, 2.0], "extension": [0.1, 0.1, 0.1]}, "extension: 3 numbers"),
        ({"frequency": [2.0, 1.0], "extension": [0.1, 0.1]}, "frequencies of a table increase"),
        ({"frequency": [1.0, 2.0], "extension": [0.1, 0.0]}, r"extension\[1\]: 0.0"),
        ({"frequency": [1.0, 2.0], "extension": [0.1, 0.1], "band": BAND}, "goes from 1 to 2 Hz"),
        ({"extension": [0.1, 0.1], "band": BAND}, "needs the frequencies of its rows"),
        ({"extension": 0.1, "bulk": 0.1, "band": BAND}, "bulk: given: extension, bulk"),
        ({"frequency": 1.0, "extension": 0.1, "within": 0.01}, "within: 0.01"),
        ({"frequency": 1.0, "extension": 0.1, "moduli_at": 0.0}, "moduli_at: 0.0"),
        ({"extension": 0.1, "band": BAND, "within": 2.0}, "within: 2.0"),
        ({"extension": 0.1, "band": (5.0, 1.0)}, "band"),
    ],
)
def test_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        vr.LossFactor(**arguments)


def test_no_loss_is_no_loss():
    assert metal(extension=0.0, band=BAND).branches == ()


def test_written_as_it_was_given():
    damping = vr.LossFactor(frequency=[1.0, 10.0], extension=[0.01, 0.02], moduli_at=0.0)
    steel = vr.Material(2e11, 0.3, 7850.0, damping=damping)
    assert vr.Material.model_validate(steel.to_dict()) == steel
    assert steel.to_dict()["youngs_modulus"] == 2e11


def bar(material, length=1.0):
    model = vr.Model()
    model.add(
        "bar", vr.Rod.straight((0, 0, 0), (length, 0, 0), section=vr.Circle(0.01), material=material, order=4)
    )
    model.clamp("bar.start")
    return model


def test_modes_have_half_the_loss_factor():
    # a mode of a homogeneous rod sees E* alone, and to first order its damping ratio is half the loss factor
    modes = bar(metal(extension=0.01, band=BAND)).modes(8)
    assert modes.frequencies[0] > BAND[0]
    assert modes.frequencies[-1] < BAND[1]
    assert modes.damping_ratios == pytest.approx(np.full(8, 0.005), rel=0.015)


def test_a_silicone_bar_with_and_without_a_weight():
    # free decays of a bar of silicone (ETH Zurich, diffPD_sim2real): a loss factor of about 0.10 at 7.7 Hz alone and at
    # 4.4 Hz with 52 g at its tip; Kelvin-Voigt that is right alone has little more than half of it there
    ratios = {}
    for name, damping in (
        ("band", vr.LossFactor(extension=0.10, band=(1.0, 20.0))),
        ("one frequency", vr.LossFactor(frequency=7.7, extension=0.10)),
    ):
        silicone = vr.Material(3.0e5, 0.499, 1070.0, damping=damping)
        for weight in (0.0, 0.052):
            model = vr.Model()
            rod = vr.Rod.straight((0, 0, 0), (0.1, 0, 0), section=vr.Rectangle(0.03, 0.03), material=silicone)
            model.add("bar", rod)
            model.clamp("bar.start")
            if weight:
                model.add("weight", vr.Body(weight, (1e-6, 1e-6, 1e-6), centre=(0.1, 0, 0)))
                model.attach("bar.end", "weight")
            modes = model.modes(2, about="reference")
            ratios[name, weight] = modes.damping_ratios[0] / 0.05
    assert ratios["band", 0.0] == pytest.approx(1.0, rel=0.05)
    assert ratios["band", 0.052] == pytest.approx(1.0, rel=0.05)
    assert ratios["one frequency", 0.0] == pytest.approx(1.0, rel=0.15)
    assert ratios["one frequency", 0.052] < 0.65


def test_a_run_tells_whether_it_is_in_the_band():
    for band, place in (((1.0, 1000.0), "within it"), ((200.0, 1000.0), "outside of it")):
        model = bar(metal(extension=0.05, band=band))
        model.force("bar.end", (0.0, 0.0, 5.0), until=0.0)
        report = flat(model.simulate(0.5).report())
        assert f"its loss factor holds from {band[0]:.4g} Hz to 1000 Hz" in report
        assert place in report


def test_a_decay_has_the_damping_ratio_of_the_mode():
    model = bar(metal(extension=0.05, band=(1.0, 1000.0)))
    model.force("bar.end", (0.0, 0.0, 5.0), until=0.0)
    mode = model.modes(1)
    run = model.simulate(8.0 / float(mode.frequencies[0]), tolerance=1e-6)
    decay = run.decrement("bar.end", "z", rest=None)  # slow branches let the position of rest creep back
    assert decay.damping_ratio[3:6] == pytest.approx(np.full(3, mode.damping_ratios[0]), rel=0.01)
    # a loss factor that is flat everywhere means E* as s^alpha, and free vibrations s^(2 - alpha) = -omega^(2 - alpha)
    alpha = 2.0 / math.pi * math.atan(0.05)
    exact = math.sin(0.5 * math.pi * alpha / (2.0 - alpha))
    assert mode.damping_ratios[0] == pytest.approx(exact, rel=0.02)


def test_frequencies_outside_of_the_band_are_told():
    model = DiscreteModel.of(bar(metal(extension=0.01, band=(100.0, 1000.0))))
    found = [text for text in check(model).warnings if "its loss factor holds from 100 to 1000 Hz" in text]
    first = float(check(model).frequencies[0])
    assert len(found) == 1
    assert f"of the model {first:.3g}" in found[0]
    assert doubts(model)[-1].startswith("rod bar: its loss factor holds")
    inside = DiscreteModel.of(bar(metal(extension=0.01, band=(1.0, 1000.0))))
    assert not any("loss factor" in text for text in check(inside).warnings)

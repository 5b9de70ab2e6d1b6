"""Time-temperature shift and self-heating, against closed forms."""

import math

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.errors import InputError
from viscorod.model.sections.composite import Composite, CompositeRegion
from viscorod.results.text_numbers import quantity

SHIFT = vr.WLF(c1=8.86, c2=101.6, reference=20.0)
LAWS = {
    "prony": vr.Prony(shear_ratios=[0.3, 0.5], shear_times=[0.002, 0.03], constant="bulk_modulus"),
    "loss factor": vr.LossFactor(extension=0.2, band=(1.0, 100.0)),
    "one frequency": vr.LossFactor(frequency=10.0, extension=0.2),
    "times": vr.KelvinVoigt(0.002, 0.003),
    "viscosities": vr.KelvinVoigt(shear_viscosity=800.0, bulk_viscosity=900.0),
    "moduli": vr.ComplexModuli(
        frequency=[1, 10, 100], storage=[1e6, 1.2e6, 1.5e6], loss=[5e4, 9e4, 1e5], law="maxwell"
    ),
}


def material(law, temperature=None, density=1000.0, **more):
    warm = {} if temperature is None else {"temperature": temperature, "shift": SHIFT}
    return vr.Material(1e6, 0.4, density, damping=LAWS[law], **warm, **more)


def cantilever(given):
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Circle(0.01), material=given, elements=2, order=3
    )
    model.add("rod", rod)
    model.clamp("rod.start")
    model.force("rod.end", (0.0, 0.0, 0.1), until=0.0)
    return model


def test_factors():
    # Williams, Landel and Ferry: log10 a_T = -c1 (T - T_ref)/(c2 + T - T_ref)
    assert SHIFT.factor(20.0) == 1.0
    assert SHIFT.factor(50.0) == pytest.approx(10.0 ** (-8.86 * 30.0 / 131.6), rel=1e-14)
    # Arrhenius: E_a = R ln 2/(1/293.15 - 1/303.15) halves the times from 20 to 30 degrees C
    halving = 8.314462618 * math.log(2.0) / (1.0 / 293.15 - 1.0 / 303.15)
    assert vr.Arrhenius(halving, reference=20.0).factor(30.0) == pytest.approx(0.5, rel=1e-12)
    table = vr.ShiftTable([0.0, 20.0, 40.0], [100.0, 1.0, 0.1])
    assert table.factor(10.0) == pytest.approx(10.0, rel=1e-14)
    assert table.factor(40.0) == pytest.approx(0.1, rel=1e-14)
    assert table.origin == pytest.approx(20.0)


@pytest.mark.parametrize("law", LAWS)
def test_small_motions_keep_their_shape_in_stretched_time(law):
    # all relaxation takes a times as long; with a^2 of the density, so does inertia: s(T) a = s(reference)
    a = SHIFT.factor(30.0)
    reference = cantilever(material(law)).modes(4).eigenvalues
    warm = cantilever(material(law, 30.0, density=1000.0 * a**2)).modes(4).eigenvalues
    assert a * warm == pytest.approx(reference, rel=1e-7)


@pytest.mark.parametrize("law", ["prony", "times"])
def test_a_large_motion_keeps_its_shape_in_stretched_time(law):
    a = SHIFT.factor(30.0)
    midpoint = {"integrator": "midpoint"} if law == "times" else {}
    reference = cantilever(material(law)).simulate(0.2, time_step=4e-3, **midpoint)
    slow = material(law, 30.0, density=1000.0 * a**2)
    warm = cantilever(slow).simulate(0.2 * a, time_step=4e-3 * a, **midpoint)
    one, other = (run.history("rod.end").values for run in (reference, warm))
    assert np.ptp(one[:, 2]) > 0.05
    assert other == pytest.approx(one, abs=1e-7)


def test_a_band_of_the_motion_is_no_data():
    # moduli nearest over the band of the motion: as of a series whose times were shifted by hand
    a = SHIFT.factor(30.0)

    def series(times):
        ratios = {"shear_ratios": [0.3, 0.5], "constant": "bulk_modulus"}
        return vr.Prony(**ratios, shear_times=times, law="kelvin_voigt", band=(2.0, 20.0))

    warm = vr.Material(1e6, 0.4, 1000.0, damping=series([0.002, 0.03]), temperature=30.0, shift=SHIFT)
    by_hand = vr.Material(1e6, 0.4, 1000.0, damping=series([0.002 * a, 0.03 * a]))
    for name in ("youngs_modulus", "shear_time", "bulk_time"):
        assert getattr(warm, name) == pytest.approx(getattr(by_hand, name), rel=1e-12)


def test_a_table_at_another_temperature_than_the_reference():
    lists = {"frequency": [1.0, 10.0], "storage": [1e6, 1.1e6], "loss": [5e4, 9e4]}
    given = vr.ComplexModuli(**lists, law="maxwell")
    a = SHIFT.factor(50.0, 30.0)
    assert a == pytest.approx(SHIFT.factor(50.0) / SHIFT.factor(30.0), rel=1e-13)
    warm = vr.Material(1e6, 0.4, 1000.0, damping=given, temperature=50.0, shift=SHIFT)
    assert warm.shift_factor == SHIFT.factor(50.0)
    fit = vr.kelvin_voigt_fit(warm, (1.0 / warm.shift_factor, 10.0 / warm.shift_factor))
    assert fit.time == pytest.approx(
        warm.shift_factor * vr.kelvin_voigt_fit(given_material(given)).time, rel=1e-12
    )


def given_material(damping):
    return vr.Material(1e6, 0.4, 1000.0, damping=damping)


def test_the_shift_is_told_and_written():
    warm = material("prony", 50.0)
    (told,) = (text for text in warm.assumptions if "degrees C" in text)
    assert f"{SHIFT.factor(50.0):.4g} times" in told
    assert vr.Material.model_validate(warm.to_dict()) == warm
    assert warm.with_damping(LAWS["times"]).shear_time == pytest.approx(0.002 * SHIFT.factor(50.0), rel=1e-14)
    low, high = material("loss factor", 50.0).loss_band
    assert (low, high) == pytest.approx((1.0 / warm.shift_factor, 100.0 / warm.shift_factor), rel=1e-14)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"temperature": 20.0, "damping": LAWS["times"]}, "shift: a temperature and a shift"),
        ({"shift": SHIFT, "damping": LAWS["times"]}, "temperature: a temperature and a shift"),
        ({"shift": SHIFT, "temperature": 20.0}, "nothing relaxes"),
        (
            {"shift": SHIFT, "temperature": -90.0, "damping": LAWS["times"]},
            r"temperature: -90\.0: .* ends at -81\.6",
        ),
        (
            {"shift": SHIFT, "temperature": 30.0, "damping": vr.MeasuredDamping(0.1)},
            "that at the temperature of the measurement",
        ),
        (
            {"shift": vr.ShiftTable([0, 20], [5, 1]), "temperature": 30.0, "damping": LAWS["times"]},
            "goes from 0 to 20 degrees C",
        ),
    ],
)
def test_refused(more, message):
    with pytest.raises(InputError, match=message):
        vr.Material(1e6, 0.4, 1000.0, **more)


@pytest.mark.parametrize(
    ("temperatures", "factors", "message"),
    [
        ([0.0, 20.0], [5.0, 1.0, 0.1], "factors: 3 numbers"),
        ([20.0, 0.0], [5.0, 1.0], "temperatures of a table increase"),
        ([0.0, 20.0], [1.0, 5.0], "faster the warmer"),
        ([0.0, 20.0], [5.0, 2.0], "factors that pass 1"),
        ([-300.0, 20.0], [5.0, 1.0], "below absolute zero"),
    ],
)
def test_tables_refused(temperatures, factors, message):
    with pytest.raises(InputError, match=message):
        vr.ShiftTable(temperatures, factors)


def stretched_bar(damping, cycles=2, **more):
    """A bar whose end goes to and fro, slow beside its own vibrations: it is strained uniformly."""
    given = vr.Material(1e7, 0.3, 1000.0, damping=damping, **more)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.1, 0, 0), section=vr.Circle(0.01), material=given, elements=1, order=2
    )
    model.add("bar", rod)
    model.clamp("bar.start")
    w = 2.0 * math.pi
    motion = vr.FunctionOfTime(
        lambda t: 5e-4 * (1.0 - math.cos(w * t)),
        lambda t: 5e-4 * w * math.sin(w * t),
        lambda t: 5e-4 * w * w * math.cos(w * t),
    )
    model.clamp("bar.end", {"ux": motion})
    return model.simulate(float(cycles), time_step=0.01, integrator="midpoint")


def test_heating_of_a_uniformly_strained_bar():
    # loss of a cycle per volume, pi E'' eps^2 with E'' = omega tau E and eps = 0.005: over rho c it is the rise
    run = stretched_bar(vr.KelvinVoigt(0.01, 0.01), specific_heat=1500.0)
    found = run.self_heating().rods[0]
    expected = math.pi * 2.0 * math.pi * 0.01 * 1e7 * 0.005**2 / (1000.0 * 1500.0)
    assert found.per_cycle == pytest.approx(expected, rel=5e-3)
    assert found.largest == pytest.approx(2.0 * expected, rel=5e-3)
    assert found.mean == pytest.approx(found.largest, rel=5e-3)
    assert found.cycle == pytest.approx(1.0, rel=1e-3)
    assert f"{quantity(found.largest, 'K', 3)} over the run" in flat(run.report())


def test_nothing_is_said_without_a_specific_heat():
    run = stretched_bar(vr.KelvinVoigt(0.01, 0.01), cycles=1)
    assert "Self-heating" not in run.report()
    with pytest.raises(InputError, match="no rod of this result has a material with a specific heat"):
        run.self_heating()


def test_heat_capacity_along_the_rod():
    given = vr.Material(1e6, 0.4, 1000.0, specific_heat=2000.0)
    taper = vr.Taper(start=vr.Rectangle(0.02, 0.01), end=vr.Rectangle(0.01, 0.01))
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=taper, material=given)
    assert rod.heat_capacity_at(0.5) == pytest.approx(1000.0 * 2000.0 * 0.015 * 0.01, rel=1e-12)
    other = vr.Material(1e6, 0.4, 500.0, specific_heat=1000.0)
    halves = [
        CompositeRegion(material=m, section=vr.Rectangle(0.01, 0.01), at=(x, 0.0))
        for m, x in ((given, 0.005), (other, -0.005))
    ]
    section = Composite(halves)
    assert section.heat_capacity(None) == pytest.approx(1e-4 * (2e6 + 5e5), rel=1e-6)

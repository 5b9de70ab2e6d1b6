"""Master curves of a Prony series whose times follow a known law: shifts, their intervals, laws, and the material."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.cli.app import app
from viscorod.model.materials.moduli_over_frequency import DmaTable, tidied

TIMES = 10.0 ** np.arange(-12.0, 7.0, 0.4)
TRUTH = vr.RelaxationModulus(
    3e6, tuple(1.2e8 * np.exp(-0.5 * ((np.log10(TIMES) + 1.0) / 2.5) ** 2)), tuple(TIMES)
)
C1, C2, REFERENCE = 12.0, 70.0, 60.0
CELSIUS = np.arange(40.0, 91.0, 7.0) - 1.0  # 60 is one of them
HERTZ = np.geomspace(0.1, 30.0, 8)


def law(celsius):
    return -C1 * (celsius - REFERENCE) / (C2 + celsius - REFERENCE)


def lift(celsius):
    return (celsius + 273.15) / (REFERENCE + 273.15)


def sweeps(seed, noise=0.005, lifted=True, temperatures=CELSIUS):
    """What an instrument measures of it at the temperatures."""
    rng = np.random.default_rng(seed)
    found = []
    for celsius in temperatures:
        omega = 2.0 * np.pi * HERTZ
        modulus = TRUTH.shifted(10.0 ** law(celsius)).complex_modulus(omega) * (
            lift(celsius) if lifted else 1.0
        )
        parts = [
            part * np.exp(noise * k * rng.normal(size=len(omega)))
            for k, part in ((1.0, modulus.real), (2.0, modulus.imag))
        ]
        found.append((float(celsius), DmaTable(omega, *parts)))
    return found


@pytest.fixture(scope="module")
def master():
    return vr.master_curve(sweeps(1), reference=60.0, title="rubber")


def test_shifts_are_found_within_their_intervals(master):
    width = master.data.log_shift_width.values
    off = np.abs(master.log_shifts - law(CELSIUS))
    assert off[width == 0.0] == pytest.approx([0.0], abs=1e-9)
    assert (off[width > 0.0] < 2.0 * width[width > 0.0]).all()
    assert width.max() < 0.3
    assert np.abs(master.lifts - lift(CELSIUS)).max() < 2.0 * master.data.lift_width.values.max()


def test_intervals_of_shifts_hold():
    """Of 6 data sets with 7 shifts each: 42 intervals; 95 % hold, within three binomial standard deviations."""
    inside = []
    for seed in range(6):
        found = vr.master_curve(sweeps(seed, lifted=False), reference=60.0, vertical=False)
        width = found.data.log_shift_width.values
        free = width > 0.0
        inside += list(np.abs(found.log_shifts - law(CELSIUS))[free] < width[free])
    assert len(inside) == 42
    assert np.mean(inside) > 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / 42)


def test_law_of_wlf_with_intervals(master):
    found = master.laws["wlf"]
    for value, low, high, truth in zip(found["values"], found["low"], found["high"], (C1, C2), strict=True):
        assert low < truth < high
        assert value == pytest.approx(truth, rel=0.1)
    assert master.law == "wlf"
    assert found["off"] < 0.03 < master.laws["arrhenius"]["off"]
    shift = vr.WLF(**{key: value for key, value in master.shift().items() if key != "kind"})
    assert shift.decades(75.0) == pytest.approx(law(75.0), abs=0.03)


def test_laws_do_not_depend_on_a_reference_in_the_glass():
    """Beside a glass no shift is known, beside each other those of the transition are: the law is that of the truth."""
    found = vr.master_curve(
        sweeps(3, lifted=False, temperatures=[19.0, 29.0, *CELSIUS]), reference=19.0, vertical=False
    )
    assert found.reference == 19.0
    assert found.data.log_shift_width.values[2:].min() > 3.0
    shift = found.shift("wlf")
    about = shift.pop("reference")
    assert about == 39.0
    assert any(f"referred to {about:.4g} C" in text for text in found.warnings)
    wlf = vr.WLF(reference=about, c1=shift["c1"], c2=shift["c2"])
    for celsius in (53.0, 81.0):
        assert wlf.decades(celsius) == pytest.approx(law(celsius) - law(about), abs=0.05)
    with pytest.warns(
        vr.AccuracyWarning, match="fitted from 39 to .* at 20 C it is carried on.*sweep at 19 C itself"
    ):
        found.material(20.0, density=1100.0, poissons_ratio=0.45)
    rubber = vr.Material(**found.material(67.0, density=1100.0, poissons_ratio=0.45))
    omega = 2.0 * np.pi * np.array([0.3, 3.0, 10.0])
    exact = TRUTH.shifted(10.0 ** law(67.0)).complex_modulus(omega)
    assert np.abs(rubber.relaxation("extension").complex_modulus(omega) / exact - 1.0).max() < 0.06


def test_below_a_glass_transition_no_law_is_bent_to_the_shifts():
    """Above 60 C the law is WLF's, below it shifts grow by a tenth of a decade per K: one law for both would be off."""
    rng = np.random.default_rng(5)
    tables = []
    celsius = np.arange(36.0, 91.0, 6.0)
    decades = np.where(celsius >= REFERENCE, law(celsius), (REFERENCE - celsius) * 0.06)
    for degrees, shift in zip(celsius, decades, strict=True):
        modulus = TRUTH.shifted(10.0**shift).complex_modulus(2.0 * np.pi * HERTZ)
        parts = [part * np.exp(0.004 * rng.normal(size=8)) for part in (modulus.real, modulus.imag)]
        tables.append((float(degrees), DmaTable(2.0 * np.pi * HERTZ, *parts)))
    found = vr.master_curve(tables, reference=72.0, vertical=False)
    assert np.abs(found.log_shifts - (decades - law(72.0))).max() < 0.05
    assert found.law == "wlf"
    wlf = vr.WLF(**{key: value for key, value in found.shift().items() if key != "kind"})
    assert wlf.decades(87.0) - wlf.decades(63.0) == pytest.approx(law(87.0) - law(63.0), abs=0.05)
    assert any("as in a glass: laws are fitted above" in text for text in found.warnings)
    omega = 2.0 * np.pi * HERTZ[1:-1]
    for degrees in (42.0, 51.0):
        rubber = vr.Material(**found.material(degrees, density=1100.0, poissons_ratio=0.45))
        exact = TRUTH.shifted(10.0 ** ((REFERENCE - degrees) * 0.06)).complex_modulus(omega)
        assert np.abs(rubber.relaxation("extension").complex_modulus(omega) / exact - 1.0).max() < 0.06


def test_laws_that_fit_alike_are_not_told_apart():
    """Over 12 K the law of WLF bends as little as that of Arrhenius, by which the shifts were made."""
    rng = np.random.default_rng(3)
    tables = []
    for celsius in (57.0, 60.0, 63.0, 66.0, 69.0):
        decades = 2e5 / 8.314462618 * (1.0 / (celsius + 273.15) - 1.0 / 333.15) / np.log(10.0)
        modulus = TRUTH.shifted(10.0**decades).complex_modulus(2.0 * np.pi * HERTZ)
        parts = [part * np.exp(0.01 * rng.normal(size=8)) for part in (modulus.real, modulus.imag)]
        tables.append((celsius, DmaTable(2.0 * np.pi * HERTZ, *parts)))
    assert "hardly told from the other" in vr.master_curve(tables, vertical=False).report()


def test_activation_energy():
    """Shifts of 150 kJ/mol, whose law is a straight line over the inverse temperature."""
    energy = 1.5e5
    tables = []
    for celsius in CELSIUS:
        decades = energy / 8.314462618 * (1.0 / (celsius + 273.15) - 1.0 / 333.15) / np.log(10.0)
        modulus = TRUTH.shifted(10.0**decades).complex_modulus(2.0 * np.pi * HERTZ)
        tables.append((celsius, DmaTable(2.0 * np.pi * HERTZ, modulus.real, modulus.imag)))
    found = vr.master_curve(tables, reference=60.0, vertical=False)
    (value,) = found.laws["arrhenius"]["values"]
    assert value == pytest.approx(energy, rel=0.01)
    assert found.laws["arrhenius"]["off"] < 0.02


def test_material_has_the_moduli_of_its_temperature(master):
    """Maxwell branches through the curve, shifted to a temperature between two sweeps."""
    for celsius in (50.0, 71.0):
        rubber = vr.Material(**master.material(celsius, density=1100.0, poissons_ratio=0.45))
        omega = 2.0 * np.pi * np.array([0.3, 3.0, 10.0])
        exact = lift(celsius) * TRUTH.shifted(10.0 ** law(celsius)).complex_modulus(omega)
        assert np.abs(rubber.relaxation("extension").complex_modulus(omega) / exact - 1.0).max() < 0.06


def test_files_command_and_picture(master, tmp_path):
    from typer.testing import CliRunner

    rows = [
        f"{hertz},{storage * 1e-6},{loss * 1e-6},{celsius}"
        for celsius, one in sweeps(2)
        for hertz, storage, loss in zip(HERTZ, one.storage, one.loss, strict=True)
    ]
    file = tmp_path / "sweeps.csv"
    file.write_text("f (Hz),E' (MPa),E'' (MPa),T (C)\n" + "\n".join(rows) + "\n")
    out = tmp_path / "out"
    told = CliRunner().invoke(app, ["damping", "master", str(file), "--reference", "60", "-o", str(out)])
    assert told.exit_code == 0, told.output
    assert 'kind = "wlf"' in told.output
    again = vr.load(out / "master.nc")
    assert again.report() in told.output
    assert (out / "master.png").stat().st_size > 20_000
    table = vr.ModulusTable(file=str(out / "master.csv")).table
    assert len(table.omega) == again.data.sizes["curve"]
    part = vr.load(master.save(tmp_path / "again.nc"))
    assert part.report() == master.report()


def test_what_cannot_be_laid_over_each_other_is_told():
    two = sweeps(3)[:2]
    with pytest.raises(vr.InputError, match="needs three sweeps of three frequencies"):
        vr.master_curve(two)
    with pytest.raises(vr.InputError, match="two sweeps have the same temperature"):
        vr.master_curve([*sweeps(3), sweeps(3)[0]])
    with pytest.raises(vr.InputError, match="no sweep is near it"):
        vr.master_curve(sweeps(3), reference=300.0)
    far = [one for one in sweeps(3) if one[0] not in (46.0, 53.0, 60.0)]
    assert any("no level in common" in text for text in vr.master_curve(far).warnings)


def test_the_instruments_resonance_is_left_out():
    """A loss modulus that stands up at the highest frequency of every sweep, as the instrument's inertia makes it."""
    off = []
    for celsius, one in sweeps(1):
        loss = one.loss.copy()
        loss[-1] *= 1.5
        off.append((celsius, tidied(one.omega, one.storage, loss)))
    found = vr.master_curve(off, reference=60.0)
    assert any(
        "30 Hz is off what its neighbours lead to expect in 8 of 8 sweeps" in text for text in found.warnings
    )
    assert found.data.sizes["point"] == 8 * 7
    width = found.data.log_shift_width.values
    assert (np.abs(found.log_shifts - law(CELSIUS))[width > 0.0] < 2.0 * width[width > 0.0]).all()


def test_sweeps_far_apart():
    """Steps of 14 K leave gaps at the cold end: those shifts are told to be a guess, the others are right."""
    apart = [one for one in sweeps(5, lifted=False) if round(one[0] - 39.0) % 14 == 7]
    cold = 25.0
    modulus = TRUTH.shifted(10.0 ** law(cold)).complex_modulus(2.0 * np.pi * HERTZ)
    apart = [(cold, DmaTable(2.0 * np.pi * HERTZ, modulus.real, modulus.imag)), *apart]
    found = vr.master_curve(apart, reference=60.0, vertical=False)
    assert any("the moduli at 25" in text and "no level in common" in text for text in found.warnings)
    assert found.log_shifts[2:] == pytest.approx(law(np.array([60.0, 74.0, 88.0])), abs=0.3)

"""Materials from tables of complex moduli, and from loss factors."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from viscorod.analyses.model import Model
from viscorod.casefile.case import case_from_dict, load_case
from viscorod.errors import InputError
from viscorod.model.materials.complex_moduli import ComplexModuli, ModulusTable
from viscorod.model.materials.kelvin_voigt import KelvinVoigt
from viscorod.model.materials.loss_factor import LossFactor
from viscorod.model.materials.material import Material
from viscorod.model.materials.nearest_kelvin_voigt import errors
from viscorod.model.materials.prony import Prony
from viscorod.model.materials.relaxation_modulus import RelaxationModulus
from viscorod.model.rod import Rod
from viscorod.model.sections.section_shapes import Rectangle

HERTZ = np.geomspace(0.01, 100.0, 41)
OMEGA = 2.0 * np.pi * HERTZ


def table(modulus, frequency=HERTZ) -> dict:
    return {"frequency": frequency, "storage": modulus.real, "loss": modulus.imag}


def kelvin_voigt(E: float, tau: float) -> np.ndarray:
    return E * (1.0 + 1j * OMEGA * tau)


RELAXATION = RelaxationModulus(1e6, (5e5, 3e5), (0.2, 0.01))


@given(st.floats(-0.9, 0.49), st.floats(1e-6, 1.0), st.just(0.0) | st.floats(1e-30, 1.0))
def test_time_in_extension_in_place_of_bulk(nu, shear, bulk):
    known = Material(1e6, nu, 1.0, damping=KelvinVoigt(shear, bulk))
    same = Material(
        1e6, nu, 1.0, damping=KelvinVoigt(shear_time=shear, extensional_time=known.extensional_time)
    )
    assert same.extensional_time == pytest.approx(known.extensional_time, rel=1e-12)
    assert same.bulk_time == pytest.approx(bulk, rel=1e-9, abs=1e-13 / (1.0 - 2.0 * nu))


def test_time_in_extension_of_an_incompressible_material():
    m = Material(1e6, 0.5, 1.0, damping=KelvinVoigt(shear_time=0.1, extensional_time=0.1))
    assert (m.shear_time, m.extensional_time) == pytest.approx((0.1, 0.1), rel=1e-15)
    with pytest.raises(InputError, match=r"damping.extensional_time: .*give 0\.1 s for both"):
        Material(1e6, 0.5, 1.0, damping=KelvinVoigt(shear_time=0.1, extensional_time=0.2))


def test_time_in_extension_that_means_a_negative_bulk_viscosity():
    # 2(1+nu)/3 = 0.8 for nu = 0.2
    with pytest.raises(InputError, match=r"at least 0\.08 s in extension.* at most 0\.0875 s in shear"):
        Material(1e6, 0.2, 1.0, damping=KelvinVoigt(shear_time=0.1, extensional_time=0.07))
    at_the_limit = Material(1e6, 0.2, 1.0, damping=KelvinVoigt(shear_time=0.1, extensional_time=0.08))
    assert at_the_limit.bulk_time == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("strain", ["extension", "shear"])
def test_one_loss_factor(strain):
    m = Material(1e6, 0.3, 1.0, damping=LossFactor(5.0, **{strain: 0.1}))
    # eta''/E' = omega tau at 5 Hz
    for time in (m.extensional_time, m.shear_time, m.bulk_time):
        assert 2.0 * math.pi * 5.0 * time == pytest.approx(0.1, rel=1e-14)
    assert any("taken equal" in text for text in m.assumptions)


def test_two_loss_factors():
    m = Material(1e6, 0.3, 1.0, damping=LossFactor(5.0, extension=0.1, shear=0.08))
    assert 2.0 * math.pi * 5.0 * m.extensional_time == pytest.approx(0.1, rel=1e-12)
    assert 2.0 * math.pi * 5.0 * m.shear_time == pytest.approx(0.08, rel=1e-12)
    assert m.bulk_time > 0.0
    with pytest.raises(InputError, match=r"damping.extension: 0\.05 in extension: .*negative bulk viscosity"):
        Material(1e6, 0.3, 1.0, damping=LossFactor(5.0, extension=0.05, shear=0.1))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"frequency": 1.0}, "give extension or shear"),
        ({"extension": 0.1}, "frequency"),
        ({"frequency": 0.0, "extension": 0.1}, "frequency: 0.0"),
        ({"frequency": 1.0, "extension": -0.1}, "extension: -0.1"),
        ({"frequency": 1.0, "tan_delta": 0.1}, "no such key"),
    ],
)
def test_loss_factor_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        LossFactor(**arguments)


@pytest.mark.parametrize("fit", [None, "best", "low_frequency"])
@pytest.mark.parametrize("of", ["extension", "shear"])
def test_a_kelvin_voigt_material_is_found_again(fit, of):
    damping = ComplexModuli(**table(kelvin_voigt(2e6, 1e-3)), of=of, fit=fit)
    m = Material(poissons_ratio=0.25, density=1.0, damping=damping)
    assert (m.youngs_modulus if of == "extension" else m.shear_modulus) == pytest.approx(2e6, rel=1e-12)
    assert (m.shear_time, m.bulk_time, m.extensional_time) == pytest.approx((1e-3,) * 3, rel=1e-12)
    assert m.poissons_ratio == 0.25
    assert "youngs_modulus" not in m.to_dict()


def test_best_fit_is_the_least_relative_error_over_the_logarithm():
    modulus = RELAXATION.complex_modulus(OMEGA)
    m = Material(poissons_ratio=0.3, density=1.0, damping=ComplexModuli(**table(modulus), band=(0.1, 10.0)))
    inside = (HERTZ > 0.0999) & (HERTZ < 10.001)

    def misfit(x):
        square = np.abs((modulus - 1e6 * x[0] - 1j * OMEGA * 1e5 * x[1])[inside] / modulus[inside]) ** 2
        return np.trapezoid(square, np.log(OMEGA[inside]))

    found = minimize(misfit, [1.0, 1.0], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-16})
    assert m.youngs_modulus == pytest.approx(1e6 * found.x[0], rel=1e-6)
    assert m.extensional_viscosity == pytest.approx(1e5 * found.x[1], rel=1e-6)
    assert any("from 0.1 to 10 Hz" in text for text in m.assumptions)


def test_low_frequency_fit_tends_to_the_limit():
    hertz = np.geomspace(1e-4, 100.0, 61)
    modulus = RELAXATION.complex_modulus(2.0 * np.pi * hertz)
    damping = ComplexModuli(**table(modulus, hertz), fit="low_frequency")
    m = Material(poissons_ratio=0.3, density=1.0, damping=damping)
    # the error is of the order (omega tau)^2
    assert m.youngs_modulus == pytest.approx(RELAXATION.equilibrium, rel=1e-6)
    assert m.extensional_viscosity == pytest.approx(RELAXATION.viscosity, rel=1e-6)


def test_given_moduli_are_kept():
    damping = ComplexModuli(**table(kelvin_voigt(2e6, 1e-3)))
    m = Material(1e6, 0.3, 1.0, damping=damping)
    assert m.youngs_modulus == 1e6
    assert m.extensional_time == pytest.approx(1e-3, rel=1e-12)
    assert any("kept as given" in text and "+1e+02 %" in text for text in m.assumptions)


def test_two_tables():
    other = ModulusTable(**table(kelvin_voigt(0.8e6, 0.8e-3)))
    damping = ComplexModuli(**table(kelvin_voigt(2e6, 1e-3)), other=other)
    m = Material(density=1.0, damping=damping)
    assert m.poissons_ratio == pytest.approx(0.25, rel=1e-12)
    assert (m.youngs_modulus, m.shear_modulus) == pytest.approx((2e6, 0.8e6), rel=1e-12)
    assert (m.extensional_time, m.shear_time) == pytest.approx((1e-3, 0.8e-3), rel=1e-12)
    exchanged = ComplexModuli(
        **table(kelvin_voigt(0.8e6, 0.8e-3)), of="shear", other=table(kelvin_voigt(2e6, 1e-3))
    )
    same = Material(density=1.0, damping=exchanged)
    assert same.bulk_time == pytest.approx(m.bulk_time, rel=1e-12)


#: relaxation times that a fit of a table over OMEGA with three branches per decade tries: 16 from half a decade below
#: the inverse of the highest frequency to half a decade above that of the lowest
TIMES = np.geomspace(1.0 / (10.0**0.5 * OMEGA[-1]), 10.0**0.5 / OMEGA[0], 16)


def branches(m: Material, strain: str) -> RelaxationModulus:
    moduli = tuple(getattr(branch, strain) for branch in m.branches)
    return RelaxationModulus(getattr(m, strain), moduli, tuple(branch.time for branch in m.branches))


def test_maxwell_branches_are_found_again():
    known = RelaxationModulus(1e6, (5e5, 3e5), (TIMES[5], TIMES[11]))
    damping = ComplexModuli(**table(known.complex_modulus(OMEGA)), law="maxwell", per_decade=3)
    m = Material(poissons_ratio=0.3, density=1.0, damping=damping)
    found = branches(m, "youngs_modulus")
    assert found.equilibrium == pytest.approx(1e6, rel=1e-9)
    assert found.times == pytest.approx((TIMES[5], TIMES[11]), rel=1e-12)
    assert found.moduli == pytest.approx((5e5, 3e5), rel=1e-9)
    assert branches(m, "shear_modulus").moduli == pytest.approx((5e5 / 2.6, 3e5 / 2.6), rel=1e-9)
    assert any("Maxwell branches in extension" in text for text in m.assumptions)


@pytest.mark.parametrize("per_decade", [1, None, 5])
def test_maxwell_branches_follow_other_times(per_decade):
    # a table whose times are none of those tried: the errors fall with the distance of the times; the loss factor is
    # 0.0065 where it is least, and fitted beside the whole modulus the loss was wrong by 0.55, 0.28 and 0.033
    modulus = RELAXATION.complex_modulus(OMEGA)
    damping = ComplexModuli(**table(modulus), law="maxwell", per_decade=per_decade)
    m = Material(poissons_ratio=0.3, density=1.0, damping=damping)
    storage, loss = errors(modulus, branches(m, "youngs_modulus").complex_modulus(OMEGA))
    largest = {1: (0.08, 0.4), None: (0.025, 0.16), 5: (0.005, 0.025)}[per_decade]
    assert np.abs(storage).max() < largest[0]
    assert np.abs(loss).max() < largest[1]


def flat(loss_factor: float, decades: float):
    """Frequencies, and the moduli of a causal law whose loss factor hardly depends on them (many short times apart)."""
    hertz = np.geomspace(0.1, 0.1 * 10.0**decades, 8 * round(decades) + 1)
    times = np.geomspace(10.0 / hertz[0], 0.1 / hertz[-1], 4 * round(decades + 2))
    share = 2.0 / np.pi * loss_factor * np.log(times[0] / times[1])
    law = RelaxationModulus(1e9, tuple(share * 1e9 for _ in times), tuple(times))
    return hertz, law.complex_modulus(2.0 * np.pi * hertz)


def test_the_loss_of_a_glass_is_not_given_up_for_its_storage():
    """Storage that falls by 3 % along a sweep, as that of a sample that warms: a third of the loss went with it."""
    hertz, modulus = flat(0.02, 3.0)
    drifting = modulus.real * np.linspace(1.0, 0.97, len(hertz)) + 1j * modulus.imag
    damping = ComplexModuli(**table(drifting, hertz), law="maxwell")
    m = Material(poissons_ratio=0.3, density=1.0, damping=damping)
    storage, loss = errors(modulus, branches(m, "youngs_modulus").complex_modulus(2.0 * np.pi * hertz))
    assert np.abs(loss).max() < 0.06
    assert np.abs(storage).max() < 0.04


def test_moduli_that_contradict_each_other_are_told():
    """A flat loss factor of 0.05 means 7 % more storage per decade (Kramers and Kronig), and the table has none."""
    hertz, modulus = flat(0.05, 8.0)
    level = np.full(len(hertz), 2e9) * (1.0 + 0.05j)
    doubts = {
        name: Material(
            poissons_ratio=0.3, density=1.0, damping=ComplexModuli(**table(given, hertz), law="maxwell", **more)
        ).doubts
        for name, given, more in (
            ("level", level, {}), ("causal", modulus, {}), ("a decade", level, {"band": (10.0, 100.0)}),
        )
    }  # fmt: skip
    assert not doubts["causal"]
    assert not doubts["a decade"]
    assert any("no Maxwell branches follow the table of extension" in one for one in doubts["level"])


def test_maxwell_branches_beside_a_given_modulus():
    # a table that ends far above equilibrium: the given modulus is kept, and the same branches are found
    known = RelaxationModulus(1e6, (5e5, 3e5), (TIMES[5], TIMES[9]))
    keep = HERTZ > 0.3
    hertz = np.concatenate([HERTZ[:1], HERTZ[keep]])
    modulus = known.complex_modulus(2.0 * np.pi * hertz)
    damping = ComplexModuli(**table(modulus, hertz), law="maxwell", per_decade=3)
    m = Material(1e6, 0.3, 1.0, damping=damping)
    assert m.youngs_modulus == 1e6
    assert branches(m, "youngs_modulus").moduli == pytest.approx(known.moduli, rel=1e-9)


def test_maxwell_of_a_fluid_needs_a_modulus():
    modulus = 1e6 * 1j * OMEGA / (1.0 + 1j * OMEGA)
    damping = ComplexModuli(**table(modulus), law="maxwell")
    with pytest.raises(InputError, match=r"still falls.*give youngs_modulus"):
        Material(poissons_ratio=0.3, density=1.0, damping=damping)


def test_maxwell_of_two_tables():
    shear = RelaxationModulus(4e5, (2e5,), (TIMES[6],))
    extension = RelaxationModulus(1e6, (1e5, 4e5), (TIMES[4], TIMES[7]))
    damping = ComplexModuli(
        **table(extension.complex_modulus(OMEGA)),
        other=table(shear.complex_modulus(OMEGA)),
        law="maxwell",
        per_decade=3,
    )
    m = Material(density=1.0, damping=damping)
    assert (m.shear_modulus, m.poissons_ratio) == pytest.approx((4e5, 0.25), rel=1e-9)
    assert branches(m, "youngs_modulus").moduli == pytest.approx(extension.moduli, rel=1e-9)
    assert branches(m, "shear_modulus").moduli == pytest.approx(shear.moduli, rel=1e-9)
    assert m.extensional_viscosity == pytest.approx(extension.viscosity, rel=1e-9)
    assert m.shear_viscosity == pytest.approx(shear.viscosity, rel=1e-9)


def test_tan_delta_in_place_of_loss():
    modulus = kelvin_voigt(2e6, 1e-3)
    given = {"frequency": HERTZ, "storage": modulus.real}
    one = ComplexModuli(**given, tan_delta=modulus.imag / modulus.real)
    np.testing.assert_allclose(one.table.loss, modulus.imag, rtol=1e-15)


def test_rows_in_any_order():
    modulus = kelvin_voigt(2e6, 1e-3)
    rows = np.random.default_rng(1).permutation(len(HERTZ))
    one = ComplexModuli(**table(modulus[rows], HERTZ[rows]))
    np.testing.assert_allclose(one.table.storage, modulus.real, rtol=1e-15)


CASE = """
[materials.polymer]
poissons_ratio = 0.4
density = 1200.0
damping = { kind = "complex_moduli", file = "dma.csv", law = "maxwell" }

[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
section = { shape = "circle", radius = 0.01 }
material = "polymer"

[equilibrium]
"""


def test_files_are_found_from_the_case_file_on(tmp_path):
    folder = tmp_path / "cases"
    folder.mkdir()
    (folder / "case.toml").write_text(CASE)
    modulus = RELAXATION.complex_modulus(OMEGA)
    rows = "\n".join(f"{f},{m.real},{m.imag}" for f, m in zip(HERTZ, modulus, strict=True))
    (folder / "dma.csv").write_text(f"Frequency (Hz),E' (Pa),E'' (Pa)\n{rows}\n")
    case = load_case(folder / "case.toml")
    material = case.description.rods["beam"].material
    assert material.youngs_modulus == pytest.approx(1e6, rel=0.02)
    assert material.branches
    again = case_from_dict(case.to_dict())
    assert again.description.rods["beam"].material == material
    (folder / "dma.csv").unlink()
    with pytest.raises(
        InputError, match=r"materials.polymer.damping.file: .*dma.csv': there is no such file"
    ):
        load_case(folder / "case.toml")


GOOD = {"frequency": [1.0, 2.0], "storage": [1e6, 1e6], "loss": [1e4, 2e4]}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "lists or from a file"),
        (GOOD | {"file": "x.csv"}, "lists or from a file"),
        (GOOD | {"loss": None}, "loss .Pa. and tan_delta"),
        (GOOD | {"tan_delta": [0.1, 0.1]}, "loss .Pa. and tan_delta"),
        (GOOD | {"frequency": None}, "three columns"),
        (GOOD | {"loss": [1.0]}, "loss: 1 numbers: .*give 2"),
        (GOOD | {"loss": [1.0, -1.0]}, r"loss\[1\]: -1\.0"),
        (GOOD | {"storage": [0.0, 1.0]}, r"storage\[0\]: 0\.0"),
        (GOOD | {"frequency": [1.0, 1.0]}, "has 1 row there; 2 at least are needed"),
        (GOOD | {"frequency": [1.0, 1.0], "storage": [1e6, 2e6]}, "one frequency has different storage"),
        (GOOD | {"temperature": 20.0}, "temperature: 20.0: lists are one sweep; leave it out"),
        (GOOD | {"frequency": [1.0] * 100_001}, "100000 rows at most"),
        (GOOD | {"modulus_unit": "MPa"}, "lists are in Hz and Pa"),
        (GOOD | {"frequency_unit": "1/s"}, "give one of 'Hz', 'kHz', 'rad/s'"),
        (GOOD | {"of": "bending"}, "give one of 'extension', 'shear'"),
        (GOOD | {"band": [2.0, 1.0]}, "from a lower to a higher"),
        (GOOD | {"band": [1.0]}, "2 numbers are needed"),
        (GOOD | {"band": [10.0, 20.0]}, "band: .*0 rows there; 2 at least are needed; .* from 1 to 2 Hz"),
        (GOOD | {"band": [1.0, 2.0], "fit": "low_frequency"}, "band: .*lowest rows; leave it out"),
        (GOOD | {"fit": "low_frequency", "law": "maxwell"}, "fit: .*leave it out"),
        (GOOD | {"per_decade": 2}, "no branches; leave it out"),
        (GOOD | {"per_decade": 6, "law": "maxwell"}, "from 1 to 5"),
        (GOOD | {"fit": "worst"}, "give one of 'best', 'low_frequency'"),
        (GOOD | {"law": "zener"}, "give one of 'kelvin_voigt', 'maxwell'"),
        (GOOD | {"other": {"frequency": [1.0]}}, "other: .*three columns"),
        ({"file": 3}, "text is needed"),
        ({"file": "absent.csv"}, "file: 'absent.csv': there is no such file"),
    ],
)  # fmt: skip
def test_refused(arguments, message):
    with pytest.raises(InputError, match=message) as caught:
        ComplexModuli(**arguments)
    assert all(problem.instead for problem in caught.value.problems)


def test_a_table_of_shear_is_not_one_of_extension(tmp_path):
    (tmp_path / "dma.csv").write_text("f (Hz);G' (Pa);G'' (Pa)\n1;2;1\n2;3;1\n")
    with pytest.raises(InputError, match="the columns of the file are those of shear; give of = 'shear'"):
        ComplexModuli(file=str(tmp_path / "dma.csv"))


@pytest.mark.parametrize(
    ("constants", "two", "message"),
    [
        ({}, False, "one table does not determine Poisson's ratio; give poissons_ratio"),
        ({"poissons_ratio": 0.3}, True, "leave poissons_ratio out"),
        ({"shear_modulus": 1e6}, False, "shear_modulus: .*give poissons_ratio in its place"),
        ({"youngs_modulus": 1e6}, False, "exactly one of"),
    ],
)
def test_refused_with_the_material(constants, two, message):
    damping = GOOD | ({"other": GOOD} if two else {})
    with pytest.raises(InputError, match=message):
        Material(**constants, density=1.0, damping=ComplexModuli(**damping))


def test_tables_that_contradict_each_other():
    other = GOOD | {"storage": [3e5, 3e5]}
    with pytest.raises(InputError, match=r"a Poisson's ratio of 0\.6667, outside"):
        Material(density=1.0, damping=ComplexModuli(**GOOD, other=other))


def test_young_is_required_with_all_other_kinds():
    with pytest.raises(
        InputError, match="youngs_modulus: this key is required and missing; add youngs_modulus"
    ):
        Material(poissons_ratio=0.3, density=1.0, damping=LossFactor(1.0, 0.1))


def test_a_sweep_finds_the_file_too(tmp_path):
    import viscorod as vr

    held = """
[[supports]]
kind = "clamp"
at = "beam.start"

[[loads]]
kind = "force"
at = "beam.end"
value = [0.0, 1.0, 0.0]
"""
    (tmp_path / "case.toml").write_text(CASE + held)
    (tmp_path / "dma.csv").write_text(
        "frequency (Hz),E' (Pa),tan delta\n0.1,1e8,0.1\n1,1.1e8,0.1\n10,1.2e8,0.1\n"
    )
    members = vr.sweep(
        tmp_path / "case.toml", {"materials.polymer.poissons_ratio": [0.3, 0.4]}, workers=1
    ).members
    # the modulus comes from the table, whatever Poisson's ratio is: both sag alike but for shear
    sag = [member.result.displacement("beam.end")[1] for member in members]
    assert sag[0] == pytest.approx(sag[1], rel=1e-3)


FAR_OFF = RELAXATION.complex_modulus(OMEGA)


@pytest.mark.parametrize(
    ("damping", "doubted"),
    [
        (ComplexModuli(**table(FAR_OFF)), True),
        (ComplexModuli(**table(FAR_OFF), law="maxwell"), False),
        (ComplexModuli(**table(FAR_OFF), fit="low_frequency"), False),
        (ComplexModuli(**table(kelvin_voigt(1e6, 1e-4))), False),
        (
            Prony(
                extension_moduli=(5e5, 3e5),
                extension_times=(0.2, 0.01),
                law="kelvin_voigt",
                band=(0.01, 100.0),
            ),
            True,
        ),
        (Prony(extension_moduli=(5e5, 3e5), extension_times=(0.2, 0.01), law="maxwell"), False),
    ],
)
def test_every_result_tells_that_one_time_does_not_follow_the_data(damping, doubted):
    """Values: the errors of the material that results, over the band, against the series that made the table."""
    given = {"youngs_modulus": 1e6} if isinstance(damping, Prony) else {}
    material = Material(**given, poissons_ratio=0.3, density=1000.0, damping=damping)
    model = Model()
    model.add("strip", Rod.straight((0, 0, 0), (0.2, 0, 0), section=Rectangle(0.01, 0.01), material=material))
    model.clamp("strip.start")
    told = [text for text in model.modes(1).warnings if "one Kelvin-Voigt time" in text]
    assert told == [text for text in model.simulate(0.01).warnings if "one Kelvin-Voigt time" in text]
    assert told == [text for text in model.check().warnings if "one Kelvin-Voigt time" in text]
    if not doubted:
        assert not told
        return
    fit = material.youngs_modulus + 1j * OMEGA * material.extensional_viscosity
    wrong = 100.0 * np.abs(fit.imag / FAR_OFF.imag - 1.0).max()
    (found,) = (float(n) for text in told for n in re.findall(r"the loss modulus by ([\d.]+) %", text))
    assert found == pytest.approx(wrong, rel=0.05)  # two digits

"""Numbers of rods from records: synthetic truth, what cannot be told, several cases at once, the file and the page."""

import re

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.errors import InputError

YOUNG, SHEAR, BULK = (
    "materials.rubber.youngs_modulus",
    "materials.rubber.damping.shear_time",
    "materials.rubber.damping.bulk_time",
)
DENSITY = "materials.rubber.density"
BOTH = f"{SHEAR}, {BULK}"
TRUE = {
    "youngs_modulus": 1e6,
    "poissons_ratio": 0.3,
    "density": 1000.0,
    "damping": {"shear_time": 0.02, "bulk_time": 0.02},
}


def content(analysis, load=0.02, **material):
    return {
        "title": "strip",
        "materials": {"rubber": {**TRUE, **material}},
        "rods": {
            "beam": {
                "shape": "straight",
                "start": [0.0, 0.0, 0.0],
                "end": [0.3, 0.0, 0.0],
                "section": {"shape": "rectangle", "width": 0.01, "height": 0.01},
                "material": "rubber",
                "elements": 1,
                "order": 5,
            }
        },
        "supports": [{"kind": "clamp", "at": "beam.start"}],
        "loads": [{"kind": "force", "at": "beam.end", "value": [0.0, load, 0.0], "until": 0.0}],
        **analysis,
    }


def swing(load=0.02, **material):
    return case_from_dict(content({"simulate": {"duration": 1.0, "tolerance": 1e-5}}, load, **material))


def history(case, name="tip", size=2e-3, seed=0, release=None, **more):
    times = np.linspace(0.0, 1.0, 100)
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y", "name": name}
    clock = vr.Record(times, np.zeros(100), **about, unknown=["release_time"])
    clean = clock.predicted(run_case(case), {f"{name}.release_time": release or 0.0})
    return vr.Record(times, clean + size * np.random.default_rng(seed).normal(size=100), **about, **more)


@pytest.fixture(scope="module")
def two_times():
    """The swing with both times unknown: bending tells one combination of them."""
    return vr.identify(swing(youngs_modulus=1.2e6), history(swing()), {YOUNG: None, SHEAR: 0.03, BULK: 0.03})


def test_shear_and_bulk_time_cannot_be_separated_and_the_extensional_time_can(two_times):
    assert two_times[YOUNG].low <= 1e6 <= two_times[YOUNG].high
    assert two_times[YOUNG].told
    for key in (SHEAR, BULK):
        assert (two_times[key].low, two_times[key].high) == (0.0, np.inf)
    tau = two_times.combinations["extensional time of beam"]
    exact = swing().description.rods["beam"].material.extensional_time
    assert tau.low <= exact <= tau.high
    assert tau.high - tau.low < 0.15 * exact
    (sentence,) = [text for text in two_times.sentences if "cannot be separated" in text]
    assert re.search(r"extensional time of beam can: 0\.0\d+ \+- 0\.00\d+ s", sentence)


def test_a_fit_comes_back_from_its_file_with_its_case(two_times, tmp_path):
    found = vr.load(two_times.save(tmp_path / "fit.nc"))
    assert isinstance(found, vr.Identification)
    assert found.report() == two_times.report()
    assert found.numbers == two_times.numbers
    material = found.case.description.rods["beam"].material
    assert material.youngs_modulus == found[YOUNG].value
    predicted = history(found.case, size=0.0).observed
    np.testing.assert_allclose(predicted, found.data["predicted"].values, atol=1e-9)


def test_the_page_is_one_file_that_needs_no_network(two_times, tmp_path):
    text = two_times.page(tmp_path / "fit.html").read_text(encoding="utf-8")
    assert text.count("<svg") == 4
    assert not re.search(r"(src|href)=\"https?:", text.replace("http://www.w3.org", ""))
    for words in ("not told", "infinite", "extensional time of beam", "youngs_modulus = "):
        assert words in text


def test_one_time_to_the_bound_of_cramer_and_rao_and_in_other_programs_numbers():
    """With white noise of known size the covariance is sigma^2 (J^T J)^-1, here by differences of its own."""
    record = history(swing(), size=1e-3, seed=4)
    fit = vr.identify(swing(), record, {YOUNG: None, BOTH: 0.015})
    columns = []
    for change in (
        {"youngs_modulus": 1e6 * np.exp(1e-3)},
        {"damping": {"shear_time": 0.02 * np.exp(1e-3), "bulk_time": 0.02 * np.exp(1e-3)}},
    ):
        columns.append(
            (history(swing(**change), size=0.0).observed - history(swing(), size=0.0).observed) / 1e-3
        )
    bound = 1e-3 * np.sqrt(np.diag(np.linalg.inv(np.stack(columns) @ np.stack(columns).T)))
    numbers = fit.parameters.values()
    relative = [one.standard_error / one.value for one in numbers]
    size = np.sqrt(np.sum(fit.residuals**2) / (100 - 2)) / 1e-3  # the noise of this very record
    np.testing.assert_allclose(relative, size * bound, rtol=0.03)
    assert [one.low <= true <= one.high for one, true in zip(numbers, (1e6, 0.02), strict=True)] == [
        True,
        True,
    ]
    mujoco = next(one for name, one in fit.in_programs.items() if name.startswith("MuJoCo"))
    stiffness = 1e6 * 0.01**4 / 12.0 / (0.3 / 20)  # E I over the length of a segment, times the time
    assert mujoco.value == pytest.approx(stiffness * fit[YOUNG].value / 1e6 * fit[BOTH].value, rel=1e-3)
    assert mujoco.low < mujoco.value < mujoco.high


def test_two_loads_at_once_with_a_release_time_of_their_own():
    records = []
    for name, load, release in (("light", 0.01, 0.03), ("heavy", 0.03, 0.05)):
        unknown = [vr.Unknown("release_time", 0.02, low=0.0, high=0.1)]
        record = history(swing(load), name, 1e-3, 5, release, unknown=unknown)
        records.append((swing(load, youngs_modulus=1.03e6), record))
    fit = vr.identify(records, parameters={YOUNG: None, BOTH: 0.018}, profile=False)
    for name, true in (
        (YOUNG, 1e6),
        (BOTH, 0.02),
        ("light.release_time", 0.03),
        ("heavy.release_time", 0.05),
    ):
        one = fit[name]
        assert abs(one.value - true) < 4.0 * one.standard_error
        assert one.told
    assert list(fit.nuisances) == ["light.release_time", "heavy.release_time"]
    assert len(fit.cases) == 2


def modes_case(**material):
    return case_from_dict(content({"modes": {"count": 6, "about": "reference"}}, **material))


def test_frequencies_tell_stiffness_over_mass_and_ratios_tell_the_time():
    """Frequencies go with the root of E/rho: its factors cannot be told, their ratio can; zeta = omega tau/2."""
    true = run_case(modes_case())
    rng = np.random.default_rng(1)
    hertz, ratios = true.frequencies[:6], true.damping_ratios[:6]
    record = vr.ModesRecord(
        hertz * (1.0 + 1e-3 * rng.normal(size=6)), ratios * (1.0 + 1e-2 * rng.normal(size=6))
    )
    fit = vr.identify(
        modes_case(youngs_modulus=1.5e6), record, {YOUNG: None, DENSITY: 1200.0, BOTH: 0.01}, profile=False
    )
    assert not fit[YOUNG].told
    assert not fit[DENSITY].told
    assert fit[BOTH].low < 0.02 < fit[BOTH].high
    sound = fit.combinations["speed of sound in beam"]
    assert sound.low < np.sqrt(1e6 / 1000.0) < sound.high
    assert sound.high - sound.low < 0.01 * sound.value
    assert fit[BOTH].high - fit[BOTH].low < 0.1 * fit[BOTH].value


def test_static_loads_give_the_stiffness():
    def static(**material):
        return case_from_dict(content({"equilibrium": {"load_steps": 5}}, **material))

    loads = np.linspace(0.2, 1.0, 5)
    about = {"place": "beam.end", "direction": "y", "noise": 1e-4}
    true = vr.StaticRecord(loads, np.zeros(5), **about).predicted(run_case(static()))
    record = vr.StaticRecord(loads, true + 1e-4 * np.random.default_rng(3).normal(size=5), **about)
    fit = vr.identify(static(youngs_modulus=0.7e6), record, [YOUNG])
    assert fit[YOUNG].low < 1e6 < fit[YOUNG].high
    assert fit[YOUNG].high - fit[YOUNG].low < 0.01e6


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"materials.rubber.youngs": 1e6}, "no case has a number there"),
        ({YOUNG: (2e6, 1e6, 3e6)}, "low <= start <= high"),
        ({YOUNG: "stiff"}, "a start, or low, start and high"),
        ({}, "nothing is sought"),
        ({"rods.beam.section": 1.0}, "not one number"),
        ({"materials.rubber.youngs modulus": 1.0}, "not a key"),
    ],
)
def test_wrong_keys_and_ranges_are_refused(parameters, words):
    with pytest.raises(InputError, match=words):
        vr.identify(swing(), history(swing()), parameters)


def test_records_of_one_name_and_what_is_none_are_refused():
    record = history(swing())
    with pytest.raises(InputError, match="another record has this name"):
        vr.identify(swing(), [record, record], [YOUNG])
    with pytest.raises(InputError, match="no record"):
        vr.identify(swing(), 3.0, [YOUNG])
    with pytest.raises(InputError, match="level"):
        vr.identify(swing(), record, [YOUNG], level=1.5)

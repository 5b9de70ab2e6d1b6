"""Numbers of rods from records: synthetic truth, what cannot be told, several cases at once, the file and the page."""

import re
import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers import chromium
from helpers.measured_files import STRIP, write_lengths
from viscorod.analyses.case_run import run_case
from viscorod.analyses.identification.case_numbers import case_with, number_at
from viscorod.analyses.identification.case_predictions import CasePredictions
from viscorod.analyses.identification.fit_file import load_fit
from viscorod.analyses.identification.foretold import amplitude_sentences, swings_of
from viscorod.analyses.identification.law_sentences import law_sentences
from viscorod.analyses.identification.law_words import Frequencies, variant
from viscorod.analyses.identification.members import Member, members_of
from viscorod.analyses.identification.moved_numbers import moved_numbers
from viscorod.analyses.identification.record_frequencies import held_band
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.toml_text import toml_text
from viscorod.cli.app import app
from viscorod.errors import InputError
from viscorod.pictures.plots.plot_identification import draw_intervals
from viscorod.records.any_record import STEP
from viscorod.results.identification_report import limits_text, programs_table, with_prefix
from viscorod.results.identified import Number
from viscorod.solve.estimation.intervals import Covariance
from viscorod.solve.estimation.least_squares import no_worse
from viscorod.solve.estimation.unknowns import Unknown, Unknowns
from viscorod.solve.problem import layout

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
                "order": 4,
            }
        },
        "supports": [{"kind": "clamp", "at": "beam.start"}],
        "loads": [{"kind": "force", "at": "beam.end", "value": [0.0, load, 0.0], "until": 0.0}],
        **analysis,
    }


def swing(load=0.02, **material):
    return case_from_dict(content({"simulate": {"duration": 0.8, "tolerance": 1e-5}}, load, **material))


def history(case, name="tip", size=2e-3, seed=0, release=None, **more):
    times = np.linspace(0.0, 0.8, 100)
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y", "name": name}
    clock = vr.Record(times, np.zeros(100), **about, unknown=["release_time"])
    clean = clock.predicted(run_case(case), {f"{name}.release_time": release or 0.0})
    return vr.Record(times, clean + size * np.random.default_rng(seed).normal(size=100), **about, **more)


def test_runs_of_a_fit_share_what_does_not_change():
    """Parts of the case and where its nodes are; what is predicted is that of a fit that begins there, bit for bit."""
    tip = history(swing())
    (member,) = members_of([(swing(), [tip])])
    tried = [{YOUNG: 1.2e6, SHEAR: 0.03}, {YOUNG: 1.2e6, SHEAR: 0.03003}, {YOUNG: 0.9e6, SHEAR: 0.02}]
    found = [member.predicted(tip, values) for values in tried]
    cases = [case_with(member.case, values, member._known) for values in tried]
    assert cases[0].description.rods["beam"].centreline is cases[2].description.rods["beam"].centreline
    for values, predicted in zip(tried, found, strict=True):
        (alone,) = members_of([(swing(), [tip])])
        layout._kept.cache_clear()
        np.testing.assert_array_equal(predicted, alone.predicted(tip, values))


def test_of_samples_that_were_held_a_fit_takes_the_first():
    """Each of 100 samples stands four times, as a slow converter holds it: held ones are a step and a half late."""
    case, tip = swing(), history(swing())
    times = np.linspace(0.0, tip.times[-1] + 0.75 * tip.interval, 400)
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y", "name": "tip"}
    written = vr.Record(times, np.repeat(tip.values, 4), **about)
    held, alone = (vr.identify(case, one, {YOUNG: 1.1e6}, profile=False) for one in (written, tip))
    assert held.sentences[0].startswith("Every value of tip stands 4 times in a row (it was held)")
    assert held.data.sizes["value"] == 100
    assert held[YOUNG].low < 1e6 < held[YOUNG].high
    assert held[YOUNG].value == pytest.approx(alone[YOUNG].value, rel=1e-6)
    assert not any("in a row" in one for one in alone.sentences)


def test_slopes_at_the_estimate_are_exact():
    """About the reference shape frequencies go with the root of E, ratios with that and the time, on one mesh.

    Those of a swing with held steps are met by differences to both sides, extrapolated, but for what the iteration of
    steps leaves in these.
    """
    case = modes_case()
    true = run_case(case)
    record = vr.ModesRecord(true.frequencies, true.damping_ratios)
    unknowns = Unknowns([Unknown(YOUNG, 1e6, logarithmic=True), Unknown(BOTH, 0.02, logarithmic=True)])
    modes = CasePredictions(members_of([(case, [record])]), unknowns, [])
    slopes = modes.jacobian(np.array([1e6, 0.02])) * [1e6, 0.02]
    hertz, ratios = np.split(modes.values(np.array([1e6, 0.02])), 2)
    none = np.zeros(4)
    exact = np.stack([np.append(hertz, ratios) / 2.0, np.append(none, ratios)], axis=1)
    np.testing.assert_allclose(slopes, exact, atol=1e-8 * hertz[0])
    tip = history(swing())
    motion, at = CasePredictions(members_of([(swing(), [tip])]), unknowns, []), np.array([1.1e6, 0.025])
    motion.hold(at)
    found = motion.jacobian(at) * at
    for k in range(2):
        change = np.eye(2)[k] * at
        once, twice = (
            (motion.values(at + part * change) - motion.values(at - part * change)) / (2.0 * part)
            for part in (1e-3, 5e-4)
        )
        np.testing.assert_allclose(found[:, k], (4.0 * twice - once) / 3.0, atol=1e-5 * np.abs(once).max())


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


def test_what_is_told_does_not_depend_on_units_of_unknowns():
    """An offset in m changes values far more per unit than a time does per part; both are told, and so is the pull."""
    tip = history(swing(), size=3e-5, unknown=["offset"])
    fit = vr.identify(
        swing(), tip, {YOUNG: 1.1e6, BOTH: 0.025}, nuisances={"loads[0].value[1]": (0.01, 0.018, 0.1)}
    )
    for name, true in ((YOUNG, 1e6), (BOTH, 0.02), ("loads[0].value[1]", 0.02), ("tip.offset", 0.0)):
        assert fit[name].low <= true <= fit[name].high, name
        assert fit[name].high - fit[name].low < 0.03 * max(true, 0.01), name


def test_records_of_one_case_keep_their_own_numbers():
    """Two pulls by hand of one bar: each record has its own, and one without any has that of the case."""
    pull = [vr.Unknown("pull", 0.018, low=0.01, high=0.03, key="loads[0].value[1]")]
    first, second = (
        history(swing(load), name, seed=seed, unknown=pull)
        for load, name, seed in ((0.022, "first", 1), (0.015, "second", 2))
    )
    third = history(swing(), "third, 5 g", seed=3, unknown=["offset"])  # a name that is none of a key
    fit = vr.identify(swing(), [first, second, third], {YOUNG: 1.05e6})
    for name, true in (("first.pull", 0.022), ("second.pull", 0.015), (YOUNG, 1e6)):
        assert fit[name].value == pytest.approx(true, rel=0.01), name
    assert fit.residuals.std() == pytest.approx(2e-3, rel=0.1)


def test_a_fit_comes_back_from_its_file_with_its_case(two_times, tmp_path):
    found = vr.load(two_times.save(tmp_path / "fit.nc"))
    assert isinstance(found, vr.Identification)
    assert found.report() == two_times.report()
    assert found.numbers == two_times.numbers
    material = found.case.description.rods["beam"].material
    assert material.youngs_modulus == found[YOUNG].value
    predicted = history(found.case, size=0.0).observed
    # the search goes through steps of its own, which err by 1e-5 of 0.3 m, too
    np.testing.assert_allclose(predicted, found.data["predicted"].values, atol=3e-6)


def test_the_page_is_one_file_that_needs_no_network(two_times, tmp_path):
    text = two_times.page(tmp_path / "fit.html").read_text(encoding="utf-8")
    assert text.count("<svg") == 4
    assert not re.search(r"(src|href)=\"https?:", text.replace("http://www.w3.org", ""))
    for words in ("not told", "infinite", "extensional time of beam", "youngs_modulus = "):
        assert words in text


@pytest.mark.slow
@pytest.mark.skipif(chromium.find() is None, reason="no Chromium or Chrome is on the PATH")
def test_on_a_telephone_wide_tables_and_pictures_of_the_page_move_by_themselves(two_times, tmp_path):
    pytest.importorskip("websocket", reason="the package websocket-client drives the browser")
    with chromium.opened(tmp_path / "profile") as shown:
        shown.resize(420, 900)
        shown.send("Page.navigate", url=two_times.page(tmp_path / "fit.html").as_uri())
        shown.wait("document.querySelectorAll('svg').length === 4 && document.readyState === 'complete'")
        assert shown.run("document.documentElement.scrollWidth") <= 420
        narrow = "[...document.querySelectorAll('.wide')].every(e => e.scrollWidth <= e.clientWidth)"
        assert not shown.run(narrow)  # as they would be unread if they were shrunk
        shown.resize(1280, 900)
        assert shown.run(narrow)
        assert shown.errors == []


def test_equal_inputs_of_a_program_share_a_row(two_times):
    header, rows = programs_table(two_times)
    unfolded = {
        f"{program}: {word}": rest
        for name, *rest in rows
        for program, words in [name.split(": ")]
        for word in words.split(" = ")
    }
    assert header[1:] == ["value", "low", "high", "unit"]
    assert unfolded == {
        name: [f"{one.value:.5g}", *limits_text(one), one.unit] for name, one in two_times.in_programs.items()
    }
    assert len(rows) < len(unfolded)


def test_an_interval_that_leaves_its_picture_tells_where_it_ends():
    numbers = {"offset": Number("offset", 2.0, -1.0, 11.0), "gain": Number("gain", 4.0, 3.0, 5.0)}
    picture = draw_intervals(SimpleNamespace(numbers=numbers, combinations={}, level=0.95))
    (axes,) = picture.axes
    assert sorted(text.get_text() for text in axes.texts) == ["450 %", "\N{MINUS SIGN}150 %"]
    assert axes.get_xlabel() == "interval of 95 %, in % of the value"


def test_a_motion_that_the_model_has_not_is_told_beside_every_interval(two_times, tmp_path):
    """The swing with a smaller one of another frequency added: no time and no modulus explains it."""
    right = history(swing())
    more = 0.2 * np.interp(1.3 * right.times, right.times, right.values)
    wrong = vr.Record(
        right.times, right.values + more, place="beam.end", quantity="displacement", direction="y", name="tip"
    )
    fit = vr.identify(swing(youngs_modulus=1.2e6), wrong, {YOUNG: None, BOTH: 0.03}, profile=False)
    assert fit.missed == ["tip"]
    assert two_times.missed == []
    numbers = [*fit.numbers.values(), *fit.combinations.values(), *fit.in_programs.values()]
    assert all("model misses motion" in one.how for one in numbers)
    assert "model misses motion" not in two_times[YOUNG].how
    words = " ".join(fit.report().split())
    for text in ("intervals of 95 %", "other programs"):
        assert f"{text}: too narrow, the model misses part of tip" in words
    assert vr.load(fit.save(tmp_path / "fit.nc")).missed == ["tip"]


FAULTS = {
    "sign": (lambda t, y: -y, {}, "on the other side of its rest than the model"),
    "unit": (lambda t, y: 1e3 * y, {}, "times as far as the model: look at the unit"),
    "axis": (
        lambda t, y: y,
        {"direction": "z"},
        "hardly moves where tip was measured (beam.end, displacement z)",
    ),
    "range": (lambda t, y: np.clip(y, -0.6 * y.max(), 0.6 * y.max()), {}, "it is clipped there"),
    "zero": (lambda t, y: y + 0.01, {}, "unknown = ['offset']"),
    "drift": (lambda t, y: y + 0.03 * t, {"unknown": ["offset"]}, "unknown = ['drift']"),
    "held": (lambda t, y: np.interp(t - 0.3, t, y), {}, "tip stands still for its first 0.3"),
    "late": (lambda t, y: np.interp(t - 0.02, t, y), {}, "unknown = ['release_time']"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_common_faults_of_a_measurement_are_named(name):
    change, more, words = FAULTS[name]
    right = history(swing(), size=5e-4)
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y", "name": "tip"}
    record = vr.Record(right.times, change(right.times, right.values), **(about | more))
    fit = vr.identify(swing(youngs_modulus=1.1e6), record, {YOUNG: None, BOTH: 0.03}, profile=False)
    assert words in fit.sentences[0]
    assert fit.missed == ([] if name == "zero" else ["tip"])


def test_the_motion_lasts_as_long_as_differences_by_the_release_need():
    """At its lower bound the search ended in an error, as differences go beyond it."""
    release = vr.Unknown("release_time", low=-0.05, high=0.4)
    record = vr.Record(
        [0.0, 0.5, 1.0],
        [0.0, 0.0, 0.1],
        place="beam.end",
        quantity="displacement",
        direction="y",
        unknown=[release],
    )
    duration = Member(swing(), [record]).case.settings.duration
    assert duration >= 1.0 + 0.05 + STEP * 0.45


def test_noise_of_a_history_with_gaps_is_no_miss_of_the_model():
    """Noise of half of the spread, a tenth of the samples lost: white, and the interval holds; a motion is told."""
    clean = history(swing(), size=0.0)
    seen = np.random.default_rng(2).random(len(clean.times)) > 0.1
    noise = 0.5 * np.std(clean.values) * np.random.default_rng(3).normal(size=len(clean.times))
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y", "name": "tip"}
    for more, missed in ((0.0, []), (1.0, ["tip"])):
        values = clean.values + noise + more * np.interp(1.3 * clean.times, clean.times, clean.values)
        record = vr.Record(clean.times[seen], values[seen], **about)
        fit = vr.identify(swing(youngs_modulus=1.1e6), record, {YOUNG: None, BOTH: 0.03}, profile=False)
        assert fit.missed == missed
        assert missed or fit[YOUNG].low < 1e6 < fit[YOUNG].high


def test_a_history_in_which_nothing_moves_is_told():
    times = np.linspace(0.0, 0.8, 100)
    still = vr.Record(times, 0.0 * times, place="beam.end", quantity="displacement", direction="y")
    fit = vr.identify(swing(), still, {YOUNG: (0.9e6, 1e6, 1.1e6)}, profile=False)
    assert "Nothing moves" in fit.sentences[0]


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
    assert mujoco.unit == "N m s/rad"
    axial = fit.in_programs["MBDyn: viscosity, axial"]
    assert axial.unit == "N s"
    assert axial.value == pytest.approx(fit[YOUNG].value * 1e-4 * fit[BOTH].value, rel=1e-6)  # E A tau
    assert "N m s/rad" in fit.report()


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
    return case_from_dict(content({"modes": {"count": 4, "about": "reference"}}, **material))


def test_frequencies_tell_stiffness_over_mass_and_ratios_tell_the_time():
    """Frequencies go with the root of E/rho: its factors cannot be told, their ratio can; zeta = omega tau/2."""
    true = run_case(modes_case())
    rng = np.random.default_rng(1)
    hertz, ratios = true.frequencies, true.damping_ratios
    record = vr.ModesRecord(
        hertz * (1.0 + 1e-3 * rng.normal(size=4)), ratios * (1.0 + 1e-2 * rng.normal(size=4))
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


def test_moduli_of_a_material_need_no_motion():
    """E* = E (1 + ratio i w tau/(1 + i w tau)), a Maxwell branch beside a spring, to Cramer and Rao's bound."""
    hertz, true = np.geomspace(0.1, 100.0, 40), np.array([1e6, 0.4, 0.05])

    def modulus(young, ratio, tau):
        turn = 2j * np.pi * hertz * tau
        return young * (1.0 + ratio * turn / (1.0 + turn))

    exact, rng = modulus(*true), np.random.default_rng(6)
    noisy = exact + 0.01 * np.abs(exact) * (rng.normal(size=40) + 1j * rng.normal(size=40))
    prony = {"kind": "prony", "extension_ratios": [0.2], "extension_times": [0.02]}
    case = case_from_dict(content({"modes": {"count": 1}}, damping=prony))
    record = vr.ModuliRecord(hertz, noisy.real, noisy.imag, relative_noise=0.01)
    path = "materials.rubber.damping.extension_"
    fit = vr.identify(case, record, [YOUNG, f"{path}ratios[0]", f"{path}times[0]"])
    columns = [
        (modulus(*(true * (1.0 + 1e-6 * axis))) - exact) / (1e-8 * np.abs(exact)) for axis in np.eye(3)
    ]
    slopes = np.concatenate([np.real(columns), np.imag(columns)], axis=1)
    bound = np.sqrt(np.diag(np.linalg.inv(slopes @ slopes.T)))
    assert all(low < value < high for (low, high), value in zip(fit.intervals.values(), true, strict=True))
    errors = [one.standard_error / one.value for one in fit.numbers.values()]
    np.testing.assert_allclose(errors, bound, rtol=0.2)  # the size of the noise is that of 80 values


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"materials.rubber.youngs": 1e6}, "no case has a number there; did you mean youngs_modulus?"),
        ({"materials.ruber.youngs_modulus": 1e6}, "no case has a number there; did you mean rubber?"),
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


def test_numbers_that_the_case_leaves_out_are_those_of_the_model():
    case = swing()
    assert "twist" not in case.content["rods"]["beam"]
    assert number_at(case, "rods.beam.twist") == 0.0
    assert case_with(case, {"rods.beam.twist": 0.1}).description.rods["beam"].twist == 0.1
    assert number_at(case, "rods.other.twist") is None


def test_numbers_of_a_report_have_the_prefix_of_their_value():
    modulus = with_prefix(Number("E", 1.2e6, 1.1e6, np.inf, 39.0, unit="Pa"))
    assert (modulus.value, modulus.low, modulus.high, modulus.standard_error) == pytest.approx(
        (1.2, 1.1, np.inf, 3.9e-5)
    )
    assert modulus.unit == "MPa"
    nothing = with_prefix(Number("offset", 0.0, -2e-5, 3e-5, unit="m"))
    assert (nothing.high, nothing.unit) == (pytest.approx(30.0), "µm")
    assert with_prefix(Number("ratio", 3e-7, 0.0, 1.0, unit="1")).value == 3e-7


def test_records_of_one_name_and_what_is_none_are_refused():
    record = history(swing())
    with pytest.raises(InputError, match="another record has this name"):
        vr.identify(swing(), [record, record], [YOUNG])
    with pytest.raises(InputError, match="no record"):
        vr.identify(swing(), 3.0, [YOUNG])
    with pytest.raises(InputError, match="level"):
        vr.identify(swing(), record, [YOUNG], level=1.5)


LAWS = {
    "kelvin_voigt": {"shear_time": 0.01, "bulk_time": 0.01},
    "flat_loss": {"kind": "loss_factor", "extension": 0.06, "band": [0.3, 300.0]},
    "wide": {"kind": "loss_factor", "extension": 0.06, "band": [0.01, 3000.0]},
}


def ratios_of(law):
    """A table of four modes of a strip with a law, noise 0.1 % of frequencies and 3 % of ratios."""
    true, rng = run_case(modes_case(damping=LAWS[law])), np.random.default_rng(2)
    hertz, ratios = true.frequencies, true.damping_ratios
    return vr.ModesRecord(
        hertz * (1.0 + 1e-3 * rng.normal(size=4)),
        ratios * (1.0 + 0.03 * rng.normal(size=4)),
        frequency_noise=1e-3 * hertz,
        ratio_noise=0.03 * ratios,
    )


@pytest.mark.parametrize(("best", "excluded"), [("kelvin_voigt", "flat_loss"), ("flat_loss", "kelvin_voigt")])
def test_the_law_is_told_by_ratios_over_frequency(best, excluded):
    """Ratios that grow with the frequency are a viscosity's, those that do not are a flat loss factor's."""
    fit = vr.identify(modes_case(), ratios_of(best), [YOUNG], profile=False, laws=[excluded, best])
    assert fit.laws[0].name == best
    (sentence,) = [text for text in fit.sentences if text.startswith("Excluded")]
    assert excluded in sentence
    assert best not in sentence
    assert "Laws on the same data" in fit.report()


def test_a_flat_loss_of_another_band_is_a_flat_loss():
    """The squares are those of eight values of that noise less two numbers; 16.8 are exceeded by 1 % of chi^2 of 6."""
    record = ratios_of("wide")
    fit = vr.identify(modes_case(), record, [YOUNG], profile=False, laws=["flat_loss", "kelvin_voigt"])
    assert fit.laws[0].name == "flat_loss"
    assert float(fit.data["law_square"][0]) < 16.8
    assert fit["materials.rubber.damping.extension"].value == pytest.approx(0.06, rel=0.05)
    flat = fit.case.content["materials"]["rubber"]["damping"]
    hertz = record.frequencies
    np.testing.assert_allclose(flat["band"], [hertz.min() / 10.0, hertz.max() * 10.0])
    assert hertz.min() < flat["moduli_at"] < hertz.max()
    assert re.match(r"youngs_modulus \S+ \+- \S+ (kPa|MPa);", fit.laws[0].values)


def test_the_band_of_a_flat_loss_is_what_a_history_holds_or_what_the_case_says():
    """A decay of 2 s at 2 Hz, 100 samples a second: what creeps in 20 s is slow to it, 50 Hz is its fastest."""
    times = np.linspace(0.0, 2.0, 201)
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y"}
    record = vr.Record(times, np.exp(-times) * np.cos(2.0 * np.pi * 2.0 * times), **about)
    band = held_band(members_of([(swing(), record)]))
    np.testing.assert_allclose(band, [0.05, 50.0])
    held = Frequencies(2.0, band)
    for case, shown in (
        (swing(), ([0.05, 50.0], 2.0)),
        (swing(damping=LAWS["flat_loss"]), ([0.3, 300.0], None)),
    ):
        flat = variant(swing(), "flat_loss", held.of_case(case))[0].content["materials"]["rubber"]["damping"]
        assert flat["band"] == pytest.approx(shown[0])
        assert flat.get("moduli_at") == shown[1]


def test_what_was_left_out_decides_between_laws_of_one_frequency():
    """One mode has any law; a weight at the tip lowers the ratio of a viscosity with the frequency, not a flat loss."""
    true = run_case(modes_case(damping=LAWS["wide"]))
    hertz, ratio = float(true.frequencies[0]), float(true.damping_ratios[0])
    noise = {"frequency_noise": [1e-3 * hertz], "ratio_noise": [0.02 * ratio]}
    twice = [vr.ModesRecord([hertz], [ratio], name=name, **noise) for name in ("first", "second")]
    weight = {"shape": "sphere", "centre": [0.3, 0.0, 0.0], "radius": 0.005, "mass": 0.03}
    heavy = content({"simulate": {"duration": 12.0, "tolerance": 1e-4}}, 0.002, damping=LAWS["wide"])
    heavy |= {"bodies": {"weight": weight}, "attachments": [{"a": "beam.end", "b": "weight"}]}
    heavy = case_from_dict(heavy)
    times = np.linspace(0.0, 12.0, 150)
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y", "name": "heavy"}
    clean = vr.Record(times, np.zeros(150), **about).predicted(run_case(heavy))
    weighed = vr.Unknown("weight", 0.03, deviation=0.0003, key="bodies.weight.mass")
    tip = vr.Record(
        times,
        clean + 1e-5 * np.random.default_rng(7).normal(size=150),
        noise=1e-5,
        unknown=[weighed],
        **about,
    )
    fit = vr.identify(
        modes_case(),
        twice,
        [YOUNG],
        laws=["kelvin_voigt", "flat_loss"],
        left_out=[(heavy, tip)],
        profile=False,
    )
    assert [law.name for law in fit.laws] == ["flat_loss", "kelvin_voigt"]
    assert "materials.rubber.damping.extension" in fit.parameters
    assert fit.case.content["materials"]["rubber"]["damping"]["kind"] == "loss_factor"
    flat, viscous = (next(one for one in fit.foretold if one.law == law.name) for law in fit.laws)
    assert abs(flat.frequency - flat.measured_frequency) < flat.frequency_width
    by_weight = 0.5 * 1.96 * 0.01 * flat.frequency  # if the weight were all that moves
    assert 0.6 * by_weight < flat.frequency_width < 1.2 * by_weight
    assert flat.damping_ratio == pytest.approx(
        flat.measured_ratio, rel=0.06
    )  # branches ripple about a flat loss
    assert viscous.damping_ratio == pytest.approx(ratio * viscous.frequency / hertz, rel=0.03)
    excluded = [text for text in fit.sentences if text.startswith("Excluded by what was left out")]
    assert [text.split(":")[1].split(".")[0].strip() for text in excluded] == ["kelvin_voigt"]
    assert "Records left out, foretold and measured" in fit.report()
    (told,) = [text for text in fit.sentences if text.startswith("flat_loss foretells")]
    assert "The frequencies differ by no more than these intervals; " in told
    # a weight of 30 +- 0.3 g moves the frequency by half of a hundredth of it, if it were all that moves
    assert "rests on what was believed of heavy.weight (0.03 +- 0.0003 in SI)" in told


def test_a_ratio_that_depends_on_the_amplitude_is_not_called_the_materials():
    """Of two made-up decays one has a ratio that is twice as large at a tenth of the amplitude."""
    times = np.arange(0.0, 8.0, 0.02)

    def record(name, rise):
        phase, amplitude, values = 0.0, 1e-2, []
        for _ in times:
            values.append(amplitude * np.cos(phase))
            phase += 2.0 * np.pi * 1.5 * 0.02
            amplitude *= np.exp(-0.03 * (1.0 + rise * np.exp(-amplitude / 3e-3)) * 2.0 * np.pi * 1.5 * 0.02)
        noise = 1e-6 * np.random.default_rng(1).normal(size=len(times))
        return vr.Record(times, values + noise, place="a", quantity="position", direction="x", name=name)

    case = swing()
    (steady, rising) = swings_of([(case, record("steady", 0.0)), (case, record("rising", 1.0))]).values()
    assert steady.ends is None
    (sentence,) = amplitude_sentences({"steady": steady}, {"rising": rising}, "flat_loss")
    assert sentence.startswith("The damping ratio of rising rises from 0.03")
    assert "that of steady, which flat_loss was fitted to, does not" in sentence
    assert "not called the material's" in sentence


def test_a_foretold_frequency_that_depends_on_the_amplitude_is_told_with_its_ends():
    """A made-up decay with omega = omega0 (1 - A/0.2 m), its phase in closed form: 1.425 Hz at 0.01 m, 1.5 at rest."""
    times = np.arange(0.0, 8.0, 0.02)
    rate = 0.4
    size = 1e-2 * np.exp(-rate * times)
    phase = 2.0 * np.pi * 1.5 * (times - (size[0] - size) / (0.2 * rate))
    noise = 1e-6 * np.random.default_rng(1).normal(size=len(times))
    record = vr.Record(
        times, size * np.cos(phase) + noise, place="a", quantity="position", direction="x", name="soft"
    )
    (soft,) = swings_of([(swing(), record)]).values()
    (sentence,) = [
        one
        for one in amplitude_sentences({}, {"soft": soft}, "flat_loss")
        if "The frequency of soft goes" in one
    ]
    assert "as one number it is known no better than that" in sentence
    for part in (sentence.split("from ")[1], sentence.split(" to ")[1]):
        hertz, amplitude = float(part.split(" Hz at ")[0]), float(part.split(" m")[0].split()[-1])
        assert hertz == pytest.approx(1.5 * (1.0 - amplitude / 0.2), rel=3e-3)


def test_what_is_not_the_materials_is_said():
    names = ["flat_loss + air_drag", "flat_loss", "kelvin_voigt"]
    merits, errors = np.array([0.0, 25.0, 90.0]), np.array([1.0, 2.0, 4.0])
    told = " ".join(law_sentences(names, merits, errors, 80.0, {names[0]: 0.12}))
    assert "flat_loss (AICc +25), kelvin_voigt (AICc +90)" in told
    assert "not the material's: the air takes its part, 12 % of the lost energy" in told
    assert "predicts best (times its error: flat_loss: 2, kelvin_voigt: 4)" in told
    told = " ".join(law_sentences(names, np.array([0.0, 3.0, 90.0]), np.zeros(3), 80.0, {}))
    assert "do not tell whether the air takes part" in told
    assert "not the material's" not in told


def test_a_law_that_foretells_as_well_is_not_excluded_by_one_that_misses_the_motion_too():
    names, merits = ["branches 2", "flat_loss", "kelvin_voigt"], np.array([0.0, 35.0, 62.0])
    errors = np.array([23.8, 21.6, 87.4])
    told = law_sentences(names, merits, errors, 47.0, {}, misses=True)
    assert told[0] == "Excluded by these data (47 effective values): kelvin_voigt (AICc +62)."
    assert told[1].startswith(
        "Not excluded, though the fit is worse: flat_loss (AICc +35). branches 2 misses part"
    )
    assert told[2] == "These data fit branches 2 best."
    told = law_sentences(names, merits, errors, 47.0, {})
    assert told[0].endswith("flat_loss (AICc +35), kelvin_voigt (AICc +62).")
    told = law_sentences(names, merits, np.array([23.8, 30.0, 87.4]), 47.0, {}, misses=True)
    assert told[0].endswith("flat_loss (AICc +35), kelvin_voigt (AICc +62).")


def test_a_law_whose_search_did_not_come_to_rest_is_named_and_not_excluded():
    names, merits = ["flat_loss", "kelvin_voigt", "elastic"], np.array([0.0, 35.0, 62.0])
    steps = {"flat_loss": 0.0, "kelvin_voigt": 2.34, "elastic": 0.0}
    told = law_sentences(names, merits, np.zeros(3), 47.0, {}, unsettled=steps)
    assert told[0].startswith("The search did not come to rest with kelvin_voigt (2.3); in brackets")
    assert told[0].endswith("which does not exclude kelvin_voigt: give starts = 5.")
    assert told[1] == "Excluded by these data (47 effective values): elastic (AICc +62)."
    steps["kelvin_voigt"] = 1.1  # which takes a criterion down by some 1.2, and not by 25
    told = law_sentences(names, merits, np.zeros(3), 47.0, {}, unsettled=steps)
    assert told[0].endswith("The fit may be better than the table says: give starts = 5.")
    assert "kelvin_voigt (AICc +35), elastic (AICc +62)" in told[1]
    settled = law_sentences(names, merits, np.zeros(3), 47.0, {}, unsettled=dict.fromkeys(names, 0.0))
    assert settled[0].endswith("kelvin_voigt (AICc +35), elastic (AICc +62).")


def test_a_clamp_that_only_gives_way_is_not_called_damping():
    names, merits = ["kelvin_voigt + clamp_loss", "kelvin_voigt"], np.array([0.0, 700.0])
    told = " ".join(law_sentences(names, merits, np.zeros(2), 300.0, {}, names[:1]))
    assert "The clamp gives way: kelvin_voigt alone is excluded. Whether the clamp damps" in told
    assert "not the material's" not in told
    assert "not the material's: the clamp" in " ".join(law_sentences(names, merits, np.zeros(2), 300.0, {}))


def test_a_clamp_that_is_a_spring_gives_way_and_is_not_called_damping():
    """A strip whose clamp is a spring without a damper, by five modes."""
    spring = {"at": "beam.start", "stiffness": dict.fromkeys(("rx", "ry", "rz"), 0.2)}
    modes = {"modes": {"count": 5, "about": "reference"}, "loads": []}
    soft = content(modes, damping=LAWS["kelvin_voigt"])
    found = run_case(
        case_from_dict(soft | {"supports": [{"kind": "pin", "at": "beam.start"}], "springs": [spring]})
    )
    noise = {"frequency_noise": 1e-3 * found.frequencies, "ratio_noise": 0.01 * found.damping_ratios}
    record = vr.ModesRecord(found.frequencies, found.damping_ratios, **noise)
    laws = ["kelvin_voigt", "kelvin_voigt + clamp_loss"]
    fit = vr.identify(case_from_dict(content(modes)), record, [YOUNG], laws=laws, profile=False)
    assert fit.laws[0].name == laws[1]
    assert [text for text in fit.sentences if "Whether the clamp damps these data do not tell" in text]
    assert "springs[0].stiffness.rx" in fit.laws[0].values


def test_numbers_of_the_best_law_are_those_of_the_fit_and_narrow_ones_are_marked():
    """The swing with a smaller one of another frequency added, as if noise had no colour and with it."""
    right = history(swing())
    more = 0.2 * np.interp(1.3 * right.times, right.times, right.values)
    wrong = vr.Record(
        right.times, right.values + more, place="beam.end", quantity="displacement", direction="y", name="tip"
    )
    fit = vr.identify(swing(), wrong, {YOUNG: None}, laws=["kelvin_voigt"], profile=False)
    (law,) = fit.laws
    modulus = float(re.search(r"youngs_modulus (\S+) \+- \S+ kPa", law.values)[1])
    assert 1e3 * modulus == pytest.approx(fit[YOUNG].value, rel=1e-3)
    assert law.values.endswith("(too narrow, it misses part of the motion)")


def test_numbers_that_the_colour_of_the_noise_moves_are_named():
    """Standard errors of 3e-3 and 4e-3 are 5e-3 of a difference: 2e-2 is four of them, and 1e-2 two."""
    unknowns = Unknowns([Unknown("modulus", 1.0, logarithmic=True), Unknown("time", 1.0, logarithmic=True)])
    none = np.zeros((0, 2))
    last, before = (Covariance(size**2 * np.eye(2), none, np.full(2, 50.0), ()) for size in (3e-3, 4e-3))
    found = moved_numbers(unknowns, (np.array([2e-2, 1e-2]), last), (np.zeros(2), before), ["MPa", "s"])
    assert found == ["modulus (1.0202 MPa and 1 MPa)"]


@pytest.mark.parametrize(("start", "nearer"), [(1.3917, True), (1.3918, False)])
def test_a_search_does_not_begin_where_a_step_has_gone_too_far(start, nearer):
    """Newton's steps for the root of arctan diverge from 1.39175 on, where 2 z = (1 + z^2) arctan z."""
    scaled = SimpleNamespace(values=np.arctan)
    noise = SimpleNamespace(whitened=lambda values: values)
    step = -np.arctan(start) * (1.0 + start**2)
    there = np.array([start + step])
    assert no_worse(scaled, noise, np.zeros(1), np.arctan([start]), there) is nearer


def test_laws_that_there_are_not_are_refused():
    for laws, words in (
        (["honey"], "no such law"),
        (["elastic + flat_loss"], "two laws"),
        (["branches 9"], "no such law"),
    ):
        with pytest.raises(InputError, match=words):
            vr.identify(modes_case(), ratios_of("kelvin_voigt"), [YOUNG], profile=False, laws=laws)


FIT = """
case = "strip.toml"
profile = false

[parameters]
"materials.rubber.youngs_modulus" = [3e5, 7e5, 3e6]

[[records]]
kind = "static"
file = "pull.csv"
load = "F"
value = "w"
full_load = 0.02
place = "beam.end"
direction = "y"
noise = 1e-4
"""


@pytest.fixture
def fit_folder(tmp_path):
    case = case_from_dict(content({"equilibrium": {"load_steps": 5}}))
    (tmp_path / "strip.toml").write_text(toml_text(case.content))
    moved = run_case(case).probe("beam.end")["displacement"].values[:, 0, 1]
    rows = [f"{0.004 * (k + 1):.4f};{1e3 * w:.5f}" for k, w in enumerate(moved)]
    (tmp_path / "pull.csv").write_text("\n".join(["F [N];w [mm]", *rows]))
    (tmp_path / "fit.toml").write_text(FIT)
    return tmp_path


def test_the_command_reads_a_file_and_writes_all(fit_folder):
    out = fit_folder / "out"
    done = CliRunner().invoke(app, ["identify", str(fit_folder / "fit.toml"), "-o", str(out)])
    assert done.exit_code == 0, done.output
    assert "Numbers of the model" in done.output
    assert sorted(path.name for path in out.iterdir()) == ["case.toml", "fit.html", "fit.nc", "fit.png"]
    fitted = vr.load_case(out / "case.toml").description.rods["beam"].material
    assert fitted.youngs_modulus == pytest.approx(1e6, rel=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('case = "strip.toml"', "", "the path of a case file is needed"),
        ("profile = false", "profiles = false", "no such key"),
        ("profile = false", "starts = 1.5", "a whole number is needed"),
        ('load = "F"', 'load = "G"', "G"),
        ('kind = "static"', 'kind = "dynamic"', "no kind of record"),
        ("[[records]]", "[[record]]", "at least one is needed"),
    ],
)
def test_what_is_wrong_in_a_file_is_told(fit_folder, old, new, words):
    (fit_folder / "fit.toml").write_text(FIT.replace(old, new))
    done = CliRunner().invoke(app, ["identify", str(fit_folder / "fit.toml")])
    assert done.exit_code != 0
    assert words in done.output


def test_the_file_of_the_howto_fits_its_case(tmp_path):
    """A reader who copies both has cases and records without a change; the second record has a pull of its own."""
    page = (Path(__file__).parents[2] / "docs/howto/identify.md").read_text(encoding="utf-8")
    blocks = dict(re.findall(r"```none\n# (\w+\.toml)\n(.*?)```", page, re.DOTALL))
    for name in ("bar.toml", "fit.toml"):
        (tmp_path / name).write_text(blocks[name], encoding="utf-8")
    for name in ("trial_1.csv", "trial_2.csv"):
        (tmp_path / name).write_text("t [s],tip_y [mm]\n0,1\n0.1,2\n0.2,1\n", encoding="utf-8")
    found = load_fit(tmp_path / "fit.toml")
    pulls = [number_at(case, "loads[0].value[1]") for case, _ in [*found.pairs, *found.left_out]]
    assert pulls == [0.02, 0.015]


def test_content_as_toml_reads_back_as_it_was():
    given = content(
        {"simulate": {"duration": 1.0}},
        damping={"kind": "prony", "extension_ratios": [0.1], "extension_times": [1.0]},
    )
    given["title"] = 'a "quoted" title\n'
    assert tomllib.loads(toml_text(given)) == given


def test_what_is_known_of_numbers_goes_into_an_ensemble():
    """Frequencies go with the root of E: their spread is half of E's; two keys of one number are equal."""
    fit = vr.identify(modes_case(), ratios_of("kelvin_voigt"), {YOUNG: None, BOTH: 0.01}, profile=False)
    known, correlation = fit.distributions(), fit.correlation_of_distributions()
    assert list(known) == [YOUNG, SHEAR, BULK]
    assert correlation[1, 2] == pytest.approx(1.0)
    assert known[YOUNG].std() == pytest.approx(fit[YOUNG].standard_error, rel=0.01)
    with pytest.raises(InputError, match="no draws were made"):
        _ = fit.posterior
    assert list(fit.distributions(names=[BOTH])) == [SHEAR, BULK]
    np.testing.assert_array_equal(
        fit.correlation_of_distributions(names=[BOTH]), correlation[np.ix_([1, 2], [1, 2])]
    )
    with pytest.raises(InputError, match=r"names: 'damping': there is no such unknown"):
        fit.distributions(names=["damping"])
    found = vr.ensemble(
        fit.case, known, 8, quantities={"hertz": ("frequency", 1)}, correlation=correlation, workers=1
    )
    values = found.data
    np.testing.assert_allclose(values[SHEAR], values[BULK], rtol=1e-9)
    hertz = values["hertz"].values
    relative = np.std(np.log(values[YOUNG].values))
    assert np.std(np.log(hertz)) == pytest.approx(0.5 * relative, rel=1e-3)
    assert relative == pytest.approx(fit[YOUNG].standard_error / fit[YOUNG].value, rel=0.3)


def test_draws_come_back_from_a_file_as_arviz_takes_them(tmp_path):
    pytest.importorskip("emcee")
    fit = vr.identify(
        modes_case(), ratios_of("kelvin_voigt"), {YOUNG: None, BOTH: 0.01}, profile=False, draws=60
    )
    tree = vr.load(fit.save(tmp_path / "fit.nc")).posterior
    draws = tree["posterior"][YOUNG]
    assert draws.dims == ("chain", "draw")
    assert draws.size >= 60
    assert float(draws.mean()) == pytest.approx(fit[YOUNG].value, abs=fit[YOUNG].standard_error)
    assert float(draws.std()) == pytest.approx(fit[YOUNG].standard_error, rel=0.5)
    assert tree["sample_stats"]["lp"].shape == draws.shape
    known = fit.distributions()
    assert known[YOUNG].mean() == pytest.approx(float(draws.mean()), rel=1e-3)
    correlation = fit.correlation_of_distributions()
    quantities = {"hertz": ("frequency", 1)}
    found = vr.ensemble(fit.case, known, 16, quantities=quantities, correlation=correlation, workers=1)
    spread = np.log(found.table()[[YOUNG, "hertz"]]).std()  # frequencies go with the root of E
    assert spread["hertz"] == pytest.approx(0.5 * spread[YOUNG], rel=1e-3)
    assert spread[YOUNG] == pytest.approx(float(np.log(draws).std()), rel=0.3)


def lengths(folder, sought, mass=0.005, at=(0.3, 0.4, 0.5, 0.6)):
    """Fit the frequencies of a strip of 68 GPa with a sensor at some lengths, 0.3 % noise, by a file."""
    made = tomllib.loads(STRIP)
    made["materials"]["aluminium"]["youngs_modulus"] = 68e9
    made["bodies"]["sensor"]["mass"] = mass
    rng, found = np.random.default_rng(8), {}
    for length in at:
        made["rods"]["strip"]["end"][0] = made["bodies"]["sensor"]["centre"][0] = length
        found[length] = run_case(case_from_dict(made)).frequencies[:2] * (1.0 + 3e-3 * rng.normal(size=2))
    plan = load_fit(write_lengths(folder, found, sought))
    return vr.identify(plan.pairs, parameters=plan.parameters)


ALUMINIUM, SENSOR, CLAMP = (
    "materials.aluminium.youngs_modulus",
    "bodies.sensor.mass",
    "springs[0].stiffness.ry",
)


def test_lengths_separate_the_modulus_from_the_mass_of_a_sensor(tmp_path):
    """A sensor counts more on a short strip, a modulus alike on all lengths."""
    fit = lengths(tmp_path, {ALUMINIUM: 70e9, SENSOR: 0.005}, mass=0.007)
    for name, true in ((ALUMINIUM, 68e9), (SENSOR, 0.007)):
        assert abs(fit[name].value - true) < 4.0 * fit[name].standard_error
        assert fit[name].told
    assert fit.correlation[0, 1] > 0.8
    assert (fit[ALUMINIUM].unit, fit[SENSOR].unit) == ("Pa", "kg")


def test_a_clamp_that_is_much_stiffer_than_the_strip_is_not_told(tmp_path):
    """One that turns 1000 times less than the strip bends: nothing limits it from above."""
    fit = lengths(tmp_path, {ALUMINIUM: 70e9, CLAMP: 5e3}, at=(0.3, 0.6))
    assert fit[CLAMP].high == np.inf
    assert any(CLAMP in text for text in fit.sentences)
    assert fit[ALUMINIUM].told
    with pytest.raises(InputError, match="leave it out, names=") as refused:
        fit.distributions()
    assert repr([ALUMINIUM]) in str(refused.value)
    assert list(fit.distributions(names=[ALUMINIUM])) == [ALUMINIUM]


def test_draws_go_into_an_ensemble_as_they_are():
    """Known truth; frequencies go with the root of E, so that quantiles of the ensemble are those of the draws."""
    pytest.importorskip("emcee")
    fit = vr.identify(
        modes_case(),
        ratios_of("kelvin_voigt"),
        {YOUNG: (0.5e6, 1e6, 2e6), BOTH: (1e-3, 0.01, 0.1)},
        profile=False,
        draws=300,
    )
    draws = fit.posterior["posterior"]
    for name, true in ((YOUNG, 1e6), (BOTH, 0.01)):
        low, high = np.quantile(draws[name], [0.005, 0.995])
        assert low < true < high, name
        assert float(draws[name].std()) == pytest.approx(fit[name].standard_error, rel=0.25)
    known, correlation = fit.distributions(), fit.correlation_of_distributions()
    found = vr.ensemble(
        fit.case, known, 16, quantities={"hertz": ("frequency", 1)}, correlation=correlation, workers=1
    )
    about = run_case(fit.case).frequencies[0]
    exact = about * np.sqrt(draws[YOUNG].values.ravel() / fit[YOUNG].value)
    parts = [0.25, 0.5, 0.75]
    off = np.quantile(found.data["hertz"], parts) - np.quantile(exact, parts)
    assert np.abs(off).max() < 0.3 * exact.std()
    np.testing.assert_allclose(found.data[SHEAR], found.data[BULK], rtol=1e-9)


def test_the_posterior_of_a_modulus_is_the_belief_in_the_gain():
    """What a small load moves goes with gain over E: what is believed of the gain, 5 %, is all that is known of E."""
    pytest.importorskip("emcee")
    case = case_from_dict(content({"equilibrium": {"load_factors": [0.0, 0.5, 1.0]}}, 1e-4))
    loads = np.array([0.0, 2.5e-5, 5e-5, 7.5e-5, 1e-4])
    about = {"place": "beam.end", "direction": "y", "full_load": 1e-4}
    moved = vr.StaticRecord(loads, np.zeros(5), **about).predicted(run_case(case))
    noisy = moved + 1e-3 * moved.max() * np.random.default_rng(3).normal(size=5)
    gain = vr.Unknown("gain", deviation=0.05)
    record = vr.StaticRecord(loads, noisy, unknown=[gain], noise=1e-3 * moved.max(), **about)
    fit = vr.identify(case, record, {YOUNG: (0.3e6, 1.1e6, 3e6)}, profile=False, draws=240)
    draws = fit.posterior["posterior"]
    modulus, factor = np.log(draws[YOUNG].values.ravel() / 1e6), draws["beam.end.gain"].values.ravel()
    assert modulus.std() == pytest.approx(0.05, rel=0.2)
    assert factor.std() == pytest.approx(0.05, rel=0.2)
    assert np.corrcoef(modulus, np.log(factor))[0, 1] > 0.99
    assert abs(np.mean(modulus - np.log(factor))) < 3e-3


def test_spikes_of_a_history_are_named_unless_they_count_less():
    record = history(swing(), size=2e-4)
    values = record.values.copy()
    values[[20, 47, 80]] += [0.05, -0.04, 0.06]
    spiky = record.with_samples(record.times, values)
    fit = vr.identify(swing(), spiky, {YOUNG: 1.02e6}, profile=False)
    assert any("3 samples of tip stand far off the others" in text for text in fit.sentences), fit.sentences
    robust = vr.identify(swing(), spiky, {YOUNG: 1.02e6}, profile=False, robust=True)
    assert not any("far off" in text for text in robust.sentences)
    assert abs(robust[YOUNG].value - 1e6) < 3.0 * robust[YOUNG].standard_error

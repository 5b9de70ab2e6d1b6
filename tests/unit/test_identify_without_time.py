"""What often is wrong with tables of modes, static loads and responses is named; invented data of known truth."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.errors import InputError
from viscorod.solve.estimation.noise import neighbours_alike

YOUNG = "materials.alloy.youngs_modulus"
TIMES = "materials.alloy.damping.shear_time, materials.alloy.damping.bulk_time"
TRUE = {
    "youngs_modulus": 70e9,
    "poissons_ratio": 0.33,
    "density": 2700.0,
    "damping": {"shear_time": 1e-4, "bulk_time": 1e-4},
}


def strip(analysis):
    return case_from_dict(
        {
            "title": "strip",
            "materials": {"alloy": TRUE},
            "rods": {
                "strip": {
                    "shape": "straight",
                    "start": [0.0, 0.0, 0.0],
                    "end": [0.4, 0.0, 0.0],
                    "section": {"shape": "rectangle", "width": 0.02, "height": 0.003},
                    "material": "alloy",
                    "elements": 1,
                    "order": 4,
                }
            },
            "supports": [{"kind": "clamp", "at": "strip.start"}],
            "loads": [{"kind": "force", "at": "strip.end", "value": [0.0, 0.0, -1.0], "until": 0.0}],
            **analysis,
        }
    )


MODES = strip({"modes": {"count": 5}, "loads": []})
HERTZ = np.linspace(6.0, 61.0, 12)
SHAKEN = strip(
    {
        "response": {
            "inputs": ["strip.end fz"],
            "outputs": ["strip.end az"],
            "frequencies": HERTZ.tolist(),
            "about": "reference",
        }
    }
)
LOADED = strip({"equilibrium": {}})


def told(fit, words):
    return [text for text in fit.sentences if words in text]


@pytest.mark.parametrize("order", [[1, 3, 4], [2, 1, 3, 4]], ids=["one was missed", "two were exchanged"])
def test_modes_that_were_missed_or_exchanged_are_named(order):
    found = run_case(MODES)
    noise = 1.0 + 0.002 * np.random.default_rng(3).normal(size=len(order))
    measured = found.frequencies[[k - 1 for k in order]] * noise
    wrong = vr.identify(MODES, vr.ModesRecord(measured), {YOUNG: 60e9}, profile=False)
    assert wrong.missed == ["modes: frequencies"]
    inputs = wrong.in_programs
    assert all(one.low > 0.0 for one in inputs.values())  # also those that the data hardly tell
    time = inputs["BeamDyn: mu1"]
    assert time.low == time.high == pytest.approx(1e-4, rel=1e-14)  # no modulus acts on a time
    assert told(wrong, f"give modes = {order}")
    right = vr.identify(MODES, vr.ModesRecord(measured, modes=order), {YOUNG: 60e9})
    assert right[YOUNG].low < 70e9 < right[YOUNG].high
    assert not right.missed
    assert not right.sentences


def moved(**more):
    """What five loads move, at loads that are rounded as those of a balance are; the case has one load step."""
    loads = np.array([0.0, 0.25, 0.5, 0.75, 1.00004])
    about = {"place": "strip.end", "direction": "z", **more}
    known = strip({"equilibrium": {"load_factors": [0.0, 0.25, 0.5, 0.75, 1.0]}})
    clean = vr.StaticRecord(loads, np.zeros(5), **about).predicted(run_case(known))
    return loads, clean + 2e-5 * np.random.default_rng(1).normal(size=5), about


def test_equilibria_are_those_at_the_measured_loads():
    """Bending at small loads is in proportion to them: E from the slope, w = F L^3 / (3 E I) and shear, alike."""
    loads, values, about = moved()
    fit = vr.identify(LOADED, vr.StaticRecord(loads, values, **about), {YOUNG: 60e9})
    assert fit[YOUNG].low < 70e9 < fit[YOUNG].high
    slope = float(np.polyfit(loads, values, 1)[0])
    bending = 0.4**3 / (3.0 * 0.02 * 0.003**3 / 12.0)
    assert fit[YOUNG].value == pytest.approx(bending / abs(slope), rel=3e-3)
    assert not fit.sentences


def test_loads_of_a_cell_are_noisy_repeat_and_begin_below_none():
    """300 readings of a pull, loads with 0.3 % of noise in steps of 0.5 mN: E is 70 GPa within its interval."""
    random = np.random.default_rng(4)
    true = np.linspace(0.0, 1.0, 300)
    known = strip({"equilibrium": {"load_factors": [0.0, 0.25, 0.5, 0.75, 1.0]}})
    about = {"place": "strip.end", "direction": "z"}
    clean = vr.StaticRecord(true, np.zeros(300), **about).predicted(run_case(known))
    loads = np.round((true + 0.003 * random.normal(size=300)) / 5e-4) * 5e-4
    assert loads.min() < 0.0
    assert len(np.unique(loads)) < 300
    case = strip({"equilibrium": {"load_factor": 1.01}})
    record = vr.StaticRecord(loads, clean + 2e-5 * random.normal(size=300), **about)
    fit = vr.identify(case, record, {YOUNG: 60e9}, profile=False)
    assert fit[YOUNG].low < 70e9 < fit[YOUNG].high < 1.002 * fit[YOUNG].low
    there = np.concatenate([true, true[::-1]])
    with pytest.raises(InputError, match="they go there and back: row 300 is the farthest"):
        vr.StaticRecord(there, there, **about)


@pytest.mark.parametrize(
    ("change", "words"), [(-1.0, "goes to the other side"), (1000.0, "times as far as the model")]
)
def test_sign_and_unit_of_what_a_load_moved_are_named(change, words):
    loads, values, about = moved()
    fit = vr.identify(
        LOADED, vr.StaticRecord(loads, change * values, **about), {YOUNG: (30e9, 60e9, 200e9)}, profile=False
    )
    assert told(fit, words)
    assert fit.missed == ["strip.end"]


@pytest.mark.parametrize("part", [0.1, 1.0])
def test_a_zero_of_static_loads_that_is_off_is_named_with_its_size(part):
    """By a tenth of the way a tenth of the modulus is wrong, and neighbours of so few points show nothing."""
    loads, values, about = moved()
    zero = part * float(np.ptp(values))
    fit = vr.identify(LOADED, vr.StaticRecord(loads, values + zero, **about), {YOUNG: 60e9}, profile=False)
    (sentence,) = told(fit, "give it unknown = ['offset']")
    found = float(sentence.split("an offset of its zero of ")[1].split(" m,")[0])
    assert found == pytest.approx(zero, abs=5e-5)
    record = vr.StaticRecord(loads, values + zero, **about, unknown=["offset"])
    right = vr.identify(LOADED, record, {YOUNG: 60e9}, profile=False)
    assert right[YOUNG].low < 70e9 < right[YOUNG].high
    assert not right.sentences


@pytest.mark.parametrize("part", [0.04, 0.0])
def test_a_loop_of_loading_and_unloading_is_named_with_its_size(part):
    """A loop of a parabola, told by its mean over the loads between."""
    loads = np.linspace(0.0, 1.0, 9)
    about = {"place": "strip.end", "direction": "z"}
    known = strip({"equilibrium": {"load_factors": loads.tolist()}})
    clean = vr.StaticRecord(loads, np.zeros(9), **about).predicted(run_case(known))
    noise = 1e-3 * abs(clean[-1]) * np.random.default_rng(1).normal(size=(2, 9))
    wide = part * clean[-1] * (1.0 - (2.0 * loads - 1.0) ** 2)
    pulls = [
        vr.StaticRecord(loads, clean + more + noise[k], **about, name=name)
        for k, (name, more) in enumerate((("up", 0.0), ("down", wide)))
    ]
    fit = vr.identify(LOADED, pulls, {YOUNG: 60e9}, profile=False)
    said = told(fit, "a loop of loading and unloading")
    assert bool(said) == bool(part)
    if part:
        size = float(said[0].split(" and by ")[1].split(" %")[0])
        inner = (1.0 - (2.0 * loads[1:-1] - 1.0) ** 2).mean()
        assert size == pytest.approx(100.0 * part * inner, rel=0.05)
    else:
        assert fit[YOUNG].low < 70e9 < fit[YOUNG].high


PULLS = {
    # a load that only takes up play moves nothing; a grip that settles moves by itself; a zero taken before the slack
    "play": lambda way, loads: np.interp(np.maximum(loads - 0.25, 0.0), loads, way),
    "settling": lambda way, loads: way + 0.3 * way[-1] * (1.0 - np.exp(-loads / 0.08)),
    "jump": lambda way, loads: way + 0.2 * way[-1] * (loads > 0.0),
}


@pytest.mark.parametrize("kind", PULLS)
def test_slack_at_the_start_of_a_pull_is_named_with_what_the_other_loads_tell(kind):
    """The loads that carry have E = 70 GPa; with the slack it comes out by up to 60 % wrong, with an interval."""
    loads = np.linspace(0.0, 1.0, 11)
    about = {"place": "strip.end", "direction": "z"}
    known = strip({"equilibrium": {"load_factors": loads.tolist()}})
    clean = vr.StaticRecord(loads, np.zeros(11), **about).predicted(run_case(known))
    noise = 2e-3 * abs(clean[-1]) * np.random.default_rng(1).normal(size=11)
    values = PULLS[kind](clean, loads) + noise
    fit = vr.identify(LOADED, vr.StaticRecord(loads, values, **about), {YOUNG: 60e9}, profile=False)
    assert not fit[YOUNG].low < 70e9 < fit[YOUNG].high
    (sentence,) = told(fit, "slack, or a grip that settles")
    part = float(sentence.split("each moves ")[1].split(" times")[0])
    assert fit[YOUNG].value / part == pytest.approx(70e9, rel=0.02)
    first = int(sentence.split(" loads of")[0].split()[-1]) if "loads of" in sentence else 1
    rest = vr.StaticRecord(loads[first:], values[first:], **about, unknown=["offset"])
    right = vr.identify(LOADED, rest, {YOUNG: 60e9}, profile=False)
    assert right[YOUNG].value == pytest.approx(70e9, rel=0.02)
    assert not right.sentences


def test_loads_in_kilograms_and_frequencies_in_radians_are_named():
    """A modulus takes up any factor of a unit: the start tells it."""
    loads, values, about = moved()
    small = vr.StaticRecord(loads / 9.80665, values, **about)
    fit = vr.identify(LOADED, small, {YOUNG: 69e9}, profile=False)
    assert fit[YOUNG].value == pytest.approx(70e9 / 9.80665, rel=0.01)
    assert told(fit, "the loads are in kg: give them in N")
    turns = 2.0 * np.pi * run_case(MODES).frequencies[:3] * np.array([1.001, 1.0, 0.999])
    fit = vr.identify(MODES, vr.ModesRecord(turns), {YOUNG: 68e9}, profile=False)
    assert told(fit, "are 6.37 times those of the model as it was at the start"), fit.sentences
    assert told(fit, "rad/s: divide them by 2 pi")


def test_loads_in_grams_are_refused_with_what_full_load_is():
    loads, values, about = moved()
    with pytest.raises(
        InputError, match=r"101\.976 of full_load = 1, and the equilibria go from 1 to 1; full_load is"
    ):
        vr.identify(LOADED, vr.StaticRecord(loads / 9.80665e-3, values, **about), {YOUNG: 60e9})


@pytest.fixture(scope="module")
def accelerance():
    found = np.asarray(run_case(SHAKEN).response(0, 0))
    rng = np.random.default_rng(0)
    return found + 0.003 * np.abs(found).max() * (rng.normal(size=12) + 1j * rng.normal(size=12))


OMEGA = 2j * np.pi * HERTZ


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            1.0 / OMEGA**2,
            "looks like the second integral (a displacement where the case has an acceleration)",
        ),
        (1.0 / OMEGA, "looks like the integral ("),
        (-1.0, "with the opposite sign"),
        (1.0 / 9.80665, "times the response of the model"),
        (np.exp(-1e-3 * OMEGA), "is what another delay would leave"),
        (None, "exp(-i omega t); give its conjugate"),
    ],
    ids=["receptance", "mobility", "sign", "in g", "delay", "conjugate"],
)
def test_kind_sign_size_and_delay_of_a_response_are_named(accelerance, change, words):
    values = np.conj(accelerance) if change is None else change * accelerance
    fit = vr.identify(SHAKEN, vr.ResponseRecord(HERTZ, values), {YOUNG: (55e9, 69e9, 90e9)}, profile=False)
    assert told(fit, words), fit.sentences


def test_a_response_of_another_unit_is_no_record_of_the_models(accelerance):
    record = vr.ResponseRecord(HERTZ, accelerance, unit="m/N")
    with pytest.raises(
        InputError, match=r"unit: m/N: the response of the model is in \(?m/s\^2\)?/N; name the output"
    ):
        vr.identify(SHAKEN, record, {YOUNG: 69e9})
    same = vr.ResponseRecord(HERTZ, accelerance, unit="m/s^2/N")
    assert len(same.predicted(run_case(SHAKEN))) == 2 * len(HERTZ)


LINES = np.linspace(2.0, 202.0, 401)


@pytest.fixture(scope="module")
def many_lines():
    """A response of 401 lines with its case: away from the peaks its integrals are below 1 % of noise."""
    settings = {"inputs": ["strip.end fz"], "outputs": ["strip.end az"], "frequencies": LINES.tolist()}
    case = strip({"response": {**settings, "about": "reference"}})
    return case, np.asarray(run_case(case).response(0, 0))


@pytest.mark.parametrize(
    ("power", "words"), [(2, "looks like the second integral"), (1, "looks like the integral"), (0, "")]
)
def test_the_kind_of_a_noisy_response_is_named_from_a_start_that_is_off(many_lines, power, words):
    """Peaks of the start are 7 % lower; in what the data do not explain nothing is sought for long."""
    case, clean = many_lines
    lines = LINES[:201:2]  # two peaks, each as narrow as in all of them
    values = clean[:201:2] / (2j * np.pi * lines) ** power
    noise = np.random.default_rng(0).normal(size=(2, len(lines)))
    values = values + 0.01 * np.abs(values).max() / np.sqrt(2.0) * (noise[0] + 1j * noise[1])
    fit = vr.identify(case, vr.ResponseRecord(lines, values), {YOUNG: 60e9, TIMES: 2e-4})
    assert bool(told(fit, "looks like")) == bool(words)
    assert bool(fit.missed) == bool(words)
    if words:
        assert told(fit, words)
        assert all("profile" not in one.how for one in fit.numbers.values())
    else:
        for name, true in ((YOUNG, 70e9), (TIMES, 1e-4)):
            assert fit[name].low < true < fit[name].high


def test_laws_are_compared_by_a_response(accelerance):
    record = vr.ResponseRecord(HERTZ, accelerance)
    fit = vr.identify(SHAKEN, record, {YOUNG: 69e9}, laws=["elastic", "kelvin_voigt"], profile=False)
    assert fit.laws[0].name == "kelvin_voigt"
    assert told(fit, "Excluded")


def test_a_number_at_its_bound_is_told_with_its_unit(accelerance):
    record = vr.ResponseRecord(HERTZ, accelerance)
    fit = vr.identify(SHAKEN, record, {YOUNG: (55e9, 60e9, 69e9)}, profile=False)
    assert told(fit, "youngs_modulus is at its bound 69 GPa: the data want it beyond")


def test_a_response_tells_modulus_time_gain_and_delay(accelerance):
    late = 2.5 * np.exp(-1e-3 * OMEGA) * accelerance
    record = vr.ResponseRecord(HERTZ, late, unknown=["gain", "delay"])
    fit = vr.identify(SHAKEN, record, {YOUNG: 69e9, TIMES: 2e-4})
    for name, true in ((YOUNG, 70e9), (TIMES, 1e-4), ("response.gain", 2.5), ("response.delay", 1e-3)):
        assert fit[name].low < true < fit[name].high, name
        assert fit[name].high - fit[name].low < 0.3 * true, name
    assert fit["response.delay"].unit == "s"
    assert not fit.sentences


def test_what_a_wrong_damping_leaves_of_a_response_is_no_noise(many_lines):
    """Neighbouring lines go together where the peak is as wide as the material of the case makes it, not the rod's."""
    case, clean = many_lines
    noise = np.random.default_rng(1).normal(size=(2, 401))
    record = vr.ResponseRecord(LINES, clean + 0.01 * np.abs(clean).max() * (noise[0] + 1j * noise[1]))
    wider = {**TRUE, "damping": {"shear_time": 2e-4, "bulk_time": 2e-4}}
    wrong = case_from_dict({**case.content, "materials": {"alloy": wider}})
    fit = vr.identify(wrong, record, {YOUNG: (65e9, 70e9, 75e9)}, profile=False)
    assert fit.missed == ["response"]
    assert told(fit, "goes together from one point to the next")
    right = vr.identify(case, record, {YOUNG: (65e9, 70e9, 75e9)}, profile=False)
    assert right.missed == []


def test_neighbours_of_independent_noise_are_not_called_alike():
    """Of 2000 sets of noise that is a hundred times larger in the middle 1 % are below 1 %, give or take 0.5 %."""
    rng = np.random.default_rng(2)
    size = np.concatenate([np.ones(30), np.full(40, 100.0), np.ones(30)])
    below = [neighbours_alike(np.tile(size, 2) * rng.normal(size=200), 2) < 0.01 for _ in range(2000)]
    assert 0.002 < np.mean(below) < 0.015


@pytest.mark.parametrize(("modulus", "time"), [(0.5, 3.0), (1.7, 0.3)])
def test_a_response_is_fitted_from_far_away(modulus, time):
    """Peaks are narrower than the lines, and none of the model's is over a measured one: the first cycles lead."""
    ported = {"inputs": ["strip.end fz"], "outputs": ["strip.end az"], "about": "reference"}
    hertz = np.arange(6.0, 130.0, 1.0)
    known = run_case(strip({"loads": [], "response": {**ported, "frequencies": hertz.tolist()}}))
    rng = np.random.default_rng(3)
    noise = rng.normal(size=len(hertz)) + 1j * rng.normal(size=len(hertz))
    values = known.response(0, 0) * (1.0 + 0.01 * noise)
    times = time * TRUE["damping"]["shear_time"]
    fit = vr.identify(
        strip({"loads": [], "response": {**ported, "band": [5.0, 130.0]}}),
        vr.ResponseRecord(hertz, values, name="tip"),
        {YOUNG: modulus * 70e9, TIMES: times},
    )
    assert fit.numbers[YOUNG].value == pytest.approx(70e9, rel=2e-3)
    assert fit.numbers[TIMES].value == pytest.approx(1e-4, rel=2e-2)

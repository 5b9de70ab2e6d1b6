"""A model before it is computed: checked, written as a case file; places, progress and results by one set of words."""

import numpy as np
import pytest

import viscorod as vr
from helpers.synthetic_results import rolled_up, swing
from viscorod.casefile.case import load_case, parse_case


def beam():
    model = vr.Model()
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.01, 0.01))
    section = vr.Rectangle(0.01, 0.02)
    model.add(
        "bar", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=rubber, elements=2, order=2)
    )
    model.add("tip", vr.Sphere(0.01, mass=0.02, centre=(0.3, 0, 0)))
    model.clamp("bar.start", motion={"uz": vr.Sine(2.0, 0.01)})
    model.attach("bar.end", "tip")
    model.force("bar.end", (0, 0, 1), time=vr.Ramp(0, 0.5), name="pull")
    return model


def test_a_check_has_what_the_command_prints():
    """The first mode of the bare bar is that of Euler, (1.8751/L)^2 sqrt(EI/rho A)/(2 pi), less a little for shear."""
    model = beam()
    model.attachments.clear()
    model.remove("tip")
    found = model.check()
    euler = 1.8751**2 / 0.3**2 * np.sqrt(1e6 * 0.01**2 / 12.0 / 1000.0) / (2.0 * np.pi)
    assert found.frequencies[0] == pytest.approx(euler, rel=0.01)
    assert "slowest mode" in repr(found)
    assert "First natural modes" in str(found)
    assert "Linear systems: " in str(found)
    assert "No warnings" in str(found)


def test_a_model_goes_to_a_file_and_back(tmp_path):
    model = beam()
    text = model.to_toml(tmp_path / "bar.toml", "simulate", duration="20 ms")
    case = load_case(tmp_path / "bar.toml")
    assert vr.Model.of(**case.description.parts()) == model
    assert case.settings.duration == pytest.approx(0.02)
    assert parse_case(text).description.rods["bar"] == model.rods["bar"]
    assert parse_case(model.to_toml()).kind == "equilibrium"


def test_what_no_file_can_hold():
    model = beam()
    model.force("bar.end", (1, 0, 0), time=lambda t: t)
    with pytest.raises(vr.InputError, match=r"loads\[1\]\.time.*Python function"):
        model.to_toml()
    with pytest.raises(vr.InputError, match="did you mean 'modes'"):
        beam().to_toml(analysis="mode")
    with pytest.raises(vr.InputError, match="did you mean duration"):
        beam().to_toml(analysis="simulate", durations=1)


def test_a_place_is_told_where_it_is_given():
    model = beam()
    for call, words in (
        (lambda: model.clamp("bra.end"), "Clamp.at: 'bra'.*did you mean 'bar'"),
        (lambda: model.force("bar.ned", (0, 0, 1)), "Force.at: 'bar.ned': a rod has no such point"),
        (lambda: model.force("bar@0.5", (0, 0, 1)), "only 0.3 m long"),
        (lambda: model.spring("tipp", stiffness={"ux": 1}), "Spring.at: 'tipp'.*did you mean 'tip'"),
        (lambda: model.drag("bra", density=1.0, width=0.1, coefficient_across=1.0), "Drag.rod: 'bra'"),
        (lambda: model.rest_strain("bra", (0,) * 6), "RestStrain.rod: 'bra'"),
    ):
        with pytest.raises(vr.InputError, match=words):
            call()
    assert (len(model.supports), len(model.loads), len(model.springs)) == (1, 1, 0)
    model.force("bar@150 mm", (0, 0, 1))
    assert str(model.place(model.loads[-1].at)) == "bar@0.15"


def test_progress_is_shown(capsys):
    model = beam()
    model.supports[0] = vr.Clamp("bar.start")
    model.equilibrium(progress=True)
    assert "load = 1 of 1" in capsys.readouterr().err
    model.equilibrium(progress=False)
    assert capsys.readouterr().err == ""
    with pytest.raises(vr.InputError, match="progress: 3: a function is needed"):
        model.equilibrium(progress=3)


def test_history_and_probe_take_the_same_words():
    run, held = vr.Run(swing()), vr.Equilibrium(rolled_up())
    times = [run.time[1], run.time[3]]
    whole = run.probe(["beam.end", "beam@0.1"], times)
    for quantity in whole:
        one = run.history(["beam.end", "beam@0.1"], quantity, times)
        np.testing.assert_array_equal(one.values, whole[quantity].values)
        alone = run.history("beam.end", quantity, times)
        np.testing.assert_array_equal(alone.values, whole[quantity].values[:, 0])
        only = run.probe(["beam.end", "beam@0.1"], times, quantity=quantity)
        assert list(only) == [quantity]
    along = run.history("beam", "position", s=[0.05, 0.1])
    np.testing.assert_array_equal(along.values, run.probe("beam", s=[0.05, 0.1])["position"].values)
    assert run.history("beam", "position", s="10 cm").dims == ("time", "axis")
    assert (
        held.history("rod.end" if "rod" in held.sites.rods else f"{held.sites.rods[0]}.end").dims[0]
        == "load_factor"
    )
    with pytest.raises(vr.InputError, match="did you mean 'velocity'"):
        run.history("beam.end", "velocty")
    with pytest.raises(vr.InputError, match="did you mean 'position'"):
        run.probe("beam.end", quantity="positions")


def test_times_and_arc_lengths_have_units():
    run = vr.Run(swing())
    np.testing.assert_array_equal(run.positions_at("100 ms"), run.positions_at(0.1))
    np.testing.assert_array_equal(run.history("beam@5 cm").values, run.history("beam@0.05").values)
    with pytest.raises(vr.InputError, match="time: '1 mm': this is a length, time needs a time"):
        run.snapshot("1 mm")
    with pytest.raises(vr.InputError, match=r"'3 s' is not an arc length \(this is a time"):
        run.history("beam@3 s")


def test_ratios_have_one_name():
    decay = vr.Run(swing()).decay("beam.end", "y")
    np.testing.assert_array_equal(decay.damping_ratios, decay.damping_ratio)


def test_what_a_file_holds_can_be_expected(tmp_path):
    vr.Run(swing()).save(tmp_path / "run.nc")
    run: vr.Run = vr.load(tmp_path / "run.nc", vr.Run)
    assert run.time[0] == 0.0
    with pytest.raises(vr.InputError, match="holds a Run and no Modes"):
        vr.load(tmp_path / "run.nc", vr.Modes)

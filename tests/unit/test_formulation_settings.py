"""What the formulations cannot do is refused by name, before anything is computed, with what to take instead."""

import pytest
from typer.testing import CliRunner

import viscorod as vr
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.json_schema import case_schema
from viscorod.cli.app import app
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.registry import FORMULATIONS, Formulation
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.integrators import INTEGRATORS

SECTION = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-3, 1e-3, 2e-3])


def rod():
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=SECTION, elements=1, order=3))
    return model


@pytest.mark.parametrize(
    ("given", "where", "instead"),
    [
        ({"damping": "linearised"}, "damping", "formulation = 'intrinsic'"),
        ({"dynamics": "linear"}, "dynamics", "formulation = 'intrinsic'"),
        ({"formulation": "intrinsic", "dynamics": "linear"}, "dynamics", "damping = 'linearised'"),
        (
            {"formulation": "intrinsic", "integrator": "generalized_alpha"},
            "integrator",
            "'radau' or 'midpoint', or formulation = 'geometric'",
        ),
        ({"formulation": "mixed"}, "formulation", "intrinsic"),
    ],
)
def test_settings_that_do_not_go_together(given, where, instead):
    model = rod()
    model.clamp("rod.start")
    with pytest.raises(vr.InputError) as refused:
        model.simulate(1.0, **given)
    assert where in str(refused.value)
    assert instead in str(refused.value)


def moved(model):
    model.clamp("rod.start", motion={"uy": vr.Sine(1.0)})


def driven(model):
    model.body_velocity("rod.start", ["v1"], velocity={"w3": 1.0})


def strained(model):
    model.strain("rod", [0, 0, 0, 1, 0, 0])


LINEAR = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}


@pytest.mark.parametrize(
    ("build", "given", "words"),
    [
        (moved, LINEAR, ("supports[0].motion", "clamp at rod.start", "dynamics = 'nonlinear'")),
        (driven, LINEAR, ("supports[0].velocity", "body_velocity at rod.start", "dynamics = 'nonlinear'")),
        (driven, {"integrator": "generalized_alpha"}, ("supports[0].kind", "'radau' or 'midpoint'")),
        (strained, {}, ("initial", "initial = 'reference'")),
    ],
)
def test_models_that_do_not_fit_are_refused_at_check_and_at_simulate(build, given, words):
    model = rod()
    build(model)
    settings = SimulateSettings(duration=1.0, **given)
    for call in (lambda: check(DiscreteModel.of(model), settings), lambda: model.simulate(1.0, **given)):
        with pytest.raises(vr.InputError) as refused:
            call()
        assert all(word in str(refused.value) for word in words)


def test_the_command_checks_the_analysis_too(tmp_path):
    """``viscorod check`` ends with the same message."""
    case = tmp_path / "case.toml"
    case.write_text(
        """
[rods.rod]
shape = "straight"
start = [0, 0, 0]
end = [1, 0, 0]
section = { shape = "stiffness", stiffness = [1e3, 1e3, 1e3, 1, 1, 1], inertia = [1, 1, 1, 1e-3, 1e-3, 2e-3] }

[[supports]]
kind = "body_velocity"
at = "rod.start"
fixed = ["v1", "v2", "v3"]

[simulate]
duration = 1.0
integrator = "generalized_alpha"
""",
        encoding="utf-8",
    )
    result = CliRunner().invoke(app, ["check", str(case), "-o", str(tmp_path)])
    assert result.exit_code != 0
    text = " ".join((result.output + (result.stderr or "")).split())
    assert "supports[0].kind" in text
    assert "'radau' or 'midpoint'" in text


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"fixed": ["ux"]}, "v1"),
        ({}, "holds nothing"),
        ({"fixed": ["v1"], "velocity": {"v1": 1.0}}, "both fixed and prescribed"),
        ({"velocity": {"w3": vr.TimeTable([0, 1, 1], [0, 0, 1])}}, "must not jump"),
        ({"velocity": 3.0}, "velocities"),
    ],
)
def test_wrong_body_velocities(given, word):
    with pytest.raises(vr.InputError, match=word):
        vr.VelocitySupport("rod.start", **given)


@pytest.mark.parametrize("value", [[1, 2, 3], "x", [float("nan")] * 6, 1.0])
def test_wrong_initial_strains(value):
    model = rod()
    with pytest.raises(vr.InputError, match=r"InitialStrain\.value"):
        model.strain("rod", value)


def test_a_strain_function_must_return_six_numbers():
    model = rod()
    model.strain("rod", lambda s: (s, 0, 0))
    with pytest.raises(vr.InputError, match="six"):
        model.simulate(0.1, initial="reference")


class Renamed(GeometricSystem):
    """The geometric formulation under another name: counts what it is asked for."""

    made = 0

    def __init__(self, problem):
        super().__init__(problem)
        type(self).made += 1


def test_a_formulation_is_known_once_it_is_registered(monkeypatch):
    """Settings, schema and motions take it; the numbers are those of the geometric formulation."""
    model = rod()
    model.gravity()
    given = {"initial": "reference", "time_step": 0.01}
    with pytest.raises(vr.InputError, match=r"formulation: 'own'.*give one of 'geometric', 'intrinsic'"):
        model.simulate(0.02, formulation="own", damping="own_damping", **given)
    monkeypatch.setitem(FORMULATIONS, ("own", "own_damping"), Formulation(Renamed))
    monkeypatch.setitem(
        INTEGRATORS, "radau", INTEGRATORS["radau"]._replace(formulations=("geometric", "own"))
    )
    words = case_schema()["definitions"]["simulate"]["properties"]
    assert words["formulation"]["enum"] == ["geometric", "intrinsic", "own"]
    assert words["damping"]["enum"] == ["full", "linearised", "own_damping"]
    assert "own" not in case_schema()["definitions"]["steady"]["properties"]["formulation"]["enum"]
    found = model.simulate(0.02, formulation="own", damping="own_damping", **given)
    assert Renamed.made == 1  # steps are tried again by the same
    assert found.data.attrs["formulation"] == "own"
    expected = model.simulate(0.02, **given)
    assert (found.data["position"].values == expected.data["position"].values).all()

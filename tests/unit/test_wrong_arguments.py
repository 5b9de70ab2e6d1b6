"""Every argument of every public function and class with values of wrong kinds: one message, or an answer."""

import copy
import inspect
import os
import pkgutil
import tomllib
from importlib import import_module

import numpy as np
import pytest

import viscorod as vr
from helpers.damaged_cases import CASES
from helpers.synthetic_results import rolled_up, swing
from viscorod.analyses.case_run import as_model
from viscorod.casefile.case import case_from_dict
from viscorod.model.fields.definition import Definition

WRONG = {
    "none": None,
    "true": True,
    "one": 1,
    "negative": -1,
    "fraction": 1.5,
    "nan": float("nan"),
    "infinite": float("inf"),
    "denormal": 5e-324,
    "empty text": "",
    "word": "x",
    "surrogate": "\ud800",
    "nul": "a\0b",
    "bytes": b"x",
    "empty list": [],
    "numbers": [1, 2],
    "words": ["x"],
    "nones": [None],
    "empty table": {},
    "table": {"a": 1},
    "object": object(),
    "beyond double precision": 10**400,
    "complex": 1j,
    "array": np.array([1.0, np.nan]),
    "array of text": np.array("x"),
}


@pytest.fixture(scope="module")
def model():
    case = copy.deepcopy(CASES["cantilever_swing"])
    for rod in case["rods"].values():
        rod |= {"elements": 1, "order": 2}
    return as_model(case_from_dict(case).description)


@pytest.fixture(scope="module")
def results():
    return {"run": vr.Run(swing(duration=2.0)), "equilibrium": vr.Equilibrium(rolled_up())}


FUNCTIONS = {
    "history": ("run", {"place": "beam.end", "quantity": "position"}),
    "joint": ("run", {"name": "x"}),
    "probe": ("run", {"places": "beam.end", "times": [0.1], "s": None}),
    "at": ("run", {"level": 0.1}),
    "decrement": ("run", {"place": "beam.end", "axis": "y", "rest": 0.0, "below": False}),
    "free_decay": ("run", {"place": "beam.end", "axis": "y"}),
    "snapshot": ("run", {"time": 0.1}),
    "positions_at": ("run", {"time": 0.1}),
    "rotations_at": ("run", {"time": 0.1}),
    "damping_validity": ("run", {"tolerance": 0.1}),
    "field": ("run", {"quantity": "position", "states": 0, "stations": None}),
    "save": ("run", {"path": "a.nc"}),
    "position": ("equilibrium", {"place": "beam.end"}),
    "displacement": ("equilibrium", {"place": "beam.end"}),
    "rotation": ("equilibrium", {"place": "beam.end"}),
    "special_points": ("equilibrium", {"kind": "limit_points"}),
}


def told(call, **arguments):
    """Let a call answer, or say in one message that can be printed what is wrong; anything else fails the test."""
    try:
        call(**arguments)
    except (vr.InputError, vr.SolveError) as error:
        message = str(error)
    else:
        return
    assert message.encode("utf-8")


@pytest.mark.parametrize("wrong", WRONG)
def test_methods_of_results(wrong, results, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, (kind, good) in FUNCTIONS.items():
        for argument in good:
            told(getattr(results[kind], name), **{**good, argument: copy.copy(WRONG[wrong])})


@pytest.mark.parametrize(
    ("method", "good"),
    [
        ("plot", {"path": "a.png", "place": "beam.end", "axis": "y"}),
        ("plot_energy", {"path": "a.png"}),
        ("animate", {"path": "a.gif", "fps": 1.0, "speed": 1.0}),
        ("save_paraview", {"path": "a.vtkhdf"}),
    ],
)
def test_what_writes_files(method, good, results, tmp_path, monkeypatch):
    """Wrong values of the options that decide what is written; a picture for each takes too long."""
    monkeypatch.chdir(tmp_path)
    for argument in good:
        for wrong in (
            "object",
            "surrogate",
            "nul",
            "bytes",
            "table",
            "array",
            "empty text",
            "denormal",
            "nan",
        ):
            with pytest.raises(vr.InputError, match=argument):
                getattr(results["run"], method)(**{**good, argument: WRONG[wrong]})


@pytest.mark.parametrize("wrong", WRONG)
def test_functions_of_the_package(wrong, results, model, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    value = WRONG[wrong]
    told(vr.load, path=value)
    told(vr.load_case, path=value)
    told(vr.Run, data=value)
    told(vr.sweep, case=value, values={"a": [1]})
    told(vr.sweep, case=case_from_dict(CASES["cantilever_swing"]), values=value, workers=1)
    told(vr.sweep, case=case_from_dict(CASES["cantilever_swing"]), values={"a": [1]}, workers=value)
    told(vr.sweep, case=case_from_dict(CASES["cantilever_swing"]), values={"a": [1]}, progress=value)
    told(vr.kelvin_voigt_fit, material=value)
    fit = vr.RelaxationModulus(1e6, [1e5], [0.1])
    for argument in ("band", "strain", "fit", "keep_modulus"):
        told(vr.kelvin_voigt_fit, material=fit, **{argument: value})
    told(vr.view, result=value, path="v.html")
    for argument in ("path", "frames", "megabytes"):
        if wrong not in ("true", "one", "fraction", "none"):
            told(vr.view, **{"result": results["equilibrium"], "path": "v.html", argument: value})


ANALYSES = {
    "equilibrium": {},
    "path": {"points": 2},
    "simulate": {"duration": 0.001, "time_step": 0.001},
    "modes": {},
    "steady": {"spin": [0.0, 0.0, 4.0]},
    "co_simulation": {},
}


@pytest.mark.parametrize("analysis", ANALYSES)
def test_settings_of_analyses(analysis, model, tmp_path, monkeypatch):
    """They are refused before anything is computed, so that only wrong ones are tried."""
    monkeypatch.chdir(tmp_path)
    method = getattr(model, analysis)
    for argument in inspect.signature(method).parameters:
        for wrong in (
            "object",
            "surrogate",
            "nul",
            "bytes",
            "nones",
            "complex",
            "beyond double precision",
            "nan",
        ):
            if (argument, wrong) in {("title", "nan")} or argument == "self":
                continue
            with pytest.raises(vr.InputError) as caught:
                method(**{**ANALYSES[analysis], argument: WRONG[wrong]})
            assert argument in str(caught.value)
            str(caught.value).encode("utf-8")


@pytest.mark.parametrize(
    ("argument", "value", "words"),
    [
        ("progress", 1, "a function is needed"),
        ("progress", lambda: 0, "cannot be called with 2 arguments"),
        ("stop", 1, "a function is needed"),
        ("stop", lambda reached: "", "cannot be called with 0 arguments"),
        ("folder", 5, "a path is needed"),
        ("folder", "a\0b", "no file can have this name"),
        ("folder", "", "the path is empty"),
        ("resume", "yes", "True or False"),
        ("title", "\ud800", "cannot be written"),
        ("title", 5, "a text is needed"),
        ("start", "\ud800", "no file can have this name"),
    ],
)
def test_options_of_a_call_name_what_they_need(argument, value, words, model, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(vr.InputError, match=words) as caught:
        model.simulate(duration=0.001, **{argument: value})
    assert str(caught.value).startswith(argument)
    assert not os.listdir(tmp_path)


def described():
    """All classes of the model that a user can make."""
    import viscorod.model

    for module in pkgutil.walk_packages(viscorod.model.__path__, "viscorod.model."):
        import_module(module.name)
    found, waiting = [], [Definition]
    while waiting:
        kinds = waiting.pop().__subclasses__()
        waiting += kinds
        found += [
            kind
            for kind in kinds
            if kind.__module__.startswith("viscorod.model.") and not inspect.isabstract(kind)
        ]
    found = [kind for kind in found if kind.__name__[0] != "_" and kind is not vr.FunctionOfTime]
    return sorted(set(found), key=lambda kind: kind.__name__)


@pytest.mark.parametrize("kind", described())
def test_fields_of_descriptions(kind):
    for field in kind.model_fields:
        for value in WRONG.values():
            told(kind, **{field: copy.copy(value)})


@pytest.mark.parametrize("wrong", WRONG)
def test_co_simulation(wrong, model):
    coupled = model.co_simulation(ports=["beam.end"])
    value = copy.copy(WRONG[wrong])
    for argument in ("port", "force", "moment"):
        told(coupled.apply, **{"port": "beam.end", argument: value})
    for method in (coupled.position, coupled.velocity, coupled.frame, coupled.angular_velocity):
        told(method, place=value)
    told(coupled.restore, state=value)
    if wrong not in ("true", "one", "fraction"):
        told(coupled.step, duration=value)


def usual():
    """Arguments of functions of ``viscorod.programs`` by their names; any other is a number."""
    line = vr.Straight([0, 0, 0], [0, 0, 1.0])
    material = vr.Material(youngs_modulus=1e6, poissons_ratio=0.3, density=1000.0)
    stiffness = np.eye(6)
    return {
        "rod": vr.Rod(line, vr.Rectangle(0.01, 0.01), material),
        "stations": [0.0, 1.0],
        "stiffness": stiffness,
        "damping": 0.1 * stiffness,
        "law": 0.1 * stiffness,
        "times": [0.1] * 6,
        "pieces": 2,
        "elements": 2,
        "poissons_ratio": 0.3,
    }


PROGRAMS = [
    name
    for name in vr.programs.__all__
    if callable(getattr(vr.programs, name)) and not inspect.isclass(getattr(vr.programs, name))
]


@pytest.mark.parametrize("name", PROGRAMS)
def test_functions_for_other_programs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function = getattr(vr.programs, name)
    known = usual()
    needed = {
        key: known.get(key, 1.0)
        for key, parameter in inspect.signature(function).parameters.items()
        if parameter.default is inspect.Parameter.empty
    }
    for argument in inspect.signature(function).parameters:
        for value in WRONG.values():
            told(function, **{**needed, argument: copy.copy(value)})


LEAST = 5e-324


@pytest.mark.parametrize(
    "build",
    [
        lambda x: vr.Material(youngs_modulus=x, poissons_ratio=0.3, density=1.0),
        lambda x: vr.Material(youngs_modulus=1.0, poissons_ratio=0.3, density=x),
        lambda x: vr.KelvinVoigt(shear_time=x, bulk_time=0.0),
        lambda x: vr.Rectangle(x, 1.0),
        vr.Circle,
        lambda x: vr.Straight([0, 0, 0], [x, 0, 0]),
        lambda x: vr.StiffnessSection([x, 1, 1, 1, 1, 1], [1] * 6),
        lambda x: vr.StiffnessSection([1] * 6, [1, 1, 1, 1, 1, x]),
        lambda x: vr.StiffnessSection([1] * 6, [1] * 6, damping=[x, 0, 0, 0, 0, 0]),
        lambda x: vr.StiffnessSection([1] * 6, [1] * 6, times=[x, 0, 0, 0, 0, 0]),
        lambda x: vr.Force("beam.end", [0, x, 0]),
        lambda x: vr.Gravity([0, 0, x]),
        lambda x: vr.Sphere(mass=x, radius=1.0),
        lambda x: vr.LineSpring("a.end", "b.end", stiffness=x),
        lambda x: vr.Prony([x], [1.0], youngs_modulus=1.0, poissons_ratio=0.3),
    ],
)
def test_numbers_below_any_quantity_are_refused(build):
    """Denormal numbers have no inverse: they gave infinite times and frequencies."""
    with pytest.raises(vr.InputError, match=r"smaller than any quantity|outside what is allowed") as caught:
        build(LEAST)
    assert "4.9" in str(caught.value) or "5e-324" in str(caught.value)


def test_the_case_file_says_the_same():
    content = tomllib.loads("youngs_modulus = 5e-324\npoissons_ratio = 0.3\ndensity = 1000.0")
    case = copy.deepcopy(CASES["cantilever_swing"])
    name = next(iter(case["materials"]))
    case["materials"][name] = content
    with pytest.raises(vr.InputError, match=rf"materials\.{name}\.youngs_modulus.*smaller than any quantity"):
        case_from_dict(case)


def test_values_without_names_beyond_the_last_are_refused_by_what_can_be_named() -> None:
    """`history` takes a quantity second, `probe` takes it by name: the other way round is told, not tried."""
    beam = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=vr.Material(1e9, 0.3, 1000.0)
    )
    model = vr.Model()
    model.add("beam", beam)
    model.clamp("beam.start")
    still = model.equilibrium()
    said = r"probe: 'displacement': at most 1 can be given without their names: places; write the name .* quantity = "
    with pytest.raises(vr.InputError, match=said):
        still.probe("beam.end", "displacement")
    with pytest.raises(vr.InputError, match="at most 2 can be given without their names"):
        still.history("beam.end", "position", 0.5)

"""What is said about the variables of results, against data sets of every kind that the solvers make."""

from pathlib import Path

import pytest

import viscorod as vr
from viscorod.results.data_schema import DIMENSION, DIMENSIONS, FRAMES, PLACES, STATES, VARIABLES

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "data.md"
STIFFNESS = [50.0, 50.0, 90.0, 1.0, 2.0, 1.0]
INERTIA = [1.0, 1.0, 1.0, 0.01, 0.01, 0.02]


def clamped(*, loaded=True, **section):
    model = vr.Model()
    section = vr.StiffnessSection(STIFFNESS, INERTIA, **section)
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3))
    model.clamp("beam.start")
    if loaded:
        model.force("beam.end", (0, 0.1, 0.02))
    return model


def in_a_medium():
    model = clamped()
    model.drag("beam", linear_across=0.1, coefficient_across=1.2, density=1.2, width=0.1)
    return model


def assembled():
    model = clamped()
    model.add("plate", vr.Body.box((1.1, 0, 0), (0.2, 0.1, 0.1), density=10.0, points={"tip": (1.2, 0, 0)}))
    model.revolute("plate", "beam.end", (0, 1, 0), stiffness={"rz": 1.0}, damping={"rz": 0.01})
    model.line_spring("plate.tip", (1.2, 0, 0.8), stiffness=5.0, damping=0.1)
    return model


RESULTS = {
    "motion": lambda: clamped(damping=[1e-3 * value for value in STIFFNESS]).simulate(0.02),
    "bodies and joints": lambda: assembled().simulate(0.02),
    "Maxwell branches": lambda: clamped(
        branches=[{"time": 0.05, "stiffness": [0.1 * value for value in STIFFNESS]}]
    ).simulate(0.02),
    "drag": lambda: in_a_medium().simulate(0.02),
    "intrinsic": lambda: clamped().simulate(0.02, formulation="intrinsic"),
    "equilibrium": lambda: clamped().equilibrium(),
    "path": lambda: clamped().path(load_factor=0.5),
    "steady": lambda: clamped(loaded=False).steady(spin=(0.0, 0.0, 0.5)),
    "modes": lambda: clamped().modes(3),
}
BROUGHT = {
    "motion": "dissipation",
    "bodies and joints": "joint_force",
    "Maxwell branches": "branch_loss",
    "drag": "outside",
    "path": "negative_eigenvalues",
    "steady": "eigenvalue",
    "modes": "mode_error",
}


@pytest.mark.parametrize("kind", RESULTS)
def test_every_variable_is_documented_as_it_is(kind):
    data = RESULTS[kind]().data
    along = DIMENSION[data.attrs["kind"]]
    assert BROUGHT.get(kind, "position") in data
    for name, variable in data.variables.items():
        if variable.dims == (name,) and name != along:
            assert name in PLACES, name  # words of a dimension
            continue
        assert name in VARIABLES, f"{name} is in no table of the reference"
        assert variable.dims == tuple(along if word == STATES else word for word in DIMENSIONS[name]), name
        assert variable.attrs.get("units", "") == VARIABLES[name][0], name
        assert variable.attrs["long_name"] == VARIABLES[name][1], name
    assert {*data.dims} <= {*PLACES, along}


def test_tables_speak_of_the_same_variables():
    assert set(DIMENSIONS) == set(VARIABLES)
    assert set(FRAMES) <= set(VARIABLES)
    used = {word for dims in DIMENSIONS.values() for word in dims}
    assert used <= {*PLACES, STATES, *DIMENSION.values()}
    for name, dims in DIMENSIONS.items():
        if set(dims) & {"axis", "quaternion", "component"}:
            assert name in FRAMES, f"in which axes is {name}?"


def rows_below(heading):
    """Rows of the table below a heading of the page: name -> cells."""
    text = PAGE.read_text(encoding="utf-8").partition(heading)[2].partition("\n## ")[0]
    return {
        name.strip(" `"): [cell.strip() for cell in row.strip("|").split("|")[1:]]
        for row in text.splitlines()
        if row.startswith("| `")
        for name in row.strip("|").split("|")[0].split(",")
    }


def test_what_probe_gives_is_on_the_page():
    found = clamped().simulate(0.02).probe("beam.end")
    rows = rows_below("What `probe` gives")
    assert set(rows) == set(found)
    for name, (dims, unit, *_) in rows.items():
        assert tuple(word.strip(" `") for word in dims.split(",") if word) == found[name].dims[2:], name
        if name not in ("strain", "section_force"):  # one unit for each component there
            assert unit == found[name].attrs["units"], name


def test_what_stress_gives_is_on_the_page():
    model, rubber = vr.Model(), vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.01, 0.01))
    given = {"section": vr.Circle(0.01), "material": rubber, "elements": 2, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), **given))
    model.clamp("beam.start")
    found = model.simulate(0.02).stress("beam.end")
    rows = rows_below("What `stress` gives")
    assert set(rows) == {*found, *(name for name in found.coords if name not in found.dims)}
    for name, (dims, unit, _) in rows.items():
        words = tuple(word.strip(" `") for word in dims.split(","))
        assert words == tuple("states" if word == "time" else word for word in found[name].dims), name
        assert unit == found[name].attrs["units"], name

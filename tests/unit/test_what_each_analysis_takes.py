"""The table of what each analysis takes (docs/howto/choose_formulation.md) against what the code refuses."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import viscorod as vr

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "choose_formulation.md"
LINEARISED = {"formulation": "intrinsic", "damping": "linearised"}
C = [1e3, 1e3, 1e3, 1.0, 1.0, 1.0]
M = [1.0, 1.0, 1.0, 1e-2, 1e-2, 2e-2]
SPIN = {"spin": (1.0, 0, 0)}


def moved(model, **settings):
    model.simulate(1e-3, initial="reference", tolerance=1e-4, **settings)


ANALYSES = {
    "statics, paths": lambda model: (model.equilibrium(), model.path(load_factor=0.1)),
    "modes": lambda model: model.modes(2, about="reference"),
    "motion, geometric": moved,
    "motion, intrinsic": lambda model: moved(model, formulation="intrinsic"),
    "motion, intrinsic, linearised damping": lambda model: moved(model, **LINEARISED),
    "linear dynamics": lambda model: moved(model, dynamics="linear", **LINEARISED),
    "steady rotation": lambda model: model.steady(**SPIN, modes=2),
    "steady rotation, intrinsic": lambda model: model.steady(**SPIN, modes=2, formulation="intrinsic"),
    "motion in modes": lambda model: moved(model, formulation="intrinsic", modes=2),
}
BRANCH = vr.MaxwellBranch(time=0.1, stiffness=C)


def bodies(model):
    model.add("disc", vr.Body(1.0, (1, 1, 1), centre=(1, 0, 0)))
    model.attach("disc", "rod.end")


def joints(model):
    model.add("other", rod((1, 0, 0), (2, 0, 0)))
    model.ball("rod.end", "other.start")
    model.support("other.end", ("uy", "uz", "rx"))


def springs(model):
    model.spring("rod.end", stiffness={"uy": 1.0, "uz": 1.0}, damping={"uy": 0.1, "uz": 0.1})


def moving(model):
    model.supports.clear()
    model.clamp("rod.start", motion={"uy": vr.Sine(1.0, 1e-3)})


def nothing(model):
    del model


# fields of the rod and of its section, and what is added to the model
FEATURES = {
    "bodies": ({}, {}, bodies),
    "joints": ({}, {}, joints),
    "springs and dampers": ({}, {}, springs),
    "held strains": ({"constraints": "kirchhoff"}, {}, nothing),
    "Maxwell branches": ({}, {"branches": [BRANCH]}, nothing),
    "laws of sections": ({"law": vr.CubicBending(2.0)}, {}, nothing),
    "drag": ({}, {}, lambda model: model.drag("rod", linear_across=0.1)),
    "supports and motors that move": ({}, {}, moving),
}


def rod(start, end, **more):
    given = {"section": vr.StiffnessSection(C, M), "elements": 1, "order": 2} | more
    return vr.Rod.straight(start, end, **given)


def table():
    """Return the cells by row and column, and the marks that are explained."""
    text = PAGE.read_text(encoding="utf-8").split("## What each analysis takes")[1].split("\n## ")[0]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in text.splitlines()
        if line.startswith("|")
    ]
    head, *body = (row for row in rows if not set(row[0]) <= set("-"))
    cells = {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in body if len(row) == len(head)}
    return cells, {row[0] for row in body if len(row) == 2}


CELLS, MARKS = table()


def test_the_table_has_all_rows_columns_and_reasons():
    assert set(CELLS) == set(FEATURES)
    assert all(list(row) == list(ANALYSES) for row in CELLS.values())
    marks = {
        re.fullmatch(r"no \((\w)\)", cell)[1]
        for row in CELLS.values()
        for cell in row.values()
        if cell != "yes"
    }
    assert marks == MARKS - {""}


@pytest.mark.parametrize("feature", FEATURES)
def test_cells_are_what_the_code_does(feature):
    """Refused cells raise, and all others are computed."""
    of_rod, of_section, add = FEATURES[feature]
    for analysis, compute in ANALYSES.items():
        model = vr.Model()
        model.add("rod", rod((0, 0, 0), (1, 0, 0), section=vr.StiffnessSection(C, M, **of_section), **of_rod))
        model.clamp("rod.start")
        model.force("rod.end", (1e-3, 0, 0), following=True)
        add(model)
        if CELLS[feature][analysis] == "yes":
            compute(model)
        else:
            with pytest.raises(vr.InputError):
                compute(model)

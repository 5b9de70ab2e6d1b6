"""Supports: what they hold, in which axes, and what is refused."""

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.actions.time_function import Ramp, Until
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import Place
from viscorod.model.connections.support import Clamp, Guide, Pin, Roller, Support, support

NODE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""Frame of a rod along x: d1 = y, d2 = z, d3 = x."""


def resolve(given):
    return given.resolve("supports[0]", Place("beam", 0.0), NODE)


@pytest.mark.parametrize(
    ("given", "fixed"),
    [
        (Clamp("beam.start"), MOTIONS),
        (Pin("beam.start"), MOTIONS[:3]),
        (Guide("beam.start"), MOTIONS[1:]),
        (Roller("beam.start", (0, 1, 0)), ("ux",)),
        (Support("beam.start", ["rz", "ux"]), ("ux", "rz")),
    ],
)
def test_fixed_motions(given, fixed):
    found = resolve(given)
    assert found.fixed == found.held == fixed
    assert found.motion == {}
    assert found.path == "supports[0]"
    assert found.label == f"{given.kind} at beam.start"


def test_a_moved_component_is_not_fixed():
    found = resolve(Clamp("beam.start", motion={"rz": Ramp(0, 1), "ux": 0.2}))
    assert found.fixed == ("uy", "uz", "rx", "ry")
    assert list(found.motion) == ["ux", "rz"]
    assert found.held == MOTIONS
    assert found.motion["ux"].value(3.0) == 0.2


def test_axes():
    clamp, node = resolve(Clamp("beam.start")), resolve(Support("beam.start", ["ux"], frame="node"))
    assert clamp.frame == "global"
    assert (clamp.axes == np.eye(3)).all()
    assert node.frame == "node"
    assert (node.axes == NODE).all()


def test_guide_slides_along_the_tangent_unless_told_otherwise():
    along_rod = resolve(Guide("beam.start"))
    assert along_rod.frame == "axes"
    assert along_rod.axes == pytest.approx(np.eye(3))
    told = resolve(Guide("beam.start", (0, 3, 4)))
    assert told.axes[:, 0] == pytest.approx([0, 0.6, 0.8])
    assert told.axes.T @ told.axes == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(told.axes) == pytest.approx(1.0)


def test_own_axes():
    found = resolve(Support("beam.start", ["uy"], axes=[(0, 2, 0), (0, 0, 3)]))
    assert found.frame == "axes"
    assert found.axes == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]))


def test_a_table_without_kind_is_a_general_support():
    assert support({"at": "beam.end", "fixed": ["uz"]}) == Support("beam.end", ["uz"])


def test_all_that_is_wrong_with_motions_is_told_with_their_words():
    """A word that is no motion is told beside the unknown and missing keys of the others."""
    with pytest.raises(InputError) as caught:
        Clamp("beam.end", motion={"ux": {"kind": "ramp", "begin": 0.0}, "uv": {"kind": "table"}, "rz": "x"})
    told = {problem.where: problem.why for problem in caught.value.problems}
    missing = "this key is required and missing"
    assert told == {
        "Clamp.motion.ux.begin": "no such key",
        "Clamp.motion.ux.start": missing,
        "Clamp.motion.ux.end": missing,
        "Clamp.motion.uv": "not a motion",
        "Clamp.motion.rz": "a function of time is needed here",
    }


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Clamp("beam end"), "Clamp.at", "not a place"),
        (lambda: Clamp("beam.end.end"), "Clamp.at", "not a place"),
        (lambda: Clamp("ground"), "Clamp.at", "the ground is not a place"),
        (lambda: Clamp(3), "Clamp.at", "text is needed"),
        (lambda: Clamp("beam@x"), "Clamp.at", "not a number"),
        (lambda: Clamp("beam@-1"), "Clamp.at", ">= 0"),
        (lambda: Clamp("beam@1e999"), "Clamp.at", "finite"),
        (lambda: Clamp("beam.end", motion={"rw": 1.0}), "Clamp.motion.rw", "not a motion"),
        (lambda: Clamp("beam.end", motion={"rx": {"kind": "rampp"}}), "Clamp.motion.rx.kind", "'ramp'"),
        (lambda: Clamp("beam.end", motion={"rx": Until(1.0)}), "Clamp.motion.rx", "must not jump"),
        (
            lambda: Clamp("beam.end", motion={"rx": lambda t: t}),
            "Clamp.motion.rx",
            "velocity and acceleration",
        ),
        (lambda: Clamp("beam.end", motion=[1]), "Clamp.motion", "table of motions"),
        (lambda: Pin("beam.end", motion={"rx": 1.0}), "Pin.motion.rx", "does not hold rx"),
        (lambda: Guide("beam.end", motion={"ux": 1.0}), "Guide.motion.ux", "does not hold ux"),
        (lambda: Guide("beam.end", (0, 0, 0)), "Guide.along", "no direction"),
        (lambda: Roller("beam.end"), "Roller.normal", "missing"),
        (lambda: Support("beam.end"), "Support.fixed", "holds nothing"),
        (lambda: Support("beam.end", ["ux", "ux"]), "Support.fixed[1]", "twice"),
        (lambda: Support("beam.end", ["u"]), "Support.fixed[0]", "did you mean"),
        (lambda: Support("beam.end", "ux"), "Support.fixed", "list"),
        (
            lambda: Support("beam.end", ["ux"], motion={"ux": 1.0}),
            "Support.motion.ux",
            "both fixed and prescribed",
        ),
        (lambda: Support("beam.end", ["ux"], frame="nod"), "Support.frame", "did you mean 'node'"),
        (lambda: Support("beam.end", ["ux"], axes=[(1, 0, 0), (1, 1, 0)]), "Support.axes", "perpendicular"),
        (lambda: Support("beam.end", ["ux"], "node", [(1, 0, 0), (0, 1, 0)]), "Support.axes", "either"),
        (lambda: support({"kind": "clmap", "at": "beam.end"}), "kind", "did you mean 'clamp'"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=text) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead

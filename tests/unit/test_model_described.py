"""The base of the user's objects, the texts of its errors, and the settings built on it."""

import numpy as np
import pytest

from viscorod.errors import Fault, InputError
from viscorod.model.actions.initial_velocity import InitialVelocity
from viscorod.model.bodies.body_shapes import Sphere
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import Definition, path_text, show, some_of
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Number, Positive
from viscorod.model.materials.material import Material
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings
from viscorod.wording import nearest


class Inner(Definition):
    width: Positive = Key("", "m")
    height: Positive = Key("", "m")


class Outer(Definition):
    inner: Inner
    factor: Number = 1.0


def test_arguments_by_position_and_by_name():
    assert Inner(1, 2) == Inner(1.0, height=2.0) == Inner(width=1, height=2)
    assert Outer(Inner(1, 2), 3).factor == 3.0


def test_nested_tables_keep_their_paths():
    with pytest.raises(InputError, match=r"^Outer\.inner\.height: -2: "):
        Outer({"width": 1, "height": -2})
    with pytest.raises(InputError, match=r"^Outer\.inner: 3: a table of keys and values is needed here"):
        Outer(3)


def test_a_misspelt_key_explains_the_missing_one():
    with pytest.raises(InputError) as caught:
        Inner(1, hieght=2)
    (problem,) = caught.value.problems
    assert str(problem) == (
        "Inner.hieght: 2: no such key; did you mean height? The keys here are width, height"
    )


def test_a_missing_key_is_told_with_its_unit():
    with pytest.raises(
        InputError, match=r"Inner\.height: this key is required and missing; add height \(number > 0, m\)"
    ):
        Inner(1)


def test_several_problems_are_listed():
    with pytest.raises(InputError) as caught:
        Inner(-1, True, depth=3)
    assert len(caught.value.problems) == 3
    assert str(caught.value).startswith("3 problems\n  - ")


def test_frozen_and_written_without_defaults():
    outer = Outer(Inner(1, 2))
    assert outer.to_dict() == {"inner": {"width": 1.0, "height": 2.0}}
    with pytest.raises(ValueError, match="frozen"):
        outer.factor = 2.0


def test_paths():
    assert path_text(("loads", 0, "value", 2)) == "loads[0].value[2]"
    assert path_text(("rods", "a b")) == "rods.'a b'"


def test_nearest():
    assert nearest("densty", ["density", "damping"]) == "density"
    assert nearest("Density", ["density"]) == "density"
    assert nearest("xyz", ["density"]) is None


def test_values_are_shown_briefly():
    assert show(True) == "true"
    assert len(show("x" * 1000)) < 80
    assert len(show(list(range(1000)))) < 80
    assert "300 digits" in show(10**5000)
    nested: list = []
    for _ in range(100_000):
        nested = [nested]
    assert len(show(nested)) < 80
    for _ in range(99_999):  # take it apart, level by level, so that no recursion is needed
        nested = nested[0]


def test_errors_from_texts_and_problems():
    assert str(InputError("no good")) == "no good"
    problem = Fault("a", "1", "too small", "give 2")
    assert str(InputError(problem, heading="x.toml")) == "x.toml: a: 1: too small; give 2"
    assert problem.within("b").where == "b.a"
    assert problem.within("b[0]").where == "b[0].a"


def test_settings_of_a_simulation():
    settings = SimulateSettings(10)
    assert (settings.duration, settings.time_step, settings.initial) == (10.0, None, "equilibrium")
    assert SimulateSettings(10, 0.1, initial="reference").to_dict() == {
        "duration": 10.0,
        "time_step": 0.1,
        "initial": "reference",
    }


@pytest.mark.parametrize(
    ("build", "path"),
    [
        (lambda: SimulateSettings(0), "SimulateSettings.duration"),
        (lambda: SimulateSettings(-1), "SimulateSettings.duration"),
        (lambda: SimulateSettings(float("nan")), "SimulateSettings.duration"),
        (lambda: SimulateSettings(1, 2), "SimulateSettings.time_step"),
        (lambda: SimulateSettings(1, 0), "SimulateSettings.time_step"),
        (lambda: SimulateSettings(1, initial="rest"), "SimulateSettings.initial"),
        (lambda: SimulateSettings(1, integrator="euler"), "SimulateSettings.integrator"),
        (lambda: SimulateSettings(1, spectral_radius=1.1), "SimulateSettings.spectral_radius"),
        (lambda: SimulateSettings(1, output_interval=2), "SimulateSettings.output_interval"),
        (lambda: EquilibriumSettings(0), "EquilibriumSettings.load_steps"),
        (lambda: EquilibriumSettings(1.5), "EquilibriumSettings.load_steps"),
    ],
)
def test_wrong_settings(build, path):
    with pytest.raises(InputError) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


def test_many_names_are_counted():
    names = [f"rod_{k}" for k in range(40)]
    assert some_of(names[:3]) == "rod_0, rod_1, rod_2"
    assert some_of(names[:12]).endswith(", rod_11")
    assert some_of(iter(names)).endswith(", rod_11 and 28 more")


@pytest.mark.parametrize(
    ("make", "former", "present"),
    [
        (PathSettings, {"turns": 2}, {"limit_point": 2}),
        (lambda **given: SteadySettings((0, 0, 4), **given), {"about": (1, 0, 0)}, {"centre": (1, 0, 0)}),
        (lambda **given: InitialVelocity("rod", **given), {"about": (1, 0, 0)}, {"point": (1, 0, 0)}),
    ],
    ids=["path", "steady", "velocity"],
)
def test_former_names_of_keys_are_understood_with_a_warning(make, former, present):
    """Contract: the names of version 0.1 work; beside the present name the former one is unknown."""
    with pytest.warns(DeprecationWarning, match=f"{next(iter(former))} is now {next(iter(present))}"):
        assert make(**former) == make(**present)
    with pytest.raises(InputError, match="no such key"):
        make(**former, **present)


def test_former_names_of_arguments_are_understood_with_a_warning():
    model = ModelDescription()
    model.add("rod", Sphere(0.1, density=1000.0))
    model.velocity("rod", angular=(0, 0, 1), point=(1, 0, 0))
    with pytest.warns(DeprecationWarning, match="about is now point") as warned:
        model.velocity("rod", angular=(0, 0, 1), about=(1, 0, 0))
    assert [warning.filename for warning in warned] == [__file__]  # where Python shows it
    assert model.velocities[0] == model.velocities[1]


@pytest.mark.parametrize(
    ("key", "meant"),
    [("youngs_moduls", "youngs_modulus"), ("poisons_ratio", "poissons_ratio"), ("modulus", "shear_modulus")],
)
def test_an_unknown_key_is_compared_with_those_that_are_given_too(key, meant):
    """A misspelt name beside the right one, as in the numbers of a sweep, is that name, not the next best free one."""
    with pytest.raises(InputError, match=f"did you mean {meant}\\?"):
        Material(1e6, 0.3, 1000.0, **{key: 2.0})


def test_numbers_of_numpy_in_tuples_are_shown_as_numbers():
    with pytest.raises(InputError, match=r"position: \(0.1, 0, \[1.0, 2.0\]\): no such key"):
        Sphere(0.1, density=1000.0, position=(np.float64(0.1), 0, np.array([1.0, 2.0])))

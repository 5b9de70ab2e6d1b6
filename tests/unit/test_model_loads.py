"""Loads and initial velocities: factors in time, and what is refused."""

import numpy as np
import pytest
from pydantic import ValidationError

import viscorod as vr
from viscorod.errors import InputError
from viscorod.model.actions.initial_velocity import InitialVelocity
from viscorod.model.actions.load import DistributedForce, Drag, Force, Gravity, Moment, MovingForce, load
from viscorod.model.actions.time_function import Ramp, Until
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.model.sections.stiffness_section import StiffnessSection


def test_factor_is_one_without_a_function_of_time():
    force = Force("beam.end", (1, 2, 3))
    assert force.factor(-5.0) == force.factor(5.0, before=True) == 1.0
    assert force.breakpoints == force.jumps == ()


def test_a_load_held_until_it_is_let_go():
    force = Force("beam.end", (0, 1, 0), until=0.0)
    assert (force.factor(-1.0), force.factor(0.0, before=True), force.factor(0.0)) == (1.0, 1.0, 0.0)
    assert force.jumps == force.breakpoints == (0.0,)


def test_factor_is_the_function_until_it_ends():
    force = Force("beam.end", (0, 1, 0), time=Ramp(0.0, 4.0), until=2.0)
    assert [force.factor(t) for t in (-1.0, 1.0, 2.0, 3.0)] == [0.0, 0.25, 0.0, 0.0]
    assert force.factor(2.0, before=True) == 0.5
    assert force.breakpoints == (0.0, 2.0)
    assert force.jumps == (2.0,)


def test_no_jump_where_the_function_has_ended_by_itself():
    force = Force("beam.end", (0, 1, 0), time=TimeTable([0, 1, 2], [0, 1, 0]), until=3.0)
    assert force.jumps == ()
    assert force.breakpoints == (0.0, 1.0, 2.0, 3.0)


def test_python_functions_and_numbers_scale_a_load():
    assert Moment("beam.end", (1, 0, 0), time=lambda t: 3 * t).factor(2.0) == 6.0
    assert Gravity(time=0.5).factor(1.0) == 0.5
    assert Gravity().acceleration == (0.0, 0.0, -9.81)


def test_density_of_distributed_loads():
    assert DistributedForce("beam", (1, 2, 3)).density(0.7) == pytest.approx([1, 2, 3])
    load_ = DistributedForce("beam", lambda s: (0, s, 0), True, from_s=0.1, to_s=0.2)
    assert load_.density(0.15) == pytest.approx([0, 0.15, 0])
    assert (load_.from_s, load_.to_s) == (0.1, 0.2)
    with pytest.raises(InputError, match=r"at s = 0.1 m: 3 numbers"):
        DistributedForce("beam", lambda s: (0, s)).density(0.1)


def test_moving_forces():
    even = MovingForce("beam", (0, 0, -1), speed=2.0, start=0.5)
    assert even.arc_length(3.0) == 6.5
    told = MovingForce("beam", (0, 0, -1), position=Ramp(1.0, 2.0, 4.0), until=1.5)
    assert told.arc_length(1.5) == 2.0
    assert told.breakpoints == (1.0, 1.5, 2.0)


def test_rigid_initial_velocity():
    velocity = InitialVelocity("rod", (1, 0, 0), (0, 0, 2), point=(1, 0, 0))
    linear, angular = velocity.at(0.3, np.array([1.0, 3.0, 5.0]))
    assert linear == pytest.approx([1 - 6, 0, 0])
    assert angular == pytest.approx([0, 0, 2])


def test_initial_velocity_as_a_function():
    velocity = InitialVelocity("rod", field=lambda s: ((s, 0, 0), (0, 1, 0)))
    linear, angular = velocity.at(0.3, np.zeros(3))
    assert linear == pytest.approx([0.3, 0, 0])
    assert angular == pytest.approx([0, 1, 0])
    with pytest.raises(InputError, match="return two vectors"):
        InitialVelocity("rod", field=lambda s: 3).at(0.3, np.zeros(3))


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Force("beam.end", (1, 2)), "Force.value", "3 numbers"),
        (lambda: Force("beam.end", (1, 2, float("nan"))), "Force.value[2]", "finite"),
        (lambda: Force("beam.end", 3.0), "Force.value", "list"),
        (lambda: Force("beam.end"), "Force.value", "missing"),
        (lambda: Force("beam.end", (1, 2, 3), 1), "Force.following", "true or false"),
        (lambda: Force("beam.end", (1, 2, 3), until="0"), "Force.until", "number"),
        (lambda: Force("beam.end", (1, 2, 3), until=-1.0), "Force.until", ">= 0"),
        (lambda: Force("beam.end", (1, 2, 3), time="ramp"), "Force.time", "function of time"),
        (lambda: Force("beam.end", (1, 2, 3), tme=Until(1)), "Force.tme", "did you mean time"),
        (lambda: DistributedForce("a beam", (1, 2, 3)), "DistributedForce.rod", "as a name"),
        (
            lambda: DistributedForce("beam", (1, 2, 3), from_s=1.0, to_s=1.0),
            "DistributedForce.to_s",
            "positive length",
        ),
        (lambda: DistributedForce("beam", (1, 2, 3), from_s=-1.0), "DistributedForce.from_s", ">= 0"),
        (lambda: Gravity((0, 0)), "Gravity.acceleration", "3 numbers"),
        (lambda: MovingForce("beam", (1, 2, 3)), "MovingForce", "either a speed or a position"),
        (
            lambda: MovingForce("beam", (1, 2, 3), 1.0, Ramp(0, 1)),
            "MovingForce",
            "either a speed or a position",
        ),
        (
            lambda: MovingForce("beam", (1, 2, 3), None, Ramp(0, 1), 0.1),
            "MovingForce.start",
            "leave start out",
        ),
        (lambda: Drag("beam"), "Drag", "without any coefficient"),
        (lambda: Drag("beam", linear_across=-1.0), "Drag.linear_across", ">= 0"),
        (
            lambda: Drag("beam", linear_across=1.0, density=1.2),
            "Drag.density",
            "goes with a drag coefficient",
        ),
        (lambda: Drag("beam", coefficient_across=1.0, width=0.1), "Drag.density", "needs the density"),
        (lambda: Drag("beam", coefficient_along=1.0, density=1.0), "Drag.width", "needs the width"),
        (lambda: Drag("beam", linear_along=1.0, velocity=(1, 0)), "Drag.velocity", "3 numbers"),
        (lambda: Drag("beam", linear_along=1.0, time=Ramp(0.0, 1.0, -1.0)), "Drag.time", "negative at"),
        (lambda: Drag("beam", linear_about=1.0, from_s=1.0, to_s=0.5), "Drag.to_s", "positive length"),
        (lambda: InitialVelocity("rod", (1, 0, 0), field=lambda s: s), "InitialVelocity", "both"),
        (lambda: InitialVelocity("rod", angular=(1, 0)), "InitialVelocity.angular", "3 numbers"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=text) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


def test_load_tables():
    assert load({"kind": "gravity"}) == Gravity()
    with pytest.raises(InputError, match="did you mean 'force'"):
        load({"kind": "forse"})
    with pytest.raises(InputError, match="kind = one of"):
        load({"at": "beam.end"})
    with pytest.raises(ValidationError):  # nested tables keep their paths for the reader of the file
        load({"kind": "force", "at": "beam.end"})


def test_arrows_of_drag_are_what_the_medium_does_to_the_shape_at_rest():
    """Normal and tangential parts of k |u| u by hand on a rod along x; a medium at rest does nothing."""
    model = ModelDescription()
    model.add("beam", Rod.straight((0, 0, 0), (1, 0, 0), section=StiffnessSection([1] * 6, [1] * 6)))
    wind = Drag(
        "beam", coefficient_across=1.5, density=2.0, width=0.1, linear_along=0.3, velocity=(2.0, 3.0, 4.0)
    )
    drawn = wind.arrows(model, 0.0)
    assert drawn.values == pytest.approx(np.tile([0.6, 0.15 * 5.0 * 3.0, 0.15 * 5.0 * 4.0], (9, 1)))
    assert not Drag("beam", linear_across=1.0).arrows(model, 0.0).values.any()


@pytest.mark.parametrize(
    ("start", "speed"), [(None, -1.0), (0.0, -1.0), (0.4, 1.0), (0.3, 1.0), (0.4, 0.0), (-0.1, 0.0)]
)
def test_a_moving_force_that_is_never_on_its_rod_is_refused(start, speed):
    def loaded(start, speed):
        model = vr.Model()
        steel = vr.Material(2e11, 0.3, 7850.0)
        model.add("bar", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Circle(0.01), material=steel))
        model.clamp("bar.start")
        model.moving_force("bar", (0, 0, -1.0), speed=speed, start=start)
        return model

    with pytest.raises(InputError, match=r"speed: .*never on the rod bar, which is 0.3 m long") as caught:
        loaded(start, speed).validate()
    assert "leads onto it" in caught.value.problems[0].instead
    for good in ((0.0, 1.0), (0.3, -1.0), (-1.0, 1.0), (0.5, -1.0), (0.1, 0.0)):
        loaded(*good).validate()

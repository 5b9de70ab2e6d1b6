"""Motions that loads and strains leave free: each is listed once, at 0 Hz, whatever round-off makes of them."""

import numpy as np
import pytest
import scipy.linalg

import viscorod as vr


@pytest.mark.parametrize("below", [0.0, 0.1])
def test_a_body_on_two_strings_swings_as_a_double_pendulum(below: float) -> None:
    """Closed form: a massless string of length l, a body of radius of gyration k at a distance d below its end.

    ``[[l^2, l d], [l d, d^2 + k^2]] x'' + g [[l, 0], [0, d]] x = 0`` across the plane of the strings. With d = 0 the
    turn about the line of both ends is neutral: it stood twice in the list, as "swing 1" at 1.6e-8 Hz.
    """
    mass, g, half = 2.0, 9.81, (0.5, 0.1, 0.1)
    light = vr.Material(1e9, 0.3, 1e-3, damping=vr.KelvinVoigt(0.01, 0.01))
    model = vr.Model()
    places = {"left": (-0.5, 0, below), "right": (0.5, 0, below)}
    model.add("body", vr.Box(tuple(2.0 * size for size in half), mass=mass, points=places))
    for name, (x, y, z) in places.items():
        string = vr.Rod.straight(
            (x, y, z + 1.0), (x, y, z), section=vr.Circle(0.002), material=light, elements=1
        )
        model.add(name, string)
        model.pin(f"{name}.start")
        model.ball(f"{name}.end", f"body.{name}")
    model.gravity()
    modes = model.modes(7)
    length = 1.0 + 0.5 * mass * g / (1e9 * np.pi * 0.002**2)
    gyration = (half[1] ** 2 + half[2] ** 2) / 3.0
    inertia = np.array([[length**2, length * below], [length * below, below**2 + gyration]])
    squares = scipy.linalg.eigh(g * np.diag([length, below]), inertia, eigvals_only=True)
    neutral = 3 if below == 0.0 else 2  # the twists of the strings are free
    assert modes.rigid == neutral
    assert (modes.frequencies[:neutral] == 0.0).all()
    wanted = np.sqrt(squares[squares > 1e-9]) / (2.0 * np.pi)
    for frequency in wanted:
        assert np.abs(modes.frequencies / frequency - 1.0).min() < 1e-6
    assert len(set(modes.names)) == len(modes.names)
    assert (modes.frequencies[neutral:] > 0.1).all()


def test_a_hinge_whose_stiffness_is_round_off_turns_freely():
    """Linear motions about the reference shape are those of the other formulation, to second order of the turn.

    A stiffness of 1e-53 passed for a number to divide by, and the search for modes ended in an error of LAPACK.
    """
    model = vr.Model()
    held = ("shear_1", "shear_2", "stretch")
    material = vr.Material(70e9, poissons_ratio=0.3, density=2700.0)
    section = vr.Rectangle(0.02, 0.02)
    bar = vr.Rod.straight(
        (0, 0, 0), (0, 0, -1), section=section, material=material, elements=2, constraints=held, d1=(0, 1, 0)
    )
    model.add("bar", bar)
    model.revolute("bar.start", "ground", (0, 1, 0))
    model.force("bar.end", (3.0, 0, 0))
    moved = []
    for settings in ({"formulation": "intrinsic", "dynamics": "linear", "damping": "linearised"}, {}):
        run = model.simulate(0.004, initial="reference", **settings)
        moved.append(float(run.history("bar.end", "displacement").sel(axis="x")[-1]))
    assert moved[0] == pytest.approx(moved[1], rel=1e-4)


@pytest.mark.parametrize("mesh", [{"elements": 2, "order": 5}, {"elements": 8, "order": 5}])
def test_a_round_rod_that_is_pinned_has_its_bending_on_every_mesh(mesh):
    """Closed form: 15.4182 sqrt(EI/rhoA)/L^2 of a bar that is pinned and free, which hardly turns.

    That it may spin about itself has a root of round-off alone. A finer mesh was asked for motions near that and had
    nothing else, so that errors of the mesh were told to be 100 %.
    """
    model = vr.Model()
    steel = vr.Material(2e11, 0.3, 7850.0)
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=steel, **mesh))
    model.pin("bar.start")
    found = model.campbell(axis=(0, 0, 1), speeds=(0.1, 0.2), modes=2)
    bending = 15.4182 * np.sqrt(2e11 / 7850.0) * 0.0025 / (2.0 * np.pi)
    assert found.frequencies[0] == pytest.approx([bending, bending], rel=5e-4)  # shear takes 1e-4
    assert found.data["mesh_error"].values.max() < 1e-3


@pytest.mark.parametrize("hinged", ["support", "joint"])
def test_a_blade_that_flaps_rigidly_swings(hinged):
    """A hinge on the axis: a rigid blade flaps about once a turn; round-off named that "twist 1"."""
    model = vr.Model()
    alu = vr.Material(7e10, 0.3, 2700.0)
    section = vr.Rectangle(0.3, 0.03)
    blade = vr.Rod.straight(
        (0, 0, 0), (5, 0, 0), section=section, d1=(0, 1, 0), material=alu, elements=4, order=4
    )
    model.add("blade", blade)
    if hinged == "support":
        model.support("blade.start", ("ux", "uy", "uz", "rx", "rz"))
    else:
        model.add("hub", vr.Box((0.1, 0.1, 0.1), mass=1.0))
        model.clamp("hub")
        model.revolute("blade.start", "hub", (0, 1, 0))
    turning = model.campbell(axis=(0, 0, 1), speeds=(5.0, 10.0), modes=2)
    names = [str(name) for name in turning.modes]
    assert names == ["swing 1", "bend_1 1"]
    thick = (
        0.03**2 / 12.0 / (5.0**2 / 3.0)
    )  # what the height adds to one moment of inertia, and not to the other
    once = np.sqrt((1.0 - thick) / (1.0 + thick))
    assert turning.frequencies[:, 0] * 2.0 * np.pi == pytest.approx([5.0 * once, 10.0 * once], rel=1e-8)
    steady = model.steady(spin=(0, 0, 10.0), modes=2)
    assert list(steady.modes.names) == names

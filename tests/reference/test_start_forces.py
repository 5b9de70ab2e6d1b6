"""Forces of joints, held strains and supports at the instant a motion starts, and within the first step.

They follow from the accelerations there. Closed forms of a rigid uniform bar: of mass m and inertia J about the hinge
at its end, it turns with the acceleration M/J under the moment M of what is applied about the hinge, and the forces
there and in every section are what the parts beyond lack to their accelerations.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

G = 9.81
SIDE, DENSITY = 0.02, 2700.0
MASS = DENSITY * SIDE**2  # [kg], of a metre
ROTARY = MASS * SIDE**2 / 12.0
INERTIA = MASS / 3.0 + ROTARY
RIGID = ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")
METHODS = {
    "radau": {"tolerance": 1e-6},
    "intrinsic": {"formulation": "intrinsic", "tolerance": 1e-6},
    "midpoint": {"integrator": "midpoint", "time_step": 1e-3},
    "generalized_alpha": {"integrator": "generalized_alpha", "time_step": 1e-3},
}
every_method = pytest.mark.parametrize("settings", METHODS.values(), ids=METHODS)


def bar(tilt: float, constraints: tuple[str, ...] = RIGID, order: int = 5) -> vr.Model:
    """A bar of one metre that hangs from the origin, tilted towards x [rad]."""
    material = vr.Material(youngs_modulus=70e9, poissons_ratio=0.3, density=DENSITY)
    rod = vr.Rod.straight(
        (0, 0, 0),
        (np.sin(tilt), 0, -np.cos(tilt)),
        section=vr.Rectangle(SIDE, SIDE),
        material=material,
        d1=(0, 1, 0),
        elements=2,
        order=order,
        constraints=constraints,
    )
    model = vr.Model()
    model.add("bar", rod)
    return model


def axial(run: vr.Run) -> np.ndarray:
    """Axial forces at the Gauss points, of all instants."""
    return np.asarray(run.data["section_force"].values[:, :, 2])


def at_points(run: vr.Run) -> np.ndarray:
    """Arc lengths of the Gauss points."""
    return np.asarray(run.data["point_s"].values)


@every_method
def test_released_bar(settings: dict) -> None:
    """Tension m g (1 - s) cos(tilt), and m g sin(tilt) (1 - m/4J) across at the hinge: m g/4 of a thin level bar."""
    for tilt in (0.5, 0.5 * np.pi):
        model = bar(tilt)
        model.revolute("bar.start", "ground", (0, 1, 0), name="hinge")
        model.gravity()
        run = model.simulate(0.004, initial="reference", **settings)
        wanted = MASS * G * (1.0 - at_points(run)) * np.cos(tilt)
        assert axial(run)[0] == pytest.approx(wanted, rel=1e-10, abs=1e-10)
        across = MASS * G * np.sin(tilt) * (1.0 - 0.25 * MASS / INERTIA)
        force = np.linalg.norm(run.joint("hinge")["force"].values[:, :3], axis=1)
        assert force[0] == pytest.approx(np.hypot(across, MASS * G * np.cos(tilt)), rel=1e-10)
        assert force == pytest.approx(force[0], rel=1e-4)  # the angle changes by 5e-5 rad
    assert across == pytest.approx(MASS * G / 4.0, rel=1e-3)


@every_method
def test_support_that_leaves_rotations_free(settings: dict) -> None:
    model = bar(0.5 * np.pi)
    model.pin("bar.start")
    model.gravity()
    run = model.simulate(0.004, initial="reference", **settings)
    across = MASS * G * (1.0 - 0.25 * MASS / INERTIA)
    assert run.data["reaction"].values[0, 0, :3] == pytest.approx((0.0, 0.0, across), abs=1e-10)


@every_method
def test_spinning_bar(settings: dict) -> None:
    """Tension rho A w^2 (1 - s^2)/2 from the start on, which velocities alone cause."""
    spin = 7.0
    model = bar(0.0, ("shear_1", "shear_2", "stretch"))
    model.revolute("bar.start", "ground", (0, 1, 0))
    model.velocities.append(vr.InitialVelocity("bar", angular=(0, spin, 0)))
    run = model.simulate(0.004, initial="reference", **settings)
    wanted = 0.5 * MASS * spin**2 * (1.0 - at_points(run) ** 2)
    assert axial(run)[0] == pytest.approx(wanted, rel=1e-10)
    assert axial(run) == pytest.approx(np.tile(wanted, (len(run.time), 1)), rel=1e-4)


@every_method
def test_hinge_on_what_moves(settings: dict) -> None:
    """A support sets off with the acceleration A: J a = -m/2 (g sin + A cos), and the hinge exerts m times that."""
    tilt, quick = 0.3, 0.1 * (2.0 * np.pi) ** 2
    model = bar(tilt)
    material = vr.Material(youngs_modulus=70e9, poissons_ratio=0.3, density=DENSITY)
    cart = vr.Rod.straight(
        (0, 0, 0), (0, 0.2, 0), section=vr.Rectangle(SIDE, SIDE), material=material, constraints=RIGID
    )
    model.add("cart", cart)
    back = vr.Sine(1.0, amplitude=0.1, phase=0.5 * np.pi, offset=-0.1)
    model.clamp("cart.start", motion={"ux": back})
    model.revolute("bar.start", "cart.start", (0, 1, 0), name="hinge")
    model.gravity()
    run = model.simulate(0.004, initial="reference", **settings)
    turn = 0.5 * MASS * (quick * np.cos(tilt) - G * np.sin(tilt)) / INERTIA
    along, up = -quick + 0.5 * turn * np.cos(tilt), 0.5 * turn * np.sin(tilt)
    force = np.linalg.norm(run.joint("hinge")["force"].values[0, :3])
    assert force == pytest.approx(MASS * np.hypot(along, G + up), rel=1e-9)
    later = np.linalg.norm(run.joint("hinge")["force"].values[:, :3], axis=1)
    assert later == pytest.approx(
        force, rel=2e-3
    )  # in 4 ms the acceleration falls by 3e-4, and the angle changes
    reaction = run.data["reaction"].values[0, 0, :3]
    wanted = MASS * along - 0.2 * MASS * quick, 0.0, MASS * (G + up) + 0.2 * MASS * G
    assert reaction == pytest.approx(wanted, rel=1e-9, abs=1e-9)


@every_method
def test_motor_that_starts_to_turn(settings: dict) -> None:
    """Its moment is J times the acceleration that it prescribes, and the bar pulls with m w^2/2."""
    model, rate = bar(0.0), 2.0 * np.pi
    swing = vr.Sine(1.0, amplitude=0.3, phase=0.25 * np.pi, offset=-0.3 * np.sin(0.25 * np.pi))
    model.revolute("bar.start", "ground", (0, 1, 0), name="motor", motion={"rz": swing})
    spin, quick = (0.3 * rate**k * np.sin(0.25 * np.pi) for k in (1, 2))
    model.velocities.append(vr.InitialVelocity("bar", angular=(0, spin, 0)))
    run = model.simulate(0.004, initial="reference", **settings)
    force = run.joint("motor")["force"].values[0]
    assert abs(force[5]) == pytest.approx(INERTIA * quick, rel=1e-9)
    moments = np.abs(run.joint("motor")["force"].values[:, 5])
    assert moments == pytest.approx(INERTIA * quick, rel=0.03)  # cos(2 pi 4 ms)
    assert np.linalg.norm(force[:3]) == pytest.approx(0.5 * MASS * np.hypot(spin**2, quick), rel=1e-9)


@every_method
def test_start_from_the_equilibrium(settings: dict) -> None:
    """What rests needs no acceleration: held strains have the forces of statics."""
    model = bar(0.5 * np.pi, ("shear_1", "shear_2", "stretch"))
    model.clamp("bar.start")
    model.gravity()
    wanted = model.equilibrium().data["section_force"].values[-1]
    found = model.simulate(0.004, **settings).data["section_force"].values
    largest = np.abs(wanted).max()
    assert found[0] == pytest.approx(wanted, abs=1e-8 * largest)
    assert found == pytest.approx(np.tile(wanted, (len(found), 1, 1)), abs=1e-4 * largest)


@every_method
def test_within_the_first_steps_and_after_a_jump(settings: dict) -> None:
    """The hinge of a pendulum, which a force leaves after 10 ms, against its equation of motion by another program."""
    from scipy.integrate import solve_ivp

    push, until = 5.0, 0.01
    model = bar(0.5)
    model.revolute("bar.start", "ground", (0, 1, 0), name="hinge")
    model.force("bar.end", (push, 0, 0), time=vr.Until(until))
    model.gravity()
    run = model.simulate(0.02, initial="reference", output_interval=2.5e-4, **settings)

    def turning(y: np.ndarray, push: float) -> np.ndarray:
        return (push * np.cos(y[0]) - 0.5 * MASS * G * np.sin(y[0])) / INERTIA

    times, start, done = np.asarray(run.time), [0.5, 0.0], []
    for part, begin, now in ((times <= until, 0.0, push), (times > until, until, 0.0)):
        some = times[part]
        given = {"t_eval": some, "rtol": 1e-11, "atol": 1e-12}
        found = solve_ivp(lambda _, y, f=now: [y[1], turning(y, f)], (begin, some[-1]), start, **given)
        (angle, speed), quick = found.y, turning(found.y, now)
        start = found.y[:, -1]
        along = 0.5 * (quick * np.cos(angle) - speed**2 * np.sin(angle))
        up = 0.5 * (quick * np.sin(angle) + speed**2 * np.cos(angle))
        done.append(np.hypot(MASS * along - now, MASS * (G + up)))
    wanted = np.concatenate(done)
    force = np.linalg.norm(run.joint("hinge")["force"].values[:, :3], axis=1)
    assert force == pytest.approx(wanted, abs=1e-5 * wanted.max())


def test_midpoint_rule_has_forces_of_second_order() -> None:
    """Against Radau IIA: those of the middle of a step alone would lag by half a step, and be of first order."""
    model = bar(1.2, order=2)
    model.revolute("bar.start", "ground", (0, 1, 0), name="hinge")
    model.gravity()
    kept = {"initial": "reference", "output_interval": 0.02}
    exact = model.simulate(0.3, tolerance=1e-9, **kept)
    errors = []
    for step in (0.004, 0.002):
        run = model.simulate(0.3, integrator="midpoint", time_step=step, **kept)
        errors.append(
            [
                np.abs(axial(run) - axial(exact)).max(),
                np.abs((run.joint("hinge")["force"] - exact.joint("hinge")["force"]).values).max(),
            ]
        )
    order = np.log2(np.divide(*errors))
    assert order == pytest.approx(2.0, abs=0.1)


def test_reactions_by_the_midpoint_rule_are_of_second_order() -> None:
    """A soft bar swings on a support that leaves one turn free; beside radau at 1e-8, halved steps err by a quarter.

    They had accelerations of the middle of a step, of first order, and 1.4e-2, 3.4e-3 and 1.8e-3 N here for steps of
    4, 2 and 1 ms.
    """
    material = vr.Material(1e9, 0.3, 1000.0, damping=vr.KelvinVoigt(1e-3, 1e-3))
    line = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=3
    )
    model = vr.Model()
    model.add("bar", line)
    model.support("bar.start", ("ux", "uy", "uz", "rx", "rz"))
    model.gravity((0, 0, -G))
    exact = model.simulate(0.3, initial="reference", tolerance=1e-8, output_interval=4e-3, errors=False)
    late = exact.time > 0.15  # what the sudden weight set off has faded
    errors = []
    for step in (4e-3, 2e-3):
        run = model.simulate(0.3, initial="reference", integrator="midpoint", time_step=step, errors=False)
        same = np.searchsorted(run.time, exact.time[late] - 1e-9)
        gap = run.data["reaction"].values[same, 0, :3] - exact.data["reaction"].values[late, 0, :3]
        errors.append(np.abs(gap).max())
    assert errors[0] < 3e-3
    assert errors[1] < 0.3 * errors[0]

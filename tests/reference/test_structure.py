"""Structure tests E1 to E7: what must hold whatever the numbers are (E1 and E4 at element level: tests/unit)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import methods, stiff


def coupled(damping=None):
    stiffness = np.diag([800.0, 700.0, 2e3, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 10.0
    inertia = np.diag([1.0, 1.0, 1.0, 1e-2, 2e-2, 3e-2])
    inertia[0, 5] = inertia[5, 0] = -0.05  # off-centre mass
    inertia[2, 3] = inertia[3, 2] = 0.05
    return vr.StiffnessSection(stiffness, inertia, None if damping is None else damping * stiffness)


def free_rod(damping=None, order=3):
    model = vr.Model()
    model.add(
        "rod",
        vr.Rod.helix(0.3, 0.4, 1.0, section=coupled(damping), elements=4, order=order, twist=1.0),
    )
    return model


@methods(1e-8, 0.005, without={"intrinsic": "momentum is kept to the order of the mesh: test_intrinsic"})
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # equal steps, coarse ones
def test_free_flight_conserves_momentum(method):
    """E2: damped, tumbling, vibrating, off-centre mass: momenta to round-off, the tolerance, or second order."""
    model = free_rod(damping=0.005)
    model.velocity("rod", field=lambda s: ((np.sin(3 * s), 1.0, s), (2.0, s, -1.0)))
    run = model.simulate(1.0, initial="reference", **method)
    # the midpoint rule was measured to lose 1.41 h^2 at h = 0.01, 0.005, 0.0025 and 0.00125
    second_order = 2.0 * method.get("time_step", 0.0) ** 2
    drift = {"radau": 4e-8, "generalized_alpha": 1e-11, "midpoint": second_order}[method["integrator"]]
    for name in ("linear_momentum", "angular_momentum"):
        value = run.data[name].values
        assert np.abs(value - value[0]).max() < drift * np.linalg.norm(value[0])
    assert run.data["viscous"].values[-1] > 0


@methods(1e-6, 0.02)
def test_rigid_spin_is_not_damped(method):
    """E1 in motion: a free straight rod spinning about a principal axis, strongly viscous. Only the slow growth of the
    centrifugal stretch is damped, so the spin's energy stays."""
    model = vr.Model()
    model.add(
        "rod",
        vr.Rod.straight(
            (-0.5, 0, 0), (0.5, 0, 0), section=stiff(1e6, 1e6, 1e3, 1e3, damping=0.5), elements=1, order=4
        ),
    )
    model.velocity("rod", angular=(0, 0, 2.0))
    run = model.simulate(10.0, initial="reference", **method)
    kinetic = run.data["kinetic"].values
    assert kinetic[-1] == pytest.approx(kinetic[0], rel=1e-5)
    assert run.data["viscous"].values[-1] < 1e-5 * kinetic[0]
    turned = run.history("rod.end", "position").values[-1]
    assert turned[:2] == pytest.approx([0.5 * np.cos(20), 0.5 * np.sin(20)], abs=3e-3)


@pytest.mark.parametrize("damping", [None, 0.01])
@pytest.mark.parametrize(
    "methods",
    [
        [{"integrator": "radau", "tolerance": tolerance} for tolerance in (1e-5, 1e-6)],
        [{"integrator": "generalized_alpha", "time_step": h} for h in (0.0005, 0.00025)],
    ],
    ids=["radau", "generalized_alpha"],
)
def test_energy_is_accounted_for(damping, methods):
    """E3: T + W + D = const without loads, the remainder falling with the step or the tolerance; D never decreases."""
    remainders = []
    for method in methods:
        model = free_rod(damping)
        model.velocity("rod", field=lambda s: ((0.0, np.sin(4 * s), 0.5), (0.0, 0.5, 1.0)))
        run = model.simulate(0.2, initial="reference", **method)
        remainders.append(run.energy.numerical_fraction)
        assert np.all(np.diff(run.data["viscous"].values) >= 0)
    assert remainders[1] < 2e-3
    assert remainders[1] < remainders[0] / 2.5


@methods(1e-5, 0.005)
def test_work_of_loads_and_supports_closes_the_account(method):
    """E3 with everything that does work: gravity, dead, following and moving loads, a driven clamp."""
    model = free_rod(damping=0.01)
    model.clamp("rod.start", motion={"rz": vr.Sine(0.7, amplitude=0.5), "ux": vr.Sine(0.4, amplitude=0.1)})
    model.gravity((0, 0, -2.0))
    model.force("rod.end", (0.3, 0, 0), following=True, time=vr.Ramp(0.0, 0.5))
    model.moment("rod@0.7", (0.0, 0.1, 0.05), time=vr.Sine(1.0))
    model.moving_force("rod", (0, 0.2, 0), speed=1.5)
    model.distributed_force("rod", (0.1, 0.1, 0), following=True, from_s=0.4, to_s=1.1)
    run = model.simulate(1.5, **method)
    assert abs(run.energy.external[-1]) > 0.01
    assert run.energy.numerical_fraction < 2e-3


@methods(
    1e-6,
    0.1,
    spectral_radius=0.5,
    without={"intrinsic": "its equilibrium differs by the error of the mesh: test_intrinsic"},
)
def test_slow_loading_ends_in_the_static_equilibrium(method):
    """E6: a load applied over many periods of the damped rod; statics and dynamics share one residual."""

    def model():
        rod = free_rod(damping=0.1)
        rod.clamp("rod.start")
        return rod

    static = model()
    static.force("rod.end", (0.05, 0.1, 0.2))
    expected = static.equilibrium()
    slow = model()
    slow.force("rod.end", (0.05, 0.1, 0.2), time=vr.TimeTable([0, 40], [0, 1], "cubic"))
    run = slow.simulate(120.0, initial="reference", **method)
    assert run.history("rod.end").values[-1] == pytest.approx(expected.position("rod.end"), abs=1e-6)
    reaction = run.data["reaction"].values[-1, 0]
    assert reaction == pytest.approx(expected.reactions.values[0], abs=1e-5)
    assert reaction[:3] == pytest.approx([-0.05, -0.1, -0.2], abs=1e-5)


@pytest.mark.filterwarnings(
    "ignore:steps .* is not the material's"
)  # what is left of the damping is the question
@methods(1e-8, 0.01, without={"midpoint": "frequencies that it does not resolve hide the small damping"})
def test_vanishing_viscosity_is_the_elastic_run(method):
    """E7: the difference to the undamped run falls in proportion to tau, once tau omega of all modes is small.

    Radau follows modes that generalised-alpha damps anyway.
    """
    times = (1e-7, 1e-8) if method["integrator"] == "radau" else (1e-5, 1e-6)

    def run(damping):
        model = free_rod(damping)
        model.clamp("rod.start")
        model.force("rod.end", (0.0, 0.1, 0.1), until=0.0)
        return model.simulate(1.0, output_interval=0.1, **method).history("rod.end").values

    elastic = run(None)
    gaps = [np.abs(run(tau) - elastic).max() for tau in times]
    assert gaps[1] < 0.12 * gaps[0]
    assert gaps[1] < 1e-5


def test_superposed_rigid_rotation_of_a_loaded_frame():
    """B11 (i): an L-frame turned by 100 rad about a skew axis with loads that follow: same energy to 1e-12."""

    def energy(turn):
        axis = np.array([1.0, 2.0, -0.5]) / np.sqrt(5.25)
        skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        R = np.eye(3) + np.sin(turn) * skew + (1 - np.cos(turn)) * skew @ skew
        model = vr.Model()
        for name, a, b, d1 in (
            ("a", (0, 0, 0), (1, 0, 0), (0, 1, 0)),
            ("b", (1, 0, 0), (1, 1, 0), (1, 0, 0)),
        ):
            rod = vr.Rod.straight(R @ a, R @ b, section=coupled(), elements=2, order=4, d1=R @ d1)
            model.add(name, rod)
        model.attach("a.end", "b.start")
        model.clamp("a.start")
        model.force("b.end", R @ (0.3, -0.2, 0.5))
        return model.equilibrium().elastic_energy

    assert energy(100.0) == pytest.approx(energy(0.0), rel=1e-11)


@methods(1e-9, 0.01)
def test_one_rod_equals_two_attached_halves(method):
    """A rod and the same rod cut and attached, frames turned against each other: the same static and moving shape."""
    section = stiff(500.0, 800.0, 1.0, 0.7, damping=0.01)

    def tip(model, place):
        model.clamp("a.start")
        model.force(place, (0.2, 0.5, 0.8), until=0.0)
        model.moment(place, (0.1, 0.2, 0.0), until=0.2)
        return model.simulate(0.5, output_interval=0.05, **method).history(place).values

    whole = vr.Model()
    whole.add("a", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4, order=3))
    halves = vr.Model()
    halves.add("a", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), section=section, elements=2, order=3))
    halves.add(
        "b", vr.Rod.straight((0.5, 0, 0), (1, 0, 0), section=section, elements=2, order=3, d1=(0, 1, 1))
    )
    halves.attach("a.end", "b.start")
    assert tip(halves, "b.end") == pytest.approx(tip(whole, "a.end"), abs=1e-9)


@pytest.mark.parametrize(
    ("fixed", "turned"),
    [
        (("ux", "uy", "uz", "ry"), {"rx": 0.7, "rz": 1.1}),
        (("ux", "uy", "uz"), {"rx": 0.7, "rz": 1.1}),
        (("ux", "uy", "uz", "rx"), {"rz": 1.1}),
    ],
)
def test_reactions_balance_in_statics_after_large_rotations(fixed, turned):
    """Sum of forces and of moments about the support, whatever the rotation vector of the support has become."""
    model = free_rod()
    model.support("rod.start", fixed, motion={word: vr.Constant(angle) for word, angle in turned.items()})
    model.support("rod.end", ("ux",))
    model.force("rod@0.7", (0.06, -0.04, 0.08))
    model.moment("rod@0.7", (0.02, 0.05, -0.03))
    found = model.equilibrium(load_steps=4)
    start, end = found.reactions.values
    force = np.array([0.06, -0.04, 0.08])
    assert start[:3] + end[:3] + force == pytest.approx(np.zeros(3), abs=1e-9)
    at = {p: found.position(p) for p in ("rod.start", "rod.end", "rod@0.7")}
    moment = start[3:] + end[3:] + [0.02, 0.05, -0.03]
    moment += np.cross(at["rod.end"] - at["rod.start"], end[:3])
    moment += np.cross(at["rod@0.7"] - at["rod.start"], force)
    assert moment == pytest.approx(np.zeros(3), abs=1e-9)


@methods(
    1e-6, 0.0025, without={"midpoint": "its reactions ring with the frequencies that it does not resolve"}
)
def test_reactions_balance_the_momentum_of_a_swinging_hinge(method):
    """Rates of momentum equal reactions plus weight; what is left of the moments is the weight's."""
    model = free_rod(damping=0.02)
    model.support("rod.start", ("ux", "uy", "uz", "rx", "ry"))
    model.gravity((0, 1.0, -2.0))
    run = model.simulate(1.0, output_interval=0.0025, initial="reference", **method)
    origin = run.history("rod.start").values[0]
    P, L = run.data["linear_momentum"].values, run.data["angular_momentum"].values
    reaction = run.data["reaction"].values[:, 0]
    k = np.arange(100, 390)
    rate = (L[k + 1] - L[k - 1]) / 0.005
    total = float(run.data["point_weight"].sum())  # line mass is one
    centre_moment = rate - reaction[k, 3:] - np.cross(origin, reaction[k, :3])
    force = (P[k + 1] - P[k - 1]) / 0.005 - reaction[k, :3]
    assert force == pytest.approx(np.tile([0, total, -2 * total], (len(k), 1)), abs=2e-2 * total)
    # what is left is the moment of gravity about the origin: perpendicular to gravity
    assert centre_moment @ [0, 1.0, -2.0] == pytest.approx(np.zeros(len(k)), abs=2e-2)


@pytest.mark.parametrize(
    "travel",
    [
        {"speed": 2.0, "start": -0.31},
        {"position": vr.TimeTable([0, 0.1, 0.7, 1], [-0.2, -0.2, 1.0, 1.6])},
        {"speed": -2.0, "start": 1.4},
    ],
)
@methods(1e-6, 0.01)
def test_moving_force_gives_its_whole_impulse(travel, method):
    """A force that enters and leaves a free rod inside the run: momentum F L/speed, and the account closes."""
    model = vr.Model()
    section = stiff(1e4, 1e4, 10.0, 10.0, damping=0.01)
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=3, order=4))
    model.moving_force("rod", (0, 0, 0.5), **travel)
    run = model.simulate(1.0, initial="reference", **method)
    bound = {"radau": 5e-7, "generalized_alpha": 1e-12, "midpoint": 1e-4}[method["integrator"]]
    assert run.data["linear_momentum"].values[-1] == pytest.approx([0, 0, 0.5 / 2.0], abs=bound)
    assert run.energy.numerical_fraction < 5e-3


def slide_with_motor(speed, **method):
    """A rod whose end is turned about z while it may slide along z, under its weight."""
    model = vr.Model()
    section = stiff(1e4, 1e4, 10.0, 10.0, damping=0.01)
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=4))
    model.support("rod.start", ("ux", "uy", "rx", "ry"), motion={"rz": vr.SpinUp(speed, 1.0)})
    model.gravity((0, 0, -0.1))
    return model.simulate(1.2, initial="reference", **method)


@methods(1e-7, 0.005)
def test_motor_on_a_slide_turns_beyond_half_a_turn(method):
    """Rotation prescribed at a node that may slide: 5.6 rad, while it falls freely."""
    run = slide_with_motor(8.0, **method)
    root = run.history("rod.start", "displacement").values
    assert root[-1, 2] == pytest.approx(-0.1 * 1.2**2 / 2, rel=2e-2)
    assert np.abs(root[:, :2]).max() < 1e-9
    q = run.data["rotation"].values[:, 0]
    angle = 2 * np.unwrap(np.arctan2(_twist_about_z(q), _scalar(q)), period=np.pi)
    exact = np.array([vr.SpinUp(8.0, 1.0).value(t) for t in run.time])
    assert exact[-1] > 5.5
    assert angle - angle[0] == pytest.approx(exact, abs=1e-8)


@methods(1e-7, 0.005)
def test_motor_on_a_slide_turns_beyond_a_turn(method):
    """8.4 rad, past the turn at which a rotation vector is singular, while it falls freely as before."""
    run = slide_with_motor(12.0, **method)
    root = run.history("rod.start", "displacement").values
    assert root[-1, 2] == pytest.approx(-0.1 * 1.2**2 / 2, rel=2e-2)
    q = run.data["rotation"].values[:, 0]
    angle = 2 * np.unwrap(np.arctan2(_twist_about_z(q), _scalar(q)), period=np.pi)
    exact = np.array([vr.SpinUp(12.0, 1.0).value(t) for t in run.time])
    assert exact[-1] > 8.3
    assert angle - angle[0] == pytest.approx(exact, abs=1e-8)


def _scalar(q):
    """Scalar part of q conj(q_0)."""
    return q @ q[0]


def _twist_about_z(q):
    """z component of q conj(q_0)."""
    w, x, y, z = q.T
    return -w * q[0, 3] - x * q[0, 2] + y * q[0, 1] + z * q[0, 0]

"""Results of rods with bodies, joints, springs and held strains: places, coordinates of joints, drift, pictures."""

import numpy as np
import pytest

import viscorod as vr
from helpers.pictures import written
from helpers.plain_text import flat
from viscorod.pictures.plots.plot_motion import draw_motion
from viscorod.pictures.plots.plot_shape import draw_shape
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.node_names import describe_node

STIFFNESS, DAMPING = 20.0, 0.5
SHAPE = {"section": vr.Rectangle(0.03, 0.03), "elements": 2, "order": 3}
PLASTIC = vr.Material(
    youngs_modulus=2e9,
    poissons_ratio=0.3,
    density=1200.0,
    damping=vr.KelvinVoigt(shear_time=0.001, bulk_time=0.001),
)


def rod(start, end, **others):
    return vr.Rod.straight(start, end, material=PLASTIC, **SHAPE, **others)


def arm():
    """A motor turns a rod, a second one hangs on it in a sprung hinge and carries a box on a rope."""
    model = vr.Model()
    model.add("a", rod((0, 0, 0), (1, 0, 0)))
    model.add("b", rod((1, 0, 0), (2, 0, 0), constraints="kirchhoff"))
    model.add("plate", vr.Body.box((2.1, 0, 0), (0.2, 0.1, 0.1), density=1000.0, points={"tip": (2.2, 0, 0)}))
    model.attach("b.end", "plate")
    laws = {"stiffness": {"rz": STIFFNESS}, "damping": {"rz": DAMPING}}
    model.revolute("b.start", "a.end", (0, 1, 0), name="elbow", **laws)
    model.revolute("a.start", "ground", (0, 1, 0), motion={"rz": vr.Ramp(0.2, 0.8)}, name="shoulder")
    model.line_spring("plate.tip", (2.2, 0, 0.8), stiffness=50.0, damping=1.0, name="rope")
    model.gravity()
    return model


@pytest.fixture(scope="module", params=["radau", "generalized_alpha", "midpoint"])
def run(request, tmp_path_factory):
    found = arm().simulate(0.5, initial="reference", integrator=request.param, title="An arm")
    return vr.load(found.save(tmp_path_factory.mktemp("run") / "run.nc"))


@pytest.fixture(scope="module")
def frame():
    """Two cantilevers that hold a body between them: one rigidly, one by a hinge with a spring."""
    model = vr.Model()
    model.add("left", rod((0, 0, 0), (1, 0, 0)))
    model.add("right", rod((2, 0, 0), (1.2, 0, 0)))
    model.add("box", vr.Body.sphere((1.1, 0, 0), 0.05, mass=3.0, points={"seat": (1.2, 0, 0)}))
    model.clamp("left.start")
    model.clamp("right.start")
    model.attach("left.end", "box")
    model.revolute("box.seat", "right.end", (0, 1, 0), stiffness={"rz": 2.0})
    model.gravity()
    return model.equilibrium(title="A frame")


def test_bodies_and_their_points_are_places(run):
    assert run.sites.rods == ("a", "b")
    assert run.sites.bodies == ("plate", "plate.tip")
    centre, tip, end = (run.history(place).values for place in ("plate", "plate.tip", "b.end"))
    assert centre[0] == pytest.approx([2.1, 0, 0], abs=1e-12)
    assert np.linalg.norm(tip - centre, axis=1) == pytest.approx(0.1)
    assert np.linalg.norm(centre - end, axis=1) == pytest.approx(0.1)
    assert tip - centre == pytest.approx(centre - end, abs=1e-9)
    snapshot = run.snapshot(0.25)
    assert snapshot["plate.tip"].shape == (1, 3)
    assert set(snapshot) == {"a", "b", "plate", "plate.tip"}


def test_velocities_on_bodies_are_those_of_a_rigid_motion(run):
    station = {place: int(run.sites.stations(place)[0]) for place in run.sites.bodies}
    centre, tip = (run.history(place, "velocity").values for place in station)
    arm_ = run.history("plate.tip").values - run.history("plate").values
    spin = run.data["angular_velocity"].values[:, station["plate"]]  # about y, which the body keeps
    assert tip - centre == pytest.approx(np.cross(spin, arm_), abs=1e-9)
    assert run.data["angular_velocity"].values[:, station["plate.tip"]] == pytest.approx(spin)
    later = run.positions_at(0.4)[station["plate"]]
    assert later == pytest.approx(run.history("plate").interp(time=0.4).values, abs=1e-3)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("plate.tp", r"no such place; did you mean 'plate.tip'\?"),
        ("plaet", r"no such place; did you mean 'plate'\?"),
        ("plate@0.1", r"no such place; did you mean 'plate"),
        ("c.end", r"no such place; did you mean '.\.end'\?"),
        ("a", "a rod, not a place on it; write a.start"),
    ],
)
def test_wrong_places(run, place, message):
    with pytest.raises(vr.InputError, match=message):
        run.history(place)


def test_coordinates_of_joints(run):
    elbow = run.joint("elbow")
    assert set(elbow["motion"].values) == {"ux", "uy", "uz", "rx", "ry", "rz"}
    assert elbow["held"].sel(motion="ux")
    assert not elbow["held"].sel(motion="rz")
    free = elbow.sel(motion="rz")
    law = -STIFFNESS * free["value"] - DAMPING * free["rate"]
    assert free["force"].values[1:] == pytest.approx(law.values[1:], rel=0.05, abs=0.05)
    angles = [
        run.data["rotation"].sel(station=run.sites.at(place).stations[0]).values
        for place in ("a.end", "b.start")
    ]
    # rotation about y by the angle: its half's tangent is a ratio of parts of the relative quaternion
    w = np.abs(np.sum(angles[0] * angles[1], axis=-1))
    assert 2.0 * np.arccos(np.minimum(w, 1.0)) == pytest.approx(np.abs(free["value"].values), abs=1e-6)
    held = elbow.sel(motion=["ux", "uy", "uz"])
    assert np.abs(held["value"]).max() < 1e-5  # states between the ends of steps are interpolated
    assert elbow["value"].attrs["units"] == "m, rad"


def test_motors_follow_and_lines_have_lengths(run):
    shoulder = run.joint("shoulder").sel(motion="rz")
    assert shoulder["held"]
    given = [vr.Ramp(0.2, 0.8).value(t) for t in run.time]
    assert shoulder["value"].values == pytest.approx(given, abs=1e-6)
    rope = run.joint("rope")
    distance = np.linalg.norm(run.history("plate.tip").values - [2.2, 0, 0.8], axis=1)
    assert rope["value"].values[:, 0] == pytest.approx(distance)
    assert rope["force"].values[-1, 0] == pytest.approx(
        -50.0 * (distance[-1] - 0.8) - rope["rate"].values[-1, 0], rel=0.05
    )


def test_unknown_joint(run):
    with pytest.raises(vr.InputError, match=r"no joint or spring is called 'elbo'; did you mean 'elbow'\?"):
        run.joint("elbo")
    plain = vr.Model()
    plain.add("a", rod((0, 0, 0), (1, 0, 0)))
    plain.clamp("a.start")
    with pytest.raises(vr.InputError, match="no joints or springs"):
        plain.equilibrium().joint("elbow")


def test_drift_is_told(run):
    position, velocity = run.data.attrs["drift_position"], run.data.attrs["drift_velocity"]
    assert 0.0 <= position < 1e-8
    assert 0.0 <= velocity < 1e-8
    assert "Joints and held strains: largest violation" in flat(run.report())
    assert "Rod ends and bodies at" in flat(run.report())
    assert "plate.tip" in run.report()
    assert run.energy.numerical_fraction < 0.01


def test_momentum_includes_bodies(run):
    velocity = run.history("plate", "velocity").values[-1]
    mass = 1200.0 * 0.03**2
    assert run.data["linear_momentum"].values[-1, 2] < (2.0 * velocity + mass * velocity)[2] < 0.0


def test_equilibrium_of_bodies_and_joints(frame, tmp_path):
    again = vr.load(frame.save(tmp_path / "run.nc"))
    assert again.report() == frame.report()
    hinge = frame.joint("revolute box.seat - right.end")
    last = hinge.isel(load_factor=-1)
    weight = 9.81 * (3.0 + 1200.0 * 0.03**2 * 1.8)
    assert frame.reactions.values[:, 2].sum() == pytest.approx(weight)
    assert last["force"].sel(motion="rz") == pytest.approx(-2.0 * last["value"].sel(motion="rz").values)
    # what the joint carries is what the right clamp carries, less the weight of the right rod
    carried = frame.reactions.sel(support="right.start", motion="fz") - 9.81 * 1200.0 * 0.03**2 * 0.8
    up = np.sqrt(sum(float(last["force"].sel(motion=word)) ** 2 for word in ("ux", "uy", "uz")))
    assert up >= abs(float(carried)) * (1.0 - 1e-9)
    assert frame.position("box.seat") == pytest.approx(frame.position("right.end"), abs=1e-9)
    assert frame.rotation("box") == pytest.approx(frame.rotation("left.end"), abs=1e-9)
    report = frame.report()
    assert "Rod ends and bodies" in flat(report)
    assert "Joints and springs" in flat(report)
    assert "revolute box.seat - right.end" in flat(report)


def test_sections_that_hold_strains_carry_reactions(run):
    rods, component = run.data["point_rod"].values, run.data["component"].values
    b = run.data["section_force"].values[-1][rods == "b"]
    assert np.abs(run.data["strain"].values[:, rods == "b"][..., component == "stretch"]).max() < 1e-8
    assert np.abs(b[:, component == "stretch"]).max() > 1.0


def test_pictures_show_bodies_joints_and_springs(run, frame, tmp_path):
    figure = draw_motion(run)
    snapshots = figure.axes[1]
    legend = [text.get_text() for text in snapshots.get_legend().get_texts()]
    assert legend == ["reference", "body", "joints", "spring"]
    assert "Rods and bodies in the xz plane" in snapshots.get_title(loc="left")
    legend = [text.get_text() for text in draw_shape(frame).axes[0].get_legend().get_texts()]
    assert {"body", "joint", "supports"} < set(legend)
    assert written(run.plot, tmp_path / "motion.png").stat().st_size > 10_000
    assert written(frame.plot, tmp_path / "shape.png").stat().st_size > 10_000


def test_names_of_unnamed_springs_are_unique():
    model = arm()
    for stiffness in (1.0, 2.0):
        model.line_spring("plate", (3, 0, 0), stiffness)
    run = model.simulate(0.01, initial="reference", integrator="generalized_alpha", time_step=0.005)
    first, second = (run.joint(name) for name in ("line plate - ground", "line plate - ground (2)"))
    assert second["force"].values == pytest.approx(2.0 * first["force"].values)


def test_places_of_messages():
    problem = discretise(arm())
    assert describe_node(problem, int(problem.bodies.nodes[0])) == "body 'plate'"
    assert describe_node(problem, int(problem.stations.nodes[0])) == "rod 'a', element 1, s = 0 m"
    rows = [describe_node(problem, problem.size + row) for row in range(problem.multipliers)]
    assert rows[:2] == ["joint 'elbow'", "joint 'shoulder'"]
    assert rows[2:] == sorted(rows[2:])
    assert set(rows[2:]) == {f"held strains of rod 'b', element {k}" for k in (1, 2)}


def test_motions_that_joints_leave_free_are_named():
    model = arm()
    model.joints[1] = vr.Revolute("a.start", "ground", (0, 1, 0))
    model.springs.clear()
    model.joints[0] = vr.Revolute("b.start", "a.end", (0, 1, 0))
    with pytest.raises(
        vr.InputError, match=r"nothing holds the model against rotation about y .*, with 1 more part"
    ):
        model.equilibrium(search=False)

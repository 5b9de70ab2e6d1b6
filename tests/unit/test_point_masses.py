"""Point masses, thin rods, and several bodies that are one rigid node."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.errors import InputError

STEEL = vr.Material(2e11, 0.3, 8000.0)
MASSES = {"left": (10000.0, 2.0), "right": (1000.0, -2.0)}


def cantilever(inertia=0.0, joined="attach", constraints=None) -> vr.Model:
    """Return NAFEMS FV4: a tube of 10 m, 0.5 m thick, with two masses on arms of 2 m at its end."""
    model = vr.Model()
    line = {"section": vr.Circle(0.25), "material": STEEL, "constraints": constraints or ()}
    model.add("tube", vr.Rod.straight((0, 0, 0), (10, 0, 0), **line))
    model.clamp("tube.start")
    for name, (mass, y) in MASSES.items():
        model.add(name, vr.Body(mass, (inertia,) * 3, centre=(10, y, 0)))
        getattr(model, joined)("tube.end", name)
    return model


def test_nafems_fv4():
    """NAFEMS, The Standard NAFEMS Benchmarks (1990), FV4: six frequencies, of a beam that does not shear."""
    published = [1.723, 1.727, 7.413, 9.972, 18.155, 26.957]
    found = cantilever(constraints="unshearable").modes(6, about="reference").frequencies
    assert found == pytest.approx(published, rel=3e-4)
    # shear lowers the sixth by a hundredth
    assert cantilever().modes(6, about="reference").frequencies[:3] == pytest.approx(published[:3], rel=1e-3)


def test_joined_by_rigid_joints_the_frequencies_are_the_same():
    found = cantilever().modes(6, about="reference").frequencies
    for inertia in (1e-3, 0.0):  # what joints hold needs no inertia of its own
        other = cantilever(inertia, "rigid").modes(6, about="reference").frequencies
        assert found == pytest.approx(other, rel=1e-6)


def soft_model(bodies) -> vr.Model:
    """Return a soft cantilever under gravity with bodies at its end, the first of which carries a force."""
    rubber = vr.Material(2e6, 0.45, 1100.0, damping=vr.KelvinVoigt(0.01, 0.01))
    model = vr.Model()
    model.add(
        "bar", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Circle(0.01), material=rubber, elements=3)
    )
    model.clamp("bar.start")
    for name, body in bodies.items():
        model.add(name, body)
        model.attach("bar.end", name)
    model.gravity((0, 0, -9.81))
    return model


TURN = np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0]
TURN *= np.sign(np.linalg.det(TURN))
PLATE = vr.Body(0.02, (3e-6, 4e-6, 6e-6), centre=(0.31, 0.02, 0.0), axes=TURN.T[:2].tolist())
LUMP = vr.Body(0.03, (0, 0, 0), centre=(0.29, -0.01, 0.01), points={"tip": (0.3, -0.02, 0.0)})
NEEDLE = vr.Body(0.01, (0.0, 2e-6, 2e-6), centre=(0.3, 0.0, 0.02), axes=[(0, 0.6, 0.8), (0, -0.8, 0.6)])


def combined() -> vr.Body:
    """Return the three bodies as one, by the parallel-axis theorem."""
    mass = sum(body.mass for body in (PLATE, LUMP, NEEDLE))
    centre = sum(body.mass * np.array(body.centre) for body in (PLATE, LUMP, NEEDLE)) / mass
    inertia = np.zeros((3, 3))
    for body in (PLATE, LUMP, NEEDLE):
        arm = np.array(body.centre) - centre
        inertia += body.frame() @ body.inertia_matrix() @ body.frame().T
        inertia += body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return vr.Body(mass, inertia, centre=tuple(centre))


@pytest.mark.parametrize("order", [("plate", "lump", "needle"), ("lump", "needle", "plate")])
def test_several_bodies_move_as_the_one_they_are(tmp_path, order):
    """Motion, energies and momenta against one body with the mass and inertia of all."""
    bodies = {"plate": PLATE, "lump": LUMP, "needle": NEEDLE}
    settings = {"duration": 0.2, "time_step": 2e-3}
    run = soft_model({name: bodies[name] for name in order}).simulate(initial="reference", **settings)
    one = soft_model({"all": combined()}).simulate(initial="reference", **settings)
    tip, other = (result.probe("bar.end")["position"].values[:, 0] for result in (run, one))
    assert np.abs(tip[-1] - tip[0]).max() > 0.02
    assert tip == pytest.approx(other, abs=1e-7)
    for name in ("kinetic", "external", "elastic"):
        assert run.data[name].values == pytest.approx(one.data[name].values, abs=1e-6)
    # every body where the rigid node puts it
    ends = run.probe("bar.end")
    turned = ends["frame"].transpose("time", "place", "axis", "director").values[:, 0]
    turned = turned @ turned[0].T
    for name, body in bodies.items():
        found = run.probe(name)
        arms = turned @ (np.array(body.centre) - (0.3, 0.0, 0.0))
        assert found["position"].values[:, 0] == pytest.approx(
            ends["position"].values[:, 0] + arms, abs=1e-12
        )
        axes = found["frame"].transpose("time", "place", "axis", "director").values[:, 0]
        assert axes == pytest.approx(turned @ body.frame(), abs=1e-12)
    # and back from a file
    run.save(tmp_path / "run.nc")
    again = vr.load(tmp_path / "run.nc")
    assert again.probe("lump.tip")["position"].values == pytest.approx(
        run.probe("lump.tip")["position"].values
    )


def test_bodies_on_bodies():
    model = soft_model({"plate": PLATE})
    model.add("lump", LUMP)
    model.attach("plate", "lump")
    other = soft_model({"plate": PLATE, "lump": LUMP})
    assert model.modes(3).frequencies == pytest.approx(other.modes(3).frequencies, rel=1e-12)


def test_statics_with_a_load_on_the_second_body():
    """A force on a body beside the node is that force and its moment at the node."""
    model = cantilever()
    model.force("right", (0, 0, 1e5))
    model.moment("right", (1e5, 0, 0))
    found = model.equilibrium()
    bare = vr.Model()
    bare.add("tube", vr.Rod.straight((0, 0, 0), (10, 0, 0), section=vr.Circle(0.25), material=STEEL))
    bare.clamp("tube.start")
    bare.add("tip", vr.Body(1.0, (1, 1, 1), centre=(10, -2, 0)))
    bare.attach("tube.end", "tip")
    bare.force("tip", (0, 0, 1e5))
    bare.moment("tip", (1e5, 0, 0))
    same = bare.equilibrium()
    assert found.displacement("tube.end") == pytest.approx(same.displacement("tube.end"), rel=1e-9)
    assert found.displacement("right") == pytest.approx(same.displacement("tip"), rel=1e-9)


@pytest.mark.parametrize(
    ("inertia", "join", "about"),
    [((0, 0, 0), "ball", ""), ((0, 1, 1), "ball", r" about \(1, 0, 0\)")],
)
def test_turning_without_inertia_is_refused(inertia, join, about):
    model = cantilever()
    model.add("lump", vr.Body(1.0, inertia, centre=(10, 0, 0)))
    getattr(model, join)("tube.end", "lump")
    message = f"bodies.lump.inertia: lump: nothing gives turning{about} an inertia, and no .*attach the body to a rod"
    with pytest.raises(InputError, match=message):
        model.modes(2, about="reference")


def hinged_bars(joint="revolute", **axes) -> vr.Model:
    """Return two thin bars of 1 m and 1 kg that hang one below the other, without inertia about their own axis."""
    model = vr.Model()
    for k, name in enumerate(("upper", "lower")):
        points = {"top": (0, 0, -k), "foot": (0, 0, -k - 1)}
        model.add(name, vr.Body(1.0, (1 / 12, 1 / 12, 0), centre=(0, 0, -k - 0.5), points=points))
    for a, b in (("upper.top", "ground"), ("lower.top", "upper.foot")):
        getattr(model, joint)(a, b, **axes)
    model.gravity((0, 0, -9.81))
    return model


@pytest.mark.parametrize(
    ("joint", "axes", "times"),
    [("revolute", {"axis": (0, 1, 0)}, 1), ("universal", {"axes": [(1, 0, 0), (0, 1, 0)]}, 2)],
)
def test_thin_bars_on_hinges_that_hold_their_own_axis(joint, axes, times):
    """Lagrange's equations for small angles: M = [[4/3, 1/2], [1/2, 1/3]], K = g diag(3/2, 1/2)."""
    inverse = np.linalg.inv([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])
    squares = np.sort(np.linalg.eigvals(inverse @ np.diag([1.5, 0.5]) * 9.81))
    expected = np.repeat(np.sqrt(squares) / (2 * np.pi), times)
    found = hinged_bars(joint, **axes).modes(2 * times).frequencies
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("integrator", ["radau", "midpoint", "generalized_alpha"])
def test_a_point_mass_on_a_slider_with_a_spring(integrator):
    """x(t) = -g/w^2 (1 - cos w t), after half a period of 1 s; no rods, in each integrator."""
    model = vr.Model()
    model.add("mass", vr.Body(1.0, (0, 0, 0), centre=(0, 0, 0)))
    model.prismatic("mass", "ground", axis=(0, 0, 1), stiffness={"uz": (2 * np.pi) ** 2})
    model.gravity((0, 0, -9.81))
    run = model.simulate(0.5, initial="reference", integrator=integrator)
    assert run.history("mass").values[-1, 2] == pytest.approx(-2 * 9.81 / (2 * np.pi) ** 2, rel=1e-5)


def test_a_point_mass_whose_rotations_are_held():
    """A mass on a spring, f = sqrt(k/m)/(2 pi)."""
    model = cantilever()
    model.add("lump", vr.Body(2.0, (0, 0, 0), centre=(0, 0, 1)))
    model.support("lump", fixed=("ux", "uy", "rx", "ry", "rz"))
    model.line_spring("lump", (0, 0, 0), stiffness=8.0)
    assert model.modes(1, about="reference").frequencies[0] == pytest.approx(2.0 / (2.0 * np.pi), rel=1e-9)
    run = model.simulate(duration=0.5, initial="reference")
    assert run.outcome


def test_bodies_that_are_one_have_one_velocity():
    model = cantilever()
    model.velocity("left", (0, 0, 1), angular=(1, 0, 0), point=(10, 0, 0))
    model.velocity("right", (0, 0, 1), angular=(1, 0, 0), point=(10, 0, 0))
    run = model.simulate(duration=1e-3, initial="reference")
    # v + w x r, with r = (0, y, 0) and w along x: 1 + y along z
    for name, (_, y) in MASSES.items():
        assert run.probe(name)["velocity"].values[0, 0] == pytest.approx([0, 0, 1 + y], abs=1e-9)
    model.velocities.pop()
    model.velocity("right", (0, 0, 2))
    with pytest.raises(
        InputError, match=r"velocities\[1\]: right: it moves as one with 'left', which has another"
    ):
        model.simulate(duration=1e-3, initial="reference")


def test_a_motion_goes_on_from_an_earlier_one():
    """Bodies whose axes differ from the node's are read back into the same rigid node."""
    model = soft_model({"lump": LUMP, "plate": PLATE, "needle": NEEDLE})
    run = model.simulate(duration=0.05, initial="reference")
    later = model.simulate(duration=1e-3, start=run)
    for place in ("bar.end", "lump", "plate", "needle"):
        end, first = run.probe(place), later.probe(place)
        for name in ("position", "frame", "velocity"):
            assert first[name].values[0] == pytest.approx(end[name].values[-1], abs=1e-9)

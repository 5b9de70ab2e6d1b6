"""One model described in several ways: the results must not depend on how it is cut, ordered or oriented."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.mechanics.rotations.quaternion import matrices

from .cases import methods

LENGTH = 0.3
HALF = LENGTH / 2
MATERIAL = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.01))
SECTION = vr.Rectangle(0.01, 0.02)
# ends of the two halves (start, end), and the attached places
HALVES = {
    "end to start": (((0, HALF), (HALF, LENGTH)), ("left.end", "right.start")),
    "end to end": (((0, HALF), (LENGTH, HALF)), ("left.end", "right.end")),
    "start to start": (((HALF, 0), (HALF, LENGTH)), ("right.start", "left.start")),
    "both backwards": (((HALF, 0), (LENGTH, HALF)), ("left.start", "right.end")),
}


class Whole:
    """A straight rod along x in one piece."""

    def __init__(self):
        self.model = vr.Model()
        self.add("beam", 0.0, LENGTH, 4)

    def add(self, name, a, b, elements):
        rod = vr.Rod.straight(
            (a, 0, 0), (b, 0, 0), section=SECTION, material=MATERIAL, elements=elements, order=3, d1=(0, 1, 0)
        )
        self.model.add(name, rod)

    def place(self, x):
        return f"beam@{x!r}"

    def backwards(self, x):
        return False

    def body(self, x, vector):
        """Components of a vector along d1, d2, d3 of the whole rod, in the axes of the rod that is there."""
        a, b, c = vector
        return (a, -b, -c) if self.backwards(x) else vector

    def pieces(self):
        return [("beam", HALF)]


class Halves(Whole):
    """The same rod in two attached pieces."""

    def __init__(self, kind):
        self.model = vr.Model()
        self.ends, joint = HALVES[kind]
        self.add("left", *self.ends[0], 2)
        self.add("right", *self.ends[1], 2)
        self.model.attach(*joint)

    def place(self, x):
        name, (a, _) = ("left", self.ends[0]) if x < HALF else ("right", self.ends[1])
        return f"{name}@{abs(x - a)!r}"

    def backwards(self, x):
        a, b = self.ends[0] if x < HALF else self.ends[1]
        return a > b

    def pieces(self):
        return [("left", HALF / 2), ("right", 1.5 * HALF)]


def dead(beam):
    beam.model.clamp(beam.place(0.0))
    for x in (0.1, HALF, 0.2, LENGTH):
        beam.model.force(beam.place(x), (0.01, 0.02, -0.01))
        beam.model.moment(beam.place(x), (1e-3, 1e-3, -5e-4))


def following(beam):
    beam.model.clamp(beam.place(0.0))
    for x in (0.1, HALF, 0.2, LENGTH):
        beam.model.force(beam.place(x), beam.body(x, (0.01, 0.02, 0.01)), following=True)
        beam.model.moment(beam.place(x), beam.body(x, (1e-3, 1e-3, -5e-4)), following=True)


def distributed(beam):
    beam.model.clamp(beam.place(0.0))
    beam.model.gravity((1.0, -1.0, -2.0))
    for name, x in beam.pieces():
        beam.model.distributed_force(name, (0.05, 0.1, 0.2))
        beam.model.distributed_moment(name, beam.body(x, (1e-3, 2e-3, 3e-3)), following=True)


def supported(beam):
    beam.model.support(beam.place(0.0), ("ux", "uy", "uz", "rx"))
    beam.model.support(beam.place(HALF), ("rx",), motion={"uy": vr.Sine(3.0, 0.01)})
    beam.model.roller(beam.place(LENGTH), (0, 0, 1))
    beam.model.force(beam.place(0.1), (0.0, 0.1, 0.15))


@pytest.mark.parametrize("kind", HALVES)
@pytest.mark.parametrize("loaded", [dead, following, distributed, supported])
def test_a_rod_equals_its_attached_halves(loaded, kind):
    whole, halves = Whole(), Halves(kind)
    loaded(whole)
    loaded(halves)
    stations = [float(x) for x in (0.0, LENGTH / 4, HALF, 0.75 * LENGTH, LENGTH)]
    one, two = (beam.model.equilibrium(load_steps=2) for beam in (whole, halves))
    for x in stations:
        assert two.position(halves.place(x)) == pytest.approx(one.position(whole.place(x)), abs=1e-11)
    assert two.elastic_energy == pytest.approx(one.elastic_energy, rel=1e-9)
    # a given tolerance, with which no step depends on the rounding of an estimated error
    how = {"time_step": 2e-3, "initial": "reference", "tolerance": 1e-4, "errors": False}
    one, two = (beam.model.simulate(0.06, **how) for beam in (whole, halves))
    for x in stations:
        assert np.abs(two.history(halves.place(x)) - one.history(whole.place(x))).max() < 1e-11
    assert two.energy.viscous == pytest.approx(one.energy.viscous, rel=1e-8, abs=1e-12)


CORNERS = {"A": (0, 0, 0), "B": (0, 0, 0.2), "C": (0.3, 0, 0.2), "D": (0.3, 0, 0)}
CORNERS |= {"E": (0.15, 0, 0.2), "T": (0.15, 0.15, 0.2)}
BARS = {"left": "AB", "right": "DC", "first": "BE", "second": "EC", "stub": "ET"}


def portal(order, backwards, joints, held):
    """A portal frame with a stub at the middle of its beam: three rods at one node.

    Returns:
        the model, and the place of every (bar, corner).
    """
    model, at = vr.Model(), {}
    for bar in order:
        a, b = BARS[bar][::-1] if bar in backwards else BARS[bar]
        model.add(
            bar,
            vr.Rod.straight(
                CORNERS[a],
                CORNERS[b],
                section=SECTION,
                material=MATERIAL,
                elements=2,
                order=3,
                d1=(0, 0, 1) if bar == "stub" else (0, 1, 0),
            ),
        )
        at |= {(bar, a): f"{bar}.start", (bar, b): f"{bar}.end"}
    for joint in joints:
        corner = joint[-1]
        model.attach(*(at[bar, corner] for bar in joint[:2]))
    model.clamp(at["left", "A"], motion={"ux": vr.Sine(3.0, 0.02), "ry": vr.Sine(2.0, 0.3)})
    model.pin(at["right", "D"])
    model.support(at[held, "E"], ("uy",))
    model.force(at["second", "C"], (0.03, 0.015, -0.01))
    model.force(at["stub", "T"], (0, 0.01, -0.01))
    model.moment(at["stub", "E"], (1e-3, 0, 2e-3))
    model.gravity((0, 0, -1.0))
    return model, at


@pytest.mark.parametrize(
    ("order", "backwards", "joints", "held"),
    [
        (
            ("stub", "second", "first", "right", "left"),
            (),
            (
                ("stub", "first", "E"),
                ("second", "stub", "E"),
                ("second", "right", "C"),
                ("first", "left", "B"),
            ),
            "second",
        ),
        (
            ("second", "stub", "left", "first", "right"),
            ("second", "right", "stub"),
            (
                ("left", "first", "B"),
                ("first", "second", "E"),
                ("second", "stub", "E"),
                ("stub", "first", "E"),  # closes a ring of attachments
                ("right", "second", "C"),
            ),
            "stub",
        ),
        (
            ("right", "second", "stub", "left", "first"),
            ("right", "second", "stub", "left", "first"),
            (
                ("left", "first", "B"),
                ("stub", "second", "E"),
                ("first", "stub", "E"),
                ("second", "right", "C"),
            ),
            "first",
        ),
    ],
)
def test_a_frame_does_not_depend_on_how_it_is_described(order, backwards, joints, held):
    plain = (
        ("left", "first", "B"),
        ("first", "second", "E"),
        ("second", "right", "C"),
        ("second", "stub", "E"),
    )
    one, at = portal(tuple(BARS), (), plain, "first")
    two, other = portal(order, backwards, joints, held)
    q1, q2 = (model.equilibrium(load_steps=2) for model in (one, two))
    r1, r2 = (model.simulate(0.06, time_step=2e-3, errors=False) for model in (one, two))
    for where, place in at.items():
        assert q2.position(other[where]) == pytest.approx(q1.position(place), abs=1e-12)
        assert np.abs(r2.history(other[where]) - r1.history(place)).max() < 1e-12
    assert r2.energy.viscous == pytest.approx(r1.energy.viscous, rel=1e-9)


def answers(section, material=MATERIAL, **rod):
    """Numbers that hang on stiffness, damping and inertia: a static and a moving tip, a loss, eigenvalues."""
    model = vr.Model()
    model.add(
        "beam",
        vr.Rod.straight(
            (0, 0, 0), (LENGTH, 0, 0), section=section, material=material, elements=4, order=3, **rod
        ),
    )
    model.clamp("beam.start")
    model.force("beam.end", (0.01, 0.02, 0.03))
    model.moment("beam.end", (1e-3, 0, 0), until=0.02)
    run = model.simulate(0.05, time_step=2e-3, initial="reference")
    modes = model.modes(5, about="equilibrium").eigenvalues
    values = [
        model.equilibrium().position("beam.end"),
        run.history("beam.end").values[-1],
        [run.energy.viscous[-1]],
    ]
    return np.concatenate([*values, modes.real, modes.imag])


def test_sections_described_in_different_ways():
    wide = vr.Rectangle(0.02, 0.02)
    full = vr.StiffnessSection(*(a.tolist() for a in np.array(SECTION.matrices(MATERIAL))[[0, 2, 1]]))
    plain = answers(SECTION, d1=(0, 1, 0))
    same = {
        "6x6": answers(full, None, d1=(0, 1, 0)),
        "function": answers(lambda s: SECTION, d1=(0, 1, 0)),
        "taper": answers(vr.Taper(SECTION, SECTION), d1=(0, 1, 0)),
        "turned": answers(vr.Rectangle(0.02, 0.01), d1=(0, 0, 1)),
        "twisted": answers(vr.Rectangle(0.02, 0.01), d1=(0, 1, 0), twist=lambda s: np.pi / 2),
    }
    for way, found in same.items():
        assert found == pytest.approx(plain, rel=1e-9, abs=1e-10), way
    pieces = answers(vr.Piecewise([(HALF, SECTION), (LENGTH, wide)]))
    assert answers(lambda s: SECTION if s < HALF else wide) == pytest.approx(pieces, rel=1e-9, abs=1e-10)


@pytest.mark.filterwarnings("ignore:the numerical remainder")  # momentum is exact whatever the energy
@pytest.mark.parametrize("kind", ["arc", "helix"])
@methods(1e-8, 1e-3)
def test_momentum_of_a_thrown_curved_rod_with_off_centre_mass(kind, method):
    c = np.array([0.01, -0.02, 0.0])
    off = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    mass = 0.2 * np.block([[np.eye(3), -off], [off, -off @ off]])
    mass[3:, 3:] += np.diag([2e-5, 3e-5, 5e-5])
    section = vr.StiffnessSection(
        [200.0, 200.0, 400.0, 0.5, 0.4, 0.3], mass.tolist(), damping=[0.1] * 3 + [1e-3] * 3
    )
    if kind == "arc":
        rod = vr.Rod.arc((0.1, 0.2, 0.3), (1, 0, 0), (0, 1, 1), 0.2, 2.0, section=section, twist=1.0)
    else:
        rod = vr.Rod.helix(0.05, 0.03, 1.5, section=section)
    linear, angular, about = np.array([1.0, 2, -1]), np.array([6.0, -8, 10]), np.array([0.3, -0.1, 0.2])
    model = vr.Model()
    model.add("rod", rod)
    model.velocity("rod", linear=linear, angular=angular, point=about)
    chosen = {"errors": True}  # by which the program divides the rod
    data = model.simulate(0.05, initial="reference", **(method | chosen)).data
    drift = {"radau": 5e-7, "generalized_alpha": 1e-10, "midpoint": 1e-3}[method["integrator"]]

    x, weights = np.polynomial.legendre.leggauss(200)
    r, frames = rod.frames(rod.length * (x + 1) / 2)
    velocity = linear + np.cross(angular, r - about)
    centre = r + frames @ c
    spin = np.einsum("nij,j,nkj,k->ni", frames, [2e-5, 3e-5, 5e-5], frames, angular)
    momentum = 0.2 * (velocity + np.cross(angular, centre - r))
    turning = np.cross(centre, momentum) + spin
    for values, density in ((data.linear_momentum, momentum), (data.angular_momentum, turning)):
        expected = rod.length / 2 * weights @ density
        assert np.abs(values.values[0] - expected).max() < 1e-6 * np.abs(expected).max()
        assert np.abs(values.values - values.values[0]).max() < drift * np.abs(expected).max()


def test_the_reference_axis_of_a_section_is_a_choice():
    """Moving the axis within the section changes the matrices, couplings included, but not the rod."""
    c = np.array([0.004, -0.006, 0.0])
    move = np.eye(6)
    move[:3, 3:] = -np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    stiffness, damping, mass = (move.T @ a @ move for a in SECTION.matrices(MATERIAL))
    moved = vr.StiffnessSection(stiffness.tolist(), mass.tolist(), damping=damping.tolist())
    tips, losses = [], []
    for section, shift in ((SECTION, np.zeros(3)), (moved, c)):
        start = np.array([0.0, -shift[0], -shift[1]])  # d1 = y, d2 = z
        model = vr.Model()
        model.add(
            "beam",
            vr.Rod.straight(
                start,
                np.add(start, (LENGTH, 0, 0)),
                section=section,
                material=MATERIAL if section is SECTION else None,
                elements=4,
                order=5,
                d1=(0, 1, 0),
            ),
        )
        model.clamp("beam.start")
        model.gravity((1, 2, 3))
        model.moment("beam.end", (1e-3, 2e-3, 3e-3), until=0.02)
        run = model.simulate(0.06, time_step=2e-3, errors=False)
        frames = matrices(np.ascontiguousarray(run.data["rotation"].values[:, -1]))
        tips.append(run.history("beam.end").values + frames @ shift)
        losses.append(run.energy.viscous[-1])
    assert np.abs(tips[1] - tips[0]).max() < 1e-8
    assert losses[1] == pytest.approx(losses[0], rel=1e-7)

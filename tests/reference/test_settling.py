"""Equilibria that load steps do not lead to: slack, hanging, buckled and folded things, against closed forms."""

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from scipy.special import ellipe, ellipk

import viscorod as vr

STEEL = vr.Material(2e11, 0.3, 7850.0)
G = 9.81


def settled(found: vr.Equilibrium) -> bool:
    return "settling" in found.found_by and found.negative_eigenvalues == 0


# --- slack


def tube() -> vr.Model:
    model = vr.Model()
    rubber = vr.Material(3.0e6, 0.49, 1100.0)
    model.add(
        "tube", vr.Rod.straight((0, 0, 0), (0.6, 0, 0), section=vr.Annulus(0.004, 0.003), material=rubber)
    )
    model.clamp("tube.start")
    model.clamp("tube.end", motion={"ux": -0.25, "uz": 0.1})
    model.gravity()
    return model


def test_slack_tube_sags() -> None:
    """The planar extensible, shearable rod as a boundary value problem: the middle is at (0.2250, 0, -0.1500) m."""
    found = tube().equilibrium()
    assert settled(found)
    assert found.position("tube@0.3") == pytest.approx([0.2250, 0.0, -0.1500], abs=3e-4)


def test_motion_and_modes_start_from_the_same_equilibrium() -> None:
    model = tube()
    found = model.equilibrium().position("tube@0.3")
    run = model.simulate(0.01)
    assert run.history("tube@0.3").values[0] == pytest.approx(found, abs=1e-9)
    assert "settling" in run.report()
    assert model.modes(1).frequencies[0] > 0.1


def cable(bending: float, support: tuple[str, ...]) -> vr.Model:
    section = vr.StiffnessSection(
        [5e7, 5e7, 1e8, bending, bending, bending], [5.09684, 5.09684, 5.09684, 1e-3, 1e-3, 2e-3]
    )
    model = vr.Model()
    model.add("cable", vr.Rod.straight((0, 0, 0), (100, 0, 0), section=section))
    model.support("cable.start", support)
    model.support("cable.end", ("uy", "uz"), motion={"ux": -10.0})
    model.gravity((0, 0, -G))
    return model


def catenary(length: float, span: float, weight: float, axial: float) -> tuple[float, float]:
    """Return horizontal pull and sag of the elastic catenary between level supports (Irvine 1981, 1.2)."""
    half = weight * length / 2.0
    pull = brentq(
        lambda H: H * length / axial + 2.0 * H / weight * np.arcsinh(half / H) - span, 1e-3 * half, 1e3 * half
    )
    sag = weight * length**2 / (8.0 * axial) + pull / weight * (np.hypot(1.0, half / pull) - 1.0)
    return pull, sag


@pytest.mark.parametrize(
    ("bending", "support"),
    [(1.0, ("ux", "uy", "uz", "rx")), (0.0, ("ux", "uy", "uz", "rx")), (0.0, ("ux", "uy", "uz"))],
)
def test_cable_with_little_or_no_bending_stiffness(bending: float, support: tuple[str, ...]) -> None:
    pull, sag = catenary(100.0, 90.0, 5.09684 * G, 1e8)
    assert (pull, sag) == pytest.approx((2799.96, 19.0741), rel=2e-6)
    found = cable(bending, support).equilibrium()
    assert found.position("cable@50.0") == pytest.approx([45.0, 0.0, -sag], abs=2e-5)
    assert found.reactions.values[1, 0] == pytest.approx(pull, rel=1e-6)


@pytest.mark.parametrize("axial", [1e6, 1e8, 1e9, 1e10])
@pytest.mark.parametrize("support", [("ux", "uy", "uz", "rx"), ("ux", "uy", "uz")])
def test_slack_cable_of_any_axial_stiffness(axial: float, support: tuple[str, ...]) -> None:
    section = vr.StiffnessSection([axial / 2, axial / 2, axial, 0, 0, 0], [2.0, 2.0, 2.0, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("cable", vr.Rod.straight((0, 0, 0), (120, 0, 0), section=section))
    model.support("cable.start", support)
    model.pin("cable.end", motion={"ux": -20.0})
    model.gravity((0, 0, -G))
    pull, sag = catenary(120.0, 100.0, 2.0 * G, axial)
    found = model.equilibrium()
    assert found.position("cable@60.0") == pytest.approx([50.0, 0.0, -sag], abs=2e-3)
    assert found.reactions.values[1, 0] == pytest.approx(pull, rel=1e-3)


@pytest.mark.parametrize("length", [10.0, 1.0, 0.1])
def test_slack_steel_wire_of_any_length(length: float) -> None:
    """A wire of length over radius 1e4; ends bend over sqrt(EI/H) only, so the sag is nearly that of the catenary."""
    steel, radius = vr.Material(2.1e11, 0.3, 7850.0), 1e-4 * length
    model = vr.Model()
    model.add("wire", vr.Rod.straight((0, 0, 0), (length, 0, 0), section=vr.Circle(radius), material=steel))
    model.pin("wire.start")
    model.pin("wire.end", motion={"ux": -length / 6})
    model.gravity((0, 0, -G))
    area = np.pi * radius**2
    _, sag = catenary(length, 5 / 6 * length, 7850.0 * area * G, 2.1e11 * area)
    found = model.equilibrium()
    assert -found.position(f"wire@{length / 2}")[2] == pytest.approx(sag, rel=0.01)
    assert found.warnings == []
    assert found.mesh_errors["wire"] < 1e-4  # though sections may spin about their own axis


def test_mesh_of_a_loop_that_may_turn_about_its_chord() -> None:
    """A round rod between clamps, slack and twisted, whirls out of its line in any direction at the same energy."""
    energies = []
    for mesh in ({}, {"elements": 20}):
        rubber = vr.Material(1e6, 0.5, 1000.0)
        model = vr.Model()
        line = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=rubber, **mesh)
        model.add("rod", line)
        model.clamp("rod.start")
        model.clamp("rod.end", motion={"ux": -0.2, "rx": 4.0})
        found = model.equilibrium()
        assert settled(found)
        assert found.warnings == []
        assert found.mesh_errors["rod"] < 1e-4
        energies.append(found.data["elastic"].values[-1])
    assert energies[0] == pytest.approx(energies[1], rel=1e-6)


def test_cable_of_no_bending_stiffness_swings_sideways() -> None:
    """A taut string: f_n = n/2L sqrt(T/m), the same up and down as sideways, as its weight is left out."""
    section = vr.StiffnessSection([5e5, 5e5, 1e6, 0, 0, 0], [0.1, 0.1, 0.1, 1e-6, 1e-6, 2e-6])
    model = vr.Model()
    model.add("string", vr.Rod.straight((0, 0, 0), (2, 0, 0), section=section))
    model.support("string.start", ("ux", "uy", "uz", "rx"))
    model.support("string.end", ("uy", "uz"), motion={"ux": 0.002})
    pull, length = 1e6 * 0.001, 2.0 * 1.001
    mass = 0.1 / 1.001
    wanted = [n / (2.0 * length) * np.sqrt(pull / mass) for n in (1, 1, 2, 2)]
    assert model.modes(4).frequencies == pytest.approx(wanted, rel=2e-3)
    # plucked by its weight, which is taken away: it swings, and no energy is lost
    model.distributed_force("string", (0, 0, -1.0), until=0.0)
    run = model.simulate(2.0 / wanted[0], tolerance=1e-5)
    swing = run.history("string@1.0", "displacement").values[:, 2]
    assert swing[0] == pytest.approx(-1.0 * 2.0**2 / (8.0 * pull), rel=2e-3)
    assert swing[-1] == pytest.approx(swing[0], rel=0.02)
    assert run.energy.numerical_fraction < 1e-2


def test_zero_bending_stiffness_is_refused_beside_twist() -> None:
    with pytest.raises(vr.InputError, match="a cable"):
        vr.StiffnessSection([1e6, 1e6, 1e6, 0, 0, 1], [1, 1, 1, 1, 1, 2])


# --- hanging


def pendulum(*, hinge: bool = True) -> vr.Model:
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=STEEL))
    if hinge:
        model.revolute("rod.start", "ground", (0, 1, 0))
    else:
        model.pin("rod.start")
    model.gravity()
    return model


def test_level_pendulum_comes_to_rest_and_swings() -> None:
    model = pendulum()
    found = model.equilibrium()
    assert settled(found)
    stretch = STEEL.density * G / (2.0 * STEEL.youngs_modulus)
    assert found.position("rod.end") == pytest.approx([0, 0, -1.0 - stretch], abs=1e-9)
    assert model.modes(1).frequencies[0] == pytest.approx(np.sqrt(1.5 * G) / (2.0 * np.pi), rel=1e-4)


def test_free_spin_does_not_prevent_an_answer() -> None:
    found = pendulum(hinge=False).equilibrium()
    assert settled(found)
    assert found.position("rod.end")[:2] == pytest.approx([0, 0], abs=1e-8)


@pytest.mark.parametrize("ball", [True, False])
def test_chain_hangs_straight_down(ball: bool) -> None:
    count, length = 20, 0.1
    model = vr.Model()
    for k in range(count):
        line = vr.Rod.straight(
            (k * length, 0, 0), ((k + 1) * length, 0, 0), section=vr.Circle(0.005), material=STEEL,
            elements=1, order=2,
        )  # fmt: skip
        model.add(f"link{k}", line)
        before = f"link{k - 1}.end" if k else "ground"
        if ball:
            model.ball(f"link{k}.start", before)
        else:
            model.revolute(f"link{k}.start", before, (0, 1, 0))
            model.spring(f"link{k}.start", before, {"ry": 1e-3})
    model.gravity()
    found = model.equilibrium()
    # weak springs bend the top by about k pi/2 over the moment of the weight below it
    assert found.position(f"link{count - 1}.end") == pytest.approx(
        [0, 0, -count * length], abs=1e-6 if ball else 2e-3
    )
    assert settled(found)


def test_standing_pendulum_falls() -> None:
    """It stands exactly on its unstable equilibrium, where nothing drives it."""
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=vr.Circle(0.005), material=STEEL))
    model.revolute("rod.start", "ground", (0, 1, 0))
    model.gravity()
    found = model.equilibrium()
    assert settled(found)
    assert found.position("rod.end") == pytest.approx([0, 0, -1], abs=1e-6)


def test_long_chain_hangs() -> None:
    count = 100
    model = vr.Model()
    for k in range(count):
        line = vr.Rod.straight(
            (k, 0, 0), (k + 1, 0, 0), section=vr.Circle(0.05), material=STEEL, elements=1, order=2
        )
        model.add(f"link{k}", line)
        model.ball(f"link{k}.start", f"link{k - 1}.end" if k else "ground")
    model.gravity()
    found = model.equilibrium()
    assert settled(found)
    # a hanging bar stretches by rho g L^2/2E
    stretch = STEEL.density * G * count**2 / (2.0 * STEEL.youngs_modulus)
    assert found.position(f"link{count - 1}.end") == pytest.approx([0, 0, -count - stretch], abs=1e-5)


def test_heavy_chain_with_springs_balances_moments() -> None:
    """Two rigid links, hinges with springs: the moments of the weights about the hinges are those of the springs."""
    stiffness, length = 2.0, 0.5
    model = vr.Model()
    for k in range(2):
        line = vr.Rod.straight(
            (k * length, 0, 0), ((k + 1) * length, 0, 0), section=vr.Circle(0.01), material=STEEL
        )
        model.add(f"link{k}", line)
        before = f"link{k - 1}.end" if k else "ground"
        model.revolute(f"link{k}.start", before, (0, 1, 0))
        model.spring(f"link{k}.start", before, {"ry": stiffness})
    model.gravity()
    found = model.equilibrium()
    weight = model.rods["link0"].mass * G

    def moments(lower: float) -> tuple[float, float]:
        """Return the angle of the first link for that of the second, and the imbalance at the first hinge."""
        bend = weight * length / 2.0 * np.cos(lower) / stiffness
        upper = lower - bend
        return upper, weight * 1.5 * length * np.cos(upper) - stiffness * (upper - bend)

    lower = brentq(lambda x: moments(x)[1], 0.5, 3.0)
    upper, _ = moments(lower)
    tip = length * np.array([np.cos(upper) + np.cos(lower), 0.0, -np.sin(upper) - np.sin(lower)])
    assert found.position("link1.end") == pytest.approx(tip, abs=2e-4)


# --- buckled


def strut(load: float) -> vr.Model:
    model = vr.Model()
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 1.0, 1.0, 1.0], [1, 1, 1, 1e-4, 1e-4, 2e-4])
    model.add("strut", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4))
    model.clamp("strut.start")
    model.force("strut.end", (-load, 0, 0))
    return model


def elastica(load: float) -> tuple[float, float]:
    """Return along and across of the tip of a cantilever of EI = L = 1 (Love 1927, art. 263)."""
    k = brentq(lambda k: ellipk(k**2) - np.sqrt(load), 1e-6, 1.0 - 1e-12)
    root = np.sqrt(load)
    return float(2.0 * ellipe(k**2) / root - 1.0), float(2.0 * k / root)


@pytest.mark.parametrize("ratio", [1.05, 1.5, 4.0])
def test_compressed_strut_ends_buckled(ratio: float) -> None:
    load = ratio * np.pi**2 / 4.0
    found = strut(load).equilibrium()
    along, across = elastica(load)
    assert settled(found)
    tip = found.position("strut.end")
    assert tip[0] == pytest.approx(along, abs=1e-5)
    assert np.hypot(tip[1], tip[2]) == pytest.approx(across, abs=1e-5)
    assert tip[1] == pytest.approx(0.0, abs=1e-6)  # isotropic: to the side of global z


@pytest.mark.parametrize("part", [0.01, 0.5])
def test_strip_between_approaching_clamps_is_an_elastica(part: float) -> None:
    """Four quarters, each the elastica of a cantilever: shortened by 2 - 2E/K, the middle moves across by k/K."""
    model = vr.Model()
    model.add(
        "strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.001, 0.02), material=STEEL)
    )
    model.clamp("strip.start")
    model.clamp("strip.end", motion={"ux": -part})
    k = brentq(lambda k: 2.0 - 2.0 * ellipe(k**2) / ellipk(k**2) - part, 1e-6, 0.99)
    found = model.equilibrium()
    assert settled(found)
    middle = found.displacement("strip@0.5")
    assert np.hypot(middle[1], middle[2]) == pytest.approx(k / ellipk(k**2), rel=2e-4)


def test_search_can_be_switched_off() -> None:
    found = strut(1.5 * np.pi**2 / 4.0).equilibrium(search=False)
    assert found.negative_eigenvalues == 2
    assert found.position("strut.end")[1:] == pytest.approx([0, 0], abs=1e-12)
    assert "load step" in found.found_by


def test_truss_snaps_to_the_inverted_one() -> None:
    """Von Mises' truss of two bars under a dead load beyond its limit load."""
    half, rise, axial, load = 1.0, 0.1, 1e5, 60.0
    section = vr.StiffnessSection([axial, axial, axial, 100.0, 100.0, 100.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("left", vr.Rod.straight((-half, 0, 0), (0, 0, rise), section=section))
    model.add("right", vr.Rod.straight((0, 0, rise), (half, 0, 0), section=section))
    model.revolute("left.start", "ground", (0, 1, 0))
    model.revolute("right.end", "ground", (0, 1, 0))
    model.revolute("left.end", "right.start", (0, 1, 0))
    model.force("left.end", (0, 0, -load))
    first = np.hypot(half, rise)

    def balance(z: float) -> float:
        now = np.hypot(half, z)
        return 2.0 * axial * (now - first) / first * z / now + load

    heights = np.linspace(0.0, rise, 1000)
    assert load > -min(balance(z) - load for z in heights)  # beyond the limit load
    found = model.equilibrium()
    assert settled(found)
    assert found.position("left.end")[2] == pytest.approx(brentq(balance, -2 * rise, -0.5 * rise), abs=1e-5)


# --- nothing holds


def test_what_is_pulled_apart_is_told_so() -> None:
    """A rubber rod (EA = 100 N) that is held at one end, under 1e9 N: supports lack nothing."""
    rubber = vr.Material(1e6, 0.3, 1000.0)
    model = vr.Model()
    model.add(
        "rod", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber)
    )
    model.clamp("rod.start")
    model.force("rod.end", (0, 1e9, 0))
    with pytest.raises(vr.SolveError, match="100 times its size; check the loads against the stiffness"):
        model.equilibrium()


def test_what_falls_without_end_is_refused() -> None:
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=STEEL))
    model.gravity()
    with pytest.raises(
        vr.InputError, match="no static equilibrium: nothing holds the model against translation"
    ):
        model.equilibrium()


def test_arm_turns_towards_the_pull() -> None:
    """A rod on a pin under a dead end force points along it; its length follows from its axial stiffness."""
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-2, 1e-2, 2e-2])
    model = vr.Model()
    model.add("arm", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    model.pin("arm.start")
    model.force("arm.end", (1, 1, 0))
    along = (1.0 + np.sqrt(2.0) / 1e3) / np.sqrt(2.0)
    assert model.equilibrium().position("arm.end") == pytest.approx([along, along, 0.0], abs=1e-8)


@pytest.mark.parametrize("bending", [0.0, 1e-3])
def test_pins_leave_a_tight_string_to_turn_about_itself(bending: float) -> None:
    """A string between pins that are pulled apart: n/(2 L) sqrt(N L/m), though nothing holds its turn."""
    section = vr.StiffnessSection(
        [1e4, 1e4, 1e4, bending, bending, bending], [1.0, 1.0, 1.0, 1e-9, 1e-9, 2e-9]
    )
    model = vr.Model()
    model.add("string", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    model.pin("string.start")
    model.pin("string.end", motion={"ux": 0.01})
    found = model.equilibrium()
    assert found.reactions.sel(support="string.end", motion="fx") == pytest.approx(100.0, rel=1e-9)
    assert "rotation about x" in found.found_by
    modes = model.modes(count=5)
    speed = np.sqrt(100.0 * 1.01)  # of waves, per length before the pull
    assert np.count_nonzero(modes.rigid) == 1
    exact = np.repeat([1, 2], 2) * speed / 2.0 / 1.01
    np.testing.assert_allclose(modes.frequencies[1:], exact, rtol=5e-4)


@pytest.mark.parametrize("strain", [0.005, 0.02, 0.1])
def test_a_heated_bar_between_clamps_bows_out(strain: float) -> None:
    """Clamped elastica, longer than the way between its ends, which its force presses together by P/EA.

    (2 E/K - 1) l = 1 with P = 16 K^2 EI/l and l = 1 + strain - P/EA; its rise is k l/K.
    """
    bar = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.StiffnessSection([1e6] * 3 + [1.0, 5.0, 1.0]))
    model = vr.Model()
    model.add("bar", bar)
    model.clamp("bar.start")
    model.clamp("bar.end")
    model.rest_strain("bar", [0, 0, strain, 0, 0, 0])
    found = model.equilibrium()

    def length(m: float) -> float:
        return 1.0 + strain - 16.0 * ellipk(m) ** 2 / (1.0 + strain) / 1e6

    m = brentq(lambda m: length(m) * (2.0 * ellipe(m) / ellipk(m) - 1.0) - 1.0, 1e-6, 0.8)
    rise = np.sqrt(m) * length(m) / ellipk(m)
    assert np.linalg.norm(found.displacement("bar@0.5")) == pytest.approx(rise, rel=2e-4)
    assert settled(found)


@pytest.mark.parametrize("held", [False, True])
def test_a_beam_that_rolls_over_on_its_supports_is_told(held):
    """Held by points on its line alone, a beam on edge lies down: 5 w L^4/384 EI about its other axis is four times."""
    steel = vr.Material(2.1e11, 0.3, 7850.0)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (2, 0, 0), section=vr.Rectangle(0.02, 0.04), material=steel)
    model.add("beam", rod)
    if held:
        model.support("beam.start", ("ux", "uy", "uz", "rx"))
    else:
        model.pin("beam.start")
    model.support("beam.end", ("uy", "uz"))
    model.gravity((0, 0, -9.81))
    found = model.equilibrium()
    second = 0.02 * 0.04**3 / 12.0 if held else 0.04 * 0.02**3 / 12.0
    sag = 5.0 * 7850.0 * 0.02 * 0.04 * 9.81 * 2.0**4 / (384.0 * 2.1e11 * second)
    assert found.displacement("beam@1.0")[2] == pytest.approx(-sag, rel=4e-3)  # it shears, too
    told = [text for text in found.warnings if "has turned by" in text]
    assert bool(told) != held
    if not held:
        assert "rotation about x" in told[0]
        assert "has turned by 90 degrees" in told[0]
    for other in (model.modes(2), model.simulate(1e-3)):
        assert any("has turned by 90 degrees" in text for text in other.warnings) != held


def test_a_truss_that_falls_over_is_told_and_a_pendulum_is_not():
    """Three bars on two supports, drawn upright, hang from the line through these; a rod on one is meant to swing."""
    steel = vr.Material(2.1e11, 0.3, 7850.0)
    section = vr.Circle(0.02)
    model = vr.Model()
    for name, start, end in (
        ("left", (0, 0, 0), (1, 0, 1)),
        ("right", (2, 0, 0), (1, 0, 1)),
        ("base", (0, 0, 0), (2, 0, 0)),
    ):
        model.add(name, vr.Rod.straight(start, end, section=section, material=steel))
    model.rigid("left.end", "right.end")
    model.rigid("left.start", "base.start")
    model.rigid("right.start", "base.end")
    model.pin("base.start")
    model.support("base.end", ("uy", "uz"))
    model.force("left.end", (0, 0, -100.0))
    found = model.equilibrium()
    assert found.position("left.end")[2] == pytest.approx(-1.0, abs=1e-3)
    assert any("has turned by 180 degrees" in text for text in found.warnings)
    pendulum = vr.Model()
    pendulum.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=steel))
    pendulum.pin("rod.start")
    pendulum.gravity()
    hanging = pendulum.equilibrium()
    assert hanging.position("rod.end")[2] == pytest.approx(-1.0, abs=1e-3)
    assert not hanging.warnings


def test_a_line_that_its_supports_lift_has_not_turned_by_itself():
    """A mooring line, drawn level: its end is lifted by 60 of 200 m, and it hangs below, as it is meant to.

    Elastic catenary (Irvine 1981, 2.2): X = H S/EA + H/w (asinh V/H - asinh (V - wS)/H), Z likewise.
    """
    steel = vr.Material(2.0e11, 0.3, 7850.0)
    model = vr.Model()
    model.add("line", vr.Rod.straight((0, 0, 0), (220, 0, 0), section=vr.Circle(0.02), material=steel))
    model.pin("line.start")
    model.pin("line.end", motion={"ux": -20.0, "uz": 60.0})
    model.gravity((0, 0, -9.81))
    found = model.equilibrium()
    assert found.warnings == []
    area, length = np.pi * 0.02**2, 220.0
    weight, stretch = 7850.0 * 9.81 * area, 2.0e11 * area

    def gaps(pulls):
        h, upper = pulls
        lower = upper - weight * length
        across = h * length / stretch + h / weight * (np.arcsinh(upper / h) - np.arcsinh(lower / h))
        up = (upper**2 - lower**2) / (2.0 * weight * stretch)
        up += (np.hypot(h, upper) - np.hypot(h, lower)) / weight
        return across - 200.0, up - 60.0

    h, upper = fsolve(gaps, (16e3, 16e3), xtol=1e-12)
    reaction = found.reactions.values[1]
    assert (reaction[0], reaction[2]) == pytest.approx((h, upper), rel=5e-4)  # bends: EI k^2 is 1 N

"""Mechanisms of rods, bodies and joints against independent solutions and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import viscorod as vr

from .cases import methods, stiff
from .independent.comb_resonator import UM, Resonator
from .independent.four_bar import POINTS, RISE, SPEED, THICK, THIN, TILT
from .independent.mechanism_data import table
from .independent.rotor import Overhung, Top
from .independent.slider_crank import SliderCrank
from .motion import Motion, rigid_parts

ALL_STRAINS = ["shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"]


SAME = {"intrinsic": "rods that deform little: as the geometric formulation"}


def places(run, place, times):
    """Rows of the history of a place at the times, which must be among the output."""
    return run.history(place).values[rows_at(run, times)]


def rows_at(run, times):
    """Numbers of the stored times."""
    index = [int(np.argmin(np.abs(run.time - t))) for t in times]
    assert np.abs(run.time[index] - times).max() < 1e-9
    return index


def columns(rows, name, keys="xyz"):
    return np.column_stack([rows[f"{name}_{k}"] for k in keys])


def test_a_bar_that_is_no_rod_hangs_below_one_that_is():
    """Two uniform bars of length 1 and mass 1 on hinges: ``M = [[4/3, 1/2], [1/2, 1/3]]``, ``K = g [3/2, 1/2]``.

    The upper one is a rod that keeps its shape.
    """
    section = vr.StiffnessSection(np.ones(6), [1.0, 1.0, 1.0, 1e-12, 1e-12, 2e-12])
    model = vr.Model()
    held = ("kirchhoff", "bend_1", "bend_2", "twist")
    model.add("upper", vr.Rod.straight((0, 0, 0), (0, 0, -1), section=section, constraints=held))
    bar = vr.Body(1.0, (1 / 12, 1 / 12, 1e-12), centre=(0, 0, -1.5), points={"top": (0, 0, -1)})
    model.add("lower", bar)
    model.revolute("upper.start", "ground", axis=(0, 1, 0))
    model.revolute("lower.top", "upper.end", axis=(0, 1, 0))
    model.gravity((0, 0, -9.81))
    squares = eigh(9.81 * np.diag([1.5, 0.5]), [[4 / 3, 1 / 2], [1 / 2, 1 / 3]], eigvals_only=True)
    assert model.modes(2).frequencies == pytest.approx(np.sqrt(squares) / (2.0 * np.pi), rel=1e-8)


@pytest.mark.parametrize("kind", ["constrained", "stiff"])
@methods(1e-7, 0.005)
def test_rigid_double_pendulum(kind, method):
    """Bars that cannot deform, or hardly, on two revolute joints: the ODE's elbow and tip over 3 s."""
    rows = table("double_pendulum")
    rotary = 1e-8 if kind == "constrained" else 1e-6  # slender: of no account, but no zero
    section = stiff(1e7, 1e7, 1e5, 1e5, rotary=(rotary, rotary, 2 * rotary))
    held = {"constraints": ALL_STRAINS} if kind == "constrained" else {}
    model = vr.Model()
    model.add("upper", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=2, **held))
    model.add("lower", vr.Rod.straight((1, 0, 0), (2, 0, 0), section=section, elements=1, order=2, **held))
    model.revolute("ground", "upper.start", axis=(0, 1, 0), name="shoulder")
    model.revolute("upper.end", "lower.start", axis=(0, 1, 0), name="elbow")
    model.gravity((0, 0, -9.81))
    motion = Motion(model, 3.0, initial="reference", output_interval=0.05, **method)
    assert motion.drift < 1e-9
    second_order = method["integrator"] != "radau"
    assert motion.imbalance() < (2e-3 if second_order else 2e-6)
    # bending of the stiff bars: weight times cube of the length over 8 EI, 1e-5 of the length, grows with the motion
    allowed = 5e-3 if second_order else 2e-6 if kind == "constrained" else 3e-4
    for place, name in (("upper.end", "elbow"), ("lower.end", "tip")):
        found = places(motion.run, place, rows["t"])
        assert found[:, [0, 2]] == pytest.approx(columns(rows, name, "xz"), abs=allowed)
        assert np.abs(found[:, 1]).max() < 1e-9


def beam_section(given, tau):
    """Section of the four-bar's bars: order shear, shear, stretch, bend, bend, twist."""
    K = [given["GA"], given["GA"], given["EA"], given["EI"], given["EI"], given["GJ"]]
    J = given["rotary"]
    return vr.StiffnessSection(K, [*3 * [given["mass"]], J, J, 2 * J], damping=[tau * k for k in K])


@methods(
    1e-6,
    0.01,
    spectral_radius=0.7,
    without={"midpoint": "nothing damps what the two snaps start", **SAME},
)
def test_four_bar_with_an_inclined_hinge(method):
    """Slow motion: the equilibria, but for the ringing after the branch changes at the stretched positions.

    Inertia changes the places by 1e-6 m in the middle of the table, more around the stretched positions, where Exudyn's
    differences are in the table.
    """
    rows = table("four_bar")
    model = vr.Model()
    for name, a, b, section in (("ab", "A", "B", THICK), ("bc", "B", "C", THICK), ("cd", "C", "D", THIN)):
        rod = vr.Rod.straight(POINTS[a], POINTS[b], section=beam_section(section, 1e-4), elements=2, order=4)
        model.add(name, rod)
    z, hinge = (0, 0, 1), (float(np.sin(TILT)), 0.0, float(np.cos(TILT)))
    model.revolute("ground", "ab.start", axis=z, name="A", motion={"rz": vr.SpinUp(SPEED, RISE)})
    model.revolute("ab.end", "bc.start", axis=z, name="B")
    model.revolute("bc.end", "cd.start", axis=hinge, name="C")
    model.revolute("cd.end", "ground", axis=z, name="D")
    if method["integrator"] == "radau":
        method = {"time_step": 0.04, **method}  # the drive alone asks for no short steps
    motion = Motion(model, 12.0, initial="reference", output_interval=0.2, **method)
    run = motion.run
    quiet = np.min(np.abs(rows["crank"][:, None] + [np.pi / 2, 3 * np.pi / 2]), axis=1) > 0.25
    for place, name in (("ab.end", "B"), ("bc.end", "C")):
        found, expected = places(run, place, rows["t"]), columns(rows, name)
        assert found[quiet] == pytest.approx(expected[quiet], abs=2e-6)
        assert found == pytest.approx(expected, abs=1e-3)
    at = rows_at(run, rows["t"])
    # inertia, which the table lacks, changes forces by what another program found
    for name, word in (("motor", "rz"), ("force_x", "ux"), ("force_y", "uy"), ("force_z", "uz")):
        if name == "motor":
            found = motion.joint("A", word)[2][at]
        else:
            found = np.array([motion.joint("A", w)[2][at] for w in ("ux", "uy", "uz")])
            found = -found["xyz".index(name[-1])]
        away = np.abs(found - rows[name])[quiet]
        assert (away < 2.0 * rows["dynamic_force"][quiet] + 0.02).all(), name
    for joint, sign in (("B", -1.0), ("C", -1.0)):
        angle = sign * motion.joint(joint, "rz")[0][at]
        wrapped = (angle - rows[f"angle_{joint}"] + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(wrapped[quiet]).max() < 1e-4
    assert motion.drift < 1e-9
    assert motion.imbalance() < (1e-5 if method["integrator"] == "radau" else 1e-2)


def slider_crank(case: SliderCrank) -> vr.Model:
    """The slider-crank as rods and bodies; its motor turns at an even speed."""
    EA, GA, EI = case.stiffness
    mass, J = case.density * case.area, case.density * case.inertia
    K = np.array([GA, GA, EA, EI, EI, EI])
    given = {"damping": list(case.damping * K)} if case.damping else {}
    section = vr.StiffnessSection(list(K), [mass, mass, mass, J, J, 2 * J], **given)
    a, L, W = case.crank, case.length, case.speed
    turns = 8 * np.pi / W  # longer than any of the motions
    model = vr.Model()
    model.add("crank", vr.Body(1e-3, (1e-6, 1e-6, 1e-6), centre=(0, 0, 0), points={"pin": (a, 0, 0)}))
    model.add("coupler", vr.Rod.straight((a, 0, 0), (a + L, 0, 0), section=section, elements=2, order=5))
    model.add("slider", vr.Body(case.slider, (1e-6, 1e-6, 1e-6), centre=(a + L, 0, 0)))
    drive = vr.Ramp(0.0, turns, turns * W)
    model.revolute("ground", "crank", axis=(0, 0, 1), name="motor", motion={"rz": drive})
    model.revolute("crank.pin", "coupler.start", axis=(0, 0, 1), name="pin")
    model.revolute("coupler.end", "slider", axis=(0, 0, 1), name="wrist")
    model.prismatic("slider", "ground", axis=(1, 0, 0), name="guide")
    model.velocity("crank", angular=(0, 0, W))
    model.velocity("coupler", angular=(0, 0, -a * W / L), point=(a + L, 0, 0))
    return model


@pytest.mark.parametrize("damping", [0.0, 2e-5])
def test_slider_crank_with_a_flexible_coupler(damping):
    """Closed loop: slider and mid-coupler deflection over two turns."""
    case, rows = SliderCrank(damping=damping), table("slider_crank")
    model, turns = slider_crank(case), float(rows["t"][-1])
    motion = Motion(model, turns, initial="reference", tolerance=1e-6, output_interval=turns / 60)
    run = motion.run
    assert motion.drift < 1e-9
    assert motion.imbalance() < 1e-4
    pin, middle, end = (places(run, p, rows["t"]) for p in ("coupler.start", "coupler@0.15", "coupler.end"))
    chord, arm = end - pin, middle - pin
    across = (chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]) / np.linalg.norm(chord, axis=1)
    suffix = "_damped" if damping else ""
    # without damping axial ringing, which no step resolves for long, moves the slider by some micrometres
    allowed = 1e-6 if damping else 2e-5
    assert end[:, 0] == pytest.approx(rows["slider" + suffix], abs=allowed)
    assert across == pytest.approx(rows["deflection" + suffix], abs=allowed)
    if (
        damping
    ):  # without it axial ringing fills the torque; the crank of the table has no mass, here next to none
        torque = motion.joint("motor", "rz")[2][rows_at(run, rows["t"])]
        expected = rows["torque_damped"]
        assert np.abs(torque - expected)[2:].max() < 2e-3 * np.abs(expected).max()


def spectrum_peaks(signal, step, guesses):
    """Angular frequencies of a sum of exp(i w t) near the guesses: least squares on the whole record."""
    from scipy.optimize import least_squares

    t = step * np.arange(signal.size)

    def misfit(w):
        basis = np.exp(1j * np.outer(t, w))
        rest = signal - basis @ np.linalg.lstsq(basis, signal, rcond=None)[0]
        return np.concatenate([rest.real, rest.imag])

    return least_squares(misfit, guesses, x_scale=np.abs(guesses), xtol=1e-14, ftol=1e-14).x


@pytest.mark.parametrize("spin", [0.0, 100.0, 300.0])
def test_whirl_of_a_disc_on_a_flexible_shaft(spin):
    """Four whirl frequencies of the disc on a light shaft, its mass included; the spin splits forward and backward."""
    rotor = Overhung(line_mass=0.01)
    L, EI = rotor.length, rotor.EI
    section = stiff(1e8, 1e8, EI, 2 * EI, mass=rotor.line_mass, rotary=(1e-9, 1e-9, 2e-9))
    model = vr.Model()
    model.add("shaft", vr.Rod.straight((0, 0, 0), (0, 0, L), section=section, elements=2, order=6))
    inertia = (rotor.diametral, rotor.diametral, rotor.polar)
    model.add("disc", vr.Body(rotor.mass, inertia, centre=(0, 0, L)))
    model.attach("shaft.end", "disc")
    # the whole turns from the start on, and the disc has a small sideways velocity besides
    drive = {"rz": vr.Ramp(0.0, 10.0, 10.0 * spin)} if spin else None
    model.clamp("shaft.start", motion=drive)
    push = 1e-3
    model.velocity("shaft", field=lambda s: ((push * (s / L) ** 2, 0, 0), (0, 2 * push * s / L**2, spin)))
    model.velocity("disc", linear=(push, 0, 0), angular=(0, 2 * push / L, spin), point=(0, 0, L))
    step, duration = 2e-3, 2.0
    run = model.simulate(duration, initial="reference", tolerance=1e-7, output_interval=step, errors=False)
    r = run.history("shaft.end").values
    expected = rotor.whirl(spin)
    assert spectrum_peaks(r[:, 0] + 1j * r[:, 1], step, expected) == pytest.approx(expected, rel=2e-4)


def test_steady_precession_of_a_heavy_top():
    """A disc on a ball joint, started in steady precession: its centre stays on its circle."""
    m, d, tilt, spin = 1.0, 0.1, 0.5, 200.0
    axial, about_centre = 0.002, 0.002
    top = Top(mass=m, axial=axial, transverse=about_centre + m * d * d, distance=d)
    rate = float(top.precession(tilt, spin)[0])
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    across = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    centre = d * axis
    body = vr.Body(
        m,
        (about_centre, about_centre, axial),
        centre=tuple(centre),
        axes=(tuple(across), (0.0, 1.0, 0.0)),
        points={"tip": (0.0, 0.0, 0.0)},
    )
    model = rigid_parts(("top", body))
    model.ball("top.tip", "ground")
    model.gravity((0, 0, -top.gravity))
    model.velocity("top", angular=tuple(top.angular_velocity(tilt, spin, rate)), point=(0, 0, 0))
    turn = 2 * np.pi / rate
    # 80 turns about its axis
    given = {"initial": "reference", "tolerance": 1e-8, "output_interval": turn / 40, "errors": False}
    motion = Motion(model, turn, **given)
    angle = rate * motion.time
    expected = d * np.column_stack(
        [np.sin(tilt) * np.cos(angle), np.sin(tilt) * np.sin(angle), np.full_like(angle, np.cos(tilt))]
    )
    assert motion.body("top") == pytest.approx(expected, abs=1e-6)
    assert motion.drift < 1e-9
    assert motion.imbalance() < 1e-6


@pytest.mark.parametrize("length", [146 * UM, 170 * UM])
def test_folded_comb_resonator(length):
    """F6: flexures as rods, trusses and shuttle as bodies; the lowest frequency is that of the motion in the plane."""
    model, case = resonator(length)
    modes = model.modes(2)
    assert modes.frequencies[0] == pytest.approx(case.folded_exact(), rel=1e-6)
    assert modes.frequencies[0] == pytest.approx(case.folded_lumped(), rel=1e-3)
    assert modes.damping_ratios[0] == pytest.approx(0.0, abs=1e-9)
    period = 1 / case.folded_exact()
    swing(model, length, 0.05)  # half a micrometre
    motion = Motion(model, 2 * period, initial="reference", tolerance=1e-7, output_interval=period / 40)
    x = motion.body("shuttle")[:, 0]
    up = np.flatnonzero((x[1:-1] < 0) & (x[2:] >= 0)) + 1
    crossing = motion.time[up] - x[up] * (motion.time[up + 1] - motion.time[up]) / (x[up + 1] - x[up])
    assert crossing[0] == pytest.approx(1 / modes.frequencies[0], rel=2e-3)
    assert motion.drift < 1e-9
    assert motion.imbalance() < 1e-4


def swing(model, length, speed):
    """Start the motion with the static shape: shuttle, trusses at half its speed, flexures guided at both ends."""
    model.velocity("shuttle", linear=(speed, 0, 0))
    for sign, side in (("p", 1), ("m", -1)):
        model.velocity(f"truss{sign}", linear=(speed / 2, 0, 0))
        for k in range(4):
            begin = speed if k in (1, 2) else 0.0

            def field(s, begin=begin, side=side):
                x = s / length
                v = begin + (speed / 2 - begin) * (3 * x**2 - 2 * x**3)
                slope = (speed / 2 - begin) * 6 * (x - x**2) / length
                return (v, 0, 0), (0, 0, -side * slope)

            model.velocity(f"flexure{sign}{k}", field=field)


def resonator(length):
    """Unshearable flexures, d1 across in the plane: bend_2 is bending in the plane."""
    case = Resonator(length=length, trusses=2 * 2330 * 100 * UM * 10 * UM * 2.25 * UM)
    area = case.width * case.thickness
    EA, EI = case.young * area, case.EI
    out = case.young * case.width * case.thickness**3 / 12
    mass, small = case.line_mass, case.line_mass * 1e-15
    section = vr.StiffnessSection(
        [EA, EA, EA, out, EI, EI], [mass, mass, mass, small, small, 2 * small], damping=None
    )
    model = vr.Model()
    px, py = case.plate
    # shuttle in the middle; trusses at y = +-(L + py/2); flexures along y, d1 = x in the plane
    shuttle = {}
    for side in (1, -1):
        truss = {}
        for k, x in enumerate((-100 * UM, -40 * UM, 40 * UM, 100 * UM)):
            low, high = (x, side * py / 2, 0.0), (x, side * (py / 2 + length), 0.0)
            name = f"flexure{'p' if side > 0 else 'm'}{k}"
            rod = vr.Rod.straight(
                low,
                high,
                section=section,
                d1=(1, 0, 0),
                elements=1,
                order=5,
                constraints=["shear_1", "shear_2"],
            )
            model.add(name, rod)
            truss[f"at{k}"] = high
            if k in (1, 2):
                shuttle[f"{name}"] = low
            else:
                model.clamp(f"{name}.start")
        body = vr.Body(
            case.trusses / 2,
            tuple(np.full(3, case.trusses / 2 * (50 * UM) ** 2)),
            centre=(0, side * (py / 2 + length), 0),
            points=truss,
        )
        model.add(f"truss{'p' if side > 0 else 'm'}", body)
    body = vr.Body(
        case.plate_mass, tuple(case.plate_mass * px**2 / 12 * np.ones(3)), centre=(0, 0, 0), points=shuttle
    )
    model.add("shuttle", body)
    for sign in "pm":
        for k in range(4):
            model.attach(f"flexure{sign}{k}.end", f"truss{sign}.at{k}")
        for k in (1, 2):
            model.attach(f"flexure{sign}{k}.start", f"shuttle.flexure{sign}{k}")
    return model, case


@pytest.mark.parametrize("integrator", ["radau", "midpoint", "generalized_alpha"])
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # equal steps, coarse ones
def test_rates_of_driven_joints_are_those_of_their_motors(integrator):
    """Closed form: every stored rate of a driven coordinate is the derivative of its motion, also between steps."""
    model = vr.Model()
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model.add("arm", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=rubber))
    motor = vr.SpinUp(2.0, 0.3)
    model.revolute("arm.start", "ground", (0, 0, 1), motion={"rz": motor}, name="motor")
    run = model.simulate(0.5, initial="reference", time_step=0.01, integrator=integrator)
    rate = run.joint("motor").rate.sel(motion="rz").values
    assert rate == pytest.approx([motor.rate(t) for t in run.time], abs=1e-6)

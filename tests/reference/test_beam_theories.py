"""Named theories of planar straight beams, against closed forms (Artola, Wynn and Palacios, section IV)."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.special import ellipk
from typer.testing import CliRunner

import viscorod as vr
from helpers.plain_text import flat
from viscorod.cli.app import app
from viscorod.errors import InputError

from .test_awp_bridge import EI as BRIDGE_EI
from .test_awp_bridge import MASS, TIMES, bridge, table

LENGTH, SIDE, YOUNG, NU, DENSITY, TAU = 1.0, 0.05, 1e9, 0.3, 1000.0, 1e-4
AREA, INERTIA = SIDE**2, SIDE**4 / 12.0
EA, EI, MU = YOUNG * AREA, YOUNG * INERTIA, DENSITY * AREA
HINGED = ("ux", "uy", "uz", "rx")


def beam(supports, tau=0.0, d1=(0, 0, 1), **more):
    material = vr.Material(YOUNG, NU, DENSITY, damping=vr.KelvinVoigt(tau, tau) if tau else None)
    rod = vr.Rod.straight(
        (0, 0, 0), (LENGTH, 0, 0), section=vr.Rectangle(SIDE, SIDE), material=material, d1=d1, **more
    )
    model = vr.Model()
    model.add("beam", rod)
    for place, fixed in supports.items():
        model.support(place, fixed=fixed) if fixed else model.clamp(place)
    return model


def cantilever(force, **more):
    model = beam({"beam.start": None}, **more)
    model.force("beam.end", (0.0, 0.0, force))
    return model


def hinged(amplitude, tau=0.0, until=None, stretching=True, **more):
    """A beam between hinges that cannot approach each other, under the load that makes von Karman's sine shape.

    EI w'''' - N w'' = q with N = EA/(2 L) int w'^2 = EA pi^2 a^2/(4 L^2).
    """
    k = np.pi / LENGTH
    load = EI * k**4 * amplitude + stretching * 0.25 * EA * k**4 * amplitude**3
    model = beam({"beam.start": (*HINGED, "rz"), "beam.end": (*HINGED, "rz")}, tau, **more)
    model.distributed_force("beam", lambda s: (0.0, 0.0, load * np.sin(k * s)), until=until)
    return model


@pytest.mark.parametrize("d1", [(0, 0, 1), (0, 1, 0)])
def test_deflections_of_a_cantilever(d1):
    # F L^3/3 EI, and F L/k G A more where sections shear: linear, along d1 as along d2
    force = 2.0
    found = cantilever(force, d1=d1).compare_theories()
    bending = force * LENGTH**3 / (3.0 * EI)
    k = vr.Rectangle(SIDE, SIDE).matrices(vr.Material(YOUNG, NU, DENSITY))[0][0, 0]  # k G A
    signed = found.theories["euler_bernoulli"].displacement[0, -1, 1]
    assert abs(signed) == pytest.approx(bending, rel=1e-9)
    assert found.theories["timoshenko"].deflection == pytest.approx(
        np.sign(signed) * (bending + force * LENGTH / k), rel=1e-9
    )
    for word in ("euler_bernoulli", "timoshenko"):
        axial, shear, moment = found.theories[word].section_force[0].T
        assert shear == pytest.approx(np.full(len(shear), shear[0]), rel=1e-7)
        assert abs(shear[0]) == pytest.approx(force, rel=1e-7)
        assert np.abs(moment) == pytest.approx(force * (LENGTH - found.point_s), abs=1e-8)
        assert axial == pytest.approx(np.zeros(len(axial)), abs=1e-7)
        assert found.displacement_error(word) < 0.02
    assert found.enough == "euler_bernoulli"


def elastica(force):
    """Deflection and shortening of the tip of an inextensible, unshearable cantilever: EI theta'' = -F cos theta."""

    def rate(s, y):
        return np.array([y[1], -force / EI * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def ends(a, b):
        return np.array([a[0], b[1], a[2], a[3]])

    s = np.linspace(0.0, LENGTH, 40)
    found = solve_bvp(rate, ends, s, np.array([s, 1.0 - s, s, 0.3 * s]), tol=1e-9)
    return found.y[3, -1], found.y[2, -1] - LENGTH


def test_a_large_load_needs_the_exact_theory():
    # F L^2/EI = 2, where linear theory errs by some 35 %; the exact one is held against the elastica
    force = 2.0 * EI / LENGTH**2
    found = cantilever(force).compare_theories()
    across, along = elastica(force)
    tip = found.exact.displacement[0, -1]
    assert np.abs(tip) == pytest.approx(np.abs([along, across]), rel=4e-3)  # shear and stretch make the rest
    linear = np.array([0.0, force * LENGTH**3 / (3.0 * EI)])
    expected = np.linalg.norm(linear - np.abs([along, across])) / np.hypot(along, across)
    assert found.displacement_error("euler_bernoulli") == pytest.approx(expected, rel=0.02)
    # moderate rotations: u' = -w'^2/2 without axial force, so that the tip comes back by int w'^2/2 = 3 w^2/5 L
    karman = found.theories["von_karman"].displacement[0, -1]
    assert karman[0] == pytest.approx(-0.6 * linear[1] ** 2 / LENGTH, rel=1e-8)
    assert found.enough == "exact"
    assert "only the exact theory is within 5 %" in found.sentence
    assert "von Karman errs by" in flat(str(found))


@pytest.mark.parametrize("part", [0.5, 2.0])
def test_von_karman_between_hinges(part):
    # closed form of von Karman's beam under a sine load, amplitude 0.5 and 2 radii of gyration
    amplitude = part * np.sqrt(INERTIA / AREA)
    found = hinged(amplitude, constraints=("shear_1", "shear_2")).compare_theories()
    karman = found.theories["von_karman"]
    assert abs(karman.deflection) == pytest.approx(amplitude, rel=1e-6)
    tension = EA * (np.pi * amplitude / LENGTH) ** 2 / 4.0
    assert karman.section_force[0, :, 0] == pytest.approx(np.full(len(found.point_s), tension), rel=1e-5)
    # about it: EI k^4 + N k^2 and, since the sine stretches it too, EA k^4 a^2/2; without inertia along the beam
    k = np.pi / LENGTH
    square = (EI * k**4 + tension * k**2 + 0.5 * EA * k**4 * amplitude**2) / MU
    assert karman.frequencies[0] == pytest.approx(np.sqrt(square) / (2.0 * np.pi), rel=5e-4)
    assert found.error("von_karman") < 0.01
    # the load is larger by a^2/4 r^2 than linear theory needs for this deflection
    assert found.displacement_error("euler_bernoulli") == pytest.approx(part**2 / 4.0, rel=0.03)


def test_frequency_rises_with_amplitude():
    # Woinowsky-Krieger (1950): q'' + w0^2 q + pi^4 EA/(4 mu L^4) q^3 = 0, and for small a the square of the frequency
    # is w0^2 (1 + 3/16 (a/r)^2) with the radius of gyration r
    k = np.pi / LENGTH
    linear = np.sqrt(EI / MU) * k**2
    gyration = np.sqrt(INERTIA / AREA)

    def duffing(a):
        cubic = 0.25 * EA / MU * k**4 * a**2
        m = 0.5 * cubic / (linear**2 + cubic)
        return 0.5 * np.pi * np.sqrt(linear**2 + cubic) / ellipk(m)

    small = 0.01 * gyration
    assert (duffing(small) / linear) ** 2 - 1.0 == pytest.approx(3.0 / 16.0 * 1e-4, rel=1e-3)
    period = 2.0 * np.pi / duffing(gyration)
    found = hinged(gyration, until=0.0, elements=2, order=5).compare_theories(
        period, theory="von_karman", output_interval=period / 40
    )
    middle = found.theories["von_karman"].displacement[:, np.argmin(np.abs(found.s - 0.5 * LENGTH)), 1]
    # after a period it is where it was; the axial inertia, which the closed form leaves out, is felt a little
    assert middle[-1] == pytest.approx(middle[0], rel=2e-3)
    half = middle[np.argmin(np.abs(found.time - 0.5 * period))]
    assert half == pytest.approx(-middle[0], rel=2e-3)
    quarter = np.interp(0.25 * period, found.time, middle)
    assert abs(quarter) < 0.01 * abs(middle[0])


def test_decay_of_a_linear_beam():
    # Euler-Bernoulli with Kelvin-Voigt damping: one mode, w = a exp(-zeta w0 t) (cos wd t + zeta w0/wd sin wd t)
    omega = np.sqrt(EI / MU) * (np.pi / LENGTH) ** 2
    duration = 3.0 / omega * 2.0 * np.pi
    tau = 0.1 / omega
    model = hinged(1e-3, tau=tau, until=0.0, stretching=False, elements=2, order=5)
    found = model.compare_theories(duration, output_interval=duration / 60)
    zeta = 0.5 * tau * omega
    fast = omega * np.sqrt(1.0 - zeta**2)
    t = found.time
    exact = 1e-3 * np.exp(-zeta * omega * t) * (np.cos(fast * t) + zeta * omega / fast * np.sin(fast * t))
    at = np.argmin(np.abs(found.s - 0.5 * LENGTH))
    middle = found.theories["euler_bernoulli"].displacement[:, at, 1]
    assert np.sign(middle[0]) * middle == pytest.approx(exact, abs=2e-6)
    # the exact beam shears and turns: at this amplitude it is Timoshenko's
    assert found.displacement_error("timoshenko") < 2e-3
    assert found.displacement_error("euler_bernoulli") > 2.0 * found.displacement_error("timoshenko")


def test_timoshenko_is_linear_dynamics():
    # an independent formulation: the intrinsic one, linear about the unloaded beam, with linearised damping
    model = beam({"beam.start": None}, tau=TAU, elements=2, order=5)
    model.force("beam.end", (0.0, 0.0, 30.0), time=vr.Sine(5.0))
    found = model.compare_theories(0.1, theory="timoshenko", output_interval=0.01)
    linear = model.simulate(
        0.1,
        formulation="intrinsic",
        damping="linearised",
        dynamics="linear",
        output_interval=0.01,
        tolerance=1e-7,
    )
    wanted = [int(np.argmin(np.abs(linear.time - t))) for t in np.linspace(0.01, 0.1, 10)]
    mine = [int(np.argmin(np.abs(found.time - t))) for t in np.linspace(0.01, 0.1, 10)]
    expected = linear.history("beam.end", "displacement").values[wanted, 2]
    timoshenko = found.theories["timoshenko"].displacement[mine, -1, 1]
    assert timoshenko == pytest.approx(expected, abs=3e-6 * np.abs(expected).max())


def test_frequencies_of_timoshenko_between_hinges():
    # w = W sin kx, phi = P cos kx: two frequencies for every k
    found = hinged(0.0).compare_theories(frequencies=3)
    material = vr.Material(YOUNG, NU, DENSITY)
    C, _, M = vr.Rectangle(SIDE, SIDE).matrices(material)
    kga, rotary = C[0, 0], M[3, 3]
    timoshenko, euler = [], []
    for n in (1, 2, 3):
        k = n * np.pi / LENGTH
        K = np.array([[kga * k**2, -kga * k], [-kga * k, EI * k**2 + kga]])
        squares = np.linalg.eigvals(np.linalg.solve(np.diag([MU, rotary]), K))
        timoshenko.append(np.sqrt(squares.real.min()) / (2.0 * np.pi))
        euler.append(np.sqrt(EI / MU) * k**2 / (2.0 * np.pi))
    assert found.theories["timoshenko"].frequencies == pytest.approx(np.array(timoshenko), rel=1e-4)
    assert found.theories["euler_bernoulli"].frequencies == pytest.approx(np.array(euler), rel=1e-4)
    assert found.exact.frequencies == pytest.approx(np.array(timoshenko), rel=1e-4)


def test_von_karman_of_the_prestressed_bridge():
    """The bridge of Artola, Wynn and Palacios, V.A: von Karman's beam against the independent solution of it."""
    known = table()["von Karman full", 0.001, 1.0]
    found = bridge(0.001, 1.0).compare_theories(1.5, theory="von_karman", output_interval=0.25)
    at = [int(np.argmin(np.abs(found.time - t))) for t in TIMES]
    middle = int(np.argmin(np.abs(found.s - 15.0)))
    karman = found.theories["von_karman"]
    assert -karman.displacement[at, middle, 1] == pytest.approx(known, abs=2e-3)
    # about the prestressed equilibrium, w^2 = k^4 EI/mu (1 - Q/Qcr)
    first = np.sqrt(0.9 * BRIDGE_EI / MASS) * (np.pi / 30.0) ** 2 / (2.0 * np.pi)
    assert karman.frequencies[0] == pytest.approx(first, rel=1e-3)
    assert found.exact.frequencies[0] == pytest.approx(first, rel=2e-3)


def changed(change, **more):
    model = cantilever(1.0, **more)
    change(model)
    return model


def pulled():
    """A beam that only its load keeps from turning."""
    model = beam({"beam.start": (*HINGED, "rz")})
    model.force("beam.end", (1.0, 0.0, 0.0))
    return model


def bent():
    model = vr.Model()
    material = vr.Material(YOUNG, NU, DENSITY)
    line = vr.ThroughPoints([(0, 0, 0), (0.5, 0, 0.1), (1, 0, 0)])
    model.add("beam", vr.Rod(line, section=vr.Circle(0.01), material=material))
    model.clamp("beam.start")
    return model


def turning_over():
    """A flat beam between ball joints, loaded on edge."""
    model = vr.Model()
    material = vr.Material(YOUNG, NU, DENSITY)
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.03), material=material)
    model.add("beam", rod)
    model.pin("beam.start")
    model.pin("beam.end")
    model.force("beam@0.3", (0, 0, 5.0))
    return model


def test_a_bar_under_axial_load_alone():
    # F L/EA in every theory, and no bending that errors could be parts of
    model = beam({"beam.start": None})
    model.force("beam.end", (1000.0, 0.0, 0.0))
    found = model.compare_theories()
    for solution in found.theories.values():
        assert solution.displacement[0, -1] == pytest.approx([1000.0 * LENGTH / EA, 0.0], rel=1e-9, abs=1e-12)
        assert found.error(solution.word) < 1e-6


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (changed(lambda m: m.force("beam.end", (0.0, 1.0, 0.0))), "act in the plane"),
        (changed(lambda m: m.moment("beam.end", (1.0, 0.0, 0.0))), "act in the plane"),
        (changed(lambda m: m.force("beam.end", (0.0, 0.0, 1.0), following=True)), r"loads\[1\].*keep their directions"),
        (changed(lambda m: None, constraints=("stretch",)), "can hold shear only"),
        (changed(lambda m: m.add("b", m.rods["beam"])), "give a model with one rod"),
        (pulled(), "free to move in its plane"),
        (bent(), r"rods\.beam: curved or twisted"),
        (changed(lambda m: m.roller("beam.end", (0, 0.6, 0.8))), "neither in the plane of the beam nor normal"),
        (turning_over(), "the exact beam leaves their plane"),
    ],
)  # fmt: skip
def test_refused(model, message):
    with pytest.raises(InputError, match=message):
        model.compare_theories()


def test_a_case_file_is_compared(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(
        """
        title = "A shelf"
        [materials.wood]
        youngs_modulus = 1.0e10
        poissons_ratio = 0.3
        density = 600.0
        [rods.shelf]
        shape = "straight"
        start = [0.0, 0.0, 0.0]
        end = [1.0, 0.0, 0.0]
        section = { shape = "rectangle", width = 0.02, height = 0.02 }
        material = "wood"
        [[supports]]
        kind = "clamp"
        at = "shelf.start"
        [[supports]]
        kind = "clamp"
        at = "shelf.end"
        [[loads]]
        kind = "force"
        at = "shelf@0.5"
        value = [0.0, 0.0, -1000.0]
        [equilibrium]
        """
    )
    result = CliRunner().invoke(app, ["theories", str(case)])
    assert result.exit_code == 0, result.output
    assert "A shelf" in result.output
    assert "For this load von Karman is enough (within 5 %)" in result.output
    picture = tmp_path / "shelf.png"
    one = CliRunner().invoke(app, ["theories", str(case), "--theory", "timoshenko", "-o", str(picture)])
    assert picture.stat().st_size > 10_000
    assert "only the exact theory" in one.output
    wrong = CliRunner().invoke(app, ["theories", str(case), "--theory", "rayleigh"])
    assert wrong.exit_code != 0
    assert "rayleigh" in wrong.output

"""Modes that are complete: rigid motions as geometry counts them, and elastic ones of closed forms, none invented."""

import functools
import itertools

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq
from scipy.special import jn_zeros

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.modes import linearisation, undamped
from viscorod.solve.modes.linearisation import linearise

STEEL = vr.Material(2.1e11, 0.3, 7850.0)
WORDS = ("ux", "uy", "uz", "rx", "ry", "rz")
LENGTH = 0.5
BAR = vr.Rectangle(0.01, 0.016)
G = 9.81


def rod(start=(0, 0, 0), end=(LENGTH, 0, 0), section=BAR, material=STEEL, **given):
    given = {"elements": 4, "order": 5} | given
    return vr.Rod.straight(start, end, section=section, material=material, **given)


def bar(held=(), **given):
    model = vr.Model()
    model.add("bar", rod(**given))
    if held:
        model.support("bar.start", held)
    return model


@functools.cache
def timoshenko(shear, bending, mass, inertia, moves, turns):
    """Return the angular frequencies of a beam with one free end from its transfer matrix (Timoshenko 1921).

    Args:
        shear, bending: stiffness; mass, inertia: per length; moves, turns: whether the other end may.
    """
    units = np.array([1.0, 1.0 / LENGTH, bending / LENGTH**2, bending / LENGTH**3])
    unknown = [0 if moves else 3, 1 if turns else 2]  # displacement or force, rotation or moment of that end

    def at_the_end(w):
        A = np.array(
            [
                [0, 1, 0, 1 / shear],
                [0, 0, 1 / bending, 0],
                [0, -inertia * w**2, 0, -1],
                [-mass * w**2, 0, 0, 0],
            ]
        )
        transfer = scipy.linalg.expm(A * units / units[:, None] * LENGTH)
        return np.linalg.det(transfer[np.ix_([2, 3], unknown)])

    trial = np.geomspace(20.0, 1.2e5, 400)
    values = [at_the_end(w) for w in trial]
    brackets = [k for k in range(len(trial) - 1) if values[k] * values[k + 1] < 0.0]
    return [brentq(at_the_end, trial[k], trial[k + 1], xtol=1e-9) for k in brackets]


def closed_form(model, held):
    """Return the elastic frequencies [Hz] of a bar with one free end, held at the other as told."""
    part = model.rods["bar"]
    C, _, M = part.matrices_at(0.0)
    found = []
    for word, i in (("ux", 2), ("rx", 5)):
        first = 0.5 if word in held else 1.0
        found += [(first + k) * np.pi * np.sqrt(C[i, i] / M[i, i]) / LENGTH for k in range(3)]
    along_y = int(np.argmax(np.abs(part.frames(0.0)[1].reshape(3, 3)[1, :2])))  # the director along y
    for i, moved, turned in ((along_y, "uy", "rz"), (1 - along_y, "uz", "ry")):
        j = 4 - i  # bending in the plane of a director is about the other
        found += timoshenko(C[i, i], C[j, j], M[i, i], M[j, j], moved not in held, turned not in held)
    return np.sort(found) / (2.0 * np.pi)


@pytest.mark.parametrize("count", range(7))
def test_all_ways_to_hold_one_end(count):
    """Closed forms of stretch, twist and both bendings, and 6 less the held motions for the rigid ones: 64 supports."""
    for held in itertools.combinations(WORDS, count):
        model = bar(held)
        found = model.modes(12 - count, about="reference")
        assert found.rigid == 6 - count, held
        assert found.certified, held
        np.testing.assert_array_equal(found.eigenvalues[: found.rigid], 0.0)
        np.testing.assert_array_equal(found.damping_ratios, 0.0)
        exact = closed_form(model, held)[:6]
        np.testing.assert_allclose(found.frequencies[found.rigid :], exact, rtol=2e-4, err_msg=str(held))


def test_a_free_shaft_begins_with_six():
    """Own Timoshenko elements, quoted to 0.1 Hz, and torsion G/rho/2L; number 7 is the first elastic one."""
    model = vr.Model()
    model.add(
        "shaft", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Annulus(0.01504, 0.0035), material=STEEL)
    )
    found = model.modes(11, about="reference")
    assert found.rigid == 6
    np.testing.assert_array_equal(found.frequencies[:6], 0.0)
    np.testing.assert_array_equal(found.damping_ratios, 0.0)
    exact = [1535.35, 1535.35, 4028.8, 4028.8, 5346.1]
    np.testing.assert_allclose(found.frequencies[6:], exact, rtol=1e-4)
    assert found.names[6:] == ("bend_1 1", "bend_2 1", "bend_1 2", "bend_2 2", "twist 1")
    assert found.names[0] == "translation along x"


def ring(arcs, radius=1.0, section=None):
    model, angles = vr.Model(), np.linspace(0.0, 2.0 * np.pi, arcs + 1)
    for k, a in enumerate(angles[:-1]):
        outward = np.array([np.cos(a), np.sin(a), 0.0])
        part = vr.Rod.arc(
            tuple(radius * outward),
            (-np.sin(a), np.cos(a), 0.0),
            tuple(-outward),
            radius,
            2.0 * np.pi / arcs,
            section=section or vr.Circle(0.01),
            material=STEEL,
            elements=12 // arcs or 1,
            order=5,
        )
        model.add(f"arc{k}", part)
    for k in range(arcs):
        model.attach(f"arc{k}.end", f"arc{(k + 1) % arcs}.start")
    return model


@pytest.mark.parametrize("arcs", [1, 2, 3, 4, 5, 6])
def test_free_rings_of_arcs(arcs):
    """Closed form of thin rings (Love, article 293): pairs in and out of the plane, n = 2 and 3; six rigid motions."""
    model = ring(arcs)
    found = model.modes(14, about="reference")
    assert found.rigid == 6
    assert found.certified
    C, _, M = model.rods["arc0"].matrices_at(0.0)
    n = np.array([2.0, 3.0])
    unit = C[3, 3] / M[0, 0] * n**2 * (n**2 - 1.0) ** 2
    within, across = np.sqrt(unit / (n**2 + 1.0)), np.sqrt(unit / (n**2 + C[3, 3] / C[5, 5]))
    exact = np.sort(np.repeat([within, across], 2)) / (2.0 * np.pi)
    np.testing.assert_allclose(found.frequencies[6:], exact, rtol=1e-3)
    np.testing.assert_array_equal(found.damping_ratios, 0.0)


def test_the_slowest_mode_of_a_slender_ruler_gets_its_damping():
    """Euler-Bernoulli, 1.8751^2/(2 pi) sqrt(E h^2/12 rho)/L^2 = 15.42 Hz, with the ratio 0.05/2 pi of its decrement."""
    damping = vr.MeasuredDamping(logarithmic_decrement=0.05, mode="bend_1 1")
    material = vr.Material(7e10, 0.33, 2700.0, damping=damping)
    model = vr.Model()
    model.add(
        "ruler",
        vr.Rod.straight(
            (0, 0, 0), (0.4, 0, 0), d1=(0, 1, 0), section=vr.Rectangle(0.025, 0.003), material=material
        ),
    )
    model.clamp("ruler.start")
    found = model.modes(2, about="reference")
    assert found.frequencies[0] == pytest.approx(15.42, rel=1e-3)
    assert found.damping_ratios[0] == pytest.approx(0.05 / (2.0 * np.pi), rel=1e-4)
    assert found.names == ("bend_1 1", "bend_1 2")


def test_a_pendulum_on_a_hinge():
    """Closed form: (m g L/2)/(m L^2/3 + rotary inertia) with gravity; without, it turns freely and bends as before."""
    model = vr.Model()
    model.add("bar", rod(end=(0, 0, -LENGTH)))
    model.support("bar.start", ("ux", "uy", "uz", "rx", "rz"))
    model.gravity((0, 0, -G))
    hanging, free = model.modes(3), model.modes(3, about="reference")
    _, _, M = model.rods["bar"].matrices_at(0.0)
    about_y = model.rods["bar"].frames(0.0)[1].reshape(3, 3)[1]
    inertia = M[0, 0] * LENGTH**3 / 3.0 + about_y @ M[3:, 3:] @ about_y * LENGTH
    exact = np.sqrt(M[0, 0] * G * LENGTH**2 / 2.0 / inertia) / (2.0 * np.pi)
    assert hanging.frequencies[0] == pytest.approx(exact, rel=1e-5)
    assert hanging.names[0] == "swing 1"
    assert (hanging.rigid, free.rigid) == (0, 1)
    np.testing.assert_allclose(hanging.frequencies[1:], free.frequencies[1:], rtol=2e-3)


@pytest.mark.parametrize("stiffness", [1e-6, 1e-2])
def test_a_soft_spring_is_not_round_off(stiffness):
    """Closed form: a rod on a hinge, 1e14 times stiffer than its spring: w^2 = k L^2/(m L^2/3 + rotary inertia)."""
    model = bar(("ux", "uy", "uz", "rx", "ry"))
    model.spring("bar.end", stiffness={"uy": stiffness})
    found = model.modes(1, about="reference")
    _, _, M = model.rods["bar"].matrices_at(0.0)
    frames = model.rods["bar"].frames(0.0)[1].reshape(3, 3)
    about_z = frames[2] @ M[3:, 3:] @ frames[2]
    exact = stiffness * LENGTH**2 / (M[0, 0] * LENGTH**3 / 3.0 + about_z * LENGTH)
    assert (2.0 * np.pi * found.frequencies[0]) ** 2 == pytest.approx(exact, rel=1e-6)
    assert found.rigid == 0
    assert found.names == ("spring 1",)


def chain(links, joint, *, free):
    model = vr.Model()
    for k in range(links):
        model.add(f"link{k}", rod((k * LENGTH, 0, 0), ((k + 1) * LENGTH, 0, 0), elements=1))
    if not free:
        joint(model, "ground", "link0.start")
    for k in range(1, links):
        joint(model, f"link{k - 1}.end", f"link{k}.start")
    return model


@pytest.mark.parametrize("links", [1, 2, 5])
def test_chains_are_mechanisms(links):
    """Counted: a hinge frees 1 motion, a ball joint 3; 6 more of a free chain."""
    hinge, ball = (lambda m, a, b: m.revolute(a, b, (0, 0, 1))), (lambda m, a, b: m.ball(a, b))
    for joint, each in ((hinge, 1), (ball, 3)):
        for way, first in ((False, each), (True, 6)):
            found = chain(links, joint, free=way).modes(40, about="reference")
            assert found.rigid == first + each * (links - 1)
            assert found.frequencies[found.rigid] > 1.0
            assert found.certified


def test_links_between_hinges_bend_as_free_ones():
    """Closed form: a chain of two links on hinges that twists and bends across them; stretch of 2 L held at one end."""
    model = chain(2, lambda m, a, b: m.revolute(a, b, (0, 0, 1)), free=False)
    found = model.modes(30, about="reference")
    C, _, M = model.rods["link0"].matrices_at(0.0)
    stretch = 0.25 * np.sqrt(C[2, 2] / M[2, 2]) / (2.0 * LENGTH)
    named = found.frequencies[list(found.names).index("stretch 1")]
    assert named == pytest.approx(stretch, rel=1e-4)


@pytest.mark.parametrize(("load", "grows"), [(15.0, False), (20.0, False), (20.1, True)])
def test_flutter_of_a_column_under_a_following_load(load, grows):
    """Beck (1952): a cantilever under a following force flutters from 20.05 EI/L^2 on; below nothing grows."""
    model = vr.Model()
    section = vr.Circle(0.001)
    model.add(
        "column", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section, material=STEEL, elements=4, order=5)
    )
    model.clamp("column.start")
    C, _, _ = model.rods["column"].matrices_at(0.0)
    model.force("column.end", (0, 0, -load * C[3, 3]), following=True)
    found = model.modes(4)
    assert bool(found.eigenvalues.real.max() > 1e-3) is grows
    if not grows:
        np.testing.assert_array_equal(found.damping_ratios, 0.0)
    assert found.residuals.max() < 1e-6


@pytest.mark.parametrize("part", [0.5, 2.0])
@pytest.mark.parametrize("elements", [4, 40])
def test_a_dashpot_at_the_end_of_a_bar(part, elements, monkeypatch):
    """Closed form: tanh(s L/a) = -EA/(a c), of which one root is real where the dashpot exceeds the impedance EA/a.

    Full matrices, and Ritz vectors that are refined.
    """
    if elements > 4:
        for module in (linearisation, undamped):
            monkeypatch.setattr(module, "DENSE", 0)
    model = bar(("ux", "uy", "uz", "rx", "ry", "rz"), elements=elements)
    C, _, M = model.rods["bar"].matrices_at(0.0)
    speed = np.sqrt(C[2, 2] / M[2, 2])
    for word in ("uy", "uz"):
        model.spring("bar.end", stiffness={word: 1e13})
    model.spring("bar.end", stiffness={"ux": 0.0}, damping={"ux": part * C[2, 2] / speed})
    found = model.modes(60, about="reference")
    mine = found.eigenvalues[found.shares[:, 2] > 0.99]
    n = np.arange(1, 4)
    rate = np.arctanh(min(part, 1.0 / part))
    exact = speed / LENGTH * (-rate + 1j * np.pi * (n - 0.5 if part < 1.0 else n))
    if part > 1.0:
        exact = np.append(speed / LENGTH * -rate, exact)
    for s in exact[:3]:
        assert np.abs(mine - s).min() < 1e-5 * abs(s)
    assert found.residuals.max() < 1e-6


def test_rates_that_crowd_do_not_fill_the_list():
    """Closed form of damping in proportion to stiffness: s^2 + tau w^2 s + w^2 = 0; creeping roots crowd at -1/tau."""
    tau, elastic = 2e-4, bar(WORDS).modes(20, about="reference")
    w = 2.0 * np.pi * elastic.frequencies
    damped = vr.Material(2.1e11, 0.3, 7850.0, damping=vr.KelvinVoigt(tau, tau))
    for elements in (4, 17):
        model = bar(WORDS, material=damped, elements=elements)
        found = model.modes(12, about="reference")
        # in the order of the undamped frequencies, both roots of an overdamped mode side by side
        exact = []
        for each in w:
            pair = np.roots([1.0, tau * each**2, each**2])
            pair = pair[np.argsort(np.abs(pair))]
            exact += [pair[pair.imag > 0.0][0]] if abs(pair[0].imag) > 0.0 else list(pair)
        np.testing.assert_allclose(found.eigenvalues, exact[:12], rtol=2e-4)
        alone = model.modes(50, about="reference", oscillating=True)
        assert (alone.damping_ratios < 1.0).all()
        assert len(alone.frequencies) == np.count_nonzero(w * tau < 2.0)
        i, j = np.flatnonzero(found.eigenvalues.imag == 0.0)[:2]
        assert found.names[i] == found.names[j]


def test_what_a_dashpot_alone_resists_creeps():
    """Closed form: a bar of mass m that slides against a dashpot, s = -c/m, and the rigid motion itself."""
    model = bar(("uy", "uz", "rx", "ry", "rz"))
    model.spring("bar.start", stiffness={"ux": 0.0}, damping={"ux": 3.0})
    found = model.modes(2, about="reference")
    assert found.rigid == 1
    assert found.eigenvalues[1] == pytest.approx(-3.0 / model.rods["bar"].mass, rel=1e-6)
    assert found.names == ("translation along x", "damper 1")


@pytest.mark.parametrize("dense", [10**6, 0])
def test_modes_near_a_frequency(dense, monkeypatch):
    """They are those of the whole list, with their names, and the count proves that none between is missing."""
    whole = bar(elements=12).modes(40, about="reference")
    for module in (linearisation, undamped):
        monkeypatch.setattr(module, "DENSE", dense)
    middle = 0.5 * (whole.frequencies[25] + whole.frequencies[26])
    found = bar(elements=12).modes(6, about="reference", near=middle)
    nearest = np.sort(np.argsort(np.abs(whole.frequencies - middle))[:6])
    np.testing.assert_allclose(found.frequencies, whole.frequencies[nearest], rtol=1e-7)
    assert found.names == tuple(whole.names[k] for k in nearest)
    assert found.certified


def test_the_count_of_pivots_finds_what_iteration_misses(monkeypatch):
    """Round bars bend alike in two planes: where an iteration has one of each pair, the others are found beside it."""
    problem = DiscreteModel.of(bar(WORDS, section=vr.Circle(0.01), elements=12))
    linear = linearise(problem.static, State.reference(problem.problem), scale=0.0)
    full = undamped.undamped_modes(linear, 8)
    monkeypatch.setattr(undamped, "DENSE", 0)
    whole, calls = undamped._lanczos, []

    def careless(*arguments):
        values, vectors = whole(*arguments)
        calls.append(len(values))
        return (values[::2], vectors[:, ::2]) if len(calls) == 1 else (values, vectors)

    monkeypatch.setattr(undamped, "_lanczos", careless)
    found = undamped.undamped_modes(linear, 8)
    assert len(calls) > 1
    assert found.certified
    np.testing.assert_allclose(found.squares[:8], full.squares[:8], rtol=1e-7)


def test_shares_of_the_strain_energy():
    """A straight bar bends, twists and stretches apart; shares are parts of one, and none of a rigid motion."""
    found = bar().modes(16, about="reference")
    np.testing.assert_array_equal(found.shares[:6], 0.0)
    np.testing.assert_allclose(found.shares[6:].sum(axis=1), 1.0, rtol=1e-12)
    for name, share in zip(found.names[6:], found.shares[6:], strict=True):
        if name.startswith(("twist", "stretch")):
            assert share.max() == pytest.approx(1.0, rel=1e-9)


def string(tension, stretching):
    """A string that neither bends nor twists at any cost, of mass 1 kg/m, pulled between pins."""
    EA, length = stretching, 100.0
    section = vr.StiffnessSection([EA / 2, EA / 2, EA, 0, 0, 0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    cable = vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, elements=8, order=4)
    model.add("string", cable)
    model.pin("string.start")
    model.support("string.end", ("uy", "uz"), motion={"ux": tension / EA * length})
    return model


@pytest.mark.parametrize(
    ("mesh", "around"),
    [({}, 0.0), ({"elements": 40, "order": 2}, 0.0), ({"elements": 30, "order": 3}, 1e-12)],
)
def test_a_hanging_cable_spins_about_its_own_line(mesh, around):
    """Irvine (1981): sidewise and antisymmetric modes of a cable, ``tan x = x - (4/lambda^2) x^3`` of symmetric ones.

    That all its sections turn about its line strains nothing on any mesh: one motion at 0 Hz that does not grow. A drag
    against it alone, however weak, gives that one motion a rate (moment over inertia), and moves nothing else.
    """
    L, H, EA, g, mass = 100.0, 5000.0, 1e6, 9.81, 1.0
    sag = mass * g * L**2 / (8.0 * H)
    natural = L * (1.0 + 8.0 / 3.0 * (sag / L) ** 2) - H * L / EA * (1.0 + 16.0 / 3.0 * (sag / L) ** 2)
    section = vr.StiffnessSection([EA / 2, EA / 2, EA, 0, 0, 0], [mass] * 3 + [1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("string", vr.Rod.straight((0, 0, 0), (natural, 0, 0), section=section, **mesh))
    model.pin("string.start")
    model.support("string.end", ("uy", "uz"), motion={"ux": L - natural})
    model.gravity((0, 0, -g))
    if around:
        model.drag("string", linear_about=around)
    found = model.modes(5)
    assert found.names[0] == "free of stiffness"
    assert found.rigid == 1
    if around:
        # the radius of gyration of a cable, see model.cable
        assert found.eigenvalues[1] == pytest.approx(-around / (mass * (1e-5 * natural) ** 2), rel=1e-6)
    assert found.eigenvalues.real.max() < 1e-12
    elastic = (mass * g * L / H) ** 2 * EA / (H * (1.0 + 8.0 * (sag / L) ** 2))
    x = brentq(lambda x: np.tan(x) - x + 4.0 / elastic * x**3, np.pi / 2 + 1e-6, 3.0 * np.pi / 2 - 1e-6)
    string_like = np.sqrt(H / mass) / (2.0 * L)
    expected = [string_like, 2.0 * x / np.pi * string_like, 2.0 * string_like]
    listed = 2 if around else 1
    assert found.frequencies[listed : listed + 3] == pytest.approx(sorted(expected), rel=4e-3)


@pytest.mark.parametrize("damper", [1e-3, 1e-14, 1e-18])
def test_a_rod_that_slides_almost_without_resistance_vibrates_as_ever(damper):
    """A sliding rod dies away by ``damper / mass``; its roots ``1/s`` would hide those of bending."""
    model = vr.Model()
    steel = vr.Material(2e11, 0.3, 7850.0, damping=vr.KelvinVoigt(1e-4, 1e-4))
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=steel))
    model.support("rod.start", ("uy", "uz", "rx", "ry", "rz"))
    model.spring("rod.start", damping={"ux": damper})
    found = model.modes(4, about="reference")
    assert found.eigenvalues[1] == pytest.approx(-damper / model.mass, rel=1e-9)
    bending = 3.5160153**2 * 2e11 * 0.005**2 / 4 / 7850.0
    assert np.abs(found.eigenvalues[2:]) == pytest.approx(np.sqrt(bending), rel=1e-4)
    assert found.damping_ratios[2:] == pytest.approx(0.5e-4 * np.sqrt(bending), rel=1e-4)


def test_a_string_with_a_damper_near_its_end():
    """Krenk (2000): with ``b`` the wave number, ``sin bL + i c/sqrt(Tm) sin ba sin b(L - a) = 0``.

    The damper stands on the axis about which the string may spin, and does not resist that.
    """
    T, L, a, EA = 1e3, 100.0, 2.0, 1e6
    c = np.sqrt(T) / (np.pi * a / L)  # the best one for the first mode
    model = string(T, EA)
    model.spring(f"string@{a}", damping={"uz": c})
    found = model.modes(4, oscillating=True)
    inside = T / (1.0 + T / EA)  # per length before it was pulled
    b = np.pi / L * (1.0 + 0.01j)
    for _ in range(30):  # Newton's method with differences

        def left(b):
            return np.sin(b * L) + 1j * c / np.sqrt(inside) * np.sin(b * a) * np.sin(b * (L - a))

        b = b - left(b) * 1e-7 * b / (left(b * (1.0 + 1e-7)) - left(b))
    frequencies = sorted([abs(b) * np.sqrt(inside) / (2.0 * np.pi), np.sqrt(inside) / (2.0 * L)])
    assert found.frequencies[:2] == pytest.approx(frequencies, rel=3e-4)
    assert found.damping_ratios[:2] == pytest.approx([0.0, b.imag / abs(b)], rel=0.01, abs=1e-12)
    assert b.imag / abs(b) == pytest.approx(0.5 * a / L, rel=0.03)


def test_a_body_that_hangs_loose_on_a_loaded_rod_turns_freely():
    """Three free turns, by geometry, and the vibrations of a cantilever with a mass at its end, also under a load.

    ``1 + cos b cosh b = (M/m L) b (sin b cosh b - cos b sinh b)``; ``M`` is the mass of the body along the line from
    the joint to its centre, and across it ``m/(1 + m d^2/I)``, since a push there turns it away.
    """
    E, rho, r, L, m, d = 1e7, 1000.0, 0.01, 0.5, 0.05, 0.1
    material = vr.Material(E, 0.3, rho, damping=vr.KelvinVoigt(0.002, 0.002))
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=vr.Circle(r), material=material))
    model.clamp("rod.start")
    model.force("rod.end", (0, 1e-4, 1e-4))
    model.add("bob", vr.Sphere(radius=0.02, centre=(L, 0, -d), mass=m))
    model.ball("rod.end", "bob")
    found = model.modes(5)
    assert found.rigid == 3
    line = rho * np.pi * r**2

    def frequency(mass):
        part = mass / (line * L)
        b = brentq(
            lambda b: (
                1 + np.cos(b) * np.cosh(b) - part * b * (np.sin(b) * np.cosh(b) - np.cos(b) * np.sinh(b))
            ),
            0.1,
            1.8751,
        )
        return b**2 / L**2 * np.sqrt(E * np.pi * r**4 / 4 / line) / (2 * np.pi)

    inertia = 0.4 * m * 0.02**2
    expected = [frequency(m), frequency(m / (1.0 + m * d**2 / inertia))]
    assert found.frequencies[3:] == pytest.approx(expected, rel=2e-3)


def test_more_modes_than_a_mesh_has_are_cut_and_told():
    """As many as the first mesh can have, each as good as of few; a mesh that was given has those of its matrices."""
    free = bar(WORDS, elements=None, order=None)
    many = free.modes(100_000)
    few = free.modes(20)
    assert 40 < len(many.frequencies) < 100
    np.testing.assert_allclose(many.frequencies[:20], few.frequencies, rtol=1e-3)
    assert many.frequency_errors.max() < 1e-2
    told = f"100000 modes were asked for, and {len(many.frequencies)} are listed"
    assert any(told in text for text in many.warnings)
    assert few.warnings == []
    given = bar(WORDS).modes(100_000)
    assert len(given.frequencies) == 6 * 20  # nodes that are not held, undamped
    assert any("120 are listed, all that the mesh has" in text for text in given.warnings)


@pytest.mark.parametrize("axial", [1e4, 1e6])
def test_a_chain_that_hangs_swings_as_bernoulli_says(axial):
    """``omega_k = j_0k/2 sqrt(g/L)`` with the zeros of J_0 (Daniel Bernoulli 1732), whatever its axial stiffness.

    What gives the sections of a cable their direction bends, the more waves a vibration has.
    """
    section = vr.StiffnessSection([axial] * 3 + [0.0] * 3, [0.1] * 3 + [1e-7, 1e-7, 2e-7])
    model = vr.Model()
    model.add("chain", vr.Rod.straight((0, 0, 0), (0, 0, -1), section=section))
    model.pin("chain.start")
    model.gravity((0, 0, -9.81))
    found = model.modes(7)
    expected = jn_zeros(0, 3) / 2.0 * np.sqrt(9.81) / (2.0 * np.pi)
    assert found.frequencies[0] == 0.0  # it may spin about its line
    assert found.frequencies[1:] == pytest.approx(np.repeat(expected, 2), rel=1e-4)

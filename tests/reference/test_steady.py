"""Steady rotations against closed forms, tables, boundary value problems, and between the two formulations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial
from scipy.integrate import solve_bvp
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import viscorod as vr
from helpers.plain_text import flat
from reference.cases import cantilever, slope, stiff

FORMULATIONS = ("geometric", "intrinsic")

# eta -> mu of three flap modes: Wright et al. 1982, Hodges and Rutkowski 1981; also computed independently (case C8)
FLAP = {
    1: (3.68165, 22.18101, 61.84176),
    2: (4.13732, 22.61492, 62.27318),
    4: (5.58500, 24.27335, 63.96676),
    8: (9.25684, 29.99538, 70.29296),
    12: (13.17015, 37.60311, 79.61448),
}


def thin(ratio, hub=0.0, elements=4, order=7):
    """A cantilever with EI = L = rhoA = 1 that stretches, shears and resists turning by ``ratio`` squared."""
    section = vr.StiffnessSection(
        [ratio**-2] * 3 + [1.0] * 3, [1.0, 1.0, 1.0, ratio**2, ratio**2, 2.0 * ratio**2]
    )
    model = vr.Model()
    rod = vr.Rod.straight((hub, 0, 0), (hub + 1, 0, 0), section=section, elements=elements, order=order)
    model.add("blade", rod)
    model.clamp("blade.start")
    return model


@lru_cache
def bernoulli(eta, formulation, hub=0.0):
    """Flap and lag frequencies (rad/s) of three pairs of modes in the limit of a thin rod.

    Extrapolated from two ratios: what a thick rod adds is of second order in the ratio (rotary inertia, shear,
    stretching), the rest of fourth.
    """
    values = []
    for ratio in (1e-3, 2e-3):
        found = thin(ratio, hub).steady(spin=(0, 0, float(eta)), formulation=formulation)
        values.append(found.eigenvalues.imag)
    limit = (4.0 * values[0] - values[1]) / 3.0
    return limit[1::2], limit[0::2]


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("eta", FLAP)
def test_flap_of_a_rotating_cantilever(eta, formulation):
    """C8 [Wright et al. 1982; Hodges and Rutkowski 1981]: to the last printed digit."""
    flap, _ = bernoulli(eta, formulation)
    assert flap == pytest.approx(FLAP[eta], rel=0, abs=1e-5)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("eta", FLAP)
def test_lag_of_a_rotating_cantilever(eta, formulation):
    """C8: in the plane the centrifugal field takes ``eta^2`` from the square of the frequency.

    Extrapolation leaves 1e-6 of the third frequency.
    """
    flap, lag = bernoulli(eta, formulation)
    assert lag**2 == pytest.approx(flap**2 - eta**2, rel=1e-6)


def galerkin(eta, hub, count=10):
    """Flap frequencies of a Bernoulli blade on a hub of radius ``hub``: Galerkin's method with polynomials."""
    # s^2 times Legendre polynomials of [0, 1]
    trial = [Polynomial([0, 0, 1]) * Legendre.basis(k, [0, 1]).convert(kind=Polynomial) for k in range(count)]
    s = Polynomial([0, 1])
    tension = eta**2 * (0.5 * (1 - s**2) + hub * (1 - s))

    def matrix(form):
        def whole(p):
            return p.integ()(1.0) - p.integ()(0.0)

        return np.array([[whole(form(a, b)) for b in trial] for a in trial])

    K = matrix(lambda a, b: a.deriv(2) * b.deriv(2) + tension * a.deriv() * b.deriv())
    M = matrix(lambda a, b: a * b)
    return np.sqrt(eigh(K, M, eigvals_only=True)[:3])


def test_galerkin_itself():
    """The independent solution of the next test reproduces the table at hub radius 0."""
    assert galerkin(4.0, 0.0) == pytest.approx(FLAP[4], rel=0, abs=6e-6)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("hub", [0.5, 2.0])
def test_hub_radius(hub, formulation):
    """Independent solution (Galerkin, polynomials): a blade that begins away from the axis.

    Tolerance as for the table; in the plane ``eta^2`` is taken off as with hub radius 0.
    """
    flap, lag = bernoulli(4, formulation, hub)
    expected = galerkin(4.0, hub)
    assert flap == pytest.approx(expected, rel=3e-7)
    assert lag**2 == pytest.approx(expected**2 - 16.0, rel=1e-6)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_stretch_of_a_rotating_arm(formulation):
    """Closed form (C9): ``u(L) = tan(a L)/a - L``, ``a^2 = rhoA Omega^2/EA``.

    Exact here: the stretch is measured per reference length and the load follows the displaced mass.
    """
    section = vr.StiffnessSection([1e7, 1e7, 2.8e7, 1.4e4, 1.4e4, 1e4], [1.2, 1.2, 1.2, 6e-4, 6e-4, 1.2e-3])
    model = cantilever(section, length=10.0, elements=2, order=5)
    found = model.steady(spin=(0, 0, 6.0), formulation=formulation)
    a = np.sqrt(1.2 * 6.0**2 / 2.8e7)
    expected = np.tan(10.0 * a) / a - 10.0
    assert expected == pytest.approx(5.1431e-4, abs=1e-8)
    moved = found.displacement("beam.end")
    assert moved == pytest.approx([expected, 0.0, 0.0], rel=1e-8, abs=1e-12)
    assert found.rotation("beam.end") == pytest.approx(np.zeros(3), abs=1e-12)
    pull = found.reactions.sel(support="beam.start").values
    # the force on the hub is EA (r' - 1) at its centre
    assert pull[0] == pytest.approx(-2.8e7 * (1.0 / np.cos(10.0 * a) - 1.0), rel=1e-6)
    assert found.spin == pytest.approx([0.0, 0.0, 6.0])


# --- a bent rod that whirls about a ball joint (Artola, Wynn and Palacios, section V.B)

AWP_STIFFNESS = [5e3, 5e3, 1e4, 1.0, 2.0, 1.0]
AWP_MASS = [1.0, 1.0, 1.0, 2e-4, 2e-4, 4e-4]


def hinged(elements=4, order=5, eta=1e-3):
    model = vr.Model()
    section = vr.StiffnessSection(AWP_STIFFNESS, AWP_MASS, [eta * c for c in AWP_STIFFNESS])
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=order))
    model.pin("beam.start")
    return model


@lru_cache
def whirling(formulation, energy, elements=4, order=5, modes=12):
    return hinged(elements, order).steady(energy=energy, formulation=formulation, modes=modes)


@lru_cache
def continuous_whirl(energy):
    """The continuous steady equations in the plane of the bent rod and the axis, by collocation (SciPy).

    With the angle t from the axis x, the distance y from it, force across it Q (that along it vanishes: the end is
    free), moment m about the normal of the plane:

        x' = (1 + e) cos t - g sin t,  y' = (1 + e) sin t + g cos t,  t' = m/EI,  Q' = -mu W^2 y,
        m' = -x' Q + (J_axis - J_across) W^2 sin t cos t,  e = Q sin t/EA,  g = Q cos t/GA.

    Returns:
        angular speed, tip (x, |y|), elastic energy, angular momentum, largest bending strain.
    """
    GA, EA, EI = AWP_STIFFNESS[0], AWP_STIFFNESS[2], AWP_STIFFNESS[3]
    across, axial = AWP_MASS[3], AWP_MASS[5]

    def densities(z, W):
        y, t, Q, m = z[1:5]
        kinetic = 0.5 * W**2 * (y**2 + axial * np.cos(t) ** 2 + across * np.sin(t) ** 2)
        elastic = 0.5 * (m**2 / EI + (Q * np.sin(t)) ** 2 / EA + (Q * np.cos(t)) ** 2 / GA)
        return kinetic, elastic

    def slopes(s, z, p):
        _, y, t, Q, m, _, _ = z
        W = p[0]
        e, g = Q * np.sin(t) / EA, Q * np.cos(t) / GA
        x_ = (1 + e) * np.cos(t) - g * np.sin(t)
        y_ = (1 + e) * np.sin(t) + g * np.cos(t)
        m_ = -x_ * Q + (axial - across) * W**2 * np.sin(t) * np.cos(t)
        kinetic, elastic = densities(z, W)
        return np.array([x_, y_, m / EI, -(W**2) * y, m_, kinetic, elastic])

    def ends(a, b, p):
        return np.array([a[0], a[1], a[4], b[3], b[4], a[5], a[6], b[5] + b[6] - energy])

    # the mode of a hinged-free Bernoulli rod, at an amplitude like that of the solution
    s = np.linspace(0.0, 1.0, 81)
    beta, W = 3.92660231, 15.8
    sine, sinh = np.sin(beta * s) / np.sin(beta), np.sinh(beta * s) / np.sinh(beta)
    y = 0.07 * (sine + sinh)
    t = np.gradient(y, s)
    m = 0.07 * EI * beta**2 * (sinh - sine)
    Q = -np.gradient(m, s)
    guess = np.array([s, y, t, Q, m, 0.3 * s, 0.2 * s])
    found = solve_bvp(slopes, ends, s, guess, p=[W], tol=1e-11, max_nodes=100_000, bc_tol=1e-12)
    assert found.success, found.message
    W = float(found.p[0])
    kinetic, elastic = found.y[5, -1], found.y[6, -1]
    return W, found.y[0, -1], abs(found.y[1, -1]), elastic, 2.0 * kinetic / W, np.abs(found.y[4]).max() / EI


def described(found):
    """The same numbers as :func:`continuous_whirl`."""
    axis = found.spin / np.linalg.norm(found.spin)
    tip = found.position("beam.end")
    across = np.linalg.norm(tip - (tip @ axis) * axis)
    momentum = np.linalg.norm(found.angular_momentum)
    return np.array([np.linalg.norm(found.spin), abs(tip @ axis), across, found.elastic_energy, momentum])


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_whirling_rod(formulation):
    """Independent solution (SciPy's collocation of the continuous equations) of a bent rod about its ball joint.

    Elements of order 5 err by 1e-9 to 1e-8; positions round off to 1e-10 of the stiff forces.
    """
    expected = continuous_whirl(0.5)
    found = whirling(formulation, 0.5)
    assert described(found) == pytest.approx(expected[:5], rel=1e-7)
    # bent about the less stiff axis only
    strain = found.data["strain"].values[-1]
    assert np.abs(strain[:, [0, 4, 5]]).max() < 1e-9
    assert np.abs(strain[:, 3]).max() == pytest.approx(expected[5], rel=0.01)
    assert np.linalg.norm(np.cross(found.angular_momentum, found.spin)) < 1e-9 * np.linalg.norm(
        found.angular_momentum
    ) * np.linalg.norm(found.spin)


def test_balance_of_the_whirling_rod():
    """AWP (20): the balance of the intrinsic equations, strain rates included, is fulfilled to round-off."""
    assert whirling("intrinsic", 0.5).residual < 1e-13
    assert whirling("geometric", 0.5).residual < 1e-9  # positions round off before they are multiplied by EA


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_convergence_of_the_whirling_rod(formulation):
    """Order of convergence: elements of order p and p Gauss points, 2 p for the angular speed and energies."""
    expected = np.array(continuous_whirl(0.5)[:5])
    errors = [np.abs(described(whirling(formulation, 0.5, n, 2)) / expected - 1).max() for n in (4, 8, 16)]
    assert slope([4, 8, 16], errors) == pytest.approx(-4.0, abs=0.4)


@pytest.mark.parametrize("given", ["spin", "momentum"])
def test_same_rotation_by_other_measures(given):
    """Consistency: the rotation found by its energy is found by its angular speed and by its angular momentum."""
    found = whirling("intrinsic", 0.5)
    value = float(np.linalg.norm(found.spin if given == "spin" else found.angular_momentum))
    again = hinged().steady(**{given: value}, formulation="intrinsic")
    assert described(again) == pytest.approx(described(found), rel=1e-8)


def test_eigenvalues_of_both_formulations():
    """Equivalence: small motions about the whirling rod in poses and in intrinsic variables converge to each other."""
    differences = []
    for elements in (3, 6):
        s = [whirling(f, 0.5, elements, 3).eigenvalues for f in FORMULATIONS]
        differences.append(np.max(np.abs(s[0] - s[1])[1:] / np.abs(s[0])[1:]))
    assert differences[0] / differences[1] > 2**5  # order 2 p = 6
    s = [whirling(f, 0.5, 6, 5).eigenvalues for f in FORMULATIONS]
    assert s[0][1:] == pytest.approx(s[1][1:], rel=1e-7)
    # spinning a bit faster is neutral, and simple
    assert abs(s[0][0]) < 1e-9
    assert abs(s[1][0]) < 1e-9


def test_whirling_rod_is_all_but_stable():
    """Both formulations agree on a precession that damping lets grow, by e in a month and a half; all else fades."""
    for formulation in FORMULATIONS:
        found = whirling(formulation, 0.5)
        assert not found.stable
        assert found.growth_rate == pytest.approx(2.8775e-7, rel=2e-3)
        assert found.neutral == 1
        assert found.eigenvalues[2:].real.max() < -0.1


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_whirling_rod_keeps_whirling(formulation):
    """Solvers against each other: a transient that starts from the steady rotation keeps its strains for 3 turns."""
    from viscorod.analyses.discrete import DiscreteModel
    from viscorod.analyses.motion_stepping import integrator_makers, stepping
    from viscorod.solve.settings.motion import SimulateSettings
    from viscorod.solve.settings.steady import SteadySettings
    from viscorod.solve.steady.rotation_search import Search
    from viscorod.solve.transient.transient_solver import Transient

    model = hinged(4, 4)
    work = DiscreteModel.of(model, formulation=(formulation, "full"))
    found = Search(work.static, SteadySettings(energy=0.5, formulation=formulation), None).run()
    duration = 3.0 * 2.0 * np.pi / float(np.linalg.norm(found.spin))
    settings = SimulateSettings(duration, tolerance=1e-8, formulation=formulation, initial="reference")
    make, _ = integrator_makers(work, settings, found.state)
    integrator, control, _ = stepping(
        work, settings, None, make
    )  # a given tolerance asks for no small motions
    run = Transient(work.problem, integrator, control).run(
        found.state.copy(), duration, output_interval=None, progress=None
    )
    last = run.history.snapshots[-1]
    largest = np.abs(found.strain).max()
    assert last.strain == pytest.approx(found.strain, abs=1e-6 * largest)
    assert last.kinetic + last.elastic == pytest.approx(found.kinetic + found.elastic, rel=1e-8)
    # and it has turned: three times
    assert last.state.r == pytest.approx(found.state.r, abs=1e-5)


# --- straight rotations, damping, stability


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_straight_rotations_are_found(formulation):
    """Closed form: from the reference shape a hinged rod spins about itself, or stretched about a transverse axis."""
    model = hinged()
    about_itself = model.steady(spin=10.0, axis=(1, 0, 0), formulation=formulation)
    assert about_itself.kinetic_energy == pytest.approx(0.5 * 4e-4 * 100.0, rel=1e-12)
    assert np.abs(about_itself.data["strain"].values).max() < 1e-12
    across = model.steady(momentum=4.0, axis=(0, 0, 1), formulation=formulation)
    W = np.linalg.norm(across.spin)
    a = W / np.sqrt(1e4)
    assert across.position("beam.end") == pytest.approx([np.tan(a) / a, 0.0, 0.0], abs=1e-10)
    assert across.angular_momentum == pytest.approx([0.0, 0.0, 4.0], abs=1e-9)
    assert across.stable


def test_linearised_damping_leaves_the_spin_about_the_rods_own_axis():
    """AWP (33) and V.B: the steady rotation is the unstressed spin of the straight rod about itself.

    The paper's 12.963 rad/s have 0.0336 J. Small motions fade, but for a spin that is a bit faster and for the
    precession of a rod that does not bend, ``s = i W (J - J_axis)/J``, which hardly notices damping.
    """
    found = hinged().steady(spin=12.963, formulation="intrinsic", damping="linearised", modes=20)
    assert found.spin == pytest.approx([12.963, 0.0, 0.0], abs=1e-9)
    assert found.kinetic_energy == pytest.approx(0.0336, abs=5e-5)
    assert np.abs(found.data["strain"].values).max() < 1e-12
    assert found.residual < 1e-13
    assert found.stable
    J = 1.0 / 3.0 + 2e-4
    precession = found.eigenvalues[np.argmin(np.abs(found.eigenvalues - 12.963j))]
    assert precession == pytest.approx(12.963j * (1.0 - 4e-4 / J), rel=1e-6)
    fading = found.eigenvalues[(found.eigenvalues != precession) & (np.abs(found.eigenvalues) > 1e-6)]
    assert fading.real.max() < -0.1


@pytest.mark.parametrize("damping", ["full", "linearised"])
def test_spin_about_itself_above_the_first_frequency_of_bending(damping):
    """Closed form: beyond the frequency of its softer bending, 15.36 rad/s, the spinning rod buckles in any case."""
    for spin, stable in ((15.0, True), (16.0, False)):
        found = hinged().steady(spin=spin, axis=(1, 0, 0), formulation="intrinsic", damping=damping)
        assert (found.growth_rate < 1e-6) == stable


def test_curved_rods_have_no_such_rotation():
    """Contract: with linearised damping a curved rod has no steady rotation, and the message says why."""
    section = vr.StiffnessSection(AWP_STIFFNESS, AWP_MASS, [1e-3 * c for c in AWP_STIFFNESS])
    model = vr.Model()
    model.add("bow", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), radius=1.0, angle=1.0, section=section))
    model.pin("bow.start")
    with pytest.raises(vr.InputError, match="a curved rod has no such axis"):
        model.steady(spin=5.0, formulation="intrinsic", damping="linearised")


@lru_cache
def free_whirl(formulation):
    section = vr.StiffnessSection(AWP_STIFFNESS, AWP_MASS, [1e-3 * c for c in AWP_STIFFNESS])
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4, order=5))
    return model.steady(energy=1.0, formulation=formulation, modes=8)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_free_rod(formulation):
    """Symmetry: a free bent rod whirls about its mass centre, both ends equally far from the axis.

    It begins with the first free-free mode, 22.37 sqrt(EI/mu)/L^2, and whirls faster as it bends.
    """
    found = free_whirl(formulation)
    assert found.residual < 1e-9
    tips = [found.position(f"beam.{end}") for end in ("start", "end")]
    axis = found.spin / np.linalg.norm(found.spin)
    distance = [np.linalg.norm(np.cross(tip - found.centre, axis)) for tip in tips]
    assert distance[0] == pytest.approx(distance[1], rel=1e-7)
    assert 22.37 < np.linalg.norm(found.spin) < 24.0


def test_free_rod_in_both_formulations():
    """Equivalence: angular speed and small motions of the free rod, four of which are neutral or all but."""
    one, other = (free_whirl(f) for f in FORMULATIONS)
    assert np.linalg.norm(one.spin) == pytest.approx(np.linalg.norm(other.spin), rel=1e-8)
    assert (
        np.abs([one.eigenvalues[:2], other.eigenvalues[:2]]).max() < 1e-6
    )  # faster; travelling along the axis
    assert one.eigenvalues[2:] == pytest.approx(other.eigenvalues[2:], rel=1e-6)


def spatial_frame(held):
    """A straight and a curved rod joined at an angle, unequal in bending: nothing is planar."""
    stiffness = [5e3, 5e3, 1e5, 1.0, 2.0, 1.0]
    section = vr.StiffnessSection(stiffness, AWP_MASS, [1e-3 * c for c in stiffness])
    model = vr.Model()
    straight = {"section": section, "elements": 2, "order": 6, "d1": (0, 0.3, 1)}
    model.add("arm", vr.Rod.straight((0.1, 0, 0), (0.6, 0, 0), **straight))
    curved = {"radius": 0.7, "angle": 0.8, "section": section, "elements": 2, "order": 6}
    model.add("hook", vr.Rod.arc((0.6, 0, 0), (0, 0.6, 0.8), (1, 0, 0), **curved))
    model.attach("arm.end", "hook.start")
    if held:
        getattr(model, held)("arm.start")
    return model


@pytest.mark.parametrize(
    ("held", "given"),
    [
        ("clamp", {"spin": (0.3, 0.5, 3.0)}),
        ("pin", {"energy": 0.5}),
        ("pin", {"spin": 3.0, "axis": (0, 0, 1)}),
        (None, {"momentum": 0.05}),
    ],
    ids=["on a slanting hub", "bent about a joint", "about a joint", "free"],
)
def test_spatial_frames(held, given):
    """Equivalence: both formulations in space, with attachments and curved rods; order 6 errs by 1e-9."""
    one, other = (spatial_frame(held).steady(**given, formulation=f, modes=6) for f in FORMULATIONS)
    assert one.elastic_energy == pytest.approx(other.elastic_energy, rel=1e-7)
    assert one.kinetic_energy == pytest.approx(other.kinetic_energy, rel=1e-7)
    moving = np.abs(other.eigenvalues) > 1e-3
    assert one.eigenvalues[moving] == pytest.approx(other.eigenvalues[moving], rel=1e-6)
    # rods that turn freely may stand anywhere on their way round
    shapes = [np.linalg.norm(f.field("position")[-1] - f.position("arm.start"), axis=1) for f in (one, other)]
    assert shapes[0] == pytest.approx(shapes[1], abs=1e-7)
    if held == "clamp":
        assert one.field("position")[-1] == pytest.approx(other.field("position")[-1], abs=1e-7)
        force = [f.data["reaction"].values[-1] for f in (one, other)]
        assert force[0] == pytest.approx(force[1], abs=1e-7 * np.abs(force[1]).max())


def test_shaft_above_its_critical_speed():
    """Closed form: internal damping makes a shaft between bearings unstable above its first critical speed.

    Thin shaft: the critical speed is the bending frequency ``pi^2 sqrt(EI/mu)/L^2``; in the turning frame the whirl
    has ``(s + i W)^2 + tau w^2 s + w^2 = 0``.
    """
    tau, w = 0.01, np.pi**2
    model = vr.Model()
    section = stiff(1e6, 1e6, 1.0, 1.0, rotary=(1e-8, 1e-8, 2e-8), damping=tau)
    model.add("shaft", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=3, order=5))
    model.pin("shaft.start")
    model.support("shaft.end", ["uy", "uz"])
    for W, stable in ((0.8 * w, True), (1.2 * w, False)):
        found = model.steady(spin=(W, 0, 0), modes=8)
        roots = np.roots([1.0, 2j * W + tau * w**2, w**2 - W**2])
        slow = roots[np.argmin(np.abs(roots))]
        slow = slow if slow.imag > 0 else np.conj(slow)
        nearest = found.eigenvalues[np.argmin(np.abs(found.eigenvalues - slow))]
        assert nearest == pytest.approx(slow, rel=1e-4)
        assert found.stable == stable


def test_whirl_of_a_shaft_on_springs():
    """Own Timoshenko finite elements with gyroscopic couples: the whirls of a steel shaft on springs at 3000 rpm.

    At rest 23.118 and 44.490 Hz; in space -23.109/+23.126 and -44.336/+44.645 Hz, in the turning frame 50 Hz less.
    """
    steel = vr.Material(2.1e11, 0.3, 7800.0)
    model = vr.Model()
    shaft = vr.Rod.straight((0, 0, 0), (3, 0, 0), section=vr.Circle(0.1), material=steel, elements=3, order=5)
    model.add("shaft", shaft)
    model.support("shaft.start", ("ux", "rx"))
    for end in ("shaft.start", "shaft.end"):
        model.spring(end, stiffness={"uy": 1e7, "uz": 1e7})
    at_rest = model.modes(4, about="reference").frequencies
    assert at_rest == pytest.approx([23.118, 23.118, 44.490, 44.490], abs=1e-3)
    found = model.steady(spin=(100.0 * np.pi, 0, 0), modes=8)
    for whirl in (5.355, 26.874, 73.109, 94.336):
        assert np.abs(found.frequencies - whirl).min() < 1.1e-3
    assert found.stable
    assert found.modes.names[:2] == ("spring 1", "spring 2")


def test_dampers_alike_around_the_axis():
    """Invariance: a thin shaft whirls in space as it swings at rest, ``s`` there is ``s + i W`` seen from the shaft."""
    model = vr.Model()
    section = stiff(1e6, 1e6, 1.0, 1.0, rotary=(1e-8, 1e-8, 2e-8))
    model.add("shaft", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=3, order=5))
    model.support("shaft.start", ("ux", "rx"))
    for end in ("shaft.start", "shaft.end"):
        model.spring(end, stiffness={"uy": 30.0, "uz": 30.0}, damping={"uy": 0.5, "uz": 0.5})
    W = 3.0
    rest, found = model.modes(4, about="reference").eigenvalues, model.steady(spin=(W, 0, 0), modes=16)
    for s in rest:
        for turned in (s - 1j * W, s + 1j * W):
            assert np.abs(found.eigenvalues - turned).min() < 1e-5 * abs(s)
    assert found.stable


@pytest.mark.parametrize(
    ("spring", "message"),
    [
        ({"stiffness": {"uy": 1.0, "uz": 2.0}}, "not the same in all directions"),
        ({"stiffness": {"uy": 1.0, "uz": 1.0}, "rest": {"uy": 0.1}}, "not on the axis"),
        ({"stiffness": {"rx": 1.0}}, "along ux, uy and uz only"),
    ],
)
def test_springs_that_do_not_stay_as_they_are(spring, message):
    model = thin(1e-3)
    model.spring("blade.end", **spring)
    with pytest.raises(vr.InputError, match=message):
        model.steady(spin=(1.0, 0, 0))


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_shapes_of_a_slow_rotation_are_those_at_rest(formulation):
    """Limit: a blade that turns slowly bends in the shapes of its modes at rest, with their names."""
    model = vr.Model()
    section = vr.StiffnessSection([400.0] * 3 + [1.0, 2.0, 1.0], [1.0] * 3 + [0.0025, 0.0025, 0.005])
    model.add("blade", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=6))
    model.clamp("blade.start")
    rest, found = (
        model.modes(4, about="reference"),
        model.steady(spin=(0, 0, 1e-3), formulation=formulation, modes=4),
    )
    assert found.modes.names == rest.names
    assert found.modes.residuals.max() < 1e-10
    moved = [np.concatenate([m.shapes, m.rotations], axis=1) for m in (found.modes, rest)]
    for one, other in zip(*moved, strict=True):
        overlap = abs(np.vdot(one, other)) / (np.linalg.norm(one) * np.linalg.norm(other))
        assert overlap == pytest.approx(1.0, abs=1e-6)
    faster = model.steady(spin=(0, 0, 2.0), formulation=formulation)
    # the turning blade is longer: modes are drawn about that shape
    assert faster.modes.positions[-1, 0] > 1.001


def test_conical_pendulum():
    """Closed form: a heavy stiff rod on a ball joint that whirls at W hangs at ``cos a = 3 g/(2 L W^2)``."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e4, 1e4, 1e4], [1.0, 1.0, 1.0, 1e-9, 1e-9, 1e-9])
    model.add("bob", vr.Rod.straight((0, 0, 0), (0.6, 0, -0.8), section=section, elements=1, order=4))
    model.pin("bob.start")
    model.gravity((0, 0, -10.0))
    leaning = model.simulate(1e-6, initial="reference")  # not the rod that hangs and spins about itself
    found = model.steady(spin=(0, 0, 5.0), start=leaning)
    tip = found.position("bob.end")
    assert -tip[2] / np.linalg.norm(tip) == pytest.approx(15.0 / 25.0, rel=1e-4)
    assert found.stable


@pytest.mark.parametrize("part", [0.8, 1.3])
def test_a_pendulum_that_hangs_beyond_its_bifurcation_says_so(part):
    """Closed form: a rod on a hinge that is turned at W leaves the vertical from ``W^2 = 3 g/(2 L)`` on; beyond, it
    does so at the rate ``sqrt(W^2 - 3 g/(2 L))``."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e4, 1e4, 1e4], [1.0, 1.0, 1.0, 1e-9, 1e-9, 1e-9])
    model.add("bob", vr.Rod.straight((0, 0, 0), (0, 0, -1), section=section, elements=1, order=3))
    model.support("bob.start", ("ux", "uy", "uz", "rx", "rz"))
    model.gravity((0, 0, -10.0))
    found = model.steady(spin=(0, 0, part * np.sqrt(15.0)), centre=(0, 0, 0))
    told = [text for text in found.warnings if "unstable" in text]
    assert len(told) == (part > 1.0)
    if told:
        assert found.growth_rate == pytest.approx(np.sqrt(15.0 * (part**2 - 1.0)), rel=1e-3)
        assert f"at up to {found.growth_rate:.3g} 1/s" in told[0]
        assert told[0] in flat(found.report())


def test_carousel():
    """Closed form: a stiff heavy rod that hangs from a rim of radius a, pinned, and swings out at angle b:
    ``W^2 (a/2 + L sin b/3) cos b = g sin b/2``."""
    model = vr.Model()
    stiffness = np.array([1e6, 1e6, 1e6, 1e4, 1e4, 1e4])
    section = vr.StiffnessSection(stiffness, [1.0, 1.0, 1.0, 1e-9, 1e-9, 1e-9], 1e-3 * stiffness)
    model.add("chair", vr.Rod.straight((2, 0, 0), (2, 0, -1), section=section, elements=1, order=4))
    model.pin("chair.start")
    model.gravity((0, 0, -10.0))
    found = model.steady(spin=(0, 0, 2.0), centre=(0, 0, 0))
    tip = found.position("chair.end") - np.array([2.0, 0.0, 0.0])
    b = np.arctan2(tip[0], -tip[2])
    assert 4.0 * (1.0 + np.sin(b) / 3.0) * np.cos(b) == pytest.approx(5.0 * np.sin(b), rel=1e-4)
    assert found.stable


@pytest.mark.parametrize(("speed", "axial"), [(5.0, 1e6), (100.0, 1e7)])
def test_a_slack_rope_that_is_swung_is_a_troposkien(speed, axial):
    """A skipping rope of length L = 1.2 over a span l = 1: ``y = a sn(2 K x/l)``, whatever it weighs and its speed.

    ``L/l = 2 E/((1 - k^2) K) - 1`` and ``a/l = k/((1 - k^2) K)`` (Routh, Advanced Rigid Dynamics; Blackwell 1974).
    At rest it hangs in a catenary, and is less taut than at 100 rad/s by a factor of a thousand.
    """

    def rope(weight):
        section = vr.StiffnessSection([axial] * 3 + [0.0] * 3, [0.1] * 3 + [1e-6, 1e-6, 2e-6])
        model = vr.Model()
        model.add("rope", vr.Rod.straight((0, 0, 0), (1.2, 0, 0), section=section))
        model.pin("rope.start")
        model.pin("rope.end", motion={"ux": -0.2})
        if weight:
            model.gravity()
        return model

    def length(k):
        return 2.0 * ellipe(k**2) / ((1.0 - k**2) * ellipk(k**2)) - 1.0

    k = brentq(lambda k: length(k) - 1.2, 1e-3, 0.99)
    found = rope(False).steady(spin=(speed, 0, 0), start=rope(True).equilibrium())
    assert found.stable
    rise = np.linalg.norm(found.position("rope@0.6")[1:])
    assert rise == pytest.approx(k / ((1.0 - k**2) * ellipk(k**2)), rel=1e-4)

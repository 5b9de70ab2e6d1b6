"""Generalised Maxwell rods: creep, relaxation, complex frequencies, energy and limits, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import viscorod as vr
from viscorod.mechanics.elements.maxwell_branches import add_section_stiffness
from viscorod.model.materials.prony import Prony
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.transient.integrators.radau import Radau

from .cases import cantilever, methods, slope

RATIOS, TIMES = np.array([0.3, 2.5]), np.array([0.05, 0.5])  # of the branches, over the relaxed stiffness; s
LENGTH = 0.3


def root_of(omega, ratios=RATIOS, times=TIMES):
    """The vibrating root of s^2 + omega^2 M*(s)/M_inf = 0, times all 1 + s tau_j a polynomial."""
    factors = [np.array([tau, 1.0]) for tau in times]

    def product(polynomials):
        total = np.ones(1)
        for polynomial in polynomials:
            total = np.polymul(total, polynomial)
        return total

    whole = np.polymul([1.0, 0.0, omega**2], product(factors))
    for j, (g, tau) in enumerate(zip(ratios, times, strict=True)):
        others = product(factors[:j] + factors[j + 1 :])
        whole = np.polyadd(whole, np.polymul([omega**2 * g * tau, 0.0], others))
    (root,) = (s for s in np.roots(whole) if s.imag > 0)
    return root


def section(ratios=RATIOS, times=TIMES, damping=None, wide=0.012, light=1.0):
    """A section all of whose strains relax alike; ``light`` is a part of its mass."""
    C, _, M = vr.Rectangle(0.01, wide).matrices(vr.Material(1e6, poissons_ratio=0.3, density=1000.0))
    branches = [vr.MaxwellBranch(time=t, stiffness=g * C) for g, t in zip(ratios, times, strict=True)]
    return vr.StiffnessSection(
        C, light * M, branches=branches, **({} if damping is None else {"damping": damping * C})
    )


def swing(given, force=0.02, **more):
    """The cantilever of LLT section 3, pulled askew and released."""
    model = cantilever(given, LENGTH, elements=2, order=4, **more)
    model.force("beam.end", (0, force, 0.5 * force), until=0.0)
    return model


# --- small vibrations


@pytest.mark.parametrize(("elements", "order"), [(3, 1), (2, 5)])
def test_complex_frequencies_where_all_strains_relax_alike(elements, order):
    """Closed form on any mesh: s^2 + w^2 M*(s)/M_inf = 0, w being the relaxed frequencies of the same mesh."""
    relaxed = cantilever(section((), ()), LENGTH, elements, order).modes(6).eigenvalues
    found = cantilever(section(), LENGTH, elements, order).modes(6).eigenvalues
    expected = [root_of(abs(omega)) for omega in relaxed]
    assert found == pytest.approx(np.array(expected), rel=1e-9)


def test_complex_frequencies_of_bars_match_the_complex_moduli():
    """Closed form: rho s^2 + M*(s) k^2 = 0 with E* of the axial and G* of the torsional bar, which differ here.

    The bulk modulus does not relax, so E* = 9 K G*/(3 K + G*) (correspondence principle).
    """
    prony = Prony(shear_moduli=[2e5, 5e5], shear_times=[0.004, 0.05], constant="bulk_modulus")
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=prony)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=8,
        constraints=("shear_1", "shear_2", "bend_1", "bend_2"),
    )  # fmt: skip
    model = vr.Model()
    model.add("bar", rod)
    model.clamp("bar.start")
    K, G = 1e6 / (3 * 0.4), 1e6 / 2.6

    def shear(s):
        return G + sum(g * s * t / (1 + s * t) for g, t in ((2e5, 0.004), (5e5, 0.05)))

    def extension(s):
        return 9 * K * shear(s) / (3 * K + shear(s))

    def exact(modulus, k):
        s = 1j * k * np.sqrt(modulus(1j * k * 20.0) / 1000.0)
        for _ in range(200):
            s = 1j * k * np.sqrt(modulus(s) / 1000.0)
        return s

    found = model.modes(12).eigenvalues
    for modulus in (shear, extension):
        for n in (1, 2):
            expected = exact(modulus, (2 * n - 1) * np.pi / 2)
            assert np.abs(found - expected).min() < 1e-6 * abs(expected)


def test_complex_frequencies_of_bending_match_the_complex_modulus():
    """Closed form: Euler-Bernoulli with a relaxing EI, s^2 + (beta L)^4 (EI)*(s)/(mu L^4) = 0 (C1)."""
    bend = np.diag([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    branches = [vr.MaxwellBranch(time=t, stiffness=g * bend) for g, t in zip(RATIOS, TIMES, strict=True)]
    given = vr.StiffnessSection(
        [1e3, 1e3, 1e3, 1.0, 1.0, 1.0], [1, 1, 1, 1e-10, 1e-10, 2e-3], branches=branches
    )
    model = vr.Model()
    model.add(
        "beam",
        vr.Rod.straight((0, 0, 0), (1, 0, 0), section=given, elements=4, order=6, constraints="unshearable"),
    )
    model.clamp("beam.start")
    found = model.modes(8).eigenvalues
    for omega in (3.51601526850015, 22.0344915646688):
        expected = root_of(omega)
        assert np.abs(found - expected).min() < 1e-6 * abs(expected)


def bar(v0):
    """A clamped axial bar that starts in its first mode, u = sin(k s) v0 t."""
    model = cantilever(section(), LENGTH, elements=2, order=5)
    k = np.pi / (2 * LENGTH)
    model.velocity("beam", field=lambda s: ((v0 * np.sin(k * s), 0.0, 0.0), (0.0, 0.0, 0.0)))
    return model, k


@methods(1e-9, 5e-5, spectral_radius=0.9)
def test_free_vibration_of_a_bar(method):
    """Closed form: one coordinate and the strains of two dashpots, a linear system, by its matrix exponential."""
    model, k = bar(1.0)
    rate = k**2 * 1e6 / 1000.0
    A = np.zeros((4, 4))
    A[0, 1] = 1.0
    A[1, 0], A[1, 2:] = -rate * (1.0 + RATIOS.sum()), rate * RATIOS
    A[2, 0], A[2, 2] = 1 / TIMES[0], -1 / TIMES[0]
    A[3, 0], A[3, 3] = 1 / TIMES[1], -1 / TIMES[1]
    run = model.simulate(0.1, initial="reference", **method)
    motion = run.data.position[:, -1, 0].values - LENGTH
    exact = np.array([(expm(A * t) @ [0, 1.0, 0, 0])[0] for t in run.data.time.values])
    accuracy = 2e-7 if "tolerance" in method else 1e-3
    assert motion == pytest.approx(exact, abs=accuracy * np.abs(exact).max())


# --- creep and relaxation: with so little mass that inertia does nothing


def hold(at, until):
    """From 0 to ``at`` in ``until`` seconds, then constant."""
    return vr.Ramp(0.0, until, at)


@methods(1e-6, 0.05)
def test_relaxation_of_a_stretched_bar(method):
    """Closed form: N = EA [eps + sum g_j tau_j eps_t (1 - e^(-t/tau_j))] in the ramp, Prony decay after it."""
    ratios, times, T, stretch = np.array([0.4, 1.0]), np.array([2.0, 30.0]), 1.0, 1e-3
    model = cantilever(section(ratios, times, light=1e-8), LENGTH, elements=1, order=3)
    model.clamp("beam.end", motion={"ux": hold(stretch * LENGTH, T)})
    run = model.simulate(20.0, initial="reference", **method | {"time_step": 0.05})
    t = run.data.time.values
    rate = stretch / T
    expected = rate * np.minimum(t, T)
    lost = np.zeros((len(t), 2))
    for j, (g, tau) in enumerate(zip(ratios, times, strict=True)):
        ramp = tau * rate * -np.expm1(-np.minimum(t, T) / tau)
        expected = expected + g * ramp * np.exp(-np.maximum(t - T, 0.0) / tau)
        # int beta^2/tau: in the ramp, then in the decay
        x = np.minimum(t, T) / tau
        lost[:, j] = g * tau**2 * rate**2 * (x + 2 * np.expm1(-x) - 0.5 * np.expm1(-2 * x))
        lost[:, j] += g * 0.5 * ramp**2 * -np.expm1(-2 * np.maximum(t - T, 0.0) / tau)
    EA = 1e6 * 0.01 * 0.012
    assert run.data.section_force[:, 0, 2].values == pytest.approx(
        EA * expected, abs=2e-5 * EA * expected.max()
    )
    energy = EA * LENGTH * lost
    assert run.data.branch_loss.values == pytest.approx(energy, abs=2e-4 * energy.max())
    assert run.data.relaxation_time.values == pytest.approx(times)
    assert run.data.viscous.values == pytest.approx(run.data.branch_loss.sum("branch").values, abs=1e-15)


@methods(1e-6, 0.05)
def test_creep_in_bending_with_large_rotations(method):
    """Closed form: an end moment bends the rod to an arc of the curvature M J(t), J the creep compliance."""
    g, tau, T, turn = 1.5, 4.0, 2.0, 2.0
    model = cantilever(section((g,), (tau,), light=1e-8), LENGTH, elements=3, order=6)
    EI = 1e6 * 0.012 * 0.01**3 / 12.0
    moment = turn * EI / LENGTH
    model.moment("beam.end", (0, moment, 0), following=True, time=hold(1.0, T))
    run = model.simulate(15.0, initial="reference", **method | {"time_step": 0.05})
    t = run.data.time.values
    slow = tau * (1.0 + g)  # the retardation time of the solid

    def crept(t):  # int_0^t J(t - s) ds over the relaxed compliance
        return t + g / (1 + g) * slow * np.expm1(-t / slow)

    angle = turn / T * (crept(t) - np.where(t > T, crept(np.maximum(t - T, 0.0)), 0.0))
    with np.errstate(invalid="ignore"):
        x = np.where(angle > 1e-9, LENGTH * np.sin(angle) / angle, LENGTH)
        y = np.where(angle > 1e-9, LENGTH * (1 - np.cos(angle)) / angle, 0.0)
    tip = run.data.position[:, -1].values
    # ends of steps: in between motions follow velocities, which jump after the ramp where inertia is next to nothing
    assert tip[::4, 0] == pytest.approx(x[::4], abs=1e-4 * LENGTH)
    assert tip[::4, 1] == pytest.approx(y[::4], abs=1e-4 * LENGTH)


# --- energy


def test_midpoint_accounts_for_every_joule():
    """Conservation law: large motion in space, two branches and Kelvin-Voigt beside them, remainder at round-off."""
    run = swing(section(damping=1e-3)).simulate(1.0, integrator="midpoint", time_step=0.01, errors=False)
    data = run.data
    moved = float(data.elastic[0])
    assert np.abs(data.numerical).max() < 1e-10 * moved
    assert np.diff(data.branch_loss.values, axis=0).min() >= 0.0
    assert float(data.branch_loss[-1].sum()) < float(data.viscous[-1])
    assert float(data.branch_loss[-1].min()) > 0.01 * moved


@pytest.mark.parametrize("integrator", ["radau", "generalized_alpha"])
def test_other_integrators_converge_to_the_energy_of_the_midpoint_rule(integrator):
    exact = (
        swing(section())
        .simulate(0.5, integrator="midpoint", time_step=5e-4, errors=False)
        .data.branch_loss[-1]
        .values
    )
    errors = []
    for part in (1.0, 0.5):
        given = {"tolerance": 1e-4 * part**3} if integrator == "radau" else {"time_step": 4e-3 * part}
        data = swing(section()).simulate(0.5, integrator=integrator, errors=False, **given).data
        errors.append(np.abs(data.branch_loss[-1].values - exact).max() / exact.max())
        assert np.abs(data.numerical).max() < 2e-3 * float(data.elastic[0])
    assert errors[1] < 2e-3
    assert errors[1] < errors[0] or errors[1] < 1e-5


def test_dissipation_density_integrates_to_the_loss():
    """Conservation: the recorded power per length, integrated along the rod and in time, is what was lost."""
    data = swing(section()).simulate(0.5, tolerance=1e-6, output_interval=5e-4, errors=False).data
    power = (data.dissipation * data.point_weight).sum("point")
    total = np.trapezoid(power.values, data.time.values)
    assert total == pytest.approx(float(data.viscous[-1]), rel=1e-3)


# --- limits and equivalence


def test_fast_branches_become_kelvin_voigt():
    """Limit: with sum g_j tau_j kept, the difference to the Kelvin-Voigt rod is of order one in the times."""
    tau = 0.02
    whole = swing(section((), (), damping=tau)).simulate(
        1.0, tolerance=1e-7, output_interval=0.02, errors=False
    )
    expected = whole.data.position[:, -1].values
    sizes, errors = np.array([4e-4, 2e-4, 1e-4]), []
    for fast in sizes:
        given = section((0.5 * tau / fast, 0.25 * tau / fast), (fast, 2 * fast))
        run = swing(given).simulate(1.0, tolerance=1e-7, output_interval=0.02, errors=False)
        errors.append(np.abs(run.data.position[:, -1].values - expected).max() / LENGTH)
    assert slope(sizes, errors) == pytest.approx(1.0, abs=0.15)
    assert errors[-1] < 5e-3


@pytest.mark.parametrize(("integrator", "order"), [("midpoint", 2.0), ("generalized_alpha", 2.0)])
def test_order_in_time(integrator, order):
    given = section(damping=2e-3)  # the fastest waves do not ring
    reference = (
        swing(given).simulate(0.4, tolerance=1e-9, output_interval=0.4, errors=False).data.position[-1, -1]
    )
    steps, errors = np.array([4e-3, 2e-3, 1e-3]), []
    for step in steps:
        run = swing(given).simulate(0.4, integrator=integrator, time_step=step, errors=False)
        errors.append(float(np.abs(run.data.position[-1, -1] - reference).max()))
    assert slope(steps, errors) == pytest.approx(order, abs=0.25)


def test_both_formulations_agree():
    """Equivalence: the intrinsic formulation keeps strains as states, and the memory of the branches beside them."""
    runs = [
        swing(section(), force=0.01)
        .simulate(0.5, tolerance=1e-7, output_interval=0.05, formulation=name, errors=False)
        .data
        for name in ("geometric", "intrinsic")
    ]
    difference = np.abs(runs[0].position - runs[1].position).max()
    assert difference < 2e-4 * LENGTH  # of the mesh: the formulations are two elements
    losses = [run.branch_loss[-1].values for run in runs]
    assert losses[0] == pytest.approx(losses[1], rel=1e-3)


def test_statics_see_the_relaxed_rod():
    """Equivalence: branches carry nothing in equilibrium."""
    found, expected = (
        swing(given).equilibrium().data.position[-1, -1].values for given in (section(), section((), ()))
    )
    assert found == pytest.approx(expected, abs=1e-12)


def test_held_strains_have_no_branches():
    """Equivalence: an unshearable Maxwell rod is the limit of a stiff one (difference 1/GA), energy exact."""
    C, _, M = vr.Rectangle(0.01, 0.012).matrices(vr.Material(1e6, poissons_ratio=0.3, density=1000.0))
    tips = []
    for stiffer in (1e3, None):
        K = C.copy()
        if stiffer is not None:
            K[0, 0] *= stiffer
            K[1, 1] *= stiffer
        branches = [vr.MaxwellBranch(time=t, stiffness=g * K) for g, t in zip(RATIOS, TIMES, strict=True)]
        rod = vr.Rod.straight(
            (0, 0, 0), (LENGTH, 0, 0), section=vr.StiffnessSection(K, M, branches=branches), elements=2, order=4,
            constraints=() if stiffer else "unshearable",
        )  # fmt: skip
        model = vr.Model()
        model.add("beam", rod)
        model.clamp("beam.start")
        model.force("beam.end", (0, 0.02, 0.01), until=0.0)
        data = model.simulate(0.1, integrator="midpoint", time_step=2e-3, errors=False).data
        # Newton's tolerance, times the stiffness that a thousandfold shear stiffness means
        assert np.abs(data.numerical).max() < 1e-7 * float(data.elastic[0])
        tips.append(data.position[-1, -1].values)
    assert tips[0] == pytest.approx(tips[1], abs=1e-5 * LENGTH)


# --- the linear systems of a step


@pytest.mark.parametrize("dtype", [float, complex])
def test_stiffness_of_a_section_modulus(dtype):
    """Independent formulation: sum_g w_g B^T M B by dense NumPy."""
    model = swing(section())
    model.add(
        "arm", vr.Rod.straight((LENGTH, 0, 0), (LENGTH, 0.1, 0), section=section(), elements=1, order=2)
    )
    model.attach("arm.start", "beam.end")
    system = GeometricSystem(discretise(model))
    elements, n = system.elements(), system.problem.size
    rng = np.random.default_rng(2)
    count = elements.reference.shape[1]
    B = rng.normal(size=(len(elements.order), 6 * count, 6 * (count + 1)))
    modulus = rng.normal(size=(len(elements.stiffness), 6, 6)).astype(dtype)
    if dtype is complex:
        modulus += 1j * rng.normal(size=modulus.shape)
    blocks = np.zeros((len(system.problem.pattern.rows), 6, 6), dtype=dtype)
    add_section_stiffness(elements, modulus, B, blocks)
    expected = np.zeros((6 * n, 6 * n), dtype=dtype)
    for e, p in enumerate(elements.order):
        places = (6 * elements.nodes[e, : p + 1, None] + np.arange(6)).ravel()
        for g in range(p):
            own = B[e, 6 * g : 6 * g + 6, : 6 * (p + 1)]
            weight = elements.weights[p, g] * elements.half_lengths[e]
            expected[np.ix_(places, places)] += weight * own.T @ modulus[elements.section[e, g]] @ own
    found = np.zeros_like(expected)
    pattern = system.problem.pattern
    for block, row, column in zip(blocks, pattern.rows, pattern.columns, strict=True):
        found[6 * row : 6 * row + 6, 6 * column : 6 * column + 6] = block.T
    assert found == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


def test_newton_has_the_tangent_of_the_branches():
    """The linear systems contain the complex modulus: a small motion takes one iteration and one to see it.

    Without it the rate would be that of the missing stiffness, of order one.
    """
    problem = discretise(cantilever(section(), LENGTH, elements=2, order=4))
    system, supports = GeometricSystem(problem), SupportState(problem)
    radau = Radau(system, supports, tolerance=1e-6)
    state = State.reference(problem)
    state.twist[1:] = 1e-5 * np.random.default_rng(1).normal(size=state.twist[1:].shape)
    radau.start(0.0, state)
    report = radau.attempt(0.05, before=False)
    assert report.converged
    assert report.rate <= 1e-3
    assert report.iterations <= 2


# --- together with joints


@pytest.mark.parametrize("integrator", ["radau", "midpoint", "generalized_alpha"])
def test_halves_joined_rigidly_are_one_rod(integrator):
    """The same elements on a shared node, or on two nodes that a rigid joint holds together: the same rod."""
    model = vr.Model()
    half = 0.5 * LENGTH
    for name, start, end in (("one", 0.0, half), ("two", half, LENGTH)):
        model.add(
            name,
            vr.Rod.straight((start, 0, 0), (end, 0, 0), section=section(), elements=1, order=4),
        )
    model.clamp("one.start")
    model.rigid("one.end", "two.start")
    model.force("two.end", (0, 0.02, 0.01), until=0.0)
    given = {"tolerance": 1e-7} if integrator == "radau" else {"time_step": 0.005}
    joined = model.simulate(0.5, integrator=integrator, errors=False, **given)
    whole = swing(section()).simulate(0.5, integrator=integrator, errors=False, **given)
    tip = [
        run.history(place, "position").values[-1] for run, place in ((joined, "two.end"), (whole, "beam.end"))
    ]
    assert tip[0] == pytest.approx(tip[1], abs=1e-7 * LENGTH)
    assert joined.data.branch_loss.values[-1] == pytest.approx(whole.data.branch_loss.values[-1], rel=1e-5)


def test_a_swinging_chain_loses_its_energy_in_the_branches():
    """Conservation law, by two methods that share no time stepping: relaxing rods on a hinge and a ball, falling."""
    model = vr.Model()
    for name, start in (("one", 0.0), ("two", LENGTH)):
        ends = (start, 0, 0), (start + LENGTH, 0, 0)
        model.add(name, vr.Rod.straight(*ends, section=section(), elements=2, order=3))
    model.revolute("one.start", "ground", (0, 1, 1))
    model.ball("one.end", "two.start")
    model.gravity()
    midpoint = model.simulate(0.4, initial="reference", integrator="midpoint", time_step=5e-4, errors=False)
    radau = model.simulate(0.4, initial="reference", tolerance=1e-6, errors=False)
    for run in (midpoint, radau):
        data = run.data
        given, lost = float(data.external[-1]), float(data.branch_loss[-1].sum())
        stored = float(data.kinetic[-1] + data.elastic[-1])
        assert stored + lost == pytest.approx(given, rel=1e-4)
        assert lost > 1e-3 * given
        ends = [run.history(place, "position").values for place in ("one.end", "two.start")]
        assert ends[0] == pytest.approx(ends[1], abs=1e-9 * LENGTH)
    assert radau.data.branch_loss.values[-1] == pytest.approx(midpoint.data.branch_loss.values[-1], rel=2e-3)


# --- what has no branches


def test_refused_by_name():
    with pytest.raises(vr.InputError, match="Maxwell branches") as error:
        swing(section()).simulate(0.1, formulation="intrinsic", damping="linearised")
    assert "damping = 'full'" in str(error.value)
    assert "rods.beam" in str(error.value)

"""The estimated error of the mesh, beside the error that closed forms and refinement tell."""

from __future__ import annotations

import functools
import importlib.util

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import viscorod as vr
from helpers.plain_text import flat
from helpers.timoshenko_beam import cantilever_frequencies
from viscorod.results.result_warnings import warnings_of

from .cases import slope
from .test_examples import ROOT

_spec = importlib.util.spec_from_file_location("choose_mesh", ROOT / "docs" / "figures" / "choose_mesh.py")
assert _spec is not None
assert _spec.loader is not None
choose_mesh = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(choose_mesh)

PLACES = np.linspace(0.0, 1.0, 41)


def along(result, rod, length):
    """Return displacements along a rod in all states (states, places, 3), over its length."""
    return result.probe(rod, s=PLACES * length)["displacement"].values / length


def distance(a, b):
    return float(np.linalg.norm(a - b, axis=2).max())


@pytest.fixture
def seen(monkeypatch):
    """The last equilibrium that was computed."""
    results = []
    compute = vr.Model.equilibrium

    def kept(self, **given):
        results.append(compute(self, **given))
        return results[-1]

    monkeypatch.setattr(vr.Model, "equilibrium", kept)
    return results


def elastica(load):
    """Return displacements (1, places, 3) of Euler's elastica of length and stiffness 1 under a dead force across it.

    theta'' = -load cos(theta), from the clamp on, where theta' follows from the slope of the tip.
    """
    sine = 0.5 * load * choose_mesh.elastica(load)[0] ** 2
    start = [0.0, np.sqrt(2.0 * load * sine), 0.0, 0.0]
    found = solve_ivp(
        lambda _, y: [y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])],
        (0.0, 1.0),
        start,
        t_eval=PLACES,
        rtol=1e-12,
        atol=1e-12,
    )
    return np.array([found.y[2] - PLACES, found.y[3], 0.0 * PLACES]).T[None]


@pytest.mark.parametrize(
    ("order", "elements"), [(1, (4, 8, 16)), (2, (2, 4, 8)), (3, (2, 4, 8)), (5, (2, 4))]
)
def test_estimate_beside_eulers_elastica(seen, order, elements):
    """Closed form: a strip bent by ten times EI/L^2; the estimate is within a factor of three, by a fall as steep."""
    for n in elements:
        choose_mesh.bent(n, order)
    exact = elastica(10.0)
    errors = [distance(along(result, "strip", 1.0)[-1:], exact) for result in seen]
    estimates = [result.mesh_errors["strip"] for result in seen]
    ratio = np.array(estimates) / errors
    assert np.all((ratio > 1 / 3) & (ratio < 3))
    assert slope(elements, estimates) == pytest.approx(slope(elements, errors), abs=0.5)


@pytest.mark.parametrize(("order", "elements"), [(2, (8, 16)), (3, (4, 8)), (5, (4,))])
def test_estimate_beside_a_wound_wire(seen, order, elements):
    """Closed form: a helix of constant curvature."""
    a, c, radius = 4.0 * np.pi, 50.0 / (40.0 * np.pi), 10.0
    length = np.hypot(1.0, c) * radius * a
    exact = radius * np.array([np.sin(a * PLACES), -np.cos(a * PLACES), c * a * PLACES]).T / length
    for n in elements:
        choose_mesh.coil(n, order)
        found = seen[-1].probe("wire", s=PLACES * length)["position"].values[-1] / length
        error = np.linalg.norm(found - exact, axis=1).max()
        assert 1 / 3 < seen[-1].mesh_errors["wire"] / error < 3


def following(**mesh):
    """A cantilever rolled up by a following force, F L^2/EI = 37."""
    section = vr.StiffnessSection([1.0e14, 1.0e14, 4.2e8, 3.5e7, 3.5e7, 3.5e7], [1.0] * 5 + [2.0])
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (100.0, 0, 0), d1=(0, 1, 0), section=section, **mesh))
    model.clamp("beam.start")
    model.force("beam.end", (1.3e5, 0, 0), following=True)
    return model


def test_a_following_force_rolls_a_beam_up():
    """Published: a benchmark of several codes, here integrated from the tip as an initial value problem (1e-11)."""
    held = following().equilibrium()
    tip = held.displacement("beam.end")
    np.testing.assert_allclose(tip[:2], [-75.8571, -47.8454], atol=2e-4)
    assert tip[2] == pytest.approx(0.0, abs=1e-6)
    assert held.data.attrs["mesh_motion_error"] < 1e-4
    assert held.data.attrs["mesh_force_error"] < 1e-4


def test_estimate_under_a_following_force():
    """Refinement: the same on given meshes, beside 24 elements of order 6; they stay as they are given."""
    fine = following(elements=24, order=6).equilibrium()
    places = np.linspace(0.0, 100.0, 121)

    def forces(result):
        return result.probe("beam", s=places)["section_force"].values[-1].reshape(-1, 2, 3)

    largest = np.linalg.norm(forces(fine), axis=2).max(axis=0)
    for elements in (2, 3, 4, 6, 8):
        held = following(elements=elements).equilibrium()
        assert held.data.sizes["station"] == 5 * elements + 1
        error = distance(along(held, "beam", 100.0)[-1:], along(fine, "beam", 100.0)[-1:])
        assert 1 / 3 < held.mesh_errors["beam"] / error < 3
        apart = np.linalg.norm(forces(held) - forces(fine), axis=2).max(axis=0) / largest
        assert 1 / 3 < held.data.attrs["mesh_force_error"] / apart.max() < 3


def uneven_blade(**mesh):
    """A cantilever of 60 m whose bending stiffness is given at 21 stations, linear in between."""
    k = np.arange(21)
    e = k / 20
    uneven = 1 + 0.4 * (-1.0) ** k * (k > 0) * (k < 20)
    bending, mass = 8e9 * np.exp(-7 * e) * uneven, 600 * np.exp(-3.5 * e)

    def diagonals(s):
        i, n = np.interp(s / 60.0, e, bending), np.interp(s / 60.0, e, mass)
        return [4e6 * n, 4e6 * n, 2e7 * n, i, 2 * i, i], [n] * 6

    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (60.0, 0, 0), section=lambda s: vr.StiffnessSection(*diagonals(s)), **mesh
    )
    model.add("blade", rod)
    model.clamp("blade.start")
    return model, diagonals


def test_a_blade_of_21_stations_bends_as_it_should():
    """Closed form: F int (L - s)^2/EI + 1/GA ds for a small deflection."""
    model, diagonals = uneven_blade()
    model.force("blade.end", (0, 0, 50.0))
    held = model.equilibrium()
    s = np.linspace(0.0, 60.0, 60001)
    stiffness = np.array([diagonals(x)[0] for x in s])
    exact = 50.0 * np.trapezoid((60.0 - s) ** 2 / stiffness[:, 3] + 1.0 / stiffness[:, 1], s)
    assert held.displacement("blade.end")[2] == pytest.approx(exact, rel=2e-4)
    assert held.data.attrs["mesh_motion_error"] < 1e-4


def test_a_blade_of_21_stations_has_its_frequencies():
    """Independent formulation: Timoshenko finite elements of the same tables; ten frequencies to 1e-4 by default."""
    model, diagonals = uneven_blade()
    found = model.modes(10, about="reference")
    exact = cantilever_frequencies(
        60.0, lambda s: diagonals(s)[0], lambda s: diagonals(s)[1], 10, elements=4000
    )
    np.testing.assert_allclose(exact[:3], [0.8034, 1.1349, 2.2088], rtol=1e-4)
    np.testing.assert_allclose(found.frequencies, exact, rtol=2e-4)
    assert found.frequency_errors.max() < 1e-4


def random_blade(seed, count):
    rng = np.random.default_rng(seed)
    places = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 1.7, count - 1))])
    places *= 40.0 / places[-1]
    rough = rng.uniform(0.6, 1.6, (count, 4)) * np.exp(-5.0 * places / 40.0)[:, None]

    def diagonals(s):
        m, flap, edge, twist = (np.interp(s, places, rough[:, j]) for j in range(4))
        stiffness = [2e9 * m, 3e9 * m, 6e9 * m, 3e9 * flap, 6e9 * edge, 8e8 * twist]
        return stiffness, [400 * m] * 3 + [30 * flap, 60 * edge, 90 * twist]

    return diagonals


@pytest.mark.parametrize("seed", [1, 2])
def test_a_blade_of_40_stations_has_ten_frequencies(seed):
    """Independent formulation: Timoshenko finite elements; a table of 40 stations at random, unevenly spaced."""
    diagonals = random_blade(seed, 40)
    model = vr.Model()
    model.add(
        "blade",
        vr.Rod.straight((0, 0, 0), (0, 0, 40.0), section=lambda s: vr.StiffnessSection(*diagonals(s))),
    )
    model.clamp("blade.start")
    found = model.modes(10, about="reference")
    exact = cantilever_frequencies(40.0, lambda s: diagonals(s)[0], lambda s: diagonals(s)[1], 10)
    np.testing.assert_allclose(found.frequencies, exact, rtol=3e-4)


def test_a_thin_end_gets_smaller_elements():
    """Closed form: a cantilever that tapers to a twentieth of its height; F int (L - s)^2/EI ds and shear, small."""
    model = vr.Model()
    material = vr.Material(1e9, 0.3, 1000.0)
    thick, thin = vr.Rectangle(0.02, 0.01), vr.Rectangle(0.001, 0.01)
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Taper(thick, thin), material=material))
    model.clamp("rod.start")
    model.force("rod.end", (0, 1e-5, 1e-5))
    held = model.equilibrium()
    assert held.data.attrs["mesh_motion_error"] < 1e-4
    fine = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Taper(thick, thin), material=material, elements=60, order=4
    )
    refined = vr.Model()
    refined.add("rod", fine)
    refined.clamp("rod.start")
    refined.force("rod.end", (0, 1e-5, 1e-5))
    other = refined.equilibrium()
    moved = np.abs(along(other, "rod", 1.0)).max()
    assert distance(along(held, "rod", 1.0)[-1:], along(other, "rod", 1.0)[-1:]) < 1e-4 * moved
    ends = np.unique(held.data["station_s"].values)[::5]
    assert np.diff(ends)[-1] < np.diff(ends)[0]


def test_the_accuracy_can_be_chosen():
    """Order of convergence: what is asked for is reached, with the more elements the more is asked for."""
    sizes, exact = [], elastica(10.0)
    for accuracy in (1e-2, 1e-4, 1e-6):
        section = vr.StiffnessSection([1.0] * 6, [1.0] * 6)
        model = vr.Model()
        model.add(
            "strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, constraints="kirchhoff", order=2)
        )
        model.clamp("strip.start")
        model.force("strip.end", (0, 10.0, 0))
        held = model.equilibrium(accuracy=accuracy)
        found = along(held, "strip", 1.0)[-1:]
        assert distance(found, exact) < 2.0 * accuracy * np.abs(exact).max()
        sizes.append(held.data.sizes["station"])
    assert sizes[0] < sizes[1] < sizes[2]


def test_modes_of_a_given_mesh_tell_their_errors():
    """Closed form: a clamped Euler-Bernoulli beam, (beta L)^2 = 3.5160, 22.0345, 61.6972, 120.9019."""
    section = vr.StiffnessSection([1e9, 1e9, 1e9, 1.0, 1.0, 1e6], [1.0, 1.0, 1.0, 1e-9, 1e-9, 1.0])
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3))
    model.clamp("rod.start")
    found = model.modes(8, about="reference")
    exact = np.repeat([3.51601527, 22.03449156, 61.69721441, 120.90191605], 2) / (2.0 * np.pi)
    errors = np.abs(found.frequencies / exact - 1.0)
    ratio = found.frequency_errors / errors
    assert np.all((ratio > 1 / 3) & (ratio < 3))


@pytest.mark.parametrize("part", [0.45, 0.5])
def test_a_path_tells_the_error_of_its_mesh(part):
    """Refinement: the same loads, far past a limit point, on an arch; the estimate is orthogonal to the path.

    With the load in the middle the arch is symmetric, and passes bifurcations."""

    def arch(**mesh):
        section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1.0] * 6)
        model = vr.Model()
        model.add(
            "arch", vr.Rod.arc((0, 0, 0), (0.8, 0, 0.6), (0.6, 0, -0.8), 1.0, length, section=section, **mesh)
        )
        model.clamp("arch.start")
        model.clamp("arch.end")
        place = f"arch@{part * model.rods['arch'].length!r}"
        model.force(place, (0, 0, -40.0))
        return model.path(place=place, axis="z", displacement=-0.2)

    length = 2.0 * np.arctan(0.75)
    fine = arch(elements=12, order=6)
    last = along(fine, "arch", length)[-1:]
    assert len(fine.limit_points)
    for elements, order in ((4, 3), (6, 3), (2, 5)):
        found = arch(elements=elements, order=order)
        assert "mesh_lost" not in found.data.attrs
        error = distance(along(found, "arch", length)[-1:], last)
        assert 1 / 3 < found.mesh_errors["arch"] / error < 3


@functools.cache
def swing(elements, order):
    material = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=material,
        elements=elements, order=order,
    )  # fmt: skip
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model.simulate(1.0, tolerance=1e-6, output_interval=0.02)


@pytest.mark.parametrize(("elements", "order"), [(4, 1), (2, 2), (4, 2), (2, 3), (4, 3)])
def test_estimate_beside_a_refined_swing(elements, order):
    """Refinement: the tutorial's swing for a second, beside 4 elements of order 8."""

    found, fine = swing(elements, order), swing(4, 8)
    error = distance(along(found, "beam", 0.3), along(fine, "beam", 0.3))
    assert 1 / 3 < found.mesh_errors["beam"] / error < 5.0
    assert 1e-7 > fine.mesh_errors["beam"]


def sudden_bar(elements, order, **given):
    """Steel, undamped, under a load that is suddenly there: vibrations that a coarse mesh cannot follow begin too."""
    material = vr.Material(2e11, 0.3, 7850.0)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.02), material=material, elements=elements, order=order
    )  # fmt: skip
    model.add("bar", rod)
    model.clamp("bar.start")
    model.distributed_force("bar", (0, 0, 50.0))
    return model.simulate(0.06, initial="reference", output_interval=0.002, **given)


@pytest.mark.parametrize(("elements", "order"), [(2, 3), (1, 4)])
def test_estimate_of_what_a_sudden_load_sets_off(elements, order):
    """Refinement: twice the elements, of an order higher by two, all with 3/1000 of the tolerance.

    Most of the error of the mesh is that fast vibrations run ahead, which larger steps would damp away at once.
    """
    found = sudden_bar(elements, order)
    tolerance = 3e-3 * found.data.attrs["tolerance"]
    same = sudden_bar(elements, order, tolerance=tolerance)
    fine = sudden_bar(2 * elements, order + 2, tolerance=tolerance)
    error = distance(along(same, "bar", 1.0), along(fine, "bar", 1.0))
    assert 1 / 3 < found.mesh_errors["bar"] / error < 10.0
    whole = distance(along(found, "bar", 1.0), along(fine, "bar", 1.0))
    assert 1 / 3 < (found.mesh_errors["bar"] + found.step_errors["position"]) / whole < 10.0


LINEAR = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}


@functools.cache
def linear_motion(case, elements, order):
    material = vr.Material(2e11, 0.3, 7850.0, damping=vr.KelvinVoigt(1e-4, 1e-4))
    mesh = {
        "section": vr.Rectangle(0.02, 0.01),
        "material": material,
        "elements": elements,
        "order": order,
    }
    model = vr.Model()
    if case == "released":
        rod = vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 0, 1), 0.5, 2.0, **mesh)
    else:
        rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), **mesh)
    model.add("bar", rod)
    model.clamp("bar.start")
    if case == "sudden":
        model.distributed_force("bar", (0, 0, 3.0))
    else:
        model.force("bar.end", (0, 1.0, 1.0), until=0.0)
    if case == "stressed":
        model.force("bar.end", (0, 0, 30.0))
    initial = "reference" if case == "sudden" else "equilibrium"
    return model.simulate(0.1, initial=initial, tolerance=1e-7, output_interval=0.005, **LINEAR)


@pytest.mark.parametrize("case", ["sudden", "released", "stressed"])
@pytest.mark.parametrize(("elements", "order"), [(1, 4), (2, 3)])
def test_linear_motions_tell_the_error_of_their_mesh(case, elements, order):
    """Refinement: a damped bar, or an arc, beside six elements of order 5; the last vibrates about a loaded shape."""

    found, fine = linear_motion(case, elements, order), linear_motion(case, 6, 5)
    error = distance(along(found, "bar", 1.0), along(fine, "bar", 1.0))
    assert 1 / 3 < found.mesh_errors["bar"] / error < 10.0
    assert fine.mesh_errors["bar"] < 1e-6


def test_a_coarse_mesh_is_warned_of():
    """Refinement: a cable of 20 m falls and swings; two elements of order 5 are off by 0.8 % of it, six by nothing."""

    def cable(elements):
        material = vr.Material(100e9, 0.3, 7800.0, damping=vr.KelvinVoigt(1e-4, 1e-4))
        model = vr.Model()
        rod = vr.Rod.straight(
            (0, 0, 0), (20.0, 0, 0), section=vr.Circle(0.005), material=material, elements=elements, order=5
        )
        model.add("cable", rod)
        model.support("cable.start", ("ux", "uy", "uz", "rx"))
        model.gravity()
        return model.simulate(4.0, initial="reference", output_interval=0.02)

    coarse, fine = cable(2), cable(6)
    error = distance(along(coarse, "cable", 20.0), along(fine, "cable", 20.0))
    assert 0.002 < error < 0.02
    assert any("most in rod 'cable', whose mesh is coarse" in text for text in warnings_of(coarse))
    assert 0.3 * error < coarse.mesh_errors["cable"] < 10.0 * error
    assert "Mesh: 'cable' 2 elements of order 5; estimated errors: positions by" in flat(coarse.report())
    assert not warnings_of(fine)


def test_a_shaft_that_spins_about_its_line_has_no_coarse_mesh():
    """It stays where it is, within the tolerance of the steps: nothing can be said of its mesh by what is left."""
    model = vr.Model()
    steel = vr.Material(2e11, 0.3, 7850.0)
    line = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=steel, elements=4, order=3)
    model.add("shaft", line)
    model.support("shaft.start", ("ux", "uy", "uz"))
    model.support("shaft.end", ("uy", "uz"))
    model.velocity("shaft", angular=(100.0, 0, 0))
    run = model.simulate(0.03)
    assert np.abs(run.history("shaft@0.5", "displacement")).max() < 1e-6
    assert not any("positions may be off" in text for text in run.warnings)


@pytest.mark.parametrize("pushed", [0.0, 1e-5])
def test_a_model_that_stays_at_rest_errs_as_its_equilibrium_does(pushed) -> None:
    """What does not move is an equilibrium: inertia holds no error there, however short the run is."""
    model = vr.Model()
    rubber = vr.Material(1e7, 0.3, 1000.0, damping=vr.KelvinVoigt(0.002, 0.002))
    rod = vr.Rod.straight(
        (0, 0, 0), (0.5, 0, 0), section=vr.Circle(0.01), material=rubber, elements=2, order=4
    )
    model.add("rod", rod)
    model.clamp("rod.start")
    model.gravity()
    model.force("rod.end", (-0.05, 0, 0.01))
    if pushed:
        model.force("rod.end", (0, 0, pushed), until=0.0)
    held, run = model.equilibrium(), model.simulate(0.02)
    error = run.data.attrs["mesh_force_error"]
    assert error == pytest.approx(held.data.attrs["mesh_force_error"], rel=0.1)
    assert error < 0.01
    assert not [text for text in run.warnings if "mesh" in text]


@pytest.mark.parametrize("elements", [None, 8])
def test_estimate_of_moments_under_a_moving_force(elements) -> None:
    """A force crosses a simply supported beam at a quarter of the critical speed (Fryba 1972): sums of sines.

    The shear jumps at the force, within an element, on any mesh: that is told in words and is no error of the mesh.
    """
    L, side, E, rho, alpha = 1.0, 0.01, 1e9, 1000.0, 0.25
    EI, mass = E * side**4 / 12.0, rho * side**2
    pace = np.pi / L * np.sqrt(EI / mass)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0),
        (L, 0, 0),
        section=vr.Rectangle(side, side),
        material=vr.Material(E, 0.3, rho),
        elements=elements,
    )
    model.add("beam", rod)
    model.pin("beam.start")
    model.support("beam.end", ("uy", "uz", "rx"))
    force = 1e-3 * 48.0 * EI / L**2
    model.moving_force("beam", (0, -force, 0), speed=alpha * pace)
    run = model.simulate(0.99 * L / (alpha * pace))

    n = np.arange(1, 401)[:, None]
    omega, drive = (n * np.pi / L) ** 2 * np.sqrt(EI / mass), n * np.pi * alpha * pace / L
    t = np.asarray(run.time)
    q = (
        2.0
        * force
        / (mass * L)
        / (omega**2 - drive**2)
        * (np.sin(drive * t) - drive / omega * np.sin(omega * t))
    )
    s = run.data["point_s"].values
    exact = np.einsum("nt,nx->tx", q * EI * (n * np.pi / L) ** 2, np.sin(n * np.pi / L * s))
    moment = np.abs(run.data["section_force"].values[..., 3:5]).max(axis=2)
    error = np.abs(moment - np.abs(exact)).max() / np.abs(exact).max()
    assert error < 0.1
    assert 0.3 * error < run.data.attrs["mesh_force_error"] < 5.0 * error
    middle = -np.asarray(run.history("beam@0.5", "displacement"))[:, 1]
    assert middle.max() == pytest.approx(1.2576e-3 * L, rel=1e-3)
    assert "over which the jump of forces is spread" in " ".join(run.report().split())


def folded_rope(elements, order, gap=0.1):
    """A soft rope of 0.8 m that hangs in a U between two points, with and without its second end held."""
    turn = 0.5 * np.pi * gap
    leg = 0.5 * (0.8 - turn)

    def place(s):
        if s < leg:
            return 0.0, 0.0, -s
        if s > leg + turn:
            return gap, 0.0, s - 0.8
        angle = 2.0 * (s - leg) / gap
        return 0.5 * gap * (1.0 - np.cos(angle)), 0.0, -leg - 0.5 * gap * np.sin(angle)

    points = [place(s) for s in np.linspace(0.0, 0.8, 81)]
    material = vr.Material(2e6, poissons_ratio=0.3, density=1000.0)
    models = []
    for ends in (["rope.start", "rope.end"], ["rope.start"]):
        model = vr.Model()
        model.add(
            "rope",
            vr.Rod.through(
                points, section=vr.Circle(0.0025), material=material, elements=elements, order=order
            ),
        )
        for end in ends:
            model.pin(end)
        model.gravity()
        models.append(model)
    return models


def falling_rope(elements, order, **given):
    """The same, one end of which is let go."""
    held, falling = folded_rope(elements, order)
    return falling.simulate(0.4, start=held.equilibrium(), output_interval=0.004, **given)


@functools.cache
def refined_rope():
    """The same with three times the elements of the coarse ones."""
    return falling_rope(24, 3, tolerance=1e-5, errors=False)


@pytest.mark.parametrize(("elements", "order"), [(8, 3), (8, 2)])
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # section forces ring
def test_a_rope_that_is_let_go_tells_the_error_of_its_mesh(elements, order):
    """Refinement: three times the elements. The motion is that of a folded chain (Schagerl et al. 1997).

    It is pressed in places, where single states told 0.25 to 11 times the error, and steps choose the states.
    """
    fine = refined_rope()
    length = float(fine.data["station_s"].values[-1])  # that of the splines through the points
    runs = [falling_rope(elements, order, tolerance=tolerance) for tolerance in (1e-4, 1e-6)]
    told = [run.mesh_errors["rope"] for run in runs]
    for run, one in zip(runs, told, strict=True):
        assert 1.0 < one / distance(*(along(each, "rope", length) for each in (run, fine))) < 3.0
    assert told[0] == pytest.approx(told[1], rel=0.05)


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_a_run_on_a_finer_mesh_that_is_stopped_says_that_errors_are_not_known(caplog):
    """The motion is over, and its errors of steps are known; the last run is stopped after its first step."""
    caplog.set_level("INFO", logger="viscorod")
    run = falling_rope(8, 3, stop=lambda: "enough" if "elements half as long" in caplog.text else "")
    assert run.outcome == "completed"
    assert [one for one in run.warnings if one.startswith("the run on a finer mesh")]

"""Rest strains in time and along the rod: motions of every method against closed forms and equivalents."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

L, BENDING, TIME = 1.0, 2.0, 0.02
STIFFNESS = [400.0, 400.0, 800.0, BENDING, BENDING, 1.5]
SECTION = vr.StiffnessSection(
    STIFFNESS, [0.1, 0.1, 0.1, 1e-3, 1e-3, 2e-3], damping=[TIME * c for c in STIFFNESS]
)
FREQUENCY, CURVATURE = 0.8, 1.5
METHODS = [
    {"tolerance": 1e-7},
    {"integrator": "midpoint", "time_step": 2e-3},
    {"integrator": "generalized_alpha", "time_step": 2e-3, "tolerance": None},
    {"formulation": "intrinsic", "tolerance": 1e-7},
]


def cantilever(section: vr.StiffnessSection = SECTION, **more: Any) -> vr.Model:
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (L, 0, 0), section=section, **({"elements": 1, "order": 4} | more))
    model.add("arm", rod)
    model.clamp("arm.start")
    return model


@pytest.fixture(scope="module")
def by_a_moment() -> tuple[vr.Run, np.ndarray]:
    """The equivalent: an end moment that turns with the section, ``C kappa_r + D kappa_r'`` (planar bending)."""
    model = cantilever(elements=2, order=5)
    omega = 2.0 * np.pi * FREQUENCY
    size = BENDING * CURVATURE * np.hypot(1.0, TIME * omega)
    moved = vr.Sine(FREQUENCY, phase=float(np.arctan(TIME * omega)))
    model.moment("arm.end", (size, 0, 0), following=True, time=moved)
    run = model.simulate(0.4, output_interval=0.1, tolerance=1e-7, initial="reference")
    return run, np.asarray(run.history("arm.end").values)


@pytest.mark.parametrize(
    "settings", METHODS, ids=lambda s: s.get("integrator", s.get("formulation", "radau"))
)
def test_a_muscle_moves_the_rod_as_the_moment_that_it_is_equivalent_to(
    by_a_moment: tuple[vr.Run, np.ndarray], settings: dict[str, Any]
) -> None:
    model = cantilever(elements=2, order=5)
    model.rest_strain("arm", (0, 0, 0, CURVATURE, 0, 0), vr.Sine(FREQUENCY))
    run = model.simulate(0.4, output_interval=0.1, **settings)
    coarse = "time_step" in settings  # second order in 2 ms
    assert np.abs(run.history("arm.end").values - by_a_moment[1]).max() < (2e-4 if coarse else 2e-6)
    energy = run.energy
    # nothing acts on the rod but what changes the rest strain
    assert not energy.external.any()
    gained = energy.kinetic + energy.elastic + energy.viscous - energy.numerical
    assert energy.actuator == pytest.approx(gained - gained[0], abs=1e-12)
    assert energy.actuator[-1] > 0.1
    least = 1e-3 if "generalized_alpha" in settings.values() else 2e-6
    assert energy.numerical_fraction < least
    assert "work of rest strains" in flat(str(energy))


def test_functions_of_arc_length_and_time_and_tables_along_the_rod_say_the_same() -> None:
    ways: list[Callable[[vr.Model], None]] = [
        lambda m: m.rest_strain("arm", lambda s: (0, 0, 0, s, 0, 0), lambda t: np.sin(3.0 * t)),
        lambda m: m.rest_strain("arm", lambda s, t: (0, 0, 0, s * np.sin(3.0 * t), 0, 0)),
        lambda m: m.rest_strain(
            "arm",
            stations=[0.0, L],
            values=[[0] * 6, [0, 0, 0, L, 0, 0]],
            time=vr.Sine(3.0 / (2.0 * np.pi)),
        ),
    ]
    found = []
    for way in ways:
        model = cantilever()
        way(model)
        run = model.simulate(0.2, output_interval=0.1, tolerance=1e-5)
        found.append((run.history("arm.end").values, run.energy.actuator))
    for other in found[1:]:
        assert other[0] == pytest.approx(found[0][0], abs=1e-9)
        assert other[1] == pytest.approx(found[0][1], abs=1e-9)
    assert np.ptp(found[0][0][:, 2]) > 0.01


def test_a_free_cantilever_takes_an_elongation_and_two_curvatures() -> None:
    # as code_aster's V3.01.104, large: r' = exp(s [u]) v in the frame of the start, no force anywhere
    u, v = 100.0 * np.array([0.002, 0.003, 0.0]), np.array([0.0, 0.0, 1.1])
    model = cantilever(elements=1, order=5)
    model.rest_strain("arm", (0, 0, 0.1, *u))
    found = model.equilibrium()
    size = np.linalg.norm(u)
    K = np.cross(u / size, np.eye(3)).T
    a = size * L
    travelled = (np.eye(3) * L + (1 - np.cos(a)) / size * K + (a - np.sin(a)) / size * K @ K) @ v
    frame = model.rods["arm"].frames([0.0])[1][0]
    assert found.position("arm.end") == pytest.approx(frame @ travelled, abs=1e-9)
    assert np.abs(found.reactions.values).max() < 1e-9


def test_a_rod_grows_into_a_helix() -> None:
    # rest curvature and twist ramped in time: radius kappa/(kappa^2+tau^2), pitch 2 pi tau/(kappa^2+tau^2)
    kappa, tau = 5.0, 3.0
    slow = [0.5 * c for c in STIFFNESS]  # half a second: it creeps
    section = vr.StiffnessSection(STIFFNESS, [1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 2e-5], damping=slow)
    model = vr.Model()
    model.add("arm", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=section, elements=2, order=5))
    model.clamp("arm.start")
    model.rest_strain("arm", (0, 0, 0, kappa, 0, tau), vr.Ramp(0.0, 1.0))
    run = model.simulate(8.0, output_interval=4.0, tolerance=1e-5)
    r = run.field("position", states=-1)
    mesh = np.asarray(run.data["station_s"].values)
    # the axis along the Darboux vector u = kappa d1 + tau d3, through r0 + (u x ...) of the start
    frame = model.rods["arm"].frames([0.0])[1][0]
    size = np.hypot(kappa, tau)
    axis = (kappa * frame[:, 0] + tau * frame[:, 2]) / size
    radius, pitch = kappa / size**2, 2.0 * np.pi * tau / size**2
    centre = np.zeros(3) - radius * frame[:, 1]  # d1 x d3 points away from where it bends
    across = (r - centre) - np.outer((r - centre) @ axis, axis)
    assert np.linalg.norm(across, axis=1) == pytest.approx(radius, rel=1e-5)
    assert (r - r[0]) @ axis == pytest.approx(pitch * mesh * size / (2.0 * np.pi), abs=1e-5)
    assert run.energy.elastic[-1] < 1e-8
    assert run.energy.actuator[-1] == pytest.approx(run.energy.viscous[-1], rel=0.01)  # all of it is lost


def test_a_held_rod_relaxes_after_a_step_of_its_rest_strain() -> None:
    # N = -(E + sum E_j exp(-t/tau_j)) A e, and each branch loses E_j A e^2 L (1 - exp(-2 t/tau_j))/2
    young, area, strain = 1e6, 1e-4, 1e-3
    damping = vr.Prony(
        shear_moduli=[2e5, 1e5], shear_times=[0.05, 0.5], bulk_moduli=[2e5, 1e5], bulk_times=[0.05, 0.5]
    )
    material = vr.Material(youngs_modulus=young, poissons_ratio=0.0, density=1000.0, damping=damping)
    branches = [(b.youngs_modulus, b.time) for b in material.branches]
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    model.add(
        "bar", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=section, material=material, elements=1, order=2)
    )
    model.clamp("bar.start")
    model.clamp("bar.end")
    step = vr.TimeTable([0.0, 0.1, 0.1, 1.0], [0.0, 0.0, 1.0, 1.0])
    model.rest_strain("bar", (0, 0, strain, 0, 0, 0), step)
    run = model.simulate(0.4, output_interval=0.1, time_step=0.02)  # nothing moves: no error asks for steps
    time = run.time[2:] - 0.1
    wanted = -area * strain * (young + sum(e * np.exp(-time / tau) for e, tau in branches))
    force = run.data["section_force"].sel(component="stretch").values
    assert np.abs(force[:2]).max() < 1e-9
    assert force[2:] == pytest.approx(np.broadcast_to(wanted[:, None], force[2:].shape), rel=1e-6)
    square = 0.5 * area * strain**2 * L
    lost = [square * e * (1.0 - np.exp(-2.0 * time[-1] / tau)) for e, tau in branches]
    assert run.energy.branches[-1] == pytest.approx(lost, rel=1e-5)
    assert run.energy.actuator[-1] == pytest.approx(square * (young + sum(e for e, _ in branches)), rel=1e-6)
    assert run.energy.numerical_fraction < 1e-6


def test_jumps_are_refused_where_dashpots_would_answer_with_infinite_forces() -> None:
    model = cantilever()
    model.rest_strain("arm", (0, 0, 0, 1, 0, 0), vr.Until(0.1))
    with pytest.raises(vr.InputError, match="infinite force"):
        model.simulate(0.2)


def test_a_rod_is_let_go_by_its_muscle() -> None:
    # at rest with a rest curvature, which ends at t = 0: it begins with the energy of the curvature that it has
    model = cantilever()
    model.rest_strain("arm", (0, 0, 0, CURVATURE, 0, 0), vr.Until(0.0))
    energy = model.simulate(0.05, output_interval=0.025, tolerance=1e-5).energy
    assert energy.elastic[0] == pytest.approx(0.5 * BENDING * CURVATURE**2 * L, rel=1e-6)
    assert energy.viscous[-1] > 0.1 * energy.elastic[0]
    assert not energy.actuator.any()


def test_strains_that_constraints_hold_do_not_change() -> None:
    model = cantilever(constraints="inextensible")
    model.rest_strain("arm", (0, 0, 0.1, 0, 0, 0), vr.Ramp(0.0, 0.1))
    with pytest.raises(vr.InputError, match="inextensible hold a strain whose rest strain changes"):
        model.simulate(0.2)


def test_a_bimetal_strip_bends_as_timoshenko_says() -> None:
    # Timoshenko (1925): 6 (a2-a1) dT (1+m)^2 / (h (3 (1+m)^2 + (1+mn)(m^2 + 1/(mn))))
    thin, thick, width, warmer = 1e-3, 2e-3, 5e-3, 100.0
    common = {"poissons_ratio": 0.3, "density": 8000.0}
    one = vr.Material(youngs_modulus=1e11, thermal_expansion=1e-5, **common)
    other = vr.Material(youngs_modulus=2e11, thermal_expansion=2e-5, **common)
    w = width / 2.0
    regions = [
        vr.CompositeRegion(one, points=[(-w, 0), (w, 0), (w, thin), (-w, thin)]),
        vr.CompositeRegion(other, points=[(-w, -thick), (w, -thick), (w, 0), (-w, 0)]),
    ]
    section = vr.Composite(regions, mesh_size=2e-3)
    model = vr.Model()
    model.add("strip", vr.Rod.straight((0, 0, 0), (0.1, 0, 0), section=section, elements=1, order=4))
    model.clamp("strip.start")
    model.rest_strain("strip", temperature=warmer)
    m, n, h = thin / thick, 0.5, thin + thick
    curvature = (
        6.0 * 1e-5 * warmer * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    )
    found = model.equilibrium()
    turned = found.rotation("strip.end")
    assert abs(turned[1]) == pytest.approx(curvature * 0.1, rel=1e-9)
    with pytest.raises(vr.InputError, match="balance each other"):  # they have no section force
        found.stress("strip.end")
    assert np.abs(found.reactions.values).max() < 1e-6


def test_heat_on_one_side_of_a_plain_section() -> None:
    material = vr.Material(youngs_modulus=1e9, poissons_ratio=0.3, density=1e3, thermal_expansion=1e-4)
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.02)
    model.add("bar", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=section, material=material, elements=1))
    model.clamp("bar.start")
    model.rest_strain("bar", temperature=10.0, gradient=(0.0, 500.0))  # warmer along d2
    end = model.equilibrium().displacement("bar.end")
    angle, stretch = 500.0 * 1e-4 * L, 1.0 + 10.0 * 1e-4
    radius = stretch * L / angle
    # it bends away from the warm side, towards -d2 = -z
    assert end == pytest.approx([radius * np.sin(angle) - L, 0.0, -radius * (1.0 - np.cos(angle))], abs=1e-9)
    bare = cantilever()
    bare.rest_strain("arm", temperature=10.0)
    with pytest.raises(vr.InputError, match="thermal expansion is not known"):
        bare.equilibrium()


def turned(matrix: np.ndarray, turn: np.ndarray) -> list[list[float]]:
    both = np.kron(np.eye(2), turn)
    return (both.T @ matrix @ both).tolist()


@pytest.mark.parametrize("settings", [{}, {"formulation": "intrinsic"}], ids=["geometric", "intrinsic"])
def test_oblique_sections_describe_the_same_rod(settings: dict[str, str]) -> None:
    # the same rod, once with normal sections, once with those that Q turns: strains Q^T eps, matrices T^T C T
    tilt = (0.3, -0.5, 0.4)
    turn = rotation(tilt)
    inertia = np.diag([0.1, 0.1, 0.1, 1e-3, 1e-3, 2e-3])
    C = np.diag(STIFFNESS)
    oblique = vr.StiffnessSection(turned(C, turn), turned(inertia, turn), damping=turned(TIME * C, turn))
    found = []
    for section, more in ((SECTION, {}), (oblique, {"tilt": tilt})):
        model = cantilever(section, **more)
        model.gravity()
        strain = np.array([0.0, 0.05, 0.0, 0.5, 0.0, 0.3])
        if more:
            strain = np.kron(np.eye(2), turn).T @ strain
        model.rest_strain("arm", strain.tolist(), vr.Ramp(0.0, 0.2))
        run = model.simulate(0.3, output_interval=0.1, tolerance=1e-7, **settings)
        found.append(
            (run, model.modes(4, about="equilibrium").frequencies, model.equilibrium().position("arm.end"))
        )
    (plain, modes, rest), (tilted, other_modes, other_rest) = found
    assert other_rest == pytest.approx(rest, abs=1e-9)
    assert other_modes == pytest.approx(modes, rel=1e-7)
    assert tilted.history("arm.end").values == pytest.approx(plain.history("arm.end").values, abs=2e-6)
    strain = np.einsum("ij,tpj->tpi", np.kron(np.eye(2), turn), tilted.data["strain"].values)
    assert strain == pytest.approx(plain.data["strain"].values, abs=2e-5)
    assert tilted.energy.actuator == pytest.approx(plain.energy.actuator, abs=1e-6)


def rotation(vector: tuple[float, float, float]) -> np.ndarray:
    """Return the matrix of a rotation vector (Rodrigues)."""
    x, y, z = vector
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.linalg.norm(vector)
    return np.eye(3) + np.sin(angle) / angle * K + (1.0 - np.cos(angle)) / angle**2 * K @ K


def test_what_does_not_take_rest_strains_in_time_says_so() -> None:
    model = cantilever()
    model.rest_strain("arm", (0, 0, 0, 1, 0, 0), vr.Sine(1.0))
    for settings in ({"dynamics": "linear"}, {}):
        with pytest.raises(vr.InputError, match="change"):
            model.simulate(0.1, formulation="intrinsic", damping="linearised", **settings)
    with pytest.raises(vr.InputError, match="a steady rotation does not"):
        model.steady((0, 5, 0))

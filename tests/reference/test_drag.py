"""Drag: falls, decays, flutter and equilibria in a medium, against closed forms and an independent eigenproblem."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import viscorod as vr
from helpers.plain_text import flat

LENGTH, DIAMETER, DENSITY, G = 0.3, 0.006, 1000.0, 9.81
MASS = DENSITY * np.pi / 4 * DIAMETER**2
LINEAR, SPRAY = {"linear_across": 0.5}, {"coefficient_across": 1.2, "density": 20.0, "width": DIAMETER}
SQUARE = 0.5 * 1.2 * 20.0 * DIAMETER
FINE = {"tolerance": 1e-6}
WAYS = {
    "radau": (FINE, 1e-5),
    "midpoint": ({"integrator": "midpoint", "time_step": 0.004}, 1e-4),
    "generalized_alpha": ({"integrator": "generalized_alpha", "time_step": 0.004}, 1e-4),
    "intrinsic": (FINE | {"formulation": "intrinsic"}, 1e-5),
    "linearised": (FINE | {"formulation": "intrinsic", "damping": "linearised"}, 1e-5),
}


def noodle(**drag):
    """A level rod of soft rubber in gravity and a medium."""
    rubber = vr.Material(
        youngs_modulus=1e6,
        poissons_ratio=0.3,
        density=DENSITY,
        damping=vr.KelvinVoigt(shear_time=1e-3, bulk_time=1e-3),
    )
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (LENGTH, 0, 0), section=vr.Circle(0.5 * DIAMETER), material=rubber, elements=2
    )
    model.add("noodle", rod)
    model.gravity((0, 0, -G))
    model.drag("noodle", **drag)
    return model


def fall(run):
    """Return times and velocities downwards of the middle."""
    velocity = run.history("noodle@0.15", "velocity")
    return velocity["time"].values, -velocity.sel(axis="z").values


@pytest.mark.parametrize("way", WAYS)
def test_noodle_falls_to_its_terminal_speed(way):
    """Galileo and Newton: v_t tanh(g t/v_t), v_t = sqrt(m g/k); the loss is that of k v^3, in closed form."""
    settings, part = WAYS[way]
    run = noodle(**SPRAY).simulate(0.8, initial="reference", **settings)
    t, v = fall(run)
    end = np.sqrt(G * MASS / SQUARE)
    assert v == pytest.approx(end * np.tanh(G * t / end), abs=part * end)
    tanh = np.tanh(G * t / end)
    depth = end**2 / G * np.log(np.cosh(G * t / end))
    loss = LENGTH * MASS * (G * depth - 0.5 * (end * tanh) ** 2)  # what falls less what moves
    energy = run.energy
    assert energy.outside == pytest.approx(loss, abs=3.0 * part * loss[-1])
    assert energy.external == pytest.approx(LENGTH * MASS * G * depth, abs=3.0 * part * loss[-1])
    assert energy.numerical_fraction < 3.0 * part
    assert "lost to drag" in flat(str(energy))


def test_noodle_in_a_thick_fluid_loses_what_its_drag_takes():
    """Linear drag: v = v_t (1 - exp(-c t/m)), v_t = m g/c; the loss is c times the integral of its square."""
    run = noodle(**LINEAR).simulate(0.5, initial="reference", **FINE)
    t, v = fall(run)
    time, end = MASS / 0.5, G * MASS / 0.5
    assert v == pytest.approx(end * -np.expm1(-t / time), abs=1e-5 * end)
    loss = (
        0.5
        * LENGTH
        * end**2
        * (t + 2.0 * time * np.expm1(-t / time) - 0.5 * time * np.expm1(-2.0 * t / time))
    )
    assert run.energy.outside == pytest.approx(loss, abs=2e-5 * loss[-1])
    assert run.energy.viscous[-1] < 1e-9 * loss[-1]


def test_wind_carries_a_rod_along():
    """Linear drag in wind: v = U (1 - exp(-c t/m)), the wind does the work c U v, and c v^2 of it is lost outside."""
    speed, time = 0.7, MASS / 0.5
    model = noodle(**LINEAR, linear_along=0.5, velocity=(0, 0, -speed))
    model.loads.pop(0)  # the gravity
    run = model.simulate(0.3, initial="reference", **FINE)
    t, v = fall(run)
    assert v == pytest.approx(-speed * np.expm1(-t / time), abs=1e-5 * speed)
    lost = t + 2.0 * time * np.expm1(-t / time) - 0.5 * time * np.expm1(-2.0 * t / time)
    work = t + time * np.expm1(-t / time)
    scale = 0.5 * LENGTH * speed**2
    assert run.energy.outside == pytest.approx(scale * lost, abs=2e-5 * scale * lost[-1])
    assert run.energy.external == pytest.approx(scale * work, abs=2e-5 * scale * work[-1])


def test_linear_dynamics_know_drag():
    """The same closed form where the motion is linear about the level rod, and the account of it closes."""
    options = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"} | FINE
    run = noodle(**LINEAR).simulate(0.5, initial="reference", **options)
    t, v = fall(run)
    time, end = MASS / 0.5, G * MASS / 0.5
    assert v == pytest.approx(end * -np.expm1(-t / time), abs=1e-5 * end)
    assert run.energy.outside[-1] > 0.9 * run.energy.external[-1]
    assert run.energy.numerical_fraction < 1e-5
    changing = noodle(**LINEAR, until=1.0)
    with pytest.raises(vr.InputError, match=r"loads\[1\]: drag: linear dynamics have constant matrices"):
        changing.simulate(0.5, initial="reference", **options)


def cantilever(**drag):
    """EI = 1, length and mass per length of 1, without damping of its own."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 4.0, 1.0], [1, 1, 1, 1e-8, 1e-8, 1e-4])
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4, d1=(0, 1, 0)))
    model.clamp("beam.start")
    model.drag("beam", **drag)
    return model


def test_damping_ratios_of_a_cantilever():
    """c/(2 m w_n) across, in bending; c/(2 J w_n) about the axis, in torsion: exact for uniform damping."""
    modes = cantilever(linear_across=0.3, linear_about=2e-4).modes(8)
    omega = 2.0 * np.pi * modes.frequencies
    expected = np.where(
        [name.startswith("twist") for name in modes.names], 2e-4 / (2.0 * 1e-4 * omega), 0.3 / (2.0 * omega)
    )
    assert modes.damping_ratios == pytest.approx(expected, rel=1e-4)
    assert {name.split()[0] for name in modes.names} >= {"bend_1", "bend_2", "twist"}


def test_still_air_does_not_damp_small_motions_and_wind_does():
    """A quadratic law has no slope at rest; in a cross wind 2 k U along it, half as much across both (k U)."""
    assert cantilever(coefficient_across=1.0, density=1.0, width=0.2).modes(
        4
    ).damping_ratios == pytest.approx(np.zeros(4), abs=1e-12)
    k, speed = 0.5 * 0.2, 0.01
    windy = cantilever(coefficient_across=1.0, density=1.0, width=0.2, velocity=(0, speed, 0)).modes(2)
    omega = 2.0 * np.pi * windy.frequencies
    ratios = sorted(2.0 * omega * windy.damping_ratios)
    assert ratios == pytest.approx([k * speed, 2.0 * k * speed], rel=1e-3)


def test_decay_in_a_medium():
    """A small free vibration decays by c/(2 m w_1), and all of it goes outside."""
    model = cantilever(linear_across=0.6)
    model.distributed_force("beam", (0, 0, 0.01), until=0.0)
    run = model.simulate(6.0)
    ratios = run.decrement("beam.end", axis="z").damping_ratio
    assert ratios.mean() == pytest.approx(0.6 / (2.0 * 1.8751**2), rel=5e-3)
    energy = run.energy
    assert energy.outside[-1] == pytest.approx(energy.total[0] - energy.total[-1], rel=2e-3)
    assert np.all(np.diff(energy.outside) >= 0.0)
    assert not energy.viscous.any()
    assert "drag takes 100 % of what is lost" in flat(run.report())


def spectral_beck(load, count=40):
    """Eigenvalues mu of y'''' + P y'' = mu y on a cantilever with a following force, by Chebyshev collocation."""
    x = np.cos(np.pi * np.arange(count + 1) / count)
    c = np.r_[2.0, np.ones(count - 1), 2.0] * (-1.0) ** np.arange(count + 1)
    D = np.outer(c, 1.0 / c) / (x[:, None] - x + np.eye(count + 1))
    D = 2.0 * (D - np.diag(D.sum(axis=1)))  # from 0 (last) to 1 (first)
    D2 = D @ D
    operator, ones = D2 @ D2 + load * D2, np.eye(count + 1)
    for row, condition in zip((0, 1, -1, -2), (D2[0], (D2 @ D)[0], ones[-1], D[-1]), strict=True):
        operator[row], ones[row] = condition, 0.0
    mu = scipy.linalg.eigvals(operator, ones)
    return mu[np.isfinite(mu) & (np.abs(mu) < 1e5)]


def flutter_load(damping):
    """Load at which s^2 + c s + mu = 0 first has a growing s, for any eigenvalue mu."""

    def growth(load):
        mu = spectral_beck(load)
        return max(np.roots([1.0, damping, value]).real.max() for value in mu)

    low, high = 18.0, 45.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if growth(middle) > 1e-7 else (middle, high)
    return high


@pytest.mark.parametrize(("damping", "published"), [(1e-3, 20.05), (10.0, None), (1e3, 37.7)])
def test_beck_column_in_a_medium(damping, published):
    """Plaut and Infante 1970: from 20.05 EI/L^2 on, and later with external damping, towards 37.7."""
    load = flutter_load(damping)
    if published is not None:
        assert load == pytest.approx(published, rel=2e-3)
    for part, stable in ((0.995, True), (1.005, False)):
        model = cantilever(linear_across=damping)
        model.force("beam.end", (0, 0, -part * load), following=True)
        assert model.equilibrium().stable is stable


def test_load_factor_leaves_a_medium_at_rest_as_it_is():
    """The path of the following force flutters where the damping of the whole medium says."""
    model = cantilever(linear_across=10.0)
    model.force("beam.end", (0, 0, -10.0), following=True)
    path = model.path(load_factor=3.5)
    assert 10.0 * path.flutter_points[0] == pytest.approx(flutter_load(10.0), rel=1e-3)


def test_wind_that_pushes_alike_in_all_directions_is_a_line_load():
    """With equal linear coefficients the force is c U whatever the shape: large deflections as under a line load."""
    wind = cantilever(linear_across=4.0, linear_along=4.0, velocity=(0, 0, 1.5)).equilibrium()
    loaded = cantilever(linear_across=4.0)
    loaded.distributed_force("beam", (0, 0, 6.0))
    for s in (0.3, 1.0):
        assert wind.position(f"beam@{s}") == pytest.approx(
            loaded.equilibrium().position(f"beam@{s}"), abs=1e-9
        )
    assert wind.position("beam.end")[2] > 0.4


@pytest.mark.parametrize("strength", [0.3, 4.0])
def test_rod_hangs_in_a_cross_wind(strength):
    """k U^2 cos^2 a = m g sin a (the critical angle of a towed cable), along the whole rod, whatever its stiffness."""
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1e-2, 1e-2, 1e-2], [1, 1, 1, 1e-6, 1e-6, 2e-6])
    model = vr.Model()
    model.add("rope", vr.Rod.straight((0, 0, 0), (0, 0, -1), section=section, elements=3))
    model.support("rope.start", ("ux", "uy", "uz", "rz"))
    model.gravity((0, 0, -1.0))
    model.drag("rope", coefficient_across=1.0, density=2.0, width=strength, velocity=(1.0, 0, 0))
    sine = (-1.0 + np.sqrt(1.0 + 4.0 * strength**2)) / (2.0 * strength)
    found = model.equilibrium()
    x, _, z = found.position("rope.end")
    assert x / np.hypot(x, z) == pytest.approx(sine, abs=1e-4)
    assert np.abs(found.data["strain"].values[..., 3:]).max() < 1e-6
    assert found.stable


def test_propeller_in_still_air_turns_steadily():
    """Drag k (W s)^2 along a blade on its hub bends its tip by 13 k W^2 L^6/(180 EI) against the motion."""
    section = vr.StiffnessSection([1e9, 1e9, 1e9, 1e4, 1e4, 1e4], [1, 1, 1, 1e-6, 1e-6, 2e-6])
    model = vr.Model()
    model.add("blade", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2))
    model.clamp("blade.start")
    model.drag("blade", coefficient_across=1.0, linear_along=0.1, linear_about=1e-4, density=1.0, width=0.2)
    spin, k = 3.0, 0.1
    steady = model.steady(spin=(0, 0, spin))
    bent = -13.0 / 180.0 * k * spin**2 / 1e4
    assert steady.position("blade.end")[1] == pytest.approx(bent, rel=1e-3)
    assert steady.stable
    assert steady.eigenvalues.real.max() < 0.0  # drag damps all small motions, and nothing else does
    with pytest.raises(vr.InputError, match=r"loads\[0\]: drag: it sees the motion"):
        model.steady(spin=(0, 0, spin), formulation="intrinsic")
    model.drag("blade", linear_across=1.0, velocity=(1.0, 0, 0))
    with pytest.raises(vr.InputError, match=r"loads\[1\]: drag: the medium moves across the axis"):
        model.steady(spin=(0, 0, spin))


@pytest.mark.parametrize("spin", [3.0, 15.0])
def test_shaft_in_a_medium_whirls_down_at_any_speed(spin):
    """Drag from outside damps whirling by c/(2 m) below and above the critical speed (pi^2), whoever turns along."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1, 1, 1, 1e-7, 1e-7, 2e-7])
    model = vr.Model()
    model.add("shaft", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section, elements=3))
    model.support("shaft.start", ("ux", "uy", "uz", "rz"))
    model.support("shaft.end", ("ux", "uy"))
    model.drag("shaft", linear_across=0.4)
    steady = model.steady(spin=(0, 0, spin))
    slowest = steady.eigenvalues[np.abs(steady.eigenvalues) < 60.0]
    assert slowest.real == pytest.approx(np.full(len(slowest), -0.2), rel=1e-4)
    omega = np.sqrt(np.pi**4 - 0.2**2)
    for whirl in (omega - spin, omega + spin):
        assert np.abs(np.abs(slowest.imag) - abs(whirl)).min() < 1e-3 * omega
    assert steady.stable


@pytest.mark.parametrize("elements", [3, None])
def test_drag_on_a_part_of_a_rod(elements):
    """c/(2 m w) times the share of the square of the sine that lies in it, on pinned ends; elements end there."""
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 1.0, 4.0, 1.0], [1, 1, 1, 1e-9, 1e-9, 1e-4])
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, d1=(0, 1, 0))
    model.add("beam", rod)
    model.support("beam.start", ("ux", "uy", "uz", "rx"))
    model.support("beam.end", ("uy", "uz"))
    first, last = 0.25, 0.6
    model.drag("beam", linear_across=0.3, from_s=first, to_s=last)
    modes = model.modes(1)
    share = last - first - (np.sin(2.0 * np.pi * last) - np.sin(2.0 * np.pi * first)) / (2.0 * np.pi)
    omega = 2.0 * np.pi * modes.frequencies[0]
    assert modes.damping_ratios[0] == pytest.approx(0.3 * share / (2.0 * omega), rel=1e-3)


def test_co_simulation_falls_to_the_terminal_speed():
    """The same noodle, driven from outside step by step."""
    falling = noodle(**SPRAY).co_simulation(ports=["noodle@0.15"], initial="reference", tolerance=1e-6)
    end = np.sqrt(G * MASS / SQUARE)
    falling.step(0.3)
    assert -falling.velocity("noodle@0.15")[2] == pytest.approx(end * np.tanh(G * 0.3 / end), rel=1e-4)

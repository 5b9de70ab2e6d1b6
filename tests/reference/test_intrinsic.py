"""The intrinsic formulation beside the geometric one, its energy balance, and the beam models it contains (AWP IV)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import cantilever, stiff


def released(elements, order):
    """LLT's cantilever, pulled sideways to 0.66 of its length and released."""
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = cantilever(section, 0.3, elements, order, rubber)
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model, 0.3, {}


def hinged(elements, order):
    """AWP V.B, eta = 0.001 s: a beam at a ball joint, driven by following torques at its tip."""
    stiffness = np.diag([5e3, 5e3, 1e4, 1.0, 2.0, 1.0])
    section = vr.StiffnessSection(stiffness, np.diag([1, 1, 1, 2e-4, 2e-4, 4e-4]), 1e-3 * stiffness)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=order)
    model.add("beam", rod)
    model.support("beam.start", ("ux", "uy", "uz"))
    model.moment("beam.end", (0.5, 0.5, 0), following=True, time=vr.Sine(2.0), until=0.5)
    return model, 1.0, {"initial": "reference"}


def shaken(elements, order):
    """A curved, twisted rod of a coupled section with unequal times, off-centre mass, loads, and a moving base."""
    stiffness = np.diag([800.0, 700.0, 2e3, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 10.0
    stiffness[3, 5] = stiffness[5, 3] = 0.2
    inertia = np.diag([1.0, 1.0, 1.0, 1e-2, 2e-2, 3e-2])
    inertia[0, 5] = inertia[5, 0] = -0.02
    inertia[1, 5] = inertia[5, 1] = 0.01
    damping = 0.01 * (stiffness + np.diag([400.0, 0.0, 900.0, 1.0, 0.0, 0.4]))
    section = vr.StiffnessSection(stiffness, inertia, damping)
    given = {"section": section, "elements": elements, "order": order, "twist": 0.8}
    model = vr.Model()
    model.add("rod", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2, **given))
    model.clamp("rod.start", motion={"uy": vr.SpinUp(0.4, 1.0), "rz": vr.SpinUp(1.0, 1.0)})
    model.force("rod.end", (0.4, 0.8, 1.0), time=vr.Sine(1.0))
    model.moment("rod.end", (0.2, 0.0, -0.3), following=True, time=vr.Sine(0.7))
    model.gravity((0, 0, -0.5))
    return model, 1.2, {}


CASES = {
    "released cantilever": (released, 10.0, (1, 2), 4),
    "hinged beam": (hinged, 2.0, (2, 4), 4),
    "shaken composite arc": (shaken, 1.5, (1, 2), 4),
}


def distance(make, elements, order, duration, tolerance):
    """Largest distance of positions over the length, and of energies over the largest, between the formulations."""
    model, length, given = make(elements, order)
    runs = [
        model.simulate(
            duration,
            formulation=name,
            tolerance=tolerance,
            output_interval=duration / 100,
            errors=False,
            **given,
        ).data
        for name in ("geometric", "intrinsic")
    ]
    a, b = (run["position"].values for run in runs)
    energies = [np.array([run[name].values for name in ("kinetic", "elastic", "viscous")]) for run in runs]
    scale = np.abs(energies[0]).max()
    gap = runs[1].attrs["pose_gap"] / length, runs[1].attrs["rotation_gap"]
    return np.abs(a - b).max() / length, np.abs(energies[0] - energies[1]).max() / scale, *gap


@pytest.mark.parametrize("name", CASES)
def test_both_formulations_agree(name):
    """Independent formulation: differences fall with the mesh at its order at least, and below 1e-6 on a fine mesh.

    So does the distance of the poses integrated in time from those that the strains give along the rod.
    """
    make, duration, (few, more), order = CASES[name]
    coarse = np.array(distance(make, few, order, duration, 1e-7))
    fine = np.array(distance(make, more, order, duration, 1e-7))
    assert np.all(coarse > 1e-6)
    assert np.all(coarse / fine > 0.7 * 2**order)
    finest = distance(make, more, order + 3, duration, 1e-8)
    assert max(finest) < 1e-6


@pytest.mark.parametrize("damping", ["full", "linearised"])
@pytest.mark.parametrize("name", ["released cantilever", "hinged beam"])
def test_energy_balance_of_the_midpoint_rule(name, damping):
    """AWP (19), (32): energy changes by the work of loads less what damping takes, step by step, to round-off.

    The dissipated energy is summed up here from the recorded strain rates' powers at the middle of the steps only as a
    check of its size: within the error of the sum.
    """
    make, duration, (_, elements), order = CASES[name]
    model, _, given = make(elements, order)
    duration = min(duration, 1.0)
    run = model.simulate(
        duration,
        formulation="intrinsic",
        damping=damping,
        integrator="midpoint",
        time_step=duration / 500,
        errors=False,
        **given,
    ).data
    moved = float(np.abs(run["viscous"]).max())
    assert float(np.abs(run["numerical"]).max()) < 1e-8 * moved
    power = (run["dissipation"] * run["point_weight"]).sum("point").values
    time = run["time"].values
    summed = float(np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(time)))
    assert summed == pytest.approx(moved, rel=0.02)
    assert np.all(np.diff(run["viscous"].values) >= -1e-14 * moved)


def helix(order, damping):
    """A free helix of a coupled section."""
    stiffness = np.diag([80.0, 70.0, 200.0, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 3.0
    section = vr.StiffnessSection(stiffness, [1, 1, 1, 1e-2, 2e-2, 3e-2], damping * stiffness)
    model = vr.Model()
    model.add("rod", vr.Rod.helix(0.3, 0.4, 1.0, section=section, elements=3, order=order))
    return model


def test_momentum_of_free_flight_converges_with_the_mesh():
    """Conservation law: tested in body frames, linear and angular momentum are kept to the order of the mesh."""
    drifts = []
    for order in (3, 5, 7):
        model = helix(order, 0.01)
        model.velocity("rod", field=lambda s: ((np.sin(3 * s), 1.0, s), (2.0, s, -1.0)))
        run = model.simulate(1.0, initial="reference", formulation="intrinsic", tolerance=1e-9, errors=False)
        for name in ("linear_momentum", "angular_momentum"):
            value = run.data[name].values
            drifts.append(np.abs(value - value[0]).max() / np.linalg.norm(value[0]))
    drifts = np.array(drifts).reshape(3, 2)
    assert np.all(drifts[1:] < drifts[:-1] / 15)
    assert np.all(drifts[-1] < 1e-6)


def test_slow_loading_ends_in_the_static_equilibrium():
    """E6, independent formulation: the intrinsic rod comes to rest where statics of the geometric one ends."""
    gaps = []
    for order in (2, 4, 6):
        model = helix(order, 0.5)
        model.clamp("rod.start")
        model.force("rod.end", (0.05, 0.1, 0.2), time=vr.TimeTable([0, 40], [0, 1], "cubic"))
        given = {"tolerance": 1e-7, "output_interval": 100.0}
        run = model.simulate(100.0, initial="reference", formulation="intrinsic", errors=False, **given)
        model.loads.clear()
        model.force("rod.end", (0.05, 0.1, 0.2))
        expected = model.equilibrium().position("rod.end")
        gaps.append(np.abs(run.history("rod.end").values[-1] - expected).max())
    assert np.all(np.array(gaps[1:]) < np.array(gaps[:-1]) / 10)
    assert gaps[-1] < 3e-7


LINEAR = [
    pytest.param(({"damping": "linearised", "dynamics": "linear", "tolerance": 1e-7}, 1.0), id="linear"),
    pytest.param(({"damping": "linearised", "tolerance": 1e-10}, 1e-4), id="linearised damping"),
    pytest.param(({"tolerance": 1e-10}, 1e-4), id="full damping"),
]
"""Settings and amplitude of the velocity: small where the motion is not linear."""


def decaying(time, omega, tau):
    """Displacement of the oscillator q'' + tau w^2 q' + w^2 q = 0 from q = 0, q' = 1."""
    s = np.roots([1.0, tau * omega**2, omega**2]).astype(complex)
    return np.real((np.exp(np.outer(time, s[0])) - np.exp(np.outer(time, s[1])))[:, 0] / (s[0] - s[1]))


def follows(model, settings, omega, tau, place, motion, rtol):
    """Compare the motion of a place, started as one mode with a velocity of that amplitude, with the closed form."""
    given, amplitude = settings
    duration = 3 * 2 * np.pi / omega
    run = model.simulate(
        duration,
        formulation="intrinsic",
        initial="reference",
        output_interval=duration / 60,
        errors=False,
        **given,
    )
    value = motion(run, place) / amplitude
    expected = decaying(run.time, omega, tau)
    assert value == pytest.approx(expected, abs=rtol * np.abs(expected).max())


def displacement(axis):
    return lambda run, place: run.history(place, "displacement").values[:, axis]


@pytest.mark.parametrize("settings", LINEAR)
def test_axial_bar(settings):
    """C6 and AWP (36a), (39a): (2k - 1) pi/2 c/L with zeta = tau omega/2, started as the first mode."""
    model = cantilever(stiff(1.0, 1.0, 1.0, 1.0, damping=0.1), elements=2, order=6)
    model.velocity("beam", field=lambda s: ((settings[1] * np.sin(0.5 * np.pi * s), 0, 0), (0, 0, 0)))
    follows(model, settings, 0.5 * np.pi, 0.1, "beam.end", displacement(0), 1e-5)


@pytest.mark.parametrize("settings", LINEAR)
def test_torsional_bar(settings):
    """C6: likewise, with tau_S; rho J = 2e-3, GJ = 1."""
    model = cantilever(
        stiff(1e3, 1e3, 1.0, 1.0, rotary=(1e-3, 1e-3, 2e-3), damping=0.01), elements=2, order=6
    )
    model.velocity("beam", field=lambda s: ((0, 0, 0), (settings[1] * np.sin(0.5 * np.pi * s), 0, 0)))
    omega = 0.5 * np.pi * np.sqrt(1.0 / 2e-3)
    follows(model, settings, omega, 0.01, "beam.end", turn, 1e-5)


def turn(run, place):
    """Rotation about x from the reference orientation [rad]."""
    assert place == "beam.end"
    q = run.data["rotation"].values[:, -1]
    w, x, y, z = q[0]
    return 2.0 * np.arcsin(-x * q[:, 0] + w * q[:, 1] - z * q[:, 2] + y * q[:, 3])


@pytest.mark.parametrize("settings", LINEAR)
@pytest.mark.parametrize(
    ("shear", "rotary"), [(30.0, 2e-2), (1e6, 1e-8)], ids=["Timoshenko", "Euler-Bernoulli"]
)
def test_simply_supported_beam(settings, shear, rotary):
    """AWP (36b), (39): first mode w = sin(pi x), phi = a cos(pi x), zeta = tau omega/2 for equal times in both forces.

    omega^2 from the quadratic of the Timoshenko beam; Euler-Bernoulli is its limit pi^4 (to 1e-5 here).
    """
    k, tau = np.pi, 0.02
    # stiffness and mass of (w, phi): E = GA (k w - phi)^2/2 + EI k^2 phi^2/2
    K = np.array([[shear * k * k, -shear * k], [-shear * k, shear + k * k]])
    M = np.diag([1.0, rotary])
    squares, vectors = np.linalg.eig(np.linalg.solve(K, M))
    first = int(np.argmax(squares))
    omega, shape = float(squares[first] ** -0.5), vectors[:, first] / vectors[0, first]
    if shear > 1e3:
        assert omega == pytest.approx(np.pi**2, rel=1e-5)
    section = stiff(shear, 1e4, 1.0, 1.0, rotary=(rotary, rotary, 2 * rotary), damping=tau)
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=7))
    model.support("beam.start", ("ux", "uy", "uz", "rx", "ry"))
    model.support("beam.end", ("uy", "uz", "rx", "ry"))

    def field(s):
        return (0, settings[1] * np.sin(k * s), 0), (0, 0, settings[1] * shape[1] * np.cos(k * s))

    model.velocity("beam", field=field)
    follows(model, settings, omega, tau, "beam@0.5", displacement(1), 1e-5)


def test_start_from_a_strain_field():
    """Closed form: a uniform curvature and twist make a helix; both formulations then move alike.

    The helix of U = (k, 0, t): radius k/(k^2 + t^2), pitch angle t/k.
    """
    k, t = 3.0, 2.0
    section = stiff(200.0, 400.0, 1.0, 0.8, rotary=(1e-3, 2e-3, 3e-3), damping=0.02)
    runs = []
    for formulation in ("geometric", "intrinsic"):
        model = cantilever(section, elements=3, order=6)
        model.strain("beam", [0, 0, 0, k, 0, t])
        runs.append(
            model.simulate(
                0.5,
                initial="reference",
                formulation=formulation,
                tolerance=1e-8,
                output_interval=0.01,
                errors=False,
            )
        )
    n2 = k * k + t * t
    end = runs[1].data["position"].values[0, -1]
    n = np.sqrt(n2)
    advance = t / n
    radius = k / n2
    assert np.linalg.norm(end) == pytest.approx(np.hypot(advance, 2 * radius * abs(np.sin(n / 2))), rel=1e-9)
    assert end[0] == pytest.approx(t * t / n2 + k * k / n2 * np.sin(n) / n, rel=1e-9)
    a, b = (run.data["position"].values for run in runs)
    assert np.abs(a - b).max() < 2e-6
    assert float(runs[1].data["elastic"][0]) == pytest.approx(0.5 * (k * k + 0.8 * t * t), rel=1e-12)
    assert float(runs[0].data["elastic"][0]) == pytest.approx(0.5 * (k * k + 0.8 * t * t), rel=1e-6)


@pytest.mark.parametrize("following", [False, True], ids=["dead", "following"])
def test_linear_dynamics_about_a_bent_and_stressed_rod(following):
    """Limit: small motions of the nonlinear model about the equilibrium of a coupled arc under a large tip load.

    What the two differ by is quadratic in the small load. The energy account closes in both, with a load that follows
    too, whose stiffness is not symmetric.
    """
    gaps = []
    for small in (2e-2, 1e-2):
        model, length, _ = shaken(2, 7)
        model.supports.clear()
        model.loads.clear()
        model.clamp("rod.start")
        model.force("rod.end", (0.8, 1.2, 1.0), following=following)
        model.force("rod.end", (0.5 * small, 0.0, small), time=vr.Sine(0.4))
        given = {
            "formulation": "intrinsic",
            "damping": "linearised",
            "output_interval": 0.05,
            "errors": False,
        }
        runs = [
            model.simulate(2.0, tolerance=1e-8, **given),
            model.simulate(2.0, tolerance=1e-8, dynamics="linear", **given),
        ]
        moved = [run.data["position"].values - run.data["position"].values[0] for run in runs]
        size = np.abs(moved[0]).max()
        gaps.append(np.abs(moved[0] - moved[1]).max() / length)
        assert size > 1e-4 * length
        assert gaps[-1] < 0.05 * size
        assert runs[1].energy.numerical_fraction < 1e-6
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.1)


def test_initial_strains_are_refused_where_they_cannot_be():
    """Messages name the place that holds the rod, and the setting to change."""
    model = cantilever(stiff(1e3, 1e3, 1.0, 1.0), elements=2, order=3)
    model.strain("beam", [0, 0, 0, 1, 0, 0])
    with pytest.raises(vr.InputError, match="initial = 'reference' to start"):
        model.simulate(1.0)
    model.pin("beam.end")
    with pytest.raises(vr.InputError, match=r"supports\[1\] holds beam.end"):
        model.simulate(1.0, initial="reference")

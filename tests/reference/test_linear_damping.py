"""Small damped vibrations against closed forms (cases C1, C2, C4, C6, C8, C9 and our own for unequal times)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import cantilever, methods, slope, stiff

# omega_n L^2 sqrt(rho A/EI) of the clamped-free Euler-Bernoulli beam: roots of 1 + cos cosh = 0, squared
EULER_BERNOULLI = np.array([3.5160153, 22.0344916, 61.6972144])
# Timoshenko cantilever, r/L = 1/20, exact frequencies (EI = rho A = L = 1, GA = 0.9 EA/2.6)
TIMOSHENKO = np.array([3.49635532, 21.21744277, 56.69347328, 104.63352456])


def planar(model):
    """Hold everything but motion in the x-y plane, so that modes come one by one."""
    for rod, mesh in model.rods.items():
        for k in range(1, mesh.elements + 1):
            model.support(f"{rod}@{mesh.length * k / mesh.elements!r}", ("uz", "rx", "ry"))
    return model


@pytest.mark.parametrize("tau", [0.001, 0.01, 0.1])
@pytest.mark.parametrize(("elements", "order"), [(3, 1), (2, 4)])
def test_equal_times_make_every_mode_a_damped_oscillator(tau, elements, order):
    """C4: s^2 + tau w^2 s + w^2 = 0 on any mesh, w being the undamped frequencies of the same mesh; to round-off."""
    section = stiff(300.0, 900.0, 1.0, 0.7, damping=tau)
    elastic = stiff(300.0, 900.0, 1.0, 0.7)
    w = np.abs(cantilever(elastic, elements=elements, order=order).modes(8).eigenvalues)
    s = cantilever(section, elements=elements, order=order).modes(200).eigenvalues
    for omega in w[:6]:
        if tau * omega < 2:
            roots = [complex(-tau * omega**2 / 2, omega * np.sqrt(1 - (tau * omega / 2) ** 2))]
        else:
            roots = [complex(np.roots([1, tau * omega**2, omega**2]).max(), 0)]
        for root in roots:
            assert np.abs(s - root).min() < 1e-9 * abs(root)


@pytest.mark.parametrize("tau", [0.001, 0.01])
def test_euler_bernoulli_values(tau):
    """C4 with C1: the tabulated roots of the Euler-Bernoulli cantilever, shear and rotary inertia made negligible."""
    table = {
        0.001: [-0.00618118 + 3.51600984j, -0.24275941 + 22.03315425j, -1.90327313 + 61.66785076j],
        0.01: [-0.06181182 + 3.51547190j, -2.42759409 + 21.90035629j, -19.03273133 + 58.68817091j],
    }[tau]
    section = stiff(1e8, 1e8, 1.0, 1e4, rotary=(1e-9, 1e-9, 2e-9), damping=tau)
    s = cantilever(section, elements=5, order=6).modes(40).eigenvalues
    for root in table:
        assert np.abs(s - root).min() < 3e-6 * abs(root)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_euler_bernoulli_frequencies_converge(order):
    """C1: frequencies converge at order p + 1 at least (they converge faster, at 2 p)."""
    counts = {1: (8, 16, 32), 2: (4, 8, 16), 3: (1, 2, 4)}[order]
    errors = []
    for n in counts:
        section = stiff(1e8, 1e8, 1.0, 1e4, rotary=(1e-9, 1e-9, 2e-9))
        found = 2 * np.pi * cantilever(section, elements=n, order=order).modes(2).frequencies
        errors.append(abs(found[0] - EULER_BERNOULLI[0]))
    assert slope([1 / n for n in counts], errors) > order + 1 - 0.3


@pytest.mark.parametrize("order", [2, 5])
def test_timoshenko_frequencies(order):
    """C2 at r/L = 1/20: exact Timoshenko frequencies, all four digits-complete."""
    inertia = 1 / 1600
    ea, ga = 1 / inertia, 0.9 / inertia / 2.6
    section = vr.StiffnessSection([ga, ga, ea, 1.0, 1.0, 1e3], [1, 1, 1, inertia, inertia, 2 * inertia])
    elements = {2: 40, 5: 6}[order]
    found = 2 * np.pi * cantilever(section, elements=elements, order=order).modes(8).frequencies[::2]
    assert found[:3] == pytest.approx(TIMOSHENKO[:3], rel={2: 2e-5, 5: 2e-8}[order])


def test_axial_and_torsional_bars():
    """C6: c = L = 1, tau = 0.1: roots of s^2 + tau w^2 s + w^2 with w = (2k-1) pi/2."""
    table = [-0.12337006 + 1.5659441j, -1.1103305 + 4.57971354j, -3.08425138 + 7.2230479j]
    axial = vr.StiffnessSection(
        [1e4, 1e4, 1.0, 1e4, 1e4, 1e4], [1, 1, 1, 1e-4, 1e-4, 1e-4], [0, 0, 0.1, 0, 0, 0]
    )
    torsion = vr.StiffnessSection([1e4, 1e4, 1e4, 1e4, 1e4, 1.0], [1, 1, 1, 1, 1, 1], [0, 0, 0, 0, 0, 0.1])
    for section in (axial, torsion):
        s = cantilever(section, elements=3, order=6).modes(60).eigenvalues
        for root in table:
            assert np.abs(s - root).min() < 1e-6 * abs(root)


def test_axial_frequencies_converge():
    """C6: order 1 elements, error of the damped root of the first axial mode falls at order 2."""
    errors = []
    counts = (4, 8, 16)
    for n in counts:
        section = vr.StiffnessSection(
            [1e4, 1e4, 1.0, 1e4, 1e4, 1e4], [1, 1, 1, 1e-4, 1e-4, 1e-4], [0, 0, 0.1, 0, 0, 0]
        )
        s = cantilever(section, elements=n, order=1).modes(20).eigenvalues
        errors.append(np.abs(s - (-0.12337006 + 1.5659441j)).min())
    assert slope([1 / n for n in counts], errors) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_unequal_times_of_a_slender_rod(nu):
    """Own derivation: in a slender rod each family of modes has one modulus.

    So zeta = tau w/2, with tau_S for torsion and, for stretch and bending,
    tau_E = [(1-2nu) tau_B + 2(1+nu) tau_S]/3 (LLT 4).

    Bending couples to shear: the Timoshenko correction of zeta is of order (w r/c)^2 = 1e-4 here.
    """
    tau_s, tau_b = 0.002, 0.009
    material = vr.Material(
        1e7, poissons_ratio=nu, density=1000.0, damping=vr.KelvinVoigt(shear_time=tau_s, bulk_time=tau_b)
    )
    tau_e = ((1 - 2 * nu) * tau_b + 2 * (1 + nu) * tau_s) / 3
    length, radius = 1.0, 0.01
    modes = cantilever(vr.Circle(radius), length, elements=4, order=6, material=material).modes(40)
    G = 1e7 / (2 * (1 + nu))

    def ratio_at(frequency):
        k = np.argmin(np.abs(modes.frequencies - frequency))
        assert modes.frequencies[k] == pytest.approx(frequency, rel=1e-3)
        return modes.damping_ratios[k]

    bending = EULER_BERNOULLI[0] / length**2 * np.sqrt(1e7 * radius**2 / 4 / 1000.0)
    assert ratio_at(bending / 2 / np.pi) == pytest.approx(tau_e * bending / 2, rel=2e-3)
    torsion = np.pi / 2 * np.sqrt(G / 1000.0) / length
    assert ratio_at(torsion / 2 / np.pi) == pytest.approx(tau_s * torsion / 2, rel=1e-6)
    axial = np.pi / 2 * np.sqrt(1e7 / 1000.0) / length
    assert ratio_at(axial / 2 / np.pi) == pytest.approx(tau_e * axial / 2, rel=1e-6)


@methods(
    1e-6,
    0.005,
    spectral_radius=0.5,
    without={"midpoint": "it does not damp what the sudden moment starts in a rod of negligible inertia"},
)
def test_creep_under_a_step_moment(method):
    """C7: with negligible inertia the curvature creeps as (M/EI)(1 - exp(-t/tau)), in a finite rotation as well."""
    tau, moment = 0.5, 1.0
    section = stiff(1e4, 1e4, 1.0, 1.0, mass=1e-7, rotary=(1e-9, 1e-9, 2e-9), damping=tau)
    model = cantilever(section, elements=2, order=4)
    model.moment("beam.end", (0, 0, moment))
    run = model.simulate(2.0, initial="reference", **method)
    curvature = np.abs(run.data["strain"].sel(component=["bend_1", "bend_2"]).values).max(axis=2)
    exact = moment * (1 - np.exp(-run.time / tau))
    assert np.abs(curvature - exact[:, None]).max() < 1e-4


@pytest.mark.parametrize("slenderness", [1e2, 1e3, 1e4])
@pytest.mark.parametrize("length", [1e-5, 1.0, 1e3])
def test_frequencies_at_any_slenderness_and_scale(length, slenderness):
    """C1 for wires of 10 micrometres, 1 m and 1 km: stiff directions and units do not cost the slow modes' digits."""
    width = length / slenderness
    material = vr.Material(2e11, poissons_ratio=0.3, density=7800.0)
    model = cantilever(vr.Circle(width / 2), length, elements=3, order=6, material=material)
    found = 2 * np.pi * model.modes(4).frequencies * length**2 / np.sqrt(2e11 / 7800.0 * width**2 / 16)
    # shear and rotary inertia lower the first two by 0.6 and 4 over the square of the slenderness
    assert found[::2] == pytest.approx(EULER_BERNOULLI[:2], rel=5 / slenderness**2 + 4e-6)

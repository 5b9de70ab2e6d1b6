"""Large motions against published or independently converged numbers (cases D1, D3, D4, C10)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import methods, stiff

# t: tip displacement along and across, rotation, in the rotating (shadow) frame; converged independently to 2e-6
SPIN_UP = {
    1: (-0.000024, -0.020543, -0.002793),
    2: (-0.000606, -0.102381, -0.013959),
    3: (-0.002728, -0.217267, -0.029624),
    4: (-0.006766, -0.342279, -0.046636),
    5: (-0.012655, -0.468476, -0.063716),
    6: (-0.016971, -0.543596, -0.073600),
    7: (-0.018618, -0.571312, -0.076781),
    8: (-0.016630, -0.542841, -0.072235),
    9: (-0.011745, -0.460271, -0.060559),
    10: (-0.007073, -0.362814, -0.047237),
    11: (-0.003299, -0.257350, -0.033222),
    12: (-0.000803, -0.150900, -0.019360),
    13: (0.000233, -0.069215, -0.008848),
    15: (0.000514, 0.001303, 0.000167),
}


@methods(1e-6, 0.005, spectral_radius=0.8)
def test_spin_up_manoeuvre(method):
    """D1 (Simo and Vu-Quoc 1986): every tabulated value within 1e-4; steady stretch of C9 within the ripple."""
    model = vr.Model()
    section = vr.StiffnessSection([1e7, 1e7, 2.8e7, 1.4e4, 1.4e4, 1e4], [1.2, 1.2, 1.2, 6e-4, 6e-4, 1.2e-3])
    model.add("arm", vr.Rod.straight((0, 0, 0), (10, 0, 0), section=section, elements=2, order=5))
    model.clamp("arm.start", motion={"rz": vr.SpinUp(6.0, 15.0)})
    run = model.simulate(20.0, output_interval=0.01, **method)
    turned = vr.SpinUp(6.0, 15.0)
    tip = run.history("arm.end").values
    angle = np.array([turned.value(t) for t in run.time])
    c, s = np.cos(angle), np.sin(angle)
    along = c * tip[:, 0] + s * tip[:, 1] - 10.0
    across = -s * tip[:, 0] + c * tip[:, 1]
    q = run.data["rotation"].values[:, -1]
    q0 = run.data["reference_rotation"].values[-1]
    # planar: the rotation about z from the reference, relative to the root's
    relative = 2 * np.arctan2(_z_part(q, q0), _scalar(q, q0)) - angle
    alpha = (relative + np.pi) % (2 * np.pi) - np.pi
    for t, expected in SPIN_UP.items():
        k = int(np.argmin(np.abs(run.time - t)))
        assert run.time[k] == pytest.approx(t, abs=1e-9)
        assert (along[k], across[k], alpha[k]) == pytest.approx(expected, abs=1e-4)
    # nothing damps what rounding starts out of the plane in the midpoint rule
    assert np.abs(tip[:, 2]).max() < (1e-4 if method["integrator"] == "midpoint" else 1e-10)
    a = np.sqrt(1.2 * 36 / 2.8e7)
    steady = along[run.time > 15].mean()
    assert steady == pytest.approx(np.tan(10 * a) / a - 10, abs=2e-6)
    assert run.energy.numerical_fraction < 0.01


def _scalar(q, q0):
    return q @ q0


def _z_part(q, q0):
    """z component of q conj(q0)."""
    w, x, y, z = q.T
    return -w * q0[3] - x * q0[2] + y * q0[1] + z * q0[0]


def flying_rod(elements, order, duration, **method):
    """D3: a free rod, force and couple at one end, triangular in time until t = 5."""
    model = vr.Model()
    section = vr.StiffnessSection([1e4, 1e4, 1e4, 500, 500, 500], [1, 1, 1, 10, 10, 20])
    model.add("rod", vr.Rod.straight((0, 0, 0), (6, 0, -8), section=section, elements=elements, order=order))
    triangle = vr.TimeTable([0, 2.5, 5], [0, 1, 0])
    model.force("rod.end", (20, 0, 0), time=triangle, until=5.0)
    model.moment("rod.end", (0, 200, 100), time=triangle, until=5.0)
    return model.simulate(duration, initial="reference", output_interval=0.05, **method)


# t: displacement of the near and of the loaded end, kinetic and elastic energy (independent, 160 cells of second order)
FLYING = {
    1: ((0.119, -0.016, -0.025), (-0.419, 0.185, -0.284), 9.78, 16.26),
    2: ((1.647, -0.282, 0.093), (-1.932, 0.224, -0.496), 59.69, 99.74),
    3: ((7.806, -0.166, 0.559), (-1.975, -1.654, 0.804), 264.7, 168.7),
    4: ((12.493, 4.617, -3.596), (2.516, -4.506, 3.573), 544.1, 68.8),
    5: ((12.953, 3.029, -1.191), (13.214, -2.128, 1.626), 692.6, 31.8),
    6: ((22.490, 1.401, 0.260), (11.760, -0.413, -0.092), 694.7, 29.7),
}


# relative drift of the momenta of free flight: round-off, the tolerance, or the second order of the step
# (or the mesh: the intrinsic formulation tests with body frames, see test_intrinsic for its convergence)
MOMENTUM = {"intrinsic": 4e-6, "radau": 1.3e-6, "generalized_alpha": 1e-10, "midpoint": 6e-4}


@methods(1e-7, 0.005, midpoint=0.0025, spectral_radius=1.0)
def test_flying_rod_trajectory_energy_and_momentum(method):
    """D3: displacements as tabulated; momentum after release constant; energy of the converged motion.

    The table's 724.41 J is that of 160 cells of second order; its sequence 724.09, 724.35, 724.41 tends to 724.43 J.
    """
    run = flying_rod(4, 6, 8.0, **method)
    start, end = (run.history(f"rod.{p}", "displacement").values for p in ("start", "end"))
    data = run.data
    for t, (near, far, kinetic, elastic) in FLYING.items():
        k = int(np.argmin(np.abs(run.time - t)))
        assert start[k] == pytest.approx(near, abs=2.5e-3)
        assert end[k] == pytest.approx(far, abs=2.5e-3)
        assert float(data["kinetic"][k]) == pytest.approx(kinetic, abs=0.06)
        assert float(data["elastic"][k]) == pytest.approx(elastic, abs=0.11)
    free = run.time > 5.0 + 1e-9
    bound = MOMENTUM[method.get("formulation", method["integrator"])]
    for name in ("linear_momentum", "angular_momentum"):
        momentum = data[name].values[free]
        assert np.abs(momentum - momentum[0]).max() < bound * np.linalg.norm(momentum[0])
    total = (data["kinetic"] + data["elastic"]).values
    assert np.abs(total[free] - 724.435).max() < (0.015 if method["integrator"] == "midpoint" else 0.01)
    assert float(data["external"][-1]) == pytest.approx(total[-1], abs=0.01)
    # impulse of the loads: triangle of area 2.5 s
    assert data["linear_momentum"].values[-1] == pytest.approx([50.0, 0, 0], abs=50 * bound)


@methods(
    1e-5,
    0.005,
    midpoint=0.0025,
    spectral_radius=1.0,
    without={"intrinsic": "the table's mesh error is that of the geometric element of order 1"},
)
def test_flying_rod_energy_at_the_resolution_of_the_table(method):
    """D3: 160 elements of order 1, the resolution of the tabulated 724.41 J."""
    run = flying_rod(160, 1, 5.2, **method)
    total = (run.data["kinetic"] + run.data["elastic"]).values[run.time > 5.0 + 1e-9]
    assert np.abs(total - 724.41).max() < 0.01


@methods(1e-6, 0.005, spectral_radius=1.0)
def test_right_angle_cantilever_energy(method):
    """D4 (Simo and Vu-Quoc 1988): total energy after the load is gone, 114.88 J converged independently.

    The shape of the inertia is the source's (20, 10, 10), the first about the rod's axis.
    """
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 1e3], [1, 1, 1, 10, 10, 20])
    given = {"section": section, "elements": 3, "order": 5}
    model.add("leg1", vr.Rod.straight((0, 0, 0), (10, 0, 0), **given))
    model.add("leg2", vr.Rod.straight((10, 0, 0), (10, 10, 0), **given))
    model.attach("leg1.end", "leg2.start")
    model.clamp("leg1.start")
    model.force("leg1.end", (0, 0, 50), time=vr.TimeTable([0, 1, 2], [0, 1, 0]), until=2.0)
    run = model.simulate(6.0, initial="reference", **method)
    total = (run.data["kinetic"] + run.data["elastic"]).values[run.time > 2.0 + 1e-9]
    assert total == pytest.approx(114.88, abs=5e-3)


@pytest.mark.parametrize(
    ("alpha", "zeta", "peak"),
    [(0.25, 0.0, 1.2576), (0.25, 0.05, 1.2009), (0.5, 0.1, 1.5033), (1.0, 0.05, 1.4307)],
)
@methods(1e-6, 1 / 400)
def test_moving_force_on_a_simply_supported_beam(alpha, zeta, peak, method):
    """C10: largest mid-span deflection over F L^3/48EI; modal sum of 20 modes of the Euler-Bernoulli beam."""
    tau = 2 * zeta / np.pi**2
    model = vr.Model()
    section = stiff(1e6, 1e6, 1.0, 1.0, rotary=(1e-7, 1e-7, 2e-7), damping=tau or None)
    model.add("bridge", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=8, order=4))
    model.support("bridge.start", ("ux", "uy", "uz", "rx"))
    model.support("bridge.end", ("uy", "uz"))
    force, speed = 1e-4, alpha * np.pi
    model.moving_force("bridge", (0, 0, -force), speed=speed)
    if "time_step" in method:
        method = method | {"time_step": method["time_step"] / speed}  # part of the passage
    run = model.simulate(1.0 / speed, initial="reference", output_interval=1 / speed / 400, **method)
    deflection = -run.history("bridge@0.5", "displacement").values[:, 2] / (force / 48)
    assert deflection.max() == pytest.approx(peak, rel=2e-3)

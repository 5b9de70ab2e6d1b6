"""Models of rigid bodies without any rod, against closed forms and ordinary differential equations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.special import ellipk

import viscorod as vr
from viscorod.results.result_warnings import energy_doubt


def block() -> vr.Model:
    """A body of 2 kg on springs and dampers along three directions, and on springs about three."""
    model = vr.Model()
    model.add("block", vr.Body(2.0, (0.01, 0.02, 0.03), points={"tip": (0.1, 0, 0)}))
    stiffness = {"ux": 800.0, "uy": 1000.0, "uz": 1200.0, "rx": 5.0, "ry": 6.0, "rz": 7.5}
    model.spring("block", stiffness=stiffness, damping={"ux": 4.0, "uy": 4.0, "uz": 4.0})
    return model


def test_a_block_on_springs_is_one_oscillator_for_each_motion(tmp_path: Path) -> None:
    """The band holds resonances of turns that nothing damps, exactly: responses are sought beside them.

    ``f = sqrt(k/m)/2 pi``, ``zeta = c/(2 sqrt(k m))``, and the resonance ``1/(2 zeta k sqrt(1 - zeta^2))``."""
    model = block()
    stiffness, mass = (
        np.array([800.0, 1000.0, 1200.0, 5.0, 6.0, 7.5]),
        np.array([2.0, 2.0, 2.0, 0.01, 0.02, 0.03]),
    )
    modes = model.modes(6)
    omega = np.sqrt(stiffness / mass)
    order = np.argsort(omega)
    assert modes.frequencies == pytest.approx(omega[order] / (2.0 * np.pi), rel=1e-9)
    ratios = np.array([4.0, 4.0, 4.0, 0, 0, 0]) / (2.0 * mass * omega)
    assert modes.damping_ratios == pytest.approx(ratios[order], abs=1e-9)
    assert not modes.warnings
    response = model.frequency_response(inputs="block fx", outputs="block ux", band=(2.0, 5.0))
    expected = 1.0 / (2.0 * ratios[0] * 800.0 * np.sqrt(1.0 - ratios[0] ** 2))
    assert response.summit().amplitude == pytest.approx(expected, rel=1e-4)

    model.force("block", (8.0, 0, 0), until=0.0)
    run = model.simulate(1.0)
    damped = omega[0] * np.sqrt(1.0 - ratios[0] ** 2)
    decay = np.exp(-ratios[0] * omega[0] * run.time)
    swing = np.cos(damped * run.time) + ratios[0] * omega[0] / damped * np.sin(damped * run.time)
    error = np.abs(run.history("block").values[:, 0] - 0.01 * decay * swing).max()
    assert error < min(1e-5, 1.5 * run.step_errors["position"])
    again = vr.load(run.save(tmp_path / "block.nc"))
    assert again.history("block.tip").values == pytest.approx(run.history("block.tip").values)
    assert "No warnings" in again.report()
    vr.view(again, tmp_path / "block.html")
    assert model.check().validity.conditions == ()


def test_a_top_that_precesses_steadily_is_not_told_that_its_energy_is_lost() -> None:
    """It exchanges no energy at all, so that what moved is what its steps lose: beside that the loss was 97 %.

    Steady precession at the rate W, tilted by a, with the spin w about its axis and moments of inertia I, J about its
    pivot: ``J cos(a) W^2 - I w W + m g l = 0``.
    """
    mass, arm, tilt, spin, own, across = 1.0, 0.1, 0.5, 100.0, 1e-2, 6e-3
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    sideways, around = (np.cos(tilt), 0.0, -np.sin(tilt)), (0.0, 1.0, 0.0)
    model = vr.Model()
    arms = {"centre": tuple(arm * axis), "points": {"foot": (0, 0, 0)}}
    top = vr.Body(mass, (across, across, own), axes=(sideways, around), **arms)
    model.add("top", top)
    model.ball("top.foot", "ground")
    model.gravity((0, 0, -9.81))
    about_foot = (across + mass * arm**2) * np.cos(tilt)
    rate = np.sort(np.roots([about_foot, -own * spin, mass * 9.81 * arm]).real)[0]
    model.velocity("top", angular=tuple((spin - rate * np.cos(tilt)) * axis + (0.0, 0.0, rate)))
    run = model.simulate(1.0, initial="reference")
    expected = arm * np.array([np.sin(tilt) * np.cos(rate), np.sin(tilt) * np.sin(rate), np.cos(tilt)])
    assert run.history("top").values[-1] == pytest.approx(expected, abs=3e-4 * arm)
    assert run.energy.numerical_fraction > 0.5
    assert not run.warnings
    assert "% of all that is there" in " ".join(str(run.energy).split())
    lossy = run.data.assign(
        numerical=run.data.numerical * (2e-4 * run.energy.total[0] / abs(run.energy.numerical).max())
    )
    assert "energy account reaches" in energy_doubt(lossy)


@pytest.mark.parametrize("angle", [0.1, 2.0])
def test_a_body_on_a_hinge_swings_as_a_physical_pendulum(angle: float) -> None:
    """Period ``4 K(sin(angle/2)) sqrt(J/(m g d))`` with J about the hinge, K of the first kind (elliptic integral)."""
    mass, inertia, d = 2.0, 0.02, 0.3
    centre = np.array([d * np.sin(angle), 0.0, -d * np.cos(angle)])
    model = vr.Model()
    model.add("bob", vr.Body(mass, (0.01, inertia, 0.03), centre=tuple(centre), points={"pivot": (0, 0, 0)}))
    model.revolute("bob.pivot", "ground", axis=(0, 1, 0))
    model.gravity()
    slow = np.sqrt(mass * 9.81 * d / (inertia + mass * d**2)) / (2.0 * np.pi)
    period = 2.0 * ellipk(np.sin(0.5 * angle) ** 2) / np.pi / slow
    run = model.simulate(period, initial="reference")
    x, _, z = run.history("bob").values[-1]
    assert np.arctan2(x, -z) == pytest.approx(angle, abs=1e-3 * angle)
    half = run.history("bob", times=[0.5 * period]).values[0]
    assert half[0] == pytest.approx(-centre[0], abs=1e-3 * d * angle)
    assert model.modes(1).frequencies[0] == pytest.approx(slow, rel=1e-9)
    assert model.equilibrium().position("bob") == pytest.approx([0, 0, -d], abs=1e-12)


def test_two_bars_hang_as_a_double_pendulum() -> None:
    """Uniform bars of length 1 and mass 1: ``M = [[4/3, 1/2], [1/2, 1/3]]``, ``K = g [3/2, 1/2]``."""
    model = vr.Model()
    for name, top in (("upper", 0.0), ("lower", -1.0)):
        points = {"top": (0, 0, top), "foot": (0, 0, top - 1.0)}
        model.add(name, vr.Body(1.0, (1 / 12, 1 / 12, 1e-6), centre=(0, 0, top - 0.5), points=points))
    model.revolute("upper.top", "ground", axis=(0, 1, 0))
    model.revolute("lower.top", "upper.foot", axis=(0, 1, 0))
    model.gravity()
    squares = eigh(9.81 * np.diag([1.5, 0.5]), [[4 / 3, 1 / 2], [1 / 2, 1 / 3]], eigvals_only=True)
    assert model.modes(2).frequencies == pytest.approx(np.sqrt(squares) / (2.0 * np.pi), rel=1e-9)


def test_a_rigid_rotor_in_two_bearings_whirls() -> None:
    """``m z'' + K z = 0``, ``J_d p'' - i J_p W p' + ... = 0``: complex displacement and tilt, seen from outside."""
    m, J, Jp, a, b, left, right, speed = 4.0, 0.05, 0.02, 0.15, 0.25, 2e4, 3e4, 500.0
    model = vr.Model()
    model.add("rotor", vr.Body(m, (Jp, J, J), points={"left": (-a, 0, 0), "right": (b, 0, 0)}))
    for end, k in (("left", left), ("right", right)):
        model.spring(f"rotor.{end}", stiffness={"uy": k, "uz": k})
    model.support("rotor", ("ux", "rx"))
    found = model.campbell(axis=(1, 0, 0), speeds=[0.0, speed], modes=4, frame="space")
    coupled = right * b - left * a
    K = np.array([[left + right, coupled], [coupled, left * a**2 + right * b**2]])
    M, G = np.diag([m, J]), np.diag([0.0, Jp * speed])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), 1j * np.linalg.solve(M, G)]])
    expected = np.sort(np.abs(np.linalg.eigvals(A).imag)) / (2.0 * np.pi)
    assert np.sort(np.abs(found.frequencies[-1])) == pytest.approx(expected, rel=1e-7)
    assert not found.warnings


def test_a_free_body_tumbles_as_euler_says() -> None:
    """About the axis between: Euler's equations, ``I w' = I w x w`` in body axes; energy and momentum stay."""
    inertia = np.array([0.01, 0.02, 0.03])
    model = vr.Model()
    model.add("top", vr.Body(2.0, tuple(inertia)))
    model.velocity("top", angular=(2.0, 10.0, 0.0))
    run = model.simulate(1.5, tolerance=1e-7)
    exact = solve_ivp(
        lambda _, w: np.cross(inertia * w, w) / inertia, (0, 1.5), [2, 10, 0], rtol=1e-10, atol=1e-10
    ).y[:, -1]
    spin = run.history("top", "angular_velocity").values[-1]
    assert np.linalg.norm(spin) == pytest.approx(np.linalg.norm(exact), rel=1e-4)
    assert np.linalg.norm(exact) > 1.01 * np.hypot(2.0, 10.0)  # it tumbles
    assert "it only turns" in run.report()


def test_a_case_file_may_have_bodies_only(tmp_path: Path) -> None:
    path = tmp_path / "ball.toml"
    path.write_text(
        '[bodies.ball]\nshape = "sphere"\nradius = 0.1\nmass = 2.0\n'
        '[[springs]]\nkind = "line"\nat = "ball"\nto = [0, 0, 1]\nstiffness = 800\nlength = 1\n'
        '[[loads]]\nkind = "gravity"\nacceleration = [0, 0, -10]\n[equilibrium]\n'
    )
    model = vr.load_case(path).model(vr.Model)
    assert model.equilibrium().displacement("ball") == pytest.approx([0, 0, -20.0 / 800.0], abs=1e-9)


def test_a_mass_on_a_spring_that_is_a_pendulum() -> None:
    """``f = sqrt(k/m)/2 pi`` along the spring and ``sqrt(g/L)/2 pi`` across, L with its elongation ``m g/k``.

    The line is as long as it is without force where the model is described: nothing holds the mass across it there.
    """
    mass, stiffness, length = 1.0, 100.0, 1.0
    model = vr.Model()
    model.add("bob", vr.Body(mass, (0, 0, 0), centre=(0, 0, -length)))
    model.support("bob", ("rx", "ry", "rz"))
    model.line_spring("bob", (0, 0, 0), stiffness=stiffness, length=length)
    model.gravity()
    across = np.sqrt(9.81 / (length + 9.81 * mass / stiffness))
    expected = np.array([across, across, np.sqrt(stiffness / mass)]) / (2.0 * np.pi)
    assert model.modes(3).frequencies == pytest.approx(expected, rel=1e-9)


def test_a_steady_top_starts_where_it_was_described():
    """Slow precession w of a heavy top: I1 cos(theta) w^2 - I3 spin w + m g l = 0 (Goldstein).

    By default it would hang from its point before it spins, which is told.
    """
    mass, arm, polar, across, spin, angle = 1.0, 0.1, 2e-3, 1.2e-2, 300.0, np.radians(60)
    axis = np.array([np.sin(angle), 0.0, np.cos(angle)])
    about_centre = across - mass * arm**2  # as large as about the axis: no direction of axes matters
    model = vr.Model()
    points = {"pin": (0, 0, 0), "tip": tuple(arm * axis)}
    body = vr.Body(mass, (about_centre, about_centre, polar), centre=tuple(arm * axis), points=points)
    model.add("top", body)
    model.ball("top.pin", "ground")
    model.gravity()
    a, b, c = across * np.cos(angle), -polar * spin, mass * 9.81 * arm
    slow = (-b - np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    turning = (spin - slow * np.cos(angle)) * axis + np.array([0.0, 0.0, slow])
    model.velocity("top", angular=tuple(turning))
    run = model.simulate(0.2, initial="reference", tolerance=1e-6)
    x, y, z = run.history("top.tip").values[-1]
    assert np.arctan2(y, x) == pytest.approx(0.2 * slow, rel=1e-4)
    assert z == pytest.approx(arm * np.cos(angle), rel=1e-4)
    assert not any("initial" in text for text in run.warnings)
    with pytest.warns(vr.AccuracyWarning, match="before the given velocities act, the model came to rest"):
        model.simulate(1e-3)

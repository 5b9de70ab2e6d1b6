"""Estimated errors of motions by their steps, beside closed forms and solutions with much smaller steps."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.results.result_warnings import warnings_of
from viscorod.solve.transient.integrators.generalized_alpha import GeneralizedAlpha
from viscorod.solve.transient.integrators.momentum_model import Coefficients
from viscorod.solve.transient.integrators.stability import order, seen_by_halving, stability
from viscorod.solve.transient.integrators.tableau import MIDPOINT, radau

PI = np.pi


def test_stability_functions():
    """Closed forms: Pade approximations of exp (Hairer and Wanner 1996, tables IV.3.1); orders 2 s - 1 and 2."""
    z = np.array([0.3j, -0.2 + 1.0j, 5.0j, -40.0])
    pade = (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)
    np.testing.assert_allclose(stability(radau(3), z), pade, rtol=1e-12)
    np.testing.assert_allclose(stability(MIDPOINT, z), (1 + z / 2) / (1 - z / 2), rtol=1e-12)
    assert [order(method) for method in (radau(3), radau(5), radau(7), MIDPOINT)] == [5, 9, 13, 2]
    assert seen_by_halving(MIDPOINT) == 0.75


def test_stability_of_generalised_alpha():
    """Closed forms: the spectral radius at infinity is what was asked for; without damping it is that of no loss."""
    for radius in (0.3, 0.6, 1.0):
        method = object.__new__(GeneralizedAlpha)
        method.coefficients = Coefficients.of(radius)
        np.testing.assert_allclose(np.abs(method.stability(np.array([1e9j]))), radius, rtol=1e-3)
        small = method.stability(np.array([1e-2j, 2e-2j])) - np.exp([1e-2j, 2e-2j])
        assert np.log2(abs(small[1] / small[0])) == pytest.approx(3.0, abs=0.05)


def twisted(angle=0.02):
    """One element of order 1, twisted and let go: a single vibration in its torsion."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 4.0], [1.0, 1.0, 1.0, 1e-2, 1e-2, 2e-2])
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section, elements=1, order=1))
    model.clamp("rod.start")
    model.moment("rod.end", (0, 0, 4.0 * angle), until=0.0)
    return model


def turns(run):
    """The angle of the end about the axis [rad]."""
    q = run.data["rotation"].values[:, -1]
    return 2.0 * np.arctan2(q[:, 3], q[:, 0])


@pytest.mark.parametrize(
    ("integrator", "stages"), [("midpoint", None), ("radau", 3), ("radau", 5), ("generalized_alpha", None)]
)
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_a_single_vibration(integrator, stages):
    """Closed form: after n steps the error is |R(i w h)^n - exp(i w n h)| of the amplitude."""
    omega = float(2.0 * PI * twisted().modes(1, about="reference").frequencies[0])
    h = {None: 0.1, 3: 0.8, 5: 3.5}[stages] / omega
    n, given = 200, {} if stages is None else {"tolerance": 0.1, "stages": stages}
    run = twisted().simulate(n * h, integrator=integrator, time_step=h, **given)
    kind = MIDPOINT if integrator == "midpoint" else radau(stages or 3)
    ends = run.time if run.step_ends is None else run.time[run.step_ends]
    angle = turns(run) if run.step_ends is None else turns(run)[run.step_ends]
    error = np.abs(angle - 0.02 * np.cos(omega * ends)).max()
    if integrator != "generalized_alpha":
        lost = np.abs(stability(kind, 1j * np.array([omega * h])) ** n - np.exp(1j * omega * n * h))[0]
        assert error == pytest.approx(0.02 * lost, rel=0.15)
    assert 1.0 / 3.0 < run.step_errors["rotation"] / error < 10.0


def soft(damping=None, **given):
    """A soft cantilever, bent far and let go."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=damping)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=material, elements=2, order=4
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model, {"duration": 1.0} | given


def swinging():
    return soft()


def fading():
    return soft(vr.KelvinVoigt(0.02, 0.02))


def relaxing():
    return soft(vr.Prony(shear_ratios=[0.1], shear_times=[0.05], constant="poissons_ratio"))


def intrinsic():
    return soft(vr.KelvinVoigt(0.02, 0.02), formulation="intrinsic")


def by_alpha():
    return soft(vr.KelvinVoigt(0.02, 0.02), integrator="generalized_alpha", time_step=4e-3)


def steel(**mesh):
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.01), material=material, elements=2, order=4
    )
    model.add("bar", rod)
    model.clamp("bar.start")
    return model


def forced():
    """A bar, at resonance: 16.4 Hz."""
    model = steel()
    model.force("bar.end", (0, 0, 1.0), time=vr.Sine(16.4))
    return model, {"duration": 0.25, "initial": "reference"}


def linear():
    model = steel()
    model.force("bar.end", (0, 1.0, 0), until=0.0)
    given = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}
    return model, {"duration": 0.05} | given


def whirling():
    """A heavy shaft that begins to turn about its axis."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=4
    )
    model.add("shaft", rod)
    model.clamp("shaft.start", motion={"rx": vr.SpinUp(30.0, 0.2)})
    model.force("shaft.end", (0, 0, -20.0))
    return model, {"duration": 0.5}


def tumbling():
    """A free rod that spins about its axis of least inertia and a little about another."""
    model = vr.Model()
    material = vr.Material(2e9, poissons_ratio=0.3, density=1000.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.01), material=material, elements=2, order=4
    )
    model.add("rod", rod)
    model.velocity("rod", linear=(0.2, 0, 0), angular=(20.0, 0.3, 2.0))
    return model, {"duration": 2.0, "initial": "reference"}


def pendulum():
    """A rod on a hinge, let go level."""
    model = vr.Model()
    material = vr.Material(2e9, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(1e-3, 1e-3))
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=3
    )
    model.add("rod", rod)
    model.revolute("rod.start", "ground", (0, 1, 0))
    model.gravity((0, 0, -9.81))
    return model, {"duration": 3.0, "initial": "reference"}


def double_pendulum():
    """Two stiff rods on hinges, let go level: joints let the second one move otherwise once it has turned."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    given = {"section": vr.Circle(0.05), "material": material, "elements": 1, "order": 2}
    model.add("one", vr.Rod.straight((0, 0, 0), (1, 0, 0), **given))
    model.add("two", vr.Rod.straight((1, 0, 0), (2, 0, 0), **given))
    model.revolute("one.start", "ground", (0, 1, 0))
    model.revolute("one.end", "two.start", (0, 1, 0))
    model.gravity((0, 0, -9.81))
    return model, {"duration": 2.0, "initial": "reference"}


MOTIONS = (
    swinging, fading, relaxing, intrinsic, by_alpha, forced, linear, whirling, tumbling, pendulum, double_pendulum,
)  # fmt: skip
SHORTER = {swinging: 0.5, relaxing: 0.5, linear: 0.006, double_pendulum: 1.2}
"""Seconds that show as much where small tolerances take very many steps."""


def apart(run, fine):
    """Return the largest errors of positions [m] and rotations [rad] of all stations at the ends of all steps."""
    ends = np.arange(len(run.time)) if run.step_ends is None else run.step_ends
    places = list(range(run.data.sizes["station"]))
    other = fine.probe(places, run.time[ends])
    moved = np.linalg.norm(run.data["position"].values[ends] - other["position"].values, axis=2).max()
    away = product(conjugate(other["rotation"].values), run.data["rotation"].values[ends])[..., 1:]
    turned = 2.0 * np.arcsin(np.linalg.norm(away, axis=2)).max()
    return moved, turned


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.__name__)
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of coarse steps
def test_estimates_beside_much_smaller_steps(motion):
    """Refinement: the same mesh with a thousandth of the tolerance, or an eighth of the step."""
    model, given = motion()
    given["duration"] = SHORTER.get(motion, given["duration"])
    run = model.simulate(**given)
    if "time_step" in given:
        finer = {"time_step": given["time_step"] / 8.0}
    else:
        finer = {"tolerance": max(1e-3 * run.data.attrs["tolerance"], 1e-10)}
    errors = apart(run, model.simulate(**(given | finer), errors=False))
    for kind, error in zip(("position", "rotation"), errors, strict=True):
        assert 1.0 / 3.0 < run.step_errors[kind] / error < 10.0, kind


def suddenly_loaded():
    """A bar under a load that is suddenly there, undamped: fast vibrations have a large part in its forces."""
    model = steel()
    model.distributed_force("bar", (0, 30.0, 40.0))
    return model, {"duration": 0.06, "initial": "reference"}


@pytest.mark.parametrize("motion", [swinging, fading, by_alpha, suddenly_loaded], ids=lambda m: m.__name__)
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of coarse steps
def test_estimates_of_section_forces_beside_much_smaller_steps(motion):
    """Refinement: as above, at fifty instants."""
    model, given = motion()
    given |= {"output_interval": given["duration"] / 50.0}
    run = model.simulate(**given)
    if "time_step" in given:
        finer = {"time_step": given["time_step"] / 8.0}
    else:
        finer = {"tolerance": 1e-3 * run.data.attrs["tolerance"]}
    fine = model.simulate(**(given | finer), errors=False)
    away = run.data["section_force"].values - fine.data["section_force"].values
    sizes = np.linalg.norm(away.reshape(-1, 2, 3), axis=2).max(axis=0)
    for kind, error in zip(("section_force", "section_moment"), sizes, strict=True):
        assert 1.0 / 3.0 < run.step_errors[kind] / error < 10.0, kind


def shear_stiff():
    """The fading swing as an Euler-Bernoulli rod by sections that are 1e5 times stiffer in shear than in stretch."""
    stiffness, _, inertia = vr.Rectangle(0.01, 0.01).matrices(
        vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    )
    damping = 0.02 * stiffness
    damping[:2, :2] = 0.0
    stiffness[[0, 1], [0, 1]] = 1e5 * stiffness[2, 2]
    section = vr.StiffnessSection(stiffness.tolist(), inertia.tolist(), damping.tolist())
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=1, order=5))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model, {"duration": 0.1, "output_interval": 0.01}


def test_stiff_sections_make_no_forces_of_errors_of_poses():
    """Refinement: a hundredth of the tolerance. Small motions from the start see 6e2 times the force there is."""
    model, given = shear_stiff()
    run = model.simulate(tolerance=1e-4, **given)
    fine = model.simulate(tolerance=1e-6, **given)
    force = fine.data["section_force"].values[..., :3]
    error = np.linalg.norm(run.data["section_force"].values[..., :3] - force, axis=-1).max()
    assert error / 3.0 < run.step_errors["section_force"] < 0.01 * np.abs(force).max()


@pytest.mark.parametrize("integrator", ["radau", "midpoint"])
def test_a_free_fall_has_no_section_forces_to_be_wrong(integrator):
    """Closed form: r = r0 + v t + g t^2/2; sections carry round-off, of which no part is told."""
    model = vr.Model()
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=material, elements=2, order=2
    )
    model.add("beam", rod)
    model.gravity((0, 0, -9.81))
    model.velocity("beam", (0, 0, -10.0))
    run = model.simulate(1.0, integrator=integrator, time_step=0.02, initial="reference")
    fallen = -10.0 * run.time - 9.81 / 2.0 * run.time**2
    np.testing.assert_allclose(run.history("beam.end", "displacement").values[:, 2], fallen, atol=1e-9)
    assert not any("section forces" in text for text in warnings_of(run))


def test_large_errors_of_section_forces_are_told():
    """The swing without damping, whose axial forces are off by a third of the largest (see the test before)."""
    model, given = swinging()
    with pytest.warns(vr.AccuracyWarning, match="the steps may leave section forces off by"):
        run = model.simulate(**given)
    told = [text for text in run.warnings if "steps may leave section forces" in text]
    assert len(told) == 1
    assert told[0] in flat(run.report())


def test_large_errors_are_told():
    """Closed form: the midpoint rule is (w h)^2/12 of the time late, after two periods of a bar by 10 % of a radian."""
    model = steel()
    model.force("bar.end", (0, 1.0, 0), until=0.0)
    with pytest.warns(vr.AccuracyWarning, match="use a smaller time_step than 0.003"):
        run = model.simulate(0.24, integrator="midpoint", time_step=3e-3)
    omega = 2.0 * PI * model.modes(1, about="reference").frequencies[0]
    late = run.data.attrs["step_motion_error"] / ((3e-3 * omega) ** 2 / 12.0 * omega * 0.24)
    assert 1.0 / 3.0 < late < 10.0
    told = [text for text in run.warnings if "of the motion" in text]
    assert len(told) == 1
    assert told[0] in flat(run.report())
    assert "Steps: estimated errors: positions by" in flat(run.report())


def test_small_errors_are_not_told():
    """The damped swing by default: estimates are in the report, and there is no warning."""
    model, given = fading()
    run = model.simulate(**given)
    assert set(run.step_errors) == {"position", "rotation", "section_force", "section_moment"}
    assert run.data.attrs["step_motion_error"] < 0.01
    assert not any("the steps" in text for text in warnings_of(run))
    assert not model.equilibrium().data.attrs.keys() & {"step_motion_error"}


def test_a_resumed_run_tells_the_same(tmp_path):
    """Trials of steps go on with the run, bit for bit."""
    model, given = fading()
    whole = model.simulate(**given)
    count = iter(range(1000))
    with pytest.raises(vr.SolveError):
        model.simulate(**given, folder=tmp_path / "run", stop=lambda: "" if next(count) < 6 else "enough")
    run = model.simulate(**given, folder=tmp_path / "run", resume=True)
    assert run.step_errors == whole.step_errors

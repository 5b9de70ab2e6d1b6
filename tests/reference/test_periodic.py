"""Periodic motions against frequency responses, poles, Mathieu's equation and long time integrations."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson, simpson, solve_ivp
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.optimize import brentq
from scipy.special import ellipk

import viscorod as vr
import viscorod.analyses.periodic as analysis
from helpers.pictures import written
from viscorod.analyses.case_run import as_model, run_case
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case
from viscorod.solve.linear_systems.measured_moduli import of_law_in_place
from viscorod.solve.periodic import floquet, orbit_matrix

LENGTH, WIDTH, HEIGHT = 0.4, 0.025, 0.003


def strip(time=5e-5, *, damping=None, **more):
    """Return a model with one strip of aluminium along x, the thin side across z, held nowhere."""
    model = vr.Model()
    damping = damping or vr.KelvinVoigt(shear_time=time, extensional_time=time)
    material = vr.Material(youngs_modulus=70e9, poissons_ratio=0.33, density=2700.0, damping=damping)
    given = {"elements": 2, "order": 3} | more
    section = vr.Rectangle(WIDTH, HEIGHT)
    model.add("beam", vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, material=material, **given))
    return model


def clamped(time=5e-5, **more):
    model = strip(time, **more)
    model.clamp("beam.start")
    model.clamp("beam.end")
    return model


def cantilever(**more):
    model = strip(**more)
    model.clamp("beam.start")
    return model


def pinned(time=5e-5, **more):
    model = strip(time, **more)
    model.support("beam.start", ("ux", "uy", "uz", "rx", "rz"))
    model.support("beam.end", ("uy", "uz", "rx"))
    return model


def hinged():
    """Return two strips with a hinge that has a spring and a damper, in gravity, with drag."""
    model = cantilever()
    model.add(
        "two",
        vr.Rod.straight(
            (LENGTH, 0, 0),
            (2 * LENGTH, 0.05, 0),
            section=vr.Rectangle(WIDTH, HEIGHT),
            material=model.rods["beam"].material,
            elements=1,
            order=3,
            constraints=("kirchhoff",),
        ),
    )
    model.revolute("beam.end", "two.start", (0, 1, 0), stiffness={"rz": 3.0}, damping={"rz": 0.002})
    model.gravity((0, 0, -9.81))
    model.drag("two", linear_across=0.3)
    return model


PRONY = vr.Prony(shear_ratios=[0.2, 0.1], shear_times=[1e-3, 1e-2], constant="poissons_ratio")
MIDDLE = ["beam@0.2 uz", "beam@0.1 strain bend_1", "beam@0.1 section_force bend_1", "beam.start reaction fz"]


@pytest.mark.parametrize(
    ("model", "source", "size", "outputs"),
    [
        (cantilever(), "base az", 1e-3, [*MIDDLE, "beam.end az", "beam.end ry"]),
        (pinned(damping=PRONY), "beam@0.2 fz", 1e-4, MIDDLE),
        (hinged(), "two.end fz", 1e-4, ["two.end uz", "beam.end vz", "two@0.2 section_force bend_1"]),
    ],
    ids=["shaken base", "Maxwell branches and partial supports", "hinge, held strains, gravity and drag"],
)
def test_small_motions_are_those_of_the_frequency_response(model, source, size, outputs):
    """The dynamic stiffness at one frequency, solved apart from all of this, is the limit of small amplitudes."""
    linear = model.frequency_response(inputs=source, outputs=outputs, frequencies=[12.0])
    found = model.periodic(
        inputs=source, amplitudes=[size], outputs=outputs, frequencies=[12.0, 13.0], harmonics=3, points=2
    )
    for k in range(len(outputs)):
        np.testing.assert_allclose(found.harmonics(k)[0, 1] / size, linear.response(k)[0], rtol=1e-5)
    assert found.work[0] == pytest.approx(found.loss[0], rel=1e-4)


@pytest.mark.parametrize("damping", [None, PRONY], ids=["Kelvin-Voigt", "Maxwell branches"])
def test_multipliers_of_small_motions_are_those_of_the_poles(damping):
    """A free motion exp(s t) is multiplied by exp(s T) in a period T."""
    model = cantilever(damping=damping)
    poles = model.modes(count=1).eigenvalues
    found = model.periodic(
        inputs="beam.end fz",
        amplitudes=[1e-4],
        outputs=["beam.end uz"],
        frequencies=[12.0, 13.0],
        harmonics=3,
        points=2,
    )
    exact = np.exp(poles[0] / 12.0)
    first = found.multipliers[0, :2]
    np.testing.assert_allclose(first[first.imag * exact.imag > 0], [exact], rtol=1e-6)


def test_hardening_beam_folds_where_a_multiplier_is_one():
    """Between folds motions are unstable (jumps); the loop of the force encloses its work, which is what is lost."""
    found = clamped().periodic(
        inputs="beam@0.2 fz", amplitudes=[1.0], outputs=["beam@0.2 uz"], frequencies=[95.0, 115.0], step=0.25
    )
    folds = [k for k, kind in found.bifurcations if kind == "fold"]
    assert len(folds) == len(found.bifurcations) == 2
    np.testing.assert_allclose(found.multipliers[folds, 0], 1.0, atol=2e-4)
    assert found.frequencies[folds[0]] > found.frequencies[folds[1]]
    inside = np.arange(folds[0] + 1, folds[1])
    assert len(inside) > 3
    assert not found.stable[inside].any()
    assert np.delete(found.stable, [*folds, *inside]).all()
    np.testing.assert_allclose(found.work, found.loss, rtol=1e-6)
    y, force = found.loop(10, 0, 2000)
    area = 0.5 * np.sum((force + np.roll(force, -1)) * (np.roll(y, -1) - y))
    assert area == pytest.approx(found.work[10], rel=1e-4)


def test_motion_is_that_to_which_a_simulation_settles():
    """Radau IIA from rest, after 30 periods, at an amplitude of two thirds of the thickness."""
    hertz, force = 110.0, 8.0
    found = clamped(4e-4).periodic(
        inputs="beam@0.2 fz",
        amplitudes=[force],
        outputs=["beam@0.2 uz"],
        frequencies=[hertz, 120.0],
        points=2,
    )
    assert found.amplitude(0)[0] > 0.6 * HEIGHT
    model = clamped(4e-4)
    model.force("beam@0.2", (0, 0, force), time=vr.Sine(amplitude=1.0, frequency=hertz, phase=np.pi / 2))
    run = model.simulate(30.0 / hertz, tolerance=1e-6, initial="reference")
    there = run.probe("beam@0.2")
    swing = CubicHermiteSpline(
        run.time, there["displacement"].values[:, 0, 2], there["velocity"].values[:, 0, 2]
    )
    times, course = found.course(0, 0, 50)
    np.testing.assert_allclose(swing(29.0 / hertz + times), course, atol=1e-4 * np.abs(course).max())


def test_straight_column_under_a_pulsating_force_doubles_its_period_as_mathieu_says(monkeypatch):
    """One mode, x'' + 2 z w x' + w^2 (1 - e cos W t) x = 0: where its multiplier passes -1, integrated apart.

    The force is quasi-static along the column up to (W/axial frequency)^2 = 3e-4 of it.
    """
    model, part = pinned(1e-4, order=4), 0.2
    pole = model.modes(count=1).eigenvalues[0]
    w, z = abs(pole), -pole.real / abs(pole)
    C, _, _ = model.rods["beam"].matrices_at(0.0)
    euler = np.pi**2 * min(C[3, 3], C[4, 4]) / LENGTH**2

    def growth(ratio):
        W = 2.0 * w * ratio

        def rate(t, x):
            return [x[1], -2 * z * w * x[1] - w**2 * (1 - part * np.cos(W * t)) * x[0]]

        ends = [solve_ivp(rate, (0, 2 * np.pi / W), x, rtol=1e-9, atol=1e-9).y[:, -1] for x in np.eye(2)]
        return np.abs(np.linalg.eigvals(np.array(ends))).max() - 1.0

    exact = [brentq(growth, 0.93, 0.98), brentq(growth, 1.02, 1.07)]
    hertz = w / np.pi
    checked, real = [], analysis.multipliers_with_more_harmonics
    monkeypatch.setattr(
        analysis,
        "multipliers_with_more_harmonics",
        lambda *given: checked.append((given[-1], real(*given))) or checked[-1][1],
    )
    found = model.periodic(
        inputs="beam.end fx",
        amplitudes=[part * euler],
        outputs=["beam.end ux"],
        frequencies=[0.94 * hertz, 1.06 * hertz],
        harmonics=3,
        step=0.5,
    )
    assert [kind for _, kind in found.bifurcations] == ["period doubling"] * 2
    at = [found.frequencies[k] / hertz for k, _ in found.bifurcations]
    np.testing.assert_allclose(at, exact, atol=2e-4)
    assert np.abs(found.multipliers[:, 0]).max() == pytest.approx(1.0 + growth(1.0), abs=5e-3)
    assert [harmonics for harmonics, _ in checked] == [6, 6]
    for _, more in checked:
        assert np.abs(more + 1.0).min() < 1e-3
    assert not [text for text in found.warnings if "not sure" in text]
    for better, told in (
        (1.01 * checked[0][1], "not sure: the multiplier"),
        (None, "no motion was found there"),
    ):
        monkeypatch.setattr(analysis, "multipliers_with_more_harmonics", lambda *_, better=better: better)
        record = analysis.Record(SimpleNamespace(fourier=SimpleNamespace(harmonics=3)), None)
        setting = SimpleNamespace(omega=2.0 * np.pi * hertz)
        point = SimpleNamespace(
            orbit=None,
            setting=setting,
            bifurcation="period doubling",
            multipliers=found.multipliers[found.bifurcations[0][0]],
        )
        record.check(point)
        assert told in record.notes[0]


def stretched_duffing():
    """Return ``w^2/w0^2 - 1`` over the square of the amplitude in the middle of a clamped beam [1/m^2].

    One mode of von Karman's beam whose ends cannot come nearer: the potential EA/(8 L) (int w'^2)^2 makes the force
    EA/(2 L) (int phi'^2)^2 q^3, three quarters of which count (Nayfeh and Mook, Nonlinear Oscillations, section 7.1).
    """
    x, f, f1, _ = mode_of(4.730040744862704, sign=-1.0)
    stretching = 0.5 * simpson(f1**2, x=x) ** 2 * 12.0 / HEIGHT**2
    stiffness = 4.730040744862704**4 * simpson(f * f, x=x)
    return 0.75 * stretching / stiffness / np.interp(0.5, x, f) ** 2


def mode_of(k, sign):
    """Return arc length, shape and two derivatives of a mode of a clamped beam, other end free (1) or clamped (-1)."""
    x = np.linspace(0.0, 1.0, 4001)
    s = (np.cosh(k) + sign * np.cos(k)) / (np.sinh(k) + sign * np.sin(k))
    ch, sh, c, n = np.cosh(k * x), np.sinh(k * x), np.cos(k * x), np.sin(k * x)
    return x, ch - c - s * (sh - n), k * (sh + n - s * (ch - c)), k**2 * (ch + c - s * (sh + n))


def inextensible_cantilever(k):
    """Return ``w^2/w0^2 - 1`` over the square of the amplitude of the tip, over the length, of one mode.

    Curvature w''^2 (1 + w'^2) against the inertia of the shortening int w'^2/2: q'' + w0^2 q + k3 q^3 + b (q q'^2 +
    q^2 q'') = 0 (Crespo da Silva and Glynn 1978; Nayfeh and Pai, Linear and Nonlinear Structural Mechanics, 2004,
    section 4.5): the first mode hardens, the second softens.
    """
    x, f, f1, f2 = mode_of(k, sign=1.0)
    mass = simpson(f * f, x=x)
    k3 = 2.0 * simpson(f1**2 * f2**2, x=x) / mass / k**4
    b = simpson(cumulative_simpson(f1**2, x=x, initial=0.0) ** 2, x=x) / mass
    return (0.75 * k3 - 0.5 * b) / f[-1] ** 2


def shift(found, last):
    """Return by what the square of the frequency grows with that of the amplitude, over its first value."""
    square, a = (found.frequencies / found.frequencies[0]) ** 2, found.amplitude(0)
    return (square[-1] - square[last]) / (a[-1] ** 2 - a[last] ** 2)


def test_beam_between_hinges_hardens_as_woinowsky_krieger_says():
    """J. Appl. Mech. 17 (1950) 35: q'' + w^2 (q + q^3/(4 r^2)) = 0 with the radius of gyration r, an elliptic integral.

    Its second mode has four times the frequency of the first, and small swings leave round-off of the stretch.
    """
    steel = vr.Material(2.1e11, 0.3, 7850.0)
    model = vr.Model()
    section = vr.Rectangle(0.02, 0.01)
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), d1=(0, 1, 0), section=section, material=steel)
    model.add("beam", rod)
    for end in ("beam.start", "beam.end"):
        model.support(end, ("ux", "uy", "uz", "rx", "rz"))
    found = model.periodic(mode=1, outputs=["beam@0.5 uz"], largest=2e-3)
    cubic = found.amplitude(0) ** 2 * 12.0 / (4.0 * 0.01**2)
    ratio = np.pi * np.sqrt(1.0 + cubic) / (2.0 * ellipk(cubic / (2.0 * (1.0 + cubic))))
    linear = model.modes(1).frequencies[0]
    assert found.frequencies == pytest.approx(linear * ratio, rel=1e-4)
    assert found.warnings == []
    assert "without damping a free vibration has neither work nor loss" in " ".join(found.report().split())


def test_clamped_beam_hardens_as_duffing_says():
    found = clamped(order=4).periodic(mode=1, largest=4e-4, outputs=["beam@0.2 uz"], harmonics=3, step=0.8)
    assert shift(found, -3) == pytest.approx(stretched_duffing(), rel=2e-3)
    # all viscosity is that of one time: tau w/2
    assert found.damping_ratios[0] == pytest.approx(5e-5 * np.pi * found.frequencies[0], rel=1e-4)


@pytest.mark.parametrize(
    ("mode", "k", "largest"), [(1, 1.875104068711961, 0.06), (2, 4.694091132974175, 0.02)]
)
def test_first_mode_of_a_cantilever_hardens_and_the_second_softens(mode, k, largest):
    exact = inextensible_cantilever(k)
    assert (exact > 0.0) == (mode == 1)
    found = strip(5e-6, order=4)
    found.clamp("beam.start")
    swings = found.periodic(
        mode=mode, largest=largest * LENGTH, outputs=["beam.end uz"], harmonics=5, step=0.8
    )
    assert shift(swings, -4) * LENGTH**2 == pytest.approx(exact, rel=3e-3)


def test_backbone_is_what_a_decay_passes_through():
    """The released cantilever of Linn, Lang and Tuganov, computed in time: period and decrement of its cycles."""
    case = load_case(shipped_case("cantilever_swing"))
    decay = run_case(case).decrement("beam.end", "y")
    found = as_model(case.description).periodic(
        mode=1, largest=0.17, outputs=["beam.end uy"], about="released", harmonics=7, step=0.3
    )
    sizes = np.asarray(decay.amplitude)
    mean, at = (
        np.sqrt(sizes[1:] * sizes[:-1])[2:],
        found.amplitude(0),
    )  # the first cycles have other modes too
    ratio = CubicSpline(at, found.decrement_ratios(0))(mean)
    np.testing.assert_allclose(np.asarray(decay.damping_ratio)[2 : 2 + len(mean)], ratio, rtol=5e-3)
    undamped = CubicSpline(at, found.frequencies)(mean)
    zeta = CubicSpline(at, found.damping_ratios)(mean)
    period = 1.0 / (undamped * np.sqrt(1.0 - zeta**2))
    np.testing.assert_allclose(np.asarray(decay.period)[2 : 2 + len(mean)], period, rtol=2e-4)
    assert len(mean) >= 3


def test_result_is_saved_loaded_reported_drawn_and_tabulated(tmp_path):
    found = clamped(elements=2, order=2).periodic(
        inputs="beam@0.2 fz",
        amplitudes=[1.0],
        outputs=["beam@0.2 uz", "beam.start reaction fz"],
        frequency=95.0,
        levels=[0.2, 1.0],
        harmonics=3,
        step=0.5,
    )
    assert found.levels[-1] == 1.0
    again = vr.load(found.save(tmp_path / "curve.nc"))
    np.testing.assert_array_equal(again.harmonics(1), found.harmonics(1))
    assert again.report() == found.report()
    assert "stable" in found.report()
    rows = found.save_csv(tmp_path / "curve.csv").read_text().splitlines()
    assert len(rows) == 1 + len(found.levels)
    for kind in ("amplitude", "multipliers", "loops"):
        assert written(found.plot, tmp_path / f"{kind}.png", kind).stat().st_size > 10_000
    free = clamped(elements=2, order=2).periodic(
        mode=1, largest=1e-3, outputs=["beam@0.2 uz"], harmonics=3, step=1.0
    )
    again = vr.load(free.save(tmp_path / "free.nc"))
    assert again.report() == free.report()
    assert written(free.plot, tmp_path / "backbone.png").stat().st_size > 10_000
    with pytest.raises(vr.InputError, match="free vibrations"):
        _ = free.stable


def test_what_periodic_motions_do_not_know_is_refused_by_name():
    drive = {"amplitudes": [1.0], "outputs": ["beam.end uz"], "frequencies": [10.0, 12.0]}
    with pytest.raises(vr.InputError, match="2 inputs have 2 amplitudes"):
        cantilever().periodic(inputs=["beam.end fz", "beam.end fy"], **drive)
    with pytest.raises(vr.InputError, match="over frequencies or over levels"):
        cantilever().periodic(inputs="beam.end fz", amplitudes=[1.0], outputs=["beam.end uz"])
    with pytest.raises(vr.InputError, match="forced by inputs, or are free vibrations"):
        cantilever().periodic(outputs=["beam.end uz"])
    with pytest.raises(vr.InputError, match="moved, not turned"):
        cantilever().periodic(inputs="base rz", **drive)
    spinning = strip()
    spinning.body_velocity("beam.start", ("v1", "v2", "v3", "w1", "w2", "w3"))
    with pytest.raises(vr.InputError, match="velocities along axes of the section"):
        spinning.periodic(inputs="beam.end fz", **drive)


@pytest.mark.parametrize(
    ("model", "source", "size", "output"),
    [
        (pinned(damping=PRONY), "beam@0.2 fz", 0.5, "beam@0.2 uz"),
        (hinged(), "two.end fz", 1e-2, "two.end uz"),
    ],
    ids=["Maxwell branches and partial supports", "hinge, held strains, gravity and drag"],
)
def test_sparse_and_dense_matrices_are_one(monkeypatch, model, source, size, output):
    """The matrix of an orbit is the same whether it is stored by blocks or whole."""
    found = []
    for most in (2500, 0):
        monkeypatch.setattr(orbit_matrix, "DENSE", most)
        found.append(
            model.periodic(
                inputs=source,
                amplitudes=[size],
                outputs=[output],
                frequencies=[12.0, 13.0],
                harmonics=2,
                points=2,
            )
        )
    dense, blocks = found
    assert blocks.amplitude(0) == pytest.approx(dense.amplitude(0), rel=1e-9)
    assert blocks.frequencies == pytest.approx(dense.frequencies, rel=1e-9)


def test_large_models_have_no_multipliers_and_say_so(monkeypatch):
    monkeypatch.setattr(floquet, "MOST", 5)
    given = {
        "inputs": "beam.end fz",
        "amplitudes": [1e-3],
        "outputs": ["beam.end uz"],
        "frequencies": [12.0, 13.0],
    }
    with pytest.raises(vr.InputError, match=r"stability: true.*give stability = false, or fewer elements"):
        cantilever().periodic(**given, harmonics=2, points=2)
    found = cantilever().periodic(**given, harmonics=2, points=2, stability=False)
    assert found.multipliers.shape[1] == 0


def test_what_a_law_lacks_of_a_table_is_told():
    """Kelvin and Voigt's E (1 + i w t) in place of E (1 + i eta): |w t - eta|/sqrt(1 + eta^2) of it where E is one."""
    eta, hertz = 0.05, 25.0
    table = vr.ComplexModuli(frequency=[0.1, 1e4], storage=[70e9, 70e9], tan_delta=[eta, eta])
    model = vr.Model()
    material = vr.Material(density=2700.0, poissons_ratio=0.33, damping=table)
    section = vr.Rectangle(WIDTH, HEIGHT)
    model.add("beam", vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, material=material))
    (text,) = of_law_in_place(model, hertz, hertz)
    told = float(re.search(r"up to (\S+) of it", text)[1])
    law = material.youngs_modulus * (1.0 + 2j * np.pi * hertz * material.extensional_time)
    assert told == pytest.approx(abs(law / (70e9 * (1.0 + 1j * eta)) - 1.0), rel=0.05)
    assert "was not compared" in of_law_in_place(model, 2e4, 3e4)[0]


def test_a_law_of_branches_is_as_near_to_a_loss_factor_as_it_says():
    eta, within = 0.05, 0.02
    damping = vr.LossFactor(extension=eta, band=(1.0, 100.0), within=within)
    (text,) = of_law_in_place(cantilever(damping=damping), 2.0, 50.0)
    assert 0.0 < float(re.search(r"up to (\S+) of it", text)[1]) < 2.0 * eta
    assert not of_law_in_place(cantilever(), 2.0, 50.0)  # Kelvin and Voigt's law is what was given

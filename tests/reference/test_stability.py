"""Stability along a load against boundary value problems solved here: Beck's column, Ziegler's pendulum.

Beck (1952): ``(1 + tau s) EI w'''' + P w'' + c s w + m s^2 w = 0``, clamped, free under a force that follows; with
``s = i w`` its determinant vanishes at the flutter load (Bolotin, Nonconservative Problems of the Theory of Elastic
Stability, 1963). Ziegler (1952): two bars, 2m and m, springs c: ``(7/2 - sqrt 2) c/l``, 41/28 with hardly any damping.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar, root

import viscorod as vr
from helpers.pictures import written
from helpers.plain_text import flat
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case

LOOSE = [1, 1, 1, 1e-12, 1e-12, 2e-12]


def beck(tau=0.0, outside=0.0, elements=8, branches=(), load=1.0, following=True):
    """A column of EI, length and mass per length 1 that neither shears nor stretches."""
    C = np.array([1.0, 1.0, 1.0, 1.0, 30.0, 1.0])
    made = [vr.MaxwellBranch(time=t, stiffness=g * np.diag(C)) for g, t in branches]
    section = vr.StiffnessSection(np.diag(C), LOOSE, damping=tau * np.diag(C) if tau else None, branches=made)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0, 0, 1), section=section, elements=elements, order=4, constraints="kirchhoff"
    )
    model.add("column", rod)
    model.clamp("column.start")
    model.force("column.end", (0, 0, -load), following=following)
    if outside:
        model.drag("column", linear_across=outside)
    return model


def determinant(s, load, modulus=1.0, outside=0.0):
    """That of Beck's column for motions exp(s t); ``modulus`` is the complex one over EI."""
    p, q = load / modulus, (s**2 + outside * s) / modulus
    middle = np.sqrt(0.25 * p**2 - q + 0j)
    a, b = np.sqrt(middle - 0.5 * p + 0j), np.sqrt(middle + 0.5 * p + 0j)
    # w = A (cosh a x - cos b x) + B (sinh a x / a - sin b x / b), moment and shear vanish at the end
    moment = a**2 * np.cosh(a) + b**2 * np.cos(b), a * np.sinh(a) + b * np.sin(b)
    shear = a**3 * np.sinh(a) - b**3 * np.sin(b), a**2 * np.cosh(a) + b**2 * np.cos(b)
    return moment[0] * shear[1] - moment[1] * shear[0]


def undamped():
    """The largest load on the curve of the first two frequencies: its double root."""

    def load(w):
        return brentq(lambda p: determinant(1j * w, p).real, 5.0, 25.0, xtol=1e-14)

    found = minimize_scalar(
        lambda w: -load(w), bounds=(9.0, 13.0), method="bounded", options={"xatol": 1e-10}
    )
    return load(found.x), found.x


def damped(guess, modulus=lambda s: 1.0, outside=0.0):
    """Load and angular frequency at which a motion neither grows nor fades."""

    def left(x):
        s = 1j * x[1]
        value = determinant(s, x[0], modulus(s), outside)
        return [value.real, value.imag]

    found = root(left, guess, tol=1e-13)
    assert found.success
    return found.x


def flutter(model, **settings):
    found = model.stability(**{"band": (0.0, 25.0), "count": 6, "modes": 3} | settings)
    (limit,) = found.limits
    assert (limit.kind, limit.unstable) == ("flutter", True)
    return limit


def test_flutter_of_becks_column():
    """20.05095 EI/L^2, here to 1e-8 of the double root; the mesh error that is told is the one there is."""
    load, omega = undamped()
    assert load == pytest.approx(20.05095, abs=5e-6)
    found = flutter(beck())
    assert found.at == pytest.approx(load, rel=1e-8)
    assert found.frequency == pytest.approx(omega / (2.0 * np.pi), rel=1e-5)
    coarse = flutter(beck(elements=3))
    gap = abs(coarse.at / load - 1.0)
    assert 0.8 * gap < coarse.mesh_error < 1.25 * gap


@pytest.mark.parametrize(("tau", "guess"), [(1e-3, (10.9, 5.4)), (0.1, (13.6, 5.5))])
def test_flutter_with_kelvin_voigt_damping(tau, guess):
    """A little damping lowers it to 10.94; more of it raises it again."""
    load, omega = damped(guess, lambda s: 1.0 + tau * s)
    found = flutter(beck(tau))
    assert found.at == pytest.approx(load, rel=1e-8)
    assert found.frequency == pytest.approx(omega / (2.0 * np.pi), rel=1e-7)


def test_flutter_with_maxwell_branches():
    """The same boundary value problem with the complex modulus of two branches."""
    pairs = ((0.3, 0.02), (0.2, 0.3))
    load, omega = damped((12.0, 6.0), lambda s: 1.0 + sum(g * s * t / (1.0 + s * t) for g, t in pairs))
    found = flutter(beck(branches=pairs, elements=4), modes=2)
    assert found.at == pytest.approx(load, rel=2e-6)
    assert found.frequency == pytest.approx(omega / (2.0 * np.pi), rel=2e-6)


@pytest.mark.parametrize(("outside", "guess"), [(0.1, (20.05, 11.0)), (300.0, (37.6, 0.6))])
def test_flutter_in_a_thick_fluid(outside, guess):
    """Damping from outside does not lower it, and lifts it to 37.7 where inertia does not count."""
    load, _ = damped(guess, outside=outside)
    found = flutter(beck(outside=outside, elements=6), band=(0.0, 45.0), count=10)
    assert found.at == pytest.approx(load, rel=1e-6)
    if outside > 1.0:
        assert load == pytest.approx(37.7, abs=0.1)


def test_the_growing_one_of_two_that_meet_is_followed():
    """With one mode the other that it meets is not followed: the limit is seen all the same."""
    one, two = (beck(elements=3).stability(band=(0.0, 25.0), count=6, modes=k) for k in (1, 3))
    assert [limit.at for limit in one.limits] == pytest.approx([limit.at for limit in two.limits], rel=1e-11)
    assert not one.warnings
    late = beck(elements=3).stability(band=(22.0, 25.0), count=3, modes=1)
    assert "grow from the beginning" in flat(late.report())


def test_beals_free_rod_flutters_beside_motions_that_diverge():
    """Beal 1965: ``EI w'''' + P ((1 - x) w')' + m w'' = 0``, free at both ends, a thrust P that follows at x = 0.

    The thrust is in balance with the inertia of the rod, a dead force along it, and soft springs hold it, on which it
    turns away at once. The right load by Ritz's method with polynomials. A rigid motion that diverges all the while
    looks much like the one that flutters: the limit was told to be at the last load before.
    """
    points, weights = np.polynomial.legendre.leggauss(40)
    x, weights = 0.5 * (points + 1.0), 0.5 * weights
    shapes = [np.polynomial.Legendre.basis(j, domain=[0, 1]) for j in range(14)]
    w, slope, bend = (np.array([one.deriv(k)(x) if k else one(x) for one in shapes]) for k in range(3))
    mass, own = (w * weights) @ w.T, (bend * weights) @ bend.T
    pushed = (slope * weights * (1.0 - x)) @ slope.T
    pushed += np.outer([one(0.0) for one in shapes], [one.deriv()(0.0) for one in shapes])

    def fluttering(load):
        squares = np.linalg.eigvals(np.linalg.solve(mass, own - load * pushed))
        return np.abs(squares[np.abs(squares) > 1.0].imag).max() - 1e-2

    right = brentq(fluttering, 100.0, 115.0, xtol=1e-4)
    section = vr.StiffnessSection(
        {"EA": 1e6, "GA1": 1e6, "GA2": 1e6, "EI1": 1.0, "EI2": 2.0, "GJ": 1.0}, [1, 1, 1, 1e-9, 1e-9, 2e-9]
    )
    model = vr.Model()
    mesh = {"elements": 4, "order": 4, "constraints": "kirchhoff"}
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, **mesh))
    model.force("rod.start", (0, 0, 1.0), following=True)
    with pytest.raises(vr.InputError, match="What its own thrust accelerates"):
        model.stability(band=(90.0, 120.0), count=4)
    model.distributed_force("rod", (-1.0, 0, 0))
    model.spring("rod@0.5", stiffness=dict.fromkeys(("ux", "uy", "uz", "rx", "ry", "rz"), 1e-3))
    found = model.stability(band=(90.0, 120.0), count=4, modes=8)
    (flutter,) = found.limits
    assert flutter.kind == "flutter"
    assert flutter.at == pytest.approx(right, rel=5e-5)


def test_eulers_column_diverges():
    """pi^2/4 under a load that keeps its direction, here in tenths of that; frequencies vanish there."""
    found = beck(load=0.1 * np.pi**2 / 4.0, following=False, elements=4).stability(
        band=(0.0, 12.0), count=4, modes=2
    )
    (limit,) = found.limits
    assert (limit.kind, limit.frequency) == ("divergence", 0.0)
    assert limit.at == pytest.approx(10.0, rel=1e-8)
    assert found.frequencies[0, 0] == pytest.approx(3.516015268 / (2.0 * np.pi), rel=1e-6)


@pytest.mark.parametrize("following", [False, True])
def test_nikolais_shaft_flutters_under_any_torque(following):
    """Nikolai (1928): a round shaft under a torque at its free end has no stable straight state, however small it is.

    Its two equal frequencies meet at no torque at all. With EI2 = 2 EI1 they begin apart, and the limit is finite.
    """

    def limits(other):
        section = vr.StiffnessSection([1.0, 1.0, 1.0, 1.0, other, 1.0], LOOSE)
        model = vr.Model()
        rod = vr.Rod.straight(
            (0, 0, 0), (0, 0, 1), section=section, elements=2, order=3, constraints="kirchhoff"
        )
        model.add("shaft", rod)
        model.clamp("shaft.start")
        model.moment("shaft.end", (0, 0, 1.0), following=following)
        return model.stability(band=(0.0, 2.0), count=3, modes=3).limits

    round_one = limits(1.0)
    assert {limit.at for limit in round_one} == {0.0}
    assert {(limit.kind, limit.mesh_error) for limit in round_one} == {("flutter", 0.0)}
    assert round_one[0].frequency == pytest.approx(3.516015 / (2.0 * np.pi), rel=1e-3)
    assert min(limit.at for limit in limits(2.0)) > 1.0


def ziegler(damping):
    """Two bars of length 1 on hinges with springs, masses 2 and 1 at their ends, a force of 1 that follows."""
    section = vr.StiffnessSection(np.ones(6), [1e-9, 1e-9, 1e-9, 1e-12, 1e-12, 2e-12])
    held = ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")
    model = vr.Model()
    for name, z, mass in (("lower", 0.0, 2.0), ("upper", 1.0, 1.0)):
        bar = vr.Rod.straight(
            (0, 0, z), (0, 0, z + 1.0), section=section, elements=1, order=1, constraints=held
        )
        model.add(name, bar)
        model.add(f"{name}_mass", vr.Body(mass, (1e-9, 1e-9, 1e-9), centre=(0, 0, z + 1.0)))
        model.attach(f"{name}.end", f"{name}_mass")
    hinge = {"axis": (0, 1, 0), "stiffness": {"rz": 1.0}}
    if damping:
        hinge["damping"] = {"rz": damping}
    model.revolute("lower.start", "ground", **hinge)
    model.revolute("upper.start", "lower.end", **hinge)
    model.force("upper.end", (0, 0, -1.0), following=True)
    return model


def test_zieglers_pendulum():
    """Joints and bodies: (7/2 - sqrt 2) without damping, and 41/28 with damping that all but vanishes."""
    settings = {"band": (0.0, 3.0), "count": 7, "modes": 2}
    assert flutter(ziegler(0.0), **settings).at == pytest.approx(3.5 - np.sqrt(2.0), rel=1e-7)
    assert flutter(ziegler(1e-3), **settings).at == pytest.approx(41.0 / 28.0, rel=1e-5)


def test_what_it_refuses():
    with pytest.raises(vr.InputError, match="no loads whose factor could grow"):
        beck().stability(band=(0.0, 1.0), constant=["force"])
    with pytest.raises(vr.InputError, match="give load_factors"):
        beck().stability()
    loose = beck()
    loose.supports.clear()
    with pytest.raises(vr.InputError, match="no static equilibrium"):
        loose.stability(band=(0.0, 1.0))


def test_it_is_kept_drawn_and_told(tmp_path):
    found = beck(1e-2, elements=3).stability(band=(0.0, 15.0), count=4, modes=2)
    again = vr.load(found.save(tmp_path / "stability.nc"))
    assert isinstance(again, vr.Stability)
    assert again.report() == found.report()
    assert "begins: flutter" in flat(found.report())
    assert written(found.plot, tmp_path / "stability.png").stat().st_size > 10_000
    table = found.save_csv(tmp_path / "stability.csv").read_text(encoding="utf-8").splitlines()
    assert table[0].startswith("load factor,")
    assert len(table) == 1 + 4


@pytest.mark.parametrize(
    ("name", "analysis", "given"),
    [
        ("becks_column", "stability", {"load_factors": [1.0, 2.0]}),
        ("whirling_shaft", "campbell", {"axis": (1, 0, 0), "speeds": [10.0, 20.0]}),
        ("tall_rod", "buckling", {"count": 2}),
    ],
)
def test_a_reason_to_stop_is_told(name, analysis, given):
    """Analyses along a parameter ask ``stop`` in their iterations, and end with its reason."""
    model = load_case(shipped_case(name)).model(vr.Model)
    asked = itertools.count()
    with pytest.raises(vr.SolveError, match="enough"):
        getattr(model, analysis)(**given, stop=lambda: "enough" if next(asked) > 1 else "")
    assert next(asked) > 2


@pytest.mark.parametrize(
    ("name", "analysis", "given", "kept"),
    [
        ("becks_column", "stability", {"load_factors": [1.0, 2.0, 3.0, 4.0], "modes": 2}, "values"),
        ("whirling_shaft", "campbell", {"axis": (1, 0, 0), "speeds": [1.0, 2.0, 3.0], "modes": 2}, "values"),
        ("tall_rod", "buckling", {"count": 3}, "load_factors"),
    ],
)
def test_what_was_found_before_a_stop_is_kept(tmp_path, name, analysis, given, kept):
    """The part that was done is the beginning of the whole, is told along its way, and says that it is a part."""
    model = load_case(shipped_case(name)).model(vr.Model)
    told, limits = [], {"buckling": 1.02}  # its first two critical loads are at 1.0177
    most = limits.get(analysis, 2.0)
    with pytest.raises(vr.SolveError, match="enough") as caught:
        getattr(model, analysis)(
            **given,
            progress=lambda reached, step: told.append(reached),
            stop=lambda: "enough" if told and told[-1] >= most else "",
        )
    part, whole = caught.value.run, getattr(model, analysis)(**given)
    assert told == sorted(told)
    mine, all_of_it = getattr(part, kept), getattr(whole, kept)
    assert len(mine) == 2
    assert mine == pytest.approx(all_of_it[:2], rel=1e-9)
    assert part.outcome not in ("completed", whole.outcome)
    assert vr.load(part.save(tmp_path / "part.nc")).report() == part.report()
    assert "not all that was asked for" in flat(part.report()) or "ended before" in flat(part.report())


def test_a_campbell_diagram_without_limits_is_read_again(tmp_path):
    """Lists of no texts come back from a file."""
    model = load_case(shipped_case("whirling_shaft")).model(vr.Model)
    found = model.campbell((1, 0, 0), speeds=[1.0, 2.0], modes=2)
    assert not found.limits
    assert not vr.load(found.save(tmp_path / "campbell.nc")).limits

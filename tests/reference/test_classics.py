"""Classics of the field that other tests do not have; meshes and settings are left to the program where it matters."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq, fsolve, minimize_scalar

import viscorod as vr

STEEL = vr.Material(2e11, 0.3, 7850.0)


def ring(gj: float, twist: float = 0.0, *, ends: bool, **mesh: int) -> vr.Model:
    """A circle of radius 1 about z with EI = 1, from the x axis on; closed, or with its ends held at one place."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, gj], [1.0, 1.0, 1.0, 1e-9, 1e-9, 2e-9])
    model = vr.Model()
    rod = vr.Rod.arc((1, 0, 0), (0, 1, 0), (-1, 0, 0), 1.0, 2.0 * np.pi, section=section, **mesh)
    model.add("ring", rod)
    if ends:
        model.clamp("ring.start")
        model.clamp("ring.end", motion={"ry": twist})
    else:
        model.attach("ring.end", "ring.start")
    return model


def test_a_ring_vibrates_as_hoppe_and_spins_as_bryan_say() -> None:
    """Hoppe 1871, Love 1927 (art. 293): ``w^2 = n^2 (n^2 - 1)^2 / (n^2 + 1)`` and, off the plane, ``/(n^2 + EI/GJ)``.

    Bryan 1890: seen on a ring that spins, ``w = root +- 2 n W / (n^2 + 1)``, ``root^2`` being the square at rest times
    ``1 + W^2 / (n^2 + 1)``. Off its plane a spinning ring has ``n^2 W^2`` more (tension ``W^2``, and its mode n = 1
    tilts in space, so that it is seen at W).
    """
    gj, speed = 0.8, 1.0
    model = ring(gj, ends=False)
    n = np.arange(2.0, 4.0)
    own = n**2 * (n**2 - 1.0) ** 2
    inside, outside = own / (n**2 + 1.0), own / (n**2 + 1.0 / gj)
    found = model.modes(14, about="reference")
    assert found.rigid == 6
    expected = np.sort(np.sqrt(np.repeat(np.concatenate([inside, outside]), 2)))
    assert 2.0 * np.pi * found.frequencies[6:] == pytest.approx(expected, rel=5e-5)
    spinning = model.steady(spin=speed, axis=(0, 0, 1), modes=8)
    assert spinning.stable
    root, split = np.sqrt(inside * (1.0 + speed**2 / (n**2 + 1.0))), 2.0 * n / (n**2 + 1.0)
    seen = 2.0 * np.pi * np.asarray(spinning.frequencies)
    assert seen[2:4] == pytest.approx(speed, rel=1e-6)
    assert seen[4] == pytest.approx(root[0] - speed * split[0], rel=1e-4)
    assert seen[5] == pytest.approx(np.sqrt(outside[0] + n[0] ** 2 * speed**2), rel=1e-4)


def twisted_ring(twist: float, **mesh: int) -> vr.Model:
    """A ring bent from a straight rod and twisted, held against turning about its own line, which costs nothing."""
    model = ring(1.3, twist, ends=True, **mesh)
    model.rest_strain("ring", (0, 0, 0, 0, -1.0, 0))
    model.support(f"ring@{np.pi}", ("uz",))
    return model


def test_a_twisted_ring_writhes_as_michell_says() -> None:
    """Michell 1889: a ring bent from a straight rod is stable up to a torque of ``sqrt(3) EI/R``.

    Its centre line does not move before that, only its sections turn: errors of positions are no part of nothing.
    """
    critical = np.sqrt(3.0) / 1.3
    for part, unstable in ((0.99, 0), (1.01, 2)):
        model = twisted_ring(part * 2.0 * np.pi * critical, elements=8, order=4)
        found = model.equilibrium(stages=[{"loads": ["rest_strains"]}, {}], search=False)
        assert found.negative_eigenvalues == unstable
        assert found.data["section_force"].values[-1, :, 5] == pytest.approx(part * np.sqrt(3.0), rel=1e-3)
        assert not found.warnings


@pytest.mark.parametrize("off", [0.0, -1e-10, 1e-9])
def test_a_mesh_on_which_critical_loads_are_not_found_is_refined(off: float) -> None:
    """Michell's ring again: Newton's method fails on the first mesh that the program chooses.

    It writhes in two directions at once, whatever the last digits of the turn are: rounding of its stiff sections moves
    equilibria by more than their distance there. Just below a whole turn the first mesh is coarser, and parts them.
    """
    found = twisted_ring(2.0 * np.pi * (1.0 + off)).buckling(constant=["rest_strains"], count=1, about=1.2)
    assert found.load_factors == pytest.approx(2 * [np.sqrt(3.0) / 1.3], rel=1e-4)
    assert not found.limit.any()
    assert not found.warnings
    (told,) = found.with_errors(np.array([1e-3, 0.3])).warnings
    assert told.startswith("critical load 2 is another by up to 30 % on a finer mesh; use more elements.")


def test_lees_frame_snaps_where_shooting_says() -> None:
    """Lee, Manuel and Rossow 1968: two legs of 120 cm on hinges, a load on the beam at a fifth of it.

    The load at the same displacement of both legs as one extensible elastica, from the foot to the other hinge, which
    has its extreme there. Literature: 18.53 kN (Schweizerhof and Wriggers 1986, on coarser meshes).
    """
    EA, EI, L, a = 4.32e7, 1.44e7, 120.0, 24.0
    section = vr.StiffnessSection(
        [1e3 * EA, 1e3 * EA, EA, 10.0 * EI, EI, EI], [1.0, 1.0, 1.0, 1e-3, 1e-3, 2e-3]
    )
    frame = vr.Model()
    frame.add("leg", vr.Rod.straight((0, 0, 0), (0, L, 0), section=section, elements=3, order=4))
    frame.add("beam", vr.Rod.straight((0, L, 0), (L, L, 0), section=section, elements=5, order=4))
    frame.attach("leg.end", "beam.start")
    for hinge in ("leg.start", "beam.end"):
        frame.support(hinge, ("ux", "uy", "uz", "rx", "ry"))
    frame.force(f"beam@{a}", (0, -1.0, 0))
    found = frame.path(limit_point=1)
    load, sunk = found.limit_points[0], -found.displacement(f"beam@{a}")[1]

    def along(pose, push, lift, length):
        def slopes(_s, y):
            stretch = 1.0 + (push * np.cos(y[2]) + lift * np.sin(y[2])) / EA
            across = lift * np.cos(y[2]) - push * np.sin(y[2])
            return [stretch * np.cos(y[2]), stretch * np.sin(y[2]), y[3] / EI, -stretch * across]

        return solve_ivp(slopes, (0.0, length), pose, rtol=1e-9, atol=1e-9).y[:, -1]

    def missed(unknown, down):
        turned, push, lift, force = unknown * scales
        pose = along([0.0, 0.0, turned, 0.0], push, lift, L)
        pose[2] -= 0.5 * np.pi
        loaded = along(pose, push, lift, a)
        end = along(loaded, push, lift + force, L - a)
        return [end[0] / L - 1.0, end[1] / L - 1.0, end[3] / EI * L, loaded[1] / L - 1.0 + down / L]

    scales = np.array([1.0, load, load, load])
    fx, fy = found.reactions.sel(support="leg.start", motion=["fx", "fy"]).values.ravel()[-2:]
    first = [0.5 * np.pi + found.rotation("leg.start")[2], -fx / load, -fy / load, 1.0]
    loads = [
        load * fsolve(missed, first, args=(down,), xtol=1e-10)[3] for down in (sunk - 1.0, sunk, sunk + 1.0)
    ]
    assert loads[1] == pytest.approx(load, rel=2e-5)
    assert max(loads[0], loads[2]) < load


def test_a_helical_spring_vibrates_and_gives_way_as_published() -> None:
    """Pearson 1982 and Yildirim 1996: clamped, wire 1 mm, 7.6 turns of 10 mm; their figures have four digits.

    An axial force alone twists and bends the wire of a spring whose end does not turn: energy by Castigliano.
    """
    E, nu, R, r, turns, rise = 2.06e11, 0.3, 0.005, 0.0005, 7.6, np.radians(8.5744)
    wire = vr.Material(E, nu, 7900.0)
    pitch = 2.0 * np.pi * R * np.tan(rise)
    coil = vr.Rod.helix(radius=R, pitch=pitch, turns=turns, section=vr.Circle(r), material=wire)
    model = vr.Model()
    model.add("spring", coil)
    model.clamp("spring.start")
    held = vr.Model.of(**model.parts())
    held.clamp("spring.end")
    published = [393.5, 395.9, 462.8, 525.5, 864.0, 876.9, 914.3, 1037.0, 1310.5, 1363.8]
    assert held.modes(10).frequencies == pytest.approx(published, rel=1e-3)

    model.add("plate", vr.Body(1e-3, (1e-9, 1e-9, 1e-9), centre=(0, 0, pitch * turns)))
    model.attach("spring.end", "plate")
    model.support("plate", ("rz",))
    model.force("plate", (0, 0, 1e-3))
    A, EI, GJ, c, s = (
        np.pi * r**2,
        E * np.pi * r**4 / 4,
        E / (2 + 2 * nu) * np.pi * r**4 / 2,
        np.cos(rise),
        np.sin(rise),
    )
    kGA = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu) * E / (2.0 + 2.0 * nu) * A
    couple = -R * s * c * (1.0 / GJ - 1.0 / EI) / (s**2 / GJ + c**2 / EI)
    twist, bend = R * c + couple * s, couple * c - R * s
    soft = twist**2 / GJ + bend**2 / EI + c**2 / kGA + s**2 / (E * A)
    expected = 1e-3 * coil.length * soft
    assert model.equilibrium().displacement("plate")[2] == pytest.approx(expected, rel=2e-3)


def test_a_stiff_string_is_sharp_and_a_heated_strip_buckles() -> None:
    """Fletcher 1964: ``f = n f0 sqrt(1 + B n^2)``, ``B = pi^2 EI/(T L^2)``; a strip at ``4 pi^2 I/(A L^2 alpha)``."""
    r, L, T = 0.0005, 0.65, 700.0
    A, EI = np.pi * r**2, 2e11 * np.pi * r**4 / 4
    string = vr.Model()
    string.add("string", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=vr.Circle(r), material=STEEL))
    string.support("string.start", ("ux", "uy", "uz", "rx"))
    string.support("string.end", ("uy", "uz"))
    string.force("string.end", (T, 0, 0))
    longer = L * (1.0 + T / (2e11 * A))
    n = np.repeat(np.arange(1.0, 5.0), 2)
    own = np.sqrt(T * longer / (7850.0 * A * L)) / (2.0 * longer)
    expected = n * own * np.sqrt(1.0 + np.pi**2 * EI / (T * longer**2) * n**2)
    assert string.modes(8).frequencies == pytest.approx(expected, rel=1e-5)

    hot = vr.Material(2e11, 0.3, 7850.0, thermal_expansion=1.2e-5)
    strip = vr.Model()
    strip.add("strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.002), material=hot))
    strip.clamp("strip.start")
    strip.clamp("strip.end")
    strip.rest_strain("strip", temperature=1.0)
    critical = strip.buckling(count=1)
    assert critical.load_factors[0] == pytest.approx(4.0 * np.pi**2 * 0.002**2 / 12.0 / 1.2e-5, rel=1e-4)


def test_followers_along_the_column_and_with_a_mass_at_its_tip() -> None:
    """Leipholz 1962: 40.05 EI/L^3 along the whole; Pflueger 1955: with the column's mass at the tip, by its roots."""

    def column():
        section = vr.StiffnessSection([1.0, 1.0, 1.0, 1.0, 5.0, 1.0], [1.0, 1.0, 1.0, 1e-9, 1e-9, 2e-9])
        model = vr.Model()
        rod = vr.Rod.straight(
            (0, 0, 0), (1, 0, 0), section=section, elements=4, order=4, constraints="kirchhoff"
        )
        model.add("beam", rod)
        model.clamp("beam.start")
        return model

    def determinant(load, square):
        a, b = (np.sqrt(np.hypot(0.5 * load, np.sqrt(square)) + sign * 0.5 * load) for sign in (-1.0, 1.0))
        first = (
            np.cosh(a) - np.cos(b),
            a * a * np.cosh(a) + b * b * np.cos(b),
            a**3 * np.sinh(a) - b**3 * np.sin(b),
        )
        other = (
            np.sinh(a) / a - np.sin(b) / b,
            a * np.sinh(a) + b * np.sin(b),
            a**2 * np.cosh(a) + b**2 * np.cos(b),
        )
        return first[1] * (other[2] + square * other[0]) - other[1] * (first[2] + square * first[0])

    def least(load):  # two roots, of opposite signs between, until they meet
        signs = [
            determinant(load, square) * np.sign(determinant(1.0, 0.1))
            for square in np.linspace(1.0, 300.0, 3000)
        ]
        return min(signs)

    along = column()
    along.distributed_force("beam", (0, 0, -1.0), following=True)
    assert along.stability(band=(36.0, 44.0), count=3).limits[0].at == pytest.approx(40.05, rel=2e-4)
    tip = column()
    tip.add("tip", vr.Body(1.0, (0, 0, 0), centre=(1, 0, 0)))
    tip.attach("beam.end", "tip")
    tip.force("beam.end", (0, 0, -1.0), following=True)
    assert tip.stability(band=(14.0, 18.0), count=3).limits[0].at == pytest.approx(
        brentq(least, 14.0, 18.0, xtol=1e-6), rel=2e-5
    )


def test_a_buckled_strip_vibrates_as_nayfeh_says() -> None:
    """Nayfeh, Kreider and Anderson 1995 (Ritz): ``EI w_xxxx + P w_xx = EA/L psi_xx int psi_xx w``, P at buckling.

    Its shape is ``psi = b/2 (1 - cos 2 pi x/L)``; the shortening is that of the rise and of the pressing.
    """
    b, h, L, rise, E, density = 0.02, 0.001, 0.5, 0.002, 2e11, 7850.0
    A, EI = b * h, E * b * h**3 / 12.0
    pushed = 4.0 * np.pi**2 * EI / (E * A * L) + (np.pi * rise) ** 2 / (4.0 * L)
    strip = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (L, 0, 0), d1=(0, 1, 0), section=vr.Rectangle(b, h), material=STEEL)
    strip.add("strip", rod)
    strip.clamp("strip.start")
    strip.clamp("strip.end", motion={"ux": -pushed})
    buckled = strip.equilibrium()
    assert buckled.displacement("strip@0.25")[2] == pytest.approx(rise, rel=1e-4)
    found = strip.modes(3, about=buckled)

    x, weights = np.polynomial.legendre.leggauss(60)
    x, weights, k = 0.5 * (x + 1.0), 0.5 * weights, np.arange(12)
    legendre = [np.polynomial.Legendre.basis(int(j), domain=[0, 1]) for j in k]
    bubble = np.polynomial.Polynomial([0, 0, 1, -2, 1])  # x^2 (1 - x)^2
    shapes = [bubble * one.convert(kind=np.polynomial.Polynomial) for one in legendre]
    w, slope, bend = (np.array([one.deriv(m)(x) if m else one(x) for one in shapes]) for m in range(3))
    own = 0.5 * rise * (2.0 * np.pi / L) ** 2 * np.cos(2.0 * np.pi * x)
    stretch = (own * weights) @ w.T * L
    stiffness = (
        EI / L**3 * (bend * weights) @ bend.T - 4.0 * np.pi**2 * EI / L**3 * (slope * weights) @ slope.T
    )
    stiffness += E * A / L * np.outer(stretch, stretch)
    squares = eigh(stiffness, density * A * L * (w * weights) @ w.T, eigvals_only=True)
    assert found.frequencies == pytest.approx(np.sqrt(squares[:3]) / (2.0 * np.pi), rel=3e-4)


def test_a_truss_snaps_under_a_sudden_load_below_its_limit_load() -> None:
    """Hoff and Bruce 1954: a load that appears at once snaps it if its work passes the hump of the elastic energy."""
    EA, width, height = 1e6, 1.0, 0.1
    length = np.hypot(width, height)
    hump = minimize_scalar(
        lambda v: -EA * (np.hypot(width, height - v) - length) ** 2 / (2.0 * length * v),
        bounds=(1e-4, height),
    )
    section = vr.StiffnessSection([1e6, 1e6, EA, 1e3, 1e3, 1e3], [1e-6, 1e-6, 1e-6, 1e-9, 1e-9, 2e-9])
    for part, snaps in ((0.99, False), (1.01, True)):
        truss = vr.Model()
        truss.add("bar", vr.Rod.straight((0, 0, 0), (width, height, 0), section=section, elements=1, order=1))
        truss.support("bar.start", ("ux", "uy", "uz", "rx", "ry"))
        truss.support("bar.end", ("ux", "uz", "rx", "ry"))
        truss.add("mass", vr.Body(1.0, (0, 0, 0), centre=(width, height, 0)))
        truss.attach("bar.end", "mass")
        truss.force("bar.end", (0, part * hump.fun, 0))
        sunk = -truss.simulate(0.2, initial="reference").history("bar.end", "displacement").values[:, 1]
        assert bool(sunk.max() > height) is snaps
        if not snaps:
            assert sunk.max() < hump.x


def test_a_string_that_is_stretched_and_spun_whirls() -> None:
    """Seen on the string waves of the speed c have ``n pi c/L +- W``; an end that is moved pulls it, at rest, too."""
    T, L, mass, EA, speed = 100.0, 2.0, 0.01, 1e6, 200.0
    section = vr.StiffnessSection([EA / 2, EA / 2, EA, 0, 0, 0], [mass] * 3 + [1e-9, 1e-9, 2e-9])
    model = vr.Model()
    model.add("string", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=section))
    model.pin("string.start")
    model.support("string.end", ("uy", "uz"), motion={"ux": T / EA * L})
    longer = L * (1.0 + T / EA)
    wave = np.pi * np.sqrt(T * longer / (mass * L)) / longer
    spun = model.steady(spin=(speed, 0, 0))
    expected = np.sort(np.abs([wave - speed, wave + speed, 2.0 * wave - speed, 3.0 * wave - speed]))
    found = 2.0 * np.pi * np.asarray(spun.frequencies)
    assert found[found > 1e-3 * speed][:4] == pytest.approx(expected, rel=1e-4)
    assert float(spun.data["reaction"].sel(support="string.end", motion="fx").values[-1]) == pytest.approx(
        T, rel=1e-9
    )
    diagram = model.campbell(axis=(1, 0, 0), band=(0.0, speed), count=3, modes=2)
    assert [one.speed for one in diagram.critical_speeds] == pytest.approx([0.5 * wave, wave], rel=1e-4)


SHAKEN = ((0.01, np.sqrt(1.5 * 9.81 / 0.5) / np.pi, 0.01), (np.pi - 0.1, 60.0, 0.02))
"""Angle from hanging, frequency [Hz] and amplitude [m] of the pivot."""


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of the axial force that the start sets off
@pytest.mark.parametrize(("angle", "hertz", "size"), SHAKEN)
def test_a_shaken_pendulum_grows_as_mathieu_and_stands_as_kapitza_say(
    angle: float, hertz: float, size: float
) -> None:
    """A bar whose pivot goes up and down: the equation of the rigid pendulum, integrated by another method.

    Hanging and shaken at twice its frequency its swing grows; standing upside down and shaken fast it stays there.
    """
    length, radius, omega = 0.5, 0.004, 2.0 * np.pi * hertz
    # so stiff that its bending, which the equation leaves out, turns it by 5e-6 only
    material = vr.Material(2e15, poissons_ratio=0.3, density=7850.0)
    end = (length * np.sin(angle), 0, -length * np.cos(angle))
    model = vr.Model()
    model.add(
        "bar",
        vr.Rod.straight((0, 0, 0), end, section=vr.Circle(radius), material=material, elements=1, order=3),
    )
    pivot = vr.Sine(hertz, amplitude=size, phase=np.pi / 2, offset=-size)
    model.support("bar.start", fixed=["ux", "uy", "rx", "rz"], motion={"uz": pivot})
    model.gravity()
    duration = min(15.0, 60.0 / hertz)
    run = model.simulate(duration, initial="reference", output_interval=duration / 100, tolerance=1e-6)
    along = run.history("bar.end").values - run.history("bar.start").values
    found = np.unwrap(np.arctan2(along[:, 0], -along[:, 2]))
    inertia = length**2 / 3.0 + radius**2 / 4.0

    def rates(t: float, y: np.ndarray) -> list[float]:
        lift = 9.81 - size * omega**2 * np.cos(omega * t)
        return [y[1], -0.5 * length * lift * np.sin(y[0]) / inertia]

    exact = solve_ivp(
        rates, (0.0, duration), [angle, 0.0], "DOP853", t_eval=run.time, rtol=1e-11, atol=1e-13
    ).y[0]
    assert np.abs(found - exact).max() < max(3.0 * run.step_errors["rotation"], 1e-5)
    if hertz > 10.0:  # (size omega)^2 > 4/3 g length keeps it up
        assert np.abs(exact - np.pi).max() < 0.2
    else:
        assert np.abs(exact).max() > 4.0 * angle

"""Campbell diagrams against closed forms: Jeffcott's rotor with damping that turns, a disc's couples, blades on a hub.

Jeffcott's rotor with viscous damping of the shaft c_i, which turns with it, and of the surroundings c_e obeys in space
``m z'' + (c_e + c_i) z' + (k - i W c_i) z = 0`` (Genta, Dynamics of Rotating Systems, 2005, 3.4): it whirls by itself
beyond ``W = w (1 + c_e/c_i)``. Blades: the integral equation of a rotating Euler-Bernoulli beam by polynomials, which
gives the published numbers of Wright et al. (1982) with hub radius 0.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.pictures import written
from helpers.plain_text import flat
from viscorod import programs

EI, LENGTH, MASS, TAU, OUTSIDE = 100.0, 1.0, 3.0, 2e-3, 0.3
SPRING = 48.0 * EI / LENGTH**3


def bare(EI, tau=0.0):
    """A section that bends, and neither shears nor has inertia worth mentioning."""
    stiffness = np.array([1.0, 1.0, 1.0, EI, EI, 1e3 * EI])
    damping = list(tau * stiffness) if tau else None
    return vr.StiffnessSection(stiffness, [1e-9] * 3 + [1e-15] * 3, damping=damping)


def jeffcott():
    model = vr.Model()
    for name, start in (("left", 0.0), ("right", 0.5)):
        half = vr.Rod.straight(
            (start, 0, 0),
            (start + 0.5, 0, 0),
            section=bare(EI, TAU),
            elements=1,
            order=3,
            constraints="kirchhoff",
        )
        model.add(name, half)
    model.add("disc", vr.Body(MASS, (0.02, 0.01, 0.01), centre=(0.5, 0, 0)))
    model.attach("left.end", "disc")
    model.attach("right.start", "disc")
    model.support("left.start", ("ux", "uy", "uz", "rx"))
    model.support("right.end", ("uy", "uz"))
    model.spring("disc", damping={"uy": OUTSIDE, "uz": OUTSIDE})
    return model


def jeffcott_roots(speed):
    """Roots in space: with the spin, against it."""
    inside = SPRING * TAU
    found = np.roots([MASS, OUTSIDE + inside, SPRING - 1j * speed * inside])
    return found[np.argsort(-found.imag)]


@pytest.fixture(scope="module")
def rotor():
    return jeffcott().campbell((1, 0, 0), band=(0.0, 100.0), count=6, modes=4, frame="space")


def test_whirl_of_jeffcotts_rotor(rotor):
    """Both whirls at all speeds: frequency, damping ratio, direction."""
    for k, speed in enumerate(rotor.speeds):
        for way, root in zip((1.0, -1.0), jeffcott_roots(speed), strict=True):
            if speed == 0.0:
                mode = 0
            else:
                (mode,) = np.flatnonzero(np.abs(rotor.whirl[k, :2] - way) < 1e-6)
            assert rotor.frequencies[k, mode] == pytest.approx(abs(root.imag) / (2.0 * np.pi), rel=1e-7)
            assert rotor.damping_ratios[k, mode] == pytest.approx(-root.real / abs(root), abs=1e-8)
    assert (rotor.whirl[0] == 0.0).all()
    assert rotor.data["likeness"].values.min() > 0.99


def test_an_error_that_vanishes_is_told_as_rounding():
    """A standing shaft, alike all around, whose errors at one of its critical speeds come to 0: 0 is for unknown."""
    from viscorod.analyses.followed import ROUNDING

    steel = vr.Material(2.1e11, 0.3, 7850.0)
    model = vr.Model()
    shaft = vr.Rod.straight((0, 0, 0), (0, 0, 0.8), section=vr.Circle(5e-3), material=steel)
    model.add("shaft", shaft)
    model.support("shaft.start", ("ux", "uy", "uz"))
    model.support("shaft.end", ("ux", "uy"))
    model.gravity()
    found = model.campbell(axis=(0, 0, 1), band=(0.0, 400.0), count=5, frame="space", modes=4)
    slow = np.pi**2 / 0.8**2 * np.sqrt(2.1e11 * 0.005**2 / 4 / 7850.0)  # without its own weight
    assert [one.speed for one in found.critical_speeds] == pytest.approx([slow, slow], rel=2e-3)
    assert min(one.mesh_error for one in found.critical_speeds) >= ROUNDING


def test_limit_of_jeffcotts_rotor(rotor):
    """Internal damping makes it whirl beyond w (1 + c_e/c_i): found to 1e-8 between speeds 20 rad/s apart."""
    (limit,) = rotor.limits
    natural = np.sqrt(SPRING / MASS)
    assert limit.at == pytest.approx(natural * (1.0 + OUTSIDE / (SPRING * TAU)), rel=1e-8)
    assert (limit.kind, limit.unstable) == ("flutter", True)
    assert limit.frequency == pytest.approx(natural / (2.0 * np.pi), rel=1e-8)
    assert limit.mesh_error < 1e-8
    assert "begins: flutter" in flat(rotor.report())


def test_critical_speed_of_jeffcotts_rotor(rotor):
    """Where Im s of a whirl is the speed, with damping: closed form in both directions."""
    from scipy.optimize import brentq

    for number, sign in ((0, 1.0), (1, -1.0)):
        expected = brentq(
            lambda w, n=number, g=sign: g * jeffcott_roots(w)[n].imag - w, 30.0, 50.0, xtol=1e-13
        )
        gap = min(abs(one.speed / expected - 1.0) for one in rotor.critical_speeds)
        assert gap < 1e-8
    assert len(rotor.critical_speeds) == 2
    assert all(one.mesh_error > 0.0 for one in rotor.critical_speeds)  # 0 would say that it is not known


def test_critical_speeds_of_an_overhung_disc():
    """Two complex coordinates with the couples of the disc: ``w^2 M - w W G - K`` vanishes at w = n W."""
    L, EI, mass, radius = 0.5, 2000.0, 8.0, 0.15
    across, polar = 0.25 * mass * radius**2 + 0.01, 0.5 * mass * radius**2
    K = EI / L**3 * np.array([[12.0, -6.0 * L], [-6.0 * L, 4.0 * L**2]])
    expected = []
    for order in (1.0, 2.0):
        for way in (1.0, -1.0):  # the disc's couple is polar W w: inertia less or more than without
            inertia = np.diag([mass, across - way * polar / order])
            squares = np.linalg.eigvals(np.linalg.solve(inertia, K))
            expected += list(np.sqrt(squares[squares > 0.0].real) / order)
    expected = np.sort([w for w in expected if w < 500.0])
    model = vr.Model()
    shaft = vr.Rod.straight(
        (0, 0, 0), (L, 0, 0), section=bare(EI), elements=1, order=3, constraints="kirchhoff"
    )
    model.add("shaft", shaft)
    model.clamp("shaft.start")
    model.add("disc", vr.Body(mass, (polar, across, across), centre=(L, 0, 0)))
    model.attach("shaft.end", "disc")
    found = model.campbell(
        (1, 0, 0), band=(0.0, 500.0), count=11, modes=4, frame="space", engine_orders=(1, 2)
    )
    speeds = np.sort([one.speed for one in found.critical_speeds])
    assert speeds == pytest.approx(expected, rel=1e-7)
    assert not found.limits
    waves = found.whirl[1:]
    assert np.abs(np.abs(waves) - 1.0).max() < 1e-9
    assert np.abs(waves.sum(axis=1)).max() < 1e-9


def galerkin(hub, speed, count=14, taper=0.0):
    """Flap frequencies of a blade of unit length, by polynomials that are clamped at the root.

    Mass per length and bending stiffness are 1 at the root and less by a part ``taper`` at the tip, in between linear.
    """
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    basis = [
        np.polynomial.Polynomial.fromroots([0.0, 0.0])
        * np.polynomial.Legendre.basis(k, [0, 1]).convert(kind=np.polynomial.Polynomial)
        for k in range(count)
    ]
    V, D, S = (np.array([p.deriv(n)(x) if n else p(x) for p in basis]) for n in (0, 1, 2))
    pull = (np.polynomial.Polynomial([hub, 1.0]) * np.polynomial.Polynomial([1.0, -taper])).integ()
    tension, size = speed**2 * (pull(1.0) - pull(x)), 1.0 - taper * x
    from scipy.linalg import eigh

    stiffness = (S * (w * size)) @ S.T + (D * (w * tension)) @ D.T
    return np.sqrt(eigh(stiffness, (V * (w * size)) @ V.T, eigvals_only=True))


def blade(hub=0.0, bending=(1.0, 25.0)):
    """A slender blade of unit length, mass and stiffness against flapping; neither shear nor stretch."""
    section = vr.StiffnessSection([1.0, 1.0, 1.0, *bending, 400.0], [1, 1, 1, 1e-8, 1e-8, 2e-8])
    model = vr.Model()
    rod = vr.Rod.straight(
        (hub, 0, 0),
        (hub + 1.0, 0, 0),
        d1=(0, 1, 0),
        section=section,
        elements=4,
        order=4,
        constraints="kirchhoff",
    )
    model.add("blade", rod)
    model.clamp("blade.start")
    return model


def test_blade_of_the_literature():
    """Wright et al. 1982, hub radius 0: flap frequencies at five speeds; in-plane squares are less by the speed's."""
    table = {
        1.0: (3.68165, 22.18101),
        2.0: (4.13732, 22.61492),
        4.0: (5.58500, 24.27335),
        8.0: (9.25684, 29.99538),
        12.0: (13.17015, 37.60311),
    }
    found = blade().campbell((0, 0, 1), speeds=list(table), modes=4, engine_orders=(1, 2, 3))
    for speed, own in zip(table, 2.0 * np.pi * found.frequencies, strict=True):
        for flap in table[speed]:
            assert np.abs(own - flap).min() < 2e-5 * flap
    assert not found.limits


@pytest.mark.parametrize("hub", [0.5, 2.0])
def test_blade_on_a_hub(hub):
    """Flap frequencies by polynomials, and the speed at which the first is three times the speed."""
    from scipy.optimize import brentq

    found = blade(hub).campbell((0, 0, 1), band=(0.0, 6.0), count=7, modes=4, engine_orders=(3,))
    for speed, own in zip(found.speeds, 2.0 * np.pi * found.frequencies, strict=True):
        for flap in galerkin(hub, speed)[:2]:
            assert np.abs(own - flap).min() < 1e-5 * flap
    expected = brentq(lambda w: galerkin(hub, w)[0] - 3.0 * w, 0.1, 6.0)
    first = min(found.critical_speeds, key=lambda one: abs(one.speed - expected))
    assert first.speed == pytest.approx(expected, rel=1e-5)
    assert first.frequency == pytest.approx(3.0 * first.speed / (2.0 * np.pi), rel=1e-12)


def blade_file(path, taper):
    """A BeamDyn blade file of two stations: flapping as in ``galerkin``, all else stiff."""

    def rows(matrix):
        return "\n".join(" ".join(f"{value:.9E}" for value in row) for row in matrix)

    head = "BLADE\ntitle\n---\n2 station_total\n0 damp_type\n---\nmu1 to mu6\n(-)\n0 0 0 0 0 0\n---\n"
    text = head
    for at, part in ((0.0, 1.0), (1.0, 1.0 - taper)):
        stiffness = np.diag([1e6, 1e6, 1e6, 25.0, 1.0, 400.0]) * part
        inertia = np.diag([1.0, 1.0, 1.0, 1e-7, 1e-7, 2e-7]) * part
        text += f" {at:.6f}\n{rows(stiffness)}\n\n{rows(inertia)}\n\n"
    path.write_text(text)
    return path


def test_tapered_blade_of_a_file_on_a_hub(tmp_path):
    """A file of the public format, its blade along +Z from the edge of a hub: flap frequencies by polynomials."""
    hub, taper = 0.3, 0.6
    file = blade_file(tmp_path / "blade.dat", taper)
    line = [(0.0, 0.0, hub), (0.0, 0.0, hub + 1.0)]
    model = vr.Model()
    model.add("blade", programs.rod_from_blade(file, line, elements=5, order=4))
    model.clamp("blade.start")
    found = model.campbell((1, 0, 0), speeds=[0.0, 3.0, 6.0], modes=3)
    for speed, own in zip(found.speeds, 2.0 * np.pi * found.frequencies, strict=True):
        for flap in galerkin(hub, speed, taper=taper)[:2]:
            assert np.abs(own - flap).min() < 1e-4 * flap
    # with a swept tip, the same roots as those of the steady rotation, which are found in another way
    swept = [(0.0, 0.3 * max(z - 0.5, 0.0) ** 2, hub + z) for z in np.linspace(0.0, 1.0, 9)]
    other = vr.Model()
    other.add("blade", programs.rod_from_blade(file, swept, elements=5, order=4))
    other.clamp("blade.start")
    roots = other.campbell((1, 0, 0), speeds=[3.0, 6.0], modes=4).eigenvalues[1]
    steady = other.steady(spin=(6.0, 0, 0), modes=4).eigenvalues
    assert np.sort(np.abs(roots)) == pytest.approx(np.sort(np.abs(steady)), rel=1e-6)
    assert np.abs(roots[0]) != pytest.approx(2.0 * np.pi * found.frequencies[2, 0], rel=1e-4)


def test_modes_that_cross_and_modes_that_veer():
    """Flap and lag do not know each other and cross; with the blade set at an angle they are coupled and veer."""
    straight = blade(bending=(1.0, 1.6)).campbell((0, 0, 1), band=(0.0, 8.0), count=9, modes=2)
    assert [one.crosses for one in straight.meetings] == [True]
    model = vr.Model()
    section = vr.StiffnessSection([1.0, 1.0, 1.0, 1.0, 1.6, 400.0], [1, 1, 1, 1e-8, 1e-8, 2e-8])
    d1 = (0.0, np.cos(0.1), np.sin(0.1))
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), d1=d1, section=section, elements=4, order=4, constraints="kirchhoff"
    )
    model.add("blade", rod)
    model.clamp("blade.start")
    pitched = model.campbell((0, 0, 1), band=(0.0, 8.0), count=9, modes=2)
    (meeting,) = pitched.meetings
    assert not meeting.crosses
    assert meeting.gap > 0.0
    assert "veer" in pitched.report()
    order = np.argsort(pitched.eigenvalues.imag, axis=1)
    assert (order == order[0]).all()
    crossed = np.argsort(straight.eigenvalues.imag, axis=1)
    assert (crossed[0] != crossed[-1]).all()


def test_maxwell_branches_turn_with_a_shaft():
    """A thin shaft all of whose strains relax alike: ``(s + i W)^2 + w^2 M*(s)/M_inf = 0`` in the turning frame."""
    ratios, times = (0.3, 0.5), (0.05, 0.5)
    C = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    branches = [vr.MaxwellBranch(time=t, stiffness=g * C) for g, t in zip(ratios, times, strict=True)]
    section = vr.StiffnessSection(C, [1, 1, 1, 1e-8, 1e-8, 2e-8], branches=branches)
    model = vr.Model()
    model.add(
        "shaft",
        vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=5, constraints="kirchhoff"),
    )
    model.clamp("shaft.start")
    found = model.campbell((1, 0, 0), speeds=[1.0, 3.0, 5.0], modes=2)
    w = 3.516015268682
    for speed, own in zip(found.speeds, found.eigenvalues, strict=True):
        for s in own:
            loss = 1.0 + sum(g * s * t / (1.0 + s * t) for g, t in zip(ratios, times, strict=True))
            gaps = [abs((s + way * 1j * speed) ** 2 + w**2 * loss) for way in (1.0, -1.0)]
            assert min(gaps) < 1e-4 * w**2
    (limit,) = found.limits
    assert limit.at == pytest.approx(w, rel=1e-5)  # damping that turns: unstable beyond the critical speed


def test_a_free_rod_that_spins():
    """That it drifts, at the spin itself as seen on it, is no vibration; both whirls are the free bending, split."""
    section = vr.StiffnessSection([1.0] * 6, [1, 1, 1, 1e-5, 1e-5, 2e-5])
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=4, constraints="kirchhoff")
    model.add("rod", rod)
    found = model.campbell((1, 0, 0), speeds=[1.0, 30.0, 50.0], modes=3, frame="space")
    assert [one.speed for one in found.critical_speeds] == pytest.approx([22.3733] * 2, rel=2e-3)
    assert not found.limits
    assert not found.warnings
    assert 2.0 * np.pi * found.frequencies[:, 1:].mean(axis=1) == pytest.approx([22.3733] * 3, rel=2e-3)


def test_the_modes_are_those_of_the_steady_rotation():
    """A blade with a swept tip: roots of both analyses, which are found in different ways."""
    from viscorod.casefile.case import load_case
    from viscorod.casefile.shipped import shipped_case

    model = load_case(shipped_case("swept_blade")).model(vr.Model)
    found = model.campbell((0, 0, 1), speeds=[30.0, 60.0], modes=6)
    for speed, roots in zip(found.speeds, found.eigenvalues, strict=True):
        steady = model.steady(spin=(0, 0, speed), modes=6).eigenvalues
        assert np.sort(np.abs(roots)) == pytest.approx(np.sort(np.abs(steady)), rel=1e-7)


def test_what_a_diagram_refuses():
    with pytest.raises(vr.InputError, match="goes round the axis both ways"):
        blade().campbell((0, 0, 1), band=(1.0, 4.0), count=3, modes=2, frame="space")
    model = blade()
    model.force("blade.end", (0, 1.0, 0))
    with pytest.raises(vr.InputError, match="not parallel to the axis"):
        model.campbell((0, 0, 1), band=(1.0, 4.0))
    with pytest.raises(vr.InputError, match="give speeds"):
        blade().campbell((0, 0, 1))
    with pytest.raises(vr.InputError, match="increase"):
        blade().campbell((0, 0, 1), speeds=[2.0, 1.0])


def test_a_diagram_is_kept_drawn_and_told(rotor, tmp_path):
    again = vr.load(rotor.save(tmp_path / "campbell.nc"))
    assert isinstance(again, vr.Campbell)
    assert again.report() == rotor.report()
    assert again.critical_speeds == rotor.critical_speeds
    table = rotor.save_csv(tmp_path / "campbell.csv").read_text(encoding="utf-8").splitlines()
    assert table[0].startswith("speed [rad/s],")
    assert len(table) == 1 + len(rotor.speeds)
    assert written(rotor.plot, tmp_path / "campbell.png").stat().st_size > 10_000
    picture = rotor.plot()
    picture.canvas.draw()
    (turns,) = picture.axes[-1].child_axes  # under that in rad/s
    assert turns.get_xlabel() == "[rpm]"
    assert turns.get_xlim() == pytest.approx(rotor.speeds[[0, -1]] * 30.0 / np.pi)
    with pytest.raises(vr.InputError, match="no Campbell diagram"):
        vr.Campbell(rotor.data.drop_vars("whirl"))


def test_a_shaft_whose_frequencies_are_those_on_it_is_told_where_its_unbalance_excites():
    """A pinned shaft of EI = rhoA = L = 1 is in resonance with its unbalance at pi^2, seen from outside.

    Seen on it that is a frequency of 0; its frequency is the speed at half of that, where nothing that turns excites.
    """
    section = vr.StiffnessSection([1e8] * 3 + [1.0] * 3, [1.0, 1.0, 1.0, 1e-8, 1e-8, 2e-8])
    model = vr.Model()
    model.add("shaft", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    model.support("shaft.start", ("ux", "uy", "uz", "rx"))
    model.support("shaft.end", ("uy", "uz"))
    settings = {"axis": (1, 0, 0), "band": (0.0, 15.0), "count": 5, "modes": 2}
    on_it = model.campbell(**settings)
    assert on_it.critical_speeds[0].speed == pytest.approx(np.pi**2 / 2.0, rel=1e-4)
    assert any("unbalance" in text and "frame = 'space'" in text for text in on_it.warnings)
    outside = model.campbell(**settings, frame="space")
    assert [one.speed for one in outside.critical_speeds] == pytest.approx([np.pi**2] * 2, rel=1e-4)
    for found in (
        outside,
        model.campbell(**settings, frame="turning"),
        blade().campbell((0, 0, 1), speeds=[2.0, 3.0]),
    ):
        assert not any("unbalance" in text for text in found.warnings)

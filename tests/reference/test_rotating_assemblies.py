"""Steady rotations of assemblies against closed forms: hinged blades, overhung discs, held strains, branches.

Closed forms: W. Johnson, Helicopter Theory (1980), 5-1 and 5-19: flap and lag of a rigid hinged blade; the overhung
disc is the textbook rotor of Jeffcott with gyroscopic couples (Genta, Dynamics of Rotating Systems, 2005, 2.6); a thin
rod all of whose strains relax alike obeys ``(s + i W)^2 + w^2 M*(s)/M_inf = 0`` in the turning frame.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

SPIN, OFFSET = 10.0, 0.2
RIGID = vr.StiffnessSection([1e6] * 3 + [1e6] * 3, [1.0, 1.0, 1.0, 1e-8, 1e-8, 2e-8])


def slowest(model, spin, count=1):
    """Return the angular frequencies of the slowest small motions [rad/s]."""
    found = model.steady(spin=spin, modes=max(count, 2))
    assert found.stable
    return 2.0 * np.pi * found.frequencies[:count]


def hinged(axis, to="hub", **more):
    """A stiff blade from the hinge to 1 m, on an arm of a clamped hub, or on the ground, which turns with the model."""
    model = vr.Model()
    model.add(
        "blade",
        vr.Rod.straight(
            (OFFSET, 0, 0), (1, 0, 0), section=RIGID, elements=1, order=3, constraints="kirchhoff"
        ),
    )
    if to == "hub":
        model.add("hub", vr.Body.box((0.1, 0, 0), (0.2, 0.1, 0.1), 1000.0, points={"hinge": (OFFSET, 0, 0)}))
        model.clamp("hub")
        to = "hub.hinge"
    model.revolute("blade.start", to, axis, **more)
    return model


@pytest.mark.parametrize("to", ["hub", "ground"])
def test_flap_and_lag_of_a_hinged_blade(to):
    """Closed form: ``1 + 3/2 e/(1 - e)`` and ``3/2 e/(1 - e)``, squares over that of the spin."""
    lag = 1.5 * OFFSET / (1.0 - OFFSET)
    (flap,) = slowest(hinged((0, 1, 0), to), (0, 0, SPIN))
    assert (flap / SPIN) ** 2 == pytest.approx(1.0 + lag, rel=5e-6)
    (found,) = slowest(hinged((0, 0, 1), to), (0, 0, SPIN))
    assert (found / SPIN) ** 2 == pytest.approx(lag, rel=5e-5)


def test_spring_and_damper_at_a_hinge():
    """Closed form: the spring adds ``k/I`` to the square of the flap frequency, the damper is ``c/I``."""
    k, c, inertia = 50.0, 0.3, (1.0 - OFFSET) ** 3 / 3.0
    square = SPIN**2 * (1.0 + 1.5 * OFFSET / (1.0 - OFFSET)) + k / inertia
    inside = hinged((0, 1, 0), stiffness={"rz": k}, damping={"rz": c})
    beside = hinged((0, 1, 0))
    beside.spring("blade.start", "hub.hinge", stiffness={"ry": k}, damping={"ry": c})
    for model in (inside, beside):
        found = model.steady(spin=(0, 0, SPIN), modes=2).eigenvalues[0]
        assert abs(found) ** 2 == pytest.approx(square, rel=2e-5)
        assert -2.0 * found.real == pytest.approx(c / inertia, rel=2e-5)


def test_a_motor_holds_its_angle():
    """Closed form: a blade of length l raised by an angle b asks for ``W^2 sin b (e l^2/2 + cos b l^3/3)``."""
    angle, length = 0.3, 1.0 - OFFSET
    found = hinged((0, 1, 0), motion={"rz": angle}, name="hinge").steady(spin=(0, 0, SPIN))
    assert abs(found.position("blade.end")[2]) == pytest.approx(length * np.sin(angle), rel=1e-4)
    hinge = found.joint("hinge").sel(motion="rz")
    assert float(hinge["value"][0]) == pytest.approx(angle, abs=1e-9)
    moment = SPIN**2 * np.sin(angle) * (OFFSET * length**2 / 2.0 + np.cos(angle) * length**3 / 3.0)
    assert abs(float(hinge["force"][0])) == pytest.approx(moment, rel=1e-4)


@pytest.mark.parametrize("spin", [100.0, 400.0])
def test_whirl_of_an_overhung_disc(spin):
    """Closed form: two complex coordinates, ``[[12, -6 L], [-6 L, 4 L^2]] EI/L^3``, and the gyroscopic couple."""
    L, EI, mass, radius = 0.5, 2000.0, 8.0, 0.15
    across, polar = 0.25 * mass * radius**2 + 0.01, 0.5 * mass * radius**2
    K = EI / L**3 * np.array([[12.0, -6.0 * L], [-6.0 * L, 4.0 * L**2]])
    none, inertia = np.zeros((2, 2)), np.diag([mass, across])
    A = np.block(
        [[none, np.eye(2)], [-np.linalg.solve(inertia, K), np.diag([0.0, 1j * polar * spin / across])]]
    )
    in_space = (np.linalg.eigvals(A) / 1j).real
    section = vr.StiffnessSection([1.0] * 3 + [EI, EI, 1e5], [1e-6, 1e-6, 1e-6, 1e-12, 1e-12, 2e-12])
    model = vr.Model()
    shaft = vr.Rod.straight(
        (0, 0, 0), (L, 0, 0), section=section, elements=1, order=4, constraints="kirchhoff"
    )
    model.add("shaft", shaft)
    model.clamp("shaft.start")
    model.add("disc", vr.Body(mass, (polar, across, across), centre=(L, 0, 0)))
    model.attach("shaft.end", "disc")
    found = 2.0 * np.pi * model.steady(spin=(spin, 0, 0), modes=6).frequencies
    for whirl in np.abs(in_space - spin):
        assert np.abs(found - whirl).min() < 2e-6 * whirl


def test_held_strains_are_the_limit_of_a_stiff_shaft():
    """The whirls of a shaft on springs: the distance to the Kirchhoff shaft falls as one over the stiffness."""

    def whirls(large, **more):
        section = vr.StiffnessSection([large] * 3 + [1.0, 1.0, 0.8], [1.0, 1.0, 1.0, 0.01, 0.01, 0.02])
        model = vr.Model()
        model.add(
            "shaft", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=6, **more)
        )
        model.support("shaft.start", ("ux", "rx"))
        for end in ("shaft.start", "shaft.end"):
            model.spring(end, stiffness={"uy": 30.0, "uz": 30.0})
        return slowest(model, (3.0, 0, 0), 4)

    limit = whirls(1.0, constraints="kirchhoff")
    errors = [np.abs(whirls(large) - limit).max() for large in (1e3, 1e5)]
    assert errors[1] < 1.1e-2 * errors[0]
    assert errors[1] < 1e-3


@pytest.mark.parametrize(
    ("spin", "formulation"), [(2.0, "geometric"), (8.0, "geometric"), (8.0, "intrinsic")]
)
def test_branches_that_turn_with_a_shaft(spin, formulation):
    """Closed form, and beyond the critical speed the damping that turns with the shaft makes it unstable."""
    ratios, times = (0.3, 0.5), (0.05, 0.5)
    C = np.diag([1e5, 1e5, 1e5, 1.0, 1.0, 1.0])
    branches = [vr.MaxwellBranch(time=t, stiffness=g * C) for g, t in zip(ratios, times, strict=True)]

    def shaft(branches):
        section = vr.StiffnessSection(C, [1, 1, 1, 1e-8, 1e-8, 2e-8], branches=branches)
        model = vr.Model()
        model.add("shaft", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=5))
        model.clamp("shaft.start")
        return model

    w = 2.0 * np.pi * shaft([]).modes(1, about="reference").frequencies[0]
    first, second = (np.array([t, 1.0]) for t in times)
    turned = np.polymul([1.0, 1j * spin], [1.0, 1j * spin])
    whole = np.polyadd(np.polymul(turned, np.polymul(first, second)), w**2 * np.polymul(first, second))
    for g, t, other in zip(ratios, times, (second, first), strict=True):
        whole = np.polyadd(whole, np.polymul([w**2 * g * t, 0.0], other))
    roots = np.roots(whole)
    found = shaft(branches).steady(spin=(spin, 0, 0), modes=4, formulation=formulation)
    both = np.concatenate([found.eigenvalues, found.eigenvalues.conj()])
    for root in roots[np.abs(roots.imag) > np.abs(roots.real)]:
        assert np.abs(both - root).min() < 1e-6 * abs(root)
    assert found.stable == (spin < w)
    assert found.stable == (roots.real.max() < 0.0)


def test_bent_rods_that_relax_and_hold_strains_in_both_formulations():
    """A curved Kirchhoff rod with branches: eigenvalues, section forces and reactions, which share no formula."""
    C = np.diag([1.0, 1.0, 1.0, 1.0, 1.6, 0.8])
    branches = [vr.MaxwellBranch(time=t, stiffness=0.3 * C) for t in (0.05, 0.5)]
    section = vr.StiffnessSection(C, [1, 1, 1, 0.02, 0.05, 0.07], branches=branches)
    arc = (0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2
    model = vr.Model()
    model.add("bow", vr.Rod.arc(*arc, section=section, elements=1, order=7, constraints="kirchhoff"))
    model.clamp("bow.start")
    one, other = (model.steady(spin=(0, 0, 2.0), modes=2, formulation=f) for f in ("geometric", "intrinsic"))
    assert np.abs(one.eigenvalues - other.eigenvalues).max() < 1e-6
    for field in ("section_force", "reaction"):
        gap = np.abs(one.data[field].values - other.data[field].values).max()
        assert gap < 1e-5 * np.abs(one.data[field].values).max()

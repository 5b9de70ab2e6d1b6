"""Responses and linear systems about steady rotations against closed forms, modes, other rotations and motions.

The overhung disc is the textbook rotor of Jeffcott with gyroscopic couples (Genta, Dynamics of Rotating Systems, 2005,
2.6) and with damping that turns (4.2): with the complex coordinate ``z = uy + i uz`` of the turning frame
``M (z'' + 2 i W z' - W^2 z) - i W Jp (z' + i W z) + K (z + tau z') = f``.
"""

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

LENGTH, EI, MASS, RADIUS = 0.5, 2000.0, 8.0, 0.15
ACROSS, POLAR = 0.25 * MASS * RADIUS**2 + 0.01, 0.5 * MASS * RADIUS**2


def overhung(material=None):
    """Return a disc at the end of a shaft of hardly any mass, clamped in what turns."""
    radius = (4.0 * EI / (np.pi * material.youngs_modulus)) ** 0.25
    model = vr.Model()
    model.add(
        "shaft",
        vr.Rod.straight(
            (0, 0, 0),
            (LENGTH, 0, 0),
            section=vr.Circle(radius),
            material=material,
            elements=1,
            order=4,
            constraints="kirchhoff",
        ),
    )
    model.clamp("shaft.start")
    model.add("disc", vr.Body(MASS, (POLAR, ACROSS, ACROSS), centre=(LENGTH, 0, 0)))
    model.attach("shaft.end", "disc")
    return model


def of_the_rotor(omega, spin, modulus):
    """Return deflections along y and z over a force along y (2,), complex, in the turning frame.

    Args:
        modulus: over that at rest, a function of the angular frequency.
    """
    inertia, polar = np.diag([MASS, ACROSS]), np.diag([0.0, POLAR])
    K = EI / LENGTH**3 * np.array([[12.0, -6.0 * LENGTH], [-6.0 * LENGTH, 4.0 * LENGTH**2]])

    def one(w):
        turned = w + spin
        A = -inertia * turned**2 + spin * polar * turned + modulus(w) * K
        return np.linalg.solve(A, [1.0, 0.0])[0]

    ahead, back = one(omega), np.conj(one(-omega))
    return np.array([(ahead + back) / 2.0, (ahead - back) / 2.0j])


@pytest.mark.parametrize("spin", [30.0, 400.0])
def test_overhung_disc(spin):
    """Below and above the critical speed; at 0 Hz it is the answer to an unbalance, which turns along."""
    tau = 2e-4
    material = vr.Material(2.1e11, 0.3, 1e-6, damping=vr.KelvinVoigt(tau, tau))
    model = overhung(material)
    turning = model.steady(spin=(spin, 0, 0))
    settings = {"inputs": "disc fy", "outputs": ["disc uy", "disc uz"], "about": turning}
    hertz = np.array([0.0, 5.0, 18.0, 60.0])
    found = model.frequency_response(**settings, frequencies=hertz)
    exact = [of_the_rotor(2 * np.pi * f, spin, lambda w: 1 + 1j * w * tau) for f in hertz]
    np.testing.assert_allclose(found.values[:, :, 0], exact, rtol=2e-5, atol=1e-6 * np.abs(exact).max())
    assert found.data.attrs["about"] == f"the steady rotation at {spin:g} rad/s, in axes that turn with it"
    system = model.linear(**{k: settings[k] for k in ("inputs", "outputs", "about")})
    np.testing.assert_allclose(system.response(hertz), found.values, rtol=1e-9, atol=1e-18)
    assert abs(system.gyroscopic).max() > 0.0
    assert system.circulatory.nnz == 0
    whole = turning.eigenvalues[turning.eigenvalues.imag > 0.0]
    below = whole[np.abs(whole) < 2 * np.pi * 60.0]
    np.testing.assert_allclose(found.poles[: len(below)], below, rtol=1e-8)


def test_constant_loss_turns_with_the_shaft():
    """E (1 + i eta) in the turning frame, conjugate for motions that turn back."""
    eta, spin = 0.05, 100.0
    damping = vr.LossFactor(extension=eta, band=(1.0, 100.0))
    material = vr.Material(2.1e11, 0.3, 1e-6, damping=damping)
    model, given = overhung(material), material.given_moduli.youngs_modulus / material.youngs_modulus
    found = model.frequency_response(
        inputs="disc fy",
        outputs=["disc uy", "disc uz"],
        frequencies=[5.0, 20.0],
        about=model.steady(spin=(spin, 0, 0)),
    )
    exact = [
        of_the_rotor(2 * np.pi * f, spin, lambda w: given * (1 + 1j * eta * np.sign(w))) for f in (5.0, 20.0)
    ]
    np.testing.assert_allclose(found.values[:, :, 0], exact, rtol=2e-5)
    assert "(1 + 0.05 i) Pa at every frequency" in flat(found.report())


def blade(load=0.0, elements=2, order=3):
    """Return a blade on a hub of 0.2 m, which a force pushes along the axis."""
    rubber = vr.Material(4e7, 0.45, 1100.0, damping=vr.KelvinVoigt(1.2e-2, 1.2e-2))
    model = vr.Model()
    model.add(
        "blade",
        vr.Rod.straight(
            (0.2, 0, 0),
            (0.7, 0, 0),
            section=vr.Rectangle(0.04, 0.03),
            material=rubber,
            elements=elements,
            order=order,
        ),
    )
    model.clamp("blade.start")
    if load:
        model.force("blade.end", (0, 0, load))
    return model


def test_at_rest_in_the_turning_frame_it_is_the_derivative_of_the_rotation():
    """Two rotations under forces along the axis that differ a little."""
    spin, load, step = (0, 0, 12.0), 0.5, 1e-3
    model = blade(load)
    about = model.steady(spin=spin)
    found = model.frequency_response(
        inputs="blade.end fz",
        outputs=["blade.end uz", "blade.end ux", "blade@0.2 section_force bend_1", "blade.start reaction fx"],
        frequencies=[0.0],
        about=about,
    )
    ends = [blade(load + k * step).steady(spin=spin) for k in (-1.0, 1.0)]
    rate = (ends[1].position("blade.end") - ends[0].position("blade.end")) / (2 * step)
    np.testing.assert_allclose(found.values[0, :2, 0], rate[[2, 0]], rtol=1e-6)
    # a stiffer blade than at rest: the centrifugal force holds it
    still = model.frequency_response(inputs="blade.end fz", outputs="blade.end uz", frequencies=[0.0])
    assert abs(found.values[0, 0, 0]) < 0.9 * abs(still.response()[0])
    # the support also holds the centrifugal force of what is pulled in
    assert found.values[0, 3, 0].real > 0.0
    other = blade(load)
    other.rods["blade"] = other.rods["blade"].model_copy(update={"elements": 3})
    moved = other.frequency_response(
        inputs="blade.end fz", outputs="blade.end uz", frequencies=[0.0], about=about
    )
    np.testing.assert_allclose(moved.response(), found.values[:, 0, 0], rtol=1e-4)


def test_a_motion_settles_to_the_response():
    """A blade on a hub that turns, pushed at its tip along and across the plane in which it turns."""
    speed, hertz, push, periods = 12.0, 6.0, 1e-3, 18
    model = blade(elements=1, order=4)
    model.add("hub", vr.Body.box((0, 0, 0), (0.1, 0.1, 0.1), 1000.0, points={"root": (0.2, 0, 0)}))
    model.supports.clear()
    model.attach("blade.start", "hub.root")
    model.clamp("hub")
    about = model.steady(spin=(0, 0, speed))
    load = vr.Force("blade.end", (push, push, 0), following=True)
    found = model.frequency_response(
        inputs=[load], outputs=["blade.end uy", "blade.end uz"], frequencies=[hertz], about=about
    )
    model.supports.clear()
    turns = vr.TimeTable((0.0, 10.0), (0.0, 10.0 * speed))
    model.clamp("hub", motion={"rz": turns})
    model.force("blade.end", (push, push, 0), following=True, time=vr.Sine(hertz))
    run = model.simulate(
        duration=periods / hertz, start=about, output_interval=1 / hertz / 24, tolerance=1e-6
    )
    t, r = run.time[-25:-1], run.history("blade.end", "position").values[-25:-1]
    across = -np.sin(speed * t) * r[:, 0] + np.cos(speed * t) * r[:, 1]
    for k, u in enumerate([across, r[:, 2]]):
        # sin(omega t) is the imaginary part of exp(i omega t)
        size = 2j * np.mean(u * np.exp(-2j * np.pi * hertz * t))
        assert size == pytest.approx(found.values[0, k, 0], rel=3e-3)


def test_what_turns_freely_and_what_cannot_be():
    """A rod that turns freely has no response at 0 Hz; loads that do not turn along are refused by name."""
    model = blade()
    model.supports.clear()
    settings = {"inputs": "blade.end fz", "outputs": "blade.end uz"}
    about = model.steady(spin=20.0, axis=(0, 0, 1))
    found = model.frequency_response(**settings, frequencies=[7.0], about=about)
    assert np.isfinite(found.values).all()
    with pytest.raises(vr.SolveError, match="turning about the axis"):
        model.frequency_response(**settings, frequencies=[0.0, 7.0], about=about)
    held = blade()
    about = held.steady(spin=(0, 0, 5.0))
    held.gravity((0, -9.81, 0))
    with pytest.raises(vr.InputError, match="not parallel to the axis"):
        held.linear(**settings, about=about)


def test_reduced_about_a_rotation():
    """Branches alone damp: round-off of the gyroscopic matrix is no damping; poles are those of the rotation."""
    model = blade()
    model.rods["blade"] = model.rods["blade"].model_copy(
        update={
            "material": vr.Material(4e7, 0.45, 1100.0, damping=vr.LossFactor(extension=0.1, band=(1.0, 10.0)))
        }
    )
    about = model.steady(spin=(0, 0, 12.0))
    found = model.linear("blade.end fz", "blade.end uz", about=about).reduced("modal", 8, band=(0.5, 8.0))
    assert found.passive
    assert found.has_potential
    assert found.error < 1e-4
    np.testing.assert_allclose(found.whole_poles[0], about.eigenvalues[0], rtol=1e-8)


def test_modes_of_what_turns_are_its_own():
    """They are not silently taken about the shape at rest near by."""
    model = blade()
    with pytest.raises(vr.InputError, match=r"Steady\.modes"):
        model.modes(2, about=model.steady(spin=(0, 0, 5.0)))


def test_a_growing_motion_is_told():
    """Damping that turns makes a shaft grow above its critical speed (Kimball 1924): no response is ever reached."""
    material = vr.Material(2.1e11, 0.3, 1e-6, damping=vr.KelvinVoigt(2e-4, 2e-4))
    model = overhung(material)
    settings = {"inputs": "disc fy", "outputs": "disc uy", "frequencies": [60.0]}
    slow, fast = (
        model.frequency_response(**settings, about=model.steady(spin=(w, 0, 0))) for w in (30.0, 400.0)
    )
    assert not any("grows" in text for text in slow.warnings)
    assert any("grows" in text for text in fast.warnings)

"""Campbell diagrams of an overhung disc, of shafts that nothing holds, and of blades that turn slowly."""

import numpy as np
import pytest

import viscorod as vr

STEEL = vr.Material(2.06e11, 0.29, 7850.0)
LIGHT = vr.Material(2.06e11, 0.3, 1e-3)  # next to no mass


def overhung(length: float, mass: float, inertia: tuple[float, float]) -> tuple[vr.Model, float]:
    """Return a disc at the end of a shaft without mass, and the bending stiffness [N m^2]."""
    across, along = inertia
    model = vr.Model()
    shaft = vr.Rod.straight(
        (0, 0, 0),
        (0, 0, length),
        section=vr.Circle(0.01),
        material=LIGHT,
        elements=3,
        constraints="kirchhoff",
    )
    model.add("shaft", shaft)
    model.clamp("shaft.start")
    model.add("disc", vr.Body(mass, (across, across, along), centre=(0, 0, length)))
    model.attach("shaft.end", "disc")
    return model, 2.06e11 * np.pi * 0.02**4 / 64


def test_an_overhung_disc_whirls_as_stodola_and_green_say() -> None:
    """Two complex coordinates, z = x + iy and its slope: M z'' and Id t'' - i Ip W t' with the end stiffness."""
    length, mass, across, along = 0.4, 6.0, 0.03, 0.06
    model, EI = overhung(length, mass, (across, along))
    stiffness = EI * np.array([[12 / length**3, -6 / length**2], [-6 / length**2, 4 / length]])
    diagram = model.campbell(axis=(0, 0, 1), band=(0.0, 600.0), count=5, modes=4, frame="space")

    bending = np.array([not str(name).startswith("twist") for name in diagram.data["mode"].values])
    inertia = np.diag([mass, across])
    below = np.zeros((2, 2))
    for speed, found in zip(diagram.speeds, diagram.frequencies, strict=True):
        gyroscopic = np.diag([0.0, 1j * along * speed / across])
        states = np.block([[below, np.eye(2)], [-np.linalg.solve(inertia, stiffness), gyroscopic]])
        exact = np.abs(np.linalg.eigvals(states).imag) / (2 * np.pi)
        assert np.abs(found[bending][:, None] - exact).min(axis=1) == pytest.approx(
            0.0, abs=1e-6 * exact.max()
        )

    # forward synchronous whirl: det(K - W^2 diag(M, Id - Ip)) = 0; backward with Id + Ip
    def synchronous(moment: float) -> float:
        product = mass * moment
        linear = -(stiffness[0, 0] * moment + stiffness[1, 1] * mass)
        roots = np.roots([product, linear, np.linalg.det(stiffness)])
        return float(np.sqrt(roots[roots > 0.0].min()))

    speeds = [one.speed for one in diagram.critical_speeds if not one.mode.startswith("twist")]
    expected = [synchronous(across + along), synchronous(across - along)]
    assert speeds == pytest.approx(expected, rel=1e-7)
    assert not diagram.limits
    # round-off of the shaft's own vibrations, at 1e7 rad/s, is no growth
    assert [text for text in diagram.warnings if "rod shaft: Young's modulus" not in text] == []


def free_shaft(section: object) -> vr.Model:
    """Return a bar of 1 m that nothing holds."""
    model = vr.Model()
    bar = vr.Rod.straight((-0.5, 0, 0), (0.5, 0, 0), section=section, material=STEEL, elements=3, order=4)
    model.add("bar", bar)
    return model


def first_bending(thickness: float) -> float:
    """Return the slowest angular frequency of a free Euler-Bernoulli bar of 1 m [rad/s]; thickness over sqrt(12)."""
    return 4.730040745**2 * thickness * np.sqrt(2.06e11 / 7850.0)


def test_a_free_bar_of_rectangular_section_diverges_at_its_bending_frequencies() -> None:
    """On the bar the softer bending loses its stiffness at W = w1; before, frequencies fall as w - W."""
    model = free_shaft(vr.Rectangle(0.02, 0.01))
    soft = first_bending(0.01 / np.sqrt(12.0))
    with pytest.raises(vr.InputError, match="begin above 0"):
        model.campbell(axis=(1, 0, 0), band=(0.0, 1.3 * soft), count=5, modes=2)
    diagram = model.campbell(axis=(1, 0, 0), band=(1.0, 1.3 * soft), count=5, modes=2)
    assert [one.kind for one in diagram.limits] == ["divergence"]
    assert diagram.limits[0].at == pytest.approx(soft, rel=1e-3)
    bending = diagram.frequencies[:, 1]
    assert bending[0] == pytest.approx(soft / (2 * np.pi), rel=5e-3)
    assert (np.diff(bending)[:-1] < 0.0).all()  # one mode, never one at rest
    (critical,) = diagram.critical_speeds
    assert 0.5 * soft < critical.speed < soft


@pytest.mark.parametrize("modes", [2, 4])
def test_a_free_round_bar_has_one_critical_speed_on_the_bar(modes: int) -> None:
    """The forward whirl w - W meets the speed W at w/2; rigid motions meet it nowhere, and nothing grows."""
    radius = 0.01
    whirl = first_bending(radius / 2)
    diagram = free_shaft(vr.Circle(radius)).campbell(axis=(1, 0, 0), band=(1.0, whirl), count=5, modes=modes)
    assert [one.speed for one in diagram.critical_speeds] == pytest.approx([0.5 * whirl], rel=1e-3)
    assert not diagram.limits
    (told,) = diagram.warnings  # that it is not the speed at which unbalance excites the bar
    assert "frame = 'space' has them" in told


def test_an_inextensible_blade_of_many_elements_lags_as_its_closed_form_says() -> None:
    """lag^2 = flap^2 - speed^2, flap of Wright et al. (1982); the diagram begins at a speed above 0."""
    length, EI, mass = 2.0, 30.0, 0.7
    section = vr.StiffnessSection([1e7, 1e7, 1e7, 400 * EI, EI, 1e4], [mass] * 3 + [1e-7, 1e-7, 2e-7])
    model = vr.Model()
    blade = vr.Rod.straight(
        (0, 0, 0), (0, length, 0), section=section, d1=(1, 0, 0), elements=8, constraints="kirchhoff"
    )
    model.add("blade", blade)
    model.clamp("blade.start")
    unit = np.sqrt(EI / mass) / length**2
    diagram = model.campbell(axis=(0, 0, 1), speeds=[unit, 4 * unit], modes=1)
    lag = diagram.frequencies[:, 0] * 2 * np.pi / unit
    assert lag == pytest.approx([np.sqrt(3.68165**2 - 1), np.sqrt(5.58500**2 - 16)], rel=1e-5)


@pytest.mark.parametrize("constraints", [(), "kirchhoff"])
def test_a_blade_that_turns_slowly_turns(constraints: object) -> None:
    """Centrifugal forces of 1e-6 N are less than what rounding its positions makes of the forces in a steel strip."""
    model = vr.Model()
    strip = vr.Rod.straight(
        (0, 0, 0),
        (2, 0, 0),
        section=vr.Rectangle(0.05, 0.003),
        material=STEEL,
        elements=4,
        constraints=constraints,
    )
    model.add("strip", strip)
    model.clamp("strip.start")
    slow = model.steady(spin=(0, 0, 1e-4))
    still = model.modes(1, about="reference")
    assert slow.frequencies[0] == pytest.approx(still.frequencies[0], rel=1e-6)

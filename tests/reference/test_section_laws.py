"""Laws of sections beside their matrices, in all analyses: cubic bending against closed forms and linear twins."""

import numpy as np
import pytest

import viscorod as vr

CUBIC, TIME, CURVATURE = 0.3, 0.05, 1.2
MATERIAL = vr.Material(1e9, poissons_ratio=0.3, density=1000.0)
SECTION = vr.Circle(0.01)
C, _, M = SECTION.matrices(MATERIAL)
EI = C[3, 3]
LAW = vr.CubicBending(CUBIC, TIME)
MOMENT = EI * CURVATURE * (1.0 + CUBIC * CURVATURE**2)


def cantilever(law=LAW, **given):
    model = vr.Model()
    given = {"section": SECTION, "material": MATERIAL, "elements": 4, "order": 5} | given
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), law=law, **given))
    model.clamp("beam.start")
    return model


def test_the_law_has_an_energy_and_loses_no_less_than_nothing():
    """Structure: forces at rest are the gradient of the energy, tangents those of forces; power = s.eps_t - dW/dt."""
    rng = np.random.default_rng(1)
    numbers = LAW.parameters(np.diag([1.0, 1.0, 1.0, 2.0, 3.0, 1.0]))

    def respond(strain, rate):
        force, by_strain, by_rate = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6))
        energy, power = LAW.respond(numbers, strain, rate, force, by_strain, by_rate)
        return force, energy, power, by_strain, by_rate

    h = 1e-4
    for strain, rate in rng.normal(size=(20, 2, 6)):
        force, _, power, by_strain, by_rate = respond(strain, rate)
        still = respond(strain, np.zeros(6))[0]
        for k, e in enumerate(h * np.eye(6)):
            ends = [respond(strain + x, rate) for x in (e, -e)]
            assert by_strain[:, k] == pytest.approx((ends[0][0] - ends[1][0]) / (2.0 * h), abs=1e-6)
            assert still[k] == pytest.approx((ends[0][1] - ends[1][1]) / (2.0 * h), abs=1e-6)
            slope = (respond(strain, rate + e)[0] - respond(strain, rate - e)[0]) / (2.0 * h)
            assert by_rate[:, k] == pytest.approx(slope, abs=1e-6)
        assert power == pytest.approx((force - still) @ rate, rel=1e-12)
        assert power > 0.0


@pytest.mark.parametrize("axis", [(0, 1.0, 0), (0, 0.6, -0.8)])
def test_pure_bending(axis):
    """Closed form: M = EI kappa (1 + cubic kappa^2) along a circle, in every direction of a round section."""
    model = cantilever()
    model.moment("beam.end", tuple(MOMENT * np.array(axis)))
    found = model.equilibrium()
    assert np.linalg.norm(found.data["strain"][..., 3:], axis=-1) == pytest.approx(CURVATURE, rel=1e-6)
    ends = np.sin(CURVATURE) / CURVATURE, (1.0 - np.cos(CURVATURE)) / CURVATURE
    x, *across = found.position("beam.end")
    assert (x, np.hypot(*across)) == pytest.approx(ends, rel=1e-8)
    stored = EI * (CURVATURE**2 / 2.0 + CUBIC * CURVATURE**4 / 4.0)
    assert float(found.data["elastic"][-1]) == pytest.approx(stored, rel=1e-6)


@pytest.mark.parametrize("constraints", [(), "kirchhoff"])
def test_pure_bending_from_a_rest_strain(constraints):
    """Closed form: the law counts from the strains at which the rod is free of stress; held strains add nothing."""
    model = cantilever(constraints=constraints)
    model.rest_strain("beam", (0, 0, 0, 0, 0.7, 0))
    model.moment("beam.end", (0, 0, MOMENT))
    found = model.equilibrium()
    bent = found.data["strain"].values[-1, :, 4]
    assert np.abs(bent) == pytest.approx(CURVATURE, rel=1e-6)
    curvature = 0.7 + bent.mean()
    assert found.position("beam.end")[0] == pytest.approx(np.sin(curvature) / curvature, rel=1e-6)


def test_a_path_stiffens():
    """Closed form, at every point of a path: the load is what its curvature asks for."""
    model = cantilever()
    model.moment("beam.end", (0, MOMENT, 0))
    found = model.path(2.0)
    curvature = np.abs(found.data["strain"].values[:, :, 3:]).max(axis=(1, 2))
    load = EI * curvature * (1.0 + CUBIC * curvature**2) / MOMENT
    assert load == pytest.approx(found.load_factor, rel=1e-5, abs=1e-9)
    assert curvature[-1] > CURVATURE


def test_modes_about_a_bent_state():
    """Independent formulation: a linear rod of the same stress and the same tangent has the same complex modes.

    It is naturally curved by what is left of kappa after M/EI_t with EI_t = EI (1 + 3 cubic kappa^2), the tangent in
    the plane of bending; across it the tangent is the secant, EI (1 + cubic kappa^2).
    """
    bent = cantilever()
    bent.moment("beam.end", (0, 0, MOMENT))
    grown, secant = EI * CUBIC * CURVATURE**2 * np.array([3.0, 1.0]), EI * (1.0 + CUBIC * CURVATURE**2)
    stiffness, damping = C.copy(), np.zeros((6, 6))
    # d1 is in the plane of bending, so that bend_2, about d2, is in it
    stiffness[4, 4], stiffness[3, 3] = EI + grown[0], secant
    damping[4, 4], damping[3, 3] = TIME * grown
    natural = CURVATURE - MOMENT / stiffness[4, 4]
    section = vr.StiffnessSection(stiffness, M, damping)
    linear = vr.Model()
    rod = vr.Rod.arc(
        (0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0 / natural, natural, section=section, elements=4, order=5, d1=(0, 1, 0)
    )  # fmt: skip
    assert rod.length == pytest.approx(1.0)
    linear.add("beam", rod)
    linear.clamp("beam.start")
    linear.moment("beam.end", (0, 0, MOMENT))
    found, expected = (model.modes(4, about="equilibrium") for model in (bent, linear))
    assert found.eigenvalues == pytest.approx(expected.eigenvalues, rel=1e-5)
    assert np.all(found.damping_ratios > 1e-3)


def released(**settings):
    model = cantilever(elements=2, order=3)
    model.force("beam.end", (0.5, 4, 6), time=vr.Ramp(0.0, 0.05))
    return model.simulate(0.15, initial="reference", **settings)


def test_the_account_of_a_motion_closes():
    """Conservation law: the midpoint rule creates and destroys no energy; what is lost is what the law dissipates."""
    run = released(integrator="midpoint", time_step=1e-3)
    energy = run.energy
    assert np.abs(energy.numerical).max() < 1e-9 * energy.external.max()
    dissipation = run.data["dissipation"]
    assert dissipation.values.min() >= 0.0
    power = dissipation.values @ run.data["point_weight"].values
    lost = np.trapezoid(power, run.data["time"].values)
    assert energy.viscous[-1] == pytest.approx(lost, rel=2e-3)
    assert energy.viscous[-1] > 0.05 * energy.external.max()


@pytest.mark.parametrize("settings", [{}, {"formulation": "intrinsic"}, {"integrator": "generalized_alpha"}])
def test_formulations_and_integrators_agree(settings):
    """Independent formulations: positions and losses of one motion, against the midpoint rule with small steps."""
    fine, run = released(integrator="midpoint", time_step=2.5e-4), released(tolerance=1e-4, **settings)
    assert run.positions_at(0.15)[-1] == pytest.approx(fine.positions_at(0.15)[-1], abs=1e-3)
    assert run.energy.viscous[-1] == pytest.approx(fine.energy.viscous[-1], rel=5e-3)


def test_steady_rotations():
    """Independent formulations: positions, and body twists and strains; the law is a tenth of the moment or more."""
    found = []
    for formulation in ("geometric", "intrinsic"):
        model = cantilever()
        model.force("beam.end", (0, 0, 9.0), following=True)
        found.append(model.steady(spin=(0, 0, 3.0), formulation=formulation, modes=3))
    one, other = found
    assert one.position("beam.end") == pytest.approx(other.position("beam.end"), rel=1e-6)
    assert float(one.data["elastic"][-1]) == pytest.approx(float(other.data["elastic"][-1]), rel=1e-6)
    assert one.eigenvalues == pytest.approx(other.eigenvalues, rel=1e-5)
    linear = cantilever(None)
    linear.force("beam.end", (0, 0, 9.0), following=True)
    assert linear.steady(spin=(0, 0, 3.0)).position("beam.end")[2] > 1.05 * one.position("beam.end")[2]


def test_what_cannot_take_a_law_says_so():
    model = cantilever()
    for settings in ({"dynamics": "linear", "damping": "linearised"}, {"damping": "linearised"}):
        with pytest.raises(vr.InputError, match=r"rods.beam.law: CubicBending"):
            model.simulate(0.1, formulation="intrinsic", **settings)
    with pytest.raises(vr.InputError, match=r"rods.beam.law: CubicBending"):
        model.steady(spin=(0, 0, 1.0), formulation="intrinsic", damping="linearised")
    with pytest.raises(vr.InputError, match=r"stiffness and damping matrices only"):
        vr.programs.SectionData.of(model.rods["beam"])
    with pytest.raises(vr.InputError, match="by hand"):
        vr.programs.case_text(model.rods["beam"])

"""Rest strains: what is free takes them without force, what is held answers with C times them, in every analysis."""

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

L, CURVATURE, BENDING, AXIAL = 2.0, 0.5, 100.0, 1e6
SECTION = vr.StiffnessSection([AXIAL, AXIAL, AXIAL, BENDING, BENDING, BENDING], [1, 1, 1, 1, 1, 2])
BENT = (0.0, 0.0, 0.0, CURVATURE, 0.0, 0.0)


def beam(*, ends: int = 1) -> vr.Model:
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (L, 0, 0), section=SECTION, elements=4))
    model.clamp("beam.start")
    if ends == 2:
        model.clamp("beam.end")
    return model


def bent() -> vr.Model:
    model = beam()
    model.rest_strain("beam", BENT)
    return model


def built_bent() -> vr.Model:
    """The same beam built as the arc that the rest strain makes of it: no rest strain in it."""
    model = vr.Model()
    arc = vr.Rod.arc(
        (0, 0, 0),
        (1, 0, 0),
        (0, 0, -1),
        1.0 / CURVATURE,
        CURVATURE * L,
        d1=(0, 1, 0),
        section=SECTION,
        elements=4,
    )
    model.add("beam", arc)
    model.clamp("beam.start")
    return model


def circle() -> np.ndarray:
    return np.array([np.sin(CURVATURE * L), 0.0, np.cos(CURVATURE * L) - 1.0]) / CURVATURE


def test_free_cantilever_takes_an_imposed_curvature_without_reaction() -> None:
    # kappa L^2/2 = 0.004 m across; given by Model.strain, which statics impose at rest
    model = beam()
    model.strain("beam", (0, 0, 0, 0.002, 0, 0))
    found = model.equilibrium()
    angle = 0.002 * L
    wanted = [np.sin(angle) / 0.002 - L, 0.0, (np.cos(angle) - 1.0) / 0.002]
    assert found.displacement("beam.end") == pytest.approx(wanted, abs=1e-12)
    assert found.displacement("beam.end")[2] == pytest.approx(-0.002 * L**2 / 2.0, rel=1e-5)
    assert np.abs(found.reactions.values).max() < 1e-8  # N: EA times round-off
    assert found.elastic_energy < 1e-16
    assert "imposed as rest strains" in flat(found.report())


def test_held_beam_answers_with_its_stiffness_times_the_rest_strain() -> None:
    # as code_aster's V3.01.104: elongation 0.001 and curvatures 0.002, 0.003 between two clamps
    model = beam(ends=2)
    rest = np.array([0.0, 0.0, -1e-4, 0.002, 0.003, 0.004])
    model.rest_strain("beam", rest)
    found = model.equilibrium()
    assert np.abs(found.data["position"].values[-1] - found.data["reference_position"].values).max() < 1e-12
    stiffness = np.array([AXIAL, AXIAL, AXIAL, BENDING, BENDING, BENDING])
    assert found.data["section_force"].values[-1] == pytest.approx(
        np.broadcast_to(-stiffness * rest, found.data["section_force"].values[-1].shape), rel=1e-9, abs=1e-8
    )
    assert found.elastic_energy == pytest.approx(0.5 * L * float(stiffness @ rest**2), rel=1e-9)


def test_rest_strain_along_the_rod_and_half_of_it_by_the_load_factor() -> None:
    # curvature k s: the angle is k s^2/2, small: deflection k s^3/6
    model = beam()
    model.rest_strain("beam", lambda s: (0, 0, 0, 1e-4 * s, 0, 0))
    for factor in (1.0, 0.5):
        tip = model.equilibrium(load_factor=factor).displacement("beam.end")
        assert tip[2] == pytest.approx(-factor * 1e-4 * L**3 / 6.0, rel=1e-6)


def test_path_reaches_the_circle() -> None:
    path = bent().path()
    assert path.position("beam.end") == pytest.approx(circle(), abs=1e-10)
    assert np.abs(path.data["section_force"].values).max() < 1e-6  # of EA = 1e6 N


def test_modes_are_those_of_the_beam_built_bent() -> None:
    assert bent().modes(8).frequencies == pytest.approx(built_bent().modes(8).frequencies, rel=1e-6)


def test_motion_from_the_equilibrium_stays_there() -> None:
    run = bent().simulate(0.1)
    assert run.history("beam.end").values[-1] == pytest.approx(circle(), abs=1e-12)


@pytest.mark.parametrize(
    "settings", [{}, {"formulation": "intrinsic"}, {"integrator": "generalized_alpha"}], ids=str
)
def test_motion_is_that_of_the_beam_built_bent_and_straightened(settings: dict[str, str]) -> None:
    straight = built_bent()
    straight.strain("beam", tuple(-value for value in BENT))
    other = straight.simulate(0.1, initial="reference", output_interval=0.05, tolerance=1e-6)
    run = bent().simulate(0.1, initial="reference", output_interval=0.05, tolerance=1e-6, **settings)
    difference = run.history("beam.end").values - other.history("beam.end").values
    assert np.abs(difference).max() < 2e-5
    assert run.energy.elastic[0] == pytest.approx(0.5 * BENDING * CURVATURE**2 * L, rel=1e-9)
    assert run.energy.numerical_fraction < 1e-4


def test_steady_rotation_is_that_of_the_beam_built_bent() -> None:
    spin = (0.0, 5.0, 0.0)
    wanted = built_bent().steady(spin).probe("beam.end")["position"].values[-1]
    for formulation in ("geometric", "intrinsic"):
        found = bent().steady(spin, formulation=formulation)
        assert found.probe("beam.end")["position"].values[-1] == pytest.approx(wanted, abs=1e-7)


def test_initial_strains_are_refused_where_nothing_begins_with_them() -> None:
    model = beam()
    model.strain("beam", BENT)
    for analysis in (lambda: model.modes(2), lambda: model.steady((0, 5, 0))):
        with pytest.raises(vr.InputError, match="give a rest strain"):
            analysis()
    model.rest_strain("beam", BENT)
    with pytest.raises(vr.InputError, match="has one already"):
        model.equilibrium()

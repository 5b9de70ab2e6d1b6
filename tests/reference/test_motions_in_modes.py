"""Motions of the reduced intrinsic equations: against those of all nodes, and the energy law.

With as many modes as a mesh has the reduced equations are the whole intrinsic formulation (another code: compiled
elements, poses integrated in time); with few of them the released cantilever (Linn, Lang and Tuganov, section 3) and
the hinged beam (Artola, Wynn and Palacios, section V.B) converge to it.
"""

import numpy as np
import pytest

import viscorod as vr

ALL = 200
"""Modes; more than the meshes here have."""


def coupled():
    """Return a section whose strains are coupled, with its mass beside the centre line and unequal times."""
    stiffness = np.diag([800.0, 700.0, 2e3, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 10.0
    stiffness[3, 5] = stiffness[5, 3] = 0.2
    inertia = np.diag([1.0, 1.0, 1.0, 2e-3, 1e-3, 3e-3])
    inertia[0, 5] = inertia[5, 0] = -0.01
    inertia[2, 3] = inertia[3, 2] = 0.01
    return vr.StiffnessSection(stiffness, inertia, np.diag([8.0, 7.0, 20.0, 0.01, 0.02, 0.01]))


def arc(**given):
    """Return a curved rod under a dead force, a following moment, gravity and drag."""
    model = vr.Model()
    given = {"section": coupled(), "elements": 1, "order": 4} | given
    model.add("rod", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2, **given))
    model.force("rod.end", (0.4, 0.8, 1.0), time=vr.Sine(1.0))
    model.moment("rod.end", (0.2, 0.0, -0.3), following=True, time=vr.Sine(0.7))
    model.gravity((0, 0, -0.5))
    return model


def clamped():
    """Return an arc on a clamp, which falls at a speed and meets drag."""
    model = arc()
    model.clamp("rod.start")
    model.drag("rod", coefficient_across=1.2, density=2.0, width=0.3)
    model.velocity("rod", field=lambda s: ((0, 0, s * s), (0, -2.0 * s, 0)))
    return model, {}


def swinging():
    """Return an arc on a ball joint."""
    model = arc()
    model.pin("rod.start")
    return model, {"initial": "reference"}


def frame():
    """Return two rods that meet at a body beside their ends, held more than they need."""
    model = arc()
    x, y = np.sin(1.2), 1.0 - np.cos(1.2)
    model.add(
        "arm", vr.Rod.straight((x + 0.1, y, 0), (x + 0.1, y, 0.6), section=coupled(), elements=1, order=4)
    )
    model.add("hub", vr.Body(0.2, (1e-3, 2e-3, 1e-3), centre=(x + 0.05, y, 0)))
    model.attach("rod.end", "hub")
    model.attach("arm.start", "hub")
    model.clamp("rod.start")
    model.pin("arm.end")
    return model, {}


@pytest.mark.parametrize("damping", ["full", "linearised"])
@pytest.mark.parametrize("case", [clamped, swinging, frame])
def test_all_modes_are_the_whole_formulation(case, damping):
    """Independent formulation: all nodes by the compiled intrinsic elements."""
    model, given = case()
    given = given | {
        "formulation": "intrinsic",
        "damping": damping,
        "tolerance": 1e-7,
        "output_interval": 0.1,
    }
    whole, reduced = model.simulate(0.1, **given), model.simulate(0.1, modes=ALL, **given)
    assert reduced.data.attrs["modes_open"] < 1e-5
    for name in ("velocity", "strain", "section_force", "reaction", "viscous", "kinetic", "elastic"):
        wanted, found = (run.data[name].values for run in (whole, reduced))
        assert np.abs(found - wanted).max() < 4e-5 * np.abs(wanted).max(), name
    # positions of all nodes are integrated in time, and differ from those of the strains as that run tells
    wanted, found = (run.data["position"].values for run in (whole, reduced))
    assert np.abs(found - wanted).max() < 1e-6 + 1.1 * whole.data.attrs["pose_gap"]
    assert reduced.energy.numerical_fraction < 1e-7


def test_a_free_rod_tumbles_as_all_its_nodes_do():
    """Independent formulation, without supports: strains and energies; momenta are those of the mesh."""
    model = vr.Model()
    model.add("rod", vr.Rod.helix(0.3, 0.4, 0.5, section=coupled(), elements=1, order=5))
    model.velocity("rod", field=lambda s: ((np.sin(3 * s), 1.0, s), (2.0, s, -1.0)))
    given = {
        "initial": "reference",
        "formulation": "intrinsic",
        "tolerance": 1e-8,
        "output_interval": 0.05,
        "errors": False,
    }
    whole, reduced = model.simulate(0.1, **given), model.simulate(0.1, modes=ALL, **given)
    assert reduced.data.attrs["modes_rigid"] == 6
    for name in ("strain", "kinetic", "elastic", "viscous"):
        wanted, found = (run.data[name].values for run in (whole, reduced))
        assert np.abs(found - wanted).max() < 1e-5 * np.abs(wanted).max(), name


def hinged():
    """Return the hinged beam of AWP V.B."""
    stiffness = np.array([5e3, 5e3, 1e4, 1.0, 2.0, 1.0])
    section = vr.StiffnessSection(stiffness, [1.0, 1.0, 1.0, 2e-4, 2e-4, 4e-4], 1e-3 * stiffness)
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=5))
    model.pin("beam.start")
    model.moment("beam.end", (0.5, 0.5, 0), following=True, time=vr.Sine(2.0), until=0.5)
    return model


@pytest.mark.parametrize("damping", ["full", "linearised"])
def test_the_midpoint_rule_keeps_the_energy_law_of_the_reduced_equations(damping):
    """Conservation law (AWP 19, 32): work of loads less dissipation, to round-off, in few modes and long steps."""
    given = {"initial": "reference", "formulation": "intrinsic", "damping": damping, "modes": 5}
    with pytest.warns(vr.AccuracyWarning, match="steps may leave positions"):
        run = hinged().simulate(0.6, integrator="midpoint", time_step=0.01, **given)
    assert run.energy.viscous[-1] > 0.05 * run.energy.external[-1] > 0.01
    assert run.energy.numerical_fraction < 1e-12


def test_a_hinged_beam_converges_with_its_modes():
    """AWP V.B against all nodes: energy, and the angular momentum about the joint, which no vibration changes."""
    given = {"initial": "reference", "formulation": "intrinsic", "tolerance": 1e-5, "output_interval": 0.25}
    whole = hinged().simulate(0.75, **given)
    errors = []
    for count in (4, 16):
        run = hinged().simulate(0.75, modes=count, **given)
        energies = [(r.data["kinetic"] + r.data["elastic"]).values for r in (whole, run)]
        errors.append(np.abs(energies[1] - energies[0]).max() / energies[0].max())
        assert run.data.attrs["modes"] == count
        assert run.data.attrs["modes_rigid"] == 3
    assert errors[0] < 0.2
    assert errors[1] < 1e-3
    momentum = np.linalg.norm(run.data["angular_momentum"].values[-1])
    assert momentum == pytest.approx(0.16665, abs=1e-4)


def released():
    """Return the cantilever of LLT, section 3, bent far beyond the linear range."""
    rubber = vr.Material(1e6, density=1000.0, poissons_ratio=0.3, damping=vr.KelvinVoigt(0.02, 0.02))
    model = vr.Model()
    given = {"section": vr.Rectangle(0.01, 0.01), "material": rubber, "elements": 2, "order": 5}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model


def test_a_released_cantilever_converges_with_its_modes():
    """LLT section 3 against all nodes: positions; half as many modes bound the error, in the result."""
    given = {"formulation": "intrinsic", "tolerance": 1e-5, "output_interval": 0.1}
    wanted = released().simulate(1.0, **given).history("beam.end")
    errors = []
    for count in (4, 8):
        run = released().simulate(1.0, modes=count, **given)
        errors.append(np.abs(run.history("beam.end") - wanted).max() / 0.3)
        assert errors[-1] < run.data.attrs["modes_motion_gap"]
    assert errors[0] < 1e-3
    assert errors[1] < 1e-4
    assert errors[1] < 0.5 * errors[0]

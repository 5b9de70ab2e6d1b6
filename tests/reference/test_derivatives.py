"""Derivatives by numbers of a case: closed forms, an independent linearisation, extrapolated differences."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from viscorod.analyses.derivatives import eigenvalues, motions, neighbours, orbits, resting_neighbours
from viscorod.analyses.derivatives.case_numbers import CaseNumber, with_values
from viscorod.analyses.derivatives.mode_shapes import ShapeRates
from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.provenance import material_record
from viscorod.analyses.start_state import StartState
from viscorod.errors import InputError, SolveError
from viscorod.results.data_schema import annotated
from viscorod.results.dataset import dataset
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.sensitivity import motion_sensitivity
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.motion_sensitivity import KeptSteps
from viscorod.solve.start import Start
from viscorod.solve.transient.company_steps import CompanySteps
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.radau import Radau

E, TAU = "materials.rubber.youngs_modulus", "materials.rubber.damping.shear_time"


def bar(elements=3, tau=0.004, **rod):
    model = vr.Model()
    rubber = vr.Material(
        2.5e6, poissons_ratio=0.45, density=1100.0, damping=vr.KelvinVoigt(tau, tau) if tau else None
    )
    model.materials["rubber"] = rubber
    given = {"section": vr.Rectangle(0.02, 0.01), "material": rubber, "elements": elements, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **(given | rod)))
    return model


def swing():
    """A rubber cantilever that hangs aside in equilibrium, and is let go."""
    model = bar()
    model.clamp("beam.start")
    model.gravity((0, 0, -9.81))
    model.force("beam.end", (0.0, 0.05, 0.0), until=0.0)
    return model


def assembly():
    """Two rods with a hinge, a body at the end, held strains, a rest strain."""
    model = bar(elements=2)
    rubber = model.materials["rubber"]
    given = {"section": vr.Rectangle(0.02, 0.01), "material": rubber, "elements": 2, "order": 2}
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.4, 0, 0), **given, constraints="inextensible"))
    model.add("tip", vr.Body(mass=0.01, centre=(0.4, 0, 0), inertia=(1e-5, 1e-5, 1e-5)))
    model.attach("arm.end", "tip")
    model.revolute("beam.end", "arm.start", axis=(0, 1, 0), stiffness={"rz": 0.1}, damping={"rz": 1e-3})
    model.clamp("beam.start")
    model.gravity((0, 0, -9.81))
    model.force("beam.end", (0.0, 0.05, 0.0))
    model.rest_strain("beam", (0, 0, 0, 0.1, 0, 0))
    return model


def extrapolated(function, value, step):
    """The derivative by two central differences (Richardson): error of the fourth order."""
    first, second = ((function(value + h) - function(value - h)) / (2.0 * h) for h in (step, 0.5 * step))
    return (4.0 * second - first) / 3.0


ASSEMBLY = (
    "rods.beam.end[0]",
    "loads[1].value[1]",
    "bodies.tip.mass",
    "joints[0].axis[0]",  # the axis is a global one, beside which others are chosen across it
    "joints[0].axis[2]",
)


STORED = ("position", "rotation", "strain", "elastic", "joint_value")


def test_equilibria_of_assemblies_change_as_differences_say():
    """Richardson-extrapolated differences of equilibria, by numbers of every kind; all that is stored."""
    model = assembly()
    found = model.equilibrium(derivatives=list(ASSEMBLY))
    for key, derivative in found.derivatives.items():
        step = 1e-3 * (abs(derivative.value) or 1.0)

        def data(value, key=key):
            return with_values(model, {key: value}).equilibrium().data[list(STORED)]

        expected = extrapolated(data, derivative.value, step)
        for name in STORED:
            wanted, mine = expected[name].values, derivative.data[name].values
            np.testing.assert_allclose(
                mine, wanted, atol=1e-7 * np.abs(wanted).max(), err_msg=f"{key} {name}"
            )
    force = found.derivatives["loads[1].value[1]"]
    assert force.data.position.attrs["units"] == "(m)/(N)"
    tip = force.probe("beam.end").position.values[-1, 0]
    np.testing.assert_allclose(tip, force.history("beam.end").values[-1], atol=1e-12)


LAYOUT_STAYS = (
    E,
    TAU,
    "materials.rubber.density",
    "rods.beam.section.width",
    "loads[0].acceleration[2]",
    "loads[1].value[1]",
)


@pytest.mark.parametrize("analysis", ["equilibrium", "modes"])
def test_problems_of_neighbours_share_what_a_number_leaves_alone(monkeypatch, analysis):
    """Independent: the same derivatives where every neighbour is discretised as a whole and has its own solver."""
    model, quick, made = assembly(), neighbours.discretise_beside, []
    others = ["rods.beam.end[0]", "bodies.tip.mass", "joints[0].stiffness.rz", "rest_strains[0].value[3]"]
    keys = [*LAYOUT_STAYS, *others]
    settings = {"count": 2} if analysis == "modes" else {}

    def counted(*parts):
        made.append(quick(*parts))
        return made[-1]

    monkeypatch.setattr(neighbours, "discretise_beside", counted)
    mine = getattr(model, analysis)(**settings, derivatives=keys).derivatives
    each = len(made) // len(keys)
    assert [one is not None for one in made] == [k < each * len(LAYOUT_STAYS) for k in range(len(made))]
    monkeypatch.setattr(neighbours, "discretise_beside", lambda *_: None)
    monkeypatch.setattr(Neighbour, "resting", property(lambda one: one.static))
    whole = getattr(model, analysis)(**settings, derivatives=keys).derivatives
    for key in keys:
        for name, values in whole[key].data.data_vars.items():
            size = float(np.abs(values.values).max(initial=0.0))
            found = mine[key].data[name].values
            np.testing.assert_allclose(
                found, values.values, rtol=0.0, atol=1e-10 * size, err_msg=f"{key} {name}"
            )


def test_forces_of_neighbours_at_rest_are_computed_when_they_are_read(monkeypatch):
    seen, taken = [], resting_neighbours.snapshots
    monkeypatch.setattr(resting_neighbours, "snapshots", lambda *given: seen.append(1) or taken(*given))
    by_modulus = swing().equilibrium(derivatives=[E]).derivatives[E]
    poses = by_modulus.of(lambda found: found.field("position"))
    assert not seen
    np.testing.assert_array_equal(poses, by_modulus.data.position.values)
    assert len(seen) == 1  # for both neighbours


def test_equilibria_of_thin_rods_obey_eulers_theorem():
    """Forces are E times a function of the loads over E, so that ``E df/dE + F df/dF = f``, and of positions 0.

    The strip is so thin that section forces of two neighbours in states of first order would be wrong by 1e-6, and
    those of four, farther apart, by 1.4e-8.
    """
    model = bar(section=vr.Rectangle(0.02, 0.002), elements=4)
    model.clamp("beam.start")
    model.force("beam.end", (0.0, 0.0128, -0.00032))
    keys = [E, "loads[0].value[1]", "loads[0].value[2]"]
    found = model.equilibrium(derivatives=keys)
    assert all(len(found.derivatives[key].parts) == 2 for key in keys)
    for name, degree in (("position", 0), ("section_force", 1), ("reaction", 1), ("elastic", 1)):
        values = found.data[name].values
        scaled = sum(found.derivatives[key].value * found.derivatives[key].data[name].values for key in keys)
        assert scaled == pytest.approx(degree * values, abs=1e-8 * np.abs(values).max()), name


def test_a_damped_bar_changes_as_its_closed_form():
    """Closed form: f ~ E^1/2 at once for all modes, and the ratio of each is omega tau/2 (theta of shear and bulk)."""
    model = bar(tau=0.0004)
    model.clamp("beam.start")
    modes = model.modes(4, derivatives=[E, TAU, "materials.rubber.damping.bulk_time"])
    f, ratios = modes.frequencies, modes.damping_ratios
    by_modulus = modes.derivatives[E]
    np.testing.assert_allclose(by_modulus.frequencies, 0.5 * f / 2.5e6, rtol=1e-8)
    np.testing.assert_allclose(by_modulus.damping_ratios, 0.5 * ratios / 2.5e6, rtol=1e-7)
    both = sum(
        modes.derivatives[key].damping_ratios for key in (TAU, "materials.rubber.damping.bulk_time")
    )  # of one time for both, to which ratios are proportional
    np.testing.assert_allclose(both, ratios / 0.0004, rtol=1e-7)
    np.testing.assert_allclose(by_modulus.of(lambda modes: modes.shapes), 0.0, atol=1e-8 / 2.5e6)
    with pytest.raises(InputError, match="no derivative"):
        by_modulus.of(lambda modes: modes.shares)
    with pytest.raises(InputError, match="derivatives are those of numbers"):
        by_modulus.report()
    assert "mode_share" not in by_modulus.data


@pytest.mark.parametrize("make", [assembly, lambda: bar(elements=2)])
def test_eigenvalues_change_as_differences_say(make):
    """Richardson-extrapolated differences, about an equilibrium that changes too, and of a free rod."""
    model = make()
    keys = ["joints[0].damping.rz"] if model.joints else [TAU]
    count = 3 if model.joints else 9
    modes = model.modes(count, derivatives=keys)
    s = modes.eigenvalues
    for key in keys:
        value = modes.derivatives[key].value
        expected = extrapolated(
            lambda v, key=key: with_values(model, {key: v}).modes(count).eigenvalues, value, 1e-2 * abs(value)
        )
        found = modes.derivatives[key].of(lambda modes: modes.eigenvalues)
        assert (np.abs(found - expected) <= 2e-8 * np.abs(s / value)).all(), key


def test_numbers_that_hardly_matter_to_eigenvalues_are_not_lost_in_rounding():
    """Extrapolated differences far apart: a force that bends a rod a little changes eigenvalues by 2e-4 of them only.

    Neighbours at the usual distance were wrong by 2e-6 of that.
    """
    model, key, force = bar(elements=2), "loads[0].value[1]", 0.01
    model.clamp("beam.start")
    model.force("beam.end", (0.0, force, 0.5 * force))
    found = model.modes(4, derivatives=[key]).derivatives[key].of(lambda modes: modes.eigenvalues)
    expected = extrapolated(lambda v: with_values(model, {key: v}).modes(4).eigenvalues, force, 0.25 * force)
    assert np.abs(found - expected).max() <= 3e-7 * np.abs(expected).max()


def test_eigenvalues_begin_with_neighbours_as_far_apart_as_rounding_asks_for(monkeypatch):
    """Closed form: without damping and loads angular frequencies go as the root of the modulus.

    A thousandth apart rounding is 3e-8 and more of the largest. It is known before any neighbour is made, so none
    is made twice.
    """
    made, begin = [], eigenvalues._Rates.__init__

    def counted(self, neighbours, *rest):
        made.append(neighbours)
        begin(self, neighbours, *rest)

    monkeypatch.setattr(eigenvalues._Rates, "__init__", counted)
    model = bar(elements=10, tau=0.0)
    model.clamp("beam.start")
    modes = model.modes(about="reference", count=4, derivatives=[E])
    found = modes.derivatives[E].of(lambda one: one.eigenvalues.imag)
    np.testing.assert_allclose(found, modes.eigenvalues.imag / (2.0 * 2.5e6), rtol=1e-8)
    assert len(made) == 1
    assert made[0].each[0].change > 2.0 * neighbours.STEP * 2.5e6


def test_shapes_of_modes_change_as_differences_say():
    """Richardson-extrapolated differences, about an equilibrium that changes too; displacements and rotations."""
    model, key = assembly(), "bodies.tip.mass"
    modes = model.modes(3, derivatives=[key])

    def shapes(found):
        return np.stack([found.shapes, found.rotations])

    expected = extrapolated(lambda v: shapes(with_values(model, {key: v}).modes(3)), 0.01, 5e-5)
    found = modes.derivatives[key].of(shapes)
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_stress_changes_with_the_section_that_it_is_of():
    """Closed form: sigma = M x/(h w^3/12) at a point at x across the width; it falls with w as -3, with h as -1."""
    model = bar(tau=0.0, elements=1)
    model.clamp("beam.start")
    model.force("beam.end", (0, 1e-4, 0))
    powers = {"rods.beam.section.width": -3.0, "rods.beam.section.height": -1.0}
    found = model.equilibrium(derivatives=list(powers))

    def stress(result):
        return result.stress("beam.start", points=(0.008, 0.0)).stress.values[-1, 0, 2]

    for key, power in powers.items():
        by = found.derivatives[key]
        assert by.of(stress) * by.value / stress(found) == pytest.approx(power, rel=1e-5)


def test_a_file_keeps_derivatives(tmp_path):
    """What is read answers as what was written, to first order, of lengths that change too; what has none stays so."""
    model = swing()
    keys = [E, "rods.beam.end[0]"]
    run = model.simulate(0.02, output_interval=0.01, derivatives=keys)
    again = vr.load(run.save(tmp_path / "run.nc"))
    assert list(again.derivatives) == keys
    assert "derivatives" not in again.data.attrs
    for key in keys:
        mine, its = run.derivatives[key], again.derivatives[key]
        assert (its.value, its.unit) == (mine.value, mine.unit)
        for function in (
            lambda run: run.history("beam.end").values,
            lambda run: run.stress("beam.start", points=(0.0, 0.0)).stress.values,
            lambda run: run.data.station_s.values,
        ):
            wanted = mine.of(function)
            np.testing.assert_allclose(its.of(function), wanted, atol=1e-8 * np.abs(wanted).max())
    model = bar()
    model.clamp("beam.start")
    modes = model.modes(2, derivatives=[E])
    again = vr.load(modes.save(tmp_path / "modes.nc"))
    np.testing.assert_allclose(again.derivatives[E].frequencies, modes.derivatives[E].frequencies, rtol=1e-9)
    with pytest.raises(InputError, match="no derivative"):
        again.derivatives[E].of(lambda modes: modes.shares)


def test_derivatives_leave_the_motion_as_it_is():
    """Bit for bit the run without them."""
    model = swing()
    plain, other = (model.simulate(0.05, output_interval=0.01, derivatives=keys) for keys in ([], [TAU]))
    np.testing.assert_array_equal(plain.data.position.values, other.data.position.values)


def test_modes_that_fall_together_have_the_derivative_of_their_mean():
    """A square free rod: the trace of what a width parts is that of both bendings."""
    model = bar(elements=2, section=vr.Rectangle(0.01, 0.01))
    with pytest.warns(UserWarning, match="have one frequency"):
        modes = model.modes(8, derivatives=["rods.beam.section.width"])
    derivative = modes.derivatives["rods.beam.section.width"]

    def mean(width):
        return with_values(model, {"rods.beam.section.width": width}).modes(8).frequencies[6:].mean()

    assert derivative.frequencies[6] == pytest.approx(extrapolated(mean, 0.01, 1e-4), rel=1e-6)


def test_a_motion_changes_as_its_exact_linearisation_says():
    """An independent formulation: each step linearised exactly and solved, by the arrays of the problem."""
    model = bar(elements=2)
    model.clamp("beam.start")
    model.gravity((0, 2.0, -9.81))
    density = "materials.rubber.density"
    run = model.simulate(0.2, initial="reference", tolerance=1e-4, derivatives=[E, TAU, density])
    problem = discretise(model)
    method = Radau(GeometricSystem(problem), SupportState(problem), tolerance=1e-8)
    method.iterations = 60
    steps = KeptSteps(method)
    steps.start(0.0, State.reference(problem))
    for end in run.ends_of_steps:
        assert steps.attempt(end, before=bool(end == run.ends_of_steps[-1])).converged
        steps.accept()
    elements = method.system.elements()
    changes = [ArrayChanges.none(problem, elements) for _ in range(2)]
    changes[0].stiffness[:], changes[0].damping[:] = elements.stiffness, elements.damping
    changes[1].mass[:] = problem.mass
    tip = problem.stations.nodes[-1]
    change = list(motion_sensitivity.forward(steps, changes))[-1]
    matrix = _rotation(change.state.q[tip])
    for k, (key, value) in enumerate(((E, 2.5e6), (density, 1100.0))):
        expected = matrix @ change.pose[k, tip, :3] / value
        found = run.derivatives[key].history("beam.end").values[-1]
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_a_motion_of_an_assembly_changes_as_differences_say():
    """Richardson-extrapolated differences of runs with equal steps, from equilibria: a hinge, held strains, a body."""
    model = assembly()
    given = {"integrator": "generalized_alpha", "time_step": 2e-3, "output_interval": 4e-3}
    model.force("tip", (0, 0.1, 0.2), time=vr.Sine(20.0))
    key = "bodies.tip.mass"
    found = model.simulate(0.02, **given, derivatives=[key]).derivatives[key]

    def data(value):
        return (
            with_values(model, {key: value}).simulate(0.02, **given).data[["position", "velocity", "kinetic"]]
        )

    expected = extrapolated(data, 0.01, 4e-5)
    for name, wanted in expected.items():
        np.testing.assert_allclose(
            found.data[name], wanted, atol=1e-6 * np.abs(wanted).max().item(), err_msg=name
        )


def _rotation(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_data_beside_a_result_are_those_made_anew():
    """Independent: the data set of a neighbour as every result's is made, without the result that it stands beside.

    Lengths, rest shapes, joints and materials of the neighbour are its own.
    """
    model = assembly()
    keys = ["rods.beam.end[0]", "materials.rubber.density", "bodies.tip.mass"]
    run = model.simulate(0.02, output_interval=0.005, derivatives=keys)
    rest = model.equilibrium(derivatives=keys)
    for result in (run, rest):
        for derivative in result.derivatives.values():
            near = derivative.parts[0].result
            one, history, _ = near._build.args
            if result is rest:
                one, history = one.neighbours.each[history], one.histories[history]
            made = dataset(
                result.kind, one.problem, one.system.gauss_positions(), history, one.attributes(result)
            )
            xr.testing.assert_identical(near.data, annotated(made, result.kind))
            case = json.loads(near.data.attrs["case"])
            assert case != json.loads(result.data.attrs["case"])
            record = material_record(one.discrete.model)
            assert {name: near.data.attrs[name] for name in record} == record


def test_a_second_number_takes_up_what_the_first_one_found(monkeypatch):
    """Between the neighbours of one number is the motion itself, and theirs of another mirror each other about it.

    With predictions corrected by that, those of a second number need three quarters of the iterations at most.
    Counted in steps that are taken one by one.
    """
    monkeypatch.setattr(CompanySteps, "of", lambda *_: None)
    iterated = []
    attempt = Collocation.attempt

    def counted(self, *args, **given):
        report = attempt(self, *args, **given)
        if self.company is not None:
            iterated.append(report.iterations)
        return report

    monkeypatch.setattr(Collocation, "attempt", counted)
    sums = []
    for keys in ([E], [E, "rods.beam.section.width"]):
        iterated.clear()
        swing().simulate(0.2, output_interval=0.1, derivatives=keys)
        sums.append(sum(iterated))
    assert sums[1] - sums[0] < 0.8 * sums[0]


def test_what_a_number_moves_at_rest_tells_how_far_its_neighbours_are(monkeypatch):
    """Poisson's ratio hardly bends a bar: all go through the steps once, as far apart as the equilibrium asks for."""
    passes = []
    together = motions.side_by_side

    def counted(all_of_them, *args):
        passes.append(len(all_of_them))
        return together(all_of_them, *args)

    monkeypatch.setattr(motions, "side_by_side", counted)
    keys = [E, "materials.rubber.poissons_ratio"]
    swing().simulate(0.1, output_interval=0.05, derivatives=keys)
    assert len(passes) == 1


def test_neighbours_of_a_light_beam_are_not_too_far(monkeypatch):
    """What two neighbours leave is of third order: others, 2.5 times nearer, give the same derivatives.

    A stiff beam with branches and a body at its end, which the density of the beam moves little: its neighbours were
    2.7e-4 of it apart, and angular velocities off by 1e-6 of their derivatives.
    """
    model = vr.Model()
    damping = vr.Prony(
        shear_ratios=[0.2, 0.1], shear_times=[0.0018726409, 0.0187110591], constant="bulk_modulus"
    )
    material = vr.Material(15208167.2, poissons_ratio=0.2746898, density=1100.0, damping=damping)
    model.materials["rubber"] = material
    end = (0.3, -0.04980764, 0.00057211)
    section = vr.Rectangle(0.012424904, 0.01743000853)
    model.add(
        "beam", vr.Rod.straight((0, 0, 0), end, section=section, material=material, elements=2, order=3)
    )
    model.add("tip", vr.Body(mass=0.02, centre=end, inertia=(2e-6, 3e-6, 4e-6)))
    model.attach("beam.end", "tip")
    model.clamp("beam.start")
    model.gravity((-2.26836614, 0.62697184, -2.10073493))
    model.force("beam.end", (0.35887263, 0.206855232, 0.01894257), until=0.0)
    model.rest_strain("beam", (0, 0, 0, 0.6273288, 0.64227178, -0.61253798))
    key, given = "materials.rubber.density", {"duration": 0.05, "output_interval": 0.01}

    def turning():
        return model.simulate(**given, derivatives=[key]).derivatives[key].data["angular_velocity"].values

    found = turning()
    monkeypatch.setattr(motions, "CLOSE", 0.4 * motions.CLOSE)
    monkeypatch.setattr(motions, "LEAST", 0.0)
    wanted = turning()
    assert np.linalg.norm(wanted) > 1e-3
    assert np.linalg.norm(found - wanted) < 3e-7 * np.linalg.norm(wanted)


def test_neighbours_whose_velocities_hardly_differ_are_taken_farther(monkeypatch):
    """Four neighbours that are 200 times as far apart, extrapolated, whose round-off is below 1e-7, tell the same.

    Gravity moves this beam by 2e-6 of its length, which was enough, but hardly changes how it swings: round-off was
    2.7e-6 of the derivative of angular velocities.
    """
    model = vr.Model()
    times = [0.001419487205, 0.011896954237]
    damping = vr.Prony(shear_ratios=[0.2, 0.1], shear_times=times, constant="bulk_modulus")
    rubber = vr.Material(12701537.891282, poissons_ratio=0.38259033, density=1100.0, damping=damping)
    end = (0.3, -0.053544209375, -0.097644360924)
    section = vr.Rectangle(0.019035283091, 0.008800102362)
    rod = vr.Rod.straight((0, 0, 0), end, section=section, material=rubber, elements=2, order=3)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.gravity((1.583064841317, 0.565465659612, 0.206335024970))
    model.force("beam.end", (0.080573187341, 0.090798689642, -0.021145758417), until=0.0)
    model.rest_strain("beam", (0, 0, 0, 0.981234616804, 0.068285343968, -0.427707997122))
    key, given = "loads[0].acceleration[1]", {"duration": 0.05, "output_interval": 0.01}

    def turning():
        return model.simulate(**given, derivatives=[key]).derivatives[key].data["angular_velocity"].values

    def far(cls, model, key, discrete, *_):
        return cls(Neighbours.of(model, key, discrete, many=1e-2), None)

    found = turning()
    monkeypatch.setattr(motions._Tried, "of", classmethod(far))
    wanted = turning()
    assert np.linalg.norm(wanted) > 1e-3
    assert np.linalg.norm(found - wanted) < 1e-6 * np.linalg.norm(wanted)


def test_neighbours_by_a_time_of_damping_are_not_too_far(monkeypatch):
    """Four neighbours that are as far apart at most, extrapolated, tell the same.

    A beam whose fast modes die within a few milliseconds: of a thousandth of the time of damping the third order was
    1e-6 of how the beam turns.
    """
    model = vr.Model()
    damping = vr.KelvinVoigt(0.015833807108616368, 0.0025220538376172844)
    rubber = vr.Material(
        13236641.67659404, poissons_ratio=0.2095711959695778, density=1100.0, damping=damping
    )
    model.materials["rubber"] = rubber
    end = (0.3, -0.08750747346771565, -0.08713422569638929)
    section = vr.Rectangle(0.018879032455999957, 0.010147040579882256)
    rod = vr.Rod.straight((0, 0, 0), end, section=section, material=rubber, elements=2, order=3)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.gravity((-1.7214501334318308, 2.333841523896845, -1.5072697846025933))
    model.force("beam.end", (-0.135081956344353, -0.116294002500836, -0.0133209056717778), until=0.0)
    key, given = "materials.rubber.damping.shear_time", {"duration": 0.05, "output_interval": 0.01}

    def turning():
        return model.simulate(**given, derivatives=[key]).derivatives[key].data["angular_velocity"].values

    def many(cls, model, key, discrete, *_):
        return cls(Neighbours.of(model, key, discrete, many=1e-3), None)

    found = turning()
    monkeypatch.setattr(motions._Tried, "of", classmethod(many))
    wanted = turning()
    assert np.linalg.norm(wanted) > 1.0
    assert np.linalg.norm(found - wanted) < 7e-7 * np.linalg.norm(wanted)


def test_numbers_that_are_felt_in_motion_only_go_through_it_once(monkeypatch):
    """A time of damping that round-off would hide, and one that it would not: what they move is known beforehand.

    The elongation of a rod that bends hardly damps it; what does follows from the adjoint, which has no neighbours.
    """
    passes = []
    together = motions.side_by_side

    def counted(all_of_them, *args):
        passes.append(len(all_of_them))
        return together(all_of_them, *args)

    monkeypatch.setattr(motions, "side_by_side", counted)
    times = ["materials.rubber.damping.shear_time", "materials.rubber.damping.bulk_time"]
    given = {"duration": 0.2, "output_interval": 0.02}
    run = swing().simulate(**given, derivatives=times)
    assert passes == [6]
    weights = {"position": np.zeros(run.data["position"].shape)}
    weights["position"][:, -1] = np.random.default_rng(4).normal(size=(len(run.time), 3))

    def scalar(found):
        return float(np.vdot(weights["position"], found.data["position"].values)), weights

    function = swing().value_and_gradient(times, scalar, adjoint=True, **given)
    gradient = function(function.values)[1]
    assert function.way == "adjoint"
    for key, exact in zip(times, gradient, strict=True):
        found = float(np.vdot(weights["position"], run.derivatives[key].data["position"].values))
        assert found == pytest.approx(exact, rel=1e-6)


def test_neighbours_that_rest_go_through_their_motion_once(monkeypatch):
    """Where nothing moves velocities of neighbours do not differ, however far apart they are."""
    passes = []
    together = motions.side_by_side

    def counted(all_of_them, *args):
        passes.append(len(all_of_them))
        return together(all_of_them, *args)

    monkeypatch.setattr(motions, "side_by_side", counted)
    model = bar()
    model.clamp("beam.start")
    model.gravity((0, 0, -9.81))
    model.simulate(0.1, output_interval=0.05, derivatives=[E])
    assert len(passes) == 1


def test_a_state_that_was_stored_is_taken_as_it_is(monkeypatch):
    """Independent: the same state interpolated between those that were stored, at its own instant."""
    model = assembly()
    run = model.simulate(0.02, output_interval=0.005, initial="reference")
    discrete = DiscreteModel.of(model)
    for given in (Start(result=run, time=0.01), Start(result=model.equilibrium())):
        stored = StartState(discrete, given).state
        with monkeypatch.context() as patch:
            patch.setattr(StartState, "_stored", lambda self: None)
            between = StartState(discrete, given).state
        np.testing.assert_allclose(stored.r, between.r, rtol=0.0, atol=1e-14)
        np.testing.assert_allclose(np.abs(np.sum(stored.q * between.q, axis=1)), 1.0, rtol=1e-14)
        np.testing.assert_allclose(
            stored.twist, between.twist, rtol=0.0, atol=1e-12 * np.abs(between.twist).max()
        )


def test_a_number_that_opens_a_joint_of_the_shape_at_the_start_is_refused():
    """What was told of it before was that Newton's method diverged in some step; one that closes it has derivatives."""
    model = assembly()
    given = {"duration": 1e-3, "output_interval": 5e-4, "initial": "reference"}
    with pytest.raises(InputError, match=r"rods\.beam\.end\[0\].*takes the places of .*beam\.end.* apart"):
        model.simulate(**given, derivatives=["rods.beam.end[0]"])
    assert model.simulate(**given, derivatives=["rods.arm.end[1]"]).derivatives


def test_a_release_has_the_derivative_of_its_equilibrium_at_the_start():
    """The state at t = 0 is the equilibrium; what follows from the motion has derivatives too."""
    model = swing()
    run = model.simulate(0.3, output_interval=0.05, derivatives=[E, TAU])
    resting = model.equilibrium(derivatives=[E])
    start = run.derivatives[E].data.position.values[0]
    expected = resting.derivatives[E].data.position.values[-1]
    np.testing.assert_allclose(start, expected, atol=1e-8 * np.abs(expected).max())
    assert np.abs(run.derivatives[TAU].data.position.values[0]).max() < 1e-9  # which does not damp what rests
    energy = run.derivatives[E].data
    account = energy.kinetic + energy.elastic + energy.viscous - energy.external
    scale = np.abs(energy.elastic.values).max()  # what a swing loses is what it began with
    np.testing.assert_allclose((account - account[0]).values, energy.numerical.values, atol=1e-9 * scale)
    at = run.derivatives[E].probe("beam@0.2", times=[0.07, 0.11])
    assert at.position.shape == (2, 1, 3)


def test_responses_change_as_differences_say():
    """Richardson-extrapolated differences, of an assembly with a joint and held strains; and of its poles."""
    model = assembly()
    given = {"inputs": "base uz", "outputs": ["beam.end uz", "arm.end ay"], "frequencies": [0.5, 3.0, 12.0]}
    key = "bodies.tip.mass"
    found = model.frequency_response(**given, derivatives=[key]).derivatives[key]

    def near(value):
        response = with_values(model, {key: value}).frequency_response(**given)
        return np.concatenate([response.values.ravel(), response.poles[:2]])

    expected = extrapolated(near, 0.01, 5e-5)
    values = found.values.ravel()
    np.testing.assert_allclose(values, expected[:-2], atol=1e-6 * np.abs(expected[:-2]).max())
    np.testing.assert_allclose(found.poles[:2], expected[-2:], rtol=1e-6)
    with pytest.raises(InputError, match="no derivative"):
        _ = found.residues


def test_small_periodic_motions_change_as_responses_do():
    """An independent formulation: the dynamic stiffness at one frequency is the limit of small amplitudes."""
    model = bar(elements=2)
    model.clamp("beam.start")
    given = {"inputs": "beam.end fz", "outputs": ["beam.end uz"]}
    keys = [E, TAU]
    linear = model.frequency_response(**given, frequencies=[12.0], derivatives=keys)
    span = {"frequencies": [12.0, 13.0], "points": 2, "harmonics": 3, "stability": False}
    found = model.periodic(**given, **span, amplitudes=[1e-6], derivatives=keys)
    for key in keys:
        wanted = linear.derivatives[key].values[0, 0, 0]
        mine = found.derivatives[key].of(lambda motions: motions.harmonics(0))[0, 1] / 1e-6
        assert abs(mine - wanted) < 1e-5 * abs(wanted)
        assert np.abs(found.derivatives[key].frequencies).max() == 0.0
    with pytest.raises(InputError, match="free vibrations"):
        model.periodic(mode=1, largest=1e-3, outputs=["beam.end uz"], derivatives=keys)


def test_periodic_motions_without_a_neighbour_leave_the_others_their_derivatives(monkeypatch):
    """A fold, or what a superharmonic resonance sets off, beside one motion: that one has none, and it is told."""
    model = bar(elements=2)
    model.clamp("beam.start")
    given = {"inputs": "beam.end fz", "outputs": ["beam.end uz"], "amplitudes": [1e-6], "derivatives": [E]}
    span = {"frequencies": [12.0, 13.0], "points": 2, "harmonics": 3, "stability": False}

    def others(found):
        return found.harmonics(0)[1:, 1]

    whole = model.periodic(**given, **span).derivatives[E].of(others)
    alone = [12.0]

    class Alone(orbits.OrbitSolver):
        def solve(self, orbit, setting, *more, **named):
            hertz = setting.omega / (2.0 * np.pi)
            found = super().solve(orbit, setting, *more, **named)
            return None if any(abs(hertz - one) < 1e-6 for one in alone) else found

    monkeypatch.setattr(orbits, "OrbitSolver", Alone)
    found = model.periodic(**given, **span)
    assert found.derivatives[E].of(others) == pytest.approx(whole, rel=1e-12)
    told = "no motion was found beside that of point 1 (12 Hz) for a slightly other"
    assert told in found.derivatives[E].notes[0]
    with pytest.raises(InputError, match=re.escape(told)):
        found.derivatives[E].of(lambda all_of_them: all_of_them.harmonics(0)[:, 1])
    alone += found.frequencies.tolist()
    with pytest.raises(SolveError, match="Ask for frequencies or levels further off"):
        model.periodic(**given, **span)


def test_a_motion_knows_no_unit_of_mass():
    """Dimensional analysis: E, density, mass and force by one factor leave positions, and multiply energies by it."""
    model = assembly()
    keys = [E, "materials.rubber.density", "bodies.tip.mass", "loads[1].value[1]", "joints[0].stiffness.rz"]
    keys += ["joints[0].damping.rz", *(f"bodies.tip.inertia[{k}]" for k in range(3))]
    run = model.simulate(0.01, output_interval=0.005, derivatives=keys)
    changes = [run.derivatives[key] for key in keys]
    for function, power in (
        (lambda run: run.data.position.values, 0.0),
        (lambda run: run.data.elastic.values, 1.0),
    ):
        total = sum(one.value * one.of(function) for one in changes)
        scale = max(np.abs(one.value * one.of(function)).max() for one in changes)
        np.testing.assert_allclose(total, power * function(run), atol=1e-6 * scale)


def test_a_steady_rotation_stretches_as_its_spin_and_modulus_say():
    """Closed form: u'' = -rho omega^2 x/E of a stiff bar from the axis on, u(L) = rho omega^2 L^3/(3 E)."""
    model = vr.Model()
    steel = vr.Material(2e11, poissons_ratio=0.3, density=8000.0)
    section = vr.Rectangle(0.02, 0.02)
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=steel, elements=2))
    model.clamp("bar.start")
    keys = ["rods.bar.material.youngs_modulus", "rods.bar.material.density"]
    found = model.steady(spin=(0, 0, 100.0), centre=(0, 0, 0), derivatives=keys)
    stretch = 8000.0 * 1e4 / (3.0 * 2e11)
    by_modulus, by_density = (found.derivatives[key].history("bar.end").values[-1, 0] for key in keys)
    assert by_modulus == pytest.approx(-stretch / 2e11, rel=1e-3)  # of the square of the strain
    assert by_density == pytest.approx(stretch / 8000.0, rel=1e-3)


def test_steady_rotations_turn_with_a_rod_that_is_clamped_otherwise():
    """Richardson-extrapolated differences, and one formulation the other: where a rod ends turns its clamp, too.

    In the intrinsic one the clamp of the neighbours stayed where it was, and all derivatives were wrong by themselves.
    """
    key, model = "rods.beam.end[1]", vr.Model()
    section, tau = vr.Rectangle(0.02, 0.012), vr.KelvinVoigt(0.004, 0.006)
    material = vr.Material(2.5e6, poissons_ratio=0.4, density=1100.0, damping=tau)
    given = {"section": section, "material": material, "elements": 2, "order": 3}
    model.add("beam", vr.Rod.straight((0.05, 0, 0), (0.3, 0.02, 0.01), **given))
    model.clamp("beam.start")
    for formulation in ("geometric", "intrinsic"):

        def tip(value, formulation=formulation):
            near = with_values(model, {key: value}).steady(spin=(0.0, 0.0, 15.0), formulation=formulation)
            return near.data.position.values[0, -1]

        found = model.steady(spin=(0.0, 0.0, 15.0), formulation=formulation, derivatives=[key])
        mine = found.derivatives[key].data.position.values[0, -1]
        np.testing.assert_allclose(mine, extrapolated(tip, 0.02, 2e-4), atol=1e-7 * np.abs(mine).max())


def test_a_value_with_its_gradient_goes_to_an_optimiser():
    """SciPy finds the modulus that gives a tip's deflection again."""
    from scipy.optimize import least_squares

    model = bar()
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.02, 0))
    given = {"ftol": None, "gtol": None, "xtol": 1e-12}
    wanted = model.equilibrium().position("beam.end")
    function = model.value_and_gradient([E], lambda found: found.position("beam.end"), "equilibrium")
    assert function.values == pytest.approx([2.5e6])
    assert function.units == ["Pa"]
    other = least_squares(
        lambda x: function(x * 1e6)[0] - wanted, [3.0], lambda x: 1e6 * function(x * 1e6)[1], **given
    )
    assert other.x[0] == pytest.approx(2.5, rel=1e-9)


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("rods.beam.elements", "this is a whole number"),
        ("rods.beam.section.breadth", "there is no such number"),
        ("rods.beam.section.shear_factor_1", "it has no value here"),
        ("materials.steel.density", "the names here are rubber"),
        ("loads[7].value[0]", "the first is"),
        ("simulate.duration", "setting of the analysis"),
        ("beam", "not the key of a number"),
        ("supports[0].at", "name a number"),
    ],
)
def test_what_is_no_number_of_a_model_is_refused_by_its_key(key, text):
    with pytest.raises(InputError, match=text):
        swing().equilibrium(derivatives=[key])


def test_numbers_of_directions_of_supports():
    """Extrapolated differences: components of a direction along a global axis, across which axes could be others."""
    model = swing()
    model.roller("beam.end", normal=(0, 0, 1))
    for key in ("supports[1].normal[0]", "supports[1].normal[1]"):
        found = model.equilibrium(derivatives=[key]).derivatives[key]

        def tip(value, key=key):
            return with_values(model, {key: value}).equilibrium().data["position"].values[-1]

        expected = extrapolated(tip, found.value, 1e-3)
        mine = found.data["position"].values[-1]
        np.testing.assert_allclose(mine, expected, atol=1e-7 * np.abs(expected).max(), err_msg=key)


def test_shapes_are_computed_when_they_are_read(monkeypatch):
    """Frequencies alone need no derivatives of shapes; those of the data set have them."""
    seen = []
    near = ShapeRates.near

    def counted(self, *args):
        seen.append(1)
        return near(self, *args)

    monkeypatch.setattr(ShapeRates, "near", counted)
    found = swing().modes(2, derivatives=[E]).derivatives[E]
    assert np.all(found.frequencies > 0.0)
    assert not seen
    assert np.isfinite(found.data["mode_shape"].values).all()
    assert len(seen) == len(found.parts)


def test_numbers_of_shared_and_named_parts():
    """A named material changes wherever it is; one of a rod changes there alone; defaults are numbers too."""
    model = assembly()
    everywhere = CaseNumber.of(model, E).at(3e6)
    assert [rod.material.youngs_modulus for rod in everywhere.rods.values()] == [3e6, 3e6]
    one = CaseNumber.of(model, "rods.arm.material.youngs_modulus").at(3e6)
    assert [rod.material.youngs_modulus for rod in one.rods.values()] == [2.5e6, 3e6]
    assert CaseNumber.of(model, "rods.beam.twist").value == 0.0
    case = vr.load_case("examples/rubber_strip.toml").model(vr.Model)
    assert list(case.materials)


def test_a_number_that_turns_nodes_far_is_taken_closer():
    """Extrapolated differences of a helical spring by its turns: a thousandth of them turns its end by 0.03 rad.

    Section forces show it most; they were 2e-6 of their largest off, and eigenvalues 1e-5.
    """
    rubber = vr.Material(3e7, poissons_ratio=0.48, density=1150.0)
    model = vr.Model()
    shape = {"radius": 0.03, "pitch": 0.02, "turns": 5.0, "axis": (0, 0, -1)}
    given = {"section": vr.Circle(0.004), "material": rubber, "elements": 10, "order": 4}
    model.add("spring", vr.Rod.helix(**shape, **given))
    model.clamp("spring.start")
    model.gravity((0, 0, -9.81))
    key = "rods.spring.turns"

    def forces(value):
        return with_values(model, {key: value}).equilibrium().data["section_force"].values[-1]

    expected = extrapolated(forces, 5.0, 4e-3)
    found = model.equilibrium(derivatives=[key]).derivatives[key]
    mine = found.of(lambda rest: rest.data["section_force"].values[-1])
    np.testing.assert_allclose(mine, expected, atol=1e-7 * np.abs(expected).max())


def test_a_diagonal_is_numbered_as_in_its_file():
    """A section's matrices are written as their diagonals; both keys are the same number."""
    case = vr.load_case("examples/right_angle_frame.toml").model(vr.Model)
    one, other = (CaseNumber.of(case, f"sections.leg.stiffness[4]{more}") for more in ("", "[4]"))
    assert one.value == other.value == 1000.0
    for number in (one, other):
        assert number.at(1100.0).rods["arm"].section.stiffness[4][4] == 1100.0


def test_numbers_of_sections_have_the_names_of_their_files():
    """EI2 is the fifth number of the diagonal; the polar inertia goes along where it is the sum of the others."""
    names = {"GA1": 10.0, "GA2": 11.0, "EA": 20.0, "EI1": 1.0, "EI2": 2.0, "GJ": 1.5}
    inertia = {"mass": 1.0, "J1": 0.1, "J2": 0.2}
    model = vr.Model()
    section = vr.StiffnessSection(stiffness=names, inertia=inertia, times={"EI1": 0.01, "GJ": 0.02})
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    number = CaseNumber.of(model, "rods.beam.section.stiffness.EI2")
    assert number.value == 2.0
    assert number.at(3.0).rods["beam"].section.stiffness[4][4] == 3.0
    assert CaseNumber.of(model, "rods.beam.section.times.GJ").at(0.5).rods["beam"].section.times[5] == 0.5
    whole = {name: CaseNumber.of(model, f"rods.beam.section.inertia.{name}") for name in ("mass", "J1", "J3")}
    diagonals = {
        name: np.diag(one.at(2.0 * one.value).rods["beam"].section.inertia) for name, one in whole.items()
    }
    np.testing.assert_allclose(diagonals["mass"], [2.0, 2.0, 2.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(diagonals["J1"], [1.0, 1.0, 1.0, 0.2, 0.2, 0.4])
    np.testing.assert_allclose(diagonals["J3"], [1.0, 1.0, 1.0, 0.1, 0.2, 0.6])
    with pytest.raises(InputError, match="there is no such number"):
        CaseNumber.of(model, "rods.beam.section.stiffness.EI3")


def test_a_coupling_of_a_section_is_one_number_that_is_written_twice():
    """Closed form: a pulled rod stretches and twists by e = C^-1 f, and de = -C^-1 dC e, dC symmetric."""
    stiffness = np.diag([50.0, 50.0, 100.0, 1.0, 1.0, 0.8])
    stiffness[2, 5] = stiffness[5, 2] = 2.0
    model = vr.Model()
    section = vr.StiffnessSection(stiffness=stiffness.tolist())
    model.add("rope", vr.Rod.straight((0, 0, 0), (2, 0, 0), section=section, elements=2))
    model.clamp("rope.start")
    model.force("rope.end", (5.0, 0, 0))
    strain = np.linalg.solve(stiffness, [0, 0, 5.0, 0, 0, 0])
    both = np.zeros((6, 6))
    both[2, 5] = both[5, 2] = 1.0
    wanted = -np.linalg.solve(stiffness, both @ strain)
    for key in ("rods.rope.section.stiffness[2][5]", "rods.rope.section.stiffness[5][2]"):
        found = model.equilibrium(derivatives=[key]).derivatives[key]
        changed = found.data.strain.values[-1]
        np.testing.assert_allclose(changed, np.tile(wanted, (len(changed), 1)), atol=1e-11)
        np.testing.assert_allclose(found.history("rope.end").values[-1], [2.0 * wanted[2], 0, 0], atol=1e-11)


def test_a_rod_of_another_length_takes_the_end_of_its_pieces_along():
    """Closed form: the end of a pulled rod is at L + F (l/EA_1 + (L - l)/EA_2), its derivative by L 1 + F/EA_2."""
    model, force = vr.Model(), 3.0
    rubber = vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0)
    sections = [(0.1, vr.Rectangle(0.02, 0.01)), (0.3, vr.Rectangle(0.01, 0.01))]
    section = vr.Piecewise(sections)
    model.add(
        "beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=rubber, elements=4, order=2)
    )
    model.clamp("beam.start")
    model.force("beam.end", (force, 0, 0))
    found = model.equilibrium(derivatives=["rods.beam.end[0]"]).derivatives["rods.beam.end[0]"]
    wanted = 1.0 + force / (2.5e6 * 1e-4)
    np.testing.assert_allclose(found.history("beam.end").values[-1], [wanted, 0, 0], atol=1e-9)


def test_plain_numbers_in_the_place_of_functions_of_time_have_derivatives():
    """By definition: all goes along with a clamp that is moved; a factor t of a force F moves by F/t of what F does."""
    model = bar(elements=2)
    model.clamp("beam.start", motion={"ux": 0.01})
    model.force("beam.end", (0, 0.05, 0), time=0.5)
    keys = ["supports[0].motion.ux", "loads[0].time", "loads[0].value[1]"]
    found = model.equilibrium(derivatives=keys).derivatives
    place = found[keys[0]].data.position.values[-1]
    np.testing.assert_allclose(place, np.tile([1.0, 0, 0], (len(place), 1)), atol=1e-10)
    by_factor, by_force = (found[key].data.position.values for key in keys[1:])
    np.testing.assert_allclose(by_factor, 0.1 * by_force, atol=1e-7 * np.abs(by_factor).max())


def test_whole_numbers_have_no_derivatives():
    with pytest.raises(InputError, match="a whole number, which nothing has a derivative by"):
        CaseNumber.of(bar(), "rods.beam.elements")


def test_both_sides_of_a_number_say_why_they_are_refused():
    case = vr.load_case("examples/rubber_strip.toml").model(vr.Model)
    with pytest.raises(InputError, match="is incompressible") as refused:
        case.equilibrium(derivatives=["materials.rubber.poissons_ratio"])
    assert "changes how many different relaxation times" in str(refused.value)

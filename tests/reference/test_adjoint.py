"""Gradients of one scalar of a motion by many numbers: a similarity law, and derivatives by neighbours of the model."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.derivatives import adjoint
from viscorod.analyses.derivatives.case_numbers import with_values
from viscorod.errors import InputError

E, TAU = "materials.rubber.youngs_modulus", "materials.rubber.damping.shear_time"
STORED = ("position", "rotation", "velocity", "angular_velocity")


def rubber(tau=0.004):
    return vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0, damping=vr.KelvinVoigt(tau, tau))


def swing(tau=0.004):
    """A rubber cantilever that hangs aside in equilibrium, and is let go."""
    model = vr.Model()
    model.materials["rubber"] = material = rubber(tau)
    given = {"section": vr.Rectangle(0.02, 0.01), "material": material, "elements": 3, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given))
    model.clamp("beam.start")
    model.force("beam.end", (0.0, 0.05, 0.02), until=0.0)
    return model


def machine():
    """A driven rod with a body beside its end, a spring, wind, a rest strain, and a load that jumps within the motion.

    Another rod begins at the body, off its centre.
    """
    model = swing()
    material = model.materials["rubber"]
    model.add("tip", vr.Body(mass=0.01, centre=(0.3, 0.01, 0), inertia=(1e-5, 2e-5, 3e-5)))
    model.attach("beam.end", "tip")
    section = vr.Rectangle(0.01, 0.01)
    arm = vr.Rod.straight(
        (0.32, 0, 0), (0.4, 0, 0.02), section=section, material=material, elements=1, order=3
    )
    model.add("arm", arm)
    model.attach("arm.start", "tip")
    model.spring("beam@0.15", "ground", stiffness={"uz": 3.0}, damping={"uz": 0.02})
    model.gravity((0, -3.0, -9.81))
    model.force("arm.end", (0.0, 0.1, 0.0), following=True, time=vr.Sine(3.0))
    model.force("beam@0.15", (0.0, 0.0, 0.05), until=0.05)
    model.drag("beam", coefficient_across=1.2, density=50.0, width=0.02, velocity=(0, 2.0, 0))
    model.rest_strain("arm", (0, 0, 0, 0.5, 0.2, 0))
    return model


KEYS = (
    E,
    TAU,
    "rods.beam.section.width",
    "materials.rubber.density",
    "bodies.tip.mass",
    "bodies.tip.inertia[1]",
    "springs[0].stiffness.uz",
    "loads[0].value[1]",
    "loads[1].acceleration[2]",
    "loads[2].time.frequency",
    "loads[4].velocity[1]",
    "rest_strains[0].value[3]",
    "rods.beam.end[0]",
)


def random_weights(run, stations, seed=0):
    rng, found = np.random.default_rng(seed), {}
    for name in STORED:
        found[name] = np.zeros(run.data[name].shape)
        found[name][:, stations] = rng.normal(size=found[name][:, stations].shape)
    return found


def value_of(run, weights):
    return sum(float(np.vdot(by, run.data[name].values)) for name, by in weights.items())


def require_gradient(model, keys, stations, seed=0, **given):
    """Ask that the adjoint of a random scalar is the sum of derivatives by neighbours; return the run with these."""
    seen = {}

    def scalar(run):
        weights = seen.setdefault("weights", random_weights(run, stations, seed))
        return value_of(run, weights), weights

    function = model.value_and_gradient(keys, scalar, adjoint=True, **given)
    value, gradient = function(function.values)
    assert function.way == "adjoint"
    run = model.simulate(**given, derivatives=keys)
    assert value == pytest.approx(value_of(run, seen["weights"]), rel=1e-12)
    for key, found in zip(keys, gradient, strict=True):
        parts = [seen["weights"][name] * run.derivatives[key].data[name].values for name in STORED]
        size = np.sqrt(sum(float((part**2).sum()) for part in parts))
        assert abs(found - sum(float(part.sum()) for part in parts)) < 1e-6 * size, key
    return run


DAMPING = "materials.rubber.damping."


@pytest.mark.parametrize("times", [("shear_time", "bulk_time"), ("shear_times[0]", "shear_times[1]")])
def test_a_swing_obeys_the_similarity_of_linear_viscosity(times):
    """Similarity (Linn, Lang, Tuganov, section 3): stiffness and force times s^2, times over s, at once over s.

    So 2 E J_E + 2 F . J_F - tau . J_tau = t J_t for any J of the shape at the time t, without gravity.
    """
    model, duration = swing() if times[0] == "shear_time" else viscoelastic(), 0.23
    keys = [E, "loads[0].value[1]", "loads[0].value[2]", *(DAMPING + name for name in times)]

    def tip(run):
        weights = np.zeros(run.data.position.shape)
        weights[-1, -1] = 1.0, 2.0, 3.0
        return np.vdot(weights, run.data.position.values), {"position": weights}

    given = {"output_interval": 0.05, "tolerance": 1e-8}
    function = model.value_and_gradient(keys, tip, adjoint=True, duration=duration, **given)
    _, gradient = function(function.values)
    assert function.way == "adjoint"
    speed = model.simulate(duration, **given).data.velocity.values[-1, -1]
    found = gradient @ (function.values * np.array([2.0, 2.0, 2.0, -1.0, -1.0]))
    assert found == pytest.approx(duration * np.dot((1.0, 2.0, 3.0), speed), rel=1e-6)


def test_the_adjoint_is_what_neighbours_say():
    """Neighbours of the model through the same steps: by numbers of every kind, of all that is stored."""
    require_gradient(machine(), KEYS, [2, 9, -1, -2], duration=0.12, output_interval=0.01)


def hinged(held):
    """A cantilever and an arm on a damped hinge at its end, with a body; strains of the arm are held."""
    model = swing()
    given = {"section": vr.Rectangle(0.015, 0.01), "material": model.materials["rubber"]}
    given |= {"elements": 1, "order": 3, "constraints": held}
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.38, 0.02, 0.01), **given))
    model.add("tip", vr.Body(mass=0.01, centre=(0.38, 0.02, 0.01), inertia=(1e-6, 2e-6, 3e-6)))
    model.attach("arm.end", "tip")
    model.rest_strain("arm", (0, 0, 0, 0.5, 0.2, 0))
    model.gravity((0, -3.0, -9.81))
    return model


HINGED = (
    E,
    TAU,
    "rods.beam.section.width",
    "materials.rubber.density",
    "joints[0].axis[0]",
    "rods.arm.end[1]",
    "bodies.tip.mass",
    "rest_strains[0].value[3]",
    "loads[0].value[1]",
)


@pytest.mark.parametrize("held", ["inextensible", "unshearable"])
def test_joints_and_held_strains_have_an_adjoint(held):
    """Neighbours of the model: states that are closed before they are recorded, within steps and at their ends."""
    model = hinged(held)
    hinge = {"stiffness": {"rz": 0.02}, "damping": {"rz": 2e-4}}
    model.revolute("beam.end", "arm.start", axis=(0.1, 1, 0.2), **hinge)
    keys = [*HINGED, "joints[0].stiffness.rz", "joints[0].damping.rz"]
    require_gradient(model, keys, [2, 5, -1, -2], duration=0.06, output_interval=0.01)


def test_velocities_within_steps_are_closed_as_neighbours_close_them():
    """Neighbours of the model, whose recorded velocities were closed with the matrix of an older step: 3e-6 apart."""
    model, end = vr.Model(), (0.3, 0.09474, 0.02606)
    damping = vr.KelvinVoigt(0.01419, 0.01137)
    model.materials["rubber"] = vr.Material(2.618e7, poissons_ratio=0.28, density=1100.0, damping=damping)
    given = {"section": vr.Rectangle(0.01773, 0.0122), "material": model.materials["rubber"], "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), end, elements=2, **given))
    model.add("arm", vr.Rod.straight(end, (0.4, *end[1:]), elements=1, **given))
    model.add("tip", vr.Body(mass=0.02, centre=(0.4, *end[1:]), inertia=(2e-6, 3e-6, 4e-6)))
    model.attach("arm.end", "tip")
    model.clamp("beam.start")
    model.gravity((3.3, 3.3, 5.0))
    model.force("beam.end", (-0.26, 0.56, -0.79), until=0.0)
    model.revolute("beam.end", "arm.start", axis=(0, 1, 0), stiffness={"rz": 0.436}, damping={"rz": 0.00436})
    keys = [E, "joints[0].stiffness.rz", "materials.rubber.density"]
    given = {"duration": 0.05, "output_interval": 0.01}
    run = model.simulate(**given, derivatives=keys)
    weights = random_weights(run, slice(None))
    weights = {name: weights[name] for name in ("velocity", "angular_velocity")}
    function = model.value_and_gradient(
        keys, lambda run: (value_of(run, weights), weights), adjoint=True, **given
    )
    for key, found in zip(keys, function(function.values)[1], strict=True):
        parts = [by * run.derivatives[key].data[name].values for name, by in weights.items()]
        size = np.sqrt(sum(float((part**2).sum()) for part in parts))
        assert abs(found - sum(float(part.sum()) for part in parts)) < 7e-7 * size, key


def test_a_rod_that_hangs_still_does_so_under_any_gravity(monkeypatch):
    """By equilibrium: velocities are zero and change by nothing, however far apart the neighbours are.

    Differences of two settled neighbours left 2e-6 here, which grew with the square of their distance.
    """
    monkeypatch.setattr(adjoint, "change_of", lambda steps: 5e-4)
    model = swing()
    model.loads.clear()
    model.gravity((0, -3.0, -9.81))
    model = with_values(model, {E: 3e5})
    given = {"duration": 0.05, "output_interval": 0.01}
    run, keys = model.simulate(**given), [f"loads[0].acceleration[{k}]" for k in (1, 2)]
    weights = random_weights(run, slice(None))
    weights = {name: weights[name] for name in ("velocity", "angular_velocity")}
    function = model.value_and_gradient(
        keys, lambda run: (value_of(run, weights), weights), adjoint=True, **given
    )
    gradient = function(function.values)[1]
    assert function.way == "adjoint"
    assert np.abs(gradient).max() < 5e-8  # m/s per m/s^2, and rad/s


def test_supports_that_hold_rotations_in_part_have_an_adjoint():
    """Neighbours of the model: an oblique axle, whose velocities are corrected at the end of every step."""
    model = vr.Model()
    model.materials["rubber"] = material = rubber()
    given = {"section": vr.Rectangle(0.02, 0.01), "material": material, "elements": 3, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given))
    model.support("beam.start", ("ux", "uy", "uz", "rx", "ry"), axes=((0.8, 0, 0.6), (0, 1, 0)))
    model.spring("beam.end", "ground", stiffness={"ux": 5.0, "uy": 5.0, "uz": 5.0})
    model.gravity((0, -3.0, -9.81))
    model.force("beam.end", (0.0, 0.05, 0.02), until=0.0)
    model.force("beam@0.15", (0.0, 0.0, 0.02), time=vr.Sine(4.0), following=True)
    keys = [E, TAU, "springs[0].stiffness.uy", "rods.beam.end[1]", "rods.beam.start[2]"]
    keys += ["loads[0].acceleration[1]", "loads[1].value[1]", "rods.beam.section.width"]
    require_gradient(model, keys, [2, 5, -1], duration=0.12, output_interval=0.013)


def test_driven_joints_and_a_start_with_velocities_have_an_adjoint():
    """Neighbours of the model: a motor turns the arm from the start, and the whole flies about its hinge."""
    model = hinged("inextensible")
    model.revolute("beam.end", "arm.start", axis=(0.1, 1, 0.2), motion={"rz": vr.Sine(5.0, amplitude=0.3)})
    keys = [key for key in HINGED if "mass" not in key]
    require_gradient(model, keys, [2, 5, -1], seed=1, duration=0.06, output_interval=0.013)


def test_a_start_with_velocities_changes_by_them():
    """Neighbours of the model: initial velocities about a point, of a free rod, whose reference shape is the start."""
    model = swing()
    free = vr.Model()
    free.materials["rubber"] = model.materials["rubber"]
    free.add("beam", model.rods["beam"])
    free.velocity("beam", linear=(0.1, 0.0, 0.2), angular=(0.0, 3.0, 5.0), point=(0.1, 0, 0))
    keys = [E, "velocities[0].angular[2]", "velocities[0].point[0]", "rods.beam.end[0]"]
    given = {"duration": 0.1, "output_interval": 0.03, "tolerance": 1e-6}
    run = require_gradient(free, keys, [0, -1], seed=3, **given)
    start = run.derivatives["rods.beam.end[0]"].data.position.values[0]
    np.testing.assert_allclose(start[[0, -1]], [(0, 0, 0), (1, 0, 0)], atol=1e-9)


def viscoelastic():
    """A cantilever with two Maxwell branches and a rest strain, aside in equilibrium and let go."""
    model = swing()
    prony = vr.Prony(shear_ratios=[0.3, 0.2], shear_times=[0.003, 0.03], constant="bulk_modulus")
    material = vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0, damping=prony)
    model.materials["rubber"] = material
    model.rods["beam"] = model.rods["beam"].model_copy(update={"material": material})
    model.rest_strain("beam", (0, 0, 0, 0.3, 0.2, 0))
    return model


def test_maxwell_branches_have_an_adjoint():
    """Neighbours of the model: by moduli, by what only the start sees, over a jump of a load."""
    model = viscoelastic()
    model.force("beam@0.15", (0.0, 0.0, 0.05), until=0.05)
    keys = [E, "materials.rubber.density", "rods.beam.section.width", "rest_strains[0].value[3]"]
    keys += ["loads[0].value[1]", "loads[1].value[2]"]
    require_gradient(model, keys, [4, -1], duration=0.12, output_interval=0.02)


@pytest.mark.parametrize("seed", range(6))
def test_random_models_have_the_gradient_of_neighbours(seed):
    """Neighbours of random models: sections, laws, bodies, springs, rest strains, a drive, a moving clamp."""
    rng = np.random.default_rng(seed)
    model, modulus = vr.Model(), float(10.0 ** rng.uniform(6.0, 7.0))
    times = sorted(rng.uniform(0.002, 0.02, 2).tolist())
    prony = vr.Prony(shear_ratios=[0.3, 0.1], shear_times=times, constant="bulk_modulus")
    damping = prony if rng.random() < 0.4 else vr.KelvinVoigt(*times)
    model.materials["rubber"] = material = vr.Material(
        modulus, poissons_ratio=float(rng.uniform(0.2, 0.48)), density=1100.0, damping=damping
    )
    end = np.array([0.3, *rng.uniform(-0.1, 0.1, 2)])
    section = vr.Rectangle(*rng.uniform(0.008, 0.02, 2).tolist())
    orders = {"elements": int(rng.integers(1, 4)), "order": int(rng.integers(2, 5))}
    model.add("beam", vr.Rod.straight((0, 0, 0), tuple(end), section=section, material=material, **orders))
    model.clamp("beam.start", motion={"uz": vr.Sine(4.0, amplitude=0.01)} if rng.random() < 0.5 else None)
    model.gravity(tuple(rng.normal(size=3) * 4.0))
    size = 1e-10 * modulus
    model.force("beam.end", tuple(rng.normal(size=3) * size), until=0.0)
    model.moment("beam.end", tuple(rng.normal(size=3) * 0.1 * size), time=vr.Sine(5.0), following=True)
    keys = [E, "rods.beam.section.width", "materials.rubber.density", "loads[2].value[1]"]
    if rng.random() < 0.5:
        model.add("tip", vr.Body(mass=0.02, centre=tuple(end + 0.01), inertia=(2e-6, 3e-6, 4e-6)))
        model.attach("beam.end", "tip")
        keys.append("bodies.tip.mass")
    if rng.random() < 0.5:
        model.rest_strain("beam", (0, 0, 0, *(rng.normal(size=3) * 0.5)))
        keys.append("rest_strains[0].value[3]")
    if rng.random() < 0.5:
        model.spring("beam.end", "ground", stiffness={"ux": 30.0 * size, "uy": 20.0 * size})
    require_gradient(model, keys, [1, -1], seed=seed, duration=0.06, output_interval=0.013)


@pytest.mark.parametrize("part", ["jump at a joint", "place", "integrator"])
def test_what_has_no_adjoint_has_the_gradient_of_neighbours(part):
    """The same numbers, and the function tells the way."""
    model = viscoelastic() if part == "place" else swing()
    key = "rods.beam.end[0]" if part == "place" else E
    given = {"duration": 0.04, "output_interval": 0.01}
    if part == "jump at a joint":
        arm = vr.Rod.straight(
            (0.3, 0, 0), (0.4, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber(), elements=1
        )
        model.add("arm", arm)
        model.ball("beam.end", "arm.start")
        model.force("arm.end", (0.1, 0, 0))
        model.force("arm.end", (0, 0.01, 0), until=0.02)
    elif part == "integrator":
        given |= {"integrator": "generalized_alpha", "time_step": 2e-3}

    def scalar(run):
        weights = np.ones(run.data.position.shape)
        return float(run.data.position.values.sum()), {"position": weights}

    function = model.value_and_gradient([key], scalar, adjoint=True, **given)
    _, gradient = function(function.values)
    assert function.way.startswith("neighbours of the model")
    expected = model.simulate(**given, derivatives=[key]).derivatives[key].data.position.values.sum()
    assert gradient[0] == pytest.approx(expected, rel=1e-9)


def test_what_the_adjoint_cannot_use_is_refused():
    model = swing()
    given = {"adjoint": True, "duration": 0.02, "output_interval": 0.01}
    with pytest.raises(InputError, match="one number and its derivatives"):
        model.value_and_gradient([E], lambda run: run.history("beam.end").values.max(), **given)([2.5e6])
    with pytest.raises(InputError, match="differentiate by position"):
        model.value_and_gradient([E], lambda run: (0.0, {"strain": run.data.strain.values}), **given)([2.5e6])
    with pytest.raises(InputError, match="one number for each"):
        model.value_and_gradient([E], lambda run: (0.0, {"position": np.ones(3)}), **given)([2.5e6])
    with pytest.raises(InputError, match="only motions have an adjoint"):
        model.value_and_gradient([E], lambda found: found, "equilibrium", adjoint=True)

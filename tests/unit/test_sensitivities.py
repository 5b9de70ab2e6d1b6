"""Derivatives of equilibria, steps and motions: closed forms, stability functions, differences, the adjoint."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.errors import InputError
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.sensitivity import motion_sensitivity
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.balance import Balance
from viscorod.solve.sensitivity.equilibrium_sensitivity import EquilibriumSensitivity, actions_of
from viscorod.solve.sensitivity.motion_sensitivity import KeptSteps, Look
from viscorod.solve.sensitivity.stage_records import StageRecord
from viscorod.solve.sensitivity.step_linearisation import StepLinearisation
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.midpoint import Midpoint
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.recorded_steps import RecordedSteps
from viscorod.solve.transient.step_control import ErrorControl
from viscorod.solve.transient.transient_solver import Transient

C, _, M = vr.Rectangle(0.02, 0.01).matrices(vr.Material(1e6, poissons_ratio=0.3, density=1000.0))


def rotation(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def extrapolated(function, size=2e-3):
    """The derivative at 0 by two central differences (Richardson): error of the fourth order."""
    first, second = ((function(h) - function(-h)) / (2.0 * h) for h in (size, 0.5 * size))
    return (4.0 * second - first) / 3.0


# --- equilibria


def cantilever(force, stiffer=0.0, elements=3):
    model = vr.Model()
    section = vr.StiffnessSection((1.0 + stiffer) * C, M)
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=4))
    model.clamp("beam.start")
    model.force("beam.end", force)
    return model


def arch_with_a_joint(stiffer=0.0):
    """Two rods with a hinge between them, the second one inextensible, hinged and clamped, under gravity.

    The first one stiffens with its curvature, by a law that the parameters do not change.
    """
    model = vr.Model()
    section = vr.StiffnessSection((1.0 + stiffer) * C, M)
    law = vr.CubicBending(cubic=0.3 / (1.0 + stiffer))
    left = vr.Rod.straight((0, 0, 0), (0.5, 0.2, 0), section=section, elements=2, order=3, law=law)
    model.add("left", left)
    right = vr.Rod.straight(
        (0.5, 0.2, 0), (1, 0, 0), section=section, elements=2, order=3, constraints="inextensible"
    )
    model.add("right", right)
    model.revolute("left.end", "right.start", axis=(0, 0, 1))
    model.support("left.start", ("ux", "uy", "uz", "rx", "ry"))
    model.clamp("right.end")
    model.gravity((0, -0.05, 0.02))
    return model


def solved(model):
    problem = discretise(model)
    system = GeometricSystem(problem)
    solver = StaticSolver(system, SupportState(problem), tolerance=1e-12)
    state = State.reference(problem)
    assert solver.solve(state).outcome.name == "COMPLETED"
    return solver, state


def all_stiffer(system):
    changes = ArrayChanges.none(system.problem, system.elements())
    changes.stiffness[:] = system.elements().stiffness
    return changes


def test_a_cantilever_softens_as_one_over_its_modulus():
    """Closed form: the tip of F L^3/(3 EI) + F L/(GA) moves by -w for dE/E, and by w/F for the force."""
    force = 1e-7
    solver, state = solved(cantilever((0, force, 0), elements=1))
    problem = solver.system.problem
    tip = problem.stations.nodes[-1]
    deflection = force * (1.0 / (3.0 * C[4, 4]) + 1.0 / C[1, 1])
    sensitivity = EquilibriumSensitivity(solver, state)
    stiffer, factor = all_stiffer(solver.system), ArrayChanges.none(problem, solver.system.elements())
    factor.factors[0] = 1.0
    weights = np.zeros((problem.size, 6))
    weights[tip, :3] = rotation(state.q[tip])[1]
    gradient = sensitivity.adjoint(weights)
    for changes, expected in ((stiffer, -deflection), (factor, deflection)):
        moved = rotation(state.q[tip]) @ sensitivity.direct(changes)[tip, :3]
        assert moved[1] == pytest.approx(expected, rel=1e-6)
        assert gradient.product(changes) == pytest.approx(moved[1], rel=1e-9)


@pytest.mark.parametrize("make", [lambda h=0.0: cantilever((0.0, 2e-2, 5e-3), h), arch_with_a_joint])
def test_large_deflections_change_as_differences_say(make):
    """Richardson-extrapolated differences of equilibria; the adjoint is the direct derivative, transposed."""
    solver, state = solved(make())
    system = solver.system
    sensitivity = EquilibriumSensitivity(solver, state)
    increments = sensitivity.direct(all_stiffer(system))
    moved = np.array([rotation(q) @ p for q, p in zip(state.q, increments[:, :3], strict=True)])
    expected = extrapolated(lambda h: solved(make(h))[1].r)
    assert np.abs(expected).max() > 5e-3
    np.testing.assert_allclose(moved, expected, atol=1e-7 * np.abs(expected).max())
    weights = np.random.default_rng(1).normal(size=increments.shape)
    gradient = sensitivity.adjoint(weights)
    assert gradient.product(all_stiffer(system)) == pytest.approx(np.vdot(weights, increments), rel=1e-9)


def test_mass_and_rest_strain_enter_by_gravity_and_by_the_reference():
    """Twice the mass is twice gravity; a rest strain that grows is a reference strain."""
    solver, state = solved(arch_with_a_joint())
    system, problem = solver.system, solver.system.problem
    sensitivity = EquilibriumSensitivity(solver, state)
    heavier, gravity, bent = (ArrayChanges.none(problem, system.elements()) for _ in range(3))
    heavier.mass[:] = problem.mass
    gravity.factors[0] = 1.0
    np.testing.assert_allclose(sensitivity.direct(heavier), sensitivity.direct(gravity), atol=1e-10)
    bent.reference[..., 5] = 1.0

    def made(h):
        model = arch_with_a_joint()
        for rod in ("left", "right"):
            model.rest_strain(rod, (0, 0, 0, 0, 0, h))
        return solved(model)[1].r

    moved = sensitivity.direct(bent)[:, :3]
    moved = np.array([rotation(q) @ p for q, p in zip(state.q, moved, strict=True)])
    expected = extrapolated(made, 1e-2)
    np.testing.assert_allclose(moved, expected, atol=1e-7 * np.abs(expected).max())


def test_what_has_no_derivatives_is_refused():
    towed = swing(drive=0.0)
    towed.body_velocity("beam.end", fixed=("v1",))
    with pytest.raises(InputError, match="velocities along the axes"):
        list(motion_sensitivity.forward(KeptSteps(integrator(towed)), []))
    problem = discretise(swing())
    midpoint = Midpoint(GeometricSystem(problem), SupportState(problem))
    with pytest.raises(InputError, match="midpoint"):
        list(motion_sensitivity.forward(KeptSteps(midpoint), []))
    steps, _ = moved(linked())
    steps.start(steps.times[-1], steps.integrator.state)
    with pytest.raises(InputError, match=r"jump at t = 0.185 s"):
        motion_sensitivity.gradient(steps, lambda *_: None)
    branches = vr.Model()
    section = vr.StiffnessSection(C, M, branches=[vr.MaxwellBranch(0.1, 0.1 * C)])
    branches.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1))
    branches.clamp("beam.start")
    with pytest.raises(InputError, match="Maxwell branches"):
        list(motion_sensitivity.forward(KeptSteps(integrator(branches)), []))


# --- steps


def swing(stiffer=0.0, heavier=0.0, dampers=0.0, drive=0.3):
    """A soft cantilever whose clamp turns, under gravity, a following force and wind, with large rotations."""
    model = vr.Model()
    section = vr.StiffnessSection(
        0.1 * (1.0 + stiffer) * C, (1.0 + heavier) * np.array(M), damping=4e-4 * (1.0 + dampers) * C
    )
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=2, order=3))
    model.clamp("beam.start", motion={"rz": vr.Sine(0.7, amplitude=drive)} if drive else None)
    if drive:
        model.gravity((0, -4, 3.0))
        model.force("beam.end", (0.01, 0.02, 0), following=True, time=vr.Sine(2.0))
        wind = {"density": 1.2, "width": 0.02, "velocity": (0.0, 2.0, 1.0)}
        model.drag("beam", coefficient_across=1.2, linear_along=0.05, **wind)
    return model


def linked(stiffer=0.0, heavier=0.0, dampers=0.0):
    """A rod that hangs on a hinge with a spring and a damper, and an unshearable one in a ball joint at its end.

    Both in a viscous medium; the first one stiffens with its curvature, by a law that the parameters do not change.
    """
    model = vr.Model()
    section = vr.StiffnessSection(
        0.1 * (1.0 + stiffer) * C, (1.0 + heavier) * np.array(M), damping=4e-4 * (1.0 + dampers) * C
    )
    given = {"section": section, "elements": 1, "order": 3}
    law = vr.CubicBending(cubic=2e-3 / (1.0 + stiffer), time=1e-3)
    model.add("upper", vr.Rod.straight((0, 0, 0), (0.2, 0, 0), **given, law=law))
    model.add("lower", vr.Rod.straight((0.2, 0, 0), (0.3, 0, 0), **given, constraints="unshearable"))
    model.revolute("upper.start", "ground", axis=(0, 0, 1), stiffness={"rz": 1e-2}, damping={"rz": 1e-4})
    model.ball("upper.end", "lower.start")
    model.gravity((0, -6, 0))
    model.force("lower.end", (0.0, 0.0, 0.02), time=vr.Sine(3.0))
    for rod in ("upper", "lower"):
        model.drag(rod, linear_across=0.05, coefficient_across=1.2, density=200.0, width=0.02)
    return model


def propped(stiffer=0.0, heavier=0.0, dampers=0.0):
    """A rod that is pinned at one end and slides on a moving roller, oblique to the axes, at the other."""
    model = vr.Model()
    section = vr.StiffnessSection(
        0.1 * (1.0 + stiffer) * C, (1.0 + heavier) * np.array(M), damping=4e-4 * (1.0 + dampers) * C
    )
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=2, order=3))
    model.support("beam.start", ("ux", "uy", "uz"))
    slope = ((0.8, 0.6, 0.0), (-0.6, 0.8, 0.0))
    model.support("beam.end", ("uz",), axes=slope, motion={"uy": vr.Sine(2.0, amplitude=0.03)})
    model.gravity((0, -2, 1))
    return model


def pivoted(stiffer=0.0, heavier=0.0, dampers=0.0):
    """A rod that swings about an oblique axle at its end, twisted by a moment."""
    model = vr.Model()
    section = vr.StiffnessSection(
        0.1 * (1.0 + stiffer) * C, (1.0 + heavier) * np.array(M), damping=4e-4 * (1.0 + dampers) * C
    )
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=2, order=3))
    slope = ((0.8, 0.0, 0.6), (0.0, 1.0, 0.0))
    model.support("beam.start", ("ux", "uy", "uz", "rx", "ry"), axes=slope)
    model.gravity((0, -4, 1))
    model.moment("beam.end", (2e-4, 0.0, 0.0), time=vr.Sine(3.0))
    return model


class ExactRadau(Radau):
    """Iterates to round-off, so that differences of motions are those of the method."""

    iterations = 80

    def _newton_tolerance(self):
        return 1e-12


def integrator(model):
    problem = discretise(model)
    return ExactRadau(GeometricSystem(problem), SupportState(problem), tolerance=1e-6)


def stability_function(Z):
    """R(Z) of Radau IIA with three stages (Hairer and Wanner 1996, table IV.3.1)."""
    unit, square = np.eye(len(Z)), Z @ Z
    below = unit - 3.0 / 5.0 * Z + 3.0 / 20.0 * square - square @ Z / 60.0
    return np.linalg.solve(below, unit + 2.0 / 5.0 * Z + square / 20.0)


def test_a_step_at_rest_is_the_stability_function():
    """Small vibrations about rest: the transition is R(hA), of the matrices of M x'' + D x' + K x = 0."""
    method, h = integrator(swing(drive=0.0)), 3e-3
    problem = method.system.problem
    method.start(0.0, State.reference(problem))
    assert method.attempt(h, before=False).converged
    linear = StepLinearisation(method)
    linear.linearise(StageRecord.of(method, h, before=False))
    found = np.vstack(linear.forward(*np.split(np.eye(12 * problem.size), 2)))
    resting = State.reference(problem)
    balance = Balance(actions_of(method.system), resting, np.zeros_like(resting.twist), 0.0, before=False)
    free = np.repeat(method.body.held == 0.0, 6)
    inverse = np.linalg.inv(block_diagonal(problem.mass).toarray()[free][:, free])
    K, D = (matrix.toarray()[free][:, free] for matrix in (balance.pose, balance.twist))
    none, unit = np.zeros_like(K), np.eye(len(K))
    expected = stability_function(h * np.block([[none, unit], [-inverse @ K, -inverse @ D]]))
    both = np.concatenate([free, free])
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found[both][:, both], expected, atol=1e-9 * scale)
    assert not found[~both].any()


# --- motions

ENDS = np.cumsum([0.02, 0.015, 0.025, 0.03, 0.02, 0.02, 0.03, 0.025])


def moved(model, every=3, memory=10**8):
    """States at the ends of given steps, and the record of these."""
    method = integrator(model)
    steps = KeptSteps(method, every, memory)
    steps.start(0.0, State.reference(method.system.problem))
    states = [method.state.copy()]
    for number, end in enumerate(ENDS):
        if number == 4:
            steps.attempt(end + 0.02, before=True)  # not accepted: its factors stay behind
        if number == 6 and not method.system.constraints.rows and not len(method.supports.partial):
            steps.start(method.t, method.state)  # as after a jump of loads
        assert steps.attempt(end, before=True).converged
        steps.accept()
        states.append(method.state.copy())
    return steps, states


PARAMETERS = {"stiffer": "stiffness", "dampers": "damping", "heavier": "mass"}


@pytest.fixture(scope="module", params=[swing, linked, propped, pivoted])
def motion(request):
    make = request.param
    steps, states = moved(make())
    system = steps.integrator.system
    elements, problem = system.elements(), system.problem
    arrays = {"stiffness": elements.stiffness, "damping": elements.damping, "mass": problem.mass}
    changes = []
    for name in PARAMETERS.values():
        changes.append(ArrayChanges.none(problem, elements))
        getattr(changes[-1], name)[:] = arrays[name]
    return make, steps, states, changes, list(motion_sensitivity.forward(steps, changes))


def test_steps_are_gone_through_again_bit_for_bit(motion):
    """Identity, from every checkpoint, in any order, with a failed attempt between; by a run that picks its steps."""
    make, steps, states = motion[:3]
    for stretch in (2, 0, 1, 2):
        for step in steps.again(stretch):
            here = steps.integrator.state
            for name in ("r", "q", "twist"):
                assert (getattr(here, name) == getattr(states[step.number], name)).all()
    assert steps.times == [0.0, *ENDS]
    method = integrator(make())
    steps, seen = RecordedSteps(method, every=4), []
    problem = method.system.problem
    run = Transient(problem, steps, ErrorControl(method.estimate_order, largest=0.02, duration=0.2))
    run.run(State.reference(problem), 0.2, after_step=lambda: seen.append(method.state.copy()) or "")
    again = [
        steps.integrator.state.r.copy() for stretch in range(steps.stretches) for _ in steps.again(stretch)
    ]
    assert len(again) == len(seen) > 4
    assert all((r == state.r).all() for r, state in zip(again[1:], seen, strict=False))


@pytest.mark.parametrize("number", range(len(PARAMETERS)))
def test_a_motion_changes_as_differences_say(motion, number):
    """Richardson-extrapolated differences of motions with the same steps: poses and twists of all nodes at all ends."""
    make, _, states, _, changed = motion
    name = list(PARAMETERS)[number]

    def flat(h):
        return np.array([np.hstack([state.r, state.twist]) for state in moved(make(**{name: h}))[1]])

    expected = extrapolated(flat)
    assert len(changed) == len(states) == len(ENDS) + 1
    for here, state, wanted in zip(changed, states, expected, strict=True):
        turned = [rotation(q) @ p for q, p in zip(state.q, here.pose[number, :, :3], strict=True)]
        for found, known in ((turned, wanted[:, :3]), (here.twist[number], wanted[:, 3:])):
            np.testing.assert_allclose(found, known, atol=3e-8 * max(np.abs(known).max(), 1e-3))


def test_the_adjoint_is_the_forward_derivative(motion):
    """Of a scalar of the tip at two ends of steps; by all parameters at once, and by the state at the start."""
    _, steps, states, changes, changed = motion
    rng = np.random.default_rng(2)
    looked = {
        4: Look(*rng.normal(size=(2, *states[0].twist.shape))),
        len(ENDS): Look(*rng.normal(size=(2, *states[0].twist.shape))),
    }
    found = motion_sensitivity.gradient(steps, lambda k, *_: looked.get(k))
    for k, change in enumerate(changes):
        expected = sum(
            np.vdot(weights[0], changed[at].pose[k]) + np.vdot(weights[1], changed[at].twist[k])
            for at, weights in looked.items()
        )
        assert found.arrays.product(change) == pytest.approx(expected, rel=1e-9)
    system, supports = steps.integrator.system, steps.integrator.supports
    start = rng.normal(size=(2, 1, *states[0].twist.shape))
    for node in supports.set.nodes:  # what supports may hold does not change
        start[:, :, node] = 0.0
    none = ArrayChanges.none(system.problem, system.elements())
    ends = list(motion_sensitivity.forward(steps, [none], (start[0], start[1])))
    expected = sum(np.vdot(w[0], ends[at].pose) + np.vdot(w[1], ends[at].twist) for at, w in looked.items())
    assert np.vdot(found.pose, start[0]) + np.vdot(found.twist, start[1]) == pytest.approx(expected, rel=1e-9)


def test_stages_that_are_computed_again_are_those_that_were_kept(motion):
    """Identity: with memory for the stages of one step the gradient is the same."""
    make, steps, states = motion[:3]
    weights = np.random.default_rng(4).normal(size=(2, *states[0].twist.shape))

    def seen(k, *_):
        return Look(*weights) if k in (3, len(ENDS)) else None

    whole = motion_sensitivity.gradient(steps, seen)
    again = motion_sensitivity.gradient(moved(make(), memory=1)[0], seen)
    for mine, its in zip((*whole.arrays, whole.pose), (*again.arrays, again.pose), strict=True):
        np.testing.assert_allclose(mine, its, rtol=1e-9, atol=1e-9 * np.abs(its).max(initial=0.0))


def test_a_linearised_step_and_its_transpose_have_one_dot_product(motion):
    """Identity: w . A v = A' w . v, of states and of the arrays of the problem, for random v and w."""
    steps = motion[1]
    linear, rng = StepLinearisation(steps.integrator), np.random.default_rng(3)
    system = steps.integrator.system
    free = np.repeat(steps.integrator.body.held == 0.0, 6)[:, None]
    change = ArrayChanges(
        *(rng.normal(size=part.shape) * part for part in ArrayChanges.none(system.problem, system.elements()))
    )
    change.stiffness[:] = rng.normal(size=change.stiffness.shape) * system.elements().stiffness
    change.mass[:] = rng.normal(size=change.mass.shape) * system.problem.mass
    change.reference[:] = 1e-2 * rng.normal(size=change.reference.shape)
    for _, step in steps.stages(1):
        linear.linearise(step)
        v, w = rng.normal(size=(2, 2, len(free), 1))
        v *= free
        end = linear.forward(*v, [change])
        start_pose, start_twist, arrays = linear.backward(*w)
        forward = np.vdot(w[0], end[0]) + np.vdot(w[1], end[1])
        backward = np.vdot(v[0], start_pose) + np.vdot(v[1], start_twist) + arrays.product(change)
        size = np.linalg.norm(w) * np.linalg.norm(end)
        assert abs(forward - backward) < 1e-11 * size


def released(stiffer=0.0, dampers=0.0):
    """A cantilever that hangs in equilibrium under a force, which lets go at t = 0; the state at the given ends."""
    section = vr.StiffnessSection((1.0 + stiffer) * C, M, damping=0.01 * (1.0 + dampers) * C)
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), section=section, elements=2, order=3))
    model.clamp("beam.start")
    model.force("beam.end", (0.0, 0.02, 0.01), until=0.0)
    solver, state = solved(model)
    method = integrator(model)
    steps = KeptSteps(method, every=4)
    steps.start(0.0, state.copy())
    tips = []
    for end in ENDS:
        assert steps.attempt(end, before=False).converged
        steps.accept()
        tips.append(method.state.r[-1].copy())
    return solver, state, steps, np.array(tips)


def test_a_release_from_equilibrium_changes_by_its_start_too():
    """The tip's history by modulus and viscosity: differences, which find the equilibrium anew; the adjoint as well."""
    solver, state, steps, _ = released()
    system = solver.system
    problem, elements = system.problem, system.elements()
    start = EquilibriumSensitivity(solver, state)
    viscous = ArrayChanges.none(problem, elements)
    viscous.damping[:] = elements.damping
    changes = [all_stiffer(system), viscous]
    poses = np.array([start.direct(change) for change in changes])
    history = list(motion_sensitivity.forward(steps, changes, (poses, np.zeros_like(poses))))[1:]
    for k, name in enumerate(("stiffer", "dampers")):
        expected = extrapolated(lambda h, name=name: released(**{name: h})[3])
        found = np.array([rotation(here.state.q[-1]) @ here.pose[k, -1, :3] for here in history])
        assert np.abs(expected).max() > 1e-4
        np.testing.assert_allclose(found, expected, atol=1e-7 * np.abs(expected).max())
    weights = np.zeros((2, problem.size, 6))
    weights[0, -1, :3] = rotation(history[-1].state.q[-1])[1]  # the height of the tip at the end
    gradient = motion_sensitivity.gradient(steps, lambda k, *_: Look(*weights) if k == len(ENDS) else None)
    gradient.arrays.add(start.adjoint(gradient.pose))
    for k, change in enumerate(changes):
        expected = np.vdot(weights[0], history[-1].pose[k])
        assert gradient.arrays.product(change) == pytest.approx(expected, rel=1e-8)

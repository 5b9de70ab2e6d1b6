"""Motions in threads: kernels run without Python's lock and share nothing."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.step_control import ErrorControl
from viscorod.solve.transient.transient_solver import Transient

DURATION = 0.2


def _history(acceleration: float) -> tuple[np.ndarray, ...]:
    """Let a damped rubber cantilever fall, and return times, positions, section forces and energies."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=material, elements=1, order=4)
    model = vr.Model()
    model.add("rod", rod)
    model.clamp("rod.start")
    model.gravity((0, 0, -acceleration))
    problem = discretise(model)
    system = GeometricSystem(problem)
    integrator = Radau(system, SupportState(problem), tolerance=1e-4)
    control = ErrorControl(integrator.estimate_order, DURATION / 10, DURATION)
    run = Transient(problem, integrator, control)
    history = run.run(State.reference(problem), DURATION, output_interval=DURATION / 40).history
    return (
        np.array(history.instant),
        np.array([snapshot.state.r for snapshot in history.snapshots]),
        np.array([snapshot.section_force for snapshot in history.snapshots]),
        history.energies()[0],
    )


def test_two_motions_in_two_threads_are_those_of_one_after_the_other():
    """Bit for bit."""
    falls = (9.81, 1.62)
    alone = [_history(fall) for fall in falls]
    assert not np.array_equal(alone[0][1], alone[1][1])
    with ThreadPoolExecutor(2) as threads:
        for _ in range(2):
            together = list(threads.map(_history, falls))
            for one, other in zip(alone, together, strict=True):
                for before, now in zip(one, other, strict=True):
                    np.testing.assert_array_equal(before, now)

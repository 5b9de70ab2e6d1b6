"""The cases in PyElastica: staggered Cosserat rods, explicit symplectic time steps."""

from __future__ import annotations

import time
from dataclasses import dataclass
from importlib.metadata import version
from math import ceil, pi, sqrt
from typing import Any

import elastica as ea
import numpy as np

from .cases import Case, Floats, PeerRun
from .chain import held_angles

PROGRAM = "PyElastica"
LONGEST = 60.0
"""Time loops that would take longer are measured on their first part and extrapolated, s; the trajectory ends there."""


class _Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing):
    """What the cases need of PyElastica's modules."""


@dataclass(frozen=True)
class _Model:
    simulator: Any
    rod: Any


def run(case: Case, elements: int, *, time_step: float | None = None, repeats: int = 2) -> PeerRun:
    """Compute `case` with `elements` and the largest stable step.

    How it is modelled:
        One rod of the same mass, rotary inertia, shear, axial, bending and torsional stiffness (the matrices
        of the rod are overwritten). Differs from the reference:

        - No material damping: PyElastica's dampers act on velocities against the surroundings, none on strain
          rates. The motion is to be compared with `case.undamped()`, and only such a case is taken.
        - The section's area follows the stretch (constant volume), which changes the stiffness in second
          order of the strain.
        - `OneEndFixedBC` holds the first node and the whole first element straight, so that the rod is clamped
          at half an element from its first node. The rod begins that half element before the clamp, with
          elements of length L/(n - 1/2); without this the error is of first order in 1/n.
        - There is no static solver: the preloaded start is the equilibrium of the same staggered chain,
          from `chain.held_angles`.

    `PositionVerlet` is used, one evaluation of forces for each step, as the shortest loop at the limit of
    stability (`PEFRL`, of fourth order with four evaluations, was not tried: time is not what limits accuracy). Without
    `time_step`, the step is 0.95 times the largest stable one, found by bisection on the first part of the
    motion. The rod is sampled between steps; nothing is called back. Only single legs.

    Args:
        case: without damping.
        elements: number.
        time_step: s.
        repeats: the best time of so many runs counts, after a warm-up that compiles.
    """
    if any(case.damping):
        raise ValueError("PyElastica has no material damping; give case.undamped()")
    if len(case.legs) > 1:
        raise ValueError("only single legs")
    step = time_step or 0.95 * largest_stable_step(case, elements)
    samples = 500
    every = ceil(case.duration / samples / step)
    step = case.duration / samples / every
    pilot, _, _ = _loop(case, elements, step, every, max(1, ceil(1000 / every)))
    pilot, _, _ = _loop(case, elements, step, every, max(1, ceil(2000 / every)))
    expected = pilot * case.duration / step / (every * max(1, ceil(2000 / every)))
    done = samples if expected < LONGEST else max(1, int(samples * LONGEST / 4.0 / expected))
    loops = [
        _loop(case, elements, step, every, done) for _ in range(repeats if expected < LONGEST / 4 else 1)
    ]
    seconds, t, tip = min(loops, key=lambda loop: loop[0])
    label = f"undamped {elements}, h {step:.3g} s"
    if done < samples:
        label += f", first {t[-1]:.2g} s, extrapolated"
    return PeerRun(PROGRAM, version("pyelastica"), label, seconds * samples / done, t, tip)


def largest_stable_step(case: Case, elements: int, steps: int = 4000) -> float:
    """Bisect for the largest step with which `steps` steps stay bounded, to one per cent, s."""
    length = case.lengths[0] / (elements - 0.5)
    shear, _, axial, bend, _, _ = case.stiffness
    mass, rotary = case.inertia[0], case.inertia[1]
    # the fastest motions of the staggered chain: neighbours against each other, and the section against shear
    fastest = max(
        2.0 / length * sqrt(axial / mass),
        sqrt(4.0 / length**2 * (shear / mass + bend / rotary) + shear / rotary),
    )
    low, high = 0.4 / fastest, 4.0 / fastest
    while high / low > 1.01:
        middle = sqrt(low * high)
        low, high = (middle, high) if _stays_bounded(case, elements, middle, steps) else (low, middle)
    return low


def _stays_bounded(case: Case, elements: int, step: float, steps: int) -> bool:
    with np.errstate(all="ignore"):
        _, _, tip = _loop(case, elements, step, steps // 20, 20)
    reach = 1.05 * case.lengths[0]
    return bool(np.isfinite(tip).all() and np.linalg.norm(tip, axis=1).max() < reach)


def _loop(case: Case, elements: int, step: float, every: int, samples: int) -> tuple[float, Floats, Floats]:
    """Seconds of the time loop, sampled times and tips; `samples` times `every` steps."""
    model = _model(case, elements)
    stepper = ea.PositionVerlet()
    tips = np.empty((samples + 1, 3))
    tips[0] = model.rod.position_collection[:, -1]
    now = np.float64(0.0)
    start = time.perf_counter()
    for k in range(samples):
        for _ in range(every):
            now = stepper.step(model.simulator, now, step)
        tips[k + 1] = model.rod.position_collection[:, -1]
    seconds = time.perf_counter() - start
    return seconds, np.arange(samples + 1) * every * step, tips


def _model(case: Case, elements: int) -> _Model:
    simulator = _Simulator()
    length = case.lengths[0]
    element = length / (elements - 0.5)
    stiffness, inertia = np.array(case.stiffness), np.array(case.inertia)
    along = np.subtract(case.corners[1], case.corners[0]) / length
    across = np.array([0.0, 0.0, 1.0])
    radius = 1e-2 * length  # of no consequence: everything that follows from it is overwritten
    rod = ea.CosseratRod.straight_rod(
        elements,
        np.array(case.corners[0]) - 0.5 * element * along,
        along,
        across,
        elements * element,
        radius,
        inertia[0] / (pi * radius**2),
        youngs_modulus=stiffness[2] / (pi * radius**2),
    )
    # d1 of PyElastica is the given normal; bending stiffness and inertia are the same about d1 and d2 here
    rod.shear_matrix[:] = np.diag(stiffness[:3])[:, :, None]
    rod.bend_matrix[:] = np.diag(stiffness[3:])[:, :, None]
    rod.mass_second_moment_of_inertia[:] = np.diag(inertia[1:] * element)[:, :, None]
    rod.inv_mass_second_moment_of_inertia[:] = np.diag(1.0 / (inertia[1:] * element))[:, :, None]
    if case.preload:
        rod.position_collection[:], rod.director_collection[:] = _held(case, elements, element)
    simulator.append(rod)
    simulator.constrain(rod).using(
        ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    if case.gravity:
        simulator.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array(case.gravity))
    simulator.finalize()
    return _Model(simulator, rod)


def _held(case: Case, elements: int, element: float) -> tuple[Floats, Floats]:
    """Nodes and directors of the preloaded chain, in the plane z = 0; the first element stays along x."""
    assert case.preload is not None
    lengths = np.full(elements - 1, element)
    hinges = np.full(elements - 1, case.stiffness[3] / element)
    angles, links = held_angles(lengths, hinges, case.preload, case.stiffness[2], case.stiffness[0])
    angles = np.append(0.0, angles)
    links = np.vstack([[element, case.preload[1] / case.stiffness[0] * element], links])
    position = np.zeros((3, elements + 1))
    position[0, 0] = -0.5 * element
    position[:2, 1:] = position[:2, :1] + np.cumsum(links, axis=0).T
    directors = np.zeros((3, 3, elements))
    directors[0, 2] = 1.0
    directors[1, 0], directors[1, 1] = np.sin(angles), -np.cos(angles)
    directors[2, 0], directors[2, 1] = np.cos(angles), np.sin(angles)
    return position, directors

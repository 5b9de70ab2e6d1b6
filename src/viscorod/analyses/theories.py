"""Theories of planar straight beams side by side with the geometrically exact rod (Artola, Wynn and Palacios, IV)."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium, find_initial_equilibrium
from viscorod.analyses.motion import motion
from viscorod.errors import Fault, InputError
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run
from viscorod.results.theory_comparison import TheoryComparison, TheorySolution
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import linearise
from viscorod.solve.planar.planar_beam import PlanarBeam, Plane
from viscorod.solve.planar.planar_checks import plane_of, require_planar
from viscorod.solve.planar.planar_solution import equilibrium_of, motion_of, squares_about, squares_of
from viscorod.solve.planar.planar_theory import EXACT, THEORIES
from viscorod.solve.problem.division import divisions_of
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.solve.settings.theories import TheorySettings
from viscorod.typing import Floats

__all__ = ["compare_theories"]

PROBES = 50
"""Times at which loads are looked at to find their plane."""
OUTSIDE = 1e-5
"""Section forces out of the plane over the largest that are round-off or errors of the solution."""
RECORDS = 200
"""Intervals at which a motion is compared unless others are given."""


def compare_theories(discrete: DiscreteModel, settings: TheorySettings) -> TheoryComparison:
    """Compute a planar straight beam by several theories and by the exact one; see ``Model.compare_theories``."""
    moving = settings.duration is not None
    require_planar(discrete.model, discrete.problem, moving=moving)
    if all(rod.elements is None for rod in discrete.model.rods.values()):
        halved = {name: division.halved() for name, division in divisions_of(discrete.problem).items()}
        discrete = discrete.on_mesh(halved)
    problem, loads = discrete.problem, ExternalLoads(discrete.problem)
    instants = np.linspace(0.0, settings.duration or 0.0, PROBES if moving else 1)
    states = [loads.at(float(t), before) for t in instants for before in (True, False)[: 1 + moving]]
    plane = plane_of(problem, states)
    exact, times = _exact(discrete, settings, plane)
    found = {
        word: _theory(discrete, settings, plane, word, times) for word in THEORIES if word in settings.theory
    }
    gauss = discrete.system.gauss_positions()
    return TheoryComparison(
        exact,
        found,
        problem.stations.s,
        gauss.s,
        times,
        settings.within,
        tuple(_doubts(exact, found)),
    )


def _doubts(exact: TheorySolution, found: dict[str, TheorySolution]) -> list[str]:
    return [
        f"{one.title}: the equilibrium at the start is unstable in the plane"
        for one in (exact, *found.values())
        if not one.stable
    ]


def _exact(discrete: DiscreteModel, settings: TheorySettings, plane: Plane) -> tuple[TheorySolution, Floats]:
    """Return what the geometrically exact rod does, and the times of its states."""
    result: Equilibrium | Run
    if settings.duration is None:
        result, times = equilibrium(discrete, EquilibriumSettings()), np.zeros(1)
    else:
        interval = settings.output_interval or settings.duration / RECORDS
        result = motion(discrete, SimulateSettings(settings.duration, output_interval=interval))
        times = result.time
    last = slice(-times.size, None)  # of an equilibrium the last of its load steps
    moved = result.field("displacement", states=last)
    forces = np.asarray(result.data["section_force"].values[last], dtype=float)
    _require_in_plane(forces, plane, discrete.problem.length)
    bend = forces[..., 4] if plane.transverse == 0 else -forces[..., 3]
    section = np.stack([forces[..., 2], forces[..., plane.transverse], bend], axis=-1)
    along_and_across = np.stack([moved @ plane.tangent, moved @ plane.across], axis=-1)
    squares = _exact_squares(discrete, plane, settings.frequencies)
    return TheorySolution(EXACT, "exact", along_and_across, section, *_judged(squares)), times


def _require_in_plane(forces: Floats, plane: Plane, length: float) -> None:
    """Refuse an exact beam that leaves the plane: it turned over, or buckled out of it.

    Raises:
        InputError: it does.
    """
    size = np.abs(forces).max(axis=(0, 1)) * np.repeat([1.0, 1.0 / length], 3)
    if np.delete(size, plane.strains).max() > OUTSIDE * size.max():
        raise InputError(
            Fault(
                "model",
                "out of the plane",
                "under these loads the exact beam leaves their plane: it turns about its axis, or gives way sideways",
                "hold its rotation about the axis and its displacement normal to the plane, or load it less",
            )
        )


def _judged(squares: Floats) -> tuple[Floats, bool]:
    """Return frequencies [Hz] from the squares of angular ones, 0 of what grows, and whether nothing grows."""
    return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi), bool((squares > 0.0).all())


def _exact_squares(discrete: DiscreteModel, plane: Plane, count: int) -> Floats:
    """Return the least squares of undamped angular frequencies in the plane, about the equilibrium, 1/s^2."""
    state = State.reference(discrete.problem)
    find_initial_equilibrium(discrete, state)
    linear = linearise(discrete.static, state).unconditional()
    basis = np.asarray(linear.basis.todense()).reshape(discrete.problem.size, 6, -1)
    outside = np.delete(basis, plane.motions, axis=1).reshape(-1, basis.shape[2])
    inside = null_space(outside, rcond=1e-9)
    K, M = (inside.T @ (matrix @ inside) for matrix in (linear.stiffness, linear.mass))
    return squares_of(K, M, count)


def _theory(
    discrete: DiscreteModel, settings: TheorySettings, plane: Plane, word: str, times: Floats
) -> TheorySolution:
    """Return what an approximate theory says."""
    problem, theory = discrete.problem, THEORIES[word]
    (rod,) = discrete.model.rods.values()
    beam = PlanarBeam(problem, plane, theory, held_shear=rod.constrained_strains[plane.transverse])
    if beam.free:
        raise InputError(
            Fault(
                "supports",
                "",
                f"they leave the beam free to move in its plane, and {theory.title} beams keep their place",
                "hold it along, across and against rotation",
            )
        )
    loads = ExternalLoads(problem)

    def nodal(t: float, before: bool) -> Floats:
        return beam.loads(loads.at(t, before))

    start = equilibrium_of(beam, nodal(0.0, True))
    squares = squares_about(beam, start, settings.frequencies)
    if settings.duration is None:
        displacement = start[None]
        forces = beam.section_forces(start, nodal(0.0, True) - beam.internal(start))[None]
    else:
        corners = np.array(sorted({*problem.breakpoints, *problem.jumps, *problem.rows}))
        displacement, velocity, acceleration = motion_of(beam, nodal, start, times, corners)
        acceleration[0] = 0.0  # the first state is the equilibrium, before loads jump
        forces = np.array(
            [
                beam.section_forces(x, nodal(t, t <= 0.0) - beam.internal(x, v) - beam.mass @ a, v)
                for t, x, v, a in zip(times.tolist(), displacement, velocity, acceleration, strict=True)
            ]
        )
    moved = displacement.reshape(len(times), problem.size, 3)[:, problem.stations.nodes, :2]
    section = forces[:, beam.order][..., [1, 0, 2]]
    return TheorySolution(word, theory.title, moved, section, *_judged(squares))

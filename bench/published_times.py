"""Times that the authors of GXBeam publish for their program, beside viscorod's for the same problems on this machine.

    python bench/published_times.py [--rounds 5] [--only static]

GXBeam's are the least of several runs, its compilation done, on the processor named in the table; they and the numbers
of the problems are in the public repository byuflowlab/GXBeam.jl: `benchmark/benchmarks.jl` with
`benchmarks/baseline_benchmark_jl.txt`, and `test/examples_benchmark.jl` with
`benchmarks/baseline_examples_sparsediff.txt` (version 1.1.0, May 2026). GXBeam's errors are not published. What is
timed here is all from the description to the numbers that are compared, of motions with the estimate of the mesh's
error, at the default tolerance, with the kernels loaded. The error is the largest of these numbers against a finer mesh
and tolerance: of displacements over the largest one, of frequencies each over itself.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import viscorod as vr
from viscorod.programs.axial_first import from_axial_first
from viscorod.typing import Floats

Vector = tuple[float, float, float]
Mesh = tuple[int, int]
"""Elements of a leg and their order."""

EXAMPLES = Path(__file__).parents[1] / "examples"
INCH, POUND = 0.0254, 4.4482216152605
"""In m and N: the strip and the bend are published in inches and pounds."""

BLADE_STIFFNESS = np.array(
    [
        [2.389e9, 1.524e6, 6.734e6, -3.382e7, -2.627e7, -4.736e8],
        [1.524e6, 4.334e8, -3.741e6, -2.935e5, 1.527e7, 3.835e5],
        [6.734e6, -3.741e6, 2.743e7, -4.592e5, -6.869e5, -4.742e6],
        [-3.382e7, -2.935e5, -4.592e5, 2.167e7, -6.279e5, 1.430e6],
        [-2.627e7, 1.527e7, -6.869e5, -6.279e5, 1.970e7, 1.209e7],
        [-4.736e8, 3.835e5, -4.742e6, 1.430e6, 1.209e7, 4.406e8],
    ]
)
"""Of the wind turbine's blade, GXBeam's order (axis first), N, N m and N m^2."""

BLADE_MASS = np.array(
    [
        [258.053, 0.0, 0.0, 0.0, 7.07839, -71.6871],
        [0.0, 258.053, 0.0, -7.07839, 0.0, 0.0],
        [0.0, 0.0, 258.053, 71.6871, 0.0, 0.0],
        [0.0, -7.07839, 71.6871, 48.59, 0.0, 0.0],
        [7.07839, 0.0, 0.0, 0.0, 2.172, 0.0],
        [-71.6871, 0.0, 0.0, 0.0, 0.0, 46.418],
    ]
)
"""Of the same, kg/m, kg and kg m."""

WING_COMPLIANCE = (
    2.93944738387698e-10,
    8.42991725049126e-10,
    3.38313996669689e-08,
    4.69246721094557e-08,
    6.79584100559513e-08,
    1.37068861370898e-09,
)
WING_MASS = (4.86e-2, 4.86e-2, 4.86e-2, 1.0632465e-2, 2.10195e-4, 1.042227e-2)
WING_TIP, WING_ROOTS = (0.0, 0.0, 0.0), ((-7.1726, -12.0, -3.21539), (7.1726, -12.0, 3.21539))
WING_FRAMES = (
    ((0.5, 0.866025, 0.0), (0.836516, -0.482963, 0.258819), (0.224144, -0.12941, -0.965926)),
    ((0.5, 0.866025, 0.0), (-0.836516, 0.482963, 0.258819), (0.224144, -0.12941, 0.965926)),
)
"""Rows of the rotations from each leg's axes; the section's axes are their second and third columns."""


@dataclass(frozen=True)
class Problem:
    """One row of the table.

    Attributes:
        name: what is computed.
        theirs: GXBeam's mesh and steps.
        processor: on which it was timed.
        published: its least time, s.
        ours: viscorod's mesh.
        compute: what is timed, and returns the numbers that are compared.
        exact: the same numbers on a finer mesh.
    """

    name: str
    theirs: str
    processor: str
    published: float
    ours: str
    compute: Callable[[], Floats]
    exact: Callable[[], Floats]


def rod(
    start: Vector, end: Vector, section: vr.StiffnessSection, mesh: Mesh, d1: Vector = (0.0, 1.0, 0.0)
) -> vr.Rod:
    """A straight leg; its d1 is GXBeam's y axis of the section."""
    return vr.Rod.straight(start, end, section=section, elements=mesh[0], order=mesh[1], d1=d1)


def axial_first(diagonal: tuple[float, ...]) -> list[float]:
    """Six numbers of GXBeam's order (axis, y, z; twist, y, z) in viscorod's (y, z, axis; y, z, twist)."""
    return [diagonal[k] for k in (1, 2, 0, 4, 5, 3)]


def bend(mesh: Mesh) -> Floats:
    """The bend of 45 degrees and 100 in under 600 lbf: displacement of the loaded end, in, as its numbers are."""
    young, area, second = 1e7, 1.0, 1.0 / 12.0
    stiffness = [
        young / 2 * area,
        young / 2 * area,
        young * area,
        young * second,
        young * second,
        young * second,
    ]
    model = vr.Model()
    arc = vr.Rod.arc(
        (0.0, 0.0, 0.0),
        tangent=(0.0, 1.0, 0.0),
        normal=(1.0, 0.0, 0.0),
        radius=100.0,
        angle=math.pi / 4.0,
        section=vr.StiffnessSection(stiffness, [1.0] * 6),
        elements=mesh[0],
        order=mesh[1],
    )
    model.add("bend", arc)
    model.clamp("bend.start")
    model.force("bend.end", (0.0, 0.0, 600.0))
    return model.equilibrium().history("bend.end", "displacement").values


def swept_strip(mesh: Mesh) -> vr.Model:
    """The strip with a tip swept by 45 degrees on a hub of 2.5 in (Epps and Chandra), in SI units."""
    compliance = (1.4974543276e-06, 4.7619054919e-06, 5.8036221902e-05)
    bending = (3.1234387938e-03, 4.5274507258e-03, 1.7969451932e-05)
    stiffness = [POUND / c for c in compliance] + [POUND * INCH**2 / c for c in bending]
    mass = [POUND / INCH**2 * 1.5813e-05] * 3
    inertia = [POUND * m for m in (1.3229801498e-06, 5.23014975e-09, 1.3177500000e-06)]
    section = vr.StiffnessSection(axial_first(tuple(stiffness)), axial_first((*mass, *inertia)))
    hub, bent = 2.5 * INCH, 34.0 * INCH
    tip = 6.0 * INCH / math.sqrt(2.0)
    model = vr.Model()
    model.add("blade", rod((hub, 0.0, 0.0), (bent, 0.0, 0.0), section, mesh))
    model.add("tip", rod((bent, 0.0, 0.0), (bent + tip, -tip, 0.0), section, (1, mesh[1]), (1.0, 1.0, 0.0)))
    model.attach("blade.end", "tip.start")
    model.clamp("blade.start")
    return model


def spinning_strip(mesh: Mesh, modes: int) -> vr.Steady:
    """The same in steady rotation at 750 revolutions per minute."""
    return swept_strip(mesh).steady((0.0, 0.0, 25.0 * math.pi), modes=modes)


def displacement(steady: vr.Steady) -> Floats:
    """Of the tip of the spinning strip, m."""
    return steady.history("tip.end", "displacement").values


def blade(mesh: Mesh, tolerance: float | None = None) -> Floats:
    """The blade of 60 m in 0.1 s of a force of 100 kN sin(20 t) at its tip: displacement of the tip, m."""
    model = vr.Model()
    section = vr.StiffnessSection(from_axial_first(BLADE_STIFFNESS), from_axial_first(BLADE_MASS))
    model.add("blade", rod((0.0, 0.0, 0.0), (60.0, 0.0, 0.0), section, mesh))
    model.clamp("blade.start")
    model.force("blade.end", (0.0, 0.0, 1e5), time=vr.Sine(10.0 / math.pi))
    run = model.simulate(0.1, tolerance=tolerance, output_interval=0.001)
    return run.history("blade.end", "displacement").values


def joined_wing(mesh: Mesh, tolerance: float | None = None) -> Floats:
    """Two legs of 14 m in 0.01 s of forces that rise where they meet: displacement of that place, m."""
    stiffness = axial_first(tuple(1.0 / c for c in WING_COMPLIANCE))
    section = vr.StiffnessSection(stiffness, axial_first(WING_MASS))
    (first, last), (one, other) = WING_ROOTS, WING_FRAMES
    model = vr.Model()
    model.add("first", rod(first, WING_TIP, section, mesh, tuple(row[1] for row in one)))
    model.add("second", rod(WING_TIP, last, section, mesh, tuple(row[1] for row in other)))
    model.attach("first.end", "second.start")
    model.clamp("first.start")
    model.clamp("second.end")
    model.force("first.end", (1e4, 1e4, 0.0), time=vr.TimeTable([0.0, 0.01], [0.0, 1.0]))
    model.force(
        "first.end", (0.0, 0.0, 5e3), time=vr.Sine(25.0, amplitude=-1.0, phase=math.pi / 2.0, offset=1.0)
    )
    run = model.simulate(0.01, tolerance=tolerance, output_interval=5e-5)
    return run.history("first.end", "displacement").values


OLD, NEW = "i7-5500U", "i7-9750H"
FINE = 1e-8
"""Tolerance of the references."""

PROBLEMS = (
    Problem(
        "static: bend of 45 degrees, 600 lbf",
        "16 elements",
        NEW,
        89.390e-3,
        "1 x order 6",
        lambda: bend((1, 6)),
        lambda: bend((4, 8)),
    ),
    Problem(
        "steady: swept strip at 750 rpm",
        "24 elements",
        OLD,
        4.716e-3,
        "1 + 1 x order 6",
        lambda: displacement(spinning_strip((1, 6), 1)),
        lambda: displacement(spinning_strip((4, 8), 1)),
    ),
    Problem(
        "the same with 20 modes",
        "24 elements",
        OLD,
        18.478e-3,
        "6 + 1 x order 6",
        lambda: spinning_strip((6, 6), 20).frequencies[:6],
        lambda: spinning_strip((9, 9), 20).frequencies[:6],
    ),
    Problem(
        "motion: blade of 60 m, 0.1 s",
        "5 elements, 100 steps",
        NEW,
        103.747e-3,
        "4 x order 6",
        lambda: blade((4, 6)),
        lambda: blade((8, 8), FINE),
    ),
    Problem(
        "motion: joined wing, 0.01 s",
        "8 elements, 200 steps",
        NEW,
        357.665e-3,
        "2 x order 6",
        lambda: joined_wing((2, 6)),
        lambda: joined_wing((4, 8), FINE),
    ),
)


def best(compute: Callable[[], Floats], rounds: int) -> float:
    """Least time [s] of a call."""
    compute()
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        compute()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", default="", help="a part of the problem's name")
    given = parser.parse_args()
    print("| problem | GXBeam | published, on | viscorod | here | error |")
    print("|---|---|---|---|---|---|")
    for problem in PROBLEMS:
        if given.only not in problem.name:
            continue
        seconds = best(problem.compute, given.rounds)
        found, exact = problem.compute(), problem.exact()
        scale = np.abs(exact) if "modes" in problem.name else np.abs(exact).max()
        error = float(np.max(np.abs(found - exact) / scale))
        print(
            f"| {problem.name} | {problem.theirs} | {1e3 * problem.published:.3g} ms, {problem.processor} "
            f"| {problem.ours} | {1e3 * seconds:.3g} ms | {error:.1e} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

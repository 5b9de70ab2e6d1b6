"""Write the tables of mechanisms: ``python -m tests.reference.independent.mechanism_tables NAME...``, from the root.

Names: double_pendulum, slider_crank, four_bar, right_angle; the last two need Exudyn.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from . import exudyn_rods, four_bar, slider_crank
from .double_pendulum import DoublePendulum
from .galerkin import Array

FOLDER = Path("tests/reference/data")
COMMAND = "python -m tests.reference.independent.mechanism_tables"


def write(name: str, notes: Sequence[str], columns: Sequence[str], rows: Array, digits: int = 9) -> None:
    """Write one table with its notes."""
    lines = [f"# {note}" for note in (*notes, f"Written by: {COMMAND} {name}")]
    lines.append(",".join(columns))
    lines += [",".join(f"{value + 0.0:.{digits}g}" for value in row) for row in rows]
    (FOLDER / f"{name}.csv").write_text("\n".join(lines) + "\n")
    print(*lines[: len(notes) + 2], sep="\n", flush=True)


def double_pendulum() -> None:
    """Two bars of 1 kg and 1 m, released horizontal and straight."""
    pendulum, times = DoublePendulum(), np.arange(61) * 0.05
    states = pendulum.solve(times)
    coarse = np.abs(states - pendulum.solve(times, rtol=1e-10)).max()
    elbow, tip = pendulum.places(states)
    write(
        "double_pendulum",
        [
            "Rigid double pendulum: bars of 1 kg and 1 m, gravity 9.81 m/s2 along -z, released at rest along +x.",
            "Angles of the bars below the x axis in rad; elbow and tip in m.",
            f"DOP853 at a relative tolerance of 1e-12; one of 1e-10 changes angles and rates by {coarse:.0e}; "
            f"energy constant within {np.ptp(pendulum.energy(states)):.0e} J.",
        ],
        ("t", "angle1", "angle2", "elbow_x", "elbow_z", "tip_x", "tip_z"),
        np.column_stack([times, states[:, :2], elbow, tip]),
        12,
    )


def slider_crank_table() -> None:
    """Two turns of the crank, without damping and with a little."""
    times = np.linspace(0, 4 * np.pi / 150, 61)
    columns, notes = [times], []
    for damping in (0.0, 2e-5):
        case = slider_crank.SliderCrank(damping=damping)
        fine, coarse = slider_crank.solve(case, times, degree=12, steps=40), slider_crank.solve(case, times)
        gaps = [
            float(np.abs(getattr(fine, k) - getattr(coarse, k)).max())
            for k in ("slider", "deflection", "torque")
        ]
        columns += [fine.slider, fine.deflection, *([fine.torque] if damping else [])]
        notes.append(
            f"Damping {damping} s: degree 10 and half the steps change slider by {gaps[0]:.0e} m, deflection by "
            f"{gaps[1]:.0e} m, torque by {gaps[2]:.0e} N m; energy balance within {fine.imbalance:.0e}."
        )
    case = slider_crank.SliderCrank()
    EA, GA, EI = case.stiffness
    write(
        "slider_crank",
        [
            "Slider-crank, flexible coupler: crank 0.15 m at 150 rad/s from angle 0, coupler 0.3 m, slider 0.033 kg.",
            f"Coupler: EA {EA:.9g} N, GA {GA:.9g} N, EI {EI:.9g} N m2, {case.density * case.area:.9g} kg/m, rotary "
            f"{case.density * case.inertia:.9g} kg m; planar, with shear; straight at t = 0, with rigid velocities.",
            "Slider's x in m; deflection of the middle from the chord in m, left of it seen from crank to slider; "
            "motor torque in N m on a massless crank (with damping only: axial ringing fills it without).",
            "Damping: Kelvin-Voigt time of all strains, 0 and 2e-5 s.",
            *notes,
            "Exudyn's planar beams, 16, 32, 64 elements, approach the damped deflection at second order: "
            "1.7e-4, 4.2e-5, 1.0e-5 m away.",
        ],
        ("t", "slider", "deflection", "slider_damped", "deflection_damped", "torque_damped"),
        np.column_stack(columns),
    )


def four_bar_table() -> None:
    """Equilibria at 60 crank angles; what inertia changes, by Exudyn."""
    times = 0.2 * np.arange(1, 61)
    poses = four_bar.path(np.array([four_bar.crank_angle(t) for t in times]))
    motion = exudyn_rods.four_bar(times, 16, 0.002)
    meshes = np.abs(motion - exudyn_rods.four_bar(times, 8, 0.002))
    rows = np.array(
        [[t, p.crank, *p.B, *p.C, *p.force, p.motor, *p.angles] for t, p in zip(times, poses, strict=True)]
    )
    away = np.abs(motion - rows[:, 2:11])
    # what tells the two apart, instant by instant
    places, forces = away[:, :6].max(axis=1), away[:, 6:].max(axis=1)
    write(
        "four_bar",
        [
            "Four-bar mechanism, hinge at C inclined by 5 degrees: equilibria at the crank angles reached at t when",
            "the crank starts smoothly within 1 s and turns at -0.6 rad/s from then on (crank_angle in four_bar.py).",
            "B, C: places in m; force: in the bars, of the outer part on the inner one, N; motor: torque on the "
            "crank, N m;",
            "angle_B, angle_C: relative rotations at the joints, angle_D: of CD about z, in (-pi, pi], rad.",
            "Bars by Runge-Kutta of order 4 in 16 intervals: errors below 1e-8 m and 1e-3 N.",
            "At the two stretched positions (crank -1.57 and -4.71) the branch changes from parallel to crossed and",
            "back; forces rise steeply there.",
            "dynamic_place (m) and dynamic_force (N): largest difference of a component from Exudyn with inertia, "
            "16 + 32 + 16 elements, 2 ms, spectral radius 0.7;",
            f"its own mesh (8 + 16 + 8) changes the places by {np.median(meshes[:, :6].max(axis=1)):.0e} m (median), "
            f"{meshes[:, :6].max():.0e} m (most).",
        ],
        (
            *(
                "t",
                "crank",
                "B_x",
                "B_y",
                "B_z",
                "C_x",
                "C_y",
                "C_z",
                "force_x",
                "force_y",
                "force_z",
                "motor",
            ),
            *("angle_B", "angle_C", "angle_D", "dynamic_place", "dynamic_force"),
        ),
        np.column_stack([rows, places, forces]),
    )


def right_angle() -> None:
    """Elbow and tip of the right-angle frame to t = 30."""
    times = 0.5 * np.arange(61)
    places, errors = exudyn_rods.right_angle_extrapolated(times)
    write(
        "right_angle",
        [
            "Right-angle frame of Simo and Vu-Quoc (1988): legs 10 + 10 along x and y, EA = GA = 1e6, GJ = EI = 1e3,",
            "unit mass, rotary inertia (20, 10, 10), the first about the leg; force along z at the elbow, 0, 50, 0 at "
            "t = 0, 1, 2.",
            "Places of elbow and tip: Exudyn, geometrically exact two-node beams, 40, 80, 160 elements a leg, steps of "
            "5 and 2.5 ms, extrapolated.",
            f"error: estimate of the largest error of a component; at most {errors.max():.0e}.",
        ],
        ("t", "elbow_x", "elbow_y", "elbow_z", "tip_x", "tip_y", "tip_z", "error"),
        np.column_stack([times, places, errors]),
        7,
    )


TABLES = {
    "double_pendulum": double_pendulum,
    "slider_crank": slider_crank_table,
    "four_bar": four_bar_table,
    "right_angle": right_angle,
}

if __name__ == "__main__":
    for name in sys.argv[1:] or TABLES:
        TABLES[name]()

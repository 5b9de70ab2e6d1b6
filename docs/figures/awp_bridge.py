"""Draw the picture of the bridge beam in docs/explanation/awp_beams.md and print its table.

python docs/figures/awp_bridge.py
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import viscorod as vr
from viscorod.pictures.style import BLUE, GREEN, RED, clean, heading

LENGTH, MASS, AREA, YOUNG, SECOND_MOMENT = 30.0, 1500.0, 0.36, 35e9, 0.0243
EA, EI = YOUNG * AREA, YOUNG * SECOND_MOMENT
COMPRESSION = 0.1 * np.pi**2 * EI / LENGTH**2
FIRST = 7.83
"""Frequency [rad/s] that the paper prints."""

MODELS = {
    "L-L": {"damping": "linearised", "dynamics": "linear"},
    "NL-L": {"damping": "linearised", "dynamics": "nonlinear"},
    "NL-NL": {"damping": "full", "dynamics": "nonlinear"},
}
LINES = {"L-L": {"ls": (0, (3, 2)), "lw": 1.1}, "NL-L": {"lw": 1.0}, "NL-NL": {"lw": 2.6, "alpha": 0.75}}
WORDS = {
    "L-L": "linear (L-L)",
    "NL-L": "nonlinear, linearised damping (NL-L)",
    "NL-NL": "nonlinear, full damping (NL-NL)",
}
MARKERS = {"L-L": "s", "NL-L": "x", "NL-NL": "o"}
COLOURS = {0.75: BLUE, 1.0: RED, 1.25: GREEN}
ETAS = (0.0001, 0.001, 0.01)
MESH, TOLERANCE = (4, 5), 1e-6
FINE_MESH, FINE_TOLERANCE = (8, 5), 1e-7
ROOT = Path(__file__).parents[2]
TABLE = ROOT / "tests" / "reference" / "data" / "awp_bridge.csv"
TARGET = ROOT / "docs" / "images" / "awp_bridge.png"


def bridge(eta: float, ratio: float, elements: int = MESH[0], order: int = MESH[1]) -> vr.Model:
    """Return the compressed beam of Artola, Wynn and Palacios, section V.A, with the second moment that fits."""
    stiffness = np.array([1e5 * EA, 1e5 * EA, EA, EI, EI, EI])
    rotary = 1e-5 * MASS * SECOND_MOMENT / AREA
    damping = stiffness * [0.0, 0.0, eta, eta, eta, 0.0]
    section = vr.StiffnessSection(stiffness.tolist(), [MASS] * 3 + [rotary] * 3, damping=damping.tolist())
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, elements=elements, order=order)
    model.add("beam", rod)
    model.support("beam.start", fixed=["ux", "uy", "uz", "rx", "rz"])
    model.support("beam.end", fixed=["uy", "uz", "rx", "rz"])
    model.force("beam.end", (-COMPRESSION, 0, 0))
    beat = vr.Sine(ratio * FIRST / (2 * np.pi))
    model.moving_force("beam", (0, 0, -2e6), speed=20.0, time=beat)
    return model


def motion(
    name: str, eta: float, ratio: float, mesh: tuple[int, int] = MESH, tolerance: float = TOLERANCE
) -> vr.Run:
    given = {"formulation": "intrinsic", "tolerance": tolerance, "output_interval": 0.01}
    return bridge(eta, ratio, *mesh).simulate(1.5, **given, **MODELS[name])


def deflection(run: vr.Run) -> np.ndarray:
    """Return the deflection of mid-span, positive downwards [m]."""
    return -run.history(f"beam@{LENGTH / 2!r}", "displacement").values[:, 2]


def last_zero(run: vr.Run) -> float:
    """Return the time at which mid-span last passes its position of rest [s]."""
    time, curve = run.time, deflection(run)
    k = np.flatnonzero(curve[1:] * curve[:-1] < 0)[-1]
    return float(time[k] - curve[k] * (time[k + 1] - time[k]) / (curve[k + 1] - curve[k]))


def independent() -> tuple[np.ndarray, dict[tuple[str, float, float], np.ndarray]]:
    """Return times and deflections of the independent solutions."""
    lines = TABLE.read_text(encoding="utf-8").splitlines()
    head, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    values = {(row[0], float(row[1]), float(row[2])): np.array(row[3:], dtype=float) for row in rows}
    return np.array(head[3:], dtype=float), values


def main() -> None:
    times, known = independent()
    frequency = 2 * np.pi * bridge(0.001, 1.0).modes(1).frequencies[0]
    print(f"first frequency under Q: {frequency:.4f} rad/s")
    figure = Figure(figsize=(9.0, 10.5), layout="constrained")
    panels = figure.subplots(len(ETAS), 1, sharex=True, sharey=True)
    for panel, eta in zip(panels, ETAS, strict=True):
        for ratio, colour in COLOURS.items():
            runs = {name: motion(name, eta, ratio) for name in MODELS}
            for name, run in runs.items():
                curve, marks = deflection(run), known[name, eta, ratio]
                panel.plot(run.time, curve, color=colour, **LINES[name])
                filled = {"mfc": "white"} if MARKERS[name] != "x" else {}
                panel.plot(times, marks, MARKERS[name], color=colour, ms=5, mew=1.2, **filled)
                gap = np.abs(np.interp(times, run.time, curve) - marks).max()
                print(
                    f"{name:5s} eta {eta:g} ratio {ratio:4g}: end {curve[-1]:9.6f} m, off by {gap:.1e} m,",
                    f"lost {run.energy.viscous[-1] / 1e6:8.4f} MJ, {run.data.attrs['steps']} steps,",
                    f"remainder {run.energy.numerical_fraction:.0e}",
                )
            marked = [deflection(runs[name])[np.searchsorted(run.time, times - 1e-6)] for name in MODELS]
            print(
                f"eta {eta:g} ratio {ratio:4g}: NL-L from NL-NL at the marks {np.ptp(marked[1:], axis=0).max():.3f} m,",
                f"last zero of L-L {1e3 * (last_zero(runs['NL-NL']) - last_zero(runs['L-L'])):.1f} ms earlier",
            )
        clean(panel, "time [s]" if panel is panels[-1] else "", "mid-span deflection [m]")
        heading(panel, f"η = {eta:g} s")
        panel.set(xlim=(0, 1.52))
    for name in MODELS:
        fine = motion(name, 0.001, 1.0, FINE_MESH, FINE_TOLERANCE)
        change = np.abs(deflection(fine) - deflection(motion(name, 0.001, 1.0))).max()
        print(f"{name}, eta 0.001, ratio 1: half the elements' length, finer steps: {change:.1e} m")
    dark = {"color": "0.25"}
    handles = [Line2D([], [], color=c, lw=2, label=f"ω = {r:.2f} · 7.83 rad/s") for r, c in COLOURS.items()]
    handles += [Line2D([], [], **dark, **LINES[name], label=WORDS[name]) for name in MODELS]
    handles += [
        Line2D([], [], **dark, ls="", marker=mark, mfc="white", ms=5, label=f"{name}, independent solution")
        for name, mark in MARKERS.items()
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=3, fontsize=9, frameon=False)
    figure.savefig(TARGET, dpi=110)


if __name__ == "__main__":
    main()

"""Draw the modes of the shipped comb resonator for docs/explanation/comb_resonator.md and print its frequencies.

python docs/figures/comb_resonator.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

import viscorod as vr
from viscorod.analyses.case_run import as_model
from viscorod.analyses.model import Model
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_cases

UM = 1e-6
TARGET = Path(__file__).parents[1] / "images" / "comb_resonator.png"
MODES = 6
E, T, W, L, DENSITY = 155e9, 2.25 * UM, 2.0 * UM, 146.0 * UM, 2330.0


def formula(shuttle: float, trusses: float) -> float:
    """Return the frequency [Hz] of Tang, Nguyen and Howe's folded flexures, with masses in kg."""
    flexures = 8 * DENSITY * W * T * L
    return float(
        np.sqrt(2 * E * T * (W / L) ** 3 / (shuttle + trusses / 4 + 12 / 35 * flexures)) / (2 * np.pi)
    )


def resonator(constraints: str | tuple[str, ...] = "unshearable", scale: float = 1.0) -> Model:
    """Return the shipped case with other constraints, and trusses of ``scale`` times the mass."""
    model = as_model(load_case(shipped_cases()["comb_resonator"]).description)
    for name, rod in model.rods.items():
        model.rods[name] = vr.Rod.model_validate(dict(rod) | {"constraints": constraints})
    for name, body in model.bodies.items():
        if "truss" in name:
            model.bodies[name] = body.model_copy(update={"density": scale * DENSITY})
    return model


def in_plane(modes: object, k: int) -> bool:
    shape = modes.shapes[k]  # type: ignore[attr-defined]
    return bool(np.abs(shape[:, 2]).max() < 1e-3 * np.abs(shape[:, :2]).max())


def draw(axes: Axes, model: Model, shape: np.ndarray, title: str) -> None:
    """Draw flexures and bodies, moved by a mode: in the plane, or out of it in an oblique view."""
    amplitude = 30 * UM / np.abs(shape).max()
    oblique = np.array([[1.0, 0.0, 0.35], [0.0, 1.0, 0.5]])
    first = 0
    tips: dict[str, np.ndarray] = {}
    for name, rod in model.rods.items():
        count = (rod.order or 5) * (rod.elements or 1) + 1
        stations = slice(first, first + count)
        first += count
        ends = rod.frames([0.0, rod.length])[0]
        nodes = np.polynomial.legendre.Legendre.basis(count - 1).deriv().roots()
        where = 0.5 * (1.0 + np.concatenate([[-1.0], np.sort(nodes.real), [1.0]]))
        fine = np.linspace(0.0, 1.0, 41)
        moved = np.array([np.polyfit(where, column, count - 1) for column in np.real(shape[stations]).T])
        line = ends[0] + fine[:, None] * (ends[1] - ends[0])
        line = line + amplitude * np.array([np.polyval(c, fine) for c in moved]).T
        axes.plot(*(oblique @ line.T / UM), color="#0072B2", lw=1.4)
        tips |= {f"{name}.start": line[0], f"{name}.end": line[-1]}
        still = oblique @ ends.T / UM
        axes.plot(*still, color="0.75", lw=0.8, zorder=0)
    for body in model.bodies:
        corners = np.array([tips[a.a] for a in model.attachments if a.b == body])
        around = np.argsort(np.arctan2(*(corners - corners.mean(axis=0))[:, 1::-1].T), kind="stable")
        flat = np.ptp(corners[:, 1]) < 20 * UM  # a truss: its flexures end in a line
        shown = corners if flat else corners[around]
        axes.add_patch(
            Polygon((oblique @ shown.T / UM).T, closed=not flat, fc="#E69F0055", ec="#E69F00", lw=2.0)
        )
    axes.set_title(title, fontsize=9)
    axes.set_aspect("equal")
    axes.set_axis_off()


def main() -> None:
    model = resonator()
    masses = {name: body.total_mass() for name, body in model.bodies.items()}
    trusses = masses["upper_truss"] + masses["lower_truss"]
    expected = formula(masses["shuttle"], trusses)
    print(f"formula: {expected:.2f} Hz")
    for label, constraints in (("unshearable", "unshearable"), ("shearable", ())):
        modes = resonator(constraints).modes(MODES, about="reference")
        lowest = next(k for k in range(MODES) if in_plane(modes, k))
        print(f"{label}: {modes.frequencies[lowest]:.2f} Hz, {modes.frequencies[lowest] / expected - 1:+.2e}")
    heavy = resonator(scale=4.0)
    found = heavy.modes(MODES, about="reference")
    lowest = next(k for k in range(MODES) if in_plane(found, k))
    lumped = formula(masses["shuttle"], 4.0 * trusses)
    print(f"trusses four times as heavy: {found.frequencies[lowest]:.2f} Hz, formula {lumped:.2f} Hz")

    modes = model.modes(MODES, about="reference")
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    for k, axes in enumerate(figure.subplots(2, 3).ravel()):
        plane = "in the plane" if in_plane(modes, k) else "out of the plane"
        quality = 1.0 / (2.0 * modes.damping_ratios[k])
        print(f"mode {k + 1}: {modes.frequencies[k] / 1e3:.3f} kHz, Q = {quality:.0f}, {plane}")
        draw(axes, model, modes.shapes[k], f"{modes.frequencies[k] / 1e3:.2f} kHz, {plane}")
    figure.suptitle("flexures blue, shuttle and trusses orange, at rest grey", fontsize=9)
    figure.savefig(TARGET, dpi=110)


if __name__ == "__main__":
    main()

"""Run every shipped case and draw the pictures of docs/gallery.md: the shapes, and what the case is checked against.

python docs/figures/gallery.py [NAME ...]
"""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from gallery_checks import RIGHT, amplitudes, critical, curve, frequencies, lines
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case, shipped_cases
from viscorod.pictures.plots.assemblies import Assembly
from viscorod.pictures.plots.plot_shape import draw_shapes
from viscorod.pictures.plots.projection_view import Curves, View, draw_reference, mark_supports
from viscorod.pictures.style import figure, heading, legend_above, with_prefixes
from viscorod.results.text_numbers import quantity

TARGET = Path(__file__).parents[1] / "images" / "gallery"
DPI = 90
LARGEST = 60_000  # bytes of a picture
SNAPSHOTS = 11
WINDOWS = {  # of the snapshots, s, where the first half period or the whole motion tells less
    "cantilever_swing": (0.0, 0.88),
    "damped_strip": (0.0, 0.129),
    "rubber_strip": (0.0, 0.21),
    "soft_arm": (0.0, 0.25),
    "comb_resonator": (0.0, 3.0e-5),
    "spinning_up_arm": (4.0, 7.5),
    "prestressed_bridge": (0.4, 1.2),
}


def snapshots(picture: Figure, axes: Axes, run: vr.Run, start: float, end: float) -> None:
    """Draw rods and bodies at equal intervals of time, dark to light."""
    curves, assembly = Curves(run), Assembly(run)
    reference = np.asarray(run.data["reference_position"].values, dtype=float)
    coiled = curves.coiled(reference)
    times = np.linspace(start, end, 5 if coiled else SNAPSHOTS)
    positions = np.array([run.positions_at(float(time)) for time in times])
    rotations = np.array([run.rotations_at(float(time)) for time in times])
    ends = [assembly.ends(*state).reshape(-1, 3) for state in zip(positions, rotations, strict=True)]
    view = View.of(np.concatenate([*positions, *ends]), enlarged=assembly.empty)
    shifts = view.strip(positions) if coiled else np.zeros((times.size, 3))
    across = f", {view.enlarged} enlarged" if view.enlarged else ""
    view.prepare(axes, f"{quantity(start, 's', 3)} (dark) to {quantity(end, 's', 3)} (light){across}")
    if not coiled:
        draw_reference(axes, view, curves, run)
    colours = colormaps["viridis"](np.linspace(0.0, 0.88, times.size))
    for position, rotation, shift, colour in zip(positions, rotations, shifts, colours, strict=True):
        curves.draw(axes, view, position + shift, color=colour, linewidth=1.6)
        if not assembly.empty:
            assembly.draw(axes, view.shifted(shift), position, rotation, tuple(colour))
        mark_supports(axes, view, run, position + shift)
    view.finish(axes)


def draw(name: str) -> Path:
    """Compute one case and write its picture."""
    result = run_case(load_case(shipped_case(name)))
    picture = figure(9.6, 4.0)
    picture.suptitle(result.title, x=0.01, ha="left")
    picture.subplots_adjust(wspace=0.26)
    left, right = picture.subplots(1, 2)
    if isinstance(result, vr.Run):
        window = WINDOWS.get(name) or (float(result.time[0]), float(result.time[-1]))
        if name == "helix_spring":
            window = (0.0, 0.4)
        snapshots(picture, left, result, *window)
    elif isinstance(result, vr.FrequencyResponse):
        curve(left, result)
    elif isinstance(result, vr.Periodic):
        amplitudes(left, result)
    elif isinstance(result, vr.Campbell):
        lines(left, result)
    elif isinstance(result, vr.Stability):
        frequencies(left, result)
    elif isinstance(result, vr.Buckling):
        critical(0, 1.01773)(left, result)
    else:
        top = picture.subplotpars.top
        draw_shapes(left, result)
        left.get_legend().remove()
        picture.subplots_adjust(top=top)  # the legend had its room
        thin = "path (thin), last (bold)" if RIGHT[name].__name__ == "along" else "loaded (bold)"
        heading(left, f"Reference (dashed), {'turning (bold)' if name == 'swept_blade' else thin}")
    RIGHT[name](right, result)
    for axes in (left, right):
        if axes.get_xscale() == "linear":
            axes.locator_params(axis="x", nbins=6)
    legend_above(right, 4)
    with_prefixes(picture)
    shot = BytesIO()
    picture.savefig(shot, format="png", dpi=DPI)
    target = TARGET / f"{name}.png"
    target.parent.mkdir(parents=True, exist_ok=True)
    Image.open(shot).convert("RGB").quantize(128, kmeans=1, dither=Image.Dither.NONE).save(
        target, optimize=True
    )
    size = target.stat().st_size
    if size > LARGEST:
        raise SystemExit(f"{target} has {size} bytes, more than {LARGEST}")
    print(f"{target.name}: {size / 1000:.0f} kB", flush=True)
    return target


def main() -> None:
    for name in sys.argv[1:] or shipped_cases():
        draw(name)


if __name__ == "__main__":
    main()

"""Draw the picture of docs/howto/motions_in_modes.md, and print its numbers: two motions in 2 to 20 modes."""

import time
from pathlib import Path

import numpy as np

import viscorod as vr
from viscorod.pictures.style import BLUE, GREEN, GREY, RED, clean, figure, legend_above, write

IMAGES = Path(__file__).parents[1] / "images"
EXAMPLES = Path(__file__).parents[2] / "examples"
COUNTS = (2, 4, 8, 12, 16, 20)


def timed(model: vr.Model, duration: float, **given: object) -> tuple[vr.Run, float]:
    """Return a motion and the processor time [s] that it took."""
    began = time.process_time()
    return model.simulate(duration, formulation="intrinsic", **given), time.process_time() - began


def errors(model: vr.Model, duration: float, **given: object) -> tuple[list[float], list[float]]:
    """Return the largest distances of the free end from where all nodes put it, over its largest displacement.

    The second list has what each result tells of half as many modes.
    """
    whole, _ = timed(model, duration, **given, tolerance=1e-8, output_interval=duration / 100)
    place = whole.history("beam.end").values
    moved = np.linalg.norm(place - place[0], axis=1).max()
    found, told = [], []
    for count in COUNTS:
        run, _ = timed(model, duration, **given, modes=count, tolerance=1e-6, output_interval=duration / 100)
        found.append(np.linalg.norm(run.history("beam.end").values - place, axis=1).max() / moved)
        told.append(run.data.attrs.get("modes_motion_gap", np.nan))
        print(f"  {count} modes: {found[-1]:.2g}; told {told[-1]:.2g}")
    return found, told


swing = vr.load_case(EXAMPLES / "cantilever_swing.toml").model(vr.Model)
hinged = vr.load_case(EXAMPLES / "hinged_beam.toml").model(vr.Model)
cases = {
    "released cantilever, 2 s": (swing, 2.0, {}),
    "hinged beam, 1 s": (hinged, 1.0, {"initial": "reference"}),
    "hinged beam, linearised damping": (hinged, 1.0, {"initial": "reference", "damping": "linearised"}),
}
picture = figure(7.5, 4.2)
axes = picture.add_subplot()
for colour, (name, (model, duration, given)) in zip((BLUE, GREEN, RED), cases.items(), strict=True):
    print(name)
    found, told = errors(model, duration, **given)
    axes.semilogy(COUNTS, found, "o-", color=colour, label=name)
    axes.semilogy(COUNTS, told, "--", color=colour, linewidth=0.9)
axes.plot([], [], "--", color=GREY, linewidth=0.9, label="told: against half as many modes")
axes.set_xticks(COUNTS)
clean(axes, "vibration modes", "error of the free end / its motion")
axes.set_ylim(1e-6, 2.0)
legend_above(axes, 2)
print(write(picture, IMAGES / "motions_in_modes.png"))
for name, model, duration, given in (
    ("released cantilever", swing, 10.0, {}),
    ("hinged beam", hinged, 5.0, {"initial": "reference"}),
):
    timed(model, 0.01, modes=2, **given)  # compiles
    for count in (None, 4, 8, 20):
        run, took = min(
            (timed(model, duration, modes=count, **given) for _ in range(3)), key=lambda one: one[1]
        )
        steps = run.data.attrs["steps"]
        print(
            f"{name}, {count or 'all'} modes: {steps} steps, {took:.2f} s, {duration / took:.1f} times real time"
        )

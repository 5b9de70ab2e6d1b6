"""Measure the tables of docs/howto/choose_integrator.md: default steps over 20 periods, and three integrators compared.

python docs/figures/choose_integrator.py

Errors are differences from the same model with a far smaller tolerance on the same mesh. Times are processor time of a
second run, when all code is there.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import viscorod as vr
from viscorod.casefile.shipped import shipped_case
from viscorod.results.text_numbers import quantity

PERIODS = 20
FINE = 1e-10
"""Tolerance of what motions over 20 periods are compared with: they are small beside their models."""
EVERY, CLOSE = 0.05, 1e-9
"""Seconds between the states that are compared, and tolerance of their reference."""
CASES: dict[str, tuple[dict[str, Any], ...]] = {
    "cantilever_swing": (
        {},
        {"tolerance": 1e-6},
        {"integrator": "generalized_alpha"},
        {"integrator": "midpoint"},
    ),
    "right_angle_frame": (
        {},
        {"tolerance": 1e-6},
        {"integrator": "generalized_alpha"},
        {"integrator": "generalized_alpha", "tolerance": 1e-4},
        {"integrator": "midpoint"},
    ),
    "spinning_up_arm": (
        {"tolerance": 1e-4},
        {"tolerance": 1e-6},
        {"integrator": "generalized_alpha"},
        {"integrator": "midpoint"},
    ),
}
"""Shipped cases with their settings beside those of their files."""


def bar(material: vr.Material, length: float, height: float, width: float, **support: Any) -> vr.Model:
    """Return a rod along x that bends along y, clamped at its start."""
    model = vr.Model()
    section = vr.Rectangle(height, width)
    model.add(
        "bar",
        vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, material=material, elements=4, order=4),
    )
    model.clamp("bar.start", **support)
    return model


def steel_bar() -> vr.Model:
    return bar(vr.Material(2e11, 0.3, 7850.0), 1.0, 0.02, 0.02)


def sudden_force() -> tuple[vr.Model, str]:
    model = steel_bar()
    model.force("bar.end", (0, 8.0, 0))
    return model, "bar.end"


def deep_beam() -> tuple[vr.Model, str]:
    """Return the beam of NAFEMS 5T without its damping, under its sudden load."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0),
        (10, 0, 0),
        section=vr.Rectangle(2.0, 2.0),
        material=vr.Material(2e11, 0.3, 8000.0),
        elements=4,
        order=4,
    )
    model.add("bar", rod)
    model.support("bar.start", ["ux", "uy", "uz", "rx"])
    model.support("bar.end", ["uy", "uz", "rx"])
    model.distributed_force("bar", (0, -1e6, 0))
    return model, "bar@5.0"


def at_resonance(model: vr.Model, force: float) -> tuple[vr.Model, str]:
    """Return a model with a harmonic force at its end at its first frequency along y."""
    modes = model.modes(2)
    along = int(np.argmax([abs(shape[-1, 1]) / np.abs(shape).max() for shape in modes.shapes]))
    model.force("bar.end", (0, force, 0), time=vr.Sine(float(modes.frequencies[along])))
    return model, "bar.end"


def shaken_tower() -> tuple[vr.Model, str]:
    """Return a tower of concrete on ground that begins to swing by 2 mm."""
    ground = vr.Sine(0.5, -1e-3, phase=np.pi / 2.0, offset=1e-3)
    return bar(vr.Material(3e10, 0.2, 2500.0), 50.0, 4.0, 4.0, motion={"uy": ground}), "bar.end"


def silicon() -> vr.Model:
    return bar(vr.Material(160e9, 0.22, 2330.0), 2e-4, 4e-6, 2e-6)


SMALL: dict[str, Callable[[], tuple[vr.Model, str]]] = {
    "steel bar of 1 m, sudden force": sudden_force,
    "NAFEMS 5T (10 m x 2 m x 2 m, undamped)": deep_beam,
    "steel bar of 1 m, force at resonance": lambda: at_resonance(steel_bar(), 0.02),
    "concrete tower of 50 m on ground that shakes by 2 mm": shaken_tower,
    "silicon beam of 0.2 mm, force at resonance": lambda: at_resonance(silicon(), 2e-11),
}
"""What vibrates -> its model and the place that is compared."""


def over_periods(name: str) -> str:
    """Return a row: amplitude, steps, largest error of the place as a part of the amplitude."""
    model, place = SMALL[name]()
    duration = PERIODS / float(model.modes(1).frequencies[0])
    given: dict[str, Any] = {"output_interval": duration / 2000, "initial": "reference", "errors": False}
    runs = [model.simulate(duration, **given), model.simulate(duration, tolerance=FINE, **given)]
    moved, exact = (
        run.history(place, "displacement").values[:, 1]
        - run.history("bar.start", "displacement").values[:, 1]
        for run in runs
    )
    amplitude = float(np.ptp(exact)) / 2.0
    error = float(np.abs(moved - exact).max()) / amplitude
    return f"| {name}: {quantity(amplitude, 'm', 2)} | {runs[0].data.attrs['steps']} | {100 * error:.2g} % |"


def compared(name: str) -> list[str]:
    """Return the rows of a shipped case: steps, error over the size of the model, remainder, processor time."""
    case = vr.load_case(shipped_case(name))
    model = case.model(vr.Model)
    own = {word: getattr(case.settings, word) for word in case.settings.model_fields_set}
    own |= {"output_interval": EVERY, "errors": False}
    reference = model.simulate(**{**own, "tolerance": CLOSE})
    exact, rows = reference.data["position"].values, []
    for settings in CASES[name]:
        given = own | settings
        if settings.get("integrator", "radau") != "radau" and "tolerance" not in settings:
            given.pop("tolerance", None)  # equal steps
        model.simulate(**given)
        before = time.process_time()
        run = model.simulate(**given)
        took = time.process_time() - before
        size = float(run.data.attrs["scale_length"])
        error = float(np.linalg.norm(run.data["position"].values - exact, axis=-1).max()) / size
        words = [str(settings.get("integrator", "radau"))]
        words += [f"tolerance {given['tolerance']:g}"] if "tolerance" in given else []
        rows.append(
            f"| {case.title if not rows else ''} | {', '.join(words)} | {run.data.attrs['steps']} "
            f"({run.data.attrs['rejected']}) | {error:.1e} | {run.energy.numerical_fraction:.0e} | {took:.2g} s |"
        )
    return rows


def main() -> None:
    print("| undamped motion over 20 periods | steps | error of the place that moves most |\n|---|---|---|")
    for name in SMALL:
        print(over_periods(name), flush=True)
    print("\n| case | integrator | steps (rejected) | error | remainder | time |\n|---|---|---|---|---|---|")
    for name in CASES:
        print("\n".join(compared(name)), flush=True)


if __name__ == "__main__":
    main()

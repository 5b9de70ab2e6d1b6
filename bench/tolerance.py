"""Actual error against requested tolerance on five motions, and what it took.

    python bench/tolerance.py [case ...] [--tolerances 1e-2 1e-4]

The error is the largest displacement error of all stations at 400 equal times over the size of the model, against
the same mesh at a tolerance of 1e-10: what the time integration did. The motions are described in ``motions``.
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import viscorod as vr

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
REFERENCE = 1e-10


def llt() -> tuple[vr.Model, float, str]:
    """Damped cantilever of Linn, Lang and Tuganov, released, 5 s."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=material, elements=3, order=3)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model, 5.0, "equilibrium"


def spin_up() -> tuple[vr.Model, float, str]:
    """Spin-up of an undamped arm, Simo and Vu-Quoc 1986, 20 s."""
    model = vr.Model()
    section = vr.StiffnessSection([1e7, 1e7, 2.8e7, 1.4e4, 1.4e4, 1e4], [1.2, 1.2, 1.2, 6e-4, 6e-4, 1.2e-3])
    model.add("arm", vr.Rod.straight((0, 0, 0), (10, 0, 0), section=section, elements=2, order=5))
    model.clamp("arm.start", motion={"rz": vr.SpinUp(6.0, 15.0)})
    return model, 20.0, "equilibrium"


def flying_rod() -> tuple[vr.Model, float, str]:
    """Free rod thrown by a force and a couple, Simo and Vu-Quoc 1988, undamped, 6 s."""
    model = vr.Model()
    section = vr.StiffnessSection([1e4, 1e4, 1e4, 500, 500, 500], [1, 1, 1, 10, 10, 20])
    model.add("rod", vr.Rod.straight((0, 0, 0), (6, 0, -8), section=section, elements=4, order=4))
    triangle = vr.TimeTable([0, 2.5, 5], [0, 1, 0])
    model.force("rod.end", (20, 0, 0), time=triangle, until=5.0)
    model.moment("rod.end", (0, 200, 100), time=triangle, until=5.0)
    return model, 6.0, "reference"


def frame() -> tuple[vr.Model, float, str]:
    """Right-angle cantilever with an out-of-plane pulse at the elbow, Simo and Vu-Quoc 1988, undamped, 5 s."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 1e3], [1, 1, 1, 10, 10, 20])
    model.add("leg0", vr.Rod.straight((0, 0, 0), (0, 10, 0), section=section, elements=3, order=4))
    model.add("leg1", vr.Rod.straight((0, 10, 0), (10, 10, 0), section=section, elements=3, order=4))
    model.attach("leg0.end", "leg1.start")
    model.clamp("leg0.start")
    model.force("leg0.end", (0, 0, 50), time=vr.TimeTable([0, 1, 2], [0, 1, 0]), until=2.0)
    return model, 5.0, "reference"


def string() -> tuple[vr.Model, float, str]:
    """Steel string of Lang, Linn and Arnold 2011, clamped at one end, falls from the horizontal, 1 s."""
    length, radius, young, shear, density = 1.0, 1e-3, 2.1e11, 2.1e11 / 2.4, 7850.0
    area, moment = np.pi * radius**2, np.pi * radius**4 / 4
    section = vr.StiffnessSection(
        [shear * area, shear * area, young * area, young * moment, young * moment, 2 * shear * moment],
        [density * area] * 3 + [density * moment, density * moment, 2 * density * moment],
        damping=[0.1, 0.1, 2.0, 2e-4, 2e-4, 8e-6],
    )
    model = vr.Model()
    model.add("string", vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, elements=4, order=4))
    model.clamp("string.start")
    model.gravity((0, 0, -9.81))
    return model, 1.0, "reference"


MOTIONS = {f.__name__: f for f in (llt, spin_up, flying_rod, frame, string)}


OUTPUTS = 400
"""Equal times at which motions are compared, between steps as well."""


def error(run: vr.Run, reference: vr.Run) -> float:
    """Largest distance of any station at any stored time, over the size of the model."""
    distance = np.linalg.norm(run.data["position"].values - reference.data["position"].values, axis=2)
    return float(distance.max() / run.data.attrs["scale_length"])


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", default=list(MOTIONS), metavar="case", help=", ".join(MOTIONS))
    parser.add_argument("--tolerances", nargs="+", type=float, default=TOLERANCES)
    options = parser.parse_args()
    for name in options.cases:
        model, duration, initial = MOTIONS[name]()
        given = {"initial": initial, "output_interval": duration / OUTPUTS}
        reference = model.simulate(duration, tolerance=REFERENCE, **given)
        print(f"{name}: {MOTIONS[name].__doc__} ({reference.data.attrs['steps']} steps at {REFERENCE:g})")
        columns = "tolerance,error,error / tolerance,told / error,steps,rejected,iterations,factorised,energy lost,loop"
        print("|", columns.replace(",", " | "), "|")
        print("|---|---|---|---|---|---|---|---|---|---|")
        for tolerance in options.tolerances:
            run = model.simulate(duration, tolerance=tolerance, **given)
            a = run.data.attrs
            actual = error(run, reference)
            told = run.step_errors["position"] / a["scale_length"]
            print(
                f"| {tolerance:.0e} | {actual:.1e} | {actual / tolerance:.2g} "
                f"| {told / actual:.2g} | {a['steps']} | {a['rejected']} "
                f"| {a['iterations']} | {a['factorisations']} | {100 * run.energy.numerical_fraction:.2g} % "
                f"| {1e3 * a['loop_time_s']:.0f} ms |"
            )
        print()


if __name__ == "__main__":
    main()

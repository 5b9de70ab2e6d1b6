"""Compare periodic motions with those to which simulations settle, at twenty frequencies, and tell the processor time.

A strip between two clamps that hardens, driven in its middle: each stable motion of the curve against the last of 40
periods from rest. Run it with ``python bench/periodic_motions.py``.
"""

import time

import numpy as np
from scipy.interpolate import CubicHermiteSpline

import viscorod as vr

FORCE, BAND, COMPARED = 8.0, (85.0, 135.0), 20
"""Amplitude [N], frequencies [Hz], and how many motions of the curve are simulated."""


def strip(hertz=None):
    """Return the strip, with the force if a frequency [Hz] is given."""
    damping = vr.KelvinVoigt(shear_time=4e-4, bulk_time=4e-4)
    aluminium = vr.Material(youngs_modulus=70e9, poissons_ratio=0.33, density=2700.0, damping=damping)
    model = vr.Model()
    section = vr.Rectangle(0.025, 0.003)
    model.add(
        "beam",
        vr.Rod.straight((0, 0, 0), (0.4, 0, 0), section=section, material=aluminium, elements=2, order=3),
    )
    model.clamp("beam.start")
    model.clamp("beam.end")
    if hertz is not None:
        wave = vr.Sine(amplitude=1.0, frequency=hertz, phase=np.pi / 2)
        model.force("beam@0.2", (0, 0, FORCE), time=wave)
    return model


def main() -> None:
    """Print the comparison."""
    began = time.process_time()
    found = strip().periodic(
        inputs="beam@0.2 fz", amplitudes=[FORCE], outputs=["beam@0.2 uz"], frequencies=list(BAND)
    )
    spent = time.process_time() - began
    print(f"{len(found.frequencies)} motions with stability: {spent:.2f} s of processor time")
    worst = 0.0
    for k in np.linspace(0, len(found.frequencies) - 1, COMPARED).astype(int):
        hertz = float(found.frequencies[k])
        run = strip(hertz).simulate(40.0 / hertz, tolerance=1e-6, initial="reference")
        there = run.probe("beam@0.2")
        swing = CubicHermiteSpline(
            run.time, there["displacement"].values[:, 0, 2], there["velocity"].values[:, 0, 2]
        )
        times, course = found.course(int(k), 0, 50)
        difference = np.abs(swing(39.0 / hertz + times) - course).max() / np.abs(course).max()
        worst = max(worst, float(difference))
        print(f"{hertz:8.3f} Hz, amplitude {found.amplitude(0)[k]:.6f} m, differs by {difference:.1e}")
    print(f"largest difference {worst:.1e} of the amplitude")


if __name__ == "__main__":
    main()

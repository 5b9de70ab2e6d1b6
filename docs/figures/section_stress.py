"""Draw the figure of docs/howto/stress.md.

python docs/figures/section_stress.py
"""

from __future__ import annotations

from pathlib import Path

import viscorod as vr

TARGET = Path(__file__).parents[1] / "images" / "section_stress.png"


def main() -> None:
    rubber = vr.Material(2e6, 0.45, 1100.0)
    model = vr.Model()
    beam = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.02, 0.015), material=rubber)
    model.add("beam", beam)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.05, 0.03))
    model.moment("beam.end", (0.01, 0, 0))
    held = model.equilibrium(title="A rubber beam, bent and twisted")
    held.plot_stress(TARGET, "beam.start")


if __name__ == "__main__":
    main()

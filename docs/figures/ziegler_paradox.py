"""Draw flutter loads of Beck's column over its damping for docs/explanation/ziegler_paradox.md and print them.

python docs/figures/ziegler_paradox.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import viscorod as vr
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    clean,
    figure,
    legend_above,
    write,
)

TARGET = Path(__file__).parents[1] / "images" / "ziegler_paradox.png"
TIMES = np.geomspace(1e-5, 0.15, 17)
OUTSIDE = {
    0.0: (BLUE, "no damping from outside"),
    0.01: (GREEN, "c = 0.01"),
    0.1: (ORANGE, "c = 0.1"),
    1.0: (PURPLE, "c = 1"),
}


def beck(tau: float, outside: float = 0.0) -> vr.Model:
    """Return a column of EI, length and mass per length 1 under a force that follows its end."""
    C = np.diag([1.0, 1.0, 1.0, 1.0, 30.0, 1.0])
    section = vr.StiffnessSection(C, [1, 1, 1, 1e-12, 1e-12, 2e-12], damping=tau * C if tau else None)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section, elements=4, order=4, constraints="kirchhoff")
    model.add("column", rod)
    model.clamp("column.start")
    model.force("column.end", (0, 0, -1.0), following=True)
    if outside:
        model.drag("column", linear_across=outside)
    return model


def flutter(tau: float, outside: float = 0.0) -> float:
    """Return the flutter load."""
    found = beck(tau, outside).stability(band=(0.0, 26.0), count=6, modes=2)
    return min(limit.at for limit in found.limits)


def main() -> None:
    picture = figure(10.0, 4.4)
    picture.subplots_adjust(wspace=0.26, top=0.8)
    left, right = picture.subplots(1, 2)
    clean(left, "retardation time τ [L²√(m/EI)]", "flutter load [EI/L²]")
    bare = flutter(0.0)
    left.axhline(bare, color=GREY, linestyle="--", linewidth=1.0)
    left.annotate("without any damping, 20.05", (1.2e-5, bare + 0.2), color=GREY, fontsize=9.0)
    for outside, (colour, name) in OUTSIDE.items():
        loads = [flutter(float(tau), outside) for tau in TIMES]
        left.semilogx(TIMES, loads, color=colour, linewidth=1.6, label=name)
        print(name, [round(load, 4) for load in loads])
    left.set_ylim(9.5, 22.5)
    legend_above(left, 2)
    clean(right, "load [EI/L²]", "largest growth rate Re s [√(EI/m)/L²]")
    for tau, colour in ((0.0, GREY), (1e-3, BLUE), (1e-2, RED)):
        found = beck(tau).stability(band=(0.0, 22.0), count=111, modes=2)
        name = f"retardation time {tau:g}" if tau else "no damping"
        right.plot(
            found.load_factors, found.eigenvalues.real.max(axis=1), color=colour, linewidth=1.6, label=name
        )
    right.axhline(0.0, color="#222222", linewidth=0.8)
    right.set_xlim(8.0, 22.0)
    right.set_ylim(-0.12, 1.0)
    legend_above(right, 2)
    write(picture, TARGET)


if __name__ == "__main__":
    main()

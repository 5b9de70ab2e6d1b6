"""Write the table of mid-span deflections; its header says how far other meshes and a second formulation are."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

from . import ETAS, MODELS, RATIOS, TIMES, Damping, bridge, deflection, solve_in_strains

TABLE = Path("tests/reference/data/awp_bridge.csv")
HEADER = """\
# Prestressed beam under a moving harmonic load, AWP section V.A with I = 0.0243 m4: mid-span deflection in metres,
# positive along the load, at the times that head the columns; omega = ratio * 7.83 rad/s, eta in seconds.
# Written by: python -m tests.reference.independent
# L-L: closed form about the compressed state, stretch 1 - Q/EA included. NL-L, NL-NL: geometrically exact, shear-rigid,
# without rotary inertia. von Karman: axial viscous force eta EA u_t' (linearised) or eta EA (u' + w'^2/2)_t (full).
# The point load makes the error fall as the third power of the mesh width: the last digit may be wrong by one.
"""


def write_table() -> None:
    """Solve every case, measure the convergence, write the file."""
    cases = list(product(ETAS, RATIOS))
    body, notes = ["model,eta,ratio," + ",".join(f"{t}" for t in TIMES)], []
    for model in MODELS:
        values = {case: deflection(model, *case) for case in cases}
        coarse = max(np.abs(values[case] - deflection(model, *case, coarser=2)).max() for case in cases)
        notes.append(f"# {model}: half the mesh and half the steps change it by {coarse:.0e} m at most")
        if model in {"NL-L", "NL-NL"}:
            damping: Damping = "full" if model == "NL-NL" else "linearised"
            times = np.append(0.0, TIMES)
            other = max(
                np.abs(values[case] - solve_in_strains(bridge(*case), damping, times).deflection[1:]).max()
                for case in cases
            )
            notes[-1] += (
                f"; the intrinsic equations with AWP's shear and rotary inertia give it within {other:.0e} m"
            )
        body += [",".join([model, *map(str, case), *(f"{v:.6f}" for v in values[case])]) for case in cases]
        print(notes[-1], *body[-len(cases) :], sep="\n", flush=True)
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    TABLE.write_text(HEADER + "\n".join([*notes, *body]) + "\n")


if __name__ == "__main__":
    write_table()

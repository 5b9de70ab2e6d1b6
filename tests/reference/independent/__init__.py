"""Solutions of AWP V.A that share nothing with the package under test: other unknowns, bases, integrator and tangents.

``python -m tests.reference.independent``, from the repository root, writes ``tests/reference/data/awp_bridge.csv``.
"""

from __future__ import annotations

import numpy as np

from .galerkin import Array, Damping
from .planar_beam import solve_in_positions, solve_in_strains
from .problem import Bridge, Motion, frequencies, modal_sum
from .von_karman import solve_von_karman

__all__ = [
    "ETAS",
    "MODELS",
    "RATIOS",
    "TIMES",
    "Bridge",
    "Damping",
    "Motion",
    "bridge",
    "deflection",
    "frequencies",
    "modal_sum",
    "solve_in_positions",
    "solve_in_strains",
    "solve_von_karman",
]

MODELS = ("L-L", "NL-L", "NL-NL", "von Karman linearised", "von Karman full")
ETAS = (0.01, 0.001, 0.0001)
RATIOS = (0.75, 1.0, 1.25)
TIMES = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5])


def bridge(eta: float, ratio: float) -> Bridge:
    """Beam with the load at ``ratio`` times the printed 7.83 rad/s."""
    return Bridge(eta=eta, omega=ratio * 7.83)


def deflection(model: str, eta: float, ratio: float, *, coarser: int = 1) -> Array:
    """Mid-span deflection at TIMES, with the mesh and the steps of the table, both divided by ``coarser``."""
    case, times = bridge(eta, ratio), np.append(0.0, TIMES)
    if model == "L-L":
        return modal_sum(case, TIMES, 400 // coarser)
    damping: Damping = "full" if model in {"NL-NL", "von Karman full"} else "linearised"
    if model.startswith("von Karman"):
        motion = solve_von_karman(case, damping, times, modes=100 // coarser, steps=100 // coarser)
    else:
        motion = solve_in_positions(case, damping, times, spans=80 // coarser, steps=100 // coarser)
    return motion.deflection[1:]

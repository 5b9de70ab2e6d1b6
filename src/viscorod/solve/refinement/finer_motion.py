"""A whole motion on the finer mesh: from which state it begins, and how far it is from that on the coarse one."""

from __future__ import annotations

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.refinement.correction import Balance, counterpart
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape
from viscorod.solve.refinement.half_elements import read
from viscorod.solve.refinement.inertial_forces import CoarseMotion
from viscorod.typing import Floats

__all__ = ["finer_start", "run_gaps"]


def finer_start(moving: CoarseMotion, start: Snapshot, anchor: float) -> State | None:
    """Return the state at t = 0 on the finer mesh, in balance with the inertial forces of the coarse one.

    What reading it there leaves out of balance would set off vibrations that neither motion has.

    Args:
        moving: the coarse mesh; start: the state; anchor: see ``Balance`` [1/s^2].
    """
    finer, shape = moving.finer, Shape.of(start)
    stress = moving.other_stress(start.state, start.section_force, 0.0, before=False)
    rates = moving.rates([shape], [stress], [0.0], before=False)
    carried = finer.carried([shape])
    inertia = moving.inertia(start.state.r, start.state.q, rates, carried.q)[0]
    finer.set_prestress(read(finer.halves.points, stress))
    found = counterpart(Balance(finer, 0.0, before=False, inertia=inertia, anchor=anchor), carried)
    return None if found is None else found.state


def run_gaps(finer: FinerMesh, r: Floats, fine_r: Floats) -> tuple[dict[str, float], float]:
    """Return how far two motions are apart at most on every rod [m], and the largest displacement [m].

    Args:
        r, fine_r: positions of the finer stations at the same times, on both meshes ``(k, stations, 3)`` [m].
    """
    away = np.linalg.norm((r - finer.coarse_reference) - (fine_r - finer.reference), axis=-1)
    gaps = np.maximum.reduceat(away.max(axis=0), finer.halves.finer_stations)
    moved = float(np.linalg.norm(fine_r - finer.reference, axis=-1).max())
    return dict(zip(finer.coarse.rods, gaps.tolist(), strict=True)), moved

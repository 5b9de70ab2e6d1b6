"""Initial velocities beside what supports and joints allow."""

from __future__ import annotations

import numpy as np

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System

__all__ = ["blow_at_start"]

ALLOWED = 1e-6
"""Part of the fastest velocity by which one that is given may differ from one that is held."""


def blow_at_start(system: System, supports: SupportState, state: State) -> list[str]:
    """Return a warning if supports or joints hold what the initial velocities of ``state`` move, else nothing.

    A motion starts with velocities that they allow: those that are given change by a blow.
    """
    problem, constraints = system.problem, system.constraints
    supports.update(0.0)
    there = state.copy()
    supports.prescribe(there)
    supports.project_twists(there)
    unit = np.array([1.0, 1.0, 1.0, *(problem.length,) * 3])  # of turning, as a velocity [m/s]
    least = ALLOWED * np.abs(state.twist * unit).max()
    changed = np.abs((there.twist - state.twist)[supports.set.nodes] * unit).max(axis=1, initial=0.0)
    held = [supports.set.names[k] for k in np.flatnonzero(changed > least)]
    if constraints.rows:
        constraints.update(0.0)
        rates = np.abs(constraints.measure(there)[1] - constraints.target_rate) / constraints.joints.unit
        joined = np.flatnonzero(constraints.is_held & (rates * problem.length > least))
        held += [constraints.joints.label(int(c)) for c in joined]
    if not held:
        return []
    names = list(dict.fromkeys(held))
    more = f" and {len(names) - 6} more" if len(names) > 6 else ""
    return [
        f"velocities: {', '.join(names[:6])}{more} {'holds' if len(names) == 1 else 'hold'} what the given velocities "
        "move: the motion begins with a blow there, which sends waves along the rods; give velocities that supports "
        "and joints allow, such as a field that is zero at a clamp"
    ]

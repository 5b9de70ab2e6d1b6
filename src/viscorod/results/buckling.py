"""The result of a search for critical loads."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from viscorod.results.text_table import table
from viscorod.typing import Floats

__all__ = ["Buckling"]


@dataclass(frozen=True, repr=False)
class Buckling:
    """Critical loads, in the order in which the equilibria pass them.

    Attributes:
        load_factors: multiples of the loads that grow ``(k,)``; of several directions that lose their stiffness at
            once each has one.
        linear: those of the linear problem at the state ``about`` ``(m,)``, the nearest first.
        limit: whether the load has an extreme there, at which the structure snaps; elsewhere equilibria branch off.
        shapes: displacement of every station as stiffness vanishes ``(k, stations, 3)``, global axes, the largest
            component 1 (of the rotations where they are pure twist).
        rotations: of every station ``(k, stations, 3)``, body axes, same scaling.
        positions: of the stations in the critical states ``(k, stations, 3)`` [m].
        about: load factor of the state of the linear problem.
        exact: whether the equilibria were followed; otherwise all is that of the linear problem.
        complete: whether as many were found as asked for.
        errors: estimated errors of the factors by the mesh, in parts of them; none where not estimated.
    """

    load_factors: Floats
    linear: Floats
    limit: np.ndarray
    shapes: Floats
    rotations: Floats
    positions: Floats
    about: float
    exact: bool
    complete: bool
    errors: Floats = field(default_factory=lambda: np.zeros(0))

    def report(self) -> str:
        """Return a table of the critical loads, and what is to be known about them."""
        rows = []
        for k, factor in enumerate(self.load_factors):
            gives = "limit point: it snaps" if self.limit[k] else "bifurcation: it buckles"
            row = [str(k + 1), f"{factor:.8g}", gives if self.exact else "linear problem"]
            rows.append([*row, f"{self.errors[k]:.1g}"] if len(self.errors) else row)
        header = ["number", "load factor", "what it is", *(["mesh error"] if len(self.errors) else [])]
        heading = "Critical loads, on the way of the equilibria" if self.exact else "Critical loads, linear"
        blocks = [table(heading, header, rows)] if rows else [f"{heading}\n  none were found"]
        linear = ", ".join(f"{factor:.6g}" for factor in self.linear) or "none"
        blocks.append(f"Of the linear problem at the load factor {self.about:g}: {linear}")
        if not self.complete:
            blocks.append("Fewer were found than asked for: the equilibria keep their stiffness beyond these")
        return "\n\n".join(blocks)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return f"Buckling(load_factors={self.load_factors.tolist()})"

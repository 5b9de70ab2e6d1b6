"""The result of a search for critical loads."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from viscorod.checks import checked
from viscorod.results.result import Result
from viscorod.results.text_table import listed, page, table
from viscorod.shown import counted
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Buckling"]


class Buckling(Result):
    """Critical loads, in the order in which the equilibria pass them.

    That is the order of their size up to the first limit point. There the load falls, and what comes after may be
    smaller: a load that grows from zero comes to the first one first. The report says so where it is.

    ``data`` holds the state about which the linear problem is solved along the dimension ``load_factor``, and the
    critical loads along ``critical``.
    """

    kind: ClassVar[str] = "buckling"
    what: ClassVar[str] = "list of critical loads"

    def _facts(self) -> Iterator[str]:
        factors = self.load_factors
        yield counted(len(factors), "critical load")
        if len(factors):
            yield f"the first at the load factor {factors[0]:.5g}"
        yield from super()._facts()

    @property
    def load_factors(self) -> Floats:
        """Multiples of the loads that grow ``(k,)``; of several directions soft at once each has one.

        In the order in which the equilibria pass them, ``min`` is not the first one where the load falls between.
        """
        return self._values("critical_load")

    @property
    def linear(self) -> Floats:
        """Those of the linear problem at the state ``about`` ``(m,)``, the nearest first."""
        return self._values("linear_load")

    @property
    def limit(self) -> np.ndarray:
        """Whether the load has an extreme there ``(m,)``, at which the structure snaps; elsewhere others branch off."""
        return np.asarray(self.data["critical_limit"].values, dtype=bool)

    @property
    def shapes(self) -> Floats:
        """Displacement of every station as stiffness vanishes ``(k, stations, 3)``, global axes.

        The largest component is 1 (of the rotations where they are pure twist).
        """
        return self._values("critical_shape")

    @property
    def rotations(self) -> Floats:
        """Rotation of every station ``(k, stations, 3)``, body axes, same scaling."""
        return self._values("critical_rotation")

    @property
    def positions(self) -> Floats:
        """Positions of the stations in the critical states ``(k, stations, 3)`` [m]."""
        return self._values("critical_position")

    @property
    def about(self) -> float:
        """Load factor of the state of the linear problem."""
        return float(self.data["load_factor"].values[-1])

    @property
    def exact(self) -> bool:
        """Whether the equilibria were followed; otherwise all is that of the linear problem."""
        return bool(self.data.attrs["buckling_exact"])

    @property
    def complete(self) -> bool:
        """Whether as many were found as asked for."""
        return bool(self.data.attrs["buckling_complete"])

    @property
    def errors(self) -> Floats:
        """Estimated errors of the factors by the mesh, in parts of them ``(m,)``; none where not estimated."""
        return self._values("critical_error") if "critical_error" in self.data else np.zeros(0)

    def with_errors(self, errors: Floats) -> Self:
        """Return the same with estimated errors of the factors ``(k,)``."""
        return type(self)(self.data.assign(critical_error=("critical", errors)))

    def report(self) -> str:
        """Return a table of the critical loads, and what is to be known about them."""
        rows, errors = [], self.errors
        for k, factor in enumerate(self.load_factors):
            gives = "limit point: it snaps" if self.limit[k] else "bifurcation: it buckles"
            row = [str(k + 1), f"{factor:.8g}", gives if self.exact else "linear problem"]
            rows.append([*row, f"{errors[k]:.1g}"] if len(errors) else row)
        header = ["number", "load factor", "what it is", *(["mesh error"] if len(errors) else [])]
        heading = "Critical loads, on the way of the equilibria" if self.exact else "Critical loads, linear"
        blocks = [self.title] if self.title else []
        blocks.append(table(heading, header, rows) if rows else f"{heading}\n  none were found")
        blocks += self._passed_later()
        linear = ", ".join(f"{factor:.6g}" for factor in self.linear) or "none"
        blocks.append(f"Of the linear problem at the load factor {self.about:g}: {linear}")
        if self.outcome != "completed":
            blocks.append(
                "The search ended before as many were found as asked for; those beyond are not known"
            )
        elif not self.complete:
            blocks.append(f"Fewer were found than asked for{self._until()}")
        if self.warnings:
            blocks.append(listed("Warnings", self.warnings))
        return page(blocks)

    def _passed_later(self) -> list[str]:
        """Return a sentence where critical loads that are passed later are smaller: the load falls on the way."""
        factors = self.load_factors
        if not self.exact or not (np.diff(factors) < 0.0).any():
            return []
        later = np.flatnonzero(factors < np.maximum.accumulate(factors)) + 1
        numbers = ", ".join(map(str, later))
        which = f"number {numbers} is" if len(later) == 1 else f"numbers {numbers} are"
        return [
            f"Beyond a limit point the load falls: {which} passed there, at a smaller load, on equilibria that are "
            "unstable already; a load that grows comes to number 1 first"
        ]

    def _until(self) -> str:
        """Return where the search ended, in words."""
        if "buckling_reached" not in self.data.attrs:
            return ": there are no more"
        reached = float(self.data.attrs["buckling_reached"])
        return (
            f": the equilibria were followed to the load factor {reached:.6g} and keep their stiffness up to there. "
            "Those beyond are found with `about`, from a load factor near them"
        )

    @checked
    def plot(
        self,
        path: str | Path | None = None,
        count: int | None = None,
        *,
        number: int | None = None,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the shapes in which the model gives way.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            count: how many are drawn, all by default; number: of one that is drawn alone, from 1.
            ax: axes of yours to draw into: one shape, by default the first.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such load, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_buckling import draw_buckling

        return delivered(draw_buckling(self, count, number, ax), path)

    def __str__(self) -> str:
        return self.report()

    def _values(self, name: str) -> Floats:
        return np.asarray(self.data[name].values, dtype=float)

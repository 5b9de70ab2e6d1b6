"""The result of statics: an equilibrium with the steps that led there, or a path of equilibria."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.last_state import LastState
from viscorod.shown import counted, span
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Equilibrium"]

_SPECIAL = ("limit_points", "bifurcations", "flutter_points")


class Equilibrium(LastState):
    """A static equilibrium; the last load factor is the result, the earlier ones are the steps to it.

    One that ``Model.path`` found holds the points of a path, along which loads may grow and shrink.
    """

    kind: ClassVar[str] = "equilibrium"

    def _facts(self) -> Iterator[str]:
        factors = self.load_factor
        yield f"load factor {span(float(factors.min()), float(factors.max()), '')}"
        yield counted(len(factors), "state")
        yield "stable" if self.stable else "unstable"
        yield from super()._facts()

    @property
    def load_factor(self) -> Floats:
        """Parts of the loads at which states are stored ``(states,)``: increasing to 1, or in the order of a path."""
        return np.asarray(self.stored["load_factor"].values, dtype=float)

    @property
    def negative_eigenvalues(self) -> int:
        """Number of negative eigenvalues of the tangent stiffness: 0 where the equilibrium is stable.

        Where following loads or moments about fixed axes make the stiffness unsymmetric it is the number of small
        motions that grow instead; `stability` says which it is.
        """
        return int(self.data.attrs.get("negative_eigenvalues", 0))

    @property
    def found_by(self) -> str:
        """How it was found, in words: load steps, or settling where these fail or end at an unstable equilibrium."""
        return str(self.data.attrs.get("found_by", ""))

    @property
    def stage_ends(self) -> Integers:
        """Numbers of the states at the ends of its stages ``(k,)``; the last one without stages."""
        ends = json.loads(self.data.attrs.get("stage_ends", "null"))
        return np.array([len(self.load_factor) - 1] if ends is None else ends, dtype=np.int64)

    @property
    def stable(self) -> bool:
        """True if no small motion about the equilibrium grows."""
        return self.negative_eigenvalues == 0

    @property
    def stability(self) -> str:
        """What stability was judged by: the "tangent stiffness", or "small motions" where that is not symmetric.

        It says so where not all of the slowest motions were found, so that others may grow.
        """
        return str(self.data.attrs.get("stability", "tangent stiffness"))

    @property
    def is_path(self) -> bool:
        """True if the states are the points of a path."""
        return "limit_points" in self.data.attrs

    @property
    def limit_points(self) -> Floats:
        """Load factors at which the path turns from growing to shrinking loads or back ``(k,)``, in its order."""
        return self._special("limit_points")

    @property
    def bifurcations(self) -> Floats:
        """Load factors at which other paths cross this one ``(k,)``, in its order."""
        return self._special("bifurcations")

    @property
    def multiplicity(self) -> Integers:
        """Number of directions in which other paths leave at each bifurcation: 2 for a column as stiff both ways."""
        return np.array(json.loads(self.data.attrs.get("multiplicity", "[]")), dtype=np.int64)

    @property
    def flutter_points(self) -> Floats:
        """Load factors at which growing oscillations begin or end ``(k,)``, in the order of the path."""
        return self._special("flutter_points")

    @checked
    def special_points(self, kind: str) -> Integers:
        """Return the numbers of the states ``(k,)`` that are "limit_points", "bifurcations" or "flutter_points".

        Raises:
            InputError: another word.
        """
        if kind not in _SPECIAL:
            raise InputError(f"kind = {kind!r} is no kind of point; it can be {', '.join(_SPECIAL)}")
        return np.array(json.loads(self.data.attrs.get(kind, "[]")), dtype=np.int64)

    def _special(self, kind: str) -> Floats:
        factors: Floats = self.load_factor[self.special_points(kind)]
        return factors

    def report(self) -> str:
        """Return a report: ends of the rods, reactions, energy, stability, the effort, warnings."""
        from viscorod.results.reports.equilibrium_report import equilibrium_report

        return equilibrium_report(self)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw the reference shape and the way to the equilibrium, for a path also loads over displacement.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the shapes, or of a path the load factor over displacement.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_path import draw_path
        from viscorod.pictures.plots.plot_shape import draw_shape

        return delivered(draw_path(self, ax) if self.is_path else draw_shape(self, ax), path)

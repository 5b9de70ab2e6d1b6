"""The result of stability along a load: modes over the load factor, flutter and divergence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from viscorod.checks import checked
from viscorod.results.followed_modes import FollowedModes
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Stability"]


class Stability(FollowedModes):
    """Modes about the equilibria of a model over its load factor, each followed through crossings and veerings.

    ``data`` is an ``xarray.Dataset`` by ``load_factor`` and ``mode``: roots, frequencies [Hz], damping ratios, where
    modes begin to flutter or diverge, and where frequencies cross and veer.
    """

    kind: ClassVar[str] = "stability"
    picture: ClassVar[str] = "stability"
    what: ClassVar[str] = "stability along a load"
    along: ClassVar[str] = "load_factor"
    unit: ClassVar[str] = ""

    @property
    def load_factors(self) -> Floats:
        """Load factors ``(n,)``."""
        return self.values

    def _heading(self) -> str:
        factors = self.load_factors
        title = f"{self.title}\n" if self.title else ""
        return (
            f"{title}Stability along a load, {len(self.modes)} modes at {len(factors)} load factors from "
            f"{factors[0]:.6g} to {factors[-1]:.6g}"
        )

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw frequencies and rates of growth over the load factor, with flutter and divergence.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the frequencies alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_campbell import draw_stability

        return delivered(draw_stability(self, ax), path)

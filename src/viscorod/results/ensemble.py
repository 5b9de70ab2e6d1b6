"""Result of an ensemble: quantiles of its quantities with their errors, Sobol' indices, pictures."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from viscorod.checks import checked, numbers
from viscorod.errors import Fault, InputError
from viscorod.results.block_errors import mean_error, quantile_interval
from viscorod.results.ensemble_design import Design
from viscorod.results.ensemble_report import report_of
from viscorod.results.sobol_indices import with_intervals
from viscorod.results.sweep_result import Sweep
from viscorod.typing import Floats

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["CONFIDENCE", "Design", "Ensemble"]

CONFIDENCE = 0.95
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
LEAST = 8
"""Members from which on there are quantiles and indices."""


class Ensemble(Sweep):
    """The members of an ensemble, which is a sweep over uncertain values.

    Attributes:
        design: how they were chosen.
    """

    design: Design

    @classmethod
    def of_sweep(cls, sweep: Sweep, design: Design) -> Self:
        """Return a sweep whose members were chosen by a design.

        Raises:
            InputError: it has another number of members.
        """
        found = cls(sweep.members, sweep.title, sweep.notes)
        if len(sweep.members) != design.members:
            raise InputError(f"{len(sweep.members)} members are no ensemble of {design.members}")
        found.design = design
        return found

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the quantities that are numbers, no histories, and that enough members have."""
        return tuple(name for name in self._columns if not self._too_few(name))

    @property
    def scarce(self) -> tuple[str, ...]:
        """What is wrong with the other quantities that are numbers, in words: too few members have them."""
        return tuple(told for name in self._columns if (told := self._too_few(name)))

    @property
    def samples(self) -> int:
        """How many members are samples of the distributions: of an ensemble with indices two for every point."""
        return self.design.n * self.design.samples

    @property
    def partial(self) -> tuple[str, ...]:
        """Which of the numbers not all samples have, in words: quantiles are those of the samples that have them."""
        found = []
        for name in self.numbers:
            have, count = len(self._samples(name)), self.samples
            if have < count:
                found.append(
                    f"{name}: {have} of {count} samples have it, and quantiles are those of these alone: if "
                    "others have none because of their values, they are not those of all"
                )
        return tuple(found)

    def _too_few(self, name: str) -> str:
        """Say that too few of the members that are samples of a quantity have it; empty if enough have."""
        count = len(self._samples(name))
        which = "member has" if count == 1 else "members have"
        return f"{name}: {count} {which} it; {LEAST} are needed" if count < LEAST else ""

    @cached_property
    def _columns(self) -> dict[str, Floats]:
        """Values of every quantity of all members; NaN where there are none."""
        found = self.table()
        return {name: found[name].to_numpy(dtype=float) for name in self.quantities if name in found}

    def values(self, quantity: str) -> Floats:
        """Return a quantity of the members that are independent samples of it, in their order ``(k,)``.

        Raises:
            InputError: there is no such quantity, or too few members have it.
        """
        if quantity not in self._columns:
            known = ", ".join(self._columns) or "none"
            raise InputError(
                Fault("quantity", str(quantity), "there is no such number", f"there are {known}")
            )
        if told := self._too_few(quantity):
            raise InputError(told)
        return self._samples(quantity)

    def _samples(self, quantity: str) -> Floats:
        column = self._points(quantity).T.reshape(-1)
        return column[np.isfinite(column)]

    def _points(self, quantity: str) -> Floats:
        """Return a quantity at every point, of the members that are samples ``(points, 1 or 2)``; NaN for none."""
        return self._columns[quantity].reshape(self.design.n, -1)[:, : self.design.samples]

    @property
    def pictured(self) -> np.ndarray:
        """Which members stand for the distributions: the other rows for indices repeat their values ``(members,)``."""
        return np.arange(len(self.members)) % self.design.rows < self.design.samples

    def _require_numbers(self) -> None:
        if not self.numbers:
            raise InputError("; ".join(self.scarce) or "no quantity of this ensemble is a number")

    def quantiles(self, levels: Sequence[float] = LEVELS) -> pd.DataFrame:
        """Return quantiles of all quantities, with intervals of 95 % confidence.

        Of 64 samples and more the intervals are those of 16 blocks of consecutive Sobol' points as replicates, which
        tell how much more evenly these lie than independent ones (``viscorod.results.block_errors``); of fewer those of
        order statistics (``scipy.stats.quantile_test``), as if they were independent. Where members are too few for a
        bound, it is infinite. Quantities that fewer than 8 members have are left out (``scarce``).

        Args:
            levels: probabilities between 0 and 1.

        Returns:
            A table by quantity and level: ``value``, ``lower``, ``upper``, and the value from the first half of the
            members, ``half``, which shows how it converges.

        Raises:
            InputError: a level is no probability, or too few members have any quantity.
        """
        import pandas as pd

        levels = np.atleast_1d(numbers("levels", levels)).tolist()
        wrong = [level for level in levels if not 0.0 < level < 1.0]
        if wrong:
            raise InputError(Fault("levels", repr(wrong[0]), "no probability", "give 0.05 or 0.95"))
        self._require_numbers()
        rows = []
        for name in self.numbers:
            values, points = self.values(name), self._points(name)
            for level in levels:
                lower, upper = quantile_interval(points, level, CONFIDENCE)
                rows.append(
                    {
                        "quantity": name,
                        "level": level,
                        "value": float(np.quantile(values, level)),
                        "lower": lower,
                        "upper": upper,
                        "half": float(np.quantile(values[: len(values) // 2], level)),
                    }
                )
        return pd.DataFrame(rows).set_index(["quantity", "level"])

    def moments(self) -> pd.DataFrame:
        """Return mean, its standard error, and standard deviation of all quantities; errors as those of quantiles.

        Raises:
            InputError: too few members have any quantity.
        """
        import pandas as pd

        self._require_numbers()
        rows = {}
        for name in self.numbers:
            values = self.values(name)
            rows[name] = {
                "mean": float(values.mean()),
                "error": mean_error(self._points(name)),
                "deviation": float(values.std(ddof=1)),
            }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("quantity")

    def indices(self) -> pd.DataFrame:
        """Return the Sobol' indices of all quantities, with intervals of 95 % confidence.

        ``first`` is the part of the variance that is due to a key alone, ``total`` the part in which it takes part
        (estimators of Saltelli et al. 2010 and Jansen 1999). Intervals are those of a bootstrap over the points.
        Estimates of small indices may be negative within these. Points of which a member failed are left out, and so
        are quantities that do not vary or that have fewer than 8 whole points.

        Returns:
            A table by quantity and key: ``first``, ``first_lower``, ``first_upper``, ``total``, ``total_lower``,
            ``total_upper``.

        Raises:
            InputError: the ensemble was computed without indices, no quantity varies, or points are too few.
        """
        import pandas as pd

        rows, without = self._sobol_rows
        if not rows:
            raise InputError("; ".join(without))
        return pd.DataFrame(rows).set_index(["quantity", "key"])

    @property
    def without_indices(self) -> tuple[str, ...]:
        """Which numbers have no Sobol' indices, or those of some points only, in words."""
        return tuple(self._sobol_rows[1])

    @cached_property
    def _sobol_rows(self) -> tuple[list[dict[str, Any]], list[str]]:
        if not self.design.indices:
            raise InputError("the ensemble has no rows for Sobol' indices; compute it with indices=True")
        self._require_numbers()
        rows: list[dict[str, Any]] = []
        without: list[str] = []
        for name in self.numbers:
            found = self._columns[name].reshape(self.design.n, -1)
            whole = found[np.isfinite(found).all(axis=1)]
            if len(whole) < LEAST:
                without.append(f"{name}: {len(whole)} points have all their members; {LEAST} are needed")
                continue
            if not np.ptp(whole[:, :2]) > 0.0:
                without.append(f"{name} does not vary; it has no Sobol' indices")
                continue
            if len(whole) < len(found):
                told = f"{name}: {len(whole)} of {len(found)} points have all their members"
                without.append(f"{told}; the others are left out of its indices")
            of_keys = with_intervals(whole, self.design.seed, CONFIDENCE)
            rows += [
                {"quantity": name, "key": key, **numbers}
                for key, numbers in zip(self.design.keys, of_keys, strict=True)
            ]
        return rows, without

    def report(self) -> str:
        """Return the distributions, quantiles of all quantities, indices, how it converges, and what failed."""
        return report_of(self)

    @checked
    def plot(
        self,
        path: str | Path | None = None,
        *,
        name: str | None = None,
        x: str | None = None,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the distribution of every quantity with its quantiles and their errors, or members over a number.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            name: of a quantity that is drawn alone.
            x: key of a number over which the members are drawn instead, see ``Sweep.plot``.
            ax: axes of yours to draw into: one quantity, by default the first.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such quantity or number, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_ensemble import draw_quantiles

        if x is not None:
            return super().plot(path, name=name, x=x, ax=ax)
        return delivered(draw_quantiles(self, name, ax), path)

    @checked
    def plot_indices(
        self, path: str | Path | None = None, *, name: str | None = None, ax: Axes | None = None
    ) -> Figure:
        """Draw the Sobol' indices of every quantity, the largest on top.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            name: of a quantity that is drawn alone.
            ax: axes of yours to draw into: one quantity, by default the first.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such quantity, no indices, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_ensemble import draw_indices

        return delivered(draw_indices(self, name, ax), path)

    @checked
    def plot_fan(
        self, path: str | Path | None = None, name: str | None = None, *, ax: Axes | None = None
    ) -> Figure:
        """Draw the quantiles over time of a quantity that is a history.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            name: of the quantity; by default the first that is a history.
            ax: axes of yours to draw into: the same.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such history, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_ensemble import draw_fan

        return delivered(draw_fan(self, name, ax), path)

    def attributes(self) -> dict[str, str]:
        """Return what a file says beside its members."""
        return super().attributes() | {"ensemble": self.design.record}

    @classmethod
    def of(cls, data: xr.Dataset, path: Path) -> Ensemble:
        """Return the ensemble whose file is ``path`` and whose root is ``data``."""
        design = Design.of_record(str(data.attrs.get("ensemble", "")), str(path))
        return cls.of_sweep(Sweep.of(data, path), design)

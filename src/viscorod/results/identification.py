"""The result of an identification: fitted numbers with intervals, what is left, what the data cannot tell, laws."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.results.identification_data import VARIABLES
from viscorod.results.identified import Foretold, Law, Number
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.shown import counted
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.casefile.case import Case

__all__ = ["Identification"]

MISSES = "model misses motion"
UNSETTLED = "search not at rest"
VERY_WIDE = 1e6
"""Variance along what the data do not see, over the largest that they do."""


class Identification(StatelessResult):
    """Numbers of cases that were fitted to records, with intervals.

    ``data`` is an ``xarray.Dataset`` with the unknowns, their covariance, all values measured and predicted, the noise,
    what the data tell of combinations, and laws that were compared.
    """

    kind: ClassVar[str] = "identification"
    picture: ClassVar[str] = "fit"
    what: ClassVar[str] = "identification"

    @classmethod
    def variables(cls) -> Variables:
        """See :class:`StatelessResult`."""
        return VARIABLES

    def _facts(self) -> Iterator[str]:
        numbers = list(self.numbers.values())
        yield counted(len(numbers), "number")
        told = sum(one.told for one in numbers)
        yield f"{told} told by the data"
        yield from super()._facts()

    @property
    def level(self) -> float:
        """Probability of the intervals."""
        return float(self.data.attrs.get("level", 0.95))

    @property
    def numbers(self) -> dict[str, Number]:
        """The unknowns by name: those of the model and those of the measurement."""
        data = self.data
        errors = self._values("standard_error") * np.where(
            self._values("relative") > 0.0, np.abs(self._values("estimate")), 1.0
        )
        found = {}
        for k, name in enumerate(data["unknown"].values):
            relative = bool(data["relative"].values[k])
            low = (
                (0.0 if relative else -np.inf) if data["low_open"].values[k] else float(data["low"].values[k])
            )
            high = np.inf if data["high_open"].values[k] else float(data["high"].values[k])
            how = "; ".join([str(data["interval_by"].values[k]), *([self.doubt] if self.doubt else [])])
            found[str(name)] = Number(
                str(name),
                float(data["estimate"].values[k]),
                low,
                high,
                float(errors[k]),
                how,
                str(data["unknown_unit"].values[k]),
            )
        return found

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Ends of the intervals by name; infinite (0 below, of positive numbers) where the data cannot tell."""
        return {name: (one.low, one.high) for name, one in self.numbers.items()}

    @property
    def parameters(self) -> dict[str, Number]:
        """Those of the model."""
        mine = self._values("nuisance") == 0.0
        return {name: one for (name, one), own in zip(self.numbers.items(), mine, strict=True) if own}

    @property
    def nuisances(self) -> dict[str, Number]:
        """Those of the measurement, or that were called so."""
        return {name: one for name, one in self.numbers.items() if name not in self.parameters}

    @property
    def combinations(self) -> dict[str, Number]:
        """What the data tell of several unknowns together, by name."""
        how = self.doubt
        values, low, high = (self._values(f"combination_{word}") for word in ("value", "low", "high"))
        return {
            name: Number(name, float(value), float(below), float(above), how=how, unit=unit)
            for (name, unit), value, below, above in zip(
                self.words("combinations"), values, low, high, strict=True
            )
        }

    @property
    def in_programs(self) -> dict[str, Number]:
        """The damping in the numbers of other programs, by program and number, in SI as the programs take them."""
        how = self.doubt
        values, low, high = (self._values(f"program_{word}") for word in ("value", "low", "high"))
        names = self.words("program_numbers")
        units = self.words("program_units") or [""] * len(names)
        return {
            name: Number(name, float(value), float(below), float(above), how=how, unit=unit)
            for name, unit, value, below, above in zip(names, units, values, low, high, strict=True)
        }

    @property
    def laws(self) -> list[Law]:
        """Laws that were compared, the best first."""
        data = self.data
        return [
            Law(
                name,
                int(data["law_unknowns"].values[k]),
                float(data["law_square"].values[k]),
                float(data["law_aicc"].values[k]),
                float(data["law_bic"].values[k]),
                float(data["law_prediction"].values[k]),
                values,
            )
            for k, (name, values) in enumerate(self.words("laws"))
        ]

    @property
    def foretold(self) -> list[Foretold]:
        """Free decays among the records left out, by every law."""
        columns = [self._values(name) for name in Foretold.COLUMNS]
        return [
            Foretold(law, record, *(float(column[k]) for column in columns))
            for k, (law, record) in enumerate(self.words("foretold"))
        ]

    @property
    def covariance(self) -> Floats:
        """Covariance of the unknowns ``(p, p)``, SI, along what the data see."""
        size = np.where(self._values("relative") > 0.0, self._values("estimate"), 1.0)
        return np.asarray(self._values("covariance") * np.outer(size, size))

    @property
    def correlation(self) -> Floats:
        """Correlation of the unknowns ``(p, p)``; directions that the data do not see count as very wide ones."""
        matrix, unseen = self._values("covariance"), self._values("unseen")
        matrix = matrix + VERY_WIDE * max(float(np.abs(matrix).max(initial=0.0)), 1.0) * unseen.T @ unseen
        size = np.sqrt(np.diag(matrix))
        size = np.where(size > 0.0, size, 1.0)
        return np.asarray(matrix / np.outer(size, size))

    @property
    def posterior(self) -> xr.DataTree:
        """Draws of the posterior as ``arviz`` takes them: the groups posterior and sample_stats, by chain and draw.

        Raises:
            InputError: none were drawn.
        """
        from viscorod.results.posterior import posterior_tree

        return posterior_tree(self)

    def distributions(self, *, nuisances: bool = False, names: Sequence[str] | None = None) -> dict[str, Any]:
        """Return what is known of the numbers of the model as distributions of SciPy, by key, as `ensemble` takes them.

        They are those of the draws where there are any, else normal or lognormal with the standard errors. Their
        correlation is that of `correlation_of_distributions`.

        Args:
            nuisances: whether numbers of the case that belong to the measurement are among them.
            names: of the unknowns that are wanted, as the report has them; by default all.

        Raises:
            InputError: the data do not tell one of them, or there is no such unknown.
        """
        from viscorod.results.posterior import distributions_of

        return distributions_of(self, nuisances=nuisances, names=names)

    def correlation_of_distributions(
        self, *, nuisances: bool = False, names: Sequence[str] | None = None
    ) -> Floats:
        """Return the correlation of the normal numbers behind `distributions`, in their order, for `ensemble`."""
        from viscorod.results.posterior import correlation_of

        return correlation_of(self, nuisances=nuisances, names=names)

    @property
    def residuals(self) -> Floats:
        """Measured less predicted (n,), SI: all values of all records, in their order."""
        return np.asarray(self._values("measured") - self._values("predicted"))

    @property
    def sentences(self) -> list[str]:
        """What the fit says, in words: what cannot be told, what is excluded."""
        return [str(text) for text in self.words("sentences")]

    @property
    def missed(self) -> list[str]:
        """Series of which the model misses part of the motion: intervals do not hold for what it leaves out."""
        return [str(text) for text in self.words("missed")]

    @property
    def unsettled(self) -> float:
        """Standard errors by which another step of the search would move the numbers; 0 where it came to rest."""
        return float(self.data.attrs.get("unsettled", 0.0))

    @property
    def doubt(self) -> str:
        """Why intervals do not hold, in a few words."""
        return "; ".join([*([UNSETTLED] if self.unsettled else []), *([MISSES] if self.missed else [])])

    @property
    def units(self) -> dict[str, str]:
        """Units of the combinations by name."""
        return dict(self.words("combinations"))

    def words(self, name: str) -> list[Any]:
        """Return a list of texts that the data set keeps as an attribute."""
        found: list[Any] = json.loads(self.data.attrs.get(name, "[]"))
        return found

    def to_toml(self, number: int = 0) -> str:
        """Return a case with the fitted numbers as the text of a case file, ready to run.

        Args:
            number: of the case, from 0, where several were fitted at once.
        """
        return str(self.words("cases")[number])

    @property
    def cases(self) -> list[Case]:
        """The cases with the fitted numbers."""
        from viscorod.casefile.case import parse_case

        return [parse_case(text) for text in self.words("cases")]

    @property
    def case(self) -> Case:
        """The case with the fitted numbers, the first one of several."""
        return self.cases[0]

    def report(self) -> str:
        """Return a report: numbers, what the data tell, residuals, laws, warnings."""
        from viscorod.results.identification_report import identification_report

        return identification_report(self)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw data and model over each other with the residuals.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the first series without its residuals.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_identification import draw_identification

        return delivered(draw_identification(self, ax), path)

    @checked
    def page(self, path: str | Path) -> Path:
        """Write a page of one file that needs no network: fit, residuals, intervals, correlation, laws.

        Returns:
            The path.
        """
        from viscorod.pictures.identification_page import write_page

        return write_page(self, Path(path))

    def _values(self, name: str) -> Floats:
        return np.asarray(self.data[name].values, dtype=float)

    def __getitem__(self, name: str) -> Any:
        """Return one of the numbers by its name."""
        return self.numbers[name]

"""What results have in common of which no states of the model are kept: curves and tables of numbers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from viscorod.alike import Alike
from viscorod.attributes import WellNamed
from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.result_warnings import stored_warnings
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.derivative import Derivative

__all__ = ["StatelessResult", "Variables"]

Variables = dict[str, tuple[tuple[str, ...], str, str]]
"""Name -> dimensions, unit and long name."""


class StatelessResult(WellNamed, Shown, Alike, ABC):
    """An ``xarray.Dataset`` whose variables are all known, ``data``."""

    kind: ClassVar[str]
    picture: ClassVar[str]
    """Name of the picture of it all."""
    what: ClassVar[str]
    """In words, as in "this data set is no ..."."""
    derivatives: Mapping[str, Derivative[Self]] = MappingProxyType({})
    """By the keys of the numbers that were asked for; see ``Derivative``."""

    def __init__(self, data: xr.Dataset) -> None:
        if not hasattr(data, "variables") or not hasattr(data, "attrs"):
            raise InputError(
                f"data: {type(data).__name__}: a {self.what} is made of an xarray.Dataset; viscorod.load reads one "
                "from a file"
            )
        known = self.variables()
        missing = [name for name in known if name not in data.variables]
        if data.attrs.get("kind") != self.kind or missing:
            raise InputError(
                f"this data set is no {self.what} of viscorod: {', '.join(missing) or 'it is of another kind'}"
            )
        for name, (dims, unit, text) in known.items():
            if data[name].dims != dims:
                raise InputError(f"this data set is no {self.what} of viscorod: {name} has other dimensions")
            data[name].attrs.update({"units": unit, "long_name": text} if unit else {"long_name": text})
            if data[name].dtype.kind == "f" and not np.isfinite(data[name].values).all():
                raise InputError(f"this data set is no {self.what} of viscorod: {name} is not finite")
        self.data = data

    @classmethod
    @abstractmethod
    def variables(cls) -> Variables:
        """Return the dimensions, units and long names of all variables; all are always there."""

    @abstractmethod
    def report(self) -> str:
        """Return a report in words and numbers."""

    def __str__(self) -> str:
        return self.report()

    def _content(self) -> xr.Dataset:
        return self.data

    def _facts(self) -> Iterator[str]:
        if self.outcome != "completed":
            yield self.outcome
        if self.warnings:
            yield counted(len(self.warnings), "warning")

    def _curves(self) -> tuple[Floats, Floats]:
        """Return what its small drawing shows: places ``(n,)`` and values over them ``(n, curves)``."""
        return np.zeros(0), np.zeros((0, 0))

    def _drawing(self) -> str:
        along, values = self._curves()
        drawing = Drawing(equal=False)
        for curve in values.T:
            drawing.line(np.stack([along, curve], axis=-1))
        return drawing.svg()

    @property
    def title(self) -> str:
        """Title of the case, empty if it has none."""
        return str(self.data.attrs.get("title", ""))

    @property
    def outcome(self) -> str:
        """How it ended: "completed", or a word for what ended it before."""
        return str(self.data.attrs.get("outcome", "completed"))

    @property
    def warnings(self) -> list[str]:
        """What the model and the result say against themselves, in sentences."""
        return stored_warnings(self.data)

    @checked
    def save(self, path: str | Path) -> Path:
        """Write it to a netCDF4 file, which ``viscorod.load`` reads; returns the path."""
        from viscorod.results.files.storage import write
        from viscorod.results.files.stored_derivatives import groups_of, with_derivatives

        return write(with_derivatives(self), path, groups_of(self.derivatives))

    def __reduce__(self) -> tuple[Callable[[xr.Dataset], Self], tuple[xr.Dataset]]:
        return type(self), (self.data,)

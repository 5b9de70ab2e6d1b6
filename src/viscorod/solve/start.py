"""The state of an earlier result from which an analysis starts."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Annotated, Any, Self

from pydantic import model_validator

from viscorod.checks import file_path
from viscorod.given_as import GivenAs
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import of_kind
from viscorod.model.fields.metadata import Accepts, Check, Key
from viscorod.model.fields.values import Flag, OptionalNumber, OptionalText

__all__ = ["OptionalStart", "Start", "as_start"]


class Start(Definition):
    """The state of an earlier result from which an analysis starts, by its file or, in Python, the result itself.

    Rods and bodies are found by their names. Another mesh gets its nodes by the interpolation of the earlier elements.
    """

    file: OptionalText = Key("of an earlier result, such as `out/run.nc`", default=None)
    time: OptionalNumber = Key(
        "of the state, {}, any that a motion covers; the last one unless given", "s", default=None
    )
    load_factor: OptionalNumber = Key(
        "of the state of an equilibrium or a path, the nearest that is stored; the last one unless given",
        default=None,
    )
    at_rest: Flag = Key("whether the velocities of the state are left out", default=False)
    result: Annotated[Any, Accepts(None, "", "a result")] = Key("instead of its file", default=None)

    @model_validator(mode="before")
    @classmethod
    def _told_by_what_it_is(cls, data: Any) -> Any:
        """Take a result, or a path, for what it is where it stands in the place of the file."""
        if isinstance(data, Mapping) and data.get("result") is None:
            given = data.get("file")
            if isinstance(given, PathLike) or _is_result(given):
                return {key: value for key, value in data.items() if key != "file"} | _source(given)
        return data

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.file is None) == (self.result is None):
            raise RefusedError(
                "a start is one earlier result",
                "give its file, such as start = { file = 'run.nc' }, or in Python the result",
                found="both" if self.file is not None else "none",
                at=("file",),
            )
        if self.time is not None and self.load_factor is not None:
            raise RefusedError(
                "a state has a time (of a motion) or a load factor (of an equilibrium)",
                "give one of them",
                found=show(self.load_factor),
                at=("load_factor",),
            )
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data; a result by what it is."""
        plain = super().to_dict()
        if self.result is not None:
            plain["result"] = f"<{type(self.result).__name__} {self.result.title}>".replace(" >", ">")
        return plain


def as_start(value: Any) -> Start | None:
    """Return what a user gives as a start: a result, a path, either with a time or load factor, or a table."""
    if value is None or isinstance(value, Start):
        return value
    if isinstance(value, Mapping):
        return Start.model_validate(value)
    if isinstance(value, tuple | list):
        if len(value) != 2:
            raise RefusedError(
                "a start is a result, or a result and its time", "give (run, 1.5), or run.at(1.5)"
            )
        along = getattr(value[0], "dimension", "time")
        key = "load_factor" if along == "load_factor" else "time"
        return Start.model_validate(_source(value[0]) | {key: value[1]})
    return Start.model_validate(_source(value))


def _is_result(value: Any) -> bool:
    return hasattr(value, "sites") and hasattr(value, "dimension")


def _source(value: Any) -> dict[str, Any]:
    if isinstance(value, str | PathLike):
        return {"file": str(file_path("file", value))}
    if not _is_result(value):
        raise RefusedError(
            "this is no result",
            "give a result, such as that of simulate, its file, or either with a time: (run, 1.5)",
        )
    return {"result": value}


OptionalStart = Annotated[
    GivenAs[Start | None, Any],
    Check(
        of_kind("start"),
        "table, see below",
        "a result, a path, or either with a time: `(run, 1.5)`",
        read=as_start,
    ),
]

"""Arguments of a model's analyses: settings, and options of a call that do not change its numbers.

Settings are spelled once, in their class. ``takes`` gives a method the parameters of such a class, with their types,
so that editors, type checkers, ``help`` and the reference show them.
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Concatenate, ParamSpec, TypeVar

from viscorod.analyses.call_options import CallOptions, Progress
from viscorod.casefile.case_keys import parts_of
from viscorod.checks import file_path, flag, require_callback, text
from viscorod.errors import Fault, InputError, let_interrupts_through
from viscorod.given_as import GivenAs, Words
from viscorod.model.fields.arguments import given
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.metadata import Check, Key
from viscorod.model.fields.signature import parameters, signature
from viscorod.one_thread import one_blas_thread
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.settings.co_simulation import CoSimulationSettings
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import LinearSettings, ResponseSettings
from viscorod.solve.settings.stability import StabilitySettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings

__all__ = [
    "CoSimulationArguments",
    "EquilibriumArguments",
    "LinearArguments",
    "ModesArguments",
    "PathArguments",
    "ResponseArguments",
    "SimulateArguments",
    "SteadyArguments",
    "takes",
]

P = ParamSpec("P")
A = TypeVar("A")
M = TypeVar("M")
R = TypeVar("R")


def _kept(name: str, words: str, kind: Callable[[str, Any], Any]) -> Check[Any]:
    """Return the check of an argument that accompanies a call; it stands in no case file."""

    def read(value: Any) -> Any:
        try:
            return kind(name, value)
        except InputError as error:
            fault = error.problems[0]
            raise RefusedError(fault.why, fault.instead, found=fault.found) from None

    return Check(None, words, read=read)


def _stop(name: str, value: Any) -> Any:
    if value is not None:
        require_callback(name, value)
    return value


def _progress(name: str, value: Any) -> Any:
    if value is not None and not isinstance(value, bool):
        require_callback(name, value, 0.0, 0.0)
    return value


def _folder(name: str, value: Any) -> Path | None:
    return None if value is None else file_path(name, value)


def _keys(name: str, value: Any) -> tuple[str, ...]:
    keys = [value] if isinstance(value, str) else list(value) if isinstance(value, list | tuple) else [value]
    for key in keys:
        if not isinstance(key, str):
            raise InputError(Fault(name, show(key), "a key is text", 'give ["loads[0].value[1]"]'))
        parts_of(key)
    return tuple(dict.fromkeys(keys))


class Titled(Definition):
    """Arguments of every analysis."""

    title: Annotated[str, _kept("title", "text", text)] = Key(
        "kept with the result", default="", kw_only=True
    )

    @property
    def options(self) -> CallOptions:
        """Those that are options of the call."""
        names = CallOptions.__dataclass_fields__.keys() & self.model_fields_set
        return CallOptions(**{name: getattr(self, name) for name in names})

    def to_dict(self) -> dict[str, Any]:
        """Return the settings alone, see ``Definition.to_dict``."""
        return {name: value for name, value in super().to_dict().items() if name not in _ACCOMPANYING}


_ACCOMPANYING = frozenset(CallOptions.__dataclass_fields__)


class Watched(Titled):
    """Arguments of analyses that can be stopped between steps or iterations."""

    stop: Annotated[Callable[[], str] | None, _kept("stop", "a function", _stop)] = Key(
        "called in every step or iteration; a reason that it returns ends the computation, which keeps what it has",
        default=None,
        kw_only=True,
    )


class Progressing(Watched):
    """Arguments of analyses that report their progress."""

    progress: Annotated[Progress | bool | None, _kept("progress", "True or a function", _progress)] = Key(
        "True shows how far it is; a function is called after every step with the time [s], load factor, displacement "
        "that ends a path [m], frequency [Hz], speed [rad/s] or amplitude that was reached, and the step; from the "
        "start again if computed again",
        default=None,
        kw_only=True,
    )


class Differentiated(Titled):
    """Arguments of analyses whose results have derivatives."""

    derivatives: Annotated[GivenAs[tuple[str, ...], Words], _kept("derivatives", "keys", _keys)] = Key(
        "keys of numbers of the model, such as `loads[0].value[1]`, by which all of the result is differentiated: "
        "`result.derivatives[key]`",
        default=(),
        kw_only=True,
    )


class EquilibriumArguments(EquilibriumSettings, Progressing, Differentiated):
    """Arguments of ``Model.equilibrium``."""


class PathArguments(PathSettings, Progressing):
    """Arguments of ``Model.path``."""


class SimulateArguments(SimulateSettings, Progressing, Differentiated):
    """Arguments of ``Model.simulate``."""

    folder: Annotated[GivenAs[Path | None, str | Path | None], _kept("folder", "a path", _folder)] = Key(
        "where the states go as they come, so that memory stays bounded and a run that is stopped can go on; "
        "``run.nc`` is there in the end. Without it everything stays in memory",
        default=None,
        kw_only=True,
    )
    resume: Annotated[bool, _kept("resume", "True or False", flag)] = Key(
        "go on with the run that was stopped in that folder; model and settings have to be the same",
        default=False,
        kw_only=True,
    )
    anew: Annotated[bool, _kept("anew", "True or False", flag)] = Key(
        "remove a run that was stopped in that folder, and begin anew; without this word it is not lost",
        default=False,
        kw_only=True,
    )
    errors: Annotated[bool, _kept("errors", "True or False", flag)] = Key(
        "False computes the motion alone: its numbers are the same, but nothing is told of the errors of steps and "
        "mesh, for which some steps are tried again, and some motions as a whole; rods need given elements then",
        default=True,
        kw_only=True,
    )


class ResponseArguments(ResponseSettings, Progressing, Differentiated):
    """Arguments of ``Model.frequency_response``."""


class ModesArguments(ModesSettings, Differentiated):
    """Arguments of ``Model.modes``."""


class LinearArguments(LinearSettings, Titled):
    """Arguments of ``Model.linear``."""


class CoSimulationArguments(CoSimulationSettings, Titled):
    """Arguments of ``Model.co_simulation``."""


class PeriodicArguments(PeriodicSettings, Progressing, Differentiated):
    """Arguments of ``Model.periodic``."""


class SteadyArguments(SteadySettings, Watched, Differentiated):
    """Arguments of ``Model.steady``."""


class CampbellArguments(CampbellSettings, Progressing):
    """Arguments of ``Model.campbell``."""


class StabilityArguments(StabilitySettings, Progressing):
    """Arguments of ``Model.stability``."""


class BucklingArguments(BucklingSettings, Progressing):
    """Arguments of ``Model.buckling``."""


def takes(arguments: Callable[P, A]) -> Callable[[Callable[[M, A], R]], Callable[Concatenate[M, P], R]]:
    """Give a method the parameters of a class of arguments, of which it gets a validated object.

    Arguments that are None count as not given.
    """
    kind: Any = arguments

    def decorate(function: Callable[[M, A], R]) -> Callable[Concatenate[M, P], R]:
        @functools.wraps(function)
        def method(self: M, /, *args: P.args, **kwargs: P.kwargs) -> R:
            try:
                call = kind(*args, **given(**kwargs))
            except InputError as error:
                prefix = f"{kind.__name__}."
                faults = [replace(fault, where=fault.where.removeprefix(prefix)) for fault in error.problems]
                raise InputError(faults) from None
            try:
                with one_blas_thread(), _shown(call) as call:
                    return function(self, call)
            except SystemError as error:
                let_interrupts_through(error)
                raise

        documented: Any = method
        documented.__signature__ = _signature(kind)
        documented.__doc__ = _documented(function.__doc__, kind)
        return method

    return decorate


@contextmanager
def _shown(call: Any) -> Iterator[Any]:
    """Yield arguments whose progress is shown, if that was asked for by True."""
    wanted = getattr(call, "progress", None)
    if not isinstance(wanted, bool):
        yield call
        return
    from viscorod.analyses.progress import reporting

    with reporting(call.course) if wanted else nullcontext() as progress:
        yield call.model_copy(update={"progress": progress})


def _signature(kind: type[Definition]) -> inspect.Signature:
    """Return the signature of a method that takes these arguments."""
    first = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    return signature([first, *parameters(kind.model_fields)])


def _documented(text: str | None, kind: type[Definition]) -> str | None:
    """Return a docstring with the arguments of a class, which names those that it inherits, before its next part."""
    if text is None:  # python -OO
        return None
    arguments = inspect.cleandoc(kind.__doc__ or "").partition("Args:\n")[2].split("\n\n")[0]
    text = inspect.cleandoc(text)
    end = re.search(r"^(Returns|Raises):", text, flags=re.MULTILINE)
    place = end.start() if end else len(text)
    return f"{text[:place].rstrip()}\n\nArgs:\n{arguments}\n\n{text[place:]}"

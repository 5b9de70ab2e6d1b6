"""Every public function, class and method, called without what it needs: one clear message, wherever it is defined."""

import functools
import inspect

import pytest

import viscorod as vr
from viscorod.argument_names import telling


def reached():
    """Yield the name, and what can be called, of all public functions, classes and methods of classes."""
    for owner in (vr, vr.programs):
        for name in dir(owner):
            found = getattr(owner, name)
            if inspect.isroutine(found):
                yield name, found
            elif inspect.isclass(found) and not issubclass(found, BaseException):
                yield name, found
                yield from methods(name, found)


def methods(name, kind):
    """Yield those of a class that this package defines; what a method does is never reached."""
    for word in dir(kind):
        raw = inspect.getattr_static(kind, word)
        plain = getattr(raw, "__func__", raw)
        if (
            word.startswith("_")
            or isinstance(raw, staticmethod)  # formulas of section laws, which compiled code calls
            or not inspect.isfunction(plain)
            or plain.__module__.partition(".")[0] != "viscorod"
        ):
            continue
        if plain is raw:
            yield f"{name}.{word}", functools.partial(plain, object())
        else:
            yield f"{name}.{word}", getattr(kind, word)


def needed(function):
    """Return the names of arguments without which a function cannot be called."""
    parameters = inspect.signature(function).parameters.values()
    free = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return [one.name for one in parameters if one.default is one.empty and one.kind not in free]


CALLS = {name: function for name, function in reached() if needed(function)}


def test_all_kinds_are_found():
    """Functions, classes of every kind and their methods are among what is called."""
    assert {
        "sweep",
        "decay",
        "Run",
        "Energy",
        "Number",
        "Rod.straight",
        "Model.add",
        "Record.decimated",
    } <= set(CALLS)
    assert {"viscosity", "BeamDyn", "BeamDyn.from_section", "CoSimulation.restore", "Constant.value"} <= set(
        CALLS
    )


@pytest.mark.parametrize("name", CALLS)
def test_missing_arguments_are_named(name):
    first = needed(CALLS[name])[0]
    with pytest.raises(
        vr.InputError, match=rf"\b{first}: this (key|argument) is required and missing"
    ) as caught:
        CALLS[name]()
    assert caught.value.__cause__ is None
    assert caught.value.__context__ is None or caught.value.__suppress_context__


def test_errors_within_a_function_stay_what_they_are():
    """A TypeError that a call raises inside, with the right arguments, is not taken for a wrong call."""
    within = telling(lambda number: len(number) + 1)
    with pytest.raises(TypeError, match="has no len"):
        within(5)
    with pytest.raises(TypeError, match="missing 1 required positional argument"):
        telling(lambda function: function())(lambda number: number)

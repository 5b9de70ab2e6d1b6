"""Geometrically exact rods with Kelvin-Voigt damping.

Public names are listed once, in ``__init__.pyi``; each is imported when it is first used, so that ``import viscorod``
takes no time.
"""

from __future__ import annotations

import importlib

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        globals()[name] = version("viscorod")
        return globals()[name]
    if name == "damping":
        return importlib.import_module("viscorod.damping")
    return _load(name)

"""Geometrically exact rods in large motion, with damping from their material.

Public names are listed once, in ``__init__.pyi``; each is imported when it is first used, so that ``import viscorod``
takes no time.
"""

from __future__ import annotations

import importlib
import warnings

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

RENAMED = {
    "BodyVelocity": "VelocitySupport",
    "Curve": "ParametricCurve",
    "Function": "FunctionOfTime",
    "Member": "SweepRun",
    "ModalDamping": "MeasuredDamping",
    "Outline": "PolygonSection",
    "Points": "ThroughPoints",
    "Region": "CompositeRegion",
    "Relaxation": "RelaxationModulus",
    "Section": "SectionProperties",
    "System": "CoSimulation",
    "Table": "TimeTable",
}
"""Public names of version 0.1 and what they are called now."""


def __getattr__(name: str) -> object:
    if name in RENAMED:
        text = f"viscorod.{name} is now viscorod.{RENAMED[name]}"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return _load(RENAMED[name])
    if name == "__version__":
        from importlib.metadata import version

        globals()[name] = version("viscorod")
        return globals()[name]
    if name == "damping":
        return importlib.import_module("viscorod.damping")
    if name in __all__:
        return _load(name)
    if name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from viscorod.attributes import UnknownAttributeError

    raise UnknownAttributeError.of(None, name, lambda: [*__all__, "damping"], called=__name__)

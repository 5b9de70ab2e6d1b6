"""Geometrically exact rods with Kelvin-Voigt damping.

Public names are imported when they are first used, so that ``import viscorod`` takes no time.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from viscorod.errors import InputError, SolveError

if TYPE_CHECKING:
    from viscorod.cases.case import load_case
    from viscorod.front import Model
    from viscorod.material_fit import kelvin_voigt_fit
    from viscorod.model.axis_joint import Cylindrical, Planar, Prismatic, Revolute
    from viscorod.model.body import Body
    from viscorod.model.body_shapes import Box, Cylinder, Sphere
    from viscorod.model.body_velocity import BodyVelocity
    from viscorod.model.complex_moduli import ComplexModuli, ModulusTable
    from viscorod.model.composite import Composite, Region
    from viscorod.model.event import Crossing, Decayed, SteadyState
    from viscorod.model.initial_strain import InitialStrain
    from viscorod.model.joint import Ball, Joint, Rigid, Universal
    from viscorod.model.line_shapes import Arc, Helix, Straight
    from viscorod.model.load import DistributedForce, DistributedMoment, Force, Gravity, Moment, MovingForce
    from viscorod.model.loss_factor import LossFactor
    from viscorod.model.material import KelvinVoigt, Material
    from viscorod.model.modal import ModalDamping
    from viscorod.model.outline import Outline
    from viscorod.model.parametric_lines import Curve, Points
    from viscorod.model.profile import Piecewise, Taper
    from viscorod.model.prony import Prony
    from viscorod.model.relaxation import Relaxation
    from viscorod.model.rod import Rod
    from viscorod.model.section import Section
    from viscorod.model.shapes import Annulus, Circle, Ellipse, Rectangle, SquareTube
    from viscorod.model.spring import LineSpring, Spring
    from viscorod.model.stiffness_section import MaxwellBranch, StiffnessSection
    from viscorod.model.support import Clamp, Guide, Pin, Roller, Support
    from viscorod.model.time_function import Constant, Ramp, Sine, SpinUp, Until
    from viscorod.model.time_table import Function, Table
    from viscorod.model.velocity import InitialVelocity
    from viscorod.results.decrement import Decrement
    from viscorod.results.energy import Energy
    from viscorod.results.kelvin_voigt_fit import KelvinVoigtFit
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady import Steady
    from viscorod.results.storage import load
    from viscorod.results.sweep import Member, Sweep
    from viscorod.stepping import System
    from viscorod.sweeps import sweep
    from viscorod.viewer import view

    __version__: str

# Where each name lives; the imports above tell type checkers the same.
_HOMES = {
    "cases.case": ("load_case",),
    "front": ("Model",),
    "model.line_shapes": ("Arc", "Helix", "Straight"),
    "model.parametric_lines": ("Curve", "Points"),
    "model.body": ("Body",),
    "model.body_shapes": ("Box", "Cylinder", "Sphere"),
    "model.event": ("Crossing", "Decayed", "SteadyState"),
    "model.joint": ("Ball", "Joint", "Rigid", "Universal"),
    "model.axis_joint": ("Cylindrical", "Planar", "Prismatic", "Revolute"),
    "model.spring": ("LineSpring", "Spring"),
    "model.load": ("DistributedForce", "DistributedMoment", "Force", "Gravity", "Moment", "MovingForce"),
    "model.material": ("KelvinVoigt", "Material"),
    "model.modal": ("ModalDamping",),
    "material_fit": ("kelvin_voigt_fit",),
    "results.kelvin_voigt_fit": ("KelvinVoigtFit",),
    "model.composite": ("Composite", "Region"),
    "model.outline": ("Outline",),
    "model.prony": ("Prony",),
    "model.relaxation": ("Relaxation",),
    "model.complex_moduli": ("ComplexModuli", "ModulusTable"),
    "model.loss_factor": ("LossFactor",),
    "model.profile": ("Piecewise", "Taper"),
    "model.rod": ("Rod",),
    "model.section": ("Section",),
    "model.shapes": ("Annulus", "Circle", "Ellipse", "Rectangle", "SquareTube"),
    "model.stiffness_section": ("MaxwellBranch", "StiffnessSection"),
    "model.body_velocity": ("BodyVelocity",),
    "model.support": ("Clamp", "Guide", "Pin", "Roller", "Support"),
    "model.time_function": ("Constant", "Ramp", "Sine", "SpinUp", "Until"),
    "model.time_table": ("Function", "Table"),
    "model.velocity": ("InitialVelocity",),
    "model.initial_strain": ("InitialStrain",),
    "results.decrement": ("Decrement",),
    "results.energy": ("Energy",),
    "results.run": ("Equilibrium", "Run"),
    "results.steady": ("Steady",),
    "results.storage": ("load",),
    "results.sweep": ("Member", "Sweep"),
    "stepping": ("System",),
    "sweeps": ("sweep",),
    "viewer": ("view",),
}
_MODULES = {name: f"viscorod.{module}" for module, names in _HOMES.items() for name in names}

__all__ = [
    "Annulus",
    "Arc",
    "Ball",
    "Body",
    "BodyVelocity",
    "Box",
    "Circle",
    "Clamp",
    "ComplexModuli",
    "Composite",
    "Constant",
    "Crossing",
    "Curve",
    "Cylinder",
    "Cylindrical",
    "Decayed",
    "Decrement",
    "DistributedForce",
    "DistributedMoment",
    "Ellipse",
    "Energy",
    "Equilibrium",
    "Force",
    "Function",
    "Gravity",
    "Guide",
    "Helix",
    "InitialStrain",
    "InitialVelocity",
    "InputError",
    "Joint",
    "KelvinVoigt",
    "KelvinVoigtFit",
    "LineSpring",
    "LossFactor",
    "Material",
    "MaxwellBranch",
    "Member",
    "ModalDamping",
    "Model",
    "ModulusTable",
    "Moment",
    "MovingForce",
    "Outline",
    "Piecewise",
    "Pin",
    "Planar",
    "Points",
    "Prismatic",
    "Prony",
    "Ramp",
    "Rectangle",
    "Region",
    "Relaxation",
    "Revolute",
    "Rigid",
    "Rod",
    "Roller",
    "Run",
    "Section",
    "Sine",
    "SolveError",
    "Sphere",
    "SpinUp",
    "Spring",
    "SquareTube",
    "Steady",
    "SteadyState",
    "StiffnessSection",
    "Straight",
    "Support",
    "Sweep",
    "System",
    "Table",
    "Taper",
    "Universal",
    "Until",
    "kelvin_voigt_fit",
    "load",
    "load_case",
    "sweep",
    "view",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        globals()[name] = version("viscorod")
        return globals()[name]
    if name == "damping":  # a package of its own: viscorod.damping.BeamDyn
        return importlib.import_module("viscorod.damping")
    if name in _MODULES:
        value = getattr(importlib.import_module(_MODULES[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})

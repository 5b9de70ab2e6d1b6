"""Doubts whether a model is one of rods, and whether its damping is right, before it is solved."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.model.rod_checks import reaching_centre
from viscorod.results.damping_validity import QUICK
from viscorod.results.validity import SLENDER, SMALL_STRAIN, Condition, Validity, unknown_width
from viscorod.typing import Floats

__all__ = ["band_warnings", "known_validity", "shape_warnings", "speed_warnings"]


class _Shape(NamedTuple):
    """Half width [m] of a rod at its start times reference curvature and twist, and over its length."""

    curvature: float
    twist: float
    slenderness: float


def _shape(rod: Rod) -> _Shape | None:
    """Return how slender the reference shape of a rod is (LLT 2.2); None where its half width is not known."""
    half = rod.section_at(0.0).half_width
    if half is None:
        return None
    s = np.linspace(0.0, rod.length, 201)
    curvature = float(np.linalg.norm(rod.centreline.curvature(s), axis=1).max())
    twist = float(np.abs(np.gradient(rod.centreline.twisted(s, rod.turn), s)).max())
    return _Shape(half * curvature, half * twist, half / rod.length)


def shape_warnings(name: str, rod: Rod) -> list[str]:
    """Judge the slenderness of the reference shape: half width times curvature (LLT 2.2)."""
    warnings = []
    shape = _shape(rod)
    if shape is not None:
        for what, size in (("curvature", shape.curvature), ("twist", shape.twist)):
            if size > SLENDER and not (
                what == "curvature" and reaching_centre(rod) is not None
            ):  # told by itself
                warnings.append(
                    f"rod {name}: half width times {what} of the reference shape is {size:.2g}; "
                    "a rod model is meant for values much smaller than 1"
                )
        if SLENDER < shape.slenderness <= 1.0:  # what is thicker than long is told by itself
            warnings.append(
                f"rod {name}: its half width is {shape.slenderness:.2g} of its length; "
                "a rod model is meant for slender bodies"
            )
    warnings.extend(f"rod {name}: {remark}" for remark in rod.section_at(0.0).remarks())
    return warnings


def known_validity(model: ModelDescription, frequencies: Floats) -> Validity:
    """Return the conditions of a rod model that are known before a solution, with the names that results give them."""
    if not model.rods:
        return Validity(())
    known = {name: shape for name, rod in model.rods.items() if (shape := _shape(rod)) is not None}
    names = ("|J0 - 1|: half width x curvature", "half width x reference twist")
    conditions = []
    for k, name in enumerate((*names, "half width / length")):
        if known:
            worst = max(known, key=lambda rod: known[rod][k])
            conditions.append(Condition(name, "LLT 2.2", known[worst][k], SLENDER, worst))
        else:
            conditions.append(unknown_width(name, "LLT 2.2", SLENDER))
    for name in ("shear and stretch", "half width x bending, twist"):
        conditions.append(Condition(name, "LLT 2.2", math.nan, SMALL_STRAIN, "known of a solution"))
    times = {name: _longest_time(rod) for name, rod in model.rods.items()}
    slowest = max(times, key=lambda rod: times[rod], default="")
    if slowest and times[slowest] > 0.0:
        omega = 2 * np.pi * float(frequencies[0]) if len(frequencies) else math.nan
        where = f"{slowest}, first mode" if len(frequencies) else "no mode is known"
        name = "angular frequency x time"
        conditions.append(Condition(name, "LLT 2.6", omega * times[slowest], QUICK, where))
    return Validity(tuple(conditions))


def _longest_time(rod: Rod) -> float:
    """Return the longest Kelvin-Voigt retardation time of a rod at its start [s]."""
    C, D, _ = rod.matrices_at(0.0)
    free = ~np.array(rod.constrained_strains)
    return float(np.max((np.diag(D) / np.diag(C))[free], initial=0.0))


def speed_warnings(model: ModelDescription, frequencies: Floats) -> list[str]:
    """Compare retardation times with the slowest motion (LLT 2.6)."""
    if not len(frequencies):
        return []
    omega = 2 * np.pi * float(frequencies[0])
    warnings = []
    for name, rod in model.rods.items():
        time = _longest_time(rod)
        if omega * time > QUICK:
            warnings.append(
                f"rod {name}: first angular frequency times longest retardation time is {omega * time:.2g}; "
                "Kelvin-Voigt damping is meant for motions much slower than the material's relaxation"
            )
    return warnings


def band_warnings(model: ModelDescription, frequencies: Floats) -> list[str]:
    """Compare the bands of loss factors with the frequencies [Hz] of the first motions."""
    warnings = []
    for name, rod in model.rods.items():
        band = None if rod.material is None else rod.material.loss_band
        if band is None or rod.material is None:
            continue
        outside = frequencies[(frequencies < band[0]) | (frequencies > band[1])]
        modulus = rod.material.relaxation("extension")
        if outside.size and modulus is not None:
            found = modulus.complex_modulus(2.0 * np.pi * outside)
            where, losses = (
                ", ".join(f"{value:.3g}" for value in values) for values in (outside, found.imag / found.real)
            )
            warnings.append(
                f"rod {name}: its loss factor holds from {band[0]:.4g} to {band[1]:.4g} Hz, and of the first "
                f"frequencies of the model {where} Hz {'are' if outside.size > 1 else 'is'} outside: there it is "
                f"{losses} in extension"
            )
    return warnings

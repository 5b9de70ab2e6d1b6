"""Sections and models shared by the reference tests."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr


def stiff(ga, ea, ei, gj, mass=1.0, rotary=(1e-3, 1e-3, 2e-3), damping=None):
    """A section without couplings; rotary inertia about (d1, d2, d3)."""
    stiffness = [ga, ga, ea, ei, ei, gj]
    given = {} if damping is None else {"damping": list(damping * np.array(stiffness))}
    return vr.StiffnessSection(stiffness, [mass, mass, mass, *rotary], **given)


def cantilever(section, length=1.0, elements=None, order=None, material=None):
    """A rod along x, clamped at the origin; transverse directions y (d1) and z (d2)."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (length, 0, 0), section=section, material=material, elements=elements, order=order
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    return model


def slope(sizes, errors):
    """Order of convergence: slope of log error over log size."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


# what every integrator and formulation is asked for: radau follows a tolerance, the others have equal steps
def methods(tolerance, time_step, *, midpoint=None, spectral_radius=None, without=None):
    """All integrators, and both formulations, as parameters of a test: keyword arguments of ``simulate``.

    Only with radau are errors estimated, for which a motion may be computed again: those of the others have tests of
    their own.

    Args:
        tolerance: of radau; time_step: of the integrators of second order, s.
        midpoint: time step of the midpoint rule where it needs another one.
        spectral_radius: of generalised-alpha.
        without: why an integrator (or "intrinsic") does not apply, by name.
    """
    damping = {} if spectral_radius is None else {"spectral_radius": spectral_radius}
    table = {
        "radau": {"tolerance": tolerance},
        "generalized_alpha": {"time_step": time_step, "errors": False, **damping},
        "midpoint": {"time_step": midpoint or time_step, "errors": False},
        "intrinsic": {
            "integrator": "radau",
            "tolerance": tolerance,
            "formulation": "intrinsic",
            "errors": False,
        },
    }
    left = {name: given for name, given in table.items() if name not in (without or {})}
    return pytest.mark.parametrize(
        "method", [pytest.param({"integrator": name, **given}, id=name) for name, given in left.items()]
    )

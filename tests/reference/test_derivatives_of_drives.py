"""Derivatives of motions that are driven: motors of ball joints and hinges, supports that move and leave places free.

Beside Richardson-extrapolated differences of whole runs with equal steps. By the midpoint rule velocities are compared
to 1e-6 as well: they are corrected with the matrix of a step before they are recorded.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.derivatives.case_numbers import CaseNumber, with_values

E = "materials.rubber.youngs_modulus"


def beam():
    """A rubber bar under gravity."""
    model = vr.Model()
    rubber = vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model.materials["rubber"] = rubber
    given = {"section": vr.Rectangle(0.02, 0.01), "material": rubber, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), elements=2, **given))
    model.gravity((0, 0, -9.81))
    return model


def armed():
    """It is clamped; an arm is to be joined to its end."""
    model = beam()
    model.clamp("beam.start")
    given = {"section": vr.Rectangle(0.02, 0.01), "material": model.materials["rubber"], "order": 3}
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.4, 0, 0), elements=1, **given))
    return model


def ball():
    """A ball joint with motors about all axes."""
    model = armed()
    motors = {"rx": vr.Sine(4.0, 0.3), "ry": vr.Sine(5.0, 0.4), "rz": vr.Sine(3.0, 0.2)}
    model.ball("beam.end", "arm.start", motion=motors)
    return model


def hinge():
    """A hinge with a motor."""
    model = armed()
    model.revolute("beam.end", "arm.start", axis=(0, 1, 0), motion={"rz": vr.Sine(4.0, 0.3)})
    return model


def lifted():
    """It turns freely about an axis that is moved up and down, on a spring with a damper at its other end."""
    model = beam()
    model.support("beam.start", fixed=("ux", "uy", "rx", "rz"), motion={"uz": vr.Sine(8.0, 0.01)})
    springs = {"ux": 1.0, "uy": 1.0, "uz": 2.0}
    model.spring("beam.end", "ground", stiffness=springs, damping={"uz": 0.05})
    return model


@pytest.mark.filterwarnings("ignore::viscorod.errors.AccuracyWarning")  # steps are few: any have derivatives
@pytest.mark.parametrize(
    ("make", "key", "integrator"),
    [
        (ball, "joints[0].motion.ry.amplitude", "generalized_alpha"),
        (ball, E, "midpoint"),
        (hinge, E, "midpoint"),
        (lifted, "supports[0].motion.uz.amplitude", "generalized_alpha"),
        (lifted, E, "midpoint"),
    ],
)
def test_driven_motions_change_as_differences_say(make, key, integrator):
    """Neighbours of the midpoint rule shared a matrix, and velocities were 1e-2 of the derivative off with motors."""
    model, given = make(), {"integrator": integrator, "time_step": 2e-3, "output_interval": 4e-3}
    fields = ("position", "velocity", "section_force")
    found = model.simulate(0.024, **given, derivatives=[key]).derivatives[key]
    number = CaseNumber.of(model, key)

    def stored(value):
        run = with_values(model, {key: value}).simulate(0.024, **given)
        return [run.data[name].values for name in fields]

    def central(step):
        above, below = stored(number.value + step), stored(number.value - step)
        return [(a - b) / (2.0 * step) for a, b in zip(above, below, strict=True)]

    coarse, fine = central(4e-3 * number.size), central(2e-3 * number.size)
    for name, one, two in zip(fields, coarse, fine, strict=True):
        wanted = (4.0 * two - one) / 3.0
        largest = np.abs(wanted).max()
        assert largest * number.size > 1e-6
        np.testing.assert_allclose(found.data[name], wanted, rtol=0.0, atol=1e-6 * largest, err_msg=name)

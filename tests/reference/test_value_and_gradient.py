"""A function of numbers of a model, as optimisers call it."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

E, WIDTH, FORCE = "materials.rubber.youngs_modulus", "rods.beam.section.width", "loads[0].value[1]"


def cantilever():
    model = vr.Model()
    model.materials["rubber"] = rubber = vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0)
    section = vr.Rectangle(0.02, 0.01)
    model.add(
        "beam",
        vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=rubber, elements=1, order=3),
    )
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.01, -0.02))
    return model


def tip(found):
    return found.position("beam.end")


def test_numbers_of_different_sizes_are_minimised_as_parts_of_them():
    """Closed form: of the modulus alone a deflection is a function of F/E, so that the force's half is twice E."""
    from scipy.optimize import minimize

    model = cantilever()
    wanted = tip(model.equilibrium())
    keys = [E, FORCE]
    f = model.value_and_gradient(keys, lambda found: float(((tip(found) - wanted) ** 2).sum()), "equilibrium")
    np.testing.assert_allclose(f.sizes, [2.5e6, 0.02])
    _, gradient = f(1.1 * f.values)
    _, by_parts = f.relative(1.1 * f.values / f.sizes)
    np.testing.assert_allclose(by_parts, gradient * f.sizes, rtol=1e-12)
    found = minimize(f.relative, [1.3, 0.4], jac=True, options={"gtol": 1e-10})
    np.testing.assert_allclose(found.x, f.values / f.sizes, rtol=1e-4)


def test_what_was_asked_last_is_remembered():
    """A least-squares method asks for value and Jacobian one after the other; what it does with them is its own."""
    model, calls = cantilever(), []
    f = model.value_and_gradient([WIDTH], lambda found: calls.append(1) or tip(found), "equilibrium")
    value, jacobian = f(f.values)
    once = len(calls)
    value[:], jacobian[:] = 0.0, 0.0
    again, its = f(f.values)
    assert len(calls) == once
    assert np.abs(again).max() > 0.1
    assert np.abs(its).max() > 0.1
    f(1.1 * f.values)
    assert len(calls) > once


@pytest.mark.parametrize("keys", [E, [], [E, WIDTH, E]])
def test_keys_are_a_list(keys):
    with pytest.raises(vr.InputError, match="each once"):
        cantilever().value_and_gradient(keys, tip, "equilibrium")


@pytest.mark.parametrize("values", ["x", [[1.0], [2.0, 3.0]], [1.0, 2.0]])
def test_values_are_numbers(values):
    f = cantilever().value_and_gradient([E], tip, "equilibrium")
    with pytest.raises(vr.InputError, match="needed, one for each key"):
        f(values)


def test_what_a_function_returns_is_a_number():
    f = cantilever().value_and_gradient([E], lambda found: found, "equilibrium")
    with pytest.raises(vr.InputError, match="returns a number, or an array of numbers"):
        f(f.values)

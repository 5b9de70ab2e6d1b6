"""Loads that grow on a model whose springs push it out of its reference shape before there are any."""

import numpy as np
import pytest
from scipy.optimize import brentq

import viscorod as vr

TIP = "column.end"


def guyed(force, tension=1.0):
    """A cantilever of length and EI 1 with a mass on its end, which a taut line pulls to a side."""
    model = vr.Model()
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1.0, 2.0, 1.0], [1e-2, 1e-2, 1e-2, 1e-6, 1e-6, 2e-6])
    model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3))
    model.clamp("column.start")
    model.add("tip", vr.Body(1.0, (0.1, 0.1, 0.1), centre=(1, 0, 0)))
    model.attach("tip", TIP)
    model.line_spring(TIP, (1.1, 0.5, 0.1), stiffness=tension, damping=0.3, length=0.2)
    if force is not None:
        model.force(TIP, force)
    return model


def test_a_path_begins_where_the_springs_hold_it():
    """Independent algorithm: load steps to the same factors; at 0 it is the equilibrium without the load."""
    found = guyed((0, 0.5, 0.2)).path(1.0, load_factors=(0.5,))
    for factor in (0.5, 1.0):
        steps = guyed((0, 0.5, 0.2)).equilibrium(load_factor=factor).position(TIP)
        at = int(np.argmin(np.abs(found.load_factor - factor)))
        assert found.history(TIP).values[at] == pytest.approx(steps, abs=1e-8)
    assert found.load_factor[0] == 0.0
    without = guyed(None).equilibrium().position(TIP)
    assert found.history(TIP).values[0] == pytest.approx(without, abs=1e-8)
    assert without[1] > 0.03


def test_stability_begins_where_the_springs_hold_it():
    """Independent analysis: the modes of the model without the load, and with it."""
    found = guyed((0, 0.5, 0.2)).stability(band=(0.0, 1.0), count=2, modes=3)
    for k, force in enumerate((None, (0, 0.5, 0.2))):
        roots = guyed(force).modes(3).eigenvalues
        order = np.argsort(roots.imag)
        assert 2.0 * np.pi * found.frequencies[k] == pytest.approx(roots.imag[order], rel=1e-6)
        ratios = -roots.real / np.abs(roots)
        assert found.damping_ratios[k] == pytest.approx(ratios[order], rel=1e-5, abs=1e-9)


def test_a_column_between_taut_lines_buckles_under_less():
    """Closed form: lines to its foot press the column as a load through its foot, which carries EI pi^2/L^2 alone.

    Under that load T and a dead load P the column is v = A sin kx + B (cos kx - 1) + C x with k^2 = (P + T) L^2/EI, and
    the moment at the tip and the force across it vanish: T sin k + P k cos k = 0.
    """
    tension = 2.0

    def column():
        model = vr.Model()
        section = vr.StiffnessSection([1e7, 1e7, 1e7, 1.0, 2.0, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
        model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=5))
        model.clamp("column.start")
        model.line_spring(TIP, (0, 0, 0), stiffness=lambda e: tension)
        model.force(TIP, (-1.0, 0, 0))
        return model

    def missing(load):
        k = np.sqrt(load + tension)
        return tension * np.sin(k) + load * k * np.cos(k)

    exact = brentq(missing, 0.5, 4.0, xtol=1e-13)
    found = column().buckling(1)
    assert found.load_factors[0] == pytest.approx(exact, rel=1e-5)

"""Stability under following forces and moments about fixed axes, where the tangent stiffness is not symmetric."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

INERTIA = [1, 1, 1, 1e-7, 1e-7, 2e-7]


def beck(load, damping=None):
    """A column of EI = 1 and length 1 under a following force at its free end."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 5.0, 1.0], INERTIA, damping=damping)
    model = vr.Model()
    model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4))
    model.clamp("column.start")
    model.force("column.end", (0, 0, -load), following=True)
    return model


def shaft(moment, bending=1.0):
    """A shaft of length 1 on two bearings that let it tilt, between two opposite couples about its axis in space."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, bending, bending, 1.0], INERTIA)
    model = vr.Model()
    model.add("shaft", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4))
    model.support("shaft.start", ("ux", "uy", "uz", "rx"))
    model.support("shaft.end", ("uy", "uz"))
    model.moment("shaft.start", (-moment, 0, 0))
    model.moment("shaft.end", (moment, 0, 0))
    return model


@pytest.mark.parametrize(
    ("load", "stable"), [(9.0, True), (15.0, True), (19.0, True), (20.0, True), (20.1, False)]
)
def test_beck_column(load, stable):
    """Beck 1952: stable up to 20.05 EI/L^2, although the symmetric part of the stiffness is not beyond pi^2."""
    found = beck(load).equilibrium()
    assert found.stable is stable
    assert found.stability == "small motions"
    assert int(found.data.attrs["flutter"]) == (0 if stable else 2)
    text = found.report()
    assert "unsymmetric" in text
    assert ("Stable: no small motion grows" in text) is stable


def test_path_of_beck_column():
    """No other equilibrium exists, so there is no bifurcation; flutter begins at 20.05."""
    path = beck(10.0).path(load_factor=2.3)
    assert path.bifurcations.size == path.limit_points.size == 0
    assert 10.0 * path.flutter_points == pytest.approx([20.0509], abs=2e-3)
    assert path.negative_eigenvalues == 2
    assert "flutter at" in flat(path.report())


def test_a_little_damping_lowers_the_flutter_load():
    """Ziegler 1952, Bolotin 1963: with vanishing internal damping the column flutters from 10.94 on (Beck: 20.05)."""
    damping = [1e2, 1e2, 1e2, 1e-4, 5e-4, 1e-4]
    assert beck(10.7, damping).equilibrium().stable
    assert not beck(11.2, damping).equilibrium().stable


def test_greenhill_shaft():
    """Greenhill 1883: 2 pi EI/L, in both directions at once; the symmetric part of the stiffness says 4.91."""
    path = shaft(2.0 * np.pi).path(load_factor=1.2, arc_length=0.5)
    assert path.bifurcations == pytest.approx([1.0], abs=1e-5)
    assert path.multiplicity.tolist() == [2]
    assert path.flutter_points.size == 0
    assert path.negative_eigenvalues == 2
    assert "2-fold bifurcation at 1" in flat(path.report())
    assert shaft(6.2).equilibrium().stable
    assert not shaft(6.4).equilibrium().stable

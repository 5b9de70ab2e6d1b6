"""Thin sections whose fibres are stretched as they twist (Buckley 1914): against fibres and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

STEEL = vr.Material(2e11, 0.3, 7850.0)
WIDTH, THICKNESS, LENGTH = 0.05, 0.0005, 1.0
STRIP = vr.Rectangle(WIDTH, THICKNESS)
C, _, M = STRIP.matrices(STEEL)
EA, P, GJ = C[2, 2], C[3, 3] + C[4, 4], C[5, 5]
Q = 1.8 * P**2 / EA


def ribbon(tension: float, *, law: vr.TrapezeEffect | None) -> vr.Model:
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=STRIP, material=STEEL, law=law)
    model.add("ribbon", rod)
    model.clamp("ribbon.start")
    model.force("ribbon.end", (tension, 0, 0))
    return model


def test_the_law_is_what_its_fibres_do() -> None:
    """A fibre at (x, y) is stretched by e + r^2 tau^2/2 and carries E times that; a sum over fibres is independent."""
    stretch, twist = 3e-4, 1.3
    x, weight = np.polynomial.legendre.leggauss(8)
    X, Y = np.meshgrid(0.5 * WIDTH * x, 0.5 * THICKNESS * x, indexing="ij")
    area = np.outer(weight, weight) * WIDTH * THICKNESS / 4.0
    square = X**2 + Y**2
    fibre = stretch + 0.5 * square * twist**2
    law = vr.TrapezeEffect()
    force, by_strain, by_rate = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6))
    strain = np.array([0, 0, stretch, 0, 0, twist])
    energy, lost = law.respond(law.parameters(C), strain, np.zeros(6), force, by_strain, by_rate)
    E = STEEL.youngs_modulus
    assert EA * stretch + force[2] == pytest.approx(E * (area * fibre).sum(), rel=1e-12)
    assert force[5] == pytest.approx(
        E * (area * fibre * square * twist).sum(), rel=1e-3
    )  # thickness in <r^4>
    assert 0.5 * EA * stretch**2 + energy == pytest.approx(0.5 * E * (area * fibre**2).sum(), rel=1e-3)
    assert lost == 0.0
    for k in (2, 5):
        for way in (1e-6, -1e-6):
            moved, near = strain.copy(), np.zeros(6)
            moved[k] += way
            law.respond(law.parameters(C), moved, np.zeros(6), near, by_rate.copy(), by_rate.copy())
            assert near - force == pytest.approx(way * by_strain[:, k], rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("tension", [0.0, 2000.0])
def test_a_ribbon_is_twisted_and_becomes_shorter(tension: float) -> None:
    """Closed form: ``T = (GJ + N P/EA) tau + (Q - P^2/EA) tau^3/2``, and the stretch ``(N - P tau^2/2)/EA``."""
    twist = 0.8
    torque = (GJ + tension * P / EA) * twist + 0.5 * (Q - P**2 / EA) * twist**3
    model = ribbon(tension, law=vr.TrapezeEffect())
    model.moment("ribbon.end", (torque, 0, 0))
    found = model.equilibrium()
    stretch = (tension - 0.5 * P * twist**2) / EA
    assert found.rotation("ribbon.end")[0] == pytest.approx(twist * LENGTH, rel=1e-6)
    assert found.displacement("ribbon.end")[0] == pytest.approx(stretch * LENGTH, rel=1e-6)
    assert not found.warnings
    plain = ribbon(tension, law=None)
    plain.moment("ribbon.end", (torque, 0, 0))
    assert "TrapezeEffect" in " ".join(plain.equilibrium().warnings)


def test_a_ribbon_under_tension_turns_faster() -> None:
    """Closed form: clamped and free, ``w = pi/2L sqrt((GJ + N P/EA)/J3)``; modes without the law say what they lack."""
    tension = 2000.0
    slow = np.sqrt(GJ / M[5, 5]) / (4.0 * LENGTH)
    for law, stiffer in ((None, 1.0), (vr.TrapezeEffect(), 1.0 + tension * P / (EA * GJ))):
        found = ribbon(tension, law=law).modes(8)
        twisting = found.frequencies[found.names.index("twist 1")]
        assert twisting == pytest.approx(slow * np.sqrt(stiffer), rel=1e-4)
        told = " ".join(found.warnings)
        assert ("TrapezeEffect" in told) is (law is None)
        if law is None:
            lacking = 100.0 * tension * P / (EA * GJ)
            assert f"by about {lacking:.2g} % of GJ" in told

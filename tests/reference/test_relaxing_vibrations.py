"""Motions of rods that have crept far: vibrations about there see the stiffness at their own frequency."""

from __future__ import annotations

import numpy as np

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import linearise, natural_frequencies
from viscorod.solve.refinement.start_modes import StartModes


def creeping():
    """A material that is a hundred times stiffer at once than after long."""
    law = vr.Prony(
        shear_ratios=[0.19, 0.2, 0.2, 0.2, 0.2],
        shear_times=[1e-4, 1e-2, 1.0, 30.0, 1e3],
        constant="poissons_ratio",
        moduli="instantaneous",
    )
    return vr.Material(2e9, poissons_ratio=0.4, density=1200.0, damping=law)


def strip(material):
    """A strip, clamped."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.15, 0, 0), section=vr.Rectangle(0.02, 0.002), material=material, elements=1, order=4
    )
    model.add("strip", rod)
    model.clamp("strip.start")
    return model


def test_vibrations_are_as_stiff_as_the_material_at_their_frequency():
    """Closed form: where all moduli relax alike, ``w^2/W^2`` is ``E'(w)/E``, and the decay ``W^2 E''(w)/(2 w E)``.

    ``W`` is the frequency of the same rod without branches, with any modulus ``E``.
    """
    material = creeping()
    discrete = DiscreteModel.of(strip(material))
    modes = StartModes.about(discrete.static, State.reference(discrete.problem), 0.0)
    elastic = DiscreteModel.of(strip(vr.Material(2e9, poissons_ratio=0.4, density=1200.0)))
    bare = linearise(elastic.static, State.reference(elastic.problem), scale=0.0)
    W, w = natural_frequencies(bare, 6), modes.omega[:6]
    modulus = material.relaxation("extension").complex_modulus(w) / 2e9
    np.testing.assert_allclose((w / W) ** 2, modulus.real, rtol=1e-8)
    np.testing.assert_allclose(modes.decay[:6], W**2 * modulus.imag / (2.0 * w), rtol=1e-6)


def test_a_release_from_where_it_crept_to():
    """Refinement: a tenth of the tolerance. The release moves little of what the load has moved in the long run."""
    model = strip(creeping())
    model.force("strip.end", (0, 0, 0.1), until=0.0)
    run = model.simulate(0.02)
    assert not [text for text in run.warnings if "steps" in text or "remainder" in text]
    fine = model.simulate(0.02, tolerance=0.1 * run.data.attrs["tolerance"])
    times = np.linspace(0.0, 0.02, 101)
    z, exact = (np.array([one.positions_at(t)[-1, 2] for t in times]) for one in (run, fine))
    moved, error = np.abs(exact - exact[0]).max(), np.abs(z - exact).max()
    assert moved < 0.1 * exact[0]
    assert error < 3e-3 * moved
    assert 1.0 / 3.0 < run.step_errors["position"] / error < 10.0

"""From material data to damped vibrations: the correspondence principle on whole rods."""

import numpy as np
import pytest
from scipy.optimize import newton

import viscorod as vr

SHEAR, BULK = vr.RelaxationModulus(4e5, (2e5, 1e5), (0.05, 0.002)), vr.RelaxationModulus(2e6, (1e6,), (0.01,))
YOUNG = 9.0 * 2e6 * 4e5 / (3.0 * 2e6 + 4e5)


def at(relaxation: vr.RelaxationModulus, s: complex) -> complex:
    """Modulus at a complex frequency, the relaxation function's transform times s."""
    terms = zip(relaxation.moduli, relaxation.times, strict=True)
    return relaxation.equilibrium + sum(m * s * t / (1.0 + s * t) for m, t in terms)


def young(s: complex) -> complex:
    G, K = at(SHEAR, s), at(BULK, s)
    return 9.0 * K * G / (3.0 * K + G)


def beam(damping: vr.Prony | None) -> vr.Model:
    nu = (3.0 * 2e6 - 2.0 * 4e5) / (6.0 * 2e6 + 2.0 * 4e5)
    material = vr.Material(YOUNG, nu, 1000.0, damping=damping)
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.015)
    model.add(
        "beam",
        vr.Rod.straight(
            (0, 0, 0),
            (0.2, 0, 0),
            section=section,
            material=material,
            elements=3,
            order=4,
            constraints="kirchhoff",
        ),
    )
    model.clamp("beam.start")
    return model


def test_shear_and_bulk_series_in_bending_and_torsion():
    # without shear a bending mode sees Young's modulus alone, one of torsion the shear modulus alone:
    # s^2 = -w^2 M*(s)/M_inf on any mesh, w being the frequencies of the elastic rod of the same mesh
    damping = vr.Prony(
        shear_moduli=list(SHEAR.moduli),
        shear_times=list(SHEAR.times),
        bulk_moduli=list(BULK.moduli),
        bulk_times=list(BULK.times),
    )
    found = beam(damping).modes(8, about="reference").eigenvalues
    elastic = beam(None).modes(8, about="reference")
    twisting = np.abs(elastic.shapes).max(axis=(1, 2)) < 1e-6 * np.abs(elastic.rotations).max(axis=(1, 2))
    assert twisting.sum() >= 1
    for frequency, twists in zip(elastic.frequencies[:5], twisting, strict=False):
        omega = 2.0 * np.pi * frequency

        def characteristic(s, omega=omega, twists=twists):
            stiffening = at(SHEAR, s) / 4e5 if twists else young(s) / YOUNG
            return s**2 + omega**2 * stiffening

        fast = omega * np.sqrt(abs(young(1j * omega)) / YOUNG)
        root = newton(characteristic, complex(-0.05 * fast, fast), tol=1e-12, maxiter=200)
        assert np.abs(found - root).min() < 1e-7 * abs(root)


@pytest.mark.parametrize("law", ["maxwell", "kelvin_voigt"])
def test_the_damping_ratio_is_half_the_measured_tan_delta(law):
    # a table around the first frequency; constant nu, so that every mode sees the same tan delta
    omega = 2.0 * np.pi * np.geomspace(1.0, 5.0, 15)
    modulus = 1e6 * (1.0 + 0.1 * np.log10(omega)) * (1.0 + 0.04j)
    damping = vr.ComplexModuli(
        frequency=omega / (2.0 * np.pi), storage=modulus.real, loss=modulus.imag, law=law
    )
    material = vr.Material(poissons_ratio=0.4, density=1000.0, damping=damping)
    model = vr.Model()
    model.add(
        "beam",
        vr.Rod.straight(
            (0, 0, 0), (0.2, 0, 0), section=vr.Rectangle(0.02, 0.02), material=material, elements=2
        ),
    )
    model.clamp("beam.start")
    modes = model.modes(1, about="reference")
    assert 1.0 < modes.frequencies[0] < 5.0
    if law == "maxwell":
        assert modes.damping_ratios[0] == pytest.approx(0.02, rel=0.1)
    else:  # one viscosity: omega tau/2, which has the table's tan delta at one frequency of it
        ratio = np.pi * modes.frequencies[0] * material.extensional_time
        assert modes.damping_ratios[0] == pytest.approx(ratio, rel=1e-6)
        assert 0.01 < ratio < 0.04

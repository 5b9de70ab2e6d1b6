"""Kelvin-Voigt solids beside what they stand for: limits, least errors, and the picture."""

import numpy as np
import pytest
from scipy.optimize import minimize

import viscorod as vr
from helpers.pictures import written
from viscorod.errors import InputError
from viscorod.pictures.plots.plot_kelvin_voigt_fit import draw_fit

ZENER = vr.RelaxationModulus(1e6, (5e5,), (0.1,))
PRONY = vr.Prony(
    shear_moduli=[2e5, 1e5], shear_times=[0.1, 0.001], constant="bulk_modulus", law="kelvin_voigt"
)
MATERIAL = vr.Material(3e6, 0.45, 1000.0, damping=PRONY)


def test_low_frequency_errors_of_a_zener_solid():
    # E* = E + E1 (x^2 + i x)/(1 + x^2) with x = omega tau; the fit E + i E1 x: errors in closed form
    fit = vr.kelvin_voigt_fit(ZENER, (0.01, 10.0), fit="low_frequency")
    x = 2.0 * np.pi * fit.frequency * 0.1
    assert (fit.modulus, fit.time) == pytest.approx((1e6, 0.05), rel=1e-14)
    storage = 1e6 + 5e5 * x**2 / (1.0 + x**2)
    np.testing.assert_allclose(fit.storage_error, 1e6 / storage - 1.0, rtol=1e-10, atol=1e-14)
    np.testing.assert_allclose(fit.loss_error, x**2, rtol=1e-10, atol=1e-14)
    # LLT 2.6: |difference| = G1 x^2/sqrt(1 + x^2)
    np.testing.assert_allclose(
        fit.error * np.abs(fit.exact), 5e5 * x**2 / np.sqrt(1.0 + x**2), rtol=1e-10, atol=1e-6
    )


def test_slow_motion_has_no_error_in_the_limit():
    small = vr.kelvin_voigt_fit(MATERIAL, (1e-5, 1e-4), fit="low_frequency").error.max()
    smaller = vr.kelvin_voigt_fit(MATERIAL, (1e-6, 1e-5), fit="low_frequency").error.max()
    assert small / smaller == pytest.approx(100.0, rel=1e-3)  # of second order


@pytest.mark.parametrize("keep", [False, True])
def test_best_fit_has_the_least_error(keep):
    fit = vr.kelvin_voigt_fit(MATERIAL, (0.1, 100.0), keep_modulus=keep)

    def misfit(x):
        modulus = MATERIAL.youngs_modulus if keep else 1e6 * x[1]
        square = (
            np.abs(modulus + 2e4j * np.pi * fit.frequency * x[0] - fit.exact) ** 2 / np.abs(fit.exact) ** 2
        )
        return np.trapezoid(square, np.log(fit.frequency))

    start = [0.1] if keep else [0.1, 3.0]
    found = minimize(misfit, start, method="Nelder-Mead", options={"xatol": 1e-11, "fatol": 1e-17}).x
    assert fit.viscosity == pytest.approx(1e4 * found[0], rel=1e-6)
    assert fit.modulus == pytest.approx(MATERIAL.youngs_modulus if keep else 1e6 * found[1], rel=1e-6)


def test_the_material_has_the_fit_of_its_band():
    band = (1.0, 50.0)
    given = {"shear_ratios": [0.2, 0.1], "shear_times": [0.1, 0.001], "constant": "poissons_ratio"}
    m = vr.Material(3e6, 0.3, 1000.0, damping=vr.Prony(**given, law="kelvin_voigt", band=band))
    for strain, modulus, time in (
        ("extension", m.youngs_modulus, m.extensional_time),
        ("shear", m.shear_modulus, m.shear_time),
    ):
        fit = vr.kelvin_voigt_fit(m, band, strain=strain)
        assert (fit.modulus, fit.time) == pytest.approx((modulus, time), rel=1e-12)
    assert m.poissons_ratio == pytest.approx(0.3, rel=1e-12)
    assert m.branches == ()
    assert m.to_dict()["youngs_modulus"] == 3e6
    assert any(
        "from 1 to 50 Hz" in text and "at rest Young's modulus would be 3e+06 Pa" in text
        for text in m.assumptions
    )


def test_the_band_of_shear_and_bulk_keeps_both_viscosities_positive():
    m = vr.Material(3e6, 0.45, 1000.0, damping=PRONY.model_copy(update={"band": (1.0, 50.0)}))
    fit = vr.kelvin_voigt_fit(MATERIAL, (1.0, 50.0), strain="shear")
    assert (m.shear_modulus, m.shear_time) == pytest.approx((fit.modulus, fit.time), rel=1e-12)
    assert m.bulk_modulus == pytest.approx(MATERIAL.bulk_modulus, rel=1e-9)
    assert m.bulk_time == 0.0
    # Young's modulus of the two is near the one fitted by itself
    alone = vr.kelvin_voigt_fit(MATERIAL, (1.0, 50.0))
    assert m.youngs_modulus == pytest.approx(alone.modulus, rel=0.01)
    assert m.extensional_time == pytest.approx(alone.time, rel=0.05)


def test_an_incompressible_material_has_one_fit():
    damping = vr.Prony(
        shear_ratios=[0.2], shear_times=[0.1], constant="bulk_modulus", law="kelvin_voigt", band=(0.1, 10.0)
    )
    m = vr.Material(3e6, 0.5, 1000.0, damping=damping)
    assert m.poissons_ratio == 0.5
    assert m.extensional_time == pytest.approx(m.shear_time, rel=1e-14)


def test_tables_are_compared_row_by_row():
    hertz = np.geomspace(0.1, 100.0, 31)
    modulus = ZENER.complex_modulus(2.0 * np.pi * hertz)
    damping = vr.ComplexModuli(frequency=hertz, storage=modulus.real, loss=modulus.imag)
    m = vr.Material(poissons_ratio=0.3, density=1.0, damping=damping)
    fit = vr.kelvin_voigt_fit(m)
    assert (fit.modulus, fit.time) == pytest.approx((m.youngs_modulus, m.extensional_time), rel=1e-12)
    np.testing.assert_allclose(fit.frequency, hertz, rtol=1e-14)
    np.testing.assert_allclose(fit.exact, modulus, rtol=1e-14)
    within = vr.kelvin_voigt_fit(m, (1.0, 10.0))
    assert within.band == pytest.approx((1.0, 10.0), rel=1e-12)
    slow = vr.kelvin_voigt_fit(m, fit="low_frequency")
    assert slow.modulus == pytest.approx(modulus.real[:4].mean(), rel=0.01)
    with pytest.raises(InputError, match="strain: 'shear': the table of this material is one of extension"):
        vr.kelvin_voigt_fit(m, strain="shear")
    with pytest.raises(InputError, match="0 rows of the table are there"):
        vr.kelvin_voigt_fit(m, (200.0, 300.0))


def test_where_it_holds():
    fit = vr.kelvin_voigt_fit(ZENER, (1e-3, 100.0), fit="low_frequency")
    low, high = fit.band_within(0.01)
    assert low == pytest.approx(1e-3)
    # 0.5 x^2 = 0.01 (1 + x^2 ..): solved by bisection on the closed form
    x = np.geomspace(1e-3, 10.0, 200_001)
    exact = np.abs(1.0 + 0.5 * (x**2 + 1j * x) / (1.0 + x**2))
    limit = x[np.argmax(0.5 * x**2 / np.sqrt(1.0 + x**2) / exact > 0.01)] / (0.2 * np.pi)
    assert high <= limit < high * 1.05
    assert fit.band_within(1e-12) is None


def test_default_band_covers_the_relaxation():
    low, high = vr.kelvin_voigt_fit(MATERIAL).band
    times = MATERIAL.relaxation("extension").times
    assert low == pytest.approx(0.01 / (2.0 * np.pi * times[-1]), rel=1e-9)
    assert high == pytest.approx(100.0 / (2.0 * np.pi * times[0]), rel=1e-9)


def test_picture_and_words(tmp_path):
    fit = vr.kelvin_voigt_fit(MATERIAL, (1.0, 50.0))
    assert written(fit.plot, tmp_path / "fit.png").stat().st_size > 10_000
    figure = draw_fit(fit)
    lines = {line.get_label(): line for line in figure.axes[0].get_lines()}
    np.testing.assert_allclose(lines["storage, material"].get_ydata(), fit.exact.real)
    np.testing.assert_allclose(lines["loss, Kelvin-Voigt"].get_ydata(), fit.fitted.imag)
    np.testing.assert_allclose(figure.axes[1].get_lines()[0].get_ydata(), 100.0 * fit.storage_error)
    assert "From 1 to 50 Hz" in str(fit)
    wide = vr.kelvin_voigt_fit(MATERIAL, fit="low_frequency")
    assert written(wide.plot, tmp_path / "wide.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"material": 3}, "this is not a material"),
        ({"material": vr.Material(1e6, 0.3, 1.0)}, "no damping: this material is Kelvin-Voigt or elastic"),
        (
            {"material": vr.Material(1e6, 0.3, 1.0, damping=vr.KelvinVoigt(1.0, 1.0))},
            "KelvinVoigt: this material",
        ),
        ({"material": vr.RelaxationModulus(1.0)}, "nothing relaxes"),
        ({"material": ZENER, "band": (2.0, 1.0)}, r"band: .*give \(low, high\) in Hz"),
        ({"material": ZENER, "band": (1.0,)}, "band: .*2 numbers"),
        ({"material": ZENER, "strain": "bending"}, "strain: 'bending': no such word"),
        (
            {"material": ZENER, "fit": "good"},
            "fit: 'good': no such word; give one of 'best', 'low_frequency'",
        ),
    ],
)
def test_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        vr.kelvin_voigt_fit(**arguments)


def test_a_band_is_refused_beside_branches():
    with pytest.raises(InputError, match=r"band: .*Maxwell branches hold at every frequency"):
        vr.Prony(shear_ratios=[0.1], shear_times=[1.0], constant="bulk_modulus", band=(1.0, 2.0))

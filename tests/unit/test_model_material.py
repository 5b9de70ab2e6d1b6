"""Material formulas against their limits (Linn, Lang and Tuganov 2013, equations 3-4)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from viscorod.errors import InputError
from viscorod.model.materials.material import KelvinVoigt, Material

RATIOS = st.floats(-0.99, 0.5)
VISCOSITIES = st.just(0.0) | st.floats(1e-30, 1e6)
TIMES = st.just(0.0) | st.floats(1e-30, 10.0)


def material(nu: float, damping: KelvinVoigt | None = None) -> Material:
    return Material(2.0e6, nu, 1100.0, damping=damping)


@given(RATIOS, TIMES)
def test_equal_times_make_one_time(nu, tau):
    m = material(nu, KelvinVoigt(tau, tau))
    assert m.extensional_time == pytest.approx(tau, rel=1e-14)


@given(TIMES, TIMES)
def test_without_lateral_contraction(shear, bulk):
    m = material(0.0, KelvinVoigt(shear, bulk))
    assert m.extensional_time == pytest.approx((bulk + 2.0 * shear) / 3.0, rel=1e-14)


@given(TIMES, TIMES)
def test_incompressible_extension_is_shear(shear, bulk):
    m = material(0.5, KelvinVoigt(shear, bulk))
    assert m.extensional_time == pytest.approx(shear, rel=1e-14)
    assert m.extensional_viscosity == pytest.approx(3.0 * m.shear_viscosity, rel=1e-14)
    assert m.bulk_modulus == math.inf
    assert m.bulk_viscosity == (math.inf if bulk > 0.0 else 0.0)


@given(st.floats(-0.99, 0.49), VISCOSITIES, VISCOSITIES)
def test_extensional_viscosity_from_viscosities(nu, eta, zeta):
    m = material(nu, KelvinVoigt(shear_viscosity=eta, bulk_viscosity=zeta))
    expected = zeta * (1.0 - 2.0 * nu) ** 2 + 4.0 / 3.0 * eta * (1.0 + nu) ** 2
    assert m.extensional_viscosity == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert m.shear_viscosity == pytest.approx(eta, rel=1e-14)
    assert m.bulk_viscosity == zeta
    assert m.bulk_time == pytest.approx(zeta / m.bulk_modulus, rel=1e-14)


@given(st.floats(-0.9, 0.49), TIMES, TIMES)
def test_times_and_viscosities_say_the_same(nu, shear, bulk):
    by_times = material(nu, KelvinVoigt(shear, bulk))
    by_viscosities = material(
        nu, KelvinVoigt(shear_viscosity=by_times.shear_viscosity, bulk_viscosity=by_times.bulk_viscosity)
    )
    assert by_viscosities.extensional_time == pytest.approx(by_times.extensional_time, rel=1e-12, abs=1e-15)


def test_finite_extensional_viscosity_of_an_incompressible_fluidlike_solid():
    m = material(0.5, KelvinVoigt(shear_viscosity=10.0, bulk_viscosity=3.0))
    assert m.bulk_time == 0.0
    assert m.extensional_viscosity == pytest.approx(30.0, rel=1e-14)


def test_elastic_material_has_no_viscosity():
    m = material(0.3)
    assert (m.shear_viscosity, m.bulk_viscosity, m.extensional_viscosity) == (0.0, 0.0, 0.0)
    assert (m.shear_time, m.bulk_time, m.extensional_time) == (0.0, 0.0, 0.0)


@given(RATIOS)
def test_shear_modulus_instead_of_poissons_ratio(nu):
    by_ratio = material(nu)
    by_modulus = Material(2.0e6, density=1100.0, shear_modulus=by_ratio.shear_modulus)
    assert by_modulus.poissons_ratio == pytest.approx(nu, abs=1e-12)
    assert by_ratio.shear_modulus == pytest.approx(1.0e6 / (1.0 + nu), rel=1e-14)
    assert by_modulus.to_dict().keys() == {"youngs_modulus", "density", "shear_modulus"}


@pytest.mark.parametrize(
    ("arguments", "path"),
    [
        ({"youngs_modulus": 0.0}, "Material.youngs_modulus"),
        ({"youngs_modulus": -1.0}, "Material.youngs_modulus"),
        ({"youngs_modulus": math.nan}, "Material.youngs_modulus"),
        ({"youngs_modulus": math.inf}, "Material.youngs_modulus"),
        ({"youngs_modulus": "1e6"}, "Material.youngs_modulus"),
        ({"youngs_modulus": True}, "Material.youngs_modulus"),
        ({"poissons_ratio": -1.0}, "Material.poissons_ratio"),
        ({"poissons_ratio": 0.5000001}, "Material.poissons_ratio"),
        ({"poissons_ratio": math.nan}, "Material.poissons_ratio"),
        ({"density": 0.0}, "Material.density"),
        ({"density": -1.0}, "Material.density"),
        ({"density": None}, "Material.density"),
        ({"shear_modulus": 1e6}, "Material"),
        ({"damping": 0.1}, "Material.damping"),
        ({"damping": {"shear_time": -0.1, "bulk_time": 0.1}}, "Material.damping.shear_time"),
    ],
)
def test_refused(arguments, path):
    good = {"youngs_modulus": 1e6, "poissons_ratio": 0.3, "density": 1000.0}
    with pytest.raises(InputError) as caught:
        Material(**(good | arguments))
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.why
    assert problem.instead


def test_missing_density_and_ratio_are_named():
    assert not Material(1e6, 0.3).has_density
    with pytest.raises(InputError, match=r"Material\.density"):
        Material(1e6, 0.3, float("nan"))
    with pytest.raises(InputError, match="poissons_ratio, or shear_modulus"):
        Material(1e6, density=1.0)


def test_shear_modulus_outside_the_range_of_poissons_ratio():
    with pytest.raises(InputError, match=r"Material\.shear_modulus: 100000\.0: .*Poisson's ratio of 4"):
        Material(1e6, density=1.0, shear_modulus=1e5)


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"shear_time": 0.1},
        {"shear_time": 0.1, "bulk_viscosity": 0.1},
        {"shear_time": 0.1, "bulk_time": 0.1, "shear_viscosity": 1.0},
        {"shear_time": 0.1, "bulk_time": 0.1, "shear_viscosity": 1.0, "bulk_viscosity": 1.0},
    ],
)
def test_viscosity_needs_one_complete_pair(arguments):
    with pytest.raises(InputError, match="one complete pair"):
        KelvinVoigt(**arguments)


def test_a_misspelt_key_is_told_with_the_right_one():
    with pytest.raises(InputError, match=r"Material\.densty: 3\.0: no such key; did you mean density\?"):
        Material(1e6, 0.3, densty=3.0)


def test_materials_cannot_be_changed():
    with pytest.raises(ValueError, match="frozen"):
        material(0.3).density = 2.0


@pytest.mark.parametrize(
    ("damping", "kind"),
    [
        ({"extension": 0.01, "band": ["1 Hz", "200 Hz"]}, "loss_factor"),
        ({"loss_factor": 0.01}, "loss_factor"),  # the word for the kind as a key
        ({"extension_ratios": [0.1], "extension_times": [0.1]}, "prony"),
        ({"file": "dma.csv"}, "complex_moduli"),
    ],
)
def test_damping_without_its_kind_is_told_the_kind(damping, kind):
    with pytest.raises(
        InputError, match=rf"^Material.damping.kind: this key is missing, .*; add kind = '{kind}'$"
    ):
        Material(2.0e6, 0.3, 1100.0, damping=damping)


def test_a_misspelt_key_of_the_usual_damping_is_no_other_kind():
    with pytest.raises(InputError, match="did you mean shear_time"):
        Material(2.0e6, 0.3, 1100.0, damping={"sheartime": 0.1, "bulk_time": 0.1})

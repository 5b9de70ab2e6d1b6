"""Numbers in a unit that was not meant are doubted where the check of a model is read; those of real materials are not.

Moduli and densities of the second list are those of tables (Ashby, Materials Selection in Mechanical Design, 2011).
"""

import numpy as np
import pytest

import viscorod as vr


def doubts(youngs_modulus=2.1e11, density=7850.0, damping=None, angle=1.0):
    model = vr.Model()
    material = vr.Material(youngs_modulus, 0.3, density, damping=damping)
    arc = vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, angle, section=vr.Circle(0.01), material=material)
    model.add("rod", arc)
    model.clamp("rod.start")
    return [text for text in model.check().warnings if text.startswith("rod rod:")]


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"density": 7.85}, "a density in g/cm3"),
        ({"youngs_modulus": 210.0}, "1 GPa is 1e9 Pa"),
        ({"youngs_modulus": 210e3}, "1 MPa is 1e6 Pa"),
        ({"damping": vr.LossFactor(extension=5.0, frequency=10.0)}, "1 % is 0.01"),
        (
            {"damping": vr.ComplexModuli([1.0, 10.0], [2.1e5, 2.2e5], [2e3, 2e4])},
            "2.1e+05 to 2.2e+05 Pa; 1 MPa is 1e6",
        ),
        ({"angle": 45.0}, "goes round 7.16 times upon itself; 45 degrees are 0.7854 rad"),
    ],
)
def test_another_unit_is_told(given, text):
    (found,) = [text for text in doubts(**given) if "first angular frequency" not in text]
    assert text in found


@pytest.mark.parametrize(
    ("modulus", "density"),
    [
        (1.05e12, 3510.0),  # diamond
        (1e3, 1000.0),  # a gel
        (1e5, 1100.0),  # silicone
        (1e7, 11.0),  # foam
        (16e9, 11340.0),  # lead
        (3e11, 1850.0),  # beryllium
        (1.0, 1.0),  # no units at all
    ],
)
def test_materials_that_exist_are_not_doubted(modulus, density):
    assert doubts(modulus, density, angle=2.0 * np.pi) == []


def test_a_modulus_in_the_range_of_its_own_table_is_not_doubted():
    """At rest, of a table that begins in the glass transition, and none given."""
    table = vr.ComplexModuli([1.0, 10.0], [2.1e7, 2.2e8], [2e6, 2e7])
    for modulus in (3e6, 2e8):
        assert not [text for text in doubts(modulus, 1200.0, table) if "own table" in text]
    model = vr.Model()
    material = vr.Material(poissons_ratio=0.4, density=1200.0, damping=table)
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material))
    model.clamp("rod.start")
    assert not [text for text in model.check().warnings if "own table" in text]

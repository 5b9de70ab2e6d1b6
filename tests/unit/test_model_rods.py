"""Rods: sections along them, their checks, and their form as a table."""

import math

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.rod import Rod
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.section_profile import Piecewise, Taper
from viscorod.model.sections.section_shapes import Circle, Ellipse, Rectangle
from viscorod.model.sections.stiffness_section import StiffnessSection

STEEL = Material(2.1e11, 0.3, 7850.0)
SQUARE = Rectangle(0.01, 0.01)
MATRIX = StiffnessSection((1, 2, 3, 4, 5, 6), (1, 1, 1, 1, 1, 1))


def straight(section, material=STEEL, **options):
    return Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=material, **options)


def test_constructors_follow_their_centre_lines():
    options = {"section": SQUARE, "material": STEEL}
    assert straight(SQUARE).length == pytest.approx(0.3)
    assert Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 2.0, 0.5, **options).length == pytest.approx(1.0)
    assert Rod.helix(1.0, 0.0, 2.0, **options).length == pytest.approx(4 * math.pi)
    assert Rod.through([(0, 0, 0), (0, 3, 4)], **options).length == pytest.approx(5.0)
    assert Rod.curve(lambda u: (u, 2 * u, 2 * u), **options).length == pytest.approx(3.0)


def test_one_section():
    rod = straight(SQUARE)
    assert rod.section_at(0.1) is SQUARE
    assert rod.section_breaks == ()
    assert rod.matrices_at(0.2)[0] == pytest.approx(SQUARE.matrices(STEEL)[0])


def test_pieces():
    rod = straight(Piecewise([(0.1, SQUARE), (0.3, Circle(0.01))]))
    assert rod.section_breaks == (0.1,)
    assert rod.section_at(0.0999) == SQUARE
    assert rod.section_at(0.1) == Circle(0.01)
    assert rod.section_at(0.3) == Circle(0.01)


def test_pieces_may_mix_shapes_and_matrices():
    rod = straight(Piecewise([(0.1, MATRIX), (0.3, Circle(0.01))]))
    assert np.diag(rod.matrices_at(0.05)[0]) == pytest.approx([1, 2, 3, 4, 5, 6])
    assert rod.matrices_at(0.2)[0] == pytest.approx(Circle(0.01).matrices(STEEL)[0])


def test_taper_is_linear_in_every_dimension():
    rod = straight(Taper(Rectangle(0.01, 0.02), Rectangle(0.03, 0.01)))
    section = rod.section_at(0.15)
    assert (section.width, section.height) == (pytest.approx(0.02), pytest.approx(0.015))
    assert rod.section_at(0.0) == Rectangle(0.01, 0.02)
    assert rod.section_at(0.3) == Rectangle(0.03, 0.01)


def test_taper_of_given_numbers_overrides_and_matrices():
    given = Taper(SectionProperties(1, 2, 3, 4), SectionProperties(3, 4, 5, 6)).at(0.5)
    assert (given.area, given.torsion_constant) == (2.0, 5.0)
    fixed = Taper(Circle(1.0, torsion_constant=1.0), Circle(2.0, torsion_constant=3.0)).at(0.25)
    assert (fixed.radius, fixed.torsion_constant) == (1.25, 1.5)
    double = StiffnessSection((2, 4, 6, 8, 10, 12), (3,) * 6)
    assert np.diag(Taper(MATRIX, double).at(0.5).matrices()[0]) == pytest.approx([1.5, 3, 4.5, 6, 7.5, 9])


def test_section_as_a_function_of_arc_length():
    rod = straight(lambda s: Circle(0.01 + s))
    assert rod.section_at(0.2).radius == pytest.approx(0.21)
    assert rod.to_dict()["section"].startswith("<Python function")


@pytest.mark.parametrize(
    ("section", "volume"),
    [
        (Circle(0.01), 0.3 * math.pi * 1e-4),
        (Piecewise([(0.1, Circle(0.02)), (0.3, Circle(0.01))]), math.pi * (0.1 * 4e-4 + 0.2 * 1e-4)),
        (Taper(Circle(0.01), Circle(0.03)), 0.3 * math.pi / 3 * (1e-4 + 3e-4 + 9e-4)),  # a truncated cone
        (lambda s: Circle(0.01 * math.exp(s)), math.pi * 1e-4 * (math.exp(0.6) - 1) / 2),
    ],
)
def test_mass_is_density_times_volume(section, volume):
    assert straight(section).mass == pytest.approx(STEEL.density * volume, rel=1e-13)


def test_first_axis_and_twist_reach_the_frames():
    rod = straight(SQUARE, d1=(0, 0, 2), twist=math.pi / 2)
    _, frames = rod.frames([0.0, 0.3])
    assert frames[0][:, 0] == pytest.approx([0, 0, 1], abs=1e-15)
    assert frames[1][:, 0] == pytest.approx([0, -1, 0], abs=1e-15)


def test_counts_are_whole_numbers_or_automatic():
    rod = straight(SQUARE, elements=3, order=8)
    assert (rod.elements, rod.order) == (3, 8)
    assert straight(SQUARE, elements="auto").elements is None
    assert straight(SQUARE).order is None


def test_as_a_table():
    rod = straight(Piecewise([(0.1, SQUARE), (0.3, Circle(0.01))]), elements=2)
    table = rod.to_dict()
    assert table["shape"] == "straight"
    assert table["end"] == [0.3, 0.0, 0.0]
    assert table["sections"][1] == {"until": 0.3, "section": {"shape": "circle", "radius": 0.01}}
    assert table["elements"] == 2
    assert "order" not in table
    assert straight(Taper(SQUARE, SQUARE)).to_dict()["taper"].keys() == {"start", "end"}


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: straight(SQUARE, None), "Rod.material", "needs a material"),
        (lambda: straight(MATRIX), "Rod.material", "takes no material"),
        (
            lambda: straight(Piecewise([(0.1, SQUARE), (0.2, SQUARE)])),
            "Rod.section.pieces[1].until",
            "end of the rod",
        ),
        (
            lambda: straight(Piecewise([(0.1, SQUARE), (0.4, SQUARE)])),
            "Rod.section.pieces[1].until",
            "end of the rod",
        ),
        (lambda: Piecewise([(0.2, SQUARE), (0.1, SQUARE)]), "Piecewise.pieces[1].until", "further along"),
        (lambda: Piecewise([]), "Piecewise.pieces", "at least one"),
        (lambda: Piecewise([(0.2, "square")]), "Piecewise.pieces[0].section", "table"),
        (lambda: Taper(SQUARE, Circle(1.0)), "Taper", "same shape"),
        (
            lambda: Taper(Circle(1.0, torsion_constant=1.0), Circle(1.0)),
            "Taper.torsion_constant",
            "one end only",
        ),
        (lambda: straight(lambda s: 3), "Rod.section", "this is no section"),
        (lambda: straight("square"), "Rod.section", "a section is needed"),
        (
            lambda: Rod.straight((0, 0, 0), (1e-300, 0, 0), section=SQUARE, material=STEEL),
            "Straight.end[0]",
            "smaller than any quantity",
        ),
        (lambda: straight(SQUARE, elements=0), "Rod.elements", "from 1"),
        (lambda: straight(SQUARE, elements=2.0), "Rod.elements", "whole number"),
        (lambda: straight(SQUARE, order=13), "Rod.order", "1 to 12"),
        (lambda: straight(SQUARE, order=True), "Rod.order", "whole number"),
        (lambda: straight(SQUARE, twist="a"), "Rod.twist", "number"),
        (lambda: straight(SQUARE, twist=lambda s: None), "Rod.twist", "function of the twist"),
        (lambda: straight(SQUARE, twist=lambda s: math.nan), "Rod.twist", "finite"),
        (lambda: straight(SQUARE, d1=(1, 0, 0)), "Rod.d1", "along the rod"),
        (
            lambda: straight(
                Rectangle(1e60, 1e60), Material(1e59, 0.3, 1e59, damping=KelvinVoigt(1e59, 1e59))
            ),
            "Rod.section",
            "not a positive number",
        ),
        (lambda: straight(Rectangle(1e-200, 1.0)), "Rectangle.width", "smaller than any quantity"),
        (lambda: straight(Rectangle(1e200, 1.0)), "Rectangle.width", "larger than any quantity"),
        (lambda: straight(Ellipse(0.01, 1.0), Material(1.0, -0.5, 1.0)), "Rod.section", "very flat ellipse"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=text) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


@pytest.mark.parametrize(
    ("given", "held"),
    [
        ((), ""),
        ("unshearable", "110000"),
        ("inextensible", "001000"),
        ("kirchhoff", "111000"),
        (["unshearable", "twist"], "110001"),
        (["bend_2"], "000010"),
        (("kirchhoff", "bend_1", "bend_2", "twist"), "111111"),
    ],
)
def test_constraints(given, held):
    rod = straight(SQUARE, constraints=given)
    assert rod.constrained_strains == tuple(bit == "1" for bit in held.ljust(6, "0"))
    arc = Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 2.0, 0.5, section=MATRIX, constraints=given)
    assert arc.constraints == rod.constraints


def test_constraints_in_a_table():
    assert straight(SQUARE, constraints="kirchhoff").to_dict()["constraints"] == ["kirchhoff"]
    assert "constraints" not in straight(SQUARE).to_dict()


@pytest.mark.parametrize(
    ("given", "where", "text"),
    [
        ("kirchoff", "Rod.constraints", "did you mean 'kirchhoff'"),
        (["unshearable", "shear1"], r"Rod.constraints\[1\]", "did you mean 'shear_1'"),
        (["twist", "twist"], r"Rod.constraints\[1\]", "the same constraint twice"),
        ([3], r"Rod.constraints\[0\]", "no such constraint"),
        (True, "Rod.constraints", "a word or a list of words"),
    ],
)
def test_constraints_that_are_none(given, where, text):
    with pytest.raises(InputError, match=f"{where}: .*{text}"):
        straight(SQUARE, constraints=given)

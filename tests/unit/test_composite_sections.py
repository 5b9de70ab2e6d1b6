"""Composite sections against closed forms of laminates and of damped layers; regions, branches, case files."""

import math
import sys
import tomllib

import numpy as np
import pytest

from helpers.section_matrices import material, scaled
from viscorod.casefile.case import case_from_dict
from viscorod.errors import InputError
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.materials.measured_damping import MeasuredDamping
from viscorod.model.materials.prony import Prony
from viscorod.model.rod import Rod
from viscorod.model.sections.composite import Composite, CompositeRegion
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.saint_venant import _once
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_profile import Piecewise, Taper
from viscorod.model.sections.section_shapes import Annulus, Circle, Rectangle, SquareTube

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def strip(lower, upper, b=0.04, h1=0.01, h2=0.02, **given):
    """Two layers of width b, one of height h1 below y = 0, one of height h2 above."""
    return Composite(
        [
            CompositeRegion(lower, Rectangle(b, h1), at=(0, -h1 / 2)),
            CompositeRegion(upper, Rectangle(b, h2), at=(0, h2 / 2)),
        ],
        **given,
    )


def test_a_bimetal_strip_by_laminate_theory():
    """A, B, D integrals of classical lamination about the interface: extension couples with bending about d1."""
    E1, E2, b, h1, h2 = 2.1e11, 7e10, 0.04, 0.01, 0.02
    section = strip(material(E1, density=7800.0), material(E2, density=2700.0), b, h1, h2, origin="given")
    C, D, M = section.matrices()
    A = b * (E1 * h1 + E2 * h2)
    B = b * (-E1 * h1**2 + E2 * h2**2) / 2
    stiffness = b * (E1 * h1**3 + E2 * h2**3) / 3
    assert C[2:4, 2:4] == pytest.approx(np.array([[A, B], [B, stiffness]]), rel=1e-10)
    assert C[4, 4] == pytest.approx((E1 * h1 + E2 * h2) * b**3 / 12, rel=1e-10)
    assert not D.any()
    assert M[0, 0] == pytest.approx(b * (7800 * h1 + 2700 * h2), rel=1e-10)
    assert M[2, 3] == pytest.approx(b * (-7800 * h1**2 + 2700 * h2**2) / 2, rel=1e-10)
    assert M[0, 5] == pytest.approx(-M[2, 3], rel=1e-10)
    assert section.centres.tension_centre == pytest.approx((0.0, B / A), abs=1e-12)
    about = strip(material(E1), material(E2), b, h1, h2).matrices()[0]
    assert about[2, 3] == pytest.approx(0.0, abs=1e-9 * math.sqrt(about[2, 2] * about[3, 3]))
    assert about[3, 3] == pytest.approx(stiffness - B**2 / A, rel=1e-10)


def bending_loss(C, D):
    """Time of bending about d1 at zero axial force: d/d(i omega) of the Schur complement over itself."""
    reduced = C[3, 3] - C[2, 3] ** 2 / C[2, 2]
    ratio = C[2, 3] / C[2, 2]
    return (D[3, 3] - 2 * ratio * D[2, 3] + ratio**2 * D[2, 2]) / reduced


@pytest.mark.parametrize("origin", ["centroid", "shear_centre", "given"])
@pytest.mark.parametrize(("e", "h"), [(0.01, 1.0), (0.05, 2.0), (0.5, 0.5)])
def test_loss_of_a_free_damping_layer_by_obersts_formula(origin, e, h):
    """H. Oberst, Acustica 2 (1952); Nashif, Jones and Henderson, Vibration damping (1985), section 5.3.

    eta/eta_2 = e h (3 + 6 h + 4 h^2 + 2 e h^3 + e^2 h^4)/[(1 + e h)(1 + 4 e h + 6 e h^2 + 4 e h^3 + e^2 h^4)]
    for a layer of loss factor eta_2, e = E_2/E_1, h = h_2/h_1; small losses, whose factors are omega times time.
    """
    tau_S, tau_B, nu = 0.02, 0.05, 0.4
    layer = material(e * 2e11, nu=nu, shear=tau_S, bulk=tau_B)
    C, D, _ = strip(
        material(2e11, nu=0.3), layer, h1=0.01, h2=0.01 * h, origin=origin, mesh_size=0.01
    ).matrices()
    tau_E = ((1 - 2 * nu) * tau_B + 2 * (1 + nu) * tau_S) / 3
    share = e * h * (3 + 6 * h + 4 * h**2 + 2 * e * h**3 + e**2 * h**4)
    share /= (1 + e * h) * (1 + 4 * e * h + 6 * e * h**2 + 4 * e * h**3 + e**2 * h**4)
    assert bending_loss(C, D) == pytest.approx(share * tau_E, rel=1e-8)


def test_a_coated_wire_in_torsion():
    """Concentric circles do not warp: GJ = sum G_m I_p,m, and its damping sum eta_m I_p,m."""
    core, coat = material(7e10, nu=0.3, shear=1e-4, bulk=1e-4), material(5e6, nu=0.48, shear=0.05, bulk=0.01)
    section = Composite([CompositeRegion(core, Circle(0.001)), CompositeRegion(coat, Annulus(0.002, 0.001))])
    C, D, _ = section.matrices()
    polar = math.pi / 2 * np.array([0.001**4, 0.002**4 - 0.001**4])
    assert C[5, 5] == pytest.approx(polar @ [core.shear_modulus, coat.shear_modulus], rel=1e-5)
    assert D[5, 5] == pytest.approx(polar @ [core.shear_viscosity, coat.shear_viscosity], rel=1e-5)
    assert section.half_width == pytest.approx(0.002, rel=1e-3)
    assert "lateral contraction" in section.remarks()[1]


def test_damping_is_positive_and_coupled():
    """A soft viscous block on one side of a stiff one: shear centre and couplings of C, D and M differ."""
    section = Composite(
        [
            CompositeRegion(material(2e9, nu=0.3, shear=1e-3, bulk=1e-3, density=1500.0), points=SQUARE),
            CompositeRegion(
                material(1e8, nu=0.45, shear=0.1, bulk=0.02, density=900.0), points=SQUARE, at=(1.0, 0.3)
            ),
        ]
    )
    C, D, M = section.matrices()
    for matrix in (C, D, M):
        assert matrix == pytest.approx(matrix.T)
        assert np.linalg.eigvalsh(scaled(matrix)).min() > 0.0
    assert abs(D[2, 4]) > 1e-3 * math.sqrt(D[2, 2] * D[4, 4])
    assert abs(D[1, 5]) > 1e-3 * math.sqrt(D[1, 1] * D[5, 5])
    times = np.diag(D) / np.diag(C)
    assert (times > 1e-3).all()
    assert (times < 0.1).all()


def test_only_the_bulk_viscous_do_not_damp_shear():
    law = Material(youngs_modulus=1e6, poissons_ratio=0.2, density=1.0,
                   damping=KelvinVoigt(shear_viscosity=0.0, bulk_viscosity=10.0))  # fmt: skip
    D = strip(material(2e6, nu=0.1), law).matrices()[1]
    assert not D[np.ix_((0, 1, 5), (0, 1, 5))].any()
    assert np.diag(D)[2:5].all()


def relaxing(E, moduli, times):
    """A material with Poisson's ratio 0: G_j = E_j/2."""
    damping = Prony(extension_moduli=moduli, extension_times=times, constant="poissons_ratio")
    return Material(E, 0.0, 1.0, damping=damping)


def test_maxwell_branches_of_the_regions():
    """E_j dC/dE + G_j dC/dG of every region; branches of the same time are summed, times increase."""
    section = strip(
        relaxing(1e9, [3e8, 5e7], [0.1, 2.0]), relaxing(2e8, [6e7, 1e7], [0.1, 0.03]), origin="given"
    )
    times, stiffness = section.branch_matrices()
    assert times == pytest.approx([0.03, 0.1, 2.0])
    assert not section.matrices()[1].any()  # viscosity is in the branches
    b, h1, h2 = 0.04, 0.01, 0.02
    assert stiffness[:, 2, 2] == pytest.approx(
        [1e7 * b * h2, 3e8 * b * h1 + 6e7 * b * h2, 5e7 * b * h1], rel=1e-9
    )
    assert stiffness[:, 2, 3] == pytest.approx(
        [1e7 * b * h2**2 / 2, (6e7 * h2**2 - 3e8 * h1**2) * b / 2, -5e7 * b * h1**2 / 2], rel=1e-9
    )
    # in torsion: the derivative of the stiffness by the shear modulus of the upper layer, a step of 1e-4
    analysis = section._analysis
    youngs, shear = np.array([1e9, 2e8]), np.array([5e8, 1e8])

    def torsion(step):
        moduli = shear + np.array([0.0, step])
        strains = _once(section._polygons, youngs, moduli, 0.0, analysis.side).strains
        return 1.0 / np.einsum("r,rij->ij", moduli, strains)[2, 2]

    slope = (torsion(1e4) - torsion(-1e4)) / 2e4
    centred = Composite(section.regions, origin="shear_centre").branch_matrices()[1]
    assert centred[0, 5, 5] == pytest.approx(5e6 * slope, rel=1e-6)


def test_a_prony_material_in_a_region():
    """Its branches are those that it has alone in the same outline, since the other region has none."""
    rubber = Material(
        1e7,
        0.45,
        1000.0,
        damping=Prony(shear_moduli=[1e6, 2e6], shear_times=[0.1, 1e-3], constant="poissons_ratio"),
    )
    steel = material(2e11, nu=0.3)
    section = strip(steel, rubber, origin="given")
    times, stiffness = section.branch_matrices()
    corners = [(-0.02, 0.0), (0.02, 0.0), (0.02, 0.02), (-0.02, 0.02)]
    alone_times, alone = PolygonSection(corners, origin="given").branch_matrices(rubber)
    assert len(times) == len(rubber.branches) == 2
    assert times == pytest.approx(alone_times)
    extension = np.ix_(range(len(times)), (2, 3, 4), (2, 3, 4))
    assert stiffness[extension] == pytest.approx(alone[extension], rel=1e-9, abs=1e-6)
    for matrix in stiffness:
        assert np.linalg.eigvalsh(scaled(matrix)).min() > -1e-9


def test_regions_are_placed_and_turned():
    law = material(1.0)
    quarter = Composite(
        [CompositeRegion(law, Rectangle(0.2, 0.5), at=(1.0, 2.0), angle=math.pi / 2)], origin="given"
    )
    C = quarter.matrices()[0]
    assert quarter.centres.tension_centre == pytest.approx((1.0, 2.0))
    centred = Composite([CompositeRegion(law, Rectangle(0.5, 0.2))]).matrices()[0]
    assert C[3, 3] == pytest.approx(centred[3, 3] + 0.1 * 4.0, rel=1e-9)
    assert C[4, 4] == pytest.approx(centred[4, 4] + 0.1 * 1.0, rel=1e-9)
    assert C[3, 4] == pytest.approx(-0.1 * 2.0, rel=1e-9)


def test_regions_meet_in_spite_of_round_off():
    """0.1 + 0.2 against 0.3, and a slanted edge in the middle of which the others have a corner."""
    law, third = material(1.0), 1.0 / 3.0
    level = [
        CompositeRegion(law, points=[(0, 0), (1, 0), (1, 0.1 + 0.2), (0, 0.1 + 0.2)]),
        CompositeRegion(law, points=[(0, 0.3), (1, 0.3), (1, 1), (0, 1)]),
    ]
    slanted = [
        CompositeRegion(law, points=[(0, 0), (1, 0), (0, third)]),
        CompositeRegion(law, points=[(1, 0), (1, 1), (0.1, 0.9 * third)]),
        CompositeRegion(law, points=[(0.1, 0.9 * third), (1, 1), (0, third)]),
    ]
    for regions, whole in ((level, SQUARE), (slanted, [(0, 0), (1, 0), (1, 1), (0, third)])):
        C = Composite(regions).matrices()[0]
        assert C == pytest.approx(PolygonSection(whole).matrices(law)[0], rel=1e-3, abs=1e-4)
        assert C[2, 2] == pytest.approx(PolygonSection(whole).moments()[0], rel=1e-7)


def test_an_object_that_is_none_of_the_shapes_is_told_by_its_class():
    """It was told to be a table that lacks a key, which nobody has in Python."""
    polygon = PolygonSection(((0, 0), (1, 0), (1, 1)))
    with pytest.raises(InputError, match=r"this cannot be a PolygonSection; give one of Circle, Annulus"):
        CompositeRegion(Material(2e11, 0.3, 7850.0), polygon)


def test_rods_take_no_material_beside_a_composite_section():
    law = material(1e6, nu=0.3, shear=0.01, bulk=0.01)
    section = strip(law, material(2e6, nu=0.3))
    rod = Rod.straight((0, 0, 0), (1, 0, 0), section=section)
    assert isinstance(section, AnySection)
    assert rod.matrices_at(0.3)[0] == pytest.approx(section.matrices()[0])
    assert rod.branches_at(0.3)[1].shape == (0, 6, 6)
    with pytest.raises(InputError, match="regions of a composite section have their own materials"):
        Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=law)
    with pytest.raises(InputError, match="their own materials"):
        section.matrices(law)
    mixed = Piecewise([(0.5, section), (1.0, Rectangle(0.04, 0.03))])
    with pytest.raises(InputError, match="needs a material"):
        Rod.straight((0, 0, 0), (1, 0, 0), section=mixed)
    Rod.straight((0, 0, 0), (1, 0, 0), section=mixed, material=law)
    with pytest.raises(InputError, match="a mesh of its own at every station"):
        Taper(section, section)


CASE = """
[materials.steel]
youngs_modulus = 2e11
poissons_ratio = 0.3
density = 7800.0

[materials.rubber]
youngs_modulus = 5e6
poissons_ratio = 0.48
density = 1100.0
damping = { shear_time = 0.01, bulk_time = 0.01 }

[sections.core]
shape = "rectangle"
width = 0.02
height = 0.002

[sections.coated]
shape = "composite"
origin = "given"
regions = [
  { section = "core", material = "steel" },
  { points = [[-0.01, 0.001], [0.01, 0.001], [0.01, 0.004], [-0.01, 0.004]], material = "rubber" },
]

[rods.blade]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.3, 0.0, 0.0]
section = "coated"

[[supports]]
kind = "clamp"
at = "blade.start"

[simulate]
duration = 0.1
"""


def test_a_case_file_names_materials_and_sections_in_the_regions():
    case = case_from_dict(tomllib.loads(CASE))
    section = case.description.rods["blade"].section
    assert [region.material.youngs_modulus for region in section.regions] == [2e11, 5e6]
    assert section.regions[0].section == Rectangle(0.02, 0.002)
    again = case_from_dict(case.to_dict())
    assert again.to_dict() == case.to_dict()
    assert again.description.rods["blade"].section == section


@pytest.mark.parametrize(
    ("old", "new", "where", "text"),
    [
        ('material = "rubber" }', 'material = "ruber" }', "sections.coated.regions[1].material", "'rubber'"),
        ('"core", material = "steel" }', '"core" }', "sections.coated.regions[0].material", "required"),
        ('section = "core", ', 'section = "cor", ', "sections.coated.regions[0].section", "no section"),
        (
            'section = "core", ',
            'sections = "core", ',
            "sections.coated.regions[0].sections",
            "did you mean section",
        ),
        ("[-0.01, 0.001]", "[-0.01, 0.0]", "sections.coated.regions[1]", "overlaps region 1"),
        ("[-0.01, 0.001]", "[nan, 0.001]", "sections.coated.regions[1].points[0][0]", "finite"),
        ('origin = "given"', 'origin = "middle"', "sections.coated.origin", "shear_centre"),
        ("regions = [", "mesh_size = 1e-9\nregions = [", "sections.coated.mesh_size", "more than 50000"),
    ],
)
def test_what_is_wrong_in_a_case_file(old, new, where, text):
    assert old in CASE
    with pytest.raises(InputError, match=text) as caught:
        case_from_dict(tomllib.loads(CASE.replace(old, new)))
    assert [problem.where for problem in caught.value.problems] == [where]


LAW = material(1.0)
BOW = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]
HOLE = [(0.4, 0.4), (0.6, 0.4), (0.6, 0.6)]
BOX = Rectangle(1.0, 1.0)


@pytest.mark.parametrize(
    ("make", "where", "text"),
    [
        (
            lambda: PolygonSection([(0, 0), (1, 0)]),
            "PolygonSection.points",
            "at least 3 different corners, 2 were given",
        ),
        (lambda: PolygonSection([(0, 0), (1, 0), (0, 0)]), "PolygonSection.points", "2 were given"),
        (lambda: PolygonSection([(0, 0), (1, 0), (2, 0)]), "PolygonSection.points", "encloses no area"),
        (
            lambda: PolygonSection(BOW),
            "PolygonSection.points",
            r"crosses or touches itself near \(0\.5, 0\.5\)",
        ),
        (
            lambda: PolygonSection([(0, 0), (1, 0), (1, 0), (1, 1)]),
            "PolygonSection.points[2]",
            "twice in a row",
        ),
        (
            lambda: PolygonSection([(0, 0), (1, 0, 0), (1, 1)]),
            "PolygonSection.points[1]",
            "2 numbers are needed",
        ),
        (lambda: PolygonSection([(0, 0), (math.inf, 0), (1, 1)]), "PolygonSection.points[1][0]", "finite"),
        (lambda: PolygonSection([(0, 0), (1, 0), (1, 1e-7), (0, 1e-7)]), "PolygonSection.points", "too thin"),
        (lambda: PolygonSection(SQUARE, [SQUARE]), "PolygonSection.holes[0]", "does not lie inside"),
        (
            lambda: PolygonSection(SQUARE, [HOLE, [(0.5, 0.1), (0.55, 0.5), (0.5, 0.9)]]),
            "PolygonSection.holes[1]",
            "hole 1",
        ),
        (
            lambda: PolygonSection(SQUARE, [BOW]),
            "PolygonSection.holes[0]",
            "hole 1 crosses or touches itself",
        ),
        (lambda: PolygonSection(SQUARE, mesh_size=0.0), "PolygonSection.mesh_size", "> 0"),
        (
            lambda: PolygonSection(SQUARE, mesh_size=1e-4),
            "PolygonSection.mesh_size",
            "give a number above 0.0068",
        ),
        (lambda: PolygonSection(SQUARE, axes="main"), "PolygonSection.axes", "principal"),
        (lambda: PolygonSection.from_geometry(3), "", "one connected region"),
        (lambda: CompositeRegion(LAW), "CompositeRegion", "one outline"),
        (lambda: CompositeRegion(LAW, BOX, SQUARE), "CompositeRegion", "one outline"),
        (lambda: CompositeRegion(LAW, BOX, holes=[HOLE]), "CompositeRegion.holes", "points"),
        (
            lambda: CompositeRegion(LAW, SectionProperties(1, 1, 1, 1)),
            "CompositeRegion.section",
            "give one of Circle",
        ),
        (
            lambda: CompositeRegion(LAW, Rectangle(1, 1, torsion_constant=1.0)),
            "CompositeRegion.section",
            "mean nothing",
        ),
        (lambda: CompositeRegion(LAW, points=BOW), "CompositeRegion.points", "crosses"),
        (lambda: Composite([]), "Composite.regions", "at least one"),
        (lambda: Composite([3]), "Composite.regions[0]", "table"),
        (lambda: Composite([{"section": BOX}]), "Composite.regions[0].material", "required"),
        (
            lambda: Composite([CompositeRegion(LAW, BOX), CompositeRegion(LAW, BOX, at=(0.9, 0))]),
            "Composite.regions[1]",
            r"overlaps region 1 with 10 % of its area",
        ),
        (
            lambda: Composite([CompositeRegion(LAW, BOX), CompositeRegion(LAW, BOX, at=(1.1, 0))]),
            "Composite.regions",
            "2 separate parts",
        ),
        (
            lambda: Composite([CompositeRegion(LAW, BOX), CompositeRegion(LAW, BOX, at=(1.0, 1.0))]),
            "Composite.regions",
            "do not all join along edges",
        ),
        (
            lambda: Composite([CompositeRegion(LAW, SquareTube(1.0, 0.1)), CompositeRegion(LAW, BOX)]),
            "Composite.regions[1]",
            "overlaps",
        ),
    ],
)
def test_what_is_refused(make, where, text):
    with pytest.raises(InputError, match=text) as caught:
        make()
    (problem,) = caught.value.problems
    assert problem.where == where
    assert problem.instead


def test_without_the_library_the_command_that_installs_it_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "sectionproperties.pre", None)
    with pytest.raises(InputError, match=r"pip install 'viscorod\[sections\]'"):
        PolygonSection(SQUARE)


def test_damping_of_a_mode_is_refused_in_a_region():
    """Other regions take part in a mode: its ratio says nothing of one of them."""
    material = Material(1e9, 0.3, 1000.0, damping=MeasuredDamping(ratio=0.02))
    with pytest.raises(
        InputError, match=r"CompositeRegion.material.damping: .*cannot follow from a mode.*give times"
    ):
        CompositeRegion(material, Rectangle(0.02, 0.002))

"""Sections at stations along a rod, listed or from a file."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import viscorod as vr
from viscorod.model.sections.station_file import stiffness_from

GLASS = vr.Material(3.5e10, 0.3, 1900.0)
STIFF = {"EA": 6e8, "GA1": 9e7, "GA2": 8e7, "EI1": 1.8e5, "EI2": 4.5e6, "GJ": 6e4}
INERT = {"mass": 34.0, "J1": 0.01, "J2": 0.25}
HEAD = "s,EA,GA1,GA2,EI1,EI2,GJ\n"


def written(tmp_path, text: str) -> str:
    path = tmp_path / "blade.csv"
    path.write_text(text)
    return str(path)


def blade(section, **more) -> vr.Rod:
    return vr.Rod.straight((1, 0, 0), (11, 0, 0), section=section, **more)


def test_dimensions_of_a_file_are_those_of_a_taper(tmp_path):
    """The two rows are the ends of a taper, whose section is known at every station."""
    text = "distance (m), width (cm), height (mm)\n0, 30, 60\n10, 10, 15\n"
    read = blade(vr.Stations(file=written(tmp_path, text), shape="rectangle"), material=GLASS)
    taper = blade(vr.Taper(vr.Rectangle(0.30, 0.06), vr.Rectangle(0.10, 0.015)), material=GLASS)
    assert read.mass == pytest.approx(taper.mass, rel=1e-12)
    for s in (0.0, 3.3, 10.0):
        for one, other in zip(read.matrices_at(s), taper.matrices_at(s), strict=True):
            assert one == pytest.approx(other, rel=1e-12)


def test_stiffness_by_name_in_any_unit(tmp_path):
    """Against the same numbers in SI, and halfway between two stations their mean."""
    text = (
        "# glass\nSpan [m]\tmass [kg/m]\tEA [MN]\tGA1 [MN]\tGA2 [MN]\tEI1 [kN m^2]\tEI2 [MN m2]\tGJ [kN m^2]"
        "\tJ1 [kg m]\tJ2 [kg m]\ttwist [deg]\n"
        "0\t34\t600\t90\t80\t180\t4.5\t60\t0.01\t0.25\t12\n10\t34\t300\t90\t80\t180\t4.5\t60\t0.01\t0.25\t0\n"
    )
    rod = blade(vr.Stations(file=written(tmp_path, text)))
    stiffness, _, inertia = rod.matrices_at(0.0)
    expected = vr.StiffnessSection(STIFF, INERT).matrices()
    assert stiffness == pytest.approx(expected[0], rel=1e-12)
    assert inertia == pytest.approx(expected[2], rel=1e-12)
    assert rod.matrices_at(5.0)[0][2, 2] == pytest.approx(4.5e8, rel=1e-12)
    turned = blade(vr.StiffnessSection(STIFF, INERT), twist=-np.deg2rad(12.0)).frames([0.0, 2.5, 10.0])[1]
    about = rod.frames([0.0, 2.5, 10.0])[1]
    start = np.deg2rad(12.0)  # the blade begins with the angle that the other ends without
    expected_d1 = np.cos(start) * turned[:, :, 0] + np.sin(start) * turned[:, :, 1]
    assert about[:, :, 0] == pytest.approx(expected_d1, abs=1e-12)


def test_centres_off_the_line_are_those_of_a_section_moved_there():
    """An off-centre circle by finite elements over its area, against its own stiffness about its centre."""
    pytest.importorskip("sectionproperties")
    at = (0.03, -0.02)
    moved = vr.Composite([vr.CompositeRegion(GLASS, vr.Circle(0.05), at=at)], origin="given")
    stiffness, _, inertia = moved.matrices()
    about = stiffness_from(
        {"EA": stiffness[2, 2], "GA1": stiffness[0, 0], "GA2": stiffness[1, 1]}
        | {"EI1": GLASS.youngs_modulus * np.pi * 0.05**4 / 4, "EI2": GLASS.youngs_modulus * np.pi * 0.05**4 / 4}
        | {"GJ": GLASS.shear_modulus * np.pi * 0.05**4 / 2, "mass": inertia[0, 0]}
        | {"J1": GLASS.density * np.pi * 0.05**4 / 4, "J2": GLASS.density * np.pi * 0.05**4 / 4}
        | {f"{which} centre {axis}": at[axis - 1] for which in ("tension", "shear", "mass") for axis in (1, 2)}
    ).matrices()  # fmt: skip
    scale = np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))
    assert np.abs((about[0] - stiffness) / scale).max() < 3e-3  # of the mesh of the circle
    scale = np.sqrt(np.outer(np.diag(inertia), np.diag(inertia)))
    assert np.abs((about[2] - inertia) / scale).max() < 3e-3


def test_jumps_and_kinks_of_listed_stations():
    """A station given twice is a jump: the rod is the one in pieces."""
    thick, thin = vr.Circle(0.05), vr.Circle(0.02)
    stations = vr.Stations([(0, thick), (4, thick), (4, thin), (10, thin)])
    rod = blade(stations, material=GLASS)
    pieces = blade(vr.Piecewise([(4, thick), (10, thin)]), material=GLASS)
    assert rod.section_breaks == (4.0,)
    assert rod.mass == pytest.approx(pieces.mass, rel=1e-14)
    assert [rod.section_at(s) for s in (3.9, 4.0)] == [thick, thin]
    bent = vr.Stations([(0, thick, 0.1), (4, thick, 0.0), (10, thin, 0.0)])
    assert blade(bent, material=GLASS).kinks == (4.0,)


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        (HEAD + "0,1,1,1,1,1,1\n1,1,1,1,x,1,1\n", {}, "line 3 .* no number in column 5"),
        (HEAD + "0,1,1,1,1,1,1\n1,1,1,1,-1,1,1\n", {}, "-1: line 3, column EI1: it cannot be negative"),
        (HEAD + "0,1,1,1,1,1,1\n1,1,1,nan,1,1,1\n", {}, "line 3, column GA2: no finite number"),
        (HEAD.replace("GJ", "GK") + "0,1,1,1,1,1,1\n", {}, "'GK': column 7 is not known here"),
        (HEAD.replace("GJ", "GJ [N]") + "0,1,1,1,1,1,1\n", {}, "'N': the unit of column 7, GJ: this is a force"),
        (HEAD.replace("GJ", "EA") + "0,1,1,1,1,1,1\n", {}, "columns 2 and 7 are both EA"),
        (HEAD.replace(",GJ", "") + "0,1,1,1,1,1\n", {}, "GJ is missing"),
        (
            HEAD.replace(",GJ", ",mass") + "0,1,1,1,1,1,1\n",
            {},
            "GJ is missing(?s:.)*line 2: J1, J2 are missing; give mass, J1 and J2",
        ),
        (HEAD + "1,1,1,1,1,1,1\n2,1,1,1,1,1,1\n", {}, "line 2, column s: the first station must be the start"),
        (HEAD + "0,1,1,1,1,1,1\n2,1,1,1,1,1,1\n1,1,1,1,1,1,1\n", {}, "line 4, column s: each station must lie"),
        (HEAD + "0,1,1,1,1,1,1\n", {}, "all stations are at the start"),
        ("s,width,height\n0,1,2\n1,1,-2\n", {"shape": "rectangle"}, "-2.0: line 3, column height"),
        ("s,width\n0,1\n1,1\n", {"shape": "rectangle"}, "column height: this key is required and missing"),
        ("width,height\n1,2\n1,2\n", {"shape": "rectangle"}, "no column says where the stations are"),
        ("s,w,h\n0,1,2\n1,1,2\n", {"shape": "rectangle", "columns": {"s": 1, "wodth": 2}}, "did you mean 'width'"),
        ("s,w,h\n0,1,2\n1,1,2\n", {"shape": "rectangle", "columns": {"s": 4}}, "has 3 columns; give 1 to 3"),
        ("s,w,h\n0,1,2\n1,1,2\n", {"shape": "rectangel"}, "did you mean 'rectangle'"),
        ("s,width,height\n0,1,2\n1,1,2\n", {"shape": "rectangle", "times": [1] * 6}, "leave times out"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_by_line_and_column(tmp_path, text, given, message):
    with pytest.raises(vr.InputError, match=message):
        vr.Stations(file=written(tmp_path, text), **given)


def test_stations_that_do_not_fit_are_refused():
    with pytest.raises(vr.InputError, match=r"Stations.stations\[1\].*two sections of the same shape"):
        vr.Stations([(0, vr.Circle(0.1)), (1, vr.Rectangle(1, 1))])
    with pytest.raises(vr.InputError, match="let the stations end at 10 m"):
        blade(vr.Stations([(0, vr.Circle(0.1)), (9, vr.Circle(0.1))]), material=GLASS)
    twisted = vr.Stations([(0, vr.Circle(0.1), 0.2), (10, vr.Circle(0.1), 0.0)])
    with pytest.raises(vr.InputError, match="the twist is given twice"):
        blade(twisted, material=GLASS, twist=0.3)
    with pytest.raises(vr.InputError, match="it is given at some stations only"):
        vr.Stations([(0, vr.Circle(0.1), 0.2), (10, vr.Circle(0.1))])
    with pytest.raises(vr.InputError, match="give stations, or file"):
        vr.Stations()


CASE = """
[materials.glass]
youngs_modulus = "35 GPa"
poissons_ratio = 0.3
density = 1900.0

[rods.blade]
shape = "straight"
start = [1.0, 0.0, 0.0]
end = [11.0, 0.0, 0.0]
material = "glass"
elements = 6
order = 4
sections = { file = "blade.csv", shape = "rectangle", columns = { s = "r", width = 3, height = 2, twist = "beta" } }

[[supports]]
kind = "clamp"
at = "blade.start"

[[loads]]
kind = "force"
at = "blade.end"
value = [0.0, 0.0, 1.0]

[equilibrium]
"""


def test_a_result_holds_the_numbers_and_not_the_file(tmp_path):
    """The table beside the case is removed; copies, results and stresses, known in closed form, go on."""
    table = tmp_path / "blade.csv"
    table.write_text("r [m]; t [mm]; b [mm]; beta [deg]; note\n0; 60; 300; 0; 7\n10; 20; 100; 0; 7\n")
    (tmp_path / "case.toml").write_text(CASE)
    case = vr.load_case(tmp_path / "case.toml")
    model = case.model(vr.Model)
    copies = [copy.deepcopy(model.rods["blade"]), pickle.loads(pickle.dumps(model.rods["blade"]))]
    table.unlink()
    for one in copies:
        assert one.matrices_at(5.0)[0] == pytest.approx(model.rods["blade"].matrices_at(5.0)[0])
    found = model.equilibrium()
    found.save(tmp_path / "found.nc")
    stress = vr.load(tmp_path / "found.nc").stress("blade.start", (0.0, -0.03)).stress
    expected = 1.0 * 10.0 / (0.3 * 0.06**2 / 6.0)
    assert abs(float(stress.sel(stress_component="33").squeeze())) == pytest.approx(expected, rel=1e-4)
    (tmp_path / "again.toml").write_text(model.to_toml())
    assert vr.load_case(tmp_path / "again.toml").model(vr.Model).equilibrium().data.equals(found.data)

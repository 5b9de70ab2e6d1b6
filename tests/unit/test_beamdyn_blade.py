"""BeamDyn blade files and GXBeam-style beams: read, made into rods, written, read again."""

import json
import math

import numpy as np
import pytest

import viscorod as vr
from helpers.blade_files import HEAD, MODAL, MU, PRIMARY, assembly, blade_text, matrices
from viscorod import programs as vd
from viscorod.casefile.case import parse_case
from viscorod.errors import InputError
from viscorod.programs.blades.beamdyn_line import beamdyn_axis
from viscorod.programs.blades.blade_rod import BladeSections


@pytest.fixture
def blade_file(tmp_path):
    path = tmp_path / "blade.dat"
    path.write_text(blade_text())
    return path


@pytest.fixture
def primary(tmp_path):
    path = tmp_path / "primary.dat"
    path.write_text(PRIMARY)
    return path


@pytest.mark.parametrize("modal", ["", MODAL])
def test_both_formats_are_read(tmp_path, modal):
    path = tmp_path / "blade.inp"
    path.write_text(blade_text(modal=modal))
    blade = vd.read_beamdyn_blade(path)
    assert blade.stations == pytest.approx([0.0, 0.4, 1.0])
    assert blade.mu == pytest.approx(MU)
    assert blade.title == "A short blade with couplings"
    for k in range(3):
        stiffness, inertia = matrices(k)
        assert blade.stiffness[k] == pytest.approx(stiffness, rel=1e-6)
        assert blade.inertia[k] == pytest.approx(inertia, rel=1e-6)


@pytest.mark.parametrize("modal", [False, True])
def test_writing_and_reading_gives_the_same_numbers(tmp_path, blade_file, modal):
    blade = vd.read_beamdyn_blade(blade_file)
    again = vd.read_beamdyn_blade(vd.write_beamdyn_blade_file(blade, tmp_path / "b.dat", modal_section=modal))
    for name in ("stations", "stiffness", "inertia", "mu"):
        assert (getattr(again, name) == getattr(blade, name)).all()
    assert again.title == blade.title


def test_rod_round_trip_to_round_off(tmp_path, blade_file, primary):
    blade = vd.read_beamdyn_blade(blade_file)
    rod = vd.rod_from_blade(blade_file, primary)
    losses = vd.write_beamdyn_blade(rod, tmp_path / "again.dat")
    again = vd.read_beamdyn_blade(tmp_path / "again.dat")
    assert again.stations == pytest.approx(blade.stations, abs=0.0)
    assert again.mu == pytest.approx(blade.mu, rel=1e-14)
    for name in ("stiffness", "inertia"):
        here, there = getattr(blade, name), getattr(again, name)
        assert there == pytest.approx(here, rel=1e-14, abs=1e-14 * float(np.abs(here).max()))
    assert len(losses) == 1
    assert "the product of these times with a stiffness can create energy, but not with this one" in losses[0]
    # the line: key points and twist at the arc lengths of the key points
    line = vd.ReferenceLine.read(primary)
    table = vd.key_points(rod, line.arc_lengths() / rod.length)
    assert table[:, :3] == pytest.approx(line.points, abs=1e-9)
    assert table[:, 3] == pytest.approx(line.initial_twist, abs=1e-7)


def test_sections_are_linear_between_stations_and_the_damping_too(blade_file):
    rod = vd.rod_from_blade(blade_file, [[0, 0, 0], [0, 0, 10.0]])
    (first, inertia_1), (second, inertia_2) = matrices(0), matrices(1)
    stiffness, damping, inertia = rod.matrices_at(1.0)  # a quarter of the way to station 0.4
    assert stiffness == pytest.approx(0.75 * first + 0.25 * second, rel=1e-6)
    assert inertia == pytest.approx(0.75 * inertia_1 + 0.25 * inertia_2, rel=1e-6)
    assert damping == pytest.approx(vd.symmetric_damping(stiffness, MU), rel=1e-12)


def test_straight_blade_frames_are_beamdyns(blade_file):
    """Initial twist about the negative tangent: 90 degrees turn x into -y (input_files.rst)."""
    rod = vd.rod_from_blade(blade_file, [[0, 0, 0, 90.0], [0, 0, 10.0, 0.0]])
    _, frames = rod.frames([0.0, 5.0, 10.0])
    assert frames[0] == pytest.approx(np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]]), abs=1e-12)
    middle = math.sqrt(0.5)
    assert frames[1][:, 0] == pytest.approx([middle, -middle, 0.0], abs=1e-12)
    assert frames[2] == pytest.approx(np.eye(3), abs=1e-12)


def test_curved_blade_frames_are_beamdyns(blade_file, primary):
    """e1 across the tangent without a y part, e2 = e3 x e1, both turned by minus the twist (BeamDyn_Subs.f90)."""
    rod = vd.rod_from_blade(blade_file, primary)
    line = vd.ReferenceLine.read(primary)
    positions, frames = rod.frames(line.arc_lengths())
    assert positions == pytest.approx(line.points, abs=1e-9)
    for frame, twist in zip(frames, line.initial_twist, strict=True):
        e3 = frame[:, 2]
        e1 = np.array([math.sqrt(1.0 - e3[0] ** 2 / (e3[0] ** 2 + e3[2] ** 2)), 0.0, 0.0])
        e1[2] = -e3[0] / math.hypot(e3[0], e3[2])
        e2 = np.cross(e3, e1)
        phi = -math.radians(twist)
        assert frame[:, 0] == pytest.approx(math.cos(phi) * e1 + math.sin(phi) * e2, abs=1e-9)


def test_local_components_have_viscorods_signs(blade_file):
    """Off-centre mass, m Ycm in row 3, column 4: the momentum along z of a body turning about x."""
    _, inertia = vd.read_beamdyn_blade(blade_file).at(0.0)
    mass, centre = 300.0, np.array([-0.1, 0.05, 0.0])
    spin = np.array([0.3, -0.2, 0.7])
    assert (inertia @ np.concatenate([np.zeros(3), spin]))[:3] == pytest.approx(
        mass * np.cross(spin, centre), rel=1e-5
    )


def test_same_power_takes_beamdyns_power(blade_file):
    rod = vd.rod_from_blade(blade_file, [[0, 0, 0], [0, 0, 10.0]], law="same power")
    stiffness, damping, _ = rod.matrices_at(4.0)
    product = np.array(MU)[:, None] * stiffness
    for rate in np.random.default_rng(0).normal(size=(50, 6)):
        assert rate @ damping @ rate == pytest.approx(rate @ product @ rate, rel=1e-9)
    sections = rod.section
    assert isinstance(sections, BladeSections)
    assert 0.0 < sections.difference() < 0.2


def test_a_product_that_creates_energy_is_refused_and_the_symmetric_law_is_not(tmp_path):
    text = blade_text(HEAD.replace("1.4D-03     0.0018", "1.0E-06     1.0E+00"))
    (tmp_path / "b.dat").write_text(text)
    line = [[0, 0, 0], [0, 0, 10.0]]
    with pytest.raises(
        InputError, match=r"station 1 \(eta = 0\), mu: the product of these times .* creates energy"
    ) as caught:
        vd.rod_from_blade(tmp_path / "b.dat", line, law="same power")
    assert "stretch and bend_1" in str(caught.value)
    rod = vd.rod_from_blade(tmp_path / "b.dat", line)
    damping = rod.matrices_at(3.0)[1]
    scale = np.sqrt(np.diag(damping))
    assert np.linalg.eigvalsh(damping / scale[:, None] / scale[None, :])[0] > 0.0
    assert vd.read_beamdyn_blade(tmp_path / "b.dat").checks()[0].creates_energy
    assert "creates energy in some motions" in vd.blade_from_rod(rod)[1][0]


def test_undamped_blades(tmp_path):
    (tmp_path / "b.dat").write_text(blade_text(HEAD.replace("1      damp_type", "0      damp_type")))
    rod = vd.rod_from_blade(tmp_path / "b.dat", [[0, 0, 0], [0, 0, 10.0]])
    assert not rod.matrices_at(3.0)[1].any()
    assert rod.section.difference() == 0.0
    blade, losses = vd.blade_from_rod(rod)
    assert (blade.damp_type, losses) == (0, ())


def test_any_rod_becomes_a_blade(tmp_path):
    material = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.03))
    thin, thick = vr.Rectangle(0.01, 0.02), vr.Rectangle(0.02, 0.03)
    rod = vr.Rod.straight(
        (0, 0, 0), (0, 0, 1), section=vr.Taper(thick, thin), material=material, d1=(1, 0, 0)
    )
    assert vd.write_beamdyn_blade(rod, tmp_path / "b.dat", [0.0, 0.5, 1.0]) == ()
    blade = vd.read_beamdyn_blade(tmp_path / "b.dat")
    assert blade.mu == pytest.approx([0.02, 0.02] + [material.extensional_time] * 3 + [0.02], rel=1e-12)
    assert blade.stiffness[1] == pytest.approx(rod.matrices_at(0.5)[0], rel=1e-12)
    assert vd.key_points(rod, [0.0, 1.0]) == pytest.approx(
        np.array([[0, 0, 0, 0], [0, 0, 1, 0.0]]), abs=1e-12
    )
    assert len(vd.blade_from_rod(rod)[0].stations) == 11


def test_key_points_of_a_rod_in_another_direction_are_those_of_the_turned_rod():
    """Of the same arc, started along +Z and along +X: 80 degrees of a circle, from its root on."""
    steel = vr.Material(2e11, 0.3, 7850.0)
    given = {"section": vr.Rectangle(0.01, 0.02), "material": steel, "twist": 0.4}
    upright = vr.Rod.arc((0, 0, 0), (0, 0, 1), (1, 0, 0), 2.0, np.deg2rad(80), d1=(1, 0, 0), **given)
    lying = vr.Rod.arc((3, 4, 5), (1, 0, 0), (0, 1, 0), 2.0, np.deg2rad(80), d1=(0, 1, 0), **given)
    stations = [0.0, 0.5, 1.0]
    assert vd.key_points(lying, stations) == pytest.approx(vd.key_points(upright, stations), abs=1e-12)
    assert vd.key_points(upright, stations)[-1, [0, 2]] == pytest.approx(
        [2.0 * (1.0 - np.cos(np.deg2rad(80))), 2.0 * np.sin(np.deg2rad(80))], rel=1e-12
    )


def test_times_that_change_along_a_rod_are_told():
    def section(s):
        return vr.StiffnessSection([1.0] * 6, [1.0] * 6, [0.01 * (1.0 + s)] * 6)

    rod = vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section)
    blade, losses = vd.blade_from_rod(rod, [0.0, 1.0])
    assert blade.mu == pytest.approx([0.015] * 6)
    assert "differ from their mean by up to 0.005 s" in losses[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("3      station_total", "x      station_total"), "line 4: 'x      station_total"),
        (("3      station_total", "3.5    station_total"), "line 4: 3.5: station_total is a whole number"),
        (("3      station_total", "4      station_total"), "the end of the file: the position of station 4"),
        (("1      damp_type", "5      damp_type"), "line 5: 5: damp_type is 0, 1 or 2"),
        (("1.0E-03 ", "-1.0E-03 "), "line 9: -0.001: a damping coefficient must not be negative"),
        (("  1.000000\n", "  0.900000\n"), "stations from 0 to 0.9: they must rise from 0 to 1"),
        (("  2.000000E+08", "  3.000000E+08"), "300000000.0 against 200000000.0 in rows 3 and 4"),
        (("  0.400000\n", "  0.000000\n"), "station 2 (eta = 0) after eta = 0: they must rise from 0 to 1"),
        (
            ("  1.000000\n", "  1.0  1.0\n"),
            "the position of station 3 is expected here, and the line has more",
        ),
    ],
)
def test_wrong_files_are_refused_with_their_line(tmp_path, change, message):
    path = tmp_path / "b.dat"
    path.write_text(blade_text().replace(*change, 1))
    with pytest.raises(InputError) as caught:
        vd.read_beamdyn_blade(path)
    text = str(caught.value)
    assert message in text
    assert str(path) in text


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ([[0, 0, 0]], "the reference line needs key points"),
        ("nowhere.dat", "the file cannot be read"),
        ([[0, 0, 0], [0, 0, -1.0]], r"a tangent along \(0, 0, -1\): BeamDyn"),
        ([[0, 0, 0], [0, 1.0, 0]], r"a tangent along \(0, 1, 0\)"),
    ],
)
def test_wrong_lines_are_refused(blade_file, line, message):
    with pytest.raises(InputError, match=message):
        vd.rod_from_blade(blade_file, line)


def test_other_refusals(tmp_path, blade_file, primary):
    with pytest.raises(InputError, match="there is no such law"):
        vd.rod_from_blade(blade_file, primary, law="other")
    with pytest.raises(InputError, match="there is no line with member_total"):
        vd.ReferenceLine.read(blade_file)
    primary.write_text(PRIMARY.replace("1   member_total", "2   member_total"))
    with pytest.raises(InputError, match="only one member is read"):
        vd.rod_from_blade(blade_file, primary)
    (tmp_path / "modal.dat").write_text(
        blade_text(HEAD.replace("1      damp_type", "2      damp_type"), MODAL)
    )
    with pytest.raises(InputError, match="modal damping belongs to modes, not to sections"):
        vd.rod_from_blade(tmp_path / "modal.dat", [[0, 0, 0], [0, 0, 1]])
    rod = vd.rod_from_blade(blade_file, [[0, 0, 0], [0, 0, 1]])
    with pytest.raises(InputError, match="they must rise from 0 to 1"):
        vd.blade_from_rod(rod, [0.0, 0.5])
    with pytest.raises(InputError, match="cannot be written"):
        vd.write_beamdyn_blade(rod, blade_file / "b.dat")  # a file is no folder
    (tmp_path / "zero.dat").write_text(blade_text().replace("  1.100000E+09", "  0.000000E+00", 1))
    with pytest.raises(InputError, match=r"station 1 \(eta = 0\), StiffnessSection"):
        vd.rod_from_blade(tmp_path / "zero.dat", [[0, 0, 0], [0, 0, 1]])


def test_axis_of_an_upright_tangent():
    assert beamdyn_axis(np.array([0.0, 0.0, 1.0]), 0.0) == pytest.approx([1.0, 0.0, 0.0])
    assert beamdyn_axis(np.array([0.0, 0.0, 1.0]), math.pi / 2) == pytest.approx([0.0, 1.0, 0.0])


@pytest.mark.parametrize("curved", [False, True])
def test_a_blade_as_a_case_file(blade_file, primary, curved):
    """Pieces have the matrices of the blade at their middle, seen from the same directions in space."""
    blade = vd.rod_from_blade(
        blade_file, primary if curved else [[0, 0, 0, 13.0], [0, 0, 5, 4.0], [0, 0, 10, 0.0]]
    )
    case = parse_case(vd.case_text(blade, 20, title="a blade"))
    assert case.title == "a blade"
    rod = case.description.rods["blade"]
    assert rod.length == pytest.approx(blade.length, rel=1e-6)
    for s in (0.025, 0.475, 0.975):
        _, (here,) = blade.frames([s * blade.length])
        _, (there,) = rod.frames([s * rod.length])
        turns = [np.kron(np.eye(2), frame) for frame in (here, there)]
        pairs = zip(blade.matrices_at(s * blade.length), rod.matrices_at(s * rod.length), strict=True)
        for ours, theirs in pairs:
            size = float(np.diag(ours).max())
            difference = turns[0] @ ours @ turns[0].T - turns[1] @ theirs @ turns[1].T
            assert np.abs(difference).max() < (1e-4 if curved else 1e-12) * size


def test_a_maxwell_rod_is_refused():
    """Also where only a part of it, away from its start, has branches."""
    elastic = vr.StiffnessSection([1.0] * 6, [1.0] * 6)
    branched = vr.StiffnessSection([1.0] * 6, [1.0] * 6, branches=[{"time": 0.1, "stiffness": [1.0] * 6}])
    for section in (branched, vr.Piecewise([(0.5, elastic), (1.0, branched)])):
        rod = vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section)
        for call in (vd.case_text, vd.blade_from_rod, lambda r: vd.gxbeam_from_rod(r, 4)):
            with pytest.raises(InputError, match="Maxwell branches"):
                call(rod)


# ---- GXBeam-style descriptions


def test_a_gxbeam_beam_in_viscorods_order():
    rod = vd.rod_from_gxbeam(assembly())
    stiffness, damping, inertia = rod.matrices_at(0.5)
    expected, mass = matrices(0)
    assert stiffness == pytest.approx(expected, rel=1e-12)
    assert inertia == pytest.approx(mass, rel=1e-12)
    assert damping == pytest.approx(
        vd.symmetric_damping(expected, [0.02, 0.03, 0.01, 0.05, 0.06, 0.04]), rel=1e-12
    )
    _, (frame, *_) = rod.frames([0.0])
    assert frame == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0.0]]), abs=1e-12)
    compliance = np.linalg.inv(np.array(assembly()["stiffness"])).tolist()
    other = vd.rod_from_gxbeam(assembly(stiffness=None, compliance=compliance))
    assert other.matrices_at(0.5)[0] == pytest.approx(expected, rel=1e-6, abs=1.0)


def test_frames_turned_about_the_beam_change_nothing_but_the_numbers():
    """The same beam with the second element's axes turned by 30 degrees, and its matrices accordingly."""
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    six = np.kron(np.eye(2), turned)
    base = assembly(damping=[0.02] * 6)
    stiffness, mass = (np.array(base[key]) for key in ("stiffness", "mass"))
    rod = vd.rod_from_gxbeam(
        base
        | {
            "frames": [np.eye(3).tolist(), turned.tolist()],
            "stiffness": [stiffness.tolist(), (six.T @ stiffness @ six).tolist()],
            "mass": [mass.tolist(), (six.T @ mass @ six).tolist()],
        }
    )
    for here, there in zip(rod.matrices_at(0.5), rod.matrices_at(1.5), strict=True):
        assert here == pytest.approx(there, rel=1e-9, abs=1e-9 * float(np.abs(here).max()))


@pytest.mark.parametrize("suffix", [".json", ".toml"])
def test_gxbeam_files_and_round_trip(tmp_path, suffix):
    path = tmp_path / f"beam{suffix}"
    data = assembly()
    path.write_text(
        json.dumps(data)
        if suffix == ".json"
        else "\n".join(f"{key} = {json.dumps(value)}" for key, value in data.items())
    )
    rod = vd.rod_from_gxbeam(path)
    again = vd.rod_from_gxbeam(vd.gxbeam_from_rod(rod, 2))
    for here, there in zip(rod.matrices_at(1.7), again.matrices_at(1.7), strict=True):
        assert here == pytest.approx(there, rel=1e-12, abs=1e-12 * float(np.abs(here).max()))


def test_a_curved_gxbeam_beam():
    angles = np.linspace(0.0, 0.5, 6)
    points = np.array([np.sin(angles), 1.0 - np.cos(angles), 0.0 * angles]).T
    middle = (angles[1:] + angles[:-1]) / 2.0
    frames = [[[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]] for a in middle]
    rod = vd.rod_from_gxbeam(assembly(points=points.tolist(), frames=frames))
    assert rod.length == pytest.approx(0.5, rel=1e-5)
    again = vd.rod_from_gxbeam(vd.gxbeam_from_rod(rod, 5))
    assert again.matrices_at(0.25)[0] == pytest.approx(matrices(0)[0], rel=1e-6, abs=1e3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"points": None}, "points: this key is required and missing"),
        ({"points": [[0, 0, 0]]}, "points: 1 points: an element has two ends"),
        ({"colour": 1}, "colour: no such key; the keys are points"),
        ({"stiffness": None}, "stiffness: exactly one of stiffness and compliance"),
        ({"mass": [1.0, 2.0]}, "mass: an array of the shape"),
        ({"mass": [np.eye(6).tolist()] * 3}, "mass: 3 items: there are 2 elements"),
        ({"damping": [-0.1] + [0.1] * 5}, r"damping[0][2]: -0.1: a retardation time"),
        ({"frames": (2.0 * np.eye(3)).tolist()}, "frames[0]: this is not a rotation matrix"),
        ({"points": [[0, 0, 0], [0, 0, 1]]}, "frames[0]: 90 degrees off the beam"),
        ({"stiffness": None, "compliance": np.zeros((6, 6)).tolist()}, "compliance: it has no inverse"),
        ({"stiffness": np.diag([1.0, 1, 1, 1, 1, -1]).tolist()}, "element 1.StiffnessSection.stiffness"),
    ],
)
def test_wrong_descriptions(changes, message):
    with pytest.raises(InputError) as caught:
        vd.rod_from_gxbeam(assembly(**changes))
    assert message in str(caught.value)


def test_wrong_description_files(tmp_path):
    with pytest.raises(InputError, match="the file cannot be read"):
        vd.rod_from_gxbeam(tmp_path / "no.json")
    (tmp_path / "bad.json").write_text("{")
    with pytest.raises(InputError, match="neither TOML nor JSON"):
        vd.rod_from_gxbeam(tmp_path / "bad.json")
    (tmp_path / "list.json").write_text("[1]")
    with pytest.raises(InputError, match="a table of keys is needed"):
        vd.rod_from_gxbeam(tmp_path / "list.json")


def blade_with(matrix_of, tmp_path):
    """Return a file of two stations, whose matrices `matrix_of` gives by station, as rows of nine digits."""
    text = (
        "----\nsmall\n----\n2 station_total\n1 damp_type\n----\nmu1 ... mu6\n(s)\n" + "0.01 " * 6 + "\n----\n"
    )
    for k in (0, 1):
        text += f"{k:.1f}\n"
        for matrix in matrix_of(k):
            text += "\n".join(" ".join(f"{x:.8e}" for x in row) for row in matrix) + "\n\n"
    path = tmp_path / "small.dat"
    path.write_text(text)
    return path


def test_round_off_beside_the_diagonal_is_no_asymmetry(tmp_path):
    """K12 = 0.28133 and K21 = 0.28135 beside 2.4e9 N, as section codes leave: the symmetric part is taken."""
    stiffness = np.array([
        [2.4e9, 0.28133, 0, 0, 0, -7e2], [0.28135, 2.4e9, 0, 0, 0, 0.03], [0, 0, 1.1e10, 1.2e3, 0, 0],
        [0, 0, 1.2e3, 9e9, 0, 0], [0, 0, 0, 0, 9e9, 0], [-7e2, 0.03, 0, 0, 0, 7.8e9],
    ])  # fmt: skip
    inertia = np.diag([960.0] * 3 + [1632.0] * 3)
    path = blade_with(lambda k: (stiffness, inertia), tmp_path)
    assert vd.read_beamdyn_blade(path).stiffness[0][0, 1] == pytest.approx(0.28134, rel=1e-7)
    rod = vd.rod_from_blade(path, [(0, 0, 0), (0, 0, 30), (0, 0, 60)])
    assert rod.mass == pytest.approx(57600.0, rel=1e-12)
    stiffness[0, 1] = 2.4e4  # a hundred-thousandth of the diagonal, and one triangle only: no round-off
    with pytest.raises(
        InputError, match=r"24000.0 against 0.28135 in rows 1 and 2: the stiffness of station 1"
    ):
        vd.read_beamdyn_blade(blade_with(lambda k: (stiffness, inertia), tmp_path))


def test_the_station_that_is_wrong_is_counted_from_one(tmp_path):
    good = np.diag([1.2, 1.2, 1.2, 0.1, 0.1, 0.2])
    bad = good.copy()
    bad[1, 5] = bad[5, 1] = -0.6
    bad[2, 4] = bad[4, 2] = 0.6
    stiffness = np.diag([1.8e8, 1.8e8, 2e7, 1.5e4, 1.5e4, 8e4])
    path = blade_with(lambda k: (stiffness, bad if k else good), tmp_path)
    with pytest.raises(
        InputError, match=r"^station 2 \(eta = 1\), StiffnessSection.inertia: an eigenvalue of -0.732"
    ):
        vd.rod_from_blade(path, [(0, 0, 0), (0, 0, 5), (0, 0, 10)])


def test_files_as_other_systems_write_them(tmp_path):
    plain = vd.read_beamdyn_blade(blade_with(matrices, tmp_path))
    text = (tmp_path / "small.dat").read_text()
    changed = (
        text.replace("\n", " ! a remark\n").replace(" ! a remark\n ! a remark\n", "\n\n").replace(" ", "\t")
    )
    changed = changed.replace("e+", "D+").replace("e-", "D-").replace("\n", "\r\n")
    (tmp_path / "small.dat").write_bytes(b"\xef\xbb\xbf" + changed.encode())
    again = vd.read_beamdyn_blade(tmp_path / "small.dat")
    for name in ("stations", "stiffness", "inertia", "mu"):
        assert getattr(again, name) == pytest.approx(getattr(plain, name), rel=0.0, abs=0.0)


def test_a_beam_of_unsymmetric_matrices_is_refused():
    data = assembly()
    key = "stiffness" if "stiffness" in data else "compliance"
    skew = np.array(data[key], dtype=float)
    skew = np.array(np.broadcast_to(skew, (len(data["points"]) - 1, 6, 6)))
    skew[1, 0, 3] += 0.1 * skew[1, 0, 0]
    with pytest.raises(
        InputError, match=rf"{key} of element 2: .* rows 1 and 4: the matrix must be symmetric"
    ):
        vd.rod_from_gxbeam(data | {key: skew})

"""Tables and files for ParaView, read back and compared with motions in closed form."""

import csv
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.paraview_files import states_of
from helpers.rigid_motions import LENGTH, along, director, rigid, tumbling, with_body
from helpers.synthetic_results import LENGTH as ARC
from helpers.synthetic_results import rolled_up, swing
from viscorod.cli.app import app
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.files import csv_text
from viscorod.results.run import Run


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("saved")
    Run(rigid(0.02)).save(folder / "run.nc")
    Equilibrium(rolled_up()).save(folder / "arc.nc")
    return folder


@pytest.fixture
def files(saved, tmp_path):
    """A tumbling rod and an arc on disk."""
    return Path(shutil.copytree(saved, tmp_path, dirs_exist_ok=True))


def invoke(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def table(text):
    rows = list(csv.reader(text.splitlines()))
    return {
        head: np.array([float(row[k]) for row in rows[1:]])
        for k, head in enumerate(rows[0])
        if head != "place"
    }


def test_probe_prints_a_table(files):
    result = invoke("probe", files / "run.nc", "rod.end", "rod@0.3", "--times", "0:2:0.25")
    assert result.exit_code == 0, result.output
    columns = table(result.stdout)
    assert columns["time [s]"] == pytest.approx(np.repeat(np.arange(9) / 4, 2))
    assert columns["s [m]"] == pytest.approx(np.tile([LENGTH, 0.3], 9))
    d3, rate = director(columns["time [s]"])
    _, body, _ = tumbling(columns["time [s]"])
    for k, axis in enumerate("xyz"):
        assert columns[f"position {axis} [m]"] == pytest.approx(d3[:, k] * columns["s [m]"], abs=1e-6)
        assert columns[f"velocity {axis} [m/s]"] == pytest.approx(rate[:, k] * columns["s [m]"], abs=1e-5)
        assert columns[f"d3 {axis} [1]"] == pytest.approx(d3[:, k], abs=1e-6)
        assert columns[f"angular velocity d{k + 1} [rad/s]"] == pytest.approx(body[:, k], abs=1e-5)
    expected = np.cos(3.0 * columns["time [s]"]) * along(columns["s [m]"])[0]
    assert columns["section force 3 [N]"] == pytest.approx(expected, abs=1e-4)
    assert list(columns)[-1] == "dissipation [W/m]"


def test_probe_along_a_rod_goes_to_a_file(files):
    result = invoke(
        "probe", files / "run.nc", "rod", "--s", "0,0.25,0.8", "--times", "1.5", "-o", files / "new" / "a.csv"
    )
    assert result.exit_code == 0, result.output
    columns = table((files / "new" / "a.csv").read_text())
    d3, _ = director(np.array([1.5]))
    assert columns["position z [m]"] == pytest.approx([0.0, 0.25 * d3[0, 2], 0.8 * d3[0, 2]], abs=1e-6)


def test_probe_of_an_equilibrium(files):
    columns = table(invoke("probe", files / "arc.nc", "beam.end").stdout)
    assert columns["load_factor [1]"] == pytest.approx([0.25, 0.5, 0.75, 1.0])
    assert columns["position x [m]"][-1] == pytest.approx(ARC / (0.5 * np.pi))


def test_histories_have_units_and_all_digits(tmp_path):
    run = Run(swing())
    path = csv_text.write(
        csv_text.history_columns(run, ["beam.end", "beam@0.1"], ["velocity", "displacement"])
        | csv_text.energy_columns(run),
        tmp_path / "a" / "tip.csv",
    )
    columns = table(path.read_text())
    assert list(columns)[:4] == [
        "time [s]",
        "beam.end velocity x [m/s]",
        "beam.end velocity y [m/s]",
        "beam.end velocity z [m/s]",
    ]
    assert np.array_equal(columns["time [s]"], run.time)
    exact = run.history("beam.end", "velocity").sel(axis="y").values
    assert np.array_equal(columns["beam.end velocity y [m/s]"], exact)
    assert np.array_equal(columns["viscous [J]"], run.data["viscous"].values)


def test_joints_in_a_table(files):
    data = rigid(0.1)
    count = data.sizes["time"]
    values = np.arange(2.0 * count).reshape(count, 2)
    data = data.assign(
        {
            f"joint_{k}": (("time", "joint_coordinate"), f * values)
            for k, f in (("value", 1), ("rate", 2), ("force", 3))
        }
    ).assign_coords(
        joint=("joint_coordinate", ["hub", "hub"]),
        joint_motion=("joint_coordinate", ["rz", "ux"]),
        joint_held=("joint_coordinate", [False, True]),
    )
    Run(data).save(files / "joined.nc")
    done = invoke("export", files / "joined.nc", "--csv", files / "j.csv", "--joint", "hub")
    assert done.exit_code == 0, done.output
    columns = table((files / "j.csv").read_text())
    assert columns["hub rz value [rad]"] == pytest.approx(values[:, 0])
    assert columns["hub ux force [N]"] == pytest.approx(3.0 * values[:, 1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["export", "run.nc"], "nothing to write"),
        (["export", "run.nc", "--csv", "a.csv"], "add --history PLACE, --energy or --joint NAME"),
        (["export", "run.nc", "--csv", "a.csv", "--quantity", "strain"], "no place is named"),
        (["export", "run.nc", "--vtk", "v", "--energy"], "go with --csv"),
        (["export", "run.nc", "--csv", "a.csv", "--energy", "--times", "1"], "goes with --vtk only"),
        (["export", "run.nc", "--csv", "a.csv", "--energy", "--sections"], "goes with --vtk only"),
        (
            ["export", "run.nc", "--csv", "a.csv", "--history", "rod.end", "--quantity", "speed"],
            "quantity = 'speed'",
        ),
        (["export", "run.nc", "--csv", "a.csv", "--joint", "hub"], "this result has no joints"),
        (["probe", "run.nc", "rod.end", "--times", "0:1"], "--times: 0:1: these are not numbers in s"),
        (["probe", "run.nc", "rod.end", "--times", "0:1:0"], "these are not numbers in s"),
        (["probe", "run.nc", "rod.end", "--times", "nan"], "these are not numbers in s"),
        (["probe", "run.nc", "rod.end", "rod.start", "--s", "0.1"], "arc lengths go with one rod"),
        (["probe", "arc.nc", "beam.end", "--times", "0.5"], "holds no motion over time"),
        (["export", "arc.nc", "--vtk", "v", "--times", "0.5"], "holds no motion over time"),
        (["probe", "none.nc", "rod.end"], "is not a file"),
    ],
)
def test_wrong_commands(files, monkeypatch, arguments, message):
    monkeypatch.chdir(files)
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.output


@pytest.fixture
def states():
    return states_of


def test_round_trip_of_a_motion(states, files):
    result = invoke("export", files / "run.nc", "--vtk", files / "v.vtkhdf", "--times", "0:2:0.4")
    assert result.exit_code == 0, result.output
    times, state = states(files / "v.vtkhdf")
    assert times == pytest.approx([0.0, 0.4, 0.8, 1.2, 1.6, 2.0])
    for number, time in enumerate(times):
        (mesh,) = state(number).values()
        q, _, spin = tumbling(np.array([time]))
        s = mesh["radius"] / 0.005 - 2.0  # the rod is 0.01 + 0.005 s thick
        frame = matrices(q)[0]
        assert s[[0, -1]] == pytest.approx([0.0, LENGTH], abs=1e-12)
        assert np.all(np.diff(s) > 0.0)
        assert mesh.points == pytest.approx(s[:, None] * frame[:, 2], abs=1e-6)
        assert mesh["velocity"] == pytest.approx(np.cross(spin, mesh.points), abs=1e-5)
        for k in range(3):
            assert mesh[f"d{k + 1}"] == pytest.approx(np.tile(frame[:, k], (s.size, 1)), abs=1e-6)
        force = np.cos(3.0 * time) * along(s)[0]
        assert mesh["section_force"] == pytest.approx(force[:, None] * np.array([0, 0, 1.0]), abs=1e-4)
        assert mesh["section_force_global"] == pytest.approx(force[:, None] * frame[:, 2], abs=1e-4)
        assert mesh.n_cells == 1
        assert mesh.lines.tolist() == [s.size, *range(s.size)]


def test_surfaces_of_sections_by_command(states, tmp_path):
    """The command writes what the method does: the stress of a bent beam, M y / I at the clamp."""
    model = vr.Model()
    material = vr.Material(2e11, 0.3, 7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.01), material=material, elements=1
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, -10.0))
    held = model.equilibrium()
    one, two = tmp_path / "a.vtkhdf", tmp_path / "b.vtkhdf"
    result = invoke("export", held.save(tmp_path / "held.nc"), "--vtk", one, "--sections")
    assert result.exit_code == 0, result.output
    held.save_paraview(two, sections=True)
    found = []
    for path in (one, two):
        times, state = states(path)
        blocks = state(len(times) - 1)
        assert list(blocks) == ["rods", "sections"]
        found.append(blocks["sections"]["stress_33"])
    np.testing.assert_array_equal(*found)
    width, depth = sorted((0.02, 0.01))
    moduli = [a * b**2 / 6.0 for a, b in ((width, depth), (depth, width))]
    assert min(abs(found[0].max() * modulus / 10.0 - 1.0) for modulus in moduli) < 0.02


def test_all_stored_times_by_default_in_one_small_file(states, tmp_path):
    run = Run(rigid(0.25))
    path = run.save_paraview(tmp_path / "v.vtkhdf")
    assert list(tmp_path.iterdir()) == [path]
    times, _ = states(path)
    assert times == run.time.tolist()


def test_the_file_keeps_to_the_format(tmp_path):
    """The groups, types and sizes that VTKHDF 2.2 asks of PolyData with steps, read with HDF5 alone."""
    run = Run(with_body().isel(time=slice(0, 3)))
    with h5py.File(run.save_paraview(tmp_path / "v.vtkhdf")) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"MultiBlockDataSet"
        assert list(root["Assembly"]) == ["rods", "bodies"]
        for name, count in (("rods", root["rods/NumberOfPoints"][0]), ("bodies", len(run.sites.bodies))):
            block = root[name]
            assert block.attrs["Type"] == b"PolyData"
            assert block["NumberOfPoints"][()].tolist() == [count] * 3
            assert block["Points"].shape == (3 * count, 3)
            assert block["Steps/PointOffsets"][()].tolist() == [0, count, 2 * count]
            for field in block["PointData"]:
                last = block[f"Steps/PointDataOffsets/{field}"][-1]
                assert len(block["PointData"][field]) == last + count
            for kind in ("Vertices", "Lines", "Polygons", "Strips"):
                cells = block[kind]
                assert (
                    cells["Offsets"][-1] == len(cells["Connectivity"]) == cells["NumberOfConnectivityIds"][0]
                )
                assert len(cells["Offsets"]) == cells["NumberOfCells"][0] + 1
        assert root["bodies"].attrs["names"].tolist() == ["plate"]


def test_rods_and_bodies_are_blocks(states, tmp_path):
    run = Run(with_body().isel(time=slice(0, 3)))
    _, state = states(run.save_paraview(tmp_path / "v.vtkhdf"))
    blocks = state(1)
    rods, bodies = blocks["rods"], blocks["bodies"]
    assert bodies.points[0] == pytest.approx(2.0 * rods.points[-1], abs=1e-6)
    assert set(rods["rod"].tolist()) == {0}


def test_load_factors_of_an_equilibrium_become_times(states, tmp_path):
    times, _ = states(Equilibrium(rolled_up()).save_paraview(tmp_path / "v.vtkhdf"))
    assert times == [0.25, 0.5, 0.75, 1.0]
    turning_back = rolled_up().isel(load_factor=[0, 1, 0])
    assert states(Equilibrium(turning_back).save_paraview(tmp_path / "v.vtkhdf"))[0] == [0, 1, 2]


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(vr.InputError, match=r"end with \.vtkhdf; give run\.vtkhdf"):
        Run(rigid(0.5)).save_paraview(tmp_path / "run.pvd")

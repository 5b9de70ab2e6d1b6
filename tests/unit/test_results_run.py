"""What a run and an equilibrium answer, on data sets in closed form, fresh and read back."""

import copy
import pickle

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from helpers.synthetic_results import LENGTH, oscillator, rolled_up, swing
from viscorod.pictures.plots.plot_motion import draw_motion
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run


@pytest.fixture(params=["fresh", "loaded"])
def run(request, tmp_path):
    fresh = Run(swing(leak=1e-3))
    return fresh if request.param == "fresh" else vr.load(fresh.save(tmp_path / "made" / "run.nc"))


@pytest.fixture(params=["fresh", "loaded"])
def equilibrium(request, tmp_path):
    fresh = Equilibrium(rolled_up(1.2))
    return fresh if request.param == "fresh" else vr.load(fresh.save(tmp_path / "run.nc"))


@pytest.mark.parametrize(("kind", "data"), [(Run, swing()), (Equilibrium, rolled_up())])
def test_file_holds_exactly_what_was_saved(kind, data, tmp_path):
    result = kind(data)
    again = vr.load(result.save(tmp_path / "run.nc"))
    assert type(again) is kind
    assert again.data.identical(result.data)
    assert again.report() == result.report()
    for name, variable in again.data.variables.items():
        if variable.dtype.kind == "f":
            assert np.all(np.isfinite(variable.values)), name


def test_a_data_set_that_is_built_later_is_built_once_and_the_same():
    calls = []

    def build():
        calls.append(1)
        return rolled_up(1.2)

    late, early = Equilibrium.later(build), Equilibrium(rolled_up(1.2))
    assert not calls
    assert late.position("beam.end") == pytest.approx(early.position("beam.end"), abs=0.0)
    assert late.data.identical(early.data)
    assert late.report() == early.report()
    assert calls == [1]


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda it: pickle.loads(pickle.dumps(it))])
def test_copies_of_a_result(copied):
    for result in (Run(swing()), Equilibrium.later(lambda: rolled_up(1.2))):
        again = copied(result)
        assert type(again) is type(result)
        assert again.data.identical(result.data)
        assert again.report() == result.report()


def test_file_is_netcdf4_with_units_that_other_tools_read(tmp_path):
    path = Run(swing()).save(tmp_path / "run.nc")
    assert path.read_bytes()[1:4] == b"HDF"
    with xr.open_dataset(path, engine="h5netcdf") as data:
        assert data["position"].dims == ("time", "station", "axis")
        assert data["position"].attrs["units"] == "m"
        assert data["elastic"].attrs["units"] == "J"


def test_history(run):
    displacement, velocity = oscillator(run.time, 0.05, 3.6, 0.2)
    history = run.history("beam.end", "displacement")
    assert history.dims == ("time", "axis")
    assert history.attrs["units"] == "m"
    assert history.sel(axis="y").values == pytest.approx(displacement, abs=1e-15)
    assert run.history("beam.end").sel(axis="x").values == pytest.approx(np.full(run.time.size, LENGTH))
    assert run.history("beam.end", "velocity").sel(axis="y").values == pytest.approx(velocity, abs=1e-15)
    assert run.history(-1).equals(run.history("beam.end"))


def test_history_between_stations_is_exact_for_a_smooth_shape(run):
    between = run.history("beam@0.1234", "displacement").sel(axis="y").values
    tip = run.history("beam.end", "displacement").sel(axis="y").values
    assert between == pytest.approx((0.1234 / LENGTH) ** 2 * tip, abs=1e-15)
    station = run.sites.at(4)
    assert run.history(station.label).values == pytest.approx(run.history(4).values, abs=1e-6)


def test_decrement_of_places(run):
    for place in ("beam.end", "beam@0.15", 7):
        assert run.decrement(place, "y").damping_ratio == pytest.approx(0.05, abs=1e-6)
    with pytest.raises(vr.InputError, match="passes no complete maximum"):
        run.decrement("beam.end", axis="z")
    hanging = vr.Run(
        swing(zeta=0.05, rest=-0.3)
    )  # swings below 0, as a weight does that is let go above its rest
    assert hanging.decrement("beam.end", "y").damping_ratio == pytest.approx(0.05, abs=1e-5)
    assert hanging.decrement("beam.end", "y").damping_ratio == pytest.approx(
        hanging.decay("beam.end", "y").damping_ratio, rel=1e-12
    )
    with pytest.raises(vr.InputError, match="axis = 'w' is not a global axis"):
        run.decrement("beam.end", axis="w")


def test_free_decay_follows_a_rest_that_creeps():
    """The swing about ``0.05 exp(-t/5)`` m at the tip, which one constant rest misses by a tenth."""
    data = swing(duration=14.0)
    shape = (data["station_s"] / LENGTH) ** 2
    creep = 0.05 * np.exp(-data["time"] / 5.0)
    data["position"].loc[{"axis": "y"}] += creep * shape
    data["velocity"].loc[{"axis": "y"}] -= creep / 5.0 * shape
    found = Run(data).free_decay("beam.end", "y")
    assert found.limit == ("small amplitude", pytest.approx(0.05, rel=2e-3))
    assert found.rest_at(found.time) == pytest.approx(0.05 * np.exp(-found.time / 5.0), rel=0.01)
    bounds = draw_motion(Run(data)).axes[0].lines[-2:]
    middle = sum(line.get_ydata() for line in bounds) / 2.0  # of the drawn envelope
    inside = (data.time >= found.time[0]) & (data.time <= found.time[-1])
    assert middle[inside] == pytest.approx(creep.values[inside], rel=0.05)


def test_snapshot_between_stored_times(run):
    time = 1.2345
    shape = run.snapshot(time)
    assert list(shape) == ["beam"]
    assert shape["beam"].shape == (11, 3)
    # cubic Hermite interpolation: amplitude (omega h)^4/384 = 1.4e-8
    assert shape["beam"][-1] == pytest.approx([LENGTH, oscillator(time, 0.05, 3.6, 0.2)[0], 0.0], abs=2e-8)
    assert run.snapshot(10.0)["beam"] == pytest.approx(run.field("position")[-1])
    with pytest.raises(vr.InputError, match=r"time = 10\.1 s lies outside the run, which covers 0 to 10 s"):
        run.snapshot(10.1)


def test_energy_account(run):
    energy = run.energy
    assert energy.total[0] == pytest.approx(0.5 * 0.03 * 3.6**2 * 0.2**2)
    closed = energy.kinetic + energy.elastic + energy.viscous - energy.external - energy.numerical
    assert closed == pytest.approx(np.full(energy.time.size, energy.total[0]))
    assert energy.moved == pytest.approx(energy.total[0], rel=1e-4)  # it comes to rest, all but 3 %
    assert energy.numerical_fraction == pytest.approx(
        1e-3 * (1 - energy.total[-1] / energy.total[0]), rel=1e-4
    )


def test_energy_of_something_at_rest_is_not_divided_by_round_off():
    data = swing(duration=1.0)
    for name in ("kinetic", "viscous", "external", "numerical"):
        data[name] = 0.0 * data[name] + 1e-20
    data["elastic"] = 0.0 * data["elastic"] + 1.0
    energy = Run(data).energy
    assert energy.moved == 0.0
    assert energy.numerical_fraction == 0.0
    assert "%" in str(energy)


def test_energy_moved_counts_work_taken_out():
    data = swing(duration=1.0)
    data["external"] = data["external"] - 5.0
    assert Run(data).energy.moved == 5.0


def test_main_motion(run):
    site, axis = run.main_motion
    assert (site.label, axis) == ("beam.end", "y")


def test_stations_of_several_rods():
    run = Run(swing(rods=("left", "right")))
    assert run.sites.rods == ("left", "right")
    assert run.history("right.start").values[0] == pytest.approx([0.0, 0.0, 0.1])
    assert [shape.shape for shape in run.snapshot(0.5).values()] == [(11, 3), (11, 3)]


def test_stations_are_ordered_by_arc_length_whatever_their_numbers():
    data = swing().isel(station=[3, 0, 10, *range(1, 3), *range(4, 10)])
    run = Run(data)
    assert run.sites.ends("beam")[1].stations.tolist() == [2]
    assert run.snapshot(0.0)["beam"][:, 0] == pytest.approx(np.sort(data["station_s"].values))


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("baem.end", r"no rod is called 'baem'; did you mean 'beam'\?"),
        ("beam", "is a rod, not a place on it; write beam.start"),
        ("boom", "is no place; write beam.start"),
        ("beam.middle", "is no place"),
        ("beam@", "is no place"),
        ("beam@half", "'half' is not an arc length"),
        ("beam@nan", "lies outside the rod"),
        ("beam@0.31", "lies outside the rod; its arc length runs from 0 to 0.3 m"),
        ("beam@-0.1", "lies outside the rod"),
        (11, "stations are numbered 0 to 10"),
        (-12, "stations are numbered 0 to 10"),
    ],
)
def test_wrong_places(place, message):
    with pytest.raises(vr.InputError, match=message):
        Run(swing(duration=0.1)).history(place)


def test_wrong_quantities():
    with pytest.raises(vr.InputError, match="it can be position, displacement, rotation, frame, velocity"):
        Run(swing(duration=0.1)).history("beam.end", "speed")
    with pytest.raises(vr.InputError, match=r"it can be position, displacement, rotation, frame$"):
        Equilibrium(rolled_up()).history("beam.end", "velocity")


def test_equilibrium_of_a_rolled_up_rod(equilibrium):
    radius = LENGTH / 1.2
    assert equilibrium.load_factor[-1] == 1.0
    assert equilibrium.position("beam.end") == pytest.approx(
        [radius * np.sin(1.2), radius * (1 - np.cos(1.2)), 0]
    )
    assert equilibrium.displacement("beam.end")[0] == pytest.approx(radius * np.sin(1.2) - LENGTH)
    assert equilibrium.rotation("beam.end") == pytest.approx([0, 0, 1.2])
    assert equilibrium.rotation("beam@0.1") == pytest.approx([0, 0, 0.4], abs=1e-7)
    assert equilibrium.rotation("beam.start") == pytest.approx([0, 0, 0])
    assert equilibrium.position("beam@0.1")[0] == pytest.approx(radius * np.sin(0.4), abs=1e-7)
    assert equilibrium.elastic_energy == pytest.approx(0.5 * 8.3e-4 * 1.2**2 / LENGTH)
    assert equilibrium.reactions.sel(support="beam.start", motion="mz").item() == pytest.approx(-8.3e-4 * 4)
    assert equilibrium.negative_eigenvalues == 0
    assert equilibrium.history("beam.end").dims == ("load_factor", "axis")


def test_rotation_takes_the_shorter_way_round():
    assert Equilibrium(rolled_up(1.5 * np.pi)).rotation("beam.end") == pytest.approx([0, 0, -0.5 * np.pi])


def test_data_of_the_wrong_kind():
    with pytest.raises(vr.InputError, match="kind = 'equilibrium' where 'simulate' is needed"):
        Run(rolled_up())
    with pytest.raises(vr.InputError, match="velocity missing"):
        Run(swing(duration=0.1).drop_vars("velocity"))


def test_files_that_are_no_results(tmp_path):
    with pytest.raises(vr.InputError, match="is not a file"):
        vr.load(tmp_path / "none.nc")
    text = tmp_path / "text.nc"
    text.write_text("not netCDF")
    with pytest.raises(vr.InputError, match="cannot be read as netCDF4"):
        vr.load(text)
    other = tmp_path / "other.nc"
    xr.Dataset({"a": 1.0}).to_netcdf(other, engine="h5netcdf")
    with pytest.raises(vr.InputError, match="holds no viscorod result"):
        vr.load(other)
    with pytest.raises(vr.InputError, match="cannot be written"):
        Run(swing(duration=0.1)).save(text / "run.nc")


def test_given_data_set_is_left_alone():
    data = swing(duration=0.1)
    before = data.copy(deep=True)
    Run(data)
    assert data.identical(before)

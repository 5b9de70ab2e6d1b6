"""Records of measurements beside results in closed form, and read from files of every kind."""

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from helpers.synthetic_results import LENGTH, oscillator, rolled_up, swing
from viscorod.records.other_files import columns_of
from viscorod.records.record_table import record_of
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run

ZETA, OMEGA, AMPLITUDE, REST = 0.05, 3.6, 0.2, 0.03
SAMPLES = np.arange(0.0, 9.0, 0.17)


@pytest.fixture(scope="module")
def run():
    return Run(swing(ZETA, OMEGA, amplitude=AMPLITUDE, rest=REST))


def record(values=None, **more):
    given = {"place": "beam.end", "quantity": "position", "direction": "y"} | more
    return vr.Record(SAMPLES, np.zeros_like(SAMPLES) if values is None else values, **given)


def exact(times):
    return oscillator(times, ZETA, OMEGA, AMPLITUDE, REST)


@pytest.mark.parametrize("quantity", ["position", "displacement"])
def test_a_history_is_predicted_at_the_samples(run, quantity):
    assert record(quantity=quantity).predicted(run) == pytest.approx(exact(SAMPLES)[0], abs=1e-6)


def test_directions_velocity_acceleration_and_strain(run):
    slope = exact(SAMPLES)[1]
    assert record(quantity="velocity", direction="-y").predicted(run) == pytest.approx(-slope, abs=1e-6)
    aslant = record(direction=(1.0, 1.0, 0.0)).predicted(run)
    assert aslant == pytest.approx((LENGTH + exact(SAMPLES)[0]) / np.sqrt(2.0), abs=1e-6)
    # q'' = -omega^2 (q - rest) - 2 zeta omega q'
    law = -(OMEGA**2) * (exact(SAMPLES)[0] - REST) - 2.0 * ZETA * OMEGA * slope
    found = record(quantity="acceleration").predicted(run)
    assert found[2:] == pytest.approx(law[2:], abs=2e-4 * np.abs(law).max())
    bend = -2.0 / LENGTH**2 * exact(SAMPLES)[0]
    middle = {"place": "beam@0.15", "quantity": "strain"}
    assert record(direction="bend_1", **middle).predicted(run) == pytest.approx(bend, abs=2e-4)
    # LLT 10: axial strain is stretch + y bend_1 - x bend_2
    gauge = record(direction="axial", lever=(0.002, 0.005, 0.0), **middle)
    assert gauge.predicted(run) == pytest.approx(0.005 * bend, abs=1e-6)


def test_markers_turn_with_the_section():
    """A rod rolled into an arc: the marker above the end turns with it, whose angle is known."""
    path = Equilibrium(rolled_up(1.2))
    at = vr.StaticRecord([0.25, 1.0], [0.0, 0.0], place="beam.end", direction="x", quantity="position")
    angle = np.array([0.25, 1.0]) * 1.2
    assert at.predicted(path) == pytest.approx(LENGTH * np.sin(angle) / angle, rel=1e-12)


def test_velocity_of_a_marker_is_that_of_its_place_and_of_turning(run):
    data = run.data.copy(deep=True)
    spin = np.array([0.3, -0.2, 0.7])  # along d1, d2, d3; the section itself is left standing
    data["angular_velocity"][:] = spin
    lever = (0.01, 0.02, -0.03)
    turned = np.cross(spin, lever)  # the quaternion (1, 1, 1, 1)/2 takes d1 to y, d2 to z, d3 to x
    found = record(quantity="velocity", lever=lever).predicted(Run(data))
    assert found == pytest.approx(exact(SAMPLES)[1] + turned[0], abs=1e-6)


def test_unknowns_of_the_measurement(run):
    unknown = ["release_time", "offset", "gain", "drift", "orientation_z", "marker_3"]
    one = record(unknown=unknown, name="tip")
    assert list(one.nuisances) == [f"tip.{word}" for word in unknown]
    values = {
        "tip.release_time": 0.4,
        "tip.offset": 0.01,
        "tip.gain": 1.1,
        "tip.drift": -0.002,
        "tip.orientation_z": 0.2,
        "tip.marker_3": 0.006,
    }
    q = exact(np.maximum(SAMPLES - 0.4, 0.0))[0]  # the model waits until it is released
    expected = 1.1 * (np.cos(0.2) * q - np.sin(0.2) * (LENGTH + 0.006)) + 0.01 - 0.002 * SAMPLES
    assert one.predicted(run, values) == pytest.approx(expected, abs=1e-6)


def test_derivatives_by_unknowns(run):
    one = record(unknown=["release_time", "offset", "gain", vr.Unknown("air_drag", key="loads[0].linear")])
    slopes = one.by_nuisances(run, {"beam.end.release_time": -0.05})
    assert set(slopes) == {"beam.end.release_time", "beam.end.offset", "beam.end.gain"}
    q, rate = exact(SAMPLES + 0.05)
    assert slopes["beam.end.offset"] == pytest.approx(np.ones_like(q), rel=1e-9)
    assert slopes["beam.end.gain"] == pytest.approx(q, abs=1e-6)
    assert slopes["beam.end.release_time"] == pytest.approx(-rate, abs=1e-3 * np.abs(rate).max())


def test_shared_unknowns_have_one_name():
    camera = vr.Unknown("orientation_z", deviation=0.02, shared="camera")
    both = [record(name=name, unknown=[camera]) for name in ("a", "b")]
    assert both[0].nuisances.keys() == both[1].nuisances.keys() == {"camera.orientation_z"}
    assert both[0].nuisances["camera.orientation_z"].start == 0.0


def test_modes_static_loads_and_moduli():
    path = Equilibrium(rolled_up(1.2))
    loads = vr.StaticRecord(
        [1.0, 2.0], [0.0, 0.0], place="beam.end", direction="y", full_load=4.0, unknown="offset"
    )
    angle = np.array([0.25, 0.5]) * 1.2
    expected = LENGTH * (1.0 - np.cos(angle)) / angle
    assert loads.predicted(path, {"beam.end.offset": 1e-3}) == pytest.approx(expected + 1e-3, rel=1e-9)
    turned = vr.StaticRecord(
        [1.0, 2.0], [0.0, 0.0], place="beam.end", quantity="rotation", direction="z", full_load=4.0
    )
    assert turned.predicted(path) == pytest.approx(angle, rel=1e-9)
    with pytest.raises(
        vr.InputError, match=r"0\.1 to 1 of full_load = 1, and the equilibria go from 0\.25 to 1"
    ):
        vr.StaticRecord([0.1, 1.0], [0.0, 0.0], place="beam.end", direction="y").predicted(path)

    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(shear_time=0.02, bulk_time=0.02))
    hertz = np.array([0.5, 5.0])
    table = vr.ModuliRecord(hertz, [1.0, 1.0], [1.0, 1.0], relative_noise=0.01)
    assert table.predicted(rubber) == pytest.approx([1e6, 1e6, *(2e6 * np.pi * hertz * 0.02)], rel=1e-12)


def test_response_with_delay(tmp_path):
    class Response:
        kind = "response"
        frequencies = np.linspace(0.0, 10.0, 1001)

        def response(self, output, source):
            return 1.0 / (25.0 - self.frequencies**2 + 1j * self.frequencies)

    hertz = np.array([1.0, 5.0, 9.0])
    one = vr.ResponseRecord(hertz, np.ones(3, dtype=complex), unknown="delay", noise=0.1, name="hit")
    exact_there = np.exp(-2j * np.pi * hertz * 0.01) / (25.0 - hertz**2 + 1j * hertz)
    found = one.predicted(Response(), {"hit.delay": 0.01})
    assert found == pytest.approx([*exact_there.real, *exact_there.imag], abs=1e-12)
    assert one.noise.shape == (6,)


def test_cutting_and_decimating():
    """What lies above the new half rate is gone, what is slow is kept, and white noise gets smaller as told."""
    times = np.arange(4000) * 0.01
    slow, fast = np.sin(2 * np.pi * 0.7 * times), np.sin(2 * np.pi * 8.3 * times)
    noise = np.random.default_rng(1).normal(0.0, 0.02, len(times))
    make = {"place": "beam.end", "quantity": "position", "direction": "y", "noise": 0.02}
    kept = vr.Record(times, slow + fast, **make).decimated(10)
    assert kept.interval == pytest.approx(0.1)
    assert np.abs(kept.values - np.sin(2 * np.pi * 0.7 * kept.times))[20:-20].max() < 5e-3
    alone = vr.Record(times, noise, **make).decimated(10)
    assert np.std(alone.values[20:-20]) == pytest.approx(alone.noise[0], rel=0.1)
    part = kept.window(3.0, 5.0)
    assert (part.times[0], part.times[-1], len(part.noise)) == pytest.approx((3.0, 5.0, 21))
    still = vr.Record(times, noise + 0.1 * times, **make | {"noise": None}).with_noise_of(0.0, 30.0)
    assert still.noise[0] == pytest.approx(0.02, rel=0.05)


TEXT = {
    "commas": "# rig 7\nt [s],tip_y_mm,remark\n0.0,1.5,2\n0.1,-2.5,3\n",
    "decimal commas": "Messung\n\nZeit (s);tip_y (mm);F / N\n0,0;1,5;2\n0,1;-2,5;3\n",
    "units below": "t\ttip_y\tF\ns\tmm\tN\n0\t1.5\t2\n0.1\t-2.5\t3\n",
    "blanks": "t[ms] tip_y[um] F[N]\n 0 1500 2\n 100 -2.5e3 3\nend of file\n",
}


TEXT["LabVIEW"] = (
    "LabVIEW Measurement\t\nSeparator\tTab\nTime\t10:11:12.3\n***End_of_Header***\t\n\t\nChannels\t1\t\n"
    "Y_Unit_Label\tmm\t\nX_Dimension\tTime\t\nDelta_X\t0.1\t\n***End_of_Header***\t\t\n"
    "X_Value\ttip_y\tComment\n0.0\t1.5\tstart\n0.1\t-2.5\n"
)


@pytest.mark.parametrize("layout", TEXT)
def test_text_files_in_other_layouts(layout, tmp_path):
    file = tmp_path / "record.txt"
    file.write_text(TEXT[layout], encoding="cp1252" if layout == "decimal commas" else "utf-8-sig")
    found = vr.Record.read(file, "tip_y", place="beam.end", quantity="position", direction="y")
    assert found.times == pytest.approx([0.0, 0.1])
    assert found.values == pytest.approx([1.5e-3, -2.5e-3])


WRONG = {
    "t [s],y [m]\n0,1\n0.1,x1\n0.2,3\n0.3,4\n": r"line 3, column y: this is no number",
    "t [s],y [m]\n0,1\n0.1,2,7\n0.2,3\n0.3,4\n": r"line 3 has 3 cells, and the table 2 columns",
    "t [s],y\n0,1\n0.1,2\n": r"does not give the unit of column y; write it beside its name, or give unit",
    "t [s],y [N]\n0,1\n0.1,2\n": r"column y: 'N': this is a force, .* needs a length",
    "t [s],z [m]\n0,1\n0.1,2\n": r"no column has this name",
    "t [s],y [m]\n0,1\n0.1,\n0.2,3\n": r"column y: row 2 of the numbers: there is no number",
    "t [s],y [m]\n0,1\n0.2,2\n0.1,3\n": r"times\[2\]: 0.1: it does not come after 0.2",
    "t [s],y [m]\nabc,def\n": r"there are no lines of numbers",
}


@pytest.mark.parametrize("text", WRONG)
def test_messages_name_line_and_column(text, tmp_path):
    file = tmp_path / "record.csv"
    file.write_text(text)
    with pytest.raises(vr.InputError, match=WRONG[text]):
        vr.Record.read(file, "y", place="beam.end", quantity="position", direction="y")


def test_from_xarray_and_pandas():
    import pandas

    how = {"place": "beam.end", "quantity": "velocity", "direction": "y"}
    array = xr.DataArray(
        [1.0, 2.0], {"time": ("time", [0.0, 0.5], {"units": "s"})}, name="v", attrs={"units": "cm/s"}
    )
    frame = pandas.DataFrame({"t [s]": [0.0, 0.5], "v [cm/s]": [1.0, 2.0], "note": ["a", "b"]})
    series = pandas.Series([1.0, 2.0], pandas.Index([0.0, 0.5], name="t [s]"), name="v [cm/s]")
    for source, time in ((array, 1), (frame, "t"), (series, "t")):
        found = vr.Record.read(source, "v", time=time, **how)
        assert (found.times.tolist(), found.values.tolist()) == ([0.0, 0.5], [0.01, 0.02])


def test_uff_c3d_and_matlab(tmp_path):
    times, values = np.arange(8) * 0.25, np.sin(np.arange(8.0))
    how = {"place": "beam.end", "quantity": "position", "direction": "y"}
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"t_s": times, "tip_mm": values * 1e3})
    assert vr.Record.read(tmp_path / "a.mat", "tip", time="t", **how).values == pytest.approx(values)

    pyuff = pytest.importorskip("pyuff", reason="UFF files need the extra viscorod[records]")
    one = pyuff.prepare_58(
        func_type=1, rsp_node=3, rsp_dir=-2, ref_dir=1, ref_node=1, data=values, x=times, id1="tip",
        rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=1, ordinate_spec_data_type=8,
        orddenom_spec_data_type=0, abscissa_inc=0.25, ord_data_type=4,
    )  # fmt: skip
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets(one, "overwrite")
    found = vr.Record.read(tmp_path / "a.uff", "3:-y", **how)
    assert (found.times, found.values) == (pytest.approx(times), pytest.approx(values, rel=1e-6))


def test_c3d(tmp_path):
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files need the extra viscorod[records]")
    places = np.ones((4, 2, 5))
    places[1, 1] = [1.0, 2.0, 3.0, 5.0, 8.0]
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [50.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ("base", "tip")
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    file["data"]["points"] = places
    file.write(str(tmp_path / "a.c3d"))
    how = {"place": "beam.end", "quantity": "position", "direction": "y"}
    found = vr.Record.read(tmp_path / "a.c3d", "tip y", **how)
    assert found.values == pytest.approx([1e-3, 2e-3, 3e-3, 5e-3, 8e-3])
    assert found.interval == pytest.approx(0.02)


def test_records_of_tables(tmp_path, run):
    file = tmp_path / "tip.csv"
    rows = "\n".join(f"{t:.3f},{1e3 * q:.9f}" for t, q in zip(SAMPLES, exact(SAMPLES)[0], strict=True))
    file.write_text(f"t_s,tip_mm\n{rows}\n")
    table = {
        "file": "tip.csv", "value": "tip", "place": "beam.end", "quantity": "position", "direction": "y",
        "unknown": ["offset", {"name": "gain", "deviation": 0.02}], "window": [1.0, 8.0],
    }  # fmt: skip
    found = record_of(table, tmp_path)
    assert found.values == pytest.approx(found.predicted(run), abs=1e-6)
    assert found.nuisances["beam.end.gain"].deviation == 0.02
    with pytest.raises(
        vr.InputError,
        match=r"^Record: plaec: there is no argument of this name; did you mean place",
    ):
        record_of({**table, "plaec": "beam"}, tmp_path)
    for missing in ("value", "quantity", "place"):
        with pytest.raises(
            vr.InputError, match=f"{missing}: .*needs this key, which is missing; add {missing}"
        ):
            record_of({key: one for key, one in table.items() if key != missing}, tmp_path)
    (tmp_path / "modes.csv").write_text("f [Hz],zeta [%]\n3,1\n9,2\n")
    modes = record_of(
        {"kind": "modes", "file": "modes.csv", "frequency": "f", "damping_ratio": "zeta"}, tmp_path
    )
    assert modes.observed == pytest.approx([3.0, 9.0, 0.01, 0.02])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"quantity": "place"}, "use one of position"),
        ({"direction": "w"}, "no direction"),
        ({"direction": (0, 0, 0)}, "not all zero"),
        ({"quantity": "strain"}, "no component of strain"),
        ({"noise": -1.0}, "standard deviations are positive"),
        ({"unknown": ["gian"]}, "this kind of record has no such unknown"),
        ({"unknown": ["gain", "gain"]}, "it is there twice"),
        ({"values": np.full(len(SAMPLES), np.nan)}, "a record has no gaps"),
        ({"lever": (1.0,)}, "three numbers"),
    ],
)
def test_wrong_records_are_refused(change, message):
    with pytest.raises(vr.InputError, match=message):
        record(**change)


def test_a_run_that_is_too_short_is_refused(run):
    late = vr.Record([0.0, 11.0], [0.0, 0.0], place="beam.end", quantity="position", direction="y")
    with pytest.raises(vr.InputError, match="the run ends at 10 s; simulate longer, or cut a window"):
        late.predicted(run)
    with pytest.raises(vr.InputError, match="compared with a result of modes, and this is one of simulate"):
        vr.ModesRecord([1.0]).predicted(run)


def test_units_of_accelerometers_and_gauges(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],a [g],e [ue]\n0,1,250\n1,-2,10\n")
    at = {"place": "beam.end"}
    shaken = vr.Record.read(tmp_path / "a.csv", "a", quantity="acceleration", direction="d1", **at)
    assert shaken.values == pytest.approx([9.80665, -19.6133])
    strained = vr.Record.read(tmp_path / "a.csv", "e", quantity="strain", direction="stretch", **at)
    assert strained.values == pytest.approx([250e-6, 10e-6])
    assert columns_of(tmp_path / "a.csv").names == ("t", "a", "e")


def test_a_record_says_its_direction_as_it_is_typed():
    def text(direction):
        about = {"place": "beam.end", "quantity": "displacement", "direction": direction}
        return str(vr.Record([0.0, 1.0], [0.0, 1.0], **about))

    assert "displacement y of beam.end [m]" in text("y")
    assert "displacement -z of beam.end [m]" in text((0.0, 0.0, -2.0))
    assert "displacement along (0.6, 0.8, 0) of beam.end [m]" in text((3.0, 4.0, 0.0))


def test_a_folder_is_not_said_to_be_missing(tmp_path):
    for path, said in ((tmp_path, "this is a folder"), (tmp_path / "none.csv", "there is no such file")):
        with pytest.raises(vr.InputError, match=f"{said}; give the path of a file of measured values"):
            vr.Record.read(path, "x", place="beam.end", direction="x", quantity="displacement")


def test_ratios_that_may_be_per_cent_are_told():
    """0.8 for 0.8 % is a ratio below 1."""
    with pytest.warns(vr.AccuracyWarning, match=r"0.6 is read as 60 % of critical.*damping_as = 'percent'"):
        vr.ModesRecord([12.0, 75.0], [0.8, 0.4])
    known = vr.ModesRecord([12.0, 75.0], [0.8, 0.4], damping_as="percent")
    assert known.damping_ratios == pytest.approx([0.008, 0.004])

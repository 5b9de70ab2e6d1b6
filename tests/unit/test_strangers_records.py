"""Files of measurements as other people's instruments and programs write them: one record in many, all alike."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from viscorod.records.record_table import record_of

TIMES = np.arange(12) * 0.01
VALUES = np.round(5e-3 * np.sin(9.0 * TIMES), 9)
HOW = {"place": "beam.end", "quantity": "displacement", "direction": "y"}


def rows(mark=",", point=".", times=1.0, values=1e3):
    return "".join(
        mark.join(f"{x:.8g}".replace(".", point) for x in (t * times, y * values)) + "\n"
        for t, y in zip(TIMES, VALUES, strict=True)
    )


def clock(stamp):
    return "".join(
        f"{stamp.format(59.95 + t if t < 0.045 else t - 0.05, 58 + (t > 0.045))},{y * 1e3:.8g}\n"
        for t, y in zip(TIMES, VALUES, strict=True)
    )


TEXTS = {
    "units as words in a line of their own": "Time,tip_y\nSeconds,Millimeters\n" + rows(),
    "sec below names": "Time,tip_y\nsec,mm\n" + rows(),
    "braces": "Time {ms},tip_y {mm}\n" + rows(times=1e3),
    "settings above, as many cells as the table": "Rate,100\nLength,12\n\nTime [s],tip_y [mm]\n" + rows(),
    "the same with decimal commas": "Kanal;1\nRate;100,0\nTime [s];tip_y [mm]\n" + rows(";", ","),
    "time of day over an hour": "Time,tip_y [mm]\n" + clock("10:{1}:{0:06.3f}"),
    "dates": "Time,tip_y [mm]\n" + clock("2024-03-01T10:{1}:{0:06.3f}Z"),
    "German dates": "Zeit;tip_y [mm]\n" + clock("1/3/2024 10:{1}:{0:06.3f}").replace(",", ";").replace(".", ","),
    "a clock of twelve hours": "Time,tip_y [mm]\n" + clock("1/3/2024 10:{1}:{0:06.3f} PM"),
    "remarks beside few of the samples": "t [s],tip_y [mm],event,by\n"
    + "".join(f"{row},{'release' if k in (0, 7) else ''},\n" for k, row in enumerate(rows().splitlines())),
    "minutes": "Time [min]\ttip_y [mm]\n" + rows("\t", times=1.0 / 60.0),
    "old Mac": ("Time [s],tip_y [mm]\n" + rows()).replace("\n", "\r"),
    "thousands": "Time [s];tip_y [µm]\n"
    + "".join(f"{t:.2f};{y * 1e6:,.3f}\n" for t, y in zip(TIMES, VALUES, strict=True)),
}  # fmt: skip


def read(path, value="tip_y", **more):
    return vr.Record.read(path, value, **{**HOW, **more})


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le"])
@pytest.mark.parametrize("name", TEXTS)
def test_text(name, encoding, tmp_path):
    file = tmp_path / "record.txt"
    file.write_bytes(TEXTS[name].encode(encoding))
    found = read(file)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-8)
    np.testing.assert_allclose(found.values, VALUES, atol=1e-9)
    assert found.interval == pytest.approx(0.01)


LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t{point}\nX_Columns\t{columns}\n"
    "***End_of_Header***\t\n"
)


def segment(first, last, columns, names="tip_y\tF"):
    head = (
        f"\t\nChannels\t2\t\t\nSamples\t{last - first}\t\t\nDate\t2024/01/01\t\t\nTime\t10:11:12.3\t\t\n"
        f"Y_Unit_Label\tmm\tN\t\nX_Dimension\tTime\tTime\t\nX0\t{TIMES[first]:g}\t{TIMES[first]:g}\t\n"
        f"Delta_X\t0.01\t0.01\t\n***End_of_Header***\t\t\t\nX_Value\t{names}\tComment\n"
    )
    times = [f"{t:.6f}" if columns == "One" else "" for t in TIMES]
    return head + "".join(f"{times[k]}\t{VALUES[k] * 1e3:.8g}\t{k}\n" for k in range(first, last))


@pytest.mark.parametrize("columns", ["One", "No"])
@pytest.mark.parametrize("point", [".", ","])
def test_labview_segments_are_one_record_and_times_need_not_be_written(columns, point, tmp_path):
    """The second segment alone was read before; its first sample is at X0."""
    file = tmp_path / "record.lvm"
    text = segment(0, 5, columns) + "\n" + segment(5, 12, columns)
    head = LABVIEW.format(point=point, columns=columns)
    file.write_text(head + text.replace(".", point))
    found = read(file)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-9)
    np.testing.assert_allclose(found.values, VALUES, atol=1e-9)


def test_labview_segments_of_other_channels_are_refused(tmp_path):
    file = tmp_path / "record.lvm"
    head = LABVIEW.format(point=".", columns="One")
    file.write_text(head + segment(0, 5, "One") + "\n" + segment(5, 12, "One", names="base_y\tF"))
    with pytest.raises(vr.InputError, match=r"other channels than the first.*one segment a file"):
        read(file)


@pytest.mark.parametrize("word", ["", "NaN", "---", "#N/A", "1.#QNAN", "null"])
def test_gaps_are_refused_or_left_out_by_name(word, tmp_path):
    file = tmp_path / "record.csv"
    lines = rows().splitlines()
    lines[4] = lines[4].split(",")[0] + "," + word
    file.write_text("t [s],tip_y [mm]\n" + "\n".join(lines) + "\n")
    with pytest.raises(
        vr.InputError, match=r"row 5 of the numbers: there is no number; give gaps='leave out'"
    ):
        read(file)
    found = read(file, gaps="leave out")
    np.testing.assert_allclose(found.values, np.delete(VALUES, 4), atol=1e-9)
    assert found.interval is None
    with pytest.raises(vr.InputError, match="use 'refuse' or 'leave out'"):
        read(file, gaps="fill")


def test_stamps_that_were_rounded_are_evenly_spaced():
    """240 samples a second in whole milliseconds; one that is left out is more than rounding."""
    times = np.round(np.arange(400) / 240.0, 3)
    assert vr.Record(times, np.sin(times), **HOW).interval == pytest.approx(1.0 / 240.0, rel=1e-3)
    assert vr.Record(np.delete(times, 200), np.sin(times[1:]), **HOW).interval is None
    assert vr.Record(times**1.1, np.sin(times), **HOW).interval is None


@pytest.mark.parametrize(
    ("head", "mark", "point", "value"),
    [
        ("tip_y [mm]\n", "\n", ".", "tip_y"),
        ("# tip\ntip_y\nmm\n", "\n", ",", 1),
        ("", "\n", ".", 1),
        ("a,tip_y [mm]\n", "\n7,", ".", 2),
    ],
)
def test_a_single_column_with_its_rate(head, mark, point, value, tmp_path):
    """Lines of "9,5" are numbers with decimal commas below one name, and two columns below two names."""
    file = tmp_path / "record.csv"
    text = mark.lstrip("\n") + mark.join(
        f"{round(y * 1e9):d}" if mark != "\n" else f"{y * 1e3:.6f}" for y in VALUES
    )
    file.write_text(head + text.replace(".", point) + "\n")
    size = 1e-6 if mark != "\n" else 1.0
    unit = None if head else "mm"
    found = read(file, value, rate=100.0, unit=unit)
    np.testing.assert_allclose(size * found.values, VALUES, atol=1e-9)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-12)


def test_what_a_single_column_does_not_say_is_asked_for(tmp_path):
    file = tmp_path / "record.csv"
    file.write_text("0,5\n0,25\n-0,5\n")
    with pytest.raises(
        vr.InputError, match=r"line 1 may be one number with a decimal comma, or two columns; write"
    ):
        read(file, 1, rate=100.0, unit="mm")
    file.write_text("tip_y [mm]\n0.5\n\n-0.5\n")
    with pytest.raises(vr.InputError, match=r"this column has the values, and none has times; give rate"):
        read(file)
    with pytest.raises(vr.InputError, match=r"row 2 of the numbers: there is no number"):
        read(file, rate=100.0)
    assert read(file, rate=100.0, gaps="leave out").times.tolist() == [0.0, 0.02]


def test_values_alone_with_their_rate(tmp_path):
    file = tmp_path / "record.csv"
    file.write_text("tip_y [mm],F [N]\n" + "".join(f"{y * 1e3:.8g},1\n" for y in VALUES))
    found = read(file, rate=100.0)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-12)
    np.testing.assert_allclose(found.values, VALUES, atol=1e-9)
    with pytest.raises(vr.InputError, match="rate: 0: it is not positive"):
        read(file, rate=0.0)


def matlab_5(folder):
    from scipy.io import savemat

    savemat(folder / "a.mat", {"trial": {"t_s": TIMES, "tip_y_mm": VALUES * 1e3, "who": "me"}, "fs": 100.0})
    return folder / "a.mat", {"time": "t"}


def matlab_73(folder):
    import h5py

    with h5py.File(folder / "a.mat", "w", userblock_size=512) as file:
        trial = file.create_group("trial")
        trial["t"], trial["tip_y"] = TIMES[None, :], 1e3 * VALUES[None, :]
        file["fs"] = [[100.0]]
        file["who"] = np.array([[109, 101]], dtype=np.uint16)
        file["who"].attrs["MATLAB_class"] = np.bytes_("char")
    with (folder / "a.mat").open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\x02IM")
    return folder / "a.mat", {"time": "t", "time_unit": "s", "unit": "mm"}


def matlab_matrix(folder):
    from scipy.io import savemat

    savemat(folder / "a.mat", {"D": np.column_stack([TIMES, VALUES])})
    return folder / "a.mat", {"value": "D(2)", "time": "D(1)", "time_unit": "s", "unit": "m"}


def netcdf(folder):
    dated(None).to_dataset().to_netcdf(folder / "a.nc")
    return folder / "a.nc", {}


def dated(_folder):
    import pandas

    stamps = pandas.to_datetime("2024-01-01") + pandas.to_timedelta(TIMES, unit="s")
    return xr.DataArray(VALUES * 1e3, {"time": ("time", stamps)}, name="tip_y", attrs={"units": "mm"})


def frame_of_dates(folder):
    return dated(folder).to_series().rename("tip_y [mm]"), {}


def frame_in_a_zone(folder):
    return frame_of_dates(folder)[0].tz_localize("Europe/Vienna"), {}


def frame_of_durations(_folder):
    import pandas

    frame = pandas.DataFrame({"t": pandas.to_timedelta(TIMES, unit="s"), "tip_y [mm]": VALUES * 1e3})
    return frame, {"time": "t"}


def frame_of_two_levels(_folder):
    import pandas

    names = pandas.MultiIndex.from_tuples([("t", "s"), ("tip_y", "[mm]")])
    return pandas.DataFrame(np.column_stack([TIMES, VALUES * 1e3]), columns=names), {"time": "t"}


def binary_uff(folder):
    """A data set 58b, of the IEEE's numbers with the small end first, behind the head of a set 58."""
    pyuff = pytest.importorskip("pyuff", reason="UFF files need the extra viscorod[records]")
    one = pyuff.prepare_58(
        func_type=1, rsp_node=3, rsp_dir=2, ref_dir=1, ref_node=1, data=VALUES, x=TIMES, id1="tip",
        rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=1, ordinate_spec_data_type=8,
        orddenom_spec_data_type=0, abscissa_inc=0.01, ord_data_type=4,
    )  # fmt: skip
    pyuff.UFF(str(folder / "text.uff")).write_sets(one, "overwrite")
    lines = (folder / "text.uff").read_bytes().split(b"\n")
    raw = VALUES.astype("<f8").tobytes()
    first = b"%6d%1s%6d%6d%12d%12d%6d%6d%12d%12d" % (58, b"b", 1, 2, 11, len(raw), 0, 0, 0, 0)
    content = b"\n".join([b"    -1", first, *lines[2:13]]) + b"\n" + raw + b"\n    -1\n"
    (folder / "a.uff").write_bytes(content)
    return folder / "a.uff", {"value": "3:+y"}


MAKERS = (
    matlab_5, matlab_73, matlab_matrix, netcdf, lambda folder: (dated(folder), {}), frame_of_dates, frame_in_a_zone,
    frame_of_durations, frame_of_two_levels, binary_uff,
)  # fmt: skip


@pytest.mark.parametrize("make", MAKERS)
def test_other_files_and_objects(make, tmp_path):
    source, how = make(tmp_path)
    found = read(source, **how)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-9)
    np.testing.assert_allclose(found.values, VALUES, rtol=1e-6, atol=1e-12)


def test_pixels_and_volts_have_the_size_that_the_user_gives(tmp_path):
    """A pixel of screens, 1/96 inch, is none of a camera."""
    file = tmp_path / "track.csv"
    file.write_text("t [ms],tip [px],laser [V]\n0,0,1\n10,4,2\n20,-2,3\n")
    how = {"place": "beam.end", "quantity": "displacement", "direction": "y"}
    with pytest.raises(vr.InputError, match="nothing says how much one of column tip is; give unit"):
        vr.Record.read(file, "tip", **how)
    assert vr.Record.read(file, "tip", unit="0.21 mm", **how).values == pytest.approx([0.0, 8.4e-4, -4.2e-4])
    assert vr.Record.read(file, "laser", unit="-2e-3 m", **how).values == pytest.approx([-2e-3, -4e-3, -6e-3])


@pytest.mark.parametrize(("unit", "size"), [("mg", 9.80665e-3), ("G", 9.80665), ("gn", 9.80665)])
def test_units_of_accelerometers(tmp_path, unit, size):
    file = tmp_path / "acc.csv"
    file.write_text(f"t [s],a [{unit}]\n0,1\n1,2\n")
    found = vr.Record.read(file, "a", place="beam.end", quantity="acceleration", direction="z")
    assert found.values == pytest.approx([size, 2.0 * size])


@pytest.mark.parametrize(
    ("heads", "rows", "unit", "values"),
    [
        ("mag [m/s^2/N],phase [deg]", ("2,90", "3,-180"), None, [2j, -3.0]),
        ("mag [dB],phase [rad]", ("20,0", "-20,0"), "um/N", [1e-5, 1e-7]),
        ("re [g/N],im [g/N]", ("1,0", "0,2"), None, [9.80665, 19.6133j]),
        ("mag / dB(m/s²/N),phase / °", ("20,0", "0,90"), None, [10.0, 1j]),
        ("re [ms⁻²/N],im [ms⁻²/N]", ("1,0", "0,2"), None, [1.0, 2j]),
        ("re [N/g],im [N/g]", ("9.80665,0", "0,19.6133"), None, [1.0, 2j]),
    ],
)
def test_responses_by_magnitude_and_phase(tmp_path, heads, rows, unit, values):
    file = tmp_path / "frf.csv"
    file.write_text(f"f [Hz],{heads}\n1,{rows[0]}\n2,{rows[1]}\n")
    found = vr.ResponseRecord.read(file, [2, 3], unit=unit)
    assert found.values == pytest.approx(np.array(values))
    with pytest.raises(vr.InputError, match="a response has a phase"):
        vr.ResponseRecord.read(file, 2, unit=unit)


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("g/N", "m/s^2/N"), ("1/kg", "m/s^2/N"), ("mm/s/N", "m/s/N"), ("µε/N", "1/N"), ("rad/Nm", "1/(N m)"),
        ("kg", "N/(m/s^2)"), ("kN/mm", "N/m"), ("mV/N", None), ("g/g", None),
    ],
)  # fmt: skip
def test_a_response_has_its_unit(tmp_path, written, unit):
    file = tmp_path / "frf.csv"
    file.write_text(f"f [Hz],re [{written}],im [{written}]\n1,1,2\n2,3,4\n")
    assert vr.ResponseRecord.read(file, ["re", "im"]).unit == unit


def test_units_of_two_parts_are_one(tmp_path):
    file = tmp_path / "frf.csv"
    file.write_text("f [Hz],re [m/N],im [mm/N]\n1,1,2\n2,3,4\n")
    with pytest.raises(vr.InputError, match=r"re is in m/N and im is in mm/N; give unit"):
        vr.ResponseRecord.read(file, ["re", "im"])
    with pytest.raises(vr.InputError, match=r"response: unit: 'mm/N': values are in SI; give the unit in SI"):
        vr.ResponseRecord([1.0, 2.0], [1j, 2j], unit="mm/N")


def test_decibels_need_what_they_are_over(tmp_path):
    file = tmp_path / "frf.csv"
    file.write_text("f [Hz],mag [dB],phase [deg]\n1,0,0\n2,0,0\n")
    with pytest.raises(vr.InputError, match="it is not said what 0 dB are; give unit"):
        vr.ResponseRecord.read(file, ["mag", "phase"])


def test_a_marker_that_was_not_seen_is_a_gap(tmp_path):
    """Programs write it as no number, or as the origin."""
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files need the extra viscorod[records]")
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["tip"]
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    points = np.ones((4, 1, 8))
    points[1, 0] = np.arange(8.0)
    points[:3, 0, 3] = 0.0
    points[:3, 0, 5] = np.nan
    file["data"]["points"] = points
    file.write(str(tmp_path / "a.c3d"))
    with pytest.raises(vr.InputError, match="row 4 of the numbers: there is no number"):
        vr.Record.read(tmp_path / "a.c3d", "tip y", **HOW)
    seen = vr.Record.read(tmp_path / "a.c3d", "tip y", gaps="leave out", **HOW)
    assert seen.values == pytest.approx(1e-3 * np.array([0.0, 1.0, 2.0, 4.0, 6.0, 7.0]))


TEKTRONIX = """Record Length,4,,-0.002,1.25,
Sample Interval,0.002,,0.000,1.50,
Source,CH1,,0.002,1.75,
,,,0.004,2.00,
"""


def test_settings_beside_the_samples_of_an_oscilloscope(tmp_path):
    """The first rows, whose first cells are words, are samples too; words in a column that is asked for are told."""
    file = tmp_path / "scope.csv"
    file.write_text(TEKTRONIX)
    about = {
        "place": "beam.end",
        "quantity": "displacement",
        "direction": "y",
        "unit": "2 mm",
        "time_unit": "s",
    }
    found = vr.Record.read(file, 5, time=4, **about)
    assert found.times == pytest.approx([-0.002, 0.0, 0.002, 0.004])
    assert found.values == pytest.approx(2e-3 * np.array([1.25, 1.5, 1.75, 2.0]))
    for gaps in ("refuse", "leave out"):
        with pytest.raises(vr.InputError, match="'CH1': line 3, column 2: this is no number"):
            vr.Record.read(file, 2, time=4, gaps=gaps, **about)


def test_frames_of_a_tracker_with_lost_ones_have_their_times(tmp_path):
    """Numbers of frames are times in units of 1/30 s, and pixels stand behind the name."""
    file = tmp_path / "frames.csv"
    file.write_text("frame,x_px,y_px\n0,10,20\n1,10,21\n4,10,24\n5,10,25\n")
    found = vr.Record.read(
        file, "y", time="frame", time_unit="1/30 s", unit="-0.5 mm", place="beam.end", quantity="position",
        direction="z",
    )  # fmt: skip
    assert found.times == pytest.approx(np.array([0.0, 1.0, 4.0, 5.0]) / 30.0)
    assert found.values == pytest.approx(-5e-4 * np.array([20.0, 21.0, 24.0, 25.0]))


@pytest.mark.parametrize(
    ("measure", "given"),
    [
        ("ratio", 0.02),
        ("percent", 2.0),
        ("quality_factor", 25.0),
        ("loss_factor", 0.04),
        ("log_decrement", 2.0 * np.pi * 0.02 / np.sqrt(1.0 - 0.02**2)),
    ],
)
def test_damping_of_a_table_of_modes_by_any_measure(measure, given, tmp_path):
    """By the definitions; the decrement is ln of amplitudes one cycle apart."""
    assert vr.ModesRecord([5.0], [given], damping_as=measure).damping_ratios == pytest.approx([0.02])
    file = tmp_path / "modes.csv"
    file.write_text(f"frequency [Hz],d\n5.0,{given}\n")
    more = {} if measure != "ratio" else {"damping_ratio_unit": "1"}
    table = {"kind": "modes", "file": file.name, "damping_ratio": "d", "damping_as": measure, **more}
    assert record_of(table, tmp_path).damping_ratios == pytest.approx([0.02])


@pytest.mark.parametrize(("measure", "value"), [("Q", 25.0), ("quality_factor", 0.0), ("ratio", 2.0)])
def test_damping_that_is_none_is_refused(measure, value):
    with pytest.raises(vr.InputError, match="damping"):
        vr.ModesRecord([5.0], [value], damping_as=measure)


def test_a_response_that_is_read_says_which_input_of_the_model_it_has(tmp_path):
    """The file is given by its place: ``source`` was the name of two arguments."""
    file = tmp_path / "frf.csv"
    file.write_text("f [Hz],re [m/s^2/N],im [m/s^2/N]\n1,1,0\n2,2,1\n")
    found = vr.ResponseRecord.read(file, ["re", "im"], source="beam.end fz", output="beam.end az")
    assert (found.source, found.output) == ("beam.end fz", "beam.end az")
    table = {"kind": "response", "file": file.name, "value": ["re", "im"], "source": "beam.end fz"}
    assert record_of(table, tmp_path).source == "beam.end fz"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        # two strains in one file: their moduli were averaged without a word
        (
            "Strain (%),f (Hz),E' (MPa),E'' (MPa)\n0.01,1,30,3\n0.01,10,33,3.2\n0.1,1,28,3\n0.1,10,31,3.2\n",
            "2 frequencies stand more than once .* the moduli there are averaged",
        ),
        (
            "f (Hz),E' (MPa),tan delta\n0.1,30.0,15.8\n1,37.8,15.8\n10,47.5,15.8\n",
            "if it is in percent, the file must say so",
        ),
        ("f (Hz),E' (MPa),E'' (MPa)\n1,30,3\n10,33,\n100,36,3\n", "1 row of the file has no usable numbers"),
    ],
)
def test_what_is_doubtful_about_a_table_of_moduli_is_a_warning(text, message, tmp_path):
    file = tmp_path / "sweep.csv"
    file.write_text(text)
    with pytest.warns(UserWarning, match=message):
        vr.ModuliRecord.read(str(file))


def test_a_table_of_modes_with_columns_of_what_is_uncertain(tmp_path):
    """Of a decrement d with deviation u the ratio d/(2 pi) has u/(2 pi) where it is small."""
    file = tmp_path / "modes.csv"
    file.write_text(
        "Mode;f [Hz];u(f) [Hz];zeta [%];u(zeta) [%];d;ud\n1;10,2;0,02;0,5;0,1;0,04;0,01\n3;64;0,2;0,4;0,2;0,03;0,02\n"
    )
    table = {
        "kind": "modes",
        "file": "modes.csv",
        "frequency": "f",
        "frequency_noise": "u(f)",
        "modes": "Mode",
    }
    found = record_of({**table, "damping_ratio": "zeta", "ratio_noise": "u(zeta)"}, tmp_path)
    assert found.modes == (1, 3)
    assert found.observed == pytest.approx([10.2, 64.0, 0.005, 0.004])
    assert found.noise == pytest.approx([0.02, 0.2, 0.001, 0.002])
    about = {"damping_ratio": "d", "ratio_noise": "ud", "damping_as": "log_decrement"}
    other = record_of({**table, **about}, tmp_path)
    assert other.noise[2:] == pytest.approx(np.array([0.01, 0.02]) / (2.0 * np.pi), rel=1e-3)
    same = record_of({**table, "damping_ratio": "zeta", "ratio_noise": 0.001, "modes": [1, 3]}, tmp_path)
    assert same.noise == pytest.approx([0.02, 0.2, 0.001, 0.001])


def test_loads_there_and_back_are_one_branch_each(tmp_path):
    file = tmp_path / "pull.csv"
    file.write_text("Mass [kg],Way [mm]\n0,0\n1,2\n2,4\n1,2.5\n0,0.5\n")
    table = {"kind": "static", "file": "pull.csv", "place": "beam.end", "direction": "y"}
    with pytest.raises(
        vr.InputError, match=r"column Mass has masses, and a force is needed; give load_unit = 'kgf'"
    ):
        record_of(table, tmp_path)
    table["load_unit"] = "kgf"
    with pytest.raises(
        vr.InputError, match=r"go up to 19.6133 in row 3, and back; give branch = 'loading' or"
    ):
        record_of(table, tmp_path)
    for branch, way in (("loading", [0.0, 2.0, 4.0]), ("unloading", [0.5, 2.5, 4.0])):
        found = record_of({**table, "branch": branch}, tmp_path)
        assert found.loads == pytest.approx(9.80665 * np.arange(3.0))
        assert found.values == pytest.approx(1e-3 * np.array(way))
    with pytest.raises(vr.InputError, match=r"branch: 'up': it is not known; use loading or unloading"):
        record_of({**table, "branch": "up"}, tmp_path)


@pytest.mark.parametrize("mark", [".", ","])
def test_a_single_column_of_complex_numbers_with_the_step_of_its_lines(tmp_path, mark):
    file = tmp_path / "frf.txt"
    file.write_text("".join(f"({k + 0.5}{-k - 0.25:+}j)\n" for k in range(30)).replace(".", mark))
    found = vr.ResponseRecord.read(file, 1, step=0.5, unit="m/N")
    np.testing.assert_allclose(found.frequencies, 0.5 * np.arange(30))
    np.testing.assert_allclose(found.values, np.arange(30) * (1 - 1j) + 0.5 - 0.25j)
    with pytest.raises(vr.InputError, match=r"step: 0: it is not positive; give that of the lines, Hz"):
        vr.ResponseRecord.read(file, 1, step=0.0, unit="m/N")

"""Headings of records as instruments of many makers write them: one record of known values in each, all alike."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.records.record_table import record_of

TIMES = np.arange(12) * 0.01
VALUES = np.round(5e-3 * np.sin(9.0 * TIMES), 9)
HOW = {"place": "beam.end", "quantity": "displacement", "direction": "y"}


def rows(mark=",", more=""):
    return "".join(f"{t:.8g}{mark}{y * 1e3:.8g}{more}\n" for t, y in zip(TIMES, VALUES, strict=True))


HEADS = {
    "the time by the name of its unit": ("Vertical Units,CH1:V\nHorizontal Units,s\nSecond,Tip\n", ",", "Tip", "mm"),
    "seconds of a telephone": ("seconds_elapsed,y\n", ",", "y", "mm"),
    "a stroke in the name": ("File info\nRate:\t100 Hz\n\nTime (s)\tAI 1/Tip (mm)\n", "\t", "AI 1/Tip", None),
    "what channels are connected to": ("T0\t1.3.2024\n\nZeit\tWeg_1\n[s]\t[mm]\nMX840\t\n", "\t", "Weg_1", None),
    "units after blanks within brackets": ("Point 3\nTime\tTip\n[ s ]\t[ mm ]\n", "\t", "Tip", None),
    "a unit behind the stroke": ("Zeit / s;Tip / mm\n", ";", "Tip", None),
    "a rate in the name": ("Zeit  1 - Messrate [s],Tip, left [mm]\n".replace(", l", " l"), ",", "Tip left", None),
    "a bridge of gauges": ("t [s],SG1 [mV/V]\n", ",", "SG1", "1 mm"),
}  # fmt: skip


@pytest.mark.parametrize("name", HEADS)
def test_heads(name, tmp_path):
    head, mark, value, unit = HEADS[name]
    (tmp_path / "record.txt").write_text(head + rows(mark))
    found = vr.Record.read(tmp_path / "record.txt", value, unit=unit, **HOW)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-9)
    np.testing.assert_allclose(found.values, VALUES, atol=1e-9)


def test_settings_beside_the_units_of_an_oscilloscope(tmp_path):
    """Start and increment stand in the line of units; the samples are counted."""
    lines = "".join(f"{k},{y * 1e3:.8g},,\n" for k, y in enumerate(VALUES))
    head = "X,CH1,Start,Increment,\nSequence,Volt,-3.0e-03,1.0e-02\n"
    (tmp_path / "scope.csv").write_text(head + lines)
    with pytest.raises(vr.InputError, match="unit of column X; write it beside its name, or give time_unit"):
        vr.Record.read(tmp_path / "scope.csv", "CH1", unit="1 mm", **HOW)
    found = vr.Record.read(tmp_path / "scope.csv", "CH1", unit="1 mm", time_unit="1e-2 s", **HOW)
    np.testing.assert_allclose(found.times, TIMES, atol=1e-9)
    np.testing.assert_allclose(found.values, VALUES, atol=1e-9)


def test_samples_before_a_tracker_saw_its_point_have_their_times(tmp_path):
    """They were taken for the line of names, and times counted by the rate began at the first that was seen."""
    lines = [f"512.1,{y * 1e6:.8g}" for y in VALUES]
    lines[0], lines[1], lines[5] = "NaN,NaN", "NaN,NaN", "NaN,NaN"
    (tmp_path / "xypts.csv").write_text("pt1_X,pt1_Y\n" + "\n".join(lines) + "\n")
    how = {"rate": 100.0, "unit": "1 um", **HOW}
    with pytest.raises(vr.InputError, match="column pt1_Y: row 1 of the numbers: there is no number"):
        vr.Record.read(tmp_path / "xypts.csv", "pt1_Y", **how)
    found = vr.Record.read(tmp_path / "xypts.csv", "pt1_Y", gaps="leave out", **how)
    np.testing.assert_allclose(found.times, np.delete(TIMES, [0, 1, 5]), atol=1e-9)
    np.testing.assert_allclose(found.values, np.delete(VALUES, [0, 1, 5]), atol=1e-9)


def test_a_second_table_below_the_first_is_named(tmp_path):
    table = "t [s],y [mm]\n" + rows()
    (tmp_path / "two.csv").write_text(table + "\n" + table)
    with pytest.raises(vr.InputError, match="line 15 has the names of the columns once more"):
        vr.Record.read(tmp_path / "two.csv", "y", **HOW)


def test_dates_beside_times_of_day(tmp_path):
    lines = "".join(
        f"01.03.2024,10:11:{12 + t:06.3f},{y * 1e3}\n" for t, y in zip(TIMES, VALUES, strict=True)
    )
    (tmp_path / "two.csv").write_text("Date,Time,y [mm]\n" + lines)
    with pytest.raises(vr.InputError, match="dates say no time of day; give the column of the times of day"):
        vr.Record.read(tmp_path / "two.csv", "y", **HOW)
    np.testing.assert_allclose(
        vr.Record.read(tmp_path / "two.csv", "y", time="Time", **HOW).times, TIMES, atol=1e-9
    )


@pytest.mark.parametrize("first", [0.0, -180.0])
def test_angles_that_begin_again_are_counted_on(first, tmp_path):
    """A pendulum about where the counting begins was a square wave; a dropout stays one."""
    angle = 20.0 * np.cos(40.0 * TIMES) + first
    lines = "".join(f"{t},{(a - first) % 360.0 + first}\n" for t, a in zip(TIMES, angle, strict=True))
    (tmp_path / "turn.csv").write_text("t [s],angle [deg]\n" + lines)
    about = {"place": "beam.end", "quantity": "rotation", "direction": "x"}
    found = vr.Record.read(tmp_path / "turn.csv", "angle", **about)
    np.testing.assert_allclose(found.values - found.values[0], np.deg2rad(angle - angle[0]), atol=1e-12)


def test_angles_under_torques(tmp_path):
    """A table of a torsion test: loads are moments, what they moved is a turn; they were refused as no forces."""
    (tmp_path / "twist.csv").write_text("Torque [N mm],Angle [deg]\n0,0\n50,45\n100,90\n")
    table = {
        "kind": "static",
        "file": "twist.csv",
        "place": "shaft.end",
        "direction": "x",
        "quantity": "rotation",
    }
    found = record_of(table, tmp_path)
    assert found.loads == pytest.approx([0.0, 0.05, 0.1])
    assert found.values == pytest.approx(np.pi * np.array([0.0, 0.25, 0.5]))
    assert found.axes[0][1] == "rad"


@pytest.mark.parametrize("branch", ["loading", "unloading"])
def test_pressure_is_a_load_below_zero(branch, tmp_path):
    """Loads that fall from nothing to -2 N, as presses write them, and back; the lowest is first."""
    (tmp_path / "press.csv").write_text("F [N],s [mm]\n0,0\n-1,-3\n-2,-6\n-1,-4\n0,-0.5\n")
    table = {"kind": "static", "file": "press.csv", "place": "bar.end", "direction": "x"}
    with pytest.raises(vr.InputError, match="the loads go up to -2 in row 3, and back; give branch"):
        record_of(table, tmp_path)
    found = record_of({**table, "branch": branch}, tmp_path)
    assert found.loads.tolist() == [-2.0, -1.0, 0.0]
    assert found.values == pytest.approx([-6e-3, *((-3e-3, 0.0) if branch == "loading" else (-4e-3, -5e-4))])
    (tmp_path / "press.csv").write_text("F [N],s [mm]\n0,0\n-1,-3\n-2,-6\n")
    assert record_of(table, tmp_path).loads.tolist() == [-2.0, -1.0, 0.0]


def test_seconds_since_1970_count_from_the_first_and_other_columns_of_times_are_named(tmp_path):
    (tmp_path / "log.csv").write_text(
        "ms since 1970,tip [mm]\n1764583200000,1\n1764583200005,OVR\n1764583200010,3\n"
    )
    about = {"place": "beam.end", "quantity": "displacement", "direction": "y"}
    found = vr.Record.read(tmp_path / "log.csv", "tip", time_unit="ms", gaps="leave out", **about)
    assert found.times == pytest.approx([0.0, 0.01], abs=2.4e-7)  # what doubles resolve of 1.8e9
    (tmp_path / "gom.csv").write_text("Stage;Time [s];P1.Y [mm]\n0;0,0;1\n1;0,1;2\n")
    wanted = r"of column Stage; .* or the column that has times: time = 'Time'"
    with pytest.raises(vr.InputError, match=wanted):
        vr.Record.read(tmp_path / "gom.csv", "P1.Y", **about)

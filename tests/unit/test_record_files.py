"""Tables of a load or motion over time from files, as programs and instruments write them."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

TIMES, VALUES = (0.0, 0.01, 0.02), (0.0, 1.5, -0.25)


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("0,0\n0.01,1.5\n0.02,-0.25\n", {}),
        ("t,a\n0,0\n0.01,1.5\n0.02,-0.25\n", {"time_column": "t", "value_column": "a"}),
        ("# a shake\nTime [ms];Accel [mm/s^2]\n0;0\n10;1500\n20;-250\n", {"value_column": "accel"}),
        ("Zeit (ms);Weg (mm)\n0;0\n10;1500,0\n20;-250,0\n\n", {}),
        ("\ufefftime/ms\tforce/kN\n0\t0\n10\t1.5E-3\n20\t-2.5e-4\n", {"time_column": "TIME"}),
        ("  0.00  9 0.0\n  0.01  9 1.5\n  0.02  9 -0.25\n", {"value_column": 3}),
        ('"t","x","y"\n"0","0","0"\n"10","0","150"\n"20","0","-25"\n',
         {"time_unit": "ms", "value_column": "y", "value_unit": "cm"}),
    ],
)  # fmt: skip
def test_columns_and_units(tmp_path, text, given):
    """The same record written in seven ways, against the lists."""
    path = tmp_path / "record.csv"
    path.write_bytes(text.encode("utf-8"))
    table, lists = vr.TimeTable(file=str(path), **given), vr.TimeTable(TIMES, VALUES)
    at = np.linspace(-0.01, 0.03, 41)
    assert [table.value(t) for t in at] == pytest.approx([lists.value(t) for t in at], rel=1e-12, abs=1e-12)
    assert table.breakpoints == pytest.approx(TIMES)
    assert vr.TimeTable(**{k: v for k, v in table.to_dict().items() if k != "kind"}) == table


def test_a_head_in_latin_1(tmp_path):
    path = tmp_path / "winkel.txt"
    path.write_bytes("Zeit [s];Winkel [°]\n0;0\n1;90\n".encode("latin-1"))
    assert vr.TimeTable(file=str(path)).value(1.0) == pytest.approx(np.pi / 2.0)


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        ("t,a\n0,0\n0.1,x\n", {}, "line 3 is not like the line of 2 numbers"),
        ("t,a\n0,0\n0.1,1,2\n", {}, "line 3 is not like the line of 2 numbers"),
        ("t,a\n0,0\n0.1,1\n", {"value_column": "b"}, "no column has this name; give its number, from 1, or one of"),
        ("t,a\n0,0\n0.1,1\n", {"value_column": 3}, "the table has 2 columns"),
        ("a,a\n0,0\n0.1,1\n", {"value_column": "a"}, "several columns have this name"),
        ("t,a (furlong)\n0,0\n0.1,1\n", {}, "the unit 'furlong' of the column is not known here"),
        ("t,a [mm]\n0,0\n0.1,1\n", {"value_unit": "cm"}, "the file says 'mm'"),
        ("nothing\n", {}, "there are no lines with two numbers"),
        ("0,0\n1,1\n0.5,0\n", {}, "times must not decrease"),
        ("0,0\n1,nan\n", {}, "times and values must be finite"),
        (None, {}, "there is no such file"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused(tmp_path, text, given, message):
    path = tmp_path / "record.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(vr.InputError, match=message):
        vr.TimeTable(file=str(path), **given)


def test_lists_and_file_do_not_go_together(tmp_path):
    with pytest.raises(vr.InputError, match="leave out times and values"):
        vr.TimeTable(TIMES, VALUES, file=str(tmp_path / "record.csv"))
    with pytest.raises(vr.InputError, match="give times, or file"):
        vr.TimeTable()


def test_a_case_file_names_the_record_beside_it(tmp_path):
    """The path goes from the case file on, and the load is that of the file."""
    (tmp_path / "shake.csv").write_text("t [s],a [g]\n0,0\n1,0.5\n2,0\n")
    case = tmp_path / "case.toml"
    case.write_text(
        """
        [rods.bar]
        shape = "straight"
        start = [0, 0, 0]
        end = [1, 0, 0]
        section = { shape = "circle", radius = "10 mm" }
        material = { youngs_modulus = "210 GPa", poissons_ratio = 0.3, density = 7850 }
        [[supports]]
        kind = "clamp"
        at = "bar.start"
        [[loads]]
        kind = "gravity"
        acceleration = [0, -1, 0]
        time = { kind = "table", file = "shake.csv" }
        [simulate]
        duration = 2
        """
    )
    (load,) = vr.load_case(case).description.loads
    assert load.factor(0.5) == pytest.approx(0.25 * 9.80665)

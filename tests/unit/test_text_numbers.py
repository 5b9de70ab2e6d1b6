"""Numbers and tables as text: prefixes, digits, widths, against values written out by hand."""

import numpy as np
import pytest

from viscorod.results.text_numbers import above_rounding, even, number, per_cent, percent, quantity, scaled
from viscorod.results.text_table import WIDTH, listed, numbers, page, table, tabulated, words
from viscorod.shown import span


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (2.78839e-6, "m", "2.78839 µm"),
        (9.6e-9, "s", "9.6 ns"),
        (6.97e-12, "J", "6.97 pJ"),
        (1.5e-19, "J", "150 zJ"),
        (155e9, "Pa", "155 GPa"),
        (3e25, "Pa", "30 YPa"),
        (0.3, "m", "0.3 m"),
        (0.01, "m", "0.01 m"),
        (9999.0, "N", "9999 N"),
        (-2.5e-5, "N m", "-25 µN m"),
        (1.53e-12, "kg", "1.53 ng"),
        (2.5e5, "kg", "250 Mg"),
        (1.0e-8, "kg/m", "10 µg/m"),
        (2.0e5, "1/m", "200 1/mm"),
        (2.0e-5, "m^2", "2e-05 m^2"),
        (0.0, "s", "0 s"),
        (999.9999999999999e-6, "s", "1 ms"),
        (1e-40, "s", "1e-16 ys"),
    ],
)
def test_prefixes_down_to_what_there_is(value, unit, text):
    assert quantity(value, unit) == text


def test_the_largest_of_several_chooses_the_prefix():
    assert scaled("s", [1e-9, -3e-5, 0.0]) == (1e6, "µs")
    assert scaled("s", []) == (1.0, "s")


def test_digits():
    assert number(-0.0) == "0"
    assert number(1e-17, size=1.0) == "0"
    assert number(1e-17) == "1e-17"
    assert [number(31.0, 1), number(312.0, 1), number(0.00312, 1)] == ["30", "300", "0.003"]
    assert even([0.0, 60.7605e-9, 364.246e-9]) == ["0", "6.07605e-08", "3.64246e-07"]
    assert even([0.0, 60.7604, 364.2461]) == ["0.000", "60.760", "364.246"]
    assert even([0.09, 0.00044754], 3) == ["0.090000", "0.000448"]
    assert even([0.0, 0.0]) == ["0", "0"]


@pytest.mark.parametrize(("part", "text"), [(0.921099, "92.11 %"), (-7e-4, "-0.07 %"), (1e-8, ""), (0.0, "")])
def test_percentages_of_next_to_nothing_are_not_told(part, text):
    assert percent(part) == text


def test_columns_never_run_together_and_fit():
    long = [f"a_very_long_name_of_a_place_{k}.start" for k in range(3)]
    text = tabulated(
        "Places",
        words("place", long),
        numbers(("x", "y", "z"), "m", [[1.23456e-6, -1.23456e-6, 1e-22]] * 3),
        numbers(("moved x", "y", "z"), "m", [[1.23456e-9, -1.23456e-9, 0.0]] * 3),
    )
    assert max(map(len, text.splitlines())) <= WIDTH
    assert text.splitlines()[1].split() == ["place", "x", "[µm]", "y", "[µm]", "z", "[µm]"]
    assert text.splitlines()[2].split() == [long[0], "1.23456", "-1.23456", "0"]
    assert text.splitlines()[5].split()[1:4] == ["moved", "x", "[nm]"]


def test_long_texts_in_a_table_wrap_at_words():
    sentence = "a sentence that is much longer than what is left of the line, at 118 kHz"
    text = table("Title", ("name", "text"), [("x" * 30, sentence)])
    assert max(map(len, text.splitlines())) <= WIDTH
    assert " ".join(text.split()).endswith(sentence)
    assert "118\n" not in text


def test_pages_wrap_at_words_and_leave_numbers_beside_their_units():
    heading = "The largest displacement of the end of the rod over the whole of the motion: 5.566 µm"
    text = page([heading, "", listed("Warnings", ["word " * 40])])
    assert max(map(len, text.splitlines())) <= WIDTH
    assert "5.566 µm" in text
    assert text.count("\n\n") == 1
    assert all(line.startswith("    word") for line in text.splitlines()[5:])


def test_round_off_has_no_prefix():
    """Moments of 1e-16 N m beside forces of 1 N on a model of 1 m are none: they are not told in pN m."""
    assert numbers(("mx", "my"), "N m", [[1e-16, 0.0]], size=1.0) == [
        ("mx [N m]", ["0"]),
        ("my [N m]", ["0"]),
    ]
    assert numbers(("mx",), "N m", [2e-3, 1e-16], size=1.0) == [("mx [mN m]", ["2", "0"])]


def test_names_longer_than_half_of_the_width_stand_above_their_numbers():
    """As the keys of a fit, of which each takes one line and its numbers another."""
    key = "materials.rubber.damping.shear_time, materials.rubber.damping.bulk_time"
    header = ("", "value", "low", "high", "unit", "standard error", "interval by")
    row = ("0.02", "0.0199", "0.0201", "s", "2.9e-05", "Laplace")
    lines = table("Numbers", header, [(key, *row)]).splitlines()
    assert [line.split() for line in lines[1:]] == ["  ".join(header).split(), key.split(), list(row)]
    assert max(map(len, lines)) <= WIDTH


def test_what_rounding_leaves_of_a_damping_ratio_is_none():
    """Eigenvalues of an undamped blade that turns told 2.7e-10; the least damped resonators of quartz have 1e-8."""
    assert above_rounding(np.array([2.7e-10, -4.3e-11, 1e-8, -0.02])).tolist() == [0.0, 0.0, 1e-8, -0.02]


@pytest.mark.parametrize(
    ("value", "text"), [(330.0, "330 %"), (2.94, "2.9 %"), (1e-3, "0.001 %"), (0.0, "0 %")]
)
def test_per_cent_beyond_a_hundred_have_no_exponent(value, text):
    assert per_cent(value) == text


@pytest.mark.parametrize(
    ("ends", "text"),
    [
        ((27518.0, 172430.0, "Hz"), "27.52 to 172.4 kHz"),
        ((0.0, 2e-5, "s"), "0 to 20 µs"),
        ((1.0, 1.0, ""), "1"),
    ],
)
def test_a_range_has_one_prefix(ends, text):
    assert span(*ends) == text

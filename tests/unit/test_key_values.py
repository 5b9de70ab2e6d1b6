"""Keys with values on the command line, where shells take quotes away."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.plain_text import flat
from viscorod.cli.app import app
from viscorod.cli.key_values import column_of, drawn, grid_of, value_of

READ = [
    ("1 um,2 um", ["1 um", "2 um"]),
    ("1um, 2.5e-3 mm", ["1 um", "2.5e-3 mm"]),
    ("1,2e-3,.5e1", None),
    ("1e-3,1e3", [1e-3, 1e3]),
    ("[0 N, 0, 1 uN]", [["0 N", 0, "1 uN"]]),
    ("[0,1,2],[3,4,5]", [[0, 1, 2], [3, 4, 5]]),
    ("200 GPa,2e5 N/mm^2", ["200 GPa", "2e5 N/mm^2"]),
    ('"thin","thick"', ["thin", "thick"]),
    ("'1 um','2 um'", ["1 um", "2 um"]),
    ("3 N m", ["3 N m"]),
    ("5 µm,20 °C", ["5 µm", "20 °C"]),
    ("true,0x10", [True, 16]),
    ("thin", None),
    ("1:2", None),
    ("", None),
]


@pytest.mark.parametrize(("text", "values"), READ)
def test_values_are_those_of_a_case_file_and_quantities_need_no_quotes(text, values):
    if values is not None:
        assert column_of(f"a.b={text}") == ("a.b", values)
        return
    with pytest.raises(vr.InputError, match="give a key and values as in a case file"):
        column_of(f"a.b={text}")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("rubbish", "there is no ="),
        ("=3", "the key is missing"),
        ("a.b=", "the value is missing"),
        ("a.b=1,2", "one value is needed"),
    ],
)
def test_one_key_with_one_value_or_what_is_missing(text, what):
    assert value_of("a.b=1 um") == ("a.b", "1 um")
    with pytest.raises(vr.InputError, match=rf"^--set {text}: {what}"):
        value_of(text)


def test_ranges_have_units():
    assert grid_of("a=1 um:3 um:3") == ("a", ["1.0 um", "2.0 um", "3.0 um"])
    assert grid_of("a=1e-6:3e-6:3") == ("a", [1e-6, 2e-6, 3e-6])
    assert grid_of("a=1 um, 3 um") == ("a", ["1 um", "3 um"])
    for wrong in ("1 um:3 mm:3", "a:b:3", "1:2:1"):
        with pytest.raises(vr.InputError, match="of one unit if they have one, and a number of 2 or more"):
            grid_of(f"a={wrong}")
    with pytest.raises(vr.InputError, match=r"a range such as 0\.01:0\.05:9"):
        grid_of("a=1e-6:3e-6")


def test_distributions_of_counts_are_drawn_too():
    key, found = drawn("rods.beam.elements=randint(1, 4)")
    assert key == "rods.beam.elements"
    assert found.support() == (1, 3)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (
            ["sweep", "--set", "rods.beam.elements=1", "--set", "rods.beam.elements=2"],
            "--set rods.beam.elements: it is",
        ),
        (["sweep", "--grid", "rods.beam.elements=1,2", "--grid", "rods.beam.elements=3,4"], "KEY=1,2"),
        (
            ["sweep", "--grid", "rods.beam.elements=[1, 2]"],
            "this is one value, a list; leave out the brackets",
        ),
        (["run", "--set", "rods.beam.elements=1", "--set", "rods.beam.elements=2"], "it is given twice"),
        (
            ["sweep", "--set", "rods.beam.elements=1,2", *["--quantity", "f=frequency 1"] * 2],
            "--quantity f: it is",
        ),
        (
            ["ensemble", "-n", "8", *["--draw", "rods.beam.end[0]=norm(1, 0.1)"] * 2],
            "--draw rods.beam.end[0]: it",
        ),
    ],
)
def test_what_is_given_twice_or_in_brackets_is_refused(command, words, tmp_path, monkeypatch):
    """Only the last of two counted, without a word."""
    monkeypatch.chdir(tmp_path)
    case = Path(__file__).parents[2] / "examples" / "cantilever_swing.toml"
    told = CliRunner().invoke(app, [command[0], str(case), *command[1:]])
    assert told.exit_code == 2
    assert words in flat(told.stderr)
    assert not list(tmp_path.iterdir())


def test_parameters_with_units_are_told_where_units_go():
    with pytest.raises(vr.InputError, match=r'9.5 mm is no number.*"width \[mm\]=uniform'):
        drawn("width=uniform(9.5 mm, 1)")

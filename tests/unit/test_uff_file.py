"""Universal files as laboratories write them: several kinds of functions, several abscissae, units that differ."""

import numpy as np
import pytest

import viscorod as vr

pytest.importorskip("pyuff", reason="UFF files need the extra viscorod[records]")
LINES = np.arange(1.0, 41.0)
ACCELERANCE = 1.0 / (1.0 - (LINES / 12.3) ** 2 + 0.04j * LINES / 12.3)
"""(m/s^2)/N."""


def function(kind, response, reference, values, quantity=(0, 0), labels=("NONE", "NONE"), step=1.0):
    """A data set 58 by the fixed format of its definition, single precision, even abscissa."""
    complex_values = np.iscomplexobj(values)
    numbers = np.column_stack([values.real, values.imag]).ravel() if complex_values else values
    abscissa = 17 if kind == 1 else 18
    rows = ["    -1", "    58", *["NONE"] * 5]
    rows.append(
        f"{kind:5d}{1:10d}{0:5d}{0:10d} {'NONE':<10s}{response[0]:10d}{response[1]:4d} "
        f"{'NONE':<10s}{reference[0]:10d}{reference[1]:4d}"
    )
    first = 0.0 if kind == 1 else 1.0
    rows.append(
        f"{5 if complex_values else 2:10d}{len(values):10d}{1:10d}{first:13.5E}{step:13.5E}{0.0:13.5E}"
    )
    for code, label in ((abscissa, "NONE"), *zip(quantity, labels, strict=True), (0, "NONE")):
        rows.append(f"{code:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20s} {label:<20s}")
    rows += ["".join(f"{x:13.5E}" for x in numbers[k : k + 6]) for k in range(0, len(numbers), 6)]
    return "\n".join([*rows, "    -1", ""])


def units(length, force):
    numbers = "".join(f"{x:25.17E}".replace("E", "D") for x in (length, force, 1.0))
    temperature = f"{273.15:25.17E}".replace("E", "D")
    return f"    -1\n   164\n{9:10d}{'own':<20s}{1:10d}\n{numbers}\n{temperature}\n    -1\n"


def read(tmp_path, text, value="2:+z/1:-z", name="a.uff", **more):
    (tmp_path / name).write_text(text)
    return vr.ResponseRecord.read(tmp_path / name, value, **more)


SEVERAL = [
    function(6, (2, 3), (1, -3), np.full(40, 0.98)),
    function(4, (2, 3), (1, -3), ACCELERANCE, (12, 13)),
    function(2, (2, 3), (2, 3), np.ones(40), (12, 0)),
    function(1, (2, 3), (0, 0), np.sin(0.1 * np.arange(60.0)), (12, 0), step=0.01),
]


def test_a_response_is_found_among_coherences_spectra_and_histories(tmp_path):
    for text in ("".join(SEVERAL), "".join(SEVERAL[::-1])):
        assert read(tmp_path, text).values == pytest.approx(ACCELERANCE, rel=1e-4)
    how = {"place": "bar.end", "quantity": "acceleration", "direction": "z"}
    history = vr.Record.read(tmp_path / "a.uff", "2:+z", **how)
    assert history.values == pytest.approx(np.sin(0.1 * np.arange(60.0)), abs=1e-5)
    with pytest.raises(vr.InputError, match=r"no function has this name; give one of .*2:\+z/1:-z"):
        read(tmp_path, "".join(SEVERAL), "3:+z/1:-z")


@pytest.mark.parametrize(
    ("before", "labels", "size"),
    [
        (units(1000.0, 1000.0), ("mm/s^2", "mN"), 1.0),
        (units(1000.0, 1.0), ("NONE", "NONE"), 1e-3),
        ("", ("g", "N"), 9.80665),
        ("", ("g/N", "NONE"), 9.80665),
        ("", ("(mm/s^2)/N", "NONE"), 1e-3),
        ("", ("remark", "N"), 1.0),
        ("", ("a/b", "NONE"), 1.0),
    ],
    ids=[
        "mm and mN",
        "mm and N",
        "g by its label",
        "g/N in one label",
        "mm/s^2/N in one",
        "no unit",
        "no units",
    ],
)
def test_units_are_those_of_data_set_164_or_of_the_labels(tmp_path, before, labels, size):
    found = read(tmp_path, before + function(4, (2, 3), (1, -3), ACCELERANCE, (12, 13), labels), name="a.txt")
    assert found.values == pytest.approx(size * ACCELERANCE, rel=1e-4)


def test_units_that_contradict_each_other_are_asked_for(tmp_path):
    text = units(1.0, 1.0) + function(4, (2, 3), (1, -3), ACCELERANCE, (12, 13), ("g", "N"))
    with pytest.raises(vr.InputError, match="its unit is not known; give unit"):
        read(tmp_path, text)
    assert read(tmp_path, text, unit="g/N").values == pytest.approx(9.80665 * ACCELERANCE, rel=1e-4)

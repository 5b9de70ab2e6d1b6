"""Tables as instruments export them: names, units, separators and decimal commas."""

import math

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.dma_table import read_dma_table

FREQUENCY, STORAGE, LOSS = [0.1, 1.0, 10.0], [1.0e6, 1.5e6, 2.0e6], [1.0e5, 3.0e5, 5.0e5]

PLAIN = """Frequency (Hz), Storage Modulus (MPa), Loss Modulus (MPa)
0.1, 1.0, 0.1
1, 1.5, 0.3
10, 2.0, 0.5
"""
# the layout of TA Instruments' TRIOS as text: blocks of keys, a step, names and a line of units, tabs
TRIOS = """Filename\tsweep
[File Parameters]
Name\tsweep
Company name\tMaker
[step]
Frequency sweep - 1
Ang. frequency\tStorage modulus\tLoss modulus\tTan(delta)\tTemperature
rad/s\tPa\tPa\t\t°C
{}\t1.0e6\t1.0e5\t0.1\t25.0
{}\t1.5e6\t3.0e5\t0.2\t25.0
{}\t2.0e6\t5.0e5\t0.25\t25.0
""".format(*[repr(2.0 * math.pi * f) for f in FREQUENCY])
# NETZSCH Proteus: keys after #, the names after ##, units behind a slash, decimal commas
NETZSCH = """#EXPORTTYPE:;DATA ALL
#DECIMAL:;COMMA
#SEPARATOR:;SEMICOLON
##Temp./°C;f/Hz;E'/MPa;E''/MPa;tan d/-
25,0;0,1;1,0;0,1;0,1
25,0;1,0;1,5;0,3;0,2
25,0;10,0;2,0;0,5;0,25
"""
# the layout of RepTate's .osc files and others: symbols with the units below, double prime as a quotation mark
SYMBOLS = "f\tE'\tE\"\nHz\tkPa\tkPa\n10\t2000\t500\n0.1\t1000\t100\n1\t1500\t300\n"
OTHER_COLUMNS = """Temperature (C), Frequency (Hz), Storage Modulus (MPa), Displacement (um), Loss Modulus (MPa)
25, 0.1, 1.0, 20, 0.1
25, 1, 1.5, 20, 0.3
25, 10, 2.0, n.a., 0.5
"""
TAN_DELTA = 'freq. [Hz];"Storage modulus [MPa]";tan delta\n0,1;1;0,1\n1;1,5;0,2\n10;2;0,25\n'


def written(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "dma.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (PLAIN, "utf-8"),
        (PLAIN, "utf-8-sig"),
        (PLAIN.replace("\n", "\r\n"), "utf-16"),
        ("# a remark\n\n" + PLAIN.replace("1, 1.5", "# left out\n\n1, 1.5"), "utf-8"),
        (TRIOS, "utf-8"),
        (NETZSCH, "latin-1"),
        (SYMBOLS, "utf-8"),
        (TAN_DELTA, "utf-8"),
        (OTHER_COLUMNS, "utf-8"),
    ],
)  # fmt: skip
def test_layouts(tmp_path, text, encoding):
    table = read_dma_table(written(tmp_path, text, encoding))
    np.testing.assert_allclose(table.omega, 2.0 * np.pi * np.array(FREQUENCY), rtol=1e-15)
    np.testing.assert_allclose(table.storage, STORAGE, rtol=1e-15)
    np.testing.assert_allclose(table.loss, LOSS, rtol=1e-15)


@pytest.mark.parametrize(
    ("unit", "pascal"),
    [("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("Mpa", 1e6), ("GPa", 1e9), ("N/mm²", 1e6), ("N/m^2", 1.0),
     ("psi", 6894.757293168361)],
)  # fmt: skip
def test_units_of_the_modulus(tmp_path, unit, pascal):
    table = read_dma_table(written(tmp_path, f"f [Hz];E' [{unit}];E'' [{unit}]\n1;2;3\n"))
    assert (table.storage[0], table.loss[0]) == pytest.approx((2.0 * pascal, 3.0 * pascal), rel=1e-15)


def test_units_by_keys(tmp_path):
    path = written(tmp_path, "frequency,storage,loss\n1,2,3\n")
    table = read_dma_table(path, frequency_unit="rad/s", modulus_unit="kPa")
    assert (table.omega[0], table.storage[0], table.loss[0]) == (1.0, 2000.0, 3000.0)


@pytest.mark.parametrize(
    ("storage", "strain"),
    [("E'/Pa", "extension"), ("G' (Pa)", "shear"), ("Storage Modulus (Pa)", None),
     ("E'-Storage Modulus (Pa)", "extension"), ("Tensile storage modulus (Pa)", "extension"),
     ("Shear storage modulus (Pa)", "shear")],
)  # fmt: skip
def test_names_tell_the_strain(tmp_path, storage, strain):
    table = read_dma_table(written(tmp_path, f"f (Hz);{storage};Loss modulus (Pa)\n1;2;3\n"))
    assert table.strain == strain


@pytest.mark.parametrize(
    ("beside", "strain"),
    [("Shear Strain (%)", "shear"), ("Torque (mN m)", "shear"), ("Schubspannung (Pa)", "shear"), ("Strain (%)", None)],
)  # fmt: skip
def test_columns_beside_the_moduli_tell_the_strain_of_a_rheometer(tmp_path, beside, strain):
    """Its storage modulus is G'; it was read as E', a third of it."""
    text = f"f (Hz);Storage Modulus (Pa);Loss Modulus (Pa);{beside}\n1;2;3;4\n"
    assert read_dma_table(written(tmp_path, text)).strain == strain


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no line names columns"),
        ("1, 2, 3\n", "no line names columns"),
        ("Frequency (Hz), Storage modulus (Pa)\n1, 2\n", "loss modulus or tan delta"),
        ("frequency, storage (Pa), loss (Pa)\n1,2,3\n", "unit of the column of frequency; .*frequency_unit"),
        (
            "frequency (Hz), storage, loss (Pa)\n1,2,3\n",
            "unit of the column of storage modulus; .*modulus_unit",
        ),
        ("frequency (1/s), storage (Pa), loss (Pa)\n1,2,3\n", "the unit '1/s' .*use one of Hz, kHz, rad/s"),
        ("frequency (Hz), storage (mPa), loss (Pa)\n1,2,3\n", "the unit 'mPa'"),
        (
            "f (Hz), E' (Pa), G' (Pa), loss (Pa)\n1,2,3,4\n",
            "line 1 names two columns for the same: E' .* and G'",
        ),
        (PLAIN.replace("1.5", "low"), "line 3: the storage is not usable; give a number > 0"),
        (PLAIN.replace("0.3", "little"), "'little': line 3: the loss is not usable"),
        (PLAIN.replace("1, 1.5, 0.3", "1, 1.5"), "line 3 has 2 cells, and line 1 names 3"),
        (PLAIN + "1, 1.9, 0.3\n", "one frequency has different storage moduli.*keep one sweep"),
        (PLAIN.splitlines()[0], "no numbers below"),
        ("f (Hz);E' (Pa);E'' (Pa)\n1;2,5;3.5\n", "both points and commas"),
    ],
)
def test_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_dma_table(written(tmp_path, text))
    (problem,) = caught.value.problems
    assert problem.instead


def test_units_may_not_contradict_the_file(tmp_path):
    with pytest.raises(InputError, match="in MPa, and modulus_unit says Pa"):
        read_dma_table(written(tmp_path, PLAIN), modulus_unit="Pa")


def test_files_that_are_none(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="no such file"):
        read_dma_table(tmp_path / "absent.csv")
    with pytest.raises(InputError, match="this is a folder"):
        read_dma_table(tmp_path)
    with pytest.raises(InputError, match="no file can have this name"):
        read_dma_table("\0")
    with pytest.raises(InputError, match=r"no such file|cannot be read"):
        read_dma_table("y" * 5000)
    monkeypatch.setattr("viscorod.model.materials.table_text.LARGEST_TABLE", 10)
    with pytest.raises(InputError, match="larger than any table"):
        read_dma_table(written(tmp_path, PLAIN))

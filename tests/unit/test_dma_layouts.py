"""Tables in the layouts of common programs: each holds the same three rows, or one row too few to know."""

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.complex_moduli import ComplexModuli
from viscorod.model.materials.dma_table import read_dma_table
from viscorod.model.materials.material import Material

FREQUENCY, STORAGE, LOSS = [0.1, 1.0, 10.0, 100.0], [2.0e6, 2.3e6, 2.6e6, 3.0e6], [2.0e5, 2.6e5, 3.2e5, 4.4e5]
ROWS = list(zip(FREQUENCY, STORAGE, LOSS, strict=True))


def lines(pattern: str, unit: float = 1e6) -> str:
    """Return a row for each of the four points: {f} Hz, {w} rad/s, {s}, {l} and {c} in the unit, {t}, {p} degrees."""
    text = ""
    for k, (f, s, loss) in enumerate(ROWS):
        text += pattern.format(
            i=k + 1,
            f=f"{f:g}",
            w=repr(2.0 * np.pi * f),
            s=f"{s / unit:.10g}",
            l=f"{loss / unit:.10g}",
            c=f"{np.hypot(s, loss) / unit:.6g}",
            t=repr(loss / s),
            t2=f"{loss / s:.2f}",
            pc=repr(100.0 * loss / s),
            p=repr(float(np.degrees(np.arctan2(loss, s)))),
            lf=f"{np.log10(f):g}",
            K=f"{293.15 + 0.01 * k:.2f}",
        )
    return text


def german(text: str) -> str:
    return text.replace(".", ",")


LAYOUTS = {
    "pyvisco, two lines, blanks after commas": "f, E_stor, E_loss\nHz, MPa, MPa\n" + lines("{f},{s},{l}\n"),
    "pyvisco raw, one set": "f,E_stor,E_loss,T,Set\nHz, MPa, MPa, C, -\n" + lines("{f},{s},{l},20.0,0\n"),
    "Eplexor text, blanks, units in brackets":
    '   Index     f     E\'     E"   tan_delta\n   [#]   [Hz]   [MPa]   [MPa]   []\n'
    + lines("   {i}   {f}   {s}   {l}   {t}\n"),
    "STARe text with a footer and a force F beside f":
    "         Index            Ts             t             f             F"
    '            Tr            E\'            E"            E*     tan_delta\n'
    "           [#]          [°C]           [s]          [Hz]           [N]          [°C]         [MPa]         [MPa]"
    "         [MPa]            []\n" + lines("     {i}  1.95e+01  0.0e+00  {f}  2.9e+00  2.0e+01  {s}  {l}  {c}  {t}\n")
    + "]5[made_up_Freq0.1-100_\n",
    "STARe, moduli called M": '  t   f   M\'   M"   tan delta\n  [s]   [Hz]   [MPa]   [MPa]   []\n'
    + lines("  1   {f}   {s}   {l}   {t}\n"),
    "data frame, units in the names": "freq_hz,E_storage_pa,E_loss_pa\n" + lines("{f},{s},{l}\n", 1.0),
    "data frame with an index": ",frequency_Hz,storage_modulus_MPa,loss_modulus_MPa\n" + lines("{i},{f},{s},{l}\n"),
    "data frame, angular": "omega_rad_s,G_prime_Pa,G_double_prime_Pa\n" + lines("{w},{s},{l}\n", 1.0),
    "data frame of R": '"Frequency..Hz.","Storage.Modulus..MPa.","Loss.Modulus..MPa."\n' + lines("{f},{s},{l}\n"),
    "camel case": "AngularFrequency[rad/s],StorageModulus[kPa],LossModulus[kPa]\n" + lines("{w},{s},{l}\n", 1e3),
    "TRIOS csv with both frequencies": "Angular frequency,Frequency,Storage modulus,Loss modulus\nrad/s,Hz,MPa,MPa\n"
    + lines("{w},{f},{s},{l}\n"),
    "TRIOS text with a step, angular frequency, tan(delta)":
    "Filename\tx.tri\nInstrument name\tDMA850\n\n[step]\n"
    "Frequency sweep - 1\nStorage modulus\tLoss modulus\tTan(delta)\tAngular frequency\tOscillation torque\tStep time\t"
    "Temperature\tStatus\nMPa\tMPa\t\trad/s\tµN.m\ts\t°C\t\n" + lines("{s}\t{l}\t{t}\t{w}\t100\t9\t20.0\t\n"),
    "RheoCompass, rows begin empty": "Project:\tmade up\nTest:\tA\n\nInterval and data points:\t1\t4\n"
    "Interval data:\tPoint No.\tAngular Frequency\tStorage Modulus\tLoss Modulus\tLoss Factor\tTorque\tStatus\n"
    "\t\t\t\t\t\t\t\n\t\t[rad/s]\t[Pa]\t[Pa]\t[1]\t[mN·m]\t\n\n" + lines("\t{i}\t{w}\t{s}\t{l}\t{t2}\t3\t\n", 1.0),
    "RheoCompass, a label before the names only": "Interval data:\tAngular Frequency\tG'\tG''\t|G*|\n"
    "\t[rad/s]\t[Pa]\t[Pa]\t[Pa]\n" + lines("{w}\t{s}\t{l}\t{c}\n", 1.0),
    "RheoCompass in German":
    "Projekt:\tProbe\nIntervalldaten:\tMesspunkt-Nr.\tKreisfrequenz\tSpeichermodul\tVerlustmodul\t"
    "Verlustfaktor\n\t\t[1/s]\t[Pa]\t[Pa]\t[1]\n" + german(lines("\t{i}\t{w}\t{s}\t{l}\t{t}\n", 1.0)),
    "Proteus": "#EXPORTTYPE:;DATA ALL\n#DECIMAL:;COMMA\n##Temp./°C;Zeit/min;f/Hz;E'/MPa;E''/MPa;tan d/-\n"
    + german(lines("20.0;0.1;{f};{s};{l};{t}\n")),
    "Gabo in German": "Frequenz in Hz;Speichermodul E' in MPa;Verlustmodul E'' in MPa;tan δ\n"
    + german(lines("{f};{s};{l};{t}\n")),
    "Excel, comma after the name":
    "sep=;\nFrequency, Hz;Storage modulus, MPa;Loss modulus, MPa\n" + lines("{f};{s};{l}\n"),
    "Excel, decimal commas in quotes": "Frequency (Hz),E' (MPa),E'' (MPa)\n"
    + german(lines('"{f}"_"{s}"_"{l}"\n')).replace("_", ","),
    "typographic primes": "f (Hz)\tE′ (MPa)\tE″ (MPa)\n" + lines("{f}\t{s}\t{l}\n"),
    "curly primes": "f (Hz)\tG’ (MPa)\tG” (MPa)\n" + lines("{f}\t{s}\t{l}\n"),
    "symbols over units in slashes": "ω/(rad/s);G'/MPa;G''/MPa\n" + lines("{w};{s};{l}\n"),
    "single blanks": "f E' E''\nHz MPa MPa\n" + lines("{f} {s} {l}\n"),
    "single blanks, units beside": "f (Hz) E' (MPa) E'' (MPa)\n" + lines("{f} {s} {l}\n"),
    "a frame printed": "   freq_hz  E_storage_mpa  E_loss_mpa\n" + lines("   {f}   {s}   {l}\n"),
    "tan delta in percent": "f [Hz];E' [MPa];tan delta [%]\n" + lines("{f};{s};{pc}\n"),
    "phase angle": "Frequency (Hz),Storage modulus (MPa),Phase angle (°)\n" + lines("{f},{s},{p}\n"),
    "exponents of Fortran": "f (Hz)  E' (Pa)  E'' (Pa)\n" + "".join(
        f"{f:.5e}  {s:.5e}  {loss:.5e}\n" for f, s, loss in ROWS).replace("e", "D"),
    "kilohertz and thousands": "f (kHz);E' (kPa);E'' (kPa)\n0.0001;2,000.0;200.0\n0.001;2,300.0;260.0\n"
    "0.01;2,600.0;320.0\n0.1;3,000.0;440.0\n",
    "millihertz": "f (mHz);E' (MPa);E'' (MPa)\n100;2;0.2\n1000;2.3;0.26\n10000;2.6;0.32\n100000;3;0.44\n",
    "a mean below": "f (Hz);E' (MPa);E'' (MPa)\n" + lines("{f};{s};{l}\n") + "\nend of data\n",
    "temperature in kelvin": "f (Hz);E' (MPa);E'' (MPa);T (K)\n" + lines("{f};{s};{l};{K}\n"),
    "dyn/cm²": "w (rad/s)  G' (dyn/cm2)  G'' (dyn/cm2)\n" + lines("{w}  {s}  {l}\n", 0.1),
    "deviations beside": "f (Hz);E' (MPa);std E' (MPa);E'' (MPa);D' (1/MPa)\n" + lines("{f};{s};9;{l};0.5\n"),
    "two units of one modulus": "f (Hz);E' (MPa);E' (Pa);E'' (MPa)\n" + lines("{f};{s};{s}e6;{l}\n"),
    "names of rows before the columns, as R writes":
    "f_Hz E_stor_MPa E_loss_MPa tan_delta\n" + lines('"{i}" {f} {s} {l} {t}\n'),
    "bars": "| f (Hz) | E' (MPa) | E'' (MPa) |\n" + lines("| {f} | {s} | {l} |\n"),
    "a table of Markdown": "| f (Hz) | E' (MPa) | E'' (MPa) |\n|---|:--|--:|\n" + lines("| {f} | {s} | {l} |\n"),
    "Universal Analysis": "Version   V4.5A\nNsig      3\nSig1      Frequency (Hz)\nSig2      Storage Modulus (MPa)\n"
    "Sig3      Loss Modulus (MPa)\nDate      today\nStartOfData\n" + lines("{f}  {s}  {l}\n"),
    "names, symbols and units in three lines": "Frequency,Storage modulus,Loss modulus\nf,G',G''\nHz,MPa,MPa\n"
    + lines("{f},{s},{l}\n"),
    "Kinexus":
    "Frequency (Hz)(f),Shear modulus (elastic component)(Pa)(G'),Shear modulus (viscous component)(Pa)(G'')\n"
    + lines("{f},{s},{l}\n", 1.0),
    "Rheoplus in German": "Messpkt.\tKreisfrequenz\tSpeichermodul\tVerlustmodul\tDämpfungsfaktor\n"
    "\t[1/s]\t[Pa]\t[Pa]\t[1]\n" + german(lines("{i}\t{w}\t{s}\t{l}\t{t}\n", 1.0)),
    "Haake": "No.;t in s;f in Hz;ω in rad/s;G' in Pa;G\" in Pa;|G*| in Pa;tan(δ) in -;T in °C\n"
    + lines("{i};1;{f};{w};{s};{l};{c};{t};20\n", 1.0),
    "French": "Fréquence (Hz);Module de conservation (MPa);Module de perte (MPa)\n" + german(lines("{f};{s};{l}\n")),
    "savetxt": "# f [Hz] E' [MPa] E'' [MPa]\n" + lines("{f} {s} {l}\n"),
    "a frame with its index printed": "    f_hz  e_stor_mpa  e_loss_mpa\n"
    "0   0.1   2.0   0.2\n1   1.0   2.3   0.26\n2   10.0   2.6   0.32\n3   100.0   3.0   0.44\n",
    "a last column that is empty in some rows": "f [Hz]\tE' [MPa]\tE'' [MPa]\tStatus\n0.1\t2\t0.2\n1\t2.3\t.26\tok\n"
    "10\t2.6\t.32\n100\t3\t.44\n",
    "loss modulus and tan delta, no storage modulus": "f (Hz)\tE'' (MPa)\ttan delta\n" + lines("{f}\t{l}\t{t}\n"),
    "deg C among single blanks below names between two":
    "Frequency  Temperature  Storage Modulus  Loss Modulus\nHz  deg C  MPa  MPa\n" + lines("{f}  25.0  {s}  {l}\n"),
    "real and imaginary parts": "Frequency [Hz],Re(G*) [MPa],Im(G*) [MPa]\n" + lines("{f},{s},{l}\n"),
}  # fmt: skip
ENCODINGS = {"Proteus": "cp1252", "STARe text with a footer and a force F beside f": "latin-1"}


def written(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "dma.txt"
    path.write_bytes(text.encode(encoding))
    return path


def assert_the_rows(table):
    np.testing.assert_allclose(table.omega, 2.0 * np.pi * np.array(FREQUENCY), rtol=1e-5)
    np.testing.assert_allclose(table.storage, STORAGE, rtol=1e-5)
    np.testing.assert_allclose(table.loss, LOSS, rtol=1e-5)


@pytest.mark.parametrize("name", LAYOUTS)
def test_layouts(tmp_path, name):
    assert_the_rows(read_dma_table(written(tmp_path, LAYOUTS[name], ENCODINGS.get(name, "utf-8"))))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings_and_ends_of_lines(tmp_path, encoding, end):
    text = LAYOUTS["Gabo in German"].replace("\n", end)
    assert_the_rows(read_dma_table(written(tmp_path, text, encoding)))


def test_a_column_is_never_read_one_off(tmp_path):
    # |G*| = 1005 Pa of the first row belongs to G' = 1000 Pa and G'' = 100 Pa
    rows = [(0.1, 1000, 100), (0.5, 1150, 280), (1, 1300, 450), (5, 1850, 1200), (10, 2200, 1800),
            (50, 3000, 3500), (100, 3300, 4200)]  # fmt: skip
    head = "Project:\tx\nInterval and data points:\t1\t7\nInterval data:\tAngular Frequency\tG'\tG''"
    whole = f"{head}\t|G*|\n\t[rad/s]\t[Pa]\t[Pa]\t[Pa]\n" + "".join(
        f"{w}\t{s}\t{loss}\t{np.hypot(s, loss):.0f}\n" for w, s, loss in rows
    )
    table = read_dma_table(written(tmp_path, whole))
    np.testing.assert_allclose(
        np.column_stack([table.omega, table.storage, table.loss]), np.array(rows), rtol=1e-15
    )
    damping = ComplexModuli(file=str(tmp_path / "dma.txt"), of="shear", law="maxwell")
    assert (
        "from 0.01592 to 15.92 Hz"
        in Material(poissons_ratio=0.49, density=1.0, damping=damping).assumptions[0]
    )
    # nothing shows where the numbers belong
    bare = f"{head}\n\t[rad/s]\t[Pa]\t[Pa]\n" + "".join(f"{w}\t{s}\t{loss}\n" for w, s, loss in rows)
    with pytest.raises(InputError, match=r"line 5 has 3 cells, and line 3 names 4 columns"):
        read_dma_table(written(tmp_path, bare))
    # as many cells as names, and a label among the names all the same
    with pytest.raises(InputError, match=r"which column a number belongs to is not known"):
        read_dma_table(
            written(tmp_path, "Data:\tf (Hz)\tG' (Pa)\tG'' (Pa)\n0.1\t1000\t100\t25\n1\t1300\t450\t25\n")
        )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("f (Hz),E' (MPa),E'' (MPa)\n0,1,1,0,0,1\n", "line 2 has 6 cells, and line 1 names 3 columns"),
        ("f (Hz);E' (MPa);E'' (MPa);T (C)\n1;2;0.2\n", "line 2 has 3 cells, and line 1 names 4"),
        ("f (Hz);E' (MPa);E'' (MPa)\n1;2;0.2;20\n", "line 2 has 4 cells, and line 1 names 3"),
        ("w (rad/s);f (Hz);E' (MPa);E'' (MPa)\n1;1;2;0.2\n", r"contradict .*in line 2 w \(rad/s\).* is 1 and 2 pi"),
        ("f (Hz);E' (GPa);E'' (MPa);tan d\n1;2;0.2;0.1\n", "in line 2 tan d is 0.1 and loss over storage 0.0001"),
        ("f (Hz);E' (MPa);E'' (MPa);tan d\n1;2;0.2;10\n", "in line 2 tan d is 10 and loss over storage 0.1"),
        ("f (Hz);E' (MPa);E'' (MPa);|E*| (MPa)\n1;2;0.2;0.2\n", "the size of storage and loss .* 2.01e"),
        ("log f;log E';log E''\n0;6;5\n", "logarithms, and not of which base.*name them log10 or ln"),
        ("f (Hz);E' (dB);E'' (dB)\n1;100;80\n", "the unit 'dB' of the column of storage modulus is not known"),
        ("f (Hz);E' (mm);E'' (MPa)\n1;100;80\n", "the unit 'mm'"),
        ("f (Hz);E' (Pa s);E'' (MPa)\n1;100;80\n", "the unit 'Pa s'"),
        ("f (Hz);E' (MPa);E'' (MPa)\nHz;Pa;Pa\n1;100;80\n", "another than the one beside it"),
        ("omega [Hz];E' (MPa);E'' (MPa)\n1;100;80\n", "is called an angular frequency and has the unit Hz"),
        ("f (Hz);E' (kPa);E'' (kPa)\n1;1,000;200\n2;1,200;300\n", "may mark decimals or thousands"),
        ("f (Hz);E' (kPa);E'' (kPa)\n1;2;1\nlid opened\n2;2;1\n", "'lid opened': line 3 is no row .* line 4"),
        ("f (Hz);E' (kPa);E'' (kPa)\n1;2;low\n", "'low': line 2: the loss is not usable"),
        ("f (Hz);E' (kPa);G' (kPa);E'' (kPa)\n1;2;0.7;1\n", "two columns for the same"),
        ("t (s);F (N);E' (kPa);E'' (kPa)\n1;2;0.7;1\n", "no line names columns of frequency"),
        ("T (C);f (Hz);E' (MPa);E'' (MPa)\n-50;1;9;1\n-45;1;8;1\n-40;1;7;1\n", "a sweep over temperature, at 1 Hz"),
        ("f (Hz);E' (kPa);E'' (kPa)\n1;-2;1\n2;0;1\n", "no row has a frequency > 0"),
        ("f (Hz);E' (kPa);E'' (kPa)\n1;200;10\n2;230;12\n1;300;20\n2;340;21\n", "one frequency has different storage"),
    ],
)  # fmt: skip
def test_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_dma_table(written(tmp_path, text))
    assert all(problem.instead for problem in caught.value.problems)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"PK\x03\x04\x14\x00", "it is a workbook or an archive .*no text; export the table as text"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\x00", r"a workbook of Excel \(\.xls\)"),
        (b"%PDF-1.7", "a PDF"),
        (b"\x00\x01\x02\x03" * 100, "a binary file"),
    ],
)
def test_files_that_are_no_text(tmp_path, content, message):
    (tmp_path / "dma.xls").write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_dma_table(tmp_path / "dma.xls")


def isotherms(order="sweeps"):
    """Return a file of three sweeps of a modulus 1e9 (1 + f/100) (1 - T/200) and a loss of a tenth."""
    rows = [
        (f, 1e3 * (1.0 + f / 100.0) * (1.0 - T / 200.0), 100.0 * (1.0 - T / 200.0), T + 0.08 * (f < 1.0), k)
        for k, T in enumerate((-10.0, 20.0, 50.0))
        for f in FREQUENCY
    ]
    if order == "frequencies":
        rows.sort(key=lambda row: row[0])
    if order == "turns":
        rows[4:8] = rows[7:3:-1]
    return rows


@pytest.mark.parametrize("order", ["sweeps", "frequencies", "turns"])
@pytest.mark.parametrize("unit", ["C", "K", "°F"])
def test_one_of_several_temperatures(tmp_path, order, unit):
    degrees = {"C": lambda T: T, "K": lambda T: T + 273.15, "°F": lambda T: 32.0 + 1.8 * T}[unit]
    text = f"Frequency (Hz),E' (MPa),E'' (MPa),Temperature ({unit})\n" + "".join(
        f"{f},{s},{loss},{degrees(T):.6f}\n" for f, s, loss, T, _ in isotherms(order)
    )
    path = written(tmp_path, text)
    with pytest.raises(
        InputError, match=r"sweeps at 3 temperatures: -9.98, 20.02, 50.02 C; choose one .* = 20.02"
    ):
        read_dma_table(path)
    table = read_dma_table(path, temperature=20.0)
    np.testing.assert_allclose(table.omega, 2.0 * np.pi * np.array(FREQUENCY), rtol=1e-15)
    np.testing.assert_allclose(table.storage, [1e9 * (1.0 + f / 100.0) * 0.9 for f in FREQUENCY], rtol=1e-12)
    assert any("measured at 20.02 C, one of 3 sweeps" in note for note in table.notes)
    with pytest.raises(
        InputError, match=r"temperature: 30: .*no sweep within 2 K of it; give one of -9.98, 20"
    ):
        read_dma_table(path, temperature=30.0)
    material = ComplexModuli(file=str(path), temperature=50)
    np.testing.assert_allclose(material.table.storage[0], 0.75e9 * 1.001, rtol=1e-12)


def test_a_table_for_every_sweep(tmp_path):
    # TRIOS writes names and units again for every step; a strain sweep at one frequency is none over frequency
    head = "[step]\n{}\nFrequency\tStorage modulus\tLoss modulus\tTemperature\tStrain\nHz\tMPa\tMPa\t°C\t%\n"
    text = (
        "Filename\tx\n"
        + head.format("Strain sweep")
        + "10\t9\t1\t20\t0.1\n10\t8\t1\t20\t1\n10\t5\t1\t20\t5\n\n"
    )
    for T in (0, 40):
        rows = lines("{f}\t{s}\t{l}\tdegrees\t0.1\n", 1e6 / (1.0 + T)).replace("degrees", str(T))
        text += head.format("Frequency sweep") + rows + "\n"
    path = written(tmp_path, text)
    assert_the_rows(read_dma_table(path, temperature=0.0))
    with pytest.raises(InputError, match="sweeps at 2 temperatures: 0, 40 C"):
        read_dma_table(path)


def test_sweeps_without_temperatures_are_not_mixed(tmp_path):
    head = "Frequency (Hz),E' (MPa),E'' (MPa)\n"
    with pytest.raises(
        InputError, match="the file has 2 sweeps, and no column of temperatures to choose one by"
    ):
        read_dma_table(
            written(tmp_path, head + lines("{f},{s},{l}\n") + head + lines("{f},{s},{l}\n", 0.9e6))
        )
    path = written(
        tmp_path, head.replace("\n", ",Set\n") + lines("{f},{s},{l},0\n") + lines("{f},{s},{l},1\n", 0.9e6)
    )
    with pytest.raises(InputError, match="the file has 2 sweeps"):
        read_dma_table(path)
    # a table on two pages
    rows = lines("{f},{s},{l}\n").splitlines(keepends=True)
    assert_the_rows(read_dma_table(written(tmp_path, head + "".join(rows[:2]) + head + "".join(rows[2:]))))
    # a row without its temperature is none of a sweep
    text = head.replace("\n", ",T\n") + lines("{f},{s},{l},20\n") + "10,2.9,0.4,\n"
    table = read_dma_table(written(tmp_path, text))
    assert_the_rows(table)
    assert any("left out: line 6" in note for note in table.notes)


def test_the_set_temperature_names_a_sweep_that_drifts(tmp_path):
    text = "Ts   f   Tr   E'   E\"\n[°C]   [Hz]   [°C]   [MPa]   [MPa]\n" + "".join(
        f"{-0.6 - 0.5 * k}   {f}   0.0   {s / 1e6}   {loss / 1e6}\n" for k, (f, s, loss) in enumerate(ROWS)
    )
    table = read_dma_table(written(tmp_path, text))
    assert_the_rows(table)
    assert table.notes == ("measured at 0 C; the sample had -2.1 to -0.6 C meanwhile",)


def test_repeated_frequencies_are_averaged_and_told(tmp_path):
    text = "Frequency (Hz),E' (MPa),E'' (MPa)\n" + lines("{f},{s},{l}\n") + "10,2.62,0.325\n"
    table = read_dma_table(written(tmp_path, text))
    np.testing.assert_allclose(table.omega, 2.0 * np.pi * np.array(FREQUENCY), rtol=1e-15)
    assert (table.storage[2], table.loss[2]) == pytest.approx((2.61e6, 3.225e5), rel=1e-14)
    assert any(
        "1 frequency stands more than once (10 Hz)" in note and "0.77 %" in note for note in table.notes
    )


def test_points_that_are_left_out_are_told(tmp_path):
    text = (
        "Frequency (Hz),E' (MPa),E'' (MPa)\n"
        + lines("{f},{s},{l}\n")
        + "200,-1,0.1\n300,4,-0.1\n400,n.a.,1\n500,,\n"
    )
    table = read_dma_table(written(tmp_path, text))
    assert_the_rows(table)
    assert table.notes == (
        "4 rows of the file have no usable numbers (missing, or not positive) and are left out: line 6, 7, 8, 9",
    )
    damping = ComplexModuli(file=str(tmp_path / "dma.txt"))
    told = Material(poissons_ratio=0.4, density=1.0, damping=damping).assumptions
    assert "the table of extension: " + table.notes[0] in told


def test_spikes_are_told_and_peaks_are_not(tmp_path):
    hertz = np.geomspace(0.1, 100.0, 16)
    moduli = 1e6 + 1e8 * (1j * hertz) / (1j * hertz + 3.0)  # a Maxwell branch: a true peak of the loss
    loss = moduli.imag.copy()

    def notes():
        rows = "".join(f"{f},{s},{x}\n" for f, s, x in zip(hertz, moduli.real, loss, strict=True))
        return read_dma_table(written(tmp_path, "f (Hz),E' (Pa),E'' (Pa)\n" + rows)).notes

    assert notes() == ()
    loss[5] *= 1.5
    (note,) = notes()
    assert note.startswith("the loss modulus at 1 Hz is +5")
    loss[5] /= 1.5
    loss[-1] *= 1.5
    (note,) = notes()
    assert note.startswith("the loss modulus at 100 Hz is +5")


def test_tan_delta_that_may_be_percent_is_told(tmp_path):
    (note,) = read_dma_table(written(tmp_path, "f (Hz);E' (MPa);tan delta\n" + lines("{f};{s};{pc}\n"))).notes
    assert (
        "tan delta of 11.81 is far more than the slope of the storage modulus over frequency means (0.09"
        in note
    )
    assert (
        read_dma_table(written(tmp_path, "f (Hz);E' (MPa);tan delta\n" + lines("{f};{s};{t}\n"))).notes == ()
    )


@pytest.mark.parametrize(("one", "other"), [(1.0, 1e3), (1e3, 1.0)])
def test_moduli_of_two_units_are_told_by_the_slope_and_refused_by_tan_delta(one, other, tmp_path):
    """A branch spectrum of one decade a branch; kPa under MPa made the loss 120 times the storage without a word."""
    hertz = np.geomspace(0.1, 100.0, 13)
    moduli = 1e6 * (1.0 + sum(0.1 * 1j * hertz / (1j * hertz + f) for f in (0.05, 0.5, 5.0, 50.0, 500.0)))
    table = np.column_stack([hertz, one * moduli.real / 1e6, other * moduli.imag / 1e6])

    def text(heads, columns):
        return heads + "\n" + "".join(",".join(f"{x:.8g}" for x in row) + "\n" for row in columns)

    heads = "f [Hz],E' [MPa],E'' [MPa]"
    (note,) = read_dma_table(written(tmp_path, text(heads, table))).notes
    assert "if one of them has another unit (Pa, kPa, MPa), the file must say so" in note
    tangent = moduli.imag / moduli.real
    assert float(note.split("the loss modulus is ")[1].split(" times")[0]) == pytest.approx(
        np.median(tangent) * other / one, rel=0.01
    )
    right = np.column_stack([hertz, moduli.real / 1e6, moduli.imag / 1e6])
    assert read_dma_table(written(tmp_path, text(heads, right))).notes == ()
    with pytest.raises(InputError, match="a factor of 1000, as between units"):
        read_dma_table(written(tmp_path, text(heads + ",tan delta", np.column_stack([table, tangent]))))


def test_a_modulus_of_no_material_is_told(tmp_path):
    (note,) = read_dma_table(
        written(tmp_path, "f (Hz);E' (GPa);E'' (GPa)\n" + lines("{f};{s};{l}\n", 1.0))
    ).notes
    assert "goes up to 3e+15 Pa, which no material has" in note


@pytest.mark.parametrize("again", ["E' (MPa)", "E' (MPa).1"])
def test_two_specimens_side_by_side_are_refused(tmp_path, again):
    with pytest.raises(InputError, match=r"names two columns for the same: E' .MPa. and E'"):
        read_dma_table(written(tmp_path, f"f (Hz),E' (MPa),{again},E'' (MPa)\n1,2,3,0.1\n2,2,3,0.1\n"))


OTHER = {
    "Index": "{i}", "t [s]": "7.5", "T [C]": "20.0", "F [N]": "{s}", "Status": "ok", "D' [1/MPa]": "0.4",
    "tan_delta": "{t}", "|E*| [MPa]": "{c}", "omega [rad/s]": "{w}",
}  # fmt: skip


@pytest.mark.parametrize("seed", range(200))
def test_damaged_tables_are_right_or_refused(tmp_path, seed):
    """One cell too few or too many, in the names, the units or all rows, anywhere: never a number of another column."""
    random = np.random.default_rng(seed)
    needed = {"f [Hz]": "{f}", "E' [MPa]": "{s}", "E'' [MPa]": "{l}"}
    chosen = random.permutation(list(OTHER))[: random.integers(0, 5)].tolist()
    names = random.permutation([*needed, *chosen]).tolist()
    cells = [(needed | OTHER)[name] for name in names]
    below = bool(random.integers(0, 2))
    units = [name.partition(" [")[2].rstrip("]") for name in names]
    heads = [name.partition(" [")[0] for name in names] if below else names
    damaged = [heads, cells, units][random.integers(0, 3 if below else 2)]
    at = int(random.integers(0, len(damaged) + 1))
    if random.integers(0, 2) and at < len(damaged):
        del damaged[at]
    else:
        damaged.insert(at, random.choice(["", "3", "Interval data:"]))
    mark = random.choice([",", ";", "\t", "   "])
    text = (
        mark.join(heads) + "\n" + (mark.join(units) + "\n" if below else "") + lines(mark.join(cells) + "\n")
    )
    try:
        table = read_dma_table(written(tmp_path, text))
    except InputError:
        return
    assert_the_rows(table)

"""Tables as the instruments of six makers write them, in layouts that are less common: logarithms, one column for every
frequency or temperature, several blocks, phases and American units. Each holds the same moduli."""

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.dma_table import read_dma_sweeps, read_dma_table

HERTZ = np.array([0.1, 1.0, 10.0, 50.0])
CELSIUS = np.array([-20.0, 0.0, 25.0])
KSI, DYN = 6894757.293168361, 0.1


def moduli(hertz, celsius):
    """A modulus of a power law with the phase of its exponent, softer where it is warmer."""
    power = 0.08 + 0.001 * (celsius + 20.0)
    return 2e9 * 10 ** (-0.01 * celsius) * (1j * hertz) ** power


def cells(hertz, celsius, unit):
    """Return what a cell of a table can hold, by names."""
    value = moduli(hertz, celsius)
    size, angle = abs(value), np.angle(value)
    numbers = {
        "f": hertz, "w": 2.0 * np.pi * hertz, "s": value.real / unit, "l": value.imag / unit, "c": size / unit,
        "t": np.tan(angle), "p": np.degrees(angle), "r": angle, "T": celsius, "K": celsius + 273.15,
        "lf": np.log10(hertz), "lw": np.log10(2.0 * np.pi * hertz), "nf": np.log(hertz),
        "ls": np.log10(value.real / unit), "ll": np.log10(value.imag / unit),
    }  # fmt: skip
    return {name: f"{number:.9g}" for name, number in numbers.items()}


def one(head, row, unit=1e6):
    """Return a table of one sweep at 25 degrees."""
    return head + "".join(row.format(i=k + 1, **cells(f, 25.0, unit)) for k, f in enumerate(HERTZ))


def steps(head, row, unit=1e6, between="", once=False):
    """Return a block for every temperature, with its own head or one for all."""
    text = head if once else ""
    for celsius in CELSIUS:
        text += ("" if once else head.replace("<T>", f"{celsius:g}")) + "".join(
            row.format(i=k + 1, **cells(f, celsius, unit)) for k, f in enumerate(HERTZ)
        )
        text += between
    return text


def wide(first, names, unit=1e6, mark=";", by="frequency", label="{:g} Hz", kinds="sl"):
    """Return a table with columns for every frequency over temperature, or for every temperature over frequency."""
    keys = HERTZ if by == "frequency" else CELSIUS
    text = (
        mark.join([first, *(name.replace("<>", label.format(key)) for key in keys for name in names)]) + "\n"
    )
    for row in CELSIUS if by == "frequency" else HERTZ:
        found = [f"{row:g}"]
        for key in keys:
            values = cells(*((key, row) if by == "frequency" else (row, key)), unit)
            found += [values[kind] for kind in kinds]
        text += mark.join(found) + "\n"
    return text


def german(text):
    return text.replace(".", ",")


SINGLE = {
    "TRIOS, logarithms of base 10": one("Log10(Frequency) (Hz),Log10(E') (MPa),Log10(E'') (MPa)\n", "{lf},{ls},{ll}\n"),
    "TRIOS, logarithm of the angular frequency": one(
        "log10 Angular frequency\tStorage modulus\tLoss modulus\nrad/s\tMPa\tMPa\n", "{lw}\t{s}\t{l}\n"),
    "data frame, log10_freq": one("log10_freq_hz,E_stor_MPa,E_loss_MPa\n", "{lf},{s},{l}\n"),
    "STARe, lg": one("lg f [Hz]\tE' [MPa]\tE'' [MPa]\n", "{lf}\t{s}\t{l}\n"),
    "natural logarithm": one("ln(f) [Hz];E' [MPa];E'' [MPa]\n", "{nf};{s};{l}\n"),
    "log beside the frequency that shows its base": one("f [Hz];log f;E' [MPa];E'' [MPa]\n", "{f};{lf};{s};{l}\n"),
    "log, subscript": one("log₁₀ f [Hz];E' [MPa];E'' [MPa]\n", "{lf};{s};{l}\n"),
    "Metravib, modulus and phase": one("Frequency (Hz)\tE* (MPa)\tPhase (°)\n", "{f}\t{c}\t{p}\n"),
    "Metravib in French": german(one("Fréquence (Hz);Module E* (MPa);Déphasage (°)\n", "{f};{c};{p}\n")),
    "Metravib, delta and tangent": one(
        "Freq. (Hz);Temp. (°C);Modulus |E*| (Pa);Delta (deg);Tan delta\n", "{f};{T};{c};{p};{t}\n", 1.0),
    "loss factor in degrees": one("Frequency [Hz];Storage modulus [MPa];Loss factor [°]\n", "{f};{s};{p}\n"),
    "tan delta in a line of units of degrees": one(
        "Frequency\tStorage modulus\tTan(delta)\nHz\tMPa\tdeg\n", "{f}\t{s}\t{p}\n"),
    "phase in radians": one("f (Hz),E* (MPa),delta (rad)\n", "{f},{c},{r}\n"),
    "ARES, dyn/cm²": one("Freq\tG'\tG\"\n[rad/s]\t[dyn/cm²]\t[dyn/cm²]\n", "{w}\t{s}\t{l}\n", DYN),
    "ARES, dyn/cm^2 and G*": one("Freq (rad/s),G* (dyn/cm^2),Phase angle (deg)\n", "{w},{c},{p}\n", DYN),
    "dynes per square": one("Frequency (Hz),G' (dynes/cm²),G'' (dynes/cm²)\n", "{f},{s},{l}\n", DYN),
    "tensile modulus in ksi": one(
        "Frequency (Hz),Tensile storage modulus (ksi),Tensile loss modulus (ksi)\n", "{f},{s},{l}\n", KSI),
    "Pyris": one(
        "Sample ID: made up\nTime\tTemperature\tFrequency\tStorage Modulus\tLoss Modulus\tTan Delta\n"
        "(min)\t(°C)\t(Hz)\t(Pa)\t(Pa)\t\n", "{i}\t{T}\t{f}\t{s}\t{l}\t{t}\n", 1.0),
    "Pyris, complex modulus": one(
        "Index  Frequency(Hz)  Complex Modulus(Pa)  Phase Angle(deg)\n", "{i}  {f}  {c}  {p}\n", 1.0),
    "RheoCompass, complex modulus and shift": one(
        "Point No.\tAngular Frequency\tComplex Modulus\tPhase Shift Angle\n\t[rad/s]\t[MPa]\t[°]\n",
        "{i}\t{w}\t{c}\t{p}\n"),
    "RheoCompass in German": german(one(
        "Messpkt.\tKreisfrequenz\tKomplexer Modul\tPhasenverschiebungswinkel\n\t[1/s]\t[MPa]\t[°]\n",
        "{i}\t{w}\t{c}\t{p}\n")),
    "Proteus, sizes": one("##f/Hz;|E*|/MPa;tan(delta)/-\n", "{f};{c};{t}\n"),
}  # fmt: skip
SEVERAL = {
    "Proteus, columns by frequency": wide(
        "##Temp./°C", ["E'(<>)/MPa", "E''(<>)/MPa", "tan d(<>)/-"], label="{:.3f} Hz", kinds="slt"),
    "Proteus, decimal commas": german(wide(
        "##Temp./°C", ["E'(<>)/MPa", "E''(<>)/MPa"], label="{:.3f} Hz")),
    "TRIOS, columns by frequency": wide(
        "Temperature (°C)", ["Storage modulus (<>) (MPa)", "Tan(delta) (<>)"], mark="\t", kinds="st"),
    "STARe, at a frequency": wide("Ts [°C]", ["E' @ <> [MPa]", "E'' @ <> [MPa]"]),
    "data frame, columns by frequency": wide(
        "T_C", ["E_stor_<>_MPa", "E_loss_<>_MPa"], mark=",", label="{:g}Hz"),
    "Pyris, the frequency first": wide(
        "Temperature [C]", ["<>: E' [Pa]", "<>: tan delta"], unit=1.0, kinds="st"),
    "Metravib, columns by temperature": wide(
        "Frequency (Hz)", ["E* (MPa) at <>", "delta (°) at <>"], by="temperature", label="{:g} °C", kinds="cp"),
    "Excel, columns by temperature": wide(
        "f in Hz", ["G' <> in MPa", "G'' <> in MPa"], by="temperature", label="{:g}°C"),
    "Excel, frequencies above the names": ";0.1 Hz;;1 Hz;;10 Hz;;50 Hz;\n" + wide(
        "T [°C]", ["E' [MPa]", "E'' [MPa]"]),
    "TRIOS, a block for every step": steps(
        "[step]\nFrequency sweep at <T>\nFrequency\tComplex modulus\tPhase angle\tTemperature\nHz\tMPa\t°\t°C\n",
        "{f}\t{c}\t{p}\t{T}\n", between="\n"),
    "Anton Paar, intervals with their temperature above": steps(
        "Interval: at\nTemperature:\t<T> °C\n\nPoint No.\tFrequency\tStorage Modulus\tLoss Modulus\n"
        "\t[Hz]\t[MPa]\t[MPa]\n",
        "{i}\t{f}\t{s}\t{l}\n", between="\n"),
    "Metravib, logarithms and kelvin": steps(
        "log10(f) [Hz];T [K];log10(E') [Pa];tan delta\n", "{lf};{K};{ls};{t}\n", 1.0, once=True),
}  # fmt: skip


def written(tmp_path, text):
    path = tmp_path / "dma.txt"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", SINGLE)
def test_one_sweep(tmp_path, name):
    table = read_dma_table(written(tmp_path, SINGLE[name]))
    np.testing.assert_allclose(table.omega, 2.0 * np.pi * HERTZ, rtol=1e-7)
    np.testing.assert_allclose(table.storage + 1j * table.loss, moduli(HERTZ, 25.0), rtol=1e-6)


@pytest.mark.parametrize("name", SEVERAL)
def test_several_sweeps(tmp_path, name):
    sweeps = read_dma_sweeps(written(tmp_path, SEVERAL[name]))
    np.testing.assert_allclose([celsius for celsius, _, _ in sweeps], CELSIUS, atol=1e-6)
    for celsius, _, table in sweeps:
        np.testing.assert_allclose(table.omega, 2.0 * np.pi * HERTZ, rtol=1e-7)
        np.testing.assert_allclose(table.storage + 1j * table.loss, moduli(HERTZ, celsius), rtol=1e-6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("log f [Hz];E' [MPa];E'' [MPa]\n0;2;0.2\n", "log f .*line 1 names columns of logarithms, and not of"),
        ("T [°C];E' (1 Hz) [MPa];E'' (1 Hz) [MPa];E' (10 Hz) [MPa]\n20;2;0.2;3\n", "no complex modulus for 10 Hz"),
        ("T [°C];E' (1,000 Hz) [MPa];E'' (1,000 Hz) [MPa]\n20;2;0.2\n", "comma may mark decimals or thousands"),
        ("T [°C];E' [MPa];E'' [MPa];E' (1 Hz) [MPa]\n20;2;0.2;3\n", "no complex modulus for 1 Hz"),
        ("f [Hz];E' 20 °C [MPa];E'' 20 °C\n1;2;0.2\n2;3;0.3\n", "does not give the unit of the column of loss"),
        ("f [Hz];E' [MPa];loss factor [mm]\n1;2;0.2\n", "the unit 'mm' of the column of tan delta is not known"),
    ],
)  # fmt: skip
def test_what_is_not_clear_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_dma_table(written(tmp_path, text))
    assert all(problem.instead for problem in caught.value.problems)


def test_a_ramp_of_temperature_is_a_sweep_for_every_row(tmp_path):
    """Four frequencies side by side at every second degree: 20 sweeps of four points each."""
    names = ["T [°C]", *(f"{what} ({f:g} Hz) [MPa]" for f in HERTZ for what in ("E'", "E''"))]
    ramp = 2.0 * np.arange(20)
    rows = [
        [
            celsius,
            *(
                part / 1e6
                for f in HERTZ
                for value in [moduli(f, celsius)]
                for part in (value.real, value.imag)
            ),
        ]
        for celsius in ramp
    ]
    text = "\n".join([";".join(names), *(";".join(f"{number:.9g}" for number in row) for row in rows)])
    sweeps = read_dma_sweeps(written(tmp_path, text))
    np.testing.assert_allclose([celsius for celsius, _, _ in sweeps], ramp)
    np.testing.assert_allclose(sweeps[7][2].storage, moduli(HERTZ, ramp[7]).real, rtol=1e-6)

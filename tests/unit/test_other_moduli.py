"""Tables of compliances and viscosities in the place of moduli."""

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.materials.dma_table import read_dma_table

HERTZ = np.array([0.1, 1.0, 10.0])
OMEGA = 2.0 * np.pi * HERTZ
MODULUS = np.array([2.0e9 + 0.10e9j, 2.2e9 + 0.15e9j, 2.5e9 + 0.12e9j])
"""Values of all tables here: what they have follows from these by M* J* = 1 and M* = i omega eta*."""
YIELD = 1.0 / MODULUS
ETA = MODULUS / (1j * OMEGA)
TANGENT = MODULUS.imag / MODULUS.real
DEGREES = np.degrees(np.arctan(TANGENT))
TABLES = {
    "compliances": ("f (Hz);J' (1/Pa);J'' (1/Pa)", (HERTZ, YIELD.real, -YIELD.imag), "shear"),
    "tension": (
        "Frequency\tStorage Compliance D'\tLoss Compliance D''\nHz\t1/GPa\t1/GPa",
        (HERTZ, 1e9 * YIELD.real, -1e9 * YIELD.imag),
        "extension",
    ),
    "size and angle": ("ω [rad/s],|J*| [1/MPa],δ [°]", (OMEGA, 1e6 * np.abs(YIELD), DEGREES), "shear"),
    "storage and tan delta": (
        "Frequency (Hz),Storage compliance (1/GPa),tan δ",
        (HERTZ, 1e9 * YIELD.real, TANGENT),
        None,
    ),
    "loss and tan delta": ("f (Hz),D'' (m2/N),tan delta", (HERTZ, -YIELD.imag, TANGENT), "extension"),
    "rheometer": (
        "Angular frequency\tComplex viscosity\tPhase angle\nrad/s\tPa.s\t°",
        (OMEGA, np.abs(ETA), DEGREES),
        "shear",
    ),
    "two viscosities": (
        "Freq (Hz);η' (kPa·s);η'' (kPa·s)",
        (HERTZ, 1e-3 * ETA.real, -1e-3 * ETA.imag),
        "shear",
    ),
    "millipascals": ("w (rad/s);|η*| (mPa·s);tan(δ)", (OMEGA, 1e3 * np.abs(ETA), TANGENT), "shear"),
    "elongation": (
        "f (Hz);Elongational complex viscosity (MPa s);tan d",
        (HERTZ, 1e-6 * np.abs(ETA), TANGENT),
        "extension",
    ),
    "beside moduli": (
        "f (Hz);E' (Pa);E'' (Pa);|η*| (cSt);J' (%)",  # not needed, so that their units do not matter
        (HERTZ, MODULUS.real, MODULUS.imag, HERTZ, HERTZ),
        "extension",
    ),
}


@pytest.mark.parametrize("name", TABLES)
def test_moduli_follow(name, tmp_path):
    head, columns, strain = TABLES[name]
    mark = next(one for one in "\t;," if one in head)
    rows = "\n".join(mark.join(f"{value:.12g}" for value in row) for row in np.column_stack(columns))
    path = tmp_path / "table.txt"
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")
    table = read_dma_table(path)
    np.testing.assert_allclose(table.omega, OMEGA, rtol=1e-10)
    np.testing.assert_allclose(table.storage + 1j * table.loss, MODULUS, rtol=1e-9)
    assert table.strain == strain


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "f (Hz);J' (mm);J'' (1/Pa)\n3;2;7\n",
            "the unit 'mm' of the column of storage compliance is not known",
        ),
        ("f (Hz);eta*;tan d\n3;2;7\n", "does not give the unit of the column of complex viscosity"),
        ("f (Hz);tan delta\n3;0.2\n", "a loss factor without moduli is damping of the kind loss_factor"),
        ("t (s);E(t) (MPa)\n3;2\n", "creep or relaxation over time .* damping of the kind prony"),
        ("Time [s];Creep compliance [1/Pa]\n3;2\n", "creep or relaxation over time"),
        ("f (Hz);J' (1/Pa)\n3;2\n", "no line names columns of frequency"),
        ("f (Hz);η* (Pa s);G' (Pa)\n3;2;7\n", "no line names columns of frequency"),
    ],
)
def test_what_is_not_clear_is_refused(text, message, tmp_path):
    (tmp_path / "table.txt").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        read_dma_table(tmp_path / "table.txt")

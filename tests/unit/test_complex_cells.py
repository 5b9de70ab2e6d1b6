"""Complex numbers in the cells of texts, as scripts, spreadsheets and analysers write them; and responses with gaps."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.records.complex_cells import complex_of, complex_parts, with_complex_in_one
from viscorod.records.record_table import record_of

HERTZ = np.arange(1.0, 41.0)
TRUE = 1.0 / ((2.0 * np.pi * 17.0) ** 2 + 40j * HERTZ - (2.0 * np.pi * HERTZ) ** 2)
"""The closed form of one mode, m/N."""


def rectangular(z, unit="j"):
    return f"{z.real:.12e}{z.imag:+.12e}{unit}"


def polar(z, mark="@", unit="deg"):
    return f"{abs(z):.12e}{mark}{np.degrees(np.angle(z)):.10f}{unit}"


WRITTEN = {
    "scripts": (",", lambda z: f"({rectangular(z)})"),
    "plain": (",", rectangular),
    "spreadsheets": (";", lambda z: rectangular(z, "i").replace(".", ",")),
    "blanks about the sign": ("\t", lambda z: f"{z.real:.12e} {'-' if z.imag < 0 else '+'} {abs(z.imag):.12e}i"),
    "the same between blanks": (" ", lambda z: f"{z.real:.12e} {'-' if z.imag < 0 else '+'} {abs(z.imag):.12e}i"),
    "numpy's columns": (" ", lambda z: f" ({rectangular(z)})"),
    "pairs between commas": (",", lambda z: f"({z.real:.12e}, {z.imag:.12e})"),
    "pairs in quotes": (",", lambda z: f'"({z.real:.12e},{z.imag:.12e})"'),
    "pairs with decimal commas": (";", lambda z: f"({z.real:.12e}; {z.imag:.12e})".replace(".", ",")),
    "magnitude and phase": (",", polar),
    "angle in radians": (";", lambda z: f"{abs(z):.12e}∠{np.angle(z):.12f} rad"),
    "degrees by their sign": ("\t", lambda z: polar(z, "∠", "°")),
}  # fmt: skip


def written(kind, values=TRUE, hertz=HERTZ, heads=("f [Hz]", "H [m/N]")):
    mark, cell = WRITTEN[kind]
    comma = "," in cell(1.5 + 2.5j) and mark == ";"
    rows = [f"{f:.3f}".replace(".", ",") if comma else f"{f:.3f}" for f in hertz]
    rows = [f"{f}{mark}{cell(z) if np.isfinite(z) else 'NaN'}" for f, z in zip(rows, values, strict=True)]
    return "\n".join([mark.join(heads), *rows]) + "\n"


@pytest.mark.parametrize("kind", WRITTEN)
def test_a_response_of_complex_cells(kind, tmp_path):
    heads = ("f_Hz", "H") if WRITTEN[kind][0] == " " else ("f [Hz]", "H [m/N]")
    (tmp_path / "h.csv").write_text(written(kind, heads=heads), encoding="utf-8")
    unit = {"unit": "m/N"} if heads[1] == "H" else {}
    found = vr.ResponseRecord.read(tmp_path / "h.csv", "H", **unit)
    np.testing.assert_array_equal(found.frequencies, HERTZ)
    np.testing.assert_allclose(found.values, TRUE, rtol=1e-9)


def test_a_phase_in_a_cell_needs_its_unit(tmp_path):
    """Read as degrees where they are radians, every phase would be wrong without a word."""
    rows = "".join(f"{f:.1f},{abs(z):.9e}@{np.angle(z):.9f}\n" for f, z in zip(HERTZ, TRUE, strict=True))
    (tmp_path / "h.csv").write_text("f [Hz],H [m/N]\n" + rows)
    with pytest.raises(vr.InputError, match=r"H: .* line 2: of a phase its unit is needed; .* 1\.2@45deg"):
        vr.ResponseRecord.read(tmp_path / "h.csv", "H")


@pytest.mark.parametrize(
    "cell", ["1.2", "2024-01-03", "1e-3", "a+bj", "12:30:01", "1+2", "node 3+j", "", "3@x"]
)
def test_what_is_no_complex_number_is_none(cell):
    assert complex_parts(with_complex_in_one(cell)) is None


def test_imaginary_parts_before_or_after_their_unit():
    for cell in ("3-j4", "3-4j", "(3 - 4*i)", "3-i4"):
        assert complex_of(complex_parts(cell), float) == 3 - 4j, cell


def test_gaps_of_a_response_are_refused_or_left_out(tmp_path):
    values = TRUE.copy()
    values[[4, 30]] = np.nan
    (tmp_path / "h.csv").write_text(written("plain", values))
    with pytest.raises(
        vr.InputError, match=r"column H: .*row 5 .*gaps='leave out' to read the other 38 rows"
    ):
        vr.ResponseRecord.read(tmp_path / "h.csv", "H")
    found = vr.ResponseRecord.read(tmp_path / "h.csv", "H", gaps="leave out")
    keep = np.isfinite(values)
    np.testing.assert_array_equal(found.frequencies, HERTZ[keep])
    np.testing.assert_allclose(found.values, TRUE[keep], rtol=1e-9)
    with pytest.raises(vr.InputError, match=r"gaps: .*'fill'.* use 'refuse' or 'leave out'"):
        vr.ResponseRecord.read(tmp_path / "h.csv", "H", gaps="fill")


def test_gaps_of_tables_of_loads_and_modes_are_left_out_as_their_message_says(tmp_path):
    (tmp_path / "pull.csv").write_text("F [N],w [mm]\n0,0\n1,2\n2,\n3,6\n")
    pull = {"kind": "static", "file": "pull.csv", "place": "beam.end", "direction": "z", "full_load": 3.0}
    with pytest.raises(vr.InputError, match=r"gaps='leave out'"):
        record_of(pull, tmp_path)
    found = record_of({**pull, "gaps": "leave out"}, tmp_path)
    np.testing.assert_allclose(found.loads, [0.0, 1.0, 3.0])
    np.testing.assert_allclose(found.values, [0.0, 2e-3, 6e-3])
    (tmp_path / "modes.csv").write_text("f [Hz],zeta [%]\n10,1\n20,-\n30,2\n")
    modes = {"kind": "modes", "file": "modes.csv", "damping_ratio": "zeta", "gaps": "leave out"}
    found = record_of(modes, tmp_path)
    np.testing.assert_allclose(found.observed, [10.0, 30.0, 0.01, 0.02])

"""Responses as analysers and scripts write them: one response of two modes in many files, all read alike."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

HERTZ = np.arange(0.0, 100.25, 0.5)
MODES = ((17.0, 0.012, 1.0), (61.0, 0.008, -0.7))


def receptance(hertz):
    """Sum of a/(w^2 + 2 i z w s + s^2), the closed form, with s = i omega."""
    s = 2j * np.pi * hertz
    return sum(a / ((2.0 * np.pi * f) ** 2 + 4.0 * np.pi * z * f * s + s * s) for f, z, a in MODES)


CLEAN = receptance(HERTZ)


def text(heading, *columns):
    return (
        heading
        + "\n"
        + "".join(";".join(f"{x:.12g}" for x in row) + "\n" for row in zip(*columns, strict=True))
    )


def two_sides():
    return np.concatenate([HERTZ, -HERTZ[:0:-1]]), np.concatenate([CLEAN, CLEAN[:0:-1].conj()])


def decibels(values):
    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(np.abs(values))


BOTH, SIDES = two_sides()
SORTED = np.argsort(BOTH)
ACCELERANCE = (2j * np.pi * HERTZ) ** 2 * CLEAN
DEGREES = np.degrees(np.angle(ACCELERANCE))
PARTS, HEAD = ["re", "im"], "f [Hz];re [m/N];im [m/N]"
SIZE = ["mag", "phase"]
FILES = {
    "two sides, as a transform has them": (text(HEAD, BOTH, SIDES.real, SIDES.imag), PARTS, {}, 0),
    "two sides, sorted": (text(HEAD, *(x[SORTED] for x in (BOTH, SIDES.real, SIDES.imag))), PARTS, {}, 0),
    "two sides up to the rate": (text(HEAD, 0.5 * np.arange(401.0), SIDES.real, SIDES.imag), PARTS, {}, 0),
    "the same without 0 Hz": (text(HEAD, 0.5 * np.arange(1.0, 401.0), SIDES.real[1:], SIDES.imag[1:]), PARTS, {}, 1),
    "nothing at 0 Hz in decibels": (
        text("f [Hz];mag [dB];phase [deg]", HERTZ, decibels(ACCELERANCE), DEGREES), SIZE, {"unit": "m/s^2/N"}, 1),
    "decibels that say what they are over": (
        text("f [Hz];mag [dB re 1 g/N];phase [deg]", HERTZ, decibels(ACCELERANCE / 9.80665), DEGREES), SIZE, {}, 1),
    "decibels over mm/s^2/N": (
        text("f [Hz];mag [dB];phase [deg]", HERTZ, decibels(1e3 * ACCELERANCE), DEGREES),
        SIZE, {"unit": "dB re 1 mm/s^2/N"}, 1),
    "a phase whose unit is given": (
        text("f [Hz];mag [m/s^2/N];phase", HERTZ, np.abs(ACCELERANCE), DEGREES), SIZE, {"phase_unit": "deg"}, 0),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_files(name, tmp_path):
    content, columns, more, first = FILES[name]
    file = tmp_path / "response.csv"
    file.write_text(content)
    found = vr.ResponseRecord.read(file, columns, **more)
    np.testing.assert_allclose(found.frequencies, HERTZ[first:], atol=1e-12)
    true = CLEAN if columns == PARTS else ACCELERANCE
    np.testing.assert_allclose(found.values, true[first:], rtol=1e-8, atol=1e-9 * np.abs(true).max())


@pytest.mark.parametrize("more", [{}, {"unit": "m/s^2/N"}])
def test_a_phase_is_not_read_as_imaginary_part(more, tmp_path):
    file = tmp_path / "response.csv"
    file.write_text(text("f [Hz];Betrag [m/s^2/N];Phase", HERTZ, np.abs(ACCELERANCE), DEGREES))
    with pytest.raises(vr.InputError, match=r"of a phase its unit is needed; .* phase_unit = 'deg' or 'rad'"):
        vr.ResponseRecord.read(file, ["Betrag", "Phase"], **more)


def test_lines_below_zero_that_are_other_ones_are_refused(tmp_path):
    file = tmp_path / "response.csv"
    file.write_text(text(HEAD, BOTH, SIDES.real, np.abs(SIDES.imag)))
    with pytest.raises(vr.InputError, match="lines below 0 Hz are not the mirror of those above"):
        vr.ResponseRecord.read(file, PARTS)


def test_mirrored_lines_of_arrays_are_refused_with_how_many_to_give():
    with pytest.raises(vr.InputError, match=r"the mirror of those below.*give the first 201 lines"):
        vr.ResponseRecord(0.5 * np.arange(401.0), SIDES)
    whole = np.concatenate(
        [CLEAN[:-1], [CLEAN[-1].real], CLEAN[-2:0:-1].conj()]
    )  # an even number: a line at half
    with pytest.raises(vr.InputError, match="give the first 201 lines"):
        vr.ResponseRecord(0.5 * np.arange(400.0), whole)
    assert len(vr.ResponseRecord(HERTZ, CLEAN).frequencies) == 201


def test_a_gap_in_the_lines_is_named():
    kept = np.abs(HERTZ - 30.0) > 1.0
    with pytest.raises(
        vr.InputError, match=r"28.5, 31.5: the lines must be evenly spaced, and most are 0.5 Hz"
    ):
        vr.modal_fit(vr.ResponseRecord(HERTZ[kept], CLEAN[kept]))


def test_overloads_are_gaps_of_a_history(tmp_path):
    times = np.arange(400) / 100.0
    values = np.exp(-0.3 * times) * np.cos(12.0 * times)
    cells = [f"{v:.9f}" for v in values]
    cells[0], cells[7], cells[8] = "OVL", "-inf", "Overload"
    file = tmp_path / "record.csv"
    file.write_text("t [s];x [mm]\n" + "".join(f"{t:.2f};{v}\n" for t, v in zip(times, cells, strict=True)))
    about = {"place": "a", "quantity": "displacement", "direction": "x"}
    with pytest.raises(vr.InputError, match="give gaps='leave out' to read the other 397 rows"):
        vr.Record.read(file, "x", **about)
    found = vr.Record.read(file, "x", gaps="leave out", **about)
    kept = np.delete(np.arange(400), [0, 7, 8])
    np.testing.assert_allclose(found.times, times[kept])
    np.testing.assert_allclose(found.values, 1e-3 * values[kept], atol=1e-12)


def test_columns_without_names_and_stamps_that_were_rounded_say_what_to_do(tmp_path):
    file = tmp_path / "record.csv"
    file.write_text("".join(f"{0.01 * (k // 2):.2f}\t{k % 7}\n" for k in range(40)))
    about = {"place": "a", "quantity": "displacement", "direction": "x", "unit": "mm", "time_unit": "s"}
    with pytest.raises(vr.InputError, match="no names stand above the columns; give its number, 1 to 2"):
        vr.Record.read(file, "x", **about)
    with pytest.raises(vr.InputError, match="stamps that were rounded give even times, in read by rate"):
        vr.Record.read(file, 2, **about)
    assert vr.Record.read(file, 2, rate=200.0, **about).interval == pytest.approx(0.005)

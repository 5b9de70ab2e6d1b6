"""Poles of transformed records whose modes are known, with lines far wider than the resonances."""

import numpy as np
import pytest

import viscorod as vr
from helpers.pictures import written

MODES = ((52.3, 6e-4, 1.0), (143.7, 4e-4, -0.7), (281.2, 3e-4, 0.5))
"""Natural frequency [Hz], damping ratio, size; half-power widths are 0.06 to 0.17 of a line of 1 Hz."""
RATE, SPAN = 1000.0, 1.0


def transformed(seed, noise=2e-4, factor=1.0, modes=MODES):
    """The response of the modes to a hit, recorded over a time in which they hardly decay, transformed."""
    times = np.arange(int(RATE * SPAN)) / RATE
    values = np.zeros(len(times), dtype=complex)
    for frequency, ratio, size in modes:
        omega = 2.0 * np.pi * frequency
        pole = complex(-ratio * factor * omega, omega * np.sqrt(1.0 - ratio**2))
        values += size * np.exp(pole * times)
    lines = np.fft.rfft(values.imag) / RATE
    rng = np.random.default_rng(seed)
    lines += noise * (rng.normal(size=len(lines)) + 1j * rng.normal(size=len(lines)))
    return vr.ResponseRecord(np.arange(1, 400) / SPAN, lines[1:400], name=f"hit {seed}")


def test_modes_narrower_than_the_lines_are_found_with_intervals_that_hold():
    inside = []
    for seed in range(8):
        found = vr.modal_fit(transformed(seed))
        assert len(found.frequencies) == 3
        for k, (frequency, ratio, _) in enumerate(MODES):
            inside.append(abs(found.frequencies[k] - frequency) < found.data.frequency_width.values[k])
            inside.append(abs(found.damping_ratios[k] - ratio) < found.data.damping_ratio_width.values[k])
    assert len(inside) == 48
    assert np.mean(inside) > 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / 48)
    assert np.mean(found.data.damping_ratio_width.values / found.damping_ratios) < 0.1


def test_half_power_is_refused_where_the_lines_are_wider():
    found = vr.modal_fit(transformed(1))
    assert found.half_power == [None, None, None]
    assert any("half-power: refused at 52.3, 143.7, 281.2 Hz" in text for text in found.warnings)


def test_half_power_is_read_where_it_can_be():
    """1/(w0^2 - w^2 + 2 i zeta w0 w) with a width of 24 lines: half power is right to the square of the ratio."""
    hertz = np.arange(10.0, 200.0, 0.25)
    response = 1.0 / (60.0**2 - hertz**2 + 2j * 0.05 * 60.0 * hertz)
    found = vr.modal_fit(vr.ResponseRecord(hertz, response))
    assert found.frequencies == pytest.approx([60.0], rel=1e-3)
    assert found.damping_ratios == pytest.approx([0.05], rel=5e-3)
    assert found.half_power == pytest.approx([0.05], rel=0.02)


def test_records_that_differ_widen_the_interval():
    same = vr.modal_fit([transformed(1), transformed(2)])
    other = vr.modal_fit([transformed(1), transformed(2, factor=1.5)])
    assert (other.data.damping_ratio_width.values > 3.0 * same.data.damping_ratio_width.values).all()
    assert any("further apart than their intervals" in text for text in other.warnings)
    assert not any("further apart" in text for text in same.warnings)


def test_modes_become_a_record(tmp_path):
    found = vr.modal_fit(transformed(3), title="beam")
    record = vr.ModesRecord.of(found, name="beam")
    assert record.observed == pytest.approx([*found.frequencies, *found.damping_ratios])
    assert record.noise[3:] == pytest.approx(found.data.damping_ratio_width.values / 1.96, rel=1e-4)
    again = vr.load(found.save(tmp_path / "fit.nc"))
    assert again.report() == found.report()
    assert written(again.plot, tmp_path / "fit.png").stat().st_size > 10_000


def test_what_has_no_modes_is_refused():
    rng = np.random.default_rng(1)
    hertz = np.arange(1.0, 100.0)
    with pytest.raises(vr.InputError, match="no peak stands out"):
        vr.modal_fit(vr.ResponseRecord(hertz, 1.0 + 0.01 * rng.normal(size=99) + 0j))
    with pytest.raises(vr.InputError, match="evenly spaced"):
        vr.modal_fit(vr.ResponseRecord(np.geomspace(1.0, 100.0, 99), np.ones(99, dtype=complex)))

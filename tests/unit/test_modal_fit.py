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


def test_the_material_damps_at_most_as_much_as_the_mode_with_the_least_room():
    """A flat loss factor gives all modes of a uniform beam half of it, the time of Kelvin and Voigt omega tau/2."""
    found = vr.modal_fit(transformed(1))
    most = found.damping_ratios + found.data.damping_ratio_width.values
    flat, viscous = found.material_at_most
    assert (flat.law, flat.mode, viscous.law, viscous.mode) == ("flat_loss", 3, "kelvin_voigt", 3)
    assert flat.value == pytest.approx(2.0 * most[2])
    assert 2.0 * MODES[2][1] < flat.value < 2.0 * MODES[1][1]
    assert viscous.value == pytest.approx(2.0 * most[2] / (2.0 * np.pi * found.frequencies[2]))
    assert "a flat loss factor of 0.0006" in found.report()


def test_command_for_modes_reads_columns_of_real_and_imaginary_parts(tmp_path):
    from typer.testing import CliRunner

    from viscorod.cli.app import app

    first, second = transformed(1), transformed(2)
    columns = [
        first.frequencies,
        first.values.real,
        first.values.imag,
        second.values.real,
        second.values.imag,
    ]
    head = "f [Hz],re1 [m/s^2/N],im1 [m/s^2/N],re2 [m/s^2/N],im2 [m/s^2/N]"
    file = tmp_path / "hits.csv"
    np.savetxt(file, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.17g")
    command = ["damping", "modes", str(file), "--value", "re1,im1", "--value", "4,5", "--band", "10,300"]
    told = CliRunner().invoke(app, [*command, "-o", str(tmp_path / "out")])
    assert told.exit_code == 0, told.output
    expected = vr.modal_fit([first, second], band=(10.0, 300.0))
    again = vr.load(tmp_path / "out/modes.nc")
    np.testing.assert_allclose(again.damping_ratios, expected.damping_ratios, rtol=1e-6)
    assert (tmp_path / "out/modes.png").stat().st_size > 10_000
    other = tmp_path / "other.csv"
    other.write_bytes(file.read_bytes())
    command = ["damping", "modes", str(file), str(other), "--value", "re1,im1", "-o", str(tmp_path / "two")]
    assert CliRunner().invoke(app, command).exit_code == 0
    assert vr.load(tmp_path / "two/modes.nc").data["record_name"].values.tolist() == [file.name, other.name]
    asked = CliRunner().invoke(app, ["damping", "modes", str(file)])
    assert asked.exit_code != 0
    assert "the columns of" in asked.output
    assert "2 re1" in asked.output
    refused = CliRunner().invoke(app, ["damping", "modes", str(file), "--value", "re9"])
    assert refused.exit_code == 2
    assert "no column has this name" in refused.output


def noisy(seed, white, proportional, step=0.25):
    """The accelerance of three modes, with noise of a part of the highest peak and a part of each line's size."""
    rng = np.random.default_rng(seed)
    hertz = np.arange(5.0, 120.0, step)
    omega = 2.0 * np.pi * hertz
    response = sum(
        -(omega**2) * size / ((2.0 * np.pi * f) ** 2 - omega**2 + 4j * np.pi * f * ratio * omega)
        for f, ratio, size in RESOLVED
    )
    deviation = white * np.abs(response).max() + proportional * np.abs(response)
    noise = deviation * (rng.normal(size=len(hertz)) + 1j * rng.normal(size=len(hertz)))
    return hertz, response, noise


RESOLVED = ((20.0, 0.01, 1.0), (47.0, 0.015, -0.6), (90.0, 0.008, 0.8))


def held(found, modes):
    """How many intervals of frequencies and ratios hold the truth."""
    near = [int(np.abs(found.frequencies - mode[0]).argmin()) for mode in modes]
    truth = np.array([mode[:2] for mode in modes]).T
    off = np.abs(np.array([found.frequencies[near], found.damping_ratios[near]]) - truth)
    widths = [found.data[f"{name}_width"].values[near] for name in ("frequency", "damping_ratio")]
    return int((off < np.array(widths)).sum())


@pytest.mark.parametrize(
    ("white", "proportional", "step"),
    [(0.01, 0.0, 1.0), (0.0, 0.03, 1.0), (0.003, 0.02, 0.25), (0.0, 0.03, 0.1)],
)
def test_intervals_hold_whatever_the_noise_is_in_proportion_to(white, proportional, step):
    """Of 48 intervals of 95 % at least 41 hold the truth with a probability of 0.995; constant noise alone gave 24."""
    inside = 0
    for seed in range(8):
        hertz, response, noise = noisy(seed, white, proportional, step)
        inside += held(vr.modal_fit(vr.ResponseRecord(hertz, response + noise)), RESOLVED)
    assert inside >= 41


def test_coherence_tells_the_noise():
    """A mean of n records has the coherence 1/(1 + n sigma^2/|H|^2), sigma that of real and imaginary part together."""
    hertz, response, _ = noisy(1, 0.0, 0.0)
    deviation = np.where(hertz < 33.0, 0.002, 0.05) * np.abs(response)
    coherence = 1.0 / (1.0 + 2.0 * 20 * (deviation / np.abs(response)) ** 2)
    record = vr.ResponseRecord(hertz, response, coherence=coherence, averages=20)
    near = np.abs(hertz - 33.0) > 2.0  # neighbours are taken together
    assert record.noise[: len(hertz)][near] == pytest.approx(deviation[near], rel=1e-9)
    for wrong in ({"coherence": coherence}, {"averages": 20}, {"coherence": 2.0 * coherence, "averages": 20}):
        with pytest.raises(vr.InputError, match=r"coherence|averages"):
            vr.ResponseRecord(hertz, response, **wrong)


def test_intervals_hold_by_the_coherence():
    inside = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        hertz, response, _ = noisy(seed, 0.0, 0.0, 0.5)
        deviation = np.where(hertz < 33.0, 0.005, 0.05) * np.abs(response)
        noise = deviation * (rng.normal(size=len(hertz)) + 1j * rng.normal(size=len(hertz)))
        coherence = 1.0 / (1.0 + 2.0 * 20 * (deviation / np.abs(response)) ** 2)
        record = vr.ResponseRecord(hertz, response + noise, coherence=coherence, averages=20)
        inside += held(vr.modal_fit(record), RESOLVED)
    assert inside >= 41


def test_a_peak_whose_ratio_is_not_told_is_named():
    """Half-power width of a thousandth of a line, noise of a fiftieth of the peak."""
    found = vr.modal_fit(transformed(2, noise=0.002, modes=((52.3, 1e-5, 1.0), (143.7, 4e-3, -2.0))))
    assert len(found.frequencies) == 1
    assert found.frequencies[0] == pytest.approx(143.7, rel=1e-3)
    assert any("a peak stands at 52" in text for text in found.warnings)


CLOSE = ((31.0, 0.008, 0.7), (33.0, 0.01, 0.5))


@pytest.mark.parametrize(("white", "proportional"), [(0.003, 0.0), (0.0, 0.005)])
def test_modes_nearby_do_not_bend_each_other(white, proportional, monkeypatch):
    """Half-power bands that are three widths apart; a polynomial for the neighbour left ratios 0.7 and 1.3 % too large.

    Of 40 intervals of 95 % fewer than 34 hold the truth with a probability of 0.003.
    """
    monkeypatch.setitem(globals(), "RESOLVED", CLOSE)
    inside = 0
    for seed in range(10):
        hertz, response, noise = noisy(seed, white, proportional, 0.1)
        found = vr.modal_fit(vr.ResponseRecord(hertz, response + noise))
        inside += held(found, CLOSE)
    assert inside >= 34
    hertz, response, _ = noisy(0, 0.0, 0.0, 0.1)
    exact = vr.modal_fit(vr.ResponseRecord(hertz, response))
    assert exact.damping_ratios == pytest.approx([0.008, 0.01], rel=1e-3)


def test_a_magnitude_alone_tells_no_pole():
    hertz, response, _ = noisy(0, 0.0, 0.0)
    with pytest.raises(vr.InputError, match="poles are in the phase"):
        vr.modal_fit(vr.ResponseRecord(hertz, np.abs(response)))


def test_a_response_that_was_clipped_has_flat_peaks():
    """Lines of one and the same size beside each other are one peak."""
    hertz, response, _ = noisy(0, 0.0, 0.0)
    size = np.abs(response)
    most = 0.4 * size.max()
    found = vr.modal_fit(vr.ResponseRecord(hertz, np.where(size > most, response * most / size, response)))
    assert len(found.frequencies) == 3
    assert any("there are others" in text for text in found.warnings)


@pytest.mark.parametrize(
    "other", [(30.4, 0.01, 0.6), (30.4, 0.01, -0.6), (31.0, 0.01, 0.2)], ids=["beside", "against", "faint"]
)
def test_a_mode_hidden_beside_another_is_told(other):
    """Without a peak of its own; ratios of 0.0138 +- 0.0004, 0.0065 +- 0.0012 and 0.0089 +- 0.0005 stood for 0.01."""
    rng = np.random.default_rng(0)
    hertz = np.arange(1, 2001) * 0.05
    modes = ((30.0, 0.01, 1.0), other)
    response = sum(-(hertz**2) * a / (f**2 - hertz**2 + 2j * z * f * hertz) for f, z, a in modes)
    deviation = 0.01 * np.median(np.abs(response))
    noise = deviation * (rng.normal(size=len(hertz)) + 1j * rng.normal(size=len(hertz)))
    told = vr.modal_fit(vr.ResponseRecord(hertz, response + noise)).warnings
    assert any("is no noise: neighbouring lines are alike" in text for text in told)


def test_noise_is_not_taken_for_a_mode():
    for seed in range(3):
        for white, proportional in ((0.01, 0.0), (0.0, 0.03)):
            hertz, response, noise = noisy(seed, white, proportional)
            told = vr.modal_fit(vr.ResponseRecord(hertz, response + noise)).warnings
            assert not any("neighbouring lines are alike" in text for text in told)


def test_a_load_over_a_motion_shows_the_modes_of_what_is_held():
    """Poles of 1/H are the zeros of H: of two modes of equal weights the roots of the sum of their denominators."""
    hertz = np.linspace(1.0, 80.0, 1581)
    poles = [
        np.array([1.0, 2.0 * ratio * 2.0 * np.pi * f, (2.0 * np.pi * f) ** 2])
        for f, ratio in ((20.0, 0.01), (50.0, 0.02))
    ]
    s = 2j * np.pi * hertz
    receptance = sum(1.0 / np.polyval(one, s) for one in poles)
    zero = np.roots(poles[0] + poles[1])[0]
    found = vr.modal_fit(vr.ResponseRecord(hertz, 1.0 / receptance, unit="N/m"))
    assert found.frequencies[0] == pytest.approx(abs(zero) / (2.0 * np.pi), rel=1e-4)
    assert found.damping_ratios[0] == pytest.approx(-zero.real / abs(zero), rel=1e-2)
    assert any(
        "response is in N/m, a load over a motion: its peaks are modes of what is left free" in one
        for one in found.warnings
    )
    plain = vr.modal_fit(vr.ResponseRecord(hertz, receptance, unit="m/N"))
    assert not any("a load over a motion" in one for one in plain.warnings)


def receptance(hertz):
    """Two modes of which the higher one moves a fortieth as far."""
    omega = 2.0 * np.pi * hertz
    parts = [
        size / ((2.0 * np.pi * f) ** 2 - omega**2 + 2j * ratio * 2.0 * np.pi * f * omega)
        for f, ratio, size in ((12.0, 0.004, 1.0), (75.0, 0.006, -0.7))
    ]
    return np.sum(parts, axis=0)


@pytest.mark.parametrize("lines", ["by logarithm", "anywhere"])
def test_sines_one_by_one_may_stand_anywhere(lines):
    """Stepped sines: the response at each frequency is exact, whatever lies between. Of 20 intervals 16 hold at least
    (95 % of binomial chance 0.0026 for fewer)."""
    random = np.random.default_rng(5)
    hertz = (
        np.geomspace(5.0, 150.0, 900) if lines == "by logarithm" else np.sort(random.uniform(5.0, 150.0, 900))
    )
    clean = -((2.0 * np.pi * hertz) ** 2) * receptance(hertz)
    inside = []
    for seed in range(5):
        noise = np.random.default_rng(seed).normal(size=(2, 900))
        values = clean + 0.003 * np.abs(clean).max() * (noise[0] + 1j * noise[1])
        found = vr.modal_fit(vr.ResponseRecord(hertz, values, excitation="blow"))
        widths = [found.data[name].values for name in ("frequency_width", "damping_ratio_width")]
        inside += (np.abs(found.frequencies - [12.0, 75.0]) < widths[0]).tolist()
        inside += (np.abs(found.damping_ratios - [0.004, 0.006]) < widths[1]).tolist()
    assert sum(inside) >= 16
    with pytest.raises(vr.InputError, match=r"the lines must be evenly spaced.*say excitation='blow'"):
        vr.modal_fit(vr.ResponseRecord(hertz, clean))


def test_noise_that_is_large_beside_a_small_peak_is_no_other_mode():
    hertz = np.arange(1, 801) * 0.125
    noise = np.random.default_rng(0).normal(size=(2, 800))
    values = receptance(hertz)
    values = values + 0.0014 * np.abs(values).max() * (noise[0] + 1j * noise[1])
    found = vr.modal_fit(vr.ResponseRecord(hertz, values, excitation="blow"))
    assert abs(found.damping_ratios[1] - 0.006) < found.data.damping_ratio_width.values[1]
    assert not any("there are others" in text for text in found.warnings)

"""Files as oscilloscopes, loggers, spreadsheets and torsion pendulums write them: one ring-down of known truth."""

from __future__ import annotations

import datetime

import numpy as np
import pytest

import viscorod as vr

HERTZ, RATIO, SIZE = 6.2, 0.011, 4e-3
TIMES = np.arange(0.0, 4.0, 0.0025)
SWING = SIZE * np.exp(-2.0 * np.pi * HERTZ * RATIO * TIMES) * np.cos(2.0 * np.pi * HERTZ * TIMES)
SWING = SWING + 1e-5 * np.random.default_rng(7).normal(size=len(TIMES))
BEGIN = datetime.datetime(2024, 3, 1, 10)


def rows(heads, row):
    return (
        "\n".join([*heads, *(row(k, t, x) for k, (t, x) in enumerate(zip(TIMES, SWING, strict=True)))]) + "\n"
    )


def clock(t):
    return f"{BEGIN + datetime.timedelta(seconds=float(t)):%H:%M:%S,%f}"


FILES = {
    "a scope with settings beside the names": (
        rows(["X,CH1,Start,Increment,", "Sequence,VOLT,0.0e+00,2.5e-03,"], lambda k, t, x: f"{k},{1e3 * x:.5e},"),
        "CH1", {"unit": "1 mm", "rate": 400.0}),
    "a spreadsheet with an empty column that has a name": (
        rows(["Time;Displacement;Remark", "[ms];[mm];"], lambda k, t, x: f"{1e3 * t:.2f};{1e3 * x:.6f};"),
        "Displacement", {}),
    "dates beside times of day, and decimal commas": (
        rows(
            ["Datum;Uhrzeit;Weg [mm]"],
            lambda k, t, x: f"01.03.2024;{clock(t)};" + f"{1e3 * x:.6f}".replace(".", ","),
        ),
        "Weg", {"time": "Uhrzeit"}),
    "a unit with brackets in it": (
        rows(["t (s),x ((mm))"], lambda k, t, x: f"{t:.5f},{1e3 * x:.6f}"), "x", {}),
}  # fmt: skip


@pytest.mark.parametrize("kind", FILES)
def test_a_ring_down_has_its_frequency_ratio_and_size(kind, tmp_path):
    text, column, more = FILES[kind]
    (tmp_path / "r.csv").write_text(text)
    record = vr.Record.read(
        tmp_path / "r.csv", column, place="beam.end", quantity="displacement", direction="x", **more
    )
    assert len(record.times) == len(TIMES)
    np.testing.assert_allclose(record.values, SWING, atol=1e-8)
    np.testing.assert_allclose(record.times - record.times[0], TIMES, atol=1e-9)


def test_units_of_responses_with_brackets_within_brackets(tmp_path):
    (tmp_path / "h.csv").write_text("f (Hz),Real ((mm/s²)/N),Imag ((mm/s²)/N)\n1,2,3\n2,4,5\n3,6,7\n")
    found = vr.ResponseRecord.read(tmp_path / "h.csv", ["Real", "Imag"])
    np.testing.assert_allclose(found.values, [2e-3 + 3e-3j, 4e-3 + 5e-3j, 6e-3 + 7e-3j])


def test_fields_of_structures_within_structures_by_the_end_of_their_names(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "m.mat", {"test": {"data": {"t": TIMES, "x_mm": 1e3 * SWING}, "fs": 400.0}})
    for column in ("data.x", "x_mm", "test.data.x", "data.x_mm"):
        found = vr.Record.read(
            tmp_path / "m.mat", column, time="data.t", time_unit="s",
            place="beam.end", quantity="displacement", direction="x",
        )  # fmt: skip
        np.testing.assert_allclose(found.values, SWING)


ABOUT = {"place": "bar.end", "direction": "x"}
TORQUE, RADIUS, LENGTH = 1e-4, 4e-3, 0.3


@pytest.fixture(scope="module")
def pendulum():
    """A shaft along x that is twisted by a torque and let go."""
    model = vr.Model()
    rubber = vr.Material(2e6, 0.45, 1100.0, damping=vr.KelvinVoigt(shear_time=1e-3, bulk_time=1e-3))
    shaft = vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=vr.Circle(RADIUS), material=rubber, elements=1)
    model.add("bar", shaft)
    model.clamp("bar.start")
    model.moment("bar.end", (TORQUE, 0.0, 0.0), until=0.0)
    return model.simulate(0.2, tolerance=1e-6)


def history(pendulum, quantity, times, **more):
    about = {**ABOUT, **more}
    return vr.Record(times, np.zeros(len(times)), quantity=quantity, **about).predicted(pendulum)


def test_rotations_moments_and_rates_of_turn_are_those_of_a_shaft(pendulum):
    """Twist at rest M L/(G J) with J = pi r^4/2; the rate is the slope of the angle; a free end carries no moment."""
    stiffness = 2e6 / 2.9 * np.pi * RADIUS**4 / 2.0
    angle = history(pendulum, "rotation", [0.0, 0.1])
    assert angle[0] == pytest.approx(TORQUE * LENGTH / stiffness, rel=1e-4)
    assert history(pendulum, "moment", [0.0, 0.1], place="bar@0.1")[0] == pytest.approx(TORQUE, rel=1e-4)
    step = 1e-4
    times = np.array([0.05 - step, 0.05, 0.05 + step])
    slope = np.diff(history(pendulum, "rotation", times)[[0, 2]])[0] / (2.0 * step)
    rate = history(pendulum, "angular_velocity", times)[1]
    assert rate == pytest.approx(slope, rel=1e-3)
    assert history(pendulum, "angular_velocity", times, direction="d3")[1] == pytest.approx(rate, rel=1e-9)
    assert history(pendulum, "rotation", times, direction="-x")[1] == pytest.approx(
        -history(pendulum, "rotation", times)[1]
    )


def test_angles_in_degrees(tmp_path):
    (tmp_path / "phi.txt").write_text(
        rows(["t/s\tphi/°"], lambda k, t, x: f"{t:.4f}\t{np.degrees(100 * x):.7f}")
    )
    found = vr.Record.read(tmp_path / "phi.txt", "phi", quantity="rotation", **ABOUT)
    np.testing.assert_allclose(found.values, 100.0 * SWING, atol=2e-9)
    assert found.unit == "rad"
    with pytest.raises(
        vr.InputError, match=r"lever: .*a rotation is that of the whole section; leave it out"
    ):
        vr.Record([0.0, 1.0], [0.0, 1.0], quantity="rotation", lever=(0.0, 0.01, 0.0), **ABOUT)

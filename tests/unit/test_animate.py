"""Films: uniform in time, in fixed limits, in formats that are there."""

import shutil
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.plain_text import flat
from helpers.synthetic_results import oscillator, rolled_up, swing
from viscorod.cli.app import app
from viscorod.pictures.animation import Film, Pace, write_film
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run


@pytest.mark.parametrize(
    ("duration", "given", "speed", "count"),
    [
        (10.0, {}, 1.0, 251),
        (10.0, {"fps": 10.0}, 1.0, 101),
        (10.0, {"speed": 2.0}, 2.0, 126),
        (0.5, {}, 0.05, 251),
        (70.0, {}, 5.0, 351),
    ],
)
def test_frames_are_uniform_in_time(duration, given, speed, count):
    pace = Pace.of(Run(swing(duration=duration)), **given)
    assert pace.speed == pytest.approx(speed)
    assert pace.times.size == count
    assert np.diff(pace.times) == pytest.approx(np.full(count - 1, speed / pace.fps))
    assert pace.times[-1] <= duration + 1e-9


def test_frames_of_a_gif_last_whole_hundredths():
    pace = Pace.of(Run(swing()), 30.0, hundredths=True)
    assert pace.fps == pytest.approx(100.0 / 3.0)
    assert np.diff(pace.times) == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("run", "given", "message"),
    [
        (swing(), {"fps": 0.0}, "fps = 0.0: give a positive number"),
        (swing(), {"speed": -1.0}, "speed = -1.0: give a positive number"),
        (swing(), {"speed": 1e-3}, "250001 frames are too many"),
        (swing().isel(time=[0]), {}, "one state only"),
    ],
)
def test_wrong_paces(run, given, message):
    with pytest.raises(vr.InputError, match=message):
        Pace.of(Run(run), **given)


def test_a_frame_shows_the_rod_at_its_time_in_the_same_limits():
    run = Run(swing(duration=2.0))
    film = Film(run, Pace.of(run, 5.0, 1.0))
    axes = film.figure.axes[0]
    limits = axes.get_xlim(), axes.get_ylim()
    for number in (0, 3, 7):
        film.draw(number)
        film.figure.canvas.draw()
        rod = next(line for line in axes.lines if line.get_label() == "rod")
        expected, _ = oscillator(film.pace.times[number], 0.05, 3.6, 0.2)
        assert rod.get_ydata()[-1] == pytest.approx(expected, abs=1e-6)
        assert (axes.get_xlim(), axes.get_ylim()) == limits
        assert film._clock.get_text() == f"t = {0.2 * number:.1f} s"
    assert sum(line.get_label() == "rod" for line in axes.lines) == 1
    assert max(limits[1]) > 0.2


def test_gif_has_all_frames_at_their_pace(tmp_path):
    from PIL import Image

    path = Run(swing(duration=2.0)).animate(tmp_path / "new" / "swing.gif", fps=5.0)
    with Image.open(path) as film:
        assert film.n_frames == 11
        assert film.info["duration"] == 200
        assert film.info["loop"] == 0
        first = np.asarray(film.convert("RGB"))
        film.seek(4)
        assert np.any(np.asarray(film.convert("RGB")) != first)


def test_mp4_has_all_frames(tmp_path):
    reader = pytest.importorskip("imageio_ffmpeg", reason="films in .mp4 need the extra viscorod[animate]")
    path = write_film(Run(swing(duration=2.0)), tmp_path / "swing.mp4", fps=5.0)
    frames, seconds = reader.count_frames_and_secs(str(path))
    assert frames == 11
    assert seconds == pytest.approx(2.2, abs=0.05)


def test_missing_ffmpeg_is_one_message(monkeypatch, tmp_path):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(vr.InputError, match=r"type: pip install 'viscorod\[animate\]', or write a \.gif"):
        write_film(Run(swing(duration=2.0)), tmp_path / "swing.mp4")


def test_unknown_format_is_refused_before_anything_is_drawn(tmp_path):
    with pytest.raises(vr.InputError, match=r"'\.avi' is not that of a film; use \.mp4 or \.gif"):
        write_film(Run(swing()), tmp_path / "swing.avi")


def test_command(tmp_path):
    Run(swing(duration=2.0)).save(tmp_path / "run.nc")
    Equilibrium(rolled_up()).save(tmp_path / "arc.nc")
    result = CliRunner().invoke(app, ["animate", str(tmp_path / "run.nc"), "--fps", "4", "--speed", "2"])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "motion.gif").stat().st_size > 5_000
    assert "5 frames, speed 2" in flat(result.stdout)
    result = CliRunner().invoke(app, ["animate", str(tmp_path / "arc.nc")])
    assert result.exit_code == 2
    assert "a film needs a motion over time" in result.stderr

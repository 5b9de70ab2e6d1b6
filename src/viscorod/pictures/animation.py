"""A film of a motion, uniform in time, seen as in the pictures."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.plots.assemblies import Assembly
from viscorod.pictures.plots.projection_view import Curves, View, draw_reference, mark_supports
from viscorod.pictures.style import BLUE, DPI, GREY, INK, ORANGE, SMALL, TEXT, titled
from viscorod.results.probe import instants_of, poses_at
from viscorod.typing import Floats
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.run import Run

FORMATS = (".mp4", ".gif")
MOST_FRAMES = 20_000

_SLOWEST = 1.6e-3  # frames per second: a GIF counts hundredths of a second in two bytes
_SHORT, _LONG = 2.0, 60.0  # film [s] at true speed
_USUAL = 10.0  # of one that would be shorter or longer
_WIDTH, _HEIGHT = 8.0, 6.0
_MARGIN = 0.04
_FINE = 8  # points of the path from frame to frame
_COLOURS = 128  # of a GIF


@dataclass(frozen=True)
class Pace:
    """The instants of the frames of a film.

    Attributes:
        times: of the frames [s], uniform; fps: frames per second of the film; speed: seconds of motion in one of it.
    """

    times: Floats
    fps: float
    speed: float

    @classmethod
    def of(cls, run: Run, fps: float = 25.0, speed: float | None = None, *, hundredths: bool = False) -> Pace:
        """Choose the frames.

        Args:
            run: the motion.
            fps: wanted frames per second; speed: seconds of motion in one second of film. Without it a motion of 2 to
                60 s is shown at its own speed, others such that the film lasts 10 s, at a round speed.
            hundredths: frames last whole hundredths of a second, as a GIF needs it.

        Raises:
            InputError: a number is not positive, or there would be more than 20 000 frames.
        """
        for name, value in (("fps", fps), ("speed", speed)):
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise InputError(f"{name} = {value!r}: give a positive number")
        start, end = float(run.time[0]), float(run.time[-1])
        if run.time.size < 2:
            raise InputError("this run holds one state only; a film needs two or more")
        if hundredths:
            if fps < _SLOWEST:
                raise InputError(
                    f"fps = {fps!r}: a frame of a .gif lasts 655 s at most; give {_SLOWEST:g} or more"
                )
            fps = 100.0 / max(2, round(100.0 / fps))
        if speed is None:
            speed = 1.0 if _SHORT <= end - start <= _LONG else _round_number((end - start) / _USUAL)
        frames = (end - start) * fps / speed * (1.0 + 1e-12)
        count = math.floor(frames + 1e-9) + 1 if frames < 1e9 else MOST_FRAMES + 1
        if count > MOST_FRAMES:
            raise InputError(
                f"{max(frames, count):.6g} frames are too many (at most {MOST_FRAMES}); "
                "give a larger speed or fewer frames per second"
            )
        times = np.asarray(start + np.arange(count) * speed / fps, dtype=np.float64)
        return cls(times, fps, speed)


class Film:
    """The frames of a motion, drawn one after the other into one figure.

    Attributes:
        figure: of matplotlib.
    """

    figure: Figure

    def __init__(self, run: Run, pace: Pace) -> None:
        self.pace = pace
        self._run = run
        stations = np.arange(run.data.sizes["station"])
        self._poses = poses_at(run, stations, instants_of(run, pace.times))
        self._curves, self._assembly = Curves(run), Assembly(run)
        self._site, _ = run.main_motion
        every = np.arange(_FINE * (len(self) - 1) + 1) / _FINE
        instants = instants_of(run, np.interp(every, np.arange(len(self)), pace.times))
        around = poses_at(run, self._site.stations, instants).position
        self._trail = self._site.mixed(around)
        reference = np.asarray(run.data["reference_position"].values, dtype=float)
        ends = [self._assembly.ends(r, q).reshape(-1, 3) for r, q in self._states()]
        everything = np.concatenate([self._poses.position.reshape(-1, 3), reference, *ends])
        self._view = View.of(everything, lines=self._curves.points(self._poses.position[0]))
        self.figure = titled(run, _WIDTH, _HEIGHT)
        self._axes = self.figure.add_subplot()
        self._view.prepare(self._axes, "")
        draw_reference(self._axes, self._view, self._curves, run)
        self._axes.update_datalim(self._view.on_paper(everything).T)
        if self._view.plane is None:
            floor = everything.copy()
            floor[:, 2] = self._view.floor
            self._axes.update_datalim(self._view.on_paper(floor).T)
        self._axes.margins(_MARGIN)
        self._axes.autoscale_view()
        self._view.finish(self._axes)
        self._axes.apply_aspect()  # which sets the limits, for all frames
        self._axes.set_autoscale_on(False)
        self._axes.set_aspect("equal", adjustable="box")
        self._clock = self.figure.text(0.985, 0.98, "", fontsize=TEXT, color=INK, ha="right", va="top")
        self._still = set(self._axes.lines)
        self.draw(0)
        self._legend(self._axes)

    def __len__(self) -> int:
        return self.pace.times.size

    def draw(self, number: int) -> None:
        """Draw a frame into the figure, in place of the one before."""
        axes, view = self._axes, self._view
        for line in [line for line in axes.lines if line not in self._still]:
            line.remove()
        position, rotation = self._poses.position[number], self._poses.rotation[number]
        trail = view.on_paper(self._trail[: _FINE * number + 1])
        axes.plot(*trail, color=ORANGE, linewidth=1.0, zorder=1.8, label=f"path of {self._site.label}")
        name = "rod" if len(self._run.sites.rods) == 1 else "rods"
        self._curves.draw(axes, view, position, color=BLUE, linewidth=2.4, label=name)
        if not self._assembly.empty:
            self._assembly.draw(axes, view, position, rotation, BLUE)
            self._assembly.draw_springs(axes, view, position, rotation, GREY)
        mark_supports(axes, view, self._run, position)
        speed = "" if self.pace.speed == 1.0 else f", shown {_times(self.pace.speed)}"
        step = self.pace.speed / self.pace.fps
        digits = max(0, -math.floor(math.log10(step)))
        self._clock.set_text(f"t = {self.pace.times[number]:.{digits}f} s{speed}")

    def images(self, progress: Callable[[int], None] | None = None) -> Iterator[np.ndarray]:
        """Draw and yield all frames ``(height, width, 3)``, bytes; ``progress`` is called with the number done."""
        canvas: Any = self.figure.canvas
        for number in range(len(self)):
            self.draw(number)
            canvas.draw()
            yield np.asarray(canvas.buffer_rgba())[..., :3]
            if progress is not None:
                progress(number + 1)

    def _states(self) -> Iterator[tuple[Floats, Floats]]:
        return zip(self._poses.position, self._poses.rotation, strict=True)

    @staticmethod
    def _legend(axes: Axes) -> None:
        handles, labels = axes.get_legend_handles_labels()
        shown = [k for k, label in enumerate(labels) if "shadow" not in label]
        axes.legend(
            [handles[k] for k in shown],
            [labels[k] for k in shown],
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            ncols=6,
            frameon=False,
            fontsize=SMALL,
            handlelength=1.6,
            columnspacing=1.2,
            borderaxespad=0.1,
        )


def write_film(
    run: Run,
    path: str | Path,
    *,
    fps: float = 25.0,
    speed: float | None = None,
    progress: Callable[[int], None] | None = None,
) -> Path:
    """Write a film of a run; see ``Run.animate``."""
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(
            f"{path}: the suffix {path.suffix!r} is not that of a film; use {' or '.join(FORMATS)}"
        )
    program = _ffmpeg() if suffix == ".mp4" else ""
    film = Film(run, Pace.of(run, fps, speed, hundredths=suffix == ".gif"))
    with replacing(path) as new:
        if suffix == ".gif":
            _write_gif(film, new, progress)
        else:
            _write_mp4(film, new, program, progress)
    return path


def _write_gif(film: Film, path: Path, progress: Callable[[int], None] | None) -> None:
    """Let Pillow write frame after frame, so that memory does not depend on their number."""
    from PIL import Image

    def pictures() -> Iterator[Image.Image]:
        for frame in film.images(progress):
            yield Image.fromarray(frame).quantize(_COLOURS, dither=Image.Dither.NONE)

    rest = pictures()
    delay = round(1000.0 / film.pace.fps)
    next(rest).save(path, save_all=True, append_images=rest, duration=delay, loop=0)


def _write_mp4(film: Film, path: Path, program: str, progress: Callable[[int], None] | None) -> None:
    from matplotlib import rc_context
    from matplotlib.animation import FFMpegWriter

    # frames per second may be a fraction, whatever the hints of matplotlib say
    options: dict[str, Any] = {"fps": film.pace.fps, "codec": "libx264"}
    with rc_context({"animation.ffmpeg_path": program}), _told_by_ffmpeg(path):
        writer = FFMpegWriter(extra_args=["-pix_fmt", "yuv420p", "-crf", "20"], **options)
        with writer.saving(film.figure, str(path), DPI):
            for number in range(len(film)):
                film.draw(number)
                writer.grab_frame()
                if progress is not None:
                    progress(number + 1)


@contextmanager
def _told_by_ffmpeg(path: Path) -> Iterator[None]:
    """Turn the end of the program, which has no room to write for example, into an error of the system."""
    try:
        yield
    except (subprocess.CalledProcessError, BrokenPipeError):
        free = shutil.disk_usage(path.parent).free
        raise OSError(f"ffmpeg could not write it; {free / 1e6:.3g} MB are free on the disk") from None


def _ffmpeg() -> str:
    """Return the program that makes films: the one on the PATH, or that of the package imageio-ffmpeg."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ModuleNotFoundError, RuntimeError):
        raise InputError(
            "a film in .mp4 needs ffmpeg, which is not there; type: pip install 'viscorod[animate]', or write a .gif"
        ) from None


def _round_number(value: float) -> float:
    """Return the nearest of 1, 2 and 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(
        min((step * power for step in (1.0, 2.0, 5.0, 10.0)), key=lambda n: abs(math.log(n / value)))
    )


def _times(speed: float) -> str:
    return f"{speed:g} times faster" if speed > 1.0 else f"{1.0 / speed:g} times slower"

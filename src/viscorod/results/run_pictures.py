"""Pictures of a motion over time, in the words of ``viscorod plot``."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING

from viscorod.checks import checked
from viscorod.results.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.run import Run

__all__ = ["RunPictures"]


class RunPictures(Result):
    """Methods that draw; a part of ``Run``."""

    @property
    @abstractmethod
    def _motion(self) -> Run:
        """Return the run of which this is a part."""

    @checked
    def plot(
        self,
        path: str | Path | None = None,
        place: str | int | None = None,
        axis: str | None = None,
        *,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the motion: history with envelope, snapshots of the rods, damping ratio of every cycle.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            place: place whose displacement is drawn; by default the one that moves most.
            axis: global axis; by default the one along which the place moves most.
            ax: axes of yours to draw into: the history with its envelope alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such place or axis, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_motion import draw_motion

        return delivered(draw_motion(self._motion, place, axis, ax), path)

    @checked
    def plot_tip(
        self,
        path: str | Path | None = None,
        place: str | int | None = None,
        axis: str | None = None,
        *,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw one displacement over time, with its decay.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            place: place whose displacement is drawn; by default the one that moves most.
            axis: global axis; by default the one along which the place moves most.
            ax: axes of yours to draw into: the same.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such place or axis, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_motion import draw_tip

        return delivered(draw_tip(self._motion, place, axis, ax), path)

    @checked
    def plot_energy(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw the energy account over time, and the numerical remainder.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the account alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_energy import draw_energy

        return delivered(draw_energy(self._motion, ax), path)

    @checked
    def plot_phase(
        self,
        path: str | Path | None = None,
        place: str | int | None = None,
        axis: str | None = None,
        *,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw velocity over displacement.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            place: place whose displacement is drawn; by default the one that moves most.
            axis: global axis; by default the one along which the place moves most.
            ax: axes of yours to draw into: the same.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such place or axis, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_phase import draw_phase

        return delivered(draw_phase(self._motion, place, axis, ax), path)

    @checked
    def plot_space_time(
        self,
        path: str | Path | None = None,
        quantity: str = "section_force",
        component: str | None = None,
        rod: str | None = None,
        *,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw one component over arc length and time, an image for every rod.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            quantity: "strain", "section_force" or "dissipation".
            component: "shear_1", "shear_2", "stretch", "bend_1", "bend_2" or "twist"; by default what changes most.
            rod: by default all, or the four where it is largest.
            ax: axes of yours to draw into: the image of one rod.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such quantity, component or rod, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_strain import draw_space_time

        return delivered(draw_space_time(self._motion, quantity, component, rod, ax), path)

    @checked
    def animate(self, path: str | Path, *, fps: float = 25.0, speed: float | None = None) -> Path:
        """Write a film of the motion, uniform in time, in fixed limits.

        Args:
            path: .mp4 (needs ffmpeg: pip install 'viscorod[animate]') or .gif.
            fps: frames per second of the film; those of a .gif last whole hundredths of a second.
            speed: seconds of motion in one second of film. By default 1 for a motion of 2 to 60 s, else a round number
                for which the film lasts about 10 s.

        Returns:
            The path.

        Raises:
            InputError: the suffix is unknown, ffmpeg is missing, or there would be too many frames.
        """
        from viscorod.pictures.animation import write_film

        return write_film(self._motion, path, fps=fps, speed=speed)

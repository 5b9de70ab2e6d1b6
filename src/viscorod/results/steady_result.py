"""The result of a steady rotation."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.last_state import LastState
from viscorod.shown import counted
from viscorod.solve.modes.vibrations import Vibrations
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Steady(LastState):
    """A steady rotation: every rod turns like a rigid body, bent and stressed; and its small motions.

    ``data`` holds one state along the dimension ``spin``, at one instant of the rotation.
    """

    kind: ClassVar[str] = "steady"

    def _facts(self) -> Iterator[str]:
        yield f"{float(np.linalg.norm(self.spin)):.4g} rad/s"
        growing = int(self.stored.attrs["unstable"])
        yield (
            f"{counted(growing, 'small motion')} {'grows' if growing == 1 else 'grow'}"
            if growing
            else "stable"
        )
        yield from super()._facts()

    @property
    def spin(self) -> Floats:
        """Angular velocity [rad/s], global axes, shape (3,)."""
        return self._values("spin_vector")

    @property
    def joint_spin(self) -> Floats:
        """Angular velocity [rad/s] in the axes d1, d2, d3 of the node at the ball joint (or of the first), (3,)."""
        return self._values("joint_spin")

    @property
    def centre(self) -> Floats:
        """A point on the axis [m]: the ball joint, the mass centre, or what was given, shape (3,)."""
        return self._values("centre")

    @property
    def angular_momentum(self) -> Floats:
        """Angular momentum about the centre [N m s], global axes, shape (3,)."""
        return self._values("momentum")

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy [J]."""
        return float(self._values("kinetic")[0])

    @property
    def formulation(self) -> str:
        """The word "geometric" or "intrinsic"."""
        return str(self.stored.attrs["formulation"])

    @property
    def damping(self) -> str:
        """The word "full" or "linearised"."""
        return str(self.stored.attrs["damping"])

    @property
    def residual(self) -> float:
        """Largest imbalance of a node, as a part of the largest force that balances; 0 is exact."""
        return float(self.stored.attrs["residual"])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """``s`` [1/s] of the small motions ``exp(s t)`` about the rotation: one of each conjugate pair, slowest first.

        Turning all in space, or moving it, makes a copy of the same rotation and is not a small motion here. A change
        of the angular speed of a rod that turns freely is one, with s = 0.
        """
        real, imaginary = self._values("eigenvalue").T
        values: np.ndarray = real + 1j * imaginary
        return values

    @property
    def frequencies(self) -> Floats:
        """Natural frequencies ``|s|/2 pi`` [Hz] ``(motions,)``; those of a Campbell diagram are ``|Im s|/2 pi``."""
        size: Floats = np.abs(self.eigenvalues) / (2.0 * np.pi)
        return size

    @property
    def damping_ratios(self) -> Floats:
        """``-Re s/|s|`` of the eigenvalues ``(motions,)``; 0 where s = 0."""
        s = self.eigenvalues
        ratios: Floats = np.divide(-s.real, np.abs(s), out=np.zeros(len(s)), where=np.abs(s) > 0.0)
        return ratios

    @cached_property
    def modes(self) -> Vibrations:
        """The small motions with their shapes about the shape that turns, in the order of the eigenvalues.

        Shapes are seen from the turning axes, at the instant that is stored. All small motions are computed, so that
        none is missing among the slowest.

        Raises:
            InputError: the result is of a version that kept no shapes.
        """
        if "mode_shape" not in self.stored:
            raise InputError("this result has no shapes of its small motions; compute it again")
        shapes, rotations = (
            self._values(name)[:, 0] + 1j * self._values(name)[:, 1]
            for name in ("mode_shape", "mode_rotation")
        )
        return Vibrations(
            eigenvalues=self.eigenvalues,
            frequencies=self.frequencies,
            damping_ratios=self.damping_ratios,
            shapes=shapes,
            rotations=rotations,
            positions=self.field("position", states=-1),
            residuals=self._values("mode_residual"),
            names=tuple(str(name) for name in self.stored["mode_name"].values),
            shares=self._values("mode_share"),
            rigid=0,
            certified=True,
        )

    @property
    def shapes(self) -> np.ndarray:
        """Displacements in the small motions ``(eigenvalues, stations, 3)``, global axes, complex; see ``modes``."""
        return self.modes.shapes

    @property
    def stable(self) -> bool:
        """True if no small motion grows faster than round-off."""
        return int(self.stored.attrs["unstable"]) == 0

    @property
    def growth_rate(self) -> float:
        """The largest rate of growth [1/s] of a small motion; 0 if stable."""
        return float(self.stored.attrs["growth_rate"])

    @property
    def neutral(self) -> int:
        """Number of small motions, both of a conjugate pair, that neither grow nor fade beyond round-off."""
        return int(self.stored.attrs["neutral"])

    def report(self) -> str:
        """Return a report: the rotation, ends of the rods, energies, stability, the effort, warnings."""
        from viscorod.results.reports.steady_report import steady_report

        return steady_report(self)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw the reference shape and the one that turns.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the shapes.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_shape import draw_shape

        return delivered(draw_shape(self, ax), path)

    @checked
    def plot_modes(
        self,
        path: str | Path | None = None,
        count: int | None = None,
        *,
        number: int | None = None,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the small motions about it, see ``Modes.plot``.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            count: how many are drawn, all by default; number: of one that is drawn alone, from 1.
            ax: axes of yours to draw into: one of them.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such mode, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_modes import draw_modes

        return delivered(draw_modes(self, self.modes, count, number, ax), path)

    def _values(self, name: str) -> Floats:
        values: Floats = np.asarray(self.stored[name].values, dtype=float)
        return values

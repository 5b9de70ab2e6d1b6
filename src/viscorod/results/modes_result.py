"""The result of a search for small vibrations."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from viscorod.checks import checked
from viscorod.results.frequency_words import frequency_note
from viscorod.results.result import Result
from viscorod.results.text_numbers import number
from viscorod.results.text_table import listed, numbers, page, tabulated, words
from viscorod.shown import counted, span
from viscorod.typing import Floats
from viscorod.wording import some_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Modes"]


class Modes(Result):
    """Small vibrations about a state in order of natural frequency, rigid motions first.

    Each rigid motion (and mechanism) is listed once, with the frequency and the damping ratio 0; geometry tells how
    many there are. An overdamped mode gives two real eigenvalues, listed beside each other at the natural frequency
    that it has without damping, so that creeping motions whose rates crowd near one over the retardation time of the
    material do not come before slow vibrations. The real roots by which Maxwell branches creep are left out.

    ``data`` holds the state that they are about along the dimension ``load_factor``, and the modes along
    ``small_motion``.
    """

    kind: ClassVar[str] = "modes"
    picture: ClassVar[str] = "modes"

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.names), "mode")
        if len(self.names):
            yield span(float(self.frequencies[0]), float(self.frequencies[-1]), "Hz")
        yield f"about {self.about}"
        yield from super()._facts()

    def _drawing(self) -> str:
        """Return where they swing about, dashed, and the first that is no rigid motion."""
        base = self.positions
        if self.rigid >= len(self.names):
            return self._shapes(base, base)
        shape = self.shapes[self.rigid]
        shape = np.real(shape * np.exp(-0.5j * np.angle(np.sum(shape * shape))))
        largest = float(np.abs(shape).max())
        size = 0.15 * float(np.ptp(base, axis=0).max())
        return self._shapes(base, base + (size / largest * shape if largest > 0.0 else 0.0))

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """``s`` in ``exp(s t)`` [1/s], one of each conjugate pair (Im >= 0); overdamped modes give two real ones."""
        real, imaginary = self._values("eigenvalue").reshape(-1, 2).T
        found: np.ndarray = real + 1j * imaginary
        return found

    @cached_property
    def frequencies(self) -> Floats:
        """Natural frequencies ``|s|/2 pi`` [Hz] ``(modes,)``, of proportional damping those without it.

        A mode swings at ``|Im s|/2 pi``, which is sqrt(1 - ratio^2) of it; stability and Campbell diagrams have that.
        """
        return np.asarray(np.abs(self.eigenvalues) / (2.0 * np.pi))

    @cached_property
    def damping_ratios(self) -> Floats:
        """``-Re s/|s|`` ``(modes,)``; 0 of rigid motions."""
        s = self.eigenvalues
        return np.asarray(np.divide(-s.real, np.abs(s), out=np.zeros(len(s)), where=np.abs(s) > 0.0) + 0.0)

    @cached_property
    def shapes(self) -> np.ndarray:
        """Displacement of every station ``(modes, stations, 3)``, global axes, complex, largest component 1.

        Of a pure twist it is the largest rotation that is 1.
        """
        return self._complex("mode_shape")

    @cached_property
    def rotations(self) -> np.ndarray:
        """Rotation of every station ``(modes, stations, 3)``, body axes, same scaling."""
        return self._complex("mode_rotation")

    @property
    def positions(self) -> Floats:
        """Positions of the stations about which they swing ``(stations, 3)`` [m]."""
        return self.field("position", states=-1)

    @property
    def residuals(self) -> Floats:
        """The forces that an eigenvalue and its shape leave unbalanced, as a part of the largest of those that balance.

        All are measured by the displacements (or accelerations) that they would cause; without damping it is a bound
        of the relative error of the squared frequency of this mesh.
        """
        return self._values("mode_residual")

    @property
    def names(self) -> tuple[str, ...]:
        """What each is: ``"bend_1 2"`` is the second mode whose elastic energy is mostly that of bending about d1.

        The words are those of the strains, ``"spring"`` for springs, ``"swing"`` for parts that move like rigid ones
        under loads that turn them back, ``"damper"`` for what dampers alone resist; rigid motions are described. Modes
        near a frequency have no number where there are too many below them to be counted by kind.
        """
        return tuple(str(name) for name in self.stored["mode_name"].values)

    @property
    def shares(self) -> Floats:
        """Parts of the elastic energy of the rods in every strain ``(modes, 6)``; zeros of rigid motions."""
        return self._values("mode_share")

    @property
    def rigid(self) -> int:
        """Number of rigid motions in the list."""
        return int(self.stored.attrs["mode_rigid"])

    @property
    def certified(self) -> bool:
        """True if it is proven that none is missing up to the highest one.

        Or between the lowest and the highest of those near a frequency; but for others with just its frequency where
        there are more than 30 of them, as in many equal rods. The proof is an inertia count of the undamped modes
        (Sylvester), each of which is one of the damped ones here, or that these are all modes. False where damping
        couples the modes of a large model, or where following loads make its stiffness unsymmetric: residuals hold,
        but nothing proves that there are no others.
        """
        return bool(self.stored.attrs["mode_certified"])

    @property
    def frequency_errors(self) -> Floats:
        """Estimated errors of the frequencies by the mesh, in parts of them ``(modes,)``; none where not estimated."""
        return self._values("mode_error") if "mode_error" in self.stored else np.zeros(0)

    def with_errors(self, errors: Floats) -> Self:
        """Return the same with estimated errors of the frequencies ``(modes,)``."""
        return type(self)(self.data.assign(mode_error=("small_motion", errors)))

    def report(self) -> str:
        """Return a report: a table of the modes, how sure they are, warnings."""
        errors = self.frequency_errors
        ratios = [
            ("grows" if s.real > 0.0 else "overdamped")
            if k >= self.rigid and abs(s.imag) <= 1e-9 * abs(s)
            else number(ratio, 5, size=1.0)
            for k, (s, ratio) in enumerate(zip(self.eigenvalues, self.damping_ratios.tolist(), strict=True))
        ]
        modes = tabulated(
            "Modes",
            words("mode", [f"{k}: {name}" for k, name in enumerate(self.names, 1)]),
            numbers(("frequency",), "Hz", self.frequencies),
            words("damping ratio", ratios),
            words("mesh error", [f"{error:.1g}" for error in errors]) if len(errors) else [],
        )
        heading = f"{self.title + chr(10) if self.title else ''}Small vibrations about {self.about}"
        sure = (
            "It is proven that none is missing among them"
            if self.certified
            else "It is not proven that none is missing among them"
        )
        sure += f"; largest residual {self.residuals.max(initial=0.0):.1g}"
        blocks = [
            heading,
            modes,
            *frequency_note(self.damping_ratios, natural=True),
            sure,
        ]
        if self.assumptions:
            blocks.append(listed("Assumptions about damping", self.assumptions))
        if self.warnings:
            blocks.append(listed("Warnings", self.warnings))
        return page(blocks)

    @property
    def assumptions(self) -> list[str]:
        """What was assumed of the damping of the rods, one sentence each, such as how well moduli were fitted."""
        by_rod = json.loads(self.stored.attrs.get("damping_assumptions", "{}"))
        sentences: dict[str, list[str]] = {}
        for rod, texts in by_rod.items():
            for text in texts:
                sentences.setdefault(text, []).append(rod)
        return [f"rod{'s' * (len(rods) > 1)} {some_of(rods)}: {text}" for text, rods in sentences.items()]

    @property
    def about(self) -> str:
        """What they are about, in words."""
        return str(self.stored.attrs.get("mode_about", "a state"))

    @checked
    def plot(
        self,
        path: str | Path | None = None,
        count: int | None = None,
        *,
        number: int | None = None,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw the modes.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            count: how many are drawn, all by default; number: of one that is drawn alone, from 1.
            ax: axes of yours to draw into: one mode, by default the first.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such mode, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_modes import draw_modes

        return delivered(draw_modes(self, self, count, number, ax), path)

    def _values(self, name: str) -> Floats:
        return np.asarray(self.stored[name].values, dtype=float)

    def _complex(self, name: str) -> np.ndarray:
        parts = self._values(name)
        found: np.ndarray = parts[:, 0] + 1j * parts[:, 1]
        return found

"""Theories of a planar straight beam beside the exact one: how much each of them errs, and which is enough."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from viscorod.alike import Alike
from viscorod.argument_names import known_arguments
from viscorod.attributes import WellNamed
from viscorod.results.text_numbers import per_cent
from viscorod.results.text_table import listed, numbers, page, table, words
from viscorod.shown import Shown
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["TheoryComparison", "TheorySolution"]

ROUND_OFF = 1e-9
"""A force below this part of the largest reads 0."""
LITTLE = 1e-4
"""Moments over the length below this part of the forces, and the other way round, are not what errors are parts of."""


@known_arguments
@dataclass(frozen=True, eq=False)
class TheorySolution(Alike):
    """What one theory says of a beam; one state of an equilibrium, or many of a motion.

    Attributes:
        word, title: its name in Python and in reports.
        displacement: along the beam and across it (states, nodes, 2), m.
        section_force: axial force [N], shear force [N] and bending moment [N m] (states, points, 3).
        frequencies: the slowest undamped ones in the plane about the equilibrium, Hz.
        stable: whether no small motion in the plane grows from the equilibrium.
    """

    word: str
    title: str
    displacement: Floats
    section_force: Floats
    frequencies: Floats
    stable: bool = True

    @property
    def deflection(self) -> float:
        """The largest displacement across the beam, m, with its sign."""
        across = self.displacement[..., 1].ravel()
        return float(across[np.argmax(np.abs(across))])

    @property
    def largest_forces(self) -> Floats:
        """The largest axial force [N], shear force [N] and bending moment [N m] by size (3,)."""
        found: Floats = np.abs(self.section_force).max(axis=(0, 1))
        return found


@known_arguments
@dataclass(frozen=True, eq=False, repr=False)
class TheoryComparison(WellNamed, Shown, Alike):
    """Theories of a planar straight beam beside the exact one.

    Attributes:
        exact: the geometrically exact rod.
        theories: the approximate ones by their words, from the simplest on.
        s: arc lengths of the nodes (nodes,) and of the points of section forces (points,), m.
        point_s: of the points.
        time: of the states (states,), s; 0 of an equilibrium.
        within: what a theory may err by to be enough.
        warnings: doubts, one sentence each.
    """

    exact: TheorySolution
    theories: Mapping[str, TheorySolution]
    s: Floats
    point_s: Floats
    time: Floats
    within: float
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "theories", MappingProxyType(dict(self.theories)))

    def _facts(self) -> Iterator[str]:
        yield self.sentence.partition(":")[0]
        for word in self.theories:
            yield f"{word.replace('_', ' ')} errs by {per_cent(100.0 * self.displacement_error(word))}"

    def _drawing(self) -> str:
        across = self.exact.displacement[..., 1]
        state = int(np.argmax(np.abs(across).max(axis=-1)))
        drawing = Drawing(equal=False)
        drawing.line(np.stack([self.s, across[state]], axis=-1))
        for theory in self.theories.values():
            drawing.line(np.stack([self.s, theory.displacement[state, :, 1]], axis=-1), faint=True)
        return drawing.svg()

    def displacement_error(self, word: str) -> float:
        """Return the largest difference of displacements from the exact ones over the largest of these."""
        exact = self.exact.displacement
        apart = np.linalg.norm(self.theories[word].displacement - exact, axis=-1).max()
        size = np.linalg.norm(exact, axis=-1).max()
        return float(apart / size) if size > 0.0 else 0.0

    def force_errors(self, word: str) -> Floats:
        """Return the largest differences of axial force, shear force and moment over the largest exact ones (3,).

        The two forces count over the larger of both.
        """
        exact = self.exact.section_force
        apart = np.abs(self.theories[word].section_force - exact).max(axis=(0, 1))
        size = self.exact.largest_forces
        size[:2] = size[:2].max()
        length = float(self.s[-1])
        least = LITTLE * max(float(size[0]), float(size[2]) / length) * np.array([1.0, 1.0, length])
        size = np.maximum(size, least)
        found: Floats = np.divide(apart, size, out=np.zeros(3), where=size > 0.0)
        return found

    def frequency_errors(self, word: str) -> Floats:
        """Return the relative errors of the frequencies ``(modes,)``."""
        exact, found = self.exact.frequencies, self.theories[word].frequencies
        count = min(exact.size, found.size)
        exact, found = exact[:count], found[:count]
        return np.divide(found - exact, exact, out=np.zeros(count), where=exact > 0.0)

    def error(self, word: str) -> float:
        """Return what a theory errs by: the larger of the errors of displacements and of bending moments."""
        return max(self.displacement_error(word), float(self.force_errors(word)[2]))

    @property
    def enough(self) -> str:
        """The word of the simplest theory whose error is within what is wanted; "exact" if none is."""
        return next((word for word in self.theories if self.error(word) <= self.within), self.exact.word)

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        errors = ", ".join(
            f"{found.title} errs by {_per_cent(self.error(word))}" for word, found in self.theories.items()
        )
        what = "this motion" if self.time.size > 1 else "this load"
        if self.enough == self.exact.word:
            verdict = f"only the exact theory is within {per_cent(100.0 * self.within, 3)}"
        else:
            verdict = (
                f"{self.theories[self.enough].title} is enough (within {per_cent(100.0 * self.within, 3)})"
            )
        return f"For {what} {verdict}: {errors}."

    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw deflections and bending moments of all theories.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the deflections alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_theories import draw_theories

        return delivered(draw_theories(self, ax), path)

    def __str__(self) -> str:
        found = [self.exact, *self.theories.values()]
        forces = np.array([_forces(one) for one in found])
        columns = [
            words("theory", [one.title for one in found]),
            numbers(("deflection",), "m", [one.deflection for one in found]),
            numbers(("axial", "shear"), "N", forces[:, :2]),
            numbers(("moment",), "N m", forces[:, 2]),
            numbers(("first frequency",), "Hz", [one.frequencies[0] for one in found]),
        ]
        header, *cells = zip(*((head, *column) for part in columns for head, column in part), strict=True)
        rows = [cells[0]]
        for word, own in zip(self.theories, cells[1:], strict=True):
            errors = (self.displacement_error(word), *self.force_errors(word))
            texts = [f"errs {_per_cent(error)}" for error in errors]
            frequency = f"errs {_per_cent(float(self.frequency_errors(word)[0]), '+')}"
            rows += [own, ("", *texts, frequency)]
        title = "Largest deflection and section forces; errors are the largest differences over the largest exact value"
        warnings = [listed("Warnings", self.warnings)] if self.warnings else []
        return page(["\n".join([table(title, header, rows), self.sentence, *warnings])])


def _forces(found: TheorySolution) -> Floats:
    """Return the largest section forces ``(3,)``; those that are round-off are 0."""
    forces = found.largest_forces
    forces[:2] = np.where(forces[:2] < ROUND_OFF * forces[:2].max(), 0.0, forces[:2])
    return forces


def _per_cent(part: float, sign: str = "") -> str:
    return f"{100.0 * part:{sign}.{2 if abs(part) < 0.1 else 0}{'g' if abs(part) < 0.1 else 'f'}} %"

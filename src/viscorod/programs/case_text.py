"""Write a rod as a case file: one section per piece, so that a blade read from another program can be run."""

from __future__ import annotations

import numpy as np

from viscorod.checks import checked_with, number_of_parts, of_class
from viscorod.errors import Fault, InputError
from viscorod.model.centrelines.line_shapes import Straight
from viscorod.model.centrelines.parametric_lines import ThroughPoints
from viscorod.model.rod import Rod
from viscorod.programs.blades.gxbeam_assembly import section_turn
from viscorod.programs.matrices import symmetric_part
from viscorod.programs.own_laws import refuse_tilt
from viscorod.typing import Floats

__all__ = ["case_text"]


@checked_with(rod=of_class(Rod), pieces=number_of_parts)
def case_text(rod: Rod, pieces: int = 40, *, title: str = "Blade") -> str:
    """Return a case file with the rod clamped at its start, under gravity, in equilibrium.

    Sections are those at the middle of equal pieces, so results approach those of the rod with the square of their
    number. Their matrices are turned to the rotation-minimising frame that starts as the rod's, which changes nothing
    of their law; the initial twist is in them. A curved rod becomes a spline through the ends of the pieces.

    Args:
        rod: any rod without Maxwell branches and without a law of its sections.
        pieces: number of sections.
        title: of the case.

    Raises:
        InputError: the rod has Maxwell branches or a law.
    """
    if rod.relaxing or rod.law is not None:
        what = (
            "its sections have Maxwell branches" if rod.relaxing else "its sections have a law of their own"
        )
        raise InputError(Fault("rod", "", what, "write the case by hand, with its material and law"))
    refuse_tilt(rod)
    ends = np.linspace(0.0, rod.length, pieces + 1)
    middles = (ends[1:] + ends[:-1]) / 2.0
    points, start = rod.frames(ends)
    _, axes = rod.frames(middles)
    d1 = start[0][:, 0]
    straight = isinstance(rod.centreline, Straight)
    curve = (
        Straight(tuple(points[0].tolist()), tuple(points[-1].tolist()))
        if straight
        else ThroughPoints(tuple(map(tuple, points.tolist())))
    )
    stretch = curve.length / rod.length
    _, natural = curve.frames(middles * stretch, tuple(d1.tolist()))
    lines = [f'title = "{title}"', ""]
    listed = []
    for k, s in enumerate(middles):
        turn = section_turn(axes[k][:, [2, 0, 1]], natural[k], k)
        lines.append(f"[sections.piece_{k + 1:03d}]")
        lines.append('shape = "stiffness"')
        for word, matrix in zip(("stiffness", "damping", "inertia"), rod.matrices_at(float(s)), strict=True):
            lines += [
                f"{word} = [",
                *(f"  {_row(row)}," for row in symmetric_part(turn @ matrix @ turn.T)),
                "]",
            ]
        lines.append("")
        until = curve.length if k == pieces - 1 else float(ends[k + 1] * stretch)
        listed.append(f'  {{ until = {until!r}, section = "piece_{k + 1:03d}" }},')
    lines += ["[rods.blade]", f'shape = "{"straight" if straight else "points"}"']
    if straight:
        lines += [f"start = {_row(points[0])}", f"end = {_row(points[-1])}"]
    else:
        lines += ["points = [", *(f"  {_row(point)}," for point in points), "]"]
    lines += [f"d1 = {_row(d1)}", "sections = [", *listed, "]", ""]
    lines += ["[[supports]]", 'kind = "clamp"', 'at = "blade.start"', ""]
    lines += ["[[loads]]", 'kind = "gravity"', "", "[equilibrium]", ""]
    return "\n".join(lines)


def _row(values: Floats) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"

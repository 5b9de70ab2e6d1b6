"""The picture of small vibrations: shape, frequency and damping ratio of every mode."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.pictures.picture import chosen_numbers, columns_of, within
from viscorod.pictures.plots.assemblies import Assembly
from viscorod.pictures.plots.projection_view import Curves, View, mark_supports
from viscorod.pictures.plots.swinging_shapes import Swing
from viscorod.pictures.style import BLUE, GREY, SKY, SMALL, panels_close, titled
from viscorod.results.text_numbers import above_rounding, quantity
from viscorod.results.text_numbers import number as text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.modes_result import Modes
    from viscorod.results.result import Result
    from viscorod.solve.modes import vibrations

_SIZE = 0.15  # of the largest displacement, as a part of the model
_WIDTH = 44  # letters of a title


def draw_modes(
    result: Result,
    modes: Modes | vibrations.Vibrations,
    count: int | None = None,
    number: int | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Return the figure of modes, each in the plane of its motion or in space, in both directions of the swing.

    Args:
        result: with the stations of the rods and the supports.
        modes: of its model; count: how many are drawn, all by default.
        number: of the one that is drawn alone, from 1; ax: axes for it, by default for the first.

    Raises:
        InputError: there is no such mode.
    """
    base = modes.positions
    drawn = chosen_numbers(len(modes.frequencies), count, number, ax, "mode")
    count = len(drawn)
    columns = columns_of(count)
    rows = max(-(-count // columns), 1)
    width, height = 1.2 + 3.6 * columns, 1.6 + 3.7 * rows
    picture = titled(result, width, height) if ax is None else within(ax)
    panels: list[tuple[Axes, View]] = []
    curves, assembly = Curves(result), Assembly(result)
    coiled = curves.coiled(base)
    still = np.asarray(result.data["rotation"].values, dtype=float)[-1]
    reach = _SIZE * float(np.max(np.ptp(base, axis=0)))
    for panel, k in enumerate(drawn, 1):
        shape = modes.shapes[k]
        # the instant of the swing at which most is displaced
        phase = 0.5 * np.angle(np.sum(shape * shape))
        real, turn = (np.real(part * np.exp(-1j * phase)) for part in (shape, modes.rotations[k]))
        swing = Swing.of(base, real, still, turn, reach)
        axes = picture.add_subplot(rows, columns, panel) if ax is None else ax
        view = View.of(swing.all_lines, swept=swing.swept, lines=curves.points(base))
        seen = f"{view.name}, edges of what twists" if swing.edge else view.name
        view.prepare(axes, _name(k, modes) + (f"\n{seen}" if ax is None else ""))
        # what is coiled stands side by side: at rest, and at both ends of the swing
        ends = base + np.array([0.0, 1.0, -1.0])[:, None, None] * swing.moved
        shifts = view.strip(ends) if coiled else np.zeros((3, 3))
        for sign, shift, style in zip((0.0, 1.0, -1.0), shifts, _styles(result), strict=True):
            for line in swing.lines(sign):
                curves.draw(axes, view, line + shift, **style)
                style["label"] = "_"  # the second edge has no name of its own
            if not assembly.empty:
                moved = base + sign * swing.moved
                assembly.draw(axes, view.shifted(shift), moved, swing.rotations(sign), style["color"])
            if coiled or not sign:
                mark_supports(axes, view, result, base + shift)
        axes.margins(0.08)
        axes.title.set_fontsize(SMALL)
        panels.append((axes, view))
    if ax is None:
        labelled = any(view.plane is not None for _, view in panels)
        panels_close(picture, rows, columns, labelled=labelled)
    for axes, view in panels:
        view.finish(axes)
    return picture


def _styles(result: Result) -> tuple[dict[str, Any], ...]:
    """Return how the shape at rest and both ends of a swing are drawn."""
    rest = "turning" if result.kind == "steady" else "at rest"
    return (
        {"color": GREY, "linestyle": (0, (4, 3)), "linewidth": 1.1, "label": rest},
        {"color": BLUE, "linewidth": 2.0, "label": "mode"},
        {"color": SKY, "linewidth": 1.2, "label": "half a period later"},
    )


def _name(k: int, modes: Modes | vibrations.Vibrations) -> str:
    eigenvalue, name = modes.eigenvalues[k], modes.names[k]
    ratio = float(above_rounding(modes.damping_ratios[k]))
    title = f"{fill(f'{k + 1}: {name}', _WIDTH)}\n"
    if k < modes.rigid:
        return f"{title}nothing resists it"
    if abs(eigenvalue.imag) <= 1e-9 * abs(eigenvalue):
        return f"{title}overdamped, decays at {text_of(-eigenvalue.real, 4)} 1/s"
    return f"{title}{quantity(modes.frequencies[k], 'Hz', 4)}, damping ratio {text_of(ratio, 3)}"

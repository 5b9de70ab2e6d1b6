"""The picture of small vibrations: shape, frequency and damping ratio of every mode."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import chosen_numbers, within
from viscorod.pictures.plots.projection_view import Curves, View, mark_supports
from viscorod.pictures.style import BLUE, GREY, SKY, SMALL, legend_of_all, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.modes_result import Modes
    from viscorod.results.result import Result
    from viscorod.solve.modes import vibrations

_SIZE = 0.15  # of the largest displacement, as a part of the model
_COLUMNS = 3
_WIDTH = 44  # letters of a title


def draw_modes(
    result: Result,
    modes: Modes | vibrations.Modes,
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
    columns = max(min(_COLUMNS, count), 1)
    rows = max(-(-count // columns), 1)
    width, height = 1.2 + 3.6 * columns, 1.6 + 3.7 * rows
    if ax is None:
        picture = titled(result, width, height)
        picture.subplots_adjust(top=1.0 - 1.5 / height, hspace=0.5, wspace=0.3)
    curves = Curves(result)
    reach = _SIZE * float(np.max(np.ptp(base, axis=0)))
    rest = "turning" if result.kind == "steady" else "at rest"
    for panel, k in enumerate(drawn, 1):
        shape = modes.shapes[k]
        # the instant of the swing at which most is displaced
        phase = 0.5 * np.angle(np.sum(shape * shape))
        real = np.real(shape * np.exp(-1j * phase))
        largest = float(np.max(np.linalg.norm(real, axis=-1)))
        swing = reach / largest * real if largest > 0.0 else real
        axes = picture.add_subplot(rows, columns, panel) if ax is None else ax
        view = View.of(np.stack([base, base + swing, base - swing]))
        view.prepare(axes, _name(k, modes) + (f"\n{view.name}" if ax is None else ""))
        curves.draw(axes, view, base + swing, color=BLUE, linewidth=2.0, label="mode")
        curves.draw(axes, view, base - swing, color=SKY, linewidth=1.2, label="half a period later")
        curves.draw(axes, view, base, color=GREY, linestyle=(0, (4, 3)), linewidth=1.1, label=rest)
        axes.margins(0.08)
        mark_supports(axes, view, result, base)
        axes.title.set_fontsize(SMALL)
        view.finish(axes)
    if ax is not None:
        return within(ax)
    legend_of_all(picture, height)
    return picture


def _name(k: int, modes: Modes | vibrations.Modes) -> str:
    eigenvalue, ratio, name = modes.eigenvalues[k], modes.damping_ratios[k], modes.names[k]
    title = f"{fill(f'{k + 1}: {name}', _WIDTH)}\n"
    if k < modes.rigid:
        return f"{title}nothing resists it"
    if abs(eigenvalue.imag) <= 1e-9 * abs(eigenvalue):
        return f"{title}overdamped, decays at {-eigenvalue.real:.4g} 1/s"
    return f"{title}{modes.frequencies[k]:.4g} Hz, damping ratio {ratio:.3g}"

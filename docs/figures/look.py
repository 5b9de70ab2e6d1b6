"""The look of the pictures of the package for figures that are laid out by themselves."""

from __future__ import annotations

from matplotlib.figure import Figure

from viscorod.pictures.style import INK, SMALL, TEXT


def dressed(picture: Figure) -> Figure:
    """Return a figure with headings flush left, a light grid and no boxes, as all other pictures have."""
    for axes in picture.axes:
        title = axes.get_title() or axes.get_title(loc="left")
        axes.set_title("")
        axes.set_title(title, loc="left", fontsize=TEXT, color=INK)
        axes.tick_params(labelsize=SMALL, colors=INK)
        for label in (axes.xaxis.label, axes.yaxis.label):
            label.set_fontsize(TEXT)
        if axes.axison:
            axes.grid(color="#dddddd", linewidth=0.6)
            axes.set_axisbelow(True)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        if (legend := axes.get_legend()) is not None:
            legend.set_frame_on(True)
            legend.get_frame().set(edgecolor="none", alpha=0.85)
    return picture

"""The picture of a master curve: moduli over reduced frequency, shifts over temperature with their laws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.pictures.picture import within
from viscorod.pictures.style import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    TEXT,
    clean,
    figure,
    heading,
    headline,
    legend_inside,
    time_colours,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.master_curve_result import MasterCurve

__all__ = ["draw_master_curve"]

ZERO = -273.15
GAS_CONSTANT = 8.314462618


def draw_master_curve(master: MasterCurve, ax: Axes | None = None) -> Figure:
    """Draw a master curve; into ``ax`` go the moduli alone."""
    data = {name: np.asarray(master.data[name].values) for name in master.variables()}
    celsius = master.temperatures
    if ax is not None:
        _moduli(ax, data, celsius)
        return within(ax)
    picture = figure(11.0, 8.0)
    title = master.title or "Master curve"
    headline(picture, f"{title}, at {master.reference:.4g} °C")
    upper, lower = picture.subplots(2, 1, height_ratios=(1.35, 1.0))
    _moduli(upper, data, celsius)
    _shifts(lower, master, data)
    return picture


def _moduli(axes: object, data: dict[str, np.ndarray], celsius: np.ndarray) -> None:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    assert isinstance(axes, Axes)
    clean(axes, "reduced frequency [Hz]", "modulus [Pa]")
    norm, colours = Normalize(float(celsius[0]), float(celsius[-1])), time_colours()
    degrees = celsius[data["point_sweep"]]
    for name, marker in (("storage", "o"), ("loss", "s")):
        axes.scatter(
            data["frequency"],
            data[name],
            c=degrees,
            cmap=colours,
            norm=norm,
            s=9.0,
            marker=marker,
            linewidths=0.0,
        )
        axes.plot(data["curve_frequency"], data[f"curve_{name}"], color=INK, linewidth=0.9)
        at = int(0.5 * len(data["curve_frequency"]))
        axes.annotate(
            f"{name} modulus",
            (data["curve_frequency"][at], data[f"curve_{name}"][at]),
            (0.0, 9.0 if name == "storage" else -30.0),
            textcoords="offset points",
            fontsize=TEXT,
            ha="right" if name == "storage" else "left",
        )
    axes.set(xscale="log", yscale="log")
    bar = axes.figure.colorbar(ScalarMappable(norm, colours), ax=axes, aspect=28, pad=0.02)
    bar.set_label("temperature [°C]", fontsize=TEXT)


def _shifts(axes: object, master: MasterCurve, data: dict[str, np.ndarray]) -> None:
    from matplotlib.axes import Axes

    assert isinstance(axes, Axes)
    celsius = master.temperatures
    clean(axes, "temperature [°C]", "log10 a_T")
    axes.errorbar(
        celsius, data["log_shift"], data["log_shift_width"], fmt="o", color=BLUE, markersize=4.0, capsize=3.0,
        label="sweeps, 95 %",
    )  # fmt: skip
    inside = celsius[data["in_laws"].astype(bool)]
    if len(inside):
        fine = np.linspace(inside.min(), inside.max(), 200)
        above = fine - master.reference
        for name, law in master.laws.items():
            values = law["values"]
            if name == "wlf":
                decades = -values[0] * above / (values[1] + above)
            else:
                inverse = 1.0 / (fine - ZERO) - 1.0 / (master.reference - ZERO)
                decades = values[0] / GAS_CONSTANT * inverse / np.log(10.0)
            label = f"{'WLF' if name == 'wlf' else 'Arrhenius'}, off by {law['off']:.2g} decades"
            axes.plot(fine, decades, color=ORANGE if name == "wlf" else GREEN, linewidth=1.5, label=label)
    heading(axes, "shift factors")
    legend_inside(axes)

"""The report of periodic motions, as plain text."""

from __future__ import annotations

import numpy as np

from viscorod.results.periodic import LOSSLESS, Periodic
from viscorod.results.text_numbers import number, quantity
from viscorod.results.text_table import listed, numbers, page, tabulated, words

__all__ = ["periodic_report"]


def periodic_report(curve: Periodic) -> str:
    """Return the report of a curve of periodic motions."""
    blocks = [_heading(curve), _amplitudes(curve)]
    if curve.data.attrs.get("over") == "amplitude":
        blocks.append(_free_vibrations(curve))
    if (np.asarray(curve.data["unstable"].values) >= 0).all():
        stable = int(curve.stable.sum())
        blocks.append(f"Stability: {stable} of {len(curve.frequencies)} motions are stable")
    if curve.bifurcations:
        blocks.append(_bifurcations(curve))
    blocks.append(_energy(curve))
    blocks.append(f"Highest two harmonics: {float(curve.data['tail'].max()):.2g} of the motion at most")
    if curve.warnings:
        blocks.append(listed("Warnings", curve.warnings))
    return page(blocks)


def _heading(curve: Periodic) -> str:
    """Say how many motions they are, and where."""
    hertz, over = curve.frequencies, str(curve.data.attrs.get("over", "frequency"))
    where = (
        f"from {curve.amplitude(0)[0]:.6g} to {curve.amplitude(0)[-1]:.6g} of {curve.outputs[0]}, free vibrations"
        if over == "amplitude"
        else f"from {quantity(hertz[0], 'Hz')} to {quantity(hertz[-1], 'Hz')}"
        if over == "frequency"
        else f"at {quantity(hertz[0], 'Hz')}, {curve.levels[0]:.6g} to {curve.levels[-1]:.6g} times the amplitudes"
    )
    return (
        f"{curve.title + chr(10) if curve.title else ''}Periodic motions, {len(hertz)} on a curve {where}, "
        f"{int(curve.data.attrs['harmonics'])} harmonics"
    )


def _units(curve: Periodic) -> list[str]:
    return [str(unit) for unit in curve.data["output_unit"].values]


def _amplitudes(curve: Periodic) -> str:
    """Return a table of the largest and smallest amplitude of every output."""
    sizes = [curve.amplitude(k) for k in range(len(curve.outputs))]
    tops = [curve.summit(k) for k in range(len(curve.outputs))]
    pairs = list(zip(sizes, _units(curve), strict=True))
    return tabulated(
        "Amplitudes (half of the way between extremes)",
        words("output", curve.outputs),
        words("largest", [quantity(top.amplitude, unit) for top, (_, unit) in zip(tops, pairs, strict=True)]),
        numbers(("at",), "Hz", [top.frequency for top in tops]),
        words("level", [number(curve.levels[top.point], 4) for top in tops]),
        words("smallest", [quantity(size.min(), unit, 4) for size, unit in pairs]),
    )


def _bifurcations(curve: Periodic) -> str:
    """Return a table of them."""
    places = [k for k, _ in curve.bifurcations]
    return tabulated(
        "Bifurcations",
        words("kind", [word for _, word in curve.bifurcations]),
        numbers(("at",), "Hz", curve.frequencies[places]),
        words("level", [number(curve.levels[k], 5) for k in places]),
        numbers((curve.outputs[0],), _units(curve)[0], curve.amplitude(0)[places]),
    )


def _energy(curve: Periodic) -> str:
    """Say how well the work of a cycle is its loss."""
    if not curve.inputs and float(np.abs(curve.damping_ratios).max()) < LOSSLESS:
        return "Energy of a cycle: without damping a free vibration has neither work nor loss"
    apart = np.abs(curve.work - curve.loss)
    return (
        f"Energy of a cycle: work up to {quantity(curve.work.max(), 'J', 5)}; work and loss differ by at most "
        f"{apart.max() / max(np.abs(curve.work).max(), 1e-300):.2g} of that"
    )


def _free_vibrations(curve: Periodic) -> str:
    """Return a table of frequency and damping ratio over the amplitude, of some motions."""
    size, hertz, ratios = curve.amplitude(0), curve.frequencies, curve.damping_ratios
    chosen = np.unique(np.linspace(0, len(size) - 1, 8).astype(int))
    shown = curve.decrement_ratios(0) if len(size) > 2 and curve.loss.all() else np.full(len(size), np.nan)
    decrements = [number(shown[k]) if np.isfinite(shown[k]) else "-" for k in chosen]
    return tabulated(
        "Free vibrations",
        numbers((curve.outputs[0],), str(curve.data["output_unit"].values[0]), size[chosen], digits=5),
        numbers(("frequency",), "Hz", hertz[chosen], digits=7),
        words("damping ratio", [number(ratios[k]) for k in chosen]),
        words("by its decrement", decrements),
    )

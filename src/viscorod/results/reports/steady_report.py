"""The report of a steady rotation as plain text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.reports.effort import effort
from viscorod.results.reports.report_parts import (
    ends,
    heading,
    places,
    reactions,
    stress,
    validity,
    vector,
    warnings,
)
from viscorod.results.text_numbers import above_rounding, quantity
from viscorod.results.text_table import numbers, page, tabulated, words

if TYPE_CHECKING:
    from viscorod.results.steady_result import Steady

__all__ = ["steady_report"]


def steady_report(steady: Steady) -> str:
    """Return the report of a steady rotation."""
    judged = steady.validity()
    rate = float(np.linalg.norm(steady.spin))
    damping = "" if steady.damping == "full" else f", {steady.damping} damping"
    return page(
        [
            heading(
                steady, f"steady rotation at {rate:.6g} rad/s ({steady.formulation} formulation{damping})"
            ),
            _turning(steady, rate),
            ends(steady, places(steady), -1),
            reactions(steady),
            _small_motions(steady),
            stress(steady),
            validity(steady, judged),
            effort(steady),
            warnings(steady, judged),
        ]
    )


def _turning(steady: Steady, rate: float) -> str:
    axis, centre = (vector(values, 1.0) for values in (steady.spin / rate, steady.centre))
    momentum = float(np.linalg.norm(steady.angular_momentum))
    return "\n".join(
        [
            f"Axis ({', '.join(axis)}) through ({', '.join(centre)}) m",
            f"Kinetic energy {quantity(steady.kinetic_energy, 'J')}, elastic energy "
            f"{quantity(steady.elastic_energy, 'J')}, angular momentum {quantity(momentum, 'N m s')}",
            f"Balanced to {steady.residual:.2g} of the largest force",
        ]
    )


def _small_motions(steady: Steady) -> str:
    count = len(steady.eigenvalues)
    text = tabulated(
        "Slowest small motions about it, exp(s t)",
        words("motion", map(str, range(1, count + 1))),
        numbers(
            ("Re s", "Im s"), "1/s", np.stack([steady.eigenvalues.real, steady.eigenvalues.imag], axis=-1)
        ),
        numbers(("frequency",), "Hz", steady.frequencies),
        numbers(("damping ratio",), "", above_rounding(steady.damping_ratios)),
    )
    verdict = (
        "Stable: no small motion grows"
        if steady.stable
        else f"Unstable: a small motion grows by e in {quantity(1.0 / steady.growth_rate, 's', 4)}"
    )
    neutral = steady.neutral
    if neutral:
        verdict += (
            f"; {neutral} neither grow{'s' if neutral == 1 else ''} nor fade{'s' if neutral == 1 else ''}"
        )
    return f"{text}\n{verdict}"

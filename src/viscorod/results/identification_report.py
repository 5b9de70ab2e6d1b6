"""The report of an identification in words and numbers."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.text_numbers import per_cent, quantity, scaled
from viscorod.results.text_table import listed, page, table

if TYPE_CHECKING:
    from viscorod.results.identification import Identification
    from viscorod.results.identified import Number

__all__ = [
    "FORETOLD",
    "foretold_table",
    "identification_report",
    "laws_table",
    "limits_text",
    "programs_table",
    "residuals_table",
    "what_intervals_are_worth",
    "with_prefix",
]

FORETOLD = "Records left out, foretold and measured (+- 95 %)"


def identification_report(fit: Identification) -> str:
    """Return the report: numbers, what the data tell together, residuals, laws, programs, sentences."""
    data = fit.data
    heading = f"{fit.title + chr(10) if fit.title else ''}Identification from {data.sizes['value']} values"
    heading += (
        f" in {data.sizes['series']} series; {fit.data.attrs['evaluations']} evaluations and derivatives"
    )
    starts = int(fit.data.attrs["starts"])
    if starts > 1:
        heading += f"\n{fit.data.attrs['agreeing_starts']} of {starts} starts ended in this minimum"
    worth = what_intervals_are_worth(fit)
    blocks = [
        heading,
        _numbers(
            f"Numbers of the model, intervals of {per_cent(100.0 * fit.level, 4)}{worth}", fit.parameters
        ),
    ]
    if fit.nuisances:
        blocks.append(_numbers(f"Numbers of the measurement{worth}", fit.nuisances))
    if fit.combinations:
        rows = [
            [name, f"{one.value:.5g}", *limits_text(one), one.unit]
            for name, number in fit.combinations.items()
            for one in [with_prefix(number)]
        ]
        blocks.append(
            table(
                f"What the data tell of several together{worth}", ["", "value", "low", "high", "unit"], rows
            )
        )
    if fit.sentences:
        blocks.append(listed("What to know", fit.sentences))
    blocks.append(table("What is left", *residuals_table(fit)))
    if fit.laws:
        blocks.append(table("Laws on the same data; criteria less the least", *laws_table(fit)))
    if fit.foretold:
        header, rows = foretold_table(fit)
        blocks.append(table(FORETOLD, header, rows))
    if fit.in_programs:
        heading = f"The damping in the numbers of other programs{worth}"
        blocks.append(table(heading, *programs_table(fit)))
    if fit.warnings:
        blocks.append(listed("Warnings", fit.warnings))
    return page(blocks)


def what_intervals_are_worth(fit: Identification) -> str:
    """Return what the head of a table of intervals has to say of them."""
    if fit.unsettled:
        return f": the search did not come to rest, another step moves them by {fit.unsettled:.2g} standard errors"
    if not fit.missed:
        return ""
    listed = " and ".join([*([", ".join(fit.missed[:-1])] if len(fit.missed) > 1 else []), fit.missed[-1]])
    return f": too narrow, the model misses part of {listed}"


def with_prefix(one: Number) -> Number:
    """Return a number in the prefix of its unit in which a person reads it."""
    if one.unit in ("", "1"):
        return one
    ends = [end for end in (one.value, one.low, one.high) if np.isfinite(end)]
    factor, unit = scaled(one.unit, [one.value] if one.value else ends)
    return replace(
        one,
        value=factor * one.value,
        low=factor * one.low,
        high=factor * one.high,
        standard_error=factor * one.standard_error,
        unit=unit,
    )


def limits_text(one: Number) -> tuple[str, str]:
    """Return the ends of an interval in words; those of what nothing fitted acts on are as the case has it."""
    if one.low == one.value == one.high:
        return "as given", "as given"
    low = "-infinite" if one.low == -np.inf else f"{one.low:.5g}"
    return low, "infinite" if one.high == np.inf else f"{one.high:.5g}"


def _numbers(title: str, numbers: dict[str, Number]) -> str:
    rows = [
        [
            name,
            f"{one.value:.6g}",
            *limits_text(one),
            one.unit,
            f"{one.standard_error:.2g}" if one.told else "-",
            one.how.partition(";")[0],
        ]
        for name, number in numbers.items()
        for one in [with_prefix(number)]
    ]
    return table(title, ["", "value", "low", "high", "unit", "standard error", "interval by"], rows)


def residuals_table(fit: Identification) -> tuple[list[str], list[list[str]]]:
    """Return the heads and the rows of a table of what the model leaves of every series."""
    data = fit.data
    rows = []
    for k, name in enumerate(data["series"].values):
        mine = data["series_of"].values == k
        told, unit = float(data["noise_told"].values[k]), str(data["quantity_unit"].values[k])
        unit = "" if unit == "1" else unit
        rows.append(
            [
                str(name),
                str(int(mine.sum())),
                f"{float(data['effective_count'].values[k]):.0f}",
                quantity(float(data["noise"].values[k]), unit, 3),
                quantity(told, unit, 3) if told else "-",
                str(int(data["noise_order"].values[k])),
                f"{float(data['whiteness'].values[k]):.2g}",
            ]
        )
    return ["", "values", "effective", "noise", "told", "order", "p(white)"], rows


def programs_table(fit: Identification) -> tuple[list[str], list[list[str]]]:
    """Return the heads and the rows of a table of inputs of other programs; equal ones of a program share a row."""
    shared: dict[tuple[str, ...], list[str]] = {}
    for name, one in fit.in_programs.items():
        program, colon, word = name.rpartition(": ")
        row = (program + colon, f"{one.value:.5g}", *limits_text(one), one.unit)
        shared.setdefault(row, []).append(word)
    rows = [[program + " = ".join(words), *rest] for (program, *rest), words in shared.items()]
    return ["", "value", "low", "high", "unit"], rows


def laws_table(fit: Identification) -> tuple[list[str], list[list[str]]]:
    """Return the heads and the rows of a table of laws."""
    held = any(law.prediction > 0.0 for law in fit.laws)
    rows = [
        [
            law.name,
            str(law.unknowns),
            f"{law.square:.5g}",
            f"{law.aicc:.1f}",
            f"{law.bic:.1f}",
            *([f"{law.prediction:.3g}"] if held else []),
            law.values,
        ]
        for law in fit.laws
    ]
    return ["law", "numbers", "squares", "AICc", "BIC", *(["left out"] if held else []), "fitted"], rows


def foretold_table(fit: Identification) -> tuple[list[str], list[list[str]]]:
    """Return the heads and the rows of a table of what laws foretell of records that were left out."""
    rows = [
        [
            one.record,
            one.law,
            f"{one.frequency:.5g} +- {one.frequency_width:.2g}",
            f"{one.measured_frequency:.5g} +- {one.measured_frequency_width:.2g}",
            f"{100.0 * (one.frequency / one.measured_frequency - 1.0):+.2g}",
            f"{one.damping_ratio:.4g} +- {one.damping_ratio_width:.2g}",
            f"{one.measured_ratio:.4g} +- {one.measured_ratio_width:.2g}",
        ]
        for one in fit.foretold
    ]
    return [
        "record",
        "law",
        "frequency [Hz]",
        "measured",
        "off by [%]",
        "damping ratio",
        "measured",
    ], rows

"""What a model is before it is solved, in tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from viscorod.results.row_table import cell, row_table
from viscorod.results.text_table import WIDTH, listed
from viscorod.results.validity import Validity
from viscorod.shown import Shown, counted
from viscorod.typing import Floats

__all__ = ["AXES_OF_RODS", "CheckReport"]

AXES_OF_RODS = ("d1 at its start", "d2 at its start")
"""Columns of the rods that tell how their sections lie."""
_MOST_ROWS = 12
"""Rods that differ, up to which these columns are shown."""


@dataclass(frozen=True, repr=False)
class CheckReport(Shown):
    """The model in tables.

    Attributes:
        rods: name, length [m], mass [kg], elements, order, and d1 and d2 at the start of every rod.
        sections: stiffness [N, N m^2] and retardation time [s] of every strain, at the start of every rod and
            where it changes; "held" in place of the stiffness of strains that the rod holds; couplings of strains
            in stiffness and damping, and the mass centre [m], where they are not zero.
        bodies: name, mass [kg], principal inertia [kg m^2] of every rigid body.
        joints: name, kind, places, motions that are free or driven, where it is and its gap [m] in the reference shape.
        springs: name, kind, places, motions with stiffness and damping.
        media: loads that see motion, with the numbers of their laws.
        rest_strains: at the starts of their rods, with the factor 1, and how they change with time.
        frequencies: of the first small vibrations about the unloaded shape [Hz], rigid motions left out;
            damping_ratios, mode_names: of the same.
        rigid_motions: motions that nothing resists, in words.
        warnings: doubts, one sentence each.
        nodes, unknowns: size of the discretised model; conditions: number of those that joints and held strains make.
        linear_solver: how its linear systems are factorised.
        materials: moduli [Pa], retardation times [s] and number of Maxwell branches of the rods with a material.
        assumptions: what was assumed of their damping, one sentence each.
        validity: the conditions of a rod model, as far as they are known before a solution.
    """

    rods: list[dict[str, object]]
    sections: list[dict[str, object]]
    frequencies: Floats
    damping_ratios: Floats
    warnings: list[str]
    nodes: int
    unknowns: int
    linear_solver: str
    mode_names: tuple[str, ...] = ()
    rigid_motions: tuple[str, ...] = ()
    bodies: list[dict[str, object]] = field(default_factory=list)
    joints: list[dict[str, object]] = field(default_factory=list)
    springs: list[dict[str, object]] = field(default_factory=list)
    media: list[dict[str, object]] = field(default_factory=list)
    rest_strains: list[dict[str, object]] = field(default_factory=list)
    conditions: int = 0
    materials: list[dict[str, object]] = field(default_factory=list)
    assumptions: list[str] = field(default_factory=list)
    validity: Validity = field(default_factory=lambda: Validity(()))

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.rods), "rod")
        yield counted(self.unknowns, "unknown")
        if len(self.frequencies):
            yield f"slowest mode {self.frequencies[0]:.4g} Hz ({self.mode_names[0]})"
        if self.rigid_motions:
            yield counted(len(self.rigid_motions), "rigid motion")
        yield counted(len(self.warnings), "warning") if self.warnings else "no warnings"

    def __str__(self) -> str:
        return self.text()

    def text(self, width: int = WIDTH) -> str:
        """Return all tables, in lines of ``width`` letters where they can be."""
        modes = [
            {
                "mode": str(number),
                "name": name,
                "frequency [Hz]": frequency,
                "damping ratio": "overdamped" if ratio > 1.0 - 1e-9 else round(ratio, 10) + 0.0,
            }
            for number, (name, frequency, ratio) in enumerate(
                zip(self.mode_names, self.frequencies, self.damping_ratios, strict=True), 1
            )
        ]
        conditions = f", {self.conditions} conditions of joints and held strains" if self.conditions else ""
        tables: list[tuple[str, Sequence[Mapping[str, object]]]] = [
            ("Rods", _rods(self.rods)),
            ("Sections", _alike(self.sections)),
            ("Materials", _alike(self.materials)),
            ("Rigid bodies", self.bodies),
            ("Joints", self.joints),
            ("Springs", self.springs),
            ("Drag and other loads that see motion", self.media),
            ("Rest strains, at the start of the rod", self.rest_strains),
            ("First natural modes about the reference shape (a quick estimate)", modes),
        ]
        blocks = [
            *(row_table(title, rows, width=width) for title, rows in tables),
            listed(f"Rigid motions: {len(self.rigid_motions)}", self.rigid_motions)
            if self.rigid_motions
            else "",
            f"{self.nodes} nodes, {self.unknowns} unknowns{conditions}\nLinear systems: {self.linear_solver}",
            str(self.validity) if self.validity.conditions else "",
            listed("Assumptions about damping", self.assumptions) if self.assumptions else "",
            listed("Warnings", self.warnings) if self.warnings else "No warnings",
        ]
        return "\n\n".join(block for block in blocks if block)


def _rods(rows: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """Return the rods, alike ones as one, without their axes where these make many rows of a large frame."""
    found = _alike(rows)
    if len(found) <= _MOST_ROWS:
        return found
    return _alike([{key: cell for key, cell in row.items() if key not in AXES_OF_RODS} for row in rows])


def _to_compare(value: object) -> str:
    """Return numbers with all their digits, and directions as they are shown."""
    return cell(value) if isinstance(value, tuple) else str(value)


def _alike(rows: Sequence[Mapping[str, object]]) -> list[dict[str, object]]:
    """Return rows of which those that differ in their first cell only are one."""
    names: dict[tuple[tuple[str, object], ...], list[str]] = {}
    for row in rows:
        (_, name), *rest = row.items()
        names.setdefault(tuple((key, _to_compare(value)) for key, value in rest), []).append(str(name))
    kept: dict[str, Mapping[str, object]] = {}
    for row in rows:
        kept.setdefault(str(next(iter(row.values()))), row)
    found = []
    for alike in names.values():
        row = dict(kept[alike[0]])
        key = next(iter(row))
        others = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
        found.append({**row, key: f"{alike[0]}{others}"})
    return found

"""Whether a rod model is right for a result: the conditions of Linn, Lang and Tuganov (2013), each with its number.

They derive stiffness and damping of a rod for slender, weakly curved rods (2.2: J0 is about 1, and twist times half
width is small), small strains (2.2) and motions that are slow beside the material (2.6).
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np

from viscorod.errors import InputError
from viscorod.results.array_pieces import extremes
from viscorod.results.damping_validity import QUICK, damping_validity
from viscorod.results.reference_shape import reference_curvatures
from viscorod.results.text_numbers import number, quantity
from viscorod.results.text_table import table
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result
    from viscorod.results.run import Run

__all__ = ["SLENDER", "SMALL_STRAIN", "Condition", "Validity", "validity_of"]

SLENDER = 0.1
"""Half width times reference curvature or twist, and over the length, above which a rod is not slender (LLT 2.2)."""
SMALL_STRAIN = 0.1
"""Strain beyond which a linear material law for small strains is doubtful (LLT 2.2)."""

STRAINS = ("shear 1", "shear 2", "stretch", "bend 1", "bend 2", "twist")


@dataclass(frozen=True)
class Condition:
    """One condition.

    Attributes:
        name: what is small; source: where it comes from.
        value: the largest; NaN where it is not known.
        limit: up to which the theory is meant.
        where: of the largest value, or why it is not known.
    """

    name: str
    source: str
    value: float
    limit: float
    where: str

    @property
    def kept(self) -> bool | None:
        """Whether it holds; None where the value is not known."""
        return None if math.isnan(self.value) else self.value <= self.limit

    @property
    def row(self) -> tuple[str, str, str, str, str, str]:
        """What a table shows."""
        value = "" if math.isnan(self.value) else number(self.value, 3, size=self.limit)
        verdict = {True: "yes", False: "NO", None: ""}[self.kept]
        return self.name, value, f"{self.limit:g}", verdict, self.source, self.where


@dataclass(frozen=True)
class Validity:
    """The conditions under which a rod model is right; ``print`` shows them as a table.

    Attributes:
        conditions: as far as they are known.
        sentence: on Kelvin-Voigt damping of a material whose relaxation is known, else empty.
    """

    conditions: tuple[Condition, ...]
    sentence: str = ""

    @property
    def valid(self) -> bool:
        """True if no condition is known to be broken."""
        return all(condition.kept is not False for condition in self.conditions)

    def __str__(self) -> str:
        header = ("should be small", "largest", "limit", "kept", "from", "where")
        text = table("Validity of the rod model", header, [condition.row for condition in self.conditions])
        return f"{text}\n{self.sentence}".rstrip()


def validity_of(result: Result) -> Validity:
    """Return the conditions and their numbers; see ``Result.validity``."""
    found: list[Condition] = []
    if "strain" in result.stored and result.stored.sizes.get("point", 0):
        found = [*_shape(result), *_strains(result)]
    rate, sentence = (None, "") if result.kind == "equilibrium" else _rate(result)
    return Validity((*found, *([] if rate is None else [rate])), sentence)


def unknown_width(name: str, source: str, limit: float) -> Condition:
    """Return a condition whose number nobody knows: sections are given by numbers."""
    return Condition(name, source, math.nan, limit, "sections without a known shape")


def _shape(result: Result) -> list[Condition]:
    """Return slenderness, curvature and twist of the reference shape."""
    data = result.stored
    half = _half_widths(result)
    curved = reference_curvatures(result)
    rods = np.asarray(data["point_rod"].values, dtype=str)
    lengths = {rod: result.sites.ends(rod)[1].s for rod in result.sites.rods}
    rows = (
        ("|J0 - 1|: half width x curvature", np.linalg.norm(curved[:, :2], axis=1)),
        ("half width x reference twist", np.abs(curved[:, 2])),
        ("half width / length", np.array([1.0 / lengths[rod] for rod in rods.tolist()])),
    )
    if not half.any():
        return [unknown_width(name, "LLT 2.2", SLENDER) for name, _ in rows]
    found = [Condition(name, "LLT 2.2", *_worst(result, half * size, SLENDER)) for name, size in rows]
    return [*found[:2], replace(found[2], where=found[2].where.partition("@")[0])]


def _strains(result: Result) -> list[Condition]:
    low, high = extremes(result, "strain")
    strain, half = np.maximum(np.abs(low), np.abs(high)), _half_widths(result)
    found = [Condition("shear and stretch", "LLT 2.2", *_worst(result, strain[:, :3], SMALL_STRAIN))]
    name = "half width x bending, twist"
    if not half.any():
        return [*found, unknown_width(name, "LLT 2.2", SMALL_STRAIN)]
    turning = Condition(name, "LLT 2.2", *_worst(result, strain[:, 3:] * half[:, None], SMALL_STRAIN, 3))
    return [*found, turning]


def _half_widths(result: Result) -> Floats:
    """Return the half width of the section at every Gauss point [m], 0 if unknown."""
    data = result.stored
    if "half_width" not in data:
        return np.zeros(data.sizes["point"])
    return np.asarray(data["half_width"].values, dtype=float)


def _worst(result: Result, values: Floats, limit: float, first: int = 0) -> tuple[float, float, str]:
    """Return the largest of ``(point,)`` or ``(point, component)``, the limit, and where it is."""
    data = result.stored
    flat = values.reshape(len(values), -1)
    point, component = (int(k) for k in np.unravel_index(int(np.argmax(flat)), flat.shape))
    value = float(flat[point, component])
    where = f"{data['point_rod'].values[point]}@{float(data['point_s'].values[point]):.4g}"
    what = f"{STRAINS[first + component]}, " if values.ndim > 1 else ""
    return value, limit, what + where if value else ""


def _rate(result: Result) -> tuple[Condition | None, str]:
    """Return how quick a motion is beside the material's relaxation, and a sentence on a known relaxation."""
    name, source = "angular frequency x time", "LLT 2.6"
    laws = json.loads(str(result.stored.attrs.get("damping_laws") or "{}"))
    if not laws:
        return None, ""
    times = {rod: max((t for t in law["times"] if t), default=0.0) for rod, law in laws.items()}
    if not any(times.values()):
        relaxing = any(law["maxwell"] for law in laws.values())
        why = "Maxwell branches hold at every frequency" if relaxing else "no Kelvin-Voigt damping"
        return Condition(name, source, math.nan, QUICK, why), ""
    if result.kind == "steady":
        return _slow_motions(result, name, source, times), ""
    return _of_run(result, name, source)


def _slow_motions(steady: Result, name: str, source: str, times: dict[str, float]) -> Condition:
    imaginary = np.abs(np.asarray(steady.stored["eigenvalue"].values, dtype=float)[:, 1])
    turning = imaginary[imaginary > 0.0]
    if not turning.size:
        return Condition(name, source, math.nan, QUICK, "no small motion oscillates")
    rod = max(times, key=lambda one: times[one])
    omega = float(turning.min())
    return Condition(name, source, omega * times[rod], QUICK, f"{rod}, slowest small motion")


def _of_run(run: Result, name: str, source: str) -> tuple[Condition, str]:
    try:
        found = damping_validity(cast("Run", run))
    except InputError:
        return Condition(name, source, math.nan, QUICK, "the run is too short for a spectrum"), ""
    if not found.strains:
        return Condition(name, source, math.nan, QUICK, "no damped rod was strained"), ""
    bounded = [strain for strain in found.strains if math.isfinite(strain.bound)]
    if bounded:
        worst = max(bounded, key=lambda strain: strain.bound)
        where = f"{worst.rod}, {worst.strain}"
        name = "error of the viscous stress"
        return Condition(name, source, worst.bound, found.tolerance, where), found.sentence
    worst = max(found.strains, key=lambda strain: strain.product)
    where = f"{worst.rod}, {worst.strain}, 95 % below {quantity(worst.high_frequency, 'Hz', 3)}"
    return Condition(name, source, worst.product, QUICK, where), ""

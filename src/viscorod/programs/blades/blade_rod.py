"""A BeamDyn blade as a viscorod rod, and a rod as a BeamDyn blade."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from viscorod.argument_names import telling
from viscorod.checks import checked_with, numbers, of_class
from viscorod.errors import Fault, InputError
from viscorod.model.rod import Rod
from viscorod.model.sections.stiffness_section import StiffnessSection
from viscorod.programs.blades.beamdyn_blade import (
    BeamDynBlade,
    read_beamdyn_blade,
    station_name,
    write_beamdyn_blade_file,
)
from viscorod.programs.blades.beamdyn_line import BladeTwist, LineLike, beamdyn_axis, reference_line
from viscorod.programs.energy_creation import check_product
from viscorod.programs.matrices import by_sizes
from viscorod.programs.own_laws import refuse_own_laws
from viscorod.programs.times import component_times, symmetric_damping
from viscorod.typing import Floats

__all__ = ["BladeSections", "blade_from_rod", "product_damping", "rod_from_blade", "write_beamdyn_blade"]

Law = Literal["symmetric", "same power"]
MOST_KNOWN = 10_000
"""Sections along a blade that are kept."""
_CONSTANT = 1e-9  # relative change of a time along the rod that counts as none


@telling
def product_damping(stiffness: Floats, times: Floats) -> Floats:
    """Return (mu S + S mu)/2 (6, 6): the symmetric matrix that takes the same power as the products mu S and S mu.

    Raises:
        InputError: it creates energy in some motion; the message states from which coupling on.
    """
    check = check_product(stiffness, times)
    if check.creates_energy:
        raise InputError(
            Fault(
                "mu",
                "",
                check.text(),
                'take the law "symmetric", D = T C T with the same six times, or equal times',
            )
        )
    return np.asarray((times[:, None] + times[None, :]) / 2.0 * stiffness)


class BladeSections:
    """The section of a blade as a function of the arc length, linear between stations as in BeamDyn.

    Args:
        blade: with its stations.
        length: of the reference line, m.
        law: "symmetric" for D = T C T with the six times mu, "same power" for the symmetric part of mu S.
    """

    def __init__(self, blade: BeamDynBlade, length: float, law: Law = "symmetric") -> None:
        self.blade, self.length, self.law = blade, length, law
        self._known: dict[float, StiffnessSection] = {}

    @property
    def stations(self) -> Floats:
        """Arc lengths of the stations (n,), m, at which the sections have kinks."""
        return np.asarray(self.blade.stations * self.length)

    def damping(self, stiffness: Floats) -> Floats:
        """Return D (6, 6) for a stiffness (6, 6)."""
        if self.blade.damp_type == 0:
            return np.zeros((6, 6))
        if self.law == "symmetric":
            return symmetric_damping(stiffness, self.blade.mu)
        return product_damping(stiffness, self.blade.mu)

    def difference(self) -> float:
        """Return the largest difference of D from BeamDyn's mu S over all stations, in parts of sqrt(D_ii D_jj)."""
        largest = 0.0
        if self.blade.damp_type == 0:
            return largest
        damped = np.where(self.blade.mu > 0.0, self.blade.mu, np.inf)
        for stiffness in self.blade.stiffness:
            product = self.blade.mu[:, None] * stiffness
            scaled = by_sizes(self.damping(stiffness) - product, damped * np.diag(stiffness))
            largest = max(largest, float(np.abs(scaled).max()))
        return largest

    def __call__(self, s: float) -> StiffnessSection:
        """Return the section at the arc length `s`, m."""
        known = self._known.get(s)
        if known is None:  # every analysis asks for those at its Gauss points again
            stiffness, inertia = self.blade.at(s / self.length)
            known = StiffnessSection(stiffness, inertia, self.damping(stiffness))
            if len(self._known) < MOST_KNOWN:
                self._known[s] = known
        return known


@telling
def rod_from_blade(
    blade: BeamDynBlade | str | Path,
    centreline: LineLike,
    *,
    law: Law = "symmetric",
    elements: int | None = None,
    order: int | None = None,
) -> Rod:
    """Return a BeamDyn blade as a rod, in the blade's root axes (X, Y, Z).

    Sections are interpolated linearly between the stations, their axes are BeamDyn's with its initial twist.
    BeamDyn's damping mu S is not symmetric where coupled strains have different mu; D is T C T with the same six
    times, or with law="same power" the symmetric part of mu S, which takes the same power from every strain rate.
    BeamDyn's extension-twist term of large twist (the trapeze effect, `cet` in its source) is not in the rod.

    Args:
        blade: a blade or the path of its file.
        centreline: key points (n, 3) in m, with twist (n, 4) in degrees, or the path of a primary file.
        law: "symmetric" or "same power".
        elements: see `Rod`.
        order: see `Rod`.

    Raises:
        InputError: a file cannot be read, the blade has modal damping, a section cannot be used, or with
            law="same power" one creates energy.
    """
    if not isinstance(blade, BeamDynBlade):
        blade = read_beamdyn_blade(blade)
    if law not in ("symmetric", "same power"):
        raise InputError(Fault("law", repr(law), "there is no such law", 'give "symmetric" or "same power"'))
    if blade.damp_type == 2:
        raise InputError(
            Fault(
                "damp_type",
                "2",
                "modal damping belongs to modes, not to sections",
                "give damp_type 1 with mu_i = 2 zeta/omega of a mode of each kind, or 0",
            )
        )
    line = reference_line(centreline)
    curve = line.centreline()
    sections = BladeSections(blade, curve.length, law)
    for k, (stiffness, inertia) in enumerate(zip(blade.stiffness, blade.inertia, strict=True)):
        try:
            StiffnessSection(stiffness, inertia, sections.damping(stiffness))
        except InputError as error:
            station = station_name(k, blade.stations[k])
            raise InputError([replace(p, where=f"{station}, {p.where}") for p in error.problems]) from None
    tangent = curve.bishop(np.zeros(1))[1][0][:, 2]
    d1 = beamdyn_axis(tangent, -float(np.deg2rad(line.initial_twist[0])))
    twist = BladeTwist(line, curve, d1) if line.initial_twist.any() or len(line.points) > 2 else 0.0
    return Rod(curve, sections, elements=elements, order=order, d1=tuple(d1.tolist()), twist=twist)


@checked_with(rod=of_class(Rod), stations=numbers)
def blade_from_rod(
    rod: Rod, stations: Sequence[float] | Floats | None = None
) -> tuple[BeamDynBlade, tuple[str, ...]]:
    """Return a rod as a BeamDyn blade.

    Args:
        rod: any rod.
        stations: fractions of the length, from 0 to 1; by default the stations of the blade the rod was read from,
            else eleven.

    Returns:
        the blade, and what is lost, in sentences.

    Raises:
        InputError: the stations do not rise from 0 to 1, or the rod has Maxwell branches.
    """
    given = (
        rod.section.blade.stations if isinstance(rod.section, BladeSections) else np.linspace(0.0, 1.0, 11)
    )
    fractions = np.asarray(given if stations is None else stations, dtype=np.float64)
    if (
        fractions.ndim != 1
        or len(fractions) < 2
        or fractions[0] != 0.0
        or fractions[-1] != 1.0
        or (np.diff(fractions) <= 0.0).any()
    ):
        raise InputError(
            Fault("stations", f"{len(np.atleast_1d(fractions))} numbers", "they must rise from 0 to 1",
                    "give fractions of the length, such as 0, 0.5, 1")
        )  # fmt: skip
    refuse_own_laws(rod, fractions * rod.length)
    matrices = [rod.matrices_at(float(s)) for s in fractions * rod.length]
    stiffness, damping, inertia = (np.array(parts) for parts in zip(*matrices, strict=True))
    times = np.array([component_times(c, d) for c, d in zip(stiffness, damping, strict=True)])
    mu = times.mean(axis=0)
    losses: list[str] = []
    spread = float(np.abs(times - mu).max())
    if spread > _CONSTANT * max(float(mu.max()), 1e-300):
        losses.append(
            "BeamDyn has one mu for the whole blade: the times along the rod differ from their mean by "
            f"up to {spread:.3g} s"
        )
    else:
        mu = times[0]
    checks = [check_product(c, mu) for c in stiffness]
    worst = min(checks, key=lambda check: check.factor)
    if np.isfinite(worst.factor):
        losses.append(worst.text())
    return BeamDynBlade(fractions, stiffness, inertia, mu, int(bool(mu.any()))), tuple(losses)


@checked_with(rod=of_class(Rod), stations=numbers)
def write_beamdyn_blade(
    rod: Rod, path: str | Path, stations: Sequence[float] | Floats | None = None
) -> tuple[str, ...]:
    """Write a rod as a BeamDyn blade file; return what is lost, in sentences. See `blade_from_rod`."""
    blade, losses = blade_from_rod(rod, stations)
    write_beamdyn_blade_file(blade, path)
    return losses

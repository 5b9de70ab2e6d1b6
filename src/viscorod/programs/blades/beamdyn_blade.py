"""BeamDyn blade files: stiffness, mass and the six damping coefficients at stations along a blade.

Format and meaning: OpenFAST/openfast, modules/beamdyn/src/BeamDyn_IO.f90 (BD_ReadBladeFile) and
docs/source/user/beamdyn/input_files.rst. BeamDyn's local axes x, y, z are viscorod's d1, d2, d3 (z the tangent),
its components (shear x, shear y, extension, bending x, bending y, torsion) are viscorod's, and so are their signs:
both have strains ``R^T r' - e3`` and curvatures ``axial(R^T R')``, both matrices act on them directly.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.checks import checked, checked_with, of_class
from viscorod.errors import Fault, InputError
from viscorod.model.fields.symmetry import skew_entry
from viscorod.programs.blades.blade_text import Lines
from viscorod.programs.energy_creation import EnergyCheck, check_product
from viscorod.programs.matrices import symmetric_part
from viscorod.programs.times import six_times
from viscorod.typing import Floats
from viscorod.whole_files import replacing

__all__ = ["BeamDynBlade", "read_beamdyn_blade", "station_name", "write_beamdyn_blade_file"]


def station_name(index: int, eta: float) -> str:
    """Return how messages name a station: counted from one, with its fraction of the line."""
    return f"station {index + 1} (eta = {eta:g})"


@known_arguments
@dataclass(frozen=True, eq=False)
class BeamDynBlade:
    """The content of a blade file.

    Attributes:
        stations: fractions eta of the reference line (n,), from 0 to 1.
        stiffness: (n, 6, 6); N, N m, N m^2.
        inertia: per length (n, 6, 6); kg/m, kg, kg m.
        mu: six times, s (the files say "-"), (6,).
        damp_type: 0 none, 1 proportional to the stiffness, 2 modal (not a law of sections).
        title: second line of the file.
    """

    stations: Floats
    stiffness: Floats
    inertia: Floats
    mu: Floats
    damp_type: int = 1
    title: str = ""

    def at(self, fraction: float) -> tuple[Floats, Floats]:
        """Return stiffness and inertia (6, 6) at a fraction of the line, linear between stations as in BeamDyn."""
        k = int(
            np.clip(np.searchsorted(self.stations, fraction, side="right") - 1, 0, len(self.stations) - 2)
        )
        first, last = self.stations[k], self.stations[k + 1]
        part = min(max((fraction - first) / (last - first), 0.0), 1.0)
        mixed = [(1.0 - part) * array[k] + part * array[k + 1] for array in (self.stiffness, self.inertia)]
        return mixed[0], mixed[1]

    def checks(self) -> tuple[EnergyCheck, ...]:
        """Check for every station whether BeamDyn's product mu S creates energy."""
        return tuple(check_product(stiffness, self.mu) for stiffness in self.stiffness)


@checked
def read_beamdyn_blade(path: str | Path) -> BeamDynBlade:
    """Read a blade file, of the format with or without the section on modal damping.

    Raises:
        InputError: the file cannot be read, ends early, or is not a blade; the message names the line.
    """
    lines = Lines(path)
    title = lines.skip(2).strip()
    lines.skip()
    count = lines.whole("station_total", 2)
    damp_type = lines.whole("damp_type")
    if damp_type > 2:
        raise lines.problem(f"{damp_type}", "damp_type is 0, 1 or 2", "give one of them")
    lines.skip(3)
    mu = lines.numbers(6, "mu1 to mu6")
    if (mu < 0.0).any():
        raise lines.problem(
            f"{mu.min():g}", "a damping coefficient must not be negative", "give numbers >= 0"
        )
    heading = lines.skip()
    if "modal" in heading.lower():
        lines.skip(3)
    stations, stiffness, inertia = np.zeros(count), np.zeros((count, 6, 6)), np.zeros((count, 6, 6))
    for k in range(count):
        lines.skip_blank()
        (stations[k],) = lines.numbers(1, f"the position of station {k + 1}")
        station = station_name(k, stations[k])
        stiffness[k] = _matrix(lines, f"the stiffness of {station}")
        lines.skip_blank()
        inertia[k] = _matrix(lines, f"the mass of {station}")
    falls = np.flatnonzero(np.diff(stations) <= 0.0)
    if stations[0] != 0.0 or stations[-1] != 1.0 or falls.size:
        found = f"stations from {stations[0]:g} to {stations[-1]:g}"
        if falls.size:
            first = int(falls[0])
            found += f", {station_name(first + 1, stations[first + 1])} after eta = {stations[first]:g}"
        raise InputError(
            Fault(
                str(path),
                found,
                "they must rise from 0 to 1",
                "give each station once, in order, as fractions of the length",
            )
        )
    return BeamDynBlade(stations, stiffness, inertia, six_times(mu, "mu"), damp_type, title)


def _matrix(lines: Lines, what: str) -> Floats:
    """Read six rows of six, symmetric but for round-off and printed digits, and return them exactly symmetric."""
    matrix = np.array([lines.numbers(6, f"a row of {what}") for _ in range(6)])
    if (skew := skew_entry(matrix)) is not None:
        i, j = skew
        raise lines.problem(
            f"{float(matrix[i, j])!r} against {float(matrix[j, i])!r} in rows {i + 1} and {j + 1}",
            f"{what} must be symmetric",
            "give the same number twice",
        )
    return symmetric_part(matrix)


@checked_with(blade=of_class(BeamDynBlade))
def write_beamdyn_blade_file(blade: BeamDynBlade, path: str | Path, *, modal_section: bool = False) -> Path:
    """Write a blade file with 17 digits, so that reading it gives the same numbers.

    Args:
        blade: the content.
        path: of the file.
        modal_section: write the lines on modal damping of newer BeamDyn versions; they are not used.

    Raises:
        InputError: the file cannot be written.
    """
    text = [
        " ------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE --------------------------",
        f" {blade.title or 'written by viscorod'}",
        "---------------------- BLADE PARAMETERS --------------------------------------",
        f"{len(blade.stations)}   station_total    - Number of blade input stations (-)",
        f"{blade.damp_type}   damp_type        - Damping type: 0 none, 1 proportional to the stiffness",
        "---------------------- DAMPING COEFFICIENT -----------------------------------",
        "   mu1   mu2   mu3   mu4   mu5   mu6",
        "   (s)   (s)   (s)   (s)   (s)   (s)",
        _row(blade.mu),
    ]
    if modal_section:
        text += [
            "---------------------- MODAL DAMPING [used only if damp_type=2] --------------",
            "1   n_modes",
            "0.0   zeta",
        ]
    text.append("---------------------- DISTRIBUTED PROPERTIES --------------------------------")
    for station, stiffness, inertia in zip(blade.stations, blade.stiffness, blade.inertia, strict=True):
        text += [f"  {station:.17g}", *map(_row, stiffness), "", *map(_row, inertia), ""]
    target = Path(path)
    with replacing(target) as new:
        new.write_text("\n".join(text) + "\n", encoding="utf-8")
    return target


def _row(values: Floats) -> str:
    return "".join(f"  {value: .16E}" for value in values)

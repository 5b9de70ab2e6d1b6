"""``viscorod damping blade``: blades and beams of BeamDyn and GXBeam, read and written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from viscorod.cli.files import rod_of
from viscorod.cli.options import OptionalNumber, RodName, output_option
from viscorod.cli.terminal import notes, readable_errors, rows_text, say
from viscorod.errors import Fault, InputError
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from viscorod.model.rod import Rod
    from viscorod.programs.blades.beamdyn_blade import BeamDynBlade
    from viscorod.typing import Floats

__all__ = ["blade"]


def blade(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="BeamDyn blade file, GXBeam-style .json or .toml, or a case file."
        ),
    ],
    centreline: Annotated[
        Path | None,
        typer.Option("--centreline", metavar="PRIMARY.dat", help="BeamDyn primary file with the key points."),
    ] = None,
    length: Annotated[OptionalNumber, typer.Option(help="Of a straight, untwisted blade instead, m.")] = None,
    same_power: Annotated[
        bool, typer.Option("--same-power", help="Take the symmetric part of mu S, not T C T.")
    ] = False,
    rod: RodName = None,
    output: Annotated[
        Path | None,
        output_option("OUT", "Write a case (.toml), GXBeam's .json, or BeamDyn's blade file."),
    ] = None,
    stations: Annotated[
        int | None,
        typer.Option(
            min=2, help="Stations of the blade file [default: as read, else 11]", show_default=False
        ),
    ] = None,
    elements: Annotated[
        int, typer.Option(min=1, help="Elements of a GXBeam description, pieces of a case.")
    ] = 40,
) -> None:
    """Read a blade or a beam, check whether its damping creates energy, and write it for another program."""
    with readable_errors():
        import numpy as np

        from viscorod.programs.blades.blade_rod import blade_from_rod

        chosen = _any_rod(source, centreline, length, same_power, rod)
        found, losses = blade_from_rod(chosen, None if stations is None else np.linspace(0.0, 1.0, stations))
        heading = f"{source.name}: {len(found.stations)} stations, {chosen.length:.6g} m"
        say(rows_text(heading, _rows(found), prefixes=False))
        say("\nmu [s]: " + ", ".join(f"{value:.6g}" for value in found.mu))
        _say_law(chosen)
        notes(losses)
        if output is None:
            return
        if output.suffix in (".json", ".toml"):
            _write_description(chosen, output, elements, source.stem)
        else:
            _write_blade(chosen, output, found.stations)


def _rows(blade: BeamDynBlade) -> list[dict[str, float]]:
    """Return some stations of a blade as rows of a table."""
    import numpy as np

    return [
        {
            "station": float(blade.stations[k]),
            "mass [kg/m]": float(blade.inertia[k, 0, 0]),
            "EA [N]": float(blade.stiffness[k, 2, 2]),
            "EI about d1 [N m2]": float(blade.stiffness[k, 3, 3]),
            "EI about d2 [N m2]": float(blade.stiffness[k, 4, 4]),
            "GJ [N m2]": float(blade.stiffness[k, 5, 5]),
        }
        for k in np.unique(np.linspace(0, len(blade.stations) - 1, 7).astype(int))
    ]


def _say_law(rod: Rod) -> None:
    """Say how the damping of a blade differs from BeamDyn's."""
    from viscorod.programs.blades.blade_rod import BladeSections

    if not isinstance(rod.section, BladeSections):
        return
    law = "the symmetric part of mu S"
    if rod.section.law != "same power":
        law = "T C T with the same six times"
    say(
        f"The rod's D is {law}; it differs from BeamDyn's mu S by up to {rod.section.difference():.3g} of "
        "sqrt(D_ii D_jj)"
    )


def _write_description(rod: Rod, output: Path, elements: int, title: str) -> None:
    """Write a case (.toml), or a beam of GXBeam (.json)."""
    import json

    from viscorod.programs.blades.gxbeam_assembly import gxbeam_from_rod
    from viscorod.programs.case_text import case_text

    if output.suffix == ".toml":
        text = case_text(rod, elements, title=title)
    else:
        text = json.dumps(gxbeam_from_rod(rod, elements), indent=1) + "\n"
    with replacing(output) as new:
        new.write_text(text, encoding="utf-8")
    say(f"\nWritten: {output}, with {elements} sections")


def _write_blade(rod: Rod, output: Path, stations: Floats) -> None:
    """Write a blade file of BeamDyn, and print the key points that its primary file needs."""
    from viscorod.programs.blades.beamdyn_line import key_points, starts_along_z
    from viscorod.programs.blades.blade_rod import write_beamdyn_blade

    points = key_points(rod, stations)
    turned = "" if starts_along_z(rod) else ", the rod turned so that d1, d2, d3 at its root are X, Y, Z"
    write_beamdyn_blade(rod, output, stations)
    say(
        f"\nWritten: {output}\n"
        f"Key points for the primary file (kp_xr kp_yr kp_zr [m], initial_twist [deg]){turned}:"
    )
    for row in points:
        say("  " + "  ".join(f"{value: .10E}" for value in row))


def _any_rod(
    source: Path, centreline: Path | None, length: float | None, same_power: bool, rod: str | None
) -> Rod:
    """Return the rod of a case file, a GXBeam-style description or a BeamDyn blade file."""
    import tomllib

    from viscorod.programs.blades.blade_rod import Law, rod_from_blade
    from viscorod.programs.blades.gxbeam_assembly import rod_from_gxbeam

    law: Law = "same power" if same_power else "symmetric"
    if source.suffix == ".toml" and source.is_file():
        try:
            described = "points" in tomllib.loads(source.read_text(encoding="utf-8"))
        except (tomllib.TOMLDecodeError, UnicodeDecodeError):
            described = False
        if not described:
            return rod_of(source, rod)[1]
    if source.suffix in (".json", ".toml"):
        return rod_from_gxbeam(source, law=law)
    if (centreline is None) == (length is None):
        raise InputError(
            Fault(
                "--centreline",
                "",
                "a blade file has no positions: exactly one of --centreline and --length is needed",
                "give --centreline PRIMARY.dat, or --length M for a straight, untwisted blade",
            )
        )
    line = centreline if centreline is not None else [[0.0, 0.0, 0.0], [0.0, 0.0, length or 0.0]]
    return rod_from_blade(source, line, law=law)

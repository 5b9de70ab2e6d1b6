"""The command ``viscorod damping``: damping in other words, and in those of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from viscorod.errors import InputError, Problem
from viscorod.terminal import existing, readable_errors, rows_text

if TYPE_CHECKING:
    from viscorod.damping.programs.base import ProgramInputs, SectionData
    from viscorod.model.material import Material
    from viscorod.model.rod import Rod

__all__ = ["app"]

T = TypeVar("T")

app = typer.Typer(
    help="Damping in other words: other numbers, and the inputs of other programs.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

OptionalNumber = float | None
RodName = Annotated[
    str | None, typer.Option("--rod", metavar="NAME", help="Rod of the case; needed where it has several.")
]
SegmentLength = Annotated[
    OptionalNumber,
    typer.Option("--segment-length", metavar="M", help="Of the rigid segments of MuJoCo and Newton, m."),
]
Frequency = Annotated[
    OptionalNumber, typer.Option("--frequency", metavar="HZ", help="Undamped frequency of a mode, Hz.")
]
Station = Annotated[
    float, typer.Option("--at", metavar="S", help="Arc length of the section that is translated, m.")
]


@app.command()
def convert(
    time: Annotated[
        OptionalNumber, typer.Option(help="Retardation time of one law, s (or one of the next five).")
    ] = None,
    loss_factor: Annotated[OptionalNumber, typer.Option(help="At the frequency.")] = None,
    damping_ratio: Annotated[OptionalNumber, typer.Option(help="Of a mode with the frequency.")] = None,
    log_decrement: Annotated[OptionalNumber, typer.Option(help="Of a mode with the frequency.")] = None,
    quality_factor: Annotated[OptionalNumber, typer.Option(help="Of a mode with the frequency.")] = None,
    rayleigh: Annotated[
        str | None, typer.Option(metavar="ALPHA,BETA", help="Two constants, 1/s and s; with --band.")
    ] = None,
    youngs_modulus: Annotated[OptionalNumber, typer.Option(help="Of a material, Pa.")] = None,
    poissons_ratio: Annotated[OptionalNumber, typer.Option(help="Of the material.")] = None,
    shear_time: Annotated[OptionalNumber, typer.Option(help="Of the material, s.")] = None,
    bulk_time: Annotated[OptionalNumber, typer.Option(help="Of the material, s.")] = None,
    extensional_time: Annotated[
        OptionalNumber, typer.Option(help="Instead of the bulk time: of bending and stretching, s.")
    ] = None,
    shear_viscosity: Annotated[OptionalNumber, typer.Option(help="Of the material, Pa s.")] = None,
    bulk_viscosity: Annotated[OptionalNumber, typer.Option(help="Of the material, Pa s.")] = None,
    frequency: Frequency = None,
    band: Annotated[str | None, typer.Option(metavar="LOW,HIGH", help="For Rayleigh constants, Hz.")] = None,
) -> None:
    """Print every number that stands for the damping of one law, or of a material.

    One law: --time 0.02, or --damping-ratio 0.036 --frequency 0.57. A material: --youngs-modulus 1e6
    --poissons-ratio 0.3 --shear-time 0.02 --bulk-time 0.02. With --frequency also what it means at that frequency.
    """
    with readable_errors():
        from viscorod.damping import conversions as c
        from viscorod.damping.rayleigh import time_from_rayleigh
        from viscorod.damping.tables import law_row, material_rows, rayleigh_rows

        limits = None if band is None else _pair("--band", band)
        laws = {
            "--time": time,
            "--loss-factor": loss_factor,
            "--damping-ratio": damping_ratio,
            "--log-decrement": log_decrement,
            "--quality-factor": quality_factor,
            "--rayleigh": rayleigh,
        }
        material = {
            "youngs_modulus": youngs_modulus,
            "poissons_ratio": poissons_ratio,
            "shear_time": shear_time,
            "bulk_time": bulk_time,
            "extensional_time": extensional_time,
            "shear_viscosity": shear_viscosity,
            "bulk_viscosity": bulk_viscosity,
        }
        law = [word for word, value in laws.items() if value is not None]
        of_material = {key: value for key, value in material.items() if value is not None}
        if (len(law) != 1 or of_material) and (law or not of_material):
            raise InputError(
                Problem(
                    "damping convert",
                    f"given: {', '.join([*law, *of_material]) or 'nothing'}",
                    "one law or one material is needed",
                    f"give exactly one of {', '.join(laws)}, or a material: --youngs-modulus, --poissons-ratio, "
                    "and two "
                    "times or viscosities",
                )
            )
        if of_material:
            rows = material_rows(_material(of_material), frequency)
            tau = float(str(rows[1]["time [s]"]))
        else:
            if rayleigh is not None:
                alpha, beta = _pair("--rayleigh", rayleigh)
                low, high = _needed("--band", limits, "LOW,HIGH, Hz")
                tau, error = time_from_rayleigh(alpha, beta, low, high)
                typer.echo(
                    f"The closest Kelvin-Voigt law from {low:g} to {high:g} Hz; its damping ratio differs by up "
                    f"to {error:.3g}."
                )
            elif time is not None:
                tau = time
            else:
                at = _needed("--frequency", frequency, "of the mode, Hz")
                if loss_factor is not None:
                    tau = c.time_from_loss_factor(loss_factor, at)
                elif damping_ratio is not None:
                    tau = c.time_from_damping_ratio(damping_ratio, at)
                elif log_decrement is not None:
                    tau = c.time_from_damping_ratio(c.ratio_from_log_decrement(log_decrement), at)
                else:
                    tau = c.time_from_damping_ratio(c.ratio_from_quality_factor(quality_factor or 0.0), at)
            rows = [law_row("S = C (eps + time eps_t)", tau, frequency)]
        where = "" if frequency is None else f" at {frequency:g} Hz"
        typer.echo(_turned(f"Damping{where}", rows))
        if limits is not None and rayleigh is None:
            at = _needed("--frequency", frequency, "where the ratio is taken, Hz")
            title = f"Rayleigh constants from {limits[0]:g} to {limits[1]:g} Hz (stretch, bending)"
            typer.echo("\n" + rows_text(title, rayleigh_rows(tau, at, limits)))


@app.command()
def programs(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file with the rod.")],
    rod: RodName = None,
    program: Annotated[
        list[str] | None, typer.Option("--program", metavar="NAME", help="Only this one; may be repeated.")
    ] = None,
    segment_length: SegmentLength = None,
    frequency: Frequency = None,
    at: Station = 0.0,
) -> None:
    """Print the damping of a case's rod as inputs of other programs, ready to paste, with what is lost."""
    with readable_errors():
        from viscorod.damping.programs import PROGRAMS
        from viscorod.damping.programs import program as find

        name, chosen = _rod(case, rod)
        data = _section(chosen, at)
        options = _options(segment_length, frequency)
        kinds = list(PROGRAMS.values()) if program is None else [find(word) for word in program]
        typer.echo(f"Rod {name}, section at {at:g} m")
        for kind in kinds:
            lacking = [word for word in kind.options if word not in options]
            if lacking and program is None:
                flag = lacking[0].replace("_", "-")
                typer.echo(f"\n{kind.title}: needs --{flag}; give it to see its inputs")
                continue
            try:
                inputs = kind.from_section(data, **options)
            except InputError as error:
                if program is not None:
                    raise
                typer.echo(f"\n{kind.title}: {error}")
                continue
            typer.echo("\n" + _program_text(inputs, data))


@app.command("from")
def from_(
    program: Annotated[str, typer.Argument(metavar="PROGRAM", help="As in: viscorod damping programs.")],
    numbers: Annotated[
        str, typer.Option("--numbers", metavar="N1,N2,..", help="The program's numbers, in its order.")
    ],
    case: Annotated[
        Path, typer.Option("--case", metavar="CASE.toml", help="Case file with the rod they belong to.")
    ],
    rod: RodName = None,
    poissons_ratio: Annotated[
        OptionalNumber, typer.Option(help="Of the material that is sought; by default the rod's.")
    ] = None,
    segment_length: SegmentLength = None,
    frequency: Frequency = None,
    at: Station = 0.0,
) -> None:
    """Print what another program's damping numbers mean for a rod: six times, and the closest material."""
    with readable_errors():
        from viscorod.damping.programs import program as find
        from viscorod.model.stiffness_section import STRAINS

        kind = find(program)
        name, chosen = _rod(case, rod)
        data = _section(chosen, at)
        inputs = kind.from_numbers(
            _numbers("--numbers", numbers), data, **_options(segment_length, frequency)
        )
        found = inputs.recovered(data, poissons_ratio)
        typer.echo(f"{kind.title}: {kind.meaning}\n")
        rows = []
        for k, word in enumerate(STRAINS):
            row: dict[str, object] = {"strain": word, "time [s]": float(found.times[k])}
            row["D_ii [SI]"] = float(found.damping[k, k])
            if found.material is not None:
                row["material off by"] = f"{found.material.deviations[k]:+.2%}"
            rows.append(row)
        typer.echo(rows_text(f"Rod {name}", rows))
        if found.material is not None:
            fit = found.material
            typer.echo(
                "\nClosest material: damping = "
                f"{{ shear_time = {fit.shear_time:.10g}, bulk_time = {fit.bulk_time:.10g} }}"
            )
        _warnings(found.warnings)


@app.command()
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
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="Write a case (.toml), GXBeam's .json, or BeamDyn's blade file.",
        ),
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
    """Read a blade or a beam, say what its damping does to energy, and write it for the other program."""
    with readable_errors():
        import json

        import numpy as np

        from viscorod.damping.beamdyn_line import key_points
        from viscorod.damping.blade_rod import BladeSections, blade_from_rod, write_beamdyn_blade
        from viscorod.damping.case_text import case_text
        from viscorod.damping.gxbeam_assembly import gxbeam_from_rod

        chosen = _any_rod(source, centreline, length, same_power, rod)
        found, losses = blade_from_rod(chosen, None if stations is None else np.linspace(0.0, 1.0, stations))
        shown = np.unique(np.linspace(0, len(found.stations) - 1, 7).astype(int))
        rows = [
            {
                "station": float(found.stations[k]),
                "mass [kg/m]": float(found.inertia[k, 0, 0]),
                "EA [N]": float(found.stiffness[k, 2, 2]),
                "EI about d1 [N m2]": float(found.stiffness[k, 3, 3]),
                "EI about d2 [N m2]": float(found.stiffness[k, 4, 4]),
                "GJ [N m2]": float(found.stiffness[k, 5, 5]),
            }
            for k in shown
        ]
        typer.echo(rows_text(f"{source.name}: {len(found.stations)} stations, {chosen.length:.6g} m", rows))
        typer.echo("\nmu [s]: " + ", ".join(f"{value:.6g}" for value in found.mu))
        if isinstance(chosen.section, BladeSections):
            law = (
                "the symmetric part of mu S"
                if chosen.section.law == "same power"
                else "T C T with the same six times"
            )
            typer.echo(
                f"The rod's D is {law}; it differs from BeamDyn's mu S by up to {chosen.section.difference():.3g} of "
                "sqrt(D_ii D_jj)"
            )
        _warnings(losses)
        if output is None:
            return
        if output.suffix in (".json", ".toml"):
            text = (
                case_text(chosen, elements, title=source.stem)
                if output.suffix == ".toml"
                else json.dumps(gxbeam_from_rod(chosen, elements), indent=1) + "\n"
            )
            _write(output, text)
            typer.echo(f"\nWritten: {output}, with {elements} sections")
            return
        points = key_points(chosen, found.stations)
        write_beamdyn_blade(chosen, output, found.stations)
        typer.echo(
            f"\nWritten: {output}\nKey points for the primary file (kp_xr kp_yr kp_zr [m], initial_twist [deg]):"
        )
        for row in points:
            typer.echo("  " + "  ".join(f"{value: .10E}" for value in row))


def _any_rod(
    source: Path, centreline: Path | None, length: float | None, same_power: bool, rod: str | None
) -> Rod:
    """The rod of a case file, a GXBeam-style description or a BeamDyn blade file."""
    import tomllib

    from viscorod.damping.blade_rod import rod_from_blade
    from viscorod.damping.gxbeam_assembly import rod_from_gxbeam

    law = "same power" if same_power else "symmetric"
    if source.suffix == ".toml" and source.is_file():
        try:
            described = "points" in tomllib.loads(source.read_text(encoding="utf-8"))
        except (tomllib.TOMLDecodeError, UnicodeDecodeError):
            described = False
        if not described:
            return _rod(source, rod)[1]
    if source.suffix in (".json", ".toml"):
        return rod_from_gxbeam(source, law="same power" if law == "same power" else "symmetric")
    if (centreline is None) == (length is None):
        raise InputError(
            Problem(
                "--centreline",
                "",
                "a blade file has no positions: exactly one of --centreline and --length is needed",
                "give --centreline PRIMARY.dat, or --length M for a straight, untwisted blade",
            )
        )
    line = centreline if centreline is not None else [[0.0, 0.0, 0.0], [0.0, 0.0, length or 0.0]]
    return rod_from_blade(source, line, law="same power" if same_power else "symmetric")


def _rod(case: Path, name: str | None) -> tuple[str, Rod]:
    """A rod of a case file, with its name."""
    from viscorod.cases.case import load_case
    from viscorod.model.described import nearest

    rods = load_case(existing(case)).description.rods
    if name is None and len(rods) == 1:
        return next(iter(rods.items()))
    if name in rods:
        return name, rods[name]
    names = ", ".join(rods)
    if name is None:
        raise InputError(Problem("--rod", "", f"the case has {len(rods)} rods", f"give one of {names}"))
    close = nearest(name, rods)
    advice = f"did you mean {close}? " if close else ""
    raise InputError(Problem("--rod", name, "the case has no such rod", f"{advice}It has {names}"))


def _section(rod: Rod, at: float) -> SectionData:
    from viscorod.damping.programs.base import SectionData

    if not 0.0 <= at <= rod.length:
        raise InputError(
            Problem("--at", f"{at:g}", "outside the rod", f"give an arc length from 0 to {rod.length:g} m")
        )
    return SectionData.of(rod, at)


def _options(segment_length: float | None, frequency: float | None) -> dict[str, float]:
    given = {"segment_length": segment_length, "frequency": frequency}
    return {key: value for key, value in given.items() if value is not None}


def _material(given: dict[str, float]) -> Material:
    """A material of density one from its moduli and a pair of times or viscosities."""
    from viscorod.damping.conversions import bulk_time
    from viscorod.model.material import KelvinVoigt, Material

    values: dict[str, Any] = dict(given)
    for key in ("youngs_modulus", "poissons_ratio"):
        if key not in values:
            raise InputError(
                Problem(f"--{key.replace('_', '-')}", "", "a material needs it", "give it as well")
            )
    young, nu = values.pop("youngs_modulus"), values.pop("poissons_ratio")
    if "extensional_time" in values and "shear_time" in values and "bulk_time" not in values:
        values["bulk_time"] = bulk_time(values.pop("extensional_time"), values["shear_time"], nu)
    if "extensional_time" in values:
        raise InputError(
            Problem(
                "--extensional-time",
                "",
                "it stands for the bulk time, beside the shear time",
                "give --shear-time and --extensional-time only",
            )
        )
    return Material(young, nu, 1.0, damping=KelvinVoigt(**values))


def _program_text(inputs: ProgramInputs, data: SectionData) -> str:
    lines = [f"{inputs.title} ({inputs.program}): {inputs.meaning}", ""]
    lines += [f"    {line}" for line in inputs.text().splitlines()]
    for title, sentences in (
        ("Lost", inputs.losses(data)),
        ("Note", inputs.warnings(data)),
        ("Read in", inputs.sources),
    ):
        if sentences:
            lines += ["", *(f"  {title}: {sentence}" for sentence in sentences)]
    return "\n".join(lines)


def _turned(title: str, rows: list[dict[str, object]]) -> str:
    """A table with one column per row of data: many numbers of few things."""
    from viscorod.results.text import table
    from viscorod.terminal import cell

    keys = list(rows[0])
    columns = [[cell(row[key]) for row in rows] for key in keys]
    return table(title, ["", *columns[0]], [[k, *c] for k, c in zip(keys[1:], columns[1:], strict=True)])


def _warnings(sentences: tuple[str, ...]) -> None:
    if sentences:
        typer.echo("\n".join(["", *(f"Note: {sentence}" for sentence in sentences)]))


def _numbers(flag: str, text: str) -> list[float]:
    """Numbers separated by commas."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(
            Problem(flag, text, "numbers are needed here", "separate them by commas: 0.01,0.02")
        ) from None


def _pair(flag: str, text: str) -> tuple[float, float]:
    values = _numbers(flag, text)
    if len(values) != 2:
        raise InputError(Problem(flag, text, "two numbers are needed here", f"give {flag} 0.1,10"))
    return values[0], values[1]


def _needed(flag: str, value: T | None, what: str) -> T:
    if value is None:
        raise InputError(Problem(flag, "", "it is needed here", f"give {flag} ({what})"))
    return value


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(
            Problem(str(path), "", f"the file cannot be written ({error.strerror})", "name another folder")
        ) from None

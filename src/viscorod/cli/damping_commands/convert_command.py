"""``viscorod damping convert``: one number for damping from another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from viscorod.cli.options import Frequency, OptionalNumber, numbers_of
from viscorod.cli.terminal import readable_errors, rows_text, say
from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.model.materials.material import Material

__all__ = ["convert"]

T = TypeVar("T")


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
    """Print all numbers for the damping of one law, or of a material.

    One law: --time 0.02, or --damping-ratio 0.036 --frequency 0.57. A material: --youngs-modulus 1e6
    --poissons-ratio 0.3 --shear-time 0.02 --bulk-time 0.02. With --frequency also what it means at that frequency.
    """
    with readable_errors():
        from viscorod.programs.tables import law_row, material_rows, rayleigh_rows

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
                Fault(
                    "damping convert",
                    f"given: {', '.join([*law, *of_material]) or 'nothing'}",
                    "one law or one material is needed",
                    f"give exactly one of {', '.join(laws)}, or a material: --youngs-modulus, --poissons-ratio, "
                    "and two times or viscosities",
                )
            )
        if of_material:
            rows = material_rows(_material(of_material), frequency)
            tau = float(str(rows[1]["time [s]"]))
        else:
            tau = _time(law[0], laws[law[0]], frequency, limits)
            rows = [law_row("S = C (eps + time eps_t)", tau, frequency)]
        where = "" if frequency is None else f" at {frequency:g} Hz"
        say(_turned(f"Damping{where}", rows))
        if limits is not None and rayleigh is None:
            at = _needed("--frequency", frequency, "where the ratio is taken, Hz")
            title = f"Rayleigh constants from {limits[0]:g} to {limits[1]:g} Hz (stretch, bending)"
            say("\n" + rows_text(title, rayleigh_rows(tau, at, limits), prefixes=False))


def _time(law: str, value: Any, frequency: float | None, limits: tuple[float, float] | None) -> float:
    """Return the retardation time [s] of one law.

    Args:
        law: its flag; value: what it was given; frequency: of the mode [Hz].
        limits: of the band of Rayleigh's constants [Hz].
    """
    from viscorod.programs import conversions as c
    from viscorod.programs.rayleigh import time_from_rayleigh

    if law == "--time":
        return float(value)
    if law == "--rayleigh":
        alpha, beta = _pair("--rayleigh", value)
        low, high = _needed("--band", limits, "LOW,HIGH, Hz")
        tau, error = time_from_rayleigh(alpha, beta, low, high)
        say(
            f"The closest Kelvin-Voigt law from {low:g} to {high:g} Hz; its damping ratio differs by up to {error:.3g}."
        )
        return tau
    at = _needed("--frequency", frequency, "of the mode, Hz")
    if law == "--loss-factor":
        return c.time_from_loss_factor(value, at)
    ratios = {"--log-decrement": c.ratio_from_log_decrement, "--quality-factor": c.ratio_from_quality_factor}
    ratio = ratios[law](value) if law in ratios else value
    return c.time_from_damping_ratio(ratio, at)


def _pair(flag: str, text: str) -> tuple[float, float]:
    """Return two numbers separated by a comma."""
    values = numbers_of(flag, text)
    if len(values) != 2:
        raise InputError(Fault(flag, text, "two numbers are needed here", f"give {flag} 0.1,10"))
    return values[0], values[1]


def _needed(flag: str, value: T | None, what: str) -> T:
    """Return a value that must be given here."""
    if value is None:
        raise InputError(Fault(flag, "", "it is needed here", f"give {flag} ({what})"))
    return value


def _material(given: dict[str, float]) -> Material:
    """Return a material of density one from its moduli and a pair of times or viscosities."""
    from viscorod.model.materials.material import KelvinVoigt, Material
    from viscorod.programs.conversions import bulk_time

    values: dict[str, Any] = dict(given)
    for key in ("youngs_modulus", "poissons_ratio"):
        if key not in values:
            raise InputError(
                Fault(f"--{key.replace('_', '-')}", "", "a material needs it", "give it as well")
            )
    young, nu = values.pop("youngs_modulus"), values.pop("poissons_ratio")
    if "extensional_time" in values and "shear_time" in values and "bulk_time" not in values:
        values["bulk_time"] = bulk_time(values.pop("extensional_time"), values["shear_time"], nu)
    if "extensional_time" in values:
        raise InputError(
            Fault(
                "--extensional-time",
                "",
                "it is given instead of the bulk time, with the shear time",
                "give --shear-time and --extensional-time only",
            )
        )
    return Material(young, nu, 1.0, damping=KelvinVoigt(**values))


def _turned(title: str, rows: list[dict[str, object]]) -> str:
    """Return a table with one column per row of data, for many numbers of few things."""
    from viscorod.results.row_table import cell
    from viscorod.results.text_table import table

    keys = list(rows[0])
    columns = [[cell(row[key]) for row in rows] for key in keys]
    return table(title, ["", *columns[0]], [[k, *c] for k, c in zip(keys[1:], columns[1:], strict=True)])

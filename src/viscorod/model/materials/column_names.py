"""Names and units of the columns of measured tables, in English and German, as programs and people write them.

A name is compared as a whole, without blanks, dots and underlines, so that a column of something else, such as the
deviation of a modulus or a compliance, is never taken for the modulus.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

__all__ = ["Heading", "heading", "unit_of"]

_UNITS: dict[str, dict[str, tuple[str, ...]]] = {
    "frequency": {
        "Hz": ("hz", "hertz"),
        "kHz": ("khz",),
        "mHz": (),
        "MHz": (),
        "rad/s": ("rad/sec", "rads-1", "rads^-1", "rad*s-1", "radpers", "radpersec", "rads", "radians/s"),
        "1/s": ("s-1", "s^-1", "1/sec"),
    },
    "modulus": {
        "Pa": ("pa", "pascal", "pascals", "n/m2", "nm-2"),
        "kPa": ("kpa", "kilopascal", "kn/m2"),
        "MPa": ("mpa", "megapascal", "n/mm2", "mn/m2", "nmm-2"),
        "GPa": ("gpa", "gigapascal", "kn/mm2"),
        "psi": ("lbf/in2", "lb/in2"),
        "ksi": (),
        "bar": (),
        "dyn/cm2": ("dyne/cm2", "dynes/cm2"),
    },
    "compliance": {
        "1/Pa": ("pa-1", "pa^-1", "m2/n", "1/pascal"),
        "1/kPa": ("kpa-1", "kpa^-1"),
        "1/MPa": ("mpa-1", "mpa^-1", "mm2/n"),
        "1/GPa": ("gpa-1", "gpa^-1", "um2/mn"),
    },
    "viscosity": {
        "Pa s": ("pas", "pa.s", "pa*s", "pa-s", "pasec", "ns/m2"),
        "mPa s": ("mpas", "mpa.s", "mpa*s", "mpa-s", "cp"),
        "kPa s": ("kpas", "kpa.s", "kpa*s", "kpa-s"),
        "MPa s": (),
        "P": ("poise",),
    },
    "temperature": {
        "C": ("°c", "c", "degc", "celsius", "deg.c", "ºc", "grdc", "℃"),
        "K": ("k", "kelvin"),
        "F": ("°f", "f", "degf", "ºf"),
    },
    "ratio": {"1": ("", "-", "--", "none", "[]", "n/a", "dimensionless"), "%": ("percent",)},
    "angle": {"deg": ("°", "º", "degrees", "degree", "grad"), "rad": ("radian", "radians"), "mrad": ()},
}
"""Units by what they measure, with other spellings in small letters and without blanks."""

_HOW = (
    r"(dynamic|complex|shear|tensile|tension|youngs?|young's|flexural|flexure|bending|torsional|torsion|compressive|"
    r"compression|axial|extensional|elongational|extension|linear|schub|scher|zug|biege|torsions|elastischer?|dynamischer?)?"
)
_SYMBOL = r"\(?[egm]('|\*)?\)?"
_FREQUENCY = r"(freq|freqs|frequency|frequencies|frequenz|fréquence|frecuencia|frequenza|frequência)"
_YIELD = r"(compliance|komplianz|nachgiebigkeit)"
_FLOW, _ETA = r"(viscosity|viskosität|viskositaet)", r"(η|eta)"
KINDS: dict[str, str] = {
    "angular": rf"(ang|angular|circular|radian|kreis|winkel){_FREQUENCY}\(?(ω|omega|w)?\)?|ω|omega|w",
    "frequency": rf"(test|osc|oscillation|excitation|reduced|red|shifted|set|actual|target|mess|meß|prüf|pruef|"
    rf"anregungs?|belastungs|reduzierte)?{_FREQUENCY}\(?(f)?\)?|f",
    "storage": rf"([egm]')?{_HOW}(storage|stor|speicher)(modulus|modul|mod)?{_HOW}({_SYMBOL})?|"
    rf"[egm]'|[egm](storage|stor|store|speicher|prime|p)|(elastic|real)?{_HOW}(modulus|modul)\(?[egm]'\)?|"
    rf"(storage|stor)(modulus)?[egm]|{_HOW}modulus\(elasticcomponent\)|(re|real)\(?[egm]\*\)?|"
    r"modulede(conservation|stockage)([egm]')?",
    "loss": rf"([egm]'')?{_HOW}(loss|verlust)(modulus|modul|mod)?{_HOW}(\(?[egm]('')?\)?)?|"
    r"[egm]''|[egm](loss|verlust|doubleprime|dprime|primeprime|dblprime|pp)|"
    rf"(viscous|imaginary)?{_HOW}(modulus|modul)\(?[egm]''\)?|loss(modulus)?[egm]|"
    rf"{_HOW}modulus\(viscouscomponent\)|(im|imag)\(?[egm]\*\)?|modulede(perte|pertes)([egm]'')?",
    "tan_delta": r"(mech|mechanical|mechanischer)?(loss|verlust|damping|dämpfungs|dissipation)(factor|faktor|tangent)"
    r"(\(?tan\(?(d|delta|δ)\)?\)?|η|eta)?|tan\(?(d|delta|δ)\)?(lossfactor|\([eg]\))?|"
    r"\(?tan(d|delta|δ)\)?",
    "phase": r"(phase|loss|verlust|phasen)(shift|verschiebungs)?(angle|winkel|verschiebung|shift)?\(?(δ|delta)?\)?|"
    r"δ|delta|déphasage|angledeperte",
    "complex": rf"\|?[egm]\*\|?|{_HOW}(komplexer)?{_HOW}(modulus|modul)\(?\|?[egm]\*\|?\)?|"
    rf"(complex|komplexer){_HOW}(modulus|modul)|[egm]star|abs\(?[egm]\*?\)?|"
    r"modulecomplexe([egm]\*)?|module\|?[egm]\*\|?",
    "storage_compliance": rf"([jd]')?{_HOW}(storage|stor|speicher){_HOW}{_YIELD}(\(?[jd]'\)?)?|[jd]'|"
    rf"{_HOW}{_YIELD}\(?[jd]'\)?|[jd](storage|stor|prime)",
    "loss_compliance": rf"([jd]'')?{_HOW}(loss|verlust){_HOW}{_YIELD}(\(?[jd]''\)?)?|[jd]''|"
    rf"{_HOW}{_YIELD}\(?[jd]''\)?|[jd](loss|verlust|doubleprime)",
    "complex_compliance": rf"{_HOW}(complex|komplexe){_HOW}{_YIELD}(\(?\|?[jd]\*\|?\)?)?|\|?[jd]\*\|?|"
    rf"{_HOW}{_YIELD}\(?\|?[jd]\*\|?\)?",
    "viscosity": rf"(real|dynamic|dynamische)?{_FLOW}\(?{_ETA}'\)?|{_ETA}'|dynamic{_FLOW}",
    "out_of_phase_viscosity": rf"(imaginary|outofphase)?{_FLOW}\(?{_ETA}''\)?|{_ETA}''|(imaginary|outofphase){_FLOW}",
    "complex_viscosity": rf"{_HOW}(complex|komplexe){_HOW}{_FLOW}(\(?\|?{_ETA}\*\|?\)?)?|\|?{_ETA}\*\|?|{_ETA}star|"
    rf"{_FLOW}complex|{_FLOW}\(?\|?{_ETA}\*\|?\)?",
    "temperature": r"(sample|test|actual|furnace|chamber|proben|mess|ist|ofen|prüf)?(temp|temperature|temperatur)"
    r"\(?(t|ts)?\)?|t|ts",
    "set_temperature": r"(set|setpoint|target|nominal|soll|programmed)(temp|temperature|temperatur)|tr|tset|tsoll",
    "group": r"(set|sweep|step|isotherm|segment)(no|number|nr|index)?",
}
"""What a column holds -> the names, in small letters without blanks, dots, underlines and hyphens."""

MEASURE = {
    "angular": "frequency", "frequency": "frequency", "storage": "modulus", "loss": "modulus", "tan_delta": "ratio",
    "phase": "angle", "complex": "modulus", "temperature": "temperature", "set_temperature": "temperature",
    "group": "ratio", "storage_compliance": "compliance", "loss_compliance": "compliance",
    "complex_compliance": "compliance", "viscosity": "viscosity", "out_of_phase_viscosity": "viscosity",
    "complex_viscosity": "viscosity",
}  # fmt: skip
"""What the unit of a column measures."""

STRAINS = {
    "shear": r"\|?[gjη]['_* ]|[gjη]$|eta|shear|schub|scher|torsion|.*\b[gj]['*]|.*η",
    "extension": r"\|?[ed]['_* ]|[ed]$|tensile|tension|young|flexur|bending|zug|biege|compress|axial|extension|"
    r"elongation|.*\b[ed]['*]",
}
"""Beginnings of the name of the storage modulus that show the strain."""

OF_SHEAR = re.compile(
    r"(shear|schub|scher)\w*[\s_]*(strain|stress|rate|spannung|dehnung|verformung|deformation)|"
    r"schubspannung|scherspannung|scherdehnung|\btorque|drehmoment"
)
"""Names of other columns, in small letters, of a sample that was sheared or twisted."""

_PRIMES = str.maketrans(dict.fromkeys("\N{PRIME}\N{RIGHT SINGLE QUOTATION MARK}\N{LEFT SINGLE QUOTATION MARK}"
                                      "\N{ACUTE ACCENT}\N{GRAVE ACCENT}", "'")
                        | dict.fromkeys('"\N{DOUBLE PRIME}\N{RIGHT DOUBLE QUOTATION MARK}'
                                        "\N{LEFT DOUBLE QUOTATION MARK}", "''")
                        | dict(zip("₀₁₂", "012", strict=True))
                        | {"\N{NO-BREAK SPACE}": " ", "\N{OHM SIGN}": "ω", "µ": "u", "μ": "u", "Δ": "δ"})  # fmt: skip
_LOGARITHM = re.compile(r"(log10|log_10|log|lg|ln)(?=[\s_(]|[egmfω]['_*]?)[\s_]*(.*)")
_BASES = {"log10": "10", "log_10": "10", "lg": "10", "ln": "e", "log": "?"}


@dataclass(frozen=True)
class Heading:
    """What the name of a column says.

    Attributes:
        kind: of `KINDS`.
        text: the name as it stands in the file.
        unit: beside the name, or None.
        strain: "shear" or "extension" where the name shows it.
        logarithm: "10" or "e", its base, where the column holds logarithms; "?" where the name does not say which.
    """

    kind: str
    text: str
    unit: str | None = None
    strain: str | None = None
    logarithm: str = ""

    def completed(self, other: Heading) -> Heading:
        """Return what this and another name of the same column say together."""
        return replace(other, unit=other.unit or self.unit, strain=other.strain or self.strain)


def unit_of(text: str, measure: str) -> str | None:
    """Return the unit that a text means for a measure of ``_UNITS``, or None."""
    plain = text.strip().strip("[]()").translate(_PRIMES)
    plain = plain.replace("²", "2").replace("⁻¹", "-1").replace("^2", "2").replace("·", "").replace(" ", "")
    units = _UNITS[measure]
    if plain in units:
        return plain
    if plain in ("mPa", "mpas", "mPas") and measure == "modulus":
        return None
    if measure == "viscosity" and plain.startswith("MPa"):
        return "MPa s"
    return next((unit for unit, spellings in units.items() if plain.lower() in spellings), None)


def heading(cell: str) -> Heading | None:
    """Return what the name in a cell says, or None if it is none of `KINDS`.

    Units are understood in brackets, after a slash, "in" or a comma, and at the end after a blank, a dot or an
    underline.
    """
    text = cell.strip().lstrip("#%").strip().translate(_PRIMES)
    if not text or len(text) > 80:
        return None
    if found := re.fullmatch(r"(.+[)\]])\s*\(([egmEGM]'{1,2}|f|ω)\)", text):  # a symbol behind the unit
        text = found[1]
    if found := re.fullmatch(r"(?i)(log10|log|lg|ln)\s*\(([^()/]+)/\s*\(?([^()]+?)\)?\s*\)", text):
        text = f"{found[1]} {found[2].strip()} ({found[3]})"
    for name, unit in _parts(text):
        kind, logarithm = _kind(name)
        if kind is None:
            continue
        measure = MEASURE[kind]
        if kind == "temperature" and name in ("t", "f", "ts"):
            continue  # a time or a force
        if name in ("F", "W", "E", "G", "M") and (unit is None or unit_of(unit, measure) is None):
            continue  # a force, a work
        if kind == "tan_delta" and unit and unit_of(unit, "ratio") is None and unit_of(unit, "angle"):
            kind = "phase"  # a loss factor in degrees is the angle
        low = name.lower()
        strain = next((strain for strain, start in STRAINS.items() if re.match(start, low)), None)
        if strain is None and MEASURE[kind] == "viscosity":
            strain = "shear"  # others are called tensile, or elongational
        of_strain = MEASURE[kind] in ("modulus", "compliance", "viscosity")
        return Heading(kind, cell.strip(), unit, strain if of_strain else None, logarithm)
    return None


def _parts(text: str) -> list[tuple[str, str | None]]:
    """Return ways to divide a cell into a name and a unit, the likeliest first."""
    ways: list[tuple[str, str | None]] = [(text, None)]
    if found := re.fullmatch(r"(.+?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\])\.?", text):
        ways.append((found[1], found[2] if found[2] is not None else found[3]))
    if found := re.fullmatch(r"(.+?)\s*/\s*\(?(-|%|°|[^\W\d_][^']*?|°[CF]|1/s|1)\)?", text):
        ways.append((found[1], found[2]))
    if found := re.fullmatch(r"(.+?)\s+in\s+([^']+)", text):
        ways.append((found[1], found[2]))
    parts = re.split(r"([\s_.,;:]+)", text.rstrip(". "))
    for at in range(1, len(parts), 2):  # a unit of several words, such as rad_s, before one of its last word
        name, unit = "".join(parts[:at]), "".join(parts[at + 1 :])
        spelt = re.sub(r"[\s_.]+", "", unit)
        spelt = {"rads": "rad/s", "radsec": "rad/s", "nmm2": "N/mm2", "nm2": "N/m2"}.get(spelt.lower(), spelt)
        if spelt and any(unit_of(spelt, measure) for measure in _UNITS):
            ways.append((name, spelt))
    return [(name.strip(" _,;:"), None if unit is None else unit.strip()) for name, unit in ways]


def _kind(name: str) -> tuple[str | None, str]:
    """Return the kind of a name without unit, and the base of its logarithm, if it is one."""
    low = name.lower()
    logarithm = _LOGARITHM.match(low)
    inner = re.sub(r"^\((.*)\)$", r"\1", logarithm[2]) if logarithm else low
    joined = re.sub(r"[\s_.\-–,;:]+", "", inner)
    for kind, pattern in KINDS.items():
        if re.fullmatch(pattern, joined):
            return kind, _BASES[logarithm[1]] if logarithm else ""
    return None, ""

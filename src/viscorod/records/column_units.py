"""Units as they stand in files, beside names or below them, and what they are in SI."""

from __future__ import annotations

import re
from fractions import Fraction

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import RefusedError, show
from viscorod.unit_text import Dimension, factor_of
from viscorod.units import si_of, si_value

__all__ = ["COUNTS", "is_of_kind", "is_unit", "name_and_unit", "si_factor", "si_size_and_kind", "weight_of"]

GRAVITY = 9.80665
"""m/s^2 of the unit g of accelerometers."""
_BRACKETS = re.compile(
    r"^(?P<name>.*?)\s*(?:[\[{<](?P<a>[^\[\]{}<>]*)[\]}>]|\((?P<b>[^()]*(?:\([^()]*\)[^()]*)*)\)|\s+in\s+(?P<c>\S+))$"
)
_PLAIN = {"-": "1", "": "", "1": "1", **dict.fromkeys(("sec", "Sec", "seconds", "Seconds", "sec."), "s")}
_TIMES = {
    word + end: unit
    for word, unit in (("second", "s"), ("millisecond", "ms"), ("microsecond", "us"), ("minute", "min"))
    for end in ("", "s")
}
"""Names of columns of times that are units: "Second", "seconds_elapsed"."""
_SPELT = {
    **{"m/s2": "m/s^2", "m/s²": "m/s^2", "mm/s2": "mm/s^2", "mm/s²": "mm/s^2", "um": "µm"},
    **dict.fromkeys(("ue", "µe", "µm/m", "um/m", "microstrain", "microstrains"), "ustrain"),
    **dict.fromkeys(("m/m", "strain", "e"), "1"),
    **dict.fromkeys(("mil", "mils"), "thou"),
}
"""Other spellings of units; micro and epsilon are written as u or µ, and e."""
_RAISED = str.maketrans("¹²³", "123")
_GRAVITIES = {"g": 1.0, "G": 1.0, "gn": 1.0, "mg": 1e-3, "mG": 1e-3, "ug": 1e-6, "µg": 1e-6}
"""Units of accelerometers, in `GRAVITY`: of an acceleration g is no gram."""
WEIGHTS = {"kg": "kgf", "g": "gf", "lb": "lbf", "lbs": "lbf", "oz": "ozf", "t": "tf"}
"""Units of masses, and of their weights."""
_PLAIN_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
COUNTS = (
    "VOLT",
    "Volt",
    "Volts",
    "px",
    "pix",
    "pixel",
    "pixels",
    "V",
    "mV",
    "volt",
    "volts",
    "counts",
    "digits",
    "LSB",
    "mV/V",
    "µV/V",
    "uV/V",
    "V/V",
)
"""What cameras, amplifiers and bridges of gauges give, of which only the user knows the size."""


def si_factor(source: str, column: str, written: str, unit: str) -> float:
    """Return the SI value of a unit of the kind of an SI unit.

    Raises:
        InputError: it is no unit, or one of another kind.
    """
    size, written = _number_and_unit(written)
    if size is not None:
        return size * si_factor(source, column, written, unit)
    plain = _PLAIN.get(written.strip(), written.strip()).replace("μ", "µ").replace("ε", "e")
    if unit == "m/s^2" and plain in _GRAVITIES:
        return GRAVITY * _GRAVITIES[plain]
    plain = _small(_SPELT.get(plain, _metres_per_second(plain)))
    if unit == "1":
        if plain in ("1", "%", "ustrain", "mm/m"):
            return {"1": 1.0, "%": 1e-2, "ustrain": 1e-6, "mm/m": 1e-3}[plain]
        raise InputError(
            Fault(
                f"{source}: {column}",
                show(written),
                "this quantity is a plain number",
                "use 1, %, mm/m or ustrain",
            )
        )
    try:
        return si_value(f"1 {plain}", unit, column)
    except RefusedError as error:
        raise InputError(Fault(f"{source}: {column}", show(written), error.why, error.instead)) from None


def is_of_kind(written: str, unit: str) -> bool:
    """Return whether a text is a unit of the kind of an SI unit."""
    try:
        si_factor("", "", written, unit)
    except InputError:
        return False
    return True


def _number_and_unit(text: str) -> tuple[float | None, str]:
    """Return the number and the unit of the size of one count, "0.21 mm", "1/30 s"; None where a unit stands alone."""
    found = re.fullmatch(rf"\s*([+-]?{_PLAIN_NUMBER})(?:\s*/\s*({_PLAIN_NUMBER}))?\s+(\S.*)", text)
    if found is None or (found[2] is not None and float(found[2]) == 0.0):
        return None, text
    return float(found[1]) / float(found[2] or 1.0), found[3]


def weight_of(written: str, unit: str) -> str | None:
    """Return the unit of force that a unit of mass weighs, where one of force is needed; None of all others."""
    return WEIGHTS.get(written.strip()) if unit == "N" else None


def si_size_and_kind(source: str, column: str, written: str) -> tuple[float, Dimension]:
    """Return the SI value of a unit of a response, and its powers of m, kg, s and so on; g is that of accelerometers.

    Raises:
        InputError: it is no unit.
    """
    size, written = _number_and_unit(written)
    if size is not None:
        one, kind = si_size_and_kind(source, column, written)
        return size * one, kind
    if written.strip() in ("1", "-", ""):
        return 1.0, ()
    text = _metres_per_second(written)
    gravity = re.match(r"\s*\(?\s*(m?[gG]|gn)\s*\)?\s*(?=/|$)", text)
    if gravity:  # of an accelerometer over a force: no response is a mass
        over = text[gravity.end() :].strip(" /")
        below, kind = si_size_and_kind(source, column, over) if over else (1.0, ())
        return GRAVITY * _GRAVITIES[gravity[1]] / below, _quotient(factor_of("m/s^2")[1], kind)
    under = re.fullmatch(r"(.*\S)\s*/\s*\(?(m?[gG]|gn)\)?\s*", text)
    if under:
        above, kind = si_size_and_kind(source, column, under[1])
        return above / (GRAVITY * _GRAVITIES[under[2]]), _quotient(kind, factor_of("m/s^2")[1])
    try:
        factor, kind = factor_of(re.sub(r"/([^/()]+)/([^/()]+)$", r"/(\1 \2)", text))
    except RefusedError as error:
        raise InputError(Fault(f"{source}: {column}", show(written), error.why, error.instead)) from None
    return float(factor), kind


def _quotient(over: Dimension, under: Dimension) -> Dimension:
    """Return the powers of a unit over another."""
    powers = dict(over)
    for name, power in under:
        powers[name] = powers.get(name, Fraction(0)) - power
    return tuple(sorted((name, power) for name, power in powers.items() if power))


def _metres_per_second(unit: str) -> str:
    """Return a unit in which ms-1 and mms^-2, written in one piece, are velocities and so on, no milliseconds."""
    return re.sub(
        r"(?<![^\W\d_])([cmuµ]?m)s(?:\^|\*\*)?\(?-([12])\)?",
        r"\1 s^-\2",
        unit.replace("⁻", "-").translate(_RAISED),
    )


def name_and_unit(cell: str) -> tuple[str, str | None]:
    """Return the name and the unit of a heading: "t [s]", "t (s)", "t / s", "x in mm", "tip_x_m", "time, s"."""
    text = cell.strip().lstrip("#%").strip()
    if len(text) > 1 and text[0] == text[-1] == '"':
        text = text[1:-1]
    for stroke in re.finditer(r"\s*/\s*", text):
        name, unit = text[: stroke.start()], text[stroke.end() :]
        if name and (_is_unit(unit) or unit.startswith("dB")):
            return name, unit
    found = _BRACKETS.match(text)
    if found:
        unit = next(part for part in (found["a"], found["b"], found["c"]) if part is not None)
        return found["name"].rstrip(" /"), _PLAIN.get(unit.strip(), unit.strip()) or None
    for mark in (",", "_", " "):
        name, _, unit = text.rpartition(mark)
        if name and (_is_unit(unit.strip()) or (mark == "_" and unit in COUNTS)):
            return name.strip(), unit.strip()
    spelt = next((word for word in re.split(r"[_ ]", text) if word.lower() in _TIMES), None)
    if spelt is not None and len(re.split(r"[_ ]", text)) <= 2:
        return text, _TIMES[spelt.lower()]
    two = re.fullmatch(r"(.+?)[_ ](mm?|cm|[km]?N|um|µm)_(s2?)", text)
    if two:
        return two[1], f"{two[2]}/{two[3].replace('s2', 's^2')}"
    return text, None


_ENDINGS = (
    *(
        "s",
        "ms",
        "us",
        "µs",
        "min",
        "h",
        "m",
        "mm",
        "cm",
        "um",
        "µm",
        "in",
        "N",
        "mN",
        "kN",
        "Hz",
        "kHz",
        "N m",
    ),
    *(
        "Pa",
        "kPa",
        "MPa",
        "GPa",
        "m/s",
        "mm/s",
        "m/s^2",
        "m/s2",
        "mm/s^2",
        "g",
        "rad",
        "deg",
        "°",
        "rad/s",
        "%",
        "ustrain",
    ),
)
"""Units that are known after a name without brackets."""


def _is_unit(text: str) -> bool:
    return text in _ENDINGS


def is_unit(text: str) -> bool:
    """Return whether a text is a unit and nothing else, as in a line of units below names."""
    if _is_unit(text) or text in _PLAIN or text in _SPELT:
        return True
    try:
        si_of(_small(text))
    except RefusedError:
        return False
    return True


def _small(text: str) -> str:
    """Return a unit that is written out, in small letters; symbols as they are."""
    return text.lower() if len(text) > 3 and text.isalpha() and not text[1:].isupper() else text

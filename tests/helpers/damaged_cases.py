"""Random damage to the shipped cases and to one of everything, for property tests."""

import copy
import math
import tomllib
from pathlib import Path

from hypothesis import strategies as st

from viscorod.casefile.shipped import shipped_cases

FILES = {**shipped_cases(), "everything": Path(__file__).parents[1] / "property" / "everything.toml"}
TEXTS = {name: path.read_text(encoding="utf-8") for name, path in FILES.items()}
CASES = {name: tomllib.loads(text) for name, text in TEXTS.items()}

NESTED: object = 1.0
for _ in range(60):
    NESTED = [{"a": NESTED}]

VALUES = st.sampled_from(
    [
        -1.0,
        0.0,
        -0.0,
        1,
        0.7,
        1e300,
        1e-300,
        -1e300,
        1e59,
        1e-59,
        -1e59,
        1e20,
        1e-20,
        math.nan,
        math.inf,
        -math.inf,
        10**400,
        True,
        False,
        "",
        "x",
        "beam.start",
        "rod.end",
        "straight",
        "\u0000\u2603'\"",
        "y" * 5000,
        [],
        {},
        [0.0, 0.0, 0.0],
        [1.0, 0.0],
        [1.0, 2.0, 3.0, 4.0],
        [math.nan] * 3,
        [1e200] * 6,
        [-1.0] * 6,
        [[1.0] * 6] * 6,
        ["ux", "ux"],
        [{}],
        {"kind": "ramp"},
        {"kind": "table", "times": [0.0, 0.0, 0.0], "values": [1.0, 2.0, 3.0]},
        {"shape": "circle", "radius": -1.0},
        "10 mm",
        "-3 MPa",
        "30 deg",
        "2 kg/m^3",
        "1e300 m",
        "10 mmm",
        "20 degC",
        ["1 mm", 2.0, "3 s"],
        NESTED,
    ]
)


def spots(node, path=()):
    """All places in nested dicts and lists, as paths."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in items:
        yield (*path, key)
        yield from spots(child, (*path, key))


def typo(key, data):
    """`key` with one character dropped, doubled, swapped or replaced (an empty key gets one)."""
    if not key:
        return "q"
    at = data.draw(st.integers(0, len(key) - 1))
    kind = data.draw(st.sampled_from(["drop", "double", "swap", "replace", "case"]))
    if kind == "drop":
        return key[:at] + key[at + 1 :]
    if kind == "double":
        return key[:at] + key[at] + key[at:]
    if kind == "swap":
        return key[:at] + key[at : at + 2][::-1] + key[at + 2 :]
    return key[:at] + (key[at].upper() if kind == "case" else "q") + key[at + 1 :]


def damage(case, data):
    """Change one place of the case in one of several ways."""
    path = data.draw(st.sampled_from(list(spots(case))))
    parent = case
    for key in path[:-1]:
        parent = parent[key]
    key, value = path[-1], parent[path[-1]]
    kind = data.draw(st.sampled_from(["delete", "rename", "replace", "negate", "length", "nest", "add"]))
    if kind == "delete":
        del parent[key]
    elif kind == "rename" and isinstance(parent, dict):
        parent[typo(key, data)] = parent.pop(key)
    elif kind == "negate" and isinstance(value, int | float) and not isinstance(value, bool):
        parent[key] = -value
    elif kind == "length" and isinstance(value, list) and value:
        parent[key] = data.draw(st.sampled_from([value[:-1], [*value, value[-1]]]))
    elif kind == "nest":
        parent[key] = data.draw(st.sampled_from([[value], {"a": value}, {"kind": value}]))
    elif kind == "add" and isinstance(parent, dict):
        parent[typo(key, data)] = copy.deepcopy(value)
    else:
        parent[key] = copy.deepcopy(data.draw(VALUES))


def toml(value):
    """A value as TOML text, all tables in line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return "nan" if math.isnan(value) else repr(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return '"' + "".join(c if c.isalnum() and c.isascii() else f"\\u{ord(c):04x}" for c in value) + '"'
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return "{" + ", ".join(f"{toml(key)} = {toml(item)}" for key, item in value.items()) + "}"

"""JSON Schema of the case file, from the classes that read it: for editors, and for the units of its numbers."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from functools import cache

from viscorod.casefile.case_reader import ANALYSES, ROD_KEYS
from viscorod.casefile.meanings import meanings, units_in
from viscorod.casefile.value_forms import NAME, TEXT, Form, Units, form_of, listed, of_kind, quantity
from viscorod.model.actions.event import EVENTS, Crossing
from viscorod.model.actions.initial_strain import InitialStrain
from viscorod.model.actions.initial_velocity import InitialVelocity
from viscorod.model.actions.load import LOADS
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_table import TIME_FUNCTIONS
from viscorod.model.bodies.body import BODIES, Body
from viscorod.model.connections.joint import JOINTS, Rigid
from viscorod.model.connections.rigid_attachment import Attachment
from viscorod.model.connections.spring import SPRINGS, Spring
from viscorod.model.connections.support import SUPPORTS, Support
from viscorod.model.connections.velocity_support import VelocitySupport
from viscorod.model.fields.definition import Definition
from viscorod.model.fields.values import NOT_GIVEN
from viscorod.model.materials.complex_moduli import ModulusTable
from viscorod.model.materials.material import DAMPINGS, KelvinVoigt, Material
from viscorod.model.rod import CENTRELINES, Rod
from viscorod.model.sections.composite import CompositeRegion
from viscorod.model.sections.section_profile import SECTIONS, Piece, Taper
from viscorod.model.sections.stiffness_section import MaxwellBranch

__all__ = ["GROUPS", "PARTS", "PYTHON_ONLY_KEYS", "REQUIRED", "case_schema", "forms"]

DRAFT = "http://json-schema.org/draft-07/schema#"
"""The draft that editors of TOML understand."""

GROUPS: dict[str, tuple[str, Mapping[str, type[Definition]], type[Definition] | None]] = {
    "damping": ("damping", DAMPINGS, KelvinVoigt),
    "section": ("sections", SECTIONS, None),
    "body": ("bodies", BODIES, Body),
    "support": ("supports", SUPPORTS, Support),
    "load": ("loads", LOADS, None),
    "joint": ("joints", JOINTS, None),
    "spring": ("springs", SPRINGS, Spring),
    "time": ("time", TIME_FUNCTIONS, None),
    "event": ("events", EVENTS, None),
    "rod": ("rods", CENTRELINES, None),
}
"""What comes in kinds: name of its parts, the kinds by their word, and the kind without a word."""

SINGLE: dict[str, type[Definition]] = {
    "material": Material,
    "damping.other": ModulusTable,
    "sections.piece": Piece,
    "sections.taper": Taper,
    "sections.region": CompositeRegion,
    "sections.branch": MaxwellBranch,
    "attachments": Attachment,
    "velocities": InitialVelocity,
    "strains": InitialStrain,
    **ANALYSES,
}
PYTHON_ONLY = {"function", "curve"}
"""Words of kinds that hold a Python function."""


def parts() -> dict[str, type[Definition]]:
    """The parts of a case file that have keys, with the kinds that are registered by now."""
    return SINGLE | {
        f"{part}.{word}": kind
        for part, kinds, _ in GROUPS.values()
        for word, kind in kinds.items()
        if word not in PYTHON_ONLY
    }


PARTS: dict[str, type[Definition]] = parts()
"""Every part of a case file that has keys: its class by its name. A rod has the keys ROD_KEYS beside these."""
PYTHON_ONLY_KEYS = {
    (InitialVelocity, "field"),
    (VelocitySupport, "motion"),
    *((Rigid, name) for name in ("stiffness", "damping", "rest", "motion")),
}
"""Keys that a case file cannot have: functions, and what a class inherits and refuses."""
REQUIRED = {(Material, "density")}
"""Required although their fields have defaults."""

FILE = {
    "title": "heading of reports and pictures",
    "materials": "materials by name",
    "sections": "sections by name",
    "rods": "rods by name",
    "bodies": "rigid bodies by name",
}


def forms() -> Form:
    """The schema as every reading of a case shares it: not to be changed."""
    return _forms(tuple(parts().items()))


@cache
def _forms(kinds: tuple[tuple[str, type[Definition]], ...]) -> Form:
    definitions: Form = {
        "quantity": {
            "type": "string",
            "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*\D",
            "description": 'a number with its unit, such as "10 mm"',
        }
    }
    standard = [kind for _, _, kind in GROUPS.values()]
    definitions |= {
        name: _rod(kind) if name.startswith("rods.") else _table(kind, kind in standard)
        for name, kind in kinds
    }
    for name, (part, known, _) in GROUPS.items():
        words = [word for word in known if word not in PYTHON_ONLY]
        definitions[name] = {"oneOf": [of_kind(f"{part}.{word}") for word in words]}
    properties: Form = {"title": TEXT | {"description": FILE["title"]}}
    for key, noun in (
        ("materials", "material"),
        ("sections", "section"),
        ("rods", "rod"),
        ("bodies", "body"),
    ):
        properties[key] = {
            "type": "object",
            "propertyNames": NAME,
            "additionalProperties": of_kind(noun),
            "description": FILE[key],
        }
    properties["rods"]["minProperties"] = 1
    for key in ("supports", "loads", "joints", "springs"):
        properties[key] = listed(of_kind(key.removesuffix("s")))
    for key in ("attachments", "velocities", "strains"):
        properties[key] = listed(of_kind(key))
    properties |= {key: of_kind(key) for key in ANALYSES}
    return {
        "$schema": DRAFT,
        "title": "Case file of viscorod",
        "description": 'SI units; a number with a unit may also be a text such as "10 mm".',
        "type": "object",
        "properties": properties,
        "required": ["rods"],
        "oneOf": [{"required": [key]} for key in ANALYSES],
        "additionalProperties": False,
        "definitions": definitions,
    }


def case_schema() -> Form:
    """The JSON Schema of a case file (draft 7): every key with its form, unit (``x-unit``), default and meaning."""
    return copy.deepcopy(forms())


def _table(kind: type[Definition], standard: bool = False) -> Form:
    """The form of the table that describes an object of the class; `standard` if its word may be left out."""
    tag = getattr(kind, "tag", None)
    known = meanings(kind)  # what the class inherits and does not document is not for its users
    keys = [
        name
        for name in kind.model_fields
        if name == tag or (name in known and (kind, name) not in PYTHON_ONLY_KEYS)
    ]
    required = [
        name
        for name in keys
        if (name == tag and not standard)
        or (name != tag and (kind.model_fields[name].is_required() or (kind, name) in REQUIRED))
    ]
    found: Form = {
        "type": "object",
        "properties": {name: _key(kind, name) for name in keys},
        "additionalProperties": False,
    }
    return found | ({"required": required} if required else {})


def _key(kind: type[Definition], name: str) -> Form:
    """The form of one key of a class, with meaning and default."""
    field = kind.model_fields[name]
    if name == getattr(kind, "tag", None):
        return {"const": field.default, "description": "tells the kind"}
    meaning = meanings(kind).get(name, "")
    form = dict(_by_quantity(kind, name) or form_of(field.metadata[0].func, _units(kind, meaning)))
    unit = form.get("x-unit")
    if meaning:
        form["description"] = meaning
    if "$ref" in form:  # other keywords beside a reference are ignored in draft 7
        form = {"allOf": [{"$ref": form.pop("$ref")}], **form}
    default = None if field.is_required() else field.default
    if default not in (None, (), {}) and default is not NOT_GIVEN:
        form["default"] = list(default) if isinstance(default, tuple) else default
    return form | ({"x-unit": unit} if unit else {})


def _units(kind: type[Definition], meaning: str) -> Units:
    """The documented units of a key; functions of time have that of what they describe."""
    units = units_in(meaning)
    if issubclass(kind, TimeFunction):
        if units == ("rad/s", "m/s"):  # speed of an angle or a length
            return ("*/s",)
        return units or ("*",)
    return units


def _by_quantity(kind: type[Definition], name: str) -> Form | None:
    """A crossed value has the unit of its quantity: the word's first letter tells positions from velocities."""
    if kind is not Crossing or name != "value":
        return None
    length, speed = units_in(meanings(kind)[name])
    words = form_of(kind.model_fields["quantity"].metadata[0].func, ())["enum"]
    units = {word: speed if word.startswith("v") else length for word in words}
    return quantity((length,)) | {"x-unit-by": ["quantity", units]}


def _rod(kind: type[Definition]) -> Form:
    """The form of a rod's table: keys of its centre line, section, material and mesh."""
    section = {"anyOf": [NAME, of_kind("section")]}
    special: Form = {
        "section": section | {"description": "the section of the whole rod"},
        "sections": listed(of_kind("sections.piece"), 1) | {"description": "sections one after the other"},
        "taper": {
            "allOf": [of_kind("sections.taper")],
            "description": "section that changes along the rod",
        },
        "material": {"anyOf": [NAME, of_kind("material")], "description": "of the sections"},
    }
    form = _table(kind)
    form["properties"] |= {key: special[key] if key in special else _key(Rod, key) for key in ROD_KEYS}
    form["oneOf"] = [{"required": [key]} for key in ("section", "sections", "taper")]
    return form

"""JSON Schema of the case file, from the classes that read it: for editors, and for the units of its numbers."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from functools import cache

from pydantic.fields import FieldInfo

from viscorod.casefile.analysis_tables import ANALYSES
from viscorod.casefile.case_reader import ROD_KEYS
from viscorod.model.actions.event import EVENTS
from viscorod.model.actions.initial_strain import InitialStrain
from viscorod.model.actions.initial_velocity import InitialVelocity
from viscorod.model.actions.load import LOADS
from viscorod.model.actions.rest_strain import RestStrain
from viscorod.model.actions.time_function_kinds import TIME_FUNCTIONS
from viscorod.model.bodies.body import BODIES, Body
from viscorod.model.connections.joint import JOINTS
from viscorod.model.connections.rigid_attachment import Attachment
from viscorod.model.connections.spring import SPRINGS, Spring
from viscorod.model.connections.support import SUPPORTS, Support
from viscorod.model.fields.definition import Definition
from viscorod.model.fields.forms import NAME, TEXT, Form, in_units, listed, of_kind
from viscorod.model.fields.metadata import accepted, meaning, units_of
from viscorod.model.materials.complex_moduli import ModulusTable
from viscorod.model.materials.material import DAMPINGS, KelvinVoigt, Material
from viscorod.model.materials.temperature_shift import SHIFTS
from viscorod.model.rod import CENTRELINES, Rod
from viscorod.model.sections.composite import CompositeRegion
from viscorod.model.sections.section_kinds import SECTIONS
from viscorod.model.sections.section_laws import SECTION_LAWS
from viscorod.model.sections.section_profile import Piece
from viscorod.model.sections.section_stations import Station, Stations
from viscorod.model.sections.stiffness_section import MaxwellBranch
from viscorod.model.sections.taper import Taper
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.settings.stages import Stage
from viscorod.solve.start import Start
from viscorod.solve.transient.integrators import INTEGRATORS

__all__ = ["GROUPS", "PARTS", "case_schema", "fields_of", "forms", "is_required"]

DRAFT = "http://json-schema.org/draft-07/schema#"
"""The draft that editors of TOML understand."""

GROUPS: dict[str, tuple[str, Mapping[str, type[Definition]], type[Definition] | None]] = {
    "damping": ("damping", DAMPINGS, KelvinVoigt),
    "shift": ("shifts", SHIFTS, None),
    "section": ("sections", SECTIONS, None),
    "law": ("laws", SECTION_LAWS, None),
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
    "sections.stations": Stations,
    "sections.station": Station,
    "sections.region": CompositeRegion,
    "sections.branch": MaxwellBranch,
    "attachments": Attachment,
    "velocities": InitialVelocity,
    "strains": InitialStrain,
    "rest_strains": RestStrain,
    "start": Start,
    "equilibrium.stage": Stage,
    **ANALYSES,
}


def fields_of(kind: type[Definition]) -> dict[str, FieldInfo]:
    """Return the fields of a class that a case file can fill: the word of the kind, and what has a form."""

    def fillable(name: str, field: FieldInfo) -> bool:
        found = accepted(field)
        return name == kind.tag or (name not in kind.unused and found is not None and found.form is not None)

    return {name: field for name, field in kind.model_fields.items() if fillable(name, field)}


def is_required(field: FieldInfo) -> bool:
    """Say whether a key must be given."""
    return field.is_required()


def _in_files(kinds: Mapping[str, type[Definition]]) -> dict[str, type[Definition]]:
    """Return the kinds that a case file can describe: not those that need a Python function."""
    return {word: kind for word, kind in kinds.items() if _is_in_files(kind)}


@cache  # every case with a unit asks again which kinds there are
def _is_in_files(kind: type[Definition]) -> bool:
    fields = fields_of(kind)
    return all(name in fields for name, field in kind.model_fields.items() if field.is_required())


def parts() -> dict[str, type[Definition]]:
    """Return the parts of a case file that have keys, with the kinds that are registered by now."""
    return SINGLE | {
        f"{part}.{word}": kind
        for part, kinds, _ in GROUPS.values()
        for word, kind in _in_files(kinds).items()
    }


PARTS: dict[str, type[Definition]] = parts()
"""Every part of a case file that has keys: its class by its name. A rod has the keys ROD_KEYS beside these."""

FILE = {
    "title": "heading of reports and pictures",
    "materials": "materials by name",
    "sections": "sections by name",
    "rods": "rods by name",
    "bodies": "rigid bodies by name",
}


def forms() -> Form:
    """Return the schema as every reading of a case shares it: not to be changed."""
    return _forms(tuple(parts().items()), (*INTEGRATORS, *FORMULATIONS))


@cache
def _forms(kinds: tuple[tuple[str, type[Definition]], ...], methods: tuple[object, ...]) -> Form:
    """Return the schema with what is registered; of ``methods`` the fields know, here they only key the cache."""
    del methods
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
        definitions[name] = {"oneOf": [of_kind(f"{part}.{word}") for word in _in_files(known)]}
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
    for key in ("attachments", "velocities", "strains", "rest_strains"):
        properties[key] = listed(of_kind(key))
    properties |= {key: of_kind(key) for key in ANALYSES}
    return {
        "$schema": DRAFT,
        "title": "Case file of viscorod",
        "description": 'SI units; a number with a unit may also be a text such as "10 mm".',
        "type": "object",
        "properties": properties,
        "anyOf": [{"required": ["rods"]}, {"required": ["bodies"]}],
        "oneOf": [{"required": [key]} for key in ANALYSES],
        "additionalProperties": False,
        "definitions": definitions,
    }


def case_schema() -> Form:
    """Return the JSON Schema of a case file (draft 7): each key with form, unit (``x-unit``), default and meaning."""
    schema = copy.deepcopy(forms())
    for definition in schema["definitions"].values():
        definition.pop("x-former", None)  # read with a warning, not to be written any more
    return schema


def _table(kind: type[Definition], standard: bool = False) -> Form:
    """Return the form of the table that describes an object; `standard` if the word of its kind may be left out."""
    fields = fields_of(kind)
    required = [
        name for name, field in fields.items() if (not standard if name == kind.tag else is_required(field))
    ]
    found: Form = {
        "type": "object",
        "properties": {name: _key(kind, name) for name in fields},
        "additionalProperties": False,
    }
    found |= {"x-former": kind.renamed} if kind.renamed else {}  # for the conversion of units
    return found | ({"required": required} if required else {})


def _key(kind: type[Definition], name: str) -> Form:
    """Return the form of one key of a class, with meaning and default."""
    field = kind.model_fields[name]
    if name == kind.tag:
        return {"const": field.default, "description": "the kind"}
    accepts = accepted(field)
    assert accepts is not None
    form: Form = in_units(accepts.form, units_of(field))
    if meaning(field):
        form["description"] = f"{meaning(field)}."
    if "$ref" in form:  # other keywords beside a reference are ignored in draft 7
        form = {"allOf": [{"$ref": form.pop("$ref")}], **form}
    default = None if field.is_required() else field.default
    if default not in (None, (), {}) and str(default) != "nan":  # NaN marks what is not given
        form["default"] = list(default) if isinstance(default, tuple) else default
    return form


def _rod(kind: type[Definition]) -> Form:
    """Return the form of a rod's table: keys of its centre line, section, material and mesh."""
    section = {"anyOf": [NAME, of_kind("section")]}
    special: Form = {
        "section": section | {"description": "the section of the whole rod"},
        "sections": {
            "anyOf": [listed(of_kind("sections.piece"), 1), of_kind("sections.stations")],
            "description": "sections one after the other, or at stations",
        },
        "taper": {
            "allOf": [of_kind("sections.taper")],
            "description": "section that changes along the rod",
        },
    }
    form = _table(kind)
    form["properties"] |= {key: special[key] if key in special else _key(Rod, key) for key in ROD_KEYS}
    form["oneOf"] = [{"required": [key]} for key in ("section", "sections", "taper")]
    return form

"""The JSON Schema of the case file: shipped cases fit, wrong keys and values do not, every documented key is there."""

import copy
import json
import sys
import tomllib
from pathlib import Path

import jsonschema
import pytest
from typer.testing import CliRunner

from helpers.damaged_cases import CASES, FILES, spots
from viscorod.casefile.json_schema import case_schema
from viscorod.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"
SCHEMA = case_schema()
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)


def test_it_is_a_schema():
    VALIDATOR.check_schema(SCHEMA)
    json.dumps(SCHEMA, allow_nan=False)


@pytest.mark.parametrize("name", CASES)
def test_shipped_cases_fit(name):
    VALIDATOR.validate(tomllib.loads(FILES[name].read_text(encoding="utf-8")))


def entries(content):
    """Entries of a case one by one, each as the table that has it alone: ``(word, name or number, {word: entry})``."""
    for word, part in content.items():
        if isinstance(part, dict) and word in NAMED:
            yield from ((word, name, {word: {name: entry}}) for name, entry in part.items())
        elif isinstance(part, list):
            yield from ((word, number, {word: [entry]}) for number, entry in enumerate(part))
        else:
            yield word, None, {word: part}


NAMED = ("materials", "sections", "rods", "bodies")
"""Tables whose keys are names of the user."""
ENTRY = jsonschema.Draft7Validator(
    {key: value for key, value in SCHEMA.items() if key not in ("anyOf", "oneOf")}
)
"""What each table of a case has to fit, whichever others are there."""


@pytest.mark.parametrize("name", CASES)
def test_wrong_keys_do_not_fit(name):
    """A key that nothing knows, in every table whose keys are not names of the user.

    Tables fit one by one, without what a case must have: each is damaged alone.
    """
    assert not VALIDATOR.is_valid(CASES[name] | {"nothing_reads_this": 1.0})
    for word, entry, alone in entries(CASES[name]):
        assert ENTRY.is_valid(alone), (word, entry)
        for path in spots(alone):
            content = copy.deepcopy(alone)
            table = content
            for key in path:
                table = table[key]
            if isinstance(table, dict) and path not in {(one,) for one in NAMED} and path[-1:] != ("points",):
                table["nothing_reads_this"] = 1.0
                assert not ENTRY.is_valid(content), (entry, path)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("rods", "beam", "shape"), "strait"),
        (("simulate", "duration"), -1.0),
        (("simulate", "duration"), "x"),
        (("simulate", "integrator"), "euler"),
        (("rods", "beam", "start"), [0.0, 0.0]),
        (("rods", "beam", "elements"), 0.5),
        (("supports", 0, "kind"), "glue"),
    ],
)
def test_wrong_values_do_not_fit(path, value):
    content = copy.deepcopy(CASES["cantilever_swing"])
    VALIDATOR.validate(content)
    rod = next(iter(content["rods"]))
    parent = content
    for key in path[:-1]:
        parent = parent[rod if key == "beam" else key]
    parent[path[-1]] = value
    assert not VALIDATOR.is_valid(content)


def test_quantities_fit_where_there_is_a_unit():
    content = copy.deepcopy(CASES["cantilever_swing"])
    content["simulate"]["duration"] = "500 ms"
    VALIDATOR.validate(content)
    content["simulate"]["tolerance"] = "1 mm"
    assert not VALIDATOR.is_valid(content)


def test_every_documented_key_is_there_with_meaning_and_default(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(DOCS), *sys.path])
    import case_keys

    names = {"materials": "material"}
    for part in case_keys.PARTS:
        properties = SCHEMA["definitions"][names.get(part, part)]["properties"]
        rows = case_keys.part_rows(part)
        documented = {key for key, *_ in rows}
        own = set(properties) - (set(case_keys.schema.ROD_KEYS) if part.startswith("rods.") else set())
        assert own == documented, part
        for key, _, default, meaning in rows:
            form = properties[key]
            assert form["description"].rstrip(".") == meaning, (part, key)
            if default not in ("required", "\N{EN DASH}") and "const" not in form:
                assert "default" in form, (part, key)


def test_the_command_writes_it(tmp_path):
    path = tmp_path / "case.schema.json"
    result = CliRunner().invoke(app, ["schema", "-o", str(path)])
    assert result.exit_code == 0, result.output
    assert json.loads(path.read_text(encoding="utf-8")) == SCHEMA
    assert CliRunner().invoke(app, ["schema", "-o", str(path), "--quiet"]).output == ""
    printed = CliRunner().invoke(app, ["schema"])
    assert json.loads(printed.output) == SCHEMA


def test_the_documentation_has_the_present_one():
    shipped = DOCS / "reference" / "case.schema.json"
    assert json.loads(shipped.read_text(encoding="utf-8")) == SCHEMA, "viscorod schema -o " + shipped.name

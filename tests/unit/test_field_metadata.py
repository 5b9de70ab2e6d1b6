"""What stands beside the type of a field serves docstrings, schema and units: it does not depend on docstrings."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from viscorod.casefile import json_schema
from viscorod.casefile.json_schema import PARTS, case_schema, fields_of
from viscorod.model.fields.definition import Definition
from viscorod.model.fields.forms import in_units, quantity
from viscorod.model.fields.metadata import Key, accepted, meaning, units_of
from viscorod.model.fields.values import OptionalPositive, Vector
from viscorod.model.rod import Rod

CASE = Path(__file__).parents[2] / "examples" / "cantilever_swing.toml"


class Box(Definition):
    """A box."""

    sides: Vector = Key("along x, {}; y and z", "m")
    mass: OptionalPositive = Key("", "kg", default=None, kw_only=True)


def kinds(base=Definition):
    """Every class of the package that describes something."""
    for kind in base.__subclasses__():
        if kind.__module__.startswith("viscorod."):
            yield kind
        yield from kinds(kind)


def units_used(form):
    """The places of the units that the numbers of a form have."""
    if isinstance(form, list):
        return set().union(*map(units_used, form))
    if not isinstance(form, dict):
        return set()
    own = {form["x-unit"]} if isinstance(form.get("x-unit"), int) else set()
    return own.union(*map(units_used, form.values()))


def test_a_field_is_one_line():
    """Its text and unit make the docstring, the form of its values and the advice where it is missing."""
    assert Box.__doc__ == ("A box.\n\nArgs:\n    sides: along x, m; y and z.\n    mass: kg; by name only.")
    assert set(fields_of(Box)) == {"sides", "mass"}
    with pytest.raises(ValueError, match=r"add sides \(3 numbers, m\)"):
        Box()


def test_a_number_with_a_unit_may_be_a_text():
    text = {"$ref": "#/definitions/quantity"}
    assert in_units(quantity(), ()) == in_units(quantity(), ("1",)) == {"type": "number"}
    assert in_units(quantity(), ("m",)) == {"anyOf": [{"type": "number"}, text], "x-unit": "m"}
    assert in_units([quantity(unit=1)], ("m", "1")) == [{"type": "number"}]


def test_every_field_says_what_it_accepts():
    for kind in {*kinds()}:
        for name, field in kind.model_fields.items():
            if name != kind.tag and not kind.__name__.startswith("_"):
                assert accepted(field) is not None, f"{kind.__name__}.{name}"


@pytest.mark.parametrize("part", PARTS)
def test_every_key_has_a_meaning_and_the_units_of_its_numbers(part):
    for name, field in fields_of(PARTS[part]).items():
        if name == PARTS[part].tag:
            continue
        assert meaning(field), f"{part}.{name}"
        assert f"    {name}: {meaning(field)}"[:40] in PARTS[part].__doc__
        units = units_of(field)
        used = {place % len(units) for place in units_used(accepted(field).form)} if units else set()
        assert used == {*range(len(units))} or "x-unit-by" in accepted(field).form, f"{part}.{name}"


def test_docstrings_may_be_reworded(monkeypatch):
    schema = case_schema()
    for kind in (Rod, *PARTS.values()):
        monkeypatch.setattr(kind, "__doc__", "Something else.\n\nArgs:\n    radius: in inches.")
    json_schema._forms.cache_clear()
    assert case_schema() == schema


@pytest.mark.slow
def test_units_are_known_without_docstrings(tmp_path):
    """Python leaves all docstrings out with -OO."""
    text = CASE.read_text(encoding="utf-8").replace("width = 0.01 ", 'width = "10 mm" ')
    case = tmp_path / "case.toml"
    case.write_text(text, encoding="utf-8")
    command = [sys.executable, "-OO", "-m", "viscorod", "check", str(case)]
    environment = os.environ | {
        "NUMBA_DISABLE_JIT": "1"
    }  # or all kernels are compiled without docstrings too
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "10 mm  0.01 m" in run.stdout

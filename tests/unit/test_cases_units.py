"""Quantities with units in case files: exact conversion, dimensions of every key, messages, and what stays a text."""

import math

import pytest

import viscorod as vr
from viscorod.analyses.sweeps.member_work import member_content
from viscorod.casefile.case import case_from_dict, load_case, parse_case
from viscorod.casefile.json_schema import case_schema
from viscorod.casefile.unit_conversion import converted
from viscorod.cli.key_values import column_of
from viscorod.errors import InputError
from viscorod.units import si_value

PLAIN = """
[materials.rubber]
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000.0
damping = { kind = "kelvin_voigt", shear_time = 0.01, bulk_time = 0.02 }

[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.5, 0.0, 0.0]
section = { shape = "circle", radius = 0.01 }
material = "rubber"
twist = 0.5235987755982989

[[supports]]
kind = "clamp"
at = "beam.start"
motion.rz = { kind = "sine", frequency = 2.0, amplitude = 0.1 }
motion.ux = { kind = "spin_up", speed = 0.02, duration = 1.0 }

[[loads]]
kind = "moment"
at = "beam.end"
value = [0.0, 0.003, 0.0]

[[springs]]
at = "beam.end"
stiffness = { ux = 2000.0, rz = 5.0 }

[[strains]]
rod = "beam"
value = [0.0, 0.0, 0.01, 0.0, 0.2, 0.0]

[simulate]
duration = 2.0
events = [{ kind = "crossing", at = "beam.end", quantity = "vx", value = 0.5 }]
"""  # fmt: skip

WITH_UNITS = """
[materials.rubber]
youngs_modulus = "1 MPa"
poissons_ratio = 0.3
density = "1 g/cm^3"
damping = { kind = "kelvin_voigt", shear_time = "10 ms", bulk_time = 0.02 }

[rods.beam]
shape = "straight"
start = [0, "0 mm", 0.0]
end = ["50 cm", 0.0, "0 m"]
section = { shape = "circle", radius = "10mm" }
material = "rubber"
twist = "30 deg"

[[supports]]
kind = "clamp"
at = "beam.start"
motion.rz = { kind = "sine", frequency = "120 rpm", amplitude = "100 mrad" }
motion.ux = { kind = "spin_up", speed = "20 mm/s", duration = "1000 ms" }

[[loads]]
kind = "moment"
at = "beam.end"
value = [0.0, "3 N mm", 0.0]

[[springs]]
at = "beam.end"
stiffness = { ux = "2 N/mm", rz = "5 N m" }

[[strains]]
rod = "beam"
value = [0.0, 0.0, 0.01, 0.0, "0.2 1/m", 0.0]

[simulate]
duration = "2 s"
events = [{ kind = "crossing", at = "beam.end", quantity = "vx", value = "500 mm/s" }]
"""  # fmt: skip


def test_a_case_with_units_is_the_case_without():
    plain, given = parse_case(PLAIN), parse_case(WITH_UNITS)
    assert given.to_dict() == plain.to_dict()
    assert plain.conversions == ()
    found = {item.where: (item.given, item.value, item.unit) for item in given.conversions}
    assert len(found) == 18
    assert found["materials.rubber.youngs_modulus"] == ("1 MPa", 1e6, "Pa")
    assert found["rods.beam.end[0]"] == ("50 cm", 0.5, "m")
    assert found["supports[0].motion.rz.frequency"] == ("120 rpm", 2.0, "Hz")
    assert found["supports[0].motion.ux.speed"] == ("20 mm/s", 0.02, "m/s")
    assert found["springs[0].stiffness.rz"] == ("5 N m", 5.0, "N m/rad")
    assert found["simulate.events[0].value"] == ("500 mm/s", 0.5, "m/s")


# factors of the NIST Guide to the SI (SP 811), appendix B, and of the definitions
@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 mm", "m", 0.01),
        ("0.1 mm", "m", 0.0001),
        ("1 in", "m", 0.0254),
        ("210 GPa", "Pa", 210e9),
        ("7.85 g/cm3", "kg/m^3", 7850.0),
        ("2 N/mm²", "Pa", 2e6),
        ("1 lbf", "N", 4.4482216152605),
        ("1 psi", "Pa", 6894.757293168),
        ("180 deg", "rad", math.pi),
        ("90°", "rad", math.pi / 2.0),
        ("60 rpm", "rad/s", 2.0 * math.pi),
        ("60 rpm", "Hz", 1.0),
        ("10 deg/m", "1/m", math.radians(10.0)),
        ("1 N m/deg", "N m/rad", 180.0 / math.pi),
        ("36 km/h", "m/s", 10.0),
        ("5 N/(m s)", "N/m/s", 5.0),
        ("-3e-3 kN", "N", -3.0),
        ("3 Nmm", "N m", 3e-3),
        ("2 kNm2", "N m^2", 2000.0),
        ("2 Nm²", "N m^2", 2.0),
        ("4 N-m", "N m", 4.0),
        ("4 kg.m", "kg m", 4.0),
        ("6 N/Nmm", "1/m", 6e3),
        ("2 g", "m/s^2", 2.0 * 9.80665),
        ("2 g_0", "m/s^2", 2.0 * 9.80665),
        ("2 g", "kg", 2e-3),
        ("10 mil", "m", 2.54e-4),
        ("3600 mil", "rad", 3600.0 * math.pi / 3200.0),
        ("0.5 in.", "m", 0.0127),
        ("9.81 m s-2", "m/s^2", 9.81),
        ("60 rev/min", "rad/s", 2.0 * math.pi),
        ("60 U/min", "Hz", 1.0),
        ("120 cpm", "Hz", 2.0),
        ("6.5e-6/degF", "1/K", 1.17e-5),
        ("12e-6/°C", "1/K", 12e-6),
        ("1 pcf", "kg/m^3", 0.45359237 / 0.3048**3),
        ("1 psf", "Pa", 4.4482216152605 / 0.3048**2),
        ("1 plf", "N/m", 4.4482216152605 / 0.3048),
        ("1 pli", "N/m", 4.4482216152605 / 0.0254),
        ("1 Msi", "Pa", 6894.757293168e6),
        ("1 kp", "N", 9.80665),
    ],
)
def test_values(text, unit, value):
    assert si_value(text, unit, "key") == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "message"),
    [
        ("10 mmm", "m", "there is no unit 'mmm'; did you mean mm"),
        ("1 mpa", "Pa", "did you mean MPa"),
        ("10 mm", "Pa", "this is a length, key needs a pressure"),
        ("1 N", "N m", "this is a force, key needs a moment"),
        ("3 kg/s", "m", r"this is a quantity in kg s\^-1, key needs a length"),
        ("3 Hz", "rad/s", "this is a frequency, key needs an angular velocity; give rad/s"),
        ("20 degC", "m", "counted from an offset"),
        ("20 °C", "K", "counted from an offset; give a difference, in K"),
        ("20 °C", "1", "key has no unit; give degrees C as a plain number"),
        ("293 K", "1", "key has no unit; give degrees C as a plain number"),
        ("10 deg", "1", "key has no unit"),
        ("5 %", "m", "a plain number, key needs a length"),
        ("10", "m", "no unit; give 10 without quotes"),
        ("5 N/m s", "N/m", "two ways"),
        ("1 m**9**9", "m", "cannot be read"),
        ("1 m^99999999", "m", "cannot be read"),
        ("1 __import__('os')", "m", "cannot be read"),
        ("1e999 m", "m", "larger"),
        ("1e-999 m", "m", "smaller"),
        ("1e99999 m", "m", "cannot be read|no number"),
        ("1 " + "m " * 100, "m", "longer"),
        ("1 m/", "m", "cannot be read"),
        ("3 dB", "m", "cannot be read"),
        ("2 lb-ft", "N m", "lb is a mass; for its weight, a force, give 2 lbf-ft"),
        ("2.5e-4 lb s^2/in^4", "kg/m^3", r"for its weight, a force, give 2.5e-4 lbf s\^2/in\^4"),
        ("5 kg", "N", "kg is a mass; for its weight, a force, give 5 kgf"),
        ("5 kg", "m", "give a number in m"),
        ("1/2 in", "m", "cannot be read"),
    ],
)
def test_refusals(text, unit, message):
    with pytest.raises(InputError, match=message):
        si_value(text, unit, "key")


def test_all_that_is_wrong_is_told_once_with_its_key():
    wrong = WITH_UNITS.replace('"1 MPa"', '"10 mm"').replace('"3 N mm"', '"3 Nmx"').replace("0.3", '"30 %"')
    with pytest.raises(InputError) as caught:
        parse_case(wrong)
    problems = {problem.where: problem for problem in caught.value.problems}
    assert set(problems) == {
        "materials.rubber.youngs_modulus",
        "materials.rubber.poissons_ratio",
        "loads[0].value[1]",
    }
    assert len(caught.value.problems) == 3
    assert "this is a length, youngs_modulus needs a pressure" in str(caught.value)


def test_a_wrong_unit_is_all_that_is_told():
    """What is left without the part that was refused, here a model without rods, is no fault of its own."""
    with pytest.raises(InputError) as caught:
        parse_case(PLAIN.replace("youngs_modulus = 1e6", 'youngs_modulus = "1 mm"'))
    assert [problem.where for problem in caught.value.problems] == ["materials.rubber.youngs_modulus"]


def test_texts_stay_texts():
    content = {
        "title": "10 mm rod",
        "rods": {"b": {"shape": "straight", "material": "3 mm"}},
        "nobody": {"knows": "5 mm"},
        "loads": [{"kind": "force", "at": "2 mm"}],
        "materials": {"m": {"damping": {"kind": "complex_moduli", "file": "10 Hz.csv"}}},
    }
    plain, found, problems = converted(content)
    assert plain == content
    assert not found
    assert not problems


def leaves(form, definitions, path, seen):
    """All forms of plain numbers with their units: (path, unit)."""
    if "$ref" in form:
        name = form["$ref"].rsplit("/", 1)[1]
        if name == "quantity" or name in seen:
            return
        yield from leaves(definitions[name], definitions, path, {*seen, name})
        return
    if "x-unit" in form:
        yield path, form["x-unit"]
    elif form.get("type") == "number":
        yield path, "1"
    for key in ("allOf", "anyOf", "oneOf"):
        for inner in form.get(key, ()):
            if inner.get("type") != "number":
                yield from leaves(inner, definitions, path, seen)
    for key, inner in form.get("properties", {}).items():
        yield from leaves(inner, definitions, f"{path}.{key}", seen)
    items = form.get("items", [])
    for inner in items if isinstance(items, list) else [items]:
        yield from leaves(inner, definitions, path, seen)


def test_former_names_of_keys_take_units_too():
    velocity = '[[velocities]]\nrod = "beam"\nangular = [0, 0, 1.0]\nKEY = ["20 mm", 0, 0]\n\n'
    text = PLAIN.replace("[simulate]", f"{velocity}[simulate]")
    present = parse_case(text.replace("KEY", "point"))
    assert present.description.velocities[0].point == (0.02, 0.0, 0.0)
    with pytest.warns(DeprecationWarning, match="about is now point"):
        former = parse_case(text.replace("KEY", "about"))
    assert former.description.velocities == present.description.velocities
    assert len(former.conversions) == len(present.conversions) == 1


@pytest.mark.parametrize("name", sorted(case_schema()["definitions"]))
def test_every_number_knows_its_dimension(name):
    """A quantity in the documented unit is taken as it is; candelas are refused, with the name of the key."""
    definitions = case_schema()["definitions"]
    for path, unit in leaves(definitions[name], definitions, name, {name}):
        key = path.rpartition(".")[2]
        with pytest.raises(InputError, match=key):
            si_value("3 cd", unit.replace("*", "m"), key)
        if unit != "1":
            text = unit.replace("*", "m")
            assert si_value(f"3 {text}", text, key) == 3.0


def test_units_in_a_file_and_in_a_sweep(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(WITH_UNITS, encoding="utf-8")
    case = load_case(path)
    content = {**case.content, "simulate": {"duration": "500 ms"}}
    assert case_from_dict(content, path).settings.duration == 0.5


def test_members_of_a_sweep_may_be_quantities():
    case = parse_case(WITH_UNITS)
    key, column = column_of('rods.beam.section.radius="5 mm",0.006')
    assert column == ["5 mm", 0.006]
    contents, notes = zip(
        *(member_content(case.content, case.source, {key: value}, True) for value in column), strict=True
    )
    radii = [case_from_dict(content).description.rods["beam"].section_at(0.0).radius for content in contents]
    assert radii == [0.005, 0.006]
    assert notes == 2 * ("output_interval = 0.01 s, a 200th of the duration: the case gives none",)
    with pytest.raises(InputError, match=r"rods\.beam\.section\.radius: '5 kg': this is a mass"):
        vr.sweep(case, {key: ["5 mm", "5 kg"]})


@pytest.mark.parametrize(
    ("shared", "key"),
    [(True, "sections.round.radius"), (False, "rods.beam.section.radius")],
)
def test_a_refused_quantity_is_the_only_thing_told(shared, key):
    """A section that cannot be read leaves no rod; that is no mistake of its own."""
    text = PLAIN.replace("radius = 0.01", 'radius = "5 kg"')
    if shared:
        inside = '{ shape = "circle", radius = "5 kg" }'
        text = text.replace(inside, '"round"') + f"\n[sections]\nround = {inside}\n"
    with pytest.raises(InputError) as caught:
        parse_case(text)
    assert [problem.where for problem in caught.value.problems] == [key]

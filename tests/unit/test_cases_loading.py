"""Case files: what they mean, that they come back unchanged, and what is told when they are wrong."""

import math
import tomllib

import pytest

from viscorod.casefile.case import Case, case_from_dict, load_case, parse_case
from viscorod.casefile.shipped import shipped_case, shipped_cases
from viscorod.errors import InputError
from viscorod.model.actions.time_function import Ramp
from viscorod.model.bodies.body import Body
from viscorod.model.connections.place import Place
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.rod import Rod
from viscorod.model.sections.section_profile import Piecewise, Taper
from viscorod.model.sections.section_shapes import Circle, Rectangle
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import EquilibriumSettings

GOOD = """
[materials.rubber]
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000

[sections.strip]
shape = "rectangle"
width = 0.01
height = 0.02

[sections.wire]
shape = "circle"
radius = 0.01

[rods.beam]
shape = "straight"
start = [0, 0, 0]
end = [1, 0, 0]
section = "strip"
material = "rubber"

[[supports]]
kind = "clamp"
at = "beam.start"

[[loads]]
kind = "force"
at = "beam.end"
value = [0, 1, 0]

[equilibrium]
"""


def changed(*replacements):
    text = GOOD
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def problems(text):
    with pytest.raises(InputError) as caught:
        parse_case(text)
    return {problem.where: str(problem) for problem in caught.value.problems}


@pytest.mark.parametrize("name", shipped_cases())
def test_shipped_cases_load_name_their_source_and_come_back(name):
    path = shipped_cases()[name]
    case = load_case(path)
    assert case.title
    assert "# Source: " in path.read_text(encoding="utf-8")
    again = case_from_dict(case.to_dict())
    assert again.to_dict() == case.to_dict()
    assert again.description.rods == case.description.rods
    assert again.settings == case.settings


def test_the_shipped_cases():
    assert set(shipped_cases()) >= {
        "bend_45",
        "cantilever_swing",
        "flying_rod",
        "helix_spring",
        "hinged_beam",
        "prestressed_bridge",
        "right_angle_frame",
        "spinning_up_arm",
    }
    assert shipped_case("bend_45").name == "bend_45.toml"
    with pytest.raises(InputError, match="did you mean 'bend_45'"):
        shipped_case("bend45")


def test_a_file_says_the_same_as_the_api():
    case = load_case(shipped_case("cantilever_swing"))
    rubber = Material(1e6, 0.3, 1000.0, damping=KelvinVoigt(0.02, 0.02))
    section = Rectangle(0.01, 0.01)
    beam = Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=rubber, elements=2, order=5)
    model = ModelDescription()
    model.add("beam", beam)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    assert case.description.to_dict() == model.to_dict()
    assert case.settings == SimulateSettings(10.0)
    assert case.kind == "simulate"
    assert case.model(ModelDescription).to_dict() == model.to_dict()


def test_the_45_degree_bend_ends_where_it_should():
    rod = load_case(shipped_case("bend_45")).description.rods["bend"]
    half = math.sqrt(0.5)
    assert rod.frames([rod.length])[0][0] == pytest.approx([100 * (1 - half), 100 * half, 0])
    assert rod.matrices_at(0.0)[0][5, 5] == pytest.approx(5e6 / 6)


def test_the_frame_of_two_rods_shares_a_node():
    model = load_case(shipped_case("right_angle_frame")).description
    assert model.nodes() == [(Place("arm", 10.0), Place("leg", 0.0))]
    assert model.loads[0].factor(0.5) == 0.5


def test_the_spin_up_moves_the_root():
    (support,) = load_case(shipped_case("spinning_up_arm")).description.resolved_supports()
    assert support.fixed == ("ux", "uy", "uz", "rx", "ry")
    assert support.motion["rz"].value(20.0) == pytest.approx(75.0)


def test_title_is_the_name_of_the_file_by_default(tmp_path):
    path = tmp_path / "my_case.toml"
    path.write_text(GOOD, encoding="utf-8")
    case = load_case(path)
    assert isinstance(case, Case)
    assert case.title == "my_case"
    assert case.source == path
    assert case.kind == "equilibrium"
    assert case.settings == EquilibriumSettings()


def test_a_byte_order_mark_is_no_content(tmp_path):
    path = tmp_path / "case.toml"
    path.write_bytes(b"\xef\xbb\xbf" + shipped_case("cantilever_swing").read_bytes())
    assert load_case(path).title == load_case(shipped_case("cantilever_swing")).title


def test_sections_and_materials_by_name_or_in_place():
    named = parse_case(GOOD).description
    inline = parse_case(
        changed(
            ('section = "strip"', 'section = { shape = "rectangle", width = 0.01, height = 0.02 }'),
            (
                'material = "rubber"',
                "material = { youngs_modulus = 1e6, poissons_ratio = 0.3, density = 1000 }",
            ),
        )
    ).description
    assert inline.rods == named.rods


def test_pieces_and_tapers():
    pieces = (
        '[{ until = 0.4, section = "strip" }, { until = 1, section = { shape = "circle", radius = 0.02 } }]'
    )
    rod = parse_case(changed(('section = "strip"', f"sections = {pieces}"))).description.rods["beam"]
    assert rod.section == Piecewise([(0.4, Rectangle(0.01, 0.02)), (1.0, Circle(0.02))])
    taper = 'taper = { start = "wire", end = { shape = "circle", radius = 0.02 } }'
    rod = parse_case(changed(('section = "strip"', taper))).description.rods["beam"]
    assert rod.section == Taper(Circle(0.01), Circle(0.02))


def test_functions_of_time():
    text = changed(
        (
            "value = [0, 1, 0]",
            'value = [0, 1, 0]\ntime = { kind = "ramp", start = 0, end = 1 }\nfollowing = true',
        ),
        ('kind = "clamp"', 'kind = "clamp"\nmotion = { ux = 0.1, rz = { kind = "sine", frequency = 2 } }'),
    )
    model = parse_case(text).description
    assert model.loads[0].time == Ramp(0.0, 1.0)
    assert model.loads[0].following
    assert model.supports[0].motion["ux"].value(9.0) == 0.1


@pytest.mark.parametrize(
    ("old", "new", "where", "text"),
    [
        ("density = 1000", "density = -1", "materials.rubber.density", "give a number > 0"),
        ("density = 1000", "density = nan", "materials.rubber.density", "finite"),
        ("density = 1000", "density = true", "materials.rubber.density", "true: a number is needed"),
        ("density = 1000", 'density = "x"', "materials.rubber.density", "'x': a number is needed"),
        ("density = 1000", "density = 1979-05-27", "materials.rubber.density", "a number is needed"),
        (
            "poissons_ratio = 0.3",
            "poissons_ratio = 0.6",
            "materials.rubber.poissons_ratio",
            "> -1 and <= 0.5",
        ),
        (
            "poissons_ratio = 0.3",
            "poisson_ratio = 0.3",
            "materials.rubber.poisson_ratio",
            "mean poissons_ratio",
        ),
        ("width = 0.01", "widht = 0.01", "sections.strip.widht", "did you mean width"),
        ('"rectangle"', '"rectangel"', "sections.strip.shape", "did you mean 'rectangle'"),
        ('"rectangle"', "3", "sections.strip.shape", "give one of 'circle'"),
        ('shape = "rectangle"', "", "sections.strip.shape", "missing"),
        ('"straight"', '"strait"', "rods.beam.shape", "did you mean 'straight'"),
        ('shape = "straight"', "", "rods.beam.shape", "missing"),
        ('"straight"', '"curve"', "rods.beam.function", "missing"),
        ("end = [1, 0, 0]", "end = [0, 0, 0]", "rods.beam", "length 0"),
        ("end = [1, 0, 0]", "end = [1, 0]", "rods.beam.end", "2 were given"),
        ("end = [1, 0, 0]", "ende = [1, 0, 0]", "rods.beam.ende", "did you mean end"),
        ("end = [1, 0, 0]", 'end = [1, "0", 0]', "rods.beam.end[1]", "number"),
        ('section = "strip"', 'section = "stripe"', "rods.beam.section", "did you mean 'strip'"),
        ('section = "strip"', 'secton = "strip"', "rods.beam.secton", "did you mean section"),
        ('section = "strip"', "", "rods.beam.section", "missing"),
        ('section = "strip"', "section = 3", "rods.beam.section", "table"),
        ('section = "strip"', 'section = "strip"\ntaper = {}', "rods.beam.taper", "one description"),
        ('section = "strip"', "sections = 3", "rods.beam.sections", "list of pieces"),
        ('section = "strip"', "sections = []", "rods.beam.sections", "at least one"),
        (
            'section = "strip"',
            'sections = [{ until = 0.5, section = "strip" }]',
            "rods.beam.sections[0].until",
            "until = 1",
        ),
        (
            'section = "strip"',
            'sections = [{ until = 0.5, section = "x" }]',
            "rods.beam.sections[0].section",
            "no section",
        ),
        ('section = "strip"', 'taper = { start = "strip", end = "wire" }', "rods.beam.taper", "same shape"),
        ('section = "strip"', 'taper = { start = "strip", end = "x" }', "rods.beam.taper.end", "no section"),
        ('material = "rubber"', 'material = "ruber"', "rods.beam.material", "did you mean 'rubber'"),
        ('material = "rubber"', "", "rods.beam.material", "needs a material"),
        ('material = "rubber"', 'materiel = "rubber"', "rods.beam.materiel", "did you mean material"),
        ('material = "rubber"', 'material = "rubber"\norder = 0', "rods.beam.order", "from 1 to 12"),
        ('material = "rubber"', 'material = "rubber"\nd1 = [1, 0, 0]', "rods.beam.d1", "along the rod"),
        ('"clamp"', '"clmap"', "supports[0].kind", "did you mean 'clamp'"),
        ('"beam.start"', '"baem.start"', "supports[0].at", "did you mean 'beam'"),
        ('"beam.start"', '"beam"', "supports[0].at", 'a rod is not a place; give "beam.start"'),
        ('"beam.start"', '"beam."', "supports[0].at", "ROD.start"),
        ('"beam.start"', '"beam.strat"', "supports[0].at", "a rod has no such point"),
        ("[[supports]]", "[[support]]", "support", "did you mean supports"),
        ("[[supports]]", "[supports]", "supports", r"write each of them as [[supports]]"),
        ('"beam.end"', '"beam@1.5"', "loads[0].at", "only 1 m long"),
        ("value = [0, 1, 0]", "value = [0, 1, 0]\nvalu = 1", "loads[0].valu", "did you mean value"),
        ("value = [0, 1, 0]", "value = [0, inf, 0]", "loads[0].value[1]", "finite"),
        (
            "value = [0, 1, 0]",
            'value = [0, 1, 0]\ntime = { kind = "ram" }',
            "loads[0].time.kind",
            "did you mean 'ramp'",
        ),
        ("value = [0, 1, 0]", 'value = [0, 1, 0]\ntime = "x"', "loads[0].time", "function of time"),
        ("[equilibrium]", "[equilibrum]", "equilibrum", "did you mean equilibrium"),
        ("[equilibrium]", "", "simulate", "exactly one analysis"),
        ("[equilibrium]", "[equilibrium]\n[simulate]\nduration = 1", "simulate", "exactly one analysis"),
        ("[equilibrium]", "[equilibrium]\nload_step = 2", "equilibrium.load_step", "did you mean load_steps"),
        ("[equilibrium]", "[simulate]", "simulate.duration", "missing"),
        ("[equilibrium]", "equilibrium = 3", "loads[0].equilibrium", "no such key"),
        ("[rods.beam]", "[rods.'a beam']", "rods.'a beam'", "as a name"),
        ("[rods.beam]", "[beams.beam]", "rods", "a rod or a body"),
        ("[materials.rubber]", "title = 3\n[materials.rubber]", "title", "text"),
        ("[materials.rubber]", "[[materials]]", "materials", "[materials.NAME]"),
    ],
)
def test_one_wrong_thing_is_told_with_its_path(old, new, where, text):
    found = problems(changed((old, new)))
    assert where in found
    assert text in found[where]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("poissons_ratio = 0.3", "poisson_ratio = 0.3"),
        ("width = 0.01", "widht = 0.01"),
        ("end = [1, 0, 0]", "ende = [1, 0, 0]"),
        ('section = "strip"', 'secton = "strip"'),
        ('material = "rubber"', 'materiel = "rubber"'),
        ('section = "strip"', 'section = "stripe"'),
        ("density = 1000", "density = -1"),
        ("[materials.rubber]", "[materals.rubber]"),
        ("[sections.strip]", "[section.strip]"),
        ("[rods.beam]", "[ods.beam]"),
        ("[equilibrium]", "[equilibrum]"),
    ],
)
def test_one_mistake_is_told_once(old, new):
    assert len(problems(changed((old, new)))) == 1


def test_a_table_under_an_unknown_key_is_not_printed_whole():
    content = tomllib.loads(GOOD)
    beam = content["rods"].pop("beam")
    del content["rods"]
    content["ods"] = {f"beam_{k}": dict(beam, d1=[0.0, 1.0, 0.0], elements=k) for k in range(1, 9)}
    with pytest.raises(InputError) as caught:
        case_from_dict(content)
    (problem,) = caught.value.problems
    assert problem.where == "ods"
    assert problem.instead.startswith("did you mean rods? ")
    assert len(str(problem)) < 500


def test_many_mistakes_are_told_together():
    found = problems(
        changed(
            ("density = 1000", "density = -1"),
            ("end = [1, 0, 0]", "end = [1, 0]"),
            ('"clamp"', '"clmap"'),
            ("value = [0, 1, 0]", "value = 1"),
            ("[equilibrium]", "[equilibrium]\nsteps = 1"),
        )
    )
    assert set(found) == {
        "materials.rubber.density",
        "rods.beam.end",
        "supports[0].kind",
        "loads[0].value",
        "equilibrium.steps",
    }


def test_an_indefinite_stiffness_in_a_file():
    stiffness = (
        'section = { shape = "stiffness", stiffness = [1, 1, 1, 1, 1, -1], inertia = [1, 1, 1, 1, 1, 1] }'
    )
    found = problems(changed(('section = "strip"', stiffness), ('material = "rubber"', "")))
    assert "diagonal entry -1 for twist" in found["rods.beam.section.stiffness"]


@pytest.mark.parametrize(
    ("text", "where", "message"),
    [
        ("title = ", "end of the file", "invalid value"),
        ("a = 1\nb = [1,,2]", "line 2", "'b = [1,,2]': not TOML: invalid value"),
        ("[rods", "end of the file", "expected ']'"),
        ("a = 1\na = 2\nb = 3", "line 2", "overwrite"),
        ("a = " + "[" * 100_000, "file", "nested too deeply"),
        ("a = " + "9" * 5000, "file", "cannot be read as TOML"),
    ],
)
def test_files_that_are_not_toml(text, where, message):
    with pytest.raises(InputError) as caught:
        parse_case(text)
    (problem,) = caught.value.problems
    assert problem.where == where
    assert message in str(problem)
    assert problem.instead


def test_deeply_nested_tables_are_no_trouble():
    data = tomllib.loads(GOOD)
    nested: object = 1.0
    for _ in range(300):
        nested = [{"a": nested}]
    data["loads"][0]["value"] = nested
    with pytest.raises(InputError, match=r"loads\[0\]\.value"):
        case_from_dict(data)


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "swing.toml").write_text(GOOD, encoding="utf-8")
    with pytest.raises(InputError, match=r"there is no such file; did you mean .*swing\.toml"):
        load_case(tmp_path / "swng.toml")
    with pytest.raises(InputError, match="there is no such file; give the path"):
        load_case(tmp_path / "nowhere" / "swing.toml")
    with pytest.raises(InputError, match=r"shipped case .*: viscorod example helix_spring copies it"):
        load_case(tmp_path / "helix_spring.toml")
    with pytest.raises(InputError, match="this is a folder"):
        load_case(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not text in UTF-8"):
        load_case(tmp_path / "binary.toml")
    with pytest.raises(InputError, match="no file can have this name"):
        load_case("a\0b")


def test_messages_begin_with_the_file(tmp_path):
    path = tmp_path / "swing.toml"
    path.write_text(changed(("density = 1000", "density = -1")), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_case(path)
    assert str(caught.value) == (
        f"{path}: materials.rubber.density: -1: outside what is allowed; give a number > 0"
    )


PARTS = """
[bodies.plate]
mass = 2.0
inertia = [1, 1, 2]
centre = [2, 0, 0]
points = { corner = [1, 0, 0] }

[[joints]]
kind = "revolute"
a = "plate.corner"
b = "beam.end"
axis = [0, 0, 1]

[[springs]]
at = "plate"
stiffness = { ux = 1.0 }

[equilibrium]
"""


def test_bodies_joints_and_springs():
    text = changed(
        ("[equilibrium]", PARTS), ('material = "rubber"', 'material = "rubber"\nconstraints = "kirchhoff"')
    )
    case = parse_case(text)
    model = ModelDescription()
    model.add("beam", case.description.rods["beam"])
    model.add("plate", Body(2.0, (1, 1, 2), centre=(2, 0, 0), points={"corner": (1, 0, 0)}))
    model.clamp("beam.start")
    model.force("beam.end", (0, 1, 0))
    model.revolute("plate.corner", "beam.end", (0, 0, 1))
    model.spring("plate", stiffness={"ux": 1.0})
    expected = model.to_dict()
    assert case.description.to_dict() == expected
    assert case.description.rods["beam"].constraints == ("kirchhoff",)
    assert case.model(ModelDescription).to_dict() == expected
    assert case_from_dict(case.to_dict()).to_dict() == case.to_dict()


@pytest.mark.parametrize(
    ("old", "new", "where", "text"),
    [
        ("mass = 2.0", "mass = -2.0", "bodies.plate.mass", "> 0"),
        ("mass = 2.0", "maas = 2.0", "bodies.plate.maas", "did you mean mass"),
        ("mass = 2.0", 'mass = 2.0\nshape = "bax"', "bodies.plate.shape", "did you mean 'box'"),
        ("inertia = [1, 1, 2]", "inertia = [1, 1, 3]", "bodies.plate.inertia", "3 > 1 + 1"),
        ("[bodies.plate]", "[bodies.beam]", "bodies.beam", "already a rod of this name"),
        ("[bodies.plate]", "[bodies.ground]", "bodies.ground", "give another name"),
        ("[bodies.plate]", "[[bodies]]", "bodies", "[bodies.NAME]"),
        ('"revolute"', '"revolut"', "joints[0].kind", "did you mean 'revolute'"),
        ("axis = ", "axes = ", "joints[0].axes", "did you mean axis"),
        ('b = "beam.end"', 'b = "baem.end"', "joints[0].b", "did you mean 'beam'"),
        ('at = "plate"', 'at = "plate.tip"', "springs[0].at", "its points are corner"),
        ("[[springs]]", "[[spring]]", "spring", "did you mean springs"),
        ("stiffness = { ux = 1.0 }", "stiffness = { ux = true }", "springs[0].stiffness.ux", "number"),
        (
            'material = "rubber"',
            'material = "rubber"\nconstraints = "x"',
            "rods.beam.constraints",
            "give 'unsh",
        ),
    ],
)
def test_one_wrong_thing_of_an_assembly_is_told_with_its_path(old, new, where, text):
    found = problems(changed(("[equilibrium]", PARTS)).replace(old, new, 1))
    assert where in found
    assert text in found[where]

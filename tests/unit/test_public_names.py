"""The package's front door: every public name is there, and none costs anything until it is used."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import viscorod
from viscorod.model.actions.event import EVENTS
from viscorod.model.actions.load import LOADS
from viscorod.model.actions.time_function_kinds import TIME_FUNCTIONS
from viscorod.model.bodies.body import BODIES
from viscorod.model.connections.joint import JOINTS
from viscorod.model.connections.spring import SPRINGS
from viscorod.model.connections.support import SUPPORTS
from viscorod.model.materials.material import DAMPINGS
from viscorod.model.sections.section_laws import SECTION_LAWS
from viscorod.model.sections.section_shapes import SHAPES

HEAVY = ("xarray", "pandas", "numba", "scipy", "pydantic", "matplotlib", "rich", "typer")


def test_every_public_name_can_be_imported():
    for name in viscorod.__all__:
        assert getattr(viscorod, name).__name__.removeprefix("viscorod.") == name
        assert name in dir(viscorod)
    with pytest.raises(AttributeError, match="no attribute 'Rood'"):
        _ = viscorod.Rood


@pytest.mark.parametrize(("former", "name"), viscorod.RENAMED.items())
def test_former_names_warn(former, name):
    with pytest.warns(DeprecationWarning, match=f"viscorod.{former} is now viscorod.{name}"):
        assert getattr(viscorod, former) is getattr(viscorod, name)


def test_former_package_warns():
    with pytest.warns(DeprecationWarning, match="viscorod.damping.BeamDyn is now viscorod.programs.BeamDyn"):
        assert viscorod.damping.BeamDyn is viscorod.programs.BeamDyn


REGISTRIES = {
    "shape": SHAPES, "load": LOADS, "joint": JOINTS, "spring": SPRINGS, "support": SUPPORTS,
    "law": SECTION_LAWS, "damping": DAMPINGS, "body": BODIES, "event": EVENTS, "time": TIME_FUNCTIONS,
}  # fmt: skip
EVERYTHING = Path(__file__).parents[1] / "property" / "everything.toml"


@pytest.mark.parametrize("registry", REGISTRIES.values(), ids=REGISTRIES)
def test_every_kind_is_public_and_in_the_case_of_everything(registry):
    text = EVERYTHING.read_text(encoding="utf-8")
    for word, kind in registry.items():
        assert getattr(viscorod, kind.__name__) is kind
        assert re.search(rf'(kind|shape) = "{word}"', text), f"{word} is not in {EVERYTHING.name}"


BUILDING = """viscorod
rubber = viscorod.Material(1e9, poissons_ratio=0.3, density=1000.0)
beam = viscorod.Rod.straight((0, 0, 0), (1, 0, 0), section=viscorod.Circle(0.01), material=rubber)
model = viscorod.Model()
model.add("beam", beam)
model.clamp("beam.start")
model.force("beam.end", (0, 1, 0))"""


@pytest.mark.parametrize(
    ("module", "allowed"),
    [("viscorod", ()), ("viscorod.cli.app", ("typer", "rich")), (BUILDING, ("pydantic",))],
    ids=["package", "command line", "model"],
)
def test_import_is_light(module, allowed):
    code = f"import sys, {module}\nprint(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not set(HEAVY) - set(allowed) & set(loaded)

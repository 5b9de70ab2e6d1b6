"""The package's front door: every public name is there, and none costs anything until it is used."""

import subprocess
import sys

import pytest

import viscorod

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

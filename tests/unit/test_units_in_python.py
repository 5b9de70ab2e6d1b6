"""Quantities with units in Python: texts as in files, and the objects of a library of units."""

import copy
import pickle
from types import SimpleNamespace

import numpy as np
import pint
import pytest

import viscorod as vr
from viscorod.attributes import UnknownAttributeError
from viscorod.units import is_quantity

UNIT = pint.UnitRegistry()


def test_texts_are_what_files_have():
    assert vr.Rectangle("10 um", "2 µm") == vr.Rectangle(10e-6, 2e-6)
    silicon = vr.Material("160 GPa", 0.22, "2330 kg/m^3")
    assert silicon == vr.Material(160e9, 0.22, 2330.0)
    rod = vr.Rod.straight(
        [0, 0, 0], ["100 um", 0, 0], section=vr.Circle("1 mm"), material=silicon, twist="90 deg"
    )
    assert rod.length == pytest.approx(1e-4, rel=1e-15)
    assert rod.twist == pytest.approx(np.pi / 2.0, rel=1e-15)
    model = vr.Model()
    model.add("beam", rod)
    model.force("beam.end", [0, 0, "1 uN"], until="2 ms")
    assert model.loads == [vr.Force("beam.end", [0, 0, 1e-6], until=2e-3)]
    assert vr.Spring("beam.end", stiffness={"ux": "3 N/mm", "rz": 2.0}) == vr.Spring(
        "beam.end", stiffness={"ux": 3000.0, "rz": 2.0}
    )


def test_quantities_of_pint():
    """A frequency in revolutions is one in Hz, which Pint's own conversion makes 2 pi times as large."""
    assert vr.Rectangle(10 * UNIT.um, 2 * UNIT.micrometer) == vr.Rectangle("10 um", "2 um")
    line = vr.Rod.straight(
        np.zeros(3) * UNIT.m,
        [100, 0, 0] * UNIT.um,
        section=vr.Circle(1e-6),
        material=vr.Material(1e9, 0.3, 1e3),
    )
    assert line.length == pytest.approx(1e-4, rel=1e-15)
    assert vr.Sine(60 * UNIT.rpm).frequency == pytest.approx(vr.Sine("60 rpm").frequency, rel=1e-15) == 1.0
    assert vr.Material(1 * UNIT.N / UNIT.mm**2, 0.3, 1.2 * UNIT.g / UNIT.cm**3) == vr.Material(
        1e6, 0.3, 1200.0
    )


def test_functions_of_time_have_the_units_of_what_they_describe():
    """What they describe is known where they are given: there the unit is checked, and rpm become rad/s."""
    shake = {"ux": vr.Sine("5 Hz", "2 mm", offset=1 * UNIT.um), "rz": vr.Ramp(0, "1 ms", "180 deg")}
    plain = {"ux": vr.Sine(5.0, 2e-3, offset=1e-6), "rz": vr.Ramp(0, 1e-3, np.pi)}
    assert vr.Support("a.end", motion=shake) == vr.Support("a.end", motion=plain)
    table = vr.TimeTable([0, 1] * UNIT.ms, ["0 mm", "5 mm"])
    assert table.value(0.5e-3) == pytest.approx(2.5e-3, rel=1e-15)
    assert vr.Clamp("a.end", motion={"uy": table}) == vr.Clamp(
        "a.end", motion={"uy": vr.TimeTable([0, 1e-3], [0, 5e-3])}
    )
    turn = vr.VelocitySupport("a.start", velocity={"w1": vr.Ramp(0, 1, "60 rpm")})
    assert turn.velocity["w1"].value(1.0) == pytest.approx(2.0 * np.pi, rel=1e-15)
    assert copy.deepcopy(shake["ux"]) == shake["ux"] == pickle.loads(pickle.dumps(shake["ux"]))


class OfAstropy:
    """A quantity as Astropy's objects are: a value, a unit with its text, ``to_value``."""

    value = 3.0
    unit = SimpleNamespace(to_string=lambda: "mm")

    def to_value(self):
        return self.value


def test_quantities_of_astropy():
    assert vr.Circle(OfAstropy()) == vr.Circle(3e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: vr.Rectangle("10 s", 1), r"Rectangle.width: '10 s': this is a time, width needs a length"),
        (lambda: vr.Rectangle(10 * UNIT.s, 1), r"Rectangle.width: '10 second': this is a time"),
        (lambda: vr.Rectangle("10 umm", 1), r"no unit 'umm'; did you mean um\?"),
        (lambda: vr.Rectangle("10", 1), r"a number in quotes has no unit"),
        (lambda: vr.Rectangle(10 * UNIT.dimensionless, 1), r"this has no unit, width needs a length"),
        (
            lambda: vr.Force("a.end", [0, "1 m", 0]),
            r"Force.value\[1\]: '1 m': this is a length, value needs a force",
        ),
        (lambda: vr.Material(1e9, 0.3 * UNIT.m, 1e3), r"Material.poissons_ratio: .*has no unit"),
        (lambda: vr.Sine(1.0, "1 umm"), r"Sine.amplitude: .*no unit 'umm'; did you mean um\?"),
        (lambda: vr.Sine(1.0, "1"), r"Sine.amplitude: '1': no number with a unit"),
        (
            lambda: vr.Clamp("a.end", motion={"rz": vr.Ramp(0, 1, "5 mm")}),
            r"Clamp.motion.rz: '5 mm': this is a length, level needs an angle",
        ),
        (
            lambda: vr.Clamp("a.end", motion={"ux": vr.TimeTable([0, 1], [0, 5] * UNIT.N)}),
            r"Clamp.motion.ux: .*this is a force, values needs a length",
        ),
        (
            lambda: vr.Force("a.end", [0, 0, 1], time=vr.Ramp(0, 1, "5 N")),
            r"Force.time: '5 N': level has no unit",
        ),
        (
            lambda: vr.Clamp("a.end", motion={"ux": {"kind": "sine", "frequency": 1, "amplitude": "5 mm"}}),
            r"what the function of time describes, which is not known here; give an object",
        ),
        (
            lambda: vr.StiffnessSection(np.ones(6) * UNIT.N),
            r"its numbers have different units, N or N m\^2 or N m; give them one by one",
        ),
    ],
)
def test_wrong_units_are_told_with_what_is_needed(make, words):
    with pytest.raises(vr.InputError, match=words):
        make()


def test_texts_of_other_kinds_stay():
    """Titles and names may begin with digits."""
    assert vr.Model().modes.__name__ == "modes"
    assert vr.Force("a.end", [0, 0, 1], name="3 apples").name == "3 apples"


def test_parts_of_a_model_are_no_quantities(monkeypatch):
    """Nor are they asked for names that they do not have: they would look for the nearest of theirs each time."""

    def looked_for(*_args, **_given):
        raise AssertionError

    monkeypatch.setattr(UnknownAttributeError, "problems", property(looked_for))
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber)
    assert not is_quantity(rod)
    assert is_quantity(10 * UNIT.mm)

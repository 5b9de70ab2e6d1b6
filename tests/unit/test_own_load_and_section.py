"""A load and a section that the package does not know: one class and one line each, and all that comes with them."""

import math
from typing import Literal

import numpy as np
import pytest
from pydantic import Field

import viscorod as vr
from helpers import viewer_pages as pages
from viscorod.model.actions.load import LOADS, AnyLoad
from viscorod.model.actions.load_base import AlongRod
from viscorod.model.actions.load_effects import Arrows, PythonLaw
from viscorod.model.connections.place import Place, PlaceField
from viscorod.model.connections.resolved_places import position_of
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Direction, NonNegative, Positive, Vector
from viscorod.model.sections.section_profile import SECTIONS
from viscorod.model.sections.section_shapes import SHAPES, Shape
from viscorod.pictures.drawing.model_drawing import draw_assembly
from viscorod.pictures.viewer import view
from viscorod.solve.problem.discretise import discretise


class Rope(AnyLoad):
    """A rope that pulls in a direction."""

    kind: Literal["rope"] = Field(default="rope", kw_only=True, repr=False)
    tied_to: PlaceField = Key("place")
    tension: Positive = Key("size of the force", "N")
    towards: Direction = Key("direction, global axes", default=(0.0, 0.0, 1.0))

    def places(self):
        return {"tied_to": self.tied_to}

    def place(self, model, placing):
        force = self.tension * np.array(self.towards)
        placing.at(self.tied_to, np.array([*force, 0.0, 0.0, 0.0]), self.factor)

    def arrows(self, model, t):
        feet = (model.place(self.tied_to),)
        return Arrows(f"rope at {self.tied_to}", "N", feet, self.tension * np.array([self.towards]))


class Ground(AlongRod):
    """Soft ground below a rod, elastic and viscous, that also holds it down."""

    sees_motion = True
    kind: Literal["ground"] = Field(default="ground", kw_only=True, repr=False)
    stiffness: Positive = Key("force per length and depth", "N/m^2", kw_only=True)
    viscosity: NonNegative = Key("force per length and velocity", "Pa s", default=0.0, kw_only=True)

    def place(self, model, placing):
        def wrench(r, R, twist):
            force = self.stiffness * r[2] + self.viscosity * (R @ twist[:3])[2]
            return np.array([*(-force * R[2]), 0.0, 0.0, 0.0])

        def dissipated(r, R, twist):
            return self.viscosity * (R @ twist[:3])[2] ** 2

        start, end = self.from_s or 0.0, self.to_s
        placing.seeing_motion(self.rod, PythonLaw(wrench, dissipated), self.factor, start=start, end=end)

    def arrows(self, model, t):
        return Arrows(f"ground below {self.rod}", "N/m", (Place(self.rod, 0.0),), np.zeros((1, 3)))


class Dashpot(AnyLoad):
    """A dashpot to the ground in all directions, and a spring that pulls a place to where it is built."""

    sees_motion = True
    kind: Literal["dashpot"] = Field(default="dashpot", kw_only=True, repr=False)
    at: PlaceField = Key("place")
    damping: Positive = Key("force per velocity", "N s/m", kw_only=True)
    stiffness: NonNegative = Key("force per displacement", "N/m", default=0.0, kw_only=True)

    def places(self):
        return {"at": self.at}

    def place(self, model, placing):
        home = position_of(model, model.place(self.at))[0]

        def wrench(r, R, twist):
            return np.array([*(-self.damping * twist[:3] - self.stiffness * R.T @ (r - home)), 0.0, 0.0, 0.0])

        def dissipated(r, R, twist):
            return self.damping * twist[:3] @ twist[:3]

        placing.seeing_motion_at(
            self.at, PythonLaw(wrench, dissipated, at_rest=self.stiffness > 0.0), self.factor
        )

    def arrows(self, model, t):
        return Arrows(f"dashpot at {self.at}", "N", (model.place(self.at),), np.zeros((1, 3)))


class Hexagon(Shape):
    """Solid regular hexagon with two corners on d1."""

    shape: Literal["hexagon"] = Field(default="hexagon", kw_only=True, repr=False)
    side: Positive = Key("length of a side", "m")

    def moments(self):
        second_moment = 5.0 * math.sqrt(3.0) / 16.0 * self.side**4
        return 1.5 * math.sqrt(3.0) * self.side**2, second_moment, second_moment

    @property
    def outline(self):
        angles = math.pi / 3.0 * np.arange(6)
        corners = self.side * np.column_stack([np.cos(angles), np.sin(angles)])
        return ((tuple(map(tuple, corners.tolist())), ()),)

    def _torsion(self):
        return 1.0355 * self.side**4  # Roark's formulas for stress and strain

    def _cowper(self, nu):
        return 0.9, 0.9


E, NU, LENGTH, AT, SIDE, TENSION = 2e11, 0.3, 1.0, 0.6, 0.01, 0.05
CASE = f"""
title = "A rope"
[materials.steel]
youngs_modulus = {E}
poissons_ratio = {NU}
density = 7850.0
[rods.beam]
shape = "straight"
start = [0, 0, 0]
end = [{LENGTH}, 0, 0]
section = {{shape = "hexagon", side = {SIDE}}}
material = "steel"
[[supports]]
kind = "clamp"
at = "beam.start"
[[loads]]
kind = "rope"
tied_to = "beam@{AT}"
tension = "50 mN"
[equilibrium]
"""


@pytest.fixture
def registered(monkeypatch):
    monkeypatch.setitem(LOADS, "rope", Rope)
    monkeypatch.setitem(SHAPES, "hexagon", Hexagon)


@pytest.fixture
def case(registered, tmp_path):
    path = tmp_path / "rope.toml"
    path.write_text(CASE)
    return vr.load_case(path)


def test_a_case_file_has_the_words(case):
    assert case.description.loads == [Rope(f"beam@{AT}", TENSION)]
    assert case.description.rods["beam"].section == Hexagon(SIDE)
    assert case.to_dict()["loads"] == [{"kind": "rope", "tied_to": f"beam@{AT}", "tension": TENSION}]
    assert case.to_dict()["rods"]["beam"]["section"] == {"shape": "hexagon", "side": SIDE}


def test_a_mistyped_place_is_reported_with_its_key(registered, tmp_path):
    path = tmp_path / "rope.toml"
    path.write_text(CASE.replace(f'"beam@{AT}"', '"baem@0.6"'))
    with pytest.raises(vr.InputError, match=r"loads\[0\]\.tied_to.*did you mean 'beam'"):
        vr.load_case(path)


def test_an_element_ends_at_the_load(case):
    assert case.description.stations("beam") == (0.0, AT, LENGTH)
    (elements,) = discretise(case.description).sets
    assert np.abs(elements.start - AT).min() < 1e-12


def test_the_equilibrium_is_that_of_beam_theory(case):
    """A cantilever under a force at 0.6 of its length: bending and shear up to it, straight beyond."""
    result = case.model(vr.Model).equilibrium()
    _, bending, _ = Hexagon(SIDE).moments()
    area, G = Hexagon(SIDE).area, E / (2.0 * (1.0 + NU))
    at_load = TENSION * AT**3 / (3.0 * E * bending) + TENSION * AT / (0.9 * G * area)
    slope = TENSION * AT**2 / (2.0 * E * bending)
    lift = result.history("beam.end", "displacement").values[-1, 2]
    assert lift == pytest.approx(at_load + slope * (LENGTH - AT), rel=1e-6)


def test_the_picture_of_the_model_has_the_arrow(case):
    axes = draw_assembly(case.description).axes[0]
    assert "0.05 N" in [text.get_text() for text in axes.texts]
    assert "force" in [text.get_text() for text in axes.get_legend().get_texts()]


def test_the_page_has_arrow_and_outline(case, tmp_path):
    result = case.model(vr.Model).equilibrium()
    text = view(result, tmp_path / "page.html").read_text(encoding="utf-8")
    meta, data = pages.parts(text)
    (load,) = meta["scene"]["loads"]
    assert (load["label"], load["family"], load["largest"]) == (f"rope at beam@{AT}", "N", TENSION)
    marks, _ = pages.array(meta, data, "marks")
    assert marks[-1, load["arrows"][0]] == pytest.approx([0.0, 0.0, 1.0], abs=1e-4)
    assert marks[-1, load["feet"][0], 0] == pytest.approx(AT, abs=1e-3)
    ((contour,),) = meta["lines"][0]["contours"]
    assert np.hypot(*np.array(contour).T) == pytest.approx(np.ones(6))
    halves, _ = pages.array(meta, data, "halves")
    assert halves == pytest.approx(SIDE)


def test_the_section_can_be_a_region_and_taper(registered):
    steel = vr.Material(E, NU, 7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Taper(Hexagon(SIDE), Hexagon(0.5 * SIDE)), material=steel
    )
    assert rod.section_at(0.5).half_width == pytest.approx(0.75 * SIDE)
    whole = vr.Composite([vr.CompositeRegion(material=steel, section={"shape": "hexagon", "side": SIDE})])
    assert whole.matrices()[0][2, 2] == pytest.approx(E * Hexagon(SIDE).area)
    assert whole.half_width == pytest.approx(SIDE)


def test_what_is_not_registered_is_refused(tmp_path):
    assert "rope" not in LOADS
    assert "hexagon" not in SECTIONS
    path = tmp_path / "rope.toml"
    path.write_text(CASE)
    with pytest.raises(vr.InputError, match="no such kind") as refused:
        vr.load_case(path)
    assert "no such shape" in str(refused.value)


class Couple(AnyLoad):
    """Two opposite forces."""

    kind: Literal["couple"] = Field(default="couple", kw_only=True, repr=False)
    first: PlaceField = Key("place")
    second: PlaceField = Key("place")
    force: Vector = Key("at the first place, global components", "N")

    def places(self):
        return {"first": self.first, "second": self.second}

    def place(self, model, placing):
        wrench = np.array([*self.force, 0.0, 0.0, 0.0])
        placing.at(self.first, wrench, self.factor)
        placing.at(self.second, -wrench, self.factor)

    def arrows(self, model, t):
        feet = (model.place(self.first), model.place(self.second))
        return Arrows("couple", "N", feet, np.array([self.force, -np.array(self.force)]))


def test_only_loads_per_length_have_a_line_through_their_tips():
    def lines(load):
        model = vr.Model()
        model.add(
            "beam",
            vr.Rod.straight(
                (0, 0, 0), (LENGTH, 0, 0), section=vr.Circle(SIDE), material=vr.Material(E, NU, 7850.0)
            ),
        )
        model.loads.append(load)
        (axes,) = draw_assembly(model, "").axes
        return sum(line.get_linewidth() == 0.9 and line.get_zorder() == 6 for line in axes.get_lines())

    assert lines(Couple("beam@0.2", "beam.end", (0, 1, 0))) == 0
    assert lines(vr.DistributedForce("beam", (0, 1, 0))) == 1


def on_ground(viscosity=0.0, **options):
    """A slender rod on ground, with EI = 1, mass and length of 1, and its ground."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1, 1, 1, 1e-9, 1e-9, 2e-9])
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4)
    model.add("beam", rod)
    model.support("beam.start", ("ux", "uy", "uz", "rx"))
    model.support("beam.end", ("uy", "uz"))
    model.loads.append(Ground("beam", stiffness=900.0, viscosity=viscosity))
    return model


def test_own_load_that_sees_motion_in_modes():
    """Winkler 1867: omega^2 = (EI (n pi/L)^4 + k)/m on pinned ends, and zeta = c/(2 m omega)."""
    modes = on_ground(viscosity=2.0).modes(5)
    upright = np.sqrt((np.pi * np.arange(1, 3)) ** 4 + 900.0)
    for omega in upright:
        k = int(np.argmin(np.abs(2.0 * np.pi * modes.frequencies - omega)))
        assert 2.0 * np.pi * modes.frequencies[k] == pytest.approx(omega, rel=2e-4)
        assert modes.damping_ratios[k] == pytest.approx(2.0 / (2.0 * omega), rel=5e-4)


@pytest.mark.parametrize(
    "way",
    [
        {},
        {"integrator": "midpoint", "time_step": 2e-3},
        {"integrator": "generalized_alpha", "time_step": 2e-3},
        {"formulation": "intrinsic"},
    ],
    ids=lambda way: way.get("integrator", way.get("formulation", "radau")),
)
def test_own_load_that_sees_motion_in_statics_and_motions(way):
    """A free rod sinks by m g/k; then the ground damps it as an oscillator, and takes what it loses."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2))
    model.support("beam.start", ("ux", "uy", "rx", "ry", "rz"))
    model.gravity((0, 0, -9.0), until=0.0)
    model.loads.append(Ground("beam", stiffness=900.0, viscosity=6.0))
    assert model.equilibrium().position("beam.end")[2] == pytest.approx(-0.01, abs=1e-9)
    run = model.simulate(0.2, **way)
    history = run.history("beam.end")
    t, z = history["time"].values, history.sel(axis="z").values
    fast = np.sqrt(900.0 - 9.0)
    exact = -0.01 * np.exp(-3.0 * t) * (np.cos(fast * t) + 3.0 / fast * np.sin(fast * t))
    assert z == pytest.approx(exact, abs=5e-5)
    energy = run.energy
    assert energy.numerical_fraction < 5e-3
    assert energy.outside[-1] + energy.kinetic[-1] == pytest.approx(energy.external[-1], rel=5e-3)


def test_own_load_at_the_point_of_a_body_is_the_spring_that_it_imitates():
    """The same spring and damper to the ground, as a spring and as a load: frequencies, ratios and equilibria."""
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1.0, 2.0, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    found = []
    for own in (True, False):
        model = vr.Model()
        model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2))
        model.add(
            "plate", vr.Body.box((1.1, 0, 0), (0.2, 0.1, 0.1), density=10.0, points={"tip": (1.2, 0.1, 0)})
        )
        model.attach("beam.end", "plate")
        model.clamp("beam.start")
        model.gravity((0, 0, -2.0))
        if own:
            model.loads.append(Dashpot("plate.tip", damping=0.1, stiffness=3.0))
        else:
            three = ("ux", "uy", "uz")
            model.spring("plate.tip", stiffness=dict.fromkeys(three, 3.0), damping=dict.fromkeys(three, 0.1))
        modes = model.modes(4)
        rest = model.equilibrium().position("plate.tip")
        found.append(np.concatenate([modes.frequencies, modes.damping_ratios, rest]))
    assert found[0] == pytest.approx(found[1], rel=1e-6, abs=1e-9)


def test_mistakes_in_functions_of_own_loads_are_told():
    """An exception in a law called from compiled code reaches the caller."""
    model = on_ground()

    class Trap(Ground):
        def place(self, model, placing):
            def wrench(r, R, twist):
                raise ZeroDivisionError("in the ground")

            placing.seeing_motion(self.rod, PythonLaw(wrench), self.factor)

    model.loads.append(Trap("beam", stiffness=1.0))
    with pytest.raises(ZeroDivisionError, match="in the ground"):
        model.equilibrium()

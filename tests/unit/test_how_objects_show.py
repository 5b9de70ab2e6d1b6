"""One line for every object, a card with a small drawing in notebooks, signatures that can be read, names told."""

import copy
import inspect
import pickle
import pydoc
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import viscorod as vr
from helpers.synthetic_results import rolled_up, swing
from viscorod.attributes import INNER, UnknownAttributeError, WellNamed
from viscorod.model.fields.definition import Definition
from viscorod.model.materials.damping_model import Branch


def model():
    found = vr.Model()
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.01, 0.01))
    found.add("coil", vr.Rod.helix(0.02, 0.01, 3.0, section=vr.Circle(0.002), material=rubber))
    found.add("plate", vr.Box([0.02, 0.02, 0.01], mass=0.3, centre=[0, 0, 0.03]))
    found.clamp("coil.start")
    found.force("coil.end", [0, 0, 1], name="pull")
    return found


def shown():
    run = vr.Run(swing())
    coil = model().rods["coil"]
    return [
        model(),
        coil,
        coil.section,
        coil.material,
        vr.Annulus(0.02, 0.01),
        vr.StiffnessSection(np.ones(6)),
        run,
        vr.Equilibrium(rolled_up()),
        run.decay("beam.end", "y"),
        vr.kelvin_voigt_fit(vr.RelaxationModulus(1e6, [1e5], [0.1]), (1, 100)),
    ]


def test_one_line_and_a_card():
    for one in shown():
        line = repr(one)
        assert type(one).__name__ in line
        assert "\n" not in line
        assert " at 0x" not in line
        assert len(line) < 260
        html = one._repr_html_()
        ET.fromstring(html)  # well formed
        assert type(one).__name__ in html


def test_drawings_are_what_they_show():
    """A ring is seen as two circles, its hole cut out; a coil of three turns is no straight line."""
    ring = ET.fromstring(vr.Annulus(0.02, 0.01)._drawing())
    path = ring[0].attrib["d"]
    assert path.count("M") == path.count("Z") == 2
    assert ring[0].attrib["fill-rule"] == "evenodd"
    for one in (model(), model().rods["coil"], vr.Run(swing())):
        assert "<path" in one._repr_html_()
    assert "<rect" in model()._repr_html_()  # the support
    assert "<circle" in model()._repr_html_()  # the mass centre of the body


def test_what_was_given_is_what_is_printed():
    assert repr(vr.Rectangle(0.01, 0.002)) == "Rectangle(width=0.01, height=0.002)"
    assert repr(vr.Force("a.end", (0, 0, 1))) == "Force(at='a.end', value=(0, 0, 1))"
    assert eval(repr(vr.Rectangle(0.1 + 0.2, 1)), {"Rectangle": vr.Rectangle}) == vr.Rectangle(0.1 + 0.2, 1)
    assert str(vr.Circle(1)) == "Circle(radius=1)"


def test_signatures_are_names_kinds_and_defaults():
    words = "(width: float, height: float, *, torsion_constant: float | None = None"
    assert str(inspect.signature(vr.Rectangle)).startswith(words)
    vr.Rectangle(0.1, 0.1)  # its validator is built now
    assert str(inspect.signature(vr.Rectangle)).startswith(words)
    assert list(inspect.signature(vr.Force).parameters) == [
        "at",
        "value",
        "following",
        "name",
        "time",
        "until",
    ]
    text = pydoc.plain(pydoc.render_doc(vr.Rectangle))
    for inside in ("pydantic_core", "model_dump", "__pydantic", "Annotated"):
        assert inside not in text
    assert "Args:" in text
    own = {"section", "length", "frames", "mass", "replaced", "to_dict"}
    assert own <= set(dir(model().rods["coil"]))
    assert not {name for name in dir(model().rods["coil"]) if name.startswith(("_", "model_"))}


def test_every_described_class_has_a_signature_of_its_fields():
    for name in vr.__all__:
        kind = getattr(vr, name)
        if isinstance(kind, type) and issubclass(kind, Definition):
            known = inspect.signature(kind).parameters
            own = inspect.getfullargspec(inspect.unwrap(kind.__init__))
            assert set(known) <= set(kind.model_fields if own.varkw else own.args), name
            assert "*args" not in str(inspect.signature(kind)), name
            assert "Annotated" not in str(inspect.signature(kind)), name


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: vr.Rectange, r"no attribute 'Rectange'; did you mean Rectangle\?"),
        (lambda: vr.Circle(1).radious, r"Circle.radious: .*did you mean radius\?"),
        (lambda: model().simulat, r"did you mean simulate\?"),
        (lambda: model().rods["coil"].lenght, r"did you mean length\?"),
        (lambda: vr.Run(swing()).plot_strian, r"did you mean plot_strain\?"),
        (lambda: vr.Run(swing()).decay("beam.end", "y").periods, r"did you mean period\?"),
    ],
)
def test_names_that_are_not_there(ask, words):
    with pytest.raises(vr.InputError, match=words) as caught:
        ask()
    assert isinstance(caught.value, AttributeError)  # for hasattr, copy and pickle


@pytest.mark.parametrize("word", sorted(INNER))
def test_a_slip_is_not_answered_with_what_users_do_not_write(word):
    """Every such name is one of some public class, and none is offered for a slip in it."""
    owners = [
        kind for name in vr.__all__ if isinstance(kind := getattr(vr, name), type) and hasattr(kind, word)
    ]
    assert owners
    for kind in owners:
        error = UnknownAttributeError.of(object.__new__(kind), f"{word}x")
        assert not re.search(rf"\b{word}\b", str(error).partition("no attribute")[2]), kind


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: model().clamp(place="coil.start"),
            r"clamp: place: .*the arguments are at, motion",
        ),
        (lambda: model().force("coil.end", values=[0, 0, 1]), r"did you mean value\?"),
        (
            lambda: vr.Rod.straight([0, 0, 0], [1, 0, 0], sections=1),
            r"straight: sections: .*did you mean section\?",
        ),
        (lambda: vr.Run(swing()).plot(pth="a.png"), r"plot: pth: .*did you mean path\?"),
        (lambda: vr.Rod.straigt([0, 0, 0]), r"Rod.straigt: .*did you mean straight\?"),
        (lambda: vr.Rod.straight([0, 0, 0]), r"straight: end: this argument is required and missing"),
        (
            lambda: vr.Rod.helix((0, 0, 0), (0, 0, 1), 3, radius=0.1),
            r"helix: radius: 0\.1: it is given twice: \(0, 0, 0\) stands",
        ),
        (
            lambda: vr.StaticRecord([1.0], loads=[1.0]),
            r"StaticRecord: loads: .*given twice(.|\n)*place: .*missing",
        ),
        (lambda: vr.sweep(model(), {"a": [1]}), r"this is a model, .*to_toml"),
    ],
)
def test_arguments_and_methods_that_are_not_there(call, words):
    with pytest.raises(vr.InputError, match=words):
        call()


def test_a_property_that_fails_says_why():
    """Not that it is missing."""

    class Broken(WellNamed):
        @property
        def inside(self):
            return self.nothing_like_it

    with pytest.raises(vr.InputError, match=r"Broken\.nothing_like_it"):
        _ = Broken().inside


def test_what_is_set_is_not_lost():
    found = model()
    for name in ("gravity", "gravty", "rod"):
        with pytest.raises(vr.InputError, match=name):
            setattr(found, name, [0, 0, -9.81])
    found.loads = []
    assert found == model() or not found.loads
    with pytest.raises(vr.InputError, match=r"frozen.*replaced\(radius=2\)"):
        vr.Circle(1).radius = 2
    assert vr.Circle(1).replaced(radius="2 mm") == vr.Circle(0.002)
    with pytest.raises(vr.InputError, match="no such key"):
        vr.Circle(1).replaced(radious=2)


def test_copies_are_equal():
    for one in (model(), model().rods["coil"], model().rods["coil"].material):
        for other in (copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
            assert other == one
            assert hash(other) == hash(one)
    changed = model()
    changed.force("coil.end", [0, 0, 2])
    assert changed != model()
    assert model() != "model"


def test_mass_and_removal():
    """The mass of a coil is that of its wire: area times length times density."""
    found = model()
    length = 3.0 * np.hypot(2.0 * np.pi * 0.02, 0.01)
    assert found.mass == pytest.approx(0.3 + np.pi * 0.002**2 * length * 1000.0, rel=1e-12)
    assert "coil: Rod(" in found.summary()
    found.remove("pull")
    assert not found.loads
    found.remove("plate")
    assert not found.bodies
    with pytest.raises(vr.InputError, match=r"did you mean 'coil'\?"):
        found.remove("coils")


def test_branches_are_printed_with_digits_that_can_be_read():
    """Values that a fit found were printed with 17 digits; they stay what they are."""
    branch = Branch(0.0015915494309189538, 1478289.5374552119, 496070.31458)
    assert repr(branch) == "Branch(time=0.00159155, youngs_modulus=1.47829e+06, shear_modulus=496070)"
    assert branch.youngs_modulus == 1478289.5374552119

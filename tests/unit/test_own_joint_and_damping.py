"""A joint and a damping route that the package does not know: one class and one line each."""

import math
from typing import ClassVar, Literal

import numpy as np
import pytest
from pydantic import Field

import viscorod as vr
from helpers import viewer_pages as pages
from viscorod.analyses.case_run import as_model
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.json_schema import case_schema
from viscorod.model.connections.joint import JOINTS
from viscorod.model.connections.joint_base import AnyJoint
from viscorod.model.fields.directions import axes_from
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Direction, Positive
from viscorod.model.materials.damping_model import Behaviour, Damping
from viscorod.model.materials.material import DAMPINGS
from viscorod.pictures.drawing.model_drawing import draw_assembly


class PinInSlot(AnyJoint):
    """A pin in a slot of b: slides along the slot and rotates about the pin."""

    kind: Literal["pin_in_slot"] = Field(default="pin_in_slot", kw_only=True, repr=False)
    slot: Direction = Key("x of the joint, global components in the reference shape")

    def free_motions(self):
        return ("ux", "rz")

    def frame(self):
        return axes_from(self.slot)


class QualityFactor(Damping):
    """Kelvin-Voigt damping with a given quality factor at one frequency, the same in shear and volume change."""

    tag: ClassVar[str | None] = "kind"

    kind: Literal["quality_factor"] = Field(default="quality_factor", kw_only=True, repr=False)
    quality: Positive = Key("quality factor, one over the loss factor")
    frequency: Positive = Key("at which it was measured", "Hz")

    def behaviour(self, elastic):
        time = 1.0 / (2.0 * math.pi * self.frequency * self.quality)
        return Behaviour(*elastic, time, time, assumptions=("the quality factor is that of one frequency",))


E, SIDE, LENGTH, QUALITY, FREQUENCY = 2e11, 0.01, 1.0, 50.0, 20.0
CONTENT = {
    "materials": {
        "steel": {
            "youngs_modulus": E,
            "poissons_ratio": 0.3,
            "density": 7850.0,
            "damping": {"kind": "quality_factor", "quality": QUALITY, "frequency": "0.02 kHz"},
        }
    },
    "rods": {
        "beam": {
            "shape": "straight",
            "start": [0, 0, 0],
            "end": [LENGTH, 0, 0],
            "section": {"shape": "rectangle", "width": SIDE, "height": SIDE},
            "material": "steel",
        }
    },
    "supports": [{"kind": "clamp", "at": "beam.start"}],
    "equilibrium": {},
}


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    monkeypatch.setitem(JOINTS, "pin_in_slot", PinInSlot)
    monkeypatch.setitem(DAMPINGS, "quality_factor", QualityFactor)


def propped(joint):
    """A cantilever whose end is held by a joint and loaded by a moment, from a case file."""
    loads = [{"kind": "moment", "at": "beam.end", "value": [0, 0, MOMENT]}]
    return as_model(case_from_dict({**CONTENT, "joints": [joint], "loads": loads}).description)


MOMENT = 0.01


def test_joint_holds_what_it_does_not_free():
    """Closed form: a propped cantilever under an end moment M is deflected by M L^2/32 EI in the middle."""
    model = propped({"kind": "pin_in_slot", "a": "beam.end", "b": "ground", "slot": [1, 0, 0]})
    found = model.equilibrium()
    stiffness = E * SIDE**4 / 12.0
    deflection = MOMENT * LENGTH**2 / (32.0 * stiffness)
    assert abs(found.position("beam@0.5")[1]) == pytest.approx(deflection, rel=1e-3)
    np.testing.assert_allclose(found.position("beam.end"), (LENGTH, 0, 0), atol=1e-8)


def test_joint_is_drawn_and_shown(tmp_path):
    model = propped({"kind": "pin_in_slot", "a": "beam.end", "b": "ground", "slot": [1, 0, 0]})
    axes = draw_assembly(model).axes[0]
    assert "pin_in_slot" in [text.get_text() for text in axes.texts]
    assert "joint" in [text.get_text() for text in axes.get_legend().get_texts()]
    text = vr.view(model.equilibrium(), tmp_path / "page.html").read_text(encoding="utf-8")
    meta, data = pages.parts(text)
    (shown,) = meta["scene"]["connections"]
    assert shown["kind"] == "joint"
    ends = np.array([pages.array(meta, data, "marks")[0][-1, mark] for mark in shown["marks"]])
    np.testing.assert_allclose(ends, [[LENGTH, 0, 0]] * 2, atol=1e-3)
    (axis,) = shown["axes"]  # of the one rotation that is free: the pin, across slot and beam
    assert abs(pages.array(meta, data, "marks")[0][-1, axis, 2]) == pytest.approx(1.0, abs=1e-3)


def test_joint_without_its_direction_is_refused_with_the_key():
    with pytest.raises(vr.InputError, match=r"joints\[0\]\.slot"):
        propped({"kind": "pin_in_slot", "a": "beam.end", "b": "ground"})


def test_damping_has_the_quality_factor():
    """Closed form: with equal times every mode has the ratio omega tau/2, here f/(2 Q f0)."""
    model = as_model(case_from_dict(CONTENT).description)
    modes = model.modes(4)
    np.testing.assert_allclose(
        modes.damping_ratios, modes.frequencies / (2.0 * QUALITY * FREQUENCY), rtol=1e-6
    )


def test_both_are_in_the_schema():
    definitions = case_schema()["definitions"]
    assert definitions["damping.quality_factor"]["properties"]["frequency"]["x-unit"] == "Hz"
    assert "slot" in definitions["joints.pin_in_slot"]["required"]

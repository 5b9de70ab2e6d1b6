"""A law of a section that the package does not know: one class and one line, and all analyses take it."""

from typing import Literal

import numpy as np
import pytest
from pydantic import Field

import viscorod as vr
from viscorod.analyses.case_run import as_model
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import NonNegative, Positive
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.model.sections.section_laws import SECTION_LAWS

STIFFNESS = [50.0, 50.0, 100.0, 1.0, 1.0, 1.0]


class StiffeningCable(AnySectionLaw):
    """A stretch that stiffens: N = EA e (1 + rate e^2), and a loss with the square of it."""

    kind: Literal["stiffening_cable"] = Field(default="stiffening_cable", kw_only=True, repr=False)
    growth: Positive = Key("of the stiffness with the square of the stretch")
    loss: NonNegative = Key("retardation time at a stretch of 1", "s", default=0.0)

    def parameters(self, stiffness):
        return np.array([self.growth * stiffness[2, 2], self.loss * stiffness[2, 2]])

    @staticmethod
    def respond(parameters, strain, rate, force, by_strain, by_rate):
        k, d = parameters[0], parameters[1]
        e, e_t = strain[2], rate[2]
        force[2] = k * e**3 + d * e**2 * e_t
        by_strain[2, 2] = 3.0 * k * e**2 + 2.0 * d * e * e_t
        by_rate[2, 2] = d * e**2
        return 0.25 * k * e**4, d * e**2 * e_t**2


CASE = """
[sections.cord]
shape = "stiffness"
stiffness = [50.0, 50.0, 100.0, 1.0, 1.0, 1.0]
inertia = [1.0, 1.0, 1.0, 0.01, 0.01, 0.01]

[rods.cord]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.0, 0.0, -1.0]
section = "cord"
elements = 2
order = 3
law = { kind = "stiffening_cable", growth = 40.0, loss = "50 ms" }

[[supports]]
kind = "clamp"
at = "cord.start"

[[loads]]
kind = "force"
at = "cord.end"
value = [0.0, 0.0, -14.0]

[equilibrium]
"""


@pytest.fixture
def model(monkeypatch, tmp_path):
    """The model of a case file in which the law is read by its word, and its number with a unit."""
    monkeypatch.setitem(SECTION_LAWS, "stiffening_cable", StiffeningCable)
    (tmp_path / "case.toml").write_text(CASE)
    return as_model(vr.load_case(tmp_path / "case.toml").description)


def test_a_law_of_ones_own_in_all_analyses(model):
    """Closed forms: N = EA e (1 + growth e^2), axial frequency about it, energies; every integrator and formulation."""
    law = model.rods["cord"].law
    assert (law.growth, law.loss) == (40.0, 0.05)
    stretch = 0.1  # 100 * 0.1 * (1 + 40 * 0.01) = 14
    at_rest = model.equilibrium()
    assert at_rest.position("cord.end") == pytest.approx([0.0, 0.0, -1.0 - stretch], abs=1e-9)
    assert at_rest.elastic_energy == pytest.approx(50.0 * stretch**2 + 1000.0 * stretch**4, rel=1e-9)
    assert model.path(1.0).position("cord.end")[2] == pytest.approx(-1.0 - stretch, abs=1e-9)
    # axial waves by the tangent EA (1 + 3 growth e^2) = 220 N over 1 kg/m of the unstretched cord: f = c/4L, and
    # Im(s)^2 + Re(s)^2 = (2 pi f)^2, 2 Re(s) = -(d e^2/220) (2 pi f)^2 with d e^2 = 0.05 N s
    wave = 0.5 * np.pi * np.sqrt(220.0)
    s = model.modes(12, about="equilibrium").eigenvalues
    axial = s[np.argmin(np.abs(np.abs(s) - wave))]
    assert abs(axial) == pytest.approx(wave, rel=1e-3)
    assert axial.real == pytest.approx(-0.5 * 0.05 / 220.0 * wave**2, rel=2e-3)
    assert model.steady(spin=(0, 0, 0.1), formulation="geometric").position("cord.end")[2] == pytest.approx(
        -1.0 - stretch, abs=1e-6
    )
    model.loads.clear()
    model.force("cord.end", (0, 0, -14.0), time=vr.Ramp(0.0, 0.3))
    for settings in (
        {"integrator": "midpoint", "time_step": 4e-3},
        {"integrator": "generalized_alpha", "time_step": 2e-3},
        {"tolerance": 1e-5},
        {"tolerance": 1e-5, "formulation": "intrinsic"},
    ):
        run = model.simulate(0.4, initial="reference", **settings)
        lost = np.trapezoid(run.data["dissipation"] @ run.data["point_weight"], run.time)
        assert run.energy.viscous[-1] == pytest.approx(lost, rel=0.01)
        assert np.abs(run.energy.numerical).max() < 1e-3 * run.energy.external.max()

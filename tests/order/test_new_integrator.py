"""A fourth integrator, implicit Euler, registered here alone: settings, motions, case files and its order follow."""

from __future__ import annotations

import jsonschema
import numpy as np
import pytest

import viscorod as vr
from helpers.measured_orders import check_order_of_accuracy
from viscorod.analyses.case_run import run_case
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import parse_case
from viscorod.casefile.json_schema import case_schema
from viscorod.solve.transient.integrators import INTEGRATORS, Method
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.tableau import Tableau


class ImplicitEuler(Collocation):
    """Collocation with one stage at the end of the step."""

    estimate_order = 1
    records = 1

    def __init__(self, system, supports):
        super().__init__(system, supports, Tableau.of(np.array([1.0])), newton_tolerance=1e-12)
        self.lengths = {}

    def accept(self):
        """Count steps by their length, so that a dict has to be saved and restored."""
        super().accept()
        length = round(self._step, 9)
        self.lengths[length] = self.lengths.get(length, 0) + 1


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    """Restores the registry after each test."""
    monkeypatch.setitem(INTEGRATORS, "implicit_euler", Method(ImplicitEuler, "implicit Euler", order=1))


def pendulum():
    """A damped rod on a moving clamp."""
    stiffness = np.array([300.0, 300.0, 500.0, 0.5, 0.7, 0.4])
    section = vr.StiffnessSection(stiffness, [1, 1, 1, 1e-2, 1e-2, 2e-2], 1e-3 * stiffness)
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3))
    model.clamp("rod.start", motion={"rz": vr.Sine(0.7, amplitude=0.4)})
    model.gravity((0, 0, -2.0))
    return model


@pytest.mark.parametrize("formulation", ["geometric", "intrinsic"])
def test_its_order_is_measured(formulation):
    check_order_of_accuracy("implicit_euler", formulation)


@pytest.mark.parametrize("formulation", ["geometric", "intrinsic"])
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_it_computes_motions(formulation):
    """Near the motion by radau, with equal steps; it loses energy numerically."""
    given = {"initial": "reference", "formulation": formulation}
    run = pendulum().simulate(0.5, integrator="implicit_euler", time_step=0.001, **given)
    exact = pendulum().simulate(0.5, **given)
    assert run.data.attrs["integrator"] == "implicit_euler"
    assert run.data.attrs["time_step"] == 0.001
    end, wanted = (r.history("rod.end").values[-1] for r in (run, exact))
    assert end == pytest.approx(wanted, abs=0.01)
    assert run.energy.numerical[-1] < -1e-6 * run.energy.moved


@pytest.mark.parametrize(
    ("given", "parts"),
    [
        (
            {"tolerance": 1e-3},
            ("tolerance", "0.001", "implicit Euler has equal steps", "'radau' or 'generalized_alpha'"),
        ),
        ({"spectral_radius": 0.5}, ("'implicit_euler' has no such parameter", "'generalized_alpha'")),
        (
            {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"},
            ("implicit Euler integrates nonlinear dynamics only", "'radau' or 'midpoint'"),
        ),
    ],
)
def test_what_it_cannot_do_is_refused(given, parts):
    with pytest.raises(vr.InputError) as refused:
        pendulum().simulate(0.1, integrator="implicit_euler", **given)
    for part in parts:
        assert part in str(refused.value)


def test_others_name_it_where_it_can_do_what_they_cannot():
    with pytest.raises(vr.InputError, match="'radau' or 'midpoint' or 'implicit_euler', or formulation"):
        pendulum().simulate(0.1, integrator="generalized_alpha", formulation="intrinsic")


CASE = """
[rods.rod]
shape = "straight"
start = [0, 0, 0]
end = [1, 0, 0]
section = { shape = "stiffness", stiffness = [1e3, 1e3, 1e3, 1, 1, 1], inertia = [1, 1, 1, 1e-3, 1e-3, 2e-3] }

[[supports]]
kind = "clamp"
at = "rod.start"

[simulate]
duration = "10 ms"
time_step = "5 ms"
initial = "reference"
integrator = "implicit_euler"
"""


def test_case_files_name_it():
    run = run_case(parse_case(CASE))
    assert run.data.attrs["integrator"] == "implicit_euler"
    words = case_schema()["definitions"]["simulate"]["properties"]["integrator"]
    jsonschema.validate("implicit_euler", words)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate("explicit_euler", words)


def test_it_returns_to_a_saved_state_with_all_that_it_keeps():
    system = pendulum().co_simulation(["rod.end"], integrator="implicit_euler", time_step=0.005)
    integrator = system._transient.integrator
    system.step(0.02)
    state, kept = system.saved(), dict(integrator.lengths)
    system.step(0.006)
    assert integrator.lengths != kept
    system.restore(state)
    assert integrator.lengths == kept


def test_a_method_that_ends_before_the_step_does_is_refused():
    """Three Gauss points have no stage at the end of the step; their last one would be taken for it."""
    points = 0.5 + 0.5 * np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])

    class Gauss(Collocation):
        def __init__(self, system, supports):
            super().__init__(system, supports, Tableau.of(points), newton_tolerance=1e-12)

    discrete = DiscreteModel.of(pendulum())
    with pytest.raises(ValueError, match=r"last node is 0\.887298"):
        Gauss(discrete.system, discrete.supports)

"""What a mesh makes wrong is estimated when it is asked for, where nothing else needs it."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium
from viscorod.analyses.start_state import StartState
from viscorod.results.late_attributes import LateAttributes
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.refinement.correction import Balance, corrected
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape
from viscorod.solve.refinement.mesh_watch import MeshWatch
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.solve.start import Start

SECTION = vr.StiffnessSection([900.0, 900.0, 4000.0, 3.0, 8.0, 2.0], [1.0, 1.0, 1.0, 0.002, 0.004, 0.006])


def model(**mesh):
    found = vr.Model()
    found.add("arm", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=SECTION, **mesh))
    found.clamp("arm.start")
    found.force("arm.end", (0.0, 0.0, 2.5))
    return found


@pytest.fixture
def looks(monkeypatch):
    """Count the looks at finer meshes."""
    found = []
    own = MeshWatch._take_in
    monkeypatch.setattr(MeshWatch, "_take_in", lambda self, *given: (found.append(1), own(self, *given))[1])
    return found


ANALYSES = {
    "equilibrium": lambda model: model.equilibrium(),
    "stages": lambda model: model.equilibrium(stages=[{}, {}]),
    "steady": lambda model: model.steady((0.0, 0.0, 3.0)),
}


@pytest.mark.parametrize("analysis", ANALYSES)
def test_numbers_are_read_without_it_and_words_with_it(looks, analysis):
    found = ANALYSES[analysis](model(elements=1, order=2))
    place = found.history("arm.end", "displacement").values
    assert found.outcome == "completed"
    assert not looks
    assert "may be off by" in "\n".join(found.warnings)
    assert looks == [1]
    assert found.mesh_errors == pytest.approx({"arm": found.mesh_errors["arm"]})
    assert found.data.attrs["mesh_motion_error"] > 0.01
    assert looks == [1]
    np.testing.assert_array_equal(found.history("arm.end", "displacement").values, place)


def test_it_is_that_of_the_model_as_it_was(looks):
    own = model(elements=1, order=2)
    found, known = own.equilibrium(), model(elements=1, order=2).equilibrium().mesh_errors
    own.force("arm.end", (0.0, 50.0, 0.0))
    own.add("other", vr.Rod.straight((0, 1, 0), (1, 1, 0), section=SECTION, elements=1))
    assert found.mesh_errors == known


def test_where_the_program_chooses_the_mesh_it_needs_it_at_once(looks):
    model().equilibrium()
    assert looks


def test_it_is_the_same_as_by_itself():
    """Beside a look at the same state that nobody put off."""
    discrete = DiscreteModel.of(model(elements=1, order=2), EquilibriumSettings())
    result = equilibrium(discrete, EquilibriumSettings())
    later = result.mesh_errors
    again = DiscreteModel.of(model(elements=1, order=2), EquilibriumSettings())
    equilibrium(again, EquilibriumSettings())
    again.watch.see(Snapshot.of(_state(result, again), again.system, again.supports))
    assert later["arm"] == pytest.approx(again.watch.estimate.rods["arm"], rel=1e-6)


def _state(result, discrete):
    return StartState(discrete, Start(result=result)).state


def test_attributes_that_are_known_wait_for_none():
    made = []
    attributes = LateAttributes({"title": "one"}, lambda: (made.append(1), {"late": 2})[1])
    assert attributes["title"] == "one"
    assert not made
    assert attributes.get("late") == 2
    assert attributes.get("absent", 3) == 3
    assert dict(attributes) == {"title": "one", "late": 2}
    assert made == [1]


@pytest.mark.parametrize("force", [0.01, 0.1])
def test_the_counterpart_of_an_equilibrium_is_that_of_the_finer_mesh(force):
    """Independent: the finer mesh solved by itself. Bent by 0.2 and 0.7 of its length, in one element of order 3."""
    beam = vr.Model()
    rubber = vr.Material(youngs_modulus=1e6, poissons_ratio=0.3)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber, elements=1, order=3
    )
    beam.add("beam", rod)
    beam.clamp("beam.start")
    beam.force("beam.end", (0.0, force, 0.0))
    discrete = DiscreteModel.of(beam)
    coarse = State.reference(discrete.problem)
    discrete.static.solve(coarse)
    finer = FinerMesh(beam, discrete.problem)
    shape = Shape(coarse, discrete.static.system.gauss_points().section_force, np.zeros(0))
    carried = finer.carried([shape])
    began = finer.take_over(carried)
    found = corrected(Balance(finer), began)
    alone = State.reference(finer.problem)
    FinerMesh(beam, discrete.problem).static.solve(alone)
    moved = np.abs(found.r - began.r).max()
    assert moved > 1e-5 * 0.3
    assert np.abs(found.r - alone.r).max() < max(1e-7 * moved, 1e-10)
    assert np.abs(found.q - alone.q).max() < 1e-8

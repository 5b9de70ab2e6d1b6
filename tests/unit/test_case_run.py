"""A case on its way from the file to the result: what is done once, and that it is the same as step by step."""

import inspect

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses import discrete
from viscorod.analyses.case_run import as_model, discretised_case, run_case
from viscorod.analyses.check import doubts
from viscorod.casefile.case import parse_case
from viscorod.casefile.shipped import shipped_case
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.settings.motion import SimulateSettings

SHORT = (
    shipped_case("cantilever_swing").read_text(encoding="utf-8").replace("duration = 10.0", "duration = 0.2")
)


@pytest.fixture
def counted(monkeypatch):
    """How often a model is validated and discretised."""
    counts = {"validate": 0, "discretise": 0}
    validate, discretise = ModelDescription.validate, discrete.discretise

    def counted_validate(model):
        counts["validate"] += 1
        validate(model)

    def counted_discretise(model, **given):
        counts["discretise"] += 1
        return discretise(model, **given)

    monkeypatch.setattr(ModelDescription, "validate", counted_validate)
    monkeypatch.setattr(discrete, "discretise", counted_discretise)
    return counts


def test_a_case_is_validated_and_discretised_once(counted):
    case = parse_case(SHORT)
    assert case.settings.duration == 0.2
    prepared = discretised_case(case)
    warnings = doubts(prepared)
    run = run_case(case, prepared, doubts=warnings)
    assert run.time[-1] == pytest.approx(0.2)
    assert counted == {"validate": 1, "discretise": 1}


def test_a_case_gives_what_its_model_gives():
    """Bit for bit: warnings that were computed before do not change a run."""
    case = parse_case(SHORT)
    prepared = discretised_case(case)
    doubts(prepared)
    shared = run_case(case, prepared)
    alone = as_model(case.description).simulate(
        **{name: getattr(case.settings, name) for name in case.settings.model_fields_set}
    )
    for name in ("position", "strain", "section_force", "kinetic"):
        assert np.array_equal(shared.data[name].values, alone.data[name].values), name


def test_settings_reach_methods_with_their_names_and_texts():
    """One spelling: the parameters of a method are the fields of its settings, described by the same words."""
    parameters = inspect.signature(vr.Model.simulate).parameters
    for name, field in SimulateSettings.model_fields.items():
        assert field.is_required() or parameters[name].default == field.default
    assert vr.Model.simulate.__doc__.count("    tolerance: what steps may err by") == 1
    assert (
        vr.Model.equilibrium.__doc__.count("    accuracy: ")
        == vr.Model.path.__doc__.count("    title: ")
        == 1
    )
    assert {"title", "progress", "stop", "folder", "resume"} < set(parameters)
    with pytest.raises(vr.InputError, match=r"toleranc: 0.001: no such key; did you mean tolerance"):
        vr.Model().simulate(1.0, toleranc=1e-3)


def test_arguments_are_named_by_their_key_alone():
    with pytest.raises(vr.InputError, match=r"^duration: -1: outside"):
        vr.Model().simulate(-1)

"""Results are equal when their contents are; names that are not there are told."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import viscorod as vr
from viscorod.casefile.shipped import shipped_case


@pytest.fixture(scope="module")
def model():
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    bar = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber, elements=2
    )
    model = vr.Model()
    model.add("beam", bar)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model


@pytest.mark.parametrize(
    "analysis",
    [
        lambda model: model.simulate(0.2),
        lambda model: model.equilibrium(),
        lambda model: model.modes(count=2),
        lambda model: model.frequency_response(inputs="base uz", outputs="beam.end uz", band=(1, 10)),
    ],
    ids=["run", "equilibrium", "modes", "response"],
)
def test_copies_and_loaded_results_are_equal(model, analysis, tmp_path):
    """The same computed twice too: how long it took is no content."""
    result = analysis(model)
    result.save(tmp_path / "result.nc")
    for other in (
        copy.deepcopy(result),
        pickle.loads(pickle.dumps(result)),
        vr.load(tmp_path / "result.nc"),
        analysis(model),
    ):
        assert other == result
        assert hash(other) == hash(result)
    changed = copy.deepcopy(result)
    name = next(name for name, values in changed.data.data_vars.items() if values.dtype.kind == "f")
    changed.data[name] = changed.data[name] * 1.5 + 1.0
    assert changed != result
    assert result not in (model, 1.0, "text")


def test_sweeps_are_equal_by_their_members(tmp_path):
    """A copy, what was saved and loaded, and the same computed again; not one of other values."""
    case = vr.load_case(shipped_case("cantilever_swing"))

    def computed(*durations):
        return vr.sweep(
            case,
            {"simulate.duration": list(durations)},
            quantities={"tip": ("displacement", "beam.end", "y", "last")},
            workers=1,
            errors=0,
        )

    sweep = computed(0.02, 0.03)
    sweep.save(tmp_path / "sweep.nc")
    for other in (copy.deepcopy(sweep), computed(0.02, 0.03), vr.load(tmp_path / "sweep.nc")):
        assert other == sweep
        assert hash(other) == hash(sweep)
    assert computed(0.02, 0.04) != sweep


def test_parts_by_name_say_how_they_are_asked_for(model):
    with pytest.raises(
        AttributeError, match=r"rods\.beam: there is no attribute 'beam'; did you mean \['beam'\]"
    ):
        _ = model.rods.beam
    assert not hasattr(model.rods, "_anything")
    assert copy.deepcopy(model.rods) == model.rods


def test_accounts_decays_and_matrices_are_compared_by_their_numbers(model):
    run = model.simulate(2.5)
    system = model.linear(inputs=["beam.end fz"], outputs=["beam.end uz"])
    parts = [
        run.energy,
        run.decrement("beam.end", axis="y"),
        system,
        system.first_order(),
        system.reduced("modal", 4, band=(1, 50)),
    ]
    for part in parts:
        twin = copy.deepcopy(part)
        assert twin == part
        assert hash(twin) == hash(part)
        assert part._repr_html_().count("<div") > 3
        assert repr(part).startswith(f"<{type(part).__name__}: ")
    assert len({type(part) for part in parts}) == len(set(parts)) == 5
    twin = copy.deepcopy(run.energy)
    twin.kinetic[-1] += 1e-9
    assert twin != run.energy
    assert system != model.linear(inputs=["beam.end fy"], outputs=["beam.end uz"])


def test_what_is_not_a_number_equals_itself():
    from viscorod.alike import same_content

    assert same_content({"a": np.array([1.0, np.nan])}, {"a": np.array([1.0, np.nan])})
    assert same_content((float("nan"), "a"), [float("nan"), "a"])
    assert not same_content(np.array([1.0, 2.0]), np.array([1.0, np.nan]))
    assert not same_content({"a": 1}, {"b": 1})


def test_a_name_that_no_part_has_is_told_with_the_nearest(model):
    with pytest.raises(
        KeyError, match=r"rods\['baem'\]: nothing has this name; did you mean 'beam'\?"
    ) as caught:
        model.rods["baem"]
    assert isinstance(caught.value, vr.InputError)
    with pytest.raises(KeyError, match="there are no bodies"):
        model.bodies["plate"]
    assert model.rods.get("baem") is None
    twin = pickle.loads(pickle.dumps(model))
    assert twin == model == copy.deepcopy(model)
    with pytest.raises(KeyError, match="did you mean 'beam'"):
        twin.rods["baem"]


def test_words_of_other_libraries_are_told_what_they_are_here(model):
    run = model.equilibrium()
    for word, here in (("to_xarray", "data"), ("to_netcdf", "save"), ("show", "plot")):
        with pytest.raises(AttributeError, match=f"did you mean {here}?"):
            getattr(run, word)
    with pytest.raises(AttributeError, match=r"did you mean simulate\?"):
        _ = model.run


def test_print_of_a_check_has_what_the_command_prints(model):
    text = str(model.check())
    for heading in ("Rods", "Sections", "Materials", "First natural modes", "Linear systems", "Warnings"):
        assert heading.removesuffix("Warnings") in text
    assert max(map(len, text.splitlines())) <= 80

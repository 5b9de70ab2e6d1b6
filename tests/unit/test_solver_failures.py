"""What happens when no solution is found: messages say where and why, results up to there are kept."""

from __future__ import annotations

import re

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.solve.statics.static_solver import StaticSolver


def rod(**given):
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-2, 1e-2, 2e-2])
    return vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3, **given)


def model_of(*supports):
    model = vr.Model()
    model.add("beam", rod())
    for support in supports:
        model.support("beam.start", support)
    return model


def test_free_rod_has_no_equilibrium():
    model = model_of()
    model.force("beam.end", (1, 0, 0))
    with pytest.raises(vr.InputError) as error:
        model.equilibrium()
    for motion in (
        "translation along x", "translation along y", "translation along z",
        "rotation about x", "rotation about y", "rotation about z",
    ):  # fmt: skip
        assert motion in str(error.value)
    assert "initial = 'reference'" in str(error.value)


@pytest.mark.parametrize(
    ("fixed", "free"),
    [
        (("uy", "uz", "rx", "ry", "rz"), ["translation along x"]),
    ],
)
def test_free_motions_are_named(fixed, free):
    model = model_of(fixed)
    model.force("beam.end", (1, 1, 0))
    with pytest.raises(vr.InputError) as error:
        model.equilibrium()
    for motion in free:
        assert motion in str(error.value)
    assert str(error.value).count("translation") + str(error.value).count("rotation about") == len(free)


def test_free_rod_of_an_assembly_is_named():
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-2, 1e-2, 2e-2])
    model.add("loose", vr.Rod.straight((0, 2, 0), (1, 2, 0), section=section))
    with pytest.raises(vr.InputError, match="translation along x of loose"):
        model.equilibrium()


def test_simulation_of_a_free_rod_needs_no_equilibrium():
    """Without load the reference shape is an equilibrium; with a load that drives a free motion there is none."""
    assert model_of().simulate(0.1, time_step=0.05).outcome == "completed"
    model = model_of()
    model.force("beam.end", (1, 0, 0), until=0.0)
    with pytest.raises(vr.InputError, match="translation along x"):
        model.simulate(0.1)


def test_hanging_pendulum_is_held_by_its_weight():
    """A rod that hangs from a pin is in equilibrium: gravity does no work on the rotations that the pin leaves free."""
    model = vr.Model()
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-2, 1e-2, 2e-2])
    model.add("rod", vr.Rod.straight((0, 0, 0), (0, 0, -1), section=section, elements=2, order=3))
    model.support("rod.start", ("ux", "uy", "uz", "rz"))
    model.gravity((0, 0, -10.0))
    run = model.simulate(0.2, time_step=0.02)
    stretch = 10.0 / 2 / 1e3
    assert run.history("rod.end", "displacement").values[0] == pytest.approx([0, 0, -stretch], abs=1e-9)
    assert run.history("rod.end", "displacement").values[-1] == pytest.approx([0, 0, -stretch], abs=1e-9)


def test_static_failure_tells_load_place_and_advice():
    """A following end force beyond any equilibrium that load steps can reach: partial results are kept."""
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.distributed_force("beam", lambda s: (0.0, 4e4 * s, 0.0))
    model.moment("beam.end", (3e5, 0, 2e5))
    with pytest.raises(vr.SolveError) as error:
        model.equilibrium()
    text = str(error.value)
    assert "of the loads" in text
    assert "rod 'beam', element" in text
    assert "s = " in text
    assert "load_steps" in text
    partial = error.value.run
    assert partial is None or np.isfinite(partial.data["position"].values).all()
    if partial is not None:
        assert float(partial.load_factor[-1]) < 1.0


@pytest.mark.parametrize("integrator", ["radau", "generalized_alpha"])
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_transient_failure_keeps_what_was_computed(tmp_path, integrator):
    """A load that explodes: the message names the time, and the run up to there can be saved and read."""
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.force("beam.end", (0, 1.0, 0), time=lambda t: 1.0 if t < 0.5 else 1e12 * (t - 0.5))
    with pytest.raises(vr.SolveError) as error:
        model.simulate(1.0, time_step=0.01, integrator=integrator)
    assert "t = 0.5" in str(error.value)
    assert "grows without bound" in str(error.value)
    run = error.value.run
    assert run.outcome == "broken"
    assert run.time[-1] >= 0.49
    again = vr.load(run.save(tmp_path / "run.nc"))
    assert np.isfinite(again.data["position"].values).all()
    assert again.report()


def test_undefined_load_is_reported_at_its_time():
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.force("beam.end", (0, 1.0, 0), time=lambda t: 0.0 if t < 0.3 else float("nan"))
    with pytest.raises((vr.SolveError, vr.InputError)) as error:
        model.simulate(1.0, time_step=0.01, initial="reference")
    assert "0.3" in str(error.value)


@pytest.mark.parametrize("integrator", ["generalized_alpha", "midpoint"])
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_shortened_steps_are_reported(integrator):
    """A hard shock: equal steps are halved until they converge and the run says so."""
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.moment("beam.end", (0, 0, 60.0), time=vr.TimeTable([0, 0.2, 0.2], [0, 0, 1]), following=True)
    run = model.simulate(0.6, time_step=0.2, initial="reference", integrator=integrator)
    assert run.outcome == "completed"
    assert run.data.attrs["rejected"] > 0
    told = [text for text in run.warnings if "shortened" in text]
    assert len(told) == 1
    count = int(re.match(r"(\d+) steps? failed and (was|were) shortened, the first at t = ", told[0])[1])
    assert count == run.data.attrs["rejected"] >= 2
    assert f"down to {run.data.attrs['smallest_step']:.3g} s" in told[0]
    assert told[0] in flat(run.report())


def test_too_few_elements_for_the_supports():
    model = vr.Model()
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-2, 1e-2, 2e-2])
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1))
    model.clamp("beam.start")
    model.support("beam@0.4", ("uy",))
    with pytest.raises(vr.InputError, match=r"rods.beam.elements: 1: too few.*at least 2"):
        model.equilibrium()


def test_hanging_pendulum_has_an_equilibrium():
    """Its weight holds the swing; the free spin of a ball joint about the rod's own axis is neutral."""
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1, 1, 1], [1, 1, 1, 1e-2, 1e-2, 2e-2])
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0, 0, -1), section=section, elements=2, order=3))
    model.support("rod.start", ("ux", "uy", "uz", "rz"))
    model.gravity((0, 0, -10.0))
    assert model.equilibrium().displacement("rod.end") == pytest.approx([0, 0, -0.005], abs=1e-9)
    model.supports.clear()
    model.pin("rod.start")
    assert model.equilibrium().displacement("rod.end") == pytest.approx([0, 0, -0.005], abs=1e-9)
    with pytest.raises(vr.InputError, match="rotation about z") as error:
        model.equilibrium(search=False)
    assert "rotation about x" not in str(error.value)


def test_late_error_of_a_function_keeps_the_run(tmp_path):
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.force("beam.end", (0, 1.0, 0), time=lambda t: 0.0 if t < 0.3 else float("nan"))
    with pytest.raises(vr.SolveError, match=r"Stopped at t = 0.29") as error:
        model.simulate(1.0, time_step=0.01, initial="reference", integrator="generalized_alpha")
    assert error.value.run.time[-1] == pytest.approx(0.29)
    assert vr.load(error.value.run.save(tmp_path / "run.nc")).time[-1] == pytest.approx(0.29)


def test_interruption_keeps_the_run():
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))

    def progress(t, _step):
        if t > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(vr.SolveError, match="interrupted from the keyboard") as error:
        model.simulate(1.0, time_step=0.01, progress=progress)
    assert error.value.run.time[-1] >= 0.49


def after(count):
    """Return what is asked whether to stop, and says so from the ``count``-th time on."""
    asked = iter(range(count))
    return lambda: "enough" if next(asked, None) is None else ""


def loaded():
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.force("beam.end", (0, 5.0, 0))
    return model


def assert_beginning(kept, whole):
    """What was kept of a stopped solution are the first states of the whole one, digit by digit."""
    count = kept.load_factor.size
    assert kept.outcome == "interrupted"
    assert 1 <= count < whole.load_factor.size
    np.testing.assert_array_equal(kept.data.position, whole.data.position[:count])


def test_a_stopped_equilibrium_keeps_its_load_steps():
    """The steps that were converged are those of the search that was not stopped."""
    whole = loaded().equilibrium(load_steps=10)
    with pytest.raises(vr.SolveError, match=r"Stopped at 0\.\d+ of the loads .*: enough") as error:
        loaded().equilibrium(load_steps=10, stop=after(9))
    assert_beginning(error.value.run, whole)
    with pytest.raises(vr.SolveError, match="enough") as error:
        loaded().equilibrium(stop=after(1))
    assert error.value.run is None


def test_an_interrupted_equilibrium_keeps_its_load_steps():
    def interrupt(factor, _step):
        if factor > 0.25:
            raise KeyboardInterrupt

    with pytest.raises(vr.SolveError, match="interrupted from the keyboard") as error:
        loaded().equilibrium(load_steps=10, progress=interrupt)
    assert 0.25 < error.value.run.load_factor[-1] < 1.0


def test_a_stopped_path_keeps_its_points():
    whole = loaded().path(load_factor=1.0)
    with pytest.raises(vr.SolveError, match=r"Stopped at .* points: enough") as error:
        loaded().path(load_factor=1.0, stop=after(12))
    assert_beginning(error.value.run, whole)


def test_a_steady_rotation_can_be_stopped():
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    with pytest.raises(vr.SolveError, match=r"Stopped after 1 iterations: enough"):
        model.steady(spin=(0, 0, 3.0), stop=after(1))


def test_an_interrupted_initial_equilibrium_is_told(monkeypatch, tmp_path):
    """Ctrl-C while the equilibrium is sought from which a motion starts: nothing to keep, nothing is left behind."""
    ask = after(2)

    def interrupted(_solver):
        if ask():
            raise KeyboardInterrupt

    monkeypatch.setattr(StaticSolver, "check_interrupt", interrupted)
    with pytest.raises(vr.SolveError, match=r"initial equilibrium was not found.*interrupted") as error:
        loaded().simulate(1.0, folder=tmp_path)
    assert error.value.run is None
    assert not list(tmp_path.iterdir())


def test_a_long_search_for_the_initial_equilibrium_is_told(monkeypatch, caplog):
    """A motion has no progress before it begins; what its initial equilibrium has reached is said instead, rising."""
    monkeypatch.setattr("viscorod.analyses.equilibrium.PATIENCE", 0.0)
    model = model_of(("ux", "uy", "uz", "rx", "ry", "rz"))
    model.force("beam.end", (0, 500.0, 0))  # more than one load step: the first of them fails
    model.simulate(0.01, time_step=0.01)
    reached = [record.args[0] for record in caplog.records if "initial equilibrium" in record.message]
    assert reached
    assert reached == sorted(reached)
    assert 0.0 < reached[-1] < 1.0
    caplog.clear()
    model_of(("ux", "uy", "uz", "rx", "ry", "rz")).simulate(0.01, time_step=0.01)
    assert not caplog.records


def propped(scale):
    """Tip displacement over length of a cantilever on a roller."""
    model = vr.Model()
    material = vr.Material(1e9, poissons_ratio=0.3, density=1000.0)
    section = vr.Rectangle(0.02 * scale, 0.02 * scale)
    rod = vr.Rod.straight((0, 0, 0), (scale, 0, 0), section=section, material=material, elements=2)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.roller(f"beam@{scale / 2!r}", normal=(0, 1, 0))
    model.force("beam.end", (0, 2.0 * scale**2, 5.0 * scale**2))
    return model.equilibrium().displacement("beam.end") / scale


@pytest.mark.parametrize("scale", [1e-9, 1e-6, 1e3])
def test_statics_at_any_scale_of_length(scale):
    """Similarity: the same cantilever in micrometres and kilometres, with forces that grow with the area."""
    assert propped(scale) == pytest.approx(propped(1.0), rel=1e-9, abs=1e-12)


def test_a_rod_that_loads_carry_off_beyond_all_numbers_is_none():
    """Displacements per load whose squares overflow need a stiffness that is no quantity in SI units."""
    with pytest.raises(vr.InputError, match="smaller than any quantity in SI units"):
        vr.StiffnessSection([1e-160] * 6, [1, 1, 1, 1e-2, 1e-2, 2e-2])


def test_a_rod_that_is_torn_is_told_by_its_place():
    """Two rods, one of them pulled far beyond its stiffness by the loads at its end: no imbalance ends that motion."""
    model = model_of()
    model.clamp("beam.start")
    model.add("strong", vr.Rod.straight((0, 0, 0), (0, 1, 0), section=rod().section, elements=1, order=2))
    model.clamp("strong.start")
    model.force("beam.end", (1e6, 0, 0), time=vr.Ramp(0.0, 1.0))
    with pytest.raises(vr.SolveError, match="a hundred times its length") as error:
        model.simulate(5.0, initial="reference")
    assert re.search(r"The largest shear or stretch is that of beam@[01]", flat(str(error.value)))
    assert "imbalance" not in str(error.value)
    assert error.value.run.time[-1] > 0.0

"""Starts from earlier results, and statics in stages, each from the equilibrium at the end of the one before."""

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.analyses.case_run import run_case

STEEL = vr.Material(2e11, 0.3, 7850.0)


def cantilever(*, elements: int | None = None, length: float = 1.0) -> vr.Model:
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (length, 0, 0), section=vr.Circle(0.005), material=STEEL, elements=elements
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.gravity()
    return model


def truss(load: float) -> vr.Model:
    """Von Mises' truss: it snaps through under 60 N, and stays inverted without."""
    section = vr.StiffnessSection([1e5, 1e5, 1e5, 100.0, 100.0, 100.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("left", vr.Rod.straight((-1, 0, 0), (0, 0, 0.1), section=section))
    model.add("right", vr.Rod.straight((0, 0, 0.1), (1, 0, 0), section=section))
    model.revolute("left.start", "ground", (0, 1, 0))
    model.revolute("right.end", "ground", (0, 1, 0))
    model.revolute("left.end", "right.start", (0, 1, 0))
    if load:
        model.force("left.end", (0, 0, -load), name="push")
    return model


# --- stages


def string() -> vr.Model:
    """A string that is pulled, turned and loaded across; EA = 1e6 N, GJ = 0.4 and EI = 0.5 N m^2."""
    section = vr.StiffnessSection([4e5, 4e5, 1e6, 0.5, 0.5, 0.4], [0.1, 0.1, 0.1, 1e-6, 1e-6, 2e-6])
    model = vr.Model()
    model.add("string", vr.Rod.straight((0, 0, 0), (2, 0, 0), section=section, elements=24))
    model.clamp("string.start")
    model.clamp("string.end", motion={"ux": 0.002, "rx": TURN})
    model.distributed_force("string", (0, 0, -1.0), name="weight")
    return model


TURN = 2.5
STAGES = [{"motions": ["string.end.ux"]}, {"motions": ["string.end.rx"]}, {"loads": ["weight"]}]


def test_string_is_pulled_then_twisted_then_loaded() -> None:
    """Pull EA e = 1000 N; torque GJ phi/L; sag of a taut beam, qL^2/8T (1 - 4/(kL) tanh(kL/4)), k^2 = T/EI."""
    found = string().equilibrium(stages=STAGES)
    reaction = found.data["reaction"].values  # (state, support, motion)
    pulled, twisted, loaded = (reaction[k, 1] for k in found.stage_ends)
    assert pulled[0] == pytest.approx(1000.0, rel=1e-9)
    assert pulled[3] == pytest.approx(0.0, abs=1e-9)
    torque = 0.4 * TURN / 2.0
    assert twisted[[0, 3]] == pytest.approx([1000.0, torque], rel=1e-6)
    assert loaded[3] == pytest.approx(torque, rel=1e-3)
    assert found.load_factor[list(found.stage_ends)] == pytest.approx([1 / 3, 2 / 3, 1.0])
    # without the twist, which couples both bending planes
    plain = string()
    plain.supports[1] = vr.Clamp("string.end", motion={"ux": 0.002})
    loaded_only = plain.equilibrium(stages=[{"motions": ["string.end"]}, {}])
    slope = np.sqrt(1000.0 / 0.5) * 2.0
    sag = 1.0 * 2.0**2 / (8.0 * 1000.0) * (1.0 - 4.0 / slope * np.tanh(slope / 4.0))
    assert loaded_only.displacement("string@1.0")[2] == pytest.approx(-sag, rel=5e-3)
    assert found.found_by.startswith("stage 1: 1 load step from the reference shape; stage 2")


def test_truss_stays_inverted_when_its_load_is_taken_away() -> None:
    found = truss(60.0).equilibrium(stages=[{"loads": ["push"]}, {"loads": {"push": 0.0}}])
    assert found.position("left.end") == pytest.approx([0, 0, -0.1], abs=1e-9)
    assert found.elastic_energy < 1e-12
    assert truss(60.0).equilibrium(load_factor=0.0).position("left.end")[2] == pytest.approx(0.1)


def test_stages_of_joints_rest_strains_and_a_load_factor() -> None:
    """A motor turns an arm that bends at rest: the tip is that of the arc, turned; half of both by the load factor."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 10.0, 10.0, 10.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model = vr.Model()
    model.add("arm", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    model.revolute("arm.start", "ground", (0, 1, 0), motion={"rz": 0.6}, name="motor")
    model.rest_strain("arm", (0, 0, 0, 0.8, 0, 0))
    stages = [{"motions": ["motor"]}, {"loads": ["rest_strains"]}]
    for factor in (1.0, 0.5):
        angle, bend = 0.6 * factor, 0.8 * factor
        along, across = np.sin(bend) / bend, (1.0 - np.cos(bend)) / bend
        tip = (
            along * np.cos(angle) - across * np.sin(angle),
            0.0,
            -along * np.sin(angle) - across * np.cos(angle),
        )
        found = model.equilibrium(load_factor=factor, stages=stages)
        assert found.position("arm.end") == pytest.approx(tip, abs=1e-8)


def test_what_stages_leave_out_or_misname_is_refused() -> None:
    with pytest.raises(vr.InputError, match=r"no stage names this.*name it in a stage"):
        string().equilibrium(stages=STAGES[:2])
    with pytest.raises(vr.InputError, match=r"stages\[0\]\.loads.*did you mean 'weight'"):
        string().equilibrium(stages=[{"loads": ["wieght"]}])
    with pytest.raises(vr.InputError, match=r"stages\[0\]"):
        string().equilibrium(stages=[{"load": ["weight"]}])


# --- starts


def test_equilibrium_from_a_motion_by_object_file_and_time(tmp_path) -> None:
    model = cantilever()
    run = model.simulate(0.05, initial="reference")
    file = run.save(tmp_path / "run.nc")
    wanted = model.equilibrium().position("beam.end")
    starts = [
        run,
        (run, 0.02),
        run.at(0.02),
        file,
        str(file),
        (file, 0.02),
        {"file": str(file), "time": 0.02},
    ]
    for start in [*starts, vr.Start(str(file), 0.02), vr.Start(file, 0.02)]:
        found = model.equilibrium(start=start)
        assert found.position("beam.end") == pytest.approx(wanted, abs=1e-10)
    assert found.found_by == f"1 load step from {file} at t = 0.02 s"
    # small motions are about what rests: a state that moves is refused, unless its velocities are to be left out
    moving = {"result": run, "time": 0.02}
    signals = {"inputs": "beam.end fz", "outputs": ["beam.end uz"]}
    for small in (
        lambda about: model.modes(2, about=about),
        lambda about: model.linear(**signals, about=about),
        lambda about: model.frequency_response(**signals, frequencies=[0.0, 3.0], about=about),
    ):
        with pytest.raises(
            vr.InputError, match=r"about: .* at t = 0.02 s: this state moves.*add at_rest = true"
        ):
            small(moving)
    still = model.modes(2, about=moving | {"at_rest": True}).frequencies
    assert still == pytest.approx(model.modes(2).frequencies, rel=1e-8)
    assert model.modes(2, about=(run, 0.0)).frequencies == pytest.approx(still, rel=1e-8)  # it rests there


def test_inverted_truss_is_a_start_for_everything() -> None:
    inverted = truss(60.0).equilibrium()
    plain = truss(0.0)
    found = plain.equilibrium(start=inverted)
    assert found.position("left.end") == pytest.approx([0, 0, -0.1], abs=1e-9)
    # by symmetry its vibrations are those of the truss as built
    assert plain.modes(4, about=found).frequencies == pytest.approx(plain.modes(4).frequencies, rel=1e-6)
    # a path that begins there passes the equilibrium under a part of the load
    path = truss(60.0).path(start=inverted, load_factor=0.25)
    assert path.load_factor[0] == 1.0
    assert path.load_factor[-1] == 0.25
    staged = truss(60.0).equilibrium(stages=[{"loads": ["push"]}, {"loads": {"push": 0.25}}])
    assert path.position("left.end") == pytest.approx(staged.position("left.end"), abs=1e-8)
    # a motion that starts there stays there
    run = plain.simulate(0.05, start=found)
    assert run.history("left.end").values[-1] == pytest.approx([0, 0, -0.1], abs=1e-8)


def test_motion_goes_on_from_a_stored_time() -> None:
    """The energy account and the place at the end are those of the motion that was not interrupted."""
    model = cantilever()
    given = {"tolerance": 1e-7, "output_interval": 0.01}
    whole = model.simulate(0.1, initial="reference", **given)
    again = model.simulate(0.05, start=whole.at(0.05), **given)
    assert again.history("beam.end").values[-1] == pytest.approx(
        whole.history("beam.end").values[-1], abs=2e-8
    )
    assert again.energy.kinetic[0] == pytest.approx(whole.energy.kinetic[5], rel=1e-6)
    assert again.energy.elastic[-1] == pytest.approx(whole.energy.elastic[-1], rel=1e-4)
    still = model.simulate(0.02, start=vr.Start(whole, time=0.05, at_rest=True))
    assert still.energy.kinetic[0] == 0.0
    assert "Started from a simulate result at t = 0.05 s" in flat(again.report())


def mechanism() -> vr.Model:
    """A rod on a hinge that carries a rigid plate on a second hinge with a spring."""
    model = vr.Model()
    model.add("arm", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), section=vr.Circle(0.004), material=STEEL))
    model.add("plate", vr.Box((0.1, 0.05, 0.01), mass=0.2, centre=(0.55, 0, 0), points={"near": (0.5, 0, 0)}))
    model.revolute("arm.start", "ground", (0, 1, 0), name="hinge")
    model.revolute("plate.near", "arm.end", (0, 1, 0))
    model.spring("plate.near", "arm.end", {"ry": 0.5})
    model.gravity()
    return model


def test_mechanism_with_a_body_goes_on() -> None:
    model = mechanism()
    given = {"tolerance": 1e-7, "output_interval": 0.05}
    whole = model.simulate(0.3, initial="reference", **given)
    again = model.simulate(0.15, start=(whole, 0.15), **given)
    for place in ("arm.end", "plate"):
        assert again.history(place).values[-1] == pytest.approx(whole.history(place).values[-1], abs=2e-6)


def test_another_mesh_starts_by_the_interpolation_of_the_earlier_one() -> None:
    run = cantilever(elements=3).simulate(0.05, initial="reference", tolerance=1e-6)
    fine = cantilever(elements=7)
    again = fine.simulate(0.001, start=run)
    state = run.probe("beam", run.time[-1], s=np.linspace(0, 1, 11))
    start = again.probe("beam", 0.0, s=np.linspace(0, 1, 11))
    assert start["position"].values == pytest.approx(state["position"].values, abs=1e-7)
    assert start["velocity"].values == pytest.approx(state["velocity"].values, abs=1e-5)
    assert fine.equilibrium(start=run).position("beam.end") == pytest.approx(
        fine.equilibrium().position("beam.end"), abs=1e-10
    )


def test_constrained_rod_starts_bent() -> None:
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, constraints="kirchhoff"))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, -5.0))
    bent = model.equilibrium()
    again = model.equilibrium(start=bent)
    assert again.data.attrs["iterations"] <= 3
    assert again.position("beam.end") == pytest.approx(bent.position("beam.end"), abs=1e-12)


def test_starts_that_do_not_fit_are_refused(tmp_path) -> None:
    run = cantilever().simulate(0.01, initial="reference")
    with pytest.raises(vr.InputError, match="another length or reference shape"):
        cantilever(length=2.0).equilibrium(start=run)
    with pytest.raises(vr.InputError, match="no rod of this name"):
        string().equilibrium(start=run)
    with pytest.raises(vr.InputError, match="outside the run"):
        cantilever().equilibrium(start=(run, 0.5))
    with pytest.raises(vr.InputError, match=r"start\.load_factor.*this is a motion"):
        cantilever().equilibrium(start=vr.Start(result=run, load_factor=0.5))
    with pytest.raises(vr.InputError, match="this is no result"):
        cantilever().equilibrium(start=3.0)
    with pytest.raises(vr.InputError, match="leave initial out"):
        cantilever().simulate(0.01, initial="reference", start=run)
    lifted = cantilever()
    lifted.supports[0] = vr.Clamp("beam.start", motion={"uz": 0.1})
    with pytest.raises(vr.InputError, match=r"beam\.start is elsewhere in the earlier result"):
        lifted.simulate(0.01, start=run)
    moved = lifted.equilibrium(start=run)  # statics go there
    assert moved.displacement("beam.start")[2] == pytest.approx(0.1)


def test_case_file_starts_from_a_file_and_goes_by_stages(tmp_path) -> None:
    text = """
[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [1.0, 0.0, 0.0]
section = { shape = "circle", radius = 0.005 }
material = { youngs_modulus = 2e11, poissons_ratio = 0.3, density = 7850.0 }
[[supports]]
kind = "clamp"
at = "beam.start"
[[loads]]
kind = "gravity"
[[loads]]
kind = "force"
name = "push"
at = "beam.end"
value = [0.0, 1.0, 0.0]
"""
    run = cantilever().simulate(0.05, initial="reference")
    run.save(tmp_path / "run.nc")
    case = tmp_path / "case.toml"
    case.write_text(
        text + '[equilibrium]\nstart = { file = "run.nc", time = "20 ms" }\n[[equilibrium.stages]]\n'
        'loads = ["gravity"]\n[[equilibrium.stages]]\nloads = { push = 0.5 }\n'
    )
    loaded = vr.load_case(case)
    found = run_case(loaded)
    model = cantilever()
    model.force("beam.end", (0, 0.5, 0))
    assert found.position("beam.end") == pytest.approx(model.equilibrium().position("beam.end"), abs=1e-9)
    case.write_text(text + '[simulate]\nduration = 0.01\nstart = { file = "run.nc" }\n')
    assert run_case(vr.load_case(case)).energy.kinetic[0] > 0.0

"""Any place, any time: against rigid motion and arcs in closed form, and against denser output of the same run."""

import tomllib
from itertools import pairwise

import numpy as np
import pytest

import viscorod as vr
from helpers.rigid_motions import LENGTH, along, director, rigid, tumbling, with_body
from helpers.synthetic_results import LENGTH as ARC
from helpers.synthetic_results import rolled_up
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.shipped import shipped_cases
from viscorod.mechanics.elements.basis import gauss, lobatto
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.results.between_records import Instants, step_ends
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.files import storage
from viscorod.results.probe import fields_at, instants_of
from viscorod.results.run import Run

RNG = np.random.default_rng(5)


def errors(step):
    """Largest errors of a probe of the tumbling rod at random places and times."""
    run = Run(rigid(step))
    t, s = RNG.uniform(0.0, 2.0, 60), RNG.uniform(0.0, LENGTH, 7)
    found = run.probe("rod", t, s=s)
    q, body, _ = tumbling(t)
    d3, rate = director(t)
    turned = np.abs(np.sum(found["rotation"].values * q[:, None], axis=-1))
    return {
        "position": np.abs(found["position"].values - d3[:, None] * s[:, None]).max(),
        "rotation": np.sqrt(2.0 * np.maximum(1.0 - turned, 0.0)).max(),
        "frame": np.abs(found["frame"].values - matrices(q)[:, None]).max(),
        "velocity": np.abs(found["velocity"].values - rate[:, None] * s[:, None]).max(),
        "angular_velocity": np.abs(found["angular_velocity"].values - body[:, None]).max(),
        "section_force": np.abs(
            found["section_force"].values[:, :, 2] - np.cos(3.0 * t)[:, None] * along(s)[0]
        ).max(),
    }


def test_a_tumbling_rod_is_followed_to_fourth_order_in_time():
    coarse, fine = errors(0.04), errors(0.01)
    assert coarse["frame"] < 1e-5  # (w h)^4/384
    for name in ("position", "frame", "velocity", "angular_velocity", "section_force"):
        assert 3.5 < np.log(coarse[name] / fine[name]) / np.log(4.0) < 4.6, name


def test_a_steady_turn_is_exact():
    time = np.linspace(0.0, 1.0, 6)
    q = np.stack([np.cos(time), 0 * time, 0 * time, np.sin(time)], axis=-1)
    spin = np.tile([0.0, 0.0, 2.0], (6, 1))
    at = np.array([0.03, 0.5, 0.77])
    instants = Instants.of(time, at)
    found = instants.rotations(q[instants.states], spin[instants.states])
    assert found == pytest.approx(np.stack([np.cos(at), 0 * at, 0 * at, np.sin(at)], axis=-1), abs=1e-15)


def test_a_quantity_in_the_place_of_times_is_told():
    with pytest.raises(
        vr.InputError, match="'velocity': what probe takes second are times; write quantity='velocity'"
    ):
        Run(rigid(0.1)).probe("rod.end", "velocity")


def test_stored_states_come_back_as_they_are():
    run = Run(rigid(0.05))
    found, again = run.probe("rod", s=[0.0, 0.3, LENGTH]), run.probe("rod", run.time, s=[0.0, 0.3, LENGTH])
    for name in found:
        assert again[name].values == pytest.approx(found[name].values, abs=1e-14), name
    assert found["position"].dims == ("time", "place", "axis")
    assert found["place"].values.tolist() == ["rod.start", "rod@0.3", "rod.end"]
    assert run.history("rod@0.3").values == pytest.approx(found["position"].values[:, 1], abs=1e-15)


def test_fields_at_gauss_points_are_what_is_stored():
    run = Run(rigid(0.05))
    found = run.probe("rod", s=run.data["point_s"].values)
    for name in ("strain", "section_force", "dissipation"):
        assert found[name].values == pytest.approx(run.data[name].values, abs=1e-14)


def test_section_forces_between_gauss_points_keep_their_integral():
    """A polynomial of degree p - 1 integrates, by the 2p - 1 degree Lobatto rule, to what the Gauss points give."""
    run = Run(rigid(0.1, order=4))
    x, w = lobatto(4)
    ends = run.data["station_s"].values[::4]
    total = 0.0
    for a, b in pairwise(ends):
        # just inside of the element, since a place on its end belongs to the next one
        s = 0.5 * (a + b) + 0.5 * (b - a) * x * (1.0 - 1e-8)
        field = run.probe("rod", s=s)["section_force"].values
        total = total + 0.5 * (b - a) * np.einsum("k,tkc->tc", w, field)
    stored = np.einsum("g,tgc->tc", run.data["point_weight"].values, run.data["section_force"].values)
    assert total == pytest.approx(stored, abs=1e-7)


def test_where_two_elements_meet_the_one_that_begins_counts():
    data = rigid(0.1, order=3)
    data["section_force"][:, 3:, 0] = 7.0
    end = float(data["station_s"][3])
    found = Run(data).probe("rod", s=[end - 1e-6, end, LENGTH])["section_force"].values[0, :, 0]
    assert found == pytest.approx([0.0, 7.0, 7.0], abs=1e-12)


def test_dissipation_is_not_negative():
    data = rigid(0.1)
    data["dissipation"][:, 1:] = 0.0
    found = Run(data).probe("rod", np.linspace(0.0, 2.0, 41), s=np.linspace(0.0, LENGTH, 50))["dissipation"]
    assert float(found.min()) == 0.0
    assert float(found.max()) > 0.0


def lobatto_arc(angle, order=5, elements=2):
    """A rolled-up rod with stations at the nodes of elements, and its curvature at Gauss points, linear in s."""
    data = rolled_up(angle).isel(station=[*range(10), 10])
    ends = np.linspace(0.0, ARC, elements + 1)
    half, middle = 0.5 * np.diff(ends), 0.5 * (ends[1:] + ends[:-1])
    points = (middle[:, None] + half[:, None] * gauss(order)[0]).ravel()
    strain = np.zeros((data.sizes["load_factor"], points.size, 6))
    strain[:, :, 4] = data["load_factor"].values[:, None] * angle / ARC * (1.0 + points)
    data["strain"] = (("load_factor", "point", "component"), strain)
    return data.assign_coords(
        component=["shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"],
        point_rod=("point", np.repeat(["beam"], points.size)),
        point_s=("point", points),
    )


def test_an_arc_stays_on_its_circle():
    angle, s = 1.2, RNG.uniform(0.0, ARC, 40)
    found = Equilibrium(lobatto_arc(angle)).probe("beam", s=s).isel(load_factor=-1)
    radius = ARC / angle
    centre = np.array([0.0, radius, 0.0])
    away = found["position"].values - centre
    assert np.linalg.norm(away, axis=-1) == pytest.approx(np.full(40, radius), rel=2e-7)
    frame = found["frame"].values
    assert np.einsum("nij,nik->njk", frame, frame) == pytest.approx(np.tile(np.eye(3), (40, 1, 1)), abs=1e-14)
    tangent = np.stack([np.cos(s / radius), np.sin(s / radius), 0 * s], axis=-1)
    assert frame[:, :, 2] == pytest.approx(tangent, abs=1e-7)
    assert found["strain"].values[:, 4] == pytest.approx(angle / ARC * (1.0 + s), rel=1e-12)
    assert "velocity" not in found


@pytest.fixture(scope="module")
def swinging():
    """A short swing and the same with dense output."""
    rubber = vr.Material(
        youngs_modulus=1e6,
        poissons_ratio=0.3,
        density=1000.0,
        damping=vr.KelvinVoigt(shear_time=0.02, bulk_time=0.02),
    )
    model = vr.Model()
    square = vr.Rectangle(0.01, 0.01)
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=square, material=rubber))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.03, 0.01), until=0.0)
    return model.simulate(0.8), model.simulate(0.8, output_interval=1e-3)


def test_a_probe_is_closer_to_the_integrators_polynomial_than_the_tolerance(swinging):
    run, dense = swinging
    tolerance, length = run.data.attrs["tolerance"], 0.3
    k, s = RNG.integers(1, 800, 100), RNG.uniform(0.0, length, 9)
    found = run.probe("beam", dense.time[k], s=s)
    exact = dense.probe("beam", s=s).isel(time=k)
    gap = {name: float(np.abs(found[name].values - exact[name].values).max()) for name in found}
    assert gap["position"] < 0.05 * tolerance * length
    assert gap["frame"] < 0.05 * tolerance
    assert gap["velocity"] < tolerance * float(np.abs(exact["velocity"]).max())
    # between the ends of a step these are cubics, which the stored states give back whole
    for name in ("strain", "section_force"):
        assert gap[name] < 1e-12 * float(np.abs(exact[name]).max())


def test_the_shipped_swing_is_followed_to_three_hundredths_of_its_tolerance():
    """The figure in docs/howto/export.md: positions over the length of the rod, and directors."""
    text = tomllib.loads(shipped_cases()["cantilever_swing"].read_text(encoding="utf-8"))
    run = run_case(case_from_dict(text))
    text["simulate"]["output_interval"] = 2e-3
    dense, s = run_case(case_from_dict(text)), np.linspace(0.0, 0.3, 13)
    found, exact = run.probe("beam", dense.time, s=s), dense.probe("beam", s=s)
    limit = 0.03 * run.data.attrs["tolerance"]
    assert np.abs(found["position"].values - exact["position"].values).max() < limit * 0.3
    assert np.abs(found["frame"].values - exact["frame"].values).max() < limit


def test_shear_is_better_than_derivatives_of_positions():
    """The figure in docs/howto/export.md. A dead force has the shear strain (R^T F)/(k G A) everywhere."""
    length, width, young, nu = 0.3, 0.01, 1e6, 0.3
    rubber = vr.Material(youngs_modulus=young, poissons_ratio=nu, density=1000.0)
    square = vr.Rectangle(width, width)
    model = vr.Model()
    beam = vr.Rod.straight((0, 0, 0), (length, 0, 0), section=square, material=rubber, elements=2, order=5)
    model.add("beam", beam)
    model.clamp("beam.start")
    force = np.array([0.0, 10.0 * young * width**4 / 12.0 / length**2, 0.0])
    model.force("beam.end", force)
    found = model.equilibrium()
    h, ends = 1e-5 * length, np.array([0.0, length])
    there, near, further = (
        found.probe("beam", s=ends + k * h * np.array([1.0, -1.0])).isel(load_factor=-1) for k in range(3)
    )
    frame = there["frame"].values
    stiffness = np.array(square.shear_factors(nu)) * young / (2.0 * (1.0 + nu)) * width**2
    exact = np.einsum("nij,i->nj", frame, force)[:, :2] / stiffness
    r0, r1, r2 = (at["position"].values for at in (there, near, further))
    rate = (4.0 * r1 - 3.0 * r0 - r2) / (2.0 * h)
    rate[1] *= -1.0
    derived = np.einsum("nij,ni->nj", frame, rate)[:, :2]
    by_points = np.abs(there["strain"].values[:, :2] - exact).max()
    assert by_points < 2e-3 * np.abs(exact).max()
    assert np.abs(derived - exact).max() > 600.0 * by_points


def test_strains_are_those_of_the_probed_shape_at_gauss_points(swinging):
    """V = R^T r' by differences of the probe itself, in states that end a step, where poses and strains are one."""
    run, _ = swinging
    s, h = run.data["point_s"].values, 1e-5
    ends = slice(4, None, 4)  # three states are stored within a step
    frame = run.probe("beam", s=s).isel(time=ends)["frame"].values
    ahead, behind = (run.probe("beam", s=s + d).isel(time=ends)["position"].values for d in (h, -h))
    V = np.einsum("tgij,tgi->tgj", frame, (ahead - behind) / (2.0 * h))
    assert V - [0.0, 0.0, 1.0] == pytest.approx(run.data["strain"].values[ends, :, :3], abs=2e-8)


@pytest.mark.parametrize("times", [None, [0.0, 0.0123, 0.04]], ids=["stored", "between"])
def test_positions_alone_are_those_that_come_with_all_else(times):
    """Bit for bit, on elements of several orders, in the order in which places are asked for."""
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    about = {"section": vr.Rectangle(0.01, 0.01), "material": rubber}
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.2, 0, 0), elements=2, order=3, **about))
    model.add("arm", vr.Rod.straight((0.2, 0, 0), (0.2, 0, 0.1), elements=1, order=4, **about))
    model.attach("beam.end", "arm.start")
    model.clamp("beam.start")
    model.force("arm.end", (0, 0.02, 0.01), until=0.0)
    run = model.simulate(0.05)
    instants = None if times is None else instants_of(run, times)
    sites = [
        run.sites.along(*place) for place in (("arm", 0.09), ("beam", 0.111), ("arm", 0.0), ("beam", 0.2))
    ]
    whole = fields_at(run, sites, instants)
    alone = fields_at(run, sites, instants, (), turning=False)
    assert sorted(alone) == ["displacement", "position"]
    for name, field in alone.items():
        np.testing.assert_array_equal(field, whole[name])


def test_steps_are_found_where_their_ends_are_stored(swinging):
    run, dense = swinging
    ends = run.step_ends
    assert np.diff(ends).tolist() == [4] * int(run.data.attrs["steps"])
    assert np.diff(run.time[ends]) == pytest.approx(run.data["step_size"].values[ends[1:]])
    assert dense.step_ends is None
    assert step_ends(np.array([0.0, 0.3, 0.5]), np.array([0.0, 0.3, 0.2])).tolist() == [0, 1, 2]


def test_one_time_reads_four_states():
    known = np.linspace(0.0, 1.0, 1001)
    assert Instants.of(known, np.array([0.51234])).states.tolist() == [511, 512, 513, 514]
    assert Instants.of(known, np.array([0.9, 0.1004])).states.tolist() == [
        99,
        100,
        101,
        102,
        899,
        900,
        901,
        902,
    ]
    assert Instants.of(np.array([0.0, 0.5]), np.array([0.25])).weights == pytest.approx(
        np.array([[0.5, 0.5]])
    )


def test_a_large_file_is_read_in_pieces_only(monkeypatch, tmp_path):
    fresh = Run(rigid(0.002))
    path = fresh.save(tmp_path / "run.nc")
    monkeypatch.setattr(storage, "LARGE", 0.0)
    lazy = vr.load(path)
    found = lazy.probe("rod@0.3", 0.5131)
    exact = fresh.probe("rod@0.3", 0.5131)
    for name in exact:
        assert found[name].values == pytest.approx(exact[name].values, abs=1e-15)
    assert not lazy.data["position"].variable._in_memory
    assert not lazy.data["section_force"].variable._in_memory


def test_bodies_have_motion_only():
    run = Run(with_body())
    found = run.probe("plate", 0.513)
    d3, _ = director(np.array([0.513]))
    assert found["position"].values[0, 0] == pytest.approx(2.0 * LENGTH * d3[0], abs=1e-6)
    assert set(found) == {"position", "displacement", "rotation", "frame", "velocity", "angular_velocity"}
    with pytest.raises(vr.InputError, match="'plate' is a place on a body and has no strains"):
        run.probe(["rod.end", "plate"])


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda run: run.probe("rod.end", 2.5), r"time = 2\.5 s lies outside the run, which covers 0 to 2 s"),
        (lambda run: run.probe("rod.end", np.nan), "a finite number is needed"),
        (lambda run: run.probe("rod.end", []), "give one time"),
        (lambda run: run.probe([]), "at least one place"),
        (lambda run: run.probe("rod"), "not a place on it"),
        (lambda run: run.probe("rod.end", s=[0.1]), "arc lengths go with one rod"),
        (lambda run: run.probe("rod", s=[2.0]), "lies outside the rod"),
        (lambda run: run.probe("rod", s=[]), "give one arc length"),
    ],
)
def test_wrong_questions(ask, message):
    with pytest.raises(vr.InputError, match=message):
        ask(Run(rigid(0.1)))

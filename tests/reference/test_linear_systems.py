"""Linear systems in public: matrices against modes and responses, state space, reductions, files."""

import importlib.util

import numpy as np
import pytest
import scipy.io
import scipy.linalg
import scipy.signal

import viscorod as vr
from helpers.plain_text import flat

YOUNG, NU, DENSITY = 70e9, 0.33, 2700.0
KELVIN_VOIGT = vr.KelvinVoigt(2e-5, 2e-5)
PRONY = vr.Prony(extension_ratios=[0.05, 0.02], extension_times=[1e-2, 1e-4])
INPUTS = ["beam.end fz", "base az"]
OUTPUTS = ["beam.end uz", "beam.end az", "beam@0.2 strain bend_1", "beam.start reaction fz"]


def strip(damping, *, elements=2, order=3, **more):
    model = vr.Model()
    material = vr.Material(YOUNG, NU, DENSITY, damping=damping)
    section = vr.Rectangle(0.025, 0.003)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.4, 0, 0), section=section, material=material, elements=elements, order=order, **more
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    return model


@pytest.mark.parametrize("damping", [KELVIN_VOIGT, PRONY], ids=["Kelvin-Voigt", "Maxwell branches"])
def test_all_forms_give_the_direct_response(damping):
    """Second order, and first order with the branches as states, base acceleration included."""
    model = strip(damping)
    hertz = np.array([3.0, 15.0, 96.0, 300.0])
    system = model.linear(inputs=INPUTS, outputs=OUTPUTS)
    direct = model.frequency_response(inputs=INPUTS, outputs=OUTPUTS, frequencies=hertz).values
    np.testing.assert_allclose(system.response(hertz), direct, rtol=1e-7)
    np.testing.assert_allclose(system.first_order().response(hertz), direct, rtol=1e-7)
    kinds = system.state_space()
    assert isinstance(kinds, scipy.signal.StateSpace)
    assert kinds.D.shape == (4, 2)
    assert system.coordinates[-6:] == tuple(
        f"beam.end {word}" for word in ("d1", "d2", "d3", "about d1", "about d2", "about d3")
    )


def test_matrices_are_those_of_the_modes():
    """Eigenvalues of the state matrix are the eigenvalues of the modes; one retardation time makes D = tau K."""
    model = strip(KELVIN_VOIGT)
    system = model.linear(inputs="beam.end fz", outputs="beam.end uz")
    s = np.linalg.eigvals(system.first_order().A)
    for wanted in model.modes(6).eigenvalues:
        assert np.abs(s - wanted).min() < 1e-6 * abs(wanted)
    assert system.gyroscopic.nnz == 0
    assert np.abs(system.circulatory).max() < 1e-9 * np.abs(system.stiffness).max()
    np.testing.assert_allclose(
        system.damping.toarray(), 2e-5 * system.stiffness.toarray(), atol=1e-9 * np.abs(system.damping).max()
    )


def test_following_loads_are_circulatory():
    """A force P that follows turns with its section: its skew part is P/2; a dead one has none."""
    found = []
    for following in (False, True):
        model = strip(None)
        model.force("beam.end", (0, 0, -20.0) if following else (-20.0, 0, 0), following=following)
        system = model.linear(inputs="beam.end fz", outputs="beam.end uz")
        found.append(abs(system.circulatory).max())
    assert found[0] < 1e-9
    assert found[1] == pytest.approx(10.0, rel=1e-9)


def test_steps_in_time_agree_with_a_motion():
    """The step response of the state space about a bent shape, against the nonlinear motion under a small step."""
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.05, 0.05))
    model = vr.Model()
    rod = {"section": vr.Rectangle(0.01, 0.01), "material": rubber, "elements": 2, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **rod))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.03, 0))
    system = model.linear(inputs="beam.end fy", outputs="beam.end uy").state_space()
    small = 1e-5
    model.force("beam.end", (0, small, 0), time=vr.Ramp(0.0, 1e-6))
    run = model.simulate(1.0, initial="equilibrium", tolerance=1e-7, output_interval=0.1)
    moved = run.history("beam.end", "displacement").values[:, 1]
    # exact with a constant force: z' = A z + B
    size = len(system.A)
    step = scipy.linalg.expm(np.block([[system.A, system.B], [np.zeros((1, size + 1))]]) * 0.1)
    z, exact = np.append(np.zeros(size), 1.0), []
    for _ in run.time:
        exact.append((system.C @ z[:size])[0])
        z = step @ z
    np.testing.assert_allclose((moved - moved[0]) / small, exact, atol=2e-3 * np.abs(exact).max())


def test_joints_and_held_strains_are_eliminated():
    """A Kirchhoff rod on a driven hinge: conditions vanish in all combinations, and the response is the direct one."""
    model = strip(KELVIN_VOIGT, constraints="kirchhoff")
    model.supports.clear()
    model.revolute("beam.start", "ground", (0, 1, 0), name="motor", motion={"rz": vr.Constant(0.0)})
    outputs = ["beam.end uz", "beam@0.3 section_force shear_2", "beam@0.3 section_force bend_1"]
    settings = {"inputs": ["beam.end fz", "motor dwz"], "outputs": outputs}
    system = model.linear(**settings)
    assert abs(system.conditions @ system.combinations).max() < 1e-9
    hertz = np.array([2.0, 16.0, 90.0])
    direct = model.frequency_response(**settings, frequencies=hertz).values
    np.testing.assert_allclose(system.response(hertz), direct, rtol=1e-6)
    np.testing.assert_allclose(system.first_order().response(hertz), direct, rtol=1e-6)
    assert system.coordinates[0] == "combination 1"


def test_reductions_tell_their_errors():
    """Each error is the difference of responses found apart; damping survives in the poles; energy is lost."""
    system = strip(PRONY, elements=1, order=4).linear(inputs=["beam.end fz"], outputs=["beam.end uz"])
    for method, modes, allowed in [("modal", 4, 1e-5), ("craig_bampton", 6, 1e-2), ("balanced", 5, 1e-3)]:
        found = system.reduced(method, modes, band=(1.0, 150.0))
        assert found.error < allowed
        hertz = np.append(np.linspace(2.0, 149.0, 40), found.whole_poles[:2].imag / (2 * np.pi))
        exact = system.response(hertz)
        difference = np.abs(found.response(hertz) - exact).max() / np.abs(exact).max()
        assert difference < 1.5 * found.error + 1e-7
        assert found.passive
        np.testing.assert_allclose(found.poles[:2].real, found.whole_poles[:2].real, rtol=2e-2)
        if method == "balanced":
            assert np.abs(found.response(hertz) - exact).max() <= found.bound + 1e-7 * np.abs(exact).max()
        assert "Poles" in found.report()
        assert len(found.first_order().A) < len(system.first_order().A)


def test_static_correction_and_kept_ends():
    """At rest a modal reduction is exact; Craig-Bampton keeps the motions of the end as they are."""
    system = strip(KELVIN_VOIGT).linear(
        inputs=["beam.end fz", "beam@0.2 mx"], outputs=["beam.end uz", "beam@0.2 rx"]
    )
    found = system.reduced("modal", 2, band=(1.0, 100.0))
    np.testing.assert_allclose(found.response([0.01]), system.response([0.01]), rtol=1e-6, atol=1e-12)
    kept = system.reduced("craig_bampton", 3, band=(1.0, 100.0))
    assert kept.coordinates[2] == "beam.end d3"
    np.testing.assert_allclose(kept.response([0.01])[:, 0, 0], system.response([0.01])[:, 0, 0], rtol=1e-6)


def test_what_symmetry_forbids_has_no_error():
    """A force across one side of a rectangle neither twists it nor moves it along the other: round-off is no error."""
    model = strip(KELVIN_VOIGT)
    ports = {"inputs": "beam.end fz", "outputs": ["beam.end uz", "beam.end uy", "beam.end rx", "beam.end az"]}
    found = model.linear(**ports).reduced("modal", 6, band=(1.0, 100.0))
    assert found.error < 1e-3
    modal = model.frequency_response(**ports, frequencies=[1.0, 30.0, 100.0], method="modal")
    assert modal.data.attrs["modal_error"] < 1e-3


def test_a_free_body_is_reduced_beside_its_rigid_motions():
    """Nothing holds it: inertia balances the static shapes; roots of rigid motions are round-off and not told."""
    model = strip(KELVIN_VOIGT)
    model.supports.clear()
    system = model.linear("beam.start fz", ["beam.end uz"], about="reference")
    assert system.rigid == 6
    low = 0.5 * model.modes(7, about="reference").frequencies[6]
    errors = []
    for modes in (8, 12, 20):
        found = system.reduced("modal", modes, band=(low, 4.0 * low))
        assert found.poles[0].imag > 2.0 * np.pi * low
        assert "create energy" not in flat(found.report())
        assert "have no potential" not in flat(found.report())
        errors.append(found.error)
    assert errors[0] < 1e-4
    assert errors[2] < errors[1] < errors[0]


def test_files_hold_all(tmp_path):
    system = strip(PRONY).linear(inputs=INPUTS, outputs=OUTPUTS)
    with np.load(system.save(tmp_path / "strip.npz")) as stored:
        shape = stored["stiffness.shape"]
        K = np.zeros(shape)
        for row in range(shape[0]):
            mine = slice(stored["stiffness.indptr"][row], stored["stiffness.indptr"][row + 1])
            K[row, stored["stiffness.indices"][mine]] = stored["stiffness.data"][mine]
        np.testing.assert_array_equal(K, system.stiffness.toarray())
        assert list(stored["inputs"]) == INPUTS
        np.testing.assert_array_equal(stored["relaxation_times"], [1e-4, 1e-2])
    matlab = scipy.io.loadmat(system.save(tmp_path / "strip.mat"))
    np.testing.assert_array_equal(matlab["mass"].toarray(), system.mass.toarray())
    with pytest.raises(vr.InputError, match=r"not .npz or .mat"):
        system.save(tmp_path / "strip.csv")


def test_what_a_state_space_cannot_have():
    system = strip(KELVIN_VOIGT).linear(inputs=["base uz"], outputs="beam.end uz")
    with pytest.raises(vr.InputError, match="give the acceleration"):
        system.state_space()
    if importlib.util.find_spec("control") is None:
        with pytest.raises(vr.InputError, match="pip install control"):
            strip(None).linear(inputs="beam.end fz", outputs="beam.end uz").control()
    moved = strip(KELVIN_VOIGT).linear(inputs=["base az"], outputs="beam.end uz")
    with pytest.raises(vr.SolveError, match="every motion decays"):
        strip(None).linear(inputs="beam.end fz", outputs="beam.end uz").reduced(
            "balanced", 2, band=(1.0, 9.0)
        )
    with pytest.raises(vr.InputError, match="give 'modal'"):
        moved.reduced("guyan", band=(1.0, 9.0))
    with pytest.raises(vr.InputError, match=r"rod = 'x'"):
        moved.reduced("craig_bampton", band=(1.0, 9.0), rod="x")

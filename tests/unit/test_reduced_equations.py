"""The coefficients of the reduced intrinsic equations, what they refuse, and what a result tells of its modes."""

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.reduced.reduced_model import ReducedModel
from viscorod.solve.settings.motion import SimulateSettings

COUNT = 6


def blade(**given):
    """Return a bent blade of a material whose moduli have different times."""
    material = vr.Material(2e9, density=1200.0, poissons_ratio=0.3, damping=vr.KelvinVoigt(2e-3, 5e-3))
    given = {"section": vr.Rectangle(0.03, 0.004), "material": material, "elements": 2, "order": 4} | given
    model = vr.Model()
    model.add("blade", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), **given))
    model.clamp("blade.start")
    return model


def reduced(model, count=COUNT, damping="full"):
    """Return the reduced equations of a model at rest in its reference shape."""
    settings = SimulateSettings(1.0, initial="reference", formulation="intrinsic", damping=damping)
    discrete = DiscreteModel.of(model, settings)
    state = State.reference(discrete.problem)
    undamped = undamped_modes(linearise(discrete.static, state, scale=0.0), count)
    linearised = damping == "linearised"
    return ReducedModel.of(discrete.system, discrete.supports, undamped, state, count, linearised=linearised)


@pytest.mark.parametrize("damping", ["full", "linearised"])
def test_the_power_of_the_reduced_equations(damping):
    """Energy law: ``q1.q1' + q2.q2'`` is the power of forces less the dissipated one, for any state."""
    model = reduced(blade(), damping=damping)
    equations, (k, strains) = model.equations, model.equations.sizes
    assert np.array_equal(equations.turning, -equations.turning.transpose(1, 0, 2))
    random = np.random.default_rng(1)
    for _ in range(5):
        y, force = random.standard_normal(k + strains), random.standard_normal(k)
        change = equations.rates(y[None], force[None])[0]
        power, lost = float(y[:k] @ force), equations.dissipated(y, change)
        scale = np.abs(y) @ np.abs(change) + lost
        assert abs(y @ change - power + lost) < 1e-13 * scale
        assert lost > 0.0


def test_the_basis_is_orthonormal():
    """Velocities by mass, strains by stiffness, and strain rates of velocities by frequency."""
    model = reduced(blade())
    basis, k = model.basis, model.equations.sizes[0]
    momenta = np.einsum("nij,njk->nik", model.problem.mass, basis.velocity.reshape(-1, 6, k))
    assert np.abs(basis.velocity.T @ momenta.reshape(-1, k) - np.eye(k)).max() < 1e-10
    gram = np.einsum("kgi,lgi->kl", basis.strain, model.operators.stresses(basis.strain))
    assert np.abs(gram - np.eye(len(gram))).max() < 1e-9
    assert np.abs(model.equations.rate - np.diag(basis.omega)).max() < 1e-9 * basis.omega.max()


@pytest.mark.parametrize("damping", ["full", "linearised"])
def test_the_jacobian(damping):
    """Differences in the centre, which are exact for quadratic terms and nearly so for the cubic one."""
    model = reduced(blade(), damping=damping)
    equations, (k, strains) = model.equations, model.equations.sizes
    y, force = 1e-3 * np.random.default_rng(2).standard_normal(k + strains), np.zeros((1, k))
    J, h = equations.jacobian(y), 1e-4
    for column in range(k + strains):
        step = h * np.eye(k + strains)[column]
        rates = [equations.rates((y + sign * step)[None], force)[0] for sign in (1.0, -1.0)]
        wanted = (rates[0] - rates[1]) / (2.0 * h)
        assert np.abs(J[:, column] - wanted).max() < 1e-6 * np.abs(J).max()


@pytest.mark.parametrize(("bulk_time", "count"), [(2e-3, COUNT), (5e-3, 100)])
def test_small_motions_are_those_of_the_modes(bulk_time, count):
    """Linear limit: eigenvalues of the reduced equations at rest are those of ``Model.modes``.

    Equal times make damping proportional; others couple modes, of which all are needed for the same numbers.
    """
    damping = vr.KelvinVoigt(2e-3, bulk_time)
    model = blade(material=vr.Material(2e9, density=1200.0, poissons_ratio=0.3, damping=damping))
    found = model.modes(COUNT, about="reference")
    equations = reduced(model, count).equations
    values = np.linalg.eigvals(equations.jacobian(np.zeros(sum(equations.sizes))))
    for wanted in found.eigenvalues:
        assert np.abs(values - wanted).min() < 1e-8 * abs(wanted)


def test_two_clamps_have_six_self_stresses():
    """Equilibrium: strains beside those of vibrations do no work on any motion that the clamps allow."""
    model = blade()
    model.clamp("blade.end")
    found = reduced(model)
    k, strains = found.equations.sizes
    assert strains == k + 6
    assert np.abs(found.equations.rate[k:]).max() < 1e-8 * found.basis.omega.max()


REFUSED = {
    "joints": (lambda m: m.ball("blade@0.3", "ground"), "joints[0]"),
    "springs": (lambda m: m.spring("blade.end", stiffness={"ux": 1.0}), "springs[0]"),
    "rollers": (lambda m: m.roller("blade.end", (0, 0, 1)), "supports[1]"),
    "moving supports": (
        lambda m: m.clamp("blade.end", motion={"uy": vr.Ramp(0.0, 1.0)}),
        "supports[1].motion",
    ),
    "velocities": (
        lambda m: m.body_velocity("blade.end", velocity={"v1": vr.Ramp(0.0, 1.0)}),
        "supports[1].velocity",
    ),
    "changing rest strains": (
        lambda m: m.rest_strain("blade", (0, 0, 0, 1.0, 0, 0), time=vr.Ramp(0.0, 1.0)),
        "rest_strains[0].time",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_modes_cannot_carry_is_refused_by_name(kind):
    add, path = REFUSED[kind]
    model = blade()
    add(model)
    with pytest.raises(vr.InputError) as caught:
        model.simulate(0.1, initial="reference", formulation="intrinsic", modes=4)
    assert path in str(caught.value)
    assert "leave out modes" in str(caught.value)


@pytest.mark.parametrize(
    ("given", "path"),
    [({"material": "branches"}, "rods.blade"), ({"constraints": "kirchhoff"}, "rods.blade.constraints")],
)
def test_rods_that_modes_cannot_carry(given, path):
    if given.get("material") == "branches":
        prony = vr.Prony(shear_ratios=[0.1], shear_times=[0.01], constant="poissons_ratio")
        given = {"material": vr.Material(2e9, density=1200.0, poissons_ratio=0.3, damping=prony)}
    with pytest.raises(vr.InputError) as caught:
        blade(**given).simulate(0.1, initial="reference", formulation="intrinsic", modes=4)
    assert path in str(caught.value)


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"},
        {"integrator": "generalized_alpha"},
        {"formulation": "intrinsic", "modes": 0},
        {"formulation": "intrinsic", "modes": 201},
    ],
)
def test_settings_that_do_not_go_with_modes(given):
    with pytest.raises(vr.InputError) as caught:
        SimulateSettings(**({"duration": 1.0, "modes": 4} | given))
    assert "modes: " in str(caught.value)


def test_a_result_tells_of_its_modes(tmp_path):
    model = blade()
    model.velocity("blade", field=lambda s: ((0, s**2, 0), (0, 0, 2.0 * s)))
    run = model.simulate(0.02, initial="reference", formulation="intrinsic", modes=4, output_interval=0.01)
    back = vr.load(run.save(tmp_path / "run.nc"))
    assert back.data.attrs["modes"] == 4
    assert back.data.attrs["modes_fewer"] == 2
    assert "intrinsic formulation, 4 modes, full damping" in flat(back.report())
    assert "Modes: 4 vibrations up to" in flat(back.report())
    assert "in 2 modes positions differ by up to" in flat(back.report())
    alone = model.simulate(0.02, initial="reference", formulation="intrinsic", modes=1, output_interval=0.01)
    assert "what fewer of them would make of it is not known" in flat(alone.report())


def test_a_stopped_motion_in_modes_goes_on_bit_for_bit(tmp_path):
    """The state of the integrator, and of the motion in fewer modes beside it, is saved whole."""
    model = blade()
    model.gravity((0, 0, -9.81))
    model.velocity("blade", field=lambda s: ((0, s**2, 0), (0, 0, 2.0 * s)))
    given = {"initial": "reference", "formulation": "intrinsic", "modes": 4, "output_interval": 0.005}
    steps = iter(range(100))
    whole = model.simulate(0.03, **given)
    with pytest.raises(vr.SolveError):
        model.simulate(0.03, folder=tmp_path, stop=lambda: "enough" if next(steps) == 5 else "", **given)
    rest = model.simulate(0.03, folder=tmp_path, resume=True, **given)
    for name in ("position", "strain", "reaction", "numerical"):
        assert np.array_equal(rest.data[name].values, whole.data[name].values), name
    assert rest.data.attrs["modes_motion_gap"] == whole.data.attrs["modes_motion_gap"]

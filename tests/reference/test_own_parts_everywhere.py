"""A law of a section and a load of one's own in every analysis, against closed forms and a spring that pulls alike."""

from typing import Literal

import numpy as np
import pytest
from pydantic import Field
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

import viscorod as vr
from viscorod.model.actions.load import LOADS, AnyLoad
from viscorod.model.actions.load_effects import Arrows, PythonLaw
from viscorod.model.connections.place import PlaceField
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import NonNegative, Positive, Vector
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.model.sections.section_laws import SECTION_LAWS


class BendingSpring(AnySectionLaw):
    """A cubic spring about d2, with a loss that grows with the square of the curvature."""

    kind: Literal["bending_spring"] = Field(default="bending_spring", kw_only=True, repr=False)
    cubic: Positive = Key("moment at a curvature of 1/m", "N m")
    loss: NonNegative = Key("viscous moment at a curvature of 1/m and a rate of 1/(m s)", "N m", default=0.0)

    def parameters(self, stiffness):
        return np.array([self.cubic, self.loss])

    @staticmethod
    def respond(parameters, strain, rate, force, by_strain, by_rate):
        k, d = parameters[0], parameters[1]
        c, c_t = strain[4], rate[4]
        force[4] = k * c**3 + d * c**2 * c_t
        by_strain[4, 4] = 3.0 * k * c**2 + 2.0 * d * c * c_t
        by_rate[4, 4] = d * c**2
        return 0.25 * k * c**4, d * c**2 * c_t**2


class Magnet(AnyLoad):
    """A fixed pole that pulls a place with strength/distance^2, and brakes it along the line between them."""

    sees_motion = True
    kind: Literal["magnet"] = Field(default="magnet", kw_only=True, repr=False)
    at: PlaceField = Key("place")
    pole: Vector = Key("position of the pole", "m")
    strength: Positive = Key("force at a distance of 1 m", "N")
    braking: NonNegative = Key("force per velocity along the line", "N s/m", default=0.0)

    def places(self):
        return {"at": self.at}

    def place(self, model, placing):
        def seen(r, R, twist):
            line = np.array(self.pole) - r
            distance = np.sqrt(line @ line)
            return line / distance, distance, line / distance @ (R @ twist[:3])

        def wrench(r, R, twist):
            line, distance, speed = seen(r, R, twist)
            force = (self.strength / distance**2 - self.braking * speed) * line
            return np.array([*(R.T @ force), 0.0, 0.0, 0.0])

        def dissipated(r, R, twist):
            return self.braking * seen(r, R, twist)[2] ** 2

        placing.seeing_motion_at(self.at, PythonLaw(wrench, dissipated), self.factor)

    def arrows(self, model, t):
        return Arrows(f"magnet at {self.at}", "N", (model.place(self.at),), np.zeros((1, 3)))


@pytest.fixture(autouse=True)
def registered(monkeypatch):
    monkeypatch.setitem(SECTION_LAWS, "bending_spring", BendingSpring)
    monkeypatch.setitem(LOADS, "magnet", Magnet)


# A strip of length and EI 1 without mass, and a wheel of inertia 1 on its end: under moments about z it is bent to one
# curvature q, the angle of the wheel, with q_tt + d q^2 q_t + q + k q^3 = M exactly.
CUBIC, LOSS = 0.5, 0.05
K, D = "rods.strip.law.cubic", "rods.strip.law.loss"
ANGLE = "strip.end rz"


def strip(moment=1.0, cubic=CUBIC, loss=LOSS, **given):
    model = vr.Model()
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1.0, 1.0, 1.0], [1e-6, 1e-6, 1e-6, 1e-9, 1e-9, 2e-9])
    law = BendingSpring(cubic, loss)
    model.add("strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=4, law=law))
    model.add("wheel", vr.Body(1e-6, (1.0, 1.0, 1.0), centre=(1, 0, 0)))
    model.attach("wheel", "strip.end")
    model.clamp("strip.start")
    if moment:
        model.moment("strip.end", (0, 0, moment), **given)
    return model


def at_rest(moment=1.0, cubic=CUBIC):
    return brentq(lambda q: q + cubic * q**3 - moment, 0.0, moment, xtol=1e-15)


def stiffness(moment=1.0, cubic=CUBIC):
    """Return that of the wheel about the angle at rest."""
    return 1.0 + 3.0 * cubic * at_rest(moment, cubic) ** 2


def slope(function, at, part=1e-4):
    return (function(at * (1.0 + part)) - function(at * (1.0 - part))) / (2.0 * part * at)


def curvature(found):
    return found.data["strain"].values[-1, 0, 4]


def motion(time, cubic=CUBIC, loss=LOSS):
    """Return the angle after a time, let go from rest under a moment of 1."""

    def rates(_, y):
        return y[1], -y[0] - cubic * y[0] ** 3 - loss * y[0] ** 2 * y[1]

    ways = {"rtol": 1e-11, "atol": 1e-12}
    return solve_ivp(rates, (0.0, time), [at_rest(cubic=cubic), 0.0], **ways).y[0, -1]


def test_own_law_in_statics():
    """Closed form at rest, with derivatives; along a path; and that of a column, which the law leaves alone."""
    found = strip().equilibrium(derivatives=[K, D])
    assert curvature(found) == pytest.approx(at_rest(), rel=1e-6)
    by_cubic = slope(lambda k: at_rest(cubic=k), CUBIC)
    assert curvature(found.derivatives[K]) == pytest.approx(by_cubic, rel=1e-5)
    assert curvature(found.derivatives[D]) == pytest.approx(0.0, abs=1e-9)
    assert curvature(strip().path(2.0)) == pytest.approx(at_rest(2.0), rel=1e-6)
    column = strip(0.0)
    column.force("strip.end", (-1.0, 0, 0))
    assert column.buckling(1).load_factors[0] == pytest.approx(np.pi**2 / 4.0, rel=1e-4)


def test_own_law_in_sweeps_and_fits(tmp_path):
    """The numbers of the law are numbers of a case: swept, and found again from what it bends to (closed form)."""
    path = tmp_path / "case.toml"
    strip().to_toml(path)
    case = vr.load_case(path)
    cubics = [0.2, 0.5, 0.8]
    bent = vr.sweep(case, grid={K: cubics}, quantities={"curvature": curvature}, workers=1)
    expected = [at_rest(cubic=k) for k in cubics]
    assert bent.data["curvature"].values == pytest.approx(expected, rel=1e-6)
    loads = np.linspace(0.2, 1.0, 5)
    angles = np.array([at_rest(moment) for moment in loads])
    bent = (1.0 - np.cos(angles)) / angles
    record = vr.StaticRecord(loads, bent, place="strip.end", direction="y", noise=1e-6)
    strip(1.0, 0.3).to_toml(path, load_factors=loads.tolist())
    fit = vr.identify(vr.load_case(path), record, {K: 0.3}, profile=False)
    assert fit.parameters[K].value == pytest.approx(CUBIC, rel=1e-4)


@pytest.mark.parametrize("spin", [0.0, 0.3])
def test_own_law_in_small_motions(spin):
    """One oscillator about the angle at rest, s^2 + d q^2 s + 1 + 3 k q^2 = 0; a spin about z changes nothing."""
    q, k = at_rest(), stiffness()
    root = np.roots([1.0, LOSS * q**2, k])[0]
    if spin:
        found = strip().steady(spin=(0, 0, spin), modes=6)
        assert np.abs(found.eigenvalues - root).min() < 1e-5
        diagram = strip().campbell(axis=(0, 0, 1), band=(0.0, spin), count=2, modes=3)
    else:
        modes = strip().modes(6, derivatives=[K, D])
        at = int(np.argmin(np.abs(modes.eigenvalues - root)))
        assert modes.eigenvalues[at] == pytest.approx(root, rel=1e-5)
        frequency = slope(lambda cubic: np.sqrt(stiffness(cubic=cubic)) / (2.0 * np.pi), CUBIC)
        assert modes.derivatives[K].frequencies[at] == pytest.approx(frequency, rel=1e-4)
        ratio = q**2 / (2.0 * np.sqrt(k))
        assert modes.derivatives[D].damping_ratios[at] == pytest.approx(ratio, rel=1e-4)
        diagram = strip().stability(band=(0.5, 1.0), count=2, modes=3)
    assert np.abs(diagram.frequencies[-1] - root.imag / (2.0 * np.pi)).min() < 1e-5


def test_own_law_in_responses():
    """Closed form 1/(1 + 3 k q^2 - w^2 + i w d q^2), its derivatives, and the same from matrices."""
    frequencies = np.array([0.1, 0.2, 0.3])
    w = 2.0 * np.pi * frequencies

    def exact(cubic=CUBIC, loss=LOSS):
        q = at_rest(cubic=cubic)
        return 1.0 / (1.0 + 3.0 * cubic * q**2 - w**2 + 1j * w * loss * q**2)

    ports = {"inputs": "strip.end mz", "outputs": ANGLE}
    found = strip().frequency_response(**ports, frequencies=frequencies, derivatives=[K, D])
    assert found.response(ANGLE) == pytest.approx(exact(), rel=1e-5)
    for key, expected in (
        (K, slope(lambda cubic: exact(cubic=cubic), CUBIC)),
        (D, slope(lambda loss: exact(loss=loss), LOSS)),
    ):
        by_number = found.derivatives[key].of(lambda one: one.response(ANGLE))
        assert by_number == pytest.approx(expected, rel=1e-4)
    assert strip().linear(**ports).response(frequencies).ravel() == pytest.approx(exact(), rel=1e-5)


def test_own_law_in_periodic_motions():
    """Free: Duffing's w = pi sqrt(1 + k a^2)/(2 K(m)), m = k a^2/(2 (1 + k a^2)). Forced: the derivative by k."""
    free = strip(0.0, loss=0.0).periodic(mode=1, largest=1.2, outputs=[ANGLE], harmonics=7, stability=False)
    stretched = 1.0 + CUBIC * free.amplitude(0) ** 2
    exact = np.pi * np.sqrt(stretched) / (2.0 * ellipk(0.5 * (1.0 - 1.0 / stretched)))
    assert 2.0 * np.pi * free.frequencies == pytest.approx(exact, rel=1e-6)
    assert free.amplitude(0)[-1] > 1.2

    def forced(cubic, **given):
        found = strip(0.0, cubic).periodic(
            inputs="strip.end mz", amplitudes=[0.4], outputs=[ANGLE], frequency=0.09, levels=[0.8, 1.0],
            harmonics=5, step=0.5, **given
        )  # fmt: skip
        assert found.stable.all()
        return found

    found = forced(CUBIC, derivatives=[K])
    by_cubic = found.derivatives[K].of(lambda one: one.amplitude(0))[-1]
    assert by_cubic == pytest.approx(
        slope(lambda cubic: forced(cubic).amplitude(0)[-1], CUBIC, 1e-2), rel=1e-3
    )
    assert found.work == pytest.approx(found.loss, rel=1e-6)
    assert found.loss.min() > 1e-4


def test_own_law_in_motions(tmp_path):
    """The oscillator in time, by all methods, with derivatives, as a stream that is stopped, and in coupled steps."""
    model = strip(until=0.0)
    for ways in (
        {"tolerance": 1e-6},
        {"tolerance": 1e-6, "formulation": "intrinsic"},
        {"integrator": "midpoint", "time_step": 5e-3},
        {"integrator": "generalized_alpha", "time_step": 5e-3},
    ):
        run = model.simulate(2.0, errors=False, **ways)
        assert curvature(run) == pytest.approx(motion(2.0), abs=1e-5)
        assert run.energy.viscous[-1] + run.energy.kinetic[-1] > 0.0
        assert run.energy.numerical_fraction < 1e-4
    run = model.simulate(1.0, output_interval=0.5, derivatives=[K, D])
    for key, expected in (
        (K, slope(lambda cubic: motion(1.0, cubic=cubic), CUBIC)),
        (D, slope(lambda loss: motion(1.0, loss=loss), LOSS)),
    ):
        assert curvature(run.derivatives[key]) == pytest.approx(expected, rel=1e-4)

    def height(run):
        by = np.zeros(run.data["position"].shape)
        by[-1, -1, 1] = 1.0
        return run.data["position"].values[-1, -1, 1], {"position": by}

    given = {"duration": 1.0, "output_interval": 0.5, "adjoint": True}
    backwards = model.value_and_gradient([K, D], height, **given)
    value, gradient = backwards(backwards.values)
    forwards = [run.derivatives[key].of(lambda one: height(one)[0]) for key in (K, D)]
    assert value == pytest.approx(height(run)[0], rel=1e-9)
    assert gradient == pytest.approx(forwards, rel=1e-4)
    steps = iter(range(100))
    with pytest.raises(vr.SolveError, match="enough"):
        model.simulate(1.0, folder=tmp_path, stop=lambda: "enough" if next(steps) == 5 else "")
    rest = model.simulate(1.0, folder=tmp_path, resume=True)
    assert np.array_equal(rest.data["position"], model.simulate(1.0).data["position"])
    stepped = model.co_simulation([])
    stepped.step(0.5)
    stepped.step(0.5)
    assert stepped.position("strip.end") == pytest.approx(rest.positions_at(1.0)[-1], abs=1e-6)


# A cantilever with a mass on its end, which a pole pulls: a magnet, or a spring that pulls and brakes as it does.
POLE, STRENGTH, BRAKING = (1.1, 0.5, 0.1), 0.2, 0.3
S, B = "loads[0].strength", "loads[0].braking"
TIP = "strip.end"


def pulled(own, strength=STRENGTH, braking=BRAKING, force=None, **given):
    model = vr.Model()
    section = vr.StiffnessSection([1e3, 1e3, 1e3, 1.0, 2.0, 1.0], [1e-2, 1e-2, 1e-2, 1e-6, 1e-6, 2e-6])
    model.add("strip", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3))
    model.clamp("strip.start")
    model.add("tip", vr.Body(1.0, (0.1, 0.1, 0.1), centre=(1, 0, 0)))
    model.attach("tip", TIP)
    if own:
        model.loads.append(Magnet(TIP, POLE, strength, braking))
    else:
        model.line_spring(
            TIP, POLE, stiffness=lambda e: strength / (e + 0.2) ** 2, damping=braking, length=0.2
        )
    if force is not None:
        model.force(TIP, force, **given)
    return model


def both(analysis, **given):
    """Return what an analysis says of the magnet and of the spring."""
    return [analysis(pulled(own, **given)) for own in (True, False)]


def by_spring(analysis, at=STRENGTH, name="strength", part=1e-3, **given):
    """Return the derivative of what an analysis says of the spring."""
    return slope(lambda value: analysis(pulled(False, **{name: value}, **given)), at, part)


def test_own_load_in_statics():
    """The spring's equilibria, at the end of a path too, and its derivatives."""
    own, spring = both(lambda model: model.equilibrium().position(TIP))
    assert own == pytest.approx(spring, abs=1e-8)
    own, spring = both(lambda model: model.path(1.0).position(TIP), force=(0, 0.5, 0))
    assert own == pytest.approx(spring, abs=1e-8)
    found = pulled(True).equilibrium(derivatives=[S]).derivatives[S].of(lambda one: one.position(TIP))
    assert found == pytest.approx(by_spring(lambda model: model.equilibrium().position(TIP)), rel=1e-4)


def test_own_load_in_small_motions():
    """The spring's modes, responses, matrices and derivatives."""
    own, spring = both(lambda model: model.modes(3).eigenvalues)
    assert own == pytest.approx(spring, rel=1e-5, abs=1e-6)
    found = pulled(True).modes(3, derivatives=[S]).derivatives[S].frequencies
    assert found == pytest.approx(by_spring(lambda model: model.modes(3).frequencies), rel=1e-4)
    ports = {"inputs": f"{TIP} fy", "outputs": f"{TIP} uy"}
    frequencies = [0.1, 0.25, 0.4]

    def respond(model):
        return model.frequency_response(**ports, frequencies=frequencies).response(f"{TIP} uy")

    own, spring = both(respond)
    assert own == pytest.approx(spring, rel=1e-5)
    found = pulled(True).frequency_response(**ports, frequencies=frequencies, derivatives=[S])
    assert found.derivatives[S].of(lambda one: one.response(f"{TIP} uy")) == pytest.approx(
        by_spring(respond, part=1e-4), rel=1e-3
    )
    assert pulled(True).linear(**ports).response(frequencies).ravel() == pytest.approx(own, rel=1e-6)


def test_own_load_over_its_factor():
    """Stability: it grows with all loads, so that its modes at a factor are those of the spring of that strength."""
    found = pulled(True).stability(band=(0.5, 1.0), count=2, modes=3)
    for k, factor in enumerate((0.5, 1.0)):
        modes = pulled(False, factor * STRENGTH, factor * BRAKING).modes(3)
        assert np.sort(found.frequencies[k]) == pytest.approx(
            np.sort(np.abs(modes.eigenvalues.imag)) / (2.0 * np.pi), rel=1e-5
        )


def test_own_load_in_periodic_motions():
    """The spring's amplitudes and multipliers; all work is lost to the braking."""
    ways = {
        "inputs": f"{TIP} fy", "amplitudes": [0.05], "outputs": [f"{TIP} uy"], "frequency": 0.2,
        "levels": [0.8, 1.0], "harmonics": 5, "step": 0.5,
    }  # fmt: skip
    own, spring = both(lambda model: model.periodic(**ways))
    assert own.amplitude(0) == pytest.approx(spring.amplitude(0), rel=1e-7)
    assert np.sort(np.abs(own.multipliers[-1])) == pytest.approx(
        np.sort(np.abs(spring.multipliers[-1])), abs=1e-5
    )
    assert own.work == pytest.approx(own.loss, rel=1e-6)


def test_own_load_in_motions():
    """The spring's motions by all methods: what the braking takes is outside in place of in a damper; derivatives."""
    given = {"force": (0, -0.5, 0), "until": 0.0}
    for ways in (
        {},
        {"formulation": "intrinsic"},
        {"integrator": "midpoint", "time_step": 1e-2},
        {"integrator": "generalized_alpha", "time_step": 1e-2},
    ):
        own, spring = both(lambda model, ways=ways: model.simulate(1.0, errors=False, **ways), **given)
        assert own.positions_at(1.0)[-1] == pytest.approx(spring.positions_at(1.0)[-1], abs=1e-6)
        assert own.energy.outside[-1] == pytest.approx(spring.energy.viscous[-1], rel=1e-4)
        assert own.energy.outside[-1] > 5e-3
    found = pulled(True, **given).simulate(0.5, derivatives=[S, B]).derivatives

    def end(run):
        return run.positions_at(0.5)[-1]

    assert found[S].of(end) == pytest.approx(
        by_spring(lambda model: end(model.simulate(0.5)), **given), rel=1e-3
    )
    assert found[B].of(end) == pytest.approx(
        by_spring(lambda model: end(model.simulate(0.5)), BRAKING, "braking", **given), rel=1e-3
    )


def test_own_load_of_python_is_refused_by_what_turns():
    for turn in (
        lambda model: model.steady(spin=(0, 0, 1.0)),
        lambda model: model.campbell(axis=(1, 0, 0), band=(0.0, 1.0), count=2),
    ):
        with pytest.raises(vr.InputError, match=r"loads\[0\]: magnet: it is a Python function"):
            turn(pulled(True))

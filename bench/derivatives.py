"""Derivatives by numbers of a case: what they cost, and how far they are from extrapolated differences.

    python bench/derivatives.py [models [first]]
    python bench/derivatives.py cost [adjoint]

``models`` (200 by default) random models: rods clamped, free, hinged to a second one, with a body, a spring, held
strains, Maxwell branches, rest strains. Each is differentiated by one of its numbers, in statics, in modes and in a
motion, beside extrapolated differences of whole analyses (motions: equal steps of generalised alpha, or Radau IIA with
a small tolerance, so that differences see no change of steps). These tell by how much they may be wrong themselves;
where that is more than is asked for, as beside eigenvalues that change their order, nothing is compared. What is
compared is the largest error of all positions (eigenvalues) over the largest derivative; where a number hardly matters,
over the change that rounding could make of it. The gradient of a random scalar of the motion by all of its numbers, by
the adjoint (by neighbours where a model has none, which is counted), is compared with derivatives of the motion by
neighbours, over the root of the sum of squares of what adds up.

``cost`` prints processor time with p numbers over that without any, alternating, the least of several; the positions
(frequencies, responses) are read of all results and derivatives, as arrays, of equilibria also those of a data set.
``cost adjoint`` prints only that of a motion with the gradient of a misfit of its tip.
"""

from __future__ import annotations

import itertools
import sys
import time
import warnings
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

import viscorod as vr
from viscorod.analyses.derivatives.case_numbers import CaseNumber, with_values

FLOOR = {"equilibrium": 1e-7, "modes": 1e-7, "simulate": 1e-6, "adjoint": 1e-6}
"""Wanted relative accuracy."""


def random_model(rng: np.random.Generator) -> tuple[vr.Model, list[str]]:
    """Return a random model, and keys of numbers of it."""
    model = vr.Model()
    maxwell = rng.random() < 0.3
    times = rng.uniform(0.001, 0.02, 2)
    damping = (
        vr.Prony(shear_ratios=[0.2, 0.1], shear_times=sorted(times.tolist()), constant="bulk_modulus")
        if maxwell
        else vr.KelvinVoigt(*times.tolist())
    )
    modulus = 10.0 ** rng.uniform(6.0, 7.5)
    rubber = vr.Material(modulus, poissons_ratio=rng.uniform(0.2, 0.48), density=1100.0, damping=damping)
    model.materials["rubber"] = rubber
    width, height = rng.uniform(0.008, 0.02, 2)
    section = vr.Rectangle(width, height)
    end = np.array([0.3, *rng.uniform(-0.1, 0.1, 2)])
    given = {"section": section, "material": rubber, "order": 3}
    model.add("beam", vr.Rod.straight((0, 0, 0), tuple(end), elements=2, **given))
    keys = ["materials.rubber.youngs_modulus", "rods.beam.section.width", "materials.rubber.density"]
    keys.append("materials.rubber.damping.shear_time" + ("s[1]" if maxwell else ""))
    model.clamp("beam.start")
    model.gravity(tuple(rng.normal(size=3) * 4.0))
    keys.append("loads[0].acceleration[1]")
    stiffness = modulus * min(width, height) ** 3 * max(width, height) / 12.0
    model.force("beam.end", tuple(rng.normal(size=3) * 0.5 * stiffness / 0.09), until=0.0)
    keys.append("loads[1].value[1]")
    if rng.random() < 0.5:
        extra = (
            {"constraints": str(rng.choice(["inextensible", "unshearable"]))} if rng.random() < 0.5 else {}
        )
        tip = end + np.array([0.1, 0.0, 0.0])
        model.add("arm", vr.Rod.straight(tuple(end), tuple(tip), elements=1, **given, **extra))
        hinge = stiffness / 0.1 * rng.uniform(0.5, 2.0)
        model.revolute(
            "beam.end", "arm.start", axis=(0, 1, 0), stiffness={"rz": hinge}, damping={"rz": 0.01 * hinge}
        )
        keys += ["joints[0].stiffness.rz", "joints[0].damping.rz"]
        place, name = "arm.end", tuple(tip)
    else:
        place, name = "beam.end", tuple(end)
    if rng.random() < 0.5:
        model.add("tip", vr.Body(mass=0.02, centre=name, inertia=(2e-6, 3e-6, 4e-6)))
        model.attach(place, "tip")
        keys += ["bodies.tip.mass", "bodies.tip.inertia[1]"]
    if rng.random() < 0.5:
        model.rest_strain("beam", (0, 0, 0, *(rng.normal(size=3) * 0.5)))
        keys.append("rest_strains[0].value[3]")
    return model, keys


def differences(
    function: Callable[[float], np.ndarray], value: float, steps: Sequence[float]
) -> tuple[np.ndarray, float]:
    """Return the derivative by central differences, extrapolated, and by how much it may be wrong (Ridders 1982).

    Of all extrapolations the one is taken that is nearest to those that it is made of: large steps miss what is curved,
    small ones show what iterations leave.

    Args:
        function, value: its argument; steps: each half of the one before.
    """
    best, least, row = np.zeros(0), np.inf, []
    for step in steps:
        longer, row = row, [(function(value + step) - function(value - step)) / (2.0 * step)]
        for order, coarse in enumerate(longer, start=1):
            row.append(row[-1] + (row[-1] - coarse) / (4.0**order - 1.0))
            error = max(float(np.abs(row[-1] - one).max()) for one in (row[-2], coarse))
            if error < least:
                best, least = row[-1], error
    return best, least


STEPS = {
    "equilibrium": (1.6e-2, 8e-3, 4e-3, 2e-3),
    "modes": tuple(6.4e-2 * 0.5**k for k in range(11)),
    "simulate": (8e-3, 4e-3, 2e-3),
}
"""Steps of differences, as parts of a number."""


def compared(model: vr.Model, key: str, kind: str, rng: np.random.Generator) -> tuple[float, float]:
    """Return by how much a derivative differs from extrapolated differences, and by how much these may be wrong.

    Both over the largest derivative.
    """
    integrator = str(rng.choice(["generalized_alpha", "radau"]))
    settings = {
        "equilibrium": {},
        "modes": {"count": 4},
        "simulate": {"duration": 0.05, "integrator": integrator, "output_interval": 0.01},
    }[kind]
    if kind == "simulate":
        settings |= {"tolerance": 1e-9} if integrator == "radau" else {"time_step": 1e-3}

    def numbers(result: object) -> np.ndarray:
        if kind == "modes":
            return result.eigenvalues[result.rigid :]
        states = result.data["position"].values
        return states[-1:] if kind == "equilibrium" else states  # load steps of neighbours may be others

    number = CaseNumber.of(model, key)
    found = getattr(model, kind)(**settings, derivatives=[key])
    mine = found.derivatives[key].of(numbers)

    def at(value: float) -> np.ndarray:
        result = getattr(with_values(model, {key: value}), kind)(**settings)
        if kind == "simulate" and result.outcome != "completed":
            raise vr.SolveError(f"the motion of a neighbour ended: {result.outcome}")
        return numbers(result)

    expected, error = differences(at, number.value, [step * number.size for step in STEPS[kind]])
    scale = np.abs(numbers(found)).max() if kind == "modes" else 0.3
    noise = 1e-3 * scale / number.size  # a number that changes less than a thousandth per 100 %
    size = max(float(np.abs(expected).max()), noise)
    return float(np.abs(mine - expected).max()) / size, error / size


def adjoint_error(model: vr.Model, keys: list[str], rng: np.random.Generator) -> tuple[float, str, bool]:
    """Return the largest error of a gradient and the number that has it, and whether the adjoint found it."""
    settings = {"duration": 0.05, "output_interval": 0.01}
    run = model.simulate(**settings, derivatives=keys)
    names = ("position", "rotation", "velocity", "angular_velocity")
    weights = {name: rng.normal(size=run.data[name].shape) for name in names}

    def scalar(found: vr.Run) -> tuple[float, dict[str, np.ndarray]]:
        return sum(float(np.vdot(by, found.data[name].values)) for name, by in weights.items()), weights

    function = model.value_and_gradient(keys, scalar, adjoint=True, **settings)
    _, gradient = function(function.values)
    errors = []
    for key, found in zip(keys, gradient, strict=True):
        parts = [weights[name] * run.derivatives[key].data[name].values for name in names]
        size = np.sqrt(sum(float((part**2).sum()) for part in parts))
        number = CaseNumber.of(model, key)
        noise = 1e-3 * np.sqrt(sum(float(part.size) for part in parts)) / number.size
        errors.append(abs(found - sum(float(part.sum()) for part in parts)) / max(size, noise))
    worst = int(np.argmax(errors))
    return errors[worst], keys[worst], function.way == "adjoint"


def accuracy(first: int, count: int) -> None:
    """Print how far derivatives of random models are from extrapolated differences, from the ``first`` model on."""
    errors: dict[str, list[float]] = {kind: [] for kind in FLOOR}
    adjoints, unknown = 0, 0
    for k in range(first, first + count):
        rng = np.random.default_rng([21, k])  # each model can be made alone
        model, keys = random_model(rng)
        key = str(rng.choice(keys))
        for kind, found in errors.items():
            uncertain, by = 0.0, key
            try:
                if kind == "adjoint":
                    error, by, known = adjoint_error(model, keys, rng)
                    adjoints += known
                else:
                    error, uncertain = compared(model, key, kind, rng)
            except (vr.SolveError, vr.InputError) as problem:
                print(f"model {k}, {kind} by {key}: {problem}", flush=True)
                continue
            if error > FLOOR[kind]:
                own = f", differences uncertain by {uncertain:.1e}" if uncertain else ""
                print(f"model {k}, {kind} by {by}: {error:.1e}{own}", flush=True)
            if uncertain > FLOOR[kind]:
                unknown += 1
            else:
                found.append(error)
    for kind, found in errors.items():
        if not found:
            continue
        median, most = np.median(found), np.max(found)
        within = np.count_nonzero(np.array(found) <= FLOOR[kind])
        print(
            f"{kind}: {within} of {len(found)} within {FLOOR[kind]:.0e}; median {median:.1e}, largest {most:.1e}"
        )
    print(f"{adjoints} of the gradients by the adjoint; {unknown} differences too uncertain to tell")


def swing(elements: int) -> vr.Model:
    """Return a rubber cantilever under gravity that is let go."""
    model = vr.Model()
    rubber = vr.Material(2.5e6, poissons_ratio=0.45, density=1100.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model.materials["rubber"] = rubber
    given = {"section": vr.Rectangle(0.02, 0.01), "material": rubber}
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), elements=elements, order=3, **given))
    model.clamp("beam.start")
    model.gravity((0, 0, -9.81))
    model.force("beam.end", (0, 0.02, 0), until=0.0)
    return model


def hinged() -> vr.Model:
    """Return a rubber cantilever that is let go, with an inextensible arm and a body on a damped hinge at its end."""
    model = swing(3)
    given = {"section": vr.Rectangle(0.015, 0.01), "material": model.materials["rubber"]}
    given |= {"elements": 1, "order": 3, "constraints": "inextensible"}
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.38, 0.02, 0.01), **given))
    model.add("tip", vr.Body(mass=0.01, centre=(0.38, 0.02, 0.01), inertia=(1e-6, 2e-6, 3e-6)))
    model.attach("arm.end", "tip")
    hinge = {"stiffness": {"rz": 0.02}, "damping": {"rz": 2e-4}}
    model.revolute("beam.end", "arm.start", axis=(0.1, 1, 0.2), **hinge)
    return model


def cost() -> None:
    """Print what derivatives cost."""
    keys = ["materials.rubber.youngs_modulus", "materials.rubber.damping.shear_time"]
    keys += ["rods.beam.section.width", "loads[1].value[1]"]
    response = {"inputs": "base uz", "outputs": "beam.end uz", "band": (1.0, 60.0)}
    numbers = {
        "equilibrium": lambda found: found.field("position"),
        "equilibrium, data set": lambda found: found.data["position"].values,
        "modes": lambda found: found.frequencies,
        "simulate": lambda found: found.field("position"),
        "frequency_response": lambda found: found.values,
    }
    kinds = {
        "equilibrium": {},
        "equilibrium, data set": {},
        "modes": {},
        "simulate": {"duration": 1.0, "output_interval": 0.01},
        "frequency_response": response,
    }
    for elements in (8, 60):
        model = swing(elements)
        for kind, settings in kinds.items():
            analysis = getattr(model, kind.partition(",")[0])
            times = dict.fromkeys((0, 1, 2, 4), np.inf)
            for _ in range(20 if kind.startswith("equilibrium") else 4):
                for p in times:
                    began = time.process_time()
                    found = analysis(**settings, derivatives=keys[:p])
                    numbers[kind](found)
                    for derivative in found.derivatives.values():
                        derivative.of(numbers[kind])
                    times[p] = min(times[p], time.process_time() - began)
            parts = ", ".join(f"p = {p}: {t / times[0]:.2f}" for p, t in times.items() if p)
            print(f"{elements} elements, {kind} ({times[0]:.3f} s): {parts} of it")


def misfit(run: vr.Run) -> tuple[float, dict[str, np.ndarray]]:
    """Return half the sum of squares of the tip's positions, and its derivatives."""
    weights = np.zeros(run.data.position.shape)
    weights[:, -1] = run.data.position.values[:, -1]
    return 0.5 * float((weights**2).sum()), {"position": weights}


def cost_of_adjoint() -> None:
    """Print what the gradient of one scalar costs, by the adjoint and by neighbours."""
    material = "materials.rubber."
    arrays = ["youngs_modulus", "damping.shear_time", "damping.bulk_time", "poissons_ratio", "density"]
    keys = [material + name for name in arrays]
    keys += ["rods.beam.section.width", "rods.beam.section.height", "loads[1].value[1]"]
    swings = ((8, 1.0), (60, 1.0), (8, 20.0), (60, 5.0))
    models = [(f"{count} elements", swing(count), duration) for count, duration in swings]
    near = itertools.count(1.0)  # what was asked for last is remembered
    for name_of, model, duration in [("hinged arm", hinged(), 1.0), *models]:
        settings = {"duration": duration, "output_interval": 0.01 * duration**0.5}
        cases: dict[str, Callable[[], object]] = {"run": partial(model.simulate, **settings)}
        for p in (1, 2, 4, 8):
            f = model.value_and_gradient(keys[:p], misfit, adjoint=True, **settings)
            cases[f"adjoint, {p}"] = lambda f=f: f(f.values * (1.0 + 1e-12 * next(near)))
            g = model.value_and_gradient(keys[:p], lambda run: misfit(run)[0], **settings)
            cases[f"neighbours, {p}"] = lambda g=g: g(g.values * (1.0 + 1e-12 * next(near)))
        times = dict.fromkeys(cases, np.inf)
        for _ in range(4):
            for name, case in cases.items():
                began = time.process_time()
                case()
                times[name] = min(times[name], time.process_time() - began)
        parts = ", ".join(f"{name}: {t / times['run']:.2f}" for name, t in times.items())
        print(f"{name_of}, {duration:.0f} s ({times['run']:.3f} s): {parts}", flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    if "adjoint" in sys.argv:
        cost_of_adjoint()
    elif "cost" in sys.argv:
        cost()
    else:
        given = [int(word) for word in sys.argv[1:]] or [200]
        accuracy(given[1] if len(given) > 1 else 0, given[0])

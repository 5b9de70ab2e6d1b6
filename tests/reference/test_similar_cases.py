"""Invariance of the whole program: shipped cases turned in space, or measured in other units, give the same results.

Everything is turned or measured anew: rods, bodies, axes of supports and joints, loads, weight. Step sizes and
iterations agree as well, since errors are measured in body axes and compared with lengths of the model.
"""

import copy
import functools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from helpers.damaged_cases import CASES
from helpers.similar_cases import scaled, turned
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.errors import SolveError

STEPS = 12
# Analyses without states that follow each other, coarse here, and what they are compared by.
STATELESS = {
    "becks_column": {"stability": {"band": [6.0, 14.0], "count": 3}},
    "tall_rod": {"buckling": {"count": 2}},
    "whirling_shaft": {"campbell": {"band": [150.0, 300.0], "count": 2, "modes": 2}},
    "shaken_strip": {"response": {"band": [10.0, 20.0]}},
    "clamped_strip": {"periodic": {"frequencies": [90.0, 92.0]}},
}
SHIPPED = sorted(set(CASES) - {"everything", *STATELESS})
TURNS = {
    "skew": Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(),
    "cyclic": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
}
NEXT = {"x": "y", "y": "z", "z": "x"}


def first_steps(content):
    """Some steps of a case, or of one that ends at a displacement along an axis."""
    count = 0
    if "path" in content:  # which seeks special points between its points on a coarse mesh too
        rods = {name: rod | {"elements": 2, "order": 3} for name, rod in content["rods"].items()}
        content = content | {"rods": rods}
    if "simulate" in content:  # steps that do not depend on the rounding of an estimated error
        content = content | {"simulate": {"tolerance": 1e-4} | content["simulate"]}

    def progress(*_):
        nonlocal count
        count += 1

    try:
        return run_case(
            case_from_dict(content), progress=progress, stop=lambda: "enough" if count >= STEPS else ""
        )
    except SolveError as error:
        return error.run


@functools.cache
def own_steps(name):
    return first_steps(CASES[name])


# A path that ends at a displacement along a global axis can be turned from axis to axis only. Round-off of a shear
# stiffness of 1e15 N, which skew axes bring, chooses the first step of the bridge.
ALONG_AXES_ONLY = {"deep_arch", "prestressed_bridge"}
TURNED = [
    (name, kind) for name in SHIPPED for kind in TURNS if kind == "cyclic" or name not in ALONG_AXES_ONLY
]


@pytest.mark.parametrize(("name", "kind"), TURNED)
def test_a_turned_case_gives_the_turned_result(name, kind):
    own, Q = copy.deepcopy(CASES[name]), TURNS[kind]
    other = turned(own, Q)
    if "axis" in other.get("path", {}):
        other["path"]["axis"] = NEXT[own["path"]["axis"]]
    there, here = first_steps(other), own_steps(name)
    size = float(here.data.attrs["scale_length"])
    instants = here.data[here.dimension].values
    np.testing.assert_allclose(
        there.data[there.dimension].values, instants, rtol=0, atol=1e-7 * instants.max()
    )
    np.testing.assert_allclose(
        there.data.position.values, here.data.position.values @ Q.T, rtol=0, atol=1e-7 * size
    )
    strain = here.data.strain.values
    np.testing.assert_allclose(
        there.data.strain.values, strain, rtol=0, atol=1e-6 * float(np.abs(strain).max())
    )
    if "simulate" in own:
        assert there.data.attrs["iterations"] == here.data.attrs["iterations"]


SMALL, ODD = (1e6, 1e9, 1e3), (0.3, 7.0, 0.02)
SCALED = [(name, *ODD) for name in SHIPPED] + [(name, *SMALL) for name in SHIPPED[::3]]


@pytest.mark.parametrize(("name", "length", "mass", "time"), SCALED)
def test_a_case_in_other_units_gives_the_same_result(name, length, mass, time):
    """So there are no numbers with units in the program, and the units of the schema are those that are used."""
    own = CASES[name]
    here, there = own_steps(name), first_steps(scaled(own, length, mass, time))
    size = length * float(here.data.attrs["scale_length"])
    factor = {"time": time, "spin": 1.0 / time}.get(here.dimension, 1.0)
    instants = factor * here.data[here.dimension].values
    np.testing.assert_allclose(
        there.data[there.dimension].values, instants, rtol=0, atol=1e-6 * instants.max()
    )
    np.testing.assert_allclose(
        there.data.position.values, length * here.data.position.values, rtol=0, atol=1e-7 * size
    )
    joule = mass * length**2 / time**2
    for word in ("elastic", "kinetic", "viscous", "external"):
        if word in here.data:
            energy = joule * here.data[word].values
            np.testing.assert_allclose(
                there.data[word].values, energy, rtol=0, atol=1e-6 * float(np.abs(energy).max())
            )
    if "simulate" in own:
        assert there.data.attrs["iterations"] == here.data.attrs["iterations"]


def coarse(name):
    """A case of an analysis without states, made small."""
    content = copy.deepcopy(CASES[name])
    for word, keys in STATELESS[name].items():
        content[word] |= keys
    return content


@functools.cache
def own_result(name):
    return run_case(case_from_dict(coarse(name)))


def numbers(result):
    """Numbers of a result without states -> the power of the time in their units."""
    match result.kind:
        case "buckling":
            return [(result.load_factors, 0)]
        case "stability":
            return [(result.frequencies, -1), (np.array([limit.at for limit in result.limits]), 0)]
        case "campbell":
            limits = np.array([limit.at for limit in result.limits])
            return [(result.frequencies, -1), (limits, -1)]
        case "response":
            return [(result.poles, -1), (np.array([abs(result.response()).max()]), 0)]
        case "periodic":
            amplitude = result.amplitude(0)
            return [(result.frequencies, -1), (amplitude / amplitude.max(), 0)]


def compare(there, here, time):
    assert there.kind == here.kind
    for (found, power), (expected, _) in zip(numbers(there), numbers(here), strict=True):
        assert expected.size
        np.testing.assert_allclose(
            found * time**-power, expected, rtol=0.0, atol=1e-5 * float(np.abs(expected).max())
        )


@pytest.mark.parametrize("name", STATELESS)
def test_a_turned_case_without_states_gives_the_same_numbers(name):
    """From axis to axis, with the words of inputs and outputs."""
    content = turned(coarse(name), TURNS["cyclic"])
    for part in (content.get("response", {}), content.get("periodic", {})):
        for key in {"inputs", "outputs"} & part.keys():
            part[key] = [word[:-1] + NEXT[word[-1]] for word in part[key]]
    compare(run_case(case_from_dict(content)), own_result(name), 1.0)


@pytest.mark.parametrize("name", STATELESS)
def test_a_case_without_states_in_other_units_gives_the_same_numbers(name):
    length, mass, time = 0.3, 7.0, 0.02
    content = scaled(coarse(name), length, mass, time)
    if "periodic" in content:  # their unit is that of the inputs, here newtons
        amplitudes = CASES[name]["periodic"]["amplitudes"]
        content["periodic"]["amplitudes"] = [mass * length / time**2 * a for a in amplitudes]
    compare(run_case(case_from_dict(content)), own_result(name), time)

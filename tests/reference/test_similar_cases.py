"""Invariance of the whole program: shipped cases turned in space, or measured in other units, give the same results.

Everything is turned or measured anew: rods, bodies, axes of supports and joints, loads, weight. Step sizes and
iterations agree as well, since errors are measured in body axes and compared with lengths of the model.
"""

import copy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from helpers.damaged_cases import CASES
from helpers.similar_cases import scaled, turned
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.errors import SolveError

STEPS = 12
SHIPPED = sorted(set(CASES) - {"everything"})
TURNS = {
    "skew": Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix(),
    "cyclic": np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
}
NEXT = {"x": "y", "y": "z", "z": "x"}


def first_steps(content):
    """Some steps of a case, or of one that ends at a displacement along an axis."""
    count = 0
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
    there, here = first_steps(other), first_steps(own)
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


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize(
    ("length", "mass", "time"), [(1e6, 1e9, 1e3), (0.3, 7.0, 0.02)], ids=["small", "odd"]
)
def test_a_case_in_other_units_gives_the_same_result(name, length, mass, time):
    """So there are no numbers with units in the program, and the units of the schema are those that are used."""
    own = CASES[name]
    here, there = first_steps(own), first_steps(scaled(own, length, mass, time))
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

"""Kernels as the Python functions that they are, in a process of its own, against their machine code."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np

import viscorod as vr
from helpers.small_frame import Moved, section
from viscorod.mechanics.compilation.compiled import KERNELS, announce_compilation
from viscorod.mechanics.elements.branch_memory import begin_branches
from viscorod.mechanics.elements.internal_force import ElementWork, GaussStates, internal_forces
from viscorod.solve.problem.external_loads import ExternalLoads


def element():
    """One element of order 3, clamped."""
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section(), elements=1, order=3, d1=(0, 0.3, 1))
    model.add("rod", rod)
    model.clamp("rod.start")
    return model


def numbers():
    """Internal forces of the element in motion by both kernels, and where its end comes to rest under a load."""
    at = Moved(element())
    forces = np.zeros((1, at.n, 6))
    points, work = GaussStates.of(at.elements, 1), ElementWork.of(3)
    internal_forces(
        at.elements, at.state.r[None], at.state.q[None], at.state.twist[None], points, work, forces
    )
    at.system.assemble(at.state, ExternalLoads(at.problem).at(0.0), None, tangent=True, moving=True)
    model = element()
    model.force("rod.end", (0.1, 0.2, 0.3))
    announce_compilation(internal_forces)
    shape = model.equilibrium().position("rod.end")
    return [forces.ravel(), at.system.internal.ravel(), at.system.matrix.blocks.ravel(), np.asarray(shape)]


def test_kernels_are_python_functions(tmp_path):
    """Numba switched off: no kernel is compiled, and all numbers agree to rounding."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, __file__, str(tmp_path / "numbers.npz")]
    subprocess.run(command, check=True, env=environment)
    with np.load(tmp_path / "numbers.npz") as found:
        assert int(found["kernels"]) == 0
        for k, expected in enumerate(numbers()):
            np.testing.assert_allclose(
                found[f"arr_{k}"], expected, rtol=0, atol=1e-13 * np.abs(expected).max()
            )


def test_warmup_has_nothing_to_compile():
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "viscorod", "warmup"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    assert done.stdout.startswith("nothing to compile")


if __name__ == "__main__":
    np.savez(sys.argv[1], *numbers(), kernels=len(KERNELS))


def test_a_kernel_that_only_motions_need_is_announced_by_these(monkeypatch):
    """An equilibrium of Maxwell branches never compiles ``begin_branches``, and does not say so every time."""
    said = []
    monkeypatch.setattr("viscorod.analyses.discrete.announce_formulation", said.append)
    monkeypatch.setattr("viscorod.analyses.motion_start.announce_formulation", said.append)
    model = vr.Model()
    damping = vr.Prony(shear_ratios=[0.3], shear_times=[0.1], constant="bulk_modulus")
    rubber = vr.Material(1e6, 0.45, 1100.0, damping=damping)
    rod = vr.Rod.straight((0, 0, 0), (0, 0, 0.1), section=vr.Circle(0.01), material=rubber, elements=1)
    model.add("rod", rod)
    model.clamp("rod.start")
    model.equilibrium()
    assert not said
    model.simulate(1e-3)
    assert said == [begin_branches]

"""Linear dynamics of assemblies: joints, springs, bodies, held strains and Maxwell branches.

Modes: a small vibration is a sum of the damped modes at that state, each with its decay and frequency. Nonlinear
motions of the geometric formulation, which share no solver with linear dynamics, tend to them as they get small.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

LINEAR = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}
C = np.diag([50.0, 50.0, 1e2, 1.0, 1.5, 0.8])
M = [1.0, 1.0, 1.0, 1e-2, 1e-2, 2e-2]
TIMES = (0.05, 0.5)


def assembly(kind):
    """A cantilever of one element that is short of nothing, or an L of two rods with a sprung hinge."""
    branches = [vr.MaxwellBranch(time=t, stiffness=0.3 * C) for t in TIMES]
    kept = {"branches": branches} if "branches" in kind else {"damping": 0.05 * C}
    kept = {} if "elastic" in kind else kept
    section = vr.StiffnessSection(C, M, **kept)
    more = {"constraints": "kirchhoff"} if "held" in kind else {}
    model = vr.Model()
    model.add("a", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=3, **more))
    model.clamp("a.start")
    if "joint" in kind:
        model.add("b", vr.Rod.straight((1, 0, 0), (1, 0, -1), section=section, elements=1, order=3, **more))
        acting = {"stiffness": {"rz": 2.0}, "damping": {"rz": 0.1}}
        model.revolute("b.start", "a.end", (0, 1, 0), name="hinge", **acting)
    if "spring" in kind:
        model.spring("a.end", stiffness={"uz": 5.0}, damping={"uz": 0.2}, name="strut")
    if "body" in kind:
        model.add("disc", vr.Body(0.5, (1e-2, 2e-2, 2e-2), centre=(1, 0, 0)))
        model.attach("a.end", "disc")
    return model


def struck(kind, force, duration, tolerance, **settings):
    """Loaded at the end of the first rod at once."""
    model = assembly(kind)
    model.force("a.end", (0.3 * force, 0, force))
    given = {"initial": "reference", "output_interval": 0.025, "tolerance": tolerance}
    return model.simulate(duration, **given, **settings)


@pytest.mark.parametrize(
    "kind", ["held", "joint", "held joint", "spring", "body", "branches", "held branches"]
)
def test_vibrations_are_sums_of_damped_modes(kind):
    """Decay and frequency of all modes: what they leave of the motion, and that others leave more."""
    run = struck(kind, 1.0, 8.0 if "joint" in kind else 4.0, 3e-7, **LINEAR)
    moved = run.history("a.end").values[:, 2]
    s = assembly(kind).modes(18, about="reference").eigenvalues
    times = run.time
    # branches relax in each mode at rates of their own, all strains alike
    creep = relaxations(kind) if "branches" in kind else np.zeros(0)

    def left(change):
        waves = np.exp(np.outer(times, s * change))
        basis = np.concatenate([waves.real, waves.imag, np.exp(np.outer(times, [0.0, *creep]))], axis=1)
        weights = np.linalg.lstsq(basis, moved, rcond=1e-12)[0]
        return np.abs(basis @ weights - moved).max() / np.abs(moved).max()

    assert left(1.0) < 1e-6
    assert left(1.0 + 1e-3) > 1e-5


def relaxations(kind):
    """Real roots of ``s^2 + w^2 (1 + sum 0.3 s t/(1 + s t))`` of the slowest modes: those without branches have w."""
    bare = assembly(kind.replace("branches", "elastic"))
    first, second = (np.array([t, 1.0]) for t in TIMES)
    found = []
    for w in np.abs(bare.modes(18, about="reference").eigenvalues) ** 2:
        whole = np.polymul([1.0, 0.0, w], np.polymul(first, second))
        for t, other in zip(TIMES, (second, first), strict=True):
            whole = np.polyadd(whole, np.polymul([0.3 * w * t, 0.0], other))
        roots = np.roots(whole)
        found += list(roots.real[np.abs(roots.imag) < 1e-9 * np.abs(roots)])
    return np.array(found)


@pytest.mark.parametrize("kind", ["joint spring", "held branches"])
def test_small_motions_of_the_nonlinear_model(kind):
    """Limit: positions, section forces, hinges, reactions and losses under a force of 1e-3."""
    size = 1e-3
    linear = struck(kind, size, 0.5, 1e-9, **LINEAR).data
    exact = struck(kind, size, 0.5, 1e-9).data
    for field, close in (("position", 1e-6), ("section_force", 2e-3), ("reaction", 2e-3)):
        scale = 1.0 if field == "position" else np.abs(exact[field].values).max()
        # forces of conditions in the very first state are those of a load that jumps
        assert np.abs(linear[field].values - exact[field].values)[1:].max() < close * scale
    if "joint" in kind:
        for field in ("joint_value", "joint_rate", "joint_force"):
            scale = np.abs(exact[field].values).max()
            assert np.abs(linear[field].values - exact[field].values)[1:].max() < 2e-3 * scale
    lost = linear.viscous.values[-1]
    assert lost == pytest.approx(exact.viscous.values[-1], rel=2e-3)
    assert lost > 0.05 * exact.elastic.values[0]
    if "branches" in kind:
        assert linear.branch_loss.values[-1].sum() == pytest.approx(lost, rel=1e-9)

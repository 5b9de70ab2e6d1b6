"""The planar cases in MuJoCo: chains of rigid links with elastic, damped joints, or an elastic rod (`flex`)."""

from __future__ import annotations

import time
from importlib.metadata import version
from math import ceil, sqrt

import mujoco
import numpy as np

from .cases import Case, Floats, PeerRun
from .chain import held_angles

PROGRAM = "MuJoCo"


def run(
    case: Case,
    elements: int,
    *,
    kind: str = "hinges",
    time_step: float = 5e-4,
    integrator: str = "Euler",
    repeats: int = 3,
) -> PeerRun:
    """Compute the planar `case` with `elements`.

    How it is modelled:
        kind "hinges": rigid links in joint coordinates (one angle each), with the links' own mass and rotary
            inertia; a hinge between two links has the stiffness EI/h and the damping tau EI/h, the one at the
            clamp twice that, as half an element lies behind it. Neither shear nor stretch: that part of the error
            stays with any number of elements, 5e-3 L for the soft cantilever. (It is less with 32 elements, where the
            error of the mesh has the opposite sign.)
        kind "joints": the same with two sliding joints more for each link, along and across it, which carry
            stretch and shear with stiffness and damping of their own: everything the reference has. The
            stiffness is explicit in the integrators, so the damping times must be well above half a step. Joint
            coordinates of one long chain cost more than in proportion to its length.
        kind "flex": MuJoCo's discrete elastic rod, `flexcomp` of one dimension with a box section, bending and
            twist, edges kept at their length by equality constraints, point masses, half of one at the tip. (With
            the constraints' default stiffness the rod stretches by 2.5 per cent and the error is a quarter of its
            length.) Its first edge is clamped, so the rod begins half an element before the clamp and has
            elements of length L/(n - 1/2). The material damping is MuJoCo's, proportional to the stiffness with
            the same time. No shear. Needs MuJoCo 4 and its "discrete" integrator.

    Settings tried: "Euler" and "implicitfast" (damping implicit, stiffness explicit) have the same error and time;
    "implicit" has the same error in three to five times the time; "discrete" (stiffness implicit, too) has four
    times the error at 2e-3 s. All are of first order; RK4 treats the damping explicitly and needs 1e-5 s with 16
    links, 17 s in all. Contacts are switched off. There is no static solver: the preloaded start is the
    equilibrium of the same chain, from `chain.held_angles`.

    `mj_step` is called for all steps between two samples at once, so the loop is in C.

    Args:
        case: with a single leg along x, moving in the plane z = 0.
        elements: number.
        kind: "hinges", "joints" or "flex".
        time_step: s; made a little smaller to fit the sampling.
        integrator: "Euler", "implicitfast", "implicit", "RK4" or "discrete".
        repeats: the best time of so many runs counts.
    """
    if kind == "flex" and int(version("mujoco").split(".")[0]) < 4:
        raise RuntimeError("elastic rods as flex need MuJoCo 4")
    samples = 500
    every = ceil(case.duration / samples / time_step - 1e-9)
    step = case.duration / samples / every
    text = _flex(case, elements) if kind == "flex" else _links(case, elements, sliding=kind == "joints")
    options = f'<option timestep="{step!r}" integrator="{integrator}" gravity="{_text(case.gravity)}">'
    options += '<flag contact="disable"/></option>'
    spec = mujoco.MjSpec.from_string(f"<mujoco>{options}{text}</mujoco>")
    if kind == "flex":
        spec.body(f"rod_{elements}").mass /= 2.0  # half an element belongs to the last point
    model = spec.compile()
    best = np.inf
    for _ in range(repeats):
        data = mujoco.MjData(model)
        _hold(case, elements, kind, data)
        mujoco.mj_forward(model, data)
        tips = np.empty((samples + 1, 3))
        tips[0] = _tip(data, kind)
        start = time.perf_counter()
        for k in range(samples):
            mujoco.mj_step(model, data, every)
            tips[k + 1] = _tip(data, kind)
        best = min(best, time.perf_counter() - start)
    t = np.linspace(0.0, case.duration, samples + 1)
    label = f"{kind} {elements}, {integrator}, h {step:.3g} s"
    return PeerRun(PROGRAM, version("mujoco"), label, best, t, tips)


def _tip(data: mujoco.MjData, kind: str) -> Floats:
    """Position at the end; the kinematics of the last step are those before its update, so they are redone."""
    mujoco.mj_kinematics(data.model, data)
    if kind == "flex":
        mujoco.mj_flex(data.model, data)
        return data.flexvert_xpos[-1].copy()
    return data.site_xpos[0].copy()


def _text(numbers: Floats | tuple[float, ...] | None) -> str:
    return "0 0 0" if numbers is None else " ".join(repr(float(x)) for x in numbers)


def _links(case: Case, elements: int, sliding: bool) -> str:
    length = case.lengths[0] / elements
    mass = case.inertia[0] * length
    about_z = mass * length**2 / 12.0 + case.inertia[2] * length
    inertia = f'<inertial pos="{length / 2!r} 0 0" mass="{mass!r}" diaginertia="{about_z!r} {about_z!r} {about_z!r}"/>'
    text = f'<site pos="{length!r} 0 0"/>'
    for k in reversed(range(elements)):
        joints = _joint("hinge", "0 0 1", case, 3, (2.0 if k == 0 else 1.0) / length)
        if sliding:
            joints += _joint("slide", "1 0 0", case, 2, 1.0 / length)
            joints += _joint("slide", "0 1 0", case, 0, 1.0 / length)
        start = 0.0 if k == 0 else length
        text = f'<body pos="{start!r} 0 0">{joints}{inertia}{text}</body>'
    return f"<worldbody>{text}</worldbody>"


def _joint(kind: str, axis: str, case: Case, strain: int, factor: float) -> str:
    stiffness, damping = factor * case.stiffness[strain], factor * case.damping[strain]
    return f'<joint type="{kind}" axis="{axis}" stiffness="{stiffness!r}" damping="{damping!r}"/>'


def _flex(case: Case, elements: int) -> str:
    length = case.lengths[0] / (elements - 0.5)
    bending, mass = case.stiffness[3], case.inertia[0]
    side = sqrt(12.0 * bending / case.stiffness[2])  # of the square section with this EI/EA
    young = case.stiffness[2] / side**2
    points = " ".join(f"{(k - 0.5) * length!r} 0 0" for k in range(elements + 1))
    edges = " ".join(f"{k} {k + 1}" for k in range(elements))
    total = mass * length * (elements + 1)  # shared equally among the points
    elasticity = (
        f'<elasticity young="{young!r}" poisson="0.3" damping="{case.damping[3] / bending!r}"'
        f' section="box" sectionsize="{side / 2!r} {side / 2!r}"/>'
    )
    kept_long = '<edge equality="true" solref="0.002 1" solimp="0.9999 0.9999 0.001 0.5 2"/>'
    shape = f'name="rod" type="direct" dim="1" point="{points}" element="{edges}" mass="{total!r}"'
    rod = f'<flexcomp {shape}>{elasticity}{kept_long}<pin id="0 1"/></flexcomp>'
    return f"<worldbody>{rod}</worldbody>"


def _hold(case: Case, elements: int, kind: str, data: mujoco.MjData) -> None:
    """Set the preloaded equilibrium."""
    if case.preload is None:
        return
    if kind != "flex":
        lengths = np.full(elements, case.lengths[0] / elements)
        stiffness = case.stiffness[3] / lengths
        stiffness[0] *= 2.0
        sliding = kind == "joints"
        given = {"axial": case.stiffness[2], "shear": case.stiffness[0]} if sliding else {}
        angles, links = held_angles(lengths, stiffness, case.preload, **given)
        along = np.column_stack([np.cos(angles), np.sin(angles)])
        across = np.column_stack([-np.sin(angles), np.cos(angles)])
        joints = [np.diff(angles, prepend=0.0)]
        if sliding:
            joints += [(links * along).sum(axis=1) - lengths, (links * across).sum(axis=1)]
        data.qpos[:] = np.column_stack(joints).ravel()
        return
    lengths = np.full(elements - 1, case.lengths[0] / (elements - 0.5))
    _, links = held_angles(lengths, case.stiffness[3] / lengths, case.preload)
    moved = np.cumsum(links - np.column_stack([lengths, np.zeros(elements - 1)]), axis=0)
    names = [f"rod_{k}" for k in range(2, elements + 1)]
    for name, shift in zip(names, moved, strict=True):
        first = data.model.body(name).jntadr[0]
        data.qpos[data.model.jnt_qposadr[first] : data.model.jnt_qposadr[first] + 2] = shift

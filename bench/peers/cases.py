"""The cases of the comparison, as numbers that every program's model is built from, and viscorod's reference.

A case is a chain of straight legs of one section, clamped at its start. Strains are in viscorod's order (shear 1,
shear 2, stretch, bend 1, bend 2, twist); rotary inertia is about (d1, d2, d3) with d3 along the leg. All is SI.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import viscorod as vr

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

INSTALL = "pip install viscorod[bench]"
"""What brings the other programs."""

REFERENCE_RECORDS = 1000
"""Equal times at which references are stored."""

CACHE = Path("out/bench")
"""References are kept here, relative to where the program is run."""


@dataclass(frozen=True)
class PeerRun:
    """One motion computed by another program.

    Attributes:
        program: its name.
        version: of the program.
        label: element, number of elements, step; whatever tells this run from others.
        loop_seconds: wall time of the time loop alone, the best of several.
        t: sampled times (k,), s.
        tip: position of the tip at these times (k, 3), m.
    """

    program: str
    version: str
    label: str
    loop_seconds: float
    t: Floats
    tip: Floats


@dataclass(frozen=True)
class Case:
    """One motion.

    Attributes:
        name: short, for tables and files.
        corners: points of the chain of legs, m; the first is clamped.
        stiffness: C, six numbers.
        inertia: mass per length and rotary inertia about d1, d2, d3.
        damping: D of S = C eps + D eps_t, six numbers.
        duration: simulated, s.
        compared: errors are taken over this first part, s.
        scale: length that errors are divided by, m.
        preload: dead force at the tip whose equilibrium is the start, N; None starts from rest as built.
        gravity: m/s^2.
        pulse: dead force at the second corner, N, times a triangle 0 - 1 - 0 at 0, 1, 2 s.
        reference_mesh: elements of each leg and their order, for the reference.
        reference_step: the smaller of the two time steps of the check by generalised-alpha, s.
    """

    name: str
    corners: tuple[Vector, ...]
    stiffness: tuple[float, ...]
    inertia: tuple[float, ...]
    damping: tuple[float, ...]
    duration: float
    compared: float
    scale: float
    preload: Vector | None = None
    gravity: Vector | None = None
    pulse: Vector | None = None
    reference_mesh: tuple[int, int] = (4, 8)
    reference_step: float = 2.5e-4

    @property
    def lengths(self) -> tuple[float, ...]:
        """Of the legs, m."""
        return tuple(float(np.linalg.norm(np.subtract(b, a))) for a, b in self.legs)

    @property
    def legs(self) -> list[tuple[Vector, Vector]]:
        """Start and end of each, m."""
        return list(zip(self.corners[:-1], self.corners[1:], strict=True))

    def undamped(self) -> Case:
        """The same motion without material damping, where more of the fast modes stay and need a smaller step."""
        step = self.reference_step / 2.0
        return replace(
            self,
            name=f"{self.name}_undamped",
            damping=(0.0,) * 6,
            reference_mesh=(3, 6),
            reference_step=step,
        )

    def model(self, elements: int | None, order: int | None) -> vr.Model:
        """The model for viscorod, `elements` per leg; None leaves the mesh to the program."""
        rotary = self.inertia[1:]
        given = {"damping": list(self.damping)} if any(self.damping) else {}
        section = vr.StiffnessSection(list(self.stiffness), [self.inertia[0]] * 3 + list(rotary), **given)
        model = vr.Model()
        for k, (start, end) in enumerate(self.legs):
            rod = vr.Rod.straight(start, end, section=section, elements=elements, order=order)
            model.add(f"leg{k}", rod)
            if k:
                model.attach(f"leg{k - 1}.end", f"leg{k}.start")
        model.clamp("leg0.start")
        if self.preload:
            model.force(self.tip, self.preload, until=0.0)
        if self.pulse:
            model.force("leg0.end", self.pulse, time=vr.TimeTable([0, 1, 2], [0, 1, 0]), until=2.0)
        if self.gravity:
            model.gravity(self.gravity)
        return model

    @property
    def tip(self) -> str:
        """The place whose motion is compared."""
        return f"leg{len(self.legs) - 1}.end"

    def simulate(
        self,
        elements: int | None,
        order: int | None,
        tolerance: float,
        records: int = 200,
        *,
        errors: bool = True,
    ) -> vr.Run:
        """Viscorod's run of the whole motion, stored at equal times; ``errors``: with estimates of its errors."""
        return self.model(elements, order).simulate(
            self.duration,
            tolerance=tolerance,
            output_interval=self.duration / records,
            initial=self.initial,
            errors=errors,
        )

    @property
    def initial(self) -> str:
        """What the motion starts from."""
        return "equilibrium" if self.preload else "reference"

    def reference(self, cache: Path = CACHE) -> tuple[Floats, Floats]:
        """Times (k,) and tip positions (k, 3) of viscorod, computed once: radau at a tolerance of 1e-9, fine mesh."""
        kept = self._kept(cache)
        return kept["t"], kept["tip"]

    def reference_doubt(self, cache: Path = CACHE) -> tuple[float, float]:
        """How far two other computations of the reference are from it, over `scale`.

        First the same integrator on another mesh at a tenfold tolerance, then another integrator on another mesh:
        generalised-alpha with two steps, 2 h and h, extrapolated: (4 b - a)/3.
        """
        kept = self._kept(cache)
        return float(kept["coarser"]), float(kept["other"])

    def _kept(self, cache: Path) -> dict[str, Floats]:
        key = hashlib.sha256(repr(self).encode()).hexdigest()[:12]
        path = cache / f"reference_{self.name}_{key}.npz"
        if not path.exists():
            elements, order = self.reference_mesh

            def tip(elements: int, order: int, **given: float | str) -> tuple[Floats, Floats]:
                run = self.model(elements, order).simulate(
                    self.compared,
                    output_interval=self.compared / REFERENCE_RECORDS,
                    initial=self.initial,
                    **given,
                )
                return np.asarray(run.time), run.history(self.tip, "position").values

            t, exact = tip(elements, order, tolerance=1e-9)
            _, again = tip(elements - 1, order - 1, tolerance=1e-8)
            alpha = {"integrator": "generalized_alpha", "spectral_radius": 0.9}
            coarse, fine = (
                tip(elements - 1, order - 1, time_step=factor * self.reference_step, **alpha)[1]
                for factor in (2, 1)
            )

            def distance(other: Floats) -> float:
                return float(np.linalg.norm(other - exact, axis=1).max()) / self.scale

            cache.mkdir(parents=True, exist_ok=True)
            doubts = {"coarser": distance(again), "other": distance((4.0 * fine - coarse) / 3.0)}
            np.savez(path, t=t, tip=exact, **doubts)
        with np.load(path) as kept:
            return dict(kept)

    def error(self, t: Floats, tip: Floats) -> float:
        """Largest distance of a tip trajectory from the reference, over `scale`.

        Times that are in the reference are compared there; otherwise the trajectory is interpolated by a cubic spline.
        """
        times, exact = self.reference()
        t, tip = t[t <= self.compared + 1e-12], tip[t <= self.compared + 1e-12]
        place = np.clip(np.searchsorted(times, t - 1e-9), 0, len(times) - 1)
        if np.abs(times[place] - t).max() < 1e-9:
            gap = tip - exact[place]
        else:
            inside = (times >= t[0] - 1e-12) & (times <= t[-1] + 1e-12)
            gap = CubicSpline(t, tip)(times[inside]) - exact[inside]
        return float(np.linalg.norm(gap, axis=1).max()) / self.scale


def _llt() -> Case:
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    stiffness, damping, inertia = (np.diag(m) for m in vr.Rectangle(0.01, 0.01).matrices(rubber))
    return Case(
        name="llt",
        corners=((0.0, 0.0, 0.0), (0.3, 0.0, 0.0)),
        stiffness=tuple(stiffness.tolist()),
        inertia=tuple(inertia[2:].tolist()),
        damping=tuple(damping.tolist()),
        duration=10.0,
        compared=5.0,
        scale=0.3,
        preload=(0.0, 0.035, 0.0),
    )


def _frame() -> Case:
    return Case(
        name="frame",
        corners=((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (10.0, 10.0, 0.0)),
        stiffness=(1e6, 1e6, 1e6, 1e3, 1e3, 1e3),
        inertia=(1.0, 10.0, 10.0, 20.0),
        damping=(0.0,) * 6,
        duration=5.0,
        compared=5.0,
        scale=10.0,
        pulse=(0.0, 0.0, 50.0),
        reference_step=5e-4,
    )


def _string() -> Case:
    steel = vr.Material(2.1e11, poissons_ratio=0.2, density=7850.0)
    stiffness, _, inertia = (np.diag(m) for m in vr.Circle(1e-3).matrices(steel))
    return Case(
        name="string",
        corners=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        stiffness=tuple(stiffness.tolist()),
        inertia=tuple(inertia[2:].tolist()),
        damping=(1e-1, 1e-1, 2.0, 2e-4, 2e-4, 8e-6),
        duration=1.0,
        compared=1.0,
        scale=1.0,
        gravity=(0.0, -9.81, 0.0),
    )


LLT = _llt()
"""Linn, Lang and Tuganov (2013), section 3: a soft cantilever, held by a force at its tip, let go at t = 0."""

FRAME = _frame()
"""Simo and Vu-Quoc (1988): right-angle cantilever, force out of its plane at the elbow; undamped."""

STRING = _string()
"""Lang, Linn and Arnold (2011): steel wire of 1 mm radius, horizontal, clamped at one end, swings down freely."""

CASES = {case.name: case for case in (LLT, FRAME, STRING)}
"""By name."""

"""Random models such as strangers bring: rods, sections, curvature, joints, loads and dampings, each from one seed.

Sizes span seven decades, and loads, times and speeds are measured by the model's own stiffness and frequencies, so that
what is asked ranges from small to large displacements whatever the size. The same seed gives the same model on any
mesh: that is what lets a refined solution judge the one by default.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import viscorod as vr

ANALYSES = ("equilibrium", "modes", "simulate", "steady")
SHARES = (0.4, 0.3, 0.2, 0.1)
"""Parts of all trials that each analysis gets."""

MATERIALS = {
    "steel": (2.0e11, 0.3, 7850.0),
    "aluminium": (7.0e10, 0.33, 2700.0),
    "silicon": (1.6e11, 0.22, 2330.0),
    "nylon": (2.5e9, 0.39, 1150.0),
    "rubber": (1.5e6, 0.49, 1100.0),
    "silicone": (2.0e5, 0.495, 1050.0),
}

Mesh = Callable[[str], dict[str, int]]
"""From the name of a rod to its keys ``elements`` and ``order``; none by default."""


@dataclass(frozen=True)
class Trial:
    """One question to the program.

    Attributes:
        seed: it came from; analysis: word in ``ANALYSES``; structure: what kind of model it is.
        build: makes the model on a mesh.
        settings: arguments of the analysis.
    """

    seed: int
    analysis: str
    structure: str
    build: Callable[[Mesh], vr.Model]
    settings: dict[str, Any]


def by_default(_: str) -> dict[str, int]:
    """Leave the mesh to the program."""
    return {}


def random_trial(seed: int) -> Trial:
    """Return the trial of a seed."""
    rng = np.random.default_rng(seed)
    analysis = str(rng.choice(ANALYSES, p=SHARES))
    if analysis == "steady":
        structure = "cantilever"
    else:
        structure = str(
            rng.choice(["cantilever", "clamped", "pinned", "frame", "tip mass", "hinge", "springs"])
        )
    length = _log(rng, 1e-3, 30.0)
    rod = _random_rod(rng, length, turning=analysis == "steady")
    parts = _Structure(rng, structure, rod)
    if analysis == "equilibrium":
        loads = _random_loads(rng, parts, largest=8.0)
        return Trial(seed, analysis, structure, lambda mesh: parts.build(mesh, loads), {})
    if analysis == "modes":
        loads = _random_loads(rng, parts, largest=1.0) if rng.random() < 0.3 else []
        settings = {"count": int(rng.integers(3, 11)), "about": "equilibrium" if loads else "reference"}
        return Trial(seed, analysis, structure, lambda mesh: parts.build(mesh, loads), settings)
    frequency = _lowest_frequency(parts.build(by_default, []))
    if analysis == "steady":
        axis = rng.standard_normal(3)
        axis[0] *= 0.2  # mostly across the rod
        spin = _log(rng, 0.1, 2.0) * 2.0 * math.pi * frequency * axis / np.linalg.norm(axis)
        settings = {"spin": tuple(spin.tolist()), "modes": 4}
        return Trial(seed, analysis, structure, lambda mesh: parts.build(mesh, []), settings)
    periods = float(rng.uniform(1.0, 4.0))
    time = _random_history(rng, frequency, periods / frequency)
    loads = _random_loads(rng, parts, largest=2.0, history=time)
    settings = {"duration": periods / frequency}
    if time.get("until") is None:
        settings["initial"] = "reference"
    return Trial(seed, analysis, structure, lambda mesh: parts.build(mesh, loads), settings)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _direction(rng: np.random.Generator) -> np.ndarray:
    vector = rng.standard_normal(3)
    return vector / np.linalg.norm(vector)


@dataclass(frozen=True)
class _RodPlan:
    """A rod without its mesh: how it is made, its length, stiffness against bending, and where it ends."""

    make: Callable[..., vr.Rod]
    length: float
    bending: float
    weight: float
    end: np.ndarray


def _random_rod(rng: np.random.Generator, length: float, *, turning: bool) -> _RodPlan:
    """Return a rod that starts at the origin; one that is to turn steadily is straight and does not relax."""
    name = str(rng.choice(list(MATERIALS)))
    modulus, poissons_ratio, density = MATERIALS[name]
    damping = _random_damping(rng, length * math.sqrt(density / modulus), relaxing=not turning)
    material = vr.Material(modulus, poissons_ratio, density, damping=damping)
    height = length / _log(rng, 12.0, 150.0)
    section, needs = _random_section(rng, height, length)
    shared: dict[str, Any] = {"section": section}
    if needs:
        shared["material"] = material
    shape = "straight" if turning else str(rng.choice(["straight", "straight", "arc", "helix", "through"]))
    if rng.random() < 0.2:
        shared["twist"] = float(rng.uniform(-2.0, 2.0))
    start, along = np.zeros(3), _direction(rng)
    across = np.cross(along, _direction(rng))
    across /= np.linalg.norm(across)
    if shape == "straight":
        if rng.random() < 0.5:
            shared["d1"] = tuple(across)

        def make(**mesh: int) -> vr.Rod:
            return vr.Rod.straight(tuple(start), tuple(start + length * along), **shared, **mesh)

    elif shape == "arc":
        angle = float(rng.uniform(0.2, 5.0))

        def make(**mesh: int) -> vr.Rod:
            return vr.Rod.arc(
                tuple(start), tuple(along), tuple(across), length / angle, angle, **shared, **mesh
            )

    elif shape == "helix":
        turns, rise = float(rng.uniform(0.5, 3.0)), float(rng.uniform(0.05, 0.8))
        per_turn = length / turns
        pitch = rise * per_turn
        radius = math.sqrt(per_turn**2 - pitch**2) / (2.0 * math.pi)

        def make(**mesh: int) -> vr.Rod:
            return vr.Rod.helix(radius, pitch, turns, axis=tuple(along), **shared, **mesh)

    else:
        points = _smooth_points(rng, length, along)

        def make(**mesh: int) -> vr.Rod:
            return vr.Rod.through(points, **shared, **mesh)

    if isinstance(section, _Pieces):
        shared["section"] = section.first
        shared["section"] = section.of_length(make().length)
    rod = make()
    weakest = min(
        float(np.linalg.eigvalsh(rod.matrices_at(s)[0][3:5, 3:5])[0]) for s in np.linspace(0.0, rod.length, 9)
    )
    end = np.asarray(rod.frames([rod.length])[0][0])
    return _RodPlan(make, rod.length, weakest, rod.mass / rod.length, end)


def _smooth_points(rng: np.random.Generator, length: float, along: np.ndarray) -> list[tuple[float, ...]]:
    """Return points of a curve of about the given length."""
    count = int(rng.integers(4, 8))
    points = [np.zeros(3)]
    heading = along
    for _ in range(count - 1):
        heading = heading + 0.35 * rng.standard_normal(3)
        heading = heading / np.linalg.norm(heading)
        points.append(points[-1] + length / (count - 1) * heading)
    return [tuple(point.tolist()) for point in points]


def _random_damping(rng: np.random.Generator, passage: float, *, relaxing: bool) -> Any:
    """Return no damping, Kelvin-Voigt damping or Maxwell branches, with times near those of bending vibrations.

    ``passage`` is the time in which a wave passes the rod.
    """
    kind = str(rng.choice(["none", "kelvin-voigt", "kelvin-voigt", "prony" if relaxing else "none"]))
    period = 2.0 * math.pi * passage * _log(rng, 3.0, 100.0)
    if kind == "none":
        return None
    if kind == "kelvin-voigt":
        return vr.KelvinVoigt(_log(rng, 1e-4, 3e-2) * period, _log(rng, 1e-4, 3e-2) * period)
    times = [_log(rng, 0.02, 20.0) * period for _ in range(int(rng.integers(1, 4)))]
    shares = [float(rng.uniform(0.02, 0.15)) for _ in times]
    return vr.Prony(shear_ratios=shares, shear_times=times, constant="poissons_ratio")


def _random_section(rng: np.random.Generator, height: float, length: float) -> tuple[Any, bool]:
    """Return a section or a profile of sections, and whether it needs a material."""
    kind = str(
        rng.choice(["circle", "annulus", "rectangle", "ellipse", "taper", "pieces", "stations", "matrix"])
    )
    flat = _log(rng, 0.15, 1.0)
    if kind == "circle":
        return vr.Circle(0.5 * height), True
    if kind == "annulus":
        return vr.Annulus(0.5 * height, 0.5 * height * float(rng.uniform(0.3, 0.9))), True
    if kind == "rectangle":
        return vr.Rectangle(height, flat * height), True
    if kind == "ellipse":
        return vr.Ellipse(0.5 * height, 0.5 * flat * height), True
    if kind == "taper":
        slender = float(rng.uniform(0.25, 1.0))
        return vr.Taper(
            vr.Rectangle(height, flat * height), vr.Rectangle(slender * height, flat * height)
        ), True
    if kind == "pieces":
        share = float(rng.uniform(0.3, 0.7))
        return _Pieces(share, vr.Circle(0.5 * height), vr.Circle(float(rng.uniform(0.3, 0.5)) * height)), True
    count = int(rng.integers(5, 40))
    modulus, _, density = MATERIALS[str(rng.choice(list(MATERIALS)))]
    if kind == "stations":
        return _stations(rng, count, height, length, modulus, density), False
    return _matrix_section(rng, height, modulus, density), False


@dataclass(frozen=True)
class _Pieces:
    """Two sections; where the second ends is known with the rod's length only."""

    share: float
    first: Any
    second: Any

    def of_length(self, length: float) -> vr.Piecewise:
        return vr.Piecewise([(self.share * length, self.first), (length, self.second)])


def _stations(
    rng: np.random.Generator, count: int, height: float, length: float, modulus: float, density: float
) -> Callable[[float], vr.StiffnessSection]:
    """Return stiffness and mass given at stations, linear in between, as in the file of a blade."""
    places = np.linspace(0.0, length, count)
    thick = height * np.linspace(1.0, rng.uniform(0.3, 1.0), count) * rng.uniform(0.85, 1.15, count)
    area, inertia = thick**2, thick**4 / 12.0

    def section(s: float) -> vr.StiffnessSection:
        A, second = np.interp(s, places, area), np.interp(s, places, inertia)
        stiffness = modulus * np.array([0.3 * A, 0.3 * A, A, second, 1.5 * second, 0.7 * second])
        mass = density * np.array([A, A, A, second, 1.5 * second, 2.5 * second])
        return vr.StiffnessSection(stiffness.tolist(), mass.tolist())

    return section


def _matrix_section(
    rng: np.random.Generator, height: float, modulus: float, density: float
) -> vr.StiffnessSection:
    """Return a section with couplings, as an anisotropic laminate has."""
    area, second = height**2, height**4 / 12.0
    scale = np.sqrt(modulus * np.array([0.3 * area, 0.3 * area, area, second, 2.0 * second, 0.8 * second]))
    mixed = rng.uniform(-0.15, 0.15, (6, 6))
    coupling = np.eye(6) + 0.5 * (mixed + mixed.T)
    mass = density * np.array([area, area, area, second, 2.0 * second, 3.0 * second])
    return vr.StiffnessSection((scale[:, None] * coupling * scale).tolist(), mass.tolist())


class _Structure:
    """Rods, bodies, joints and supports; loads come later."""

    def __init__(self, rng: np.random.Generator, kind: str, rod: _RodPlan) -> None:
        self.kind, self.rod = kind, rod
        self.second = _second_rod(rng, rod) if kind == "frame" else None
        self.mass = rod.weight * rod.length * _log(rng, 0.1, 3.0)
        self.axis = tuple(_direction(rng).tolist())
        self.turning = rod.bending / rod.length * _log(rng, 0.3, 30.0)
        self.resting = rod.bending / rod.length**3 * _log(rng, 3.0, 300.0)
        self.tip = "leg.end" if kind == "frame" else "rod.end"

    def build(self, mesh: Mesh, loads: list[Callable[[vr.Model], None]]) -> vr.Model:
        """Make the model on a mesh."""
        model = vr.Model()
        model.add("rod", self.rod.make(**mesh("rod")))
        if self.kind == "springs":
            for end in ("rod.start", "rod.end"):
                model.spring(
                    end,
                    stiffness={**dict.fromkeys(("ux", "uy", "uz"), self.resting), "rx": 0.3 * self.turning},
                )
        elif self.kind == "hinge":
            model.revolute("rod.start", "ground", self.axis, stiffness={"rz": self.turning})
        elif self.kind == "pinned":
            model.pin("rod.start")
            model.support("rod.start", ("rx", "ry", "rz")[: 1 + int(1e3 * self.turning) % 2])
            model.pin("rod.end")
            model.spring("rod.end", stiffness=dict.fromkeys(("rx", "ry", "rz"), self.turning))
        else:
            model.clamp("rod.start")
        if self.kind == "clamped":
            model.clamp("rod.end")
        if self.second is not None:
            model.add("leg", self.second.make(**mesh("leg")))
            model.attach("rod.end", "leg.start")
        if self.kind == "tip mass":
            size = 0.05 * self.rod.length
            inertia = [0.4 * self.mass * size**2] * 3
            model.add("weight", vr.Body(self.mass, inertia, centre=tuple(self.rod.end.tolist())))
            model.attach("rod.end", "weight")
        for load in loads:
            load(model)
        return model


def _second_rod(rng: np.random.Generator, rod: _RodPlan) -> _RodPlan:
    """Return a straight rod of the same section that begins where the first ends."""
    share, heading = float(rng.uniform(0.3, 1.0)), _direction(rng)
    first = rod.make()
    length = share * rod.length
    section = first.section_at(first.length)
    shared: dict[str, Any] = {"section": section}
    if first.material is not None:
        shared["material"] = first.material

    def make(**mesh: int) -> vr.Rod:
        return vr.Rod.straight(tuple(rod.end), tuple(rod.end + length * heading), **shared, **mesh)

    return _RodPlan(make, length, rod.bending, rod.weight, rod.end + length * heading)


def _random_history(rng: np.random.Generator, frequency: float, duration: float) -> dict[str, Any]:
    """Return how loads depend on the time: released at t = 0, sudden, ramped or oscillating."""
    kind = str(rng.choice(["released", "sudden", "ramp", "sine"]))
    if kind == "released":
        return {"until": 0.0}
    if kind == "ramp":
        return {"time": vr.Ramp(0.0, float(rng.uniform(0.1, 0.9)) * duration)}
    if kind == "sine":
        return {"time": vr.Sine(_log(rng, 0.2, 2.5) * frequency)}
    return {}


def _random_loads(
    rng: np.random.Generator, parts: _Structure, *, largest: float, history: dict[str, Any] | None = None
) -> list[Callable[[vr.Model], None]]:
    """Return one to three loads; their size in units of the bending stiffness is spread evenly over decades."""
    history = history or {}
    rod, loads = parts.rod, []
    for _ in range(int(rng.integers(1, 4))):
        kind = str(rng.choice(["force", "moment", "distributed", "gravity", "inner"]))
        size = _log(rng, 1e-4 * largest, largest)
        force = tuple((size * rod.bending / rod.length**2 * _direction(rng)).tolist())
        following = bool(rng.random() < 0.25)
        if kind == "force" and parts.kind != "clamped":
            loads.append(_acting("force", parts.tip, force, following, history))
        elif kind == "moment" and parts.kind != "clamped":
            moment = tuple((rod.length * np.array(force)).tolist())
            loads.append(_acting("moment", parts.tip, moment, True, history))
        elif kind == "distributed":
            density = tuple((np.array(force) / rod.length).tolist())
            loads.append(_acting("distributed_force", "rod", density, following, history))
        elif kind == "inner":
            place = f"rod@{float(rng.uniform(0.2, 0.8)) * rod.length:.12g}"
            loads.append(_acting("force", place, force, following, history))
        else:
            acceleration = tuple((np.array(force) / (rod.weight * rod.length)).tolist())
            loads.append(_acting("gravity", None, acceleration, None, history))
    return loads


def _acting(
    kind: str, place: str | None, value: tuple[float, ...], following: bool | None, history: dict[str, Any]
) -> Callable[[vr.Model], None]:
    def act(model: vr.Model) -> None:
        given: dict[str, Any] = {} if following is None else {"following": following}
        arguments = (value,) if place is None else (place, value)
        getattr(model, kind)(*arguments, **given, **history)

    return act


def _lowest_frequency(model: vr.Model) -> float:
    """Return the lowest natural frequency that is not a rigid motion [Hz]."""
    found = model.modes(8, about="reference")
    vibrating = found.frequencies[found.frequencies > 1e-6 * found.frequencies.max()]
    return float(vibrating.min())

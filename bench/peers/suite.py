"""What is measured: for each program and mesh, the largest step whose error stays below that of the mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

MODULES = {"exudyn_rods": "exudyn", "pyelastica_rods": "elastica", "mujoco_rods": "mujoco"}
"""Modules of this package and what they import."""


@dataclass(frozen=True)
class Entry:
    """One run.

    Attributes:
        module: of this package.
        case: name of the case.
        elements: of each leg.
        settings: of the module's `run`.
        undamped: take the case without material damping.
    """

    module: str
    case: str
    elements: int
    settings: Mapping[str, Any] = field(default_factory=dict)
    undamped: bool = False


def available(module: str) -> bool:
    """Is the program installed that `module` needs?"""
    return find_spec(MODULES[module]) is not None


def _exudyn(case: str, elements: int, steps: int, **settings: Any) -> Entry:
    return Entry("exudyn_rods", case, elements, {"steps": steps, **settings})


def _mujoco(case: str, elements: int, kind: str, time_step: float, integrator: str = "Euler") -> Entry:
    return Entry(
        "mujoco_rods", case, elements, {"kind": kind, "time_step": time_step, "integrator": integrator}
    )


def _pyelastica(case: str, elements: int) -> Entry:
    return Entry("pyelastica_rods", case, elements, undamped=True)


SUITE = (
    _exudyn("llt", 16, 1000),
    _exudyn("llt", 32, 2000),
    _exudyn("llt", 64, 3000),
    _exudyn("llt", 80, 4000),
    _exudyn("llt", 32, 2000, kind="ancf", repeats=1),
    _mujoco("llt", 16, "hinges", 2e-3),
    _mujoco("llt", 32, "hinges", 2e-3),
    _mujoco("llt", 64, "hinges", 1e-3),
    _mujoco("llt", 16, "joints", 4e-3),
    _mujoco("llt", 32, "joints", 2e-3),
    _mujoco("llt", 64, "joints", 1e-3),
    _mujoco("llt", 32, "flex", 5e-4, "discrete"),
    *(_pyelastica("llt", elements) for elements in (16, 32, 64)),
    *(_exudyn("frame", n, steps, kind="beam3d") for n, steps in ((8, 100), (16, 150), (32, 250), (64, 500))),
    *(_exudyn("string", n, steps) for n, steps in ((16, 500), (32, 1000), (64, 1000))),
    _mujoco("string", 16, "hinges", 1e-3),
    _mujoco("string", 32, "hinges", 2e-4),
    *(_pyelastica("string", elements) for elements in (16, 32, 64)),
)
"""All runs, in the order of the table."""

"""Compile all kernels at once, by computing small models with everything that has a kernel of its own."""

from __future__ import annotations

import gc
import logging
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numba
from numba.core import event

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.frequency_response import with_inputs
from viscorod.analyses.model import Model
from viscorod.analyses.motion import motion
from viscorod.analyses.periodic import periodic
from viscorod.errors import AccuracyWarning
from viscorod.mechanics.compilation.compiled import (
    KERNELS,
    PURE_PYTHON,
    await_compilation,
    compile_aside,
    on_disk,
)
from viscorod.mechanics.compilation.machine_code import cache_folder
from viscorod.model.actions.time_function import Ramp
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.materials.material import KelvinVoigt, Material
from viscorod.model.rod import Rod
from viscorod.model.sections.cubic_bending import CubicBending
from viscorod.model.sections.section_shapes import Rectangle
from viscorod.model.sections.stiffness_section import MaxwellBranch, StiffnessSection
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.registry import FORMULATIONS, Formulation
from viscorod.solve.formulations.system import State
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.transient.company_steps import compile_guided
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.collocation_step import place_predicted, try_step
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.many_steps import ManySteps
from viscorod.solve.transient.step_control import ErrorControl

SIZE = 0.01
"""Length of the rods [m]: small enough to need the scaling of the linear algebra."""
GEOMETRIC = (("geometric", "full"),)
ALL = "all"
"""The word for the second process to compile everything, from the other end."""
SPAN = 1e-5
"""Simulated time [s]; a few steps do."""


@dataclass(frozen=True)
class WarmUp:
    """What a warm-up did.

    Attributes:
        seconds: how long it took.
        compiled: number of kernels that had to be compiled; 0 if all were on disk.
        folders: where machine code is kept.
    """

    seconds: float
    compiled: int
    folders: tuple[Path, ...]


def kernels() -> list[Any]:
    """Return all kernels, as Numba's dispatchers."""
    return list(KERNELS)


def warm_up(progress: Callable[[float], None] | None = None) -> WarmUp:
    """Compile every kernel that is not on disk yet.

    Args:
        progress: called with the number of kernels that are ready, as they are compiled.
    """
    if PURE_PYTHON:
        return WarmUp(0.0, 0, ())
    begin = time.perf_counter()
    before = _misses()
    with _watched(progress), _unannounced():
        if not all(map(on_disk, KERNELS)):
            compile_aside(ALL)
        model = small_model()
        model.equilibrium()
        model.modes(1)
        _simulate(model, "generalized_alpha")
        transients(model)
        assembly, relaxing = small_assembly(), small_relaxing()
        assembly.equilibrium()
        assembly.modes(1)
        relaxing.modes(1)
        vibrate(soft_model())
        for variant in _variants(assembly, relaxing):
            _simulate(*variant)
        _simulate(soft_model(), "radau", stages=5)
        compile_step()
        compile_loop()
        await_compilation()
    if progress is not None:
        progress(
            sum(bool(one.signatures) or on_disk(one) for one in KERNELS)
        )  # the second process compiles, too
    folder = cache_folder()
    folders = () if folder is None else (folder,)
    return WarmUp(time.perf_counter() - begin, _misses() - before, folders)


def vibrate(model: Model) -> None:
    """Follow a periodic motion over a few frequencies."""
    settings = {"inputs": ["beam.end fz"], "amplitudes": [1e-12], "outputs": ["beam.end uz"]}
    given = PeriodicSettings.model_validate(settings | {"frequencies": [0.8, 0.801], "harmonics": 1})
    described = DiscreteModel.of(with_inputs(model, given), given)
    periodic(described, given)


def transients(model: Model) -> None:
    """Run every integrator, from the reference shape: that needs no kernels of statics."""
    for integrator in INTEGRATORS:
        _simulate(model, integrator, _formulations(integrator))


def _variants(assembly: Model, relaxing: Model) -> list[tuple[Model, str, list[tuple[str, str]]]]:
    """Return models, integrators and formulations whose steps need kernels that those of others do not."""
    return [
        (model, integrator, [formulation])
        for integrator in INTEGRATORS
        for model, formulations in (
            (assembly, _formulations(integrator, lambda kind: kind.laws)),
            (relaxing, _formulations(integrator, lambda kind: kind.branches)),
        )
        for formulation in formulations
    ]


def _formulations(
    integrator: str, can: Callable[[Formulation], bool] = lambda _: True
) -> list[tuple[str, str]]:
    """Return the formulations, with their dampings, that an integrator takes and that can do something."""
    taken = INTEGRATORS[integrator].formulations
    return [(name, damping) for (name, damping), kind in FORMULATIONS.items() if name in taken and can(kind)]


def _simulate(
    model: Model, integrator: str, formulations: Iterable[tuple[str, str]] = GEOMETRIC, **more: int
) -> None:
    given = more | {
        "duration": SPAN,
        "time_step": 0.5 * SPAN,
        "integrator": integrator,
        "initial": "reference",
        "output_interval": 0.2 * SPAN,
    }
    for formulation in formulations:
        settings = SimulateSettings.model_validate(given)
        motion(DiscreteModel.of(model, formulation=formulation), settings)


def small_model() -> Model:
    """Build two damped rods with a rigid corner, and every kind of support and load."""
    material = Material(1e9, poissons_ratio=0.3, density=1000.0, damping=KelvinVoigt(1e-4, 1e-4))
    section = Rectangle(0.1 * SIZE, 0.1 * SIZE)

    def rod(start: tuple[float, float, float], end: tuple[float, float, float]) -> Rod:
        return Rod.straight(start, end, section=section, material=material, elements=1, order=2)

    model = Model()
    model.add("post", rod((0, 0, 0), (0, 0, SIZE)))
    model.add("beam", rod((0, 0, SIZE), (SIZE, 0, SIZE)))
    model.attach("post.end", "beam.start")
    still = Ramp(0.0, SPAN, 0.0)
    model.clamp("post.start", motion={"rz": still, "ry": TimeTable((0.0, SPAN), (0.0, 0.0), "cubic")})
    model.support("beam.end", fixed=["uy"], motion={"rx": still})
    model.gravity()
    model.force("beam.end", (0, 0, 1e-3), following=True)
    model.moment(f"beam@{0.3 * SIZE}", (1e-6, 0, 0))
    model.distributed_force("beam", (0, 0, 1e-3))
    model.moving_force("beam", (0, 0, 1e-3), speed=0.5 * SIZE / SPAN)
    model.drag("beam", linear_across=1e-3)
    return model


def small_hinged(law: CubicBending | None = None) -> Model:
    """Build a rod that does not shear, and a hinge with a spring to an arm: each has its own kernels."""
    model = soft_model()
    beam = model.rods["beam"]
    model.rods["beam"] = beam.model_copy(update={"constraints": ("unshearable",)})
    start, end = (SIZE, 0, 0), (2 * SIZE, 0, 0)
    model.add("arm", Rod.straight(start, end, section=beam.section, material=beam.material, law=law))
    model.revolute("arm.start", "beam.end", (0, 0, 1), stiffness={"rz": 1e-6}, damping={"rz": 1e-9})
    return model


def small_assembly() -> Model:
    """Build the same, whose arm has a law of its own and bends itself."""
    model = small_hinged(CubicBending(SIZE**2))
    model.rest_strain("arm", (0, 0, 0, 1e-3, 0, 0), time=Ramp(0.0, SPAN, 1.0))
    return model


def small_relaxing() -> Model:
    """Build a cantilever with a Maxwell branch."""
    model = soft_model()
    C, _, M = model.rods["beam"].matrices_at(0.0)
    branch = MaxwellBranch(time=SPAN, stiffness=C)
    section = StiffnessSection(C, M, damping=1e-4 * C, branches=[branch])
    model.rods["beam"] = model.rods["beam"].model_copy(update={"section": section, "material": None})
    return model


class _Unassembled(GeometricSystem):
    """Leaves out the assembly, the largest kernel, which the first process compiles meanwhile."""

    def linearise(self, *_: Any) -> None:
        """Leave the matrices of the elements zero: soft rods move by their mass alone."""


def soft_model() -> Model:
    """Build a soft, heavy cantilever: what the first run of a transient needs and little more."""
    material = Material(1e3, poissons_ratio=0.3, density=1000.0, damping=KelvinVoigt(1e-4, 1e-4))
    section = Rectangle(0.1 * SIZE, 0.1 * SIZE)
    rod = Rod.straight((0, 0, 0), (SIZE, 0, 0), section=section, material=material, elements=1, order=2)
    model = Model()
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, 1e-9))
    return model


def compile_step() -> None:
    """Compile the step of radau and its prediction, without all that a run needs before it."""
    work = DiscreteModel.of(soft_model())
    radau = Radau(work.system, work.supports, tolerance=1e-4)
    typeof: Any = numba.typeof
    arguments = tuple(typeof(argument) for argument in radau.step_arguments(SPAN))
    kernels: tuple[Any, ...] = try_step, place_predicted
    for kernel in kernels:
        kernel.compile(arguments)


def compile_loop() -> None:
    """Compile the loop of radau's steps and those of a company, and what only some models have in it.

    Runs use them if they are there.
    """
    for model in (soft_model(), small_hinged(), small_model()):
        work = DiscreteModel.of(model)
        radau = Radau(work.system, work.supports, tolerance=1e-4)
        radau.start(0.0, State.reference(work.problem))
        many = ManySteps(radau, ErrorControl(radau.estimate_order, SPAN, SPAN), SPAN, None)
        many.compile()
        compile_guided(many)


def compile_transients() -> None:
    """Compile the kernels of transients, those first that a first run needs and that statics does without."""
    compile_step()
    FORMULATIONS["unassembled", "full"] = Formulation(_Unassembled)
    _simulate(soft_model(), "radau", [("unassembled", "full")])
    for integrator in ("radau", "midpoint"):
        _simulate(small_model(), integrator)
    compile_loop()


def _ready() -> int:
    return sum(bool(kernel.signatures) for kernel in KERNELS)


def _misses() -> int:
    return sum(bool(kernel.stats.cache_misses) for kernel in KERNELS)


@contextmanager
def _unannounced() -> Iterator[None]:
    """Keep back that kernels are compiled, which is what was asked for, and how accurate the small models are."""
    logger = logging.getLogger("viscorod")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AccuracyWarning)
            yield
    finally:
        logger.setLevel(level)


@contextmanager
def _watched(progress: Callable[[float], None] | None) -> Iterator[None]:
    if progress is None:
        yield
        return
    call = progress

    class CompilationWatch(event.Listener):
        def on_start(self, _event: Any) -> None: ...

        def on_end(self, _event: Any) -> None:
            call(_ready())

    with event.install_listener("numba:compile", CompilationWatch()):
        yield


if __name__ == "__main__":  # the process that compiles aside
    gc.disable()  # compiling makes many objects, and the process ends soon
    compile_transients()
    if ALL in sys.argv[1:]:
        for variant in reversed(_variants(small_assembly(), small_relaxing())):
            _simulate(*variant)

"""A model that can be computed.

The solvers are imported when something is first computed, so that a model is built at once.
"""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.arguments import given
from viscorod.model.fields.values import number
from viscorod.solve.settings import (
    EquilibriumSettings,
    PathSettings,
    SimulateSettings,
    SteadySettings,
)
from viscorod.solve.settings_checks import require_fit

if TYPE_CHECKING:
    from viscorod.analyses.coupling import CoSimulation
    from viscorod.analyses.discrete import DiscreteModel
    from viscorod.model.actions.event import AnyEvent
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady
    from viscorod.solve.modes.vibrations import Modes

__all__ = ["Model", "Progress"]

Progress = Callable[[float, float], None]
ABOUT = ("equilibrium", "released", "reference")
"""About what small vibrations are found."""


class Model(ModelDescription):
    """Rods, supports and loads (see :class:`ModelDescription`), and what can be computed of them."""

    def __init__(self) -> None:
        super().__init__()
        self.about: dict[str, str] = {}
        """What results are to tell of the case beside the model: attributes of their data set."""

    def equilibrium(
        self,
        *,
        load_factor: float = 1.0,
        load_steps: int | None = None,
        progress: Progress | None = None,
        title: str = "",
        stop: Callable[[], str] | None = None,
    ) -> Equilibrium:
        """Find the static equilibrium under the loads at t = 0- (just before t = 0).

        Args:
            load_factor: multiple of all loads and prescribed motions.
            load_steps: number of equal load steps to start with; steps adapt anyway. None starts with one.
            progress: called with (load factor, step) after every load step.
            title: kept with the result.
            stop: called in every iteration; a reason that it returns ends the search.

        Raises:
            InputError: the model is inconsistent, or free to move as a rigid body.
            SolveError: no equilibrium was found, or the search was stopped; ``run`` holds the load steps that were.
        """
        settings = EquilibriumSettings(**given(load_steps=load_steps))
        work = self._discretised(stop=stop)
        try:
            factor = number(load_factor)
        except InputError:
            raise InputError(f"load_factor = {load_factor!r}: give a finite number such as 1.0") from None
        return work.equilibrium(factor, settings.load_steps or 1, progress, self._attrs(title))

    def path(
        self,
        *,
        load_factor: float | None = None,
        place: str | None = None,
        axis: str | None = None,
        displacement: float | None = None,
        turns: int | None = None,
        points: int = 200,
        arc_length: float = 0.1,
        progress: Progress | None = None,
        title: str = "",
        stop: Callable[[], str] | None = None,
    ) -> Equilibrium:
        """Follow the static equilibria from the unloaded one on, through limit points and past bifurcations.

        The load factor may grow and shrink on the way. The path goes on through a bifurcation; to branch off, add a
        small load that prefers one of the branches.

        Args:
            load_factor: multiple of all loads and prescribed motions towards which the path begins and where it ends;
                1 if neither displacement nor turns is given.
            place: with axis and displacement: the path ends where this place has moved so far.
            axis: global axis "x", "y" or "z" of the displacement.
            displacement: from the reference shape [m].
            turns: the path ends at this limit point, 1 for the first.
            points: number of points at most; with fewer than the path needs, its outcome is "points".
            arc_length: largest distance between two points, in which a change of the load factor by its unit
                (load_factor, or 1), a displacement by the model's length and a rotation by 1 rad count alike.
            progress: called with (load factor, its change) after every point.
            title: kept with the result.
            stop: called in every iteration; a reason that it returns ends the path.

        Returns:
            The points of the path from the unloaded shape on, in order; limit points and bifurcations are among them.

        Raises:
            InputError: the model is inconsistent, or free to move as a rigid body.
            SolveError: the path could not be followed further, or was stopped; ``run`` holds it up to there.
        """
        settings = PathSettings(
            **given(
                points=points,
                arc_length=arc_length,
                load_factor=load_factor,
                place=place,
                axis=axis,
                displacement=displacement,
                turns=turns,
            )
        )
        return self._discretised(stop=stop).path(settings, progress, self._attrs(title))

    def simulate(
        self,
        duration: float,
        *,
        tolerance: float | None = None,
        time_step: float | None = None,
        initial: str = "equilibrium",
        integrator: str = "radau",
        spectral_radius: float | None = None,
        output_interval: float | None = None,
        formulation: str = "geometric",
        damping: str = "full",
        dynamics: str = "nonlinear",
        progress: Progress | None = None,
        title: str = "",
        events: Sequence[AnyEvent] = (),
        folder: str | Path | None = None,
        resume: bool = False,
        stop: Callable[[], str] | None = None,
    ) -> Run:
        """Compute the motion from t = 0 to ``duration``.

        Args:
            duration: simulated time [s].
            tolerance: wanted accuracy: displacements over the size of the model, rotations in rad (1e-4 for "radau";
                "generalized_alpha" has equal steps without it).
            time_step: the step [s] of integrators with equal steps (None chooses it from the lowest modes), the
                largest step of the others.
            initial: "equilibrium" under the loads at t = 0-, or the "reference" shape.
            integrator: "radau", "generalized_alpha" or "midpoint".
            spectral_radius: numerical damping of unresolved frequencies by "generalized_alpha", 0 (most) to 1 (none).
            output_interval: time between stored states [s]; None stores every step.
            formulation: "geometric" (strains follow from positions and rotations) or "intrinsic" (body velocities and
                strains; positions follow by integration in time).
            damping: "full" or "linearised" (intrinsic formulation).
            dynamics: "nonlinear", or "linear" about the initial state (intrinsic formulation, linearised damping).
            progress: called with (time, step) after every step.
            title: kept with the result.
            events: what is watched for and recorded, and may end the run: `Crossing`, `Decayed`, `SteadyState`.
            folder: where the states go as they come, so that memory stays bounded and a run that is stopped can go on;
                ``run.nc`` is there in the end. Without it everything stays in memory.
            resume: go on with the run that was stopped in that folder; model and settings have to be the same.
            stop: called after every step; a reason that it returns ends the run.

        Raises:
            InputError: the model or a setting is wrong.
            SolveError: a step failed however small, or the run was stopped; ``run`` holds the motion up to there.
        """
        settings = SimulateSettings(
            **given(
                duration=duration,
                tolerance=tolerance,
                time_step=time_step,
                initial=initial,
                integrator=integrator,
                spectral_radius=spectral_radius,
                output_interval=output_interval,
                formulation=formulation,
                damping=damping,
                dynamics=dynamics,
                events=events,
            )
        )
        require_fit(self, settings)
        from viscorod.analyses.transient import simulate

        if resume and folder is None:
            raise InputError("resume: give the folder of the run that is to go on")
        work = self._discretised(settings.formulation, settings.damping)
        attrs = self._attrs(title) | {"settings": json.dumps(settings.to_dict())}
        if folder is None:
            return simulate(work, settings, progress, attrs, stop=stop)
        from viscorod.results.files.stream import Stream

        stream = Stream(folder=Path(folder), about=attrs, resuming=resume)
        try:
            return simulate(work, settings, progress, attrs, stream, stop)
        finally:
            stream.journal.close()

    def system(
        self,
        ports: Sequence[str] = (),
        *,
        tolerance: float | None = None,
        time_step: float | None = None,
        initial: str = "equilibrium",
        integrator: str = "radau",
        spectral_radius: float | None = None,
        output_interval: float | None = None,
        formulation: str = "geometric",
        damping: str = "full",
        title: str = "",
    ) -> CoSimulation:
        """Let another program move this model step by step: forces in at the ``ports``, motion out.

        Args:
            ports: places where the other program acts, such as "beam.end".
            title: kept with the result; the others: see :meth:`simulate`.

        Raises:
            InputError: the model or a setting is wrong, or a port is no place.
        """
        from viscorod.analyses.coupling import CoSimulation

        settings = given(
            tolerance=tolerance,
            time_step=time_step,
            initial=initial,
            integrator=integrator,
            spectral_radius=spectral_radius,
            output_interval=output_interval,
            formulation=formulation,
            damping=damping,
        )
        return CoSimulation(self, ports, attrs=self._attrs(title), **settings)

    def draw(self, path: str | Path, title: str = "") -> Path:
        """Draw the model in its reference shape: rods, bodies, joints, springs, supports and loads.

        Args:
            path: picture to write; the suffix tells the format (.png, .pdf, .svg).
            title: above the picture.

        Returns:
            The path.

        Raises:
            InputError: the model is inconsistent, or the picture cannot be written.
        """
        from viscorod.pictures.drawing.model_drawing import draw_assembly
        from viscorod.pictures.style import write

        return write(draw_assembly(self, title), path)

    def modes(self, count: int = 6, *, about: str = "equilibrium") -> Modes:
        """Find the slowest small damped vibrations about an equilibrium or the reference shape.

        Args:
            count: number of modes.
            about: "equilibrium" under the loads at t = 0- (just before t = 0), the equilibrium once "released", under
                those just after t = 0, or the "reference" shape (as if free of load).

        Returns:
            eigenvalues [1/s], frequencies [Hz], damping ratios, shapes, and the positions about which they swing [m].

        Raises:
            InputError: the model is inconsistent, nothing holds it there, or about or count is wrong.
            SolveError: no such equilibrium was found.
        """
        if about not in ABOUT:
            raise InputError(f"about = {about!r}: give one of {', '.join(map(repr, ABOUT))}")
        if not isinstance(count, int | np.integer) or count < 1:
            raise InputError(f"count = {count!r}: give a whole number of at least 1")
        return self._discretised().modes(int(count), about)

    def steady(
        self,
        *,
        spin: float | Sequence[float] | None = None,
        energy: float | None = None,
        momentum: float | None = None,
        axis: Sequence[float] | None = None,
        about: Sequence[float] | None = None,
        start: Run | Steady | Equilibrium | None = None,
        formulation: str = "geometric",
        damping: str = "full",
        modes: int = 6,
        title: str = "",
        stop: Callable[[], str] | None = None,
    ) -> Steady:
        """Find a steady rotation, in which every rod turns like a rigid body, and its small motions.

        Exactly one of ``spin``, ``energy`` and ``momentum`` is given. Prescribed motions are refused: supports turn
        with the rotation as they are.

        Args:
            spin: [rad/s]; three numbers: the angular velocity, global axes; one number: how fast a rod on a ball joint
                (one pin) or without supports turns, about an axis that is found.
            energy: kinetic and elastic energy of such a rod [J].
            momentum: its angular momentum about the joint or the mass centre [N m s].
            axis: start from the reference shape turning about this axis; without it a bent shape is sought.
            about: a point on the axis of a given angular velocity [m]; the origin, for a rod that turns freely its
                joint or mass centre.
            start: a result whose last state is the first guess.
            formulation: "geometric" or "intrinsic".
            damping: "full" or "linearised" (intrinsic formulation), which lets straight rods turn about their own axis
                only.
            modes: number of small motions to report.
            title: kept with the result.
            stop: called in every iteration; a reason that it returns ends the search.

        Raises:
            InputError: supports, loads or damping allow no such rotation.
            SolveError: none was found, or the search was stopped.
        """
        from viscorod.analyses.steady import steady_rotation

        settings = SteadySettings(
            **given(
                spin=spin,
                energy=energy,
                momentum=momentum,
                axis=axis,
                about=about,
                formulation=formulation,
                damping=damping,
                modes=modes,
            )
        )
        return steady_rotation(self._discretised(stop=stop), self, settings, start, self._attrs(title))

    def with_known_times(self) -> Model:
        """The model with the times of all materials known: those that follow from a mode (`MeasuredDamping`) are found.

        Raises:
            InputError: the model is inconsistent, or there is no such mode.
        """
        from viscorod.analyses.modal_damping import with_known_times

        return with_known_times(self)

    def _discretised(
        self,
        formulation: str = "geometric",
        damping: str = "full",
        stop: Callable[[], str] | None = None,
    ) -> DiscreteModel:
        from viscorod.analyses.discrete import DiscreteModel

        return DiscreteModel.of(self, formulation, damping, stop)

    def _attrs(self, title: str) -> dict[str, Any]:
        from viscorod import __version__

        case = json.dumps(self.to_dict())
        text = self.about.get("case_text") or case
        return {
            "title": title,
            "case": case,
            "case_hash": hashlib.sha256(text.encode()).hexdigest(),
            "version": __version__,
            "platform": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.platform()}",
            **self.about,
        }

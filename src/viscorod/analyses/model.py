"""A model that can be computed.

The solvers are imported when something is first computed, so that a model is built at once.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from viscorod.analyses.call_arguments import (
    CoSimulationArguments,
    EquilibriumArguments,
    PathArguments,
    PeriodicArguments,
    SimulateArguments,
    SteadyArguments,
    takes,
)
from viscorod.analyses.linearised import Linearised
from viscorod.errors import Fault, InputError
from viscorod.solve.settings.theories import TheorySettings

if TYPE_CHECKING:
    from viscorod.analyses.co_simulation import CoSimulation
    from viscorod.analyses.derivatives.value_and_gradient import ValueAndGradient
    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.results.periodic import Periodic
    from viscorod.results.run import Run
    from viscorod.results.steady_result import Steady
    from viscorod.results.theory_comparison import TheoryComparison

__all__ = ["Model"]

DIFFERENTIATED = ("simulate", "equilibrium", "modes", "steady", "frequency_response", "periodic")
"""Analyses whose results have derivatives."""


class Model(Linearised):
    """Rods, supports and loads (see :class:`ModelDescription`), and what can be computed of them."""

    @takes(EquilibriumArguments)
    def equilibrium(self, call: EquilibriumArguments) -> Equilibrium:
        """Find the static equilibrium under the loads at t = 0- (just before t = 0).

        Raises:
            InputError: the model is inconsistent, or free to move as a rigid body.
            SolveError: no equilibrium was found, or the search was stopped; ``run`` holds the load steps that were.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.equilibrium import equilibrium
        from viscorod.analyses.refinement import refined

        discrete = DiscreteModel.of(self, call, call.options)
        result = refined(equilibrium, discrete, call)
        if call.derivatives:
            from viscorod.analyses.derivatives.differentiate import equilibrium_derivatives, with_derivatives

            with_derivatives(equilibrium_derivatives, self, discrete, call, result)
        return result

    @takes(PathArguments)
    def path(self, call: PathArguments) -> Equilibrium:
        """Follow the static equilibria from the unloaded one on, through limit points and past bifurcations.

        The load factor may grow and shrink on the way. The path goes on through a bifurcation; to branch off, add a
        small load that prefers one of the branches. With fewer points than the path needs, its outcome is "points".

        Returns:
            The points of the path from the unloaded shape on, in order; limit points and bifurcations are among them.

        Raises:
            InputError: the model is inconsistent, or free to move as a rigid body.
            SolveError: the path could not be followed further, or was stopped; ``run`` holds it up to there.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.path import equilibrium_path
        from viscorod.analyses.refinement import refined

        return refined(equilibrium_path, DiscreteModel.of(self, call, call.options), call)

    @takes(SimulateArguments)
    def simulate(self, call: SimulateArguments) -> Run:
        """Compute the motion from t = 0 to ``duration``.

        Raises:
            InputError: the model or a setting is wrong.
            SolveError: a step failed however small, or the run was stopped; ``run`` holds the motion up to there.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.motion import motion
        from viscorod.analyses.refinement import refined_motion

        discrete = DiscreteModel.of(self, call, call.options)
        if not call.errors and (free := discrete.watch.free):
            why = f"the program chooses the mesh of {', '.join(map(repr, free[:6]))} by the errors that it leaves"
            raise InputError(Fault("errors", "False", why, "give these rods elements, or leave errors out"))
        run = refined_motion(motion, discrete, call)
        if call.derivatives:
            from viscorod.analyses.derivatives.differentiate import with_derivatives
            from viscorod.analyses.derivatives.motions import motion_derivatives

            with_derivatives(motion_derivatives, self, discrete, call, run)
        return run

    @takes(CoSimulationArguments)
    def co_simulation(self, call: CoSimulationArguments) -> CoSimulation:
        """Let another program move this model step by step: forces in at the ``ports``, motion out.

        Raises:
            InputError: the model or a setting is wrong, or a port is not a place.
        """
        from viscorod.analyses.co_simulation import CoSimulation

        return CoSimulation.of(self, call, call.options)

    def system(self, *args: Any, **settings: Any) -> CoSimulation:
        """Do what :meth:`co_simulation` does; the name of version 0.1."""
        warnings.warn("Model.system is now Model.co_simulation", DeprecationWarning, stacklevel=2)
        return self.co_simulation(*args, **settings)

    @takes(SteadyArguments)
    def steady(self, call: SteadyArguments) -> Steady:
        """Find a steady rotation, in which every rod turns like a rigid body, and its small motions.

        Prescribed motions have to be constant: supports turn with the rotation.

        Raises:
            InputError: supports, loads or damping allow no such rotation.
            SolveError: none was found, or the search was stopped.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.refinement import refined
        from viscorod.analyses.steady import steady_rotation

        discrete = DiscreteModel.of(self, call, call.options)
        found = refined(steady_rotation, discrete, call)
        if call.derivatives:
            from viscorod.analyses.derivatives.differentiate import with_derivatives
            from viscorod.analyses.derivatives.rotations import steady_derivatives

            with_derivatives(steady_derivatives, self, discrete, call, found)
        return found

    def value_and_gradient(
        self,
        keys: Sequence[str],
        function: Callable[[Any], Any],
        analysis: str = "simulate",
        *,
        adjoint: bool = False,
        **settings: Any,
    ) -> ValueAndGradient:
        """Make a function of numbers of this model that returns a value and its gradient.

        Optimisers and samplers call it with an array of numbers (SI units): ``scipy.optimize.minimize(f, f.values,
        jac=True)``. Give ``elements`` to the rods: a mesh that the program chooses may change with the numbers.

        Args:
            keys: of the numbers, as in ``derivatives``.
            function: what is made of the result: a number, or an array.
            analysis: "simulate", "equilibrium", "modes" or "frequency_response".
            adjoint: for many numbers of a motion. The function then returns one number and its derivatives by what is
                stored, ``(value, {"position": array})`` with arrays like ``run.data["position"]``, "rotation",
                "velocity" or "angular_velocity"; the gradient costs as much however many numbers there are.
            settings: arguments of that analysis.

        Returns:
            ``f(values) -> (value, gradient)``, the numbers along the last axis of the gradient; ``f.values`` are those
            of this model.

        Raises:
            InputError: there is no such number or analysis.
        """
        from viscorod.analyses.derivatives.value_and_gradient import ValueAndGradient

        if analysis not in DIFFERENTIATED:
            raise InputError(
                Fault(
                    "analysis", repr(analysis), "it has no derivatives", f"give {' or '.join(DIFFERENTIATED)}"
                )
            )
        if adjoint and analysis != "simulate":
            raise InputError(
                Fault("adjoint", repr(analysis), "only motions have an adjoint", "leave adjoint out")
            )
        return ValueAndGradient(self, keys, function, analysis, settings, adjoint=adjoint)

    @takes(TheorySettings)
    def compare_theories(self, settings: TheorySettings) -> TheoryComparison:
        """Compute a planar straight beam by Euler-Bernoulli, Timoshenko and von Karman beside the exact theory.

        Euler-Bernoulli's and Timoshenko's beams are linear, without and with shear and rotary inertia; von Karman's
        has no shear, and its deflections stretch it, eps = u' + w'^2/2 (Artola, Wynn and Palacios, section IV). Loads
        and mesh are the same.

        Returns:
            Displacements, section forces and frequencies of all of them, what each errs by, and which is enough for
            this load and amplitude; ``print`` shows them in a table.

        Raises:
            InputError: the model is no single straight rod in a plane with dead loads and fixed supports.
            SolveError: a theory has no equilibrium under the loads.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.theories import compare_theories
        from viscorod.model.description.consistency import require_inertia

        require_inertia(self)
        return compare_theories(DiscreteModel.of(self), settings)

    @takes(PeriodicArguments)
    def periodic(self, call: PeriodicArguments) -> Periodic:
        """Follow periodic motions under harmonic inputs, of any size: over frequency or level, through folds.

        Motions are trigonometric polynomials of the frequency that are in balance at all their phases (harmonic
        balance by collocation; see Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019). Loads of
        the model itself stay what they are just before t = 0; about the equilibrium under them the motions begin.
        Materials have their laws; a table over frequency counts by the law that was fitted to it.

        Returns:
            The motions in the order of the curve: harmonics of all outputs, Floquet multipliers, work and loss of a
            cycle; folds and other bifurcations are among them.

        Raises:
            InputError: the model is inconsistent, has parts that periodic motions do not know, or there is no such
                input or output.
            SolveError: no motion was found at the start, the curve could not be followed further, or was stopped;
                ``run`` holds the motions up to there.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.linear_about import with_input_loads
        from viscorod.analyses.periodic import periodic
        from viscorod.analyses.refined_frequencies import refined_periodic

        driven = with_input_loads(self, call)
        discrete = DiscreteModel.of(driven, call, call.options)
        found = refined_periodic(periodic, discrete, call)
        if call.derivatives:
            from viscorod.analyses.derivatives.differentiate import with_derivatives
            from viscorod.analyses.derivatives.orbits import orbit_derivatives

            with_derivatives(orbit_derivatives, driven, discrete, call, found)
        return found

    def with_known_times(self) -> Model:
        """Return the model with the times of its materials known: those from a mode (`MeasuredDamping`) are found.

        Raises:
            InputError: the model is inconsistent, or there is no such mode.
        """
        from viscorod.analyses.modal_damping import with_known_times

        return with_known_times(self)

"""A model that can be computed.

The solvers are imported when something is first computed, so that a model is built at once.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from viscorod.analyses.call_arguments import (
    BucklingArguments,
    CampbellArguments,
    CoSimulationArguments,
    EquilibriumArguments,
    LinearArguments,
    ModesArguments,
    PathArguments,
    PeriodicArguments,
    ResponseArguments,
    SimulateArguments,
    StabilityArguments,
    SteadyArguments,
    takes,
)
from viscorod.analyses.inspected import Inspected
from viscorod.errors import Fault, InputError
from viscorod.solve.settings.theories import TheorySettings

if TYPE_CHECKING:
    from viscorod.analyses.co_simulation import CoSimulation
    from viscorod.analyses.derivatives.value_and_gradient import ValueAndGradient
    from viscorod.results.buckling import Buckling
    from viscorod.results.campbell import Campbell
    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.results.frequency_response import FrequencyResponse
    from viscorod.results.linear_system import LinearSystem
    from viscorod.results.modes_result import Modes
    from viscorod.results.periodic import Periodic
    from viscorod.results.run import Run
    from viscorod.results.stability_result import Stability
    from viscorod.results.steady_result import Steady
    from viscorod.results.theory_comparison import TheoryComparison

__all__ = ["Model"]

DIFFERENTIATED = ("simulate", "equilibrium", "modes", "steady", "frequency_response", "periodic")
"""Analyses whose results have derivatives."""


class Model(Inspected):
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

    @takes(ModesArguments)
    def modes(self, call: ModesArguments) -> Modes:
        """Find small vibrations about an equilibrium or the reference shape: the slowest, or those near a frequency.

        Returns:
            eigenvalues [1/s], frequencies [Hz], damping ratios, shapes, the positions about which they swing [m], and
            their names; each with its residual, and whether it is proven that none is missing.

        Raises:
            InputError: the model is inconsistent, nothing holds it there, or about or count is wrong.
            SolveError: no such equilibrium was found.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.modes import modes
        from viscorod.analyses.refined_frequencies import refined_modes

        discrete = DiscreteModel.of(self, call, call.options)
        found = refined_modes(modes, discrete, call)
        if call.derivatives:
            from viscorod.analyses.derivatives.differentiate import with_derivatives
            from viscorod.analyses.derivatives.eigenvalues import modes_derivatives

            with_derivatives(modes_derivatives, self, discrete, call, found)
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

    @takes(LinearArguments)
    def linear(self, call: LinearArguments) -> LinearSystem:
        """Make the model linear about a state: matrices with names, inputs and outputs, state space, reductions.

        Materials have their laws; a table over frequency counts by the law that was fitted to it.

        Returns:
            mass, damping, gyroscopic, stiffness and circulatory matrices and those of Maxwell branches (sparse), with
            what inputs do and outputs read.

        Raises:
            InputError: the model is inconsistent, or there is no such input or output.
            SolveError: no such equilibrium was found.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.linear_about import with_input_loads
        from viscorod.analyses.linear_system import linear_system

        return linear_system(DiscreteModel.of(with_input_loads(self, call), None, call.options), call)

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

    @takes(ResponseArguments)
    def frequency_response(self, call: ResponseArguments) -> FrequencyResponse:
        """Find the responses to harmonic inputs: small motions about a state, solved at every frequency.

        Materials have their exact complex moduli: Kelvin-Voigt, Maxwell branches, and tables over frequency as they
        were measured. Receptance is displacement over force, mobility velocity over force, accelerance acceleration
        over force, transmissibility motion over the motion of a support.

        Returns:
            The complex responses over frequency, their peaks with the damping that is read off them, and the poles.

        Raises:
            InputError: the model is inconsistent, or there is no such input or output.
            SolveError: no such equilibrium was found, an undamped vibration is in resonance, or it was stopped; ``run``
                holds the response up to there.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.frequency_response import frequency_response
        from viscorod.analyses.linear_about import with_input_loads
        from viscorod.analyses.refined_frequencies import refined_response

        model = with_input_loads(self, call)
        discrete = DiscreteModel.of(model, call, call.options)
        found = refined_response(frequency_response, discrete, call)
        if call.derivatives:
            from viscorod.analyses.derivatives.differentiate import with_derivatives
            from viscorod.analyses.derivatives.responses import response_derivatives

            with_derivatives(response_derivatives, model, discrete, call, found)
        return found

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

    @takes(BucklingArguments)
    def buckling(self, call: BucklingArguments) -> Buckling:
        """Find critical loads: where along its equilibria the model loses stiffness, and how it gives way there.

        All loads, prescribed motions and rest strains grow with the load factor, but those that are ``constant``.

        Returns:
            critical load factors, those of the linear problem beside them, and shapes.

        Raises:
            InputError: the model is inconsistent, nothing holds it, or nothing grows.
            SolveError: there is no such prestress, the equilibria could not be followed, or it was stopped.
        """
        from viscorod.analyses.buckling import buckling
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.refined_frequencies import refined_buckling

        return refined_buckling(buckling, DiscreteModel.of(self, call, call.options), call)

    @takes(CampbellArguments)
    def campbell(self, call: CampbellArguments) -> Campbell:
        """Follow modes over the speed of a steady rotation: a Campbell diagram with critical speeds and limits.

        Supports turn with the model about a given axis, as in :meth:`steady`; springs and dampers to the ground are
        those of bearings, which are alike all around the axis. Modes are followed by their shapes through crossings and
        veerings. Critical speeds and limits of stability are roots that are solved for, not read off a curve.

        Returns:
            roots, frequencies, damping ratios and whirl over the speed, critical speeds, limits of stability.

        Raises:
            InputError: the model cannot turn steadily about this axis, or has no frequencies in space.
            SolveError: a rotation or its small motions were not found, or it was stopped.
        """
        from viscorod.analyses.campbell import campbell
        from viscorod.analyses.discrete import DiscreteModel

        return campbell(DiscreteModel.of(self, call, call.options), call)

    @takes(StabilityArguments)
    def stability(self, call: StabilityArguments) -> Stability:
        """Follow modes about the equilibria over a load factor: where they begin to flutter, and to diverge.

        Damping and loads that follow are included.

        All loads, prescribed motions and rest strains grow with the load factor, but those that are ``constant``.
        Limits of stability are roots that are solved for, not read off a curve.

        Returns:
            roots, frequencies and damping ratios over the load factor, and where modes begin to grow and cease to.

        Raises:
            InputError: the model is inconsistent, nothing holds it, or nothing grows.
            SolveError: an equilibrium or its small motions were not found, or it was stopped.
        """
        from viscorod.analyses.discrete import DiscreteModel
        from viscorod.analyses.stability import stability

        return stability(DiscreteModel.of(self, call, call.options), call)

    def with_known_times(self) -> Model:
        """Return the model with the times of its materials known: those from a mode (`MeasuredDamping`) are found.

        Raises:
            InputError: the model is inconsistent, or there is no such mode.
        """
        from viscorod.analyses.modal_damping import with_known_times

        return with_known_times(self)

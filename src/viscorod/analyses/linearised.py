"""What can be computed of small motions of a model: modes, linear systems, responses, stability, critical loads.

The solvers are imported when something is first computed, as in ``analyses.model``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from viscorod.analyses.call_arguments import (
    BucklingArguments,
    CampbellArguments,
    LinearArguments,
    ModesArguments,
    ResponseArguments,
    StabilityArguments,
    takes,
)
from viscorod.analyses.inspected import Inspected

if TYPE_CHECKING:
    from viscorod.results.buckling import Buckling
    from viscorod.results.campbell import Campbell
    from viscorod.results.frequency_response import FrequencyResponse
    from viscorod.results.linear_system import LinearSystem
    from viscorod.results.modes_result import Modes
    from viscorod.results.stability_result import Stability

__all__ = ["Linearised"]


class Linearised(Inspected):
    """Rods, supports and loads, and what can be computed of small motions about their states."""

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

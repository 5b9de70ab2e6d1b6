"""The interface between formulations and analyses, and the state they exchange.

An analysis (statics, an integrator, modes) sees a :class:`System`: it can assemble generalised forces and their tangent
for a pose and a twist of every node, carry the section forces along a Newton increment, and report energies. It does
not know strains or interpolation. A formulation implements this class once and is registered in ``FORMULATIONS``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.linearised import Operators
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.imposed_strains import Imposed, ImposedStrains
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.solve.constraints.constraints import Constraints
    from viscorod.solve.formulations.dashpot_memory import DashpotMemory
    from viscorod.solve.formulations.element_forces import ElementForces


@dataclass
class State:
    """Poses ``r (n, 3)``, ``q (n, 4)`` and body twists ``(n, 6)`` of all nodes, and multipliers, six to a block row."""

    r: Floats
    q: Floats
    twist: Floats
    multiplier: Floats = field(default_factory=lambda: np.zeros(0))

    @classmethod
    def reference(cls, problem: Problem) -> State:
        """Return the reference shape at rest."""
        return cls(
            problem.positions.copy(),
            problem.quaternions.copy(),
            np.zeros((problem.size, 6)),
            np.zeros(6 * problem.multipliers),
        )

    def copy(self) -> State:
        """Return an independent copy."""
        return State(self.r.copy(), self.q.copy(), self.twist.copy(), self.multiplier.copy())

    def set(self, other: State) -> None:
        """Take over the values of ``other``."""
        self.r[:], self.q[:], self.twist[:] = other.r, other.q, other.twist
        self.multiplier[:] = other.multiplier


@dataclass(frozen=True)
class GaussPoints:
    """Strain, strain rate and section force at all Gauss points, rod by rod in order of arc length, each ``(m, 6)``."""

    strain: Floats
    strain_rate: Floats
    section_force: Floats


@dataclass(frozen=True)
class GaussPositions:
    """Rod, arc length [m], quadrature length [m], half width [m], stiffness and damping of every Gauss point.

    ``section`` is the number of its section among those of :meth:`System.elements`.
    """

    rod: Integers
    s: Floats
    length: Floats
    half_width: Floats
    stiffness: Floats
    damping: Floats
    section: Integers


class System(Protocol):
    """A formulation as analyses use it; all nodal forces are in body components ``(n, 6)``."""

    problem: Problem
    constraints: Constraints
    imposed: ImposedStrains
    """Rest strains of the rods."""
    rest: tuple[Floats, Floats]
    """Those that change with time, ``(1, e, points, 6)``, and their rates, as they were imposed last."""
    relaxation: DashpotMemory | None
    """State of the Maxwell branches; None if there are none."""
    internal: Floats
    external: Floats
    dissipated: float
    """Power that loads dissipated in the last assembly [W]."""
    matrix: Matrix
    given_strain: Floats | None
    """Strains at the Gauss points ``(m, 6)``, in order of results, that a motion starts with; None: those of poses."""

    def assemble(
        self,
        state: State,
        loads: LoadState,
        rate_map: Floats | None,
        *,
        tangent: bool,
        moving: bool,
        rate_matrix: Matrix | None = None,
    ) -> None:
        """Fill ``internal``, ``external`` and, with ``tangent``, ``matrix`` with d(internal - external)/d(increment).

        ``rate_map (n, 6, 6)`` is d(twist)/d(increment), None for none; ``moving`` False ignores the twists (statics).
        ``rate_matrix``, if given, is filled with d(internal)/d(twist), the damping matrix (with ``tangent``).
        """

    def linearise(
        self, state: State, ad: Floats, stress: Floats, operators: Operators, K: Floats, C: Floats
    ) -> None:
        """Write the operators of all elements, and add their stiffness and damping matrices to ``K`` and ``C``.

        These are blocks of the problem's pattern; increments turn with the nodes, ``ad (n, 6, 6)`` is
        ``ad(twist)``. ``stress`` is that of the geometric stiffness, in the arrays of :meth:`elements`. Needed by
        collocation methods only.
        """

    def assemble_mass(self, state: State) -> None:
        """Fill ``matrix`` with the mass and the rows and columns of multipliers at ``state``."""

    def residual(self) -> Floats:
        """Return the unbalanced forces of the last assembly, and the gaps that multipliers must close ``(N, 6)``."""

    def impose_rest(self, rest: Imposed) -> None:
        """Take rest strains into the strains of the unstressed shape, until loads or a later call say otherwise."""

    def carry_stress(self, increment: Floats) -> None:
        """Move the stress iterate along a Newton increment of the nodes ``(N, 6)`` (mixed Newton)."""

    def constraint_gradients(self, state: State) -> sparse.csr_array:
        """Return the derivatives of all gaps (held coordinates, held strains) by body increments ``(rows, 6 n)``."""

    def multiplier_change(self, increment: Floats) -> Floats:
        """Return the change of the multipliers that an increment ``(N, 6)`` contains, in their units."""

    def reset_stress(self) -> None:
        """Take the section forces of the last assembly as stress iterate."""

    def elastic_energy(self) -> float:
        """Return the elastic energy [J] of the last assembly."""

    def viscous_loss(self, duration: float) -> float:
        """Return the energy [J] lost to viscosity since the last call, ``duration`` [s] ago; 0 starts counting anew."""

    def advance_branches(self) -> Floats:
        """Advance the branches to the last assembly; return the energy that each lost since then ``(n,)`` [J]."""

    def branch_power(self) -> Floats | None:
        """Return the power that the branches dissipate per length ``(m,)`` [W/m] in the order of results, or None."""

    def branch_strain(self) -> Floats | None:
        """Return the strains of the branches' springs ``(m, n, 6)`` in the order of results, or None."""

    def gauss_points(self) -> GaussPoints:
        """Return the Gauss-point fields of the last assembly."""

    def gauss_indices(self) -> Integers:
        """Return the indices of all Gauss points, in the same order, in the flattened arrays of :meth:`elements`."""

    def elements(self) -> Elements:
        """Return all elements as one structure for compiled code."""

    def element_forces(self, elements: Elements, stages: int) -> ElementForces:
        """Return the internal forces at the start and the stages of a collocation step."""

    def gauss_positions(self) -> GaussPositions:
        """Return where the Gauss points are, in the same order."""

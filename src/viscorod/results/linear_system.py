"""A model made linear, in public: its matrices, state space, reductions, files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy import sparse

from viscorod.alike import Alike
from viscorod.argument_names import known_arguments
from viscorod.checks import checked
from viscorod.errors import Fault, InputError
from viscorod.results.reduced_system import ReducedSystem, judged
from viscorod.results.state_matrices import StateMatrices
from viscorod.shown import Shown, counted
from viscorod.solve.linear_systems.reductions import balanced, craig_bampton_basis, modal_basis
from viscorod.solve.linear_systems.second_order import FirstOrderMatrices, SecondOrder
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from scipy.signal import StateSpace

__all__ = ["LinearSystem"]

MOST_STATES = 4000
"""States of full matrices at most."""
ROUND_OFF = 1e-12
"""Part of the entries on the diagonal that is round-off of the others."""

Reduction = Literal["modal", "craig_bampton", "balanced"]


@known_arguments
@dataclass(frozen=True, repr=False, eq=False)
class LinearSystem(Shown, Alike):
    """A model made linear about a state, ``M y'' + (D + G) y' + (K + N) y + sum_j K_j w_j = F u``.

    ``y`` are small motions of the nodes, displacements [m] and rotations [rad] in body axes; branch j of a Maxwell
    material has ``w_j' = y' - w_j/tau_j``, or in harmonic motion the complex stiffness ``i omega tau_j/(1 + i omega
    tau_j) K_j``. Matrices are sparse. About a steady rotation all is seen in axes that turn with it.

    Words and units of what goes in and comes out are its ``inputs``, ``outputs``, ``input_units`` and ``output_units``.

    Attributes:
        coordinates: names of ``y``: node and direction; where joints and held strains are eliminated, combinations of
            them (see ``combinations``).
        combinations: of the named motions of nodes ``(motions, coordinates)``; None where each coordinate is one.
        motions: names of the motions of nodes.
        conditions: ``(rows, motions)`` of joints and held strains, of unit length, whose products with these motions
            vanish; None without.
        about: the state, in words; title: of the model.
        rigid: number of motions that nothing resists at rest; warnings: doubts about the model and the state.
    """

    second_order: SecondOrder = field(repr=False)
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    coordinates: tuple[str, ...] = field(repr=False)
    motions: tuple[str, ...] = field(repr=False)
    combinations: Floats | None = field(default=None, repr=False)
    conditions: sparse.csr_array | None = field(default=None, repr=False)
    ends: dict[str, Integers] = field(default_factory=dict, repr=False)
    about: str = ""
    title: str = ""
    rigid: int = 0
    warnings: tuple[str, ...] = field(default=(), repr=False)

    def _facts(self) -> Iterator[str]:
        yield counted(self.size, "coordinate")
        if self.branches:
            yield counted(len(self.branches), "branch", "branches")
        yield f"inputs {', '.join(self.inputs)}"
        yield f"outputs {', '.join(self.outputs)}"
        if self.about:
            yield f"about {self.about}"
        if self.warnings:
            yield counted(len(self.warnings), "warning")

    @property
    def mass(self) -> sparse.csr_array:
        """M, symmetric."""
        return self.second_order.terms[2]

    @property
    def damping(self) -> sparse.csr_array:
        """D, the symmetric part of what velocities are multiplied by: viscosity and dampers, not the branches."""
        return _half(self.second_order.terms[1], 1)

    @property
    def gyroscopic(self) -> sparse.csr_array:
        """G, its skew part."""
        return _half(self.second_order.terms[1], -1)

    @property
    def stiffness(self) -> sparse.csr_array:
        """K, the symmetric part of what motions are multiplied by: material, prestress, loads; at rest."""
        return _half(self.second_order.terms[0], 1)

    @property
    def circulatory(self) -> sparse.csr_array:
        """N, its skew part, which loads that follow bring: it has no potential."""
        return _half(self.second_order.terms[0], -1)

    @property
    def branches(self) -> tuple[tuple[float, sparse.csr_array], ...]:
        """Relaxation time [s] and stiffness of every Maxwell branch."""
        return tuple(zip(map(float, self.second_order.times), self.second_order.terms[3:], strict=True))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.second_order.size

    def at(self, s: complex) -> sparse.csr_array:
        """Return the dynamic stiffness ``(n, n)`` at ``s`` [1/s], branches with their complex modulus."""
        return self.second_order.at(s)

    def response(self, frequencies: Sequence[float] | Floats) -> np.ndarray:
        """Return the responses ``(frequencies, outputs, inputs)`` at frequencies [Hz].

        Raises:
            InputError: a frequency is no finite number >= 0.
        """
        given = np.atleast_1d(np.asarray(frequencies, dtype=float))
        wrong = given[~((given >= 0.0) & (given < np.inf))]
        if len(wrong):
            raise InputError(f"frequencies: {wrong[0]:g}: give finite numbers >= 0, Hz")
        return np.array([self.second_order.response(float(f)) for f in given])

    def first_order(self) -> StateMatrices:
        """Return the equations of first order, exact, with the branches as states.

        States are the coordinates, their rates, and for each branch the displacements less those of its dashpots;
        where accelerations are prescribed, the motions, their rates and their branches follow.

        Raises:
            InputError: an input is a displacement or a velocity, whose derivatives would be needed, or there are too
                many states for full matrices.
        """
        self._require_proper()
        return self._with_words(self.second_order.first_order())

    def _require_proper(self) -> None:
        for k, derivative in enumerate(self.second_order.derivative):
            if derivative in (0, 1):
                raise InputError(
                    Fault(
                        f"inputs[{k}]",
                        repr(self.inputs[k]),
                        "equations of first order would need its second derivative",
                        "give the acceleration, such as 'base az', or take the response to harmonic motion",
                    )
                )
        states = (2 + len(self.second_order.times)) * (self.size + len(self.inputs))
        if states > MOST_STATES:
            raise InputError(
                f"{states} states are too many for full matrices ({MOST_STATES} at most); take reduced(...) first"
            )

    def _with_words(self, found: FirstOrderMatrices) -> StateMatrices:
        return StateMatrices(*found, self.inputs, self.outputs)

    def state_space(self) -> StateSpace:
        """Return the equations of first order for ``scipy.signal``; see ``first_order``."""
        return self.first_order().state_space()

    def control(self) -> Any:
        """Return them for python-control, where it is installed; see ``first_order``."""
        return self.first_order().control()

    @checked
    def save(self, path: str | Path) -> Path:
        """Write all matrices and names to a .npz file of NumPy or a .mat file of Matlab; returns the path.

        Sparse matrices of .npz files are their ``data``, ``indices`` and ``indptr`` by rows (CSR) and ``shape``, each
        under its name with a dot before these words.

        Raises:
            InputError: the suffix is another one, or the place cannot be written.
        """
        from viscorod.results.files.linear_system_file import write_linear_system

        return write_linear_system(self, Path(path))

    @checked
    def reduced(
        self,
        method: Reduction = "modal",
        modes: int = 10,
        *,
        band: tuple[float, float],
        rod: str | None = None,
    ) -> ReducedSystem:
        """Return a smaller system, with its error over a band computed, not estimated.

        Args:
            method: "modal" (the slowest undamped modes, rigid motions among them, and static correction: the static
                shapes under all inputs), "craig_bampton" (the motions of both ends of a rod kept, static shapes of
                these and modes with the ends held) or "balanced" (truncation of the state space, small systems only).
            modes: number of modes; of a balanced truncation half the number of states.
            band: lowest and highest frequency [Hz] over which the error is computed.
            rod: whose ends "craig_bampton" keeps; needed where there are several.

        Returns:
            the reduced system with its largest error, its poles beside those of the whole, and what its damping does.

        Raises:
            InputError: there is no such method or rod, or the system does not allow it.
            SolveError: a motion does not decay ("balanced").
        """
        low, high = (float(f) for f in band)
        if not 0.0 < low < high or modes < 1:
            raise InputError("band: give a lower and a higher frequency > 0, Hz; modes: one at least")
        second = self.second_order
        names: tuple[str, ...]
        if method == "balanced":
            self._require_proper()
            matrices, hankel = balanced(second, 2 * modes)
            small = self._with_words(matrices)
            names = tuple(f"state {k + 1}" for k in range(len(small.A)))
            bound = 2.0 * float(hankel[len(small.A) :].sum())
            return judged(self, method, small, None, names, (low, high), bound)
        if method == "craig_bampton":
            kept = self._ends(rod)
            V = craig_bampton_basis(second, kept, modes)
            names = tuple(self.coordinates[k] for k in kept)
            names += tuple(f"mode {k + 1} with the ends held" for k in range(V.shape[1] - len(kept)))
        elif method == "modal":
            V, _ = modal_basis(second, modes, self.rigid)
            names = tuple(
                f"mode {k + 1}" if k < modes else f"static shape {k + 1 - modes}" for k in range(V.shape[1])
            )
        else:
            raise InputError(f"method = {method!r}: give 'modal', 'craig_bampton' or 'balanced'")
        inner = replace(
            self, second_order=second.within(V), coordinates=names, combinations=V, conditions=None, ends={}
        )
        return judged(self, method, None, inner, names, (low, high), None)

    def _ends(self, rod: str | None) -> Integers:
        if self.combinations is not None:
            raise InputError(
                "craig_bampton keeps motions of nodes, and joints or held strains have been eliminated here; take "
                "method = 'modal'"
            )
        known = list(self.ends)
        if rod is None and len(known) == 1:
            rod = known[0]
        if rod not in self.ends:
            raise InputError(f"rod = {rod!r}: give one of {', '.join(map(repr, known))}")
        return self.ends[rod]


def _half(matrix: sparse.csr_array, sign: int) -> sparse.csr_array:
    """Return the symmetric (1) or the skew part (-1) of a matrix, the latter without entries that are round-off."""
    found = sparse.coo_array(0.5 * (matrix + sign * matrix.T))
    if sign < 0:
        own = np.sqrt(np.abs(matrix.diagonal()))
        found.data[np.abs(found.data) <= ROUND_OFF * own[found.row] * own[found.col]] = 0.0
    found.eliminate_zeros()
    return sparse.csr_array(found)

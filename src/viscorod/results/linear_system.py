"""A model made linear, in public: its matrices, state space, reductions, files."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.checks import checked
from viscorod.errors import Fault, InputError
from viscorod.results.text_table import table
from viscorod.solve.linear_systems.reductions import balanced, craig_bampton_basis, modal_basis
from viscorod.solve.linear_systems.second_order import FirstOrderMatrices, SecondOrder
from viscorod.typing import Floats, Integers
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from scipy.signal import StateSpace

__all__ = ["LinearSystem", "ReducedSystem", "StateMatrices"]

MOST_STATES = 4000
"""States of full matrices at most."""
POINTS = 200
"""Frequencies at which the error of a reduced system is computed, beside those of its poles."""
ROUND_OFF = 1e-12
"""Part of the entries on the diagonal that is round-off of the others."""
TOLD = 8
"""Poles that are compared at most."""

Reduction = Literal["modal", "craig_bampton", "balanced"]


@dataclass(frozen=True)
class StateMatrices:
    """Equations of first order, ``z' = A z + B u``, ``y = C z + D u``.

    Attributes:
        A, B, C, D: dense matrices; inputs, outputs: their words.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def state_space(self) -> StateSpace:
        """Return them for ``scipy.signal``."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.D)

    def control(self) -> Any:
        """Return them for python-control, with the words of inputs and outputs.

        Raises:
            InputError: python-control is not installed.
        """
        try:
            control = importlib.import_module("control")
        except ImportError:
            raise InputError(
                "python-control is not installed; install it with: pip install control, or take state_space()"
            ) from None
        return control.ss(
            self.A, self.B, self.C, self.D, inputs=list(self.inputs), outputs=list(self.outputs)
        )

    def response(self, frequencies: Floats) -> np.ndarray:
        """Return the responses ``(frequencies, outputs, inputs)`` at frequencies [Hz]."""
        A, (scale, _) = scipy.linalg.matrix_balance(self.A, permute=False, separate=True)
        B, C, unit = self.B / scale[:, None], self.C * scale, np.eye(len(A))
        return np.array(
            [C @ np.linalg.solve(2j * np.pi * f * unit - A, B) + self.D for f in np.atleast_1d(frequencies)]
        )

    @cached_property
    def poles(self) -> np.ndarray:
        """All poles ``s`` [1/s], slowest first."""
        s = np.linalg.eigvals(self.A)
        return np.asarray(s[np.argsort(np.abs(s), kind="stable")])


@dataclass(frozen=True)
class LinearSystem:
    """A model made linear about a state at rest, ``M y'' + (D + G) y' + (K + N) y + sum_j K_j w_j = F u``.

    ``y`` are small motions of the nodes, displacements [m] and rotations [rad] in body axes; branch j of a Maxwell
    material has ``w_j' = y' - w_j/tau_j``, or in harmonic motion the complex stiffness ``i omega tau_j/(1 + i omega
    tau_j) K_j``. Matrices are sparse.

    Attributes:
        inputs, outputs: their words; input_units, output_units: theirs.
        coordinates: names of ``y``: node and direction; where joints and held strains are eliminated, combinations of
            them (see ``combinations``).
        combinations: of the named motions of nodes ``(motions, coordinates)``; None where each coordinate is one.
        motions: names of the motions of nodes.
        conditions: ``(rows, motions)`` of joints and held strains, of unit length, whose products with these motions
            vanish; None without.
        about: the state, in words; title: of the model.
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
        """Return the responses ``(frequencies, outputs, inputs)`` at frequencies [Hz]."""
        return np.array([self.second_order.response(float(f)) for f in np.atleast_1d(frequencies)])

    def first_order(self) -> StateMatrices:
        """Return the equations of first order, exact, with the branches as states.

        States are the coordinates, their rates, and for each branch the displacements less those of its dashpots;
        where accelerations are prescribed, the motions, their rates and their branches follow.

        Raises:
            InputError: an input is a displacement or a velocity, whose derivatives would be needed, or there are too
                many states for full matrices.
        """
        self._require_proper()
        return self._named(self.second_order.first_order())

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

    def _named(self, found: FirstOrderMatrices) -> StateMatrices:
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
        path = Path(path)
        if path.suffix not in (".npz", ".mat"):
            raise InputError(f"{path}: the suffix {path.suffix!r} is not .npz or .mat")
        parts = self._parts()
        with replacing(path) as new, new.open("wb") as file:
            if path.suffix == ".npz":
                np.savez_compressed(file, **_flat(parts))
            else:
                from scipy.io import savemat

                texts = {
                    k: np.array(v, dtype=object) if isinstance(v, tuple) else v for k, v in parts.items()
                }
                savemat(file, texts, do_compression=True)
        return path

    def _parts(self) -> dict[str, Any]:
        second = self.second_order
        found: dict[str, Any] = {
            "mass": self.mass,
            "damping": self.damping,
            "gyroscopic": self.gyroscopic,
            "stiffness": self.stiffness,
            "circulatory": self.circulatory,
            "relaxation_times": second.times,
            "input_force": second.force,
            "input_derivative": second.derivative,
            "direct": second.direct,
            "inputs": self.inputs,
            "outputs": self.outputs,
            "input_units": self.input_units,
            "output_units": self.output_units,
            "coordinates": self.coordinates,
            "about": self.about,
        }
        words = ["stiffness", "damping", "mass", *(f"branch_{j + 1}" for j in range(len(second.times)))]
        for k, word in enumerate(words):
            found[f"input_{word}"] = second.pushed[k]
            found[f"output_{word}"] = second.rows[k]
            found[f"output_input_{word}"] = second.carried[k]
            if k > 2:
                found[word] = second.terms[k]
        if self.combinations is not None:
            found["combinations"], found["motions"] = self.combinations, self.motions
        if self.conditions is not None:
            found["conditions"] = self.conditions
        return found

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
            method: "modal" (the slowest undamped modes with static correction: the static shapes under all inputs
                beside them), "craig_bampton" (the motions of both ends of a rod kept, static shapes of these and modes
                with the ends held) or "balanced" (truncation of the state space, small systems only).
            modes: number of modes; of a balanced truncation half the number of states.
            band: lowest and highest frequency [Hz] over which the error is computed.
            rod: whose ends "craig_bampton" keeps; needed where there are several.

        Returns:
            the reduced system with its largest error, its poles beside those of the whole, and what its damping does.

        Raises:
            InputError: there is no such method or rod, or the system does not allow it.
            SolveError: a motion does not decay ("balanced"), or nothing holds the model ("modal").
        """
        low, high = (float(f) for f in band)
        if not 0.0 < low < high or modes < 1:
            raise InputError("band: give a lower and a higher frequency > 0, Hz; modes: one at least")
        second = self.second_order
        names: tuple[str, ...]
        if method == "balanced":
            self._require_proper()
            matrices, hankel = balanced(second, 2 * modes)
            small = self._named(matrices)
            names = tuple(f"state {k + 1}" for k in range(len(small.A)))
            return self._judged(
                method, small, None, names, (low, high), 2.0 * float(hankel[len(small.A) :].sum())
            )
        if method == "craig_bampton":
            kept = self._ends(rod)
            V = craig_bampton_basis(second, kept, modes)
            names = tuple(self.coordinates[k] for k in kept)
            names += tuple(f"mode {k + 1} with the ends held" for k in range(V.shape[1] - len(kept)))
        elif method == "modal":
            V, _ = modal_basis(second, modes)
            names = tuple(
                f"mode {k + 1}" if k < modes else f"static shape {k + 1 - modes}" for k in range(V.shape[1])
            )
        else:
            raise InputError(f"method = {method!r}: give 'modal', 'craig_bampton' or 'balanced'")
        inner = replace(
            self, second_order=second.within(V), coordinates=names, combinations=V, conditions=None, ends={}
        )
        return self._judged(method, None, inner, names, (low, high), None)

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

    def _judged(
        self,
        method: str,
        first: StateMatrices | None,
        second: LinearSystem | None,
        coordinates: tuple[str, ...],
        band: tuple[float, float],
        bound: float | None,
    ) -> ReducedSystem:
        """Return a reduced system with its errors against this one."""
        poles = _poles(first, second)
        resolved = min(int(np.count_nonzero(np.abs(poles) <= 2.0 * np.pi * band[1])), TOLD)
        exact = np.array([self.second_order.pole_near(complex(s)) for s in poles[:resolved]])
        inside = np.abs(np.concatenate([poles.imag, exact.imag])) / (2.0 * np.pi)
        near = inside[(inside > band[0]) & (inside < band[1])]
        hertz = np.unique(np.concatenate([np.geomspace(*band, POINTS), near]))
        whole = self.response(hertz)
        less = whole
        if first is not None:
            less = first.response(hertz)
        elif second is not None:
            less = second.response(hertz)
        difference = np.abs(less - whole)
        largest = np.maximum(np.abs(whole).max(axis=0), np.finfo(float).tiny)
        return ReducedSystem(
            method,
            second,
            first,
            coordinates,
            band,
            float((difference / largest).max()),
            float((difference / np.maximum(np.abs(whole), 1e-6 * largest)).max()),
            bound,
            poles,
            exact,
        )


@dataclass(frozen=True)
class ReducedSystem:
    """A linear system with fewer coordinates or states, and how far it is from the whole one.

    Attributes:
        method: by which it was reduced.
        system: of second order; None of a balanced truncation.
        matrices: of first order, of a balanced truncation.
        coordinates: names of the coordinates or states.
        band: frequencies [Hz] between which the errors were computed.
        error: largest difference of a response from that of the whole system, as a part of its largest one in the band.
        pointwise_error: the same as a part of the response at each frequency.
        bound: of the error of a balanced truncation at any frequency, in units of the response; None of others.
        poles: ``s`` [1/s] with Im > 0, slowest first.
        whole_poles: of the whole system next to the first of these, those within the band.
    """

    method: str
    system: LinearSystem | None
    matrices: StateMatrices | None
    coordinates: tuple[str, ...]
    band: tuple[float, float]
    error: float
    pointwise_error: float
    bound: float | None
    poles: np.ndarray
    whole_poles: np.ndarray

    def first_order(self) -> StateMatrices:
        """Return the equations of first order."""
        if self.matrices is not None:
            return self.matrices
        assert self.system is not None
        return self.system.first_order()

    def state_space(self) -> StateSpace:
        """Return them for ``scipy.signal``."""
        return self.first_order().state_space()

    def response(self, frequencies: Sequence[float] | Floats) -> np.ndarray:
        """Return the responses ``(frequencies, outputs, inputs)`` at frequencies [Hz]."""
        if self.matrices is not None:
            return self.matrices.response(np.asarray(frequencies, dtype=float))
        assert self.system is not None
        return self.system.response(frequencies)

    @property
    def passive(self) -> bool:
        """True if its damping takes energy out of every motion: forms of mass, damping and branches are not negative.

        A reduction by shapes keeps the energy balance of the motions that are left; a balanced truncation is in states
        that have no energy, and this says only that every motion decays.
        """
        if self.system is None:
            assert self.matrices is not None
            return bool(self.matrices.poles.real.max() < 0.0)
        forms = [self.system.mass, self.system.damping, *(matrix for _, matrix in self.system.branches)]
        return all(_not_negative(form) for form in forms)

    def report(self) -> str:
        """Return a report: size, errors over the band, poles, energy."""
        lines = [
            f"Reduced by {self.method.replace('_', '-')}: {len(self.coordinates)} coordinates",
            f"From {self.band[0]:g} to {self.band[1]:g} Hz responses differ from those of the whole system by "
            f"{self.error:.2g} of the largest, and by {self.pointwise_error:.2g} of the one at each frequency",
        ]
        if self.bound is not None:
            lines.append(f"No response is further off than {self.bound:.2g} at any frequency")
        lines.append(
            "Its damping takes energy out of every motion"
            if self.passive
            else "Its damping may create energy"
        )
        rows = [
            [
                f"{abs(s) / (2.0 * np.pi):.6g}",
                *(f"{-z.real / abs(z):.5g}" for z in (s, w)),
                f"{abs(w / s - 1.0):.1g}",
            ]
            for s, w in zip(self.poles, self.whole_poles, strict=False)
        ]
        header = ["frequency [Hz]", "damping ratio", "of the whole", "relative difference"]
        return "\n".join([*lines, *([table("Poles", header, rows)] if rows else [])])


def _half(matrix: sparse.csr_array, sign: int) -> sparse.csr_array:
    """Return the symmetric (1) or the skew part (-1) of a matrix, the latter without entries that are round-off."""
    found = sparse.coo_array(0.5 * (matrix + sign * matrix.T))
    if sign < 0:
        own = np.sqrt(np.abs(matrix.diagonal()))
        found.data[np.abs(found.data) <= ROUND_OFF * own[found.row] * own[found.col]] = 0.0
    found.eliminate_zeros()
    return sparse.csr_array(found)


def _not_negative(matrix: sparse.csr_array) -> bool:
    """Return whether no eigenvalue of a symmetric matrix is negative beyond round-off."""
    full = matrix.toarray()
    values = np.linalg.eigvalsh(0.5 * (full + full.T))
    return bool(values[0] >= -1e-9 * max(abs(values[-1]), np.finfo(float).tiny))


def _poles(first: StateMatrices | None, second: LinearSystem | None) -> np.ndarray:
    """Return the poles with Im > 0 of a reduced system without prescribed motions, slowest first."""
    if first is not None:
        s = first.poles
    else:
        assert second is not None
        inner = second.second_order
        free = replace(inner, derivative=np.full(len(inner.derivative), -1))
        s = np.linalg.eigvals(free.first_order().A)
    s = s[s.imag > 1e-9 * np.abs(s)]
    return np.asarray(s[np.argsort(np.abs(s), kind="stable")])


def _flat(parts: dict[str, Any]) -> dict[str, Any]:
    """Return sparse matrices as arrays, and texts as such."""
    found: dict[str, Any] = {}
    for name, value in parts.items():
        if sparse.issparse(value):
            for word in ("data", "indices", "indptr", "shape"):
                found[f"{name}.{word}"] = np.asarray(getattr(value, word))
        else:
            found[name] = np.asarray(value)
    return found

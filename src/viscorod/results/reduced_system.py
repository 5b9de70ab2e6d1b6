"""A linear system with fewer coordinates: its errors against the whole one, its poles, its energy balance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from viscorod.alike import Alike
from viscorod.argument_names import known_arguments
from viscorod.results.state_matrices import StateMatrices
from viscorod.results.text_table import page, table
from viscorod.shown import Shown, counted, span
from viscorod.typing import Floats

if TYPE_CHECKING:
    from scipy.signal import StateSpace

    from viscorod.results.linear_system import LinearSystem

__all__ = ["ReducedSystem", "judged"]

POINTS = 200
"""Frequencies at which the error of a reduced system is computed, beside those of its poles."""
RIGID = 1e-3
"""Frequency of a root over the lowest of the band, below which it is the round-off of a rigid motion."""
TOLD = 8
"""Poles that are compared at most."""


@known_arguments
@dataclass(frozen=True, repr=False, eq=False)
class ReducedSystem(Shown, Alike):
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
        poles: ``s`` [1/s] with Im > 0, slowest first, without those of rigid motions.
        whole_poles: of the whole system next to the first of these, those within the band.
        has_potential: whether all forces at rest have one: no circulatory matrix.
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
    has_potential: bool = True

    def _facts(self) -> Iterator[str]:
        yield self.method.replace("_", " ")
        yield counted(len(self.coordinates), "coordinate")
        yield f"error {self.error:.2g} of the largest response from {span(*self.band, 'Hz')}"

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
        forms = [self.system.mass, *(matrix for _, matrix in self.system.branches)]
        # what the damping is in is round-off of the gyroscopic matrix too
        rates = float(abs(self.system.second_order.terms[1]).max())
        return all(map(_not_negative, forms)) and _not_negative(self.system.damping, rates)

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
        if not self.has_potential:
            lines.append(
                "Loads that follow, or what rests beside a rotation, have no potential here: they may put energy in"
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
        text = "\n".join([*lines, *([table("Poles", header, rows)] if rows else [])])
        return page([text])


def judged(
    system: LinearSystem,
    method: str,
    first: StateMatrices | None,
    second: LinearSystem | None,
    coordinates: tuple[str, ...],
    band: tuple[float, float],
    bound: float | None,
) -> ReducedSystem:
    """Return a reduced ``system``, of first or of second order, with its errors against it."""
    poles = _poles(first, second)
    if system.rigid:  # their roots are round-off
        poles = poles[np.abs(poles) > RIGID * 2.0 * np.pi * band[0]]
    resolved = min(int(np.count_nonzero(np.abs(poles) <= 2.0 * np.pi * band[1])), TOLD)
    exact = np.array([system.second_order.pole_near(complex(s)) for s in poles[:resolved]])
    inside = np.abs(np.concatenate([poles.imag, exact.imag])) / (2.0 * np.pi)
    near = inside[(inside > band[0]) & (inside < band[1])]
    hertz = np.unique(np.concatenate([np.geomspace(*band, POINTS), near]))
    whole = system.response(hertz)
    less = whole
    if first is not None:
        less = first.response(hertz)
    elif second is not None:
        less = second.response(hertz)
    difference = np.abs(less - whole)
    largest = system.second_order.sizes(whole, np.array([*near[:TOLD], *band]))
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
        not system.circulatory.nnz,
    )


def _not_negative(matrix: sparse.csr_array, size: float = 0.0) -> bool:
    """Return whether no eigenvalue of a symmetric matrix is negative beyond round-off, of entries of a ``size``."""
    full = matrix.toarray()
    values = np.linalg.eigvalsh(0.5 * (full + full.T))
    return bool(values[0] >= -1e-9 * max(abs(values[-1]), size, np.finfo(float).tiny))


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

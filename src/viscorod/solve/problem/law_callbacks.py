"""Python functions of springs and dampers: called from compiled code, and their energies."""

from __future__ import annotations

from scipy.integrate import quad

from viscorod.mechanics.compilation.callback import Callback
from viscorod.model.connections.spring_laws import Law, law_value
from viscorod.typing import Floats

STEP = 1e-6
"""Part of a value (or of 1) over which slopes are taken."""

NUMBERS = 3
"""Exchanged in a call: number of the law, value and rate; then force and dissipated power."""


class LawCallbacks:
    """Forces of coordinates whose springs or dampers are Python functions.

    Args:
        laws: stiffness (of the value less its rest), damping (of the rate) and rest of every law.
    """

    def __init__(self, laws: tuple[tuple[Law, Law, float], ...]) -> None:
        self.laws = laws
        self.callback = Callback(self._answer)
        self._energy = [0.0] * len(laws)
        self._stretch = [0.0] * len(laws)

    def _answer(self, numbers: Floats) -> None:
        """Replace number and value of the law by force and dissipated power [W]."""
        law, value, rate = int(numbers[0]), float(numbers[1]), float(numbers[2])
        stiffness, damping, rest = self.laws[law]
        resisting = law_value(damping, rate)
        numbers[0], numbers[1] = law_value(stiffness, value - rest) + resisting, resisting * rate

    def slopes(self, law: int, value: float, rate: float) -> tuple[float, float]:
        """Return the derivatives of a law's force by value and rate."""
        stiffness, damping, rest = self.laws[law]
        return _slope(stiffness, value - rest), _slope(damping, rate)

    def power(self, law: int, rate: float) -> float:
        """Return the power [W] that the damper of a law takes at a rate."""
        return law_value(self.laws[law][1], rate) * rate

    def energy(self, law: int, value: float) -> float:
        """Return the energy [J] stored by a law at a value: its integral, carried on from the last call."""
        stiffness, _, rest = self.laws[law]
        stretch = value - rest
        if callable(stiffness):
            # in full: no warnings where the interval is so small that rounding decides
            part = quad(
                lambda x: law_value(stiffness, x), self._stretch[law], stretch, limit=200, full_output=1
            )[0]
            self._energy[law] += part
            self._stretch[law] = stretch
            return self._energy[law]
        return 0.5 * stiffness * stretch**2


def _slope(law: Law, at: float) -> float:
    if not callable(law):
        return law
    h = STEP * max(abs(at), 1e-3)
    return (law_value(law, at + h) - law_value(law, at - h)) / (2.0 * h)

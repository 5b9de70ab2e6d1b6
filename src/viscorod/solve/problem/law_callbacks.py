"""Python functions of springs, dampers and loads: called from compiled code; energies and derivatives of theirs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import scipy  # its parts are imported when they are asked for

from viscorod.mechanics.compilation.callback import Callback
from viscorod.mechanics.nodes.motion_loads import ANSWERED, LAWS, PYTHON, ROW
from viscorod.model.actions.load_effects import CompiledLaw, MotionLaw, PythonLaw
from viscorod.model.connections.spring_laws import Law, law_value
from viscorod.typing import Floats

STEP = 1e-6
"""Part of a value (or of 1) over which slopes are taken."""
FAR = 1e-3
"""Part of the distance from the origin that counts as a length: positions are rounded by it."""

NUMBERS = 3
"""Exchanged in a call: number of the law, value and rate; then force and dissipated power."""


@cache
def _no_callback() -> Callback:
    """Return one that is never called."""
    return Callback(_nothing)


def _nothing(_numbers: Floats) -> None:
    raise AssertionError("there is no law")


class LawCallbacks:
    """Forces of coordinates whose springs or dampers are Python functions.

    Args:
        laws: stiffness (of the value less its rest), damping (of the rate) and rest of every law.
    """

    def __init__(self, laws: tuple[tuple[Law, Law, float], ...]) -> None:
        self.laws = laws
        self.callback = Callback(self._answer) if laws else _no_callback()
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
            part = scipy.integrate.quad(
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


class MotionLaws:
    """Laws of loads that see motion, one row of numbers each; Python functions answer through one callback.

    Args:
        laws: of the loads; length: of the model [m], of which differences by positions are taken over a part.

    Attributes:
        rows: ``(laws, ROW)``, see ``motion_loads.MotionLoads``.
    """

    def __init__(self, laws: Sequence[MotionLaw], length: float) -> None:
        self.laws, self.length = list(laws), length
        python = any(not isinstance(law, CompiledLaw) for law in laws)
        self.callback = Callback(self._answer) if python else _no_callback()
        self.rows = np.zeros((len(self.laws), ROW))
        for k, (law, row) in enumerate(zip(self.laws, self.rows, strict=True)):
            if isinstance(law, CompiledLaw):
                row[0], row[1 : 1 + len(law.numbers)] = LAWS[law.word], law.numbers
            else:
                row[:3] = PYTHON, k, self.callback.address

    def _answer(self, numbers: Floats) -> None:
        """Replace number, position, rotation and twist by wrench, its two derivatives and the dissipated power [W]."""
        law = self.laws[int(numbers[0])]
        assert isinstance(law, PythonLaw)
        r, R, twist = numbers[1:4].copy(), numbers[4:13].reshape(3, 3).copy(), numbers[13:19].copy()
        wanted = numbers[19] != 0.0
        numbers[:] = 0.0
        numbers[ANSWERED - 1] = law.dissipated(r, R, twist)
        numbers[:6] = law.wrench(r, R, twist)
        if not wanted:
            return
        if law.by_pose is not None:
            numbers[6:42] = law.by_pose(r, R, twist).ravel()
            return
        for column, unit in enumerate(np.eye(6)):
            for first, sides in (
                (6, self._moved(law, r, R, twist, unit)),
                (42, self._faster(law, r, R, twist, unit)),
            ):
                numbers[first + column : first + 36 : 6] = sides

    def _moved(self, law: PythonLaw, r: Floats, R: Floats, twist: Floats, unit: Floats) -> Floats:
        """Return the derivative of a wrench by an increment of the pose, by central differences."""
        h = STEP * max(self.length, FAR * float(np.abs(r).max())) if unit[:3].any() else STEP
        sides = []
        for way in (h, -h):
            turned = R @ scipy.spatial.transform.Rotation.from_rotvec(way * unit[3:]).as_matrix()
            sides.append(np.asarray(law.wrench(r + R @ (way * unit[:3]), turned, twist)))
        return (sides[0] - sides[1]) / (2.0 * h)

    @staticmethod
    def _faster(law: PythonLaw, r: Floats, R: Floats, twist: Floats, unit: Floats) -> Floats:
        """Return the derivative of a wrench by a component of the twist, by central differences."""
        h = STEP * max(1e-3, float(np.abs(twist).max()))
        ahead, behind = law.wrench(r, R, twist + h * unit), law.wrench(r, R, twist - h * unit)
        return (np.asarray(ahead) - np.asarray(behind)) / (2.0 * h)

"""The amplitude of a motion so far, and the tolerance that is a part of it: the numbers of ``PartOfMotion``.

The compiled loop of steps and Python use the same functions, bit for bit.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.typing import Floats

__all__ = ["COUNT", "allowed_after", "allowed_now", "is_usual", "still_grows", "take_extent"]

AMPLITUDE, DISPLACEMENT, VELOCITY, EXPECTED, UNTIL, SLOWEST, LENGTH, COUNT = range(8)
"""Places among the numbers: amplitude, largest displacement and velocity so far (over the length of the model, or in
rad); expected amplitude, and until when [s]; slowest natural frequency [rad/s]; length of the model [m]."""

PART_OF_MOTION = 3e-4
"""Tolerance as a part of the amplitude of the motion."""

FINEST, USUAL = 1e-11, 1e-4
"""Least and largest tolerance that follows from the motion: rounding, and what is fine for motions of any size."""

LEAST_PART = 0.01
"""Least amplitude that is taken of a vibration, as a part of the whole displacement, which may be a slow one."""


@exact_part
def part_of(amplitude: float) -> float:
    """Return the tolerance of a motion with an amplitude."""
    return min(max(PART_OF_MOTION * amplitude, FINEST), USUAL)


@exact_part
def amplitude_of(numbers: Floats, displacement: float, velocity: float) -> float:
    """Return the amplitude of a motion with these largest displacements and velocities."""
    whole, slowest = 0.5 * displacement, float(numbers[SLOWEST])
    if slowest == 0.0:
        return whole
    return min(whole, max(velocity / slowest, LEAST_PART * whole))


@exact_part
def expected_at(numbers: Floats, t: float) -> float:
    """Return the expected amplitude as far as it counts at ``t`` [s]."""
    return float(numbers[EXPECTED] if t <= numbers[UNTIL] else 0.0)


@exact_part
def usual_at(numbers: Floats, t: float) -> bool:
    """Return whether the tolerance of a step to ``t`` [s] is the usual one, however far it goes."""
    return bool(PART_OF_MOTION * max(numbers[AMPLITUDE], expected_at(numbers, t)) >= USUAL)


@exact_part
def tolerance_after(numbers: Floats, t: float, moved: float, speed: float) -> float:
    """Return what is allowed of a step to ``t`` [s], to where nodes ``moved`` so far and are so fast."""
    displacement, velocity = max(numbers[DISPLACEMENT], moved), max(numbers[VELOCITY], speed)
    return part_of(max(expected_at(numbers, t), amplitude_of(numbers, displacement, velocity)))


@exact_part
def grows(numbers: Floats) -> bool:
    """Return whether the amplitude still matters."""
    return bool(PART_OF_MOTION * numbers[AMPLITUDE] < USUAL)


@exact_part
def extend(numbers: Floats, t: float, moved: float, speed: float) -> None:
    """Take a state at ``t`` [s] in which nodes ``moved`` so far and are so fast as one of the motion."""
    if t > numbers[UNTIL]:
        numbers[EXPECTED] = 0.0
    if grows(numbers):
        numbers[DISPLACEMENT] = max(numbers[DISPLACEMENT], moved)
        numbers[VELOCITY] = max(numbers[VELOCITY], speed)
        numbers[AMPLITUDE] = amplitude_of(numbers, numbers[DISPLACEMENT], numbers[VELOCITY])


@exact_part
def tolerance_now(numbers: Floats) -> float:
    """Return what is allowed before a step is tried."""
    return part_of(max(numbers[AMPLITUDE], numbers[EXPECTED]))


@loop
def allowed_now(numbers: Floats) -> float:
    """Do what :func:`tolerance_now` does."""
    return tolerance_now(numbers)


@loop
def is_usual(numbers: Floats, t: float) -> bool:
    """Do what :func:`usual_at` does."""
    return usual_at(numbers, t)


@loop
def allowed_after(numbers: Floats, t: float, moved: float, speed: float) -> float:
    """Do what :func:`tolerance_after` does."""
    return tolerance_after(numbers, t, moved, speed)


@loop
def still_grows(numbers: Floats) -> bool:
    """Do what :func:`grows` does."""
    return grows(numbers)


@loop
def take_extent(numbers: Floats, t: float, moved: float, speed: float) -> None:
    """Do what :func:`extend` does."""
    extend(numbers, t, moved, speed)

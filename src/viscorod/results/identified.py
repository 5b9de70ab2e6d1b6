"""What an identification finds: numbers with intervals, laws that were compared, decays that they foretell."""

from __future__ import annotations

from dataclasses import astuple, dataclass, field
from typing import ClassVar

import numpy as np

from viscorod.argument_names import known_arguments

__all__ = ["Foretold", "Law", "Number"]


@known_arguments
@dataclass(frozen=True)
class Number:
    """A number that was found.

    Attributes:
        name: of it; value: in SI.
        low, high: ends of its interval; infinite (or 0 of positive numbers) where the data cannot tell.
        standard_error: SI; how: by which the interval was found, and "model misses motion" where it does not hold for
            what the model leaves out.
        unit: SI unit, "1" of a plain number, empty where it is not known.
    """

    name: str
    value: float
    low: float
    high: float
    standard_error: float = 0.0
    how: str = ""
    unit: str = ""

    @property
    def told(self) -> bool:
        """Whether both ends of the interval are finite."""
        return bool(np.isfinite(self.low) and np.isfinite(self.high))


@known_arguments
@dataclass(frozen=True)
class Law:
    """A law that was compared on the same data.

    Attributes:
        name: of it; unknowns: numbers that were fitted; values: what they are, in words.
        square: sum of squares in units of the noise of the best; aicc, bic: criteria less the least.
        prediction: root mean square error of records left out, over the noise that was told of them or else their
            standard deviation (of modes each value); 0 where none was.
    """

    name: str
    unknowns: int
    square: float
    aicc: float
    bic: float
    prediction: float
    values: str


@known_arguments
@dataclass(frozen=True)
class Foretold:
    """A free decay that a law foretells, which was fitted to other records, beside what the record shows.

    Attributes:
        law, record: their names.
        frequency, measured_frequency: natural frequencies of the strongest mode, Hz.
        damping_ratio, measured_ratio: of that mode.
        frequency_width, damping_ratio_width, measured_frequency_width, measured_ratio_width: halves of the 95 %
            intervals.
        rests_on: what was believed of the measurement where most of the interval of the frequency comes from it, in
            words; not in files.
    """

    law: str
    record: str
    frequency: float
    frequency_width: float
    damping_ratio: float
    damping_ratio_width: float
    measured_frequency: float
    measured_frequency_width: float
    measured_ratio: float
    measured_ratio_width: float
    rests_on: str = field(default="", kw_only=True)

    COLUMNS: ClassVar[tuple[str, ...]] = (
        "foretold_frequency",
        "foretold_frequency_width",
        "foretold_ratio",
        "foretold_ratio_width",
        "left_out_frequency",
        "left_out_frequency_width",
        "left_out_ratio",
        "left_out_ratio_width",
    )
    """Names of its numbers in the data set, in order."""

    @property
    def numbers(self) -> tuple[float, ...]:
        """Its numbers in the order of the columns."""
        return tuple(value for value in astuple(self) if not isinstance(value, str))

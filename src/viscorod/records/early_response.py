"""A measured response as it would be if only the first part of what follows a blow had been recorded.

The response to a blow, weighed by exp(-t/T), has the frequency response
``H_T(omega) = 1/(2 pi) int H(omega') / (1/T + i (omega - omega')) d omega'``: peaks are as wide as 1/T makes them. Of
lines of one band the integral is a sum over these lines, the same for what was measured and for what a model says.
A peak that is narrower than the lines would count by how near to a line it happens to be, so both are compressed first:
H/(1 + |H|/c) is as large as c where a peak stands, over a band that does not depend on its damping.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from viscorod.records.response_record import ResponseRecord
from viscorod.typing import Floats

__all__ = ["EarlyResponse"]

PER_WIDTH = 4.0
"""Lines of the widened response within 1/T."""


class EarlyResponse(ResponseRecord):
    """A response of which only what comes before about T seconds after a blow is compared.

    Args:
        record: the whole response; span: T, s.
    """

    def __init__(self, record: ResponseRecord, span: float) -> None:
        super().__init__(
            record.frequencies,
            record.values,
            output=record.output,
            source=record.source,
            window=record.window,
            window_time=record.window_time,
            excitation=record.excitation,
            unknown=list(record.nuisances.values()),
            name=record.name,
        )
        omega = 2.0 * np.pi * record.frequencies
        step = max(float(np.median(np.diff(omega))), 1.0 / (PER_WIDTH * span))
        rows = np.unique(
            np.searchsorted(omega, np.arange(omega[0], omega[-1] + 0.5 * step, step)).clip(0, len(omega) - 1)
        )
        around = np.gradient(omega) / (2.0 * np.pi)
        self._most = float(np.exp(np.mean(np.log(np.maximum(np.abs(record.values), np.finfo(float).tiny)))))
        self._widening = around / (1.0 / span + 1j * (omega[rows, None] - omega))
        self.observed = self._widened(self.observed)

    def _widened(self, parts: Floats) -> Floats:
        count = len(self.frequencies)
        whole = parts[:count] + 1j * parts[count:]
        wide = self._widening @ (whole / (1.0 + np.abs(whole) / self._most))
        return np.concatenate([wide.real, wide.imag])

    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what a `FrequencyResponse` says, widened alike; see `AnyRecord`."""
        return self._widened(super().predicted(result, nuisances))

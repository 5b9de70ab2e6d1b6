"""Imported by the process that the workers of a sweep are copies of: what a motion needs is in memory then.

Where machine code is not on disk yet, nothing is loaded: the worker that needs it first compiles it.
"""

from __future__ import annotations

import gc
import warnings
from contextlib import suppress

__all__: list[str] = []


def _load() -> None:
    from viscorod.analyses.warmup import SPAN, soft_model
    from viscorod.mechanics.compilation.compiled import PURE_PYTHON, on_disk
    from viscorod.results.sweep_figures import figures_of
    from viscorod.solve.transient.integrators.collocation_step import try_step

    if PURE_PYTHON or not on_disk(try_step):
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        figures_of(soft_model().simulate(SPAN, initial="equilibrium"))


with suppress(Exception):  # whatever is wrong here is told by the workers
    _load()
gc.collect()
gc.freeze()  # copies share what is never looked at

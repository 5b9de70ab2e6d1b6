"""Natural frequencies and damping ratios that were measured."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from viscorod.errors import Fault, InputError, warn
from viscorod.records.any_record import AnyRecord, deviations, finite
from viscorod.records.arguments import described
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats

__all__ = ["ModesRecord", "spread_of_ratios"]


RATIOS: dict[str, Callable[[Floats], Floats]] = {
    "ratio": lambda given: given,
    "percent": lambda given: given / 100.0,
    "quality_factor": lambda given: 0.5 / given,
    "loss_factor": lambda given: 0.5 * given,
    "log_decrement": lambda given: given / np.hypot(2.0 * np.pi, given),
}
"""Damping ratios from other measures of damping; those of a resonance hold where damping is small."""
UNUSUAL = 0.2
"""Median of damping ratios above which per cent may have been meant; high modes of rubber may well be beyond it."""
NORMAL = 1.959963984540054
"""Standard deviations of half of a 95 % interval."""


class ModesRecord(AnyRecord):
    """A table of measured natural frequencies, with damping ratios or without.

    Args:
        frequencies: Hz (n,).
        damping_ratios: as many, or None.
        damping_as: what these are: "ratio" (of critical), "percent" (of critical), "quality_factor" (of a resonance,
            1/(2 ratio)), "loss_factor" (2 ratio) or "log_decrement" (of amplitudes one cycle apart). A median above
            0.2 is a warning: per cent may be meant.
        modes: which modes of the model they are, numbers from 1 or names such as "bend_1 2"; by default the first ones
            in their order, rigid motions left out.
        frequency_noise, ratio_noise: standard deviations, Hz and 1, one number or (n,); None where they are not known.
        unknown: "clock" (factor on frequencies); others with the key of a number of the case.
        name: of the record.

    Attributes:
        observed: frequencies, then damping ratios.

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "modes"
    analysis: ClassVar[str] = "modes"

    @described
    def __init__(
        self,
        frequencies: Any,
        damping_ratios: Any = None,
        *,
        damping_as: str = "ratio",
        modes: Sequence[int | str] | None = None,
        frequency_noise: Any = None,
        ratio_noise: Any = None,
        unknown: Sequence[str | Unknown] = (),
        name: str = "modes",
    ) -> None:
        where = f"record {name}"
        self.frequencies = finite(f"{where}: frequencies", frequencies)
        if not (self.frequencies > 0.0).all():
            raise InputError(
                Fault(f"{where}: frequencies", "", "frequencies are positive", "leave rigid motions out")
            )
        count = len(self.frequencies)
        self.damping_ratios = None
        if damping_ratios is not None:
            self.damping_ratios = _ratios(where, damping_ratios, damping_as)
            if len(self.damping_ratios) != count or not (np.abs(self.damping_ratios) < 1.0).all():
                raise InputError(
                    Fault(
                        f"{where}: damping_ratios",
                        "",
                        f"{count} numbers below 1 are needed",
                        "0.01 is one per cent, or give damping_as = 'percent'",
                    )
                )
            if damping_as == "ratio" and (usual := float(np.median(self.damping_ratios))) > UNUSUAL:
                warn(
                    f"{where}: the usual damping ratio of {usual:.3g} is read as {100.0 * usual:.3g} % of critical, "
                    "which few structures have; if it is per cent, give damping_as = 'percent'"
                )
        if modes is not None and (isinstance(modes, str | bytes) or not isinstance(modes, Sequence)):
            raise InputError(
                Fault(f"{where}: modes", type(modes).__name__, "no list of modes", "give [1, 2, 3]")
            )
        self.modes = tuple(range(1, count + 1)) if modes is None else tuple(modes)
        if len(self.modes) != count or len(set(map(str, self.modes))) != count:
            raise InputError(
                Fault(f"{where}: modes", str(self.modes), f"{count} different modes are needed", "")
            )
        for one in self.modes:
            if isinstance(one, bool) or not (isinstance(one, str) or (isinstance(one, int) and one >= 1)):
                raise InputError(
                    Fault(
                        f"{where}: modes",
                        repr(one),
                        "no mode",
                        "give its number from 1, or its name 'bend_1 2'",
                    )
                )
        self.observed = self.frequencies
        noise = [deviations(f"{where}: frequency_noise", frequency_noise, (count,))]
        if self.damping_ratios is not None:
            self.observed = np.concatenate([self.frequencies, self.damping_ratios])
            noise.append(deviations(f"{where}: ratio_noise", ratio_noise, (count,)))
        known = [part for part in noise if part is not None]
        if known and len(known) < len(noise):
            raise InputError(
                Fault(
                    where, "", "the noise of frequencies and of ratios go together", "give both, or neither"
                )
            )
        self.noise = np.concatenate(known) if known else None
        self._named(name, unknown, {"clock": (1.0, 0.5, 2.0)})

    @property
    def axes(self) -> tuple[tuple[str, str], ...]:
        """See `AnyRecord`."""
        ratios = () if self.damping_ratios is None else (("damping ratio", "1"),)
        return (("natural frequency", "Hz"), *ratios)

    @classmethod
    @described
    def of(cls, found: Any, **more: Any) -> ModesRecord:
        """Return the modes of a `Decay` or a `ModalFit` as a record, with the noise that their intervals mean.

        Args:
            found: the result.
            more: all else that a record has: modes, unknown, name.

        Raises:
            InputError: it is no such result.
        """
        if getattr(found, "kind", "") not in ("decay", "modal_fit"):
            raise InputError(
                Fault("found", type(found).__name__, "it has no measured modes", "give a Decay or ModalFit")
            )
        widths = [found.data[f"{name}_width"].values / NORMAL for name in ("frequency", "damping_ratio")]
        return cls(
            found.frequencies,
            2.0 * np.asarray(found.damping_ratios),  # so that no per cent are suspected
            damping_as="loss_factor",
            frequency_noise=widths[0],
            ratio_noise=widths[1],
            **more,
        )

    def _over(self) -> str:
        return f" from {self.frequencies.min():.6g} to {self.frequencies.max():.6g} Hz"

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return frequencies, and damping ratios if the record has them, of a result of `modes`; see `AnyRecord`."""
        self._needs(result, "modes")
        at = self.places_in(result)
        values = self.values_of(nuisances)
        hertz = np.asarray(result.frequencies)[at] * self.nuisance("clock", values, 1.0)
        if self.damping_ratios is None:
            return np.asarray(hertz)
        return np.concatenate([hertz, np.asarray(result.damping_ratios)[at]])

    def places_in(self, result: Any) -> list[int]:
        """Return the places of the record's modes among those of a result.

        Raises:
            InputError: the result has too few modes, or none of a name.
        """
        count, found = len(result.frequencies), []
        for one in self.modes:
            if isinstance(one, str):
                names = list(result.names)  # which takes their shapes
                if one not in names:
                    raise InputError(
                        f"record {self.name}: no mode is called {one!r}; there are {', '.join(names)}"
                    )
                found.append(names.index(one))
            else:
                found.append(int(result.rigid) + one - 1)
        if max(found) >= count:
            raise InputError(
                f"record {self.name}: it has mode {max(found) + 1}, and the result {count} modes; ask for more"
            )
        return found


def _ratios(where: str, given: Any, measure: str) -> Floats:
    """Return damping ratios from a measure of damping (n,)."""
    if measure not in RATIOS:
        raise InputError(
            Fault(
                f"{where}: damping_as",
                repr(measure),
                "no measure of damping",
                f"use one of {', '.join(RATIOS)}",
            )
        )
    values = finite(f"{where}: damping_ratios", given)
    if measure == "quality_factor" and not (values > 0.0).all():
        raise InputError(
            Fault(f"{where}: damping_ratios", "", "quality factors are positive", "leave undamped modes out")
        )
    return RATIOS[measure](values)


def spread_of_ratios(given: Floats, deviations_given: Floats, measure: str) -> Floats:
    """Return the standard deviations of damping ratios from those of a measure of damping (n,)."""
    if measure not in RATIOS:
        return deviations_given  # refused by the record
    return 0.5 * np.abs(RATIOS[measure](given + deviations_given) - RATIOS[measure](given - deviations_given))

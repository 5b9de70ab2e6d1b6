"""Settings of periodic motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Self

from pydantic import model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import POSITIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import (
    Flag,
    OptionalPositive,
    bounded,
    each,
    numbers,
    one_of,
    pair,
    positive,
    sequence,
    whole_number,
)
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.settings.signals import LoadInput, OptionalInputsField, OutputsField

__all__ = ["PeriodicSettings"]


@accepts(listed(quantity(bounds=POSITIVE), 2, 2), "2 different numbers > 0")
def _range(value: Any) -> tuple[float, float]:
    start, end = pair(value)
    start, end = positive(start), positive(end)
    if start == end:
        raise RefusedError("nothing changes between equal numbers", "give [start, end]", found=show(end))
    return start, end


@accepts(listed(quantity(bounds=POSITIVE), 1), "list of numbers > 0")
def _amplitudes(value: Any) -> tuple[float, ...]:
    return tuple(each([value] if isinstance(value, int | float) else sequence(value), positive))


@accepts(listed(quantity(), 1), "list of numbers")
def _phases(value: Any) -> tuple[float, ...]:
    return numbers([value] if isinstance(value, int | float) else value)


Range = Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(_range)]


class PeriodicSettings(Meshed):
    """Which periodic motions are wanted.

    Forced ones are followed over `frequencies`, or at one `frequency` over `levels` of all amplitudes; free vibrations
    of a `mode` over their amplitude.
    """

    needs: ClassVar[str] = "inputs, amplitudes, outputs and frequencies"

    outputs: OutputsField = Key(
        "what is read: as of frequency responses. Displacements and rotations are those from the reference shape"
    )
    inputs: OptionalInputsField = Key(
        "what drives the model, harmonic in time: as of frequency responses, see there. Loads of the model itself stay "
        "what they are at t = 0",
        default=None,
    )
    amplitudes: Annotated[GivenAs[tuple[float, ...] | None, Amounts | None], optional(_amplitudes)] = Key(
        "of the inputs, plain numbers > 0, each in its SI unit (N, N m, m, rad, m/s, m/s^2, or the factor of a load)",
        default=None,
    )
    frequencies: Range = Key(
        "where the curve over frequency starts and where it ends, 2 numbers > 0 in either order",
        "Hz",
        default=None,
    )
    frequency: OptionalPositive = Key("of a curve over `levels`", "Hz", default=None)
    levels: Range = Key(
        "factors of all amplitudes, at one `frequency`, where the curve starts and where it ends: 2 numbers > 0",
        default=None,
    )
    phases: Annotated[Sequence[float] | None, optional(_phases)] = Key(
        "of the inputs, a cos(2 pi f t + phase); 0 unless given", "rad", default=None
    )
    mode: Annotated[int | None, optional(whole_number(1, 100))] = Key(
        "in place of inputs: number of the vibration, without damping, the slowest first, whose frequency and damping "
        "ratio are wanted over the amplitude",
        default=None,
    )
    largest: OptionalPositive = Key(
        "amplitude of the first output, in its SI unit, up to which free vibrations are followed, from a hundredth on",
        default=None,
    )
    about: Annotated[str, one_of("equilibrium", "released")] = Key(
        'the loads that stay are those at t = 0- (just before t = 0), "equilibrium", or just after t = 0, "released"',
        default="equilibrium",
    )
    harmonics: Annotated[int, whole_number(1, 60)] = Key(
        "of the frequency that motions consist of, beside a constant", default=7
    )
    step: Annotated[float, bounded("from 0.005 to 1", minimum=0.005, maximum=1.0)] = Key(
        "largest change from one motion to the next, as a part of the motion", default=0.15
    )
    points: Annotated[int, whole_number(2, 20_000)] = Key("motions at most", default=1000)
    stability: Flag = Key(
        "whether the Floquet multipliers of every forced motion are computed, which tell whether it is stable",
        default=True,
    )

    @property
    def course(self) -> Course:
        """See :class:`Meshed`; at folds a curve over frequency or level turns back for a while."""
        if self.largest is not None:
            return Course("amplitude", "", 0.01 * self.largest, self.largest)
        if self.levels is not None:
            return Course("level", "", *self.levels)
        assert self.frequencies is not None
        return Course("f", " Hz", *self.frequencies)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.inputs is None) == (self.mode is None):
            raise RefusedError(
                "motions are forced by inputs, or are free vibrations of a mode",
                "give inputs with amplitudes, or mode and largest",
                found="none" if self.mode is None else "both",
                at=("inputs",),
            )
        return self._forced() if self.mode is None else self._free()

    def _free(self) -> Self:
        if self.largest is None:
            raise RefusedError(
                "free vibrations need the amplitude up to which they are wanted",
                "give largest, of the first output in its SI unit",
                at=("largest",),
            )
        for name in ("amplitudes", "phases", "frequencies", "frequency", "levels"):
            if getattr(self, name) is not None:
                raise RefusedError(
                    "free vibrations have no inputs", "leave it out, or leave mode out", at=(name,)
                )
        return self

    def _forced(self) -> Self:
        count = len(self.inputs or ())
        if self.largest is not None:
            raise RefusedError("this bounds free vibrations of a mode", "leave it out", at=("largest",))
        for name, given in (("amplitudes", self.amplitudes or ()), ("phases", self.phases)):
            if given is not None and len(given) != count:
                raise RefusedError(
                    f"{count} inputs have {count} {name}",
                    "give one for each",
                    found=f"{len(given)}",
                    at=(name,),
                )
        if (self.frequencies is None) == (self.levels is None):
            raise RefusedError(
                "a curve goes over frequencies or over levels",
                "give frequencies = [start, end] in Hz, or frequency and levels = [start, end]",
                found="none" if self.levels is None else "both",
                at=("frequencies",),
            )
        if (self.frequency is None) != (self.levels is None):
            raise RefusedError(
                "levels are followed at one frequency",
                "give frequency and levels together, or frequencies alone",
                at=("frequency",),
            )
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain data in the words of the case file."""
        plain = super().to_dict()
        if self.inputs is not None:
            plain["inputs"] = [
                one.load.to_dict() if isinstance(one, LoadInput) and one.given else one.label
                for one in self.inputs
            ]
        plain["outputs"] = [one.label for one in self.outputs]
        return plain

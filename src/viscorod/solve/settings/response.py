"""Settings of linear systems and of frequency responses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Self

from pydantic import model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import NOT_NEGATIVE, POSITIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import frequency_band, number, numbers, one_of
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.settings.modes import AboutField
from viscorod.solve.settings.signals import InputsField, LoadInput, OutputsField

__all__ = ["LinearSettings", "ResponseSettings"]

MOST = 200_000
"""Frequencies at most."""


@accepts(listed(quantity(bounds=NOT_NEGATIVE), 1), "list of numbers >= 0, increasing")
def _frequencies(value: Any) -> tuple[float, ...]:
    found = numbers(value)
    if len(found) > MOST:
        raise RefusedError("too many frequencies", f"give {MOST} at most", found=f"{len(found)}")
    for index, (low, high) in enumerate(zip((-1.0, *found), found, strict=False)):
        if high < 0.0 or high <= low:
            raise RefusedError(
                "frequencies are >= 0 and increase", "sort them, each once", found=show(high), at=(index,)
            )
    return found


@accepts(quantity(bounds=POSITIVE), "number from 1e-5 to 0.2")
def _tolerance(value: Any) -> float:
    found = number(value)
    if not 1e-5 <= found <= 0.2:
        raise RefusedError("out of reach", "give 1e-5 to 0.2")
    return found


Frequencies = Annotated[GivenAs[Sequence[float] | None, Amounts | None], optional(_frequencies)]
Band = Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(frequency_band)]


class _Ported(Definition):
    """What goes into a linear system, what comes out, and about what it is."""

    inputs: InputsField = Key(
        "what drives the model: places with fx, fy, fz (force, N) or mx, my, mz (moment, N m); `base` (all "
        "supports), a supported place or a joint with ux, uy, uz (motion, m), rx, ry, rz (rad), or its velocity (vx, "
        "wx) or acceleration (ax, dwx); or loads, of whose factor the response is"
    )
    outputs: OutputsField = Key(
        "what is read: places with ux, uy, uz, rx, ry, rz (displacement, rotation), vx, wx (velocities), ax, dwx "
        "(accelerations), global axes; with `strain` or `section_force` and a strain's name; supported places with "
        "`reaction` and fx to mz"
    )
    about: AboutField = Key(
        '"equilibrium" under the loads at t = 0- (just before t = 0), the equilibrium once "released", under those '
        'just after t = 0, or the "reference" shape (as if free of load); a state of an earlier result: about the '
        "equilibrium under the loads at t = 0- that is found from there, of a motion that moves there with "
        "`at_rest = true` only; or of a steady rotation about the one with its angular velocity, in axes that turn "
        "with it",
        default="equilibrium",
    )

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain data in the words of the case file."""
        plain = super().to_dict()
        plain["inputs"] = [
            one.load.to_dict() if isinstance(one, LoadInput) and one.given else one.label
            for one in self.inputs
        ]
        plain["outputs"] = [one.label for one in self.outputs]
        return plain


class LinearSettings(_Ported):
    """Which linear system is wanted: on the mesh that the rods have, whose nodes are its coordinates."""


class ResponseSettings(_Ported, Meshed):
    """Which frequency responses are wanted.

    Exactly one of `frequencies` and `band` is given.
    """

    needs: ClassVar[str] = "inputs, outputs and a band"

    frequencies: Frequencies = Key("at which the response is computed, {}", "Hz", default=None)
    band: Band = Key(
        "lowest and highest frequency, {}, between which they are chosen so that straight lines between them follow "
        "every response to `tolerance`",
        "Hz",
        default=None,
    )
    tolerance: Annotated[float, _tolerance] = Key("of these lines, as a part of the response", default=0.01)
    moduli: Annotated[str, one_of("measured", "law")] = Key(
        '"measured": where a material has a table over frequency (complex_moduli), or one loss factor over a band '
        "(loss_factor), its complex modulus is the measured one, or E (1 + i eta) at every frequency, without a fit; "
        '"law": the fitted law, with which motions are computed too',
        default="measured",
    )

    method: Annotated[str, one_of("direct", "modal")] = Key(
        '"direct": the dynamic stiffness is solved at every frequency; "modal": in the modes up to twice the highest '
        "frequency, with static correction, which is faster; its error is computed at some frequencies",
        default="direct",
    )

    @property
    def highest(self) -> float:
        """Highest frequency, Hz."""
        return float((self.frequencies or self.band or (0.0,))[-1])

    @property
    def course(self) -> Course:
        """See :class:`Meshed`."""
        return Course("f", " Hz", 0.0, self.highest)

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.frequencies is None) == (self.band is None):
            raise RefusedError(
                "frequencies are given, or chosen within a band",
                "give frequencies = [..] or band = [low, high], Hz",
                found="none" if self.band is None else "both",
                at=("band",),
            )
        if self.band is None and "tolerance" in self.model_fields_set:
            raise RefusedError(
                "frequencies that are given are not chosen to a tolerance",
                "leave it out, or give a band",
                found=show(self.tolerance),
                at=("tolerance",),
            )
        return self

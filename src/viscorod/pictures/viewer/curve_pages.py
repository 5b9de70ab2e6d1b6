"""Pages of curves: Campbell diagrams, stability along a load, periodic motions, frequency responses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from viscorod.errors import InputError
from viscorod.pictures.viewer.followed_page import followed_page
from viscorod.pictures.viewer.page import curve_page, heading_of
from viscorod.pictures.viewer.periodic_page import periodic_page
from viscorod.pictures.viewer.response_page import response_page
from viscorod.results.followed_modes import FollowedModes
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.results.periodic import Periodic
from viscorod.wording import with_article

if TYPE_CHECKING:
    from viscorod.results.stateless_result import StatelessResult

__all__ = ["curves_of"]


def curves_of(result: StatelessResult, most: int) -> str:
    """Return the text of the page of a result, with ``most`` places along its curves at most.

    Raises:
        InputError: results of this kind have no such page.
    """
    if isinstance(result, FollowedModes):
        parts = followed_page(result, most)
    elif isinstance(result, Periodic):
        parts = periodic_page(result, most)
    elif isinstance(result, FrequencyResponse):
        parts = response_page(result, most)
    else:
        raise InputError(
            f"{with_article(result.what)} has no page in the browser; draw it with its method plot"
        )
    shown = len(parts.chosen)
    notes = [] if shown == parts.total else [f"{shown} of {parts.total} places along the curves are shown"]
    meta = {
        **parts.meta,
        "title": result.title,
        "heading": heading_of(result),
        "version": str(result.data.attrs.get("version", "")),
        "outcome": result.outcome,
        "warnings": result.warnings,
        "notes": notes,
    }
    return curve_page(result.title, meta, parts.pack)

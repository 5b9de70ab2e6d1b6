"""What the shell completes beside commands, options and files: words of which there is a choice."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import get_args

__all__ = ["case_names", "program_names", "quantities", "words"]


def words(*choices: str) -> Callable[[str], list[str]]:
    """Return what completes the beginning of a word to one of these."""

    def matching(incomplete: str) -> list[str]:
        return _beginning(incomplete, choices)

    return matching


def case_names(incomplete: str) -> list[str]:
    """Complete the name of a case that comes with viscorod."""
    from viscorod.casefile.shipped import shipped_cases

    return _beginning(incomplete, shipped_cases())


def program_names(incomplete: str) -> list[str]:
    """Complete the name of a program whose damping can be translated."""
    from viscorod.programs.inputs import PROGRAMS

    return _beginning(incomplete, PROGRAMS)


def quantities(incomplete: str) -> list[str]:
    """Complete a quantity of which a motion has histories."""
    from viscorod.results.recorded_states import Quantity

    return _beginning(incomplete, get_args(Quantity))


def _beginning(incomplete: str, choices: Iterable[str]) -> list[str]:
    return [word for word in choices if word.startswith(incomplete)]

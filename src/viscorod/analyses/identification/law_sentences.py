"""What a comparison of laws says in words: what is excluded, what is not the material's, what predicts best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from viscorod.results.text_numbers import per_cent
from viscorod.typing import Floats

__all__ = ["EXCLUDED", "law_sentences"]

EXCLUDED, ALIKE = 10.0, 4.0
"""Difference of Akaike's criterion from which on a law is called excluded, and up to which it is called as good."""
FURTHER = 10.0
"""Times the square of the step that another step of a search would go, in standard errors, by which a criterion may
fall: the sum of squares falls by the square alone where it is a parabola."""
AS_WELL = 1.1
"""Times the error of records left out, of the law that fits best, up to which another one foretells them as well."""
OUTSIDE = {"air_drag": "the air", "clamp_loss": "the clamp"}
"""What damps outside of the material, in words."""


def law_sentences(
    names: Sequence[str],
    aicc: Floats,
    errors: Floats,
    count: float,
    lost_outside: Mapping[str, float],
    undamped: Sequence[str] = (),
    *,
    misses: bool = False,
    unsettled: Mapping[str, float] | None = None,
) -> list[str]:
    """Return what the comparison says in words: what is excluded, what is not the material's, what predicts best.

    Where even the best law misses part of the motion, its misfit is no noise, and a criterion that counts it as such
    excludes no law that foretells other records as well.

    Args:
        names: of the laws, the best first; aicc: Akaike's criterion less the least.
        errors: of records left out, in proportion; zeros where none was.
        count: effective number of values.
        lost_outside: part of the lost energy that drag took, by law.
        undamped: laws whose clamp gives way, and whose damping there is not told from none.
        misses: whether the best law misses part of the motion.
        unsettled: standard errors by which another step would move the numbers of each law, 0 where its search came to
            rest.
    """
    steps = unsettled or {}
    away = {name for k, name in enumerate(names) if aicc[k] <= EXCLUDED + FURTHER * steps.get(name, 0.0) ** 2}
    out = _unsettled(steps, [name for k, name in enumerate(names) if name in away and aicc[k] > EXCLUDED])
    worse = [k for k in range(len(names)) if aicc[k] > EXCLUDED and names[k] not in away]
    open_ones = [k for k in worse if misses and errors.any() and errors[k] <= AS_WELL * errors[0]]
    excluded = [f"{names[k]} (AICc +{aicc[k]:.0f})" for k in worse if k not in open_ones]
    alike = [name for k, name in enumerate(names) if aicc[k] <= ALIKE]
    few = f" ({count:.0f} effective values)"
    if excluded:
        out.append(f"Excluded by these data{few}: {', '.join(excluded)}.")
    if open_ones:
        listed = ", ".join(f"{names[k]} (AICc +{aicc[k]:.0f})" for k in open_ones)
        out.append(
            f"Not excluded, though the fit is worse: {listed}. {names[0]} misses part of the motion, too, and "
            "foretells what was left out no better."
        )
    if len(alike) > 1:
        out.append(f"These data do not decide between {', '.join(alike[:-1])} and {alike[-1]}.")
    else:
        fits = "fit" if open_ones else "want"
        out.append(
            f"These data {fits} {alike[0]}{few if not excluded else ''}{' best' if open_ones else ''}."
        )
    out += _outside(names, aicc, alike, lost_outside, undamped)
    if errors.any():
        first = int(np.argmin(errors))
        listed = ", ".join(
            f"{name}: {errors[k] / errors[first]:.3g}" for k, name in enumerate(names) if k != first
        )
        more = f" (times its error: {listed})" if listed else ""
        out.append(f"Of what was left out {names[first]} predicts best{more}.")
    return out


def _unsettled(steps: Mapping[str, float], not_excluded: Sequence[str]) -> list[str]:
    """Return a sentence on laws whose search did not come to rest, so that they may fit better than is said."""
    open_ones = [f"{name} ({step:.2g})" for name, step in steps.items() if step]
    if not open_ones:
        return []
    return [
        f"The search did not come to rest with {', '.join(open_ones)}; in brackets the standard errors by which "
        "another step would move the numbers. The fit may be better than the table says"
        + (f", which does not exclude {' and '.join(not_excluded)}" if not_excluded else "")
        + ": give starts = 5."
    ]


def _outside(
    names: Sequence[str],
    aicc: Floats,
    alike: Sequence[str],
    lost_outside: Mapping[str, float],
    undamped: Sequence[str],
) -> list[str]:
    """Return whether part of the damping is not the material's."""
    out = []
    merit = dict(zip(names, aicc, strict=True))
    for name in alike:
        inside = [part.strip() for part in name.split("+") if part.strip() not in OUTSIDE]
        others = [part.strip() for part in name.split("+") if part.strip() in OUTSIDE]
        pure = " + ".join(inside) or "elastic"
        if not others or pure not in merit:
            continue
        what = " and ".join(OUTSIDE[part] for part in others)
        share = f", {per_cent(100.0 * lost_outside[name])} of the lost energy" if name in lost_outside else ""
        if merit[pure] - merit[name] > EXCLUDED and others == ["clamp_loss"] and name in undamped:
            text = f"The clamp gives way: {pure} alone is excluded. Whether the clamp damps these data do not tell."
        elif merit[pure] - merit[name] > EXCLUDED:
            text = f"Part of the damping is not the material's: {what} takes its part{share}; "
            text += f"{pure} alone is excluded."
        else:
            text = f"These data do not tell whether {what} takes part in the damping{share}."
        out.append(text)
    return out

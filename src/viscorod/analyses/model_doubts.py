"""What is allowed in a model but hardly meant, told with every result: equal loads, rods that meet unjoined."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from viscorod.analyses.carried_loads import carried_loads
from viscorod.analyses.doubtful_numbers import doubtful_numbers
from viscorod.analyses.touching_coils import TOUCHING
from viscorod.analyses.unjoined_rods import unjoined_rods
from viscorod.model.actions.load import Gravity
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.centrelines.line_shapes import Helix
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import some_of
from viscorod.model.rod import Rod
from viscorod.model.rod_checks import reaching_centre
from viscorod.model.rod_sections import doubts_of
from viscorod.model.sections.isotropic_section import MaterialSection
from viscorod.model.sections.section_shapes import Annulus, Circle
from viscorod.solve.problem.problem import Problem

__all__ = ["model_doubts"]

EARTHLY = 2e-3
"""How far the acceleration of gravity differs on Earth from 9.81 m/s^2, as a part of it, as it is rounded in use."""
RECORD = 20
"""Rows from which on a table of time is a record; shorter ones are ramps, which end where they are to stay."""
HELD = 1e-3
"""Part of the largest value of a table beyond which one that is kept matters."""
WARPED = 0.1
"""Part of the length of a rod over which held warping stiffens its torsion, beyond which it is told: the twist of a
cantilever is by as large a part of itself too large."""
ASKEW = math.radians(5.0)
"""Angle between a given first axis of sections and the plane across the rod beyond which it is told."""


def model_doubts(model: ModelDescription, problem: Problem, duration: float = 0.0) -> list[str]:
    """Return what is hardly meant: numbers in other units, sections past a centre, equal loads, springs that push.

    Args:
        model: what the user said; problem: the model discretised; duration: of its motion [s], which tables of time
            should cover.
    """
    damping = [f"rod {name}: {text}" for name, rod in model.rods.items() for text in doubts_of(rod)]
    shapes = [text for name, rod in model.rods.items() for text in _no_rod(name, rod)]
    tables = [text for where, table in _tables(model) for text in _of_table(where, table, duration)]
    return [
        *doubtful_numbers(model),
        *damping,
        *shapes,
        *_loads(model),
        *carried_loads(model),
        *_pushing(model),
        *unjoined_rods(model, problem),
        *tables,
    ]


def _pushing(model: ModelDescription) -> Iterator[str]:
    """Yield which springs push what leaves its rest farther away."""
    for spring in model.springs:
        stiffness = getattr(spring, "stiffness", None)
        for word, value in stiffness.items() if isinstance(stiffness, Mapping) else [("", stiffness)]:
            if isinstance(value, float) and value < 0.0:
                along = f" along {word}" if word else ""
                yield (
                    f"{spring.label}: a stiffness of {value:.4g}{along} pushes away from rest what leaves it; springs "
                    "that pull back have positive numbers"
                )


def _no_rod(name: str, rod: Rod) -> Iterator[str]:
    """Yield whether a rod is thicker than long, reaches past its centre of curvature, or has axes along it."""
    yield from _askew(name, rod)
    half = rod.section_at(0.0).half_width or 0.0
    if half > rod.length:
        yield (
            f"rod {name}: its half width, {half:.4g} m, is more than its length, {rod.length:.4g} m: it is no rod; "
            "lengths are in m, and 1 mm is 1e-3 m"
        )
    yield from _coils(name, rod)
    yield from _warping(name, rod)
    yield from _too_stiff(name, rod)
    found = reaching_centre(rod)
    if found is not None:
        s, radius = found
        yield (
            f"rod {name}: at s = {s:.4g} m its section reaches past the centre of curvature of the reference shape, "
            f"{radius:.4g} m away: parts of it would lie within each other, which no body does, and the rod is "
            "computed as if it were slender; make the section thinner or the radius larger (lengths are in m)"
        )


def _coils(name: str, rod: Rod) -> Iterator[str]:
    """Yield whether the turns of a wire lie within each other; those of a close-coiled spring touch."""
    line, section = rod.centreline, rod.section_at(0.0)
    if not isinstance(line, Helix) or line.turns <= 1.0 or not isinstance(section, Circle | Annulus):
        return
    thick = 2.0 * (section.half_width or 0.0)
    if line.apart < (1.0 - TOUCHING) * thick:
        yield (
            f"rod {name}: its turns are {line.apart:.4g} m apart and its section is {thick:.4g} m thick: they lie "
            "within each other, and no contact is computed; make the pitch larger or the section thinner (lengths are "
            "in m)"
        )


def _warping(name: str, rod: Rod) -> Iterator[str]:
    """Yield whether warping would stiffen the torsion of thin open walls, which is not computed (Vlasov).

    It does where twist changes along the rod, at ends that hold it and in lateral buckling: a half wave of the rod's
    length has a torsional stiffness larger by ``(pi d/L)^2``, d = sqrt(EIw/GJ).
    """
    known = [section.warping_length(rod.material) or 0.0 for _, section in rod.typical_sections()]
    longest = max(known, default=0.0)
    if longest > WARPED * rod.length:
        yield (
            f"rod {name}: the warping of its section, which is free here, stiffens torsion wherever the twist changes "
            f"along the rod, over {longest:.3g} m (sqrt(EIw/GJ)), and the rod is {rod.length:.3g} m long: between "
            f"forks it would buckle sideways by a moment up to {_share(longest, rod.length)} % larger than computed, "
            "and with ends that hold the warping, as a weld does, twist less and buckle later still"
        )


def _share(reach: float, length: float) -> str:
    """Return by how many per cent warping raises the critical moment of a half wave (Timoshenko and Gere 1961, 6.3)."""
    return f"{100.0 * (np.sqrt(1.0 + (np.pi * reach / length) ** 2) - 1.0):.2g}"


def _too_stiff(name: str, rod: Rod) -> Iterator[str]:
    """Yield whether a torsion constant is larger than that without warping, which is the largest (Saint-Venant)."""
    for _, section in rod.typical_sections():
        if isinstance(section, MaterialSection):
            torsion, polar = section.torsion(), sum(section.moments()[1:])
            if torsion > (1.0 + TOUCHING) * polar:
                yield (
                    f"rod {name}: the torsion constant {torsion:.4g} m^4 is larger than the sum of the second moments, "
                    f"{polar:.4g} m^4: no section of one material has that (only round ones reach it)"
                )
                return


def _askew(name: str, rod: Rod) -> Iterator[str]:
    """Yield how far a given first axis of the sections is from the plane across the rod, into which it is turned."""
    if rod.d1 is None:
        return
    given = np.asarray(rod.d1, dtype=float)
    tangent = rod.centreline.bishop(np.zeros(1))[1][0][:, 2]
    angle = math.asin(min(1.0, abs(float(given @ tangent)) / float(np.linalg.norm(given))))
    if angle > ASKEW:
        used = ", ".join(f"{x:.4g}" for x in rod.centreline.frames([0.0], rod.d1)[1][0][:, 0].round(9) + 0.0)
        yield (
            f"rod {name}: d1 = ({', '.join(f'{x:.4g}' for x in given)}) is {math.degrees(angle):.3g} degrees off the "
            f"plane across the rod at its start; the part of it in that plane is used, ({used})"
        )


def _loads(model: ModelDescription) -> Iterator[str]:
    """Yield weights that look like those of another unit, and equal loads."""
    for index, load in enumerate(model.loads):
        if isinstance(load, Gravity):
            size = float(np.linalg.norm(load.acceleration))
            for unit, times in (("mm", 1000.0), ("cm", 100.0)):
                if abs(size / (9.81 * times) - 1.0) < EARTHLY:
                    yield (
                        f"loads[{index}].acceleration: {size:.6g} m/s2 is {times:g} times the weight on Earth; "
                        f"{size:.6g} {unit}/s2 are {size / times:.4g} m/s2"
                    )
    yield from _loads_twice(model)


def _loads_twice(model: ModelDescription) -> Iterator[str]:
    """Yield which loads are there more than once."""
    if len(model.loads) < 2:
        return
    alike: dict[str, list[list[int]]] = {}
    for index, load in enumerate(model.loads):
        groups = alike.setdefault(repr(load), [])
        for numbers in groups:
            if model.loads[numbers[0]] == load:
                numbers.append(index)
                break
        else:
            groups.append([index])
    for numbers in (numbers for groups in alike.values() for numbers in groups if len(numbers) > 1):
        same = some_of([f"loads[{index}]" for index in numbers])
        yield (
            f"{same} are the same {model.loads[numbers[0]].word}: they add up to {len(numbers)} times one of them; "
            f"leave {'one' if len(numbers) == 2 else 'all but one'} out if it is meant once"
        )


def _tables(model: ModelDescription) -> Iterator[tuple[str, TimeTable]]:
    """Yield all tables of time with their key paths: of loads, motions, motors and rest strains."""
    for word in ("loads", "supports", "joints", "rest_strains"):
        for k, part in enumerate(getattr(model, word)):
            for name in type(part).model_fields:
                given = getattr(part, name)
                for key, one in given.items() if isinstance(given, Mapping) else [("", given)]:
                    if isinstance(one, TimeTable):
                        yield f"{word}[{k}].{name}{key and '.' + key}", one


def _of_table(where: str, table: TimeTable, duration: float) -> Iterator[str]:
    """Yield what a table was read as, and what it keeps if it is a record rather than a ramp."""
    if table.doubt:
        yield f"{where}: {table.doubt}"
    if table.file is not None or len(table.knots) >= RECORD:
        yield from _uncovered(where, table, duration)


def _uncovered(where: str, table: TimeTable, duration: float) -> Iterator[str]:
    """Yield which value a table keeps before its first or after its last time, while a motion goes on."""
    first, last = (float(table.knots[k]) for k in (0, -1))
    began, ended = table.value(first, before=True), table.value(last)
    least = HELD * float(np.abs(table.at(table.knots)).max())
    if duration and first > 0.0 and abs(began) > least:
        yield (
            f"{where}: the table begins at {first:.6g} s, and its first value, {began:.4g}, is taken from the "
            "beginning on; let it begin with 0, or at 0 s"
        )
    if last < duration and abs(ended) > least:
        yield (
            f"{where}: the table ends at {last:.6g} s, and its last value, {ended:.4g}, is kept up to the end of the "
            f"motion at {duration:.6g} s; let it end with 0, or give a shorter duration, if that is not meant"
        )

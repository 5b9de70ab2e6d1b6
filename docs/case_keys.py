"""Sphinx extension: the keys of a case file, as tables made from the classes that read them.

``{case-keys} sections.circle`` becomes a table of the keys of that part of a case file. A key without a line in
the docstring of its class, a check without words here, and a part that no page shows are errors of the build.
"""

import inspect

from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

from viscorod.casefile import case_reader as schema
from viscorod.casefile.json_schema import GROUPS, PARTS, PYTHON_ONLY_KEYS, REQUIRED
from viscorod.casefile.meanings import meanings
from viscorod.model.connections.motion_words import MOTIONS, VELOCITIES
from viscorod.model.rod import Rod
from viscorod.model.sections.section_profile import SECTIONS
from viscorod.model.sections.section_shapes import SHAPES
from viscorod.solve.transient.integrators import INTEGRATORS

SECTION = "name of a section in quotes, or a table with `shape`"
FILE = {
    "title": ("text", "name of the file", "heading of reports and pictures"),
    "materials": ("tables `[materials.NAME]`", "\N{EN DASH}", "see Materials"),
    "sections": ("tables `[sections.NAME]`", "\N{EN DASH}", "see Sections"),
    "rods": ("tables `[rods.NAME]`", "required", "see Rods"),
    "bodies": ("tables `[bodies.NAME]`", "\N{EN DASH}", "see Rigid bodies"),
    "supports": ("tables `[[supports]]`", "\N{EN DASH}", "see Supports"),
    "loads": ("tables `[[loads]]`", "\N{EN DASH}", "see Loads"),
    "attachments": ("tables `[[attachments]]`", "\N{EN DASH}", "see Attachments"),
    "joints": ("tables `[[joints]]`", "\N{EN DASH}", "see Joints"),
    "springs": ("tables `[[springs]]`", "\N{EN DASH}", "see Springs"),
    "velocities": ("tables `[[velocities]]`", "at rest", "see Initial velocities"),
    "strains": ("tables `[[strains]]`", "unstrained", "see Initial strains"),
    "simulate": ("table `[simulate]`", "one of these four", "see Analyses"),
    "equilibrium": ("table `[equilibrium]`", "one of these four", "see Analyses"),
    "path": ("table `[path]`", "one of these four", "see Analyses"),
    "steady": ("table `[steady]`", "one of these four", "see Analyses"),
}
ROD = {
    "section": (SECTION, "one of these three", "the section of the whole rod"),
    "sections": ("list of pieces", "one of these three", "sections one after the other, see Sections"),
    "taper": ("table", "one of these three", "section that changes along the rod, see Sections"),
    "material": (
        "name of a material in quotes, or a table",
        "\N{EN DASH}",
        "for all sections but `stiffness` and `composite`",
    ),
}

TEXTS = {
    "number": "number",
    "word": "text, in quotes",
    "positive": "number > 0",
    "vector": "3 numbers",
    "direction": "3 numbers, not all 0; any length",
    "name_of_part": "name, in quotes",
    "place_text": "place, in quotes",
    "end_text": 'place, or `"ground"`, in quotes',
    "_anchor": "place, in quotes, or 3 numbers",
    "named_points": "table from names to 3 numbers each",
    "constraint_words": "text, or list of texts",
    "stiffness": "number",
    "damping": "number >= 0",
    "_sides": "3 numbers > 0",
    "axes_of": "2 perpendicular directions, 3 numbers each",
    "true_or_false": "`true` or `false`",
    "numbers": "numbers",
    "_several": "list of 2 numbers or more",
    "_points": "list of 2 points or more, 3 numbers each",
    "_density": "3 numbers",
    "corners": "list of 3 points or more, 2 numbers each",
    "rings": "list of such lists",
    "pair": "2 numbers",
    "_some_regions": "list of tables, see below",
    "composite._material": "name of a material in quotes, or a table",
    "_times": "6 numbers >= 0",
    "_some_branches": "list of tables, see below",
    "_branch_stiffness": "6 numbers (a diagonal) or 6 rows of 6",
    "_twist": "number",
    "_ratio": "number above 0 and below 1",
    "_decrement": "number > 0",
    "_mode": 'whole number, 1 to 50, or a text such as `"bend_1 2"`',
    "_column": "list of numbers",
    "frequency_band": "2 numbers > 0, the lower first",
    "_modulus_table": "table, see below",
    "_strain": "6 numbers",
    "_part": "number above 0 and below 1",
    "_some_events": "list of tables, see below",
    "_spin": "number > 0, or 3 numbers",
    "_stiffness": "6 numbers (a diagonal) or 6 rows of 6",
    "stiffness_section._inertia": "6 numbers (a diagonal) or 6 rows of 6",
    "body._inertia": "3 numbers > 0, or 3 rows of 3",
    "fixed_motions": f"list of some of {', '.join(f'`{word!r}`' for word in MOTIONS)}".replace("'", '"'),
    "fixed_velocities": f"list of some of {', '.join(f'`{word!r}`' for word in VELOCITIES)}".replace(
        "'", '"'
    ),
    "velocity_functions": "table from velocity words to numbers or functions of time",
    "motion_functions": "table from motion words to numbers or functions of time",
    "two_directions": "2 perpendicular directions, 3 numbers each",
    "one_section": SECTION,
    "integrator_name": " or ".join(f'`"{word}"`' for word in INTEGRATORS),
    "time_function": "number, or table with `kind`, see Functions of time",
    "material._damping": "table, see below",
    "stiffness_section._damping": "6 numbers (a diagonal) or 6 rows of 6",
}
"""Checks of values by name (with the module where two share one) and what they let through, in words."""


def allowed(check):
    """What a check lets through, in words."""
    name = check.__qualname__
    inside = inspect.getclosurevars(check).nonlocals
    if name == "optional.<locals>.<lambda>":
        return allowed(inside["check"])
    if name == "_bounded.<locals>.check":
        return f"number {inside['allowed'].split(', or')[0]}"
    if name == "_numbers.<locals>.check":
        return f"list of numbers {inside['allowed']}"
    if name == "whole_number.<locals>.check":
        return f"whole number, {inside['low']} to {inside['high']}"
    if name == "_whole_or_auto.<locals>.parse":
        return f'{allowed(inside["check"])}, or `"auto"`'
    if name == "one_of.<locals>.check":
        return " or ".join(f'`"{word}"`' for word in inside["allowed"])
    if name == "choose.<locals>.parse":
        return SECTION if inside["kinds"] in (SECTIONS, SHAPES) else f"table with `{inside['tag']}`"
    if name == "_table.<locals>.parse":
        return f"table from motion words to {allowed(inside['check']).replace('number', 'numbers')}"
    module = check.__module__.rpartition(".")[2]
    return TEXTS.get(f"{module}.{name}") or TEXTS[name]


def default(kind, name, field):
    """The default of a key as it would stand in a file."""
    if field.is_required() or (kind, name) in REQUIRED:
        return "required"
    value = field.default
    if value in (None, (), {}) or str(value) == "nan":  # NaN marks one of two alternatives
        return "\N{EN DASH}"
    if isinstance(value, tuple):
        return f"`{list(value)}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    return f"`{str(value).lower()}`"


def keys(kind, leave_out=()):
    """Rows (key, allowed values, default, meaning) of a class: its kind, what it requires, what it may have."""
    known, tag = meanings(kind), getattr(kind, "tag", None)
    fields = kind.model_fields.items()
    for name, field in sorted(fields, key=lambda pair: (pair[0] != tag, not pair[1].is_required())):
        if (kind, name) in PYTHON_ONLY_KEYS or name in leave_out:
            continue
        if name == tag:
            standard = any(kind is usual for _, _, usual in GROUPS.values())
            default_kind = f'`"{field.default}"`' if standard else "required"
            yield name, f'`"{field.default}"`', default_kind, "tells the kind"
        else:
            yield name, allowed(field.metadata[0].func), default(kind, name, field), known[name].rstrip(".")


def part_rows(part):
    """Rows of a part of the case file."""
    if part == "file":
        rows, expected = [(key, *texts) for key, texts in FILE.items()], schema.KEYS
    elif part == "rods":
        own = keys(Rod, leave_out=("centreline", "section", "material"))
        rows, expected = [*((key, *texts) for key, texts in ROD.items()), *own], schema.ROD_KEYS
    else:
        return list(keys(PARTS[part]))
    if {row[0] for row in rows} != set(expected):
        raise KeyError(f"the keys of {part} are {expected}")
    return rows


class CaseKeys(SphinxDirective):
    """Table of the keys of one part of a case file."""

    required_arguments = 1

    def run(self):
        part = self.arguments[0]
        self.env.note_reread()  # the classes may have changed where the page has not
        self.env.case_parts = getattr(self.env, "case_parts", set()) | {part}
        lines = ["| key | value | default | meaning |", "|---|---|---|---|"]
        for key, value, standard, meaning in part_rows(part):
            lines.append(f"| `{key}` | {value} | {standard} | {meaning.replace('|', chr(92) + '|')} |")
        return self.parse_text_to_nodes("\n".join(lines))


def all_shown(app, env):
    """Warn of parts that no page shows."""
    missing = {"file", "rods", *PARTS} - getattr(env, "case_parts", set())
    if missing:
        logging.getLogger(__name__).warning("no page shows the keys of %s", ", ".join(sorted(missing)))


def setup(app):
    app.add_directive("case-keys", CaseKeys)
    app.connect("env-check-consistency", all_shown)
    return {"parallel_read_safe": False}

"""Sphinx extension: the keys of a case file, as tables made from the classes that read them.

``{case-keys} sections.circle`` becomes a table of the keys of that part of a case file. A part that no page shows is an
error of the build.
"""

from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

from viscorod.casefile import case_reader as schema
from viscorod.casefile.json_schema import GROUPS, PARTS, fields_of, is_required
from viscorod.model.fields.metadata import accepted, meaning
from viscorod.model.rod import Rod
from viscorod.model.sections.section_base import SECTION

FILE = {
    "title": ("text", "name of the file", "heading of reports and pictures"),
    "materials": ("tables `[materials.NAME]`", "\N{EN DASH}", "see Materials"),
    "sections": ("tables `[sections.NAME]`", "\N{EN DASH}", "see Sections"),
    "rods": (
        "tables `[rods.NAME]`",
        "\N{EN DASH}",
        "see Rods; a case has rods or bodies, or both",
    ),
    "bodies": ("tables `[bodies.NAME]`", "\N{EN DASH}", "see Rigid bodies"),
    "supports": ("tables `[[supports]]`", "\N{EN DASH}", "see Supports"),
    "loads": ("tables `[[loads]]`", "\N{EN DASH}", "see Loads"),
    "attachments": ("tables `[[attachments]]`", "\N{EN DASH}", "see Attachments"),
    "joints": ("tables `[[joints]]`", "\N{EN DASH}", "see Joints"),
    "springs": ("tables `[[springs]]`", "\N{EN DASH}", "see Springs"),
    "velocities": ("tables `[[velocities]]`", "at rest", "see Initial velocities"),
    "strains": ("tables `[[strains]]`", "unstrained", "see Initial strains"),
    "rest_strains": ("tables `[[rest_strains]]`", "none", "see Rest strains"),
    "simulate": ("table `[simulate]`", "one of these", "see Analyses"),
    "equilibrium": ("table `[equilibrium]`", "one of these", "see Analyses"),
    "path": ("table `[path]`", "one of these", "see Analyses"),
    "steady": ("table `[steady]`", "one of these", "see Analyses"),
    "modes": ("table `[modes]`", "one of these", "see Analyses"),
    "response": ("table `[response]`", "one of these", "see Analyses"),
    "buckling": ("table `[buckling]`", "one of these", "see Analyses"),
    "campbell": ("table `[campbell]`", "one of these", "see Analyses"),
    "stability": ("table `[stability]`", "one of these", "see Analyses"),
    "periodic": ("table `[periodic]`", "one of these", "see Analyses"),
}
ROD = {
    "section": (SECTION, "one of these three", "the section of the whole rod"),
    "sections": (
        "list of pieces, or table of stations",
        "one of these three",
        "sections one after the other, or at stations, see Sections",
    ),
    "taper": (
        "table",
        "one of these three",
        "section that changes along the rod, see Sections",
    ),
}


def default(field):
    """Return the default of a key as it would stand in a file."""
    if is_required(field):
        return "required"
    value = field.default
    if (
        value in (None, (), {}) or str(value) == "nan"
    ):  # NaN marks one of two alternatives
        return "\N{EN DASH}"
    if isinstance(value, tuple):
        return f"`{list(value)}`"
    if isinstance(value, str):
        return f'`"{value}"`'
    return f"`{str(value).lower()}`"


def keys(kind):
    """Yield rows (key, allowed values, default, meaning) of a class: its kind, what it requires, what it may have."""
    fields = fields_of(kind).items()
    for name, field in sorted(
        fields, key=lambda pair: (pair[0] != kind.tag, not pair[1].is_required())
    ):
        if name == kind.tag:
            standard = any(kind is usual for _, _, usual in GROUPS.values())
            default_kind = f'`"{field.default}"`' if standard else "required"
            yield name, f'`"{field.default}"`', default_kind, "the kind"
        else:
            yield name, accepted(field).words, default(field), meaning(field)


def part_rows(part):
    """Return the rows of a part of the case file."""
    if part == "file":
        rows, expected = [(key, *texts) for key, texts in FILE.items()], schema.KEYS
    elif part == "rods":
        rows, expected = (
            [*((key, *texts) for key, texts in ROD.items()), *keys(Rod)],
            schema.ROD_KEYS,
        )
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
        for key, value, standard, text in part_rows(part):
            lines.append(
                f"| `{key}` | {value} | {standard} | {text.replace('|', chr(92) + '|')} |"
            )
        return self.parse_text_to_nodes("\n".join(lines))


def all_shown(app, env):
    """Warn of parts that no page shows."""
    missing = {"file", "rods", *PARTS} - getattr(env, "case_parts", set())
    if missing:
        logging.getLogger(__name__).warning(
            "no page shows the keys of %s", ", ".join(sorted(missing))
        )


def setup(app):
    app.add_directive("case-keys", CaseKeys)
    app.connect("env-check-consistency", all_shown)
    return {"parallel_read_safe": False}

"""Sphinx extension: the variables of results, as tables made from what the code checks."""

from __future__ import annotations

from sphinx.util.docutils import SphinxDirective

from viscorod.results.data_schema import (
    DIMENSION,
    DIMENSIONS,
    FRAMES,
    PLACES,
    STATES,
    VARIABLES,
)


def variable_rows():
    """Rows (name, dimensions, unit, axes, meaning) of all variables."""
    for name, (unit, meaning) in VARIABLES.items():
        dimensions = ", ".join(
            f"*{word}*" if word == STATES else f"`{word}`" for word in DIMENSIONS[name]
        )
        yield f"`{name}`", dimensions, unit, FRAMES.get(name, ""), meaning


def dimension_rows():
    """Rows (name, what its places are) of all dimensions."""
    kinds = ", ".join(f"`{along}` (kind {kind})" for kind, along in DIMENSION.items())
    yield f"*{STATES}*", f"the stored states: {kinds}"
    for name, meaning in PLACES.items():
        yield f"`{name}`", meaning


TABLES = {
    "variables": (("variable", "dimensions", "unit", "axes", "meaning"), variable_rows),
    "dimensions": (("dimension", "its places"), dimension_rows),
}


class DataVariables(SphinxDirective):
    """Table of the variables or of the dimensions."""

    required_arguments = 1

    def run(self):
        self.env.note_reread()  # the schema may have changed where the page has not
        heads, rows = TABLES[self.arguments[0]]
        lines = [f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}"]
        lines += [f"| {' | '.join(row)} |" for row in rows()]
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app):
    app.add_directive("data-variables", DataVariables)
    return {"parallel_read_safe": False}

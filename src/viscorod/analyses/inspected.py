"""A model looked at before it is computed: checked, drawn, written as a case file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscorod.checks import checked, checked_with, text
from viscorod.errors import Fault, InputError
from viscorod.model.description.model_description import ModelDescription

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from viscorod.results.reports.check_report import CheckReport

__all__ = ["Inspected"]


class Inspected(ModelDescription):
    """Methods about a model itself; a part of ``Model``."""

    def check(self) -> CheckReport:
        """Look at the model before it is computed, as ``viscorod check`` does.

        Returns:
            Its rods, sections, materials and joints in tables, the first modes about the reference shape, motions that
            nothing resists, and doubts; ``print`` shows it.

        Raises:
            InputError: the parts do not fit together.
        """
        from viscorod.analyses.check import check
        from viscorod.analyses.discrete import DiscreteModel

        return check(DiscreteModel.of(self))

    @checked_with(analysis=text)
    def to_toml(self, path: str | Path | None = None, analysis: str = "equilibrium", **settings: Any) -> str:
        """Return the model as a case file, with the table of an analysis.

        Args:
            path: of a file to write; without it nothing is written.
            analysis: "simulate", "equilibrium", "modes" and so on, as the tables of a case file.
            settings: of that analysis, such as ``duration=2.0``.

        Raises:
            InputError: a part is a Python function, which no file can hold, or there is no such analysis or setting.
        """
        from viscorod.casefile.analysis_tables import ANALYSES
        from viscorod.casefile.case import parse_case
        from viscorod.casefile.toml_text import toml_text
        from viscorod.whole_files import replacing
        from viscorod.wording import did_you_mean

        self.validate()
        if analysis not in ANALYSES:
            advice = f"{did_you_mean(analysis, ANALYSES)}give one of {', '.join(ANALYSES)}"
            raise InputError(Fault("analysis", repr(analysis), "there is no such analysis", advice))
        content = self.to_dict()
        for key in _functions(content):
            raise InputError(
                Fault(
                    key,
                    "",
                    "it is a Python function, which no file can hold",
                    "describe it by a table instead",
                )
            )
        made = ANALYSES[analysis](**settings)
        written = toml_text({**content, analysis: made.to_dict()})
        parse_case(written)
        if path is not None:
            with replacing(Path(path)) as new:
                new.write_text(written, encoding="utf-8")
        return written

    @checked
    def draw(self, path: str | Path | None = None, title: str = "", *, ax: Axes | None = None) -> Figure:
        """Draw the model in its reference shape: rods, bodies, joints, springs, supports and loads.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            title: above the picture.
            ax: axes of yours to draw into.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the model is inconsistent, or the picture cannot be written.
        """
        from viscorod.pictures.drawing.model_drawing import draw_assembly
        from viscorod.pictures.picture import delivered

        return delivered(draw_assembly(self, title, ax), path)


def _functions(value: Any, path: str = "") -> list[str]:
    """Return the keys of what is a Python function in the content of a case."""
    if isinstance(value, str):
        return [path] if value.startswith("<Python function") else []
    if isinstance(value, dict):
        return [
            key
            for name, item in value.items()
            for key in _functions(item, f"{path}.{name}" if path else name)
        ]
    if isinstance(value, list):
        return [key for number, item in enumerate(value) for key in _functions(item, f"{path}[{number}]")]
    return []

"""The kinds of sections by their word in a case file, and a field that takes one of them."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from typing import Annotated

from viscorod.model.fields.forms import named_or
from viscorod.model.fields.values import choose
from viscorod.model.sections.composite import Composite
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.outline import PolygonSection
from viscorod.model.sections.section_base import SECTION, AnySection
from viscorod.model.sections.section_shapes import SHAPES
from viscorod.model.sections.stiffness_section import StiffnessSection

__all__ = ["SECTIONS", "SectionField", "one_section"]

SECTIONS: Mapping[str, type[AnySection]] = ChainMap(
    {
        "outline": PolygonSection,
        "composite": Composite,
        "given": SectionProperties,
        "stiffness": StiffnessSection,
    },
    SHAPES,
)
"""The sections by their word in a case file: the SHAPES, and those that are not made of one known outline."""

one_section = choose("shape", SECTIONS, form=named_or("section"), words=SECTION)
SectionField = Annotated[AnySection, one_section]

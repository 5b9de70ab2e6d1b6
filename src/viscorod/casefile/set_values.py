"""A case with other values of some keys, as ``viscorod run --set`` asks for it."""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from viscorod.casefile.case import Case, case_from_dict
from viscorod.casefile.case_keys import put_all

__all__ = ["with_values"]


def with_values(case: Case, values: Mapping[str, Any]) -> Case:
    """Return a case with other values; what it was read from stays known beside them.

    Args:
        case: that was read from a file.
        values: key -> value, such as ``{"loads[0].value": [0.0, 0.02, 0.0]}``.

    Raises:
        InputError: a key or a value is wrong.
    """
    if not values:
        return case
    content = copy.deepcopy(dict(case.content))
    put_all(content, values)
    changed = case_from_dict(content, case.source, case.text)
    return replace(changed, changes=json.dumps({**values}))

"""The content of a case as the text of a case file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

__all__ = ["toml_text"]

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(content: Mapping[str, Any]) -> str:
    """Return nested tables, lists, texts and numbers as TOML; keys without a value are left out."""
    lines: list[str] = []
    _table(content, "", lines)
    return "\n".join(lines).strip() + "\n"


def _table(content: Mapping[str, Any], path: str, lines: list[str]) -> None:
    tables = {key: value for key, value in content.items() if isinstance(value, Mapping)}
    listed = {
        key: value
        for key, value in content.items()
        if isinstance(value, list | tuple) and value and all(isinstance(item, Mapping) for item in value)
    }
    for key, value in content.items():
        if key not in tables and key not in listed and value is not None:
            lines.append(f"{_key(key)} = {_value(value)}")
    for key, value in tables.items():
        inner = f"{path}.{_key(key)}" if path else _key(key)
        lines += ["", f"[{inner}]"]
        _table(value, inner, lines)
    for key, value in listed.items():
        inner = f"{path}.{_key(key)}" if path else _key(key)
        for item in value:
            lines += ["", f"[[{inner}]]"]
            _table(item, inner, lines)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _text(key)


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(k)} = {_value(v)}' for k, v in value.items() if v is not None)} }}"
    return repr(value)

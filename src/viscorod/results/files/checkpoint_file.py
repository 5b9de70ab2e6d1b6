"""Checkpoints of a journal: from what a run goes on, as a file of arrays and a text that orders them."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.sealed_file import read_sealed

__all__ = ["EDITION", "Checkpoint", "packed_checkpoint", "plain", "read_checkpoint"]

EDITION = 4
"""Edition of saved states, whose parts go by the names of attributes: it grows when one of them changes."""


@dataclass(frozen=True)
class Checkpoint:
    """From what a run goes on.

    Attributes:
        state: as ``solve.transient.saved_state`` returned it; None at the beginning.
        count: states of the journal at that time.
        about: what was said about it.
        doubt: what is damaged, so that this is not the last one; empty usually.
    """

    state: Any
    count: int
    about: Mapping[str, Any]
    doubt: str = ""


def packed_checkpoint(state: Any, count: int, about: Mapping[str, Any]) -> memoryview:
    """Return the content of the file of a checkpoint."""
    arrays: dict[str, Any] = {}
    tree = _flattened(state, arrays)
    text = json.dumps({"edition": EDITION, "tree": tree, "count": count, "about": dict(about)}, default=plain)
    packed = io.BytesIO()
    np.savez(packed, text=np.frombuffer(text.encode(), dtype=np.uint8), **arrays)
    return packed.getbuffer()


def read_checkpoint(path: Path, identity: bytes | None) -> Checkpoint:
    """Return the checkpoint in a file, which has to be of the journal with this identity, if one is given.

    Raises:
        FileNotFoundError: there is none. InputError: it cannot be read, or another version wrote it.
    """
    content, _ = read_sealed(path, identity)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        text = json.loads(arrays.pop("text").tobytes())
        if text.get("edition") == EDITION:
            return Checkpoint(_rebuilt(text["tree"], arrays), int(text["count"]), text["about"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, BadZipFile) as error:
        raise InputError(f"{path} cannot be read ({error})") from None
    raise InputError(
        f"{path.parent}: the run was stopped by another version of viscorod, whose state this one would misread; "
        "go on with that version, or run the case again"
    )


def _flattened(tree: Any, arrays: dict[str, np.ndarray]) -> Any:
    """Return a tree with the numbers of its arrays in their places; the arrays go into ``arrays``."""
    if isinstance(tree, np.ndarray):
        arrays[f"a{len(arrays)}"] = tree
        return {"array": len(arrays) - 1}
    if isinstance(tree, dict):
        return {"dict": {key: _flattened(item, arrays) for key, item in tree.items()}}
    if isinstance(tree, list):
        return [_flattened(item, arrays) for item in tree]
    return tree


def _rebuilt(tree: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if isinstance(tree, dict):
        if "array" in tree:
            return arrays[f"a{tree['array']}"]
        return {key: _rebuilt(item, arrays) for key, item in tree["dict"].items()}
    return [_rebuilt(item, arrays) for item in tree] if isinstance(tree, list) else tree


def plain(value: Any) -> Any:
    """Return what JSON can hold of a number of NumPy, or of a sequence."""
    return value.item() if isinstance(value, np.generic) else list(value)

"""Linear systems as .npz files of NumPy and .mat files of Matlab."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import sparse

from viscorod.errors import InputError
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from viscorod.results.linear_system import LinearSystem

__all__ = ["write_linear_system"]


def write_linear_system(system: LinearSystem, path: Path) -> Path:
    """Write all matrices and names; see ``LinearSystem.save``.

    Raises:
        InputError: the suffix is another one, or the place cannot be written.
    """
    if path.suffix not in (".npz", ".mat"):
        raise InputError(f"{path}: the suffix {path.suffix!r} is not .npz or .mat")
    parts = _parts(system)
    with replacing(path) as new, new.open("wb") as file:
        if path.suffix == ".npz":
            np.savez_compressed(file, **_flat(parts))
        else:
            from scipy.io import savemat

            texts = {k: np.array(v, dtype=object) if isinstance(v, tuple) else v for k, v in parts.items()}
            savemat(file, texts, do_compression=True)
    return path


def _parts(system: LinearSystem) -> dict[str, Any]:
    """Return matrices and names of a linear system by the names that they have in its files."""
    second = system.second_order
    found: dict[str, Any] = {
        "mass": system.mass,
        "damping": system.damping,
        "gyroscopic": system.gyroscopic,
        "stiffness": system.stiffness,
        "circulatory": system.circulatory,
        "relaxation_times": second.times,
        "input_force": second.force,
        "input_derivative": second.derivative,
        "direct": second.direct,
        "inputs": system.inputs,
        "outputs": system.outputs,
        "input_units": system.input_units,
        "output_units": system.output_units,
        "coordinates": system.coordinates,
        "about": system.about,
    }
    words = ["stiffness", "damping", "mass", *(f"branch_{j + 1}" for j in range(len(second.times)))]
    for k, word in enumerate(words):
        found[f"input_{word}"] = second.pushed[k]
        found[f"output_{word}"] = second.rows[k]
        found[f"output_input_{word}"] = second.carried[k]
        if k > 2:
            found[word] = second.terms[k]
    if system.combinations is not None:
        found["combinations"], found["motions"] = system.combinations, system.motions
    if system.conditions is not None:
        found["conditions"] = system.conditions
    return found


def _flat(parts: dict[str, Any]) -> dict[str, Any]:
    """Return sparse matrices as arrays, and texts as such."""
    found: dict[str, Any] = {}
    for name, value in parts.items():
        if sparse.issparse(value):
            for word in ("data", "indices", "indptr", "shape"):
                found[f"{name}.{word}"] = np.asarray(getattr(value, word))
        else:
            found[name] = np.asarray(value)
    return found

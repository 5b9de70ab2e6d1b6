"""GXBeam-style beams, points and 6x6 matrices per element, as viscorod rods and back.

The keys are the arguments of GXBeam's Assembly (byuflowlab/GXBeam.jl, src/assembly.jl): `points` (n + 1 rows of
three, m), `stiffness` or `compliance`, `mass`, `damping` (six mu, s) and `frames` (3x3, from the element's axes to
the global ones; the element's x is along the beam). Each of the last five is one for all elements or a list of n.
Matrices are in GXBeam's order (axial, shear y, shear z | torsion, bending y, bending z).
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viscorod.argument_names import telling
from viscorod.checks import checked_with, file_path, number_of_parts, of_class
from viscorod.errors import Fault, InputError
from viscorod.model.fields.symmetry import skew_entry
from viscorod.model.rod import Rod
from viscorod.model.sections.section_profile import Piecewise
from viscorod.model.sections.stiffness_section import StiffnessSection
from viscorod.programs.axial_first import from_axial_first, to_axial_first
from viscorod.programs.blades.beamdyn_line import ReferenceLine
from viscorod.programs.blades.blade_rod import Law, product_damping
from viscorod.programs.matrices import symmetric_part
from viscorod.programs.own_laws import refuse_own_laws
from viscorod.programs.times import component_times, six_times, symmetric_damping
from viscorod.typing import Floats

__all__ = ["gxbeam_from_rod", "rod_from_gxbeam", "section_turn"]

KEYS = ("points", "stiffness", "compliance", "mass", "damping", "frames")
_ALIGNED = 0.05  # rad between an element's x axis and the spline's tangent at its middle


@telling
def rod_from_gxbeam(assembly: Mapping[str, Any] | str | Path, *, law: Law = "symmetric") -> Rod:
    """Return a GXBeam-style beam as a rod with one section per element.

    The section axes follow the rotation-minimising frame that starts as the first element's; matrices of elements
    whose frames are turned about the tangent are turned accordingly, which changes nothing of their law. The beam is
    straight, or a smooth curve through the points. For `law` see `rod_from_blade`.

    Args:
        assembly: the keys above as a mapping, or the path of a TOML or JSON file with them.
        law: "symmetric" or "same power".

    Raises:
        InputError: a key is missing, unknown or of the wrong shape, a frame does not follow the beam, or a section
            cannot be used.
    """
    data = _content(assembly if isinstance(assembly, Mapping) else file_path("assembly", assembly))
    unknown = sorted(set(data) - set(KEYS))
    if unknown:
        raise InputError(Fault(unknown[0], "", "no such key", f"the keys are {', '.join(KEYS)}"))
    points = _array(data, "points", (-1, 3))
    count = len(points) - 1
    if count < 1:
        raise InputError(
            Fault("points", f"{len(points)} points", "an element has two ends", "give at least two")
        )
    stiffness, mass = _matrices(data, count)
    mu = _per_element(data, "damping", (6,), count) if "damping" in data else np.zeros((count, 6))
    frames = (
        _per_element(data, "frames", (3, 3), count) if "frames" in data else np.tile(np.eye(3), (count, 1, 1))
    )
    curve = ReferenceLine(points, np.zeros(count + 1)).centreline()
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    ends = np.cumsum(lengths) * (curve.length / lengths.sum())
    d1 = tuple(frames[0][:, 1].tolist())
    middles = ends - lengths / 2.0 * (curve.length / lengths.sum())
    _, natural = curve.frames(middles, d1)
    pieces = []
    for k in range(count):
        turn = section_turn(frames[k], natural[k], k)
        times = six_times(from_axial_first(mu[k]), f"damping[{k}]")
        try:
            section = _section(stiffness[k], mass[k], times, turn, law)
        except InputError as error:
            raise InputError([problem.within(f"element {k + 1}") for problem in error.problems]) from None
        pieces.append((float(ends[k]) if k < count - 1 else curve.length, section))
    profile = pieces[0][1] if count == 1 else Piecewise(pieces)
    return Rod(curve, profile, d1=d1)


def _matrices(data: Mapping[str, Any], count: int) -> tuple[Floats, Floats]:
    """Return stiffness and inertia of the elements ``(n, 6, 6)``, in their axes, the axial direction first."""
    if ("stiffness" in data) == ("compliance" in data):
        why = "exactly one of stiffness and compliance is needed"
        raise InputError(Fault("stiffness", "", why, "give one 6x6 matrix, or one per element"))
    key = "compliance" if "compliance" in data else "stiffness"
    stiffness = _per_element(data, key, (6, 6), count)
    if key == "compliance":
        stiffness = np.array([_inverse(c) for c in stiffness])
    mass = _per_element(data, "mass", (6, 6), count)
    for name, arrays in ((key, stiffness), ("mass", mass)):
        for k, array in enumerate(arrays):
            _refuse_skew(name, k, array)
    return stiffness, mass


def _section(stiffness: Floats, mass: Floats, times: Floats, turn: Floats, law: Law) -> StiffnessSection:
    """Return the section of one element in the axes of the rod.

    Args:
        stiffness, mass: in axes of the element, the axial direction first; times: six retardation times [s].
        turn: 6 x 6, from axes of the element to those of the rod.
    """
    own = from_axial_first(stiffness)
    # mu belongs to the element's own axes: D is formed there
    damping = symmetric_damping(own, times) if law == "symmetric" else product_damping(own, times)
    elastic, inertia, viscous = (turn @ m @ turn.T for m in (own, from_axial_first(mass), damping))
    return StiffnessSection(symmetric_part(elastic), symmetric_part(inertia), symmetric_part(viscous))


@checked_with(rod=of_class(Rod), elements=number_of_parts)
def gxbeam_from_rod(rod: Rod, elements: int) -> dict[str, Any]:
    """Return a rod as a GXBeam-style beam of straight elements of equal length, as plain lists.

    The matrices are those at the middle of each element, in the rod's section axes; mu_i = D_ii/C_ii.

    Raises:
        InputError: the rod has Maxwell branches.
    """
    ends, middles = (
        np.linspace(0.0, rod.length, elements + 1),
        (np.arange(elements) + 0.5) * rod.length / elements,
    )
    refuse_own_laws(rod, middles)
    points, _ = rod.frames(ends)
    _, axes = rod.frames(middles)
    matrices = [rod.matrices_at(float(s)) for s in middles]
    return {
        "points": points.tolist(),
        "stiffness": [to_axial_first(c).tolist() for c, _, _ in matrices],
        "mass": [to_axial_first(m).tolist() for _, _, m in matrices],
        "damping": [to_axial_first(component_times(c, d)).tolist() for c, d, _ in matrices],
        "frames": [frame[:, [2, 0, 1]].tolist() for frame in axes],
    }


def section_turn(frame: Floats, natural: Floats, element: int) -> Floats:
    """Return the rotation of section vectors (6, 6) from an element's axes (x along it first) to the rod's."""
    if not np.allclose(frame.T @ frame, np.eye(3), atol=1e-6) or np.linalg.det(frame) < 0.0:
        raise InputError(
            Fault(
                f"frames[{element}]",
                "",
                "this is not a rotation matrix",
                "give three orthonormal, right-handed columns: the element's x, y and z axes",
            )
        )
    off = math.acos(min(1.0, max(-1.0, float(frame[:, 0] @ natural[:, 2]))))
    if off > _ALIGNED:
        raise InputError(
            Fault(
                f"frames[{element}]",
                f"{math.degrees(off):.3g} degrees off the beam",
                "the first column is the element's x axis, along the beam (without frames it is the global x)",
                "give frames that follow the points",
            )
        )
    angle = math.atan2(float(frame[:, 1] @ natural[:, 1]), float(frame[:, 1] @ natural[:, 0]))
    c, s = math.cos(angle), math.sin(angle)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.kron(np.eye(2), rotation)


def _refuse_skew(key: str, element: int, matrix: Floats) -> None:
    if (skew := skew_entry(matrix)) is not None:
        i, j = skew
        raise InputError(
            Fault(
                f"{key} of element {element + 1}",
                f"{float(matrix[i, j])!r} against {float(matrix[j, i])!r} in rows {i + 1} and {j + 1}",
                "the matrix must be symmetric",
                "give the same number twice",
            )
        )


def _inverse(compliance: Floats) -> Floats:
    """Return the stiffness of a compliance."""
    try:
        return np.asarray(np.linalg.inv(compliance))
    except np.linalg.LinAlgError:
        raise InputError(
            Fault(
                "compliance",
                "",
                "it has no inverse: a strain without compliance",
                "give a small compliance there, or the stiffness, and constraints in the rod",
            )
        ) from None


def _content(assembly: Mapping[str, Any] | str | Path) -> Mapping[str, Any]:
    if isinstance(assembly, Mapping):
        return assembly
    path = Path(assembly)
    try:
        text = path.read_text(encoding="utf-8")
        data = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    except OSError as error:
        raise InputError(
            Fault(str(path), "", f"the file cannot be read ({error.strerror})", "check the path")
        ) from None
    except ValueError as error:
        raise InputError(
            Fault(str(path), str(error), "this is neither TOML nor JSON (.json)", "correct the file")
        ) from None
    if not isinstance(data, dict):
        raise InputError(Fault(str(path), "", "a table of keys is needed", f"give {', '.join(KEYS)}"))
    return data


def _array(data: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> Floats:
    """Return the finite numbers of a key in a shape; -1 stands for any size."""
    if key not in data:
        raise InputError(Fault(key, "", "this key is required and missing", f"add {key}"))
    try:
        array = np.array(data[key], dtype=np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    fits = array.ndim == len(shape) and all(
        want in (have, -1) for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits or not np.isfinite(array).all():
        wanted = " x ".join("n" if size == -1 else str(size) for size in shape)
        raise InputError(
            Fault(key, f"an array of the shape {array.shape}", f"{wanted} numbers are needed", "correct it")
        )
    return array


def _per_element(data: Mapping[str, Any], key: str, shape: tuple[int, ...], count: int) -> Floats:
    """Return one array per element (count, *shape), from one for all or a list."""
    if key in data and np.ndim(data[key]) == len(shape):
        return np.repeat(_array(data, key, shape)[None], count, axis=0)
    array = _array(data, key, (-1, *shape))
    if len(array) != count:
        raise InputError(
            Fault(key, f"{len(array)} items", f"there are {count} elements", f"give {count}, or one for all")
        )
    return array

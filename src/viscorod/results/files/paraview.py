"""Results for ParaView: one file of polylines for every state, and a collection that knows the times.

The files are VTK XML (``.vtp``, written by the VTK library through pyvista), the collection is ParaView's ``.pvd``.
Arrays of six components would be taken for symmetric tensors, so strains and section forces come as two vectors each.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from viscorod.errors import InputError
from viscorod.results.element_points import Stencil
from viscorod.results.files.section_surfaces import Surfaces
from viscorod.results.probe import fields_at, instants_of
from viscorod.results.result_places import ResultPlace
from viscorod.results.run import Run
from viscorod.typing import Floats, Integers
from viscorod.whole_files import replacing, system_errors

if TYPE_CHECKING:
    import pyvista

    from viscorod.results.result import Result

_SEGMENTS = 2  # drawn per order of an element
_BLOCK = 64  # states that are read at once

_COMPONENTS = {
    "strain_shear_stretch": ("shear_1", "shear_2", "stretch"),
    "strain_bend_twist": ("bend_1", "bend_2", "twist"),
    "section_force": ("shear_1", "shear_2", "normal"),
    "section_moment": ("bend_1", "bend_2", "torque"),
    "angular_velocity": ("1", "2", "3"),
}


def write_paraview(
    result: Result, folder: str | Path, times: Floats | None = None, *, sections: bool = False
) -> Path:
    """Write a result for ParaView.

    Rods are polylines with their radius, directors ``d1, d2, d3``, velocity, angular velocity (body axes), strains,
    section force and moment (body axes, and global ones), dissipation, and the number of the rod; bodies and their
    named points are points with ``d1, d2, d3`` and velocities. SI units; names of rods and bodies are field data.

    Args:
        result: a run, an equilibrium (load factors, or numbers along a path, become times) or a steady rotation.
        folder: is made; files of this name in it are replaced.
        times: of a run [s]; all stored ones by default.
        sections: also write the surfaces of rods with their true sections, with axial and von Mises stress.

    Returns:
        The collection ``run.pvd`` to open.

    Raises:
        InputError: pyvista is missing, a time lies outside the run, or the folder cannot be written.
    """
    pv = _pyvista()
    folder = Path(folder)
    sites, counts, radius = _rod_points(result)
    names = {"rod": list(result.sites.rods), "body": list(result.sites.bodies)}
    on_bodies = [result.sites.at(body) for body in names["body"]]
    count = len(_levels(result)) if times is None else int(np.size(times))
    digits = max(4, len(str(count - 1)))
    surfaces = Surfaces(result, sites) if sections else None
    collection = ElementTree.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    datasets = ElementTree.SubElement(collection, "Collection")
    with system_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for number, (level, *kinds) in enumerate(_states(result, sites, on_bodies, times, surfaces)):
            for part, (kind, fields) in enumerate(zip(("rod", "body", "section"), kinds, strict=True)):
                if not fields:
                    continue
                if kind == "section":
                    assert surfaces is not None
                    mesh = _surface(pv, fields, surfaces)
                else:
                    mesh = _lines(pv, fields, counts) if kind == "rod" else _points(pv, fields)
                if kind == "rod":
                    mesh.point_data["radius"] = radius
                mesh.field_data[f"{kind}_names"] = names["body" if kind == "body" else "rod"]
                mesh.field_data["TimeValue"] = [level]
                target = f"{kind}s_{number:0{digits}d}.vtp"
                _save(mesh, folder / target)
                entry = {"timestep": repr(level), "group": "", "part": str(part), "file": target}
                ElementTree.SubElement(datasets, "DataSet", entry)
    ElementTree.indent(collection)
    path = folder / "run.pvd"
    with replacing(path) as new:
        ElementTree.ElementTree(collection).write(new, encoding="utf-8", xml_declaration=True)
    return path


def _save(mesh: pyvista.PolyData, path: Path) -> None:
    """Write a file; VTK makes its text only, since it ends the process where the disk is full."""
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(mesh)
    writer.SetDataModeToBinary()
    writer.SetWriteToOutputString(True)
    writer.Write()
    with replacing(path) as new:
        new.write_text(writer.GetOutputString(), encoding="utf-8")


def _pyvista() -> Any:
    try:
        import pyvista
    except ModuleNotFoundError:
        raise InputError(
            "files for ParaView need the package pyvista, which is not installed; type: pip install 'viscorod[vtk]'"
        ) from None
    return pyvista


def _rod_points(result: Result) -> tuple[list[ResultPlace], Integers, Floats]:
    """Return places of all rods, rod by rod, their number on each, and the radius at each [m]."""
    data = result.data
    arc = np.asarray(data["station_s"].values, dtype=float)
    orders = np.asarray(data["station_order"].values, dtype=int)
    sites, counts = [], []
    for rod in result.sites.rods:
        stations = result.sites.stations(rod)
        p = int(orders[stations[0]])
        ends = arc[stations][::p]
        pieces = _SEGMENTS * p
        s = np.interp(np.arange(pieces * (ends.size - 1) + 1) / pieces, np.arange(ends.size), ends)
        sites += [result.sites.along(rod, float(value)) for value in s]
        counts.append(s.size)
    radius = np.zeros(len(sites))
    if "half_width" in data:
        stencil = Stencil.of(data, result.sites, sites)
        width = np.asarray(data["half_width"].values, dtype=float)[stencil.points]
        for group in stencil.groups:
            radius[group.places] = group.through_gauss_points(width[group.gauss, None])[:, 0]
    return sites, np.array(counts), np.maximum(radius, 0.0)


def _levels(result: Result) -> Floats:
    levels = np.asarray(result.data[result.dimension].values, dtype=float)
    return levels if np.all(np.diff(levels) > 0.0) else np.arange(float(levels.size))


def _states(
    result: Result,
    sites: list[ResultPlace],
    on_bodies: list[ResultPlace],
    times: Floats | None,
    surfaces: Surfaces | None,
) -> Iterator[tuple[float, dict[str, Floats], dict[str, Floats], dict[str, Floats]]]:
    """Yield the level (time or load factor) of every state and the fields of rods, bodies and surfaces there."""
    levels = _levels(result) if times is None else np.atleast_1d(np.asarray(times, dtype=float))
    step = _BLOCK if isinstance(result, Run) else len(levels)
    for first in range(0, len(levels), step):
        part = levels[first : first + step]
        instants = instants_of(result, part) if isinstance(result, Run) else None
        rods = fields_at(result, sites, instants)
        bodies = fields_at(result, on_bodies, instants) if on_bodies else {}
        around: dict[str, Floats] = {}
        if surfaces is not None and surfaces.quads.size:
            around = surfaces.fields(rods["position"], rods["frame"], instants)
        for k, level in enumerate(part.tolist()):
            here = [{name: field[k] for name, field in of.items()} for of in (rods, bodies, around)]
            yield level, here[0], here[1], here[2]


def _lines(pv: Any, fields: dict[str, Floats], counts: Integers) -> pyvista.PolyData:
    """Return polylines with all fields of rods."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    lines = np.concatenate(
        [np.concatenate([[n], first + np.arange(n)]) for first, n in zip(starts, counts, strict=True)]
    )
    mesh: pyvista.PolyData = pv.PolyData(np.ascontiguousarray(fields["position"]), lines=lines)
    numbers = np.repeat(np.arange(counts.size), counts)
    mesh.point_data["rod"] = numbers
    mesh.cell_data["rod"] = np.arange(counts.size)
    _common(mesh, fields)
    if "strain" in fields:
        _vector(mesh, "strain_shear_stretch", fields["strain"][:, :3])
        _vector(mesh, "strain_bend_twist", fields["strain"][:, 3:])
    if "section_force" in fields:
        force, moment = fields["section_force"][:, :3], fields["section_force"][:, 3:]
        for name, values in (("section_force", force), ("section_moment", moment)):
            _vector(mesh, name, values)
            _vector(mesh, f"{name}_global", np.einsum("nij,nj->ni", fields["frame"], values))
    if "dissipation" in fields:
        mesh.point_data["dissipation"] = fields["dissipation"]
    return mesh


def _surface(pv: Any, fields: dict[str, Floats], surfaces: Surfaces) -> pyvista.PolyData:
    """Return the surfaces of rods with stresses."""
    faces = np.insert(surfaces.quads, 0, 4, axis=1).ravel()
    mesh: pyvista.PolyData = pv.PolyData(np.ascontiguousarray(fields["position"]), faces=faces)
    mesh.point_data["rod"] = surfaces.rod
    for name in ("stress_33", "von_mises"):
        mesh.point_data[name] = fields[name]
    return mesh


def _points(pv: Any, fields: dict[str, Floats]) -> pyvista.PolyData:
    """Return points with all fields of bodies."""
    mesh: pyvista.PolyData = pv.PolyData(np.ascontiguousarray(fields["position"]))
    mesh.point_data["body"] = np.arange(len(fields["position"]))
    _common(mesh, fields)
    return mesh


def _common(mesh: pyvista.PolyData, fields: dict[str, Floats]) -> None:
    for k in range(3):
        _vector(mesh, f"d{k + 1}", fields["frame"][:, :, k])
    for name in ("displacement", "velocity", "angular_velocity"):
        if name in fields:
            _vector(mesh, name, fields[name])


def _vector(mesh: pyvista.PolyData, name: str, values: Floats) -> None:
    mesh.point_data[name] = np.ascontiguousarray(values)
    array = mesh.GetPointData().GetArray(name)
    for k, word in enumerate(_COMPONENTS.get(name, tuple("XYZ"))):
        array.SetComponentName(k, word)

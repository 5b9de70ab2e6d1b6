"""Results for ParaView: one VTKHDF file with the polylines, points and surfaces of every state.

The layout is that of VTKHDF 2.2 (https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format): a data set of
blocks "rods", "bodies" and "sections", each PolyData with steps. What does not change with time, the connectivity
and numbers, is there once. Arrays of six components would be taken for symmetric tensors, so strains and section forces
come as two vectors each.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.results.element_points import Stencil
from viscorod.results.files.hdf5_output import Hdf5Output, hdf5_output, uninterrupted
from viscorod.results.files.section_surfaces import Surfaces
from viscorod.results.probe import fields_at, instants_of
from viscorod.results.result_places import ResultPlace
from viscorod.results.run import Run
from viscorod.typing import Floats, Integers
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    import h5py

    from viscorod.results.result import Result

__all__ = ["SUFFIX", "write_paraview"]

SUFFIX = ".vtkhdf"
_VERSION = (2, 2)
_SEGMENTS = 2  # drawn per order of an element
_BLOCK = 64  # states that are read at once
_KINDS = ("Vertices", "Lines", "Polygons", "Strips")
_FILTER = {"compression": "gzip", "compression_opts": 4, "shuffle": True}

Fields = dict[str, Floats]


class _Block(NamedTuple):
    """A block of the collection.

    Attributes:
        kind: of its cells; sizes: points of each cell ``(cells,)``; connectivity: points of all cells.
        names: of its parts; constant: arrays of points that do not change.
    """

    kind: str
    sizes: Integers
    connectivity: Integers
    names: list[str]
    constant: dict[str, np.ndarray]


def write_paraview(
    result: Result, path: str | Path, times: Floats | None = None, *, sections: bool = False
) -> Path:
    """Write a result for ParaView.

    Rods are polylines with their radius, directors ``d1, d2, d3``, velocity, angular velocity (body axes), strains,
    section force and moment (body axes, and global ones), dissipation, and the number of the rod; bodies and their
    named points are points with ``d1, d2, d3`` and velocities. SI units; their names are the attribute ``names`` of the
    groups of the file.

    Args:
        result: a run, an equilibrium (load factors, or numbers along a path, become times) or a steady rotation.
        path: of the file, which ends with .vtkhdf.
        times: of a run [s]; all stored ones by default.
        sections: also write the surfaces of rods with their true sections, with axial and von Mises stress.

    Returns:
        The path.

    Raises:
        InputError: another suffix, a time lies outside the run, or the file cannot be written.
    """
    path = Path(path)
    if path.suffix != SUFFIX:
        raise InputError(
            Fault(
                "path", str(path), "files for ParaView end with .vtkhdf", f"give {path.stem or 'run'}{SUFFIX}"
            )
        )
    levels = _levels(result) if times is None else np.atleast_1d(np.asarray(times, dtype=float))
    with replacing(path) as new, hdf5_output(new) as output:
        write = partial(_write, output, result, levels, sections)
        uninterrupted(write, output.abandon)
    return path


def _write(output: Hdf5Output, result: Result, levels: Floats, sections: bool) -> None:
    """Write all blocks, some states at once."""
    import h5py

    sites, counts, radius = _rod_points(result)
    bodies = list(result.sites.bodies)
    on_bodies = [result.sites.at(body) for body in bodies]
    surfaces = Surfaces(result, sites) if sections else None
    blocks = {
        "rods": _Block(
            "Lines",
            counts,
            np.arange(counts.sum()),
            list(result.sites.rods),
            {"radius": radius, "rod": np.repeat(np.arange(counts.size), counts)},
        )
    }
    if bodies:
        number = np.arange(len(bodies))
        blocks["bodies"] = _Block("Vertices", np.ones_like(number), number, bodies, {"body": number})
    if surfaces is not None and surfaces.quads.size:
        quads = surfaces.quads
        blocks["sections"] = _Block(
            "Polygons", np.full(len(quads), 4), quads.ravel(), list(result.sites.rods), {"rod": surfaces.rod}
        )
    with h5py.File(output, "w", libver=("v110", "latest"), track_order=True) as file:
        root = file.create_group("VTKHDF", track_order=True)
        _typed(root, "MultiBlockDataSet")
        assembly = root.create_group("Assembly", track_order=True)
        parts = {}
        for index, (name, block) in enumerate(blocks.items()):
            parts[name] = _Part(root.create_group(name, track_order=True), block, levels)
            parts[name].group.attrs["Index"] = index
            assembly[name] = h5py.SoftLink(f"/VTKHDF/{name}")
        for first, *states in _states(result, sites, on_bodies, levels, surfaces):
            for name, fields in zip(("rods", "bodies", "sections"), states, strict=True):
                if name in parts:
                    parts[name].write(first, fields)
                    output.require_written()


def _typed(group: h5py.Group, kind: str) -> None:
    """Say of what kind a group is."""
    group.attrs["Version"] = _VERSION
    group.attrs.create("Type", np.bytes_(kind))


class _Part:
    """The group of a block: PolyData whose points and fields change from step to step."""

    def __init__(self, group: h5py.Group, block: _Block, levels: Floats) -> None:
        self.group, self.steps, self.points = group, len(levels), len(next(iter(block.constant.values())))
        _typed(group, "PolyData")
        group["NumberOfPoints"] = np.full(self.steps, self.points, dtype=np.int64)
        for kind in _KINDS:
            own = kind == block.kind
            sizes = block.sizes if own else np.zeros(0, dtype=np.int64)
            cells = group.create_group(kind)
            cells["NumberOfCells"] = np.full(self.steps, len(sizes), dtype=np.int64)
            cells["NumberOfConnectivityIds"] = np.full(self.steps, sizes.sum(), dtype=np.int64)
            cells["Offsets"] = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
            cells["Connectivity"] = (block.connectivity if own else np.zeros(0)).astype(np.int64)
        self.data = group.create_group("PointData")
        group.attrs["names"] = block.names
        steps = group.create_group("Steps")
        steps.attrs["NSteps"] = self.steps
        nothing, each = np.zeros(self.steps, dtype=np.int64), np.arange(self.steps, dtype=np.int64)
        steps["Values"] = levels
        steps["NumberOfParts"] = nothing + 1
        steps["PartOffsets"] = nothing
        steps["PointOffsets"] = each * self.points
        steps["CellOffsets"] = np.zeros((self.steps, len(_KINDS)), dtype=np.int64)
        steps["ConnectivityIdOffsets"] = np.zeros((self.steps, len(_KINDS)), dtype=np.int64)
        self.offsets = steps.create_group("PointDataOffsets")
        for name, values in block.constant.items():
            self.data[name] = values
            self.offsets[name] = nothing
        self._where: dict[str, h5py.Dataset] = {}

    def write(self, first: int, fields: Fields) -> None:
        """Write some states from the number ``first`` on, arrays ``(states, points, ...)``."""
        for name, values in _shown(fields).items():
            if name not in self._where:
                self._where[name] = self._created(name, values.shape[2:])
            rows = values.reshape(-1, *values.shape[2:])
            begin = first * self.points
            self._where[name][begin : begin + len(rows)] = rows

    def _created(self, name: str, shape: tuple[int, ...]) -> h5py.Dataset:
        """Return the new array of all states of a field, in pieces of whole states."""
        rows = self.steps * self.points
        piece = max(1, min(self.points * max(1, 8192 // max(self.points, 1)), rows))
        home = self.group if name == "Points" else self.data
        if home is self.data:
            self.offsets[name] = np.arange(self.steps, dtype=np.int64) * self.points
        made: h5py.Dataset = home.create_dataset(
            name,
            (rows, *shape),
            dtype=np.float64,
            chunks=(piece, *shape),
            **_FILTER,
        )
        return made


def _shown(fields: Fields) -> Fields:
    """Return the arrays of a block by their names in ParaView, ``(states, points)`` or ``(states, points, 3)``."""
    found = {"Points": fields["position"]}
    if "frame" in fields:
        found |= {f"d{k + 1}": fields["frame"][..., k] for k in range(3)}
    found |= {
        name: fields[name]
        for name in (
            *("displacement", "velocity", "angular_velocity"),
            *("dissipation", "stress_33", "von_mises"),
        )
        if name in fields
    }
    if "strain" in fields:
        found["strain_shear_stretch"] = fields["strain"][..., :3]
        found["strain_bend_twist"] = fields["strain"][..., 3:]
    if "section_force" in fields:
        force, moment = fields["section_force"][..., :3], fields["section_force"][..., 3:]
        for name, values in (("section_force", force), ("section_moment", moment)):
            found[name] = values
            found[f"{name}_global"] = np.einsum("tnij,tnj->tni", fields["frame"], values)
    return found


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
    levels: Floats,
    surfaces: Surfaces | None,
) -> Iterator[tuple[int, Fields, Fields, Fields]]:
    """Yield the number of the first of some states, and the fields of rods, bodies and surfaces there."""
    step = _BLOCK if isinstance(result, Run) else len(levels)
    for first in range(0, len(levels), step):
        instants = instants_of(result, levels[first : first + step]) if isinstance(result, Run) else None
        rods = fields_at(result, sites, instants)
        bodies = fields_at(result, on_bodies, instants) if on_bodies else {}
        around: Fields = {}
        if surfaces is not None and surfaces.quads.size:
            around = surfaces.fields(rods["position"], rods["frame"], instants)
        yield first, rods, bodies, around

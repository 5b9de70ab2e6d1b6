"""From a result to the page: choose frames, collect what is drawn, keep the file small."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.checks import checked
from viscorod.errors import Fault, InputError
from viscorod.pictures.described_model import described
from viscorod.pictures.drawing.load_arrows import gravity
from viscorod.pictures.viewer.beside import Beside, Others
from viscorod.pictures.viewer.camera import first_look
from viscorod.pictures.viewer.coloured_fields import fields_of, points_of, speed_of
from viscorod.pictures.viewer.colours import colour_tables
from viscorod.pictures.viewer.curve_pages import curves_of
from viscorod.pictures.viewer.frames import Frames
from viscorod.pictures.viewer.histories import decay_of, energy_of, histories_of, places_of, samples_of
from viscorod.pictures.viewer.marks import Marks
from viscorod.pictures.viewer.mode_film import Film, film_of
from viscorod.pictures.viewer.moving_arrows import loads_of, tips_of
from viscorod.pictures.viewer.packing import LEVELS, Pack
from viscorod.pictures.viewer.page import heading_of, page
from viscorod.pictures.viewer.rod_lines import MOST_NODES, Line, lines_of
from viscorod.pictures.viewer.symbols import bodies_of, connections_of, supports_of
from viscorod.results.buckling import Buckling
from viscorod.results.data_schema import AXES
from viscorod.results.element_points import aligned
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.modes_result import Modes
from viscorod.results.result import Result
from viscorod.results.result_warnings import warnings_of
from viscorod.results.run import Run
from viscorod.results.stateless_result import StatelessResult
from viscorod.results.steady_result import Steady
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats
from viscorod.whole_files import page_path, replacing
from viscorod.wording import show

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription
    from viscorod.results.any_result import AnyResult
    from viscorod.results.sweep_result import Sweep

__all__ = ["FRAMES", "MEGABYTES", "view"]

FRAMES = 1500
"""Frames of a page by default."""
MEGABYTES = 12.0
"""Size of a page by default at most; a model that is too large is shown with fewer frames."""
_FEWEST = 2
_TRIES = 6


@checked
def view(
    result: AnyResult | Sweep,
    path: str | Path,
    *,
    frames: int = FRAMES,
    megabytes: float = MEGABYTES,
    beside: Others = (),
) -> Path:
    """Write a result as one HTML file that shows it moving; it needs no server and no network.

    Beside the rods in space, coloured by a strain, a section force, the dissipation or the speed, are histories, the
    energy account and the damping ratio of every cycle, all at the same time. Modes, those of a steady rotation, and
    the shapes in which a model gives way at its critical loads swing one at a time beside a table of them. Campbell
    diagrams, stability along a load, periodic motions and frequency responses are charts: a place that is chosen on
    their curves is shown in numbers, of periodic motions with its cycle, its loop and its Floquet multipliers.

    Args:
        result: any but a sweep.
        path: file to write, ``.html``; its folder is made.
        frames: states in the page at most, 2 or more; more stored ones are shown at even times, of fewer
            positions in between follow from velocities. Of curves: places along them at most.
        megabytes: size of the file at most; if it would be larger, there are fewer frames.
        beside: of a motion: other motions, whose rods and histories are shown beside its own, as before and after a
            change; and records of measured displacements or velocities along x, y or z. A list, or a table by the
            names that they shall have in the page, such as ``{"before": run}``.

    Returns:
        The path.

    Raises:
        InputError: the result is of another kind, a number is out of range, the file is no ``.html``, or it
            cannot be written.
    """
    if not isinstance(result, Run | Equilibrium | Modes | Steady | Buckling | StatelessResult):
        instead = "give what an analysis returns, or viscorod.load of a file"
        if type(result).__name__ == "Sweep":
            instead = "give one of its members"
        elif isinstance(result, list | tuple | dict):
            instead = "give one motion, and the others as beside = [...]"
        raise InputError(Fault("result", show(result), "this has no page", instead))
    path = page_path(path)
    if isinstance(frames, bool) or not isinstance(frames, int) or frames < _FEWEST:
        raise InputError(f"frames = {frames!r}: give a whole number of 2 or more")
    if not megabytes > 1.0:
        raise InputError(f"megabytes = {megabytes!r}: the scripts alone take 0.7; give a number above 1")
    if beside and not isinstance(result, Run):
        raise InputError("beside: only motions over time have others beside them; give a run")
    text, limit, film = "", frames, None
    if isinstance(result, Modes | Steady | Buckling):
        film = film_of(result)
        limit = int(film.states.data.sizes[film.states.dimension])  # each swing is whole
    for _ in range(_TRIES):
        if isinstance(result, StatelessResult):
            text = curves_of(result, limit)
        elif film is not None:
            text = _text(film.states, limit, film, ())
        else:
            assert isinstance(result, Run | Equilibrium)
            text = _text(result, limit, None, beside)
        size = len(text.encode("utf-8")) / 1e6
        if size <= megabytes or limit <= _FEWEST or film is not None:
            break
        # what does not depend on the frames is a megabyte or less
        limit = max(_FEWEST, int(0.95 * limit * max(megabytes - 1.0, 0.1) / max(size - 1.0, 0.1)))
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8")
    return path


def _text(result: Run | Equilibrium, limit: int, film: Film | None, others: Others) -> str:
    modes = [] if film is None else film.told
    model = described(result)
    frames, pack = Frames.of(result, limit), Pack()
    positions, rotations = frames.positions(), frames.rotations()
    lines = lines_of(result, model)
    marks = Marks(result, positions, rotations)
    scene: dict[str, Any] = {
        "supports": supports_of(result, model, marks),
        "bodies": bodies_of(result, model, marks),
        "connections": connections_of(result, model, marks),
        "loads": [],
        "places": [{"label": site.label, "mark": marks.site(site)} for site in places_of(result)],
    }
    sizes = np.zeros((frames.count, 0))
    if model is not None and not modes:
        scene["loads"], sizes = loads_of(result, model, frames, marks)
    pack.plain("load_sizes", sizes)
    pack.plain("instants", frames.instants)
    pack.plain("numbers", frames.before + frames.part)
    _pack_lines(result, lines, positions, rotations, pack)
    pack.quantised("marks", marks.points, 3)
    pack.quantised("turns", marks.turns)
    fields = _pack_fields(result, frames, lines, pack)
    samples = samples_of(result)
    beside = Beside(result, samples, others)
    known = np.asarray(result.data[result.dimension].values, dtype=float)
    pack.plain("samples", known[samples])
    pack.whole("sample_numbers", samples)
    reference = np.asarray(result.data["reference_position"].values, dtype=float)
    meta = {
        "title": result.title,
        "heading": film.title.partition(";")[0]
        if film is not None and result.kind == "equilibrium"  # whose shapes swing about it
        else heading_of(result),
        "kind": result.kind,
        "dimension": result.dimension,
        "version": str(result.data.attrs.get("version", "")),
        "outcome": result.outcome,
        "warnings": warnings_of(result),
        "notes": _notes(result, frames, lines, samples.size, model, modes),
        "modes": modes,
        "film": {} if film is None else {"title": film.title, "head": film.head, "start": film.start},
        "stored": frames.stored,
        "clock": scaled("s", known) if result.dimension == "time" else (1.0, ""),
        "scene": scene,
        "lines": [
            {"rod": line.rod, "nodes": int(line.s.size), "rings": int(line.ring_s.size), "outline": line.outline,
             "known": bool(line.halves.any()),
             "contours": [[contour.tolist() for contour in region] for region in line.contours]}
            for line in lines
        ],
        "fields": fields,
        "colours": colour_tables(),
        "look": first_look(
            np.concatenate([positions, reference[None]]),
            np.zeros(3) if model is None else gravity(model),
            tips_of(scene["loads"], marks),
        ),
        "histories": histories_of(result, samples, pack, beside),
        "ghosts": beside.ghosts(frames, pack),
        "length": scaled("m", [line.s[-1] for line in lines]),
        "main": AXES.index(result.main_motion[1]),
        "energy": energy_of(result, samples, pack),
        "decay": decay_of(result),
    }  # fmt: skip
    return page(result.title, meta, pack)


def _pack_lines(result: Result, lines: list[Line], positions: Floats, rotations: Floats, pack: Pack) -> None:
    reference = np.asarray(result.data["reference_position"].values, dtype=float)[None]
    nothing = np.zeros((len(positions), 0, 4))  # of rigid bodies alone
    moved = [nothing[..., :3], *(line.nodes(positions) for line in lines)]
    pack.quantised("positions", np.concatenate(moved, axis=1), 3)
    turns = [nothing, *(aligned(line.nodes(rotations)) for line in lines)]
    pack.quantised("rotations", np.concatenate(turns, axis=1))
    pack.plain("reference", _joined([line.nodes(reference)[0] for line in lines], 3))
    pack.plain("ring_s", _joined([line.ring_s for line in lines]))
    pack.plain("halves", _joined([line.halves for line in lines], 2))
    pack.plain("holes", _joined([line.holes for line in lines]))
    start = np.cumsum([0, *(line.s.size for line in lines)])
    pack.whole("ring_first", _joined([line.ring_first + k for line, k in zip(lines, start, strict=False)]))
    width = max((line.ring_weights.shape[1] for line in lines), default=0)
    padded = [np.pad(line.ring_weights, ((0, 0), (0, width - line.ring_weights.shape[1]))) for line in lines]
    pack.plain("ring_weights", _joined(padded, width))
    pack.plain("node_s", _joined([line.s for line in lines]))


def _joined(parts: list[np.ndarray], *width: int) -> np.ndarray:
    """Return one array of those of all rods, which may be none; ``width`` is the rest of its shape."""
    return np.concatenate(parts) if parts else np.zeros((0, *width))


def _pack_fields(result: Result, frames: Frames, lines: list[Line], pack: Pack) -> list[dict[str, Any]]:
    """Put the fields into the page; returns how each is called and read."""
    found: list[dict[str, Any]] = []
    points = points_of(result, lines, MOST_NODES)
    if points is not None:
        pack.plain("point_s", points.s)
        pack.whole("point_line", points.line)
        if "half_width" in result.data:
            widths = np.asarray(result.data["half_width"].values, dtype=float)
            pack.plain("point_half_width", points.of(widths[None])[0])
        for field, values in fields_of(result, frames, points):
            pack.quantised(f"field_{field['key']}", values)
            found.append({**field, "at": "points"})
    speed = speed_of(result, frames, lines) if lines else None
    if speed is not None:
        pack.quantised("field_speed", speed)
        found.append({"key": "speed", "title": "speed", "unit": "m/s", "scale": 1.0, "at": "nodes"})
    return found


def _notes(
    result: Result,
    frames: Frames,
    lines: list[Line],
    samples: int,
    model: ModelDescription | None,
    modes: list[dict[str, Any]],
) -> list[str]:
    """Return what a reader should know of what was left out."""
    stations = int(sum(result.sites.stations(line.rod).size for line in lines))
    nodes = sum(line.s.size for line in lines)
    what = "times" if result.dimension == "time" else "states"
    notes = [f"{frames.count} frames shown of {frames.stored} stored {what}"]
    if frames.stored == 1:
        notes[0] = "one state"
    if frames.count > frames.stored:
        notes[0] = f"{frames.count} frames shown: {frames.stored} stored times and positions between them"
    if modes:
        notes[0] = f"{len(modes)} shapes, each with an amplitude that can be seen; fading is not shown"
    if nodes < stations:
        notes.append(f"{nodes} stations shown of {stations}")
    if samples < frames.stored:
        notes.append(f"charts: {samples} of {frames.stored} stored {what}, extremes kept")
    notes.append(f"positions and fields to 1/{LEVELS} of their range")
    if model is None:
        notes.append("the file does not describe the model: loads are not drawn, sections are drawn as tubes")
    return notes

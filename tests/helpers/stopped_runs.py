"""A short run, ways to stop it, and damage to what it leaves on disk."""

import functools
import itertools
import json
import multiprocessing
import os
import sys
import traceback

import viscorod as vr
from viscorod.results.files.journal_folder import FOLDER

TWINS = ("states.json", "states.twin.json", "layout.nc", "layout.twin.nc")
FILES = ("states.bin", *TWINS, "checkpoint.npz", "before.npz")
KINDS = ("missing", "empty", "cut", "flip", "zeros", "other", "longer")
GIVEN = {"duration": 0.24, "integrator": "midpoint", "time_step": 0.02, "output_interval": 0.008}


def swing():
    """A soft cantilever that is released."""
    model = vr.Model()
    C, _, M = vr.Rectangle(0.01, 0.01).matrices(vr.Material(1e6, poissons_ratio=0.3, density=1000.0))
    section = vr.StiffnessSection(C, M, damping=0.02 * C)
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=2, order=4))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0.01), until=0.0)
    return model


@functools.cache
def whole():
    """The run that is neither written nor stopped."""
    return swing().simulate(**GIVEN)


def differences(run):
    """Names of what is not, bit for bit, as in the whole run."""
    expected = whole().data
    found = set(expected.variables.keys() ^ run.data.variables.keys())
    for name, variable in expected.variables.items():
        values = run.data[name].values
        if values.shape != variable.shape or not (values == variable.values).all():
            found.add(name)
    counts = ("steps", "iterations", "rejected", "outcome", "mesh_error")
    return found | {name for name in counts if run.data.attrs.get(name) != expected.attrs.get(name)}


def stopped(folder, after=12):
    """Stop the run after so many steps; return the folder of its journal."""
    count = itertools.count(1)
    try:
        swing().simulate(**GIVEN, folder=folder, stop=lambda: "enough" if next(count) >= after else "")
    except vr.SolveError:
        return folder / FOLDER
    raise AssertionError("it was not stopped")


def damage(path, kind, place, size):
    """Damage a file: ``place`` from 0 to 1, ``size`` in bytes (of a flip: in bits)."""
    content = bytearray(path.read_bytes())
    begin = min(int(place * len(content)), len(content) - 1)
    end = min(begin + size, len(content))
    if kind == "missing":
        path.unlink()
        return
    if kind == "empty":
        content = b""
    elif kind == "cut":
        content = content[:begin]
    elif kind == "flip":
        content[begin] ^= 1 << size % 8
    elif kind == "zeros":
        content[begin:end] = bytes(end - begin)
    elif kind == "other":
        content[begin:end] = bytes((byte * 7 + 13) % 256 for byte in content[begin:end])
    elif kind == "longer":
        content += b"\1" * size
    path.write_bytes(content)


class Interrupt:
    """Raises KeyboardInterrupt in the n-th line of viscorod's own code about runs and files."""

    PARTS = tuple(
        os.path.join("viscorod", *part.split("/"))
        for part in ("results/files/", "whole_files", "solve/history", "analyses/motion", "analyses/refinement",
                     "solve/transient/transient_solver")
    )  # fmt: skip

    def __init__(self, number):
        self.number, self.count = number, 0

    def __enter__(self):
        sys.settrace(self._call)
        return self

    def __exit__(self, *_):
        sys.settrace(None)

    def _call(self, frame, event, argument):
        return self._line if _inside(frame.f_code.co_filename) else None

    def _line(self, frame, event, argument):
        self.count += 1
        if self.count == self.number:
            raise KeyboardInterrupt
        return self._line


@functools.cache  # asked at every call of a traced run
def _inside(source):
    return any(part in source for part in Interrupt.PARTS)


def gone_on(folder):
    """The run in a folder that was interrupted somewhere: gone on, complete, or begun anew where nothing is there."""
    from viscorod.results.files.journal_folder import holds_run

    if holds_run(folder / FOLDER):
        return swing().simulate(**GIVEN, folder=folder, resume=True)
    if (folder / "run.nc").is_file():
        return vr.load(folder)
    return swing().simulate(**GIVEN, folder=folder)


def in_child(work, *arguments):
    """Do something in a forked process, which has to end in order; return what it returned, as JSON can hold it."""
    context = multiprocessing.get_context("fork")
    mine, theirs = context.Pipe(duplex=False)

    def report():
        try:
            answer = {"result": work(*arguments)}
        except BaseException:
            answer = {"error": traceback.format_exc()}
        theirs.send(json.dumps(answer))

    child = context.Process(target=report)
    child.start()
    theirs.close()
    try:
        answer = json.loads(mine.recv())
    except EOFError:
        answer = {"error": "it ended without a word"}
    child.join()
    assert child.exitcode == 0, f"the process ended with {child.exitcode}; {answer}"
    assert "error" not in answer, answer["error"]
    return answer["result"]

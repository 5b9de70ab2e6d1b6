"""A large sweep with its whole results: one zarr store with a dimension ``member``, and its table beside the arrays.

Results are written block by block, by workers where there are any, each of which reads what it writes from disk; the
client lays the store out and writes the table. Pieces of the arrays hold a block of members each, with a checksum.
Results that differ from the first one in more than numbers, and those of members that failed, are netCDF files in
``apart``.
"""

from __future__ import annotations

import json
import secrets
import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, wait
from pathlib import Path
from typing import TYPE_CHECKING

from viscorod.errors import InputError, let_interrupts_through
from viscorod.results.alike_members import differing
from viscorod.results.files.store_regions import TABLE, Region, RegionWork, begin, data_of, require_zarr
from viscorod.results.files.sweep_table import ATTRIBUTES, write_table
from viscorod.results.stacked_members import plain
from viscorod.whole_files import system_errors

if TYPE_CHECKING:
    from viscorod.results.sweep_result import Sweep

__all__ = ["write_store"]

BLOCK, MEMBERS = 6.4e7, 64
"""Bytes of the members that are written at once, and how many these are at most."""
FILES = 8
"""Results that become files of their own at once."""


def write_store(sweep: Sweep, path: str | Path, executor: Executor | None = None) -> Path:
    """Write a sweep with its whole results as a zarr store, which replaces ``path`` when it is whole.

    Args:
        sweep: whose results, if they are in the folder of the sweep, workers read by themselves.
        path: of the store.
        executor: whose workers write it, but for its table; without it this process does.

    Raises:
        InputError: zarr or pyarrow are not installed, or the place cannot be written or holds something else.
    """
    require_zarr()
    path = Path(path).absolute()  # workers may be elsewhere
    if path.exists() and not (path / TABLE).is_file():
        raise InputError(f"{path} is there and is no store of a sweep; name another place")
    new = path.with_name(f"new-{secrets.token_hex(4)}.zarr")
    with system_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            _write(sweep, new, executor)
            _replace(path, new)
        except BaseException:
            shutil.rmtree(new, ignore_errors=True)
            raise
    return path


def _replace(path: Path, new: Path) -> None:
    """Put a folder in the place of another, if there is one; what comes between leaves the earlier one there."""
    if not path.exists():
        new.rename(path)
        return
    old = path.with_name(f"old-{new.name}")
    try:
        path.rename(old)
        new.rename(path)
    except BaseException:
        if old.exists() and not path.exists():
            old.rename(path)
        raise
    shutil.rmtree(old)


def _write(sweep: Sweep, folder: Path, executor: Executor | None) -> None:
    members = sweep.members
    unlike = differing(members)
    completed = members.found.completed()
    kept = members.found.with_results()
    stacked = [k for k in kept if completed[k] and k not in unlike]
    attributes: list[str | None] = [None] * len(members)
    work, regions = RegionWork(folder, (), {}), list[Region]()

    def region(numbers: Sequence[int], row: int | None) -> Region:
        return Region(tuple((k, members.stored(k)) for k in numbers), row)

    if stacked:
        first = data_of(members.stored(stacked[0]))
        size = max(1, min(MEMBERS, int(BLOCK // max(1, first.nbytes))))
        results = [first, *(data_of(members.stored(k)) for k in stacked[1:size])]
        work = RegionWork(folder, begin(folder, results, stacked, size), dict(first.attrs))
        for k, data in zip(stacked, results, strict=False):
            attributes[k] = work.changed(data)
        del results
        rows = range(size, len(stacked), size)
        regions += [region(stacked[row : row + size], row) for row in rows]
    apart = [k for k in kept if k in unlike or not completed[k]]
    regions += [region(apart[k : k + FILES], None) for k in range(0, len(apart), FILES)]
    for done, told in _spread(executor, work, regions):
        for (k, _), text in zip(done.members, told, strict=True):
            attributes[k] = text
    about = {
        "attributes": work.common,
        "stacked": stacked,
        "separate": next(iter(unlike.values()), ""),
    }
    write_table(sweep, folder / TABLE, {ATTRIBUTES: attributes}, json.loads(json.dumps(about, default=plain)))


def _spread(
    executor: Executor | None, work: RegionWork, regions: Sequence[Region]
) -> Iterator[tuple[Region, list[str]]]:
    """Have all regions written, by workers where that is possible; a region whose worker was lost is written here."""
    futures: dict[int, Future[list[str]]] = {}
    try:
        for k, region in enumerate(regions):
            if executor is not None and region.on_disk:
                try:
                    futures[k] = executor.submit(work, region)
                except RuntimeError:  # it broke, or was shut down
                    break
        for k, region in enumerate(regions):
            try:
                told = futures[k].result() if k in futures else work(region)
            except Exception as error:
                let_interrupts_through(error)
                if k not in futures:
                    raise
                told = work(region)
            yield region, told
    finally:
        for future in futures.values():
            future.cancel()
        wait(futures.values())

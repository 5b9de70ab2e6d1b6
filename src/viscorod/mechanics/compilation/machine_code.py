"""Where machine code of kernels lies: in a folder of this machine, and in wheels for one kind of processor.

Both hold the files that Numba writes. Those in a wheel (``make wheel``) were compiled for a processor that nearly all
machines of its kind contain; they are read where Numba has the version that wrote them and the processor can run them.
"""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding
import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.runtime.nrt import rtsys

__all__ = ["MAKES", "SHIPPED", "TARGET", "cache_folder", "kept", "shipped"]

SHIPPED = Path(__file__).parents[2] / "machine_code"
"""Machine code in a wheel; no other installation has this folder."""

MAKES = "VISCOROD_MAKES_MACHINE_CODE"
"""The folder that machine code for a wheel is written to, in the environment of the process that makes it."""

_MARK = re.compile(rb"^@(kernel|part|lane_kernel|loop|exact_part)$", re.MULTILINE)
_IMPORTED = re.compile(rb"^(?:from|import) viscorod\.([\w.]+)", re.MULTILINE)
"""What a module imports when it is imported, not within functions or for annotations alone."""

_config: Any = numba.config
_Cache: Any = FunctionCache
_Kind: Any = CompileResultCacheImpl


class Target(NamedTuple):
    """A processor that machine code in a wheel is made for.

    Attributes:
        name: that LLVM has for it.
        needs: abilities of a processor that runs the code, in LLVM's words.
    """

    name: str
    needs: tuple[str, ...]


_X86 = Target("x86-64-v3", ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"))
_ARM = Target("generic", ("neon",))
TARGET = {"x86_64": _X86, "amd64": _X86, "aarch64": _ARM, "arm64": _ARM}.get(platform.machine().lower())
"""The one of this kind of machine, None for those without."""


def _kernel_sources(package: Path) -> list[bytes]:
    """Return the sources that machine code depends on: modules with kernels, and what these import of the package."""
    sources = {
        path: path.read_bytes()
        for part_of in ("mechanics", "solve")
        for path in sorted((package / part_of).rglob("*.py"))
    }
    found: set[Path] = set()
    sought = {path for path, text in sources.items() if _MARK.search(text)}
    while sought:
        found |= sought
        names = {name.decode() for path in sought for name in _IMPORTED.findall(sources[path])}
        places = {package.joinpath(*name.split(".")) for name in names}
        files = {place.with_suffix(".py") for place in places} | {place / "__init__.py" for place in places}
        sought = (files & sources.keys()) - found
    return [sources[path] for path in sorted(found)]


@functools.lru_cache
def _content() -> str:
    """Return a number for exactly this version of all kernels.

    Kernels contain those that they call, so all are compiled again when the source of any has changed.
    """
    found = hashlib.sha1(usedforsecurity=False)
    for source in _kernel_sources(Path(__file__).parents[2]):
        found.update(source)
    return found.hexdigest()[:16]


@functools.lru_cache
def cache_folder() -> Path | None:
    """Return the folder of the machine code that is compiled here; None if none is writable.

    Folders of earlier versions are removed. It lies in Numba's cache folder if one is set, else in this package's.
    """
    if made := os.environ.get(MAKES):
        return Path(made)
    package = Path(__file__).parents[2]
    family = f"viscorod-{hashlib.sha1(str(package).encode(), usedforsecurity=False).hexdigest()[:8]}-"
    given = _config.CACHE_DIR
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for base in [Path(given)] if given else [package / "__pycache__", user / "viscorod"]:
        folder = base / f"{family}{_content()}"
        try:
            if not folder.is_dir():
                for earlier in base.glob(f"{family}*"):
                    shutil.rmtree(earlier, ignore_errors=True)
                folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:  # not writable
            continue
        return folder
    return None


@functools.lru_cache
def _shipped_folder() -> Path | None:
    """Return the folder of the wheel, None if its code is not for this machine, or another processor is wanted."""
    if TARGET is None or _config.CPU_NAME or _config.CPU_FEATURES is not None or not SHIPPED.is_dir():
        return None
    try:
        abilities = llvmlite.binding.get_host_cpu_features()
    except RuntimeError:  # LLVM does not know this processor
        return None
    return SHIPPED if all(abilities.get(need) for need in TARGET.needs) else None


def kept(function: Callable[..., object]) -> Any:
    """Return Numba's cache of one kernel in the folder of this machine, None if there is no folder."""
    folder = cache_folder()
    target = TARGET if MAKES in os.environ else None
    return None if folder is None else _KernelCache(function, folder, target)


def shipped(function: Callable[..., object]) -> Any:
    """Return Numba's cache of one kernel in the wheel; None if nothing there fits this machine."""
    folder = _shipped_folder()
    return None if folder is None else _KernelCache(function, folder, TARGET)


class _Place:
    """A place of Numba's files for one kernel: a folder, a stamp of the sources, and a mark in the names of files."""

    def __init__(self, function: Callable[..., object], folder: Path) -> None:
        kernel: Any = function
        self._folder = str(folder / kernel.__module__.rpartition(".")[0])
        self._line = str(kernel.__code__.co_firstlineno)

    def from_function(self, *_: object) -> _Place:
        """Return this place: it was made for the function that Numba asks for."""
        return self

    def get_cache_path(self) -> str:
        """Return the folder."""
        return self._folder

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        os.makedirs(self._folder, exist_ok=True)

    def get_source_stamp(self) -> str:
        """Return a number for all sources, since kernels contain others."""
        return _content()

    def get_disambiguator(self) -> str:
        """Return what tells apart kernels of one name in one module."""
        return self._line


class _KernelCache(_Cache):
    """Numba's cache of one kernel, at a place of our choice; code for a ``target`` serves all that can run it."""

    def __init__(self, function: Callable[..., object], folder: Path, target: Target | None) -> None:
        places = {"_locator_classes": [_Place(function, folder)]}
        self._impl_class = type("_KernelKind", (_Kind,), places)
        self._target = target
        super().__init__(function)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return machine code from disk without what Numba imports to compile: whoever compiles imports it then.

        Code that is there needs the runtime alone. The rest is all that Numba can translate, a tenth of a warm run.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        key = super()._index_key(sig, codegen)
        if self._target is None:
            return key
        signature, (triple, *_), *source = key
        return signature, (triple, self._target.name), *source

"""An open result file that finds each of its arrays once: h5netcdf asks for them by name again and again."""

from __future__ import annotations

from typing import Any

import h5py

__all__ = ["FileOfKnownItems"]


class FileOfKnownItems(h5py.File):  # type: ignore[misc]
    """A file whose arrays are found once: what a name stands for changes only where it is deleted.

    Those in groups, which may be deleted by way of the group, are found each time.
    """

    def __init__(self, *given: Any, **options: Any) -> None:
        super().__init__(*given, **options)
        self._known: dict[str, Any] = {}
        self._top = _Top(super().__getitem__("/").id, self._known)

    def __getitem__(self, name: Any) -> Any:
        if name == "/":
            return self._top
        own = name.lstrip("/") if isinstance(name, str) else "/"
        if "/" in own:  # of a group, or a reference
            return super().__getitem__(name)
        if own not in self._known:
            self._known[own] = super().__getitem__(own)
        return self._known[own]

    def __delitem__(self, name: Any) -> None:
        del self._top[name]

    def forget(self) -> None:
        """Let go of all arrays: what waits in memory for more of a piece goes to the disk."""
        self._known.clear()


class _Top(h5py.Group):  # type: ignore[misc]
    """All that is not in a group; arrays that are deleted are not known any more."""

    def __init__(self, bound: Any, known: dict[str, Any]) -> None:
        super().__init__(bound)
        self._known = known

    def __delitem__(self, name: Any) -> None:
        self._known.clear()
        super().__delitem__(name)

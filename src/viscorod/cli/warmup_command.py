"""``viscorod warmup``: all kernels compiled before they are needed."""

from __future__ import annotations

from viscorod.cli.command_kind import quiet
from viscorod.cli.terminal import say

__all__ = ["warmup"]


def warmup() -> None:
    """Compile all kernels now, so that later runs start at once."""
    from viscorod.analyses.progress import counting
    from viscorod.analyses.warmup import kernels, warm_up

    count = len(kernels())
    if count == 0:
        say("nothing to compile: NUMBA_DISABLE_JIT is set, kernels are Python functions")
        return
    with counting(count, "kernels", shown=not quiet()) as progress:
        done = warm_up(progress)
    folders = ", ".join(map(str, done.folders))
    if done.compiled:
        say(f"{count} kernels compiled in {done.seconds:.1f} s; machine code is in {folders}")
    else:
        say(f"all {count} kernels are compiled already, in {folders}; loading them took {done.seconds:.1f} s")

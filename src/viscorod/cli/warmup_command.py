"""``viscorod warmup``: all kernels compiled before they are needed."""

from __future__ import annotations

import typer

__all__ = ["warmup"]


def warmup() -> None:
    """Compile all kernels now, so that later runs start at once."""
    from viscorod.analyses.progress import counting
    from viscorod.analyses.warmup import kernels, warm_up

    count = len(kernels())
    if count == 0:
        typer.echo("nothing to compile: NUMBA_DISABLE_JIT is set, kernels are Python functions")
        return
    with counting(count, "kernels") as progress:
        done = warm_up(progress)
    folders = ", ".join(map(str, done.folders))
    if done.compiled:
        typer.echo(f"{count} kernels compiled in {done.seconds:.1f} s; machine code is in {folders}")
    else:
        typer.echo(
            f"all {count} kernels are compiled already, in {folders}; loading them took {done.seconds:.1f} s"
        )

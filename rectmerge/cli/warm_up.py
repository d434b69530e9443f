"""Command `rectmerge warm-up`."""

from __future__ import annotations

import time

import typer

from rectmerge.cli import console

SECONDS_BETWEEN_NOTES = 5.0


def warm_up() -> None:
    """Compile the inner loops of all commands, once on this machine, so that none of them waits for that later.

    Without it each command compiles what it needs on its first run.
    """
    from rectmerge.warm_up import warm_up as compile_all

    done = compile_all(_Progress())
    work = f"compiled in {done.cpu_s:.0f} s of processor time" if done.compiled else "nothing was left to compile"
    kept = ""
    if done.cache:
        kept = f"; kept in {done.cache}"
    elif done.compiled:
        kept = "; not kept: no cache can be written; NUMBA_CACHE_DIR may name one"
    typer.echo(f"inner loops are ready: {work}{kept}")


def compile_before_first_merge() -> None:
    """Compile what merging needs in one wait with progress, where nothing of it is compiled yet."""
    from rectmerge.warm_up import is_first_merge
    from rectmerge.warm_up import warm_up as compile_for

    if is_first_merge():
        compile_for(_Progress(), only_merging=True)


class _Progress:
    """Progress of the compilation, noted every few seconds with the time that is left."""

    def __init__(self) -> None:
        self._started = self._noted = time.monotonic()

    def __call__(self, ready: int, of: int) -> None:
        now = time.monotonic()
        if now - self._noted < SECONDS_BETWEEN_NOTES:
            return
        self._noted = now
        left = (now - self._started) / ready * (of - ready)
        console.note(f"rectmerge: {ready} of {of} inner loops compiled, about {left:.0f} s left")

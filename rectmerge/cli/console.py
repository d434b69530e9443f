"""Console of both commands: known errors become one line and a status, unknown ones a line and a log."""

from __future__ import annotations

import errno
import gc
import logging
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import typer

from rectmerge import __version__
from rectmerge.errors import RectMergeError

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

YES = 0
NO = 1
BAD_INPUT = 2
AMBIGUOUS = 3
INTERNAL = 70
INTERRUPTED = 130
AGAIN_SECONDS = 0.02  # until an interrupt that was lost is raised again
OBJECTS_BEFORE_COLLECTION = 100_000  # imports make as many that stay: looking through them often costs a tenth
_LOGGER = logging.getLogger("rectmerge")  # its level is what --quiet sets
BROKEN_PIPE = 141  # as a shell reports a reader that went away; 1 would mean "no"


STATUS = {"accepted": YES, "rejected": NO, "ambiguous": AMBIGUOUS}  # of a verdict


def end(app: typer.Typer, prog: str) -> NoReturn:
    """Run the command line of this process, as `run` does, and end the process with the status."""
    sys.unraisablehook = _raise_interrupts_again
    gc.set_threshold(OBJECTS_BEFORE_COLLECTION)
    status = run(app, prog)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Python takes a moment to end, and nothing is left to interrupt
    gc.freeze()  # else Python looks through all that numba made before it ends, 0.3 s
    sys.exit(status)


def run(app: typer.Typer, prog: str, args: Sequence[str] | None = None) -> int:
    """Run a command line and return its exit status, whatever happens.

    Parameters
    ----------
    app
        The commands. A command answers by ``raise typer.Exit(status)``, or returns for status 0; it raises
        `RectMergeError` for what the user can mend.
    prog
        The name people type.
    args
        The words after it; None takes those of the process.

    Returns
    -------
    int
        0 yes, 1 no, 2 bad input (one line on stderr) or bad use (the usage text), 3 ambiguous, 70 internal error
        (one line, and the path of a log with the traceback), 130 interrupted. ``--debug`` among the words shows the
        traceback of any error as well.

    Examples
    --------
    ``assert console.run(app, "rectmerge", ["--version"]) == 0``
    """
    words = list(sys.argv[1:] if args is None else args)
    try:
        with _notes(prog):
            typer.main.get_command(app).main(args=words, prog_name=prog)
    except SystemExit as end:  # how a command line ends in every version of typer
        return _status(end, prog)
    except KeyboardInterrupt:
        return _interrupted(prog)
    except RectMergeError as error:
        _show_traceback(words)
        say(f"{prog}: {one_line(error)}")
        return BAD_INPUT
    except Exception as error:  # noqa: BLE001 - the outermost wrapper: a bug ends in a line and a log, not in a screenful
        return _internal(prog, words, error)
    return YES


def say(line: str) -> None:
    """Write a line to stderr, where progress, notes and errors go."""
    typer.echo(printable(line), err=True)


def tell(text: str, *, ends_line: bool = True) -> None:
    """Write an answer to stdout, without the control characters that files may hold."""
    typer.echo(printable(text), nl=ends_line)


def printable(text: str) -> str:
    """Return text whose unprintable characters, except line ends and tabs, are written as escapes."""
    return "".join(c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text)


def note(line: str) -> None:
    """Write a line to stderr unless ``--quiet`` is given."""
    if not is_quiet():
        say(line)


def is_quiet() -> bool:
    """Return whether ``--quiet`` is given."""
    return not _LOGGER.isEnabledFor(logging.INFO)


def set_quiet(quiet: bool) -> None:
    """Keep notes off stderr from now on, where ``--quiet`` is given."""
    if quiet:
        _LOGGER.setLevel(logging.WARNING)


def one_line(error: BaseException) -> str:
    """Return an error's message as one line."""
    return " ".join(str(error).split()) or type(error).__name__


@contextmanager
def _notes(prog: str) -> Iterator[None]:
    """Show on stderr the notes of the library meanwhile, such as that it compiles."""
    handler = _ToStderr()
    handler.setFormatter(logging.Formatter(f"{prog}: %(message)s"))
    before = _LOGGER.level
    _LOGGER.addHandler(handler)
    _LOGGER.setLevel(logging.INFO)
    try:
        yield
    finally:
        _LOGGER.removeHandler(handler)
        _LOGGER.setLevel(before)


class _ToStderr(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        say(self.format(record))


def _status(end: SystemExit, prog: str) -> int:
    if isinstance(end.__context__, typer.Abort) or end.code == INTERRUPTED:
        return _interrupted(prog)
    if isinstance(end.__context__, OSError) and end.__context__.errno == errno.EPIPE:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nothing is left to complain to at exit
        return BROKEN_PIPE
    return end.code if isinstance(end.code, int) else YES if end.code is None else INTERNAL


def _interrupted(prog: str) -> int:
    say(f"{prog}: interrupted")
    return INTERRUPTED


def _raise_interrupts_again(lost: UnraisableHookArgs) -> None:
    """Raise an interrupt again that Python lost in a callback of compiled code."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        main = threading.main_thread().ident or 0
        threading.Timer(AGAIN_SECONDS, signal.pthread_kill, (main, signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(lost)


def _internal(prog: str, words: Sequence[str], error: Exception) -> int:
    text = "".join(traceback.format_exception(error))
    message = f"{prog}: internal error: {type(error).__name__}: {one_line(error)}"
    _show_traceback(words)
    try:
        handle, name = tempfile.mkstemp(prefix=f"{prog}-", suffix=".log")
        with os.fdopen(handle, "w", encoding="utf-8") as log:
            log.write(f"{prog} {__version__}, Python {sys.version}\nin {Path.cwd()}: {list(words)}\n\n{text}")
        say(f"{message} (log: {name})")
    except OSError:
        say(f"{message} (no log could be written; --debug shows the traceback)")
    return INTERNAL


def _show_traceback(words: Sequence[str]) -> None:
    if "--debug" in words:
        traceback.print_exc()

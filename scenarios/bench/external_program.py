"""External programs, in any language, as methods: a program gets two images and prints the placement of B on A."""

from __future__ import annotations

import math
import os
import re
import select
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment, Candidate
from rectmerge.errors import InputError, RectMergeError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import write_map
from rectmerge.similarity import Similarity
from scenarios.execution.limits import describe_exit, die_with
from scenarios.execution.processes import children_of, end_descendants, reap_children

REJECTED = "rejected"  # the last line that means "no"
MAX_OUTPUT_BYTES = 16 * 2**20  # of what a program may print
POLL_S = 0.1  # between looks at the size of its output
INTERPRETERS = re.compile(r"(python|pypy|bash|sh|node|java|ruby|perl|Rscript|julia|octave)[\d.]*")
NAMED = re.compile(r"([A-Za-z_][\w.-]*)=(.+)", re.DOTALL)
TAIL_BYTES = 65536  # of what a program printed, which is looked through for its last line
UNNAMED = "command"
MATRIX, PROGRAM_PEAK_MB = "matrix", "program_peak_mb"  # keys of the trace


class ProgramError(RectMergeError):
    """A program that ended in an unknown way, or printed no placement."""


@dataclass(frozen=True, kw_only=True)
class Program:
    """A command line as a method.

    The program gets its files for ``{a}`` and ``{b}``, PNG images, or ``{a_yaml}`` and ``{b_yaml}``, map_server YAMLs
    beside them, which say ``resolution: null`` where it may not be known, and for ``{scale}`` the pixel scale where
    methods get it. Its last line is the answer: the six numbers of the 2x3 matrix from B's pixel centres to A's,
    row by row, and optionally its confidence; or the word ``rejected``. No such line, an exit status other than 0, a
    signal, or more than 16 MB of output is an error. Files it leaves in TMPDIR and processes it leaves running are
    removed when it ends.

    Parameters
    ----------
    command
        As typed.
    name
        Its name in tables; by default the script's or program's.
    """

    command: str
    name: str = UNNAMED

    def __post_init__(self) -> None:
        try:
            words = shlex.split(self.command)
        except ValueError as error:
            raise InputError(f"--method-command {self.command!r}: {error}") from None
        for name in "ab":
            if f"{{{name}}}" not in self.command and f"{{{name}_yaml}}" not in self.command:
                raise InputError(f"--method-command {self.command!r}: must hold {{{name}}} or {{{name}_yaml}}")
        if shutil.which(words[0]) is None:
            raise InputError(f"--method-command {self.command!r}: there is no program {words[0]!r}")

    @classmethod
    def parse(cls, text: str) -> Program:
        """Make a program from ``COMMAND`` or ``NAME=COMMAND``."""
        named = NAMED.fullmatch(text)
        return cls(command=text) if named is None else cls(command=named[2], name=named[1])

    @property
    def label(self) -> str:
        """The name given, else that of the script which an interpreter runs, else that of the program."""
        if self.name != UNNAMED:
            return self.name
        first, *others = shlex.split(self.command)
        if INTERPRETERS.fullmatch(Path(first).name):
            first = next((word for word in others if Path(word).is_file()), first)
        return Path(first).stem or Path(first).name

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Run the program; it gets no `rng`, and `scale` only if that is one number.

        Raises
        ------
        ProgramError
            If it asks for a scale that nobody knows, ends in an unknown way, or prints no placement.
        """
        with (
            tempfile.TemporaryDirectory(prefix="rectbench-", ignore_cleanup_errors=True) as folder,
            tempfile.TemporaryFile() as said,
        ):
            words = [word.replace("{scale}", self._scale_word(scale)) for word in shlex.split(self.command)]
            for name, grid in (("a", a), ("b", b)):
                path = Path(folder) / f"{name}.yaml"
                write_map(grid, path, image_suffix=".png")
                for key, file in ((name, path.with_suffix(".png")), (f"{name}_yaml", path)):
                    words = [word.replace(f"{{{key}}}", str(file)) for word in words]
            scratch = Path(folder) / "tmp"
            scratch.mkdir()
            status, peak_mb = _run(words, said, scratch)
            if status != 0:
                old_rule = f"; a program says no by a last line {REJECTED!r} and status 0" if status == 1 else ""
                raise ProgramError(f"{self.label} {describe_exit(status)}{old_rule}")
            line = _last_line(said)
        trace = {PROGRAM_PEAK_MB: peak_mb}
        if line.strip() == REJECTED:
            return Alignment(verdict="rejected", reason="the program rejects", method=self.name, trace=trace)
        matrix, confidence = read_answer(line)
        best = Candidate.from_pixels(_nearest(matrix, b), a, b, confidence=confidence)
        return Alignment(
            verdict="accepted",
            reason="the program accepts",
            method=self.name,
            candidates=(best,),
            confidence=confidence,
            trace={**trace, MATRIX: matrix.tolist()},
        )

    def _scale_word(self, scale: tuple[float, float]) -> str:
        if "{scale}" in self.command and scale[0] != scale[1]:
            raise ProgramError(f"{self.label} asks for {{scale}}, which is known with --known-scale only")
        return f"{scale[0]:.9g}"


def labelled(programs: Iterable[Program], taken: Iterable[str]) -> dict[str, Program]:
    """Name programs by their labels, numbered where a name is taken."""
    labels: dict[str, Program] = {}
    used = set(taken)
    for program in programs:
        numbered = (f"{program.label}-{number}" if number > 1 else program.label for number in range(1, len(used) + 2))
        label = next(name for name in numbered if name not in used)
        used.add(label)
        labels[label] = program
    return labels


def read_answer(line: str) -> tuple[NDArray[np.float64], float]:
    """Read the line that a program prints: its matrix, shape (2, 3), and its confidence, NaN if there is none.

    Raises
    ------
    ProgramError
        If the line is no answer.

    Examples
    --------
    >>> read_answer("1 0 5  0 1 -3  0.9")
    (array([[ 1.,  0.,  5.],
           [ 0.,  1., -3.]]), 0.9)
    """
    try:
        numbers = [float(word) for word in line.replace(",", " ").split()]
    except ValueError:
        numbers = []
    if len(numbers) not in (6, 7) or not all(map(math.isfinite, numbers)):
        raise ProgramError(
            f"the last line must be six finite numbers and perhaps a confidence, or {REJECTED!r}, got {line[:80]!r}"
        )
    matrix = np.array(numbers[:6]).reshape(2, 3)
    if np.linalg.det(matrix[:, :2]) == 0:
        raise ProgramError(f"the matrix flattens the map: {line[:80]!r}")
    confidence = numbers[6] if len(numbers) == 7 else math.nan
    if len(numbers) == 7 and not 0 <= confidence <= 1:
        raise ProgramError(f"a confidence lies in 0..1, got {confidence:g}")
    return matrix, confidence


def _run(words: list[str], said: BinaryIO, scratch: Path) -> tuple[int, float]:
    """Run a program to its end; return its exit status, negative for a signal, and its peak memory in MB."""
    here = os.getpid()
    before = children_of(here)
    try:
        process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=said,
            env=os.environ | {"TMPDIR": str(scratch)},
            preexec_fn=partial(die_with, here),
        )
    except OSError as error:
        raise ProgramError(f"{words[0]} cannot be started: {error.strerror}") from None
    says_too_much = _wait(process.pid, said)
    if says_too_much:
        process.kill()
    _, ended, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(ended)
    end_descendants(here, spared=before)  # where this process adopts orphans, also those of another session
    reap_children(spared=before)
    if says_too_much:
        raise ProgramError(f"it printed more than {MAX_OUTPUT_BYTES // 2**20} MB")
    return process.returncode, usage.ru_maxrss / 1024


def _wait(pid: int, said: BinaryIO) -> bool:
    """Wait until a program ends, or has printed too much; return whether it has."""
    handle = os.pidfd_open(pid)
    try:
        while not select.select([handle], [], [], POLL_S)[0]:
            if os.fstat(said.fileno()).st_size > MAX_OUTPUT_BYTES:
                return True
    finally:
        os.close(handle)
    return os.fstat(said.fileno()).st_size > MAX_OUTPUT_BYTES


def _last_line(said: BinaryIO) -> str:
    said.seek(max(0, said.seek(0, os.SEEK_END) - TAIL_BYTES))
    lines = said.read().decode(errors="replace").split("\n")
    return next((line for line in reversed(lines) if line.strip()), "")


def _nearest(matrix: NDArray[np.float64], b: OccupancyGrid) -> Similarity:
    """Fit the similarity that moves B's corners most like a matrix that may mirror or shear."""
    height, width = b.shape
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float64)
    try:
        return Similarity.fit(corners, corners @ matrix[:, :2].T + matrix[:, 2])
    except InputError:  # a pure reflection is as far from every turn
        return Similarity(float(np.sqrt(abs(np.linalg.det(matrix[:, :2])))))

"""External programs, in any language, as methods: a program gets two images and prints the placement of B on A."""

from __future__ import annotations

import math
import os
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

REJECTED = 1  # the exit status that means "no"
TAIL_BYTES = 65536  # of what a program printed, which is looked through for its last line
MATRIX, PROGRAM_PEAK_MB = "matrix", "program_peak_mb"  # keys of the trace


class ProgramError(RectMergeError):
    """A program that ended in an unknown way, or printed no placement."""


@dataclass(frozen=True, kw_only=True)
class Program:
    """A command line as a method.

    The program gets its files for ``{a}`` and ``{b}``, PNG images, or ``{a_yaml}`` and ``{b_yaml}``, map_server YAMLs
    beside them, which say ``resolution: null`` where it may not be known, and for ``{scale}`` the pixel scale where
    methods get it. Its last line is the answer: the six numbers of the 2x3 matrix from B's pixel centres to A's,
    row by row, and optionally its confidence. Exit status 1 means rejected; any other but 0, a signal, or no such line
    is an error.

    Parameters
    ----------
    command
        As typed.
    """

    command: str
    name: str = "command"

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

    @property
    def program(self) -> str:
        """The program's name."""
        return Path(shlex.split(self.command)[0]).stem

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Run the program; it gets no `rng`, and `scale` only if that is one number.

        Raises
        ------
        ProgramError
            If it asks for a scale that nobody knows, ends in an unknown way, or prints no placement.
        """
        with tempfile.TemporaryDirectory(prefix="rectbench-") as folder, tempfile.TemporaryFile() as said:
            words = [word.replace("{scale}", self._scale_word(scale)) for word in shlex.split(self.command)]
            for name, grid in (("a", a), ("b", b)):
                path = Path(folder) / f"{name}.yaml"
                write_map(grid, path, image_suffix=".png")
                for key, file in ((name, path.with_suffix(".png")), (f"{name}_yaml", path)):
                    words = [word.replace(f"{{{key}}}", str(file)) for word in words]
            status, peak_mb = _run(words, said)
            trace = {PROGRAM_PEAK_MB: peak_mb}
            if status == REJECTED:
                return Alignment(verdict="rejected", reason="the program rejects", method=self.name, trace=trace)
            if status != 0:
                raise ProgramError(f"{self.program} {describe_exit(status)}")
            matrix, confidence = read_answer(_last_line(said))
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
            raise ProgramError(f"{self.program} asks for {{scale}}, which is known with --known-scale only")
        return f"{scale[0]:.9g}"


def labelled(programs: Iterable[Program], taken: Iterable[str]) -> dict[str, Program]:
    """Name programs by their files, numbered where a name is taken."""
    labels: dict[str, Program] = {}
    used = set(taken)
    for program in programs:
        numbered = (
            f"{program.program}-{number}" if number > 1 else program.program for number in range(1, len(used) + 2)
        )
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
        raise ProgramError(f"the last line must be six finite numbers and perhaps a confidence, got {line[:80]!r}")
    matrix = np.array(numbers[:6]).reshape(2, 3)
    if np.linalg.det(matrix[:, :2]) == 0:
        raise ProgramError(f"the matrix flattens the map: {line[:80]!r}")
    confidence = numbers[6] if len(numbers) == 7 else math.nan
    if len(numbers) == 7 and not 0 <= confidence <= 1:
        raise ProgramError(f"a confidence lies in 0..1, got {confidence:g}")
    return matrix, confidence


def _run(words: list[str], said: BinaryIO) -> tuple[int, float]:
    """Run a program to its end; return its exit status, negative for a signal, and its peak memory in MB."""
    try:
        process = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=said,
            preexec_fn=partial(die_with, os.getpid()),
        )
    except OSError as error:
        raise ProgramError(f"{words[0]} cannot be started: {error.strerror}") from None
    _, ended, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(ended)
    return process.returncode, usage.ru_maxrss / 1024


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

"""Trajectories as text: the format of the TUM RGB-D benchmark, ``timestamp tx ty tz qx qy qz qw`` on every line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.imagefile import replace_file

HEADER = "# timestamp tx ty tz qx qy qz qw\n"


def write_tum(path: Path, times: NDArray[np.float64], poses: NDArray[np.float64]) -> None:
    """Write planar poses, true or estimated, as a TUM trajectory, whole or not at all.

    Parameters
    ----------
    path
        The file.
    times
        Shape (S,), seconds.
    poses
        (x, y, yaw), shape (S, 3), metres and radians.

    Raises
    ------
    InputError
        If the shapes disagree or a number is not finite.
    """
    if poses.shape != (len(times), 3):
        raise InputError(f"times (S,) and poses (S, 3) disagree: {times.shape}, {poses.shape}")
    if not (np.isfinite(times).all() and np.isfinite(poses).all()):
        raise InputError("a trajectory must have finite times and poses")
    rows = (
        f"{time:.6f} {x:.9f} {y:.9f} 0 0 0 {math.sin(yaw / 2):.12f} {math.cos(yaw / 2):.12f}\n"
        for time, (x, y, yaw) in zip(times.tolist(), poses.tolist(), strict=True)
    )
    replace_file(path, (HEADER + "".join(rows)).encode())


def read_tum(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read a TUM trajectory as times (S,) and planar poses (x, y, yaw), shape (S, 3), yaw in -pi..pi.

    Raises
    ------
    InputError
        If the file cannot be read or a line is not eight numbers; the message names the line.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} cannot be read as text: {error}") from error
    rows = [_row(path, n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.startswith("#")]
    table = np.array(rows, dtype=np.float64).reshape(-1, 8)
    x, y, z, w = table[:, 4:].T
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return table[:, 0], np.column_stack([table[:, 1:3], yaw])


def _row(path: Path, number: int, line: str) -> list[float]:
    try:
        values = [float(word) for word in line.split()]
    except ValueError:
        values = []
    if len(values) != 8 or not all(map(math.isfinite, values)):
        raise InputError(f"{path}, line {number}: not eight numbers: {line[:60]!r}")
    return values

"""Trajectories in the format of the TUM RGB-D benchmark: ``timestamp tx ty tz qx qy qz qw`` on every line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file

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

"""Wheel odometry: the velocity motion model of Thrun, Burgard and Fox, applied to a true motion."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, fields

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim.slam.poses import chain_poses, relative_poses


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelNoise:
    """Noise of wheel odometry: the alphas of the velocity motion model.

    The defaults are those of an ordinary indoor robot: after 10 m straight on it is off by 2 % along its way and by
    3 degrees, and after a full turn on the spot by 4 degrees (standard deviations).

    Parameters
    ----------
    alpha1, alpha2
        Variance of the distance per metre driven, m, and per radian turned, m^2.
    alpha3, alpha4
        Variance of the turn per metre driven, rad^2/m, and per radian turned, rad.
    alpha5, alpha6
        Variance of the turn that ends a step, as for `alpha3` and `alpha4`.

    Raises
    ------
    InputError
        If a value is negative or not finite.
    """

    alpha1: float = 3e-3
    alpha2: float = 3e-4
    alpha3: float = 2e-4
    alpha4: float = 8e-4
    alpha5: float = 4e-5
    alpha6: float = 4e-5

    def __post_init__(self) -> None:
        for field, value in zip(fields(self), astuple(self), strict=True):
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"{field.name} must be a finite number >= 0, got {value}")


def simulate_odometry(
    poses: NDArray[np.float64], rng: np.random.Generator, *, noise: WheelNoise | None = None, level: float = 1.0
) -> NDArray[np.float64]:
    """Integrate the noisy odometry of a true motion, from the true first pose.

    Parameters
    ----------
    poses
        True poses (x, y, yaw) at successive scans, shape (S, 3), metres and radians.
    rng
        Source of the noise.
    noise
        Noise of the wheels; `WheelNoise()` where nothing is given.
    level
        Multiplies the standard deviations; 0 returns the true poses.

    Returns
    -------
    NDArray
        Shape (S, 3), yaw in -pi..pi.

    Raises
    ------
    InputError
        If the poses have no such shape, or the level is negative or not finite.

    Notes
    -----
    S. Thrun, W. Burgard, D. Fox, Probabilistic Robotics, 2005, chapter 5.3, tables 5.1 and 5.3, with the time between
    two scans as unit of time. Departs from the book: (1) variances grow with ``|v|`` and ``|w|``, not their squares, so
    that the error after a drive does not depend on how often it is sampled; (2) the arc turns by as much as the robot
    did, and what then remains is a small shift, not a turn gamma: a robot that turns on the spot and slips by 1 mm
    sideways would need an arc of half a turn and a gamma that undoes it.
    """
    if poses.ndim != 2 or poses.shape[1] != 3 or not len(poses):
        raise InputError(f"poses have shape (S, 3) with S >= 1, got {poses.shape}")
    if not (math.isfinite(level) and level >= 0):
        raise InputError(f"level must be a finite number >= 0, got {level}")
    along, turn, shift = recover_arcs(poses)
    spread = np.stack([np.abs(along), np.abs(turn)], axis=-1)  # (S-1, 2)
    alphas = np.array(astuple(noise or WheelNoise())).reshape(3, 2)
    wrong = level * np.sqrt(spread @ alphas.T) * rng.standard_normal((len(turn), 3))  # table 5.3, lines 2-4
    seen_turn = turn + wrong[:, 1]
    steps = arc_ends(along + wrong[:, 0], seen_turn)
    steps[:, :2] += shift
    steps[:, 2] += wrong[:, 2]  # table 5.3, line 7: gamma
    return chain_poses(poses[0], steps)


def recover_arcs(
    poses: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Recover the arcs of a motion (table 5.1).

    Parameters
    ----------
    poses
        Shape (S, 3).

    Returns
    -------
    along, turn, shift
        Signed length of each arc, shape (S-1,), metres; its turn, radians in -pi..pi; and the displacement that the
        arc leaves, shape (S-1, 2), metres in the frame of the pose before.
    """
    step = relative_poses(poses[:-1], poses[1:])
    unit = arc_ends(np.ones(len(step)), step[:, 2])[:, :2]  # of an arc of 1 m
    along = (step[:, :2] * unit).sum(axis=1) / (unit**2).sum(axis=1)
    return along, step[:, 2], step[:, :2] - along[:, None] * unit


def arc_ends(along: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the poses (N, 3) at the ends of arcs from the origin, of signed lengths and turns (N,)."""
    chord = along * np.sinc(turn / (2 * np.pi))
    return np.stack([chord * np.cos(turn / 2), chord * np.sin(turn / 2), turn], axis=-1)

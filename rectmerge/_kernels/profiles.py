"""Energies of the projection profiles of points: largest where the points pile up along a direction."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def profile_energies(points: NDArray[np.float64], angles: NDArray[np.float64], bin_width: float) -> NDArray[np.float64]:
    """Sum the squared counts of the points' profile on each direction; points (N, 2) are centred on the origin.

    Many angles in one compiled pass, one profile each. `rectmerge.analysis.dominant_angle` sums both axes of a frame
    over unit bins in float64, for the single direction that the paper's method needs.
    """
    reach = 0.0
    for k in range(len(points)):
        reach = max(reach, math.hypot(points[k, 0], points[k, 1]))
    counts = np.empty(int(2 * reach / bin_width) + 4, np.float32)
    energies = np.empty(len(angles))
    for i in range(len(angles)):
        counts[:] = 0
        cos, sin = math.cos(angles[i]) / bin_width, math.sin(angles[i]) / bin_width
        middle = reach / bin_width + 1
        for k in range(len(points)):
            at = points[k, 0] * cos + points[k, 1] * sin + middle
            low = int(at)
            share = at - low
            counts[low] += 1 - share
            counts[low + 1] += share
        energy = 0.0
        for c in counts:
            energy += float(c) * float(c)
        energies[i] = energy
    return energies

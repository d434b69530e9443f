"""Prior of the displacement: a drifting map turns freely, and is stretched or curved little."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.spline_lattice import add_blocks
from rectmerge.elastic.lattice import Lattice
from rectmerge.elastic.params import FitParams

GAUSS_POINTS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))  # two points integrate these splines' products well


def smoothness(lattice: Lattice, patch: float, params: FitParams) -> NDArray[np.float64]:
    """Return the prior's quadratic form as the lower band of a matrix, (2 nodes, half_width + 1).

    Parameters
    ----------
    lattice
        Nodes, with `spacing` in cells.
    patch
        Side of the areas that bend independently, in cells.
    params
        Standard deviations.

    Notes
    -----
    The integral over the lattice, in units of patches, of the squared strain (u_x, v_y and the shear twice) over
    ``strain_std``; of the squared gradient of the turn (v_x - u_y) / 2, in radians per patch, over ``turn_std``; and of
    the squared second derivatives times the patch over ``strain_std``, times ``curvature_weight``.
    """
    block = np.zeros((4, 4, 2, 4, 4, 2))
    area = (lattice.spacing / patch) ** 2 / len(GAUSS_POINTS) ** 2
    for ty in GAUSS_POINTS:
        for tx in GAUSS_POINTS:
            for form, weight in _forms(tx, ty, lattice.spacing, patch, params):
                block += area * weight * np.multiply.outer(form, form)
    band = np.zeros((2 * lattice.node_count, lattice.half_width + 1))
    add_blocks(band, lattice.counts, lattice.steps, block)
    return band


def _forms(
    tx: float, ty: float, spacing: float, patch: float, params: FitParams
) -> list[tuple[NDArray[np.float64], float]]:
    """Return the linear forms of the 16 nodes, (4, 4, 2) over (y, x, axis), that are to be small, and their weights."""
    x, y = _splines(tx, spacing), _splines(ty, spacing)
    value, slope, bend = 0, 1, 2
    of_x, of_y = np.outer(y[value], x[slope]), np.outer(y[slope], x[value])
    of_xx, of_xy, of_yy = np.outer(y[value], x[bend]), np.outer(y[slope], x[slope]), np.outer(y[bend], x[value])
    none = np.zeros((4, 4))
    strain, turn = params.strain_std**-2, (patch / params.turn_std) ** 2
    curvature = params.curvature_weight * (patch / params.strain_std) ** 2
    forms = [
        ((of_x, none), strain),
        ((none, of_y), strain),
        ((of_y / 2, of_x / 2), 2 * strain),
        ((-of_xy / 2, of_xx / 2), turn),
        ((-of_yy / 2, of_xy / 2), turn),
    ]
    for second in (of_xx, of_xy, of_yy):
        forms += [((second, none), curvature), ((none, second), curvature)]
    return [(np.stack(pair, axis=-1), weight) for pair, weight in forms]


def _splines(t: float, spacing: float) -> NDArray[np.float64]:
    """Return the four cubic B-splines at t, their slopes and their second derivatives, (3, 4), per cell."""
    s = 1 - t
    values = np.array([s**3, 3 * t**3 - 6 * t**2 + 4, 3 * s**3 - 6 * s**2 + 4, t**3]) / 6
    slopes = np.array([-(s**2), 3 * t**2 - 4 * t, 4 * s - 3 * s**2, t**2]) / 2
    bends = np.array([s, 3 * t - 2, 3 * s - 2, t])
    return np.stack([values, slopes / spacing, bends / spacing**2])

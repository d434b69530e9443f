"""Small pictures of maps for a page, with the transforms from their pixels to those of the maps."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from PIL import Image

from rectmerge.analysis.downscaling import Shrunk
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

# Okabe and Ito's blue and vermilion for the walls of A and B, and light tints of them for free space; 0 is clear
PALETTES = {"a": ("#DCEBF5", "#0072B2"), "b": ("#FBE7D8", "#D55E00")}


def draw_pair(a: OccupancyGrid, b: OccupancyGrid, side: int) -> dict[str, Any]:
    """Return two maps as plain data for ``widget.js``.

    Parameters
    ----------
    a, b
        The maps.
    side
        Longest side of the pictures, pixels.

    Returns
    -------
    dict
        ``a`` and ``b``: pictures as data addresses; ``to_a`` and ``to_b``: from a picture's pixels to the map's, six
        numbers, row by row; ``hull_b``: pixels (u, v) of B's picture around all known cells; ``size``: widths and
        heights, A's first.
    """
    small = {name: _small(grid, side) for name, grid in (("a", a), ("b", b))}
    return {
        **{name: _address(picture.grid, PALETTES[name]) for name, picture in small.items()},
        **{f"to_{name}": picture.to_given.matrix.ravel().tolist() for name, picture in small.items()},
        "hull_b": _hull(small["b"].grid),
        "size": [*small["a"].grid.shape[::-1], *small["b"].grid.shape[::-1]],
    }


def draw_straightened(b: OccupancyGrid, straight: OccupancyGrid, side: int) -> dict[str, Any]:
    """Return map B without its bend as plain data: ``bent``, its picture, and ``to_bent``, from its pixels to B's."""
    picture = _small(straight, side)
    tx, ty = b.map_to_pixel(straight.pixel_to_map([0.0, 0.0]))
    to_b = Similarity(tx=float(tx), ty=float(ty)) @ picture.to_given
    return {"bent": _address(picture.grid, PALETTES["b"]), "to_bent": to_b.matrix.ravel().tolist()}


def draw_one(grid: OccupancyGrid, side: int, colours: Sequence[str]) -> tuple[str, tuple[int, int], Similarity]:
    """Return a map as a picture.

    Parameters
    ----------
    grid
        The map.
    side
        Longest side of the picture, pixels.
    colours
        Of free space and of walls, as "#RRGGBB"; unknown cells are clear.

    Returns
    -------
    tuple
        The picture as a data address, its (width, height), and the similarity from its pixels to the map's.
    """
    picture = _small(grid, side)
    height, width = picture.grid.shape
    return _address(picture.grid, colours), (width, height), picture.to_given


def _small(grid: OccupancyGrid, side: int) -> Shrunk:
    if grid.unknown.all():
        return Shrunk(OccupancyGrid(np.zeros((1, 1), np.int8)), Similarity())
    return Shrunk.from_grid(grid, side)


def _hull(grid: OccupancyGrid) -> list[list[int]]:
    """List the pixels on the convex hull of the known cells; of all cells where downscaling left none known."""
    v, u = np.nonzero(~grid.unknown if not grid.unknown.all() else grid.unknown)
    hull: list[list[int]] = cv2.convexHull(np.stack([u, v], axis=-1).astype(np.int32))[:, 0].tolist()
    return hull


def _address(grid: OccupancyGrid, colours: Sequence[str]) -> str:
    """Draw a map's cells as a PNG of three colours, unknown clear, as a data address."""
    codes = np.where(grid.occupied, 2, np.where(grid.free, 1, 0)).astype(np.uint8)
    image = Image.fromarray(codes, mode="P")
    image.putpalette([0, 0, 0, *(int(colour[k : k + 2], 16) for colour in colours for k in (1, 3, 5))])
    png = io.BytesIO()
    image.save(png, "png", bits=2, transparency=0, optimize=True)
    return f"data:image/png;base64,{base64.b64encode(png.getvalue()).decode()}"

"""A pair seen anew: map B turned by any angle and drawn with other cells, by nearest neighbour."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rectmerge.errors import InputError
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.pairs import MapPair, PairSource

FACTORS = (0.6, 1.6)  # pixels of the new image per pixel of the old one


@dataclass(frozen=True, slots=True, kw_only=True)
class DisguisedSource:
    """The pairs of another source with map B turned and rescaled: a `PairSource`.

    Parameters
    ----------
    source
        Where the pairs come from.
    seed
        Of the turns and factors, at least one number.
    mark
        Added to each pair's id.
    """

    source: PairSource
    seed: tuple[int, ...]
    mark: str

    @property
    def source_id(self) -> str:
        """The other source's, marked."""
        return f"{self.source.source_id}-{self.mark}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """The other source's, marked."""
        return tuple(f"{pair_id}-{self.mark}" for pair_id in self.source.pair_ids)

    def pairs(self) -> Iterator[MapPair]:
        """Make the other source's pairs and disguise their maps B."""
        rng = np.random.default_rng(self.seed)
        for pair in self.source.pairs():
            turn_deg, factor = rng.uniform(-180.0, 180.0), math.exp(rng.uniform(*np.log(FACTORS)))
            disguised = disguise(pair, turn_deg, factor)
            yield dataclasses.replace(disguised, pair_id=f"{pair.pair_id}-{self.mark}")


def disguise(pair: MapPair, turn_deg: float, factor: float) -> MapPair:
    """Turn and rescale map B of a pair; its truth goes through the index map that was used.

    Parameters
    ----------
    pair
        The pair.
    turn_deg
        Degrees, counter-clockwise to the eye.
    factor
        Pixels of the new image per pixel of the old one, > 0.
    """
    b, new = resample(pair.b, turn_deg, factor)
    pixels, points = pair.pixels, pair.control_points
    info = {key: value for key, value in pair.info.items() if key != "origin_b"}  # it lies elsewhere now
    if info.get("resolution_b") is not None:
        info["resolution_b"] /= factor
    return dataclasses.replace(
        pair,
        b=b,
        pixels=pixels and pixels @ new.inverse(),
        control_points=None if points is None else np.hstack([points[:, :2], new.apply(points[:, 2:])]),
        info={**info, "disguise": {"turn_deg": turn_deg, "factor": factor}},
    )


def resample(grid: OccupancyGrid, turn_deg: float, factor: float) -> tuple[OccupancyGrid, Similarity]:
    """Draw a map turned about its centre and with other cells, by nearest neighbour, on a canvas that holds all of it.

    Returns
    -------
    resampled, pixels
        The new map, its map frame at its own lower-left corner, and the similarity from the pixels of the old image
        to those of the new one: exactly the index map that was used.

    Raises
    ------
    InputError
        If `factor` is not positive.
    """
    if not factor > 0:
        raise InputError(f"factor must be > 0, got {factor}")
    height, width = grid.shape
    about = Similarity(factor, -math.radians(turn_deg))  # pixels have v down
    cos, sin = abs(math.cos(about.angle)), abs(math.sin(about.angle))
    shape = (  # (H, W)
        math.ceil(factor * (width * sin + height * cos) - 1e-6),
        math.ceil(factor * (width * cos + height * sin) - 1e-6),
    )
    middle = about.apply([(width - 1) / 2, (height - 1) / 2])
    pixels = Similarity(
        factor, about.angle, float((shape[1] - 1) / 2 - middle[0]), float((shape[0] - 1) / 2 - middle[1])
    )
    u, v = np.arange(shape[1]), np.arange(shape[0])[:, None]
    back = pixels.inverse().matrix
    old_u, old_v = (np.floor(m[0] * u + m[1] * v + m[2] + 0.5).astype(np.intp) for m in back)  # (H, W)
    inside = (old_u >= 0) & (old_v >= 0) & (old_u < width) & (old_v < height)
    cells = np.full(shape, UNKNOWN, np.int8)
    cells[inside] = grid.occupancy[old_v[inside], old_u[inside]]
    return OccupancyGrid(cells, grid.resolution and grid.resolution / factor), pixels

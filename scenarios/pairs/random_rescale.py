"""Pairs whose map B is turned and rescaled at random, by nearest neighbour."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.corruption.geometry import rotate_onto_canvas, sample_nearest
from scenarios.pairs.pair import MapPair, PairSource

FACTORS = (0.6, 1.6)  # pixels of the new image per pixel of the old one


@dataclass(frozen=True, slots=True, kw_only=True)
class RescaledSource:
    """Pairs of another source with map B turned and rescaled: a `PairSource`.

    Parameters
    ----------
    source
        The source of the pairs.
    seed
        Seed of the turns and factors, at least one number.
    mark
        Suffix of each pair's id.
    """

    source: PairSource
    seed: tuple[int, ...]
    mark: str

    @property
    def source_id(self) -> str:
        """Return the other source's, with the suffix."""
        return f"{self.source.source_id}-{self.mark}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """Return the other source's, with the suffix."""
        return tuple(f"{pair_id}-{self.mark}" for pair_id in self.source.pair_ids)

    def is_related(self, pair_id: str) -> bool:
        """Return whether the other source calls the pair related."""
        return self.source.is_related(pair_id.removesuffix(f"-{self.mark}"))

    def pairs(self) -> Iterator[MapPair]:
        """Yield the other source's pairs with rescaled maps B."""
        rng = np.random.default_rng(self.seed)
        for pair in self.source.pairs():
            turn_deg, factor = rng.uniform(-180.0, 180.0), math.exp(rng.uniform(*np.log(FACTORS)))
            rescaled = rescale_pair(pair, turn_deg, factor)
            yield dataclasses.replace(rescaled, pair_id=f"{pair.pair_id}-{self.mark}")


def rescale_pair(pair: MapPair, turn_deg: float, factor: float) -> MapPair:
    """Turn and rescale map B of a pair, and its truth by the same index map.

    Parameters
    ----------
    pair
        The pair.
    turn_deg
        Degrees, counter-clockwise to the eye.
    factor
        Pixels of the new image per pixel of the old one, > 0.
    """
    b, b_to_new = turn_and_rescale(pair.b, turn_deg, factor)
    pixels, points = pair.pixels, pair.control_points
    info = {key: value for key, value in pair.info.items() if key != "origin_b"}  # no longer true
    if info.get("resolution_b") is not None:
        info["resolution_b"] /= factor
    return dataclasses.replace(
        pair,
        b=b,
        pixels=pixels and pixels @ b_to_new.inverse(),
        control_points=None if points is None else np.hstack([points[:, :2], b_to_new.apply(points[:, 2:])]),
        info={**info, "random_rescale": {"turn_deg": turn_deg, "factor": factor}},
    )


def turn_and_rescale(grid: OccupancyGrid, turn_deg: float, factor: float) -> tuple[OccupancyGrid, Similarity]:
    """Resample a map turned about its centre and rescaled, by nearest neighbour, on a canvas that holds all of it.

    Returns
    -------
    resampled, pixels
        The new map, its map frame at its own lower-left corner, and the similarity from the pixels of the old image
        to those of the new one: exactly the index map used.

    Raises
    ------
    InputError
        If `factor` is not positive.
    """
    pixels, (width, height) = rotate_onto_canvas(grid.shape, turn_deg, factor)
    u, v = np.arange(width), np.arange(height)[:, None]
    # not by `apply`: midway between two cells the last digit decides, and seeded pairs must stay what they are
    old = np.stack([m[0] * u + m[1] * v + m[2] for m in pixels.inverse().matrix], axis=-1)  # (H, W, 2)
    return OccupancyGrid(sample_nearest(grid, old), grid.resolution and grid.resolution / factor), pixels

"""Grey levels of a plain image for free, occupied and unknown, inferred from its histogram and its geometry."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN
from rectmerge.io.dialects import FREE_GREY, UNKNOWN_GREY
from rectmerge.io.image_file import grey_counts, recode

CLUSTER_REACH = 12  # grey levels this close are one level, blurred by compression
DARK_BELOW = 100  # a level that covers areas is occupied only if it is dark
AREA_SHARE = 0.2  # least share of an area level's pixels away from other levels; lines and blur have less
SAVERS_SHARE = 0.999  # of the pixels: others are single strokes of an editor
MIN_SHARE = 0.00002  # rarer levels are noise
MIN_LINE_SHARE = 0.002  # lines that are not dark may be blur between areas, if there are few
BORDER_SHARE = 0.85  # the light level is unknown if it has more than this share of both levels' border pixels


@dataclass(frozen=True, slots=True)
class Levels:
    """Grey levels, 0..255, for free, occupied and unknown; None where the image has no such level.

    Every other grey counts as the nearest of the three.
    """

    free: int
    occupied: int | None = None
    unknown: int | None = None

    def __post_init__(self) -> None:
        named = [level for level in (self.free, self.occupied, self.unknown) if level is not None]
        if not all(0 <= level <= 255 for level in named):
            raise InputError(f"grey levels must lie in 0..255, got {self}")
        if len(set(named)) < len(named):
            raise InputError(f"free, occupied and unknown must be different grey levels, got {self}")

    def __str__(self) -> str:
        parts = (("free", self.free), ("occupied", self.occupied), ("unknown", self.unknown))
        return ", ".join(f"{name} {'none' if level is None else level}" for name, level in parts)

    def classify(self, image: NDArray[np.uint8]) -> NDArray[np.int8]:
        """Turn an image of shape (H, W) into occupancy, each pixel by its nearest level."""
        meanings = ((self.free, FREE), (self.occupied, OCCUPIED), (self.unknown, UNKNOWN))
        known = [(level, value) for level, value in meanings if level is not None]
        distance = np.abs(np.arange(256)[:, None] - np.array([level for level, _ in known]))  # (256, K)
        table = np.array([value for _, value in known], np.int8)[distance.argmin(axis=1)]
        return recode(image, table)


def infer_levels(
    image: NDArray[np.uint8],
    *,
    free: int | None = None,
    occupied: int | None = None,
    unknown: int | None = None,
    seen: NDArray[np.bool_] | None = None,
) -> Levels:
    """Infer the grey levels for free, occupied and unknown.

    Parameters
    ----------
    image
        Grey levels, shape (H, W).
    free, occupied, unknown
        A level that is known already; only the others are inferred.
    seen
        Mask of the pixels that count, shape (H, W); None takes all.

    Raises
    ------
    InputError
        If no level can be free, for example in an image of one level.

    Notes
    -----
    No convention on greys is assumed beyond "walls are the darkest": published maps draw free space white on grey
    (ROS) or grey on white. Grey levels within 12 of a frequent one belong to it. Occupied is the darkest level, unless
    it covers areas and is not dark. Of the levels that cover areas, not only lines, the lighter is free, unless it
    has nearly all of the image's border: then it is the outside of the building. A single level next to the walls is
    free. An image of the greys 0, 205 and 254 alone is a map saver's, and read as such.
    """
    if all(level is not None for level in (free, occupied, unknown)):
        return Levels(free or 0, occupied, unknown)
    counts = grey_counts(image, seen)
    savers = _savers_levels(counts)
    if savers and all(mine in (None, its) for mine, its in zip((free, occupied, unknown), savers, strict=True)):
        return Levels(*savers)
    given = {level for level in (free, occupied, unknown) if level is not None}
    levels = _clusters(counts)
    clusters = {c: n for c, n in levels.items() if all(abs(c - g) > CLUSTER_REACH for g in given)}
    if free is None and len(clusters) + len(given) < 2:
        raise InputError(
            f"one grey level ({', '.join(map(str, levels)) or 'none'}) cannot separate free space from the rest"
        )
    areas = [level for level in clusters if _covers_areas(image, level, seen)]
    if occupied is None:
        occupied = _darkest_wall(clusters, areas)
    areas = [level for level in areas if level != occupied]
    if free is None and unknown is None:
        free, unknown = _split_by_border(image, areas[:2], seen)
    elif free is None:
        free = areas[0] if areas else None
    elif unknown is None:
        unknown = areas[0] if areas else None
    if free is None:
        raise InputError(f"no grey level can be identified as free space (levels: {', '.join(map(str, levels))})")
    return Levels(free, occupied, unknown)


def _savers_levels(counts: NDArray[np.int64]) -> tuple[int, int | None, int] | None:
    """Return the levels of an image that holds a map saver's greys and no others; None for any other image."""
    if not (counts[FREE_GREY] and counts[UNKNOWN_GREY]):
        return None
    if counts[[0, UNKNOWN_GREY, FREE_GREY]].sum() < SAVERS_SHARE * counts.sum():
        return None
    return FREE_GREY, (0 if counts[0] else None), UNKNOWN_GREY


def _clusters(counts: NDArray[np.int64]) -> dict[int, float]:
    """Return the frequent grey levels, most frequent first, with the share of pixels within reach of each."""
    counts = counts.copy()
    total = max(1, int(counts.sum()))
    levels: dict[int, float] = {}
    while counts.any():
        level = int(counts.argmax())
        around = slice(max(0, level - CLUSTER_REACH), level + CLUSTER_REACH + 1)
        share, counts[around] = float(counts[around].sum()) / total, 0
        if share >= MIN_SHARE:
            levels[level] = share
    return levels


def _mask(image: NDArray[np.uint8], level: int, seen: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
    near = cv2.inRange(image, np.array(level - CLUSTER_REACH), np.array(level + CLUSTER_REACH))
    mask = np.asarray(near, np.uint8) > 0
    return mask if seen is None else mask & seen


def _covers_areas(image: NDArray[np.uint8], level: int, seen: NDArray[np.bool_] | None) -> bool:
    """Return if a level covers areas, not lines: many of its pixels have mostly neighbours of the same level."""
    mask = _mask(image, level, seen)
    same = cv2.blur(mask.view(np.uint8) * 9, (3, 3), borderType=cv2.BORDER_REPLICATE)  # of nine cells
    return float(((same >= 7) & mask).sum()) >= AREA_SHARE * float(mask.sum())


def _darkest_wall(clusters: dict[int, float], areas: list[int]) -> int | None:
    """Return the darkest level if it may be walls: dark, or lines only."""
    darkest = min(clusters, default=None)
    if darkest is None or darkest < DARK_BELOW:
        return darkest
    return darkest if darkest not in areas and clusters[darkest] >= MIN_LINE_SHARE else None


def _split_by_border(
    image: NDArray[np.uint8], areas: list[int], seen: NDArray[np.bool_] | None
) -> tuple[int | None, int | None]:
    """Assign free and unknown to at most two area levels by their shares of the image's border."""
    if len(areas) < 2:
        return (areas[0] if areas else None), None
    border = np.zeros(image.shape, np.bool_)
    border[[0, -1], :] = border[:, [0, -1]] = True
    dark, light = sorted(areas)
    at_dark, at_light = (float(_mask(image, level, seen)[border].sum()) for level in (dark, light))
    return (dark, light) if at_light > BORDER_SHARE * max(1.0, at_dark + at_light) else (light, dark)

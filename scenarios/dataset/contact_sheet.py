"""One picture of many simulated pairs: every family of buildings, every pose source."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence
from typing import get_args

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rectmerge.drawing.maps import draw_map, side_by_side
from rectmerge.drawing.overlay import draw_overlay
from rectmerge.errors import SimulationError
from scenarios.pairs.pair import MapPair
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.random_missions import random_sources
from sim.floorplans import FAMILIES
from sim.slam.pose_sources import PoseSource

Picture = NDArray[np.uint8]
PAIRS, COLUMNS = 24, 4
TILE_PX = 150  # each way, of one map
POSES: tuple[PoseSource, ...] = get_args(PoseSource)
PERIOD = len(FAMILIES) * len(POSES)  # after so many missions family and pose source come again
TRIES = 8  # missions of a family and pose source, until one comes to something
SEED = 1  # not that of the pairs that are measured: what is shown was not chosen


def contact_sheet(pairs: int = PAIRS) -> Picture:
    """Draw pairs of every family and pose source: A, B, and B on A by the truth; shape (H, W, 3), RGB."""
    sources = random_sources(TRIES * PERIOD, seed=SEED, poses=POSES)
    shown = [_first_made(sources[k % PERIOD :: PERIOD]) for k in range(pairs)]
    return side_by_side([strip(pair) for pair in shown], [_caption(pair) for pair in shown], columns=COLUMNS)


def _first_made(sources: Sequence[MissionSource]) -> MapPair:
    """Make the pair of the first mission that comes to something: a wanted overlap may be out of reach."""
    for source in sources[:-1]:
        with contextlib.suppress(SimulationError):
            return next(source.pairs())
    return next(sources[-1].pairs())


def paletted_png(picture: Picture) -> bytes:
    """Encode a picture with a palette of 64 colours, which is small enough to be kept in a repository."""
    packed = io.BytesIO()
    Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE).save(packed, "png", optimize=True)
    return packed.getvalue()


def strip(pair: MapPair) -> Picture:
    """Draw a pair as three tiles: A, B, and B on A by the truth."""
    pictures = [draw_map(pair.a), draw_map(pair.b)]
    pictures.append(draw_map(pair.a) if pair.pixels is None else draw_overlay(pair.a, pair.b, pair.pixels))
    return np.hstack([_fitted(picture) for picture in pictures])


def _fitted(picture: Picture) -> Picture:
    """Scale a picture into its tile, in the middle of white."""
    factor = (TILE_PX - 4) / max(picture.shape[:2])
    size = max(1, round(picture.shape[1] * factor)), max(1, round(picture.shape[0] * factor))
    scaled = cv2.resize(picture, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_NEAREST)
    tile: Picture = np.full((TILE_PX, TILE_PX, 3), 255, np.uint8)
    left, top = (TILE_PX - size[0]) // 2, (TILE_PX - size[1]) // 2
    tile[top : top + size[1], left : left + size[0]] = scaled
    return tile


def _caption(pair: MapPair) -> str:
    overlap = "unrelated" if pair.overlap is None else f"overlap {pair.overlap:.2f}"
    bent = ", bent" if pair.info["bent"] else ""
    return f"{pair.info['family']}, {pair.info['pose_source']}, {overlap}{bent}"

"""One picture of many simulated pairs: every family of buildings, every pose source."""

from __future__ import annotations

from typing import get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.picture import beside, draw_map, draw_overlay
from scenarios.pairs import MapPair
from scenarios.variety import draw_sources
from sim.posing import PoseSource

Picture = NDArray[np.uint8]
PAIRS, COLUMNS = 24, 4
TILE_PX = 150  # each way, of one map
SEED = 1  # not that of the pairs that are measured: what is shown was not chosen


def contact_sheet(pairs: int = PAIRS) -> Picture:
    """Draw pairs of every family and pose source: A, B, and B on A by the truth; shape (H, W, 3), RGB."""
    tiles, captions = [], []
    for source in draw_sources(pairs, seed=SEED, poses=get_args(PoseSource)):
        (pair,) = source.pairs()
        tiles.append(_strip(pair))
        captions.append(_caption(pair))
    return beside(tiles, captions, columns=COLUMNS)


def _strip(pair: MapPair) -> Picture:
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
    return f"{pair.info['family']}, {pair.info['pose_source']}, noise {pair.info['noise']}, {overlap}{bent}"

"""Canvas of working grids, on which points and outlines are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.features import Features
from rectmerge.similarity import Similarity

Picture = NDArray[np.uint8]
Color = tuple[int, int, int]
FLOOR, NOTHING = (255, 255, 255), (222, 222, 222)
ZOOM = 2  # pixels of a picture per working cell


@dataclass(frozen=True, slots=True, eq=False)
class Canvas:
    """Picture of working grids, the floor in white; `zoom` takes points of the first grid to its pixels."""

    image: Picture
    zoom: Similarity

    @classmethod
    def from_features(cls, grids: Sequence[tuple[Features, Similarity]]) -> Canvas:
        """Draw the floor of grids, each moved by its placement onto the first."""
        corners = [
            placement.apply([[0, 0], [w, 0], [0, h], [w, h]])
            for (h, w), placement in ((each.free.shape, placement) for each, placement in grids)
        ]
        low, high = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
        zoom, size = Similarity(ZOOM, 0.0, *(-ZOOM * low).tolist()), np.ceil(ZOOM * (high - low)).astype(int).tolist()
        image = np.full((size[1], size[0], 3), NOTHING, np.uint8)
        for each, placement in grids:
            seen = cv2.warpAffine(each.free.view(np.uint8), (zoom @ placement).matrix, size, flags=cv2.INTER_NEAREST)
            image[seen > 0] = FLOOR
        return cls(image, zoom)

    def dots(self, points: NDArray[np.float64], color: Color) -> None:
        """Draw a dot at each point, shape (N, 2)."""
        for u, v in np.rint(self.zoom.apply(points)).astype(int).tolist() if len(points) else ():
            cv2.rectangle(self.image, (u - 1, v - 1), (u + 1, v + 1), color, cv2.FILLED)

    def outline(self, corners: NDArray[np.float64], color: Color, thickness: int) -> None:
        """Draw the outline of a polygon, shape (N, 2)."""
        path = np.rint(self.zoom.apply(corners)).astype(np.int32)
        cv2.polylines(self.image, [path], isClosed=True, color=color, thickness=thickness, lineType=cv2.LINE_AA)

    def fill(self, corners: NDArray[np.float64], color: Color) -> None:
        """Fill a polygon, shape (N, 2)."""
        cv2.fillPoly(self.image, [np.rint(self.zoom.apply(corners)).astype(np.int32)], color)

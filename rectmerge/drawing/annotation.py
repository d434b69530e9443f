"""Annotations on a picture of maps: circles around spots, origins, a scale bar and a title."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.drawing.maps import FONT, LEGEND_PX, Color, Picture, write

MAX_CIRCLES, CIRCLE_MARGIN_PX, SMALLEST_SPOT_PX = 12, 10, 40
AXIS_PX = 40
TITLE_FONT, TITLE_SIZE, LABEL_SIZE = cv2.FONT_HERSHEY_DUPLEX, 0.7, 0.5
Box = tuple[int, int, int, int]  # left, bottom, width, height
INK, WHITE = (0, 0, 0), (255, 255, 255)


@dataclass(frozen=True, slots=True)
class Spot:
    """A circle in a picture around a group of marked pixels: centre (u, v), radius and the number of those pixels."""

    centre: tuple[float, float]
    radius: float
    pixels: int


def find_spots(marks: NDArray[np.bool_]) -> list[Spot]:
    """Group the marked pixels of a mask, shape (H, W), into spots no larger than a twelfth of it, fullest first.

    Each circle encloses the marked pixels of the window that holds most of those in no circle yet.
    """
    side = max(SMALLEST_SPOT_PX, max(marks.shape) // 12)
    left = marks.copy()
    spots = []
    while left.any():
        counts = cv2.boxFilter(left.view(np.uint8), cv2.CV_32F, (side, side), normalize=False, borderType=0)
        v, u = np.unravel_index(int(counts.argmax()), counts.shape)
        rows, cols = (slice(max(0, int(at) - side // 2), int(at) + side // 2 + 1) for at in (v, u))
        points = np.argwhere(left[rows, cols])[:, ::-1] + [[cols.start, rows.start]]  # (N, 2)
        spots.append(_around(left, points))
    return spots


def circle_spots(image: Picture, spots: Sequence[Spot]) -> int:
    """Draw circles around the first spots; return the number of circles."""
    for ink, thickness in ((WHITE, 6), (INK, 2)):
        for spot in spots[:MAX_CIRCLES]:
            u, v = map(round, spot.centre)
            cv2.circle(image, (u, v), round(spot.radius), ink, thickness, cv2.LINE_AA)
    return min(len(spots), MAX_CIRCLES)


def draw_origins(
    image: Picture,
    origins: Mapping[str, tuple[Color, NDArray[np.float64]]],
    *,
    ruler: tuple[float, str] | None = None,
) -> None:
    """Draw the axes of map frames at their origins; for an origin outside, an arrow at the border that points to it.

    Parameters
    ----------
    image
        The picture to draw on.
    origins
        By name, the colour, and the axes of shape (3, 2): the origin, and unit vectors along x and y, in pixels.
    ruler
        Pixels per map unit, and the unit: the label of an origin outside then says how far from the border it lies.
    """
    bounds = np.array(image.shape[1::-1], np.float64) - 1
    taken: list[Box] = []
    for number, (name, (color, axes)) in enumerate(origins.items()):
        if ((axes[0] >= -1) & (axes[0] <= bounds + 1)).all():
            _draw_axes(image, f"origin {name}", color, axes, taken)
        else:
            label = f"origin {name}{_distance_off(axes[0], bounds, ruler)}"
            _point_at(image, label, color, axes[0], taken, aside_px=40 * number)


def _distance_off(point: NDArray[np.float64], bounds: NDArray[np.float64], ruler: tuple[float, str] | None) -> str:
    """Return how far from the picture's border a point outside lies, in map units; nothing without a ruler."""
    if ruler is None:
        return ""
    px_per_unit, unit = ruler
    return f", {math.dist(point, point.clip(0, bounds)) / px_per_unit:.3g} {unit} off"


def with_scale_bar(image: Picture, px_per_unit: float, unit: str) -> Picture:
    """Add a strip below with a scale bar of a round number of map units, at most a quarter of the width."""
    length = round_length(image.shape[1] / 4 / px_per_unit)
    strip = np.full((LEGEND_PX, image.shape[1], 3), 255, np.uint8)
    right, middle = 9 + round(length * px_per_unit), LEGEND_PX // 2 - 2
    cv2.rectangle(strip, (8, middle - 1), (right - 1, middle + 1), INK, cv2.FILLED)
    for u in (8, right - 2):
        cv2.rectangle(strip, (u, middle - 6), (u + 1, middle + 6), INK, cv2.FILLED)
    cv2.putText(strip, f"{length:.10g} {unit}", (right + 8, middle + 5), FONT, LABEL_SIZE, INK, 1, cv2.LINE_AA)
    return np.vstack([image, strip])


def round_length(limit: float) -> float:
    """Return the largest of 1, 2 or 5 times a power of ten that is not above `limit`."""
    power = 10.0 ** math.floor(math.log10(limit))
    return max(step * power for step in (1, 2, 5) if step == 1 or step * power <= limit)


def with_title(image: Picture, title: str) -> Picture:
    """Add a strip above with a title, wrapped into lines."""
    lines = [""]
    for word in title.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and _width(longer) + 16 > image.shape[1]:
            lines.append(word)
        else:
            lines[-1] = longer
    width = max(image.shape[1], *(_width(line) + 16 for line in lines))
    strip = np.full((10 + 28 * len(lines), width, 3), 255, np.uint8)
    for i, line in enumerate(lines):
        cv2.putText(strip, line, (8, 26 + 28 * i), TITLE_FONT, TITLE_SIZE, INK, 1, cv2.LINE_AA)
    return np.vstack([strip, np.pad(image, ((0, 0), (0, width - image.shape[1]), (0, 0)), constant_values=255)])


def _around(left: NDArray[np.bool_], points: NDArray[np.intp]) -> Spot:
    """Return the circle around points, shape (N, 2), with a margin, and clear the mask `left` in it."""
    centre, radius = cv2.minEnclosingCircle(points.astype(np.float32))
    radius += CIRCLE_MARGIN_PX
    disc = np.zeros_like(left, np.uint8)
    cv2.circle(disc, (round(centre[0]), round(centre[1])), round(radius), 1, cv2.FILLED)
    inside = left & (disc > 0)
    left[inside] = False
    left[points[:, 1], points[:, 0]] = False  # the rounded circle may miss some
    return Spot((centre[0], centre[1]), radius, int(inside.sum()))


def _draw_axes(image: Picture, label: str, color: Color, axes: NDArray[np.float64], taken: list[Box]) -> None:
    origin, *along = axes
    for unit, letter in zip(along, "xy", strict=True):
        _arrow(image, origin, origin + AXIS_PX * unit, color)
        _label(image, letter, origin + (AXIS_PX + 10) * unit, color, taken)
    bounds = np.array(image.shape[1::-1], np.float64) - 1
    outer, inner = origin - 18 * (along[0] + along[1]), origin + AXIS_PX * (along[0] + along[1])
    has_room = ((outer >= [40, 12]) & (outer <= bounds - [40, 12])).all()
    _label(image, label, outer if has_room else inner, color, taken)


def _point_at(
    image: Picture, label: str, color: Color, target: NDArray[np.float64], taken: list[Box], *, aside_px: float
) -> None:
    """Draw an arrow inside a picture to its border, towards a point outside, shifted sideways by `aside_px`."""
    bounds = np.array(image.shape[1::-1], np.float64) - 1
    direction = (target - bounds / 2) / math.hypot(*(target - bounds / 2))
    tip = (target.clip(4, bounds - 4) + aside_px * np.array([direction[1], -direction[0]])).clip(4, bounds - 4)
    _arrow(image, tip - AXIS_PX * direction, tip, color)
    _label(image, label, tip - (AXIS_PX + 8 + np.abs(direction) @ [36, 8]) * direction, color, taken)


def _arrow(image: Picture, start: NDArray[np.float64], end: NDArray[np.float64], color: Color) -> None:
    tail, tip = (np.rint(point).astype(int).tolist() for point in (start, end))
    for ink, thickness in ((WHITE, 6), (color, 2)):
        cv2.arrowedLine(image, tail, tip, ink, thickness, cv2.LINE_AA, tipLength=0.25)


def _label(image: Picture, text: str, centre: NDArray[np.float64], color: Color, taken: list[Box]) -> None:
    """Write a label at a point, moved into the picture where it would be cut, and up or down off taken boxes."""
    (width, height), below = cv2.getTextSize(text, FONT, LABEL_SIZE, 3)
    left = min(max(centre[0] - width / 2, 4), max(4, image.shape[1] - width - 4))
    boxes = []
    for shift in (0, -20, 20, -40, 40):
        bottom = min(max(centre[1] + height / 2 + shift, height + 4), image.shape[0] - below - 2)
        boxes.append((round(left), round(bottom), width, height + below))
    box = next((box for box in boxes if not any(_intersect(box, other) for other in taken)), boxes[0])
    taken.append(box)
    write(image, text, box[:2], LABEL_SIZE, color)


def _intersect(box: Box, other: Box) -> bool:
    (left, bottom, width, height), (u, v, w, h) = box, other
    return left < u + w and u < left + width and bottom - height < v and v - h < bottom


def _width(text: str) -> int:
    (width, _), _ = cv2.getTextSize(text, TITLE_FONT, TITLE_SIZE, 1)
    return int(width)

"""Dialects of map_server images: the meaning of pixel values to the different programs that read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import FREE, FREE_AT_MOST, OCCUPIED, OCCUPIED_AT_LEAST, UNKNOWN
from rectmerge.io.image_file import OPAQUE, Pixels, recode

Dialect = Literal["nav2", "nav2-2024", "ros1", "cartographer"]
DIALECTS: tuple[Dialect, ...] = get_args(Dialect)
Mode = Literal["trinary", "scale", "raw"]
UNKNOWN_GREY = 205  # as map savers write it
FREE_GREY = 254  # likewise
WHITE = 255
CARTOGRAPHERS_DEAD_BAND = 0.04  # probability from 0.5: a single hit, 0.55, is a wall; four misses, 0.46, are free


@dataclass(frozen=True, slots=True, kw_only=True)
class Legend:
    """Meaning of an image's pixels by its map_server YAML: `negate`, both thresholds and `mode`.

    Raises
    ------
    InputError
        If a threshold is outside 0..1, or the mode is unknown.

    Notes
    -----
    Map servers do not compare the thresholds. Where free_thresh is not the lower one, a value that is both free and
    occupied is free in dialect "nav2", and occupied in the others.
    """

    negate: bool = False
    occupied_thresh: float = 0.65
    free_thresh: float = 0.196
    mode: Mode = "trinary"

    def __post_init__(self) -> None:
        if self.mode not in get_args(Mode):
            raise InputError(f"mode must be trinary, scale or raw, got {self.mode!r}")
        if not (0 <= self.free_thresh <= 1 and 0 <= self.occupied_thresh <= 1):
            raise InputError(
                f"free_thresh and occupied_thresh must lie in 0..1, "
                f"got {self.free_thresh:g} and {self.occupied_thresh:g}; map_saver writes 0.196 and 0.65"
            )


def occupancy_table(legend: Legend, dialect: Dialect = "nav2", *, full: int = WHITE) -> NDArray[np.int8]:
    """Return the occupancy of each pixel value in a dialect, shape (full + 1,), -1 or 0..100, without alpha.

    Parameters
    ----------
    legend
        The meaning of pixels by the YAML.
    dialect
        - "nav2": nav2_map_server since 2025 (map_io.cpp, loadMapFromFile). A value at a threshold counts as beyond it;
          compared in single precision.
        - "nav2-2024": nav2_map_server before. A value at a threshold lies between.
        - "ros1": map_server 1.17 (image_loader.cpp). As "nav2-2024"; in mode scale 1..99 between the thresholds, and
          in mode raw `negate` counts.
        - "cartographer": the grey that cartographer_ros writes (ros_map.cc) is white minus the probability, 128 where
          nothing was seen. Its YAML has map_saver's thresholds, by which little of it is free; they are ignored.
    full
        The value of white.

    Notes
    -----
    Raw values beyond 100, which map_server and nav2 cannot express, are unknown.
    """
    shade = np.arange(full + 1) / full
    if dialect == "cartographer":
        return _by_probability(shade if legend.negate else 1.0 - shade)
    if legend.mode == "raw":
        level = np.arange(full + 1) * WHITE / full
        level = np.rint(level) if dialect != "ros1" else np.floor(WHITE - level if legend.negate else level)
        return np.where(level <= OCCUPIED, level, UNKNOWN).astype(np.int8)
    if dialect == "nav2":
        return _by_inclusive_thresholds(legend, shade.astype(np.float32))
    if dialect == "ros1":
        level = np.arange(full + 1) * WHITE / full
        occupied = (WHITE - (WHITE - level if legend.negate else level)) / WHITE
        return _by_exclusive_thresholds(legend, occupied, grades=(1, 98))
    return _by_exclusive_thresholds(legend, shade if legend.negate else 1.0 - shade, grades=(0, 100))


def read_cells(pixels: Pixels, legend: Legend, dialect: Dialect = "nav2", *, keep: bool = False) -> NDArray[np.int8]:
    """Turn a map_server image into occupancy, shape (H, W), as a dialect reads it.

    Parameters
    ----------
    pixels
        The decoded image.
    legend, dialect
        As in `occupancy_table`. Colours: "nav2" and "cartographer" take the luma, the others the mean of the channels.
        Alpha: "nav2" reads pixels that are not fully opaque as unknown, except in mode raw. The older ones average it
        with the colours in mode trinary, by which opaque grey 205 turns free. In mode scale "nav2-2024" reads pixels
        that are not opaque as unknown, and "ros1" fully transparent ones between the thresholds.
    keep
        Keep opaque grey 205 unknown in spite of the thresholds.
    """
    alpha = pixels.alpha
    if dialect in ("nav2", "cartographer"):
        occupancy: NDArray[np.int8] = recode(pixels.luma, _kept(occupancy_table(legend, dialect), keep))
        if alpha is not None and legend.mode != "raw":
            occupancy[alpha < OPAQUE] = UNKNOWN
        return occupancy
    if alpha is not None and legend.mode == "trinary":
        sums = pixels.values.astype(np.uint16) * np.uint16(3 * WHITE // pixels.full) + alpha
        table = _kept(occupancy_table(legend, dialect, full=4 * WHITE), keep, 3 * UNKNOWN_GREY + OPAQUE)
        return np.asarray(table[sums])
    table = _kept(occupancy_table(legend, dialect, full=pixels.full), keep, UNKNOWN_GREY * pixels.full // WHITE)
    occupancy = table[pixels.values]
    if alpha is not None and legend.mode == "scale":
        between = (occupancy > FREE) & (occupancy < OCCUPIED)
        occupancy[between & (alpha == 0) if dialect == "ros1" else alpha < OPAQUE] = UNKNOWN
    return occupancy


def grey_levels(legend: Legend) -> NDArray[np.uint8]:
    """Return the grey levels to be written for occupancy 0..100 and for unknown: shape (102,), unknown last.

    They are map_saver's own (254 free, 0 occupied, 205 unknown) where these have that meaning, else the middle one of
    those that have it. In mode scale it is the nearest where thresholds leave too few, and transparency marks unknown.
    In mode raw unknown is 255, the -1 of the message's signed bytes: map_server of ROS 1 copies greys unchanged.

    Raises
    ------
    InputError
        If no grey means free, occupied or unknown by these thresholds.
    """
    table = occupancy_table(legend)
    wanted = np.append(np.arange(OCCUPIED + 1), UNKNOWN)
    if legend.mode == "trinary":
        wanted = np.where(
            wanted >= OCCUPIED_AT_LEAST, OCCUPIED, np.where(wanted > FREE_AT_MOST, UNKNOWN, wanted.clip(-1, 0))
        )
    if legend.mode == "raw":
        return wanted.astype(np.uint8)
    is_exact = legend.mode != "scale"
    return np.array([_grey_level(int(value), table, is_exact=is_exact) for value in wanted], np.uint8)


def _by_probability(occupied: NDArray[np.float64]) -> NDArray[np.int8]:
    sure = np.where(occupied > 0.5, OCCUPIED, FREE)
    return np.where(np.abs(occupied - 0.5) >= CARTOGRAPHERS_DEAD_BAND, sure, UNKNOWN).astype(np.int8)


def _by_inclusive_thresholds(legend: Legend, shade: NDArray[np.float32]) -> NDArray[np.int8]:
    occupied = shade if legend.negate else np.float32(1.0) - shade
    low, high = np.float32(legend.free_thresh), np.float32(legend.occupied_thresh)
    between: NDArray[Any] = np.full(len(shade), UNKNOWN)
    if legend.mode == "scale" and low < high:
        between = np.floor((occupied - low) / (high - low) * np.float32(100) + np.float32(0.5))  # halves away from 0
    sure = np.where(occupied <= low, FREE, between)
    return np.where((occupied >= high) & (occupied > low), OCCUPIED, sure).astype(np.int8)


def _by_exclusive_thresholds(
    legend: Legend, occupied: NDArray[np.float64], *, grades: tuple[int, int]
) -> NDArray[np.int8]:
    """Grade values between the thresholds, in mode scale, from the first of `grades` over a range of the second."""
    low, high = legend.free_thresh, legend.occupied_thresh
    between: NDArray[Any] = np.full(len(occupied), UNKNOWN)
    if legend.mode == "scale" and low < high:
        graded = grades[0] + grades[1] * ((occupied - low) / (high - low))
        between = np.floor(graded) if grades[0] else np.rint(graded)
    sure = np.where(occupied < low, FREE, between)
    return np.where(occupied > high, OCCUPIED, sure).astype(np.int8)


def _kept(table: NDArray[np.int8], keep: bool, unknown_at: int = UNKNOWN_GREY) -> NDArray[np.int8]:
    if keep:
        table[unknown_at] = UNKNOWN
    return table


def _grey_level(value: int, table: NDArray[np.int8], *, is_exact: bool) -> int:
    usual = {FREE: FREE_GREY, OCCUPIED: 0, UNKNOWN: UNKNOWN_GREY}
    if value in usual and (table[usual[value]] == value or (value == UNKNOWN and not is_exact)):
        return usual[value]
    exact = np.flatnonzero(table == value)
    if len(exact) == 0 and (is_exact or value in usual):
        name = {FREE: "free", UNKNOWN: "unknown"}.get(value, "occupied")
        raise InputError(f"no grey level means {name} by these thresholds; widen them")
    nearest = exact if len(exact) else np.flatnonzero(table == table[np.abs(table - value).argmin()])
    return int(nearest[len(nearest) // 2])

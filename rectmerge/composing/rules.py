"""Rules for the value of a merged cell where maps contradict each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from rectmerge.composing.resampling import row_bands
from rectmerge.errors import InputError
from rectmerge.grid import UNKNOWN, OccupancyGrid

Rule = Literal["occupied", "free", "log-odds", "evidence", "newest"]
RULES: tuple[Rule, ...] = get_args(Rule)
SHADING: tuple[Rule, ...] = ("log-odds", "evidence")  # their maps have graded values; the others choose a map's value
SURE_FREE, SURE_OCCUPIED = 0.1192, 0.971  # OctoMap's clamping bounds: the most extreme probabilities of one map
RELIABILITY = 0.9  # the mass that a map gives to a cell's value of 0 or 100; the rest is "unknown"
MAX_SINGLE_PRECISION_LAYERS = 30


def merge_layers(layers: Sequence[NDArray[np.int8]], rule: Rule) -> tuple[NDArray[np.int8], NDArray[np.float32] | None]:
    """Merge occupancy arrays of one shape, at least one; only the rule "evidence" returns a mass of conflict.

    Notes
    -----
    "occupied", "free", "newest": a layer fills the cells that are neither free nor occupied before it, and wins where
    it has a wall, free space, or either.

    "log-odds" reads occupancy as a probability between 0.1192 and 0.971 (A. Hornung et al., Autonomous Robots 2013, DOI
    10.1007/s10514-012-9321-0), so a wall outweighs one map's free space, but not two maps'.

    "evidence": see `combine_evidence`.
    """
    if rule == "evidence":
        return combine_evidence(layers)
    return (_sum_log_odds(layers) if rule == "log-odds" else _lay_over(layers, rule)), None


def combine_evidence(
    layers: Sequence[NDArray[np.int8]], *, reliability: float = RELIABILITY
) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Combine layers by Dempster's rule over {free, occupied}; the order does not matter.

    Parameters
    ----------
    layers
        Occupancy arrays of one shape, at least one.
    reliability
        Above 0 and below 1: the mass that a map gives to "occupied" at 100 and to "free" at 0. It falls to none at 50;
        the rest is "unknown", either of the two.

    Returns
    -------
    tuple
        The merged occupancy, and the mass of conflict: float32, 0..1, the mass that Dempster's rule divides out. It is
        0 where fewer than two maps know a cell, and `reliability` squared where one map is sure of a wall and one of
        free space. Such a cell becomes 50, neither free nor occupied, as the masses are equal; among more maps the
        majority wins.

    Raises
    ------
    InputError
        If the reliability is not above 0 and below 1.

    Notes
    -----
    G. Shafer, A Mathematical Theory of Evidence, Princeton University Press 1976; evidential grids: J. Moras,
    V. Cherfaoui, P. Bonnifait, Credibilist Occupancy Grids for Vehicle Perception in Dynamic Environments, ICRA 2011,
    pp. 84-89. Commonalities are multiplied; the occupancy is the pignistic probability, which gives half of the unknown
    mass to either side.
    """
    if not 0 < reliability < 1:
        raise InputError(f"reliability must lie above 0 and below 1, got {reliability}")
    belief = 2 * np.arange(101) / 100.0 - 1.0  # -1 free, 0 nothing, 1 occupied
    occupied, free = reliability * belief.clip(0), reliability * (-belief).clip(0)
    unknown = 1.0 - occupied - free
    # products over many layers would vanish in single precision
    precision = np.float32 if len(layers) <= MAX_SINGLE_PRECISION_LAYERS else np.float64
    q_occupied, q_free, q_either = (
        _product(np.append(q, 1.0).astype(precision), layers)  # [-1] is unknown, all of whose commonalities are 1
        for q in (occupied + unknown, free + unknown, unknown)
    )
    agreed = q_occupied + q_free - q_either
    merged = np.rint(100.0 * (q_occupied - q_either / 2) / agreed).astype(np.int8)
    known, single = _known_by(layers)
    return np.where(known > 1, merged, single), np.where(known > 1, 1.0 - agreed, 0.0).clip(0.0).astype(np.float32)


def _lay_over(layers: Sequence[NDArray[np.int8]], rule: Rule) -> NDArray[np.int8]:
    """Let each later layer fill unknown cells, and win where the rule says so."""
    merged = layers[0].copy()
    for rows in row_bands(0, *merged.shape):  # in the processor's cache
        merged[rows] = _band_over([layer[rows] for layer in layers], rule)
    return merged


def _band_over(layers: Sequence[NDArray[np.int8]], rule: Rule) -> NDArray[np.int8]:
    merged = layers[0]
    for layer in layers[1:]:
        old, new = OccupancyGrid(merged), OccupancyGrid(layer)
        if rule == "newest":
            wins = ~new.unknown
        else:
            wins = new.occupied & ~old.occupied if rule == "occupied" else new.free & ~old.free
        fills = (old.unknown & ~new.unknown) | ((merged == UNKNOWN) & (layer != UNKNOWN))
        merged = np.where(wins | fills, layer, merged)
    return merged


def _sum_log_odds(layers: Sequence[NDArray[np.int8]]) -> NDArray[np.int8]:
    probability = np.clip(np.arange(101) / 100.0, SURE_FREE, SURE_OCCUPIED)
    log_odds = np.append(np.log(probability / (1 - probability)), 0.0).astype(np.float32)  # [-1] is unknown
    total = np.zeros(layers[0].shape, np.float32)
    for layer in layers:
        total += log_odds[layer]
    summed = np.rint(100.0 / (1.0 + np.exp(-total))).astype(np.int8)
    known, single = _known_by(layers)
    return np.where(known > 1, summed, single)


def _product(table: NDArray[np.floating], layers: Sequence[NDArray[np.int8]]) -> NDArray[np.floating]:
    """Multiply over the layers the entries of a table of 102, the last for unknown cells."""
    product = table[layers[0]]
    for layer in layers[1:]:
        product *= table[layer]
    return product


def _known_by(layers: Sequence[NDArray[np.int8]]) -> tuple[NDArray[np.uint16], NDArray[np.int8]]:
    """Count the maps that know each cell; where it is one, the second array has the value of that map."""
    known, single = np.zeros(layers[0].shape, np.uint16), np.full(layers[0].shape, UNKNOWN, np.int8)
    for layer in layers:
        known += layer != UNKNOWN
        single = np.maximum(single, layer)
    return known, single

"""Fit of noise levels 1 and 2 to the descriptors of real maps, by search along one strength after the other."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from scenarios.corruption.map_noise import MapNoise
from scenarios.studies.map_population import DescribedMap, MappedMission, values_of

# 1: more is worse, -1: less is worse, 0: neither, so that both levels aim at the middle of the real maps
WORSE: Mapping[str, int] = MappingProxyType(
    {
        "specks": 1,
        "speck_clumping": 0,
        "specks_near_walls": 0,
        "pinholes": 1,
        "holes": 1,
        "slivers": 1,
        "strays": 1,
        "frontier_share": 1,
        "blobs": 1,
        "wall_thickness_cells": 1,
        "wall_roughness_cells": 1,
        "short_gaps": 1,
        "gaps": 1,
        "straightness": -1,
    }
)
AIMS = MappingProxyType({1: 0.375, 2: 0.625})  # share of the real maps that are better than the median of a level
STEPS = (2.0, 1.4)  # factors by which a strength is tried larger and smaller, in turn; source: hand
SPREADS = (0.4, 0.7, 1.0, 1.3)
TAILS = (10, 90)  # percentiles that both levels together share with the real maps


def aim_of(name: str, level: int) -> tuple[float, float, float]:
    """Return the least, the wanted and the highest share of real maps with less of a descriptor than a level's median.

    Examples
    --------
    >>> aim_of("specks", 1), aim_of("straightness", 1), aim_of("speck_clumping", 2)
    ((0.25, 0.375, 0.5), (0.5, 0.625, 0.75), (0.25, 0.5, 0.75))
    """
    if WORSE[name] == 0:
        return 0.25, 0.5, 0.75
    aim = AIMS[level] if WORSE[name] > 0 else 1 - AIMS[level]
    return aim - 0.125, aim, aim + 0.125


def rank_among(values: NDArray[np.float64], value: float) -> float:
    """Return the share of values below one, those equal to it counted half."""
    return float((values < value).mean() + (values == value).mean() / 2)


def level_loss(real: Sequence[DescribedMap], simulated: Sequence[DescribedMap], level: int) -> float:
    """Return the mean squared distance of the medians of a level from their aims, in ranks among real maps."""
    off = [
        rank_among(values_of(real, name), float(np.median(values_of(simulated, name)))) - aim_of(name, level)[1]
        for name in WORSE
        if len(values_of(simulated, name))
    ]
    return float(np.mean(np.square(off)))


def tail_loss(real: Sequence[DescribedMap], simulated: Sequence[DescribedMap]) -> float:
    """Return the mean squared distance of the 10 and 90 % of maps from those of real ones, in ranks among real maps."""
    off = [
        rank_among(values_of(real, name), float(np.percentile(values_of(simulated, name), tail))) - tail / 100
        for name in WORSE
        for tail in TAILS
    ]
    return float(np.mean(np.square(off)))


def fit_levels(
    real: Sequence[DescribedMap],
    missions: Sequence[MappedMission],
    start: Mapping[int, MapNoise],
    *,
    on_step: Callable[[str], None] = lambda text: None,
) -> dict[int, MapNoise]:
    """Fit the strengths of levels 1 and 2, and the spread that both share.

    Parameters
    ----------
    real
        Maps of robots.
    missions
        Missions that are mapped anew under every trial.
    start
        The noise of levels 1 and 2 where the search begins.
    on_step
        Called with a line per improvement.
    """
    levels = dict(start)
    for factor in STEPS:
        for level in levels:
            loss_of = functools.partial(_loss, real, missions, level)
            levels[level] = _search(levels[level], factor, loss_of, on_step)
        spread_losses = {}
        for spread in SPREADS:
            mixed = [
                mission.described(replace(noise, spread=spread)) for noise in levels.values() for mission in missions
            ]
            spread_losses[spread] = tail_loss(real, mixed)
        best = min(spread_losses, key=spread_losses.__getitem__)
        on_step(f"spread {best}: loss of the tails {spread_losses[best]:.4f}")
        levels = {level: replace(noise, spread=best) for level, noise in levels.items()}
    return levels


def _loss(real: Sequence[DescribedMap], missions: Sequence[MappedMission], level: int, noise: MapNoise) -> float:
    return level_loss(real, [mission.described(noise) for mission in missions], level)


def _search(
    noise: MapNoise, factor: float, loss_of: Callable[[MapNoise], float], on_step: Callable[[str], None]
) -> MapNoise:
    """Try every strength larger and smaller by a factor, once, and keep what lowers the loss."""
    least = loss_of(noise)
    on_step(f"loss {least:.4f}")
    for name in (field.name for field in fields(noise) if field.name != "spread"):
        for step in (factor, 1 / factor):
            trial = replace(noise, **{name: round(getattr(noise, name) * step, 5)})
            while (loss := loss_of(trial)) < least:
                noise, least = trial, loss
                on_step(f"loss {least:.4f}: {name} = {getattr(noise, name):g}")
                trial = replace(noise, **{name: round(getattr(noise, name) * step, 5)})
    return noise

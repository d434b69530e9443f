"""Bends of real maps that people marked by hand: better where they bend, none where they are rigid."""

import os
from pathlib import Path

import numpy as np
import pytest

import rectmerge as rm
from scenarios.dataset.reader import open_dataset

pytestmark = [
    pytest.mark.real,
    pytest.mark.skipif(
        "RECTMERGE_REAL_MAPS" not in os.environ, reason="RECTMERGE_REAL_MAPS does not name the folder of the real maps"
    ),
]


def pairs(name, variant=None, *, every=1):
    rows = open_dataset(Path(os.environ["RECTMERGE_REAL_MAPS"]) / name)
    chosen = [row for row in rows if row.related and row.info.get("variant") == (variant or row.info.get("variant"))]
    return [pair for row in chosen[::every] for pair in row.pairs()]


@pytest.mark.parametrize(("variant", "every"), [("sensor-hard", 3), ("layout-hard", 2)])
def test_no_bent_pair_gets_worse_and_most_get_better(variant, every):
    ratios = []
    for pair in pairs("real_maps", variant, every=every):
        bend = rm.unbend(pair.a, pair.b, pair.pixels)  # from the best similarity there is
        at_a, at_b = pair.control_points[:, :2], pair.control_points[:, 2:]
        error = pair.residual_px
        if bend:
            error = float(np.sqrt(((bend.warp.apply(at_b) - at_a) ** 2).sum(axis=1).mean()))
        ratios.append(error / pair.residual_px)

    assert max(ratios) < 1.15
    assert np.median(ratios) < 0.85


def test_rigid_laser_maps_are_not_bent():
    bent = [pair.pair_id for pair in pairs("real_lasers") if rm.unbend(pair.a, pair.b, pair.pixels)]

    assert bent == []

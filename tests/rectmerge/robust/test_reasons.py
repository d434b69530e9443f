import dataclasses
from collections import Counter

import cv2
import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.analysis.overlap import Agreement
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid
from rectmerge.robust import reasons
from rectmerge.robust.params import ReasonParams
from rectmerge.robust.reasons import MapFacts
from rectmerge.robust.verdict import NO_AGREEMENT, Evidence
from scenarios.corruption import corrupt
from tests.rectmerge.robust import plans

PARAMS = ReasonParams()
LITTLE = NO_AGREEMENT._replace(overlap=0.2, violations=0.4)
POOR = Evidence(plausibility=-5.0, likelihood=50.0, agreement=LITTLE)
SEEN = Agreement(overlap=0.2, iou=0.1, conflict=0.4)
FINE = MapFacts(free_cells=20_000, roughness=0.05)
TINY, ROUGH = dataclasses.replace(FINE, free_cells=300), dataclasses.replace(FINE, roughness=0.4)


@pytest.mark.parametrize(
    ("change", "a", "b", "word"),
    [
        ({"plausibility": 9.0, "is_at_limit": True}, FINE, FINE, "--scale"),
        ({"plausibility": 9.0, "slack_cells": 9.0}, FINE, FINE, "slide by 9 cells"),
        ({}, FINE, TINY, "map B shows too little free space"),
        ({}, ROUGH, FINE, "map A is too noisy (40%"),
        ({"agreement": LITTLE._replace(near=0.8, matched=0.4), "support": 0.5}, FINE, FINE, "bent"),
        ({"likelihood": -3.0}, FINE, FINE, "different places"),
        ({}, FINE, FINE, "40% of the walls contradicted): these seem to be maps of different places"),
    ],
)
def test_the_first_cause_is_named(change, a, b, word):
    assert word in reasons.not_accepted("rejected", dataclasses.replace(POOR, **change), SEEN, {"A": a, "B": b}, PARAMS)


@pytest.mark.parametrize(
    ("rest_log_odds", "mirror_log_odds", "words"),
    [
        (6.0, -9.0, "more than one placement"),
        (4.5, 5.5, "mirror image"),
        (
            5.2,
            5.5,
            "more than one placement",
        ),  # half a turn is a mirror image of a mirror image: no cause is singled out
        (4.5, 4.0, "candidate 1 leads all others"),
    ],
)
def test_what_keeps_the_best_placement_from_being_accepted_is_told(rest_log_odds, mirror_log_odds, words):
    doubtful = dataclasses.replace(POOR, plausibility=6.0, rest_log_odds=rest_log_odds, mirror_log_odds=mirror_log_odds)

    assert words in reasons.not_accepted("ambiguous", doubtful, SEEN, {"A": FINE, "B": FINE}, PARAMS)


@pytest.mark.parametrize(("overlap", "conflict"), [(0.08, 0.05), (0.4, 0.16), (0.02, 0.0)])
def test_no_cause_is_named_where_a_right_and_a_wrong_placement_measure_alike(overlap, conflict):
    seen = Agreement(overlap=overlap, iou=0.1, conflict=conflict)

    said = reasons.not_accepted("rejected", POOR, seen, {"A": FINE, "B": FINE}, PARAMS)

    assert f"overlap {overlap:.0%} of the smaller map, {conflict:.0%} of the walls contradicted" in said
    for cause in ("different places", "share no room", "are bent"):
        assert cause not in said


def test_unlike_maps_are_not_said_to_be_bent():
    beside = dataclasses.replace(POOR, agreement=LITTLE._replace(near=0.9, matched=0.2), support=0.5)
    unlike = dataclasses.replace(beside, likelihood=-3.0)

    said, other = (
        reasons.not_accepted("rejected", each, SEEN, {"A": FINE, "B": FINE}, PARAMS) for each in (beside, unlike)
    )
    assert "70% of the walls lie beside each other" in said
    assert "if the maps show one place, they are bent" in said
    assert "bent" not in other


def test_bent_maps_that_are_accepted_are_told_to_be():
    fine = dataclasses.replace(POOR, plausibility=9.0, agreement=LITTLE._replace(near=0.95, matched=0.9), support=1.0)
    bent = dataclasses.replace(fine, agreement=fine.agreement._replace(matched=0.5))

    assert "bent" not in reasons.accepted(fine, SEEN, PARAMS)
    assert "bent" in reasons.accepted(bent, SEEN, PARAMS)


def mirrored(seed):
    rooms = plans.office(seed)
    return plans.see(rooms, degrees=30, noise=1, seed=1).grid, plans.flipped(plans.see(rooms, degrees=190, noise=1))


def unrelated(seed):
    return plans.see(plans.office(seed), degrees=30, noise=1).grid, plans.see(plans.office(seed + 500), noise=1).grid


def no_shared_room(seed):
    rooms = plans.office(seed, (600.0, 228.0))
    left, right = (-8, -8, 240, 244), (360, -8, 248, 244)
    return plans.see(rooms, window=left, degrees=30).grid, plans.see(rooms, window=right, degrees=90).grid


def symmetric(seed):
    """Both ends of a row of equal cells: one end looks like the other."""
    rooms = [plans.box(60.0 * k, 0.0, 56.0, 70.0) for k in range(8)]
    doors = [plans.box(60.0 * k + 20, 69.0, 14.0, 6.0) for k in range(8)]
    rooms += [*doors, plans.box(0.0, 74.0, 476.0, 26.0)]
    left, right = (-8, -8, 308, 120), (180, -8, 308, 120)
    return plans.see(rooms, window=left, degrees=20.0 * seed, noise=1).grid, plans.see(rooms, window=right).grid


def bent(seed):
    rooms = plans.office(seed)
    damage = [("bend", 10.0), ("kink", 8.0)]
    b = plans.see(rooms, degrees=120, scale=1.2)
    return plans.see(rooms, degrees=20).grid, corrupt(b.grid, damage, seed=seed).grid


def too_noisy(seed):
    rooms, rng = plans.office(seed), np.random.default_rng(seed)
    a, b = plans.see(rooms, degrees=20).grid, plans.see(rooms, degrees=100).grid
    noise = rng.random(b.shape)
    cells = np.where(~b.unknown & (noise < 0.25), OCCUPIED, np.where(~b.unknown & (noise > 0.6), FREE, b.occupancy))
    return a, OccupancyGrid(cells.astype(np.int8))


def wrong_resolution(seed):
    rooms = plans.office(seed)
    a = plans.see(rooms, degrees=20, noise=1, resolution=0.05).grid
    return a, plans.see(rooms, degrees=100, scale=1.1, noise=1, resolution=0.11 if seed % 2 else 0.0275).grid


def too_little_space(seed):
    rooms = plans.office(seed)
    b = plans.see(rooms, degrees=20)
    free = np.argwhere(cv2.erode(b.grid.free.view(np.uint8), np.ones((9, 9), np.uint8)))
    row, col = free[len(free) // 2]
    return plans.see(rooms, degrees=70).grid, OccupancyGrid(
        np.ascontiguousarray(b.grid.occupancy[max(0, row - 14) : row + 14, max(0, col - 14) : col + 14])
    )


PLANTED = {
    mirrored: ("mirrored",),
    unrelated: ("different places", "to tell one place from two", "too little speaks for it"),
    no_shared_room: ("different places", "to tell one place from two", "too little speaks for it"),
    symmetric: ("more than one placement",),
    bent: ("bent",),
    too_noisy: ("too noisy",),
    wrong_resolution: ("is one resolution wrong",),
    too_little_space: ("too little free space",),
}


@pytest.mark.slow
def test_the_reason_names_the_planted_fault_nearly_always():
    named, said = Counter(), []
    for plant, words in PLANTED.items():
        for seed in range(5):
            alignment = align(*plant(seed))
            is_named = any(word in alignment.reason for word in words)
            named[plant.__name__] += is_named
            if not is_named:
                said.append(f"{plant.__name__} {seed}: {alignment.verdict}: {alignment.reason}")

    assert sum(named.values()) >= 0.9 * 40, "\n".join([str(named), *said])

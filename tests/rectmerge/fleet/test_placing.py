import dataclasses
import itertools

import numpy as np
import pytest

from rectmerge.alignment import Alignment, Candidate
from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.evidence import Evidence
from rectmerge.fleet.map_sample import MapSample
from rectmerge.fleet.params import EvidenceParams, PlaceParams
from rectmerge.fleet.placing import place
from tests.rectmerge.fleet.fleets import Oracle, fleet

PARAMS = PlaceParams(iterations=40)


def edges_of(made, noise, seed=0):
    """Candidates of all overlapping pairs of a fleet, with some noise."""
    samples = [MapSample.from_grid(grid) for grid in made.maps.values()]
    evidence = Evidence(samples, EvidenceParams(), lambda pair, placement: 0.0)
    oracle = Oracle(made, noise=noise)
    rng = np.random.default_rng(seed)
    for (i, a), (j, b) in itertools.combinations(enumerate(made.maps), 2):
        found = oracle.align(made.maps[a], made.maps[b], scale=(0.1, 10), rng=rng)
        if found:
            evidence.add((i, j), found, is_swapped=False)
    return samples, [candidates[0] for candidates in evidence.candidates.values()]


def errors(made, poses):
    names = list(made.maps)
    return [made.error((poses[0].inverse() @ poses[k]).to_similarity(), names[0], name) for k, name in enumerate(names)]


def test_exact_pairs_give_the_true_placements_wherever_the_poses_begin():
    made = fleet(1, home=6, other=0)
    samples, edges = edges_of(made, 0.0)
    rng = np.random.default_rng(0)
    start = [
        ComplexSimilarity.from_similarity(pose) @ ComplexSimilarity(1.0 + 0j, complex(*rng.normal(0, 2, 2)))
        for pose in made.poses.values()
    ]

    poses = place(samples, start, edges, {0}, PARAMS)

    assert poses[0] == pytest.approx(start[0])
    assert max(errors(made, poses)) < 1e-6


def test_cycles_make_placements_better_than_chains():
    joint, chained = [], []
    for seed in range(6):
        made = fleet(1, home=6, other=0)
        samples, edges = edges_of(made, 0.004, seed)
        chain = [edge for edge in edges if edge.pair[1] == edge.pair[0] + 1]
        start = [ComplexSimilarity.from_similarity(pose) for pose in made.poses.values()]
        joint.append(np.mean(errors(made, place(samples, start, edges, {0}, PARAMS))))
        chained.append(np.mean(errors(made, place(samples, start, chain, {0}, PARAMS))))

    assert np.mean(joint) < 0.9 * np.mean(chained)


def test_scales_are_not_drawn_towards_small_ones():
    logs = []
    for seed in range(12):
        made = fleet(3, home=8, other=0)
        samples, edges = edges_of(made, 0.006, seed)
        start = [ComplexSimilarity.from_similarity(pose) for pose in made.poses.values()]
        poses = place(samples, start, edges, {0}, PARAMS)
        truth = [made.b_to_a("home0", name).scale for name in made.maps]
        logs.append([np.log((poses[0].inverse() @ poses[k]).scale / truth[k]) for k in range(8)])

    mean, spread = np.mean(logs), np.std(np.mean(logs, axis=1)) / np.sqrt(len(logs))
    assert abs(mean) < max(3 * spread, 0.002)


def test_a_wrong_pair_among_right_ones_moves_little():
    made = fleet(1, home=6, other=0)
    samples, edges = edges_of(made, 0.0)
    index = next(k for k, edge in enumerate(edges) if edge.pair == (2, 3))
    edges[index] = dataclasses.replace(edges[index], images=edges[index].images + 15.0)
    start = [ComplexSimilarity.from_similarity(pose) for pose in made.poses.values()]

    poses = place(samples, start, edges, {0}, PARAMS)

    assert max(errors(made, poses)) < 0.005


def test_maps_that_no_pair_connects_with_the_reference_keep_their_place():
    made = fleet(1, home=6, other=0)
    samples, edges = edges_of(made, 0.0)
    start = [ComplexSimilarity.from_similarity(pose) for pose in made.poses.values()]

    poses = place(samples, start, [edge for edge in edges if set(edge.pair) in ({0, 1}, {4, 5})], {0}, PARAMS)

    assert set(poses) == {0, 1}


def test_a_swapped_answer_is_the_same_evidence():
    made = fleet(1, home=2, other=0, side=200)
    samples = [MapSample.from_grid(grid) for grid in made.maps.values()]
    a, b = made.maps.values()
    there, back = (Evidence(samples, EvidenceParams(), lambda pair, placement: 0.0) for _ in range(2))
    truth = made.b_to_a("home0", "home1")
    for evidence, maps, pixels, is_swapped in ((there, (a, b), truth, False), (back, (b, a), truth.inverse(), True)):
        candidate = Candidate.from_pixels(pixels, *maps, confidence=0.9)
        found = Alignment(verdict="accepted", reason="", method="", candidates=(candidate,), confidence=0.9)
        evidence.add((0, 1), found, is_swapped=is_swapped)

    one, other = there.candidates[0, 1][0], back.candidates[0, 1][0]
    assert one.alone == other.alone == pytest.approx(np.log(9))
    assert one.images == pytest.approx(other.images)


def test_poses_that_begin_at_a_wrong_pair_end_at_those_that_agree():
    made = fleet(1, home=4, other=0, side=190)
    samples, edges = edges_of(made, 0.0)
    start = [ComplexSimilarity.from_similarity(pose) for pose in made.poses.values()]
    lie = next(edge for edge in edges if edge.pair == (0, 3))
    moved = ComplexSimilarity(1.0 + 0j, 0.035 * lie.span * (1 + 0j)) @ lie.placement  # it still agrees, but barely
    wrong = dataclasses.replace(lie, placement=moved, images=moved.apply(lie.points))
    start[3] = start[0] @ moved

    poses = place(samples, start, [wrong if edge is lie else edge for edge in edges], {0}, PARAMS)

    assert max(errors(made, poses)) < 0.002

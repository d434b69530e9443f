import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from rectmerge.aligning import align, searched_scale
from rectmerge.alignment import Alignment, Candidate
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing


@dataclass(frozen=True)
class Scripted:
    """Accepts a fixed placement if its scale may be searched, and remembers what it was asked."""

    name: str = "scripted"
    pixels: Similarity = field(default_factory=Similarity)
    confidence: float | None = None  # drawn where it is None
    least_width: float = 1.0  # factor between the bounds of a search that finds it
    asked: list[tuple[float, float]] = field(default_factory=list)

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        self.asked.append(scale)
        if not scale[0] <= self.pixels.scale <= scale[1] or scale[1] / scale[0] < self.least_width:
            return Alignment(verdict="rejected", reason="nothing fits", method=self.name)
        candidate = Candidate.from_pixels(self.pixels, a, b, confidence=self.confidence or rng.random())
        return Alignment(
            verdict="accepted",
            reason="fits",
            method=self.name,
            candidates=(candidate,),
            confidence=candidate.confidence,
        )


@dataclass(frozen=True)
class Judge(Scripted):
    """Judges placements, so that its confidence is a probability."""

    def align_by(self, hint, a, b, *, scale, rng):
        return self.align(a, b, scale=scale, rng=rng)


def test_auto_expects_the_ratio_of_the_resolutions():
    solver = Scripted(pixels=Similarity(2.0))

    alignment = align(drawing.building(resolution=0.05), drawing.building(resolution=0.10), method=solver)

    assert solver.asked == [pytest.approx((2 / 1.02, 2.04))]
    assert (alignment.scale.expected, alignment.scale.found, alignment.scale.source) == (2.0, 2.0, "resolution")
    assert alignment.unit == "m"


def test_what_is_searched_for_swapped_maps_is_the_inverse():
    solver, a, b = (
        Scripted(pixels=Similarity(9.0)),
        drawing.building(resolution=0.05),
        drawing.building(resolution=0.08),
    )

    for maps in ((a, b), (b, a)):
        align(*maps, method=solver)

    (low, high), _, back, _ = solver.asked
    assert back == pytest.approx((1 / high, 1 / low))


def test_a_scale_that_leaves_out_what_the_resolutions_tell_is_named_where_nothing_is_found():
    a, b = drawing.building(resolution=0.05), drawing.building(resolution=0.06)

    alignment = align(a, b, method=Scripted(pixels=Similarity(1.2)), scale=1.5)

    assert alignment.reason == "nothing fits; the resolutions give a scale of 1.2, which was not searched"
    assert align(a, b, method=Scripted(pixels=Similarity(9.0)), scale=(1.1, 1.5)).reason == "nothing fits"


@pytest.mark.parametrize(("confidence", "verdict"), [(0.96, "accepted"), (0.94, "ambiguous")])
def test_beside_the_ratio_of_the_resolutions_an_answer_has_to_be_surer_and_names_both_numbers(confidence, verdict):
    solver = Judge(pixels=Similarity(1.11), confidence=confidence)

    alignment = align(drawing.building(resolution=0.05), drawing.building(resolution=0.05), method=solver)

    assert (alignment.verdict, alignment.scale.source) == (verdict, "search")
    assert "the files' resolutions say 1, the walls 1.11" in alignment.reason
    assert alignment.confidence == (confidence if verdict == "accepted" else 0.5)


def test_far_from_the_ratio_of_the_resolutions_nothing_is_accepted_but_named_as_a_candidate():
    solver = Judge(pixels=Similarity(1.5), confidence=1.0)

    alignment = align(drawing.building(resolution=0.05), drawing.building(resolution=0.05), method=solver)

    assert (alignment.verdict, alignment.scale.source, alignment.confidence) == ("ambiguous", "search", 0.5)
    assert alignment.method_verdict == "accepted"
    assert alignment.candidates[0].pixels.scale == 1.5
    assert alignment.candidates[0].confidence == 0.5
    assert "1.50 times" in alignment.reason
    assert "is one resolution wrong? B's would be 0.075 rather than 0.05, or A's 0.0333 rather than" in alignment.reason


def test_a_method_that_is_no_judge_is_left_to_its_judge_beside_the_resolutions():
    maps = drawing.building(resolution=0.05), drawing.building(resolution=0.05)

    alignment = align(*maps, method=Scripted(pixels=Similarity(1.5), confidence=0.3))

    assert (alignment.verdict, alignment.reason, alignment.confidence) == ("accepted", "fits", 0.3)


def test_a_search_that_knew_the_scale_has_the_last_word_on_what_fits_there():
    refusing = Scripted(pixels=Similarity(1.0), confidence=1.0, least_width=2.0)

    alignment = align(drawing.building(resolution=0.05), drawing.building(resolution=0.05), method=refusing)

    assert (alignment.verdict, alignment.reason, alignment.scale.source) == ("rejected", "nothing fits", "resolution")
    assert len(refusing.asked) == 2


@pytest.mark.parametrize(("b", "bounds"), [(0.05, [(0.5, 2.0)]), (0.2, [(4 / 1.15, 4 * 1.15), (0.5, 2.0)])])
def test_what_is_searched_where_the_resolutions_find_nothing(b, bounds):
    solver = Scripted(pixels=Similarity(9.0))

    align(drawing.building(resolution=0.05), drawing.building(resolution=b), method=solver)

    assert solver.asked[1:] == [pytest.approx(each) for each in bounds]


@pytest.mark.parametrize(("b", "found"), [(0.05, 1.0), (0.05, 1.5), (0.2, 4.4), (0.2, 1.0)])
def test_the_searched_scale_of_a_report_holds_what_was_found(b, found):
    alignment = align(
        drawing.building(resolution=0.05), drawing.building(resolution=b), method=Scripted(pixels=Similarity(found))
    )

    low, high = searched_scale("auto", alignment.scale)

    assert low <= found <= high


def test_auto_keeps_the_refusal_when_a_free_search_finds_nothing_either():
    alignment = align(
        drawing.building(resolution=0.05), drawing.building(resolution=0.05), method=Scripted(pixels=Similarity(9.0))
    )

    assert (alignment.verdict, alignment.reason, alignment.scale.source) == ("rejected", "nothing fits", "resolution")


@pytest.mark.parametrize(
    ("scale", "bounds", "source"),
    [
        ("auto", (0.5, 2.0), "search"),
        ("free", (0.5, 2.0), "search"),
        ((0.9, 1.1), (0.9, 1.1), "given"),
        (1, (1, 1), "given"),
    ],
)
def test_bounds_are_what_was_asked_for_where_a_resolution_is_missing(scale, bounds, source):
    solver = Scripted()

    alignment = align(drawing.building(), drawing.building(resolution=0.05), method=solver, scale=scale)

    assert solver.asked == [bounds]
    assert (alignment.scale.expected, alignment.scale.source) == (None, source)
    assert alignment.unit == "cells"


@pytest.mark.parametrize("scale", ["wide", 0, -1.0, math.nan, math.inf, (2.0, 1.0), (0.0, 1.0), (1.0, math.inf), None])
def test_a_scale_that_cannot_be_is_refused(scale):
    with pytest.raises(InputError, match="scale"):
        align(drawing.building(), drawing.building(), method=Scripted(), scale=scale)


def test_the_seed_alone_decides_what_is_random():
    a = drawing.building()

    first, same, other = (align(a, a, method=Scripted(), seed=seed).candidates[0].confidence for seed in (1, 1, 2))

    assert first == same != other


@pytest.mark.parametrize("name", ["A", "B"])
def test_a_map_without_free_space_is_named_without_asking_the_method(name):
    solver, empty, full = Scripted(), OccupancyGrid(np.full((9, 9), -1, np.int8)), drawing.building()

    alignment = align(*((empty, full) if name == "A" else (full, empty)), method=solver)

    assert not alignment
    assert f"map {name}" in alignment.reason
    assert not solver.asked

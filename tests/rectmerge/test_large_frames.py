"""Maps in large frames of unknown cells: they cost no more than the maps, and have the same answers."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import UNKNOWN, OccupancyGrid, known_part
from rectmerge.similarity import Similarity
from tests import drawing


def framed(grid, top, left, bottom, right):
    """The map in a frame of unknown cells, in the same map frame."""
    occupancy = np.pad(grid.occupancy, ((top, bottom), (left, right)), constant_values=UNKNOWN)
    x, y = grid.pixel_to_map([-0.5 - left, grid.shape[0] - 0.5 + bottom])
    return replace(grid, occupancy=occupancy, origin=(float(x), float(y), grid.origin[2]))


@dataclass(frozen=True)
class Recorder:
    """Method that remembers the shapes of the maps and places B a little beside A."""

    name: str = "recorder"
    shapes: list[tuple[int, int]] = field(default_factory=list)

    def align(self, a, b, *, scale, rng):
        self.shapes.extend([a.shape, b.shape])
        candidate = Candidate.from_pixels(Similarity(1.0, 0.3, 5.0, -2.0), a, b, confidence=0.9)
        return Alignment(verdict="accepted", reason="", method=self.name, candidates=(candidate,))


@pytest.mark.parametrize("resolution", [0.05, None])
def test_the_known_part_has_every_known_cell_where_it_was(resolution):
    a = drawing.building(resolution=resolution, origin=(-2.0, 3.0, 0.7))
    part = known_part(framed(a, 30, 7, 11, 90))

    assert np.count_nonzero(part.occupancy != UNKNOWN) == np.count_nonzero(a.occupancy != UNKNOWN)
    assert (part.occupancy[[0, -1]] != UNKNOWN).any(axis=1).all()
    assert (part.occupancy[:, [0, -1]] != UNKNOWN).any(axis=0).all()
    wall = np.argwhere(a.occupied)[17]
    at = np.rint(part.map_to_pixel(a.pixel_to_map(wall[::-1]))).astype(int)
    assert part.occupied[at[1], at[0]]


def test_a_map_without_known_cells_is_its_own_known_part():
    grid = OccupancyGrid(np.full((3, 4), UNKNOWN, np.int8))

    assert known_part(grid) is grid


def test_a_method_sees_no_large_frame_and_its_placement_is_on_the_whole_maps():
    recorder, a, b = Recorder(), drawing.building(), drawing.building()
    wide = framed(b, 400, 300, 500, 200)
    found = align(a, wide, method=recorder).candidates[0]

    assert recorder.shapes == [a.shape, known_part(b).shape]
    plain = align(a, known_part(b), method=recorder).candidates[0]
    assert found.b_to_a == plain.b_to_a
    corner = wide.map_to_pixel(a.pixel_to_map([40.0, 30.0]))  # a and b have one map frame
    same = known_part(b).map_to_pixel(a.pixel_to_map([40.0, 30.0]))
    assert found.pixels.apply(corner) == pytest.approx(plain.pixels.apply(same))


def test_a_usual_margin_stays():
    recorder, a = Recorder(), drawing.building()
    align(framed(a, 10, 10, 10, 10), a, method=recorder)

    assert recorder.shapes == [(a.shape[0] + 20, a.shape[1] + 20), a.shape]


def test_the_default_method_answers_the_same_in_a_large_frame():
    a, (b, _) = known_part(drawing.building()), drawing.tilted(25.0)
    plain, framed_answer = align(a, known_part(b)), align(framed(a, 0, 400, 300, 0), framed(b, 600, 600, 0, 0))

    assert framed_answer.verdict == plain.verdict == "accepted"
    assert framed_answer.confidence == pytest.approx(plain.confidence, abs=1e-6)
    places = [each.candidates[0].b_to_a.apply([[0.0, 0.0], [100.0, 100.0]]) for each in (plain, framed_answer)]
    assert places[0] == pytest.approx(places[1], abs=1e-6)

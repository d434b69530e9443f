import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.grid import UNKNOWN
from rectmerge.paper import placed_image
from rectmerge.paper.placed_image import CanvasError, PlacedImage


def numbered(height: int, width: int) -> np.ndarray:
    return (np.arange(height * width) % 101).reshape(height, width).astype(np.int8)


def assert_pose_holds(image: PlacedImage) -> None:
    """Every cell has the value that lies within a cell of where its pose takes it from, and the canvas holds all."""
    v, u = np.nonzero(image.cells != UNKNOWN)
    cols, rows = np.rint(image.pose.inverse().apply(np.stack([u, v], axis=-1))).astype(int).T
    framed = np.pad(image.original, 2, constant_values=UNKNOWN)
    near = [framed[rows + 2 + dy, cols + 2 + dx] for dy in (-1, 0, 1) for dx in (-1, 0, 1)]
    height, width = image.original.shape
    corners = image.pose.apply([[0, 0], [width - 1, 0], [0, height - 1], [width - 1, height - 1]])

    assert (np.stack(near) == image.cells[v, u]).any(axis=0).all()
    assert corners.min() > -0.6
    assert (corners.max(axis=0) < np.array(image.cells.shape[::-1]) - 0.4).all()
    assert len(u) == pytest.approx(image.original.size * image.pose.scale**2, rel=0.35)


@given(st.floats(-4, 4), st.integers(5, 30), st.integers(5, 30))
def test_a_turned_image_holds_all_cells_where_its_pose_says(angle, height, width):
    image = PlacedImage.from_cells(numbered(height, width)).turned(angle)

    assert_pose_holds(image)


@given(st.integers(-4, 4), st.integers(2, 9), st.integers(2, 9))
def test_quarter_turns_move_every_cell_exactly(quarters, height, width):
    image = PlacedImage.from_cells(numbered(height, width)).turned(quarters * math.pi / 2)
    v, u = np.indices((height, width))
    cols, rows = np.rint(image.pose.apply(np.stack([u, v], axis=-1))).astype(int).transpose(2, 0, 1)

    assert (image.cells[rows, cols] == image.original).all()


@given(st.floats(1, 3), st.floats(-3, 3))
def test_turned_and_rescaled_images_agree_with_their_pose(ratio, angle):
    image = PlacedImage.from_cells(numbered(20, 24)).turned(angle).rescaled(ratio)

    assert image.pose.scale == pytest.approx(ratio)
    assert_pose_holds(image)


@pytest.mark.parametrize("ratio", [1e4, 700.0])  # 10^10 cells; a side of 33,600
def test_an_image_that_would_be_too_large_is_refused_before_it_is_resampled(monkeypatch, ratio):
    monkeypatch.setattr(placed_image, "_resample", lambda *_: pytest.fail("resampled"))

    with pytest.raises(CanvasError, match="would grow to"):
        PlacedImage.from_cells(numbered(4, 48)).rescaled(ratio)


def test_doubling_has_half_pixel_centres():
    image = PlacedImage.from_cells(numbered(4, 5)).rescaled(2.0)

    assert (image.cells == np.kron(image.original, np.ones((2, 2), np.int8))).all()
    assert image.pose.apply([0.0, 0.0]).tolist() == [0.5, 0.5]


def test_resampling_the_original_gives_back_what_resampling_twice_has_lost():
    cells = numbered(40, 40)
    there_and_back = [
        PlacedImage.from_cells(cells).rescaled(0.5, resample_from=source).rescaled(2.0, resample_from=source).cells
        for source in ("original", "previous")
    ]

    assert (there_and_back[0] == cells).all()
    assert (there_and_back[1] != cells).mean() > 0.5

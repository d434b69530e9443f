import numpy as np
import pytest

from rectmerge.analysis.exact_distance import exact_distance


def nearest(mask):
    """Oracle: the distance to every cell of the mask, one by one."""
    marked = np.argwhere(mask)
    rows, cols = np.mgrid[: mask.shape[0], : mask.shape[1]]
    squares = (rows[..., None] - marked[:, 0]) ** 2 + (cols[..., None] - marked[:, 1]) ** 2
    return np.sqrt(squares.min(axis=-1))


@pytest.mark.parametrize("share", [0.001, 0.01, 0.3])
@pytest.mark.parametrize("shape", [(1, 40), (60, 75), (121, 83)])
def test_distances_are_exact_to_the_last_digit(shape, share):
    mask = np.random.default_rng(4).random(shape) < share
    mask[shape[0] // 2, shape[1] // 3] = True

    np.testing.assert_array_equal(exact_distance(mask), nearest(mask))


def test_they_are_the_same_wherever_the_mask_lies_in_memory():
    mask = np.random.default_rng(5).random((211, 173)) < 0.001
    expected = exact_distance(mask)
    for offset in range(16):
        room = np.zeros(mask.size + offset, np.bool_)
        moved = room[offset:].reshape(mask.shape)
        moved[:] = mask
        np.testing.assert_array_equal(exact_distance(moved), expected)

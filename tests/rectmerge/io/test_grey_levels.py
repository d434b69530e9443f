import io
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from rectmerge.errors import InputError
from rectmerge.io.grey_levels import Levels, infer_levels
from rectmerge.io.map_file import read_image
from tests import drawing


def painted(free: int, occupied: int, unknown: int, *, enlarge: int = 2) -> np.ndarray:
    grid = drawing.building()
    image = np.select([grid.free, grid.occupied], [free, occupied], unknown).astype(np.uint8)
    return image.repeat(enlarge, axis=0).repeat(enlarge, axis=1)


def as_jpeg(image: np.ndarray, quality: int) -> np.ndarray:
    encoded = io.BytesIO()
    Image.fromarray(image).save(encoded, format="JPEG", quality=quality)
    return np.asarray(Image.open(encoded))


CONVENTIONS = {
    "ROS": (254, 0, 205),
    "white, black, mid grey": (255, 0, 127),
    "the source paper's figure": (192, 0, 255),
    "free darker than unknown": (100, 10, 220),
    "pale": (250, 60, 225),
}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_clean_levels_are_told_exactly(convention):
    free, occupied, unknown = CONVENTIONS[convention]

    assert infer_levels(painted(free, occupied, unknown)) == Levels(free, occupied, unknown)


@pytest.mark.parametrize("quality", [50, 75, 95])
@pytest.mark.parametrize("convention", ["ROS", "white, black, mid grey", "the source paper's figure"])
def test_compression_moves_hardly_a_cell(convention, quality):
    free, occupied, unknown = CONVENTIONS[convention]
    clean = painted(free, occupied, unknown, enlarge=4)
    blurred = as_jpeg(clean, quality)

    wrong = infer_levels(blurred).classify(blurred) != Levels(free, occupied, unknown).classify(clean)

    assert wrong.mean() < 0.03


@pytest.mark.parametrize("share", [0.01, 0.05])
def test_salt_does_not_change_the_guess(share):
    rng = np.random.default_rng(0)
    image = painted(254, 0, 205)
    salted = np.where((rng.random(image.shape) < share) & (image == 254), np.uint8(0), image)

    assert infer_levels(salted) == Levels(254, 0, 205)


def test_a_drawing_in_black_and_white_has_walls_and_free_space():
    image = np.full((200, 300), 255, np.uint8)
    image[20:180, [20, 150, 280]] = image[[20, 180], 20:281] = 0

    assert infer_levels(image) == Levels(255, 0, None)


def test_a_smoothed_drawing_has_no_third_level():
    image = np.full((200, 300), 255, np.uint8)
    image[20:180, [20, 150, 280]] = image[[20, 180], 20:281] = 0
    image[21:180, [21, 151, 279]] = 128  # anti-aliased edges

    assert infer_levels(image) == Levels(255, 0, None)


def test_a_map_that_saw_no_wall_has_free_and_unknown():
    image = np.full((100, 100), 205, np.uint8)
    image[30:60, 30:60] = 254

    assert infer_levels(image) == Levels(254, None, 205)


def test_a_small_free_space_on_a_large_canvas_is_found():
    image = np.full((1000, 1000), 205, np.uint8)
    image[500:530, 500:530] = 0
    image[501:529, 501:529] = 254

    assert infer_levels(image) == Levels(254, 0, 205)


@pytest.mark.parametrize("known", [(254, 0, 205), (254, 205)], ids=["with walls", "without"])
@pytest.mark.parametrize("unknown_share", [0.01, 0.3, 0.98])
def test_the_greys_of_map_savers_are_never_read_otherwise(known, unknown_share):
    image = np.full((100, 100), 254, np.uint8)
    image[: round(100 * unknown_share)] = 205  # also as a border of unknown, or of free, alone
    image[50, 10:90] = min(known)

    assert infer_levels(image) == Levels(254, 0 if 0 in known else None, 205)


@given(st.permutations(["free", "occupied", "unknown"]), st.integers(0, 3))
def test_named_levels_are_kept_and_the_others_guessed(names, how_many):
    truth = {"free": 254, "occupied": 0, "unknown": 205}

    assert infer_levels(painted(254, 0, 205), **{name: truth[name] for name in names[:how_many]}) == Levels(**truth)


def test_naming_the_level_that_would_be_guessed_unknown_as_free_turns_the_guess_round():
    assert infer_levels(painted(254, 0, 205), free=205) == Levels(205, 0, 254)


def test_an_image_of_one_level_says_what_it_found():
    with pytest.raises(InputError, match="77"):
        infer_levels(np.full((9, 9), 77, np.uint8))


@pytest.mark.parametrize("levels", [(254, 254, None), (256, 0, None), (254, -1, 205)])
def test_levels_that_cannot_be_are_refused(levels):
    with pytest.raises(InputError):
        Levels(*levels)


@pytest.mark.real
@pytest.mark.parametrize(("folder", "truth"), [("real_maps", (255, 0, 127)), ("real_lasers", (254, 0, 205))])
def test_the_levels_of_every_real_map_are_right(folder, truth):
    root = os.environ.get("RECTMERGE_REAL_MAPS")
    if not root:
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder of the real maps")
    files = sorted(Path(root, folder, "test", "maps").glob("*.png"))

    assert files
    assert {str(read_image(file).levels) for file in files} == {str(Levels(*truth))}


@pytest.mark.parametrize("convention", ["ROS", "white, black, mid grey"])
def test_free_space_that_holds_most_of_the_border_is_still_free(convention):
    free, occupied, unknown = CONVENTIONS[convention]
    cut = painted(free, occupied, unknown)[30:190, 30:]

    assert infer_levels(np.ascontiguousarray(cut)) == Levels(free, occupied, unknown)


def test_a_drawing_cut_to_its_walls_shows_enough_of_the_white_around_it():
    free, occupied, unknown = CONVENTIONS["the source paper's figure"]
    cut = painted(free, occupied, unknown)[22:204, 22:304]  # the border is wall, but for a door and a corner
    cut[:, :60], cut[:9, 60:66] = unknown, free

    assert infer_levels(cut) == Levels(free, occupied, unknown)

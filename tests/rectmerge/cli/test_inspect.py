import json

import pytest
from PIL import Image

from tests import drawing
from tests.rectmerge.cli.answers import A, rectmerge, write_plain

pytestmark = pytest.mark.usefixtures("small_pictures")


def test_inspect_tells_and_draws(tmp_path, capsys):
    assert rectmerge("inspect", A, "-o", tmp_path / "a.png", "--json") == 0

    inspection = json.loads(capsys.readouterr().out)
    assert (inspection["width"], inspection["height"], inspection["resolution"]) == (163, 113, 0.05)
    assert inspection["rectangles"]["count"] == len(drawing.ROOMS) + len(drawing.MORE_ROOMS) + 11  # and the doors
    assert inspection["rectangles"]["largest"][0] == [12, 12, 60, 38]
    assert inspection["descriptors"]["specks"] == 0.0
    assert inspection["descriptors"]["frontier_share"] == 0.0
    with Image.open(tmp_path / "a.png") as drawn:
        assert drawn.size[0] > 2 * 163


def test_inspect_refuses_to_draw_over_the_map(tmp_path, capsys):
    image = tmp_path / "map.png"
    write_plain(image)
    before = image.read_bytes()

    assert rectmerge("inspect", image, "-o", image) == 2
    assert rectmerge("inspect", A, "-o", tmp_path / "picture.jpg") == 2
    assert image.read_bytes() == before

import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from rectmerge.errors import DatasetError
from scenarios.dataset.reader import is_dataset, open_dataset
from scenarios.pairs.truth import control_point_rmse

ROW = {
    "pair_id": "p",
    "map_a_file_name": "maps/p_a.png",
    "map_b_file_name": "maps/p_b.png",
    "related": True,
    "pixels": [[1, 0, 5], [0, 1, 0]],
    "control_points": [[5, 0, 0, 0], [15, 0, 10, 0], [15.0, 10, 10, 10]],
    "residual_px": 0.0,
}
UNRELATED = {**ROW, "related": False, "pixels": None, "control_points": None, "residual_px": None}


def write(root, rows, split="test"):
    folder = root / split
    (folder / "maps").mkdir(parents=True)
    image = np.full((30, 40), 205, np.uint8)
    image[5:25, 5:35] = 0
    image[6:24, 6:34] = 254
    for name in ("p_a.png", "p_b.png"):
        cv2.imwrite(str(folder / "maps" / name), image)
    lines = [row if isinstance(row, str) else json.dumps(row) for row in rows]
    (folder / "metadata.jsonl").write_text("\n".join(lines) + "\n")
    return root


def test_a_row_becomes_a_pair_with_its_truth(tmp_path):
    root = write(tmp_path / "mine", [{**ROW, "overlap": 0.4, "place": "home", "colour": "blue", "resolution_a": 0.05}])

    (source,) = open_dataset(root)
    (pair,) = source.pairs()

    assert source.pair_ids == (pair.pair_id,) == ("p",)
    assert (pair.suite, pair.place, pair.overlap, pair.residual_px) == ("mine", "home", 0.4, 0.0)
    assert pair.pixels.tx == 5
    assert pair.control_points.shape == (3, 4)
    assert pair.a.shape == (30, 40)
    assert pair.info["colour"] == "blue"  # unknown keys are kept
    assert pair.info["split"] == "test"


def test_whether_a_pair_is_related_is_known_even_where_its_row_can_be_read_no_more(tmp_path):
    root = write(tmp_path, [ROW, {**UNRELATED, "pair_id": "q"}])
    sources = open_dataset(root)
    (root / "test/metadata.jsonl").unlink()

    assert [source.is_related(source.pair_id) for source in sources] == [True, False]


def test_a_known_resolution_stays_hidden_from_the_method(tmp_path):
    root = write(tmp_path, [{**ROW, "resolution_a": 0.05, "resolution_b": 0.1}])
    (root / "test/maps/p_a.yaml").write_text(
        "image: p_a.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )

    (pair,) = open_dataset(root)[0].pairs()

    assert pair.a.resolution is None
    assert pair.b.resolution is None
    assert pair.info["resolution_a"] == 0.05


def test_splits_are_opened_alone_or_together(tmp_path):
    write(tmp_path, [ROW], "train")
    write(tmp_path, [{**UNRELATED, "pair_id": "q"}], "test")

    assert [source.source_id for source in open_dataset(tmp_path)] == ["p", "q"]
    assert [source.source_id for source in open_dataset(tmp_path, split="test")] == ["q"]
    assert [source.source_id for source in open_dataset(tmp_path / "train")] == ["p"]
    assert is_dataset(tmp_path)
    assert not is_dataset(tmp_path / "train/maps")


BAD = {
    "not JSON": ("{", "not JSON"),
    "no object": ("[1]", "a row is an object"),
    "no id": ({k: v for k, v in ROW.items() if k != "pair_id"}, "pair_id is missing"),
    "id of a wrong type": ({**ROW, "pair_id": 3}, "pair_id must be of type str"),
    "related as text": ({**ROW, "related": "yes"}, "related must be of type bool"),
    "map missing": ({**ROW, "map_b_file_name": "maps/none.png"}, "no file 'maps/none.png'"),
    "map outside": ({**ROW, "map_a_file_name": "../test/maps/p_a.png"}, "inside the data set"),
    "map absolute": ({**ROW, "map_a_file_name": "/etc/hostname"}, "inside the data set"),
    "no truth": ({**ROW, "pixels": None}, "pixels must be"),
    "mirrored truth": ({**ROW, "pixels": [[-1, 0, 5], [0, 1, 0]]}, "not a rotation"),
    "truth of a wrong shape": ({**ROW, "pixels": [[1, 0], [0, 1]]}, "pixels must be finite numbers of shape (2, 3)"),
    "ragged points": ({**ROW, "control_points": [[1, 2, 3, 4], [5]]}, "control_points must be numbers of shape (N, 4)"),
    "one point": ({**ROW, "control_points": [[5, 0, 0, 0]]}, "control_points must be"),
    "not finite": (json.dumps(ROW).replace("15.0", "NaN"), "control_points must be finite"),
    "columns swapped": ({**ROW, "pixels": [[1, 0, -5], [0, 1, 0]]}, "leave 10.000"),
    "truth of unrelated": ({**ROW, "related": False}, "must be null"),
    "overlap": ({**ROW, "overlap": 1.5}, "0..1"),
    "resolution": ({**ROW, "resolution_a": 0}, "resolution_a must be > 0"),
}


@pytest.mark.parametrize(("row", "message"), BAD.values(), ids=BAD)
def test_a_bad_row_is_refused_with_its_file_and_line(tmp_path, row, message):
    write(tmp_path, [{**UNRELATED, "pair_id": "good"}, row])

    with pytest.raises(DatasetError) as refusal:
        open_dataset(tmp_path)

    assert f"test{os.sep}metadata.jsonl:2: " in str(refusal.value)
    assert message in str(refusal.value)


@pytest.mark.parametrize("way", ["link", "yaml"])
def test_a_data_set_does_not_lead_out_of_itself(tmp_path, way):
    root = write(tmp_path / "set", [{**ROW, "map_a_yaml": "maps/p_a.yaml"} if way == "yaml" else ROW])
    maps = root / "test/maps"
    (maps / "p_a.png").rename(tmp_path / "mine.png")
    (maps / "p_a.png").symlink_to(tmp_path / "mine.png")
    if way == "yaml":
        (maps / "p_a.png").unlink()
        (maps / "p_a.png").write_bytes((maps / "p_b.png").read_bytes())
        (maps / "p_a.yaml").write_text(
            f"image: {tmp_path}/mine.png\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
        )

    with pytest.raises(DatasetError, match=r"leads out of the data set, to .*mine\.png"):
        list(open_dataset(root)[0].pairs())


def test_an_id_is_used_once(tmp_path):
    with pytest.raises(DatasetError, match=r"metadata.jsonl:2: pair_id 'p' is used twice"):
        open_dataset(write(tmp_path, [ROW, ROW]))


def test_an_empty_data_set_is_refused(tmp_path):
    with pytest.raises(DatasetError, match="no rows"):
        open_dataset(write(tmp_path, []))


@pytest.mark.parametrize("split", [None, "train"])
def test_a_folder_without_rows_is_no_data_set(tmp_path, split):
    with pytest.raises(DatasetError, match="not a data set"):
        open_dataset(tmp_path, split=split)


@pytest.mark.real
@pytest.mark.parametrize(("name", "rows"), [("real_maps", 168), ("real_lasers", 22)])
def test_truth_of_real_maps_leaves_the_residual_that_the_rows_tell(name, rows):
    if not (home := os.environ.get("RECTMERGE_REAL_MAPS")):
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder that holds real_maps and real_lasers")
    sources = open_dataset(Path(home) / name)

    assert len(sources) == rows
    for source in sources:
        if source.related:
            row = source.row()
            rmse = control_point_rmse(row.pixels.matrix, row.control_points)
            assert rmse == pytest.approx(row.residual_px, abs=0.01)

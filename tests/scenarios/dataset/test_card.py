import json
import subprocess
import sys

import pytest
import yaml
from PIL import Image

from scenarios.dataset.generate import generate
from tests.scenarios.tiny_suite import TinySuite

READ = """
import sys, warnings
warnings.simplefilter("error")
import datasets, numpy as np, pandas as pd
folder, cache = sys.argv[1:]
for loaded in (
    datasets.load_dataset("imagefolder", data_dir=folder, cache_dir=cache),
    datasets.load_dataset(folder, cache_dir=cache),  # as the hub does, by the card
):
    for split, pairs, related in (("train", 4, 2), ("test", 6, 3)):
        rows = loaded[split]
        assert len(rows) == pairs, rows
        assert sum(rows["related"]) == related
        frame = pd.read_json(f"{folder}/{split}/metadata.jsonl", lines=True)
        keys = {key.removesuffix("_file_name") for key in frame.columns}
        assert keys == set(rows.column_names), keys ^ set(rows.column_names)
        required = {"pair_id", "map_a", "map_b", "related", "pixels", "control_points", "residual_px"}
        assert required <= keys
        for row, (_, told) in zip(rows, frame.iterrows(), strict=True):
            assert row["map_a"].size == (80, 60)
            assert row["map_b"].size == ((73, 56) if row["related"] else (80, 60))
            assert row["pair_id"] == told["pair_id"]
            assert not row["related"] or np.allclose(row["control_points"], told["control_points"])
            assert row["related"] or row["pixels"] is row["control_points"] is row["residual_px"] is None
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "tiny"
    generate(TinySuite(), folder)
    return folder


@pytest.mark.slow
def test_it_opens_with_datasets_and_pandas_in_a_line(tmp_path, made):
    pytest.importorskip("datasets", reason="the library datasets is not installed")
    home = {"HF_HOME": str(tmp_path), "HF_HUB_OFFLINE": "1", "HF_DATASETS_OFFLINE": "1"}

    # a process of its own: the library looks at its environment once, and leaves threads behind
    read = subprocess.run(
        [sys.executable, "-c", READ, str(made), str(tmp_path / "cache")],
        env=home,
        capture_output=True,
        text=True,
        check=False,
    )
    assert read.returncode == 0, read.stderr


def test_the_card_has_what_a_hub_reads_and_a_small_picture(made):
    _, front, text = (made / "README.md").read_text().split("---\n", 2)
    (config,) = yaml.safe_load(front)["configs"]

    assert config["data_files"] == [{"split": "train", "path": "train/**"}, {"split": "test", "path": "test/**"}]
    assert yaml.safe_load(front)["pretty_name"] == "Tiny: rooms"
    assert yaml.safe_load(front)["license"] == "mit"
    assert "rectbench generate tiny" in text
    info = json.loads((made / "dataset_info.json").read_text())
    assert f"Made by rectmerge {info['versions']['rectmerge']}" in text
    assert f"`{info['dataset_id']}`" in text
    assert f"@misc{{tiny-{info['dataset_id'][:16]}," in text
    assert "| test | 6 | 3 |" in text
    assert (made / "train/maps/000000_a.png").is_file()
    assert "train/maps/000000_a.png" in text or "test/maps/000002_a.png" in text
    with Image.open(made / "pairs.png") as picture:
        assert picture.mode == "P"
        assert picture.width > 600
    assert (made / "pairs.png").stat().st_size < 200_000

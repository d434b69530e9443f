import random
from pathlib import Path

import pytest

from rectmerge.errors import MapFileError
from rectmerge.io import bag_sizes
from rectmerge.io.bag_file import read_bag_map
from rectmerge.io.map_file import read_map
from tests.rectmerge import bags
from tests.rectmerge.bags import COMPRESSED, KINDS, MAP, TEXT


def test_nothing_compressed_is_unpacked_beyond_the_largest_map(tmp_path, monkeypatch):
    monkeypatch.setattr(bag_sizes, "MOST_CHUNK_BYTES", 50)
    monkeypatch.setattr(bag_sizes, "free_bytes", lambda: 100)
    for name, (kind, compression) in COMPRESSED.items():
        folder = tmp_path / name
        folder.mkdir()
        bag = bags.write(folder, kind, compression=compression)

        with pytest.raises(
            MapFileError, match=r"broken.*a (chunk|message|file) .* more than [^\n]*50|a chunk of \d+ b"
        ):
            read_map(f"{bag}:/map")


def test_files_that_are_no_bag_are_refused_with_a_remedy(tmp_path):
    (tmp_path / "empty.mcap").touch()
    (tmp_path / "text.bag").write_text("hello")
    (tmp_path / "text.db3").write_text("hello")
    (tmp_path / "folder").mkdir()
    (tmp_path / "bare").mkdir()
    (tmp_path / "bare" / "metadata.yaml").write_text("[]")
    wrong = {
        "missing.bag:/map": "no such file; check the name",
        "empty.mcap:/map": "the file is empty",
        "text.bag:/map": r"broken, truncated or unknown bag \(.+\); rosbag reindex",
        "text.db3": r"broken, truncated or unknown bag \(.+\); ros2 bag reindex",
        "folder:/map": "there is no metadata.yaml; ros2 bag reindex makes it",
        "bare:/map": "broken, truncated or unknown bag",
    }
    for name, reason in wrong.items():
        with pytest.raises(MapFileError, match=reason):
            read_map(tmp_path / name)
    with pytest.raises(MapFileError, match="is no bag; name a"):
        read_bag_map(tmp_path / "map.pgm")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_bag_gives_one_line_or_a_map(tmp_path, kind):
    bag, chance = bags.write(tmp_path, kind, [MAP, ("/chat", TEXT, {}), MAP]), random.Random(7)
    file = bags.storage(bag)
    whole = file.read_bytes()
    cut = [whole[: chance.randrange(len(whole))] for _ in range(40)]
    read = 0
    for damaged in [*cut, *(_flipped(whole, chance) for _ in range(100))]:
        file.write_bytes(damaged)
        for name in (f"{bag}:/map", file):
            said = _said(name)
            read += not said
            assert "\n" not in said

    assert read  # what was hit is not always what matters


def _said(name: str | Path) -> str:
    """What reading a map says against it; empty where it is read."""
    try:
        read_map(name)
    except MapFileError as error:
        return str(error)
    return ""


def _flipped(data: bytes, chance: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 3, 30))):
        changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed)


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_damaged_metadata_gives_one_line_or_a_map(tmp_path, kind):
    bag, chance = bags.write(tmp_path, kind), random.Random(3)
    whole = (bag / "metadata.yaml").read_bytes()
    for _ in range(100):
        (bag / "metadata.yaml").write_bytes(_flipped(whole, chance))
        assert "\n" not in _said(f"{bag}:/map")

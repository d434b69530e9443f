import pytest

from rectmerge.errors import InputError
from rectmerge.live.memory import Memory
from rectmerge.similarity import Similarity


def test_what_is_written_is_read_again(tmp_path):
    memory = Memory("robot1", {"robot2": Similarity(1.01, 0.5, -3.25, 1e-3)})
    memory.write(tmp_path / "new" / "memory.json")

    assert Memory.read(tmp_path / "new" / "memory.json") == memory


def test_no_file_is_no_memory(tmp_path):
    assert Memory.read(tmp_path / "memory.json") is None


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{}",
        "[]",
        '{"schema": "other/1"}',
        '{"schema": "rectmerge.live/1", "reference": "a", "placements": {"b": [1]}}',
    ],
)
def test_another_file_is_refused_by_its_name(tmp_path, text):
    (tmp_path / "memory.json").write_text(text)

    with pytest.raises(InputError, match=r"memory\.json: is no memory"):
        Memory.read(tmp_path / "memory.json")

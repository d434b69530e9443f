import pytest

from rectmerge.errors import InputError
from scenarios.journal import Journal


def entries(path):
    journal = Journal(path)
    found = [entry for _, entry in journal.entries()]
    journal.close()
    return found


def test_lines_survive_and_a_torn_one_is_dropped(tmp_path):
    journal = Journal(tmp_path / "j")
    for k in range(3):
        journal.append({"k": k})
    starts = [start for start, _ in journal.entries()]
    assert [journal.entry_at(start) for start in reversed(starts)] == [{"k": 2}, {"k": 1}, {"k": 0}]
    journal.close()
    whole = (tmp_path / "j").read_bytes()

    for end in range(len(whole) + 1):
        (tmp_path / "j").write_bytes(whole[:end])
        kept = whole[:end].count(b"\n")
        assert entries(tmp_path / "j") == [{"k": k} for k in range(kept)]
        assert (tmp_path / "j").read_bytes() == b"".join(whole.splitlines(keepends=True)[:kept])


def test_a_journal_belongs_to_one_at_a_time(tmp_path):
    journal = Journal(tmp_path / "j")
    with pytest.raises(InputError, match="another process"):
        Journal(tmp_path / "j")
    journal.close()

    assert entries(tmp_path / "j") == []

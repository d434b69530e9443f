import pytest

from rectmerge.errors import InputError
from scenarios.execution.journal import Journal


def entries(path):
    journal = Journal(path)
    journal.mend()
    listed = [entry for _, entry in journal.entries()]
    journal.close()
    return listed


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


def test_a_torn_line_longer_than_a_block_is_dropped(tmp_path, monkeypatch):
    monkeypatch.setattr("scenarios.execution.journal.BLOCK", 8)
    (tmp_path / "j").write_bytes(b'{"k": 0}\n{"torn": "and longer than two blocks')

    assert entries(tmp_path / "j") == [{"k": 0}]
    assert (tmp_path / "j").read_bytes() == b'{"k": 0}\n'


def test_a_journal_that_was_only_opened_is_as_it_was(tmp_path):
    (tmp_path / "j").write_bytes(b'{"k": 0}\nnot ours')
    journal = Journal(tmp_path / "j")

    assert [entry for _, entry in journal.entries()] == [{"k": 0}]
    journal.close()
    assert (tmp_path / "j").read_bytes() == b'{"k": 0}\nnot ours'


def test_a_journal_belongs_to_one_at_a_time(tmp_path):
    journal = Journal(tmp_path / "j")
    with pytest.raises(InputError, match="another process"):
        Journal(tmp_path / "j")
    journal.close()

    assert entries(tmp_path / "j") == []

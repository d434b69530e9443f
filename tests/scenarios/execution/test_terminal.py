import pytest

from rectmerge.cli import console
from scenarios.execution import terminal

LINES = [b"one\n", b"two\n"]


@pytest.mark.parametrize(("large_bytes", "is_shown"), [(1, True), (1000, False)])
def test_reading_a_large_file_shows_progress_on_a_terminal(tmp_path, monkeypatch, capsys, large_bytes, is_shown):
    (tmp_path / "rows").write_bytes(b"".join(LINES))
    monkeypatch.setattr(console, "is_quiet", lambda: False)
    monkeypatch.setenv("FORCE_COLOR", "1")  # stderr counts as a terminal
    monkeypatch.setattr(terminal, "LARGE_BYTES", large_bytes)

    with terminal.open_with_progress(tmp_path / "rows") as lines:
        assert list(lines) == LINES
    assert ("reading" in capsys.readouterr().err) == is_shown


def test_reading_shows_nothing_where_there_is_no_terminal(tmp_path, monkeypatch, capsys):
    (tmp_path / "rows").write_bytes(b"".join(LINES))
    monkeypatch.setattr(console, "is_quiet", lambda: False)
    monkeypatch.setattr(terminal, "LARGE_BYTES", 1)

    with terminal.open_with_progress(tmp_path / "rows") as lines:
        assert list(lines) == LINES
    assert capsys.readouterr().err == ""

import pytest

from rectmerge.errors import InputError
from scenarios.execution.files import require_place


def test_the_folder_of_a_file_is_made_before_the_work(tmp_path):
    require_place(tmp_path / "new" / "folder" / "page.md")

    assert [path.name for path in (tmp_path / "new").iterdir()] == ["folder"]
    assert not any((tmp_path / "new" / "folder").iterdir())


@pytest.mark.parametrize(("name", "message"), [("file/page.md", "cannot be written"), ("folder", "is a folder")])
def test_what_could_not_be_written_after_the_work_is_refused_before_it(tmp_path, name, message):
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()

    with pytest.raises(InputError, match=message):
        require_place(tmp_path / name)

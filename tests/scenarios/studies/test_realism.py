import pytest

from rectmerge.errors import DatasetError
from scenarios.studies.realism import PAGE, write_realism


def test_maps_that_are_not_there_are_refused_before_earlier_pages_are_cleared(tmp_path):
    (tmp_path / PAGE).write_text("earlier")

    with pytest.raises(DatasetError, match="not a data set"):
        write_realism(tmp_path / "nope", tmp_path, force=True)
    assert (tmp_path / PAGE).read_text() == "earlier"

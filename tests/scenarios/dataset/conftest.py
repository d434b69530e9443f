import pytest


@pytest.fixture(scope="module")
def no_picture():
    """Draw no picture of a data set: that takes longer than all the rest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda folder: b"a picture")
        yield

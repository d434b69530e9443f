import shutil
import subprocess

import pytest

from rectmerge.errors import DatasetError
from scenarios.dataset.dataset_id import dataset_id, dataset_root, measure_dataset_id
from scenarios.dataset.generate import generate
from tests.scenarios.dataset.test_reader import ROW, write
from tests.scenarios.tiny_suite import TinySuite

pytestmark = pytest.mark.usefixtures("no_picture")


@pytest.fixture(scope="module")
def made(tmp_path_factory, no_picture):
    folder = tmp_path_factory.mktemp("made") / "tiny"
    return folder, generate(TinySuite(), folder)["dataset_id"]


def test_the_id_is_that_of_the_files_and_what_sha256sum_makes_of_them(made):
    folder, declared = made
    lines = "find train test -type f | LC_ALL=C sort | xargs sha256sum | sha256sum"
    by_hand = subprocess.run(["sh", "-c", lines], cwd=folder, capture_output=True, text=True, check=True)

    assert measure_dataset_id(folder) == declared == by_hand.stdout.split()[0]


def test_the_order_of_the_files_does_not_count_but_their_names_and_bytes_do():
    sums = {"train/a.png": "1", "train/b.png": "2"}

    assert dataset_id(sums) == dataset_id(dict(reversed(sums.items())))
    changes = {"train/a.png": "3"}, {"train/c.png": "3"}, {"README.md": "3"}
    assert [dataset_id(sums) == dataset_id(sums | change) for change in changes] == [False, False, True]


def test_a_copy_has_the_same_id_and_a_changed_file_another(made, tmp_path):
    folder, declared = made
    copy = shutil.copytree(folder, tmp_path / "elsewhere")
    (copy / "README.md").write_text("another card")
    (copy / "train/.hidden").write_text("of a file manager")
    assert measure_dataset_id(copy) == declared

    (copy / "train/maps/000000_a.png").write_bytes(b"other")
    assert measure_dataset_id(copy) != declared


def test_rows_in_the_own_folder_have_an_id_too(tmp_path):
    folders = [
        write(tmp_path / name, [{**ROW, "pair_id": pair_id}], ".")
        for name, pair_id in (("1", "p"), ("2", "p"), ("3", "q"))
    ]

    first, again, other = map(measure_dataset_id, folders)
    assert first == again != other


def test_where_there_are_no_rows_there_is_no_id(tmp_path):
    with pytest.raises(DatasetError, match="not a data set"):
        measure_dataset_id(tmp_path)


def test_a_split_leads_to_its_data_set(tmp_path):
    assert dataset_root(tmp_path / "set" / "test") == dataset_root(tmp_path / "set") == tmp_path / "set"

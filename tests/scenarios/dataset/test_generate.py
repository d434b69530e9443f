import errno
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rectmerge.errors import DatasetError, InputError
from scenarios.dataset.generate import SEED_STRIDE, generate, plan
from scenarios.dataset.reader import open_dataset
from scenarios.dataset.verify import verify
from scenarios.execution.executors import local_workers, workplace
from scenarios.suites.spec import Seeds
from scenarios.suites.suite import load_suite
from tests.scenarios.dataset.folders import contents, rows_of
from tests.scenarios.tiny_suite import TinySuite

SUITE = TinySuite()
pytestmark = pytest.mark.usefixtures("no_picture")


@pytest.fixture(scope="module")
def made(tmp_path_factory, no_picture):
    folder = tmp_path_factory.mktemp("made") / "tiny"
    generate(SUITE, folder)
    return folder


def test_a_data_set_holds_every_pair_as_it_was_made(made):
    pairs = {pair.pair_id: pair for source in SUITE.sources() for pair in source.pairs()}
    opened = {pair.pair_id: pair for source in open_dataset(made) for pair in source.pairs()}

    assert opened.keys() == pairs.keys()
    for pair_id, was in pairs.items():
        pair = opened[pair_id]
        for grid, old in ((pair.a, was.a), (pair.b, was.b)):
            assert np.array_equal(grid.occupancy, old.occupancy)
            assert (grid.resolution, grid.origin) == (old.resolution, old.origin)
        assert (pair.related, pair.suite, pair.place) == (was.related, was.suite, was.place)
        assert pair.info["split"] == was.info["split"]
        if was.related:
            assert np.allclose(pair.pixels.matrix, was.pixels.matrix, atol=1e-8)
            assert np.allclose(pair.control_points, was.control_points, atol=6e-4)
            assert pair.residual_px == pytest.approx(was.residual_px, abs=1e-3)
            assert pair.overlap == pytest.approx(was.overlap, abs=1e-6)


def test_files_are_numbered_by_the_place_in_the_suite_and_lie_in_their_split(made):
    rows = {row["pair_id"]: row for split in ("train", "test") for row in rows_of(made, split)}

    assert rows["rooms-0000-same"]["map_a_file_name"] == "maps/000000_a.png"
    assert rows["rooms-0004-other"]["map_b_file_name"] == "maps/000009_b.png"
    assert {row["split"] for row in rows_of(made, "train")} == {"train"}
    assert sorted(path.name for path in (made / "train/maps").glob("*.yaml")) == ["000000_b.yaml", "000006_b.yaml"]


def test_every_row_has_the_same_keys_and_unrelated_pairs_have_no_truth(made):
    rows = [row for split in ("train", "test") for row in rows_of(made, split)]

    assert len({tuple(row) for row in rows}) == 1
    other = next(row for row in rows if not row["related"])
    assert [other[key] for key in ("pixels", "control_points", "residual_px", "b_to_a", "overlap")] == [None] * 5
    assert (other["why"], rows[0]["why"]) == ("another building", "")
    assert {type(row["ratio"]) for row in rows} == {float}


def test_the_info_tells_what_was_made_of_what(made):
    info = json.loads((made / "dataset_info.json").read_text())

    assert (info["suite"], info["seed"], info["pairs"]) == ("tiny", 0, None)
    assert info["splits"] == {"train": {"pairs": 4, "related": 2}, "test": {"pairs": 6, "related": 3}}
    assert {"python", "numpy", "opencv-python-headless", "rectmerge", "commit"} <= set(info["versions"])
    assert set(info["checksums"]) == set(contents(made)) - {"dataset_info.json"}
    assert verify(made).faults == ()


@pytest.mark.slow
def test_two_workers_make_the_same_bytes(tmp_path, made):
    with local_workers(2) as executor:
        generate(SUITE, tmp_path / "again", executor=executor)

    assert contents(tmp_path / "again") == contents(made)


@pytest.mark.slow
@pytest.mark.parametrize("kept", [1, 3])
def test_a_process_that_is_killed_is_gone_on_with_and_makes_the_same_bytes(tmp_path, made, kept):
    command = [sys.executable, "-m", "tests.scenarios.tiny_suite", str(tmp_path / "set")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for _ in range(1 + kept):  # it first tells that nothing is there yet
            process.stdout.readline()
        process.kill()
    with (tmp_path / "set/unfinished.jsonl").open("ab") as journal:
        journal.write(b'{"source": "rooms-')
    (tmp_path / "set/test/maps").mkdir(parents=True, exist_ok=True)
    (tmp_path / "set/test/maps/.000009_a.png.77.part").write_bytes(b"half")
    counts = []
    generate(SUITE, tmp_path / "set", on_done=counts.append)

    assert kept * 2 <= counts[0] < 10
    assert contents(tmp_path / "set") == contents(made)


def test_a_full_disk_is_told_in_a_line_and_what_was_made_is_kept(tmp_path, made, monkeypatch):
    write, calls = Path.write_bytes, []

    def full(path, data):
        calls.extend(path.relative_to(tmp_path).parts[:1] if path.is_relative_to(tmp_path / "set") else [])
        if len(calls) > 12:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, data)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        with pytest.raises(InputError, match="No space left on device"):
            generate(SUITE, tmp_path / "set")
    counts = []
    generate(SUITE, tmp_path / "set", on_done=counts.append)

    assert counts[0] == 4
    assert contents(tmp_path / "set") == contents(made)


def test_a_finished_data_set_is_not_made_again(made):
    before, counts = contents(made), []
    generate(SUITE, made, on_done=counts.append)

    assert (contents(made), counts) == (before, [10])


def test_pairs_that_cannot_be_made_are_told_and_the_others_stay(tmp_path):
    info = generate(TinySuite(failing=2), tmp_path / "set")

    assert [(failure["pair_id"], failure["reason"]) for failure in info["failed"]] == [
        ("rooms-0002-other", "RuntimeError: the robot fell over")
    ]
    assert len(open_dataset(tmp_path / "set")) == 9


def test_the_first_pairs_are_those_of_the_whole_and_more_than_there_are_take_further_seeds(tmp_path, made):
    generate(SUITE, tmp_path / "first", pairs=3)

    first = contents(tmp_path / "first")
    assert len(open_dataset(tmp_path / "first")) == 3
    assert all(contents(made)[name] == data for name, data in first.items() if "/maps/" in name)
    more = list(plan(SUITE, pairs=11))
    assert [job.source.seed for job in more] == [0, 1, 2, 3, 4, 5]
    assert [(job.first, job.count) for job in more[-2:]] == [(8, 2), (10, 1)]


def test_another_seed_takes_other_seeds_of_every_scenario():
    shifted = list(plan(load_suite("smoke"), seed=2))

    assert [job.source.seed - 2 * SEED_STRIDE for job in shifted] == [
        job.source.seed for job in plan(load_suite("smoke"))
    ]
    assert shifted[0].source.scenario.seeds == Seeds(first=2 * SEED_STRIDE, count=1)


def test_an_unfinished_data_set_is_finished_by_the_same_call_only(tmp_path, made, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda folder: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            generate(SUITE, tmp_path / "set")

    with pytest.raises(InputError, match="unfinished data set that differs in seed"):
        generate(SUITE, tmp_path / "set", seed=1)
    with pytest.raises(DatasetError, match="is unfinished"):
        verify(tmp_path / "set")

    generate(SUITE, tmp_path / "set")
    assert contents(tmp_path / "set") == contents(made)


@pytest.mark.slow
def test_a_dask_cluster_makes_the_same_bytes(tmp_path, made, dask_cluster):
    with workplace(1, dask_cluster.scheduler_address) as (executor, in_flight):
        generate(SUITE, tmp_path / "again", executor=executor, in_flight=in_flight)

    assert contents(tmp_path / "again") == contents(made)

"""Many maps aligned by a real dask cluster."""

import json
import os
import socket

import pytest

from rectmerge import methods
from rectmerge.cli import cluster, console
from tests.rectmerge.cli.many import MAPS, Judge, rectmerge
from tests.rectmerge.fleet.fleets import fleet

pytestmark = pytest.mark.usefixtures("small_pictures")


class Deadly(Judge):
    """Method that ends its process."""

    def align(self, a, b, **asked):
        os._exit(1)


@pytest.mark.slow
def test_a_cluster_gives_the_same_answer(merged_many, dask_cluster, tmp_path):
    assert rectmerge("merge", *MAPS, "--cluster", dask_cluster.scheduler_address, "-o", tmp_path / "out") == console.YES

    here, there = (json.loads((folder / "fleet.json").read_text()) for folder in (merged_many, tmp_path / "out"))
    assert here["placements"] == there["placements"]


def test_a_cluster_that_is_not_there_is_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cluster, "REACHED_WITHIN_S", 0.3)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"

    assert rectmerge("merge", *MAPS, "--cluster", address, "-o", tmp_path / "out") == console.BAD_INPUT
    assert capsys.readouterr().err == f"rectmerge: --cluster {address}: no dask scheduler answers there\n"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((*MAPS, "--workers", "2", "--cluster", "tcp://x:1"), "--workers and --cluster exclude each other"),
        ((*MAPS[:2], "--cluster", "tcp://x:1"), "--cluster is for more than two maps; two are aligned in this process"),
    ],
)
def test_options_that_do_not_go_together_are_one_line(tmp_path, capsys, words, told):
    assert rectmerge("merge", *words, "-o", tmp_path / "out") == console.BAD_INPUT
    assert capsys.readouterr().err == f"rectmerge: {told}\n"


@pytest.mark.slow
def test_a_worker_that_dies_is_one_line(tmp_path, saved, monkeypatch, capsys):
    made = fleet(1, home=4, other=0)
    files = saved(made)
    monkeypatch.setattr(methods, "make_method", lambda name, **fields: Deadly(made))
    monkeypatch.setattr("rectmerge.method_fields.field_values", lambda method: {})

    assert rectmerge("merge", *files.values(), "--workers", "2", "-o", tmp_path / "out") == console.BAD_INPUT
    told = capsys.readouterr().err.splitlines()[-1]
    assert told == "rectmerge: a worker process died; the same command goes on where this one stopped"

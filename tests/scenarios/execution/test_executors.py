import multiprocessing
import os
import signal
import socket
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from rectmerge.cli.cluster import cluster
from rectmerge.errors import InputError
from scenarios.bench.contenders import Contender
from scenarios.bench.run import read_rows
from scenarios.execution.executors import LocalPool, WorkerDiedError, completed, local_workers, workplace
from tests.scenarios.known_answers import Fixed, Source, pair, run_pairs

DATA = Path(__file__).parents[2] / "data"


@dataclass(frozen=True, kw_only=True)
class Deadly(Source):
    """Kills its worker the first `deaths` times, which it notes in a file; slow, so that others are in flight."""

    notes: Path
    deaths: int
    signal: int = signal.SIGKILL

    def pairs(self):
        count_start(self.notes)
        if starts(self.notes) <= self.deaths:
            time.sleep(0.2)
            os.kill(os.getpid(), self.signal)
        yield from super().pairs()


@dataclass(frozen=True, kw_only=True)
class Slow(Source):
    """Waits for a file before it makes its pairs."""

    started: Path
    go_on: Path

    def pairs(self):
        count_start(self.started)
        while not self.go_on.exists():
            time.sleep(0.01)
        yield pair(self.pair_ids[0])
        yield pair(self.pair_ids[1], related=False)


def count_start(notes):
    with notes.open("a") as file:
        file.write(f"{os.getpid()}\n")


def starts(notes):
    return len(notes.read_text().split()) if notes.exists() else 0


def wait_for(condition, within_s=60.0):
    ends = time.monotonic() + within_s
    while not (result := condition()):
        assert time.monotonic() < ends
        time.sleep(0.02)
    return result


def outcomes(folder):
    return {row["pair_id"]: row["outcome"] for row in read_rows(folder)}


def all_right(sources):
    return {
        **{source.pair_ids[0]: "right-accepted" for source in sources},
        **{source.pair_ids[1]: "wrong-accepted" for source in sources},
    }


METHODS = [Contender(label="fixed", method=Fixed())]


def test_work_without_an_executor_is_done_in_order():
    assert [(item, future.result()) for item, future in completed(None, abs, [-3, 2])] == [(-3, 3), (2, 2)]


@pytest.mark.slow
def test_an_item_that_fails_is_told_by_its_future_with_an_executor_or_without():
    with local_workers(2) as pool:
        for executor in (None, pool):
            futures = dict(completed(executor, inverse, [4, 0, 2]))

            assert futures.keys() == {4, 0, 2}
            assert (futures[4].result(), futures[2].result()) == (0.25, 0.5)
            with pytest.raises(ZeroDivisionError):
                futures[0].result()


def inverse(number):
    return 1 / number


def test_work_without_an_executor_is_interrupted_at_once():
    def interrupted(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        next(completed(None, interrupted, [1, 2]))


@pytest.mark.slow
def test_items_are_taken_as_there_is_room():
    taken = []

    def items():
        for item in range(50):
            taken.append(item)
            yield item

    with local_workers(2) as pool:
        work = completed(pool, abs, items(), in_flight=4)
        next(work)
        assert len(taken) <= 8
        assert len(list(work)) == 49


def test_one_worker_is_this_process():
    with local_workers(1) as pool:
        assert pool is None


@pytest.mark.slow
@pytest.mark.parametrize("deaths", [2, 9])
def test_a_task_that_kills_its_worker_is_told_from_those_beside_it(tmp_path, deaths):
    others = [Source(source_id=f"m{number}") for number in range(6)]
    deadly = Deadly(source_id="deadly", notes=tmp_path / "notes", deaths=deaths)

    with local_workers(2) as pool:
        run_pairs([others[0], deadly, *others[1:]], METHODS, tmp_path / "run", suite="made", executor=pool, in_flight=4)

    rows = [row for row in read_rows(tmp_path / "run") if row["place"] == "deadly"]
    assert outcomes(tmp_path / "run").items() >= all_right(others).items()
    assert starts(tmp_path / "notes") == min(deaths + 1, 3)
    if deaths > 2:
        assert {row["outcome"] for row in rows} == {"out-of-memory"}
        assert "was killed, most likely for want of memory, 3 times" in rows[0]["reason"]
    else:
        assert outcomes(tmp_path / "run").items() >= all_right([deadly]).items()


@pytest.mark.slow
def test_a_worker_that_crashes_is_an_error(tmp_path):
    deadly = Deadly(notes=tmp_path / "notes", deaths=9, signal=signal.SIGSEGV)

    with local_workers(2) as pool:
        run_pairs([deadly], METHODS, tmp_path / "run", suite="made", executor=pool)

    assert set(outcomes(tmp_path / "run").values()) == {"error"}
    assert all("SIGSEGV" in row["reason"] for row in read_rows(tmp_path / "run"))


@pytest.mark.slow
def test_workers_that_have_grown_are_replaced(monkeypatch):
    monkeypatch.setattr("scenarios.execution.executors.GROWN_MB", 1.0)
    monkeypatch.setattr("scenarios.execution.executors.RECYCLE_AFTER", 5)
    with local_workers(2) as pool:
        pids = {future.result() for _, future in completed(pool, pid_of, range(40), in_flight=4)}

    assert len(pids) >= 5


def pid_of(_):
    return os.getpid()


@pytest.mark.slow
def test_workers_stop_in_the_middle_of_their_work_where_the_body_fails(tmp_path):
    def fail():
        with local_workers(2) as pool:
            for _ in range(2):
                pool.submit(time.sleep, 600)  # a run that waited for it would be seen to hang
            wait_for(lambda: len(multiprocessing.active_children()) == 2)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()

    assert not multiprocessing.active_children()


def test_a_cluster_that_is_not_there_is_one_line(monkeypatch):
    monkeypatch.setattr("rectmerge.cli.cluster.REACHED_WITHIN_S", 0.3)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
    for wrong in (address, "nonsense://x"):
        with pytest.raises(InputError, match=f"--cluster {wrong}: no dask scheduler answers there"), cluster(wrong):
            pass


def test_without_distributed_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(InputError, match=r"rectmerge\[bench\]"), cluster("tcp://127.0.0.1:1"):
        pass


@pytest.mark.slow
def test_a_cluster_whose_worker_is_killed_gives_the_rows_of_an_undisturbed_run(tmp_path, dask_cluster):
    sources = [Slow(source_id=f"m{number}", started=tmp_path / "started", go_on=tmp_path / "go") for number in range(8)]

    def kill_one():
        wait_for(lambda: starts(tmp_path / "started") >= 2)
        os.kill(int((tmp_path / "started").read_text().split()[0]), signal.SIGKILL)
        (tmp_path / "go").touch()

    killer = threading.Thread(target=kill_one)
    killer.start()
    with workplace(1, dask_cluster.scheduler_address) as (executor, in_flight):
        run_pairs(sources, METHODS, tmp_path / "run", suite="made", executor=executor, in_flight=in_flight)
    killer.join()

    assert outcomes(tmp_path / "run") == all_right(sources)
    assert starts(tmp_path / "started") > len(sources)


@pytest.mark.slow
def test_a_task_that_kills_the_workers_of_a_cluster_becomes_rows(tmp_path, dask_cluster):
    others = [Source(source_id=f"m{number}") for number in range(6)]
    deadly = Deadly(source_id="deadly", notes=tmp_path / "notes", deaths=99)

    with workplace(1, dask_cluster.scheduler_address) as (executor, in_flight):
        run_pairs([deadly, *others], METHODS, tmp_path / "run", suite="made", executor=executor, in_flight=in_flight)

    by_pair = outcomes(tmp_path / "run")
    assert by_pair.items() >= all_right(others).items()
    assert {by_pair[pair_id] for pair_id in deadly.pair_ids} == {"error"}


@pytest.mark.slow
def test_a_failed_future_says_who_died():
    pool = LocalPool(2)
    try:
        [(item, future)] = completed(pool, os._exit, [7])
        assert item == 7
        with pytest.raises(WorkerDiedError, match="status 7, 3 times"):
            future.result()
    finally:
        pool.shutdown()

import subprocess
import sys
from dataclasses import replace

import pytest

from scenarios.bench.contenders import Contender, make_contenders
from scenarios.bench.task_ids import run_id, task_ids
from scenarios.dataset.reader import open_dataset
from scenarios.suites.suite import load_suite
from tests.scenarios.dataset.test_reader import ROW, write
from tests.scenarios.known_answers import Fixed, Source

ONE = Contender(label="one", method=Fixed())


def ids(source=None, *, seed=0, contender=ONE):
    return set(task_ids(source or Source(), [contender], seed=seed).values())


def test_each_pair_and_contender_has_an_id_of_its_own():
    by_task = task_ids(Source(), [ONE, Contender(label="two", method=Fixed())], seed=0)

    assert len(by_task) == len(set(by_task.values())) == 4


@pytest.mark.parametrize(
    "changed",
    [
        {"source": Source(fails=True)},
        {"source": Source(source_id="m1")},
        {"seed": 1},
        {"contender": Contender(label="one", method=Fixed(tx=5.0))},
        {"contender": Contender(label="two", method=Fixed())},
    ],
)
def test_what_determines_a_row_changes_its_id(changed):
    assert not ids(**changed) & ids()


@pytest.mark.slow
def test_ids_are_the_same_in_another_process():
    code = "from tests.scenarios.bench.test_task_ids import ids; print(sorted(ids()))"
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert process.stdout.strip() == str(sorted(ids()))


def test_a_data_set_may_be_moved_but_not_changed(tmp_path):
    def ids_of_set(name, rows, edit=b""):
        root = write(tmp_path / name / "set", rows)
        image = root / "test/maps/p_a.png"
        image.write_bytes(image.read_bytes() + edit)
        return ids(open_dataset(root)[0])

    first = ids_of_set("here", [ROW])
    assert ids_of_set("there", [ROW]) == first
    assert not ids_of_set("map", [ROW], b"more") & first
    assert not ids_of_set("truth", [{**ROW, "control_points": [*ROW["control_points"], [5, 10, 0, 10]]}]) & first
    assert not ids_of_set("about", [{**ROW, "noise": 3}]) & first


def test_a_resolved_scenario_and_its_seed_determine_a_mission():
    source = load_suite("smoke").sources()[0]
    other_noise = replace(source, scenario=replace(source.scenario, noise=(1,)))

    assert not ids(source) & ids(replace(source, seed=source.seed + 1))
    assert not ids(source) & ids(other_noise)
    assert ids(source) == ids(load_suite("smoke").sources()[0])


def test_a_run_is_all_of_its_tasks_in_their_order():
    sources = [Source(), Source(source_id="m1")]
    whole, pairs = run_id(sources, [ONE], suite="s", seed=0)

    assert pairs == 4
    assert run_id(sources, [ONE], suite="s", seed=0)[0] == whole
    others = [
        run_id(sources[::-1], [ONE], suite="s", seed=0),
        run_id(sources, [ONE], suite="t", seed=0),
        run_id(sources, [ONE], suite="s", seed=1),
        run_id(sources, [], suite="s", seed=0),
    ]
    assert whole not in [other for other, _ in others]


def test_a_field_of_a_group_changes_the_id_and_its_default_does_not():
    def robust(*settings):
        (contender,) = make_contenders(["robust"], [], settings)
        return ids(contender=contender)

    assert robust() == robust("robust.rank.max_bent_fits=8")
    assert not robust() & robust("robust.rank.max_bent_fits=7")

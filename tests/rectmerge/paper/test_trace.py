import re

import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import make_method
from rectmerge.paper.figures import FIGURES, draw_figures, final_pass
from rectmerge.paper.iteration import ConditionError
from rectmerge.paper.merging import Paper
from rectmerge.paper.repaired import PaperRepaired
from rectmerge.paper.rmap import rmap
from rectmerge.paper.trace import neighbours_table, passes_table, trace_method
from tests.rectmerge.paper import plans

PLAN = plans.floor_plan()
ONE_ROOM = OccupancyGrid(np.pad(np.zeros((30, 40), np.int8), 3, constant_values=100))
STAIRS = OccupancyGrid(np.where(plans.stairs(), 0, 100).astype(np.int8))


@pytest.mark.slow
@pytest.mark.parametrize(
    "method", [Paper(), PaperRepaired(), Paper(max_iterations=1)], ids=["letter", "repaired", "cut"]
)
def test_a_trace_gives_all_figures_whether_the_loop_ends_or_not(method):
    a, b = plans.moved(PLAN, 27)[0], plans.moved(PLAN, 225, 1 / 1.1429)[0]
    trace = trace_method(a, b, method=method)
    pictures = draw_figures(trace)

    assert tuple(pictures) == FIGURES
    assert all(picture.ndim == 3 and picture.dtype == np.uint8 and np.ptp(picture) > 0 for picture in pictures.values())
    assert bool(trace.alignment) == (method.max_iterations > 1)


def test_a_trace_ends_in_the_answer_of_the_method():
    a, b = plans.moved(PLAN, 27)[0], plans.moved(PLAN, 225)[0]
    trace = trace_method(a, b)
    alignment = Paper().align(a, b, scale=(0.5, 2.0), rng=np.random.default_rng(0))

    assert trace.alignment.as_dict() == alignment.as_dict()
    assert final_pass(trace).pixels == alignment.pixels


def test_the_table_has_a_row_per_match_and_a_ratio_only_without_a_turn():
    a, b = plans.moved(PLAN, 27)[0], plans.moved(PLAN, 225)[0]
    trace = trace_method(a, b)
    rows = [re.split(r" \| ", line.strip("| ")) for line in passes_table(trace.passes).splitlines()[2:]]

    assert len(rows) == len(trace.passes)
    assert rows[0][8:10] == ["180", "-"]
    assert rows[1][8] == "0"
    assert float(rows[1][9]) == pytest.approx(trace.passes[1].match.ratio, abs=1e-4)


@pytest.mark.parametrize(("bad", "condition"), [(ONE_ROOM, "three rectangles"), (STAIRS, "parallel edges")])
@pytest.mark.parametrize("name", ["A", "B"])
@pytest.mark.parametrize("method", ["paper", "paper-repaired"])
def test_a_condition_of_the_conclusion_that_is_not_met_is_named(bad, condition, name, method):
    maps = (bad, PLAN) if name == "A" else (PLAN, bad)

    with pytest.raises(ConditionError, match=rf"map {name} .*{condition}"):
        trace_method(*maps, method=make_method(method))


def test_another_method_has_no_trace():
    with pytest.raises(InputError, match="robust"):
        trace_method(PLAN, PLAN, method=make_method("robust"))


def test_a_series_that_ends_early_leaves_cells_empty():
    rectangles = rmap(np.pad(np.ones((3, 4), np.bool_), 1))

    assert neighbours_table(rectangles) == "\n".join(
        ["| direction |", "| --- |", "| up |", "| down |", "| left |", "| right |"]
    )

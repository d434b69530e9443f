import ast
import importlib.util
import logging
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from numba.core import config

from rectmerge._kernels import compiling
from rectmerge._kernels.wall_cells import known_bounds

SOURCE = """
from rectmerge._kernels.compiling import kernel

@kernel
def one_more(number):
    return number + 1
"""


@pytest.fixture
def notes(caplog, monkeypatch):
    """What a process notes that has not compiled yet."""
    monkeypatch.setattr(compiling.NOTICE, "is_logged", False)
    caplog.set_level(logging.INFO, logger="rectmerge")
    return caplog


CALLEE = """
from rectmerge._kernels.compiling import kernel

@kernel
def step():
    return {step}
"""
CALLER = """
from rectmerge._kernels.compiling import kernel
from loops_callee import step

@kernel
def one_step_more(number):
    return number + step()
"""
CHANGED_NUMBA = """
from numba.core import caching, ccallback
from numba.core.runtime import nrt
{change}
from rectmerge._kernels import compiling
from loops import one_more

is_expected = compiling.is_uncached(one_more)
print(one_more(1), is_expected, compiling.is_uncached(one_more))
"""


def loaded(file):
    spec = importlib.util.spec_from_file_location("loops", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_kernel_without_a_place_for_its_cache_runs_and_says_that_it_compiles_each_time(notes):
    names = {}
    exec(SOURCE, names)  # code without a file has nowhere to be cached, as on a read-only disk

    assert not compiling.is_uncached(names["one_more"])  # so that not every merge compiles all kernels first
    assert names["one_more"](1) == 2
    (note,) = notes.messages
    assert "at every start" in note


def test_only_what_is_really_compiled_is_noted(notes, tmp_path, monkeypatch):
    file = tmp_path / "loops.py"
    file.write_text(SOURCE)

    assert loaded(file).one_more(1) == 2
    (note,) = notes.messages
    assert "once on this machine for each command" in note

    notes.clear()
    monkeypatch.setattr(compiling.NOTICE, "is_logged", False)  # as in a second process
    assert loaded(file).one_more(1) == 2
    assert not notes.messages


def test_a_process_says_it_once(notes, tmp_path):
    file = tmp_path / "loops.py"
    file.write_text(SOURCE)
    one_more = loaded(file).one_more

    assert (one_more(1), one_more(1.5)) == (2, 2.5)
    assert len(notes.messages) == 1


def test_a_kernel_is_compiled_anew_where_another_file_of_its_package_has_changed(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    answers = []
    for step in (1, 10):  # two releases
        (tmp_path / "loops_callee.py").write_text(CALLEE.format(step=step))
        (tmp_path / "loops.py").write_text(CALLER)
        compiling.source_hash.cache_clear()  # as in a second process
        monkeypatch.delitem(sys.modules, "loops_callee", raising=False)
        importlib.invalidate_caches()
        module = loaded(tmp_path / "loops.py")
        assert compiling.is_uncached(module.one_step_more)
        answers.append(module.one_step_more(1))
        assert not compiling.is_uncached(module.one_step_more)

    assert answers == [2, 11]


def test_a_cache_is_of_one_level_of_optimisation(tmp_path, monkeypatch):
    file = tmp_path / "loops.py"
    file.write_text(SOURCE)
    loaded(file).one_more(1)
    assert not compiling.is_uncached(loaded(file).one_more)

    monkeypatch.setattr(config, "OPT", type(config.OPT)(0))
    assert compiling.is_uncached(loaded(file).one_more)


@pytest.mark.parametrize("change", ["del caching.FunctionCache", "del nrt.rtsys", "nrt.rtsys = object()"])
def test_without_a_name_that_numba_does_not_promise_kernels_are_cached_all_the_same(tmp_path, change):
    (tmp_path / "loops.py").write_text(SOURCE)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    for said in ("2 True False", "2 False False"):  # compiled, then loaded
        words = [sys.executable, "-c", CHANGED_NUMBA.format(change=change)]
        done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
        assert done.stdout.strip() == said, done.stderr


def test_only_kernels_are_optimised_lightly_and_what_they_call_with_them():
    light, before = compiling._LightOptimisation(), config.OPT
    kernel_event, other_event = (
        SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function)})
        for function in (known_bounds.py_func, loaded)
    )

    light.on_start(other_event)
    assert before == config.OPT
    light.on_end(other_event)
    light.on_start(kernel_event)
    light.on_start(other_event)
    light.on_end(other_event)
    assert int(config.OPT) == 1
    light.on_end(kernel_event)
    assert before == config.OPT


@pytest.mark.parametrize("folder", ["rectmerge/_kernels", "sim/_kernels"])
def test_no_kernel_is_a_generator_which_numba_cannot_call_from_its_cache(folder):
    for path in sorted((Path(__file__).parents[2] / folder).glob("*.py")):
        functions = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.FunctionDef)]
        kernels = [function for function in functions if "kernel" in map(ast.unparse, function.decorator_list)]
        assert kernels or path.stem in ("__init__", "compiling"), path.name
        for function in kernels:
            assert not any(isinstance(node, ast.Yield) for node in ast.walk(function)), f"{path.name}: {function.name}"

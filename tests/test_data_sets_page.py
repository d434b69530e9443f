"""The snippets of docs/data-sets.md load a data set; each library is tried where it is installed."""

import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from scenarios.dataset.generate import generate
from tests.scenarios.tiny_suite import TinySuite

PAGE = (Path(__file__).parents[1] / "docs" / "data-sets.md").read_text(encoding="utf-8")
PANDAS, DATASETS, TORCH = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder with a data set where the page has one."""
    monkeypatch.setattr("scenarios.dataset.writer.picture", lambda folder: b"a picture")
    generate(TinySuite(), tmp_path / "sets" / "smoke")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_pandas_reads_the_rows(checkout, capsys):
    pytest.importorskip("pandas", reason="the library pandas is not installed")
    names: dict[str, object] = {}

    exec(PANDAS, names)

    assert len(names["rows"]) == 6
    assert "rooms-0001-same" in capsys.readouterr().out


@pytest.mark.slow
def test_datasets_reads_rows_and_images(checkout):
    pytest.importorskip("datasets", reason="the library datasets is not installed")
    home = {"HF_HOME": str(checkout), "HF_HUB_OFFLINE": "1", "HF_DATASETS_OFFLINE": "1"}

    # a process of its own: the library looks at its environment once, and leaves threads behind
    read = subprocess.run([sys.executable, "-c", DATASETS], env=home, capture_output=True, text=True, check=False)

    assert read.returncode == 0, read.stderr
    assert read.stdout == "rooms-0001-same (80, 60)\n"


def stand_in_for_torch():
    """Stand in for the few names of PyTorch, a large library, that the snippet takes: arrays for tensors."""
    torch = ModuleType("torch")

    def loader(dataset, batch_size, collate_fn):
        for first in range(0, len(dataset), batch_size):
            yield collate_fn([dataset[k] for k in range(first, min(len(dataset), first + batch_size))])

    vars(torch).update(
        utils=SimpleNamespace(data=SimpleNamespace(Dataset=object, DataLoader=loader)),
        from_numpy=np.asarray,
        tensor=np.asarray,
    )
    return torch


@pytest.mark.parametrize("is_real", [True, False], ids=["torch", "stand-in"])
def test_torch_reads_related_pairs_with_their_truth(checkout, capsys, monkeypatch, is_real):
    if is_real:
        pytest.importorskip("torch", reason="the library torch is not installed")
    else:
        monkeypatch.setitem(sys.modules, "torch", stand_in_for_torch())
    names: dict[str, object] = {}

    exec(TORCH, names)

    assert len(names["MapPairs"]("sets/smoke/test")) == 3
    assert capsys.readouterr().out.count("60, 80") == 3

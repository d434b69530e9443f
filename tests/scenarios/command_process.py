"""The command `rectbench` in a process of its own, and a data set of tiny maps for it."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from subprocess import DEVNULL, Popen
from typing import IO

import cv2
import numpy as np

from tests.scenarios.dataset.test_reader import ROW

HOME = Path(__file__).parents[2]
HEEDS_CTRL_C = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"  # ignored in the background
START = [sys.executable, "-c", f"{HEEDS_CTRL_C}; from scenarios.cli.main import main; main()"]


def tiny_pairs(root: Path, count: int) -> Path:
    """Write a data set of so many pairs of one small room."""
    maps = root / "test/maps"
    maps.mkdir(parents=True)
    image = np.full((30, 40), 205, np.uint8)
    image[5:25, 5:35] = 0
    image[6:24, 6:34] = 254
    for name in "ab":
        cv2.imwrite(str(maps / f"p_{name}.png"), image)
    rows = [{**ROW, "pair_id": f"p{number:05d}", "place": f"h{number % 7}"} for number in range(count)]
    (root / "test/metadata.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    return root


def start(*words: object, stdout: int | IO[bytes] = DEVNULL, stderr: int | IO[bytes] = DEVNULL) -> Popen[bytes]:
    """Start the command in a session of its own, as a terminal does."""
    environment = {**os.environ, "PYTHONPATH": str(HOME), "COLUMNS": "150"}
    return Popen([*START, *map(str, words)], env=environment, start_new_session=True, stdout=stdout, stderr=stderr)


def descendants(pid: int) -> list[int]:
    """Return the processes below a process, its children first."""
    try:
        children = [
            int(child)
            for task in Path(f"/proc/{pid}/task").iterdir()
            for child in (task / "children").read_text().split()
        ]
    except OSError:
        return []
    return children + [below for child in children for below in descendants(child)]


def is_running(pid: int) -> bool:
    """Whether a process is there and not merely waiting for its parent to notice its end."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False

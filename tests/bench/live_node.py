"""Delay and load of the node on a real ROS 2: ``python -m tests.bench.live_node -o results/live/node.md``.

Simulated robots of one office send their maps together once a second, from the second map on once the node has compared
the first, for which it reads its compiled loops. A merge is possible from the first maps from
which the same code, without ROS and at once, publishes it; its delay runs from sending these to hearing the transform.
Nothing is asserted: figures are of the machine.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from rectmerge.live.merger import LiveMerger
from scenarios.execution.executors import describe_machine
from scenarios.scoring.markdown import markdown
from tests.ros.domain import DOMAIN
from tests.ros.fleet import Explorer, explore
from tests.ros.listening import Listener

MAP_EVERY_S = 1.0
REST_S = 30.0
START = "from rectmerge.cli.main import main; main()"


def main() -> None:
    """Measure fleets of 2, 3 and 5 robots, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3, help="fleets of each size")
    given = parser.parse_args()
    rows = []
    for robots in (2, 3, 5):
        delays, loads, costs = list[float](), list[float](), list[float]()
        for seed in range(given.seeds):
            fleet = explore(robots, seed=seed)
            heard, load = _measure(fleet)
            ticks, merge_s = _possible(fleet)
            delays += [heard[name] - tick for name, tick in ticks.items() if name in heard]
            loads.append(load)
            costs += merge_s
        figures = [f"{value:.2f}" for value in np.percentile(delays, [50, 100])] if delays else ["", ""]
        asked = str(given.seeds * (robots - 1))
        rows.append(
            (
                str(robots),
                f"{len(delays)} of {asked}",
                *figures,
                f"{np.median(costs):.2f}",
                f"{100 * np.median(loads):.0f}",
            )
        )
    given.output.write_text(
        _page(rows, f"python -m tests.bench.live_node -o {given.output} --seeds {given.seeds}"), encoding="utf-8"
    )


def _possible(fleet: list[Explorer]) -> tuple[dict[str, float], list[float]]:
    """Return the seconds at which the maps are sent that make each robot's merge possible, and what these steps take.

    The latter are seconds of a core, which other work on the machine does not lengthen.
    """
    merger, ticks, costs = LiveMerger(reference=fleet[0].name), dict[str, float](), list[float]()
    for version in range(len(fleet[0].maps)):
        for explorer in fleet:
            merger.update(explorer.name, explorer.maps[version])
        spent = time.process_time()
        events = merger.step().events
        if events:
            costs.append(time.process_time() - spent)
        for event in events:
            ticks.setdefault(event.robot, version * MAP_EVERY_S)
    return ticks, costs


def _measure(fleet: list[Explorer]) -> tuple[dict[str, float], float]:
    """Return the seconds at which each robot's transform is heard, and the share of a core that the node takes then."""
    listener = Listener()
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"ROS_DOMAIN_ID": str(DOMAIN), "ROS_HOME": folder, "ROS_LOG_DIR": folder}
        words = [sys.executable, "-c", START, "node", "--reference", fleet[0].name]
        node = subprocess.Popen(words, env=environment, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        try:
            _send(listener, fleet, 0)
            listener.wait_for(lambda: all(listener.is_compared(each.name) for each in fleet))
            heard = dict[str, float]()
            began = time.monotonic() - MAP_EVERY_S
            for version in range(1, len(fleet[0].maps)):
                _send(listener, fleet, version)
                _listen_until(listener, began + (version + 1) * MAP_EVERY_S, began, heard)
            _listen_until(listener, time.monotonic() + 5.0, began, heard)
            spent = _cpu_s(node.pid)
            listener.listen(REST_S)
            return heard, (_cpu_s(node.pid) - spent) / REST_S
        finally:
            node.kill()
            node.wait()
            listener.close()


def _send(listener: Listener, fleet: list[Explorer], version: int) -> None:
    for explorer in fleet:
        listener.send(explorer.name, explorer.maps[version])


def _listen_until(listener: Listener, end: float, began: float, heard: dict[str, float]) -> None:
    while (left := end - time.monotonic()) > 0:
        listener.listen(min(left, 0.01))
        for child in listener.transforms:
            heard.setdefault(child.removesuffix("/map"), time.monotonic() - began)


def _cpu_s(process: int) -> float:
    """Return the seconds of a core that a process has taken (Linux)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _page(rows: list[tuple[str, ...]], command: str) -> str:
    machine = describe_machine(command)
    heads = ("robots", "merged", "delay, median s", "longest s", "CPU s of the merge", "% of a core at rest")
    lines = [
        "# The node on ROS 2\n",
        "Simulated robots of one office send six maps each, together, once a second, to `rectmerge node` with its",
        "defaults. *Delay*: from the maps that made a merge possible, by the same code without ROS, to its transform;",
        "*CPU of the merge*: of the step that made it, there.",
        f"*At rest*: over {REST_S:.0f} s in which no map comes.\n",
        f"    {command}\n",
        f"By commit {machine['commit'] or 'unknown'}, on {os.cpu_count()} cores, load {os.getloadavg()[1]:.1f}.\n",
        markdown(heads, rows),
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()

"""Times of a run of the benches as ratios to the yardstick of the same run, kept per release and compared.

`python -m tests.bench.ratios save BENCH.json OUT.json` makes what is kept of what ``--benchmark-json`` wrote;
`python -m tests.bench.ratios compare NEW.json OLD.json` prints a table and exits 1 on a ratio that grew too far.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

SCHEMA = "rectmerge.bench/1"
WORSE = 1.25  # growth of a ratio that counts as a regression; two runs of one commit differ by up to a fifth


def yardstick_seconds(rounds: int = 3) -> float:
    """Time a fixed piece of work, half interpreter and half numpy; the least of the rounds, in seconds."""
    values = np.random.default_rng(0).random(400_000)
    seconds = []
    for _ in range(rounds):
        began = time.perf_counter()
        sum(k * k % 7 for k in range(200_000))
        np.sort(values)
        seconds.append(time.perf_counter() - began)
    return min(seconds)


def release_record(measured: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is kept of a run: the least time of every bench over the yardstick measured just before it."""
    ratios = {
        str(bench["fullname"]).removeprefix("tests/bench/"): round(
            bench["stats"]["min"] / bench["extra_info"]["yardstick_s"], 4
        )
        for bench in measured["benchmarks"]
    }
    machine = measured["machine_info"]
    commit = str((measured.get("commit_info") or {}).get("id") or "unknown")[:12]
    return {
        "schema": SCHEMA,
        "commit": commit,
        "machine": f"{machine['cpu'].get('brand_raw') or machine['machine']}, Python {machine['python_version']}",
        "ratios": dict(sorted(ratios.items())),
    }


def comparison(new: Mapping[str, Any], old: Mapping[str, Any], worse: float = WORSE) -> tuple[str, list[str]]:
    """Return the ratios of two runs as a Markdown table, and the names of benches that grew by more than `worse`."""
    lines, slower = ["| bench | old | new | new / old |", "| --- | --- | --- | --- |"], []
    for name in sorted({*new["ratios"], *old["ratios"]}):
        before, after = old["ratios"].get(name), new["ratios"].get(name)
        growth = after / before if before and after else None
        if growth and growth > worse:
            slower.append(name)
        cells = ("-" if value is None else f"{value:.3g}" for value in (before, after, growth))
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines), slower


def main(action: str, first: str, second: str) -> int:
    """Save or compare; return the exit status."""
    read = json.loads(Path(first).read_text(encoding="utf-8"))
    if action == "save":
        Path(second).write_text(json.dumps(release_record(read), indent=1) + "\n", encoding="utf-8")
        return 0
    table, slower = comparison(read, json.loads(Path(second).read_text(encoding="utf-8")))
    sys.stdout.write(f"{table}\n\n{len(slower)} slower by more than {WORSE - 1:.0%}: {', '.join(slower) or 'none'}\n")
    return int(bool(slower))


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("save", "compare"):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))

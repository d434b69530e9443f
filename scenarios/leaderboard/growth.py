"""Growth of the cost of methods with the size of the maps, as a table and a plot."""

from __future__ import annotations

import io
import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from scenarios.execution.files import clear_folder
from scenarios.report.charts import COLOURS, MARKERS
from scenarios.scoring.markdown import markdown

PAGE, PLOT = "README.md", "growth.svg"
BENCH = "tests/bench/bench_growth.py"
MEASURE = f'pytest {BENCH} -o python_files="bench_*.py" --benchmark-only --benchmark-json=growth.json'
REMEDY = f"make one with: {MEASURE}"
Times = Mapping[str, Mapping[int, float]]  # seconds by name and by the side of the maps, cells
ACCEPTED = "accepted"


def write_growth(measured: Path, out: Path, *, force: bool = False) -> None:
    """Write the page and the plot from the JSON of ``pytest tests/bench/bench_growth.py --benchmark-json``.

    Raises
    ------
    InputError
        If the file holds no such times, or the folder holds an earlier page and `force` is off.
    """
    try:
        record = json.loads(measured.read_text(encoding="utf-8"))
        times, refused, peaks = _times(record), _refused(record), _peaks(record)
        machine = f"{record['machine_info']['cpu']['brand_raw']}, Python {record['machine_info']['python_version']}"
    except OSError as error:
        raise InputError(f"{measured}: cannot be read: {error.strerror}; {REMEDY}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{measured}: not the JSON of {BENCH}; {REMEDY}") from error
    if not times:
        raise InputError(f"{measured}: holds no times of {BENCH}; {REMEDY}")
    folder = clear_folder(out, [PAGE, PLOT], force=force)
    replace_file(folder / PLOT, plot(times).encode())
    commit = str((record.get("commit_info") or {}).get("id") or "unknown")[:12]
    replace_file(folder / PAGE, page(times, refused, peaks, f"{machine}; commit {commit}").encode())


def page(times: Times, refused: Collection[tuple[str, int]], peaks: Mapping[int, float], machine: str) -> str:
    """Return the page: the times, and the power of the number of cells by which each grows.

    Parameters
    ----------
    times
        Of each method, stage and command.
    refused
        Names and sides of those that were not accepted.
    peaks
        Peak memory of the command by the side of the maps, MB.
    machine
        The machine and the commit.
    """
    sides = sorted({side for by_side in times.values() for side in by_side})
    rows = []
    for name, by_side in times.items():
        cells = [
            f"{by_side[side]:.3f}{' no' if (name, side) in refused else ''}" if side in by_side else "-"
            for side in sides
        ]
        rows.append((name, *cells, _power(by_side)))
    if peaks:
        memory = (f"{peaks[side]:.0f} MB" if side in peaks else "-" for side in sides)
        rows.append(("peak memory of the command", *memory, _power(peaks)))
    return f"""# How cost grows with the size of the maps

{INTRODUCTION}
{markdown(("what", *(f"{side} cells" for side in sides), "power"), rows)}
![Seconds against cells along the longest side]({PLOT})

    {MEASURE}
    rectbench growth growth.json -o results/growth

{machine}.
"""


def plot(times: Times) -> str:
    """Draw the times of whole methods as SVG."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for k, (name, by_side) in enumerate(item for item in times.items() if not item[0].startswith("stage")):
        style: dict[str, Any] = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}
        axes.plot(sorted(by_side), [by_side[side] for side in sorted(by_side)], label=name, lw=1.3, ms=5, **style)
    axes.set_xscale("log")
    axes.set_yscale("log")
    sides = sorted({side for by_side in times.values() for side in by_side})
    axes.set_xticks(sides, [str(side) for side in sides])
    axes.minorticks_off()
    axes.set_xlabel("cells along the longest side")
    axes.set_ylabel("least wall time of an answer, seconds")
    axes.grid(visible=True, alpha=0.2)
    figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    written = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": PLOT}):
        figure.savefig(written, format="svg", metadata={"Date": None})
    return written.getvalue()


def _times(record: Mapping[str, Any]) -> dict[str, dict[int, float]]:
    times: dict[str, dict[int, float]] = {}
    for bench in record["benchmarks"]:
        extra = bench["extra_info"]
        if "what" in extra and "side" in extra:
            times.setdefault(str(extra["what"]), {})[int(extra["side"])] = float(bench["stats"]["min"])
    return times


def _refused(record: Mapping[str, Any]) -> set[tuple[str, int]]:
    extras = [bench["extra_info"] for bench in record["benchmarks"]]
    return {(str(one["what"]), int(one["side"])) for one in extras if one.get("verdict", ACCEPTED) != ACCEPTED}


def _peaks(record: Mapping[str, Any]) -> dict[int, float]:
    extras = [bench["extra_info"] for bench in record["benchmarks"]]
    return {int(one["side"]): float(one["peak_mb"]) for one in extras if "side" in one and "peak_mb" in one}


def _power(by_side: Mapping[int, float]) -> str:
    """Return the slope of log time against log cells; 1 is linear in the number of cells."""
    if len(by_side) < 2:
        return "-"
    cells = 2 * np.log(np.array(sorted(by_side), np.float64))
    seconds = np.log([by_side[side] for side in sorted(by_side)])
    return f"{np.polyfit(cells, seconds, 1)[0]:.2f}"


INTRODUCTION = """Least wall time of three answers in seconds, warm, one thread, all in one run: one pair of drawn plans
with noise on its cells, drawn in more and more cells, the noise as well. *no*: not accepted. *Power*: of the number of
cells by which the time grows, by least squares; 1 is linear. Methods that shrink large maps first, as most do here,
grow by less.
"""

"""Study of fleets: every entrant put to every fleet of some data sets, by any number of workers, and resumed.

The folder gets ``results.jsonl``, a line for each fleet as it is done, and README.md at the end.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.io.atomic_file import replace_file
from scenarios.dataset.fleets import Fleet, read_fleets
from scenarios.execution.executors import IN_FLIGHT, completed, describe_machine
from scenarios.execution.journal import Journal
from scenarios.pairs.pair import MapPair
from scenarios.studies import fleet_entrants as entrants
from scenarios.studies.fleet_page import page
from scenarios.studies.fleet_scores import score_fleet

RESULTS, PAGE = "results.jsonl", "README.md"
PEERS = ("robust", "keypoints")  # whose accepted pairs make the trees


def fleets_of(datasets: Sequence[str | Path]) -> list[Fleet]:
    """Read the fleets of data sets, which must have different names.

    Raises
    ------
    InputError
        If a folder is no data set of fleets, or two have one name.
    """
    found = [read_fleets(path) for path in datasets]
    names = [fleets[0].suite for fleets in found if fleets]
    if len(set(names)) != len(names):
        raise InputError(f"data sets of fleets need different names, got {', '.join(names)}")
    return list(itertools.chain.from_iterable(found))


def study_fleets(
    fleets: Sequence[Fleet],
    out: str | Path,
    *,
    executor: Executor | None = None,
    in_flight: int = IN_FLIGHT,
    command: str = "",
    on_done: Callable[[int], None] = lambda count: None,
) -> None:
    """Put all entrants to every fleet that the folder has no line of, and write the page.

    Parameters
    ----------
    fleets
        The fleets.
    out
        The folder.
    executor, in_flight
        Where fleets are joined, and how many are handed out at a time; None is this process.
    command
        The command line, for the page.
    on_done
        Told how many more fleets are done; at first, those of an earlier call.

    Raises
    ------
    InputError
        If the folder cannot be written.
    """
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from None
    journal = Journal(folder / RESULTS)
    try:
        journal.mend()
        known = {(line["suite"], line["fleet_id"]) for _, line in journal.entries()}
        due = [fleet for fleet in fleets if (fleet.suite, fleet.fleet_id) not in known]
        on_done(len(fleets) - len(due))
        for _, future in completed(executor, measure_fleet, due, in_flight=in_flight):
            journal.append(future.result())
            on_done(1)
        lines = [line for _, line in journal.entries()]
    finally:
        journal.close()
    wanted = [(fleet.suite, fleet.fleet_id) for fleet in fleets]
    chosen = [line for line in lines if (line["suite"], line["fleet_id"]) in wanted]
    chosen.sort(key=lambda line: wanted.index((line["suite"], line["fleet_id"])))
    replace_file(folder / PAGE, page(chosen, describe_machine(command)).encode())


def measure_fleet(fleet: Fleet) -> dict[str, Any]:
    """Put all entrants to one fleet, and return the line of it."""
    rows = fleet.rows()
    truth = {names: row.pair() for names, row in rows.items()}
    maps = fleet.grids()
    methods = {name: entrants.method_of(name, maps) for name in PEERS}
    answers = {name: entrants.ask_all(method) for name, method in methods.items()}
    robust = methods["robust"]
    lies = entrants.make_lies(fleet.fleet_id, truth, answers["robust"])
    liar = robust.telling(lies)
    joint, _ = entrants.join_jointly(robust)
    joined = {
        "joint": joint,
        **{f"tree of {name}": entrants.join_by_tree(answers[name]) for name in PEERS},
        "joint, lied to": entrants.join_jointly(liar)[0],
        "tree of robust, lied to": entrants.join_by_tree(entrants.ask_all(liar)),
    }
    if fleet.is_growing:
        joined["joint, one by one"] = _grown(robust, list(maps))
    scores = {name: score_fleet(one, fleet.places, truth) for name, one in joined.items()}
    return {"suite": fleet.suite, "fleet_id": fleet.fleet_id, "group": _group(truth), "entrants": scores}


def _grown(method: entrants.Remembered, names: Sequence[str]) -> entrants.Joined:
    """Join maps that come one after the other, each time by the earlier answers."""
    graph: AlignmentGraph | None = None
    for count in range(2, len(names) + 1):
        some = entrants.Remembered(method.method, {name: method.maps[name] for name in names[:count]})
        grown, graph = entrants.join_jointly(some, graph)
    return grown


def _group(truth: dict[entrants.Pair, MapPair]) -> str:
    """Return how the maps of a fleet were made, by which the page groups fleets."""
    pair = next(iter(truth.values()))
    return str(pair.info["fleet"]).rsplit("-", 1)[0]

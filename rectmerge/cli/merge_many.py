"""Merge of more than two maps, for the command `rectmerge merge`."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.warm_up import compile_before_first_merge
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.aligning import Scale
    from rectmerge.alignment import Method
    from rectmerge.cli.bend_options import BendOptions
    from rectmerge.composing.compose import CellsOf, Rule
    from rectmerge.elastic.bend import Bend
    from rectmerge.fleet.asking import PairAsker, Progress
    from rectmerge.fleet.graph import AlignmentGraph
    from rectmerge.fleet.journal import Journal
    from rectmerge.grid import OccupancyGrid
    from rectmerge.results.inputs import Input

PROGRESS_SECONDS = 5.0
PAIRS_PER_MAP = 5  # asked, about
GOES_ON = "the same command goes on where this one stopped"

MoreMaps = Annotated[list[Path] | None, typer.Argument(metavar="[C ...]", help="More maps, any number.")]
Reference = Annotated[
    str | None,
    typer.Option(metavar="MAP", help="Of more than two maps, the one whose frame and cells are kept; else A."),
]
AllOrNothing = Annotated[
    bool, typer.Option("--all-or-nothing", metavar="", help="Of more than two maps, write a map only of all.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, metavar="N", help="Processes that align pairs, of more than two maps; same answer.")
]
Cluster = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Scheduler of a dask cluster that aligns them, such as tcp://host:8786."),
]


@dataclass(frozen=True, kw_only=True)
class FleetOptions:
    """Options on the merge of more than two maps."""

    reference: Reference = None
    all_or_nothing: AllOrNothing = False
    workers: Workers = None
    cluster: Cluster = None

    def refuse(self) -> None:
        """Refuse these options for two maps."""
        if self.reference is not None or self.all_or_nothing:
            option = "--all-or-nothing" if self.reference is None else "--reference"
            raise InputError(f"{option} is for more than two maps; of two, A's frame is kept")
        if self.cluster is not None or self.workers is not None:
            option = "--workers" if self.cluster is None else "--cluster"
            raise InputError(f"{option} is for more than two maps; two are aligned in this process")

    @contextmanager
    def executor(self) -> Iterator[Executor | None]:
        """Open what aligns pairs: a cluster or worker processes; None where this process does."""
        if self.workers and self.cluster is not None:
            raise InputError("--workers and --cluster exclude each other")
        try:
            if self.cluster is not None:
                from rectmerge.cli.cluster import cluster

                with cluster(self.cluster) as (executor, _):
                    yield executor
            elif (self.workers or 1) > 1:
                with ProcessPoolExecutor(self.workers, mp_context=get_context("spawn")) as pool:
                    yield pool
            else:
                yield None
        except KeyboardInterrupt:
            console.note(f"rectmerge: {GOES_ON}")
            raise
        except (BrokenExecutor, CancelledError):
            what = "a worker process" if self.cluster is None else f"the cluster {self.cluster}, or a worker of it,"
            raise InputError(f"{what} died; {GOES_ON}") from None

    def ordered(self, maps: Mapping[str, OccupancyGrid], inputs: Sequence[Input]) -> dict[str, OccupancyGrid]:
        """Return the maps with the reference first."""
        first = next(iter(maps))
        if self.reference is not None:
            by_path = {one.given: name for one, name in zip(inputs, maps, strict=True)}
            first = by_path.get(self.reference, self.reference)
            if first not in maps:
                raise InputError(f"--reference {self.reference} is none of the maps: {', '.join(maps)}")
        return {first: maps[first], **maps}


def map_names(inputs: Sequence[Input]) -> list[str]:
    """Name maps by their files without suffix, or by their paths where those are not distinct.

    Raises
    ------
    InputError
        If a map is given twice.
    """
    given = [one.given for one in inputs]
    if twice := [name for name in given if given.count(name) > 1]:
        raise InputError(f"{twice[0]}: is given twice; name each map once")
    stems = [Path(name).stem for name in given]
    return stems if len(set(stems)) == len(stems) else given


def merge_many(
    inputs: Sequence[Input],
    output: Path,
    options: FleetOptions,
    bending: BendOptions,
    *,
    method: Method,
    scale: Scale,
    seed: int,
    rule: Rule,
    cells: CellsOf | float,
    is_checked: bool,
    earlier: Path | None,
    force: bool,
    json: bool,
) -> None:
    """Place more than two maps together, write a merged map of each component, and exit with the status."""
    from rectmerge.cli.map_options import input_files, read_maps
    from rectmerge.fleet.asking import PairAsker
    from rectmerge.fleet.journal import Journal
    from rectmerge.fleet.outcome import answer_of, describe
    from rectmerge.fleet.record import to_json_dict
    from rectmerge.io.json_text import plain, to_json
    from rectmerge.method_fields import field_values
    from rectmerge.results.folder import ResultFolder
    from rectmerge.results.inputs import input_json_dict

    names = map_names(inputs)
    folder = ResultFolder(output)
    folder.check(input_files(inputs), force=force)
    maps = dict(zip(names, read_maps(inputs), strict=True))
    ordered = options.ordered(maps, inputs)
    reference = next(iter(ordered))
    if cells != "a" and maps[reference].resolution is None:
        raise InputError(f"{reference}: its resolution is not known: keep --output-resolution a")
    settings = {"method": method.name, "fields": plain(field_values(method)), "scale": plain(scale), "seed": seed}
    settings |= {"checked": is_checked}
    before = None if earlier is None else _earlier(earlier, settings)
    journal = Journal(output, settings)
    graph = _graph(ordered, PairAsker(method, scale, seed, is_checked=is_checked), before, options, journal)
    bends: dict[str, Bend] = {}
    files: dict[str, bytes] = {}
    merged: Sequence[str | None] = [None] * len(graph.components)
    if graph or not options.all_or_nothing:
        bends = bending.bend_many(graph, ordered, _bend_progress(len(graph.placements) - len(graph.components)))
        files, merged = _merged(graph, ordered, bends, rule, cells)
    entries = {name: input_json_dict(output, one, maps[name]) for name, one in zip(names, inputs, strict=True)}
    record = to_json_dict(graph, maps, entries, merged, bends, settings)
    written = folder.replace(files | _records(graph, ordered, merged, bends, record))
    journal.remove()
    console.tell(to_json(record) if json else describe(graph, written, merged=merged, bends=bends))
    raise typer.Exit(console.STATUS[answer_of(graph)])


def _graph(
    maps: Mapping[str, OccupancyGrid],
    ask: PairAsker,
    before: AlignmentGraph | None,
    options: FleetOptions,
    journal: Journal,
) -> AlignmentGraph:
    """Align the maps, the reference first, from where an interrupted merge left them."""
    from rectmerge.fleet.many import build_graph

    if journal.answers:
        console.note(f"rectmerge: goes on with an interrupted merge; answered pairs: {len(journal.answers)}")
    compile_before_first_merge()
    with options.executor() as executor:
        return build_graph(maps, ask, earlier=before, executor=executor, progress=_progress(len(maps)), journal=journal)


def _earlier(path: Path, settings: Mapping[str, object]) -> AlignmentGraph:
    """Read the graph of an earlier merge of many maps, by its folder or its fleet.json."""
    from rectmerge.fleet.record import FleetFile
    from rectmerge.fleet.saved_graph import read_graph

    file = FleetFile.find(path)
    if file is None:
        raise InputError(
            f"{path}: is no fleet.json, nor a folder that holds one: --from takes that of an earlier merge"
        )
    return read_graph(FleetFile.read(file), settings)


def _merged(
    graph: AlignmentGraph,
    maps: Mapping[str, OccupancyGrid],
    bends: Mapping[str, Bend],
    rule: Rule,
    cells: CellsOf | float,
) -> tuple[dict[str, bytes], Sequence[str | None]]:
    """Return the files of the merged maps, pictures among them, and the name of each component's map."""
    from rectmerge.composing.rules import SHADING
    from rectmerge.fleet.outcome import component_pictures, compose_component, merged_stems
    from rectmerge.io.image_file import encode_image
    from rectmerge.io.map_file import has_shades
    from rectmerge.results.folder import merged_files

    straight = {name: bends[name].straighten(grid) if name in bends else grid for name, grid in maps.items()}
    files: dict[str, bytes] = {}
    stems = merged_stems(graph, next(iter(maps)))
    for names, stem in zip(graph.components, stems, strict=True):
        composition = compose_component(graph, names, straight, rule, cells)
        is_shaded = rule in SHADING and has_shades(composition.grid)
        files |= merged_files(composition.grid, stem, shaded=is_shaded)
        pictures = component_pictures(graph, names, straight, composition, stem)
        files |= {name: encode_image(picture, ".png") for name, picture in pictures.items()}
    return files, [f"{stem}.yaml" for stem in stems]


def _records(
    graph: AlignmentGraph,
    maps: Mapping[str, OccupancyGrid],
    merged: Sequence[str | None],
    bends: Mapping[str, Bend],
    record: Mapping[str, object],
) -> dict[str, bytes]:
    """Return the files that say how the maps lie to each other, by name; that of the whole answer is the last."""
    from rectmerge.fleet.outcome import graph_picture
    from rectmerge.fleet.record import transforms_yaml
    from rectmerge.io.image_file import encode_image
    from rectmerge.io.json_text import to_json
    from rectmerge.results.folder import BEND_NAME

    files = {"graph.png": encode_image(graph_picture(graph, maps), ".png")}
    if bent := {name: bend.transform.as_dict() for name, bend in bends.items() if bend.transform is not None}:
        files[BEND_NAME] = (to_json({"maps": bent}) + "\n").encode()
    files["transforms.yaml"] = transforms_yaml(graph, merged)
    files["fleet.json"] = (to_json(record) + "\n").encode()
    return files


def _progress(count: int) -> Progress:
    """Return a function that notes now and then how many pairs of so many maps are asked, and the time left."""
    about = min(count * (count - 1) // 2, PAIRS_PER_MAP * count)
    started, note = time.monotonic(), _now_and_then()

    def tell(asked: int) -> None:
        left = (time.monotonic() - started) / asked * max(0, about - asked)
        note(f"{asked} of about {about} pairs asked, about {left:.0f} s left")

    return tell


def _bend_progress(count: int) -> Callable[[int], None]:
    """Return a function that notes now and then how many times a map of so many was tried to bend."""
    note = _now_and_then()
    return lambda tried: note(f"{tried} bends tried, of about {count} maps")


def _now_and_then() -> Callable[[str], None]:
    """Return a function that notes a line where the last one is some seconds old."""
    last = time.monotonic()

    def note(line: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= PROGRESS_SECONDS:
            console.note(f"rectmerge: {line}")
            last = now

    return note

"""A suite as a data set: every pair made once and kept, by any number of workers, over any number of interruptions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

from rectmerge.errors import InputError
from rectmerge.extras import require_extras
from rectmerge.io.json_text import to_json
from scenarios.dataset.content_hash import content_hash
from scenarios.dataset.packing import Explorer, Package, make_within
from scenarios.dataset.suite_seeds import Secret, mixed, seeds_end, shifted
from scenarios.dataset.writer import DataSetWriter, finished_info
from scenarios.execution.executors import IN_FLIGHT, WorkerDiedError, completed, describe_machine
from scenarios.execution.limits import MAKING, Limits
from scenarios.pairs.pair import PairSource

SCHEMA = "rectmerge.dataset/1"
SEED_STRIDE = 1_000_000  # seeds of a suite between two seeds of data sets


Form = Literal["files", "mcap", "rosbag1"]


class PairSuite(Protocol):
    """Sources and description of a data set: a dataclass such as `scenarios.suites.suite.Suite`."""

    @property
    def name(self) -> str:
        """Of the suite."""

    @property
    def title(self) -> str:
        """A few words."""

    @property
    def description(self) -> str:
        """Description for the card."""

    def sources(self) -> Sequence[PairSource]:
        """Return the sources of the pairs, in order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A source with the number of its first pair in the data set, the count of pairs wanted, and its limits."""

    source: PairSource
    first: int
    count: int
    limits: Limits = MAKING
    form: Form = "files"


def generate(
    suite: PairSuite,
    out: str | Path,
    *,
    pairs: int | None = None,
    seed: int = 0,
    form: Form = "files",
    secret: Secret | None = None,
    executor: Executor | None = None,
    in_flight: int = IN_FLIGHT,
    force: bool = False,
    command: str | None = None,
    on_done: Callable[[int], None] = lambda pairs: None,
) -> dict[str, Any]:
    """Make a data set of a suite, or continue an interrupted call with the same arguments.

    Parameters
    ----------
    suite
        What is made.
    out
        The data set's folder.
    pairs
        As many of the suite's pairs, from the first on; when they run out it goes on with further seeds. None is all.
    seed
        Of the data set: adds a million times as much to every seed of the suite, so two data sets share no building.
    form
        "mcap" and "rosbag1" also write the mission of every pair as a ROS bag, for ROS 2 or ROS 1; that takes suites
        of simulated missions.
    secret
        Mixed into every seed of the suite, so that who does not know it cannot make the same pairs; its SHA-256 is kept
        in ``dataset_info.json``.
    executor
        Where the pairs are made; None is this process.
    in_flight
        How many missions are handed to the executor at a time.
    force
        Clear another data set in the folder first.
    command
        What the card says the data set was made by; `rectbench generate` unless given.
    on_done
        Told how many more pairs are done with; at first, those of an earlier call.

    Returns
    -------
    dict
        The content of ``dataset_info.json``.

    Raises
    ------
    InputError
        If the folder holds something else, cannot be written, no pair came to be, or bags cannot be written.

    Notes
    -----
    The files are the same, byte for byte, whatever the executor and however often it was interrupted. A pair that could
    not be made is named in ``dataset_info.json`` with the reason.
    """
    check_form(suite, form)
    identity = identity_of(suite, pairs=pairs, seed=seed, form=form, secret=secret)
    if not force and (info := finished_info(out)) and all(info.get(key) == identity[key] for key in identity):
        on_done(sum(part["pairs"] for part in info["splits"].values()) + len(info["failed"]))
        return info
    with DataSetWriter(out, identity, force=force) as writer:
        on_done(sum(writer.done.values()))
        jobs = plan(mixed(suite, secret) if secret else suite, pairs=pairs, seed=seed, form=form)
        for package in _packages(executor, in_flight, (job for job in jobs if job.source.source_id not in writer.done)):
            writer.write(package)
            on_done(len(package.rows) + len(package.failed))
        about = {"title": suite.title, "description": suite.description}
        return writer.finish(about if command is None else {**about, "command": command})


def check_form(suite: PairSuite, form: Form) -> None:
    """Refuse bags if they cannot be written.

    Raises
    ------
    InputError
        If there is no such form, rosbags is not installed, or a source of the suite runs no mission.
    """
    if form not in get_args(Form):
        raise InputError(f"format must be one of {', '.join(get_args(Form))}, got {form!r}")
    if form == "files":
        return
    require_extras("rosbags")
    for source in suite.sources():
        if not isinstance(source, Explorer):
            raise InputError(f"{suite.name}: {source.source_id} runs no mission, so there is no bag of it to write")


def summary_text(info: Mapping[str, Any], *, as_json: bool = False) -> str:
    """Summarise a data set, for people or as JSON without checksums."""
    if as_json:
        return to_json({key: value for key, value in info.items() if key != "checksums"})
    splits = ", ".join(f"{split} {part['pairs']} pairs" for split, part in info["splits"].items())
    failed = [f"not made: {failure['pair_id']}: {failure['reason']}" for failure in info["failed"]]
    counts = f"{splits}; {len(failed)} could not be made; {len(info['checksums'])} files"
    return "\n".join([*failed, counts, f"id: {info['dataset_id']}"])


def plan(suite: PairSuite, *, pairs: int | None = None, seed: int = 0, form: Form = "files") -> Iterator[Job]:
    """Yield the jobs, in the order of their numbers.

    Raises
    ------
    InputError
        If there are not that many pairs.
    """
    if seed < 0 or (pairs is not None and pairs < 1):
        raise InputError(f"a data set needs seed >= 0 and pairs >= 1, got {seed} and {pairs}")
    first = 0
    for source in _sources(suite, seed * SEED_STRIDE, endless=pairs is not None):
        if pairs is not None and first >= pairs:
            return
        most = len(source.pair_ids)
        wanted = most if pairs is None else min(most, pairs - first)
        yield Job(source=source, first=first, count=wanted, form=form)
        first += most


def _sources(suite: PairSuite, shift: int, *, endless: bool) -> Iterator[PairSource]:
    """Yield the sources of a suite with its seeds shifted, then with the next seeds that it does not use, and so on."""
    period = seeds_end(suite)
    for lap in count():
        if (lap + 1) * period > SEED_STRIDE or (lap and not period):
            raise InputError(f"{suite.name}: its seeds run out; make several data sets with different --seed")
        yield from shifted(suite, shift + lap * period).sources()
        if not endless:
            return


def identity_of(
    suite: PairSuite, *, pairs: int | None, seed: int, form: Form = "files", secret: Secret | None = None
) -> dict[str, Any]:
    """Return all that determines the bytes of a data set, as plain data."""
    machine = describe_machine()
    versions = {"python": machine["python"], **machine["packages"], "commit": machine["commit"]}
    return {
        "schema": SCHEMA,
        "suite": suite.name,
        "suite_sha256": content_hash(suite),
        "seed": seed,
        "secret_sha256": None if secret is None else secret.sha256,
        "pairs": pairs,
        "format": form,
        "versions": versions,
    }


def _packages(executor: Executor | None, in_flight: int, jobs: Iterable[Job]) -> Iterator[Package]:
    for job, future in completed(executor, _do, jobs, in_flight=in_flight):
        try:
            yield future.result()
        except WorkerDiedError as death:
            yield Package(
                source_id=job.source.source_id,
                failed=dict.fromkeys(job.source.pair_ids[: job.count], str(death)),
            )


def _do(job: Job) -> Package:
    return make_within(
        job.limits, job.source, job.first, job.count, bags=None if job.form == "files" else job.form
    ).package

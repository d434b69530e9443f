"""Submission to the leaderboard: a finished run as one JSON file, with all that its lines of the table need."""

from __future__ import annotations

import hashlib
import json
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal

from rectmerge.errors import InputError, ScenarioError
from rectmerge.io.json_text import plain
from scenarios.bench.external_program import UNNAMED, Program
from scenarios.bench.resume import MACHINE, RECORD
from scenarios.bench.run import read_rows
from scenarios.dataset.dataset_id import dataset_root, measure_dataset_id
from scenarios.dataset.reader import dataset_name, open_dataset
from scenarios.dataset.writer import finished_info
from scenarios.execution.limits import Limits
from scenarios.leaderboard.submitted_row import reduced_row, submitted_row_fault, whole_row
from scenarios.report.reading import dataset_of
from scenarios.scoring.row import Row
from scenarios.suites.toml_tables import structure

Schema = Literal["rectmerge.submission/1"]
Status = Literal["self-reported", "verified"]
SCHEMA: Schema = "rectmerge.submission/1"
PROGRAM_FIELDS = {field.name for field in fields(Program)} - {"name"}  # in the record of a run
MOST_SHOWN = 200  # characters of a message


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineRecord:
    """Hardware, system and versions of a run; None where unknown."""

    processor: str
    cores: int | None
    system: str
    python: str
    packages: dict[str, str]
    commit: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DataSetRecord:
    """Name and id of a data set, and the SHA-256 of its secret where it has one."""

    name: str
    id: str
    secret_sha256: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MethodRecord:
    """Method of a run: its label, registered name, and the values of its fields; of a program "command" and none."""

    label: str
    method: str
    knows_scale: bool
    set: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Repetition of a submission by others: rows done again, all with the same result, and the machine."""

    rows: int
    of: int
    machine: MachineRecord
    seconds: dict[str, float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """A run as it is handed in.

    Parameters
    ----------
    schema
        Version of the layout.
    status
        "verified" once others have done it again, see `scenarios.leaderboard.verification`.
    data_set, seed, limits, machine, methods
        Determine the answers, but for chance in the time they take.
    seconds
        Processor time of all answers of each label; None where it was not measured.
    rows_sha256
        Of `rows`, by `hash_of_rows`.
    rows
        As in ``results.jsonl``, without what no line of the table needs: each a `SubmittedRow`, as it was written.
    verification
        Of a verified one.
    """

    schema: Schema = SCHEMA
    status: Status = "self-reported"
    data_set: DataSetRecord
    seed: int
    limits: Limits
    machine: MachineRecord
    methods: tuple[MethodRecord, ...]
    seconds: dict[str, float | None]
    rows_sha256: str
    rows: tuple[dict[str, Any], ...]
    verification: Verification | None = None

    @property
    def standing(self) -> str:
        """The status as the table shows it, with the share of rows that were done again."""
        if self.verification is None or self.verification.rows == self.verification.of:
            return self.status
        return f"{self.status}, {self.verification.rows} of {self.verification.of} rows"

    @property
    def knows_scale(self) -> dict[str, bool]:
        """Whether each label was given the scale."""
        return {method.label: method.knows_scale for method in self.methods}

    def as_rows(self) -> list[Row]:
        """Return the rows with None for what is missing."""
        return [whole_row(row) for row in self.rows]

    def to_json_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; a verification that is missing is left out."""
        return {key: value for key, value in plain(asdict(self)).items() if key != "verification" or value}


def submission_of(run: Path) -> Submission:
    """Make a submission of a finished run.

    Raises
    ------
    InputError
        If there is no finished run, its record cannot be read, or its data set is gone or has no longer all its pairs.
    """
    rows = read_rows(run)
    record = _record(run)
    target = dataset_of(run)
    if target is None:
        raise InputError(f"{run}: its data set is no longer where it was, and the submission needs its id; put it back")
    held = {pair_id for source in open_dataset(target) for pair_id in source.pair_ids}
    if lost := [row["pair_id"] for row in rows if row["pair_id"] not in held]:
        raise InputError(
            f"{run}: {target} does not hold {lost[0]}: another data set, or a pair that could not be made; "
            "run on a data set that `rectbench generate` made"
        )
    kept = tuple(sorted(map(reduced_row, rows), key=lambda row: (row["method"], row["pair_id"])))
    return Submission(
        data_set=data_set_record(target),
        seed=record["seed"],
        limits=Limits(timeout_s=record["timeout_s"], memory_mb=record.get("memory_mb")),
        machine=_read_machine(run),
        methods=tuple(map(_nameless, structure(record["methods"], list[MethodRecord], f"{RECORD}: methods"))),
        seconds=cpu_seconds(rows),
        rows_sha256=hash_of_rows(kept),
        rows=kept,
    )


def data_set_record(path: Path) -> DataSetRecord:
    """Return name, measured id and published hash of a data set, by its folder or that of a split."""
    root = dataset_root(path)
    secret = (finished_info(root) or {}).get("secret_sha256")
    return DataSetRecord(name=dataset_name(path), id=measure_dataset_id(root), secret_sha256=secret)


def read_submission(path: Path) -> Submission:
    """Read a submission and check its layout.

    Raises
    ------
    InputError
        If it cannot be read, or a key is missing, unknown, or of another kind; the message names file and key.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON: {error}") from None
    if not isinstance(content, dict) or "schema" not in content:
        raise InputError(f"{path}: schema: missing; `rectbench submit RUN -o FILE.json` makes a submission")
    try:
        submission = structure(content, Submission)
    except ScenarioError as error:
        raise InputError(f"{path}: {str(error).splitlines()[0]:.{MOST_SHOWN}}") from None
    if fault := next(_faults(submission), ""):
        raise InputError(f"{path}: {fault:.{MOST_SHOWN}}")
    return submission


def hash_of_rows(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the SHA-256 of rows, whatever their order and that of their keys."""
    lines = sorted(json.dumps(plain(row), sort_keys=True, separators=(",", ":")) for row in rows)
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def cpu_seconds(rows: Sequence[Row]) -> dict[str, float | None]:
    """Add up the processor time of each label's answers; None of a label without any."""
    times: dict[str, list[float]] = {row["method"]: [] for row in rows}
    for row in rows:
        if row["seconds"] and row["seconds"]["cpu"] is not None:
            times[row["method"]].append(row["seconds"]["cpu"])
    return {label: math.fsum(values) if values else None for label, values in times.items()}


def _faults(submission: Submission) -> Iterator[str]:
    """Yield what is wrong with values that have the right kind."""
    labels = [method.label for method in submission.methods]
    if not submission.rows:
        yield "rows: there are none"
    if len(set(labels)) != len(labels):
        yield "methods: two have the same label"
    if (submission.status == "verified") != (submission.verification is not None):
        yield 'verification: must be there where status is "verified", and only there'
    seen = set()
    for number, row in enumerate(submission.rows):
        if fault := submitted_row_fault(row, f"rows[{number}]"):
            yield fault
            return
        if row["method"] not in labels:
            yield f"rows[{number}].method: {row['method']!r} is not among methods"
        if (key := (row["method"], row["pair_id"])) in seen:
            yield f"rows[{number}].pair_id: {row['pair_id']!r} of {row['method']!r} is there twice"
        seen.add(key)
    if submission.rows_sha256 != hash_of_rows(submission.rows):
        yield "rows_sha256: is not that of the rows, which were changed"


def _nameless(method: MethodRecord) -> MethodRecord:
    """Leave out the command line of a program, which names folders, and the name it was given."""
    return replace(method, method=UNNAMED, set={}) if set(method.set) == PROGRAM_FIELDS else method


def _record(run: Path) -> dict[str, Any]:
    try:
        record = tomllib.loads((run / RECORD).read_text(encoding="utf-8"))
        return {"seed": record["seed"], "timeout_s": record["timeout_s"], "methods": record["methods"], **record}
    except (OSError, ValueError) as error:
        raise InputError(f"{run / RECORD}: cannot be read: {error}") from None
    except KeyError as error:
        raise InputError(f"{run / RECORD}: is not that of a run: there is no {error}") from None


def _read_machine(run: Path) -> MachineRecord:
    try:
        return machine_record(json.loads((run / MACHINE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise InputError(f"{run / MACHINE}: is not that of a run: {error}") from None


def machine_record(described: Mapping[str, Any]) -> MachineRecord:
    """Return a machine as `describe_machine` describes it, without the command, which may hold names of folders."""
    return structure({key: value for key, value in described.items() if key != "command"}, MachineRecord, MACHINE)

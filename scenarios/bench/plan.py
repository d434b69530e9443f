"""Who is put to what: a suite's or a data set's pairs, and the contenders that somebody named for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rectmerge.methods import DEFAULT_METHOD
from scenarios.bench import run as bench
from scenarios.bench.contenders import Contender, make_contenders
from scenarios.bench.entrants import EVERYBODY, contenders
from scenarios.bench.external_program import Program, labelled
from scenarios.dataset.reader import dataset_name, is_dataset, open_dataset
from scenarios.pairs.pair import PairSource
from scenarios.suites.suite import load_suite, suite_names


@dataclass(frozen=True, slots=True)
class Contest:
    """What is run, on what, and what the run's record says of it."""

    name: str
    sources: Sequence[PairSource]
    contenders: Sequence[Contender]
    about: dict[str, Any]
    dataset: dict[str, Any] | None = None  # of a suite, whose pairs are kept beside the rows: what its card says

    @property
    def tasks(self) -> int:
        """How many rows it makes."""
        return sum(len(source.pair_ids) for source in self.sources) * len(self.contenders)

    def run(self, out: str | Path, **options: Any) -> dict[str, Any]:
        """Run it into a folder, with the options of `bench.run`."""
        return bench.run(
            self.sources, self.contenders, out, suite=self.name, about=self.about, dataset=self.dataset, **options
        )


def contest_of(
    target: str,
    methods: Sequence[str],
    settings: Sequence[str] = (),
    commands: Sequence[str] = (),
    *,
    knows_scale: bool = False,
) -> Contest:
    """Find out what is run, on what.

    Parameters
    ----------
    target
        A suite's name or file, or a data set's folder.
    methods
        Methods, or labels of the suite or the leaderboard, "everybody" for all of the latter; where neither these nor
        commands are given, the suite's own contenders.
    settings
        Fields of methods, as in `make_contenders`.
    commands
        Command lines of programs, as in `Program`.
    knows_scale
        Whether the contenders are told the ratio of the maps' cells.

    Raises
    ------
    InputError
        If there is no such target or contender, or a contender cannot be made.
    """
    if EVERYBODY in methods:
        methods = [name for name in methods if name != EVERYBODY] + [one.label for one in contenders()]
    programs = labelled([Program(command=command) for command in commands], methods)
    others = [Contender(label=label, method=program, knows_scale=knows_scale) for label, program in programs.items()]
    default = [] if others else [DEFAULT_METHOD]
    # `make demo` leaves a folder `demo`, which must not hide the suite of that name
    if is_dataset(target) or (Path(target).is_dir() and target not in suite_names()):
        pairs = open_dataset(target)
        named = make_contenders(methods or default, contenders(), settings, knows_scale=knows_scale)
        return Contest(dataset_name(target), pairs, named + others, {"dataset": str(Path(target).resolve())})
    suite = load_suite(target)
    own = [] if others else [entry.label for entry in suite.methods]
    named = make_contenders(
        methods or own or default, [*contenders(), *suite.methods], settings, knows_scale=knows_scale
    )
    about = {"title": suite.title, "scenarios": [asdict(scenario) for scenario in suite.scenarios]}
    card = {"title": suite.title, "description": suite.description}
    return Contest(suite.name, suite.sources(), named + others, about, card)

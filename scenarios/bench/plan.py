"""The plan of a run: a suite's or a data set's pairs, and the contenders that take part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.methods import DEFAULT_METHOD
from scenarios.bench.contenders import Contender, make_contenders
from scenarios.bench.entrants import EVERYBODY, contenders
from scenarios.bench.external_program import Program, labelled
from scenarios.dataset.reader import dataset_name, is_dataset, open_dataset
from scenarios.pairs.pair import PairSource
from scenarios.suites.suite import load_suite, suite_names, with_cell_noise


@dataclass(frozen=True, slots=True, kw_only=True)
class RunPlan:
    """Pairs and contenders of a run.

    Parameters
    ----------
    suite
        Name of the suite or the data set.
    sources
        Sources of the pairs.
    contenders
        Methods under different labels.
    seed
        Seed of every answer.
    about
        Further content of ``run.toml``: the scenarios as they were resolved, or the data set's folder.
    card
        `title` and `description` of the data set in which the pairs are kept, in ``dataset/`` of the run's folder;
        None keeps no pairs.
    """

    suite: str
    sources: Sequence[PairSource]
    contenders: Sequence[Contender]
    seed: int = 0
    about: Mapping[str, Any] = field(default_factory=dict)
    card: Mapping[str, Any] | None = None

    @property
    def row_count(self) -> int:
        """Number of rows of the complete run."""
        return sum(len(source.pair_ids) for source in self.sources) * len(self.contenders)


def plan_run(
    target: str,
    methods: Sequence[str],
    settings: Sequence[str] = (),
    commands: Sequence[str] = (),
    *,
    knows_scale: bool = False,
    cell_noise: bool = False,
    seed: int = 0,
) -> RunPlan:
    """Plan a run from the words of a command.

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
        Whether the contenders get the true ratio of the maps' cells.
    cell_noise
        Whether a suite's levels of noise are those of version 1, even noise of the cells.
    seed
        Seed of every answer.

    Raises
    ------
    InputError
        If the target or a contender does not exist, a contender cannot be made, or cell noise is asked of a data set.
    """
    if EVERYBODY in methods:
        methods = [name for name in methods if name != EVERYBODY] + [entry.label for entry in contenders()]
    programs = labelled([Program.parse(command) for command in commands], methods)
    others = [Contender(label=label, method=program, knows_scale=knows_scale) for label, program in programs.items()]
    default = [] if others else [DEFAULT_METHOD]
    # `make demo` leaves a folder `demo`, which must not hide the suite of that name
    if is_dataset(target) or (Path(target).is_dir() and target not in suite_names()):
        if cell_noise:
            raise InputError(f"{target}: a data set has its noise; generate it with --cell-noise")
        sources = open_dataset(target)
        named = make_contenders(methods or default, contenders(), settings, knows_scale=knows_scale)
        return RunPlan(
            suite=dataset_name(target),
            sources=sources,
            contenders=named + others,
            seed=seed,
            about={"dataset": str(Path(target).resolve())},
        )
    suite = with_cell_noise(load_suite(target)) if cell_noise else load_suite(target)
    names = methods or ([] if others else [entry.label for entry in suite.methods]) or default
    named = make_contenders(names, [*contenders(), *suite.methods], settings, knows_scale=knows_scale)
    return RunPlan(
        suite=suite.name,
        sources=suite.sources(),
        contenders=named + others,
        seed=seed,
        about={
            "title": suite.title,
            "version": suite.version,
            "scenarios": [asdict(scenario) for scenario in suite.scenarios],
        },
        card={"title": suite.title, "description": suite.description},
    )

"""Pairs put to a method, each once, within a budget; answers of an earlier graph are taken over."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

from rectmerge.aligning import Scale, align
from rectmerge.alignment import Alignment, Method
from rectmerge.errors import InputError
from rectmerge.fleet.evidence import Evidence, Pair
from rectmerge.grid import OccupancyGrid
from rectmerge.judging import confirm

Progress = Callable[[int], None]  # takes the number of pairs asked so far


@dataclass(frozen=True, slots=True)
class PairAsker:
    """Question about a pair of maps, the same for all; it can be sent to another process.

    Parameters
    ----------
    method, scale, seed
        As for `rectmerge.align`.
    is_checked
        Whether the answer is put to the judge of `rectmerge.judging.confirm`.
    """

    method: Method
    scale: Scale
    seed: int
    is_checked: bool = False

    def __call__(self, pair: tuple[OccupancyGrid, OccupancyGrid, str]) -> Alignment:
        """Answer two maps, with the words that name them in an error."""
        a, b, names = pair
        try:
            alignment = align(a, b, method=self.method, scale=self.scale, seed=self.seed)
            if not self.is_checked:
                return alignment
            return confirm(a, b, alignment, method=self.method, scale=self.scale, seed=self.seed)
        except InputError as error:
            raise InputError(f"{names}: {error}") from error


class Questions:
    """Questions to a method about pairs of maps.

    Parameters
    ----------
    grids, names
        The maps in canonical order, and their names.
    order
        Place of each map among the given ones: of a pair, the map given first is A.
    evidence
        Evidence that the answers are added to.
    ask
        Answers a pair.
    budget
        Most pairs to ask; None for no limit.
    known
        Answers by the indices of (A, B), which cost nothing.
    executor
        Asks pairs in parallel; None asks them one by one.
    progress
        Called after each pair.
    keep
        Takes each answer that was asked, with the indices of (A, B).
    """

    def __init__(
        self,
        grids: Sequence[OccupancyGrid],
        names: Sequence[str],
        order: Sequence[int],
        evidence: Evidence,
        ask: PairAsker,
        *,
        budget: int | None,
        known: Mapping[tuple[int, int], Alignment],
        executor: Executor | None,
        progress: Progress | None,
        keep: Callable[[Pair, Alignment], None] = lambda pair, answer: None,
    ) -> None:
        self.answers: dict[tuple[int, int], Alignment] = {}  # by the indices of (A, B)
        self.asked = 0
        self._grids, self._names, self._order, self._evidence = grids, names, order, evidence
        self._ask, self._budget, self._known = ask, budget, known
        self._map = map if executor is None else executor.map
        self._progress, self._keep = progress, keep

    @property
    def is_spent(self) -> bool:
        """True if no more pairs may be asked."""
        return self._budget is not None and self.asked >= self._budget

    def ask(self, pairs: Sequence[Pair]) -> int:
        """Ask some pairs, those asked before left out; return how many answers are new."""
        new = [self._oriented(pair) for pair in dict.fromkeys(pairs) if not self._evidence.is_asked(pair)]
        left = None if self._budget is None else self._budget - self.asked
        unknown = dict.fromkeys([pair for pair in new if pair not in self._known][:left])
        questions = [(self._grids[a], self._grids[b], f"{self._names[a]} and {self._names[b]}") for a, b in unknown]
        answers = iter(self._map(self._ask, questions))
        count = 0
        for pair in new:
            if pair in self._known:
                self._add(pair, self._known[pair])
            elif pair in unknown:
                answer = next(answers)
                self.asked += 1
                self._keep(pair, answer)
                self._add(pair, answer)
                if self._progress is not None:
                    self._progress(self.asked)
            else:
                continue
            count += 1
        return count

    def _oriented(self, pair: Pair) -> tuple[int, int]:
        """Return (A, B) of a pair."""
        first, second = pair
        return pair if self._order[first] < self._order[second] else (second, first)

    def _add(self, pair: tuple[int, int], answer: Alignment) -> None:
        self.answers[pair] = answer
        self._evidence.add((min(pair), max(pair)), answer, is_swapped=pair[0] > pair[1])

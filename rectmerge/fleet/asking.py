"""Pairs put to a method, each once, within a budget; answers of an earlier graph are taken over."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rectmerge.alignment import Alignment
from rectmerge.errors import InputError
from rectmerge.fleet.evidence import Evidence, Pair
from rectmerge.grid import OccupancyGrid

AskPair = Callable[[OccupancyGrid, OccupancyGrid], Alignment]


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
        Answers a pair (A, B).
    budget
        Most pairs to ask; None for no limit.
    known
        Answers by the indices of (A, B), which cost nothing.
    """

    def __init__(
        self,
        grids: Sequence[OccupancyGrid],
        names: Sequence[str],
        order: Sequence[int],
        evidence: Evidence,
        ask: AskPair,
        budget: int | None,
        known: Mapping[tuple[int, int], Alignment],
    ) -> None:
        self.answers: dict[tuple[int, int], Alignment] = {}  # by the indices of (A, B)
        self.asked = 0
        self._grids, self._names, self._order, self._evidence = grids, names, order, evidence
        self._ask, self._budget, self._known = ask, budget, known

    @property
    def is_spent(self) -> bool:
        """True if no more pairs may be asked."""
        return self._budget is not None and self.asked >= self._budget

    def ask(self, pairs: Sequence[Pair]) -> int:
        """Ask some pairs, those asked before left out; return how many answers are new."""
        before = len(self.answers)
        for pair in pairs:
            if not self._evidence.is_asked(pair):
                is_swapped = self._order[pair[0]] > self._order[pair[1]]
                answer = self._answer(pair[::-1] if is_swapped else pair)
                if answer is not None:
                    self._evidence.add(pair, answer, is_swapped=is_swapped)
        return len(self.answers) - before

    def _answer(self, pair: Pair) -> Alignment | None:
        """Return the answer of a pair (A, B); None where the budget is spent."""
        answer = self._known.get(pair)
        if answer is None:
            if self.is_spent:
                return None
            self.asked += 1
            a, b = (self._grids[index] for index in pair)
            try:
                answer = self._ask(a, b)
            except InputError as error:
                raise InputError(f"{self._names[pair[0]]} and {self._names[pair[1]]}: {error}") from error
        self.answers[pair] = answer
        return answer

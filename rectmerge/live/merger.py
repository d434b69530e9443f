"""Merger of maps that grow: asks again when they have grown, and publishes a placement once answers agree."""

from __future__ import annotations

from collections.abc import Mapping

from rectmerge import methods
from rectmerge.aligning import Scale
from rectmerge.alignment import Method
from rectmerge.composing.compose import compose
from rectmerge.errors import RectMergeError
from rectmerge.fleet.asking import PairAsker
from rectmerge.fleet.graph import AlignmentGraph, Placement
from rectmerge.fleet.many import build_graph
from rectmerge.grid import OccupancyGrid
from rectmerge.live.memory import Memory
from rectmerge.live.params import LiveParams
from rectmerge.live.publication import Event, Publication, RobotStatus
from rectmerge.live.robot_map import RobotMap
from rectmerge.live.track import Track
from rectmerge.methods import DEFAULT_METHOD
from rectmerge.similarity import Similarity


class LiveMerger:
    """Merger of the growing maps of robots, whatever brings them.

    Parameters
    ----------
    reference
        Robot whose map frame is kept; empty takes the first that sends a map.
    method, scale, seed
        As for `rectmerge.align_many`, for every pair. The answer of a method that does not judge itself is put to the
        judge of `rectmerge.check`.
    params
        Rules by which placements are believed.
    memory
        Memory of an earlier run: its reference is kept if it sends a map before the first step and no other is given,
        and each of its placements counts as one answer.

    Examples
    --------
    >>> from rectmerge.grid import OccupancyGrid
    >>> merger = LiveMerger()
    >>> merger.update("robot1", OccupancyGrid([[0, 100], [0, 100]], 0.05))
    >>> merger.step().reference
    'robot1'
    """

    def __init__(
        self,
        *,
        reference: str = "",
        method: str | Method = DEFAULT_METHOD,
        scale: Scale = "auto",
        seed: int = 0,
        params: LiveParams = LiveParams(),  # noqa: B008 - frozen
        memory: Memory | None = None,
    ) -> None:
        chosen = methods.make_method(method) if isinstance(method, str) else method
        self.reference = reference
        self._ask = PairAsker(chosen, scale, seed, is_checked=True)
        self._params = params
        self._earlier = Memory("", {}) if memory is None else Memory(memory.reference, dict(memory.placements))
        self._maps: dict[str, RobotMap] = {}
        self._faults: dict[str, str] = {}  # of robots that have sent no usable map yet
        self._tracks: dict[str, Track] = {}
        self._graph: AlignmentGraph | None = None
        self._composed: tuple[object, OccupancyGrid] | None = None

    @property
    def robots(self) -> list[str]:
        """Robots that have sent a message."""
        return sorted({*self._maps, *self._faults})

    @property
    def memory(self) -> Memory:
        """Reference and published placements, for a later run; those of an earlier one too, unless contradicted."""
        earlier = self._earlier.placements if self._earlier.reference == self.reference else {}
        return Memory(self.reference, {**earlier, **self._published})

    @property
    def _published(self) -> dict[str, Similarity]:
        return {robot: track.published for robot, track in self._tracks.items() if track.published is not None}

    def update(self, robot: str, newest: OccupancyGrid | RectMergeError) -> None:
        """Take the newest map of a robot in place of an earlier one, or the reason why its message is no map."""
        if isinstance(newest, RectMergeError):
            if robot in self._maps:
                self._maps[robot].fault = str(newest)
            else:
                self._faults[robot] = str(newest)
            return
        self._faults.pop(robot, None)
        if robot in self._maps:
            self._maps[robot].newest, self._maps[robot].fault = newest, ""
        else:
            self._maps[robot] = RobotMap(newest)
            self._tracks[robot] = Track()

    def step(self) -> Publication:
        """Ask again where maps have grown, and return what is to be published now."""
        if self._maps and not self.reference:
            known = self._earlier.reference
            self.reference = known if known in self._maps else next(iter(self._maps))
        events = self._drop_restarted()
        changed = [robot for robot, each in self._maps.items() if each.consider(self._params)]
        if changed and len(self._maps) > 1:
            others = {robot: each for robot, each in self._maps.items() if robot != self.reference}
            first = {self.reference: self._maps[self.reference]} if self.reference in self._maps else {}
            considered = {robot: each.considered for robot, each in {**first, **others}.items()}
            named = {robot: grid for robot, grid in considered.items() if grid is not None}
            self._graph = build_graph(named, self._ask, earlier=self._graph)
            events += self._judge(self._graph)
        placements = self._published
        return Publication(
            reference=self.reference,
            grid=self._compose(placements),
            placements=placements,
            maps={robot: each.newest for robot, each in self._maps.items()},
            statuses={robot: self._status(robot) for robot in self.robots},
            events=events,
        )

    def _drop_restarted(self) -> list[Event]:
        """Forget what was known of robots whose maps have begun anew; with the reference everything is forgotten."""
        anew = [robot for robot, each in self._maps.items() if each.has_begun_anew(self._params)]
        lost = list(self._maps) if self.reference in anew else anew
        events = []
        for robot in lost:
            if self._tracks[robot].published is not None:
                whose = robot if robot in anew else self.reference
                reason = f"the map of {whose} has lost more than half of its free space: it has begun anew"
                events.append(Event(robot, self.reference, "taken out", reason))
            self._tracks[robot] = Track(questions=self._tracks[robot].questions)
            self._earlier.placements.pop(robot, None)
        for robot in anew:
            self._maps[robot].considered = None
        return events

    def _judge(self, graph: AlignmentGraph) -> list[Event]:
        """Take the graph as one answer about each robot."""
        events = []
        for robot in self._maps:
            if robot != self.reference and self.reference in self._maps:
                events += self._judge_robot(robot, _placement(graph, robot, self.reference), graph)
        return events

    def _judge_robot(self, robot: str, placement: Placement | None, graph: AlignmentGraph) -> list[Event]:
        track, question = self._tracks[robot], self._count_question(robot, graph)
        if placement is None:
            change = track.refuse({name: each.version for name, each in self._maps.items()}, self._params)
            if change is None:
                return []
            self._earlier.placements.pop(robot, None)
            return [Event(robot, self.reference, change, f"newer maps say no: {self._why_not(robot, graph)}")]
        rests_on = {name for pair in placement.rests_on for name in pair}
        versions = {name: self._maps[name].version for name in sorted(rests_on)}
        maps = self._maps[self.reference].newest, self._maps[robot].newest
        known = self._earlier.placements.get(robot) if self._earlier.reference == self.reference else None
        result = track.accept(
            placement.to_reference, versions, maps, self._params, known, placement.confidence, question
        )
        if result is None:
            return []
        change, moved = result
        reason = "one answer is enough"
        if self._params.accepts > 1:
            reason = f"{self._params.accepts} answers agree, on maps that changed between them"
        if change == "moved":
            reason = f"{reason}: {moved:.1f} cells from where it was"
        return [Event(robot, self.reference, change, reason, placement.confidence)]

    def _count_question(self, robot: str, graph: AlignmentGraph) -> int:
        """Return the number of questions about a robot: of its map, the reference's, and those joined with it."""
        joined = next((group for group in graph.components if robot in group), ())
        versions = {name: self._maps[name].version for name in sorted({robot, self.reference, *joined})}
        return self._tracks[robot].ask(versions, versions[robot] + versions[self.reference] - 1)

    def _why_not(self, robot: str, graph: AlignmentGraph) -> str:
        if robot in graph.left_out:
            return graph.left_out[robot]
        together = next((group for group in graph.components if robot in group), ())
        rest = ", ".join(name for name in together if name != robot)
        return f"it belongs to {rest}, and that group is not joined with {self.reference}"

    def _status(self, robot: str) -> RobotStatus:
        if robot not in self._maps:
            return RobotStatus("error", self._faults[robot])
        fault, track = self._maps[robot].fault, self._tracks[robot]
        if fault:
            return RobotStatus("error", f"{fault}; its last map is used")
        if robot == self.reference:
            return RobotStatus("ok", "the reference: its map frame is that of the merged map", "accepted", 1.0)
        if self.reference not in self._maps:
            return RobotStatus("warn", f"waits for a map of {self.reference}, the reference")
        if self._graph is None:
            return RobotStatus("warn", "was not compared yet")
        placement = _placement(self._graph, robot, self.reference)
        confidence = None if placement is None else placement.confidence
        if track.published is not None and track.pending is None and not track.refusals:
            return RobotStatus("ok", f"lies on the map of {self.reference}", "accepted", confidence)
        if track.published is not None:
            return RobotStatus(
                "warn", "the newest maps contradict its place: they are asked again", "pending", confidence
            )
        if placement is not None:
            return RobotStatus("warn", self._waiting(robot, placement.confidence), "pending", confidence)
        return RobotStatus("warn", self._why_not(robot, self._graph), "left out")

    def _waiting(self, robot: str, confidence: float) -> str:
        track, asked = self._tracks[robot], self._params.least_confidence
        if track.accepts >= self._params.accepts:
            asked = self._params.confidence_asked(track.questions)
        if confidence < asked:
            return f"fits with a confidence of {confidence:.4f}; {asked:.4f} is asked of maps that were asked often"
        count = f"{track.accepts} of {self._params.accepts} answers agree"
        return f"{count}; the next one is asked when a map has changed by {100 * self._params.growth:.0f} %"

    def _compose(self, placements: Mapping[str, Similarity]) -> OccupancyGrid | None:
        """Return the merged map, the last one where nothing has changed since."""
        if self.reference not in self._maps:
            return None
        reference = self._maps[self.reference].newest
        if not placements:
            return reference
        grids = [reference, *(self._maps[robot].newest for robot in placements)]
        key = [(grid, place) for grid, place in zip(grids, [None, *placements.values()], strict=True)]
        if self._composed is None or self._composed[0] != key:
            self._composed = key, compose(grids, [None, *placements.values()], rule="log-odds").grid
        return self._composed[1]


def _placement(graph: AlignmentGraph, robot: str, reference: str) -> Placement | None:
    """Return the placement of a robot in the reference's frame; None where they are not joined."""
    placement = graph.placements.get(robot)
    return placement if placement is not None and placement.reference == reference else None

"""Belief in the placement of one robot: it is published after enough answers that agree, and withdrawn likewise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.live.params import LiveParams
from rectmerge.similarity import Similarity

Change = Literal["joined", "moved", "taken out"]


@dataclass(slots=True, eq=False)
class Track:
    """Placement of one robot, published and pending.

    Parameters
    ----------
    published
        From the robot's map frame to the reference's; None while nothing is sure.
    pending
        Placement of the last answers that differ from what is published.
    accepts
        Number of answers in a row that agree on the pending placement.
    refusals
        Number of answers in a row that do not place the robot, though it is published.
    seen
        Versions of the maps on which the last answer rests.
    questions
        Number of different questions that were asked about the robot.
    asked
        Versions of the maps of which the last question was.
    """

    published: Similarity | None = None
    pending: Similarity | None = None
    accepts: int = 0
    refusals: int = 0
    seen: dict[str, int] = field(default_factory=dict)
    questions: int = 0
    asked: dict[str, int] = field(default_factory=dict)

    def ask(self, versions: Mapping[str, int], least: int) -> int:
        """Count a question about the robot, unless it is the last one again; return the number of all of them.

        Parameters
        ----------
        versions
            Versions of the maps that the answer may depend on.
        least
            Number of different pairs that the maps of the robot and of the reference have been, asked about or not.
        """
        if dict(versions) != self.asked:
            self.questions, self.asked = max(self.questions + 1, least), dict(versions)
        return self.questions

    def accept(
        self,
        placement: Similarity,
        versions: Mapping[str, int],
        maps: tuple[OccupancyGrid, OccupancyGrid],
        params: LiveParams,
        remembered: Similarity | None = None,
        confidence: float = 1.0,
        question: int = 1,
    ) -> tuple[Change, float] | None:
        """Take an answer that places the robot; return what changes, and by how many cells of the reference.

        Parameters
        ----------
        placement
            From the robot's map frame to the reference's.
        versions
            Versions of the maps on which the answer rests. The same versions again are no second answer.
        maps
            Maps of the reference and of the robot.
        params
            Rules.
        remembered
            Placement of an earlier run, which counts as one answer.
        confidence
            Of the answer, 0..1. One that is not sure enough to count can only confirm what is published.
        question
            Number of questions that were asked about the robot, this one included.
        """
        self.refusals = 0
        if self.published is not None and _moved(self.published, placement, maps) <= params.max_move_cells:
            self.published, self.pending, self.accepts = placement, None, 0
            return None
        if confidence < params.least_confidence:
            self.pending, self.accepts = None, 0
            return None
        if self.pending is None or _moved(self.pending, placement, maps) > params.max_move_cells:
            is_known = remembered is not None and _moved(remembered, placement, maps) <= params.max_move_cells
            self.accepts, self.seen = (1 if is_known else 0), {}
        if dict(versions) != self.seen:
            self.accepts, self.seen = self.accepts + 1, dict(versions)
        self.pending = placement
        if self.accepts < params.accepts or confidence < params.confidence_asked(question):
            return None
        change: Change = "joined" if self.published is None else "moved"
        moved = 0.0 if self.published is None else _moved(self.published, placement, maps)
        self.published, self.pending, self.accepts = placement, None, 0
        return change, moved

    def refuse(self, versions: Mapping[str, int], params: LiveParams) -> Change | None:
        """Take an answer that does not place the robot; return whether it is taken out."""
        self.pending, self.accepts = None, 0
        if self.published is None:
            return None
        if dict(versions) != self.seen:
            self.refusals, self.seen = self.refusals + 1, dict(versions)
        if self.refusals < params.accepts:
            return None
        self.published, self.refusals = None, 0
        return "taken out"


def _moved(before: Similarity, now: Similarity, maps: tuple[OccupancyGrid, OccupancyGrid]) -> float:
    """Return the distance between two placements over the robot's free space, cells of the reference."""
    reference, robot = maps
    return displacement_cells(
        robot, map_frame_to_pixels(before, reference, robot), map_frame_to_pixels(now, reference, robot)
    )

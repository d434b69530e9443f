"""Certificate that no placement away from the accepted one scores nearly as well, shown by branch and bound.

The search for a placement tries many and may miss one; branch and bound rules out the others.
"""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from typing import Any

from rectmerge._kernels.wall_cells import known_bounds
from rectmerge.analysis.trinary_map import MapCells, trinary
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.branch_and_bound import BranchAndBound
from rectmerge.robust.face_score import STEPS_PER_NAT, FaceScore
from rectmerge.robust.features import extract_features
from rectmerge.robust.params import Params
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreCertificate:
    """Certificate of the score of an accepted placement by branch and bound; it does not speak of the truth.

    The score is the sum, over about 240 evenly spaced faces of the walls of both maps, of the log-likelihood ratio of
    the distance to the other map's next wall that faces the same way, of four. It is taken on the working grids, in
    steps of 1/32 nat, and is 0 where the other map is not known. `spread_cells` is how far walls of one map may lie
    from the other's: of 1, 2 and 4 cells the one under which the accepted placement scores highest; 5 % of the walls
    may be missing.

    Parameters
    ----------
    certified
        That no placement elsewhere scores as much as ``(1 - margin) * score``. Elsewhere is where some landmark of B,
        of four at the radius of its walls, lies further than 5 % of A's extent (the diagonal of the bounding box of its
        known cells) from where the accepted placement puts it, the scale being within its bounds.
    margin
        A share of the score.
    score
        Of the accepted placement, nats.
    best_elsewhere
        No placement elsewhere scores more, nats, whether certified or not.
    counterexample
        Between the pixel centres: a placement elsewhere that scores within the margin. None where none was met.
    counterexample_score
        Its score, nats.
    spread_cells
        Standard deviation of the walls' distances, in working cells.
    faces
        Faces that were asked.
    seconds
        Wall time.
    boxes
        Boxes of placements that were bounded.
    """

    certified: bool
    margin: float
    score: float
    best_elsewhere: float
    counterexample: Similarity | None = None
    counterexample_score: float | None = None
    spread_cells: float
    faces: int
    seconds: float
    boxes: int

    def __bool__(self) -> bool:
        return self.certified

    def __str__(self) -> str:
        """Return a line for the terminal."""
        spent = f"{self.boxes:,} boxes in {self.seconds:.1f} s"
        if self.certified:
            return f"yes: nothing elsewhere scores {1 - self.margin:.0%} of this placement ({spent})"
        if self.counterexample is not None and self.counterexample_score is not None:
            share = self.counterexample_score / self.score
            return f"no: a placement elsewhere scores {share:.0%} of this one ({spent})"
        if self.score <= 0:
            return "no: the walls of this placement score no better than chance"
        return f"not in time: elsewhere at most {self.best_elsewhere / self.score:.0%} of this placement ({spent})"

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        other = self.counterexample
        return values | {"counterexample": None if other is None else other.matrix.tolist()}


def certify(
    a: OccupancyGrid,
    b: OccupancyGrid,
    pixels: Similarity,
    *,
    scale: tuple[float, float],
    seconds: float,
    params: Params,
) -> ScoreCertificate:
    """Show that nothing else comes close to a placement, or meet what does, or run out of time.

    Parameters
    ----------
    a, b
        The two maps.
    pixels
        The accepted placement, from pixel centres of B to those of A.
    scale
        Bounds of the pixel scale that was searched, cells of A per cell of B; 5 % beyond them is looked at too.
    seconds
        Wall time that the search may take once the maps are read. All else is determined by the maps.
    params
        Parameters of the method.

    Raises
    ------
    InputError
        If a map has no wall beside free space, the scale is no interval of positive numbers, or the time is not
        positive.
    """
    started = time.perf_counter()
    if not 0 < scale[0] <= scale[1] < math.inf:
        raise InputError(f"scale must satisfy 0 < lo <= hi, got {scale}")
    if not seconds > 0:
        raise InputError(f"seconds must be > 0, got {seconds}")
    speck = params.prepare.max_speck_cells
    cells = [MapCells.from_grid(grid, max_speck_cells=speck) for grid in (a, b)]
    features = [extract_features(each, params.prepare) for each in cells]
    if features[0] is None or features[1] is None:
        raise InputError(f"map {'A' if features[0] is None else 'B'} has no wall beside free space")
    limits = params.certificate
    score = FaceScore.from_placement(features[0], features[1], pixels, params)
    search = BranchAndBound(score, params.exact.widened(scale), _extent(a) / features[0].factor, limits)
    search.run(time.perf_counter() + seconds)
    met = search.met
    return ScoreCertificate(
        certified=search.accepted > 0 and search.highest < search.threshold,
        margin=limits.margin,
        score=search.accepted / STEPS_PER_NAT,
        best_elsewhere=search.highest / STEPS_PER_NAT,
        counterexample=None if met is None else score.to_pixels(met),
        counterexample_score=None if met is None else int(score.of_placements(met[None])[0]) / STEPS_PER_NAT,
        spread_cells=score.spread_cells,
        faces=score.faces.shape[1],
        seconds=time.perf_counter() - started,
        boxes=search.bounded,
    )


def _extent(grid: OccupancyGrid) -> float:
    """Measure the diagonal of the bounding box of a map's known cells, in cells."""
    top, bottom, left, right = known_bounds(trinary(grid))
    return math.hypot(bottom - top + 1, right - left + 1)

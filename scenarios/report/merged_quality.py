"""Merged maps compared with the building: the quality of accepted answers as maps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.exact_distance import exact_distance
from rectmerge.analysis.overlap import measure_agreement
from rectmerge.composing.resampling import resample
from rectmerge.elastic.unbend import unbend
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.io.map_file import read_map
from rectmerge.similarity import Similarity
from scenarios.dataset.reader import RowSource
from scenarios.scoring.row import Row

TRUTH = "the truth"  # label of maps merged by the true placement
Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class MergedQuality:
    """MergedQuality of a merged map.

    Parameters
    ----------
    occupied_f1
        Harmonic mean of the share of its occupied cells within one cell of the building's walls, and of the share of
        the building's visible walls within one cell of them.
    free_iou
        Free cells of both over those of either.
    wall_distance_m
        Mean distance of its occupied cells to the nearest wall of the building.
    omega
        Agreeing over all cells that both maps know.
    overlap
        As in `rectmerge.analysis.overlap.Agreement`.
    """

    occupied_f1: float
    free_iou: float
    wall_distance_m: float
    omega: float
    overlap: float


def qualities(rows: Mapping[str, Sequence[Row]], maps: Mapping[str, RowSource]) -> dict[str, list[MergedQuality]]:
    """Measure the accepted answers of each method on pairs of one place whose building is known.

    The first line, `TRUTH`, is of the same pairs merged by the true placement. Answers whose map B was bent have two
    lines of their own, "as placed" and "unbent".
    """
    by_method: dict[str, list[MergedQuality]] = {}
    scenes: dict[str, MergeScene | None] = {}
    for label, answers in rows.items():
        for row in answers:
            if row["verdict"] != "accepted" or row["stratum"] == "unrelated" or row["pair_id"] not in maps:
                continue
            if row["pair_id"] not in scenes:
                scenes[row["pair_id"]] = MergeScene.from_source(maps[row["pair_id"]])
            if (scene := scenes[row["pair_id"]]) and (candidates := row["candidates"]):
                pixels = Similarity.from_matrix(candidates[0])
                by_method.setdefault(label, []).append(scene.quality(pixels))
                if (bend := row.get("bend")) and bend["accepted"]:
                    by_method.setdefault(f"{label}, as placed", []).append(by_method[label][-1])
                    by_method.setdefault(f"{label}, unbent", []).append(scene.unbent_quality(pixels))
    truths = [scene.quality(scene.truth) for scene in scenes.values() if scene]
    return {TRUTH: truths, **by_method} if truths else {}


@dataclass(frozen=True, slots=True)
class MergeScene:
    """Pair with its building, the placement of A in it, and the true placement of B on A, between pixels."""

    a: OccupancyGrid
    b: OccupancyGrid
    world: OccupancyGrid
    a_to_world: Similarity
    truth: Similarity

    @classmethod
    def from_source(cls, source: RowSource) -> MergeScene | None:
        """Read a pair with its building; None where the data set does not hold the building."""
        row = source.row()
        info: Mapping[str, Any] = row.info
        if row.pixels is None or not info.get("world") or not info.get("resolution_a"):
            return None
        pair = row.pair()
        raster = read_map((source.folder / str(info["world"])).with_suffix(".yaml"))
        a = OccupancyGrid(pair.a.occupancy, float(info["resolution_a"]), tuple(info["origin_a"]))
        return cls(a, pair.b, raster, map_frame_to_pixels(Similarity(), raster, a), row.pixels)

    def quality(self, b_to_a: Similarity) -> MergedQuality:
        """Merge the maps on the building's raster and compare."""
        return self._compare(self.b, b_to_a)

    def unbent_quality(self, b_to_a: Similarity) -> MergedQuality:
        """Merge the maps with B bent as `rm.unbend` does, and compare."""
        bend = unbend(self.a, self.b, b_to_a)
        straight = bend.straighten(self.b)
        return self._compare(straight, map_frame_to_pixels(bend.b_to_a, self.a, straight))

    def _compare(self, placed: OccupancyGrid, b_to_a: Similarity) -> MergedQuality:
        """Compare A and a map placed on it with the building."""
        placements = [Similarity(), self.a_to_world, self.a_to_world @ b_to_a]
        layers, _ = resample([self.world, self.a, placed], placements)
        world, a, b = map(OccupancyGrid, layers)
        occupied, walls = a.occupied | b.occupied, world.occupied
        free = (a.free | b.free) & ~occupied
        visible = walls & _dilated(world.free)
        precision = _share(occupied, _dilated(walls))
        recall = _share(visible, _dilated(occupied))
        both = ~a.unknown & ~b.unknown
        distances = exact_distance(walls)
        return MergedQuality(
            occupied_f1=2 * precision * recall / max(1e-12, precision + recall),
            free_iou=float((free & world.free).sum() / max(1, (free | world.free).sum())),
            wall_distance_m=float(distances[occupied].mean()) * self.world.cell_size if occupied.any() else 0.0,
            omega=_share(both, a.free == b.free),
            overlap=measure_agreement(self.a, placed, b_to_a).overlap,
        )


def as_cells(by_method: Mapping[str, Sequence[MergedQuality]]) -> list[tuple[str, list[str]]]:
    """Return the cells of each line: the number of maps, and the mean of each measure."""
    return [
        (
            label,
            [str(len(measured)), *(f"{np.mean(values):.3f}" for values in zip(*map(astuple, measured), strict=True))],
        )
        for label, measured in by_method.items()
    ]


def _dilated(mask: Mask) -> Mask:
    """Return a mask with all neighbouring cells."""
    return np.asarray(cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8)), np.bool_)


def _share(of: Mask, within: Mask) -> float:
    return float((of & within).sum() / max(1, of.sum()))

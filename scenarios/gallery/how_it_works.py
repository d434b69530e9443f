"""Pictures of docs/how-it-works.md: the stages of the default method on simulated maps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.aligning import align
from rectmerge.alignment import Alignment, Candidate
from rectmerge.analysis.distance_codes import BINS, EDGES_CELLS, IN_UNKNOWN
from rectmerge.analysis.trinary_map import MapCells, trinary
from rectmerge.analysis.wall_faces import QUARTER, WallFaces
from rectmerge.drawing.maps import draw_map, side_by_side, with_legend
from rectmerge.errors import SimulationError
from rectmerge.io.atomic_file import replace_file
from rectmerge.robust.correlation import correlate
from rectmerge.robust.directions import dominant_angles
from rectmerge.robust.face_score import FaceScore
from rectmerge.robust.features import Features, extract_features, rectangles_in_frame
from rectmerge.robust.params import Params
from rectmerge.similarity import Similarity
from scenarios.execution.files import clear_folder
from scenarios.gallery.canvas import Canvas, Color, Picture
from scenarios.gallery.page_picture import small_png
from scenarios.pairs.pair import MapPair
from scenarios.suites.suite import load_suite, with_cell_noise

NAMES = ("maps.png", "features.png", "shifts.png", "rivals.png", "ward.png")
# colours that the colour-blind tell apart: M. Okabe and K. Ito, Color Universal Design, 2008
BLUE, SKY, ORANGE, VERMILION, PURPLE = (0, 114, 178), (86, 180, 233), (230, 159, 0), (213, 94, 0), (204, 121, 167)
SILENT = (150, 150, 150)
WAYS: Mapping[str, Color] = {"faces way 0": BLUE, "way 1": ORANGE, "way 2": SKY, "way 3": VERMILION}
ROOM, ROOM_EDGE, OTHER_ROOMS = (190, 232, 220), (0, 158, 115), (120, 120, 120)
SAME_ROOM_CELLS = 3.0  # rectangles whose centres and sides differ by no more are one room
MEETINGS: Mapping[str, Color] = {
    "wall matched": BLUE,
    "wall contradicted": VERMILION,
    "beside": PURPLE,
    "clutter matched": SKY,
    "clutter not there": ORANGE,
    "only one map knows": SILENT,
}
PARAMS = Params()  # of the default method
DRAWN_RECTANGLES = 8
PEAKS, RING_PX, WHITE = 5, 10, (255, 255, 255)
MIN_RIVAL_OVERLAP = 0.1  # of the free space: a rival that is drawn meets some walls


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """Pair, the method's answer, and the features of both maps."""

    pair: MapPair
    alignment: Alignment
    a: Features
    b: Features
    angle: float

    @classmethod
    def from_pair(cls, pair: MapPair) -> Explained:
        """Run the default method on a pair, and extract its features.

        Raises
        ------
        SimulationError
            If a map has no walls or no placement is found.
        """
        a, b = (extract_features(MapCells.from_values(trinary(grid)), PARAMS.prepare) for grid in (pair.a, pair.b))
        alignment = align(pair.a, pair.b, scale="free")
        if a is None or b is None or len(alignment.candidates) < 2:
            raise SimulationError(f"{pair.pair_id}: nothing to explain: {alignment.reason}")
        return cls(pair, alignment, a, b, dominant_angles(a, PARAMS.prepare)[0][0])

    @property
    def best(self) -> Candidate:
        """The best candidate."""
        return self.alignment.candidates[0]

    @property
    def rival(self) -> Candidate:
        """The best of the other candidates under which the maps meet; one of no overlap shows nothing."""
        _, *others = self.alignment.candidates
        return next((each for each in others if each.overlap >= MIN_RIVAL_OVERLAP), others[0])

    @property
    def sides(self) -> tuple[WallFaces, WallFaces]:
        """Wall faces of A and of B, numbered alike under the best candidate."""
        return self.a.faces(self.angle, PARAMS.faces), self.sides_of_b(self.best.pixels)

    def working(self, pixels: Similarity) -> Similarity:
        """Return the placement between working grids for one between the maps' pixels."""
        to_a, to_b = (Similarity(1 / each.factor, 0.0, *each.offset.tolist()) for each in (self.a, self.b))
        return to_a @ pixels @ to_b.inverse()

    def sides_of_b(self, pixels: Similarity) -> WallFaces:
        """Return the wall faces of B, sorted by the directions of A under a placement."""
        return self.b.faces(self.angle - pixels.angle, PARAMS.faces)


def explain(folder: str | Path, *, force: bool = False, say: Callable[[str], None]) -> list[Path]:
    """Draw all pictures from two simulated buildings, and return their files.

    Raises
    ------
    InputError
        If the folder holds earlier pictures and `force` is off.
    SimulationError
        If a mission fails.
    """
    out = clear_folder(folder, () if force else NAMES, force=force)
    say("two robots explore an office ...")
    office = Explained.from_pair(office_pair())
    say(f"{office.alignment.verdict}; two robots explore a ward of rooms that are all alike ...")
    ward = Explained.from_pair(ward_pair())
    say(f"{ward.alignment.verdict}; drawing ...")
    pictures = (draw_maps(office), draw_features(office), draw_shifts(office), draw_rivals(office), draw_ward(ward))
    for name, picture in zip(NAMES, pictures, strict=True):
        replace_file(out / name, small_png(picture))
    return [out / name for name in NAMES]


def office_pair() -> MapPair:
    """Make the maps of the demo's office, of which half the furniture was moved between the visits."""
    source = with_cell_noise(load_suite("demo")).missions()[0]
    world = replace(source.scenario.world, changed=0.5)
    mission = replace(source.scenario.mission, rays="compiled")
    return next(replace(source, scenario=replace(source.scenario, world=world, mission=mission)).pairs())


def ward_pair() -> MapPair:
    """Make the maps of the first ward of identical rooms of the suite `repetitive`."""
    source = with_cell_noise(load_suite("repetitive")).missions()[0]
    return next(replace(source, scenario=replace(source.scenario, noise=source.scenario.noise[1:])).pairs())


def draw_maps(shown: Explained) -> Picture:
    """Draw both maps."""
    grids = shown.pair.a, shown.pair.b
    captions = [f"map {name}: {grid.shape[1]} x {grid.shape[0]} cells" for name, grid in zip("AB", grids, strict=True)]
    return side_by_side([draw_map(grid) for grid in grids], captions)


def draw_features(shown: Explained) -> Picture:
    """Draw both working grids: wall faces by direction, the best rectangles, and one room of both."""
    sides = shown.sides
    maps = shown.a, shown.b
    frames = [
        rectangles_in_frame(features, each.angle, PARAMS.prepare) for features, each in zip(maps, sides, strict=True)
    ]
    room = _same_room(frames[0].boxes, frames[1].boxes, shown.working(shown.best.pixels))
    pictures = []
    for features, each, frame, same in zip(maps, sides, frames, room, strict=True):
        canvas = Canvas.from_features([(features, Similarity())])
        canvas.fill(_outline(frame.boxes[same], frame.angle), ROOM)
        for box in frame.boxes[:DRAWN_RECTANGLES]:
            canvas.outline(_outline(box, frame.angle), OTHER_ROOMS, 1)
        canvas.outline(_outline(frame.boxes[same], frame.angle), ROOM_EDGE, 3)
        for k, color in enumerate(WAYS.values()):
            canvas.dots(each.walls[each.faces[:, k]], color)
        pictures.append(canvas.image)
    captions = [f"working grid of {name}" for name in "AB"]
    legend = {**WAYS, "a room found in both": ROOM, f"the best {DRAWN_RECTANGLES} rectangles": OTHER_ROOMS}
    return with_legend(side_by_side(pictures, captions), legend)


def draw_shifts(shown: Explained) -> Picture:
    """Draw the scores of all shifts of B on A in four quarter turns, and the highest peaks of the correlation."""
    score = FaceScore.from_placement(shown.a, shown.b, shown.best.pixels, PARAMS)
    turn, size = float(score.given[0]), float(score.given[1])
    (height, width), beyond = shown.a.free.shape, math.ceil(shown.b.radius * math.exp(size))
    x, y = np.meshgrid(np.arange(-beyond, width + beyond), np.arange(-beyond, height + beyond))
    on_a, *on_b = shown.sides
    peaks, _ = correlate(on_a, on_b, [math.exp(size)], PARAMS.correlate, PARAMS.gain, max_shifts=PEAKS)
    pictures, captions = [], []
    for quarter in range(4):
        at = np.column_stack([np.full((x.size, 2), (turn + quarter * QUARTER, size)), x.ravel(), y.ravel()])
        share = score.of_placements(at).reshape(x.shape) / score.accepted
        image = _shaded(share)
        for a, b, tx, ty in peaks[quarter * PEAKS : (quarter + 1) * PEAKS]:
            spot = Similarity.from_matrix([[a, -b, tx], [b, a, ty]]).apply(score.centre) + beyond
            cv2.circle(image, np.rint(spot).astype(int).tolist(), RING_PX, WHITE, 1, cv2.LINE_AA)
        pictures.append(image)
        captions.append(f"B turned on by {90 * quarter} degrees: at most {max(0, share.max()):.0%}")
    return side_by_side(pictures, captions)


def draw_rivals(shown: Explained) -> Picture:
    """Draw the best placement and its strongest rival: matched and contradicted faces."""
    best, rival = shown.best, shown.rival
    captions = [f"best placement: confidence {best.confidence:.2f}", f"strongest rival: {rival.confidence:.2f}"]
    return with_legend(side_by_side([draw_meetings(shown, each.pixels) for each in (best, rival)], captions), MEETINGS)


def draw_ward(shown: Explained) -> Picture:
    """Draw the best placement and its rival on an ambiguous pair, and the truth."""
    best, rival = shown.alignment.candidates[:2]
    if shown.pair.pixels is None:
        raise SimulationError(f"{shown.pair.pair_id}: the maps have no truth to draw")
    captions = [f"best: confidence {best.confidence:.2f}", f"rival: {rival.confidence:.2f}", "the truth"]
    placements = (best.pixels, rival.pixels, shown.pair.pixels)
    return with_legend(side_by_side([draw_meetings(shown, each) for each in placements], captions, columns=3), MEETINGS)


def draw_meetings(shown: Explained, pixels: Similarity) -> Picture:
    """Draw the faces of both maps under a placement, in A's working grid, by their match in the other map."""
    working = shown.working(pixels)
    on_a, on_b = shown.a.faces(shown.angle, PARAMS.faces), shown.sides_of_b(pixels)
    canvas = Canvas.from_features([(shown.a, Similarity()), (shown.b, working)])
    points_by_kind = [
        (shown.a.walls, _meetings(on_a, on_b, working.inverse())),
        (working.apply(shown.b.walls), _meetings(on_b, on_a, working)),
    ]
    for kind, color in reversed(list(MEETINGS.items())):
        for points, kinds in points_by_kind:
            canvas.dots(points[kinds == kind], color)
    return canvas.image


def _meetings(mine: WallFaces, other: WallFaces, placement: Similarity) -> NDArray[np.str_]:
    """Return the key of `MEETINGS` of each wall point that a placement takes to the other map, shape (N,)."""
    u, v = np.rint(placement.apply(mine.walls)).astype(np.intp).T
    height, width = other.free.shape
    is_inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    codes = other.codes[:, v.clip(0, height - 1), u.clip(0, width - 1)].T.astype(np.intp)  # (N, 4)
    beyond = codes - IN_UNKNOWN
    is_near = (beyond >= 0) & (beyond < BINS) & (EDGES_CELLS[beyond.clip(0, BINS)] < PARAMS.rank.near_cells / 2)
    is_judged = mine.faces & is_inside[:, None] & ((codes < BINS) | is_near)
    away = np.where(is_judged, EDGES_CELLS[(codes % IN_UNKNOWN).clip(0, BINS)], np.inf).min(axis=1)
    is_long = (mine.is_long & mine.faces).any(axis=1)
    kinds = np.where(is_long, "wall matched", "clutter matched")
    kinds = np.where(away >= PARAMS.rank.matched_cells, "beside", kinds)
    kinds = np.where(
        away >= PARAMS.rank.contradicted_cells, np.where(is_long, "wall contradicted", "clutter not there"), kinds
    )
    return np.where(np.isinf(away), "only one map knows", kinds)


def _shaded(share: NDArray[np.float64]) -> Picture:
    """Shade scores as shares of the best placement's: dark blue for -0.5 and less, yellow for 1, in a few steps."""
    levels = np.rint(15 * (share.clip(-0.5, 1) + 0.5) / 1.5).astype(np.uint8) * 17
    return np.ascontiguousarray(np.asarray(cv2.applyColorMap(levels, cv2.COLORMAP_CIVIDIS), np.uint8)[..., ::-1])


def _same_room(boxes_a: NDArray[np.float64], boxes_b: NDArray[np.float64], placement: Similarity) -> tuple[int, int]:
    """Find the largest rectangles of A and B that a placement lays on each other."""
    centres, sizes = placement.apply(boxes_b[:, :2]), placement.scale * boxes_b[:, 2:]
    off = np.abs(boxes_a[:, None, :2] - centres[None]).max(axis=2)
    off = np.maximum(off, np.abs(boxes_a[:, None, 2:] - sizes[None]).max(axis=2))  # (A, B)
    worth = np.where(off < SAME_ROOM_CELLS, boxes_a[:, 2:].min(axis=1)[:, None], -off)
    i, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
    return int(i), int(j)


def _outline(box: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Return the corners of a rectangle of a frame, shape (4, 2)."""
    half = box[2:] / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners: NDArray[np.float64] = Similarity(1.0, angle, *box[:2].tolist()).apply(half)
    return corners

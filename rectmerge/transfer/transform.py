"""An answer put to use: as a transform that robots take."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from rectmerge.alignment import Verdict, right_resolutions
from rectmerge.analysis.overlap import cells_of
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import EXPECTED_WITHIN
from rectmerge.results.alignment_json import AnswerFile
from rectmerge.similarity import Similarity

Form = Literal["ros1", "ros2", "matrix", "pose"]
FORMS: tuple[Form, ...] = get_args(Form)
SAMPLED_CELLS = 20_000
FRAMES = ("map_a", "map_b")  # where the maps tell none


@dataclass(frozen=True, slots=True)
class SharedArea:
    """What both maps show, in B's map frame: its centre (x, y), the RMS distance of its cells from it, the unit."""

    centre: tuple[float, float]
    radius: float
    unit: str = "m"

    @classmethod
    def of(cls, a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> SharedArea:
        """Find it under a placement of B's pixels on A's; all of B's free space where they share none."""
        cells = cells_of(b.free, SAMPLED_CELLS)[:, ::-1]
        at = np.rint(pixels.apply(cells)).astype(np.intp)
        inside = ((at >= 0) & (at < a.shape[::-1])).all(axis=1)
        u, v = at.clip(0, np.array(a.shape[::-1]) - 1).T
        shared = cells[inside & a.free[v, u]]
        points = b.pixel_to_map(shared if len(shared) else cells)
        centre = points.mean(axis=0)
        radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1).mean()))
        return cls((float(centre[0]), float(centre[1])), radius, b.unit)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {"centre": list(self.centre), "radius": self.radius, "unit": self.unit}


@dataclass(frozen=True, slots=True)
class Placed:
    """A placement as ``alignment.json`` tells it.

    Parameters
    ----------
    b_to_a
        From B's map frame to A's.
    shared
        The area that both maps show.
    unit
        A's.
    resolutions
        A's and B's, metres per cell, where both are told.
    """

    b_to_a: Similarity
    shared: SharedArea
    unit: str
    resolutions: tuple[float, float] | None = None

    @property
    def rigid(self) -> Similarity:
        """The same without scale, for TF carries none: fitted anew to the area that both maps show."""
        centre = np.asarray(self.shared.centre)
        turn = Similarity(1.0, self.b_to_a.angle)
        tx, ty = self.b_to_a.apply(centre) - turn.apply(centre)
        return Similarity(1.0, self.b_to_a.angle, float(tx), float(ty))

    @property
    def misfit(self) -> float:
        """RMS distance in A's map frame between the placement and `rigid` over the area that both maps show."""
        return abs(self.b_to_a.scale - 1) * self.shared.radius

    @property
    def in_cells(self) -> str:
        """Which maps are in cells, for want of a resolution, and the remedy; empty where both are in metres."""
        names = [name for name, unit in (("A", self.unit), ("B", self.shared.unit)) if unit != "m"]
        if not names:
            return ""
        maps = f"maps {' and '.join(names)} are" if len(names) > 1 else f"map {names[0]} is"
        options = " and ".join(f"--resolution-{name.lower()} METRES" for name in names)
        return f"{maps} in cells, not in metres; merge again with {options}"

    @property
    def out_of_scale(self) -> str:
        """Why B's scale is none to be left out, and the remedy; empty where it is within 10 % of 1."""
        if 1 / EXPECTED_WITHIN <= self.b_to_a.scale <= EXPECTED_WITHIN:
            return ""
        fits = f"map B fits at a scale of {self.b_to_a.scale:.3g}"
        if self.in_cells:
            return f"{fits}: {self.in_cells}"
        which = "" if self.resolutions is None else f": {right_resolutions(*self.resolutions, self.b_to_a.scale)}"
        return f"{fits}, so one resolution is wrong{which}; merge again with the right --resolution-b or --resolution-a"

    def line(self, form: Form, *, parent: str = FRAMES[0], child: str = FRAMES[1]) -> str:
        """Tell the placement in a form that programs take: all but "matrix" without scale.

        The frames' names are quoted for the shell where they need it.

        Raises
        ------
        InputError
            If it is to be a line for TF, which is in metres, and a map is in cells; or it is to be without scale, but
            B's is more than 10 % off; or the frames' names are none that TF takes.
        """
        if form in ("ros1", "ros2") and self.in_cells:
            raise InputError(f"TF is in metres: {self.in_cells}")
        if form != "matrix" and self.out_of_scale:
            raise InputError(f"{self.out_of_scale} (--as matrix keeps the scale)")
        if form in ("ros1", "ros2"):
            _require_frames(parent, child)
            parent, child = shlex.quote(parent), shlex.quote(child)
        rigid = self.rigid
        yaw = math.remainder(rigid.angle, math.tau)
        if form == "ros1":
            numbers = f"{rigid.tx:.6f} {rigid.ty:.6f} 0 {yaw:.8f} 0 0"
            return f"rosrun tf2_ros static_transform_publisher {numbers} {parent} {child}"
        if form == "ros2":
            return (
                f"ros2 run tf2_ros static_transform_publisher --x {rigid.tx:.6f} --y {rigid.ty:.6f} --z 0 "
                f"--yaw {yaw:.8f} --pitch 0 --roll 0 --frame-id {parent} --child-frame-id {child}"
            )
        if form == "pose":
            return f"{rigid.tx:.6f} {rigid.ty:.6f} {yaw:.8f}"
        return "\n".join(
            " ".join(f"{number:.9g}" for number in row) for row in [*self.b_to_a.matrix.tolist(), [0, 0, 1]]
        )


@dataclass(frozen=True, slots=True)
class Answer:
    """What a merge's folder tells: verdict, reason, the candidates, best first, and the names of A's and B's frame."""

    verdict: Verdict
    reason: str
    candidates: tuple[Placed, ...]
    frames: tuple[str | None, str | None] = (None, None)

    @classmethod
    def of(cls, file: AnswerFile) -> Answer:
        """Take what an answer tells.

        Raises
        ------
        InputError
            If it lacks a candidate's numbers.
        """
        with file.refusing():
            resolutions = _resolutions(file)
            placed = (_placed(one, resolutions) for one in file.told["candidates"])
            a, b = (name if isinstance(name := file.told_of(one, "frame"), str) else None for one in "ab")
            return cls(file.verdict, file.reason, tuple(placed), (a, b))

    def named(self, parent: str | None, child: str | None) -> tuple[str, str]:
        """Return the frames' names: as given, else as the maps tell them where they differ, else `FRAMES`."""
        a, b = self.frames
        known = (a, b) if a and b and a != b else FRAMES
        return (known[0] if parent is None else parent), (known[1] if child is None else child)

    def candidate(self, number: int) -> Placed:
        """Return a candidate, 1 being the best; refuses a number that there is not."""
        if not 1 <= number <= len(self.candidates):
            raise InputError(f"there is no candidate {number}; the answer holds {len(self.candidates)}")
        return self.candidates[number - 1]


def _require_frames(parent: str, child: str) -> None:
    for option, name in (("--parent", parent), ("--child", child)):
        if not name.strip() or not name.isprintable():
            raise InputError(f"{option} must name a frame, got {name!r}")
    if parent == child:
        raise InputError(f"TF takes no frame to itself, but both are {parent!r}; name them with --parent and --child")


def _resolutions(file: AnswerFile) -> tuple[float, float] | None:
    a, b = (file.told_of(name, "metres_per_cell") for name in "ab")
    is_told = isinstance(a, int | float) and isinstance(b, int | float) and a > 0 and b > 0
    return (float(a), float(b)) if is_told else None


def _placed(told: Mapping[str, Any], resolutions: tuple[float, float] | None) -> Placed:
    placed, shared = told["b_to_a"], told["shared"]
    x, y = shared["centre"]
    b_to_a = Similarity(placed["scale"], placed["angle_rad"], *placed["translation"])
    area = SharedArea((x, y), shared["radius"], shared.get("unit", placed["unit"]))
    return Placed(b_to_a, area, placed["unit"], resolutions)

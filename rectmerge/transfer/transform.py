"""Transform of an alignment in the forms of robot software."""

from __future__ import annotations

import math
import shlex
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from rectmerge.aligning import DECLARED_WITHIN
from rectmerge.alignment import right_resolutions
from rectmerge.analysis.shared_area import SharedArea
from rectmerge.elastic.transform import BentTransform
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

Form = Literal["ros1", "ros2", "matrix", "pose"]
FORMS: tuple[Form, ...] = get_args(Form)
FRAMES = ("map_a", "map_b")  # names of the frames where the maps have none


@dataclass(frozen=True, slots=True)
class Transform:
    """Placement of map B on map A, to be passed to other programs.

    Parameters
    ----------
    b_to_a
        From B's map frame to A's.
    shared
        The area that both maps show.
    unit
        Unit of A's map frame, "m" or "cells".
    resolutions
        A's and B's, metres per cell; None unless both are known.
    """

    b_to_a: Similarity
    shared: SharedArea
    unit: str
    resolutions: tuple[float, float] | None = None

    def at(self, point: tuple[float, float], bend: BentTransform | None) -> Transform:
        """Return the transform that is right at one point of B's map frame; `bend` is that of B, if it was bent."""
        b_to_a = self.b_to_a if bend is None else bend.similarity_at(point)
        return replace(self, b_to_a=b_to_a, shared=SharedArea(point, 0.0, self.shared.unit))

    @property
    def rigid(self) -> Similarity:
        """Rigid transform, as TF carries no scale: fitted anew to the area that both maps show."""
        centre = np.asarray(self.shared.centre)
        turn = Similarity(1.0, self.b_to_a.angle)
        tx, ty = self.b_to_a.apply(centre) - turn.apply(centre)
        return Similarity(1.0, self.b_to_a.angle, float(tx), float(ty))

    @property
    def misfit(self) -> float:
        """RMS distance in A's map frame between `b_to_a` and `rigid` over the area that both maps show."""
        return abs(self.b_to_a.scale - 1) * self.shared.radius

    @property
    def unit_fault(self) -> str:
        """Maps that are in cells because they have no resolution, and the remedy; empty where both are in metres."""
        names = [name for name, unit in (("A", self.unit), ("B", self.shared.unit)) if unit != "m"]
        if not names:
            return ""
        maps = f"maps {' and '.join(names)} are" if len(names) > 1 else f"map {names[0]} is"
        options = " and ".join(f"--resolution-{name.lower()} METRES" for name in names)
        return f"{maps} in cells, not in metres; merge again with {options}"

    @property
    def scale_fault(self) -> str:
        """Reason why B's scale cannot be left out, and the remedy; empty where it is within 15 % of 1."""
        if 1 / DECLARED_WITHIN <= self.b_to_a.scale <= DECLARED_WITHIN:
            return ""
        scale = f"map B fits at a scale of {self.b_to_a.scale:.3g}"
        if self.unit_fault:
            return f"{scale}: {self.unit_fault}"
        right = "" if self.resolutions is None else f": {right_resolutions(*self.resolutions, self.b_to_a.scale)}"
        return (
            f"{scale}, so one resolution is wrong{right}; merge again with the right --resolution-b or --resolution-a"
        )

    def format(self, form: Form, *, parent: str = FRAMES[0], child: str = FRAMES[1]) -> str:
        """Write the transform in a form that programs take: all but "matrix" without scale.

        The names of the frames are quoted for the shell where they need it.

        Raises
        ------
        InputError
            If the form is a line for TF, which is in metres, and a map is in cells; or the form has no scale, but B's
            is more than 15 % off; or TF does not take the names of the frames.
        """
        if form in ("ros1", "ros2") and self.unit_fault:
            raise InputError(f"TF is in metres: {self.unit_fault}")
        if form != "matrix" and self.scale_fault:
            raise InputError(f"{self.scale_fault} (--as matrix keeps the scale)")
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


def _require_frames(parent: str, child: str) -> None:
    for option, name in (("--parent", parent), ("--child", child)):
        if not name.strip() or not name.isprintable():
            raise InputError(f"{option} must name a frame, got {name!r}")
    if parent == child:
        raise InputError(f"TF takes no frame to itself, but both are {parent!r}; name them with --parent and --child")

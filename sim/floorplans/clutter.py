"""Cluttered rooms: much furniture, most of it at odd angles."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.floorplans.drafting import Pen
from sim.floorplans.shapes import rectangle
from sim.floorplans.spec import WorldSpec, require_count, require_share
from sim.floorplans.splitting import Split, draw_split, split


@dataclass(frozen=True, kw_only=True)
class Clutter(WorldSpec):
    """Rooms full of furniture, most of it at odd angles.

    Parameters
    ----------
    rooms
        Number of rooms, 2 to 9.
    turned
        Share of the furniture that stands at any angle.
    """

    family: str = field(default="clutter", init=False)
    size_m: tuple[float, float] = (17.0, 12.0)
    furniture: float = 4.0
    rooms: int = 6
    turned: float = 0.8

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 2, 9)
        require_share("turned", self.turned)
        self.require_room(self.rooms * self.narrowest_m / 1.5, 2.2 * self.narrowest_m, f"{self.rooms} rooms")

    def draw(self, pen: Pen) -> None:
        """Split the floor into rooms, and let furniture stand close and at any angle."""
        outline = rectangle(*pen.box())
        pen.shell(outline)
        floor = Split([outline], [])
        split(floor, self.rooms, self.narrowest_m, pen.rng)
        draw_split(pen, floor, [f"room {k + 1}" for k in range(self.rooms)])
        pen.way_m, pen.turned = 0.12, self.turned

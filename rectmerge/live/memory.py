"""Memory of a live merger across its restarts: the reference, and the placements that were published."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NamedTuple

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.json_text import to_json
from rectmerge.similarity import Similarity

SCHEMA = "rectmerge.live/1"


class Memory(NamedTuple):
    """Reference and placements of one run.

    Parameters
    ----------
    reference
        Robot whose map frame is kept.
    placements
        From the map frame of each robot to the reference's.
    """

    reference: str
    placements: dict[str, Similarity]

    @classmethod
    def read(cls, path: Path) -> Memory | None:
        """Read a memory; None where there is no file.

        Raises
        ------
        InputError
            If the file is not a memory.
        """
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            if content["schema"] != SCHEMA:
                raise ValueError(content["schema"])
            placements = {robot: _similarity(numbers) for robot, numbers in content["placements"].items()}
            return cls(str(content["reference"]), placements)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise InputError(f"{path}: is no memory of rectmerge node ({error}): remove it, or name another") from None

    def write(self, path: Path) -> None:
        """Write the memory.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        numbers = {robot: [each.scale, each.angle, each.tx, each.ty] for robot, each in self.placements.items()}
        record = {"schema": SCHEMA, "reference": self.reference, "placements": numbers}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from None
        replace_file(path, (to_json(record) + "\n").encode())


def _similarity(numbers: list[float]) -> Similarity:
    scale, angle, tx, ty = map(float, numbers)
    if not (scale > 0 and all(map(math.isfinite, (scale, angle, tx, ty)))):
        raise ValueError(f"{numbers} is no placement")
    return Similarity(scale, angle, tx, ty)

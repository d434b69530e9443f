"""A small map as map_saver writes it, with some keys changed."""

from pathlib import Path

import numpy as np
import yaml
from PIL import Image

KEYS = {
    "image": "map.pgm",
    "resolution": 0.05,
    "origin": [-1.0, 2.0, 0.5],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}
GOOD_PGM = b"P5\n4 3\n255\n" + bytes([0, 254, 254, 205, 0, 254, 254, 205, 0, 0, 0, 205])
GOOD_CELLS = [[100, 0, 0, -1], [100, 0, 0, -1], [100, 100, 100, -1]]


def write(folder: Path, *, image: bytes | None = GOOD_PGM, name: str = "map.pgm", **changes: object) -> Path:
    """Write a map as map_saver would, with some keys changed (None: left out)."""
    if image is not None:
        (folder / name).write_bytes(image)
    keys = {key: value for key, value in (KEYS | {"image": name} | changes).items() if value is not None}
    path = folder / "map.yaml"
    path.write_text(yaml.safe_dump(keys))
    return path


def save(folder: Path, array: np.ndarray, name: str = "map.png") -> Path:
    Image.fromarray(array).save(folder / name)
    return folder / name

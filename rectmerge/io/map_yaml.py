"""Content of a map_server YAML, read and checked."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import yaml

from rectmerge.errors import InputError, MapFileError
from rectmerge.io.dialects import Legend
from rectmerge.io.image_file import BROKEN, require_file

MAX_YAML_BYTES = 65_536
LONGEST_SHOWN = 1000  # bits of a number in a message
UNNAMEABLE = re.compile("[\0\ud800-\udfff]")  # characters that no file name can have
TABS = re.compile(rb"([^\s])[ \t]*\t[ \t]*")  # after something else on the line
LONGEST_NAME = 4096  # bytes of a path, the limit of operating systems


@dataclass(frozen=True, slots=True, kw_only=True)
class MapHeader:
    """Checked content of a map_server YAML.

    Parameters
    ----------
    image
        The image; where the YAML names one by an absolute path that is not there, the file of that name beside it.
    named_image
        The image as the YAML names it.
    resolution, origin
        As in `rectmerge.grid.OccupancyGrid`.
    legend
        The meaning of the pixels.
    """

    image: Path
    named_image: str
    resolution: float | None
    origin: tuple[float, float, float]
    legend: Legend


def read_header(source: str | os.PathLike[str]) -> MapHeader:
    """Read a map_server YAML.

    Raises
    ------
    MapFileError
        If it is not valid; the message names the file, the key and the allowed values.
    """
    path = Path(source)
    keys = _keys(path)
    image = keys.get("image")
    if not isinstance(image, str) or not image or len(image) > LONGEST_NAME or UNNAMEABLE.search(image):
        raise MapFileError(f"{path}: image must name the map's image file, got {_short(image)}")
    mode = keys.get("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        raise MapFileError(f"{path}: mode must be trinary, scale or raw, got {_short(mode)}")
    negate = keys.get("negate", 0)
    if negate not in (0, 1, "0", "1"):
        raise MapFileError(f"{path}: negate must be 0 or 1, got {_short(negate)}")
    occupied_thresh, free_thresh = (_number(path, keys, key) for key in ("occupied_thresh", "free_thresh"))
    try:
        legend = Legend(
            negate=bool(int(negate)),
            occupied_thresh=occupied_thresh,
            free_thresh=free_thresh,
            mode=mode,
        )
    except InputError as error:
        raise MapFileError(f"{path}: {error}") from None
    return MapHeader(
        image=_image(path, image),
        named_image=image,
        resolution=_resolution(path, keys),
        origin=_origin(path, keys),
        legend=legend,
    )


def _keys(path: Path) -> dict[Any, Any]:
    require_file(path)
    if path.stat().st_size > MAX_YAML_BYTES:
        raise MapFileError(f"{path}: more than {MAX_YAML_BYTES // 1024} KB, so not a map_server YAML")
    text = b""
    try:
        text = path.read_bytes()
        keys = _load(text)
    except OSError as error:
        raise MapFileError(f"{path}: {error.strerror or error}; make the file readable") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        remedy = "; use spaces, no tabs" if b"\t" in text else ""
        raise MapFileError(f"{path}: not valid YAML: {' '.join(str(error).split())[:200]}{remedy}") from None
    except MapFileError as error:
        raise MapFileError(f"{path}: {error}") from None
    except BROKEN:  # a tag such as !!bool or !!timestamp on another value: PyYAML's own, often nameless errors
        raise MapFileError(f"{path}: not valid YAML: a value does not have the type of its tag") from None
    if keys is None:
        raise MapFileError(f"{path}: the file is empty; a map_server YAML names image, resolution, origin, ...")
    if not isinstance(keys, dict):
        raise MapFileError(f"{path}: not a map_server YAML: it must map image, resolution, origin, ... to values")
    return keys


def _image(path: Path, named: str) -> Path:
    """Return the image of a YAML: as named, or beside it by the name that it has on another machine."""
    image = path.parent / named
    beside = path.with_name(PureWindowsPath(named).name or path.name)  # either kind of slash
    is_foreign = PurePosixPath(named).is_absolute() or PureWindowsPath(named).is_absolute()
    if is_foreign and beside != path and not os.path.lexists(image) and os.path.isfile(beside):  # noqa: PTH113 - no error, any name
        return beside
    return image


def _load(text: bytes) -> Any:
    """Load YAML with tabs as yaml-cpp takes them, which map servers use: as spaces, except at the start of a line."""
    try:
        return yaml.load(text, _Loader)
    except yaml.YAMLError:
        spaced = TABS.sub(rb"\1 ", text)
        if spaced == text:
            raise
        return yaml.load(spaced, _Loader)


class _Loader(yaml.SafeLoader):
    """Loader that refuses a key given twice, of which programs take different ones."""

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        """Construct a mapping from a node, whose keys must differ."""
        seen = set()
        for key, _ in node.value:
            if key.tag != "tag:yaml.org,2002:merge" and isinstance(key.value, str):
                if key.value in seen:
                    raise MapFileError(f"the key {_short(key.value)} is given twice; keep one")
                seen.add(key.value)
        mapping: dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


def _resolution(path: Path, keys: Mapping[str, Any]) -> float | None:
    if "resolution" in keys and keys["resolution"] is None:
        return None
    resolution = _number(path, keys, "resolution")
    if resolution <= 0:
        raise MapFileError(f"{path}: resolution must be > 0 metres per cell (null if not known), got {resolution:g}")
    return resolution


def _origin(path: Path, keys: Mapping[str, Any]) -> tuple[float, float, float]:
    origin = keys.get("origin")
    if not isinstance(origin, list) or len(origin) != 3:
        got = f"a list of {len(origin)}" if isinstance(origin, list) else _short(origin)
        raise MapFileError(f"{path}: origin must be [x, y, yaw], three numbers, got {got}")
    named = {f"origin[{i}]": value for i, value in enumerate(origin)}
    x, y, yaw = (_number(path, named, key) for key in named)
    return x, y, yaw


def _number(path: Path, keys: Mapping[str, Any], key: str) -> float:
    """Read a finite number, also from text such as 5e-2, which YAML 1.1 does not read as a number."""
    if key not in keys:
        raise MapFileError(f"{path}: the key {key} is missing; map_server needs it")
    value = keys[key]
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise MapFileError(f"{path}: {key} must be a finite number, got {_short(value)}")
    return number


def _short(value: object) -> str:
    if isinstance(value, int) and value.bit_length() > LONGEST_SHOWN:  # Python writes no int of thousands of digits
        return f"a whole number of {value.bit_length()} bits"
    text = "nothing" if value is None else repr(value) if isinstance(value, str | int | float) else type(value).__name__
    return text if len(text) <= 60 else text[:57] + "..."

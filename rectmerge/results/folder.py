"""Folder of a merge: results never overwrite other results or inputs, and are never half written."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.elastic.bend import Bend
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.atomic_file import finish_interrupted, replace_files, resolve_links
from rectmerge.io.dialects import Legend
from rectmerge.io.image_file import encode_image
from rectmerge.io.json_text import to_json
from rectmerge.io.map_file import MAP_SAVER_LEGEND, encode_map

BEND_NAME = "unbend.json"
RESULT_NAMES = re.compile(
    r"(alignment|fleet|follow|unbend)\.json|view\.html|transforms\.yaml|graph\.png|(overlay|conflict)(_\d+)?\.png|"
    r"merged(_\d+)?\.(yaml|pgm)"
)
LOGGER = logging.getLogger("rectmerge")
RAW = Legend(mode="raw")  # nav2 and ROS 1 read it alike and exactly; mode scale they grade differently


@dataclass(frozen=True, slots=True)
class ResultFolder:
    """Folder for the results of one merge.

    Parameters
    ----------
    path
        The folder; it may not exist yet, or hold other files, which stay as they are.
    """

    path: Path

    def check(self, inputs: Iterable[Path], *, force: bool) -> None:
        """Refuse a folder that cannot take results.

        Raises
        ------
        InputError
            If it is not a folder or not writable, would overwrite an input, holds a folder by the name of a result, or
            holds results and `force` is False.
        """
        try:
            is_writable = self._is_writable()
        except OSError:  # a name too long, a folder above that may not be looked into
            is_writable = False
        if not is_writable:
            raise InputError(f"{self.path}: cannot be written; name another folder with -o")
        note_interrupted(self.path)
        for file in inputs:
            if self.owns(file):
                raise InputError(
                    f"{file}: is an input, and results in {self.path} would replace it; name another folder"
                )
        if folders := [p for p in self._entries() if _is_folder(p)]:
            raise InputError(f"{folders[0]}: is a folder where a result would go; name another folder with -o")
        if (results := self._files()) and not force:
            names = ", ".join(sorted(p.name for p in results))
            raise InputError(f"{self.path}: holds results ({names}); name another folder, or --force replaces them")

    def owns(self, file: Path) -> bool:
        """Return whether a result has the name of this file, or of the target of this link."""
        paths, folder = (file.absolute(), resolve_links(file)), resolve_links(self.path)
        return any(resolve_links(path.parent) == folder and RESULT_NAMES.fullmatch(path.name) for path in paths)

    def write(
        self,
        alignment: dict[str, Any],
        pictures: dict[str, NDArray[np.uint8]],
        merged: OccupancyGrid | None,
        *,
        shaded: bool = False,
        bend: Bend | None = None,
    ) -> list[Path]:
        """Replace earlier results by new ones, ``alignment.json`` last; return the files.

        Parameters
        ----------
        alignment, pictures, merged
            The content of ``alignment.json``, the pictures by file name, and the merged map, if there is one.
        shaded
            Whether the map's occupancies are kept as they are, in mode raw; else it is written as map_saver does.
        bend
            The bend of map B, for its file.

        Raises
        ------
        InputError
            If a file cannot be written; earlier results are then still there.
        """
        files = {name: encode_image(picture, ".png") for name, picture in pictures.items()}
        if merged is not None:
            files |= merged_files(merged, "merged", shaded=shaded)
        if bend is not None and bend.transform is not None:
            files[BEND_NAME] = (to_json(bend.transform.as_dict()) + "\n").encode()
        files["alignment.json"] = (to_json(alignment) + "\n").encode()
        return self.replace(files)

    def replace(self, files: Mapping[str, bytes]) -> list[Path]:
        """Replace earlier results by files with these names and contents, the last one last; return them.

        Raises
        ------
        InputError
            If a file cannot be written; earlier results are then still there.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            earlier = self._files()
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror or error}") from None
        replace_files({self.path / name: data for name, data in files.items()}, stale=earlier)
        return [self.path / name for name in files]

    def _is_writable(self) -> bool:
        """Return whether the folder takes files or can be made; refuse a path that is not a folder."""
        if not self.path.is_dir() and os.path.lexists(self.path):
            raise InputError(f"{self.path}: is not a folder; name another with -o")
        existing = next(p for p in (self.path.absolute(), *self.path.absolute().parents) if p.exists())
        return existing.is_dir() and os.access(existing, os.R_OK | os.W_OK | os.X_OK)

    def _files(self) -> list[Path]:
        return [p for p in self._entries() if not _is_folder(p)]

    def _entries(self) -> list[Path]:
        """Return the files and folders with the name of a result."""
        return [p for p in self.path.iterdir() if RESULT_NAMES.fullmatch(p.name)] if self.path.is_dir() else []


def merged_files(merged: OccupancyGrid, stem: str, *, shaded: bool) -> dict[str, bytes]:
    """Return the image and the YAML of a merged map by name, in mode raw if shaded."""
    image, header = encode_map(merged, f"{stem}.pgm", RAW if shaded else MAP_SAVER_LEGEND)
    return {f"{stem}.pgm": image, f"{stem}.yaml": header}


def note_interrupted(folder: Path) -> None:
    """Finish or undo what a killed command left half done in a folder of results, and say so."""
    if done := finish_interrupted(folder):
        LOGGER.warning("%s: %s", folder, done)


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()  # a link to a folder is replaced like a file

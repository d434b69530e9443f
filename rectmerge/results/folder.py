"""The folder that a merge writes: never over other results, never over its inputs, never half."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.atomic_file import replace_files, resolve_links
from rectmerge.io.dialects import Legend
from rectmerge.io.image_file import encode_image
from rectmerge.io.json_text import to_json
from rectmerge.io.map_file import MAP_SAVER_LEGEND, encode_map

OWN = re.compile(r"alignment\.json|view\.html|overlay(_\d+)?\.png|conflict\.png|merged\.(yaml|pgm)")
RAW = Legend(mode="raw")  # nav2 and ROS 1 read it alike and exactly; mode scale they grade differently


@dataclass(frozen=True, slots=True)
class ResultFolder:
    """A folder for the results of one merge.

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
        for file in inputs:
            if self.owns(file):
                raise InputError(
                    f"{file}: is an input, and results in {self.path} would replace it; name another folder"
                )
        if folders := [p for p in self._own() if _is_folder(p)]:
            raise InputError(f"{folders[0]}: is a folder where a result would go; name another folder with -o")
        if (held := self._own_files()) and not force:
            names = ", ".join(sorted(p.name for p in held))
            raise InputError(f"{self.path}: holds results ({names}); name another folder, or --force replaces them")

    def owns(self, file: Path) -> bool:
        """Whether results go by this name, or by that of what it leads to."""
        named = {file.absolute(), resolve_links(file)}
        return any(resolve_links(p.parent) == resolve_links(self.path) and OWN.fullmatch(p.name) for p in named)

    def write(
        self,
        alignment: dict[str, Any],
        pictures: dict[str, NDArray[np.uint8]],
        merged: OccupancyGrid | None,
        *,
        shaded: bool = False,
    ) -> list[Path]:
        """Replace earlier results by new ones, ``alignment.json`` last; return the files.

        Parameters
        ----------
        alignment, pictures, merged
            What goes into ``alignment.json``, the pictures by their files' names, and the merged map, if there is one.
        shaded
            Whether the map's occupancies are kept as they are, in mode raw; else it is written as map_saver does.

        Raises
        ------
        InputError
            If a file cannot be written; earlier results are then still there.
        """
        files = {name: encode_image(picture, ".png") for name, picture in pictures.items()}
        if merged is not None:
            legend = RAW if shaded else MAP_SAVER_LEGEND
            files["merged.pgm"], files["merged.yaml"] = encode_map(merged, "merged.pgm", legend)
        files["alignment.json"] = (to_json(alignment) + "\n").encode()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            earlier = self._own_files()
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror or error}") from None
        replace_files({self.path / name: data for name, data in files.items()}, stale=earlier)
        return [self.path / name for name in files]

    def _is_writable(self) -> bool:
        """Whether it is a folder that takes files, or can be made; refuses what is there and no folder."""
        if not self.path.is_dir() and os.path.lexists(self.path):
            raise InputError(f"{self.path}: is not a folder; name another with -o")
        existing = next(p for p in (self.path.absolute(), *self.path.absolute().parents) if p.exists())
        return existing.is_dir() and os.access(existing, os.R_OK | os.W_OK | os.X_OK)

    def _own_files(self) -> list[Path]:
        return [p for p in self._own() if not _is_folder(p)]

    def _own(self) -> list[Path]:
        """Return what bears the name of a result."""
        return [p for p in self.path.iterdir() if OWN.fullmatch(p.name)] if self.path.is_dir() else []


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()  # a link to one is only a name, and is replaced

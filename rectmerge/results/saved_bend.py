"""File ``unbend.json``: bends of an earlier merge, read to be used as transforms."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from rectmerge.elastic.transform import BentTransform
from rectmerge.results.alignment_json import AlignmentFile, explain_errors
from rectmerge.results.folder import BEND_NAME

ROUNDED = 1e-6  # map units, radians: two ways to the same placement differ by less


def read_bend(file: AlignmentFile) -> BentTransform | None:
    """Read the bend of a merge; None where it was not bent.

    Raises
    ------
    InputError
        If the merge was bent, but the file beside its record is missing, or not the bend of this merge.
    """
    unbent = file.record.get("unbent")
    if not (isinstance(unbent, Mapping) and unbent.get("accepted") is True):
        return None
    with explain_errors(file.folder / BEND_NAME):
        return bend_of(json.loads((file.folder / BEND_NAME).read_text(encoding="utf-8")), file.record["b_to_a"])


def bend_of(content: Mapping[str, Any], placed: Mapping[str, Any]) -> BentTransform:
    """Take a bend from the content of ``unbend.json``.

    Parameters
    ----------
    content
        The bend.
    placed
        The similarity that the merge recorded, which the bend's own must be.

    Raises
    ------
    ValueError
        If the bend is of another merge; other errors of unusable content as `explain_errors` takes them.
    """
    bend = BentTransform.from_dict(content)
    own = bend.b_to_a
    recorded = [placed["scale"], placed["angle_rad"], *placed["translation"]]
    if not np.allclose([own.scale, own.angle, own.tx, own.ty], recorded, rtol=0, atol=ROUNDED):
        raise ValueError("it is of another merge")
    return bend

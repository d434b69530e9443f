"""File ``unbend.json``: the bend of an earlier merge, read to be used as a transform."""

from __future__ import annotations

import json
from collections.abc import Mapping

from rectmerge.elastic.transform import BentTransform
from rectmerge.results.alignment_json import AlignmentFile, explain_errors
from rectmerge.results.folder import BEND_NAME


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
        bend = BentTransform.from_dict(json.loads((file.folder / BEND_NAME).read_text(encoding="utf-8")))
        placed = file.record["b_to_a"]
        if (bend.b_to_a.scale, bend.b_to_a.angle) != (placed["scale"], placed["angle_rad"]):
            raise ValueError("it is of another merge")
        return bend

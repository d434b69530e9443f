"""JSON text that every program reads: finite numbers only, lists of numbers on one line."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

INNERMOST_LIST = re.compile(r"\[\n[-+.\w\s,]*\n\s*\]")  # of numbers, to be joined into one line


def to_json(data: object) -> str:
    """Return data as JSON that every program reads: a number that is not finite becomes null."""
    text = json.dumps(plain(data), indent=2, allow_nan=False)
    return INNERMOST_LIST.sub(lambda match: " ".join(match[0].split()).replace("[ ", "[").replace(" ]", "]"), text)


def plain(value: Any) -> Any:
    """Turn the data of methods and pairs into plain data for JSON; a number that is not finite becomes None."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(inner) for inner in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, str | int) else str(value)

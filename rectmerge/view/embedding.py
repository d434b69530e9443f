"""What a page that asks the network for nothing holds within itself: its texts, and its data for its scripts."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from rectmerge.io.json_text import plain


def text_of(name: str, package: str = "rectmerge.view") -> str:
    """Return a style, script or template that lies in a package."""
    return (files(package) / name).read_text(encoding="utf-8")


def as_script(content: Any) -> str:
    """Write plain data so that a script element can hold it: no markup in it, and no number that JSON has not.

    Examples
    --------
    >>> as_script({"reason": "<b>", "e": float("nan")})
    '{"reason":"\\\\u003cb\\\\u003e","e":null}'
    """
    text = json.dumps(plain(content), separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")

"""Embedding of texts and data in a page that needs no network."""

from __future__ import annotations

import base64
import gzip
import json
from importlib.resources import files
from typing import Any

from rectmerge.io.json_text import plain


def package_text(name: str, package: str = "rectmerge.view") -> str:
    """Return a style, script or template file of a package."""
    return (files(package) / name).read_text(encoding="utf-8")


def as_script(content: Any) -> str:
    """Return plain data as JSON for a script element: without markup, and null for numbers that JSON does not have.

    Examples
    --------
    >>> as_script({"reason": "<b>", "e": float("nan")})
    '{"reason":"\\\\u003cb\\\\u003e","e":null}'
    """
    return _json(content).replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def as_gzip(content: Any) -> str:
    """Return plain data as the base64 of its compressed JSON, which a browser opens by ``DecompressionStream``.

    Examples
    --------
    >>> gzip.decompress(base64.b64decode(as_gzip({"reason": "<b>"}))).decode()
    '{"reason":"<b>"}'
    """
    return base64.b64encode(gzip.compress(_json(content).encode(), mtime=0)).decode()


def _json(content: Any) -> str:
    return json.dumps(plain(content), separators=(",", ":"), allow_nan=False)

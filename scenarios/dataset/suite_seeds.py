"""Seeds of a suite, wherever it names them: shifted, mixed with a secret, and counted."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from rectmerge.errors import InputError
from scenarios.suites.spec import SecretSeeds, Seeds

FEWEST_DIGITS, MOST_BYTES = 32, 1000  # of a secret: 128 bits; of its file
NAME_DIGITS = 8  # of the hash, in names
Made = TypeVar("Made")


@dataclass(frozen=True, slots=True)
class Secret:
    """Secret that is mixed into every seed of a suite, as hexadecimal digits."""

    digits: str = field(repr=False)

    @classmethod
    def from_file(cls, path: Path) -> Secret:
        """Read a secret: at least 32 hexadecimal digits, as ``openssl rand -hex 16`` prints them.

        Raises
        ------
        InputError
            If the file cannot be read, or holds something else, or too little.
        """
        try:
            with path.open("rb") as file:
                text = file.read(MOST_BYTES).decode("ascii", errors="replace").strip().lower()
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
        remedy = f"make one with: openssl rand -hex 16 > {path.name}"
        if not re.fullmatch("(?:[0-9a-f]{2})+", text):
            raise InputError(f"{path}: a secret is an even number of hexadecimal digits and nothing else; {remedy}")
        if len(text) < FEWEST_DIGITS:
            raise InputError(f"{path}: a secret needs {FEWEST_DIGITS} hexadecimal digits, got {len(text)}; {remedy}")
        return cls(text)

    @property
    def sha256(self) -> str:
        """SHA-256 of its bytes, hexadecimal: what is published before the secret is."""
        return hashlib.sha256(bytes.fromhex(self.digits)).hexdigest()


def shifted(suite: Made, by: int) -> Made:
    """Add to every seed that a suite names."""
    moved: Made = _changed(suite, lambda seeds: replace(seeds, first=seeds.first + by))
    return moved


def mixed(suite: Any, secret: Secret) -> Any:
    """Mix a secret into every seed that a suite names, and add the first digits of its hash to the suite's name.

    So rows of hidden pairs, whose ids are those of the open ones, are of another suite.
    """
    made = _changed(suite, lambda seeds: SecretSeeds(first=seeds.first, count=seeds.count, secret=secret.digits))
    return replace(made, name=f"{suite.name}-{secret.sha256[:NAME_DIGITS]}")


def seeds_end(value: Any) -> int:
    """Return the first seed beyond those that a suite names."""
    if isinstance(value, Seeds):
        return value.first + value.count
    inner = value if isinstance(value, tuple) else _parts(value).values()
    return max(map(seeds_end, inner), default=0)


def _changed(value: Any, change: Callable[[Seeds], Seeds]) -> Any:
    """Change all seeds in a suite or a part of one; a part without any stays the same object."""
    if isinstance(value, Seeds):
        return change(value)
    if isinstance(value, tuple):
        return tuple(_changed(item, change) for item in value)
    parts = {name: new for name, part in _parts(value).items() if (new := _changed(part, change)) is not part}
    return replace(value, **parts) if parts else value


def _parts(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass; nothing else has any."""
    if not is_dataclass(value):
        return {}
    return {f.name: getattr(value, f.name) for f in fields(value)}

"""Parser of the scan lines of a CARMEN log."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError

FLASER, ROBOTLASER = b"FLASER", b"ROBOTLASER1"
ROUNDED = 0.01  # radians
CONFIG, POSES, VELOCITIES, TAIL = 7, 6, 5, 3  # words of ROBOTLASER1; the tail is timestamp, host, logger's timestamp


@dataclass(frozen=True, slots=True)
class Laser:
    """Configuration of a laser, the same in all its scans; FLASER has the number of readings only.

    Parameters
    ----------
    kind
        First word of its lines.
    readings
        Number of readings of a scan.
    start, step
        Direction of the first beam and from each to the next, radians.
    maximum_m
        The largest reading.
    """

    kind: bytes
    readings: int
    start: float | None = None
    step: float | None = None
    maximum_m: float | None = None

    def __str__(self) -> str:
        if self.start is None:
            return f"{self.readings} readings"
        return f"{self.readings} readings from {self.start:g} rad by {self.step:g}, at most {self.maximum_m or 0:g} m"


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Scan of one line.

    Parameters
    ----------
    laser
        Its laser.
    ranges
        Shape (B,), metres.
    stamp
        Poses of the laser and of the robot, (x, y, theta) each, and the time: seven numbers.
    """

    laser: Laser
    ranges: NDArray[np.float32]
    stamp: list[float]


def parse_scan(words: list[bytes]) -> Scan:
    """Parse a line of the kind FLASER or ROBOTLASER1.

    Raises
    ------
    InputError
        If its counts and its words disagree, or a word is not the number that it should be.
    """
    return _flaser(words) if words[0] == FLASER else _robotlaser(words)


def _flaser(words: list[bytes]) -> Scan:
    count = _count(words, 1)
    after = 2 + count
    require_words(words, after + POSES + 1, after + POSES + TAIL)
    return Scan(Laser(FLASER, count), _ranges(words[2:after]), parse_finite(words[after : after + POSES + 1]))


def _robotlaser(words: list[bytes]) -> Scan:
    count = _count(words, CONFIG + 1)
    first = CONFIG + 2
    after, least = first + count, POSES + VELOCITIES + 1
    if len(words) - after not in (least, least + 2):  # there are remissions
        after += 1 + _count(words, after, least=0)
    require_words(words, after + least, after + least + 2)
    _, start, fov, step, maximum_m, *_ = parse_finite(words[1 : CONFIG + 1])
    step = step if step > 0 else fov / max(1, count - 1)
    if count > 1 and not 0 < step * (count - 1) < 2 * math.pi + ROUNDED:
        raise InputError(f"{count} readings {math.degrees(step):g} degrees apart are no scan")
    stamp = parse_finite([*words[after : after + POSES], words[after + POSES + VELOCITIES]])
    laser = Laser(ROBOTLASER, count, start, step, maximum_m if maximum_m > 0 else None)
    return Scan(laser, _ranges(words[first : first + count]), stamp)


def _count(words: list[bytes], at: int, *, least: int = 1) -> int:
    if len(words) <= at or not words[at].isdigit() or len(words[at]) > 9 or int(words[at]) < least:
        got = _shown(words[at]) if len(words) > at else "nothing"
        raise InputError(f"word {at + 1} must be how many numbers follow, got {got}; mend or remove the line")
    return int(words[at])


def require_words(words: list[bytes], least: int, most: float = math.inf) -> None:
    """Raise InputError unless the number of words of a line is within bounds."""
    if not least <= len(words) <= most:
        wanted = f"{least} or more" if most == math.inf else f"{least} to {most:.0f}"
        raise InputError(
            f"{_shown(words[0])} has {len(words)} words, by its counts it should have {wanted}; mend or remove the line"
        )


def parse_finite(words: list[bytes]) -> list[float]:
    """Return words as numbers, or raise InputError where a word is not a finite number."""
    values = _numbers(words)
    for word, value in zip(words, values, strict=True):
        if not math.isfinite(value):
            raise InputError(f"{_shown(word)} is not a finite number; mend or remove the line")
    return values


def _ranges(words: list[bytes]) -> NDArray[np.float32]:
    return np.array(_numbers(words), dtype=np.float32)


def _numbers(words: list[bytes]) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        word = str(error).rpartition(": b")[2]
        raise InputError(f"{word:.40} is not a number; mend or remove the line") from None


def _shown(word: bytes) -> str:
    return repr(word[:30].decode("ascii", "replace"))

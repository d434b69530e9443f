"""Checksums, lengths and trailers of image files, which decoders leave unread."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from PIL import Image

FILL = b" \t\r\n\0"  # harmless after the last pixel
DEFLATE = (8, 32946)  # values of TIFF's tag Compression
COMPRESSION, STRIPS, TILES = 259, (273, 279), (324, 325)  # TIFF's tags; offsets and byte counts of strips or tiles
STEP_BYTES = 1 << 20  # unpacked at a time


def require_intact(path: Path, image: Image.Image) -> None:
    """Check what an image file says of its own integrity.

    Parameters
    ----------
    path
        The file.
    image
        The image opened from it, not yet decoded.

    Raises
    ------
    ValueError, OSError, SyntaxError
        If a checksum, a length or a trailer is wrong.

    Notes
    -----
    PNG: the checksum of every chunk. TIFF with deflate: the checksum of every strip or tile. PGM: the length of the
    pixels. BMP: the length in the header. GIF: the trailer. JPEG: the marker of its end. Other damage to formats
    without a checksum is not found.
    """
    if check := _CHECKS.get(image.format or ""):
        check(path, image)


def _check_png(path: Path, image: Image.Image) -> None:
    with Image.open(path, formats=("PNG",)) as again:  # an image that was verified can no longer be decoded
        again.verify()


def _check_tiff(path: Path, image: Image.Image) -> None:
    tags = getattr(image, "tag_v2", {})
    if tags.get(COMPRESSION, 1) not in DEFLATE:
        return
    for at, lengths in (STRIPS, TILES):
        with path.open("rb") as file:
            for offset, length in zip(tags.get(at, ()), tags.get(lengths, ()), strict=True):
                file.seek(offset)
                _unpack(file.read(length))


def _unpack(data: bytes) -> None:
    """Unpack a zlib stream to its end, where its checksum is, without keeping it."""
    stream = zlib.decompressobj()
    try:
        while data:
            stream.decompress(data, STEP_BYTES)
            data = stream.unconsumed_tail
    except zlib.error as error:
        raise ValueError(str(error)) from None
    if not stream.eof:
        raise ValueError("a strip ends before its checksum")


def _check_pgm(path: Path, image: Image.Image) -> None:
    """Refuse bytes after the pixels: the header states fewer pixels than there are."""
    with path.open("rb") as file:
        magic = file.read(2)
        if magic not in _SAMPLES:
            return  # plain text has no length
        decoder, _, start, settings = getattr(image, "tile", [])[0][:4]
        file.seek(start + _pgm_bytes(magic, image.size, decoder, settings))
        if file.read().strip(FILL):
            raise ValueError("it holds more pixels than its header states")


def _pgm_bytes(magic: bytes, size: tuple[int, int], decoder: str, settings: object) -> int:
    width, height = size
    if magic == b"P4":
        return (width + 7) // 8 * height
    mode, full = settings if isinstance(settings, tuple) else (str(settings), 255)
    is_wide = str(mode).startswith("I") or (decoder == "ppm" and int(full) > 255)
    return width * height * _SAMPLES[magic] * (2 if is_wide else 1)


def _check_bmp(path: Path, image: Image.Image) -> None:
    with path.open("rb") as file:
        file.seek(2)
        stated = int.from_bytes(file.read(4), "little")
    length = path.stat().st_size
    if stated not in (0, length):
        raise ValueError(f"its header states {stated} bytes, the file has {length}")


def _check_gif(path: Path, image: Image.Image) -> None:
    if not path.read_bytes().rstrip(b"\0").endswith(b";"):
        raise ValueError("its end is missing")


def _check_jpeg(path: Path, image: Image.Image) -> None:
    if b"\xff\xd9" not in path.read_bytes():
        raise ValueError("its end is missing")


_SAMPLES = {b"P4": 1, b"P5": 1, b"P6": 3}  # channels of each pixel
_CHECKS: Mapping[str, Callable[[Path, Image.Image], None]] = MappingProxyType(
    {
        "PNG": _check_png,
        "TIFF": _check_tiff,
        "PPM": _check_pgm,
        "BMP": _check_bmp,
        "GIF": _check_gif,
        "JPEG": _check_jpeg,
    }
)

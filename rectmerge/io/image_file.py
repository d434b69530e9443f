"""Image files as maps use them: checked before they are decoded, and written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import re
import struct
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS

READABLE = ("PNG", "PPM", "BMP", "JPEG", "TIFF", "GIF")
OPAQUE = 255
WRITABLE = {".pgm": "PPM", ".png": "PNG"}
BROKEN = (  # what decoders raise on broken files
    *(OSError, ValueError, TypeError, SyntaxError, EOFError, LookupError, ArithmeticError, AttributeError),
    *(AssertionError, RuntimeError, struct.error),
)


class Pixels(NamedTuple):
    """A decoded image.

    Parameters
    ----------
    values, full
        The sum of the colour channels, shape (H, W), and that sum for white.
    luma
        The grey that colours look like (ITU-R 601-2), 8 bit, shape (H, W).
    alpha
        0 clear to 255 opaque, shape (H, W); None where the image has no such channel.
    """

    values: NDArray[np.uint16]
    full: int
    luma: NDArray[np.uint8]
    alpha: NDArray[np.uint8] | None = None

    @property
    def opaque(self) -> NDArray[np.bool_] | None:
        """Where it is not wholly transparent, shape (H, W); None where that is everywhere."""
        return None if self.alpha is None or self.alpha.all() else self.alpha > 0


def read_pixels(path: Path) -> Pixels:
    """Decode an image file (PGM, PNG, BMP, JPEG, TIFF, GIF; 8 or 16 bit; grey, colour or palette).

    Raises
    ------
    MapFileError
        If it is missing, not readable, not an image, truncated, or larger than 150 million pixels or
        32,766 on a side.
    """
    require_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow warns of large images; the limit here is checked below
            with Image.open(path, formats=READABLE) as image:
                width, height = image.size
                if width * height > MOST_CELLS:
                    raise _too_large(path, f"{width} x {height} pixels")
                if max(width, height) > LONGEST_SIDE_CELLS:
                    raise MapFileError(f"{path}: {width} x {height} pixels: a side may have {LONGEST_SIDE_CELLS}")
                return _channels(image)
    except MapFileError:
        raise
    except Image.DecompressionBombError as error:  # "Image size (N pixels) exceeds limit of ..."
        pixels = re.search(r"\d+", str(error))
        raise _too_large(path, f"{pixels[0] if pixels else 'too many'} pixels by its header") from None
    except UnidentifiedImageError:
        what = "the file is empty" if path.stat().st_size == 0 else "not an image"
        raise MapFileError(f"{path}: {what}; give a PGM or PNG, or the map's .yaml") from None
    except PermissionError:
        raise MapFileError(f"{path}: permission denied; make the file readable") from None
    except BROKEN as error:
        raise MapFileError(f"{path}: broken or truncated image ({error}); save or copy it again") from None


def encode_image(image: NDArray[np.uint8], suffix: str) -> bytes:
    """Encode an image, grey (H, W), with alpha (H, W, 2) or RGB (H, W, 3), for the suffix ".pgm" or ".png"."""
    encoded = io.BytesIO()
    Image.fromarray(image).save(encoded, format=WRITABLE[suffix])
    return encoded.getvalue()


def require_file(path: Path) -> None:
    """Raise MapFileError unless `path` is an existing regular file."""
    try:
        if path.is_file():
            return
        what = "is a directory; name a file in it" if path.is_dir() else "no such file; check the name"
        if path.exists() and not path.is_dir():
            what = "not a regular file; save the map to one first"
    except (OSError, ValueError) as error:
        what = f"no such file ({error})"
    raise MapFileError(f"{path}: {what}")


def real(path: Path) -> Path:
    """Resolve a path's links, as far as that goes: of a link to itself its own name stays."""
    return Path(os.path.realpath(path))


def require_other(output: Path, inputs: Iterable[Path]) -> None:
    """Raise InputError where what is to be written is a file that is read, by whatever name."""
    if real(output) in map(real, inputs):
        raise InputError(f"{output}: is an input, and would be replaced; name another file with -o")


def replace_file(path: Path, data: bytes) -> None:
    """Write a file so that its name never holds half of it.

    Raises
    ------
    MapFileError
        If it cannot be written.
    """
    replace_files({path: data})


def replace_files(files: Mapping[Path, bytes], *, stale: Iterable[Path] = ()) -> None:
    """Write files so that no name ever holds half of one, and where one cannot be written all stay as they were.

    Parameters
    ----------
    files
        What goes where; the names appear in this order. Of several, no earlier one is left when the first new one
        appears: whoever finds the last finds the others as they belong to it.
    stale
        Files that go as well.

    Raises
    ------
    MapFileError
        If one cannot be written.
    """
    partials = {path: _hidden(path, "part") for path in files}
    earlier = {path: _hidden(path, "old") for path in [*reversed([*files]), *stale]}
    if len(earlier) == 1:
        earlier = {}  # one file is replaced in one step
    path = Path()
    try:
        for path, partial in partials.items():
            _require_no_folder(path)
            partial.write_bytes(files[path])
        fresh = [path for path in files if not os.path.lexists(path)]
        try:
            for path, old in earlier.items():
                with contextlib.suppress(FileNotFoundError):
                    path.rename(old)
            for path, partial in partials.items():
                partial.replace(path)
        except BaseException:
            _put_back(earlier, fresh)
            raise
    except OSError as error:
        raise MapFileError(f"{path}: cannot be written: {error.strerror or error}") from None
    finally:
        _remove(partials.values())
    _remove(earlier.values())


def _require_no_folder(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():  # it could be set aside like a file, with all it holds
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))


def _hidden(path: Path, suffix: str) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}.{suffix}")


def _put_back(earlier: Mapping[Path, Path], fresh: Iterable[Path]) -> None:
    """Undo a replacement that broke off; what went first comes back last, so that it stands for the others again."""
    _remove(fresh)
    for path, old in reversed([*earlier.items()]):
        with contextlib.suppress(OSError):  # what does not come back stays beside, under its hidden name
            if os.path.lexists(old):
                old.replace(path)


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


def _too_large(path: Path, what: str) -> MapFileError:
    return MapFileError(f"{path}: {what}, more than {MOST_CELLS // 10**6} million; crop it to its known cells")


def _channels(image: Image.Image) -> Pixels:
    if image.mode.startswith("I"):  # 16-bit grey
        values = np.asarray(image)
        if values.min() < 0 or values.max() > 65535:
            raise ValueError(f"grey values up to {values.max()}, more than 16 bit")
        return Pixels(values.astype(np.uint16), 65535, ((values.astype(np.uint32) + 128) // 257).astype(np.uint8))
    alpha: NDArray[np.uint8] | None = None
    if image.mode in ("LA", "RGBA", "PA") or "transparency" in image.info:
        image = image.convert("LA" if image.mode in ("L", "LA") else "RGBA")
        alpha = np.asarray(image.getchannel("A"), np.uint8)
    luma = np.asarray(image.convert("RGB").convert("L") if image.mode == "RGBA" else image.convert("L"), np.uint8)
    if image.mode in ("1", "L", "LA"):
        return Pixels(luma.astype(np.uint16), OPAQUE, luma, alpha)
    colours = np.asarray(image.convert("RGB"), np.uint8)
    return Pixels(colours.sum(axis=2, dtype=np.uint16), 3 * OPAQUE, luma, alpha)

"""Image files of maps, checked before decoding."""

from __future__ import annotations

import io
import re
import struct
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from rectmerge.errors import MapFileError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS
from rectmerge.io.image_checks import require_intact

READABLE = ("PNG", "PPM", "BMP", "JPEG", "TIFF", "GIF")
OPAQUE = 255
WRITABLE = {".pgm": "PPM", ".png": "PNG"}
BROKEN = (  # errors of decoders on broken files
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
        The luma of the colours (ITU-R 601-2), 8 bit, shape (H, W).
    alpha
        0 transparent to 255 opaque, shape (H, W); None where the image has no such channel.
    """

    values: NDArray[np.uint16]
    full: int
    luma: NDArray[np.uint8]
    alpha: NDArray[np.uint8] | None = None

    @property
    def opaque(self) -> NDArray[np.bool_] | None:
        """Mask of the pixels that are not fully transparent, shape (H, W); None if all are."""
        return None if self.alpha is None or self.alpha.all() else self.alpha > 0


def read_pixels(path: Path) -> Pixels:
    """Decode an image file (PGM, PNG, BMP, JPEG, TIFF, GIF; 8 or 16 bit; grey, colour or palette).

    Raises
    ------
    MapFileError
        If it is missing, not readable, not an image, truncated, or larger than 150 million pixels or
        32,766 on a side; or damaged, as far as `rectmerge.io.image_checks` finds that.
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
                require_intact(path, image)
                return _channels(image)
    except MapFileError:
        raise
    except Image.DecompressionBombError as error:  # "Image size (N pixels) exceeds limit of ..."
        pixels = re.search(r"\d+", str(error))
        raise _too_large(path, f"{pixels[0] if pixels else 'too many'} pixels by its header") from None
    except UnidentifiedImageError:
        fault = "the file is empty" if path.stat().st_size == 0 else "not an image"
        raise MapFileError(f"{path}: {fault}; give a PGM or PNG, or the map's .yaml") from None
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
        fault = "is a directory; name a file in it" if path.is_dir() else "no such file; check the name"
        if path.exists() and not path.is_dir():
            fault = "not a regular file; save the map to one first"
    except (OSError, ValueError) as error:
        fault = f"no such file ({error})"
    raise MapFileError(f"{path}: {fault}")


def _too_large(path: Path, size: str) -> MapFileError:
    return MapFileError(f"{path}: {size}, more than {MOST_CELLS // 10**6} million; crop it to its known cells")


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

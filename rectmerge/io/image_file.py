"""Image files of maps, checked before decoding."""

from __future__ import annotations

import io
import re
import struct
import warnings
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, TiffImagePlugin, UnidentifiedImageError

from rectmerge.errors import MapFileError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS
from rectmerge.io.image_checks import require_intact

TIFF = TiffImagePlugin.TiffImageFile.format  # by its plug-in, which `Image.preinit` leaves out
READABLE = ("PNG", "PPM", "BMP", "JPEG", TIFF, "GIF")
OPAQUE = 255
CELLS_AT_ONCE = 1 << 20
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

    values: NDArray[np.uint8] | NDArray[np.uint16]
    full: int
    luma: NDArray[np.uint8]
    alpha: NDArray[np.uint8] | None = None

    @property
    def opaque(self) -> NDArray[np.bool_] | None:
        """Mask of the pixels that are not fully transparent, shape (H, W); None if all are."""
        return None if self.alpha is None or self.alpha.all() else self.alpha > 0

    @property
    def grey(self) -> NDArray[np.uint8]:
        """The mean of the colour channels, 0 to 255, shape (H, W)."""
        if self.full == OPAQUE:
            return np.asarray(self.values, np.uint8)
        table = np.rint(np.arange(self.full + 1) * (OPAQUE / self.full)).astype(np.uint8)
        return np.asarray(table[self.values])


def read_pixels(path: Path) -> Pixels:
    """Decode an image file (PGM, PNG, BMP, JPEG, TIFF, GIF; 8 or 16 bit; grey, colour or palette).

    Raises
    ------
    MapFileError
        If it is missing, not readable, not an image, truncated, or larger than 150 million pixels or
        32,766 on a side; or damaged, as far as `rectmerge.io.image_checks` finds that.
    """
    require_file(path)
    Image.preinit()  # else Pillow loads its plug-ins for 40 formats that no map has
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
    if suffix == ".pgm" and image.ndim == 2:
        return b"P5\n%d %d\n255\n" % image.shape[::-1] + image.tobytes()
    encoded = io.BytesIO()
    Image.fromarray(image).save(encoded, format=WRITABLE[suffix])
    return encoded.getvalue()


def grey_counts(grey: NDArray[np.uint8], mask: NDArray[np.bool_] | None = None) -> NDArray[np.int64]:
    """Count the pixels of each grey, shape (256,); of those in the mask where there is one."""
    counts = np.zeros(OPAQUE + 1, np.int64)
    step = max(1, CELLS_AT_ONCE // grey.shape[1])
    for top in range(0, grey.shape[0], step):  # a histogram's single precision counts to 2^24
        seen = None if mask is None else np.ascontiguousarray(mask[top : top + step]).view(np.uint8)
        band = np.ascontiguousarray(grey[top : top + step])
        counts += cv2.calcHist([band], [0], seen, [OPAQUE + 1], [0, OPAQUE + 1]).ravel().astype(np.int64)
    return counts


def recode(codes: NDArray[np.uint8], table: NDArray[np.int8]) -> NDArray[np.int8]:
    """Look up each of the codes, shape (H, W), in a table of 256."""
    return np.asarray(cv2.LUT(np.ascontiguousarray(codes), table.view(np.uint8))).view(np.int8)


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


def _luma(image: Image.Image) -> Image.Image:
    if image.mode == "L":
        return image
    return (image.convert("RGB") if image.mode == "RGBA" else image).convert("L")


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
    luma = np.asarray(_luma(image), np.uint8)
    if image.mode in ("1", "L", "LA"):
        return Pixels(luma, OPAQUE, luma, alpha)
    colours = np.asarray(image.convert("RGB"), np.uint8)
    return Pixels(colours.sum(axis=2, dtype=np.uint16), 3 * OPAQUE, luma, alpha)

"""Pictures of the pages under docs, encoded small."""

from __future__ import annotations

import io

from PIL import Image

from rectmerge.drawing.maps import Picture

WIDTH, COLORS = 1200, 64  # of a picture, at the most


def small_png(picture: Picture) -> bytes:
    """Encode a picture at the width of a page, with a palette that keeps rare colours."""
    image, packed = Image.fromarray(picture), io.BytesIO()
    image.thumbnail((WIDTH, WIDTH))
    few = image.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    few.save(packed, "png", optimize=True)
    return packed.getvalue()

"""Placements to draw, and what a flood reaches."""

import math

import cv2
import numpy as np
from hypothesis import strategies as st

from rectmerge.similarity import Similarity

placements = st.builds(
    Similarity, st.floats(0.4, 2.5), st.floats(-math.pi, math.pi), st.floats(-150, 150), st.floats(-150, 150)
)


def reached_from_corner(passable: np.ndarray) -> np.ndarray:
    """Return what a flood from the corner reaches, moving to the four neighbours."""
    image = passable.astype(np.uint8)
    cv2.floodFill(image, None, (0, 0), 2, flags=4)
    return image == 2

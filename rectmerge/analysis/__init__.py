"""Measurements on maps: overlap, accuracy, specks, orientation, wall faces."""

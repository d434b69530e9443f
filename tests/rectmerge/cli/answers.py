"""A method that gives a fixed answer, and the command as people type it."""

from pathlib import Path

import numpy as np
from PIL import Image

from rectmerge.alignment import Alignment, Candidate
from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.grid import OccupancyGrid
from tests import drawing

YES_FILES = {"alignment.json", "overlay.png", "conflict.png", "merged.yaml", "merged.pgm"}
A, B = drawing.DATA / "building_a.yaml", drawing.DATA / "building_b.yaml"


class FixedAnswers:
    """A method that judges itself, and places B where it was drawn, with the verdict it is told."""

    name = "answers"

    def __init__(self, verdict: str, candidates: int = 1) -> None:
        self.verdict, self.candidates = verdict, candidates

    def align_by(self, hint, a: OccupancyGrid, b: OccupancyGrid, **asked) -> Alignment:
        return self.align(a, b, **asked)

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        candidates = tuple(
            Candidate.from_pixels(drawing.B_IN_A, a, b, confidence=0.97, evidence={"ratio": float("inf")})
            for _ in range(self.candidates)
        )
        return Alignment(
            verdict=self.verdict, reason="told so", method=self.name, candidates=candidates, confidence=0.97
        )


def rectmerge(*words: object) -> int:
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


def write_plain(path: Path) -> None:
    with Image.open(A.with_suffix(".pgm")) as image:
        image.save(path)


def names(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir()} if folder.exists() else set()

import math
import re

import numpy as np
import pytest
from PIL import Image

from rectmerge.cli import console
from rectmerge.paper.figures import FIGURES
from rectmerge.paper.trace import neighbours_table, trace_method
from scenarios.cli import main as cli
from scenarios.gallery.paper_figures import TABLES, practical_pair, trace_simple
from scenarios.pairs.paper_plan import RATIO, TURNS_DEG, simple_maps
from scenarios.pairs.truth import known_extent
from scenarios.scoring.score import RIGHT, grade, measure_errors
from tests.test_docs import ROOT

FOLDER = ROOT / "docs" / "the-papers-method"
PAGE = FOLDER.with_suffix(".md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def walked():
    return trace_simple()


def test_the_simple_maps_are_turned_and_scaled_as_the_paper_says():
    _, _, truth = simple_maps()

    assert truth.scale == pytest.approx(RATIO)
    assert math.degrees(truth.angle) % 360 == pytest.approx(TURNS_DEG[1] - TURNS_DEG[0])


def test_the_method_lays_the_simple_maps_on_each_other(walked):
    a, b, truth = simple_maps()
    walls = np.argwhere(b.occupied)[:, ::-1]

    off = np.hypot(*(walked.passes[-1].pixels.apply(walls) - truth.apply(walls)).T)

    assert off.mean() < 0.01 * known_extent(a)


def test_the_page_tells_what_the_method_found(walked):
    turns = [f"{math.degrees(turn.turn):.2f} degrees" for turn in walked.orientations[:1]]
    ratios = [f"{step.match.ratio:.4f}" for step in walked.passes if step.is_rescaling]
    counts = f"{len(walked.rmaps[0])} and {len(walked.rmaps[1])} rectangles"
    scale = f"ends at {walked.passes[-1].scale_after:.4f}"

    text = " ".join(PAGE.split())
    assert [word for word in (*turns, *ratios, counts, scale) if word not in text] == []
    assert neighbours_table(walked.rmaps[0]) in PAGE
    assert f"{90 * walked.passes[0].match.quarter_turns} degrees" in text


def test_the_pictures_of_the_page_are_small_and_all_captioned():
    assert max((FOLDER / name).stat().st_size for name in FIGURES) <= 64_000
    assert [name for name in FIGURES if f"(the-papers-method/{name})" not in PAGE] == []
    captions = re.findall(r"\]\(the-papers-method/figure-(\d+)\.png\)\n\n\*Figures?(?: 1 and)? (\d+)\. ", PAGE)
    assert [(int(number), int(repeated)) for number, repeated in captions] == [(n, n) for n in range(2, 13)]
    assert [name for name in TABLES if (FOLDER / name).read_text().strip() not in PAGE] == []


@pytest.mark.slow
@pytest.mark.sim
def test_the_command_writes_every_figure(tmp_path, capsys):
    words = ["figures", "-o", str(tmp_path / "figures"), "--quiet"]

    assert console.run(cli.app, "rectbench", words) == console.YES
    assert console.run(cli.app, "rectbench", words) == console.BAD_INPUT  # never over earlier ones unasked

    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == sorted([*FIGURES, *TABLES])
    for name in FIGURES:
        drawn, kept = (
            np.asarray(Image.open(folder / name).convert("RGB")) for folder in (tmp_path / "figures", FOLDER)
        )
        assert drawn.shape == kept.shape
        assert (np.abs(drawn.astype(int) - kept).max(axis=2) > 32).mean() < 0.02


@pytest.mark.slow
@pytest.mark.sim
def test_the_office_of_figure_12_is_merged_rightly():
    pair = practical_pair()

    errors = measure_errors(trace_method(pair.a, pair.b).passes[-1].pixels, pair)

    assert grade(errors, pair.residual_px / known_extent(pair.a)) in RIGHT

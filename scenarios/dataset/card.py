"""The card of a data set: its content and how to load it, for people and for hubs, with a picture."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rectmerge.drawing.maps import side_by_side
from scenarios.dataset.contact_sheet import paletted_png, strip
from scenarios.dataset.dataset_id import PICTURE, SHOWN_DIGITS
from scenarios.dataset.metadata import check_row, line_at, metadata_lines, parse_row
from scenarios.dataset.reader import split_folders
from scenarios.pairs.pair import MapPair

PAIRS, COLUMNS = 8, 2

TEXT = """---
pretty_name: {quoted}
license: {license}
tags:
- robotics
- occupancy-grid
- map-merging
configs:
- config_name: default
  data_files:
{files}
---

# {title}

{description}

![Pairs of the data set: map A, map B, and B on A by the truth]({picture})

Pairs of occupancy-grid maps, as two robots made them of one building, with the similarity that takes map B to map A.
Made by `{command}`; the same command makes the same bytes.{secret}

| split | pairs | of these related |
| --- | --- | --- |
{splits}

{failed} pairs of the suite could not be made and are not in the data set; `dataset_info.json` names each with its
reason. {discarded} tries at a mission, in the same or another building, were discarded before one succeeded; it tells
why.

## Version, licence, citation

Made by {version}. The id of the data set is the hash of its content, `{id}`;
`rectbench verify {folder}` recomputes it.

{terms}

```bibtex
@misc{{{suite}-{short_id},
  title = {{{{{title}}}}},
  author = {{{{The rectmerge developers}}}},
  note = {{Pairs of occupancy-grid maps, data set {short_id}, made by {version}}}
}}
```

## Load it

```python
from datasets import load_dataset

pairs = load_dataset("imagefolder", data_dir="{folder}")["{split}"]  # map_a and map_b are images
```

```python
import pandas as pd

rows = pd.read_json("{folder}/{split}/metadata.jsonl", lines=True)
```

```python
import rectmerge as rm

a = rm.read_map("{folder}/{sample}")  # or any other reader of images or ROS maps
```

`rectbench run {folder} -m robust -o run` puts a method to every pair, and `rectbench verify {folder}` recomputes
checksums and truth.

## What a row tells

| key | meaning |
| --- | --- |
| `pair_id`, `suite`, `place` | names; pairs of one place are not independent of each other |
| `map_a_file_name`, `map_b_file_name` | the maps, relative to the split's folder: free 254, occupied 0, unknown 205 |
| `map_a_yaml`, `map_b_yaml` | its ROS map file, where a method may know the resolution; else empty |
| `related` | whether the maps show the same place at all |
| `pixels` | 2x3, the pixels (u right, v down, centres at integers) of B to those of A; null when unrelated |
| `control_points` | `[ua, va, ub, vb]`: the same surface points in both maps; null when unrelated |
| `residual_px` | RMSE of `pixels` on the control points, in pixels of A; null when unrelated |
| `b_to_a` | the same similarity between the map frames (y up), in metres or, without a resolution, in cells |
| `overlap` | shared free area over the smaller of the two free areas |
| `resolution_a`, `resolution_b` | metres per cell; hidden from methods where there is no YAML |
| `identifiable_margin`, `identifiable` | by how much the truth beats all other placements on exact maps; >= 0.25 |
| `world` | the building at 5 cm per cell, a ROS map |
| `noise`, `suite_version` | the level of noise, and the version of the suite that says what it means |
{bag}| `pose_source`, `bent`, ... | how the maps were made; empty where there is nothing to tell |
"""

SECRET = "\nThat takes the same secret; the SHA-256 of its bytes is `{secret_sha256}`."
SIMULATED_TERMS = "Simulated, under the licence of rectmerge: MIT."
RECORDED_TERMS = "Made of a recording by others, whose licence holds: ask where the recording is from."
BAG = "| `bag` | the mission as a ROS bag: growing maps, scans, odometry; empty of mirrored pairs |\n"


def card(info: Mapping[str, Any], sample: str, *, folder: str = "DATASET") -> str:
    """Write the card.

    Parameters
    ----------
    info
        The content of ``dataset_info.json``: suite, seed, title, description, dataset_id, versions, splits, discarded,
        failed; `command` where `rectbench generate` did not make it.
    sample
        One of its maps, by its path in the data set.
    folder
        What the card calls the data set's folder.
    """
    splits: Mapping[str, Mapping[str, int]] = info["splits"]
    command = f"rectbench generate {info['suite']} -o {folder} --seed {info['seed']}"
    form = info.get("format", "files")
    command += f" --format {form}" if form != "files" else ""
    if info["pairs"] is not None:
        command = f"{command} --pairs {info['pairs']}"
    command += " --secret FILE" if info.get("secret_sha256") else ""
    title = str(info.get("title") or info["suite"])
    is_simulated = "command" not in info
    return TEXT.format(
        title=title,
        quoted=json.dumps(title),
        description=" ".join(str(info.get("description", "")).split()),
        files="\n".join(f"  - split: {name}\n    path: {name}/**" for name in splits),
        picture=PICTURE,
        sample=sample,
        split=sample.partition("/")[0],
        command=info.get("command", command),
        splits="\n".join(f"| {name} | {count['pairs']} | {count['related']} |" for name, count in splits.items()),
        secret=SECRET.format(**info) if info.get("secret_sha256") else "",
        license="mit" if is_simulated else "other",
        terms=SIMULATED_TERMS if is_simulated else RECORDED_TERMS,
        version=_version(info),
        id=info["dataset_id"],
        short_id=info["dataset_id"][:SHOWN_DIGITS],
        suite=info["suite"],
        bag=BAG if form != "files" else "",
        failed=len(info["failed"]),
        discarded=info["discarded"]["count"],
        folder=folder,
    )


def _version(info: Mapping[str, Any]) -> str:
    versions: Mapping[str, Any] = info["versions"]
    commit = f", commit {versions['commit']}" if versions.get("commit") else ""
    return f"rectmerge {versions.get('rectmerge', 'of unknown version')}{commit}"


def picture(dataset: Path) -> bytes:
    """Draw some pairs of a data set, evenly chosen, as a PNG: A, B, and B on A by the truth."""
    places = [(folder, line.start) for folder in split_folders(dataset) for line in metadata_lines(folder)]
    chosen = [(folder, line_at(folder, start)) for folder, start in places[:: -(-len(places) // PAIRS)]]
    pairs = [check_row(parse_row(line), folder, "", line.place).pair() for folder, line in chosen]
    return paletted_png(
        side_by_side([strip(pair) for pair in pairs], [_caption(pair) for pair in pairs], columns=COLUMNS)
    )


def _caption(pair: MapPair) -> str:
    overlap = f"overlap {pair.overlap:.2f}" if pair.related and pair.overlap is not None else "unrelated"
    return f"{pair.pair_id}: {overlap}"
